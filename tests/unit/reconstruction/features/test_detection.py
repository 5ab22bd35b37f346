"""Detection on blobs at known places, of known size, in pictures of known turn."""

import cv2
import numpy as np
import pytest

from limbgram.reconstruction.features.detection import (
    FeatureOptions,
    Keypoints,
    find_keypoints,
    root_sift,
)

SIZE_PX = 400


def blobs(places_px: np.ndarray, sigmas_px: np.ndarray) -> np.ndarray:
    """Dark Gaussian blobs on grey, exact at pixel centres."""
    rows, columns = np.mgrid[:SIZE_PX, :SIZE_PX]
    picture = np.full((SIZE_PX, SIZE_PX), 180.0)
    for (x, y), sigma in zip(places_px, sigmas_px):
        picture -= 120 * np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2 * sigma**2))
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def grid_px(seed: int = 0) -> np.ndarray:
    """Places 40 px apart, each moved by a random part of a pixel."""
    x, y = np.meshgrid(np.arange(40, 361, 40), np.arange(40, 361, 40))
    whole = np.column_stack([x.ravel(), y.ravel()])
    return whole + np.random.default_rng(seed).uniform(-0.5, 0.5, whole.shape)


def nearest(keypoints: Keypoints, places_px: np.ndarray, sigma_px: float) -> np.ndarray:
    """For each place the keypoint of about the right scale next to it."""
    right = np.flatnonzero(np.abs(np.log2(keypoints.scale_px / sigma_px)) < 0.7)
    distances = np.linalg.norm(keypoints.xy_px[right][None] - places_px[:, None], axis=2)
    return right[distances.argmin(axis=1)]


@pytest.mark.parametrize("sigma_px", [1.5, 3.0, 6.0])
def test_keypoints_lie_where_the_blobs_are(sigma_px: float) -> None:
    places_px = grid_px()
    keypoints = find_keypoints(blobs(places_px, np.full(len(places_px), sigma_px)))
    found = nearest(keypoints, places_px, sigma_px)
    errors_px = keypoints.xy_px[found] - places_px
    assert np.abs(errors_px.mean(axis=0)).max() < 0.02
    assert 1e-4 < np.sqrt((errors_px**2).mean()) < 0.05 * sigma_px
    assert 0.8 < np.median(keypoints.scale_px[found]) / sigma_px < 1.2


def test_reducing_a_large_photo_moves_no_keypoint() -> None:
    places_px = grid_px(1)
    options = FeatureOptions(max_megapixels=SIZE_PX**2 / 1e6 / 3)
    keypoints = find_keypoints(blobs(places_px, np.full(len(places_px), 4.0)), None, options)
    found = nearest(keypoints, places_px, 4.0)
    errors_px = keypoints.xy_px[found] - places_px
    close = np.abs(errors_px).max(axis=1) < 0.3
    assert close.mean() > 0.95
    assert np.abs(errors_px[close].mean(axis=0)).max() < 0.02
    assert 0.8 < np.median(keypoints.scale_px[found[close]]) / 4.0 < 1.2


def test_angles_run_clockwise_from_x() -> None:
    picture = texture(0)
    turned = np.ascontiguousarray(np.rot90(picture, -1))  # clockwise as seen
    upright, clockwise = find_keypoints(picture), find_keypoints(turned)
    expected_px = np.column_stack([SIZE_PX - 1 - upright.xy_px[:, 1], upright.xy_px[:, 0]])
    distances = np.linalg.norm(clockwise.xy_px[None] - expected_px[:, None], axis=2)
    paired = distances.argmin(axis=1)
    close = distances.min(axis=1) < 0.1
    assert close.mean() > 0.8
    turns = np.mod(clockwise.angle_deg[paired[close]] - upright.angle_deg[close], 360)
    assert abs(np.median(turns) - 90) < 1


