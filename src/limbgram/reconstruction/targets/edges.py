"""Edges: the sides of a dark square to hundredths of a pixel, on flat and on bent paper.

In      linear light of a photo, the four corners to a pixel or two, the code inside, and the lens.
Out     the four corners, each the crossing of two fitted sides, and how well the sides fit.
Method  Pixels are taken to where a lens without distortion would have them. A side's profile is
        l(t, n) = a0 + a1 t + (h0 + h1 t) erf((n - c - m t - k t^2) / s sqrt 2), t along the side
        from -1 to 1 and n across it in pixels: a line (c, m), its bend k, its blur s, and light
        that changes along the side, fitted by Levenberg and Marquardt to all pixels of a band
        that keeps clear of corners and, as far as it can, of the code. What light the code's
        white cells still spill over the black border is known from the code, and taken off.
        Straight sides stay straight under such a lens, so a bend that is surely there means bent
        paper, and only then k is kept: it costs a corner two to three times the noise.
Limits  Light must be linear. A tone curve moves all four sides outwards or inwards alike, which
        moves corners along the diagonals and leaves the crossing of the diagonals where it is.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float32, Float64, UInt8
from scipy.special import erf

from limbgram.core.geometry.arrays import GreyImage, Points2
from limbgram.core.geometry.lens import Camera
from limbgram.core.optimisation import Descent, Trial, minimise
from limbgram.reconstruction.photos.decoding import LINEAR_OF_SRGB

Code = UInt8[np.ndarray, "c c"]
_LINEAR_OF_LUMA: Float32[np.ndarray, "256"] = (255 * LINEAR_OF_SRGB).astype(np.float32)
_MAX_ROUNDS = 4
_CONVERGED_PX = 0.02
_FIRST_BLUR_PX = 0.8
_LEAST_BLUR_PX, _MOST_BLUR_PX = 0.15, 12.0
_CODE_CLEARANCE_BLURS = 2.0
"""Distance, in blurs, that the band keeps from the code's cells."""
_CORNER_CLEARANCE_BLURS, _CORNER_CLEARANCE_PX = 2.5, 1.2
"""Distance, in blurs and in pixels at least, that the band keeps from the next side."""
_MOST_REACH_PX = 5.0
_LEAST_PIXELS = 24
_BEND, _BLUR = 2, 3
"""Places among a band's unknowns."""
_BEND_CHI2 = 18.5
"""Sum over four bends: one flat mark in a thousand has more."""
_LEAST_BEND_SIGMA_PX = 0.02
"""Least sigma of a bend: sampling and rounding to 8 bits bend the sides of the best photo by it."""
_DESCENT = Descent(iterations=25, smallest_gain=1e-7, least_gain=1e-12)


@dataclass(frozen=True, kw_only=True)
class SquareFit:
    """A dark square from its four fitted sides."""

    corners_px: Float64[np.ndarray, "4 2"]
    centre_px: Float64[np.ndarray, "2"]
    """Where the diagonals cross, which perspective keeps."""
    sigmas_px: Float64[np.ndarray, "4"]
    """Formal sigma of one coordinate of each corner: a relative weight, no promise."""
    blur_px: float
    contrast: float
    """Half the step from black to white, of 255 in linear light."""
    misfit: float
    """RMS of the residuals over the contrast, of the worst side."""
    bent: bool
    """Whether the sides are significantly curved."""


def linear_light(luma: GreyImage) -> Float32[np.ndarray, "h w"]:
    """Linear light of a photo's sRGB values, 0 to 255."""
    values: UInt8[np.ndarray, "h w"] = np.asarray(luma, np.uint8)
    return _LINEAR_OF_LUMA[values]


