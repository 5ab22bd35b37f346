"""Shortest ways against unfolded bodies and great circles."""

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import MeasureError
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.measures.geodesic import length_mm, shortest_path


def as_mesh(body: trimesh.Trimesh) -> Mesh:
    return Mesh(
        vertices_mm=np.asarray(body.vertices, np.float64), faces=np.asarray(body.faces, np.int32)
    )


def on_cylinder(turn_rad: float, height_mm: float, corners: int) -> np.ndarray:
    """A place on the flat wall of a prism of radius 50 mm, by its share of the way round."""
    side, share = divmod(turn_rad / (2 * np.pi) * corners, 1)
    ends = 2 * np.pi * (side + np.array([0, 1])) / corners
    flat = 50 * np.column_stack([np.cos(ends), np.sin(ends)])
    return np.array([*(flat[0] + share * (flat[1] - flat[0])), height_mm])


@pytest.mark.parametrize(
    ("turn_rad", "low_mm", "high_mm"), [(2.0, 10, 190), (0.01, 5, 180), (3.0, 30, 31), (1.2, 9, 90)]
)
def test_a_way_over_a_prism_is_straight_when_the_wall_is_unrolled(
    cylinder: Mesh, turn_rad: float, low_mm: float, high_mm: float
) -> None:
    path = shortest_path(
        cylinder, on_cylinder(0.3, low_mm, 96), on_cylinder(0.3 + turn_rad, high_mm, 96)
    )
    round_mm = 2 * 50 * 96 * np.sin(np.pi / 96) * turn_rad / (2 * np.pi)
    assert length_mm(path) == pytest.approx(np.hypot(round_mm, high_mm - low_mm), rel=1e-6)


def test_a_way_over_a_sphere_is_a_great_circle() -> None:
    sphere = as_mesh(trimesh.creation.icosphere(5, 50.0))
    rng = np.random.default_rng(3)
    for _ in range(4):
        ends = rng.standard_normal((2, 3))
        ends /= np.linalg.norm(ends, axis=1, keepdims=True)
        path = shortest_path(sphere, 50 * ends[0], 50 * ends[1])
        true_mm = 50 * np.arccos(ends[0] @ ends[1])
        assert -3e-4 < length_mm(path) / true_mm - 1 < 0  # the triangles lie inside the sphere


def test_a_way_over_a_box_crosses_the_edge_where_the_unfolded_line_does() -> None:
    box = as_mesh(trimesh.creation.box((40, 60, 80)))
    path = shortest_path(box, np.array([20.0, 0, -30]), np.array([0.0, 30, 30]))
    assert length_mm(path) == pytest.approx(np.hypot(30 + 20, 60), rel=1e-9)


def test_the_way_lies_on_the_surface_and_begins_and_ends_as_asked(cylinder: Mesh) -> None:
    start, end = on_cylinder(0.4, 20, 96), on_cylinder(2.9, 170, 96)
    path = shortest_path(cylinder, start, end)
    between = (path[1:] + path[:-1]) / 2
    tree = TriangleTree.of(cylinder.vertices_mm, cylinder.faces)
    assert tree.closest(np.concatenate([path, between])).distances_mm.max() < 1e-9
    np.testing.assert_allclose(path[[0, -1]], [start, end], atol=1e-9)


def test_a_way_is_the_same_length_backwards(cylinder: Mesh) -> None:
    start, end = on_cylinder(0.1, 20, 96), on_cylinder(2.2, 150, 96)
    there, back = shortest_path(cylinder, start, end), shortest_path(cylinder, end, start)
    assert length_mm(there) == pytest.approx(length_mm(back), rel=1e-9)


def test_a_way_round_a_gap_goes_along_its_brim() -> None:
    """A square plate with a slit to its edge: the way bends at the slit's end."""
    x, y = (k.ravel() for k in np.meshgrid(np.arange(21), np.arange(21)))
    vertices = np.column_stack([x, y, 0 * x]).astype(float)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(20), np.arange(20)))
    corner = j * 21 + i
    faces = np.concatenate(
        [
            np.column_stack([corner, corner + 1, corner + 22]),
            np.column_stack([corner, corner + 22, corner + 21]),
        ]
    ).astype(np.int32)
    slit = ((i == 10) & (j < 15)).nonzero()[0]
    plate = Mesh(vertices_mm=vertices, faces=np.delete(faces, [*slit, *(slit + 400)], axis=0))
    path = shortest_path(plate, np.array([5.0, 5, 0]), np.array([16.0, 5, 0]))
    assert length_mm(path) == pytest.approx(2 * np.hypot(5, 10) + 1, rel=1e-9)


def test_pieces_apart_have_no_way_between() -> None:
    both = trimesh.util.concatenate(
        [
            trimesh.creation.icosphere(2, 10),
            trimesh.creation.icosphere(2, 10).apply_translation([40, 0, 0]),
        ]
    )
    with pytest.raises(MeasureError, match="separate pieces"):
        shortest_path(as_mesh(both), np.array([0.0, 0, 10]), np.array([40.0, 0, 10]))
