"""Outward walls over creases: against bodies whose surroundings are known exactly.

Round a union of balls and capsules, what is no farther than d is the union of the same ones with
radii larger by d: so the wall's outer side, and its volume, are known wherever it fills a crease.
"""

from collections.abc import Callable

import numpy as np
import pytest
from tests.unit.workbench.edits.test_hollow import (
    BETWEEN_MM,
    CUT_MM,
    FINGER_MM,
    KNUCKLES_MM,
    PALM_MM,
    TIPS_MM,
    WRIST_MM,
    capsule_mm,
    hand,
    require_one_sound_solid,
)
from tests.unit.workbench.edits.test_solids import ragged

from limbgram.core.mesh.isosurface import level_surface
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.findings import Finding
from limbgram.reconstruction.surface.resampling import refine
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import Limb

SMALL_MM, LARGE_MM, APART_MM = 18.0, 30.0, 40.0
"""Radii of two balls, one over the other, that meet in a crease of 92 degrees."""
Inside = Callable[[np.ndarray, float], np.ndarray]
"""How far inside a body with radii larger by so much places lie."""


def snowman_mm(places: np.ndarray, more_mm: float) -> np.ndarray:
    small = capsule_mm(places, 0.0, 0.0, 0.0, SMALL_MM + more_mm)
    large = capsule_mm(places, 0.0, APART_MM, APART_MM, LARGE_MM + more_mm)
    return np.maximum(small, large)


def snowman() -> Mesh:
    """Open across the middle of its larger ball."""
    step_mm = 1.5
    lowest = np.array([-34.0, -34.0, -22.0])
    places = lowest + step_mm * np.moveaxis(np.indices((47, 47, 66)), 0, -1)
    whole = refine(level_surface(snowman_mm(places, 0.0), lowest, step_mm), step_mm)
    return keep_positive(whole, APART_MM - whole.vertices_mm[:, 2]).mesh


def hand_mm(places: np.ndarray, more_mm: float) -> np.ndarray:
    inside = capsule_mm(places, 0.0, WRIST_MM, KNUCKLES_MM, PALM_MM + more_mm)
    for x_mm in (-BETWEEN_MM, 0.0, BETWEEN_MM):
        finger = capsule_mm(places, x_mm, KNUCKLES_MM, TIPS_MM, FINGER_MM + more_mm)
        inside = np.maximum(inside, finger)
    return inside


def around_mm3(inside: Inside, thickness_mm: float, low_mm: float, high_mm: float) -> float:
    """Volume between two heights of what is no farther from a body, without the body."""
    step_mm = 0.5
    axis = np.arange(-45.0, 45.0, step_mm) + step_mm / 2
    found = 0
    for z_mm in np.arange(low_mm, high_mm, step_mm) + step_mm / 2:
        x, y = np.meshgrid(axis, axis)
        places = np.stack([x, y, np.full_like(x, z_mm)], axis=-1)
        found += int(((inside(places, thickness_mm) > 0) & (inside(places, 0.0) <= 0)).sum())
    return found * step_mm**3


def told(notes: tuple[Finding, ...], code: str) -> Finding:
    return next(one for one in notes if one.code == code)


@pytest.mark.parametrize("thickness_mm", [2.0, 4.0, 8.0])
def test_a_crease_is_filled_and_the_wall_nowhere_thinner(thickness_mm: float) -> None:
    mesh = snowman()
    made = do_edit(Limb(mesh=mesh), Wall(thickness_mm=thickness_mm))
    require_one_sound_solid(made.mesh)
    np.testing.assert_array_equal(made.mesh.vertices_mm[: len(mesh)], mesh.vertices_mm)
    assert told(made.notes, "edit.wall.thickness").values["thinnest_mm"] > thickness_mm - 0.05
    rim = np.abs(made.mesh.vertices_mm[:, 2] - APART_MM) < 1e-6
    assert made.mesh.vertices_mm[:, 2].max() < APART_MM + 1e-6
    rim_mm = np.linalg.norm(made.mesh.vertices_mm[rim, :2], axis=1)
    brim = np.abs(mesh.vertices_mm[:, 2] - APART_MM) < 1e-6
    brim_mm = np.linalg.norm(mesh.vertices_mm[brim, :2], axis=1)  # facets: LARGE_MM within 0.2
    assert rim_mm.min() == pytest.approx(brim_mm.min(), abs=1e-6)
    assert rim_mm.max() == pytest.approx(brim_mm.max() + thickness_mm, abs=0.05)
    low_mm = -SMALL_MM - thickness_mm - 1
    true = around_mm3(snowman_mm, thickness_mm, low_mm, APART_MM)
    assert volume_mm3(made.mesh) == pytest.approx(true, rel=0.01)


def test_room_between_fingers_that_is_too_narrow_is_filled_and_told() -> None:
    mesh, thickness_mm = hand(), 6.0
    made = do_edit(Limb(mesh=mesh), Wall(thickness_mm=thickness_mm))
    require_one_sound_solid(made.mesh)
    np.testing.assert_array_equal(made.mesh.vertices_mm[: len(mesh)], mesh.vertices_mm)
    assert told(made.notes, "edit.wall.thickness").values["thinnest_mm"] > thickness_mm - 0.05
    filled = told(made.notes, "edit.wall.solid").values
    assert KNUCKLES_MM < filled["point_mm"][2] < TIPS_MM
    high_mm = TIPS_MM + FINGER_MM + thickness_mm + 1
    true = around_mm3(hand_mm, thickness_mm, CUT_MM, high_mm)
    assert volume_mm3(made.mesh) == pytest.approx(true, rel=0.01)


def test_an_outward_wall_of_a_ragged_hand_is_nowhere_thinner_than_asked() -> None:
    made = do_edit(Limb(mesh=ragged(hand(), 8)), Wall(thickness_mm=6.0))
    require_one_sound_solid(made.mesh)
    assert told(made.notes, "edit.wall.thickness").values["thinnest_mm"] > 5.95
