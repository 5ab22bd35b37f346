"""The lens: the camera model, its projection, its derivatives and its inverse.

Pinhole with skew and Brown-Conrady distortion, in OpenCV's convention. Pixel (0, 0) is the CENTRE
of the top left pixel. The camera looks along +z, x right, y down. Photos are used in the sensor's
orientation; EXIF orientation only turns pictures for people.

The formulas stand once, in three functions: `distorted`, `distorted_with_jacobian` and
`coefficient_derivatives`. They are plain Python: numpy calls them with arrays, and every compiled
kernel inlines them. `fold_radius` is the radius beyond which the radial distortion turns back and
the lens shows nothing.

Ideal coordinates are normalized and undistorted: X/Z, Y/Z in the camera frame.

To add a coefficient:
1. Append it to `LensParameters`, with zero as its default, and describe it in `DISTORTION`. Packed
   rows, covariances, files, summaries and the parameters held fixed follow.
2. Write it into the three formulas, into `distorted_by` and `distorted_in`, which read a packed
   row, and as the last row of derivatives into `project_and_differentiate`.
3. `tests/unit/core/test_derivatives.py`: give it a value in `LENS`. The file checks every
   derivative in the program against complex steps and differences.

A view is a row of `View.packed`: rotation (9), translation (3), lens (LENS_SIZE). The derivative
by the pose is for x_camera = exp(w) (R x_world) + t + d, with w a small rotation vector in the
camera's frame and d a shift: six numbers (w, d).
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import LimbgramError
from limbgram.core.geometry.arrays import AnyPoints2, AnyPoints3, Matrix3, Points2, Points3
from limbgram.core.geometry.frames import Rigid, cross_matrix
from limbgram.core.kernels import inlined, njit


@dataclass(frozen=True, kw_only=True)
class LensParameters:
    """Intrinsics (pinhole and skew, px), then the distortion coefficients."""

    fx: float
    fy: float
    cx: float
    cy: float
    skew: float = 0.0
    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0


class Coefficient(NamedTuple):
    """How a distortion coefficient acts, and its prior."""

    power: int
    """Power of the radius with which the relative shift of a pixel grows."""
    radial: bool
    wide: float
    """Prior sigma of the shift at the picture's corner, relative to that of k1, for lenses that no
    board calibrated; 0 holds the coefficient fixed."""


DISTORTION = {
    "k1": Coefficient(2, radial=True, wide=1.0),
    "k2": Coefficient(4, radial=True, wide=1.0),
    "p1": Coefficient(1, radial=False, wide=0.1),
    "p2": Coefficient(1, radial=False, wide=0.1),
    "k3": Coefficient(6, radial=True, wide=0.0),
}

PARAMETERS = tuple(field.name for field in fields(LensParameters))
"""Order of the lens parameters in every packed row and covariance matrix."""

COEFFICIENTS = tuple(DISTORTION)
OPENCV = ("k1", "k2", "p1", "p2", "k3")
"""Coefficients that OpenCV and COLMAP share, in their order; theirs after k3 are a denominator."""
IN_PIXELS = PARAMETERS[: -len(COEFFICIENTS)]
"""Lens parameters with a unit; the others have none."""
RADIAL = [PARAMETERS.index(name) for name, one in DISTORTION.items() if one.radial]
"""Indices of the radial coefficients in a packed row."""
HELD = ("skew", *(name for name, one in DISTORTION.items() if one.wide == 0))
"""Held fixed unless their estimation is asked for."""

LENS_SIZE = len(PARAMETERS)
POSE_SIZE = 6
FROM_CORNER_PX = 0.5
"""Added to our pixel coordinates it gives COLMAP's, whose origin is the picture's corner."""

_UNDISTORT_STEPS = 20
_EXACT = float(np.nextafter(0.0, 1.0))
"""Tolerance below which only a step of zero lies."""


@inlined
def distorted(x: Any, y: Any, k1: Any, k2: Any, p1: Any, p2: Any, k3: Any):
    """Distorted normalized coordinates (xd, yd) of ideal ones; scalars, arrays or complex."""
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return xd, yd


@inlined
def distorted_with_jacobian(x: Any, y: Any, k1: Any, k2: Any, p1: Any, p2: Any, k3: Any):
    """`distorted` and its symmetric Jacobian: (xd, yd, dxd/dx, dxd/dy = dyd/dx, dyd/dy)."""
    xd, yd = distorted(x, y, k1, k2, p1, p2, k3)
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3))
    xd_x = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    xd_y = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    yd_y = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    return xd, yd, xd_x, xd_y, yd_y


@inlined
def coefficient_derivatives(x: Any, y: Any):
    """Derivatives of (xd, yd) with respect to k1, k2, p1, p2 and k3."""
    r2 = x * x + y * y
    return (
        (x * r2, y * r2),
        (x * r2 * r2, y * r2 * r2),
        (2.0 * x * y, r2 + 2.0 * y * y),
        (r2 + 2.0 * x * x, 2.0 * x * y),
        (x * r2 * r2 * r2, y * r2 * r2 * r2),
    )


@inlined
def distorted_by(lens: Any, x: Any, y: Any):
    """`distorted` with the coefficients of a packed lens."""
    return distorted(x, y, lens[5], lens[6], lens[7], lens[8], lens[9])


@inlined
def distorted_in(view: Any, x: Any, y: Any):
    """`distorted_with_jacobian` with the coefficients of a packed view."""
    k1, k2, p1, p2, k3 = view[17], view[18], view[19], view[20], view[21]
    return distorted_with_jacobian(x, y, k1, k2, p1, p2, k3)


@lru_cache(maxsize=256)
def fold_radius(*radial: float, slope: float = 0.0) -> float:
    """Ideal radius at which the distorted radius stops growing; infinite if it never does.

    Beyond it the picture would fold over itself: no lens shows points there.

    Args:
        radial: k1, k2, k3 and so on: coefficients of r^2, r^4, r^6.
        slope: Derivative of the distorted radius that counts as no longer growing.
    """
    terms = [(2.0 * n + 1.0) * one for n, one in enumerate(radial, start=1)]
    derivative = np.array([*reversed(terms), 1.0 - slope])  # a polynomial in r^2
    if not np.isfinite(derivative).all():
        return 0.0
    roots = np.roots(derivative)
    squares = roots.real[(roots.imag == 0.0) & (roots.real > 0.0)]
    return float(np.sqrt(squares.min(initial=np.inf)))


@njit(cache=True, nogil=True, error_model="numpy")
def ideal_from_pixel(x_px: float, y_px: float, lens: np.ndarray, steps: int, tolerance: float):
    """Ideal coordinates of a pixel, by fixed-point iteration (OpenCV's undistortPoints).

    Ends after `steps`, or when a step is smaller than `tolerance`.
    """
    yd = (y_px - lens[3]) / lens[1]
    xd = (x_px - lens[2] - lens[4] * yd) / lens[0]
    x, y = xd, yd
    for _ in range(steps):
        reached_x, reached_y = distorted_by(lens, x, y)
        step_x, step_y = xd - reached_x, yd - reached_y
        x += step_x
        y += step_y
        if abs(step_x) + abs(step_y) < tolerance:
            break
    return x, y


@dataclass(frozen=True, kw_only=True)
class _ImageSize:
    """Base of Camera: its fields come before those of the lens wherever a camera is written."""

    width_px: int
    height_px: int


@dataclass(frozen=True, kw_only=True)
class Camera(LensParameters, _ImageSize):
    """Intrinsics and distortion of one camera at one focus setting, for one image size.

    x, y = X/Z, Y/Z; r2 = x^2 + y^2; d = 1 + k1 r2 + k2 r2^2 + k3 r2^3
    xd = x d + 2 p1 x y + p2 (r2 + 2 x^2);  yd = y d + p1 (r2 + 2 y^2) + 2 p2 x y
    u = fx xd + skew yd + cx;  v = fy yd + cy          (Brown 1971; Conrady 1919)
    """

    @property
    def matrix(self) -> Matrix3:
        """The calibration matrix K."""
        return np.array([[self.fx, self.skew, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def distortion(self) -> Float64[np.ndarray, " coefficients"]:
        """The coefficients in the order of COEFFICIENTS, whose first five are OpenCV's."""
        return self.packed[len(IN_PIXELS) :]

    def coefficients(
        self, program: str, known: Sequence[str], error: type[LimbgramError]
    ) -> tuple[float, ...]:
        """Coefficients for another program: those that it knows, in its order.

        Raises:
            error: the lens has a coefficient that the program does not know.
        """
        given = dict(zip(COEFFICIENTS, self.distortion.tolist(), strict=True))
        more = tuple(name for name in COEFFICIENTS if given[name] and name not in known)
        if more:
            raise error("lens.other_model", names=more, program=program)
        return tuple(given[name] for name in known)

    @property
    def packed(self) -> Float64[np.ndarray, " lens"]:
        """The lens as one row in the order of PARAMETERS, for kernels."""
        return np.array([getattr(self, name) for name in PARAMETERS], float)

    def with_parameters(self, packed: Float64[np.ndarray, " lens"]) -> "Camera":
        return replace(self, **dict(zip(PARAMETERS, map(float, packed), strict=True)))

    @property
    def undistorted(self) -> "Camera":
        """The same camera without distortion; its skew stays."""
        return replace(self, **dict.fromkeys(COEFFICIENTS, 0.0))

    @property
    def pinhole(self) -> "Camera":
        """The same camera without distortion and skew."""
        return replace(self.undistorted, skew=0.0)

    def scaled(self, factor: float) -> "Camera":
        """The camera of an image reduced by `factor` (< 1); the half pixel is accounted for."""
        return replace(
            self,
            width_px=round(self.width_px * factor),
            height_px=round(self.height_px * factor),
            fx=self.fx * factor,
            fy=self.fy * factor,
            skew=self.skew * factor,
            cx=(self.cx + 0.5) * factor - 0.5,
            cy=(self.cy + 0.5) * factor - 0.5,
        )

    def distort(self, normalized: AnyPoints2) -> AnyPoints2:
        """Ideal normalized coordinates to distorted normalized coordinates."""
        x, y = normalized[..., 0], normalized[..., 1]
        return np.stack(distorted(x, y, *self.distortion), axis=-1)

    def project(self, points_in_camera: AnyPoints3) -> AnyPoints2:
        """Pixels of points in the camera frame; NaN behind the camera and beyond `fold_radius`."""
        depth = np.where(points_in_camera[..., 2] > 0, points_in_camera[..., 2], np.nan)
        ideal = points_in_camera[..., :2] / depth[..., None]
        shown = (ideal**2).sum(axis=-1) <= fold_radius(*self.packed[RADIAL]) ** 2
        distorted = self.distort(np.where(shown[..., None], ideal, np.nan))
        return np.stack(
            [
                self.fx * distorted[..., 0] + self.skew * distorted[..., 1] + self.cx,
                self.fy * distorted[..., 1] + self.cy,
            ],
            axis=-1,
        )

    def normalize(self, xy_px: AnyPoints2) -> AnyPoints2:
        """Ideal normalized coordinates (X/Z, Y/Z) of pixels, by fixed-point iteration."""
        pixels = np.ascontiguousarray(xy_px, np.float64)
        ideal = np.empty_like(pixels)
        _normalize_all(pixels.reshape(-1, 2), self.packed, ideal.reshape(-1, 2))
        return ideal

    def rays(self, xy_px: AnyPoints2) -> AnyPoints3:
        """Unit directions in the camera frame."""
        ideal = self.normalize(xy_px)
        directions = np.concatenate([ideal, np.ones((*ideal.shape[:-1], 1))], axis=-1)
        return directions / np.linalg.norm(directions, axis=-1, keepdims=True)

    def contains(self, xy_px: AnyPoints2, margin_px: float = 0.0) -> np.ndarray:
        """Whether pixels lie within the image, `margin_px` from its border (NaN: no)."""
        x, y = xy_px[..., 0], xy_px[..., 1]
        return (
            (x >= margin_px)
            & (y >= margin_px)
            & (x <= self.width_px - 1 - margin_px)
            & (y <= self.height_px - 1 - margin_px)
        )


@dataclass(frozen=True)
class View:
    """A placed photo: its name, lens and pose."""

    name: str
    camera: Camera
    camera_from_world: Rigid

    def project(self, points_in_world: AnyPoints3) -> AnyPoints2:
        return self.camera.project(self.camera_from_world.apply(points_in_world))

    def pixel_size_at(self, points_in_world: Points3) -> Float64[np.ndarray, " n"]:
        """Footprint of a pixel at these points (depth over focal length), in units of the world."""
        depth = self.camera_from_world.apply(points_in_world)[:, 2]
        return np.abs(depth) / np.sqrt(self.camera.fx * self.camera.fy)

    def shows(self, points_in_world: AnyPoints3, margin_px: float = 0.0) -> np.ndarray:
        """Whether points project into the image, `margin_px` from its border.

        Occlusion is ignored.
        """
        return self.camera.contains(self.project(points_in_world), margin_px)

    @property
    def centre_in_world(self) -> np.ndarray:
        return self.camera_from_world.centre

    @property
    def packed(self) -> Float64[np.ndarray, " view"]:
        """Rotation (9, row-major), translation (3), lens: one row for kernels."""
        pose = self.camera_from_world
        return np.concatenate([pose.rotation.ravel(), pose.translation, self.camera.packed])


def without_skew(camera: Camera, xy_px: Points2) -> Points2:
    """Pixels of the same rays in the camera without skew."""
    unskewed = xy_px.copy()
    unskewed[:, 0] -= camera.skew * (xy_px[:, 1] - camera.cy) / camera.fy
    return unskewed


class LensDerivatives(NamedTuple):
    """Pixels and their derivatives with respect to the ideal coordinates and the lens."""

    xy_px: Points2
    by_ideal: Float64[np.ndarray, "n 2 2"]
    by_lens: Float64[np.ndarray, "n 2 lens"]


def lens_derivatives(
    x: Float64[np.ndarray, " n"], y: Float64[np.ndarray, " n"], lens: Float64[np.ndarray, " lens"]
) -> LensDerivatives:
    """Pixels of ideal coordinates, with derivatives."""
    fx, fy, cx, cy, skew = lens[:5]
    xd, yd, xd_x, xd_y, yd_y = distorted_with_jacobian(x, y, *lens[5:])
    by_ideal = np.empty((len(x), 2, 2))
    by_ideal[:, 0, 0], by_ideal[:, 0, 1] = fx * xd_x + skew * xd_y, fx * xd_y + skew * yd_y
    by_ideal[:, 1, 0], by_ideal[:, 1, 1] = fy * xd_y, fy * yd_y
    by_lens = np.zeros((len(x), 2, LENS_SIZE))
    by_lens[:, 0, 0], by_lens[:, 1, 1] = xd, yd
    by_lens[:, 0, 2] = by_lens[:, 1, 3] = 1.0
    by_lens[:, 0, 4] = yd
    for column, (dx, dy) in enumerate(coefficient_derivatives(x, y), start=5):
        by_lens[:, 0, column], by_lens[:, 1, column] = fx * dx + skew * dy, fy * dy
    xy_px = np.stack([fx * xd + skew * yd + cx, fy * yd + cy], axis=1)
    return LensDerivatives(xy_px, by_ideal, by_lens)


@njit(cache=True, nogil=True)
def project_and_differentiate(
    view: np.ndarray,
    point: np.ndarray,
    xy: np.ndarray,
    by_point: np.ndarray,
    by_pose: np.ndarray,
    by_lens: np.ndarray,
) -> float:
    """Fill pixel `xy` (2) and its derivatives by point (2, 3), pose (2, 6) and lens (2, LENS_SIZE).

    Returns the depth; where it is not positive nothing else is filled.
    """
    rx = view[0] * point[0] + view[1] * point[1] + view[2] * point[2]
    ry = view[3] * point[0] + view[4] * point[1] + view[5] * point[2]
    rz = view[6] * point[0] + view[7] * point[1] + view[8] * point[2]
    depth = rz + view[11]
    if not depth > 0.0:
        return depth
    x, y = (rx + view[9]) / depth, (ry + view[10]) / depth
    fx, fy, cx, cy, skew = view[12], view[13], view[14], view[15], view[16]
    xd, yd, xd_x, xd_y, yd_y = distorted_in(view, x, y)
    xy[0] = fx * xd + skew * yd + cx
    xy[1] = fy * yd + cy

    u_x, u_y = fx * xd_x + skew * xd_y, fx * xd_y + skew * yd_y
    v_x, v_y = fy * xd_y, fy * yd_y

    for row in range(2):
        a = (u_x if row == 0 else v_x) / depth
        b = (u_y if row == 0 else v_y) / depth
        c = -(a * x + b * y)
        for k in range(3):
            by_point[row, k] = a * view[k] + b * view[3 + k] + c * view[6 + k]
        by_pose[row, 0] = c * ry - b * rz
        by_pose[row, 1] = a * rz - c * rx
        by_pose[row, 2] = b * rx - a * ry
        by_pose[row, 3] = a
        by_pose[row, 4] = b
        by_pose[row, 5] = c

    by_lens[0, 0], by_lens[1, 0] = xd, 0.0
    by_lens[0, 1], by_lens[1, 1] = 0.0, yd
    by_lens[0, 2], by_lens[1, 2] = 1.0, 0.0
    by_lens[0, 3], by_lens[1, 3] = 0.0, 1.0
    by_lens[0, 4], by_lens[1, 4] = yd, 0.0
    by_k1, by_k2, by_p1, by_p2, by_k3 = coefficient_derivatives(x, y)
    _by_distortion(by_lens, 5, by_k1, fx, fy, skew)
    _by_distortion(by_lens, 6, by_k2, fx, fy, skew)
    _by_distortion(by_lens, 7, by_p1, fx, fy, skew)
    _by_distortion(by_lens, 8, by_p2, fx, fy, skew)
    _by_distortion(by_lens, 9, by_k3, fx, fy, skew)
    return depth


@njit(cache=True, nogil=True)
def differentiate_all(
    view: np.ndarray,
    points: np.ndarray,
    by_point: np.ndarray,
    by_pose: np.ndarray,
    by_lens: np.ndarray,
) -> None:
    """Fill the derivatives of every point's pixel: (n, 2, 3), (n, 2, 6) and (n, 2, LENS_SIZE)."""
    xy = np.empty(2)
    for k in range(len(points)):
        project_and_differentiate(view, points[k], xy, by_point[k], by_pose[k], by_lens[k])


@njit(cache=True, nogil=True, inline="always")
def _by_distortion(
    by_lens: np.ndarray,
    column: int,
    by_distorted: tuple[float, float],
    fx: float,
    fy: float,
    skew: float,
):
    """Fill a column: the derivative of a pixel from that of its distorted coordinates."""
    by_lens[0, column] = fx * by_distorted[0] + skew * by_distorted[1]
    by_lens[1, column] = fy * by_distorted[1]


@njit(cache=True, nogil=True, error_model="numpy")
def _normalize_all(xy_px: np.ndarray, lens: np.ndarray, ideal: np.ndarray) -> None:
    """Fill the ideal coordinates of all pixels."""
    for k in range(len(xy_px)):
        ideal[k, 0], ideal[k, 1] = ideal_from_pixel(
            xy_px[k, 0], xy_px[k, 1], lens, _UNDISTORT_STEPS, _EXACT
        )


def with_pose_step(
    view: Float64[np.ndarray, " view"], step: Float64[np.ndarray, "6"]
) -> Float64[np.ndarray, " view"]:
    """The packed view after the pose step (w, d), by Rodrigues' formula."""
    angle = float(np.linalg.norm(step[:3]))
    skew_axis = cross_matrix(step[:3] if angle == 0.0 else step[:3] / angle)
    rotation = np.eye(3) + np.sin(angle) * skew_axis
    rotation += (1.0 - np.cos(angle)) * (skew_axis @ skew_axis)
    moved = view.copy()
    moved[:9] = (rotation @ view[:9].reshape(3, 3)).ravel()
    moved[9:12] += step[3:]
    return moved
