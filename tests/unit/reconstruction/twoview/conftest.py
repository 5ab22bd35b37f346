"""A pair of photos of a limb-like cylinder, with everything known."""

from dataclasses import dataclass

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE, Camera, View
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.matching.matching import PairMatches
from limbgram.reconstruction.twoview.essential import fundamental_from_pose

LENS = Camera(width_px=2400, height_px=1600, fx=5500.0, fy=5500.0, cx=1210.0, cy=790.0, k1=-0.08)
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class KnownPair:
    """Exact matches in pixels free of distortion, and the same as photographed."""

    first: np.ndarray
    second: np.ndarray
    photographed: PairMatches
    pose: Rigid
    fundamental: np.ndarray

    def noisy(self, sigma_px: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
        rng = np.random.default_rng(seed)
        return tuple(
            xy + rng.normal(scale=sigma_px, size=xy.shape) for xy in (self.first, self.second)
        )


def board(lens: Camera = LENS) -> Calibration:
    return Calibration(camera=lens, covariance=np.zeros((LENS_SIZE, LENS_SIZE)), source="board")


def photograph(points: np.ndarray, second_centre: np.ndarray) -> KnownPair:
    target = np.array([0.0, 0.0, 150.0])
    views = [
        View("", LENS, Rigid.looking_at(centre, target, UP))
        for centre in (np.array([0.0, -1500.0, 400.0]), second_centre)
    ]
    pose = views[1].camera_from_world @ views[0].camera_from_world.inverse
    pose = Rigid(pose.rotation, pose.translation / np.linalg.norm(pose.translation))
    straight = [view.camera_from_world.apply(points) @ LENS.matrix.T for view in views]
    straight = [image[:, :2] / image[:, 2:] for image in straight]
    count = len(points)
    photographed = PairMatches(
        first=0,
        second=1,
        keypoint_idx=np.column_stack([np.arange(count), np.arange(count)]).astype(np.int32),
        xy_first_px=views[0].project(points),
        xy_second_px=views[1].project(points),
        correlation=np.full(count, np.nan, np.float32),
    )
    fundamental = fundamental_from_pose(pose, LENS.matrix, LENS.matrix)
    return KnownPair(straight[0], straight[1], photographed, pose, fundamental)


def limb_points(count: int = 800) -> np.ndarray:
    rng = np.random.default_rng(8)
    angle, height = rng.uniform(-2.5, -0.3, count), rng.uniform(0.0, 300.0, count)
    radius = 60 + 10 * np.sin(height / 40.0) + rng.normal(size=count)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


@pytest.fixture(scope="session")
def limb_pair() -> KnownPair:
    """24 degrees between the photos."""
    return photograph(limb_points(), np.array([610.0, -1370.0, 380.0]))


@pytest.fixture(scope="session")
def flat_pair() -> KnownPair:
    """A plane from two places."""
    points = limb_points() * [1.0, 0.0, 1.0]
    return photograph(points, np.array([610.0, -1370.0, 380.0]))


@pytest.fixture(scope="session")
def calibration() -> Calibration:
    return board()
