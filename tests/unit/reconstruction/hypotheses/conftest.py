"""A limb and a room in photos round them, with what happened between the photos known."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE, Camera
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.hypotheses.two_body_equations import (
    TwoBodyEquations,
    two_body_equations,
)
from limbgram.reconstruction.mapping.bundle_adjustment import adjust
from limbgram.reconstruction.mapping.lens_equations import DEVIATION_SIZE, lens_basis
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.targets.board import Board, BoardDetections, PhotoCorners

DISTANCE_MM = 1000.0
HALF_MM = 100.0
ASIDE = np.array([0.8, 0.6, 0.0])
LENS = Camera(
    width_px=1200, height_px=900, fx=1500.0, fy=1500.0, cx=600.0, cy=450.0, k1=-0.05, k2=0.02
)
CALIBRATED = Calibration(
    camera=LENS,
    covariance=np.diag([0.3, 0.3, 0.5, 0.5, 0.0, 1e-3, 1e-3, 1e-4, 1e-4, 0.0]) ** 2,
    source="board",
)
BOARD = Board.charuco("7x5", 30.0, 22.0, "4X4_50")
WORLD_FROM_BOARD = Rigid(np.diag([1.0, -1.0, -1.0]), np.array([60.0, 75.0, -60.0]))
"""It lies beside the limb, its print upwards."""
BY_EXIF = replace(
    CALIBRATED,
    covariance=np.diag([75.0, 75.0, 12.0, 12.0, 0.0, 0.1, 0.1, 2e-3, 2e-3, 0.1]) ** 2,
    source="exif",
)


@dataclass(frozen=True)
class Taken:
    """What was photographed."""

    photos: int = 14
    points: int = 160
    """Of each body."""
    noise_px: float = 0.1
    shared: float = 0.0
    """Share of the noise's variance that neighbouring points have in common in a photo."""
    seed: int = 0
    own: np.ndarray | None = None
    """Deviation of each photo's lens (n, 9)."""
    focal_px: float = 1500.0
    """Of the lens in truth; the calibration has 1500."""
    k1: float = -0.05
    by_exif: bool = False
    """Whether no board calibrated the lens."""
    motions: np.ndarray | None = None
    """Turn (rad) and shift (mm) of the second body in each photo (n, 6)."""
    turn_deg: float = 360.0
    """Of the walk."""
    bows_mm: np.ndarray | None = None
    """By photo (n), how far both ends of a limb of 200 mm are bowed aside."""
    outlier_sigmas: float = 4.0
    sag_mm: float = 0.0
    """By which the ends of the board's rows stand above its middle."""
    sag_in: int | None = None
    """Photo that alone shows the board bent."""

    @property
    def calibration(self) -> Calibration:
        return BY_EXIF if self.by_exif else CALIBRATED

    @property
    def true_lens(self) -> Camera:
        return replace(LENS, fx=self.focal_px, fy=self.focal_px, k1=self.k1)


