"""Landmarks after edits: on the surface, or gone with a word."""

import numpy as np
import pytest

from limbgram.core.mesh.tree_cache import tree_on
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.offset import Offset
from limbgram.workbench.edits.plane_cut import PlaneCut
from limbgram.workbench.edits.relieve import Relieve
from limbgram.workbench.edits.trimline import Trimline
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.frame.landmarks import with_landmarks
from limbgram.workbench.limb import Landmark, Limb
from limbgram.workbench.recipe.recipe import Entry, Recipe, replay


def marked(limb: Limb, heights_mm: dict[str, float]) -> Limb:
    """Landmarks in front, at heights in the limb frame."""
    points = limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)
    marks = []
    for name, height_mm in heights_mm.items():
        front = np.where(points[:, 1] > 0, np.hypot(points[:, 0], points[:, 2] - height_mm), np.inf)
        marks.append(Landmark(name=name, position_mm=limb.mesh.vertices_mm[front.argmin()]))
    return with_landmarks(limb, marks)


def off_mm(limb: Limb) -> float:
    places = np.stack([mark.position_mm for mark in limb.landmarks])
    return float(tree_on(limb.mesh).closest(places).distances_mm.max())


CUT = PlaneCut(height_mm=60)
TURNS = 2 * np.pi * np.arange(12) / 12
LINE = Trimline(through=tuple((40 * float(np.sin(a)), 40 * float(np.cos(a)), 60.0) for a in TURNS))


@pytest.mark.parametrize("edit", [CUT, LINE], ids=["plane", "trimline"])
def test_a_landmark_that_is_cut_off_is_gone_and_the_ledger_says_so(limb: Limb, edit) -> None:
    start = marked(limb, {"low": 30.0, "just above": 64.0, "high": 85.0})
    done = replay(Recipe(name="cut", entries=(Entry(edit=edit),)), start)
    assert {mark.name for mark in done.limb.landmarks} == {"low"}  # front and right lay at 100 mm
    assert off_mm(done.limb) < 1e-3
    lost = [one for one in done.ledger.lines[0].told if one.code == "edit.landmark.cut_off"]
    assert {"high", "just above"} <= {one.values["name"] for one in lost}
    assert "low" not in {one.values["name"] for one in lost}


@pytest.mark.parametrize(
    "edit",
    [Offset(distance_mm=-2), Relieve(at="low", depth_mm=5, falloff_mm=20), Wall(thickness_mm=3)],
    ids=["offset", "relief", "wall"],
)
def test_other_edits_take_their_landmarks_along(limb: Limb, edit) -> None:
    start = marked(limb, {"low": 30.0, "high": 85.0})
    after = do_edit(start, edit)
    assert {mark.name for mark in after.landmarks} == {"front", "right", "low", "high"}
    assert off_mm(after) < 1e-3
    assert not any(note.code == "edit.landmark.cut_off" for note in after.notes)
