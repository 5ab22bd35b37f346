"""Outputs that cannot be written, and Ctrl-C: a clear refusal, its exit code, and no half file."""

import json
import os
from pathlib import Path
from typing import NoReturn

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core import files
from limbgram.core.geometry.frames import Rigid
from limbgram.formats.limb_file import write_limb
from limbgram.synthetic.props.gauges import GaugeCylinder, calibrated_values
from limbgram.workbench.carving.radius_map import RadiusMap
from limbgram.workbench.limb import AlignedLimb, LimbFrame

RUNNER = CliRunner()

WRITING = {
    "table": ["measure", "SCAN", "--csv", "OUT/table.csv"],
    "picture": ["measure", "SCAN", "--picture", "OUT/picture.png"],
    "edit": ["edit", "apply", "SCAN", "RECIPE", "-o", "OUT/edited.ply"],
    "recipe": ["edit", "new", "OUT/new.toml"],
    "mesh": ["export", "SCAN", "--to", "stl", "-o", "OUT/limb.stl"],
    "aop": ["export", "SCAN", "--to", "aop", "--side", "left", "-o", "OUT/limb.aop"],
    "comparison": ["compare", "SCAN", "SCAN", "--align", "as-is", "--picture", "OUT/both.png"],
    "report": ["report", "SCAN", "-o", "OUT/record"],
}


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("work")
    radii = np.tile(30 + 4 * np.cos(np.radians(np.arange(-90, 270, 6.0))), (7, 1))
    body = RadiusMap(thetas_deg=np.arange(0, 360, 6.0), z_mm=np.linspace(0, 90, 7), radii_mm=radii)
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="left")
    scan = write_limb(AlignedLimb(mesh=body.surface(), frame=frame), folder / "scan.ply")
    for words in (
        ["new", str(folder / "recipe.toml"), "--for", str(scan)],
        ["add", str(folder / "recipe.toml"), "offset", "distance_mm=0.5"],
    ):
        assert RUNNER.invoke(app, ["edit", *words]).exit_code == 0
    return folder


def words_of(name: str, work: Path, out: Path) -> list[str]:
    places = {"SCAN": work / "scan.ply", "RECIPE": work / "recipe.toml"}
    words = [str(places.get(word, word)) for word in WRITING[name]]
    return [word.replace("OUT", str(out)) for word in words]


@pytest.mark.parametrize("name", WRITING)
def test_under_a_file_nothing_can_be_written(name: str, work: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("kept")
    answer = RUNNER.invoke(app, [*words_of(name, work, tmp_path / "file"), "--json"])
    assert answer.exit_code == 5
    message = json.loads(answer.stdout)["error"]["message"]
    assert str(tmp_path / "file") in message
    assert "folder" in message
    assert [path.read_text() for path in tmp_path.iterdir()] == ["kept"]


@pytest.mark.parametrize("name", ["table", "picture", "edit", "mesh", "comparison"])
def test_a_place_to_write_is_looked_at_before_the_shape_is(name: str, tmp_path: Path) -> None:
    """There is no shape to work on, and what is said is that nothing could be written."""
    answer = RUNNER.invoke(app, [*words_of(name, tmp_path, tmp_path / "missing"), "--json"])
    assert answer.exit_code == 5
    message = json.loads(answer.stdout)["error"]["message"]
    assert str(tmp_path / "missing") in message
    assert "scan.ply" not in message


FOLDERS = {
    "capture": ["make-capture", "OUT", "--photos", "4", "--width", "300"],
    "demo": ["demo", "-o", "OUT"],
    "frames": ["frames", "FILM", "-o", "OUT"],
    "masks": ["masks", "CASE", "-o", "OUT"],
    "undistorted": ["undistort", "CASE", "-o", "OUT"],
    "certificate": ["verify-setup", "GAUGE", "CASE", "--mpe", "1", "-o", "OUT/kit.json"],
    "batch": ["batch", "CAPTURES", "-o", "OUT"],
    "camera": ["calibrate", "CAPTURES", "--board", "charuco:7x5:30:22:4X4_50", "-o", "OUT/c.json"],
}
"""Commands that make the folder they write into."""


@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_to_make_is_looked_at_before_the_work(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Photos, film and case are read, or a stage is set, only where something can be written."""

    def worked(*_: object, **__: object) -> NoReturn:
        raise AssertionError("it was begun")

    for work in (
        "synthetic.capture.stage_truth",
        "cases.video_frames.survey",
        "cases.masks.kept_evidence",
        "cli.undistort.kept_evidence",
        "cases.kit_verification.verify_kit",
        "batch.whole_batch.find_captures",
        "cli.calibrate.calibrate_photos",
    ):
        monkeypatch.setattr(f"limbgram.{work}", worked)
    film, gauge = tmp_path / "film.avi", tmp_path / "gauge.json"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"MJPG"), 25, (64, 48))
    for _ in range(8):
        writer.write(np.zeros((48, 64, 3), np.uint8))
    writer.release()
    gauge.write_text(json.dumps(calibrated_values(GaugeCylinder())))
    (tmp_path / "captures").mkdir()
    (tmp_path / "file").write_text("kept")
    places = {
        "FILM": film,
        "GAUGE": gauge,
        "CASE": tmp_path / "case",
        "CAPTURES": tmp_path / "captures",
    }
    words = [str(places.get(word, word)) for word in FOLDERS[name]]
    out = tmp_path / "file" / "deeper" / "still"
    there = sorted(tmp_path.iterdir())
    answer = RUNNER.invoke(app, [*(one.replace("OUT", str(out)) for one in words), "--json"])
    assert answer.exit_code == 5, answer.output
    assert json.loads(answer.stdout)["error"]["finding"]["code"] == "export.disk.no_folder"
    assert sorted(tmp_path.iterdir()) == there


def test_a_scan_whose_folder_takes_no_file_is_not_aligned(
    work: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def aligned(*_: object) -> NoReturn:
        raise AssertionError("it was aligned")

    monkeypatch.setattr("limbgram.cli.align.align", aligned)
    asked = os.access

    def access(at: str | Path, mode: int) -> bool:
        return Path(at) != work and asked(at, mode)

    monkeypatch.setattr("os.access", access)
    answer = RUNNER.invoke(app, ["align", str(work / "scan.ply"), "--side", "left", "--json"])
    assert answer.exit_code == 5
    finding = json.loads(answer.stdout)["error"]["finding"]
    assert finding["code"] == "export.disk.refused"
    assert finding["values"]["name"] == "scan.limb.json"


@pytest.mark.parametrize("name", WRITING)
def test_ctrl_c_while_a_file_is_written_leaves_none(
    name: str, work: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reached: list[int] = []

    def stop(handle: int) -> None:
        reached.append(handle)
        raise KeyboardInterrupt

    monkeypatch.setattr(files.os, "fsync", stop)
    before = sorted(work.iterdir())
    answer = RUNNER.invoke(app, [*words_of(name, work, tmp_path), "--json"])
    assert answer.exit_code == 130
    assert len(reached) == 1
    assert json.loads(answer.stdout)["error"]["kind"] == "Cancelled"
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []
    assert sorted(work.iterdir()) == before
