"""Triangulation and the Sampson distance, against points known beforehand."""

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.geometry.triangulation import (
    nearest_matches,
    sampson_px,
    triangulate,
    triangulate_linear,
)

LENS = Camera(
    width_px=2400, height_px=1600, fx=2800.0, fy=2800.0, cx=1210.0, cy=790.0, k1=-0.1, p1=0.001
)
UP = np.array([0.0, 0.0, 1.0])
CENTRES = [np.array([900 * np.sin(a), -900 * np.cos(a), 300.0]) for a in (0.0, 0.4, 0.8, 1.1)]
VIEWS = [View(str(k), LENS, Rigid.looking_at(c, np.zeros(3), UP)) for k, c in enumerate(CENTRES)]
POINTS = np.random.default_rng(2).uniform(-80, 80, (400, 3))
VIEW_IDX = np.repeat(np.arange(4, dtype=np.int32), len(POINTS))
POINT_IDX = np.tile(np.arange(len(POINTS), dtype=np.int32), 4)
XY_PX = np.concatenate([view.project(POINTS) for view in VIEWS])


def test_exact_rays_give_the_exact_points() -> None:
    linear = triangulate_linear(VIEWS, VIEW_IDX, POINT_IDX, XY_PX, len(POINTS))
    found = triangulate(VIEWS, VIEW_IDX, POINT_IDX, XY_PX, len(POINTS))
    np.testing.assert_allclose(linear, POINTS, atol=1e-5)
    np.testing.assert_allclose(found.points_in_world, POINTS, atol=1e-9)
    assert found.rms_px.max() < 1e-9


def test_covariance_tells_the_errors() -> None:
    noise = np.random.default_rng(3).normal(scale=0.3, size=XY_PX.shape)
    found = triangulate(VIEWS, VIEW_IDX, POINT_IDX, XY_PX + noise, len(POINTS))
    error = found.points_in_world - POINTS
    squares = np.einsum("ni,nij,nj->n", error, np.linalg.inv(found.covariance), error) / 0.3**2
    assert 2.7 < squares.mean() < 3.3  # chi-squared with three degrees of freedom
    expected_rms = 0.3 * np.sqrt((8 - 3) / 4)
    assert np.sqrt(np.mean(found.rms_px**2)) == pytest.approx(expected_rms, rel=0.05)


def test_order_of_measurements_does_not_matter() -> None:
    order = np.random.default_rng(4).permutation(len(XY_PX))
    shuffled = triangulate(VIEWS, VIEW_IDX[order], POINT_IDX[order], XY_PX[order], len(POINTS))
    np.testing.assert_allclose(shuffled.points_in_world, POINTS, atol=1e-9)


def test_points_that_cannot_be_had_are_nan() -> None:
    one_ray = VIEW_IDX == 0
    alone = triangulate(VIEWS, VIEW_IDX[one_ray], POINT_IDX[one_ray], XY_PX[one_ray], len(POINTS))
    assert np.isnan(alone.points_in_world).all()
    crossed = np.where((POINT_IDX == 0)[:, None], XY_PX[::-1], XY_PX)
    mixed = triangulate(VIEWS, VIEW_IDX, POINT_IDX, crossed, len(POINTS))
    np.testing.assert_allclose(mixed.points_in_world[1:], POINTS[1:], atol=1e-9)


def pinhole_pair() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """F and exact matches, without lens distortion."""
    first, second = (LENS.matrix @ view.camera_from_world.matrix_3x4 for view in VIEWS[:2])
    homogeneous = np.hstack([POINTS, np.ones((len(POINTS), 1))])
    images = [homogeneous @ matrix.T for matrix in (first, second)]
    epipole = second @ np.append(CENTRES[0], 1.0)
    cross = np.cross(np.eye(3), epipole).T
    fundamental = cross @ second @ np.linalg.pinv(first)
    matches = [image[:, :2] / image[:, 2:] for image in images]
    return fundamental / np.linalg.norm(fundamental), matches[0], matches[1]


def test_exact_matches_have_no_sampson_distance() -> None:
    fundamental, first, second = pinhole_pair()
    assert np.abs(sampson_px(fundamental, first, second)).max() < 1e-7


def test_sampson_distance_is_the_distance_across_the_epipolar_lines() -> None:
    fundamental, first, second = pinhole_pair()
    lines = np.hstack([first, np.ones((len(first), 1))]) @ fundamental.T
    across = lines[:, :2] / np.linalg.norm(lines[:, :2], axis=1, keepdims=True)
    both = sampson_px(fundamental, first, second + 0.2 * across)
    # the nearest exact match shares the 0.2 px between the photos, nearly equally here
    np.testing.assert_allclose(np.abs(both), 0.2 / np.sqrt(2), rtol=0.1)


def test_nearest_match_is_exact_and_no_other_exact_match_is_nearer() -> None:
    fundamental, first, second = pinhole_pair()
    rng = np.random.default_rng(6)
    noisy = np.hstack([first, second]) + rng.normal(scale=2.0, size=(len(first), 4))
    nearest = nearest_matches(fundamental, noisy[:, :2], noisy[:, 2:])
    assert np.abs(sampson_px(fundamental, nearest[:, :2], nearest[:, 2:])).max() < 1e-6
    distance = np.linalg.norm(nearest - noisy, axis=1)
    assert (distance <= np.linalg.norm(np.hstack([first, second]) - noisy, axis=1)).all()
    signed = np.abs(sampson_px(fundamental, noisy[:, :2], noisy[:, 2:]))
    np.testing.assert_allclose(signed, distance, rtol=0.02, atol=1e-3)
