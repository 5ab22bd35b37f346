"""Brims made even: a notch of known shape is closed as marked fill, and nothing else changes."""

import numpy as np
import pytest

from limbgram.core.mesh.folds import find_folds
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_loops, is_edge_manifold, is_vertex_manifold
from limbgram.reconstruction.surface.brim import BrimOptions, level_brim

RADIUS_MM, HEIGHT_MM, STEP_MM = 40.0, 70.0, 1.5
NOTCH_DEG, NOTCH_MM = 35.0, 14.0


def _beaker(notch_mm: float, notch_deg: float = NOTCH_DEG) -> Mesh:
    """A tube round z, closed at its top, with a notch cut into its open lower end."""
    around = int(2 * np.pi * RADIUS_MM / STEP_MM)
    rows = int(HEIGHT_MM / STEP_MM)
    angle, level = np.meshgrid(2 * np.pi * np.arange(around) / around, np.arange(rows) * STEP_MM)
    wall = np.stack([RADIUS_MM * np.cos(angle), RADIUS_MM * np.sin(angle), level], -1)
    first = np.arange(around * (rows - 1)).reshape(rows - 1, around)
    right = np.roll(first, -1, axis=1)
    quads = np.stack([first, right, right + around, first + around], -1).reshape(-1, 4)
    top = around * (rows - 1) + np.arange(around)
    lid = np.stack([top, np.roll(top, -1), np.full(around, around * rows)], 1)
    vertices = np.concatenate([wall.reshape(-1, 3), [[0, 0, HEIGHT_MM]]])
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]], lid])
    middle = vertices[faces].mean(1)
    turned = np.degrees(np.abs(np.arctan2(middle[:, 1], middle[:, 0])))
    faces = faces[~((turned < notch_deg) & (middle[:, 2] < notch_mm))]
    used, compact = np.unique(faces, return_inverse=True)
    filled = np.zeros(len(used), np.bool_)
    return Mesh(
        vertices_mm=vertices[used], faces=compact.reshape(-1, 3).astype(np.int32), filled=filled
    )


def test_a_notch_is_closed_along_the_wall_and_marked() -> None:
    ragged = _beaker(NOTCH_MM)
    even = level_brim(ragged)
    assert is_edge_manifold(even.faces)
    assert is_vertex_manifold(even.faces)
    (brim,) = boundary_loops(even.faces)
    assert even.filled is not None
    new = even.vertices_mm[even.filled]
    radius_mm = np.hypot(new[:, 0], new[:, 1])
    assert np.abs(radius_mm - RADIUS_MM).max() < 0.25 * NOTCH_MM
    assert new[:, 2].min() < 0.25 * NOTCH_MM
    assert even.vertices_mm[brim, 2].max() < 0.35 * NOTCH_MM
    assert np.degrees(np.abs(np.arctan2(new[:, 1], new[:, 0]))).max() < NOTCH_DEG + 2
    assert not len(find_folds(even))
    kept = {tuple(place) for place in even.vertices_mm[~even.filled].tolist()}
    gone = np.array([place for place in ragged.vertices_mm.tolist() if tuple(place) not in kept])
    assert len(kept) + len(gone) == len(ragged)
    # The fill folds where the notch's two ends meet the brim, and only there goes back with it.
    assert len(gone) <= 12
    ends_deg = np.degrees(np.abs(np.arctan2(gone[:, 1], gone[:, 0])))
    np.testing.assert_allclose(ends_deg, NOTCH_DEG, atol=3)
    assert gone[:, 2].max() <= 2 * STEP_MM


def test_a_crinkled_rim_is_closed_without_folds() -> None:
    """The rim of a notch is what the photos showed least of: its vertices lie anyhow."""
    ragged = _beaker(NOTCH_MM)
    random = np.random.default_rng(3)
    (rim,) = boundary_loops(ragged.faces)
    vertices = ragged.vertices_mm.copy()
    vertices[rim] += random.normal(scale=0.5 * STEP_MM, size=(len(rim), 3))
    crinkled = ragged.with_vertices(vertices)
    even = level_brim(crinkled)
    assert len(even) > len(crinkled)
    assert not len(find_folds(even))
    assert is_edge_manifold(even.faces)
    assert is_vertex_manifold(even.faces)
    assert even.filled is not None
    new = even.vertices_mm[even.filled]
    assert np.abs(np.hypot(new[:, 0], new[:, 1]) - RADIUS_MM).max() < 0.35 * NOTCH_MM


def test_a_side_that_ends_higher_adds_nothing_below_the_other() -> None:
    """As under a chin: over 144 degrees the wall begins 24 mm higher, and the level is tilted."""
    chin = _beaker(24.0, notch_deg=72.0)
    even = level_brim(chin, BrimOptions(most_share=1.0))
    assert even.filled is not None
    assert even.filled.any()
    assert even.vertices_mm[:, 2].min() > -1.5 * STEP_MM


