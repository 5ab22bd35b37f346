"""Window correlation on a picture known everywhere, seen through a known affine map."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.ndimage import map_coordinates
from scipy.optimize import least_squares

from limbgram.reconstruction.features.detection import Keypoints
from limbgram.reconstruction.matching.windows import (
    build_pyramid,
    correlate,
    follow,
)

Waves = Callable[[np.ndarray, np.ndarray], np.ndarray]

WIDTH_PX, HEIGHT_PX = 260, 220
TURN_DEG, CHANGE = 25.0, 1.15


def second_from_first() -> np.ndarray:
    """A turn, a change of scale, and a shear that keypoints do not know."""
    angle = np.radians(TURN_DEG)
    turn = CHANGE * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return turn @ np.array([[1.06, 0.05], [0.02, 0.93]])


CENTRE = np.array([130.0, 110.0])


def seen_second(xy_px: np.ndarray) -> np.ndarray:
    return (xy_px - CENTRE) @ second_from_first().T + CENTRE + [0.37, -0.81]


def pictures(waves: Waves, noise: float) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    y, x = np.mgrid[:HEIGHT_PX, :WIDTH_PX].astype(float)
    back = (np.stack([x, y], -1) - CENTRE - [0.37, -0.81]) @ np.linalg.inv(second_from_first()).T
    back += CENTRE
    brighter = 0.8 * waves(back[..., 0], back[..., 1]) + 30  # another gain and offset
    return tuple(
        np.clip(np.rint(image + rng.normal(0, noise, image.shape)), 0, 255).astype(np.uint8)
        for image in (waves(x, y), brighter)
    )


def keypoints(xy_px: np.ndarray, scale_px: float, angle_deg: float) -> Keypoints:
    count = len(xy_px)
    return Keypoints(
        xy_px=xy_px.astype(np.float32),
        scale_px=np.full(count, scale_px, np.float32),
        angle_deg=np.full(count, angle_deg, np.float32),
        descriptors=np.zeros((count, 128), np.uint8),
    )


def run(waves: Waves, scale_px: float, noise: float, off_px: float) -> np.ndarray:
    """Errors of the refined points, for keypoints that start up to `off_px` off."""
    rng = np.random.default_rng(1)
    first, second = (build_pyramid(image) for image in pictures(waves, noise))
    xy_px = rng.uniform([85, 75], [175, 145], (200, 2)).astype(np.float32).astype(float)
    start_px = seen_second(xy_px) + rng.uniform(-off_px, off_px, xy_px.shape)
    pairs = np.repeat(np.arange(200, dtype=np.int32)[:, None], 2, axis=1)
    result = correlate(
        first,
        second,
        keypoints(xy_px, scale_px, 10.0),
        keypoints(start_px, scale_px * CHANGE, 10.0 + TURN_DEG),
        pairs,
    )
    assert result.kept.mean() > 0.95
    assert (result.correlation[result.kept] > 0.9).all()
    return (result.xy_second_px - seen_second(xy_px))[result.kept]


@pytest.mark.parametrize(
    "scale_px", [1.2, *(pytest.param(one, marks=pytest.mark.slow) for one in (2.0, 4.0))]
)
def test_points_are_moved_to_where_they_belong(waves: Waves, scale_px: float) -> None:
    errors_px = run(waves, scale_px, noise=0.0, off_px=0.7)
    assert np.median(np.abs(errors_px)) < 0.02
    assert np.abs(np.median(errors_px, axis=0)).max() < 0.006


def test_noise_costs_its_share_and_no_more(waves: Waves) -> None:
    errors_px = run(waves, 2.0, noise=4.0, off_px=0.7)
    assert 0.01 < np.median(np.abs(errors_px)) < 0.06


def test_false_matches_are_dropped(waves: Waves) -> None:
    rng = np.random.default_rng(2)
    first, second = (build_pyramid(image) for image in pictures(waves, 1.0))
    xy_px = rng.uniform([85, 75], [175, 145], (200, 2))
    wrong_px = seen_second(rng.permutation(xy_px))
    pairs = np.repeat(np.arange(200, dtype=np.int32)[:, None], 2, axis=1)
    result = correlate(
        first,
        second,
        keypoints(xy_px, 2.0, 0.0),
        keypoints(wrong_px, 2.0 * CHANGE, TURN_DEG),
        pairs,
    )
    assert result.kept.mean() < 0.05


def test_windows_that_leave_the_picture_or_show_nothing_are_dropped() -> None:
    picture = np.full((HEIGHT_PX, WIDTH_PX), 90, np.uint8)
    picture[:, :100] = np.random.default_rng(0).integers(0, 255, (HEIGHT_PX, 100))
    pyramid = build_pyramid(picture)
    places = keypoints(np.array([[3.0, 100.0], [200.0, 100.0], [50.0, 100.0]]), 1.5, 0.0)
    pairs = np.repeat(np.arange(3, dtype=np.int32)[:, None], 2, axis=1)
    result = correlate(pyramid, pyramid, places, places, pairs)
    assert result.kept.tolist() == [False, False, True]
    np.testing.assert_allclose(result.xy_second_px[2], [50, 100], atol=1e-3)
    assert result.correlation[2] == pytest.approx(1, abs=1e-5)


@pytest.mark.parametrize("scale_px", [2.0, 4.0])
def test_a_point_that_moves_too_far_is_dropped(waves: Waves, scale_px: float) -> None:
    """Three pixels of the level compared, which is the half picture for keypoints of 4 px."""
    picture, _ = pictures(waves, 0.0)
    pyramid = build_pyramid(picture)
    here = keypoints(np.array([[130.0, 110.0]]), scale_px, 0.0)
    pair = np.zeros((1, 2), np.int32)
    near, far = (
        correlate(
            pyramid,
            pyramid,
            here,
            keypoints(np.array([[130.0 + level_px * scale_px / 2, 110.0]]), scale_px, 0.0),
            pair,
        )
        for level_px in (2.5, 3.5)
    )
    np.testing.assert_allclose(near.xy_second_px[0], [130, 110], atol=0.01)
    assert near.kept.tolist() == [True]
    assert far.kept.tolist() == [False]


def follow_to(waves: Waves, noise: float, off_px: float) -> np.ndarray:
    """x and y errors and correlation of points that are expected up to `off_px` off."""
    rng = np.random.default_rng(1)
    first, second = (build_pyramid(image) for image in pictures(waves, noise))
    xy_px = rng.uniform([95, 85], [165, 135], (200, 2))
    start_px = seen_second(xy_px) + rng.uniform(-off_px, off_px, xy_px.shape)
    maps = np.tile(second_from_first(), (200, 1, 1))
    expected = np.column_stack([start_px[:, 0], maps[:, 0], start_px[:, 1], maps[:, 1]])
    found = follow(first, second, xy_px, expected)
    return np.column_stack([found[:, :2] - seen_second(xy_px), found[:, 2]])


def test_points_are_followed_to_where_they_belong(waves: Waves) -> None:
    exact = follow_to(waves, noise=0.0, off_px=1.5)
    assert np.isfinite(exact).all(axis=1).mean() > 0.95
    assert np.nanmedian(np.abs(exact[:, :2])) < 0.02
    assert np.abs(np.nanmedian(exact[:, :2], axis=0)).max() < 0.006
    noisy = follow_to(waves, noise=4.0, off_px=1.5)
    assert 0.01 < np.nanmedian(np.abs(noisy[:, :2])) < 0.06


def test_points_expected_elsewhere_are_not_followed(waves: Waves) -> None:
    assert np.isfinite(follow_to(waves, noise=1.0, off_px=60.0)).all(axis=1).mean() < 0.15


def normalized(values: np.ndarray) -> np.ndarray:
    return (values - values.mean()) / values.std()


def best_place(first: np.ndarray, second: np.ndarray, xy: np.ndarray, place: np.ndarray) -> tuple:
    """Least-squares matching by scipy: B-spline windows of 13 x 13, zero mean, unit spread."""
    v, u = (axis.ravel() for axis in np.mgrid[-6:7, -6:7].astype(float))
    wanted = normalized(map_coordinates(first, [xy[1] + v, xy[0] + u], order=3, prefilter=False))

    def seen(map_: np.ndarray) -> np.ndarray:
        x, y = map_[0] + map_[1] * u + map_[2] * v, map_[3] + map_[4] * u + map_[5] * v
        return normalized(map_coordinates(second, [y, x], order=3, prefilter=False))

    solved = least_squares(lambda map_: seen(map_) - wanted, place, x_scale=[1, 0.1, 0.1] * 2)
    return solved.x[[0, 3]], float((seen(solved.x) * wanted).mean())


def test_following_is_least_squares_matching_in_two_levels(waves: Waves) -> None:
    """Each level's best place is found; the mean of the two is the point's."""
    images = pictures(waves, 0.5)
    pyramids = [build_pyramid(image) for image in images]
    xy_px = np.random.default_rng(3).uniform([100, 90], [160, 130], (12, 2))
    map_ = second_from_first()
    start_px = seen_second(xy_px) + 0.4
    expected = np.column_stack(
        [start_px[:, 0], np.tile(map_[0], (12, 1)), start_px[:, 1], np.tile(map_[1], (12, 1))]
    )
    found = follow(*pyramids, xy_px, expected)
    assert np.isfinite(found).all()
    levels = []
    for pyramid in pyramids:
        parts = (pyramid.pixels[start : start + h * w].reshape(h, w) for start, h, w in
                 pyramid.layout[:2])  # fmt: skip
        levels.append([part.astype(float) for part in parts])
    for row, xy in enumerate(xy_px):
        place = expected[row].copy()
        places = []
        for level in (1, 0):
            size = 2.0**level
            own = place.copy()
            own[[0, 3]] = (place[[0, 3]] + 0.5) / size - 0.5
            best, agreement = best_place(
                levels[0][level], levels[1][level], (xy + 0.5) / size - 0.5, own
            )
            places.append((best + 0.5) * size - 0.5)
            place[[0, 3]] = places[-1]
        np.testing.assert_allclose(found[row, :2], np.mean(places, axis=0), atol=0.008)
        assert found[row, 2] == pytest.approx(agreement, abs=1e-3)


def test_levels_keep_pixel_centres() -> None:
    y, x = np.mgrid[:HEIGHT_PX, :WIDTH_PX]
    rising = build_pyramid((x // 2 + y // 3).astype(np.uint8))
    falling = build_pyramid((255 - x // 2 - y // 3).astype(np.uint8))
    for level, (start, height, width) in enumerate(rising.layout):
        levels = slice(start, start + height * width)
        difference = rising.pixels[levels].astype(float) - falling.pixels[levels]
        slope = difference.reshape(height, width) / 2 + 127.5
        v, u = np.mgrid[:height, :width]
        full_x, full_y = (u + 0.5) * 2**level - 0.5, (v + 0.5) * 2**level - 0.5
        # the whole-number ramps lie a quarter and a third below the true ones
        expected = (full_x - 0.5) / 2 + (full_y - 1.0) / 3
        assert abs((slope - expected).mean()) < 0.05
