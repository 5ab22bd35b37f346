"""Window correlation: matched points moved to sub-pixel agreement, false ones dropped.

The window round the first keypoint is compared with the second photo through a local affine map,
which starts as the similarity between the two keypoints (their scales and orientations) and is
improved by least-squares matching with gain and offset (Grün 1985), in its inverse compositional
form (Baker and Matthews 2004): the normal matrix belongs to the first window and is computed once.

Windows are sampled with the cubic B-spline, which smooths both photos alike. Each keypoint is
looked at in the pyramid level that suits its scale.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int32

from limbgram.features import Keypoints
from limbgram.matching.leastsquares import correlate_all
from limbgram.matching.pyramid import Pyramid


@dataclass(frozen=True, kw_only=True)
class WindowOptions:
    """Which windows count as the same place."""

    min_correlation: float = 0.8
    """Normalized cross-correlation after refinement."""
    max_shift: float = 3.0
    """Farthest accepted move, in pixels of the level compared."""


@dataclass(frozen=True, kw_only=True)
class Correlated:
    """Refined places in the second photo, and which matches to keep."""

    xy_second_px: Float64[np.ndarray, "m 2"]
    correlation: Float32[np.ndarray, " m"]
    kept: Bool[np.ndarray, " m"]


def correlate(
    first: Pyramid,
    second: Pyramid,
    keypoints_first: Keypoints,
    keypoints_second: Keypoints,
    keypoint_idx: Int32[np.ndarray, "m 2"],
    options: WindowOptions,
) -> Correlated:
    """Move the second point of each match to where its window agrees with the first's."""
    rows_first = _rows(keypoints_first, keypoint_idx[:, 0])
    rows_second = _rows(keypoints_second, keypoint_idx[:, 1])
    result = np.empty((len(keypoint_idx), 3))
    correlate_all(
        first.pixels,
        first.layout,
        second.pixels,
        second.layout,
        rows_first,
        rows_second,
        options.max_shift,
        result,
    )
    with np.errstate(invalid="ignore"):
        kept = result[:, 2] >= options.min_correlation
    return Correlated(
        xy_second_px=np.ascontiguousarray(result[:, :2]),
        correlation=result[:, 2].astype(np.float32),
        kept=kept,
    )


def _rows(keypoints: Keypoints, which: Int32[np.ndarray, " m"]) -> Float64[np.ndarray, "m 4"]:
    """x, y, scale, angle in radians."""
    return np.column_stack(
        [
            keypoints.xy_px[which],
            keypoints.scale_px[which],
            np.radians(keypoints.angle_deg[which]),
        ]
    ).astype(np.float64)
