"""Polylines: distances along them, and points at equal distances."""

import numpy as np
from jaxtyping import Float64


def distances_along(points: Float64[np.ndarray, "n d"]) -> Float64[np.ndarray, " n"]:
    """Distance of each point from the first, along the polyline."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def resampled(points: Float64[np.ndarray, "n d"], count: int) -> Float64[np.ndarray, "m d"]:
    """Points at equal distances along a polyline, its ends among them."""
    along = distances_along(points)
    wanted = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(wanted, along, axis) for axis in points.T], axis=1)
