"""The reduced normal equations against dense ones, whose derivatives are differences."""

import numpy as np
import pytest

from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, View
from limbgram.reconstruction.mapping.body import BodyEquations
from limbgram.reconstruction.mapping.bundle import Bundle
from limbgram.reconstruction.mapping.bundle_adjustment import reduced_equations
from limbgram.reconstruction.mapping.bundle_equations import (
    BEHIND_COST,
    point_steps,
    reduce_equations,
    robust_cost,
)
from limbgram.reconstruction.mapping.scene import Scene

CAUCHY_PX = 1.3
NONE_OF_THEIR_OWN = np.zeros((2, LENS_SIZE, 0))
"""Numbers that photos have of their own, by lens of the made-up scene."""


def moved(bundle: Bundle, step: np.ndarray) -> Bundle:
    points = step[bundle.unknowns :].reshape(-1, 3)
    return bundle.moved(step[: bundle.unknowns], points)


def projected(bundle: Bundle, scene: Scene) -> np.ndarray:
    """Pixels of all observations, one after the other, by `View.project`."""
    views: tuple[View, ...] = bundle.scene(scene).views
    pixels = [
        views[photo].project(bundle.points[point][None])[0]
        for photo, point in zip(bundle.photo_idx, bundle.point_idx)
    ]
    return np.concatenate(pixels)


