"""Matches: which keypoint of one photo is which keypoint of another."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64, Int32


@dataclass(frozen=True, kw_only=True)
class PairMatches:
    """Matches between photo `first` and photo `second` (indices into PhotoSet.photos).

    `xy_first_px` are the keypoints of the first photo; `xy_second_px` those of the second, moved
    to sub-pixel agreement with the first by least-squares window matching where that was done.
    """

    first: int
    second: int
    keypoint_idx: Int32[np.ndarray, "m 2"]
    xy_first_px: Float64[np.ndarray, "m 2"]
    xy_second_px: Float64[np.ndarray, "m 2"]
    correlation: Float32[np.ndarray, " m"]
    """Normalized cross-correlation of the windows after refinement; NaN where not correlated."""

    def __len__(self) -> int:
        return len(self.keypoint_idx)


@dataclass(frozen=True, kw_only=True)
class Matches:
    """Matches of all pairs that were tried, and how many each test let through."""

    pairs: tuple[PairMatches, ...]
    pairs_tried: int
    descriptor_matches: int
    """Matches that passed ratio and mutual tests, before window correlation."""