def texture(seed: int) -> np.ndarray:
    noise = np.random.default_rng(seed).uniform(0, 255, (SIZE_PX, SIZE_PX)).astype(np.float32)
    smooth = cv2.GaussianBlur(noise, (0, 0), 3)
    return cv2.normalize(smooth, smooth, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)


def test_masks_are_honoured() -> None:
    mask = np.zeros((SIZE_PX, SIZE_PX), bool)
    mask[100:300, 50:200] = True
    keypoints = find_keypoints(texture(1), mask)
    assert len(keypoints) > 50
    columns, rows = np.rint(keypoints.xy_px).astype(int).T
    assert mask[rows, columns].all()


def test_a_mask_of_a_reduced_photo_is_honoured() -> None:
    mask = np.zeros((SIZE_PX, SIZE_PX), bool)
    mask[100:300, 50:200] = True
    keypoints = find_keypoints(texture(1), mask, FeatureOptions(max_megapixels=0.08))
    assert len(keypoints) > 20
    x, y = keypoints.xy_px.T
    assert 47 < x.min() < x.max() < 203
    assert 97 < y.min() < y.max() < 303


def test_the_limit_keeps_keypoints_all_over_the_picture() -> None:
    picture = texture(2)
    picture[:, SIZE_PX // 2 :] = 110 + (picture[:, SIZE_PX // 2 :].astype(int) - 128) // 3
    everything = find_keypoints(picture)
    limit = len(everything) // 2
    limited = find_keypoints(picture, None, FeatureOptions(max_keypoints=limit))
    strongest = cv2.SIFT.create(limit, contrastThreshold=0.02).detect(picture, None)
    assert len(limited) == limit
    faint = (limited.xy_px[:, 0] > SIZE_PX / 2).mean()
    assert 0.15 < faint < 0.6
    assert faint > 2 * np.mean([keypoint.pt[0] > SIZE_PX / 2 for keypoint in strongest])


def test_a_limb_in_a_corner_of_the_photo_keeps_its_keypoints() -> None:
    """Texture on a ninth of the picture, in one tile of four: as many as without tiles."""
    dice = np.random.default_rng(7)
    noise = dice.uniform(0, 255, (400, 400)).astype(np.float32)
    fine = cv2.GaussianBlur(noise, (0, 0), 1.2)
    picture = np.full((1200, 1200), 128, np.uint8)
    picture[100:500, 100:500] = cv2.normalize(fine, fine, 0, 255, cv2.NORM_MINMAX)
    whole = cv2.SIFT.create(contrastThreshold=0.02).detect(picture, None)
    limit = int(0.8 * len(whole))
    found = find_keypoints(picture, None, FeatureOptions(max_keypoints=limit))
    assert 0.99 * limit <= len(found) <= limit


def test_keypoints_come_largest_first_and_the_same_every_time() -> None:
    first, second = find_keypoints(texture(3)), find_keypoints(texture(3))
    assert (np.diff(first.scale_px) <= 0).all()
    np.testing.assert_array_equal(first.xy_px, second.xy_px)
    np.testing.assert_array_equal(first.descriptors, second.descriptors)


def test_a_bare_picture_has_no_keypoints() -> None:
    keypoints = find_keypoints(np.full((SIZE_PX, SIZE_PX), 90, np.uint8))
    assert len(keypoints) == 0
    assert keypoints.descriptors.shape == (0, 128)


def test_descriptors_have_unit_length_times_512() -> None:
    raw = np.random.default_rng(0).gamma(0.6, 40, (50, 128)).astype(np.float32)
    rooted = root_sift(raw).astype(float)
    np.testing.assert_allclose(np.linalg.norm(rooted, axis=1), 512, rtol=0.01)
    one, two = np.sqrt(raw[:2] / raw[:2].sum(axis=1, keepdims=True))
    assert np.linalg.norm(rooted[0] - rooted[1]) == pytest.approx(
        512 * np.linalg.norm(one - two), rel=0.01
    )
