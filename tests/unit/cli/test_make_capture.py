"""`limbgram make-capture`: scans, paint and skin by option, and refusals that write nothing."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from limbgram.cli.main import app

RUNNER = CliRunner()
SMALL = ("--photos", "4", "--width", "300", "--json")


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """A cylinder of 90 mm diameter and 210 mm length, lying, in metres."""
    lying = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
    path = tmp_path / "J Smith.stl"
    trimesh.creation.cylinder(0.045, 0.21, sections=90, transform=lying).export(path)
    return path


def test_a_scan_is_photographed_and_noted_by_its_digest_alone(tmp_path: Path, scan: Path) -> None:
    folder = tmp_path / "capture"
    asked = ["make-capture", str(folder), "--shape", str(scan), "--unit", "m", *SMALL]
    done = RUNNER.invoke(app, asked)
    assert done.exit_code == 0, done.output
    digest = hashlib.sha256(scan.read_bytes()).hexdigest()
    said = json.loads(done.stdout)
    assert said["scan"]["sha256"] == digest
    assert said["scan"]["height_mm"] == pytest.approx(210.0, abs=2.0)
    text = (folder / "truth" / "notes.json").read_text()
    assert "Smith" not in text
    notes = json.loads(text)
    assert (notes["kind"], notes["scan"]["sha256"]) == ("scan", digest)
    assert notes["scan"]["mm_per_unit"] == 1000.0
    mesh = trimesh.load_mesh(folder / "truth" / "mesh.ply", process=False)
    assert mesh.is_watertight
    high = mesh.vertices[(mesh.vertices[:, 2] > 100) & (mesh.vertices[:, 2] < 200)]
    assert np.linalg.norm(high[:, :2], axis=1).mean() == pytest.approx(45.0, abs=0.2)


def test_paint_and_skin_are_as_asked_for(tmp_path: Path) -> None:
    folder = tmp_path / "capture"
    asked = ["--kind", "bulbous", "--paint", "dabs", "--bare", "0.2", "--uneven", "0.5"]
    asked += ["--relief", "0.1", "--detail", "veins", "--detail", "wrinkles"]
    done = RUNNER.invoke(app, ["make-capture", str(folder), *asked, *SMALL])
    assert done.exit_code == 0, done.output
    notes = json.loads((folder / "truth" / "notes.json").read_text())
    assert (notes["kind"], notes["paint"]) == ("bulbous", "dabs")
    assert (notes["paint_bare"], notes["paint_uneven"]) == (0.2, 0.5)
    details = notes["details"]
    assert (details["veins_mm"], details["wrinkles_mm"]) == (0.7, 1.0)
    assert (details["knit_mm"], details["scars_mm"]) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (("--unit", "mm"), "--shape"),
        (("--shape", "SCAN"), "--unit"),
        (("--shape", "SCAN", "--unit", "m", "--gauge", "cylinder"), "--gauge"),
        (("--shape", "SCAN", "--unit", "5000"), "Check the unit"),
        (("--gauge", "cylinder", "--detail", "knit"), "a gauge has no knit"),
        (("--paint", "print", "--bare", "0.2"), "only of dabs"),
        (("--uneven", "1.5"), "0 to 1 on one side"),
    ],
)
def test_what_cannot_be_made_is_refused_and_nothing_written(
    tmp_path: Path, scan: Path, asked: tuple[str, ...], said: str
) -> None:
    folder = tmp_path / "capture"
    words = [str(scan) if word == "SCAN" else word for word in asked]
    done = RUNNER.invoke(app, ["make-capture", str(folder), *words, *SMALL])
    assert done.exit_code not in (0, 1)
    assert said in " ".join(done.output.split())
    assert list(tmp_path.iterdir()) == [scan]
