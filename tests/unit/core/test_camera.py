"""The lens against OpenCV, and round trips."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from limbgram.core.errors import ExportError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import (
    COEFFICIENTS,
    IN_PIXELS,
    LENS_SIZE,
    OPENCV,
    PARAMETERS,
    Camera,
    View,
    project_and_differentiate,
    with_pose_step,
)

LENS = Camera(
    width_px=2400, height_px=1600, fx=2800.0, fy=2790.0, cx=1210.0, cy=790.0,
    k1=-0.12, k2=0.08, p1=0.0009, p2=-0.0007, k3=-0.03,
)  # fmt: skip
SKEWED = replace(LENS, skew=12.0)
POSE = Rigid.from_rotation_vector(np.array([0.2, -0.1, 0.3]), np.array([20.0, -10.0, 900.0]))
POINTS = np.random.default_rng(1).uniform(-220, 220, (200, 3))


def test_the_coefficients_are_what_follows_pinhole_and_skew() -> None:
    assert (*IN_PIXELS, *COEFFICIENTS) == PARAMETERS
    assert COEFFICIENTS[: len(OPENCV)] == OPENCV


def test_projection_is_opencvs() -> None:
    theirs, _ = cv2.projectPoints(
        POINTS, POSE.rotation_vector, POSE.translation, LENS.matrix, LENS.distortion[:5]
    )
    np.testing.assert_allclose(View("a", LENS, POSE).project(POINTS), theirs[:, 0], atol=1e-8)


def test_skew_moves_x_with_y_only() -> None:
    straight, skewed = LENS.project(POSE.apply(POINTS)), SKEWED.project(POSE.apply(POINTS))
    np.testing.assert_allclose(skewed[:, 1], straight[:, 1])
    yd = (straight[:, 1] - LENS.cy) / LENS.fy
    np.testing.assert_allclose(skewed[:, 0] - straight[:, 0], 12.0 * yd, atol=1e-9)


def test_normalize_undoes_projection() -> None:
    in_camera = POSE.apply(POINTS)
    ideal = SKEWED.normalize(SKEWED.project(in_camera))
    np.testing.assert_allclose(ideal, in_camera[:, :2] / in_camera[:, 2:], atol=1e-9)
    rays = SKEWED.rays(SKEWED.project(in_camera))
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0)
    np.testing.assert_allclose(np.cross(rays, in_camera), 0.0, atol=1e-5)


def test_a_reduced_camera_sees_the_same_places() -> None:
    full, half = LENS.project(POSE.apply(POINTS)), LENS.scaled(0.5).project(POSE.apply(POINTS))
    np.testing.assert_allclose(half, (full + 0.5) * 0.5 - 0.5, atol=1e-9)


def test_another_program_is_given_the_coefficients_that_it_knows_or_none() -> None:
    order = ("k3", "k2", "k1", "p2", "p1")
    assert LENS.coefficients("it", order, ExportError) == (-0.03, 0.08, -0.12, -0.0007, 0.0009)
    with pytest.raises(ExportError) as refused:
        LENS.coefficients("it", ("k1", "k2", "p1"), ExportError)
    assert refused.value.finding.code == "lens.other_model"
    assert refused.value.finding.values["names"] == ("p2", "k3")
    few = replace(LENS, k3=0.0)
    assert (
        few.coefficients("it", ("k1", "k2", "p1", "p2"), ExportError)
        == LENS.coefficients("it", OPENCV, ExportError)[:4]
    )


def test_points_behind_give_nan() -> None:
    assert np.isnan(LENS.project(np.array([[0.0, 0.0, -1.0]]))).all()
    assert not LENS.contains(np.array([[np.nan, 5.0]])).any()


def test_kernel_says_that_a_point_is_behind() -> None:
    view = View("a", LENS, Rigid.identity()).packed
    arrays = np.full(2, 7.0), np.empty((2, 3)), np.empty((2, 6)), np.empty((2, LENS_SIZE))
    assert project_and_differentiate(view, np.array([0.0, 0.0, -2.0]), *arrays) == -2.0
    assert (arrays[0] == 7.0).all()


def test_a_turn_is_a_rotation() -> None:
    moved = with_pose_step(View("a", LENS, POSE).packed, np.array([0.5, -0.2, 0.9, 1.0, 2.0, 3.0]))
    rotation = moved[:9].reshape(3, 3)
    expected = Rigid.from_rotation_vector(np.array([0.5, -0.2, 0.9]), np.zeros(3)).rotation
    np.testing.assert_allclose(rotation, expected @ POSE.rotation, atol=1e-12)
    np.testing.assert_allclose(moved[9:12] - POSE.translation, [1.0, 2.0, 3.0])
    assert np.linalg.det(rotation) == pytest.approx(1.0)