def fit_square(
    light: Float32[np.ndarray, "h w"],
    corners_px: Float64[np.ndarray, "4 2"],
    code: Code,
    camera: Camera | None = None,
) -> SquareFit | None:
    """Fit the four sides of a dark square on white.

    Args:
        corners_px: Clockwise as printed, to a pixel or two.
        code: The square's cells, row by row: 1 white, 0 black; the outer ones are black. As much
            white as one cell must lie outside.
        camera: Lens of the photo; None takes pixels as they are, and distortion for a bend.

    Returns:
        None where the square is too small, cut off by the picture, or no square of dark on white.
    """
    patch = _patch_round(light, corners_px, 1 / len(code), camera)
    if patch is None:
        return None
    sides = _fit_curved_sides(patch, patch.undistorted(corners_px), code)
    if sides is None:
        return None
    bent = sum((side.curve[2] / side.sigma_bend) ** 2 for side in sides) > _BEND_CHI2
    if not bent:
        blur_px = float(np.median([side.blur_px for side in sides]))
        sides = _fit_sides(patch, sides, code, blur_px, bends=False)
    corners = None if sides is None else _side_intersections(sides)
    if sides is None or corners is None:
        return None
    centre = _diagonal_intersection(corners)
    if not np.isfinite(corners).all() or not np.isfinite(centre).all():
        return None
    return SquareFit(
        corners_px=patch.distorted(corners),
        centre_px=patch.distorted(centre[None])[0],
        sigmas_px=_sigmas_px(sides),
        blur_px=float(np.median([side.blur_px for side in sides])),
        contrast=min(side.contrast for side in sides),
        misfit=max(side.misfit for side in sides),
        bent=bool(bent),
    )


@dataclass(frozen=True)
class _Patch:
    """Pixels along a square's sides, where a lens without distortion would have them."""

    xy: Points2
    light: Float64[np.ndarray, " n"]
    camera: Camera | None

    def undistorted(self, xy_px: Points2) -> Points2:
        return _undistorted(xy_px, self.camera)

    def distorted(self, xy: Points2) -> Points2:
        camera = self.camera
        if camera is None:
            return xy
        ideal = (xy - (camera.cx, camera.cy)) / (camera.fx, camera.fy)
        return np.asarray(camera.project(np.column_stack([ideal, np.ones(len(ideal))])))


def _undistorted(xy_px: Points2, camera: Camera | None) -> Points2:
    if camera is None:
        return xy_px
    return camera.normalize(xy_px) * (camera.fx, camera.fy) + (camera.cx, camera.cy)


def _patch_round(
    light: Float32[np.ndarray, "h w"],
    corners_px: Float64[np.ndarray, "4 2"],
    border: float,
    camera: Camera | None,
) -> _Patch | None:
    """The pixels near a square's sides; None where the picture cuts the square off."""
    if not np.isfinite(corners_px).all():
        return None
    low, high = corners_px.min(0), corners_px.max(0)
    margin = min(border * float((high - low).max()), _MOST_REACH_PX) + 2.0
    left, top = np.floor(low - margin).astype(int).tolist()
    right, bottom = np.ceil(high + margin).astype(int).tolist()
    height, width = light.shape
    if min(low) < 2 or high[0] > width - 3 or high[1] > height - 3:
        return None
    left, top, right, bottom = max(left, 0), max(top, 0), min(right, width), min(bottom, height)
    y, x = np.mgrid[top:bottom, left:right].reshape(2, -1)
    xy = np.column_stack([x, y]).astype(float)
    near = _near_sides(xy, corners_px, margin)
    xy = xy[near]
    grey = light[top:bottom, left:right].ravel()[near].astype(float)
    return _Patch(_undistorted(xy, camera), grey, camera)


def _near_sides(
    xy: Points2, corners: Float64[np.ndarray, "4 2"], margin: float
) -> Bool[np.ndarray, " n"]:
    near = np.zeros(len(xy), bool)
    for first, last in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = last - first
        length = max(float(np.hypot(*along)), 1e-9)
        across = (xy - first) @ np.array([along[1], -along[0]]) / length
        near |= np.abs(across) < margin
    return near


