"""A made-up ring of photos round a cloud of points, measured exactly or with noise."""

from collections.abc import Callable
from typing import Literal

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.features.detection import Keypoints
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.matching.matching import PairMatches
from limbgram.reconstruction.twoview.pairs import VerifiedPair

LENSES = (
    Camera(
        width_px=900, height_px=700, fx=1500.0, fy=1490.0, cx=450.0, cy=345.0, skew=0.4,
        k1=-0.08, k2=0.03, p1=4e-4, p2=-3e-4, k3=0.01,
    ),
    Camera(width_px=900, height_px=700, fx=1300.0, fy=1300.0, cx=440.0, cy=350.0, k1=0.05),
)  # fmt: skip


def ring_scene(
    photos: int = 5, points: int = 12, noise_px: float = 0.0, share: float = 0.8, seed: int = 0,
    lenses: tuple[Camera, ...] = LENSES, spread: float = 30.0,
) -> Scene:  # fmt: skip
    """Photos on a circle; each sees a share of the points, the second lens every third photo.

    The circle's radius is 600; `spread` is the standard deviation of the points.
    """
    random = np.random.default_rng(seed)
    cloud = np.random.default_rng(7).normal(size=(points, 3)) * spread
    camera_idx = tuple((k % 3 == 2) * (len(lenses) - 1) for k in range(photos))
    poses, rows = [], []
    for k in range(photos):
        turn = 2 * np.pi * k / photos
        centre = 600.0 * np.array([np.cos(turn), np.sin(turn), 0.2 * (k % 2)])
        pose = Rigid.looking_at(centre, np.zeros(3), np.array([0.0, 0.0, 1.0]))
        poses.append(pose)
        seen = np.flatnonzero(np.random.default_rng(100 + k).random(points) < share)
        xy = lenses[camera_idx[k]].project(pose.apply(cloud[seen]))
        rows.append((np.full(len(seen), k), seen, xy + random.normal(0, noise_px, xy.shape)))
    return Scene(
        names=tuple(f"{k}.jpg" for k in range(photos)),
        cameras=lenses,
        camera_idx=camera_idx,
        camera_from_world=tuple(poses),
        points_in_world=cloud,
        observations=Observations(
            np.concatenate([photo for photo, _, _ in rows]).astype(np.int32),
            np.concatenate([point for _, point, _ in rows]).astype(np.int32),
            np.concatenate([xy for _, _, xy in rows]),
        ),
        verdicts=(),
    )


def described(
    xy_px: np.ndarray, scale_px: np.ndarray | float = 1.0, angle_deg: np.ndarray | float = 0.0
) -> Keypoints:
    """Keypoints at these places, with descriptors that tell nothing."""
    count = len(xy_px)
    return Keypoints(
        xy_px=xy_px.astype(np.float32),
        scale_px=np.broadcast_to(scale_px, count).astype(np.float32),
        angle_deg=np.broadcast_to(angle_deg, count).astype(np.float32),
        descriptors=np.zeros((count, 128), np.uint8),
    )


@pytest.fixture(scope="session")
def make_scene() -> Callable[..., Scene]:
    return ring_scene


def verified_pair(
    first: int,
    second: int,
    keypoints: np.ndarray,
    pose: Rigid | None = None,
    kind: Literal["general", "planar", "rotation"] = "general",
    xy_px: tuple[np.ndarray, np.ndarray] | None = None,
) -> VerifiedPair:
    """Row k of `keypoints` says which keypoint of each photo match k joins."""
    count = len(keypoints)
    xy_first, xy_second = xy_px or (np.zeros((count, 2)), np.zeros((count, 2)))
    return VerifiedPair(
        matches=PairMatches(
            first=first,
            second=second,
            keypoint_idx=np.asarray(keypoints, np.int32),
            xy_first_px=xy_first,
            xy_second_px=xy_second,
            correlation=np.ones(count, np.float32),
        ),
        fundamental=np.eye(3),
        second_from_first=pose,
        kind=kind,
        residual_px=np.zeros(count),
        median_angle_deg=20.0,
    )


@pytest.fixture(scope="session")
def make_pair() -> Callable[..., VerifiedPair]:
    return verified_pair
