"""The kernels over many pixels at once against plain formulas, one pixel at a time."""

import numpy as np
import pytest

from limbgram.reconstruction.dense import patchmatch
from limbgram.reconstruction.dense.crops import upsample_planes

WIDTH, HEIGHT = 60, 48
SIGMA_GREY, SIGMA_PX = 40.0, 3.0


def correlation(
    own: np.ndarray, other: np.ndarray, a: np.ndarray, b: np.ndarray, x: int, y: int,
    plane: np.ndarray,
) -> float:  # fmt: skip
    """Bilaterally weighted correlation of one window with one other photo, as the papers write it.

    The window maps by the homography's derivative at its centre; -1 where it is not whole.
    """
    w0, gx, gy = plane
    homography = a + np.outer(b, [gx, gy, w0 - gx * x - gy * y])
    u, v, depth = homography @ [x, y, 1.0]
    u, v = u / depth, v / depth
    jacobian = (homography[:2, :2] - np.outer([u, v], homography[2, :2])) / depth
    offsets = np.array([(i, j) for j in range(-5, 6, 2) for i in range(-5, 6, 2)], float)
    reach = 5 * np.abs(jacobian).sum(1)
    centre = np.array([u, v])
    if np.any(centre - reach <= 1) or np.any(centre + reach >= (WIDTH - 3, HEIGHT - 3)):
        return -1.0
    grey = own[y + offsets[:, 1].astype(int), x + offsets[:, 0].astype(int)].astype(float)
    weight = np.exp(-0.5 * ((grey - own[y, x]) / SIGMA_GREY) ** 2)
    weight *= np.exp(-0.5 * (offsets**2).sum(1) / SIGMA_PX**2)
    weight /= weight.sum()
    places = centre + offsets @ jacobian.T
    corner = np.floor(places).astype(int)
    (fx, fy), (cx, cy) = (places - corner).T, corner.T
    top = (1 - fx) * other[cy, cx] + fx * other[cy, cx + 1]
    low = (1 - fx) * other[cy + 1, cx] + fx * other[cy + 1, cx + 1]
    seen = (1 - fy) * top + fy * low
    from_own, from_other = grey - weight @ grey, seen - weight @ seen
    energy = (weight @ from_own**2) * (weight @ from_other**2)
    return float(weight @ (from_own * from_other) / np.sqrt(energy))


@pytest.fixture
def pictures() -> np.ndarray:
    rng = np.random.default_rng(3)
    smooth = rng.normal(size=(2, HEIGHT + 8, WIDTH + 8))
    for axis in (1, 2):
        smooth = sum(np.roll(smooth, k, axis) for k in range(-2, 3))
    return np.clip(128 + 12 * smooth[:, 4:-4, 4:-4], 0, 255).astype(np.uint8)


@pytest.mark.parametrize("step", [1, 2])
def test_many_pixels_at_once_correlate_as_one_does(pictures: np.ndarray, step: int) -> None:
    own, other = pictures
    other = np.round(0.6 * other + 0.4 * np.roll(own, 1, 1)).astype(np.uint8)
    a = np.array([[0.98, 0.05, 1.5], [-0.04, 1.01, -0.7], [1e-4, -2e-4, 1.0]])
    b = np.array([60.0, -25.0, 0.02])
    rng = np.random.default_rng(0)
    count = 150
    column, row = rng.integers(6, WIDTH - 6, count), rng.integers(6, HEIGHT - 6, count)
    column, row = column // step, row // step
    planes = np.stack([rng.uniform(0, 0.05, count), *rng.normal(0, 1e-3, (2, count))])

    x, y = step * column, step * row
    expected = np.array(
        [correlation(own, other, a, b, x[k], y[k], planes[:, k]) for k in range(count)]
    )
    places = (row * (WIDTH // step) + column).astype(np.int32)
    order = np.unique(places, return_index=True)[1]
    state = np.zeros((3, own.size // step**2), np.float32)
    state[:, places[order]] = planes[:, order]
    score = np.zeros(own.size // step**2, np.float32)
    sources = (
        patchmatch.pack_neighbourhoods(other), np.array([[0, WIDTH, HEIGHT]]),
        a.reshape(1, 9).astype(np.float32), b.reshape(1, 3).astype(np.float32), 1,
    )  # fmt: skip
    picture = (
        own.ravel(), WIDTH, step,
        patchmatch.grey_weights(SIGMA_GREY), patchmatch.distance_weights(SIGMA_PX),
    )  # fmt: skip
    patchmatch.score_planes(picture, sources, places[order], np.array([0.0, 1.0]), state, score)
    found, expected = score[places[order]], expected[order]
    whole = expected > -1
    assert 0.3 < whole.mean() < 0.98
    np.testing.assert_allclose(found[whole], expected[whole], atol=2e-4)
    assert np.ptp(expected[whole]) > 0.5
    assert np.all(found[~whole] == -1)


def test_a_packed_picture_holds_the_right_and_lower_neighbours(pictures: np.ndarray) -> None:
    words = patchmatch.pack_neighbourhoods(pictures[0]).reshape(HEIGHT, WIDTH)
    bytes_ = words[7, 9] >> np.array([0, 8, 16, 24], np.uint32) & 255
    np.testing.assert_array_equal(bytes_, pictures[0][[7, 7, 8, 8], [9, 10, 9, 10]])


@pytest.mark.parametrize(("step", "to_step"), [(1, 1), (1, 2), (2, 2)])
def test_a_plane_stays_the_same_plane_on_a_finer_level(step: int, to_step: int) -> None:
    """w = 0.01 + 2e-4 x - 1e-4 y in full pixels, sampled at places of the coarser ones."""
    row, column = step * np.mgrid[0:8, 0:10]
    x, y = 2 * column + 0.5, 2 * row + 0.5
    planes = np.stack([0.01 + 2e-4 * x - 1e-4 * y, np.full(x.shape, 4e-4), np.full(x.shape, -2e-4)])
    shape = 16 * step // to_step, 20 * step // to_step
    wanted = np.ones(shape, bool)
    wanted[3, 4] = False
    fine = upsample_planes(planes.reshape(3, -1).astype(np.float32), (8, 10), step, wanted, to_step)
    row, column = to_step * np.mgrid[0 : shape[0], 0 : shape[1]]
    fine = fine.reshape(3, *shape)
    assert np.all(fine[:, 3, 4] == 0)
    np.testing.assert_allclose(
        fine[0][wanted], (0.01 + 2e-4 * column - 1e-4 * row)[wanted], atol=1e-8
    )
    np.testing.assert_allclose(fine[1][wanted], 2e-4, atol=1e-9)
    np.testing.assert_allclose(fine[2][wanted], -1e-4, atol=1e-9)


def test_the_windows_reach_is_that_of_its_weights() -> None:
    one_direction = np.exp(-0.5 * np.array([1, 9, 25]) / SIGMA_PX**2)
    expected = one_direction @ [1, 9, 25] / one_direction.sum()
    assert patchmatch.window_second_moment_px2(
        patchmatch.distance_weights(SIGMA_PX)
    ) == pytest.approx(expected, rel=1e-5)