@dataclass(frozen=True, kw_only=True)
class _Side:
    """One side: a parabola over its chord, and how it fits."""

    middle: Float64[np.ndarray, "2"]
    along: Float64[np.ndarray, "2"]
    outward: Float64[np.ndarray, "2"]
    half_px: float
    curve: Float64[np.ndarray, "3"]
    """Offset, slope and bend: n = c + m t + k t^2."""
    covariance: Float64[np.ndarray, "3 3"]
    blur_px: float = _FIRST_BLUR_PX
    contrast: float = 0.0
    misfit: float = 0.0

    @property
    def sigma_bend(self) -> float:
        return max(float(np.sqrt(self.covariance[2, 2])), _LEAST_BEND_SIGMA_PX)

    def coordinates(self, xy: Points2) -> Points2:
        """t along the side, n across it in pixels, outwards."""
        off = xy - self.middle
        return np.column_stack([off @ self.along / self.half_px, off @ self.outward])

    def signed_distance_px(self, xy: Points2) -> Float64[np.ndarray, " n"]:
        """Pixels outwards from the curve, negative inside the square."""
        t, n = self.coordinates(xy).T
        t = np.clip(t, -1.3, 1.3)
        return n - (self.curve[0] + t * (self.curve[1] + t * self.curve[2]))

    def point_at(self, t: float) -> Float64[np.ndarray, "2"]:
        """Point of the curve."""
        n = self.curve[0] + t * (self.curve[1] + t * self.curve[2])
        return self.middle + t * self.half_px * self.along + n * self.outward

    def tangent_at(self, t: float) -> Float64[np.ndarray, "2"]:
        """Derivative of the point by t."""
        n = self.curve[1] + 2 * t * self.curve[2]
        return self.half_px * self.along + n * self.outward


def _straight_sides(corners: Points2) -> list[_Side]:
    """Straight sides between corners that run clockwise in the picture."""
    return [_straight_side(corners[k], corners[(k + 1) % 4]) for k in range(4)]


def _straight_side(first: Float64[np.ndarray, "2"], last: Float64[np.ndarray, "2"]) -> _Side:
    half_px = max(0.5 * float(np.hypot(*(last - first))), 1e-6)
    along = (last - first) / (2 * half_px)
    return _Side(
        middle=0.5 * (first + last),
        along=along,
        outward=np.array([along[1], -along[0]]),
        half_px=half_px,
        curve=np.zeros(3),
        covariance=np.eye(3),
    )


def _fit_curved_sides(patch: _Patch, corners: Points2, code: Code) -> list[_Side] | None:
    """Fit all sides until their corners converge, straight ones first; None where that fails."""
    sides, blur_px = _straight_sides(corners), _FIRST_BLUR_PX
    for round_idx in range(_MAX_ROUNDS):
        found = _fit_sides(patch, sides, code, blur_px, bends=round_idx > 0)
        new_corners = None if found is None else _side_intersections(found)
        if found is None or new_corners is None or not np.isfinite(new_corners).all():
            return None
        blur_px = float(np.median([side.blur_px for side in found]))
        change_px = float(np.abs(new_corners - corners).max())
        corners, sides = new_corners, found
        if round_idx > 0 and change_px < _CONVERGED_PX:
            break
    return sides


def _fit_sides(
    patch: _Patch, sides: list[_Side], code: Code, blur_px: float, *, bends: bool
) -> list[_Side] | None:
    """Fit each side to the pixels of its band; None where one cannot be fitted."""
    fits = [_fit_side(patch, sides, k, code, blur_px, bends=bends) for k in range(4)]
    found = [side for side in fits if side is not None]
    return found if len(found) == 4 else None