def cloud(rng: np.random.Generator, points: int, inner: float, outer: float) -> np.ndarray:
    """Points in a shell round the origin, flat below."""
    directions = rng.normal(size=(points, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return directions * rng.uniform(inner, outer, (points, 1)) * np.array([1.0, 1.0, 0.8])


@dataclass(frozen=True)
class Bodies:
    """Scenes of the limb, and of the room that stands round it."""

    limb: Scene
    room: Scene
    calibration: Calibration
    board: BoardDetections
    """Of a board beside the limb."""

    @property
    def equations(self) -> TwoBodyEquations:
        photos = tuple(range(len(self.limb.names)))
        return two_body_equations(self.limb, self.room, photos, [self.calibration])


def bodies(taken: Taken) -> Bodies:
    """Both placed by their own points, lenses held, as the pipeline does."""
    rng = np.random.default_rng(taken.seed)
    angles = np.radians(taken.turn_deg) * np.arange(taken.photos) / taken.photos
    centres = DISTANCE_MM * np.column_stack(
        [np.cos(angles), np.sin(angles), 0.3 + 0.15 * (np.arange(taken.photos) % 2)]
    )
    poses = [Rigid.looking_at(at, np.zeros(3), np.array([0.0, 0.0, 1.0])) for at in centres]
    own = np.zeros((taken.photos, DEVIATION_SIZE)) if taken.own is None else taken.own
    motions = np.zeros((taken.photos, 6)) if taken.motions is None else taken.motions
    limb, room = cloud(rng, taken.points, 40.0, 110.0), cloud(rng, taken.points, 120.0, 280.0)
    if taken.bows_mm is not None:
        limb = np.column_stack([0.5 * limb[:, :2], rng.uniform(-HALF_MM, HALF_MM, len(limb))])
    return Bodies(
        placed(taken, limb, poses, own, 0.0 * motions, rng, taken.bows_mm),
        placed(taken, room, poses, own, motions, rng),
        taken.calibration,
        board_in(taken, poses, own),
    )


def board_in(taken: Taken, poses: list[Rigid], own: np.ndarray) -> BoardDetections:
    """Corners of the board, which every photo shows."""
    rng = np.random.default_rng((taken.seed, 1))
    width_mm = BOARD.columns * BOARD.square_mm
    photos: list[PhotoCorners] = []
    for k, pose in enumerate(poses):
        sag_mm = taken.sag_mm if taken.sag_in in (None, k) else 0.0
        corners = BOARD.corners_mm.copy()
        corners[:, 2] -= sag_mm * (2.0 * corners[:, 0] / width_mm - 1.0) ** 2
        lens = taken.true_lens.with_parameters(taken.true_lens.packed + lens_basis(LENS) @ own[k])
        xy_px = lens.project(pose.apply(WORLD_FROM_BOARD.apply(corners)))
        xy_px += 0.5 * taken.noise_px * rng.normal(size=xy_px.shape)
        count = len(xy_px)
        photos.append(
            PhotoCorners(
                name=f"{k}.jpg",
                photo_idx=k,
                ids=np.arange(count, dtype=np.int32),
                xy_px=xy_px,
                sigmas_px=np.full(count, 0.05),
                blur_px=1.0,
                step_px=40.0,
                doubtful_ids=np.zeros(0, np.int32),
                doubtful_xy_px=np.zeros((0, 2)),
                doubts=(),
            )
        )
    return BoardDetections(
        board=BOARD, corners_mm=BOARD.corners_mm, photos=tuple(photos), set_aside=()
    )


def placed(
    taken: Taken,
    points: np.ndarray,
    poses: list[Rigid],
    own: np.ndarray,
    motions: np.ndarray,
    rng: np.random.Generator,
    bows_mm: np.ndarray | None = None,
) -> Scene:
    """A body's scene; each point is seen from one side."""
    basis = lens_basis(LENS)
    facing = points / np.linalg.norm(points, axis=1, keepdims=True)
    near = np.linalg.norm(points[:, None] - points[None], axis=2) < 40.0
    rows: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    for k, pose in enumerate(poses):
        to_camera = pose.centre / np.linalg.norm(pose.centre)
        seen = np.flatnonzero(facing @ to_camera > -0.1)
        lens = taken.true_lens.with_parameters(taken.true_lens.packed + basis @ own[k])
        turn = Rigid.from_rotation_vector(motions[k, :3], motions[k, 3:])
        shown = turn.apply(points[seen])
        if bows_mm is not None:
            shown += bows_mm[k] * ((shown[:, 2:] / HALF_MM) ** 2 @ ASIDE[None])
        xy_px = lens.project(pose.apply(shown))
        common = near[np.ix_(seen, seen)] @ rng.normal(size=(len(seen), 2))
        common /= np.sqrt(near[np.ix_(seen, seen)].sum(axis=1, keepdims=True))
        alone = rng.normal(size=xy_px.shape)
        noise = np.sqrt(taken.shared) * common + np.sqrt(1.0 - taken.shared) * alone
        inside = LENS.contains(xy_px)
        rows.append(
            (np.full(int(inside.sum()), k), seen[inside], (xy_px + taken.noise_px * noise)[inside])
        )
    scene = Scene(
        names=tuple(f"{k}.jpg" for k in range(taken.photos)),
        cameras=(taken.calibration.camera,),
        camera_idx=(0,) * taken.photos,
        camera_from_world=tuple(poses),
        points_in_world=points.copy(),
        observations=Observations(
            np.concatenate([one[0] for one in rows]).astype(np.int32),
            np.concatenate([one[1] for one in rows]).astype(np.int32),
            np.concatenate([one[2] for one in rows]),
        ),
        verdicts=(),
    )
    held = replace(taken.calibration, covariance=np.zeros((LENS_SIZE, LENS_SIZE)))
    return adjust(scene, [held], rounds=2, outlier_sigmas=taken.outlier_sigmas).scene


@pytest.fixture(scope="session")
def take() -> Callable[..., Bodies]:
    """Photographs what `Taken` describes."""

    def taken(**options: Any) -> Bodies:
        return bodies(Taken(**options))

    return taken
