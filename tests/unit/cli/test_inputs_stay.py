"""No command writes over what it reads, or over files of something else."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import PARAMETERS, Camera
from limbgram.formats.camera import read_camera, write_camera
from limbgram.formats.limb_file import write_limb
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.workbench.carving.radius_map import RadiusMap
from limbgram.workbench.limb import AlignedLimb, LimbFrame

CAMERAS = ["--camera", "second.json", "--camera", "session/camera.json"]
BOARD = ["--board", "14x10", "--square", "10"]


@pytest.fixture
def work(tmp_path: Path) -> Path:
    """Photos by name, a shape with its limb file, a case, camera files and other files."""
    (tmp_path / "photos").mkdir()
    for name in ("a.jpg", "b.jpg", "c.png"):
        (tmp_path / "photos" / name).write_bytes(name.encode())
    radii = np.tile(30 + 4 * np.cos(np.radians(np.arange(-90, 270, 6.0))), (7, 1))
    body = RadiusMap(thetas_deg=np.arange(0, 360, 6.0), z_mm=np.linspace(0, 90, 7), radii_mm=radii)
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="left")
    for name in ("scan.ply", "other.ply"):
        write_limb(AlignedLimb(mesh=body.surface(), frame=frame), tmp_path / name)
    (tmp_path / "settings.json").write_text(json.dumps({"format": "something else"}))
    (tmp_path / "case").mkdir()
    for name in ("case.json", "report.html"):
        (tmp_path / "case" / name).write_text("{}")
    (tmp_path / "website").mkdir()
    (tmp_path / "website" / "report.html").write_text("<h1>Ours</h1>")
    (tmp_path / "session").mkdir()
    for folder in (tmp_path, tmp_path / "session"):
        write_camera(folder / "camera.json", calibration(str(folder.name)))
    write_camera(tmp_path / "second.json", calibration("second"))
    return tmp_path


def calibration(label: str) -> Calibration:
    size = len(PARAMETERS)
    camera = Camera(width_px=60, height_px=40, fx=100.0, fy=100.0, cx=30.0, cy=20.0)
    return Calibration(
        camera=camera,
        covariance=np.zeros((size, size)),
        source="board",
        label=label,
        focal_mm=50.0,
        rms_px=0.1,
    )


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["calibrate", "photos", *BOARD, "-o", "photos/a.jpg"], "no camera file: it would be lost"),
        (["calibrate", "photos", *BOARD, "-o", "scan.limb.json"], "it would be lost"),
        (["calibrate", "photos", *BOARD, "-o", "settings.json"], "it would be lost"),
        (["calibrate", "photos", *BOARD, "-o", "case"], "it would be lost"),
        (["calibrate", "photos", *BOARD, "--report", "photos/c.png"], "among the photos"),
        (["calibrate", "photos/c.png", *BOARD, "--report", "photos/c.png"], "among the photos"),
        (["calibrate", "photos", *BOARD, "--report", "scan.ply"], "no name for a picture"),
        (["reconstruct", "photos", "-o", "photos"], "folder of the photos itself"),
        (["reconstruct", "photos", "-o", "website"], "written over: report.html"),
        (["reconstruct", "photos", "-o", "scan.ply"], "cannot be made"),
        (
            ["reconstruct", "photos", *CAMERAS, "-o", "session"],
            "is given as a camera file",
        ),
        (["template", "learn", "scan.ply", "other.ply", "-o", "scan.limb.json"], "landmarks"),
        (["report", "scan.ply", "-o", "case"], "is a case"),
        (["edit", "new", "scan.ply"], "name of a shape"),
        (["export", "scan.ply", "--to", "ply", "-o", "scan.ply"], "place of the shape"),
        (["measure", "scan.ply", "--csv", "scan.ply"], "no name for a table"),
        (["measure", "scan.ply", "--tape", "40=200", "--fit", "scan.ply"], "place of the shape"),
        (["compare", "scan.ply", "other.ply", "--picture", "other.ply"], "no name for a picture"),
    ],
)
def test_what_is_read_stays(
    words: list[str], told: str, work: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(work)
    before = {path: path.read_bytes() for path in work.rglob("*") if path.is_file()}
    answer = CliRunner().invoke(app, [*words, "--json"])
    assert answer.exit_code in (2, 3), answer.output
    assert told in json.loads(answer.stdout)["error"]["message"]
    assert {path: path.read_bytes() for path in before} == before


def test_a_camera_file_may_be_made_again(work: Path) -> None:
    write_camera(work / "camera.json", calibration("again"))
    assert read_camera(work / "camera.json").label == "again"
