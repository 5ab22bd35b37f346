"""Which photo sees which vertex, against rays cut with every triangle."""

from collections.abc import Sequence

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.visibility import (
    best_views,
    incidence_cosines,
    typical_edge_mm,
    views_apart,
)

CAMERA = Camera(width_px=300, height_px=300, fx=900.0, fy=900.0, cx=149.5, cy=149.5, k1=-0.1)


def ball(rows: int, columns: int, radius_mm: float, centre: tuple[float, float, float]) -> Mesh:
    """Open at the poles."""
    lat = np.radians(np.linspace(-60, 60, rows))[:, None]
    lon = 2 * np.pi * np.arange(columns)[None] / columns
    xyz = np.stack(
        [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat) + 0 * lon], -1
    )
    at = np.arange(rows * columns).reshape(rows, columns)
    a, b = at[:-1], np.roll(at, -1, 1)[:-1]
    c, d = at[1:], np.roll(at, -1, 1)[1:]
    faces = np.stack([np.stack([a, b, c], -1), np.stack([b, d, c], -1)], 2).reshape(-1, 3)
    vertices = radius_mm * xyz.reshape(-1, 3) + centre
    return Mesh(vertices_mm=vertices, faces=faces.astype(np.int32))


def two_balls() -> Mesh:
    """The small one hides a part of the large one."""
    large, small = ball(9, 14, 40.0, (0, 0, 0)), ball(7, 9, 12.0, (75.0, 10.0, 5.0))
    return Mesh(
        vertices_mm=np.concatenate([large.vertices_mm, small.vertices_mm]),
        faces=np.concatenate([large.faces, small.faces + np.int32(len(large))]),
    )


def meets_any(origin: np.ndarray, ray: np.ndarray, triangles: np.ndarray) -> bool:
    """Möller and Trumbore 1997."""
    first, one, two = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2]
    two = two - first
    across = np.cross(ray, two)
    determinant = (one * across).sum(1)
    determinant = np.where(np.abs(determinant) < 1e-12, np.nan, determinant)
    u = ((origin - first) * across).sum(1) / determinant
    along = np.cross(origin - first, one)
    v, far = (along @ ray) / determinant, (two * along).sum(1) / determinant
    return bool(np.any((u >= 0) & (v >= 0) & (u + v <= 1) & (far > 0)))


@pytest.mark.parametrize("steepest_deg", [60.0, 80.0])
def test_cosines_are_those_of_rays_that_meet_nothing(steepest_deg: float) -> None:
    mesh, up = two_balls(), np.array([0.0, 0.0, 1.0])
    eyes = [np.array([400.0, 30.0, 40.0]), np.array([-100.0, 350.0, 60.0]), np.array([250.0, 0, 0])]
    targets = [np.zeros(3), np.zeros(3), np.array([10.0, 25.0, 20.0])]
    views = [View("", CAMERA, Rigid.looking_at(e, t, up)) for e, t in zip(eyes, targets)]
    found = incidence_cosines(mesh, views, steepest_deg)
    normals, lift = mesh.vertex_normals(), 0.5 * typical_edge_mm(mesh)
    hidden = 0
    for k, (view, eye) in enumerate(zip(views, eyes)):
        for vertex in range(len(mesh)):
            place = mesh.vertices_mm[vertex]
            ray = (eye - place) / np.linalg.norm(eye - place)
            cosine = float(ray @ normals[vertex])
            x, y = view.project(place[None])[0]
            expected = 0.0
            if cosine > np.cos(np.radians(steepest_deg)) and 4 <= min(x, y) <= max(x, y) <= 295:
                origin = place + lift * normals[vertex]
                met = meets_any(origin, ray, mesh.vertices_mm[mesh.faces])
                expected, hidden = (0.0, hidden + 1) if met else (cosine, hidden)
            np.testing.assert_allclose(found[vertex, k], expected, atol=1e-6)
    assert hidden > 3, "the small ball hides something"
    assert (found == 0).any(0).all()
    assert (found > 0).any(0).all()
    np.testing.assert_array_equal(incidence_cosines(mesh, views, steepest_deg, step=3), found[::3])


@pytest.mark.parametrize("seed", range(3))
def test_best_views_are_the_most_frontal_ones(seed: int) -> None:
    random = np.random.default_rng(seed)
    cosines = (random.random((30, 6)) * (random.random((30, 6)) > 0.5)).astype(np.float32)
    found = best_views(cosines, 4, np.ones(6, bool))
    for row, chosen in zip(cosines.tolist(), found.tolist()):
        seeing = [k for k, cosine in enumerate(row) if cosine > 0]
        seeing = sorted(seeing, key=lambda k: -row[k])[:4]
        assert chosen == seeing + [-1] * (4 - len(seeing))


def test_of_many_photos_those_are_best_that_lie_apart() -> None:
    """72 photos, five degrees from each to the next: the most frontal six lay within 25 degrees."""
    around_deg = np.arange(0.0, 360.0, 5.0)
    apart = views_apart(_round(around_deg), np.zeros(3))
    np.testing.assert_array_equal(around_deg[apart], np.arange(0.0, 360.0, 10.0))
    cosines = np.maximum(np.cos(np.radians(around_deg - 1.0)), 0.0)[None].astype(np.float32)
    (found,) = best_views(cosines, 6, apart)
    assert around_deg[found].tolist() == [0.0, 10.0, 350.0, 20.0, 340.0, 30.0]


def test_of_photos_ten_degrees_apart_none_is_passed_over() -> None:
    assert views_apart(_round(np.arange(0.0, 360.0, 10.0)), np.zeros(3)).all()


def test_of_photos_side_by_side_the_finest_counts() -> None:
    far, near = _round([0.0, 45.0]), _round([3.0], 400.0)
    assert views_apart([*far, *near], np.zeros(3)).tolist() == [False, True, True]


def test_a_place_that_few_photos_see_is_measured_by_those_side_by_side_too() -> None:
    views = _round([0.0, 3.0, 50.0, 120.0])
    cosines = np.array([[0.9, 0.95, 0.5, 0.0], [0.9, 0.95, 0.5, 0.1]], np.float32)
    found = best_views(cosines, 3, views_apart(views, np.zeros(3)))
    assert found.tolist() == [[1, 0, 2], [0, 2, 3]]


def _round(around_deg: Sequence[float] | np.ndarray, radius_mm: float = 1000.0) -> list[View]:
    """Views at these angles from a spiral that widens a little from each to the next."""
    up = np.array([0.0, 0.0, 1.0])
    angles = np.radians(around_deg)
    radii_mm = radius_mm + 0.1 * np.arange(len(angles))
    centres = radii_mm[:, None] * np.column_stack(
        [np.cos(angles), np.sin(angles), np.zeros(len(angles))]
    )
    return [View("", CAMERA, Rigid.looking_at(centre, np.zeros(3), up)) for centre in centres]
