"""Which pairs are matched, what comes out, and what is refused."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from limbgram.core.errors import MatchingError
from limbgram.reconstruction.features.detection import Features, Keypoints, detect
from limbgram.reconstruction.matching.matching import (
    match,
    select_pairs,
)
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.photos.reading import read_photos

SIZE_PX = 420
STEP_PX = 60


def panorama(seed: int, width_px: int) -> np.ndarray:
    noise = np.random.default_rng(seed).uniform(0, 255, (SIZE_PX, width_px)).astype(np.float32)
    smooth = cv2.GaussianBlur(noise, (0, 0), 2) + 2 * cv2.GaussianBlur(noise, (0, 0), 6)
    return cv2.normalize(smooth, smooth, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)


def photographed(folder: Path, pictures: list[np.ndarray]) -> tuple[PhotoSet, Features]:
    for index, picture in enumerate(pictures):
        Image.fromarray(picture).save(folder / f"{index + 1}.png")
    photos = read_photos([folder])
    return photos, detect(photos)


def test_overlapping_photos_match_where_they_overlap(tmp_path: Path) -> None:
    wide = panorama(0, SIZE_PX + 2 * STEP_PX)
    views = [wide[:, left : left + SIZE_PX] for left in (0, STEP_PX, 2 * STEP_PX)]
    matches = match(*photographed(tmp_path, views))
    assert [(pair.first, pair.second) for pair in matches.pairs] == [(0, 1), (0, 2), (1, 2)]
    assert matches.pairs_tried == 3
    assert sum(map(len, matches.pairs)) <= matches.descriptor_matches
    for pair in matches.pairs:
        steps = pair.second - pair.first
        shift_px = pair.xy_first_px - pair.xy_second_px
        assert len(pair) > 150
        assert np.abs(np.median(shift_px, axis=0) - [steps * STEP_PX, 0]).max() < 0.01
        assert (np.abs(shift_px - [steps * STEP_PX, 0]).max(axis=1) < 0.1).mean() > 0.97
        assert pair.correlation.min() >= 0.8
        assert len(np.unique(pair.keypoint_idx[:, 0])) == len(pair)


def test_the_same_photos_give_the_same_matches(tmp_path: Path) -> None:
    wide = panorama(1, SIZE_PX + STEP_PX)
    photos, features = photographed(tmp_path, [wide[:, :SIZE_PX], wide[:, STEP_PX:]])
    (one,), (two,) = match(photos, features).pairs, match(photos, features).pairs
    np.testing.assert_array_equal(one.keypoint_idx, two.keypoint_idx)
    np.testing.assert_array_equal(one.xy_second_px, two.xy_second_px)


def test_photos_without_marks_are_refused(tmp_path: Path) -> None:
    plain = [np.full((SIZE_PX, SIZE_PX), 120 + index, np.uint8) for index in range(3)]
    photos, features = photographed(tmp_path, plain)
    with pytest.raises(MatchingError, match=r"plain(.|\n)*Paint"):
        match(photos, features)


def test_photos_of_different_things_are_refused(tmp_path: Path) -> None:
    photos, features = photographed(tmp_path, [panorama(seed, SIZE_PX) for seed in range(4)])
    with pytest.raises(MatchingError, match="another photo shows"):
        match(photos, features)


def ring(count: int, shuffled: bool) -> tuple[Features, np.ndarray]:
    """Photos round an object: each shares 70 % of its marks with the next, 40 % with that after.

    Returns the features, and the place in the ring of each.
    """
    rng = np.random.default_rng(0)
    marks = rng.gamma(0.6, 40, (30 * count, 128)).astype(np.float32)
    places = rng.permutation(count) if shuffled else np.arange(count)
    keypoints: list[Keypoints] = []
    for place in places:
        seen = marks[np.arange(30 * place, 30 * place + 100) % len(marks)]
        noisy = np.maximum(seen + rng.normal(0, 8, seen.shape), 0)
        unit = np.sqrt(noisy / noisy.sum(axis=1, keepdims=True))
        keypoints.append(
            Keypoints(
                xy_px=np.zeros((100, 2), np.float32),
                scale_px=np.linspace(9, 1, 100, dtype=np.float32),
                angle_deg=rng.normal(20, 5, 100).astype(np.float32),
                descriptors=np.minimum(512 * unit, 255).astype(np.uint8),
            )
        )
    return Features(tuple(keypoints)), places


def test_few_of_many_pairs_are_tried_and_the_ring_closes() -> None:
    features, places = ring(40, shuffled=True)
    pairs = {
        frozenset((int(places[c.first]), int(places[c.second]))) for c in select_pairs(features)
    }
    assert len(pairs) < 40 * 39 / 2 / 3
    for place in range(40):
        assert frozenset((place, (place + 1) % 40)) in pairs
        assert frozenset((place, (place + 2) % 40)) in pairs


def test_neighbours_by_name_are_tried_even_when_they_look_hopeless() -> None:
    features, _ = ring(12, shuffled=False)
    blind = Features(
        tuple(
            Keypoints(
                xy_px=k.xy_px,
                scale_px=k.scale_px,
                angle_deg=k.angle_deg,
                descriptors=np.random.default_rng(i).integers(0, 90, (100, 128), dtype=np.uint8),
            )
            for i, k in enumerate(features.keypoints)
        )
    )
    pairs = {(c.first, c.second) for c in select_pairs(blind)}
    ring_of_two = {(i, i + step) for step in (1, 2) for i in range(12 - step)}
    assert pairs == ring_of_two | {(0, 11), (0, 10), (1, 11)}


def test_the_change_of_scale_of_a_pair_is_found() -> None:
    features, _ = ring(3, shuffled=False)
    first = features.keypoints[0]
    nearer = Keypoints(
        xy_px=first.xy_px,
        scale_px=first.scale_px * 2,
        angle_deg=first.angle_deg + 90,
        descriptors=first.descriptors,
    )
    (pair,) = select_pairs(Features((first, nearer)))
    assert pair.scale_change == pytest.approx(2)
    assert pair.score > 90


def test_pairs_with_few_matches_are_left_out(tmp_path: Path) -> None:
    wide = panorama(2, SIZE_PX + STEP_PX)
    views = [wide[:, :SIZE_PX], wide[:, STEP_PX:], panorama(9, SIZE_PX)]
    matches = match(*photographed(tmp_path, views))
    assert [(pair.first, pair.second) for pair in matches.pairs] == [(0, 1)]
    assert matches.pairs_tried == 3
