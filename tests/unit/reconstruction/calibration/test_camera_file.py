"""The camera file: what is written is read back, and nothing else is believed."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from limbgram.core.errors import CaseError, ExportError
from limbgram.core.geometry.lens import PARAMETERS
from limbgram.formats.camera import read_camera, write_camera
from limbgram.reconstruction.calibration.board import calibrate_detections
from limbgram.reconstruction.calibration.cameras import Calibration


@pytest.fixture(scope="module")
def calibration(capture: Callable[..., Any]) -> Calibration:
    return calibrate_detections(*capture().arguments).calibration


def test_a_calibration_is_read_back_to_the_last_bit(
    tmp_path: Path, calibration: Calibration
) -> None:
    path = tmp_path / "camera.json"
    calibration = replace(calibration, focal_35mm=26.0, digital_zoom=1.5, body="0123abcd")
    write_camera(path, calibration, {"board": "9 x 7"})
    again = read_camera(path)
    np.testing.assert_array_equal(again.covariance, calibration.covariance)
    assert replace(again, covariance=calibration.covariance) == calibration
    assert json.loads(path.read_text())["provenance"] == {"board": "9 x 7"}
    assert [one.name for one in tmp_path.iterdir()] == ["camera.json"]


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("format", "other", "format"),
        ("version", 2, "version must be 1, not 2"),
        ("width_px", 0, "width_px"),
        ("width_px", 2000.5, "width_px"),
        ("source", "hearsay", "source"),
        ("covariance", [[1.0]], "covariance"),
        ("covariance", None, "covariance"),
        ("parameters", None, "parameters"),
        ("parameters", {"fx": 3000.0}, "parameters needs fy"),
        (
            "parameters",
            {**dict.fromkeys(PARAMETERS, 0.0), "k1": "0"},
            r"parameters\.k1 must be a number",
        ),
        ("width_px", True, "width_px must be a whole number, not True"),
        ("rms_px", "small", "rms_px"),
    ],
)
def test_a_value_that_cannot_be_is_refused_by_name(
    tmp_path: Path, calibration: Calibration, key: str, value: object, told: str
) -> None:
    path = tmp_path / "camera.json"
    write_camera(path, calibration)
    record = json.loads(path.read_text())
    record[key] = value
    path.write_text(json.dumps(record))
    with pytest.raises(CaseError, match=told):
        read_camera(path)


def test_a_file_from_before_a_coefficient_has_zero_for_it(
    tmp_path: Path, calibration: Calibration
) -> None:
    path = tmp_path / "camera.json"
    write_camera(path, calibration)
    record = json.loads(path.read_text())
    for kind in ("parameters", "sigmas"):
        del record[kind]["k3"]
    path.write_text(json.dumps(record))
    with pytest.raises(CaseError, match="covariance"):
        read_camera(path)
    rows = [row for row, name in enumerate(PARAMETERS) if name != "k3"]
    record["covariance"] = [[record["covariance"][i][j] for j in rows] for i in rows]
    path.write_text(json.dumps(record))
    again = read_camera(path)
    expected = replace(calibration.camera, k3=0.0)
    assert again.camera == expected
    np.testing.assert_array_equal(
        again.covariance[np.ix_(rows, rows)], calibration.covariance[np.ix_(rows, rows)]
    )
    assert not again.covariance[PARAMETERS.index("k3")].any()


def test_a_covariance_with_a_negative_direction_is_refused(
    tmp_path: Path, calibration: Calibration
) -> None:
    path = tmp_path / "camera.json"
    write_camera(path, calibration)
    record = json.loads(path.read_text())
    record["covariance"][0][0] *= 1e-3
    path.write_text(json.dumps(record))
    with pytest.raises(CaseError, match="positive"):
        read_camera(path)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"\xff\xd8\xff\xe0", b"[" * 100_000])
def test_other_files_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "camera.json"
    path.write_bytes(content)
    with pytest.raises(CaseError, match="camera file"):
        read_camera(path)


def test_a_missing_file_and_a_file_for_a_folder_are_told(
    tmp_path: Path, calibration: Calibration
) -> None:
    with pytest.raises(CaseError, match="limbgram calibrate"):
        read_camera(tmp_path / "none.json")
    path = tmp_path / "file"
    path.write_text("no folder")
    with pytest.raises(ExportError, match="was not written"):
        write_camera(path / "camera.json", calibration)
