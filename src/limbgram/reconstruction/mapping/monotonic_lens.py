"""Monotonic lens: keeps the distortion of an uncalibrated lens monotonic out to the corners.

Points in the middle of the photos tell little of the corners: a fraction of a pixel there can bend
an adjusted lens so far that its corners have no ray, or that two rays share a place. No lens does
that. So places in the picture go on parting as their rays do, by some share, out to its corners.

A step that ends with less crosses a wall somewhere on its way. It is solved again with one equation
more, which holds the lens to that wall where it was met: the slope of the ray that ends in the
corner, or of the one at which the lens turns back far within the picture.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.lens import DISTORTION, LENS_SIZE, RADIAL, fold_of

Lens = Float64[np.ndarray, " lens"]

_LEAST_SLOPE = 0.25
"""Of places in the picture over their rays. A fisheye lens that shows equal angles as equal
distances has so little at 60 degrees from its axis, far beyond what this model describes."""
_SIGMA = 1e-6
"""Standard deviation of a slope that is held."""
_SLACK = 1e-3
"""A lens that lacks so little of its corner, in focal lengths, stands at the wall."""
_HALVINGS = 40
_POWERS = np.array([float(one.power) for one in DISTORTION.values() if one.radial])


@dataclass(frozen=True)
class Held:
    """How far a lens is behind a wall, with the derivatives of that."""

    far: float
    slopes: Float64[np.ndarray, " l"]

    @property
    def information(self) -> Float64[np.ndarray, "l l"]:
        return np.outer(self.slopes, self.slopes) / _SIGMA**2

    @property
    def right(self) -> Float64[np.ndarray, " l"]:
        return -self.far * self.slopes / _SIGMA**2


@dataclass(frozen=True)
class Pictures:
    """The pictures that lenses must show, and which lens parameters may move to that end."""

    sizes_px: tuple[tuple[int, int] | None, ...]
    """Width and height; None where a board calibrated the lens."""
    free: Bool[np.ndarray, " l"]

    def cost(self, lenses: Float64[np.ndarray, " l"]) -> float:
        """Of what the lenses do not show, in squares of sigma."""
        lacking = [
            max(_lacking(lens, size_px) - _SLACK, 0.0)
            for lens, size_px in zip(lenses.reshape(-1, LENS_SIZE), self.sizes_px, strict=True)
            if size_px is not None
        ]
        return float(np.sum(np.square(lacking))) / _SIGMA**2

    def walls(
        self, lenses: Float64[np.ndarray, " l"], step: Float64[np.ndarray, " l"]
    ) -> list[Held]:
        """Those that a step would cross."""
        found: list[Held] = []
        now, after = lenses.reshape(-1, LENS_SIZE), (lenses + step).reshape(-1, LENS_SIZE)
        for idx, size_px in enumerate(self.sizes_px):
            if size_px is None or not _lacking(after[idx], size_px) > 0.0:
                continue
            met, every = _met(now[idx], after[idx], size_px), np.zeros_like(now)
            every[idx] = _behind(met, size_px)
            slopes = np.where(self.free, every.ravel(), 0.0)
            if slopes.any():
                found.append(Held(float(every[idx] @ (now[idx] - met)), slopes))
        return found


def _met(now: Lens, after: Lens, size_px: tuple[int, int]) -> Lens:
    """The lens where the way to another one first crosses a wall."""
    start = now
    if _lacking(now, size_px) > _SLACK:
        start = now.copy()
        start[RADIAL] = 0.0
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if _lacking(start + middle * (after - start), size_px) > 0.0:
            high = middle
        else:
            low = middle
    return start + high * (after - start)


def _behind(met: Lens, size_px: tuple[int, int]) -> Lens:
    """Derivatives of how far a lens is behind the wall that this one stands at."""
    ray = fold_of(*met[RADIAL], slope=_LEAST_SLOPE)
    powers, slopes = ray**_POWERS, np.zeros(LENS_SIZE)
    slopes[RADIAL] = -(_POWERS + 1) * powers
    if _lacking(met, size_px) > _SLACK:  # it turns back at once
        return slopes
    # the corner's own ray moves with the lens
    bend = float((_POWERS * (_POWERS + 1) * powers / ray) @ met[RADIAL]) / _LEAST_SLOPE
    x, y = _corner(met, size_px)
    corner = float(np.hypot(x, y))
    slopes[RADIAL] += bend * ray * powers
    slopes[:2] = bend * x * x / (met[0] * corner), bend * y * y / (met[1] * corner)
    return slopes


def _lacking(lens: Lens, size_px: tuple[int, int]) -> float:
    """How much farther from its axis a lens would have to show, in focal lengths."""
    ray = fold_of(*lens[RADIAL], slope=_LEAST_SLOPE)
    if np.isinf(ray):
        return -np.inf
    farthest = ray * (1.0 + float(ray**_POWERS @ lens[RADIAL]))
    return float(np.hypot(*_corner(lens, size_px))) - farthest


def _corner(lens: Lens, size_px: tuple[int, int]) -> tuple[float, float]:
    """The corner that is farthest from the axis, in focal lengths."""
    fx, fy, cx, cy = lens[:4].tolist()
    return max(cx, size_px[0] - 1 - cx) / fx, max(cy, size_px[1] - 1 - cy) / fy
