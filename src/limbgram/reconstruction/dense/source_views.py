"""Source views: view selection for each reference photo's depth map.

A source is good where it sees the same part of the limb, from an angle wide enough to tell
depth and narrow enough to look alike, at a similar scale. Sources are chosen one after the
other, each for what the ones before it leave thinly covered: so both sides of a photo get one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import View
from limbgram.core.run import track
from limbgram.reconstruction.dense.region import Region
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.visibility import in_frame

_UNOBSERVED_WEIGHT = 0.3
"""Weight of a point that a photo should see, but in which no feature of it was matched."""
_FACING_DEG = 65.0
"""A point faces a photo that lies within this angle of the mean direction to its observers."""
_LEAST_GAIN = 0.1
"""A source must add this share of what the first one gave,"""
_FIRST_SOURCES = 2
"""but the first two only have to add something."""


_LEAST_ANGLE_DEG = 2.0
"""Below this angle depth is not determined."""
_GOOD_ANGLES_DEG = (5.0, 20.0)
"""Between these angles all count alike; outside they count less."""


@dataclass(frozen=True, kw_only=True)
class SourceViewOptions:
    """How many source views, and at which angles between the rays."""

    most: int = 6
    most_angle_deg: float = 45.0
    """Above this angle the surface looks too different."""


DEFAULTS = SourceViewOptions()


def select_source_views(
    metric: MetricScene, region: Region, options: SourceViewOptions = DEFAULTS
) -> tuple[tuple[int, ...], ...]:
    """Source views of each photo of the scene, best first, as indices into `Scene.names`.

    Empty for a photo that is not placed or has no other photo at a useful angle.
    """
    scene = metric.scene
    in_region = region.contains(scene.points_in_world)
    rows = in_region[scene.observations.point_idx]
    observed = np.zeros((len(scene.names), len(in_region)), bool)
    observed[scene.observations.photo_idx[rows], scene.observations.point_idx[rows]] = True
    observed = observed[list(scene.placed)][:, in_region]
    points = scene.points_in_world[in_region]

    directions = np.array([_unit(view.centre_in_world - points) for view in scene.views])
    scales = np.array([_pixels_per_mm(view, points) for view in scene.views])
    visibility = _visibility_weights(scene.views, points, directions, observed)
    sources: list[tuple[int, ...]] = [()] * len(scene.names)
    for row, photo_idx in enumerate(track(scene.placed)):
        seen = observed[row]
        gains = visibility[:, seen] * _angle_weights(row, directions[:, seen], options)
        gains *= _scale_similarity(row, scales[:, seen])
        gains[row] = 0.0
        chosen = _select_greedily(gains, min(options.most, len(gains) - 1))
        sources[photo_idx] = tuple(scene.placed[k] for k in chosen)
    return tuple(sources)


def _visibility_weights(
    views: Sequence[View],
    points: Points3,
    directions: Float64[np.ndarray, "v n 3"],
    observed: Bool[np.ndarray, "v n"],
) -> Float64[np.ndarray, "v n"]:
    """Weight of each point in each view: 1 observed, less where it only faces the view."""
    facing = _unit(np.einsum("vn,vnk->nk", observed.astype(float), directions))
    turned = np.einsum("vnk,nk->vn", directions, facing)
    seen = in_frame(views, points) & (turned > np.cos(np.radians(_FACING_DEG)))
    return np.where(observed, 1.0, np.where(seen, _UNOBSERVED_WEIGHT, 0.0))


def _angle_weights(
    reference: int, directions: Float64[np.ndarray, "v n 3"], options: SourceViewOptions
) -> Float64[np.ndarray, "v n"]:
    """1 at good angles between a point's rays to the reference and to each view, falling to 0 at
    the limits."""
    cosine = np.einsum("vnk,nk->vn", directions, directions[reference])
    angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    low, high = _GOOD_ANGLES_DEG
    narrow = np.clip((angle - _LEAST_ANGLE_DEG) / (low - _LEAST_ANGLE_DEG), 0, 1)
    wide = np.clip((options.most_angle_deg - angle) / (options.most_angle_deg - high), 0, 1)
    return narrow * wide


def _scale_similarity(
    reference: int, scales: Float64[np.ndarray, "v n"]
) -> Float64[np.ndarray, "v n"]:
    """Ratio of the image scales of reference and view, at most 1."""
    return np.minimum(scales, scales[reference]) / np.maximum(scales, scales[reference])


def _pixels_per_mm(view: View, points: Points3) -> Float64[np.ndarray, " n"]:
    return view.camera.fx / np.maximum(view.camera_from_world.apply(points)[:, 2], 1e-9)


def _select_greedily(gains: Float64[np.ndarray, "v n"], most: int) -> list[int]:
    """Rows of the best sources, chosen greedily by what each adds."""
    covered = np.zeros(gains.shape[1])
    chosen: list[int] = []
    first = 0.0
    while len(chosen) < most:
        totals = (gains / (1.0 + covered)).sum(1)
        totals[chosen] = 0.0
        best = int(np.argmax(totals))
        first = first or float(totals[best])
        least = _LEAST_GAIN * first if len(chosen) >= _FIRST_SOURCES else 0.0
        if totals[best] <= least:
            break
        chosen.append(best)
        covered += gains[best]
    return chosen


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30)
