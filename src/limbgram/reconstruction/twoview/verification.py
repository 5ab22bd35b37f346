"""Geometric verification: the epipolar geometry of each pair, and its inlier matches.

In      matches, and the cameras with their lenses.
Out     verified pairs with F (Gold Standard), relative pose, kind and residuals.
Method  RANSAC in pixels freed of lens distortion, by five matches and the
        relative pose where a board calibrated both cameras, by F where EXIF had to do; pose by
        cheirality; plane and rotation tests; Gold Standard F on the inliers.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool

from limbgram.core.geometry.arrays import Matrix3, Points2
from limbgram.core.geometry.frames import Rigid
from limbgram.core.run import in_parallel
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.matching.matching import Matches, PairMatches
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.twoview.essential import (
    RobustEssential,
    essential_from_fundamental,
    estimate_essential,
    estimate_homography,
    fundamental_from_pose,
    in_front,
    pose_from_essential,
    poses_from_homography,
    rotation_share,
    to_normalized,
    undistorted,
)
from limbgram.reconstruction.twoview.fundamental import (
    estimate_fundamental,
    refine_fundamental_gold_standard,
)
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

_THRESHOLD_EXIF_PX = 3.0
"""Largest Sampson distance of an inlier where the lens distortion is unknown."""
_SEED = 0
"""Of the random samples."""
_MIN_INLIERS = 20
"""Fewest matches that must agree."""
_MIN_INLIER_SHARE = 0.3
"""Smallest part of the matches that must agree.

