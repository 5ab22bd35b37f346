"""Monotonic lens: keeps the distortion of an uncalibrated lens monotonic out to the corners.

Points in the middle of the photos tell little of the corners: a fraction of a pixel there can bend
an adjusted lens so far that its corners have no ray, or that two rays share a place. No lens does
that. So the radial mapping keeps a slope of at least `_LEAST_SLOPE` out to the corners.

A step that ends with less crosses the boundary of that constraint. It is solved again with one
equation more, which holds the lens at the boundary where it was crossed (active set): the slope at
the corner's ray, or at the ray where the lens turns back far within the picture.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.lens import DISTORTION, LENS_SIZE, RADIAL, fold_radius

Lens = Float64[np.ndarray, " lens"]

_LEAST_SLOPE = 0.25
"""Slope of distorted over undistorted radius. A fisheye lens that shows equal angles as equal
distances has so little at 60 degrees from its axis, far beyond what this model describes."""
_SIGMA = 1e-6
"""Standard deviation of an active constraint."""
_TOLERANCE = 1e-3
"""A lens that violates the constraint by so little, in focal lengths, lies on the boundary."""
_BISECTIONS = 40
_POWERS = np.array([float(one.power) for one in DISTORTION.values() if one.radial])


@dataclass(frozen=True)
class LinearConstraint:
    """Violation of a constraint, linearised in the parameters of all lenses."""

    violation: float
    gradient: Float64[np.ndarray, " l"]

    @property
    def information(self) -> Float64[np.ndarray, "l l"]:
        """What it adds to the normal matrix."""
        return np.outer(self.gradient, self.gradient) / _SIGMA**2

    @property
    def right(self) -> Float64[np.ndarray, " l"]:
        """What it adds to the right-hand side."""
        return -self.violation * self.gradient / _SIGMA**2


@dataclass(frozen=True)
class MonotonicityConstraints:
    """That each uncalibrated lens is monotonic over its whole picture."""

    sizes_px: tuple[tuple[int, int] | None, ...]
    """Width and height of each lens's picture; None where a board calibrated the lens."""
    free: Bool[np.ndarray, " l"]
    """Which parameters of the lenses may move."""

    def cost(self, lenses: Float64[np.ndarray, " l"]) -> float:
        """Penalty of the lenses that violate their constraint, in squares of sigma."""
        violations = [
            max(_violation(lens, size_px) - _TOLERANCE, 0.0)
            for lens, size_px in zip(lenses.reshape(-1, LENS_SIZE), self.sizes_px, strict=True)
            if size_px is not None
        ]
        return float(np.sum(np.square(violations))) / _SIGMA**2

    def violated_by(
        self, lenses: Float64[np.ndarray, " l"], step: Float64[np.ndarray, " l"]
    ) -> list[LinearConstraint]:
        """The constraints that a step would violate, linearised on their boundary."""
        found: list[LinearConstraint] = []
        before, after = lenses.reshape(-1, LENS_SIZE), (lenses + step).reshape(-1, LENS_SIZE)
        for idx, size_px in enumerate(self.sizes_px):
            if size_px is None or not _violation(after[idx], size_px) > 0.0:
                continue
            boundary = _boundary_lens(before[idx], after[idx], size_px)
            gradients = np.zeros_like(before)
            gradients[idx] = _violation_gradient(boundary, size_px)
            gradient = np.where(self.free, gradients.ravel(), 0.0)
            if gradient.any():
                violation = float(gradients[idx] @ (before[idx] - boundary))
                found.append(LinearConstraint(violation, gradient))
        return found


def _boundary_lens(before: Lens, after: Lens, size_px: tuple[int, int]) -> Lens:
    """The lens at which the way from one to another first leaves the feasible region."""
    start = before
    if _violation(before, size_px) > _TOLERANCE:
        start = before.copy()
        start[RADIAL] = 0.0
    low, high = 0.0, 1.0
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        if _violation(start + middle * (after - start), size_px) > 0.0:
            high = middle
        else:
            low = middle
    return start + high * (after - start)


def _violation_gradient(boundary: Lens, size_px: tuple[int, int]) -> Lens:
    """Gradient of the violation at a lens on the boundary.

    Without the principal point's part: it changes its sign where two corners are equally far, as
    nearly all lenses have them, and steps by it go to and fro there without an end. Left out, it
    moves a principal point that is 40 px beside the middle by a tenth of its prior sigma.
    """
    ray = fold_radius(*boundary[RADIAL], slope=_LEAST_SLOPE)
    powers, gradient = ray**_POWERS, np.zeros(LENS_SIZE)
    gradient[RADIAL] = -(_POWERS + 1) * powers
    if _violation(boundary, size_px) > _TOLERANCE:  # it turns back far within the picture
        return gradient
    # the corner's own ray moves with the lens
    bend = float((_POWERS * (_POWERS + 1) * powers / ray) @ boundary[RADIAL]) / _LEAST_SLOPE
    x, y = _farthest_corner(boundary, size_px)
    corner = float(np.hypot(x, y))
    gradient[RADIAL] += bend * ray * powers
    gradient[:2] = bend * x * x / (boundary[0] * corner), bend * y * y / (boundary[1] * corner)
    return gradient


def _violation(lens: Lens, size_px: tuple[int, int]) -> float:
    """By how much the corner lies beyond where the slope is sufficient, in focal lengths."""
    ray = fold_radius(*lens[RADIAL], slope=_LEAST_SLOPE)
    if np.isinf(ray):
        return -np.inf
    farthest = ray * (1.0 + float(ray**_POWERS @ lens[RADIAL]))
    return float(np.hypot(*_farthest_corner(lens, size_px))) - farthest


def _farthest_corner(lens: Lens, size_px: tuple[int, int]) -> tuple[float, float]:
    """The corner that is farthest from the axis, in focal lengths."""
    fx, fy, cx, cy = lens[:4].tolist()
    return max(cx, size_px[0] - 1 - cx) / fx, max(cy, size_px[1] - 1 - cy) / fy
