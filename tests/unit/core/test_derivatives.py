"""The lens, and every derivative in the program, against complex steps and differences.

Formulas that take complex numbers are differentiated without any loss (complex step); the others
by a difference of four values, whose error is rounding alone: `agree` allows what that can be.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid, Similarity
from limbgram.core.geometry.lens import (
    DISTORTION,
    LENS_SIZE,
    PARAMETERS,
    POSE_SIZE,
    Camera,
    View,
    coefficient_derivatives,
    differentiate_all,
    distorted,
    distorted_with_jacobian,
    lens_derivatives,
    with_pose_step,
)
from limbgram.core.geometry.triangulation import sampson_jacobian, sampson_px, triangulate
from limbgram.reconstruction.calibration.adjustment import (
    SHARED,
    board_slopes,
    moved,
    project_board,
)
from limbgram.reconstruction.mapping.body import Body
from limbgram.reconstruction.mapping.bundle import Bundle
from limbgram.reconstruction.mapping.bundle_equations import reduce_equations, robust_cost
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.measuring.sampling import project
from limbgram.reconstruction.measuring.uncertainty import _displacements as displacements
from limbgram.reconstruction.scale.ruler import scale_by_cameras
from limbgram.reconstruction.targets.board import Board, BoardDetections, PhotoCorners
from limbgram.reconstruction.targets.corners import _normal_equations as corner_equations
from limbgram.reconstruction.twoview.fundamental import normal_equations

LENS = Camera(
    width_px=2400, height_px=1600, fx=2800.0, fy=2790.0, cx=1210.0, cy=790.0, skew=12.0,
    k1=-0.12, k2=0.08, p1=0.0009, p2=-0.0007, k3=-0.03,
)  # fmt: skip
"""No parameter is zero, so that no derivative is."""
LENS_STEPS = np.append(
    np.ones(5), [0.01 * 2.0 ** max(one.power - 2, 0) for one in DISTORTION.values()]
)
"""The less a coefficient moves places, the longer its step: rounding is smaller beside it."""
POSE_STEPS = np.array([1e-3, 1e-3, 1e-3, 0.3, 0.3, 0.3])
CENTRES = [np.array([900 * np.sin(a), -900 * np.cos(a), 300.0]) for a in (0.0, 0.5, 1.0, 1.4)]
UP = np.array([0.0, 0.0, 1.0])
VIEWS = [View(str(k), LENS, Rigid.looking_at(c, np.zeros(3), UP)) for k, c in enumerate(CENTRES)]
POINTS = np.random.default_rng(2).uniform(-120, 120, (30, 3))
X, Y = np.random.default_rng(3).uniform(-0.4, 0.4, (2, 50))
COEFFICIENTS = LENS.packed[5:]
IMAGINARY = 1e-30

Function = Callable[[np.ndarray], np.ndarray]


def difference(function: Function, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of `function` at nought by each of its unknowns, and what rounding can do.

    Abramowitz and Stegun 25.3.6: the error of four values is of the fourth order in the step.
    """
    slopes: list[np.ndarray] = []
    errors: list[np.ndarray] = []
    for step in np.diag(steps):
        one, two = (
            np.asarray(function(times * step) - function(-times * step)) for times in (1, 2)
        )
        size = step.sum()
        slopes.append((8 * one - two) / (12 * size))
        largest = np.abs(np.asarray(function(step))).max()
        errors.append(np.full(one.shape, 64 * np.finfo(float).eps * largest / size))
    return np.stack(slopes, axis=-1), np.stack(errors, axis=-1)


def agree(exact: np.ndarray, function: Function, steps: np.ndarray) -> None:
    """Every unknown's derivative is right; and none is nought, which would prove nothing."""
    slopes, errors = difference(function, steps)
    largest = np.abs(slopes).max(axis=tuple(range(slopes.ndim - 1)))
    assert (np.abs(exact - slopes) <= errors + 1e-9 * largest).all()
    assert (np.abs(exact).reshape(-1, len(steps)).max(axis=0) > 0).all()


