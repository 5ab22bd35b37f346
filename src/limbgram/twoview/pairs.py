"""Verified pairs: the epipolar geometry of two photos and the matches that obey it."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.geometry.arrays import Matrix3
from limbgram.geometry.rigid import Rigid
from limbgram.matching.matches import PairMatches


@dataclass(frozen=True, kw_only=True)
class VerifiedPair:
    """Two photos whose matches share one epipolar geometry.

    `fundamental` obeys x2^T F x1 = 0 in pixels freed of lens distortion (ideal pixels: K times
    normalized coordinates). `second_from_first` has a translation of unit length; it is None
    where the pair is a pure rotation, and one of two possible poses where it shows a plane.
    """

    matches: PairMatches
    """Only the inliers."""
    fundamental: Matrix3
    second_from_first: Rigid | None
    kind: Literal["general", "planar", "rotation"]
    residual_px: Float64[np.ndarray, " m"]
    """Per match: sqrt((d(x, x^)^2 + d(x', x'^)^2) / 4), the paper's residual of one point."""
    median_angle_deg: float
    """Median intersection angle of the rays."""

    @property
    def rms_residual_px(self) -> float:
        """The paper's residual error function over all inliers."""
        return float(np.sqrt(np.mean(self.residual_px**2)))

    def chosen(self, keep: Bool[np.ndarray, " m"]) -> "VerifiedPair":
        """The pair with some of its matches."""
        return replace(
            self, matches=some_of(self.matches, keep), residual_px=self.residual_px[keep]
        )


def some_of(matches: PairMatches, keep: Bool[np.ndarray, " m"]) -> PairMatches:
    """Some of the matches, in their order."""
    return replace(
        matches,
        keypoint_idx=matches.keypoint_idx[keep],
        xy_first_px=matches.xy_first_px[keep],
        xy_second_px=matches.xy_second_px[keep],
        correlation=matches.correlation[keep],
    )


@dataclass(frozen=True)
class Pairs:
    """All verified pairs, and the number of tried ones that had no common geometry."""

    verified: tuple[VerifiedPair, ...]
    rejected: int