In limb_ring15 every pair whose rotation was over 6 degrees wrong had 0.15 to 0.32, and all
but 4 of the right ones over 0.35.
"""
_DEGENERATE_SHARE = 0.9
"""Share of the inliers from which a homography or a rotation counts as degenerate."""
_THRESHOLD_PX = 1.5
"""Largest Sampson distance of an inlier between photos of calibrated cameras."""


def verify(photos: PhotoSet, matches: Matches, cameras: Cameras) -> Pairs:
    """Keep the matches of every pair that share one epipolar geometry."""

    def one(pair: PairMatches) -> VerifiedPair | None:
        first = cameras.calibrations[photos.photos[pair.first].camera_idx]
        second = cameras.calibrations[photos.photos[pair.second].camera_idx]
        return verify_pair(pair, first, second)

    verified = [pair for pair in in_parallel(one, matches.pairs) if pair is not None]
    return Pairs(tuple(verified), matches.pairs_tried - len(verified))


def verify_pair(
    matches: PairMatches,
    first: Calibration,
    second: Calibration,
) -> VerifiedPair | None:
    """Verify one pair; None where too few matches are inliers."""
    pair = _UndistortedMatches.of(matches, first, second)
    finite = np.isfinite(np.hstack([pair.xy_first, pair.xy_second]))
    known: Bool[np.ndarray, " m"] = np.logical_and.reduce(finite, axis=1)
    matches, pair = matches.some(known), pair.chosen(known)
    fit = _fit(pair)
    fewest = max(_MIN_INLIERS, round(_MIN_INLIER_SHARE * len(matches)))
    if fit is None or fit.inliers.sum() < fewest:
        return None
    pair = pair.chosen(fit.inliers)
    motion = _motion(pair, fit)
    pose = motion.pose
    front = np.ones(len(pair.xy_first), bool) if pose is None else in_front(pose, *pair.ideal)
    if front.sum() < fewest:
        return None
    pair = pair.chosen(front)
    gold = refine_fundamental_gold_standard(fit.fundamental, pair.xy_first, pair.xy_second)
    return VerifiedPair(
        matches=matches.some(fit.inliers).some(front),
        fundamental=gold.fundamental,
        second_from_first=pose,
        kind=motion.kind,
        residual_px=gold.residual_px,
        median_angle_deg=0.0 if pose is None else _median_angle_deg(pose, *pair.ideal),
    )


@dataclass(frozen=True, kw_only=True)
class _UndistortedMatches:
    """Matches of a pair in pixels freed of lens distortion."""

    xy_first: Points2
    xy_second: Points2
    first_matrix: Matrix3
    second_matrix: Matrix3
    calibrated: bool

    @classmethod
    def of(
        cls, matches: PairMatches, first: Calibration, second: Calibration
    ) -> "_UndistortedMatches":
        return cls(
            xy_first=undistorted(first.camera, matches.xy_first_px),
            xy_second=undistorted(second.camera, matches.xy_second_px),
            first_matrix=first.camera.matrix,
            second_matrix=second.camera.matrix,
            calibrated=first.source == "board" and second.source == "board",
        )

    def chosen(self, keep: Bool[np.ndarray, " n"]) -> "_UndistortedMatches":
        return replace(self, xy_first=self.xy_first[keep], xy_second=self.xy_second[keep])

    @property
    def ideal(self) -> tuple[Points2, Points2]:
        first = to_normalized(self.first_matrix, self.xy_first)
        return first, to_normalized(self.second_matrix, self.xy_second)

    @property
    def threshold_px(self) -> float:
        return _THRESHOLD_PX if self.calibrated else _THRESHOLD_EXIF_PX


@dataclass(frozen=True)
class _RobustGeometry:
    """The result of RANSAC; the pose is None where only F was estimated."""

    fundamental: Matrix3
    pose: Rigid | None
    inliers: Bool[np.ndarray, " n"]


def _fit(pair: _UndistortedMatches) -> _RobustGeometry | None:
    """Robust essential matrix of calibrated cameras, or fundamental matrix of others."""
    threshold_px = pair.threshold_px
    if not pair.calibrated:
        robust = estimate_fundamental(
            pair.xy_first, pair.xy_second, threshold_px=threshold_px, seed=_SEED
        )
        if robust.fundamental is None:
            return None
        return _RobustGeometry(robust.fundamental, None, robust.inliers)
    found = _essential(pair)
    if found.second_from_first is None:
        return None
    fundamental = fundamental_from_pose(
        found.second_from_first, pair.first_matrix, pair.second_matrix
    )
    return _RobustGeometry(fundamental, found.second_from_first, found.inliers)


@dataclass(frozen=True)
class _RelativeMotion:
    """Kind of a pair, and its relative pose where there is one."""

    kind: Literal["general", "planar", "rotation"]
    pose: Rigid | None


def _motion(pair: _UndistortedMatches, fit: _RobustGeometry) -> _RelativeMotion:
    """Classify a pair as general, planar or pure rotation, and find its pose."""
    threshold_px = pair.threshold_px
    plane = estimate_homography(
        pair.xy_first, pair.xy_second, threshold_px=threshold_px, seed=_SEED
    )
    if plane.share < _DEGENERATE_SHARE:
        return _RelativeMotion("general", _pose(pair, fit))
    turned = rotation_share(*pair.ideal, pair.second_matrix, threshold_px=threshold_px)
    if turned >= _DEGENERATE_SHARE:
        return _RelativeMotion("rotation", None)
    poses = poses_from_homography(plane.matrix, pair.first_matrix, pair.second_matrix)
    best = max(poses, key=lambda pose: in_front(pose, *pair.ideal).sum(), default=None)
    return _RelativeMotion("planar", best)


def _pose(pair: _UndistortedMatches, fit: _RobustGeometry) -> Rigid:
    """The pose that RANSAC found, or else the one from F and K."""
    if fit.pose is not None:
        return fit.pose
    essential = essential_from_fundamental(fit.fundamental, pair.first_matrix, pair.second_matrix)
    return pose_from_essential(essential, *pair.ideal).second_from_first


def _essential(pair: _UndistortedMatches) -> RobustEssential:
    return estimate_essential(
        pair.xy_first,
        pair.xy_second,
        pair.first_matrix,
        pair.second_matrix,
        threshold_px=pair.threshold_px,
        seed=_SEED,
    )


def _median_angle_deg(pose: Rigid, ideal_first: Points2, ideal_second: Points2) -> float:
    """Median triangulation angle of the matches."""
    ones = np.ones((len(ideal_first), 1))
    first = np.hstack([ideal_first, ones]) @ pose.rotation.T
    second = np.hstack([ideal_second, ones])
    across = np.linalg.norm(np.cross(first, second), axis=1)
    return float(np.degrees(np.median(np.arctan2(across, (first * second).sum(1)))))