def dense(bundle: Bundle, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Normal matrix and right side of everything, points too, with Cauchy weights."""
    size = bundle.unknowns + 3 * len(bundle.points)
    steps = np.full(size, 1e-5)
    steps[[k for k in range(6 * len(bundle.views)) if k % 6 < 3]] = 1e-7
    steps[6 * len(bundle.views) : bundle.unknowns] = 0.1  # pixels are linear in each lens number
    columns = [
        (projected(moved(bundle, step * e), scene) - projected(moved(bundle, -step * e), scene))
        / (2 * step)
        for step, e in zip(steps, np.eye(size))
    ]
    slopes = np.column_stack(columns)
    residual = bundle.xy_px.ravel() - projected(bundle, scene)
    squares = np.repeat((residual.reshape(-1, 2) ** 2).sum(1), 2)
    weights = 1 / (1 + squares / CAUCHY_PX**2)
    return slopes.T @ (weights[:, None] * slopes), slopes.T @ (weights * residual)


def still(bundle: Bundle) -> np.ndarray:
    """No numbers that move points."""
    return np.zeros((len(bundle.points), 3, 0))


def reduced(bundle: Bundle, damping: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    size = bundle.unknowns
    normal, right, diagonal = np.empty((size, size)), np.empty(size), np.empty(size)
    reduce_equations(
        bundle.views, bundle.lens_idx, NONE_OF_THEIR_OWN, still(bundle), bundle.photo_idx,
        bundle.bounds, bundle.xy_px, bundle.points, CAUCHY_PX, damping, normal, right, diagonal,
    )  # fmt: skip
    return normal, right, diagonal


@pytest.mark.parametrize(("seed", "damping"), [(0, 0.0), (1, 0.3)])
def test_points_are_eliminated_and_follow_as_in_the_dense_equations(
    make_scene, seed: int, damping: float
) -> None:
    scene = make_scene(photos=4, points=7, noise_px=1.0, seed=seed)
    bundle = Bundle.of(scene)
    normal, right = dense(bundle, scene)
    u = bundle.unknowns
    own = normal[u:, u:] + damping * np.diag(np.diag(normal)[u:])
    follow = np.linalg.solve(own, normal[u:, :u])

    found, found_right, diagonal = reduced(bundle, damping)
    scale = 1 / np.sqrt(np.maximum(np.diag(normal)[:u], 1e-12))
    expected = normal[:u, :u] - normal[:u, u:] @ follow
    np.testing.assert_allclose(
        found * np.outer(scale, scale), expected * np.outer(scale, scale), atol=1e-5
    )
    expected = right[:u] - follow.T @ right[u:]
    np.testing.assert_allclose(scale * found_right, scale * expected, rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(diagonal, np.diag(normal)[:u], rtol=1e-5)

    step = np.random.default_rng(seed).normal(size=u) * scale
    points = np.empty_like(bundle.points)
    point_steps(
        bundle.views, bundle.lens_idx, bundle.photo_idx, bundle.bounds, bundle.xy_px,
        bundle.points, CAUCHY_PX, damping, step, points,
    )  # fmt: skip
    expected = np.linalg.solve(own, right[u:] - normal[u:, :u] @ step)
    np.testing.assert_allclose(points.ravel(), expected, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("cameras", [1, 2])
def test_own_numbers_are_those_of_lenses_that_hang_together(make_scene, cameras: int) -> None:
    """Equations of one lens a photo, tied by hand, against those made with the ties."""
    random, photos, own = np.random.default_rng(cameras), 5, 3
    bundle = Bundle.of(make_scene(photos=photos, points=9, noise_px=1.0))
    bundle = bundle.with_points(np.arange(9) > 0)  # the first one's row of observations is gone
    lens_idx = np.arange(photos) % cameras
    basis = random.normal(size=(cameras, LENS_SIZE, own))
    poses, size = POSE_SIZE * photos, (POSE_SIZE + own) * photos + LENS_SIZE * cameras
    tied = np.zeros((poses + LENS_SIZE * photos, size))
    tied[:poses, :poses] = np.eye(poses)
    for photo, lens in enumerate(lens_idx):
        rows = slice(poses + LENS_SIZE * photo, poses + LENS_SIZE * (photo + 1))
        tied[rows, poses + LENS_SIZE * lens :][:, :LENS_SIZE] = np.eye(LENS_SIZE)
        tied[rows, size - own * (photos - photo) :][:, :own] = basis[lens]

    def equations(lens_idx: np.ndarray, basis: np.ndarray, size: int) -> list[np.ndarray]:
        found = [np.empty((size, size)), np.empty(size), np.empty(size)]
        reduce_equations(
            bundle.views, lens_idx, basis, still(bundle), bundle.photo_idx, bundle.bounds,
            bundle.xy_px, bundle.points, CAUCHY_PX, 0.2, *found,
        )  # fmt: skip
        return found

    alone = np.zeros((photos, LENS_SIZE, 0))
    normal, right, _ = equations(np.arange(photos), alone, len(tied))
    found, found_right, diagonal = equations(lens_idx, basis, size)
    scale = 1 / np.sqrt(np.maximum(diagonal, 1e-12))
    both = np.outer(scale, scale)
    np.testing.assert_allclose(found * both, tied.T @ normal @ tied * both, atol=1e-9)
    np.testing.assert_allclose(scale * found_right, scale * (tied.T @ right), atol=1e-9)
    np.testing.assert_array_equal(found, found.T)
    assert np.abs(found[-own:, -own:]).min() > 0.0


def test_points_that_shift_in_one_photo_are_a_photo_that_shifts(make_scene) -> None:
    bundle = Bundle.of(make_scene(photos=4, points=9, noise_px=1.0))
    size, photos = bundle.unknowns, len(bundle.views)
    tied = np.hstack([np.eye(size), np.zeros((size, 3 * photos))])
    for photo, view in enumerate(bundle.views):
        rows = slice(POSE_SIZE * photo + 3, POSE_SIZE * (photo + 1))
        tied[rows, size + 3 * photo : size + 3 * (photo + 1)] = view[:9].reshape(3, 3)
    asked = bundle, bundle.lens_idx, NONE_OF_THEIR_OWN, 0.5, 0.2
    normal, right, _ = reduced_equations(*asked)
    found, found_right, diagonal = reduced_equations(*asked, np.tile(np.eye(3), (9, 1, 1)))
    scale = 1 / np.sqrt(np.maximum(diagonal, 1e-12))
    both = np.outer(scale, scale)
    np.testing.assert_allclose(found * both, tied.T @ normal @ tied * both, atol=1e-9)
    np.testing.assert_allclose(scale * found_right, scale * (tied.T @ right), atol=1e-9)


def test_the_cost_is_the_robust_sum_and_what_lies_behind_is_dear(make_scene) -> None:
    scene = make_scene(photos=4, points=6, noise_px=2.0)
    bundle = Bundle.of(scene)
    given = (bundle.views, bundle.photo_idx, bundle.bounds, bundle.xy_px)
    residual = (bundle.xy_px.ravel() - projected(bundle, scene)).reshape(-1, 2)
    expected = sum(CAUCHY_PX**2 * np.log1p((row @ row) / CAUCHY_PX**2) for row in residual)
    np.testing.assert_allclose(robust_cost(*given, bundle.points, CAUCHY_PX), expected, rtol=1e-12)

    behind = bundle.points.copy()
    first = scene.views[int(bundle.photo_idx[0])]
    behind[0] = first.centre_in_world * 1.5
    expected = 0.0
    for photo, point, xy in zip(bundle.photo_idx, bundle.point_idx, bundle.xy_px):
        view = scene.views[int(photo)]
        away = xy - view.project(behind[point][None])[0]
        in_front = view.camera_from_world.apply(behind[point])[2] > 0
        expected += CAUCHY_PX**2 * np.log1p(away @ away / CAUCHY_PX**2) if in_front else BEHIND_COST
    assert expected > BEHIND_COST
    np.testing.assert_allclose(robust_cost(*given, behind, CAUCHY_PX), expected, rtol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_a_body_is_eliminated_and_follows_as_in_the_dense_equations(seed: int) -> None:
    """Cameras (9), the whole (7) and five corners, from equations drawn at random."""
    random = np.random.default_rng(seed)
    cameras, corners = 9, 5
    rest = cameras + 7
    slopes = random.normal(size=(80, rest + 3 * corners))
    own_of = np.repeat(np.arange(corners), 16)  # each row measures one corner
    for row, corner in enumerate(own_of):
        of_others = [k for k in range(3 * corners) if k // 3 != corner]
        slopes[row, rest + np.array(of_others)] = 0.0
    normal, right = slopes.T @ slopes, slopes.T @ random.normal(size=80)
    parts = [slice(rest + 3 * k, rest + 3 * k + 3) for k in range(corners)]
    equations = BodyEquations(
        shared=normal[:rest, :rest],
        shared_right=right[:rest],
        blocks=np.stack([normal[part, part] for part in parts]),
        cross=np.stack([normal[part, :rest] for part in parts]),
        block_right=np.stack([right[part] for part in parts]),
    )
    follow = np.linalg.solve(normal[cameras:, cameras:], normal[cameras:, :cameras])
    found, found_right = equations.of_cameras()
    expected = normal[:cameras, :cameras] - normal[:cameras, cameras:] @ follow
    np.testing.assert_allclose(found, expected, atol=1e-9)
    np.testing.assert_allclose(found_right, right[:cameras] - follow.T @ right[cameras:], atol=1e-9)
    step = random.normal(size=cameras)
    whole, own = equations.follow(step)
    expected = np.linalg.solve(
        normal[cameras:, cameras:], right[cameras:] - normal[cameras:, :cameras] @ step
    )
    np.testing.assert_allclose(np.concatenate([whole, own.ravel()]), expected, atol=1e-9)
