"""Motions: round trips, composition and fits, against motions known beforehand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from limbgram.core.geometry.frames import (
    Rigid,
    Similarity,
    angle_between_deg,
    fit_similarity,
    rotated,
    turn_rad,
)

POINTS = np.random.default_rng(5).normal(size=(50, 3)) * 100.0
UP = np.array([0.0, 0.0, 1.0])
number = st.floats(-3.0, 3.0)
vector = st.tuples(number, number, number).map(np.array)


@given(turn=vector, shift=vector)
def test_inverse_undoes_a_motion(turn: np.ndarray, shift: np.ndarray) -> None:
    b_from_a = Rigid.from_rotation_vector(turn, shift)
    np.testing.assert_allclose(b_from_a.inverse.apply(b_from_a.apply(POINTS)), POINTS, atol=1e-10)
    np.testing.assert_allclose(b_from_a.apply(b_from_a.centre[None]), 0.0, atol=1e-10)


@given(first=vector, second=vector)
def test_composition_applies_the_right_factor_first(first: np.ndarray, second: np.ndarray) -> None:
    b_from_a = Rigid.from_rotation_vector(first, second)
    c_from_b = Rigid.from_rotation_vector(second, first)
    both = (c_from_b @ b_from_a).apply(POINTS)
    np.testing.assert_allclose(both, c_from_b.apply(b_from_a.apply(POINTS)), atol=1e-9)


def test_looking_at_puts_the_target_on_the_axis_and_up_upwards() -> None:
    centre, target = np.array([500.0, -200.0, 300.0]), np.array([1.0, 2.0, 150.0])
    pose = Rigid.looking_at(centre, target, UP)
    in_camera = pose.apply(np.stack([target, target + 10.0 * UP]))
    distance = np.linalg.norm(target - centre)
    np.testing.assert_allclose(in_camera[0], [0.0, 0.0, distance], atol=1e-9)
    assert in_camera[1, 1] < -9.0  # y points down in a photo
    assert np.linalg.det(pose.rotation) == pytest.approx(1.0)


def test_many_vectors_turn_each_by_itself_and_in_order() -> None:
    quarter = Rigid.from_rotation_vector(np.array([0, 0, np.pi / 2]), np.zeros(3)).rotation
    count = 50_001
    vectors = np.column_stack([np.arange(count), np.zeros(count), -np.arange(count)])
    expected = vectors[:, [1, 0, 2]]
    np.testing.assert_allclose(rotated(vectors, quarter), expected, atol=1e-9)
    np.testing.assert_array_equal(rotated(vectors, quarter)[-3:], rotated(vectors[-3:], quarter))


def test_angle_between_known_turns() -> None:
    first = Rigid.from_rotation_vector(np.array([0.0, 0.0, np.radians(10.0)]), np.zeros(3))
    second = Rigid.from_rotation_vector(np.array([0.0, 0.0, np.radians(37.0)]), np.zeros(3))
    assert angle_between_deg(first.rotation, second.rotation) == pytest.approx(27.0)


@given(scale=st.floats(0.01, 1000.0), turn=vector, shift=vector)
def test_fit_finds_the_similarity(scale: float, turn: np.ndarray, shift: np.ndarray) -> None:
    truth = Similarity(scale, Rigid.from_rotation_vector(turn, shift).rotation, shift)
    found = fit_similarity(POINTS, truth.apply(POINTS))
    assert found.scale == pytest.approx(scale, rel=1e-9)
    np.testing.assert_allclose(found.rotation, truth.rotation, atol=1e-8)
    np.testing.assert_allclose(truth.inverse.apply(truth.apply(POINTS)), POINTS, atol=1e-6)


def test_fit_never_mirrors() -> None:
    mirrored = POINTS * [1.0, 1.0, -1.0]
    assert np.linalg.det(fit_similarity(POINTS, mirrored).rotation) == pytest.approx(1.0)


def test_a_moved_camera_sees_the_moved_points_in_the_same_place() -> None:
    b_from_a = Similarity(
        3.0, Rigid.from_rotation_vector(np.ones(3), np.zeros(3)).rotation, np.ones(3)
    )
    camera_from_a = Rigid.from_rotation_vector(
        np.array([0.1, -0.4, 0.2]), np.array([5.0, 6.0, 900.0])
    )
    in_a = camera_from_a.apply(POINTS)
    in_b = b_from_a.move_camera(camera_from_a).apply(b_from_a.apply(POINTS))
    np.testing.assert_allclose(in_b, 3.0 * in_a, atol=1e-9)


@pytest.mark.parametrize(
    ("one_deg", "other_deg", "turn_deg"), [(350, 10, -20), (10, 350, 20), (95, 5, 90), (725, 0, 5)]
)
def test_the_smallest_turn_goes_past_zero(
    one_deg: float, other_deg: float, turn_deg: float
) -> None:
    turn = turn_rad(np.radians([one_deg]), np.radians(other_deg))
    np.testing.assert_allclose(np.degrees(turn), [turn_deg], atol=1e-9)