def test_an_even_brim_stays() -> None:
    even = _beaker(0.0)
    assert level_brim(even) is even


def test_too_large_a_guess_is_not_made() -> None:
    ragged = _beaker(NOTCH_MM)
    assert level_brim(ragged, BrimOptions(most_share=0.01)) is ragged


def test_a_closed_surface_stays(closed_cube: Mesh) -> None:
    assert level_brim(closed_cube) is closed_cube


@pytest.fixture
def closed_cube() -> Mesh:
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)
    return Mesh(vertices_mm=corners, faces=faces)


def _sandal(neck_mm: float, lean: float) -> Mesh:
    """Two soles joined at a waist, whose sides lean towards each other below two arches.

    neck_mm: half of the waist's width at the floor; it grows by `lean` for each mm above it.
    """
    around, rows, arch_mm = 190, int(60 / STEP_MM), 18.0
    angle, level = np.meshgrid(2 * np.pi * np.arange(around) / around, np.arange(rows) * STEP_MM)
    waist = neck_mm + lean * np.minimum(level, 24)
    across = waist + (24 - waist) * np.minimum(1, 1.6 * np.abs(np.cos(angle)))
    wall = np.stack([45 * np.cos(angle), np.sin(angle) * across, level], -1)
    first = np.arange(around * (rows - 1)).reshape(rows - 1, around)
    right = np.roll(first, -1, axis=1)
    quads = np.stack([first, right, right + around, first + around], -1).reshape(-1, 4)
    top = around * (rows - 1) + np.arange(around)
    lid = np.stack([top, np.roll(top, -1), np.full(around, around * rows)], 1)
    vertices = np.concatenate([wall.reshape(-1, 3), [[0, 0, 60]]])
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]], lid])
    middle = vertices[faces].mean(1)
    under = middle[:, 2] < arch_mm * (1 - (middle[:, 0] / 18) ** 2)
    faces = faces[~((np.abs(middle[:, 0]) < 18) & under)]
    used, compact = np.unique(faces, return_inverse=True)
    return Mesh(
        vertices_mm=vertices[used],
        faces=compact.reshape(-1, 3).astype(np.int32),
        filled=np.zeros(len(used), np.bool_),
    )


@pytest.mark.parametrize(
    ("neck_mm", "lean"),
    [
        (1.0, 0.3),
        (8.0, 0.8),
        pytest.param(2.0, 0.5, marks=pytest.mark.slow),
        pytest.param(3.2, 0.8, marks=pytest.mark.slow),
    ],
)
def test_no_sole_is_closed_where_the_walls_of_an_arch_meet(neck_mm: float, lean: float) -> None:
    ragged = _sandal(neck_mm, lean)
    even = level_brim(ragged)
    assert even is not ragged
    assert is_vertex_manifold(even.faces)
    assert len(boundary_loops(even.faces)) == 1
    assert even.filled is not None
    new = even.vertices_mm[even.filled]
    assert np.abs(new[:, 0]).max() < 26  # the soles' middles lie at 32
    assert new[:, 2].min() > -3


def test_what_is_closed_does_not_hang_on_a_thousandth_of_a_millimetre() -> None:
    """Without a passage between the soles: 0, 0, 1125, 0, 1124, 0 mm2."""
    sandal = _sandal(4.0, 0.8)
    areas: list[float] = []
    for seed in range(6):
        noise = np.random.default_rng(seed).normal(0, 1e-3, sandal.vertices_mm.shape)
        even = level_brim(sandal.with_vertices(sandal.vertices_mm + noise))
        assert even.filled is not None
        sides = np.linalg.norm(even.face_normals(), axis=1) / 2
        areas.append(float(sides[even.filled[even.faces].any(1)].sum()))
    assert min(areas) > 800
    assert np.ptp(areas) < 0.2 * max(areas)


def test_a_flat_sheet_and_a_slit_have_no_notch() -> None:
    """A sheet lies in the plane of its own brim, and a slit has no plane: both pass as they are."""
    at = np.arange(12 * 12).reshape(12, 12)
    quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], -1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)
    rows, columns = np.divmod(np.arange(12.0 * 12), 12)
    sheet = Mesh(vertices_mm=np.column_stack([rows, columns, np.zeros(12 * 12)]), faces=faces)
    assert level_brim(sheet) is sheet
    tips = 20.0 * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    sides = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 6, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [6, 3, 5]]
    slit = Mesh(vertices_mm=np.vstack([tips, tips[0]]), faces=np.array(sides, np.int32))
    assert level_brim(slit) is slit
