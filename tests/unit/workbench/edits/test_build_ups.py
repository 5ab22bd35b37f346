"""Build-ups: each marked bone of each kind's preset gets its room, and nothing is carved in."""

import numpy as np
import pytest
from tests.unit.workbench.edits.conftest import RADIUS_MM, stump

from limbgram.core.errors import EditError
from limbgram.core.geometry.frames import Rigid
from limbgram.workbench.anatomy.kind import Kind
from limbgram.workbench.anatomy.known_kinds import KIND_NAMED
from limbgram.workbench.edits.build_ups import BuildUps
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.limb import AlignedLimb, Landmark, LimbFrame

BUILT = [kind for kind in KIND_NAMED.values() if kind.presets]
FAR_APART = [(turn, z) for z in (76.0, 128.0) for turn in (0, 70, 140, 210, 285)]
"""Degrees round the tube, and heights: corners of its surface, 50 mm from each other."""


@pytest.mark.parametrize("kind", BUILT, ids=lambda kind: kind.name)
def test_every_marked_bone_gets_the_room_of_its_preset(kind: Kind) -> None:
    angles = {name: np.radians(turn) for name, (turn, _) in zip(kind.presets, FAR_APART)}
    outwards = {name: np.array([np.cos(a), np.sin(a), 0]) for name, a in angles.items()}
    limb = AlignedLimb(
        mesh=stump(),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="right" if kind.sided else "none"),
        kind=kind.name,
        landmarks=tuple(
            Landmark(name=name, position_mm=RADIUS_MM * outwards[name] + [0, 0, z])
            for name, (_, z) in zip(kind.presets, FAR_APART)
        ),
    )
    after = do_edit(limb, BuildUps(falloff_mm=10.0, flat_mm=3.0))
    for name, height_mm in kind.presets.items():
        step = after.landmark(name).position_mm - limb.landmark(name).position_mm
        np.testing.assert_allclose(step, height_mm * outwards[name], atol=0.05)
    points = after.mesh.vertices_mm[after.mesh.vertices_mm[:, 2] > RADIUS_MM]
    sunk = RADIUS_MM * (1 - np.cos(np.pi / 72))  # a chord of the tube lies inside it by this
    assert np.hypot(points[:, 0], points[:, 1]).min() > RADIUS_MM - sunk - 1e-9


def test_bones_that_bear_nothing_are_in_the_presets_of_socket_and_brace() -> None:
    assert {"fibula head", "tibial crest", "tibia end"} <= set(KIND_NAMED["transtibial"].presets)
    brace = KIND_NAMED["torso"].presets
    for side in ("right", "left"):
        assert {f"{side} iliac spine", f"{side} iliac crest", f"{side} tenth rib"} <= set(brace)
    assert "patellar tendon" not in KIND_NAMED["transtibial"].presets


def test_what_stays_is_named_in_any_language() -> None:
    knee, crest = (RADIUS_MM * np.array([np.cos(a), np.sin(a), 0]) for a in (0.0, np.radians(90)))
    up = np.array([0.0, 0.0, 100.0])
    limb = AlignedLimb(
        mesh=stump(),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="right"),
        kind="transtibial",
        landmarks=(
            Landmark(name="Fibulakopf", position_mm=knee + up),
            Landmark(name="tibial crest", position_mm=crest + up),
        ),
    )
    after = do_edit(limb, BuildUps(without=("Wadenbeinköpfchen",)))
    step = after.landmark("fibula head").position_mm - limb.landmark("fibula head").position_mm
    np.testing.assert_allclose(step, 0, atol=1e-9)
    assert after.notes[-1].values["names"] == ("tibial crest",)


@pytest.mark.parametrize("name", ["fibula haed", "patellar tendon"])
def test_what_stays_has_to_be_of_the_preset(name: str) -> None:
    """A misspelt name would be built up all the same."""
    head = Landmark(name="fibula head", position_mm=np.array([RADIUS_MM, 0.0, 100.0]))
    limb = AlignedLimb(
        mesh=stump(),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="right"),
        kind="transtibial",
        landmarks=(head,),
    )
    with pytest.raises(EditError) as refused:
        do_edit(limb, BuildUps(without=("tibial crest", name)))
    assert refused.value.finding.code == "edit.build_ups.without"
    assert refused.value.finding.values["names"] == (name,)
