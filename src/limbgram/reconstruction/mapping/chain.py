"""The classical chain: pair by pair, each projection matrix from the previous one.

The published method, kept for teaching and comparison; `place` is what measures. Photo 0 is the
world; photo 1 comes from F and K; points from photos i - 1 and i, seen again in photo i + 1, give
its projection matrix by resection (DLT, then Gauss-Newton on pixels). Nothing closes the ring, so
errors add up along it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float64, Int32

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.geometry.triangulation import triangulate
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

_FEWEST_POINTS = 6
LARGEST_MISS_PX = 3.0


@dataclass(frozen=True)
class Chain:
    """Views in the order of the photos, and the points of every neighbouring pair."""

    views: tuple[View, ...]
    points_in_world: tuple[Points3, ...]


def chain(photos: PhotoSet, pairs: Pairs, cameras: Cameras) -> Chain:
    """Place photos one after the other; each must match the next (PlacementError)."""
    lenses = [cameras.calibrations[photo.camera_idx].camera for photo in photos.photos]
    links = [_link(pairs, photos.names, idx) for idx in range(len(lenses) - 1)]
    start = links[0].second_from_first
    if start is None:
        raise PlacementError("placing.one_spot", first=photos.names[0], second=photos.names[1])
    views = [View(photos.names[0], lenses[0], Rigid.identity())]
    views.append(View(photos.names[1], lenses[1], start))
    points = [_pair_points(views[0], views[1], links[0])]
    for idx in range(2, len(lenses)):
        before, link = links[idx - 2], links[idx - 1]
        in_before, in_link = before.matches.keypoint_idx[:, 1], link.matches.keypoint_idx[:, 0]
        known, seen = np.intersect1d(in_before, in_link, return_indices=True)[1:]
        usable = np.isfinite(points[-1][known]).all(1)
        pose = resect(
            lenses[idx], points[-1][known][usable], link.matches.xy_second_px[seen][usable]
        )
        if pose is None:
            raise PlacementError(
                "placing.chain_weak", points=int(usable.sum()), photo=photos.names[idx]
            )
        views.append(View(photos.names[idx], lenses[idx], pose))
        points.append(_pair_points(views[-2], views[-1], link))
    return Chain(tuple(views), tuple(points))


def resect(lens: Camera, points_in_world: Points3, xy_px: Points2) -> Rigid | None:
    """camera_from_world of known points' images: six by DLT among wrong ones, then all good ones.

    None where too few of them agree.
    """
    if len(points_in_world) < _FEWEST_POINTS:
        return None
    ideal = lens.normalize(xy_px)
    found, turn, shift, inliers = cv2.solvePnPRansac(
        points_in_world,
        ideal,
        np.eye(3),
        np.zeros(5),
        reprojectionError=LARGEST_MISS_PX / lens.fx,
        iterationsCount=1000,
        confidence=0.9999,
    )
    if not found or len(inliers) < _FEWEST_POINTS:
        return None
    good: Int32[np.ndarray, " k"] = np.asarray(inliers, np.int32).ravel()
    turn, shift = cv2.solvePnPRefineLM(
        points_in_world[good], ideal[good], np.eye(3), np.zeros(5), turn, shift
    )
    return Rigid.from_rotation_vector(np.asarray(turn, float).ravel(), shift.ravel())


def _link(pairs: Pairs, names: Sequence[str], first: int) -> VerifiedPair:
    for pair in pairs.verified:
        if (pair.matches.first, pair.matches.second) == (first, first + 1):
            return pair
    raise PlacementError("placing.chain_broken", first=names[first], second=names[first + 1])


def _pair_points(first: View, second: View, link: VerifiedPair) -> Points3:
    count = len(link.matches)
    view_idx: Int32[np.ndarray, " m"] = np.repeat(np.arange(2, dtype=np.int32), count)
    point_idx: Int32[np.ndarray, " m"] = np.tile(np.arange(count, dtype=np.int32), 2)
    xy_px: Float64[np.ndarray, "m 2"] = np.vstack(
        [link.matches.xy_first_px, link.matches.xy_second_px]
    )
    found = triangulate((first, second), view_idx, point_idx, xy_px, count)
    wrong = ~(found.rms_px < LARGEST_MISS_PX)
    return np.where(wrong[:, None], np.nan, found.points_in_world)
