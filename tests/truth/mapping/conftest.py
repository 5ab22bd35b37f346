"""A made-up capture whose cameras and points are known: matches with noise and with wrong ones."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from tests.unit.reconstruction.mapping.conftest import described

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.matching.matching import Matches, PairMatches
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet

LENS = Camera(
    width_px=2400, height_px=1600, fx=4000.0, fy=4004.0, cx=1209.0, cy=788.0,
    k1=-0.09, k2=0.05, p1=0.0004, p2=-0.0003,
)  # fmt: skip
BOARD_SIGMAS = np.array([0.5, 0.5, 2.0, 2.0, 0.0, 2e-3, 2e-2, 1e-4, 1e-4, 0.0])
REACH = 3
"""Photos up to so many steps apart are matched."""


@dataclass(frozen=True)
class Capture:
    """What the stages before mapping would give, and the truth behind it."""

    photos: PhotoSet
    features: Features
    matches: Matches
    cameras: Cameras
    views: tuple[View, ...]
    points_mm: np.ndarray
    point_of_keypoint: tuple[np.ndarray, ...]


def limb(count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Points and outward normals of a lumpy cylinder, 300 mm high."""
    angle, height = rng.uniform(0, 2 * np.pi, count), rng.uniform(0.0, 300.0, count)
    radius = 65 + 8 * np.sin(height / 50.0) + 5 * np.cos(2 * angle)
    outward = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
    return outward * radius[:, None] + [0, 0, 1] * height[:, None], outward


def ring(count: int, rng: np.random.Generator) -> tuple[View, ...]:
    """Hand-held photos on an irregular ring, 1.2 m from the limb."""
    up, views = np.array([0.0, 0.0, 1.0]), []
    for k in range(count):
        angle = 2 * np.pi * (k + rng.uniform(-0.15, 0.15)) / count
        radius, height = rng.uniform(1150, 1250), rng.uniform(350, 500)
        centre = np.array([radius * np.cos(angle), radius * np.sin(angle), height])
        target = np.array([0.0, 0.0, 150.0]) + rng.normal(scale=10.0, size=3)
        views.append(View(f"IMG_{k:04d}.jpg", LENS, Rigid.looking_at(centre, target, up)))
    return tuple(views)


def capture(
    *,
    photos: int = 14,
    points: int = 2500,
    noise_px: float = 0.3,
    wrong: float = 0.2,
    calibrated_as: Camera = LENS,
    unlinked: tuple[int, ...] = (),
    seed: int = 0,
) -> Capture:
    """A capture; photos named in `unlinked` show nothing that any other photo shows."""
    rng = np.random.default_rng(seed)
    points_mm, normals = limb(points, rng)
    views = ring(photos, rng)
    seen, keypoints = [], []
    for view in views:
        towards = view.centre_in_world - points_mm
        towards /= np.linalg.norm(towards, axis=1, keepdims=True)
        found = (np.sum(towards * normals, axis=1) > 0.35) & (rng.random(points) < 0.8)
        visible = rng.permutation(np.flatnonzero(found))
        noise = rng.normal(scale=noise_px, size=(len(visible), 2))
        xy_px = view.project(points_mm[visible]) + noise
        seen.append(visible)
        keypoints.append(described(xy_px))
    pairs = [
        matched(first, second, seen, keypoints, wrong, rng)
        for first in range(photos)
        for second in range(first + 1, photos)
        if min(second - first, photos - second + first) <= REACH
        and first not in unlinked
        and second not in unlinked
    ]
    descriptor_matches = sum(map(len, pairs))
    return Capture(
        photo_set([view.name for view in views]),
        Features(tuple(keypoints)),
        Matches(pairs=tuple(pairs), pairs_tried=len(pairs), descriptor_matches=descriptor_matches),
        calibrated(calibrated_as),
        views,
        points_mm,
        tuple(seen),
    )


def calibrated(lens: Camera, source: str = "board", sigmas: np.ndarray = BOARD_SIGMAS) -> Cameras:
    return Cameras((Calibration(camera=lens, covariance=np.diag(sigmas**2), source=source),))


def photo_set(names: list[str]) -> PhotoSet:
    shared = {"width_px": LENS.width_px, "height_px": LENS.height_px, "exif": Exif()}
    photos = [
        Photo(name=name, path=Path(name), sha256="", camera_idx=0, **shared) for name in names
    ]
    return PhotoSet(tuple(photos), (CameraGroup(label="made up", **shared),))


def matched(
    first: int,
    second: int,
    seen: list[np.ndarray],
    keypoints: list[Keypoints],
    wrong: float,
    rng: np.random.Generator,
) -> PairMatches:
    _, in_first, in_second = np.intersect1d(seen[first], seen[second], return_indices=True)
    mistaken = rng.random(len(in_first)) < wrong
    in_second[mistaken] = rng.permutation(len(seen[second]))[: mistaken.sum()]
    return PairMatches(
        first=first,
        second=second,
        keypoint_idx=np.column_stack([in_first, in_second]).astype(np.int32),
        xy_first_px=keypoints[first].xy_px[in_first].astype(float),
        xy_second_px=keypoints[second].xy_px[in_second].astype(float),
        correlation=np.full(len(in_first), np.nan, np.float32),
    )


@pytest.fixture(scope="session")
def make_capture() -> Callable[..., Capture]:
    return capture


@pytest.fixture(scope="session")
def good_capture() -> Capture:
    return capture()
