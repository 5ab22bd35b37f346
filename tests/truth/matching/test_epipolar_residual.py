"""Matches of a rendered capture against its true cameras."""

import json
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.features.detection import Features, detect
from limbgram.reconstruction.matching.matching import Matches, match
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.photos.reading import read_photos

CORRECT_PX = 1.5


@pytest.fixture(scope="module")
def truth(data_folder: Path) -> dict:
    path = data_folder / "rendered" / "limb_ring15" / "truth" / "cameras.json"
    return json.loads(path.read_text())


@pytest.fixture(scope="module")
def matched(data_folder: Path) -> tuple[PhotoSet, Features, Matches]:
    folder = data_folder / "rendered" / "limb_ring15" / "images"
    photos = read_photos(sorted(folder.glob("*.jpg"))[:4])
    features = detect(photos)
    return photos, features, match(photos, features)


def sampson_px(
    truth: dict, names: tuple[str, str], first_px: np.ndarray, second_px: np.ndarray
) -> np.ndarray:
    """Distances from the true epipolar geometry, in pixels freed of distortion."""
    camera = Camera(
        width_px=truth["intrinsics"]["width"],
        height_px=truth["intrinsics"]["height"],
        **{key: truth["intrinsics"][key] for key in ("fx", "fy", "cx", "cy", "skew")},
        **truth["distortion"],
    )
    poses = {image["name"]: image for image in truth["images"]}
    (r1, t1), (r2, t2) = (
        (np.array(poses[name]["R"]), np.array(poses[name]["t"]).ravel()) for name in names
    )
    turn = r2 @ r1.T
    x, y, z = t2 - turn @ t1
    essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ turn
    inverse = np.linalg.inv(camera.matrix)
    fundamental = inverse.T @ essential @ inverse
    one, two = (
        np.column_stack([camera.normalize(px), np.ones(len(px))]) @ camera.matrix.T
        for px in (first_px, second_px)
    )
    line_two, line_one = one @ fundamental.T, two @ fundamental
    slopes = (line_one[:, :2] ** 2).sum(axis=1) + (line_two[:, :2] ** 2).sum(axis=1)
    return np.abs((two * line_two).sum(axis=1)) / np.sqrt(slopes)


def test_every_photo_shows_thousands_of_keypoints(
    matched: tuple[PhotoSet, Features, Matches],
) -> None:
    counts = [len(keypoints) for keypoints in matched[1].keypoints]
    assert min(counts) > 8000
    assert max(counts) <= 12_000


def test_neighbours_share_thousands_of_matches_and_nearly_all_are_right(
    truth: dict, matched: tuple[PhotoSet, Features, Matches]
) -> None:
    photos, _, matches = matched
    pairs = [pair for pair in matches.pairs if pair.second == pair.first + 1]
    assert len(pairs) == 3
    for pair in pairs:
        names = photos.names[pair.first], photos.names[pair.second]
        right = sampson_px(truth, names, pair.xy_first_px, pair.xy_second_px) < CORRECT_PX
        assert right.sum() > 2000
        assert right.mean() > 0.95


def test_correlation_brings_the_residual_down_to_a_third(
    truth: dict, matched: tuple[PhotoSet, Features, Matches]
) -> None:
    photos, features, matches = matched
    for pair in matches.pairs:
        names = photos.names[pair.first], photos.names[pair.second]
        found_px = features.keypoints[pair.second].xy_px[pair.keypoint_idx[:, 1]].astype(float)
        before = sampson_px(truth, names, pair.xy_first_px, found_px)
        after = sampson_px(truth, names, pair.xy_first_px, pair.xy_second_px)
        before_px = np.median(before[before < CORRECT_PX])
        after_px = np.median(after[after < CORRECT_PX])
        assert 0.06 < before_px < 0.15
        assert 0.01 < after_px < before_px / 2.5
