"""Folds: found where they were planted and nowhere else, and laid back to where they came from."""

import numpy as np
import pytest
import trimesh

from limbgram.core.mesh.folds import (
    ANY_SHAPE,
    find_branching,
    find_folds,
    unfolded,
)
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import is_edge_manifold, is_vertex_manifold, volume_mm3

SIDE = 15
MIDDLE = SIDE * (SIDE // 2) + SIDE // 2
"""The vertex in the middle of a sheet."""


def _sheet() -> Mesh:
    """A flat sheet of equilateral triangles with edges of 1 mm."""
    row, column = np.divmod(np.arange(SIDE**2), SIDE)
    places = np.column_stack([column + row / 2, row * np.sqrt(3) / 2, np.zeros(SIDE**2)])
    first = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
    lower = np.column_stack([first, first + 1, first + SIDE])
    upper = np.column_stack([first + 1, first + SIDE + 1, first + SIDE])
    return Mesh(vertices_mm=places, faces=np.concatenate([lower, upper]).astype(np.int32))


def _moved(mesh: Mesh, vertex: int, by_mm: tuple[float, float, float]) -> Mesh:
    vertices = mesh.vertices_mm.copy()
    vertices[vertex] += by_mm
    return mesh.with_vertices(vertices)


def _ball(edge_mm: float = 1.0) -> Mesh:
    """A ball of 30 mm in which every vertex was measured to 0.02 mm."""
    shape = trimesh.creation.icosphere(subdivisions=5, radius=30.0 * edge_mm)
    return Mesh(
        vertices_mm=np.asarray(shape.vertices),
        faces=np.asarray(shape.faces, np.int32),
        filled=np.zeros(len(shape.vertices), np.bool_),
        sigma_mm=np.full(len(shape.vertices), 0.02, np.float32),
    )


def test_turned_faces_are_those_whose_area_in_the_sheet_is_negative() -> None:
    sheet = _sheet()
    random = np.random.default_rng(5)
    for _ in range(20):
        way = random.uniform(0, 2 * np.pi)
        folded = _moved(sheet, MIDDLE, (1.4 * np.cos(way), 1.4 * np.sin(way), 0.0))
        found = find_folds(folded)
        negative = np.flatnonzero(folded.face_normals()[:, 2] < 0)
        assert 1 <= len(negative) <= 3
        np.testing.assert_array_equal(found.flipped, negative)
        assert found.vertices(folded)[MIDDLE]
        assert found.vertices(folded).sum() <= 9


def test_a_fold_in_a_sheet_goes_back_to_where_its_vertices_were() -> None:
    """Each vertex of this sheet is the mean of its neighbours, so that is the only answer."""
    sheet = _sheet()
    back = unfolded(_moved(sheet, MIDDLE, (1.3, 0.4, 0.5)))
    assert not len(back.left)
    np.testing.assert_allclose(back.mesh.vertices_mm, sheet.vertices_mm, atol=1e-9)
    assert back.mesh.filled is not None
    assert back.mesh.filled[MIDDLE]
    assert back.vertices == back.mesh.filled.sum() <= 9
    assert back.farthest_mm == pytest.approx(np.sqrt(1.3**2 + 0.4**2 + 0.5**2))


def test_a_cone_is_a_point_from_half_an_angle_of_about_31_degrees() -> None:
    """Six faces of 30 degrees: their slant is 1 / (2 sin 15 degrees), their height 1.653."""
    sheet = _sheet()
    assert not len(find_folds(_moved(sheet, MIDDLE, (0, 0, 1.64)), ANY_SHAPE))
    pointed = _moved(sheet, MIDDLE, (0, 0, 1.67))
    np.testing.assert_array_equal(find_folds(pointed, ANY_SHAPE).spikes, [MIDDLE])
    back = unfolded(pointed, ANY_SHAPE)
    np.testing.assert_allclose(back.mesh.vertices_mm, sheet.vertices_mm, atol=1e-9)
    assert back.vertices == 1


@pytest.mark.parametrize("rows", [1, 12])
def test_the_tip_of_a_cone_may_be_sharp_and_a_thorn_on_it_may_not(rows: int) -> None:
    """Round the foot of a tip of half an angle of 14 degrees the cosine is 0.24 on average."""
    outline = np.column_stack([np.linspace(30, 0, rows + 1), np.linspace(0, 120, rows + 1)])
    cone = trimesh.creation.revolve(np.vstack([[0, 0], outline]), sections=32)
    mesh = Mesh(vertices_mm=np.asarray(cone.vertices), faces=np.asarray(cone.faces, np.int32))
    assert unfolded(mesh, ANY_SHAPE).mesh is mesh
    assert len(find_folds(mesh).spikes) == 1  # as no measured limb is
    if rows == 1:
        return
    side = int(np.abs(mesh.vertices_mm - [15, 0, 60]).sum(1).argmin())
    thorny = _moved(mesh, side, (30.0, 0.0, 8.0))
    np.testing.assert_array_equal(find_folds(thorny, ANY_SHAPE).spikes, [side])


def test_a_crumpled_ball_is_whole_again_and_says_where_it_was_not_measured() -> None:
    ball = _ball()
    random = np.random.default_rng(11)
    vertices = ball.vertices_mm.copy()
    for middle in random.choice(len(ball), 25, replace=False):
        near = np.linalg.norm(ball.vertices_mm - ball.vertices_mm[middle], axis=1) < 3.0
        vertices[near] += random.normal(scale=1.5, size=(int(near.sum()), 3))
    crumpled = ball.with_vertices(vertices)
    assert len(find_folds(crumpled)) > 300
    assert len(find_folds(crumpled).crossing) > 100
    back = unfolded(crumpled)
    assert not len(back.left)
    assert not len(find_folds(back.mesh))
    assert is_edge_manifold(back.mesh.faces)
    assert back.mesh.filled is not None
    assert back.mesh.sigma_mm is not None
    moved = (back.mesh.vertices_mm != vertices).any(1)
    np.testing.assert_array_equal(moved, back.mesh.filled)
    np.testing.assert_array_equal(np.isnan(back.mesh.sigma_mm), back.mesh.filled)
    assert back.vertices == moved.sum() < 0.2 * len(ball)
    again = unfolded(crumpled)
    assert again.mesh.vertices_mm.tobytes() == back.mesh.vertices_mm.tobytes()


def test_a_whole_surface_is_the_same_one() -> None:
    ball = _ball()
    assert unfolded(ball).mesh is ball


def test_an_ear_that_is_turned_over_is_taken_away() -> None:
    sheet = _sheet()
    ear = np.array([[SIDE // 2, len(sheet), SIDE // 2 + 1]], np.int32)
    apex = np.array([[SIDE // 2 + 0.5, 0.9, 0.01]])  # over the sheet, not beside it
    eared = Mesh(
        vertices_mm=np.concatenate([sheet.vertices_mm, apex]),
        faces=np.concatenate([sheet.faces, ear]),
    )
    assert is_edge_manifold(eared.faces)
    assert len(find_folds(eared).bent) == 1
    back = unfolded(eared)
    assert not len(back.left)
    assert len(back.mesh) == len(sheet)
    np.testing.assert_allclose(back.mesh.vertices_mm, sheet.vertices_mm, atol=0.02)


@pytest.mark.parametrize("angle_deg", [20.0, 55.0, 65.0, 90.0])
def test_a_sharp_edge_is_bent_and_nothing_else(angle_deg: float) -> None:
    """The normals of a wedge differ by 180 degrees less its angle: over 120 below 60."""
    sheet = _sheet()
    vertices = sheet.vertices_mm.copy()
    beyond = vertices[:, 1] > vertices[MIDDLE, 1]
    turn = np.radians(180 - angle_deg)
    away = vertices[beyond, 1] - vertices[MIDDLE, 1]
    vertices[beyond, 1] = vertices[MIDDLE, 1] + np.cos(turn) * away
    vertices[beyond, 2] = np.sin(turn) * away
    found = find_folds(sheet.with_vertices(vertices))
    assert len(found.bent) == (SIDE - 1 if angle_deg < 60 else 0)
    assert len(found) == len(found.bent)
    assert not len(find_folds(sheet.with_vertices(vertices), ANY_SHAPE))


def test_bodies_through_each_other_are_left_and_said_where() -> None:
    """Nothing of a box of eight vertices stays in its place, so nothing can go back."""
    upright, lying = trimesh.creation.box((10, 10, 90)), trimesh.creation.box((90, 9, 9))
    both = Mesh(
        vertices_mm=np.concatenate([upright.vertices, lying.vertices]),
        faces=np.concatenate([upright.faces, lying.faces + 8]).astype(np.int32),
    )
    back = unfolded(both, ANY_SHAPE)
    assert len(back.left.crossing) > 0
    np.testing.assert_array_equal(back.mesh.vertices_mm, both.vertices_mm)
    assert np.isin(back.left.first_mm(back.mesh), (-45, -5, -4.5, 4.5, 5, 45)).all()


def test_branching_faces_are_found_at_edges_and_at_vertices() -> None:
    sheet = _sheet()
    assert not len(find_branching(sheet.faces))
    book = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]], np.int32)
    np.testing.assert_array_equal(find_branching(book), [0, 1, 2])
    bow_tie = np.array([[0, 1, 2], [0, 3, 4], [3, 5, 4]], np.int32)
    assert is_edge_manifold(bow_tie)
    assert not is_vertex_manifold(bow_tie)
    np.testing.assert_array_equal(find_branching(bow_tie), [0, 1])


def _fanned(radii_mm: tuple[float, float], rows: int, spokes: int) -> Mesh:
    """A closed frustum of fine triangles, each flat end a fan from its middle."""
    angle = np.arange(spokes) * 2 * np.pi / spokes
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    radius = np.linspace(*radii_mm, rows)
    walls = (radius[:, None, None] * ring).reshape(-1, 2)
    height = np.repeat(np.linspace(0.0, 150.0, rows), spokes)
    a = np.arange((rows - 1) * spokes).reshape(rows - 1, spokes)
    b = np.roll(a, -1, axis=1)
    wall = np.stack([a, b, b + spokes, a, b + spokes, a + spokes], -1).reshape(-1, 3)
    below, above, count = a[0], a[-1] + spokes, rows * spokes
    low = np.column_stack([np.roll(below, -1), below, np.full(spokes, count)])
    high = np.column_stack([above, np.roll(above, -1), np.full(spokes, count + 1)])
    points = np.vstack([np.column_stack([walls, height]), [[0, 0, 0], [0, 0, 150.0]]])
    return Mesh(vertices_mm=points, faces=np.vstack([wall, low, high]).astype(np.int32))


@pytest.mark.parametrize("radii_mm", [(45.0, 45.0), (45.0, 50.0), (45.0, 60.0), (60.0, 45.0)])
def test_a_flat_end_of_large_triangles_turns_no_fine_ones(radii_mm: tuple[float, float]) -> None:
    """The long triangles of a fan have many times the area of those beside them."""
    mesh = _fanned(radii_mm, 140, 75)
    assert len(find_folds(mesh, ANY_SHAPE)) == 0
    assert unfolded(mesh, ANY_SHAPE).vertices == 0


def test_a_plate_with_a_fine_top_and_a_bottom_of_two_triangles_has_no_fold() -> None:
    x, y = np.meshgrid(np.linspace(0, 100.0, 21), np.linspace(0, 100.0, 21))
    top = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 30.0)])
    a = (np.arange(20)[:, None] * 21 + np.arange(20)).ravel()
    faces = [np.column_stack([a, a + 1, a + 22]), np.column_stack([a, a + 22, a + 21])]
    corners = np.array([[0, 0, 0], [100.0, 0, 0], [100.0, 100.0, 0], [0, 100.0, 0]])
    low = 441 + np.arange(4)
    rim = [np.arange(20), 20 + 21 * np.arange(20), 440 - np.arange(20), 420 - 21 * np.arange(20)]
    ends = [np.append(one, [20, 440, 420, 0][k]) for k, one in enumerate(rim)]
    for k, way in enumerate(ends):
        foot, other = low[k], low[(k + 1) % 4]
        faces.append(np.column_stack([way[1:], way[:-1], np.full(20, foot)]))
        faces.append(np.array([[way[-1], foot, other]]))
    faces.append(np.array([[441, 443, 442], [441, 444, 443]]))
    mesh = Mesh(vertices_mm=np.vstack([top, corners]), faces=np.vstack(faces).astype(np.int32))
    assert volume_mm3(mesh) == pytest.approx(300_000.0)
    assert len(find_folds(mesh, ANY_SHAPE)) == 0