def _fit_side(
    patch: _Patch, sides: list[_Side], side_idx: int, code: Code, blur_px: float, *, bends: bool
) -> _Side | None:
    """Fit one side to the pixels of its band."""
    side, border = sides[side_idx], 1 / len(code)
    opposite = sides[(side_idx + 2) % 4]
    before, after = sides[side_idx - 1], sides[(side_idx + 1) % 4]
    depth_px = -float(side.signed_distance_px(opposite.middle[None])[0])
    reach_px = max(border * depth_px - _CODE_CLEARANCE_BLURS * blur_px, 0.55 * border * depth_px)
    reach_px = min(reach_px, _MOST_REACH_PX)
    clearance_px = max(_CORNER_CLEARANCE_BLURS * blur_px, _CORNER_CLEARANCE_PX)
    distance_px = side.signed_distance_px(patch.xy)
    in_band = np.abs(distance_px) <= reach_px
    in_band[in_band] = (before.signed_distance_px(patch.xy[in_band]) < -clearance_px) & (
        after.signed_distance_px(patch.xy[in_band]) < -clearance_px
    )
    if np.count_nonzero(in_band) < _LEAST_PIXELS:
        return None
    t, n = side.coordinates(patch.xy[in_band]).T
    spilled = _spilled_light(
        side, np.rot90(code, side_idx)[1], border * depth_px, t, distance_px[in_band]
    )
    band = _Band(t, n, patch.light[in_band] - spilled, bends)
    start = band.start(side.curve if bends else side.curve * (1, 1, 0), blur_px)
    found = minimise(start, band.cost(start), band.linearised, _DESCENT)
    blur, contrast = float(found[3]), float(found[6])
    if not (contrast > 0 and math.isfinite(blur) and abs(found[0]) <= reach_px):
        return None  # an edge beside the band is not seen
    rms = math.sqrt(2 * band.cost(found) / len(t))
    return replace(
        side,
        curve=found[:3].copy(),
        covariance=band.covariance(found),
        blur_px=blur,
        contrast=contrast,
        misfit=rms / contrast,
    )


def _spilled_light(
    side: _Side,
    cells: UInt8[np.ndarray, " c"],
    depth_px: float,
    t: Float64[np.ndarray, " n"],
    distance_px: Float64[np.ndarray, " n"],
) -> Float64[np.ndarray, " n"]:
    """Light that blur spreads from white cells `depth_px` inside a side, by its last fit."""
    if side.contrast <= 0:
        return np.zeros(len(t))
    scale_px = side.blur_px * math.sqrt(2)
    bounds = np.linspace(-1, 1, len(cells) + 1)
    steps = erf((t[:, None] - bounds) * side.half_px / scale_px)
    white = 0.5 * (steps[:, :-1] - steps[:, 1:]) @ cells.astype(float)
    return side.contrast * white * (1 - erf((distance_px + depth_px) / scale_px))