def derivatives(view: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """By point, pose and lens."""
    count = len(points)
    filled = np.empty((count, 2, 3)), np.empty((count, 2, 6)), np.empty((count, 2, LENS_SIZE))
    differentiate_all(view, points, *filled)
    return filled


def pixels(view: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Through the plain formulas of `View.project`."""
    pose = Rigid(view[:9].reshape(3, 3), view[9:12])
    return View("", LENS.with_parameters(view[12:]), pose).project(points)


def changed(view: np.ndarray, step: np.ndarray) -> np.ndarray:
    """A view after a step of its pose and its lens."""
    after = with_pose_step(view, step[:POSE_SIZE])
    after[12:] += step[POSE_SIZE:]
    return after


def test_distortion_by_place_is_exact() -> None:
    _, _, xd_x, xd_y, yd_y = distorted_with_jacobian(X, Y, *COEFFICIENTS)
    by_x = distorted(X + 1j * IMAGINARY, Y, *COEFFICIENTS)
    by_y = distorted(X, Y + 1j * IMAGINARY, *COEFFICIENTS)
    for exact, step in ((xd_x, by_x[0]), (xd_y, by_x[1]), (xd_y, by_y[0]), (yd_y, by_y[1])):
        np.testing.assert_allclose(exact, step.imag / IMAGINARY, rtol=1e-13, atol=1e-16)


@pytest.mark.parametrize("which", range(len(COEFFICIENTS)))
def test_distortion_by_coefficient_is_exact(which: int) -> None:
    coefficients = COEFFICIENTS.astype(complex)
    coefficients[which] += 1j * IMAGINARY
    for exact, step in zip(coefficient_derivatives(X, Y)[which], distorted(X, Y, *coefficients)):
        np.testing.assert_allclose(exact, step.imag / IMAGINARY, rtol=1e-13, atol=1e-16)


def test_the_inverse_undoes_the_distortion_and_so_do_its_derivatives() -> None:
    xy_px, by_ideal, _ = lens_derivatives(X, Y, LENS.packed)
    np.testing.assert_allclose(LENS.normalize(xy_px), np.stack([X, Y], 1), atol=1e-9)
    slopes, _ = difference(lambda d: LENS.normalize(xy_px + d), np.array([1.0, 1.0]))
    np.testing.assert_allclose(slopes @ by_ideal, np.tile(np.eye(2), (len(X), 1, 1)), atol=1e-6)


def test_arrays_give_the_kernels_derivatives_by_place_and_lens() -> None:
    slopes = lens_derivatives(X, Y, LENS.packed)
    np.testing.assert_allclose(
        slopes.xy_px, LENS.project(np.stack([X, Y, np.ones_like(X)], 1)), atol=1e-10
    )
    standing = View("", LENS, Rigid.identity()).packed
    by_point, _, by_lens = derivatives(standing, np.stack([X, Y, np.ones_like(X)], 1))
    np.testing.assert_allclose(slopes.by_ideal, by_point[:, :, :2], rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(slopes.by_lens, by_lens, rtol=1e-12, atol=1e-9)


def test_projection_by_point_pose_and_lens() -> None:
    view = VIEWS[1].packed
    by_point, by_pose, by_lens = derivatives(view, POINTS)
    agree(by_point, lambda d: pixels(view, POINTS + d), np.full(3, 0.3))
    agree(by_pose, lambda d: pixels(with_pose_step(view, d), POINTS), POSE_STEPS)
    agree(
        by_lens,
        lambda d: pixels(changed(view, np.append(np.zeros(6), d)), POINTS),
        LENS_STEPS,
    )


def test_the_measuring_kernels_projection_has_the_same_derivatives() -> None:
    view = VIEWS[2].packed
    by_point = derivatives(view, POINTS)[0]
    for point, slopes, xy_px in zip(POINTS, by_point, pixels(view, POINTS)):
        found = project(view, *point)
        np.testing.assert_allclose(found[:2], xy_px, atol=1e-9)
        np.testing.assert_allclose(found[3:], slopes.ravel(), rtol=1e-11, atol=1e-12)


def test_a_board_by_lens_shape_and_pose() -> None:
    board = Board.checkerboard("7x5", 20.0).corners_mm
    pose = Rigid.from_rotation_vector(np.array([0.3, -0.4, 0.2]), np.array([-50.0, -40.0, 300.0]))
    shared = np.append(LENS.packed, [0.01, 0.02, 0.03, -0.02, 0.01])
    slopes = board_slopes(board, board)
    exact = project_board(board, slopes, shared, pose)
    agree(
        exact.by_shared,
        lambda d: project_board(board, slopes, shared + d, pose).xy_px,
        np.append(LENS_STEPS, np.full(SHARED - LENS_SIZE, 1e-3)),
    )
    agree(
        exact.by_pose,
        lambda d: project_board(board, slopes, shared, moved(pose, d)).xy_px,
        POSE_STEPS,
    )


def test_sampson_distances_by_the_matrix() -> None:
    pinhole = [replace(view, camera=LENS.undistorted) for view in VIEWS]
    first, second = (view.project(POINTS) / 1000 for view in pinhole[:2])
    drawn = np.random.default_rng(4).normal(size=(2, len(POINTS), 2)) * 1e-3
    fundamental = np.array([[0.1, -0.7, 0.3], [0.6, 0.2, -0.9], [-0.2, 0.8, 0.1]])
    agree(
        sampson_jacobian(fundamental, first + drawn[0], second + drawn[1]),
        lambda d: sampson_px(fundamental + d.reshape(3, 3), first + drawn[0], second + drawn[1]),
        np.full(9, 1e-4),
    )


def test_gold_standard_equations_are_half_the_costs_gradient() -> None:
    drawn = np.random.default_rng(5)
    projection = np.hstack([np.eye(3) + 0.1 * drawn.normal(size=(3, 3)), [[1.0], [0.2], [0.1]]])
    points = np.column_stack([drawn.normal(size=(20, 2)), drawn.uniform(0.2, 0.5, 20)])
    given = drawn.normal(size=(20, 4))

    def residuals(p: np.ndarray, x: np.ndarray) -> np.ndarray:
        image = np.column_stack([x[:, :2], np.ones(len(x)), x[:, 2]]) @ p.T
        return given - np.hstack([x[:, :2], image[:, :2] / image[:, 2:]])

    def cost(p: np.ndarray, x: np.ndarray) -> np.ndarray:
        return np.array([(residuals(p, x) ** 2).sum()])

    equations = normal_equations(projection, points, residuals(projection, points))
    agree(
        -2 * equations.shared_right[None],
        lambda d: cost(projection + d.reshape(3, 4), points),
        np.full(12, 1e-3),
    )
    agree(
        -2 * equations.block_right.reshape(1, -1),
        lambda d: cost(projection, points + d.reshape(-1, 3)),
        np.full(points.size, 1e-3),
    )


def scene() -> Scene:
    """Four photos of all points by one lens, without errors."""
    return Scene(
        names=tuple(view.name for view in VIEWS),
        cameras=(LENS,),
        camera_idx=(0,) * len(VIEWS),
        camera_from_world=tuple(view.camera_from_world for view in VIEWS),
        points_in_world=POINTS,
        observations=Observations(
            np.repeat(np.arange(len(VIEWS), dtype=np.int32), len(POINTS)),
            np.tile(np.arange(len(POINTS), dtype=np.int32), len(VIEWS)),
            np.concatenate([view.project(POINTS) for view in VIEWS]),
        ),
        verdicts=(),
    )


CAMERA_STEPS = np.append(np.tile(POSE_STEPS, len(VIEWS)), LENS_STEPS) / 300


def test_bundle_equations_are_half_the_costs_gradient() -> None:
    """Points held by a damping without bounds: what remains is the gradient by the cameras."""
    bundle = Bundle.of(scene())
    xy_px = bundle.xy_px + np.random.default_rng(6).normal(0, 2.0, bundle.xy_px.shape)
    cauchy_px, size = 3.0, bundle.unknowns
    normal, right, diagonal = np.empty((size, size)), np.empty(size), np.empty(size)
    reduce_equations(
        bundle.views, bundle.lens_idx, np.zeros((1, LENS_SIZE, 0)),
        np.zeros((len(POINTS), 3, 0)), bundle.photo_idx, bundle.bounds, xy_px, bundle.points,
        cauchy_px, 1e16, normal, right, diagonal,
    )  # fmt: skip

    def cost(step: np.ndarray) -> np.ndarray:
        after = bundle.moved(step, np.zeros_like(bundle.points))
        return np.array(
            [
                robust_cost(
                    after.views, bundle.photo_idx, bundle.bounds, xy_px, bundle.points, cauchy_px
                )
            ]
        )

    agree(-2 * right[None], cost, CAMERA_STEPS)


def test_a_triangulated_point_is_where_the_squares_are_least() -> None:
    seen = scene().observations
    xy_px = seen.xy_px + np.random.default_rng(7).normal(0, 0.5, seen.xy_px.shape)
    found = triangulate(VIEWS, seen.photo_idx, seen.point_idx, xy_px, len(POINTS)).points_in_world

    def squares(shift: np.ndarray) -> np.ndarray:
        off = np.concatenate([view.project(found + shift) for view in VIEWS]) - xy_px
        return np.bincount(seen.point_idx, (off**2).sum(1))

    slopes, errors = difference(squares, np.full(3, 0.01))
    away, _ = difference(lambda d: squares(d + 0.01), np.full(3, 0.01))
    assert (np.abs(slopes) < 1e-6 * np.abs(away).max() + errors).all()


def test_a_bodys_equations_are_half_the_costs_gradient() -> None:
    bundle = Bundle.of(scene())
    shape = POINTS[:8]
    corner_idx, photo_idx = np.repeat(np.arange(8), len(VIEWS)), np.tile(np.arange(len(VIEWS)), 8)
    drawn = np.random.default_rng(8)
    xy_px = np.array([VIEWS[k].project(shape[c : c + 1])[0] for c, k in zip(corner_idx, photo_idx)])
    body = Body(
        shape=shape,
        world_from_body=Similarity(1.01, Rigid.identity().rotation, np.array([0.1, 0.2, -0.1])),
        offsets=drawn.normal(0, 0.1, shape.shape),
        shape_sigma=0.2,
        photo_idx=photo_idx,
        corner_idx=corner_idx,
        xy_px=xy_px + drawn.normal(0, 0.5, xy_px.shape),
        sigma_px=0.5,
    )
    equations = body.equations(bundle, 3.0)
    still, rest = np.zeros_like(shape), bundle.unknowns

    def cost_after(step: np.ndarray) -> np.ndarray:
        cameras = bundle.moved(step[:rest], np.zeros_like(bundle.points))
        return np.array([body.moved(step[rest:], still).cost(cameras, 3.0)])

    whole_steps = np.array([1e-3, 1e-3, 1e-3, 0.1, 0.1, 0.1, 1e-3]) / 100
    agree(-2 * equations.shared_right[None], cost_after, np.append(CAMERA_STEPS, whole_steps))
    agree(
        -2 * equations.block_right.reshape(1, -1),
        lambda d: np.array([body.moved(np.zeros(7), d.reshape(-1, 3)).cost(bundle, 3.0)]),
        np.full(shape.size, 0.001),
    )


def test_the_boards_size_by_the_cameras() -> None:
    """The corners triangulated anew by changed cameras grow as the linear formula says."""
    board = Board.checkerboard("7x5", 20.0)
    corners = board.corners_mm - board.corners_mm.mean(0)
    ids = np.arange(len(corners), dtype=np.int32)
    photos = tuple(
        PhotoCorners(
            name=view.name,
            photo_idx=k,
            ids=ids,
            xy_px=view.project(corners),
            sigmas_px=np.full(len(ids), 0.05),
            blur_px=1.0,
            step_px=100.0,
            doubtful_ids=np.zeros(0, np.int32),
            doubtful_xy_px=np.zeros((0, 2)),
            doubts=(),
        )
        for k, view in enumerate(VIEWS)
    )
    detections = BoardDetections(
        board=board, corners_mm=board.corners_mm, photos=photos, set_aside=()
    )
    photo_idx, corner_idx = (
        np.repeat(np.arange(len(VIEWS), dtype=np.int32), len(ids)),
        np.tile(ids, len(VIEWS)),
    )
    xy_px = np.concatenate([photo.xy_px for photo in photos])

    def shrinks(step: np.ndarray) -> np.ndarray:
        lens, views = step[-LENS_SIZE:], []
        for k, view in enumerate(VIEWS):
            row = changed(view.packed, np.append(step[POSE_SIZE * k :][:POSE_SIZE], lens))
            pose = Rigid(row[:9].reshape(3, 3), row[9:12])
            views.append(View(view.name, LENS.with_parameters(row[12:]), pose))
        found = triangulate(views, photo_idx, corner_idx, xy_px, len(ids)).points_in_world
        return np.array([-((found - corners) * corners).sum() / (corners**2).sum()])

    exact = scale_by_cameras(scene(), detections, corners)
    slopes, _ = difference(shrinks, CAMERA_STEPS)
    scale = CAMERA_STEPS * np.abs(exact).max()
    np.testing.assert_allclose(exact, slopes[0], rtol=1e-5, atol=1e-7 * float(scale.max()))
    assert len(exact) == POSE_SIZE * len(VIEWS) + len(PARAMETERS)


def test_a_corners_equations_are_half_the_costs_gradient() -> None:
    drawn = np.random.default_rng(9)
    places = np.mgrid[-3:4, -3:4].reshape(2, -1).T
    pixels = np.column_stack([places, drawn.uniform(0, 255, len(places))])
    state = np.array([0.2, -0.3, 0.1, 1.7, 1.4, 60.0, 120.0, 0.5, -0.3])
    agree(
        -2 * corner_equations(pixels, state)[2][None],
        lambda step: np.array([corner_equations(pixels, state + step)[0]]),
        np.array([0.01, 0.01, 0.003, 0.003, 0.01, 1.0, 1.0, 0.1, 0.1]) / 10,
    )


def test_a_vertex_moves_with_the_cameras_as_matching_it_anew_would_have_it() -> None:
    """Along its normal, and over its plane, to where all photos show the same place again."""
    given = scene()
    vertices, axes = POINTS[:4], np.stack([Rigid.from_rotation_vector(
        np.array([0.3 * k, 0.2, -0.1]), np.zeros(3)).rotation for k in range(4)])  # fmt: skip
    seen_by = np.array([[0, 1, 2, 3], [0, 1, 2, -1], [1, 3, 2, -1], [0, 2, -1, -1]], np.int32)
    unknowns = POSE_SIZE * len(VIEWS) + LENS_SIZE
    exact = displacements(vertices, axes, seen_by, given, np.eye(unknowns))

    def matched(step: np.ndarray) -> np.ndarray:
        lens, moves = step[-LENS_SIZE:], []
        for vertex, own, photos in zip(vertices, axes, seen_by):
            right, columns = [], []
            for k in photos[photos >= 0]:
                row = VIEWS[k].packed
                after = changed(row, np.append(step[POSE_SIZE * k :][:POSE_SIZE], lens))
                by_plane = derivatives(row, vertex[None])[0][0] @ own.T
                off_px = pixels(after, vertex[None])[0] - pixels(row, vertex[None])[0]
                in_plane = np.linalg.inv(by_plane[:, :2])
                columns.append(np.column_stack([np.eye(2), in_plane @ by_plane[:, 2]]))
                right.append(-in_plane @ off_px)
            moves.append(np.linalg.lstsq(np.vstack(columns), np.concatenate(right))[0][2])
        return np.array(moves)

    slopes, errors = difference(matched, 30 * CAMERA_STEPS)
    largest = np.abs(slopes).max(axis=0)
    assert (np.abs(exact - slopes) <= 100 * errors + 1e-7 * largest).all()
    assert (largest > 0).all()
