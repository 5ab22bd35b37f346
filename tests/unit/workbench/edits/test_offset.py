"""Offset: exact on plane, cylinder and sphere; refused where it would fold."""

import numpy as np
import pytest
import trimesh
from tests.unit.workbench.edits.conftest import stump

from limbgram.core.errors import EditError
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.edits.offset import Offsetter, offset, unit_offsets


def mesh_of(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(vertices_mm=np.array(shape.vertices), faces=np.array(shape.faces, np.int32))


def test_a_box_keeps_its_edges_and_grows_on_every_side() -> None:
    box = mesh_of(trimesh.creation.box((10, 20, 30)).subdivide())
    grown = offset(box, 1.0)
    np.testing.assert_allclose(np.ptp(grown.vertices_mm, axis=0), [12, 22, 32], atol=2e-3)


@pytest.mark.parametrize("distance_mm", [-10.0, -0.3, 0.3, 5.0])
def test_faces_of_a_sphere_move_by_the_distance(distance_mm: float) -> None:
    ball = mesh_of(trimesh.creation.icosphere(4, 50.0))
    moved = offset(ball, distance_mm)

    def depths(mesh: Mesh) -> np.ndarray:
        normals = mesh.face_normals()
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return (mesh.vertices_mm[mesh.faces[:, 0]] * normals).sum(1)

    np.testing.assert_allclose(depths(moved) - depths(ball), distance_mm, rtol=2e-4)


def test_what_is_known_of_the_vertices_stays() -> None:
    ball = mesh_of(trimesh.creation.icosphere(2, 50.0))
    known = Mesh(
        vertices_mm=ball.vertices_mm,
        faces=ball.faces,
        filled=np.arange(len(ball)) % 2 == 0,
        sigma_mm=np.arange(len(ball), dtype=np.float32),
    )
    moved = offset(known, -0.3)
    np.testing.assert_array_equal(moved.filled, known.filled)
    np.testing.assert_array_equal(moved.sigma_mm, known.sigma_mm)
    np.testing.assert_array_equal(moved.faces, known.faces)


def test_more_than_the_radius_inwards_is_refused() -> None:
    ball = mesh_of(trimesh.creation.icosphere(3, 20.0))
    with pytest.raises(EditError, match="inside out"):
        offset(ball, -21.0)


def test_two_sheets_that_would_meet_are_refused() -> None:
    outer = trimesh.creation.icosphere(3, 20.0)
    far = outer.copy()
    far.apply_translation((45, 0, 0))
    pair = mesh_of(trimesh.util.concatenate([outer, far]))
    assert len(offset(pair, 2.0)) == len(pair)
    with pytest.raises(EditError, match="pass through each other"):
        offset(pair, 3.0)


def with_scraps(ball: Mesh, hair_mm: float, noise_mm: float) -> tuple[Mesh, int]:
    """Every seventh face split at a point a hair from its side: a scrap without width."""
    rng = np.random.default_rng(0)
    at, used = ball.vertices_mm, np.zeros(len(ball), bool)
    places: list[np.ndarray] = []
    faces: list[list[int]] = []
    for number, (a, b, c) in enumerate(ball.faces.tolist()):
        if number % 7 or used[[a, b, c]].any():
            faces.append([a, b, c])
            continue
        used[[a, b, c]] = True
        middle = (at[a] + at[b]) / 2
        inwards = (at[c] - middle) / np.linalg.norm(at[c] - middle)
        new = len(at) + len(places)
        places.append(middle + hair_mm * inwards + noise_mm * rng.normal(size=3))
        faces += [[a, b, new], [b, c, new], [c, a, new]]
    vertices = np.concatenate([at, np.stack(places)])
    return Mesh(vertices_mm=vertices, faces=np.array(faces, np.int32)), len(places)


@pytest.mark.parametrize("distance_mm", [-3.0, -1.0])
@pytest.mark.parametrize("hair_mm", [0.005, 0.02])
def test_flat_scraps_are_no_reason_to_refuse(distance_mm: float, hair_mm: float) -> None:
    """They turn over where their corners move differently by micrometres."""
    split, count = with_scraps(mesh_of(trimesh.creation.icosphere(4, 50.0)), hair_mm, 1e-3)
    moved = offset(split, distance_mm)
    radii = np.linalg.norm(moved.vertices_mm, axis=1)
    assert count > 400
    np.testing.assert_allclose(radii[:-count], 50 + distance_mm, atol=0.1)
    # Their points lie on chords, as they did before.
    sunk = np.linalg.norm(split.vertices_mm, axis=1)[-count:] - 50
    np.testing.assert_allclose(radii[-count:] - (50 + distance_mm), sunk, atol=0.1)


def test_an_offset_of_a_millimetre_is_the_least_squares_of_the_faces_at_each_vertex() -> None:
    ball = mesh_of(trimesh.creation.icosphere(2, 50.0))
    mesh = ball.with_vertices(ball.vertices_mm * [1.0, 0.7, 0.5])
    weighted = mesh.face_normals()
    moves = unit_offsets(mesh)
    for vertex in range(0, len(mesh), 7):
        at = weighted[(mesh.faces == vertex).any(1)]
        root = np.sqrt(np.linalg.norm(at, axis=1))
        units = at / np.linalg.norm(at, axis=1)[:, None]
        mean = at.sum(0) / np.linalg.norm(at.sum(0))
        tie = np.sqrt(1e-3 * root @ root)  # staying on the normal, by a thousandth of the weight
        rows = np.concatenate([root[:, None] * units, tie * np.eye(3)])
        expected = np.linalg.lstsq(rows, np.concatenate([root, tie * mean]))[0]
        np.testing.assert_allclose(moves[vertex], expected, rtol=1e-9, atol=1e-12)


def test_moves_evened_out_at_one_place_change_nothing_at_another() -> None:
    """A groove that only bears 8 mm evened out; the dome, a seventh of the area, is asked for."""
    mesh = stump(144, 2.0)
    x, y, z = mesh.vertices_mm.T
    deep = 12 * np.exp(-((np.arctan2(y, x) / 0.1) ** 2)) * np.exp(-(((z - 110) / 25) ** 4))
    inward = np.column_stack([1 - deep / 40, 1 - deep / 40, np.ones(len(z))])
    offsetting = Offsetter(mesh.with_vertices(mesh.vertices_mm * inward))
    distances_mm = np.full(len(mesh), 8.0)
    plain = offsetting.by_vertex(distances_mm, None)
    beside = offsetting.by_vertex(distances_mm, z < 30)
    far = z > 60
    assert (plain.mesh.vertices_mm[far] == beside.mesh.vertices_mm[far]).all()
    alone_mm = distances_mm[:, None] * offsetting.unit_moves
    moved_mm = plain.mesh.vertices_mm - offsetting.mesh.vertices_mm
    assert np.abs(moved_mm - alone_mm)[far].max() > 1.0  # the groove was evened out
