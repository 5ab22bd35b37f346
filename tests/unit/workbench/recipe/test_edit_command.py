"""`limbgram edit`: a recipe made, changed and applied; the same bytes on any number of threads."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import trimesh
from typer.testing import CliRunner

from limbgram.cli.main import app

RUN = CliRunner()


def edit(*words: str | Path, code: int = 0) -> str:
    result = RUN.invoke(app, ["edit", *map(str, words)])
    assert result.exit_code == code, result.output
    return result.output


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    path = tmp_path / "scan.stl"
    trimesh.creation.capsule(height=100, radius=40, count=(48, 48)).export(path)
    return path


def test_a_recipe_from_its_beginning_to_a_new_shape(scan: Path, tmp_path: Path) -> None:
    recipe, out = tmp_path / "first.toml", tmp_path / "out.ply"
    edit("new", recipe, "--for", scan)
    edit("new", recipe, code=2)
    edit("add", recipe, "smoothing", "passes=2")
    edit("add", recipe, "offset", "distance_mm=-0.5")
    edit("add", recipe, "load", "at=[40,0,50]", "positions_in=mesh", "depth_mm=3", "falloff_mm=15")
    assert '"first", 3 edits' in edit("move", recipe, "2", "1")
    edit("off", recipe, "2")
    assert "smoothing (off)" in edit("show", recipe)
    answer = json.loads(edit("apply", scan, recipe, "-o", out, "--json"))
    lines = answer["ledger"]["lines"]
    assert [line["number"] for line in lines] == [1, 3]
    assert lines[0]["displacement"]["mean_mm"] == pytest.approx(-0.5, abs=0.01)
    assert lines[1]["displacement"]["largest_mm"] == pytest.approx(-3, abs=0.05)
    assert trimesh.load(out).is_watertight
    assert "recipes do the same" in edit("diff", recipe, recipe)


def test_a_refused_edit_leaves_no_file(scan: Path, tmp_path: Path) -> None:
    recipe, out = tmp_path / "deep.toml", tmp_path / "out.ply"
    edit("new", recipe)
    edit("add", recipe, "offset", "distance_mm=-60")
    assert "Edit 1 (offset" in edit("apply", scan, recipe, "-o", out, code=4)
    edit("apply", scan, recipe, "-o", scan, code=2)
    assert not out.exists()
    edit("add", recipe, "nothing", code=2)
    edit("add", recipe, "offset", "distance_mm", code=2)
    edit("kinds", "nothing", code=2)
    assert "Outwards; negative inwards." in edit("kinds", "offset")
    assert "For: foot." in edit("kinds", "heel-skive")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("wall thickness_mm=0", "thickness of 1 mm or more, not 0"),
        ("wall thickness_mm=-3 side=inward", "not -3"),
        ("wall thickness_mm=nan", "must be a number within reason, not nan"),
        ("wall thickness_mm=1e-9", "1 mm or more, not 1e-09"),
        ("liner name=alpha-3mm share=1.5", "(share) goes from 0 to 1, not 1.5"),
        ("liner name=alpha-4mm", "must be one of iceross-original, alpha-3mm"),
        ("liner name=alpha-3mm proximal_mm=90", "leave out the height at which it is full"),
        ("liner name=alpha-3mm above=patella", "leave out the height at which it is full"),
        ("liner name=iceross-original proximal_mm=-20", "at -20 mm, where the limb ends"),
        ("liner name=iceross-original above=patella", "over the landmark “patella”"),
        (
            "plane-cut height_mm=100 forward_deg=90",
            "(forward_deg) goes from -80 to 80 degrees, not 90",
        ),
        ("plane-cut height_mm=100 right_deg=-81", "there is the trimline"),
        ("plane-cut height_mm=3000", "(height_mm) is 3000 mm, which is longer than any limb"),
        ("distal-end height_mm=0", "(height_mm) goes above 0 and up to 2000 mm, not 0"),
        ("distal-end height_mm=40 roundness=1.1", "(roundness) goes from 0 to 1, not 1.1"),
        ("distal-end height_mm=40 lengthen_mm=-20", "less than half of its height, 40 mm"),
        ("distal-end height_mm=40 lengthen_mm=9000", "(lengthen_mm) is 9000 mm"),
        ("offset distance_mm=-2001", "longer than any limb"),
        ("reduction heights_mm=[10,9000] per_cent=[1,1] of=girth", "(heights_mm) is 9000 mm"),
        ("trimline through=[]", "at least 3 points"),
        ('trimline through=["a","b","a"]', "two points in a row are the same"),
        ("load depth_mm=5 falloff_mm=9 within=[[0,0,0]]", "at least 3 points"),
    ],
)
def test_what_makes_sense_on_no_limb_is_not_added(tmp_path: Path, words: str, told: str) -> None:
    recipe = tmp_path / "a.toml"
    edit("new", recipe)
    before = recipe.read_bytes()
    assert told in " ".join(edit("add", recipe, *words.split(), code=2).split())
    assert recipe.read_bytes() == before


@pytest.mark.parametrize(
    "words",
    [
        "wall thickness_mm=1",
        "liner name=alpha-3mm share=1",
        "liner name=iceross-original proximal_mm=0 above=patella",
        "plane-cut height_mm=-10 above=patella forward_deg=80",
        "distal-end height_mm=40 lengthen_mm=-19.9 roundness=1",
        'trimline through=["a","b","c"]',
    ],
)
def test_what_stands_at_its_limit_is_added(tmp_path: Path, words: str) -> None:
    recipe = tmp_path / "a.toml"
    edit("new", recipe)
    assert "1 edit" in edit("add", recipe, *words.split())


def test_a_recipe_written_by_hand_is_held_to_the_same(scan: Path, tmp_path: Path) -> None:
    recipe, out = tmp_path / "a.toml", tmp_path / "out.ply"
    edit("new", recipe)
    recipe.write_text(recipe.read_text() + '[[edit]]\ndo = "offset"\ndistance_mm = 9000.0\n')
    assert "longer than any limb" in edit("apply", scan, recipe, "-o", out, code=4)
    assert not out.exists()


def test_a_recipe_without_edits_says_that_nothing_was_done(scan: Path, tmp_path: Path) -> None:
    recipe, out = tmp_path / "none.toml", tmp_path / "out.ply"
    edit("new", recipe)
    edit("add", recipe, "smoothing")
    assert "No edit was done" not in edit("apply", scan, recipe, "-o", out)
    edit("off", recipe, "1")
    assert "No edit was done" in edit("apply", scan, recipe, "-o", out)
    answer = json.loads(edit("apply", scan, recipe, "-o", out, "--json"))
    assert any(note["code"] == "recipe.nothing_done" for note in answer["notes"])


def test_a_default_that_was_typed_stands_in_the_file(tmp_path: Path) -> None:
    recipe = tmp_path / "a.toml"
    edit("new", recipe)
    edit("add", recipe, "sock", "thickness_mm=0.3")
    assert "thickness_mm = 0.3\n" in recipe.read_text()


def test_another_scan_needs_a_word(scan: Path, tmp_path: Path) -> None:
    recipe, other = tmp_path / "a.toml", tmp_path / "other.stl"
    edit("new", recipe, "--for", scan)
    trimesh.creation.capsule(height=90, radius=40).export(other)
    edit("apply", other, recipe, "-o", tmp_path / "out.ply", code=2)
    edit("apply", other, recipe, "-o", tmp_path / "out.ply", "--other-scan")


def test_replay_gives_the_same_bytes_on_any_number_of_threads(scan: Path, tmp_path: Path) -> None:
    recipe = tmp_path / "a.toml"
    edit("new", recipe)
    edit("add", recipe, "load", "at=[40,0,50]", "positions_in=mesh", "depth_mm=3", "falloff_mm=15")
    edit("add", recipe, "smoothing", "passes=5")
    edit("add", recipe, "offset", "distance_mm=2")
    found: set[str] = set()
    for threads in ("1", "2"):
        out = tmp_path / f"out{threads}.ply"
        names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
        command = [sys.executable, "-c", "from limbgram.cli.main import app; app()"]
        command += ["edit", "apply", str(scan), str(recipe), "-o", str(out)]
        subprocess.run(
            command,
            check=True,
            capture_output=True,
            env={**os.environ, **dict.fromkeys(names, threads)},
        )
        found.add(hashlib.sha256(out.read_bytes()).hexdigest())
    assert len(found) == 1