@dataclass(frozen=True)
class _Band:
    """Pixels of one side: unknowns are c, m, k, s, a0, a1, h0, h1."""

    t: Float64[np.ndarray, " n"]
    n: Float64[np.ndarray, " n"]
    light: Float64[np.ndarray, " n"]
    bends: bool

    def start(self, curve: Float64[np.ndarray, "3"], blur_px: float) -> Float64[np.ndarray, "8"]:
        low, high = np.percentile(self.light, [5, 95])
        rest = [blur_px, (low + high) / 2, 0.0, max((high - low) / 2, 1e-3), 0.0]
        return np.concatenate([curve, rest])

    def cost(self, state: Float64[np.ndarray, "8"]) -> float:
        return 0.5 * float((self._residuals(state) ** 2).sum())

    def linearised(
        self, state: Float64[np.ndarray, "8"]
    ) -> Callable[[float], Trial[Float64[np.ndarray, "8"]] | None]:
        residuals, jacobian = self._residuals(state), self._jacobian(state)
        free = self._free_parameters
        normal, gradient = jacobian.T @ jacobian, jacobian.T @ residuals

        def step(damping: float) -> Trial[Float64[np.ndarray, "8"]] | None:
            candidate = state.copy()
            damped = normal + damping * np.diag(np.diag(normal))
            try:
                candidate[free] -= np.linalg.solve(damped, gradient)
            except np.linalg.LinAlgError:  # the edge left the band: no pixel tells of it
                return None
            candidate[_BLUR] = min(max(candidate[_BLUR], _LEAST_BLUR_PX), _MOST_BLUR_PX)
            return Trial(candidate, self.cost(candidate))

        return step

    def covariance(self, state: Float64[np.ndarray, "8"]) -> Float64[np.ndarray, "3 3"]:
        """Covariance of offset, slope and bend; zero for a bend that is held."""
        jacobian, free = self._jacobian(state), self._free_parameters
        variance = 2 * self.cost(state) / max(1, len(self.t) - len(free))
        covariance = np.zeros((8, 8))
        covariance[np.ix_(free, free)] = variance * np.linalg.inv(jacobian.T @ jacobian)
        return covariance[:3, :3]

    @property
    def _free_parameters(self) -> list[int]:
        return list(range(8)) if self.bends else [k for k in range(8) if k != _BEND]

    def _residuals(self, state: Float64[np.ndarray, "8"]) -> Float64[np.ndarray, " n"]:
        c, m, k, s, a0, a1, h0, h1 = state
        t = self.t
        profile = erf((self.n - c - t * (m + t * k)) / (s * math.sqrt(2)))
        return a0 + a1 * t + (h0 + h1 * t) * profile - self.light

    def _jacobian(self, state: Float64[np.ndarray, "8"]) -> Float64[np.ndarray, "n k"]:
        """Derivatives of the residuals by the free unknowns."""
        c, m, k, s, _, _, h0, h1 = state
        t, ones = self.t, np.ones(len(self.t))
        blurs = (self.n - c - t * (m + t * k)) / (s * math.sqrt(2))
        step = -(h0 + h1 * t) * np.exp(-(blurs**2)) * math.sqrt(2 / math.pi) / s
        profile = erf(blurs)
        columns = [step, step * t, step * t * t, step * blurs * math.sqrt(2)]
        columns += [ones, t, profile, profile * t]
        return np.column_stack([columns[k] for k in self._free_parameters])


def _side_intersections(sides: list[_Side]) -> Points2 | None:
    """Corners, each where a side meets the one before it; None where two do not meet."""
    corners = np.empty((4, 2))
    for k in range(4):
        before, after = sides[k - 1], sides[k]
        t = np.array([1.0, -1.0])
        for _ in range(8):
            gap = before.point_at(t[0]) - after.point_at(t[1])
            turn = np.column_stack([before.tangent_at(t[0]), -after.tangent_at(t[1])])
            if abs(np.linalg.det(turn)) < 1e-9:
                return None
            t = t - np.linalg.solve(turn, gap)
            if not np.abs(t).max() < 2.5:
                return None
        corners[k] = after.point_at(t[1])
    return corners


def _sigmas_px(sides: list[_Side]) -> Float64[np.ndarray, "4"]:
    """Formal sigma of one coordinate of each corner, from the sides' covariances."""
    sigmas = np.empty(4)
    for k in range(4):
        before, after = sides[k - 1], sides[k]
        across = np.linalg.inv(np.array([before.outward, after.outward]))
        ends = (np.array([1.0, 1.0, 1.0]), np.array([1.0, -1.0, 1.0]))
        variances = [
            float(end @ side.covariance @ end)
            for end, side in zip(ends, (before, after), strict=True)
        ]
        spread = across @ np.diag(variances) @ across.T
        sigmas[k] = math.sqrt(max(0.5 * float(np.trace(spread)), 0.0))
    return sigmas


def _diagonal_intersection(corners: Points2) -> Float64[np.ndarray, "2"]:
    """Where the diagonals of a quadrilateral cross."""
    rows = np.column_stack([corners, np.ones(4)])
    crossing = np.cross(np.cross(rows[0], rows[2]), np.cross(rows[1], rows[3]))
    return crossing[:2] / crossing[2]
