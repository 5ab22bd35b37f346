"""Inward walls of a hand whose fingers are too narrow for them."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.folds import find_bent
from limbgram.core.mesh.isosurface import level_surface
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    face_components,
    is_edge_manifold,
    is_vertex_manifold,
    volume_mm3,
)
from limbgram.reconstruction.surface.resampling import refine
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.hollow import Hollowing, hollowed
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import Limb

PALM_MM, FINGER_MM, WRIST_MM, KNUCKLES_MM, TIPS_MM = 25.0, 6.0, 0.0, 60.0, 105.0
CUT_MM = 5.0
"""Height at which the wrist is open."""
BETWEEN_MM = 15.0
"""From finger to finger: 3 mm of room, less than any two walls."""


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


def hand() -> Mesh:
    """A palm with a round end, three fingers on it, open at the wrist."""
    step_mm = 1.5
    lowest = np.array([-30.0, -30.0, -34.0])
    places = lowest + step_mm * np.moveaxis(np.indices((41, 41, 103)), 0, -1)
    inside = capsule_mm(places, 0.0, WRIST_MM, KNUCKLES_MM, PALM_MM)
    for x_mm in (-BETWEEN_MM, 0.0, BETWEEN_MM):
        finger = capsule_mm(places, x_mm, KNUCKLES_MM, TIPS_MM, FINGER_MM)
        inside = np.maximum(inside, finger)
    whole = refine(level_surface(inside, lowest, step_mm), step_mm)
    return keep_positive(whole, whole.vertices_mm[:, 2] - CUT_MM).mesh


def require_one_sound_solid(solid: Mesh) -> None:
    assert is_edge_manifold(solid.faces)
    assert is_vertex_manifold(solid.faces)
    assert not len(boundary_half_edges(solid.faces))
    assert int(face_components(solid.faces).max()) == 0
    every = np.ones(len(solid.faces), np.bool_)
    assert not len(find_crossings(solid.vertices_mm, solid.faces, every))
    assert not len(find_bent(solid, every))


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
    found = hollowed(Hollowing(mesh, 7.0))
    skin = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    away_mm = skin.closest(found.vertices_mm[: found.hollow]).distances_mm
    assert away_mm.min() > 6.9
    assert np.median(away_mm) == pytest.approx(7.0, abs=0.01)
    places = np.concatenate([mesh.vertices_mm, found.vertices_mm])
    hollow = TriangleTree.of(places, found.hollow_faces)
    assert hollow.closest(mesh.vertices_mm).distances_mm.min() > 6.9
    assert found.vertices_mm[: found.hollow, 2].max() < KNUCKLES_MM + PALM_MM - 7 + 2


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
