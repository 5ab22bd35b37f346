"""Cameras over HTTP: a calibration that fails ends, whatever failed, and may be begun again."""

import errno
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from limbgram.app.state import AppState
from limbgram.cases import cameras
from limbgram.core.errors import ExportError
from limbgram.core.geometry.lens import LENS_SIZE, Camera
from limbgram.formats.camera import write_camera
from limbgram.reconstruction.calibration.cameras import Calibration

API = "/api/v1"
FULL = OSError(errno.ENOSPC, "No space left on device")


@pytest.fixture
def camera(client: TestClient, app_state: AppState, monkeypatch: pytest.MonkeyPatch) -> str:
    """A camera whose photos tell its lens at once."""
    lens = SimpleNamespace(rms_px=0.2)
    found = SimpleNamespace(board="7x5", photos=(), set_aside=(), doubts=(), calibration=lens)
    monkeypatch.setattr(cameras, "calibrate_photos", lambda *_: found)
    monkeypatch.setattr(cameras, "calibration_picture", lambda _: b"a picture")
    camera_id = client.post(f"{API}/cameras", json={"name": "A"}).json()["id"]
    (app_state.shelf.cameras / camera_id / "received").mkdir()
    return f"{API}/cameras/{camera_id}"


def calibrated(client: TestClient, camera: str) -> dict[str, Any]:
    """What is said of it once that has ended."""
    assert client.post(f"{camera}/calibrate", json={}).status_code == 202
    given_up = time.monotonic() + 60
    while True:
        told: dict[str, Any] = client.get(camera).json()
        if told["state"] != "calibrating":
            return told
        assert time.monotonic() < given_up, "it stays calibrating"
        time.sleep(0.02)


@pytest.mark.parametrize("fails", ["write_lens", "write_bytes"])
@pytest.mark.parametrize("fault", [FULL, ExportError("The disk is full.")], ids=["disk", "export"])
def test_a_result_that_cannot_be_written_ends_the_calibration(
    client: TestClient, camera: str, monkeypatch: pytest.MonkeyPatch, fails: str, fault: Exception
) -> None:
    def full(*_: object) -> None:
        raise fault

    monkeypatch.setattr(cameras, "write_lens", lambda *_: None)
    monkeypatch.setattr(cameras, fails, full)
    told = calibrated(client, camera)
    assert told["state"] == "refused"
    assert "full" in told["message"]
    assert calibrated(client, camera)["state"] == "refused", "it may be begun again"


def test_a_calibration_whose_end_cannot_be_written_either_is_not_awaited_for_ever(
    client: TestClient, camera: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = cameras.write_json

    def only_the_beginning(path: object, content: Any) -> None:
        if content["state"] != "calibrating":
            raise FULL
        write(path, content)

    monkeypatch.setattr(cameras, "write_lens", lambda *_: None)
    monkeypatch.setattr(cameras, "write_json", only_the_beginning)
    told = calibrated(client, camera)
    assert told["state"] == "empty"
    assert "again" in told["message"]


def test_the_certificate_of_a_lens_goes_with_it_and_stays_where_a_file_is_refused(
    client: TestClient, camera: str, app_state: AppState, tmp_path: Path
) -> None:
    certificate = app_state.shelf.cameras / camera.rpartition("/")[2] / "certificate.png"
    certificate.write_bytes(b"of the lens before")
    refused = client.put(f"{camera}/file?name=IMG%201.json", content=b"no camera file")
    assert refused.status_code == 409
    assert refused.json()["message"].startswith("IMG 1.json is no usable camera file")
    assert client.get(f"{camera}/certificate").content == b"of the lens before"
    lens = Camera(width_px=640, height_px=480, fx=900.0, fy=900.0, cx=319.5, cy=239.5)
    covariance = np.zeros((LENS_SIZE, LENS_SIZE))
    found = Calibration(camera=lens, covariance=covariance, source="board")
    write_camera(tmp_path / "camera.json", found)
    told = client.put(f"{camera}/file", content=(tmp_path / "camera.json").read_bytes()).json()
    assert (told["state"], told["certificate"]) == ("ready", None)
    assert client.get(f"{camera}/certificate").status_code == 404
