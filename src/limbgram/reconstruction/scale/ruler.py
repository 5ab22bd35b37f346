"""Rulers: known lengths in scene units, and their derivatives by lenses and poses.

A lens too long or a photo turned moves every triangulated corner. To first order a corner moves by
-(sum A'A)^-1 (sum A'B p): A and B are the derivatives of its pixels by the corner and by the
cameras' numbers p (order of `Scene.camera_covariance`).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64, Int, Int32, Int64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, differentiate_all
from limbgram.core.interval import widening
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.scale.stated_lengths import LengthEnds
from limbgram.reconstruction.targets.board import BoardDetections

LEAST_OBSERVATIONS = 3
"""Fewest photos that triangulate a corner."""


@dataclass(frozen=True, kw_only=True)
class RulerLength:
    """One known length, with its measured length in the scene."""

    label: str
    known_mm: float
    measured: float
    """In scene units."""
    sigma: float
    """In scene units: one standard deviation of the measured length, by its own ends."""
    role: Literal["control", "check"]
    between: LengthEnds = "points"
    marks: tuple[int, ...] = ()
    stated_sigma_mm: float = 0.0
    """Standard deviation of the known length itself."""
    by_cameras: Float64[np.ndarray, " u"] | None = None
    """Relative change of the measured length by each parameter of poses and lenses; None where the
    scene has no covariance."""


@dataclass(frozen=True, kw_only=True)
class Ruler:
    """The scale by one source of known lengths."""

    units_per_mm: float
    relative_sigma: float
    lengths: tuple[RulerLength, ...]
    set_aside: tuple[SetAside, ...]
    by_cameras: Float64[np.ndarray, " u"] | None = None
    """Relative change of `units_per_mm` by the same parameters."""

    def sigma_of(self, one: RulerLength, scene: Scene) -> float:
        """Standard deviation of a length measured by this scale, in scene units.

        Lens and poses make it as uncertain as they let it grow otherwise than what sets the scale.
        The scale's own doubt is that of every length beside it; of a board's own lengths it is
        the same photos' that measured them.
        """
        beside = one.role == "check" and one.between != "board"
        variance = self.relative_sigma**2 if beside else 0.0
        covariance, ours, its = scene.camera_covariance, self.by_cameras, one.by_cameras
        if covariance is not None and ours is not None and its is not None:
            variance += max(float((its - ours) @ covariance @ (its - ours)), 0.0)
        return float(np.hypot(one.sigma, one.measured * np.sqrt(variance)))


def jackknife_sigma(replicates: Float64[np.ndarray, " p"]) -> float:
    """Standard deviation of a figure from its values without each photo in turn (Tukey 1958).

    It holds whatever a photo's errors have in common, such as its pose; widened, as the photos are
    few.
    """
    count = len(replicates)
    sigma = np.sqrt((count - 1) / count * np.sum((replicates - replicates.mean()) ** 2))
    return float(sigma) * widening(count - 1)


def scale_by_cameras(
    scene: Scene, detections: BoardDetections, corners_in_world: Points3
) -> Float64[np.ndarray, " u"]:
    """Relative change of the scene's size in millimetres for one unit of each camera number.

    A board that would come out larger makes the scale, and so the scene, smaller.
    """
    moves, seen = points_by_cameras(scene, corners_shown(detections), corners_in_world)
    located = seen >= LEAST_OBSERVATIONS
    return -size_by_cameras(corners_in_world[located], moves[located])


def size_by_cameras(
    points: Points3, moves: Float64[np.ndarray, "n 3 u"]
) -> Float64[np.ndarray, " u"]:
    """Relative change of the size of a point set, such as the two ends of a length."""
    arms = points - points.mean(0)
    return np.einsum("ni,niu->u", arms, moves) / float((arms**2).sum())


def stretch_by_cameras(
    scene: Scene,
    detections: BoardDetections,
    corners_in_world: Points3,
    ids: Int32[np.ndarray, " k"],
) -> Float64[np.ndarray, " u"]:
    """Change of the ratio of a board's sides by the corners `ids`, for one unit of each."""
    moves, _ = points_by_cameras(scene, corners_shown(detections), corners_in_world)
    plane = detections.corners_mm[ids, :2] - detections.corners_mm[ids, :2].mean(0)
    along = np.linalg.pinv(plane)
    points = corners_in_world[ids]
    axes = along @ (points - points.mean(0))
    size = np.linalg.norm(axes, axis=1)
    pulls = np.einsum("an,niu->aiu", along, moves[ids])
    growth = np.einsum("ai,aiu->au", axes / size[:, None] ** 2, pulls)
    return (size[0] / size[1]) * (growth[0] - growth[1])


def corners_shown(detections: BoardDetections) -> dict[str, Int32[np.ndarray, " k"]]:
    """By photo, the board's corners that it shows."""
    return {one.name: one.ids for one in detections.photos}


def points_by_cameras(
    scene: Scene,
    shown: Mapping[str, Int[np.ndarray, " k"]],
    points: Points3,
    least: int = LEAST_OBSERVATIONS,
) -> tuple[Float64[np.ndarray, "n 3 u"], Int64[np.ndarray, " n"]]:
    """Jacobian of each triangulated point by poses and lenses, and its number of observations.

    Args:
        shown: By photo, the rows of the points that it shows.
        least: Observations of a point that moves.
    """
    placed = scene.placed
    lenses = POSE_SIZE * len(placed)
    unknowns = lenses + LENS_SIZE * scene.lenses
    normal = np.zeros((len(points), 3, 3))
    right = np.zeros((len(points), 3, unknowns))
    seen = np.zeros(len(points), np.int64)
    place = {scene.names[photo]: k for k, photo in enumerate(placed)}
    lens_idx = scene.lens_idx
    for name, ids in shown.items():
        if name not in place:
            continue
        k = place[name]
        by_point, by_pose = np.zeros((len(ids), 2, 3)), np.zeros((len(ids), 2, POSE_SIZE))
        by_lens = np.zeros((len(ids), 2, LENS_SIZE))
        view = scene.view(placed[k]).packed
        differentiate_all(view, np.ascontiguousarray(points[ids]), by_point, by_pose, by_lens)
        lens = lenses + LENS_SIZE * lens_idx[k]
        normal[ids] += np.einsum("nai,naj->nij", by_point, by_point)
        right[ids, :, POSE_SIZE * k : POSE_SIZE * (k + 1)] += np.einsum(
            "nai,nap->nip", by_point, by_pose
        )
        right[ids, :, lens : lens + LENS_SIZE] += np.einsum("nai,nap->nip", by_point, by_lens)
        seen[ids] += 1
    enough = seen >= least
    normal[~enough] = np.eye(3)
    return -np.linalg.solve(normal, right), seen
