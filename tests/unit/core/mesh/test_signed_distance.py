"""Signed distance: every door of the program tells the same side, beyond sharp edges too."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from jaxtyping import Float64
from scipy.spatial import ConvexHull

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.signed_distance import SignedSurface
from limbgram.core.mesh.topology import find_edges
from limbgram.report.alignment import Truth
from limbgram.report.alignment import signed_mm as from_truth
from limbgram.workbench.compare.counterparts import CounterpartSurface
from limbgram.workbench.edits.pressing import signed_offsets

Asked = Callable[[Mesh, Points3], Float64[np.ndarray, " n"]]


def by_truth(mesh: Mesh, points_mm: Points3) -> Float64[np.ndarray, " n"]:
    seen = np.ones(len(mesh), np.bool_)
    truth = Truth(
        vertices_mm=mesh.vertices_mm, faces=mesh.faces, seen=seen, centres_mm=np.empty((0, 3))
    )
    return from_truth(points_mm, truth)[0]


DOORS: dict[str, Asked] = {
    "core": lambda mesh, points: (
        SignedSurface(mesh.vertices_mm, mesh.faces).query(points).signed_mm
    ),
    "pressing": lambda mesh, points: signed_offsets(mesh, points).signed_mm,
    "counterparts": lambda mesh, points: (
        CounterpartSurface.of(mesh, 0.0).counterparts(points).signed_mm
    ),
    "truth": by_truth,
}


def hull(points_mm: Points3) -> Mesh:
    """A convex body, its faces counter-clockwise from outside."""
    found = ConvexHull(points_mm)
    a, b, c = (points_mm[found.simplices[:, k]] for k in range(3))
    inward = np.einsum("fc,fc->f", np.cross(b - a, c - a), found.equations[:, :3]) < 0
    faces = np.where(inward[:, None], found.simplices[:, ::-1], found.simplices)
    return Mesh(vertices_mm=points_mm, faces=faces.astype(np.int32))


def wedge(opening_deg: float) -> Mesh:
    """A long blade with its edge along X, askew in space."""
    half = np.radians(opening_deg / 2)
    section = 40.0 * np.array([[0, 0], [np.cos(half), np.sin(half)], [np.cos(half), -np.sin(half)]])
    ends = [np.column_stack([np.full(3, x), section]) for x in (-50.0, 50.0)]
    askew = Rigid.from_rotation_vector(np.array([0.4, 1.1, -0.7]), np.array([5.0, -3, 300]))
    return hull(askew.apply(np.concatenate(ends)))


def outside_of(mesh: Mesh, points_mm: Points3) -> np.ndarray:
    """Of a convex body: beyond a face's plane."""
    normals = mesh.face_normals()
    beyond = points_mm @ normals.T - np.einsum(
        "fc,fc->f", normals, mesh.vertices_mm[mesh.faces[:, 0]]
    )
    return beyond.max(1) > 0


def round_features(mesh: Mesh, away_mm: float, count: int) -> Points3:
    """Places so far from places on edges, and from corners, in all directions."""
    rng = np.random.default_rng(5)
    sides = mesh.vertices_mm[mesh.faces[rng.integers(0, len(mesh.faces), count)]]
    share = rng.choice([0.0, 0.3, 0.5, 1.0], (count, 1))
    ways = rng.normal(size=(count, 3))
    ways *= away_mm / np.linalg.norm(ways, axis=1, keepdims=True)
    return (1 - share) * sides[:, 0] + share * sides[:, 1] + ways


@pytest.mark.parametrize("ask", DOORS.values(), ids=DOORS.keys())
@pytest.mark.parametrize("opening_deg", [10.0, 30.0, 90.0])
def test_no_sign_is_wrong_beyond_an_edge(ask: Asked, opening_deg: float) -> None:
    body = wedge(opening_deg)
    places = round_features(body, 3.0, 4000)
    outside = outside_of(body, places)
    assert 0.3 < outside.mean() < 1
    signed = ask(body, places)
    np.testing.assert_array_equal(signed > 0, outside)
    assert np.abs(signed).max() <= 3.0 + 1e-9
    hollow = Mesh(vertices_mm=body.vertices_mm, faces=body.faces[:, ::-1].copy())
    np.testing.assert_array_equal(ask(hollow, places) > 0, ~outside)


def slivered(body: Mesh, shares: tuple[float, ...]) -> Mesh:
    """The blade with vertices on its edge that one of its sides alone is joined to.

    Faces without area lie between the sides: a fan from the edge's far end.
    """
    start, end = 0, 3
    faces = body.faces.tolist()
    halves = [
        (f, k)
        for f, face in enumerate(faces)
        for k in range(3)
        if {face[k], face[(k + 1) % 3]} == {start, end}
    ]
    f, k = halves[0]
    one, two, apex = (faces[f][(k + j) % 3] for j in range(3))
    ends = body.vertices_mm[[one, two]]
    ways = [one, *(len(body.vertices_mm) + np.arange(len(shares))).tolist(), two]
    between = [ends[0] + share * (ends[1] - ends[0]) for share in shares]
    del faces[f]
    faces += [[a, b, apex] for a, b in pairwise(ways)]
    faces += [[b, a, two] for a, b in pairwise(ways[:-1])]
    return Mesh(
        vertices_mm=np.concatenate([body.vertices_mm, between]), faces=np.array(faces, np.int32)
    )


@pytest.mark.parametrize("ask", DOORS.values(), ids=DOORS.keys())
@pytest.mark.parametrize("shares", [(0.5,), (0.2, 0.3, 0.8)])
def test_no_sign_is_wrong_beyond_faces_without_area(ask: Asked, shares: tuple[float, ...]) -> None:
    plain = wedge(30.0)
    body = slivered(plain, shares)
    assert (find_edges(body.faces).uses == 2).all()
    places = round_features(plain, 3.0, 4000)
    edge = plain.vertices_mm[[0, 3]]
    rng = np.random.default_rng(2)
    along = edge[0] + rng.choice([*shares, 0.1, 0.6], (4000, 1)) * (edge[1] - edge[0])
    ways = rng.normal(size=(4000, 3))
    places = np.concatenate([places, along + 3 * ways / np.linalg.norm(ways, axis=1)[:, None]])
    np.testing.assert_array_equal(ask(body, places) > 0, outside_of(plain, places))


@pytest.mark.parametrize("ask", DOORS.values(), ids=DOORS.keys())
def test_a_body_of_needles_tells_its_sides(ask: Asked) -> None:
    """A pointed hull with corners where many faces meet at small angles."""
    rng = np.random.default_rng(8)
    body = hull(rng.normal(size=(60, 3)) * [100.0, 4, 1] + 1000)
    places = round_features(body, 0.5, 4000)
    np.testing.assert_array_equal(ask(body, places) > 0, outside_of(body, places))


def test_the_way_to_an_edge_is_along_its_normal() -> None:
    """What stands straight off a sharp edge stands on the surface, and is not beyond its rim."""
    body = wedge(30.0)
    edge = (body.vertices_mm[0] + body.vertices_mm[3]) / 2
    off = edge - body.vertices_mm.mean(0)
    found = signed_offsets(body, (edge + 3 * off / np.linalg.norm(off))[None])
    np.testing.assert_allclose(found.signed_mm, 3.0, atol=1e-9)
    np.testing.assert_allclose(found.along, 1.0, atol=1e-9)
