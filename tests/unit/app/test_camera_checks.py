"""The kit over HTTP: photos that are not of the camera chosen are told before the run."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
from fastapi.testclient import TestClient
from PIL import Image

from limbgram.app import camera_checks
from limbgram.app.state import AppState
from limbgram.capture.setup import Outcome, SetupCited
from limbgram.core.geometry.lens import Camera
from limbgram.core.typed import tree_of
from limbgram.findings import as_json, note
from limbgram.formats.camera import write_camera
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.report.accuracy.judgement import MOVED, SCALE, TAPE

API = "/api/v1"


def test_photos_of_another_size_do_not_fit_a_camera_and_its_own_do(
    client: TestClient, tmp_path: Path
) -> None:
    case = f"{API}/cases/" + client.post(f"{API}/cases", json={}).json()["id"]
    camera = client.post(f"{API}/cameras", json={"name": "Camera"}).json()["id"]
    ask = f"{case}/camera-fit?camera={camera}"
    assert client.get(ask).status_code == 409  # not calibrated yet
    sent = client.put(f"{API}/cameras/{camera}/file", content=camera_file(tmp_path))
    assert sent.status_code == 200
    assert client.get(ask).json() == {"fits": True, "why": None}  # nothing tells against it

    photo(client, case, "a.png", 640, 480)
    assert client.get(ask).json()["fits"]
    photo(client, case, "b.png", 660, 480)
    told = client.get(ask).json()
    assert not told["fits"]
    assert "660 x 480" in told["why"]["sentence"]


def test_a_case_names_the_cameras_that_it_was_computed_with(
    client: TestClient, app_state: AppState, tmp_path: Path
) -> None:
    case_id = client.post(f"{API}/cases", json={}).json()["id"]
    assert client.get(f"{API}/cases/{case_id}/kit").json() == {
        "cameras": [],
        "setups": [],
        "tapes": [],
        "notes": [],
    }
    (app_state.shelf.root / case_id / "camera.json").write_bytes(camera_file(tmp_path))
    told = client.get(f"{API}/cases/{case_id}/kit").json()
    assert told == {"cameras": ["Made Up 1"], "setups": [], "tapes": [], "notes": []}


@pytest.mark.parametrize(
    ("outcome", "months", "due"),
    [("pass", 11, False), ("pass", 12, True), ("pass", 13, True), ("cannot tell", 0, True)],
)
def test_another_acceptance_test_is_due_in_the_month_in_which_the_report_asks_for_it(
    client: TestClient, monkeypatch: pytest.MonkeyPatch, outcome: Outcome, months: int, due: bool
) -> None:
    cited = SetupCited(
        certificate="0123",
        camera="Made Up 1",
        artefact="ball",
        outcome=outcome,
        made="2026-03-31",
        months=months,
        valid_months=12,
    )
    monkeypatch.setattr(camera_checks, "cited_setups", lambda *_: (cited,))
    case_id = client.post(f"{API}/cases", json={}).json()["id"]
    (told,) = client.get(f"{API}/cases/{case_id}/kit").json()["setups"]
    assert told["due"] is due
    assert told["finding"]["code"] == cited.finding.code


def test_what_a_tape_said_of_the_size_is_told_as_the_accuracy_says_it(
    client: TestClient, app_state: AppState
) -> None:
    case_id = client.post(f"{API}/cases", json={}).json()["id"]
    said = [
        SCALE.judged(0.01, note("said.as_is", message="The scale agrees.")),
        TAPE.judged(
            0.4, note("said.as_is", message="The tape read 354 mm; the surface has 353.1 mm there.")
        ),
        TAPE.judged(
            5.0, note("said.as_is", message="The tape read 254 mm; the surface has 263.1 mm there.")
        ),
    ]
    accuracy = app_state.shelf.case(case_id).folder.accuracy("json")
    accuracy.write_text(json.dumps({"unit": "mm", "criteria": [tree_of(one) for one in said]}))
    assert client.get(f"{API}/cases/{case_id}/kit").json()["tapes"] == [
        {"light": one.light, "finding": as_json(one.finding)} for one in said[1:]
    ]
    accuracy.write_text('{"criteria": 3}')
    assert client.get(f"{API}/cases/{case_id}/kit").json()["tapes"] == []


def test_movement_and_what_was_done_with_the_photos_are_told_as_the_pages_say_it(
    client: TestClient, app_state: AppState
) -> None:
    case_id = client.post(f"{API}/cases", json={}).json()["id"]
    folder = app_state.shelf.case(case_id).folder
    moved = MOVED.judged(8.0, note("said.as_is", message="The limb moved by up to 8.0 mm."))
    agrees = SCALE.judged(0.01, note("said.as_is", message="It agrees."))
    judged = {"criteria": [tree_of(one) for one in (agrees, moved)]}
    folder.accuracy("json").write_text(json.dumps(judged))
    still, reduced = "What stood still in the photos was left out.", "The photos were reduced."
    told = {"scene": {"placed": 12, "notes": [still]}, "resolution": {"notes": [reduced]}}
    folder.summary.write_text(json.dumps(told))
    said = "The limb moved by up to 8.0 mm."
    assert notes_of(client, case_id) == [said, still, reduced]
    folder.summary.write_text("no JSON")
    unread, still_said = notes_of(client, case_id)
    assert folder.summary.name in unread
    assert still_said == said
    folder.accuracy("json").write_text('{"criteria": 3}')
    files = (folder.accuracy("json").name, folder.summary.name)
    told_of = notes_of(client, case_id)
    assert [name in one for one, name in zip(told_of, files, strict=True)] == [True, True]


def test_what_an_earlier_version_wrote_is_told_in_its_words(
    client: TestClient, app_state: AppState
) -> None:
    case_id = client.post(f"{API}/cases", json={}).json()["id"]
    old = {"key": "movement", "light": "green", "sentence": "Limb and scale board kept still."}
    accuracy = app_state.shelf.case(case_id).folder.accuracy("json")
    accuracy.write_text(json.dumps({"criteria": [old]}))
    assert notes_of(client, case_id) == [old["sentence"]]


def notes_of(client: TestClient, case_id: str) -> list[str]:
    notes = client.get(f"{API}/cases/{case_id}/kit").json()["notes"]
    return [one["sentence"] for one in notes]


def camera_file(folder: Path) -> bytes:
    lens = Camera(width_px=640, height_px=480, fx=900.0, fy=900.0, cx=319.5, cy=239.5)
    calibration = Calibration(
        camera=lens,
        covariance=np.diag([1e-4, 1e-4, 1e-4, 1e-4, 0, 1e-6, 1e-6, 1e-8, 1e-8, 0]),
        source="board",
        rms_px=0.1,
        label="Made Up 1",
    )
    write_camera(folder / "camera.json", calibration, {})
    return (folder / "camera.json").read_bytes()


def photo(client: TestClient, case: str, name: str, width_px: int, height_px: int) -> None:
    noise = np.random.default_rng(width_px).integers(0, 255, (height_px, width_px, 3), np.uint8)
    made = io.BytesIO()
    Image.fromarray(noise).save(made, "PNG")
    sent = client.put(f"{case}/photos/{name}", content=made.getvalue())
    assert sent.json()["whole"], sent.text
