"""`limbgram trend`: an arm that grows by a known share from visit to visit."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest
import trimesh
from scipy.stats import norm
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import with_faces
from limbgram.formats.limb_file import write_limb
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame

RADIUS_MM, SIDES = 50.02, 240
GIRTH_MM = 2 * SIDES * RADIUS_MM * np.sin(np.pi / SIDES)
DAYS = ("2026-03-02", "2026-03-16", "2026-03-30")
PLACES = {
    "lateral humeral epicondyle": (1.0, 0.0, 90.0),
    "medial humeral epicondyle": (-1.0, 0.0, 90.0),
    "olecranon": (0.0, -1.0, 90.0),
    "distal end": (0.0, 0.0, -150.0),
}
"""x and y in radii."""


def arm(growth: float) -> Limb:
    """A round arm, all of whose lengths across it grow; the olecranon goes up by as many radii."""
    shape = trimesh.creation.capsule(height=200, radius=RADIUS_MM, count=[60, SIDES])
    places = np.asarray(shape.vertices) * (growth, growth, 1.0)
    wide, up = growth * RADIUS_MM, (growth - 1) * RADIUS_MM
    marks = tuple(
        Landmark(
            name=name, position_mm=np.array([x * wide, y * wide, z + up * (name == "olecranon")])
        )
        for name, (x, y, z) in PLACES.items()
    )
    mesh = Mesh(
        vertices_mm=places,
        faces=np.asarray(shape.faces, np.int32),
        sigma_mm=np.full(len(places), 0.1, np.float32),
    )
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="right")
    return AlignedLimb(mesh=mesh, landmarks=marks, frame=frame, kind="arm")


@pytest.fixture
def visits(tmp_path: Path) -> list[str]:
    shares = (1.0, 1.01, 1.02)
    return [str(write_limb(arm(g), tmp_path / f"v{k}.ply")) for k, g in enumerate(shares)]


def asked(*words: str, days: tuple[str, ...] = DAYS) -> Any:
    every = [word for day in days for word in ("--day", day)]
    return CliRunner().invoke(app, ["trend", *words, *every, "--json"])


def test_a_growing_girth_is_told_with_its_change(visits: list[str], tmp_path: Path) -> None:
    book, text = tmp_path / "trend.xlsx", tmp_path / "trend.csv"
    files = ("--xlsx", str(book), "--csv", str(text), "--decimal", "comma")
    answer = asked(*visits, *files)
    assert answer.exit_code == 0, answer.output
    found = json.loads(answer.stdout)
    measures = {one["name"]: one for one in found["measures"]}
    girth = measures["elbow_girth_mm"]
    assert girth["change"] == pytest.approx(0.02 * GIRTH_MM, abs=1e-3)
    assert girth["trend"]["per_week"] == pytest.approx(0.02 * GIRTH_MM / 4, abs=1e-3)
    assert 0 < girth["change_95"] < girth["change"]
    assert girth["trend"]["probability"] > 0.975
    width = measures["elbow_width_mm"]  # landmarks err along the surface, so across it
    assert width["change"] == pytest.approx(0.02 * 2 * RADIUS_MM, abs=1e-6)
    assert width["change_95"] == pytest.approx(1.96 * 0.1 * 2, rel=0.1)
    length = measures["olecranon_to_end_mm"]  # 1 mm more, where a landmark errs by 2
    assert length["change"] == pytest.approx(0.02 * RADIUS_MM, abs=1e-6)
    assert length["change_95"] == pytest.approx(1.96 * 2 * np.sqrt(2), rel=0.05)
    asked_for = norm.cdf(0.02 * RADIUS_MM * 1.96 / length["change_95"])
    assert length["trend"]["probability"] == pytest.approx(asked_for, abs=1e-6)
    assert "axilla_girth_mm" in found["left_out"]
    rows = list(openpyxl.load_workbook(book)["trend"].iter_rows(values_only=True))
    assert dict(zip(rows[0], rows[1], strict=True))["change"] == pytest.approx(width["change"])
    assert len(openpyxl.load_workbook(book)["visits"]["A"]) == 1 + 3 * len(measures)
    assert text.read_text("utf-8-sig").startswith("name;measure;unit;first;last;change;")


def test_of_a_wall_the_inside_is_followed_and_that_is_said(tmp_path: Path) -> None:
    limb = arm(1.0)
    low = (limb.mesh.vertices_mm[limb.mesh.faces][:, :, 2] < 110).all(1)
    inside = limb.with_mesh(with_faces(limb.mesh, limb.mesh.faces[low]))
    socket = do_edit(inside, Wall(thickness_mm=4.0))
    files = [str(write_limb(one, tmp_path / f"{k}.ply")) for k, one in enumerate((inside, socket))]
    found = json.loads(asked(*files, days=DAYS[:2]).stdout)
    (girth,) = (one for one in found["measures"] if one["name"] == "elbow_girth_mm")
    assert girth["change"] == pytest.approx(0.0, abs=0.01)
    assert "compare.wall" in [one["code"] for one in found["notes"]]


def test_people_read_what_changed_and_how_surely(visits: list[str]) -> None:
    every = [word for day in DAYS for word in ("--day", day)]
    told = CliRunner().invoke(app, ["trend", *visits, *every]).stdout
    assert "2 of 3 measures changed by more than their uncertainty" in told
    german = {"LIMBGRAM_LANGUAGE": "de"}
    words = ["trend", *visits, *every]
    assert "2 von 3 Maßen haben sich" in CliRunner().invoke(app, words, env=german).stdout
    (girth,) = [line for line in told.splitlines() if "Girth at the epicondyles" in line]
    assert girth.split()[:3] == [
        f"{GIRTH_MM:.1f}",
        f"{1.02 * GIRTH_MM:.1f}",
        f"{0.02 * GIRTH_MM:+.1f}",
    ]
    assert "> 99.9%" in girth
    (length,) = [line for line in told.splitlines() if "Olecranon to the distal end" in line]
    assert length.endswith("within the uncertainty")


def test_what_is_no_trend_is_refused(visits: list[str], tmp_path: Path) -> None:
    def code(answer: Any) -> str:
        assert answer.exit_code in (2, 4), answer.output
        return json.loads(answer.stdout)["error"]["finding"]["code"]

    assert code(asked(*visits[:2])) == "options.compare.days"
    assert code(asked(*visits, days=(DAYS[0],) * 3)) == "trend.one_day"
    limb = arm(1.0)
    left = replace(limb, frame=replace(limb.frame, side="left"))
    other = str(write_limb(left, tmp_path / "left.ply"))
    assert code(asked(*visits[:2], other)) == "trend.sheets_differ"
    bare = str(write_limb(replace(limb, landmarks=()), tmp_path / "bare.ply"))
    assert code(asked(bare, bare, days=DAYS[:2])) == "trend.no_figure"
