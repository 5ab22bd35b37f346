"""Verified pairs: the epipolar geometry of two photos and the matches that obey it."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64

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


@dataclass(frozen=True)
class Pairs:
    """All verified pairs, and the number of tried ones that had no common geometry."""

    verified: tuple[VerifiedPair, ...]
    rejected: int
