"""The renderer shows what is nearest, where it is, and not mirrored."""

import numpy as np
import pytest

from limbgram.core.mesh.mesh import Mesh
from limbgram.report.drawings.shading import FILLED, Frame, looking_along, rasterise, shade


def frame(azimuth_deg: float, elevation_deg: float = 0.0) -> Frame:
    return Frame(
        picture_from_world=looking_along(azimuth_deg, elevation_deg),
        middle_mm=np.zeros(3),
        pixel_mm=1.0,
        width_px=41,
        height_px=61,
    )


@pytest.mark.parametrize("azimuth_deg", [0.0, 37.0, 90.0, 200.0])
def test_the_picture_is_not_mirrored_and_z_is_up(azimuth_deg: float) -> None:
    rotation = looking_along(azimuth_deg)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    np.testing.assert_allclose(rotation @ [0, 0, 1], [0, -1, 0], atol=1e-12)


def test_from_plus_x_one_sees_y_to_the_right_and_x_near() -> None:
    x, y, depth = frame(0.0).project(np.array([[5.0, 3.0, 7.0]]))[0]
    assert (x, y) == pytest.approx((20 + 3, 30 - 7))
    assert depth == pytest.approx(-5)


def test_the_nearer_of_two_triangles_is_seen_whatever_their_order() -> None:
    corners = np.array([[2.0, 2, 9], [30, 2, 9], [2, 30, 9], [2, 2, 4], [30, 2, 4], [2, 30, 4]])
    for faces in ([[0, 1, 2], [3, 4, 5]], [[3, 4, 5], [0, 1, 2]]):
        face_idx, weights = rasterise(corners, np.array(faces, np.int32), 40, 40)
        near = faces.index([3, 4, 5])
        assert set(np.unique(face_idx)) == {-1, near}
        y, x = np.argwhere(face_idx >= 0)[100]
        place = weights[y, x] @ corners[faces[near]]
        np.testing.assert_allclose(place[:2], [x, y], atol=1e-9)


def test_a_sphere_covers_its_disc_and_its_filled_cap_is_orange() -> None:
    mesh = sphere(15.0)
    picture = shade(mesh, frame(30.0))
    covered = (picture[..., 3] / 255.0).sum()
    assert covered == pytest.approx(np.pi * 15**2, rel=0.01)
    top, bottom = picture[30 - 12, 20].astype(float), picture[30 + 12, 20].astype(float)
    redness = [colour[0] / colour[2] for colour in (top, bottom)]
    assert redness[0] == pytest.approx(FILLED[0] / FILLED[2], rel=0.05)
    assert redness[1] < 1.2


def sphere(radius_mm: float) -> Mesh:
    azimuth, polar = np.meshgrid(np.linspace(0, 2 * np.pi, 97), np.linspace(0, np.pi, 49))
    vertices = radius_mm * np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1
    )
    grid = np.arange(49 * 97, dtype=np.int32).reshape(49, 97)
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    points = vertices.reshape(-1, 3)
    return Mesh(vertices_mm=points, faces=faces, filled=points[:, 2] > 0.5 * radius_mm)
