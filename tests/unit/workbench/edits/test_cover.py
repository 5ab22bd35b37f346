"""Walls where a shape is narrow or bends tightly: against bodies whose surroundings are known.

Round a union of balls and capsules, what is no farther than d is the union of the same ones with
radii larger by d: so an outward wall's other side, and its volume, are known wherever it fills a
crease. Inward, the fingers of a hand are too narrow for two walls.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from scipy.spatial import KDTree
from tests.unit.workbench.edits.conftest import stump
from tests.unit.workbench.edits.test_solids import ragged, require_one_sound_solid

from limbgram.core.errors import EditError
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.isosurface import level_surface
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_half_edges, faces_touching, volume_mm3, with_faces
from limbgram.findings import Finding
from limbgram.reconstruction.surface.cleaning import largest_manifold
from limbgram.reconstruction.surface.remeshing import refine
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import Limb

PALM_MM, FINGER_MM, WRIST_MM, KNUCKLES_MM, TIPS_MM = 25.0, 6.0, 0.0, 35.0, 70.0
CUT_MM = 5.0
"""Height at which the wrist is open."""
BETWEEN_MM = 15.0
"""From finger to finger: 3 mm of room, less than any two walls."""
SMALL_MM, LARGE_MM, APART_MM = 18.0, 30.0, 40.0
"""Radii of two balls, one over the other, that meet in a crease of 92 degrees."""
Inside = Callable[[np.ndarray, float], np.ndarray]
"""How far inside a body with radii larger by so much places lie."""


def capsule_mm(
    places: np.ndarray, x_mm: float, low_mm: float, high_mm: float, radius_mm: float
) -> np.ndarray:
    """How far inside an upright capsule; negative outside."""
    middle = np.stack(
        [
            np.full(places.shape[:-1], x_mm),
            np.zeros(places.shape[:-1]),
            np.clip(places[..., 2], low_mm, high_mm),
        ],
        axis=-1,
    )
    return radius_mm - np.linalg.norm(places - middle, axis=-1)


@cache
def hand() -> Mesh:
    """A palm with a round end, three fingers on it, open at the wrist."""
    step_mm = 2.0
    lowest = np.array([-30.0, -30.0, -34.0])
    places = lowest + step_mm * np.moveaxis(
        np.indices((31, 31, round((TIPS_MM + 50) / step_mm))), 0, -1
    )
    inside = capsule_mm(places, 0.0, WRIST_MM, KNUCKLES_MM, PALM_MM)
    for x_mm in (-BETWEEN_MM, 0.0, BETWEEN_MM):
        finger = capsule_mm(places, x_mm, KNUCKLES_MM, TIPS_MM, FINGER_MM)
        inside = np.maximum(inside, finger)
    whole = refine(level_surface(inside, lowest, step_mm), step_mm)
    return keep_positive(whole, whole.vertices_mm[:, 2] - CUT_MM).mesh


def snowman_mm(places: np.ndarray, more_mm: float) -> np.ndarray:
    small = capsule_mm(places, 0.0, 0.0, 0.0, SMALL_MM + more_mm)
    large = capsule_mm(places, 0.0, APART_MM, APART_MM, LARGE_MM + more_mm)
    return np.maximum(small, large)


@cache
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
    """Volume between two heights of what is no farther from a body, without the body.

    Both bodies mirror themselves in x and in y: a quarter is counted.
    """
    step_mm = 0.5
    axis = np.arange(0.0, 45.0, step_mm) + step_mm / 2
    found = 0
    for z_mm in np.arange(low_mm, high_mm, step_mm) + step_mm / 2:
        x, y = np.meshgrid(axis, axis)
        places = np.stack([x, y, np.full_like(x, z_mm)], axis=-1)
        found += int(((inside(places, thickness_mm) > 0) & (inside(places, 0.0) <= 0)).sum())
    return 4 * found * step_mm**3


def told(notes: tuple[Finding, ...], code: str) -> Finding:
    return next(one for one in notes if one.code == code)


@pytest.mark.parametrize(
    "thickness_mm",
    [pytest.param(2.0, marks=pytest.mark.slow), 4.0, pytest.param(8.0, marks=pytest.mark.slow)],
)
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
    assert told(made.notes, "edit.wall.thickness").values["thinnest_mm"] > 5.98


@pytest.mark.slow
def test_fingers_too_narrow_for_two_walls_are_solid_and_told() -> None:
    mesh, thickness_mm = hand(), 8.0
    made = do_edit(Limb(mesh=mesh), Wall(thickness_mm=thickness_mm, side="inward"))
    solid = made.mesh
    require_one_sound_solid(solid)
    given = mesh.vertices_mm[mesh.vertices_mm[:, 2] > CUT_MM + 4]
    assert KDTree(solid.vertices_mm).query(given)[0].max() == 0
    assert any(note.code == "edit.wall.solid" for note in made.notes)
    radius_mm = PALM_MM - thickness_mm
    hollow = np.pi * radius_mm**2 * (KNUCKLES_MM - CUT_MM) + 2 / 3 * np.pi * radius_mm**3
    shape = np.pi * PALM_MM**2 * (KNUCKLES_MM - CUT_MM) + 2 / 3 * np.pi * PALM_MM**3
    shape += sum(_finger_mm3(x_mm) for x_mm in (-BETWEEN_MM, 0.0, BETWEEN_MM))
    assert volume_mm3(solid) == pytest.approx(shape - hollow, rel=0.02)


def test_a_hollow_is_as_far_from_the_skin_as_the_wall_is_thick() -> None:
    mesh = hand()
    made = do_edit(Limb(mesh=mesh), Wall(thickness_mm=7.0, side="inward")).mesh
    added = (np.arange(len(made)) >= len(mesh)) & (made.vertices_mm[:, 2] > CUT_MM + 1e-6)
    skin = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    away_mm = skin.closest(made.vertices_mm[added]).distances_mm
    assert away_mm.min() > 6.9
    assert np.median(away_mm) == pytest.approx(7.0, abs=0.01)
    hollow = TriangleTree.of(made.vertices_mm, made.faces[added[made.faces].all(1)])
    assert hollow.closest(mesh.vertices_mm).distances_mm.min() > 6.9
    assert made.vertices_mm[added, 2].max() < KNUCKLES_MM + PALM_MM - 7 + 2


def _finger_mm3(x_mm: float) -> float:
    """Volume of what stands out of the palm, by thin slices across."""
    heights = np.linspace(KNUCKLES_MM, TIPS_MM + FINGER_MM, 400)
    step = 0.1
    x, y = np.meshgrid(np.arange(-7, 7, step), np.arange(-7, 7, step))
    finger = x[..., None] ** 2 + y[..., None] ** 2
    beyond = np.maximum(heights - TIPS_MM, 0.0) ** 2
    inside = finger + beyond < FINGER_MM**2
    palm = (x[..., None] + x_mm) ** 2 + y[..., None] ** 2 + (heights - KNUCKLES_MM) ** 2
    outside = palm > PALM_MM**2
    return float((inside & outside).sum() * step**2 * (heights[1] - heights[0]))


def off_right_rad(places: np.ndarray) -> np.ndarray:
    return np.abs(np.arctan2(places[:, 1], places[:, 0]))


def stump_ragged_to_its_right() -> Mesh:
    """A stump that ends in a smooth wave, of whose edge two rows are gnawed over 40 degrees."""
    whole = stump(144, 2.0)
    x, y, z = whole.vertices_mm.T
    mesh = keep_positive(whole, 60.0 + 4.0 * np.sin(2 * np.arctan2(y, x)) - z).mesh
    for _ in range(2):
        at = np.zeros(len(mesh), np.bool_)
        at[boundary_half_edges(mesh.faces)] = True
        gone = (off_right_rad(mesh.vertices_mm[mesh.faces].mean(1)) < 0.35) & faces_touching(
            at, mesh.faces
        )
        gone &= np.random.default_rng(4).random(len(mesh.faces)) < 0.7
        mesh = with_faces(mesh, largest_manifold(mesh.vertices_mm, mesh.faces[~gone]))
    return mesh


@pytest.mark.parametrize("side", ["outward", pytest.param("inward", marks=pytest.mark.slow)])
def test_a_ragged_edge_is_left_out_only_where_it_is_ragged(side: str) -> None:
    mesh = stump_ragged_to_its_right()
    made = do_edit(Limb(mesh=mesh), Wall(thickness_mm=6.0, side=side))  # pyright: ignore
    require_one_sound_solid(made.mesh)
    sound = mesh.vertices_mm[off_right_rad(mesh.vertices_mm) > 0.6]
    assert KDTree(made.mesh.vertices_mm).query(sound)[0].max() == 0
    assert told(made.notes, "edit.wall.trimmed").values["area_mm2"] < 40.0


@pytest.mark.slow
def test_an_inward_wall_of_a_ragged_hand_is_nowhere_thinner_than_asked() -> None:
    made = do_edit(Limb(mesh=ragged(hand(), 8)), Wall(thickness_mm=8.0, side="inward"))
    require_one_sound_solid(made.mesh)
    assert told(made.notes, "edit.wall.thickness").values["thinnest_mm"] > 7.98
    assert told(made.notes, "edit.wall.solid")


def test_a_wall_that_fills_a_shape_up_to_its_opening_is_refused() -> None:
    with pytest.raises(EditError) as refused:
        do_edit(Limb(mesh=hand()), Wall(thickness_mm=PALM_MM + 1, side="inward"))
    assert refused.value.finding.code == "edit.wall.no_hollow"
