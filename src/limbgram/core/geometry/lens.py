"""The lens: the camera model, its projection, its derivatives and its inverse.

Pinhole with skew and Brown-Conrady distortion, in OpenCV's convention. Pixel (0, 0) is the CENTRE
of the top left pixel. The camera looks along +z, x right, y down. Photos are used in the sensor's
orientation; EXIF orientation only turns pictures for people.

The formulas stand once, in three functions: `distorted`, `distorted_with_slopes` and
`coefficient_slopes`. They are plain Python. numpy calls them with arrays, and every compiled kernel
inlines them. All other code takes the model from them. Where the radial part turns back, and the
lens shows nothing any more, is told by `fold_of`.

To add a coefficient:
1. Append it to `LensParameters`, with nought for what files do not say, and say in `DISTORTION`
   how it acts. Rows, covariances, files, summaries and what is held at zero follow.
2. Write it into the three formulas, into `distorted_by` and `distorted_in`, which take them from a
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
from limbgram.core.geometry.frames import Rigid
from limbgram.core.kernels import inlined, njit


@dataclass(frozen=True, kw_only=True)
class LensParameters:
    """The numbers of a lens: four of the pinhole and skew in pixels, then the distortion."""

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
    """How a coefficient of the distortion acts, and what is known of it beforehand."""

    power: int
    """Of the distance from the axis: so grows the shift, in parts of that distance."""
    radial: bool
    wide: float
    """Sigma of the shift in the picture's corner where no board told it, over that of k1; 0 holds
    the coefficient at what it is, which is zero unless it was given."""


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
"""The coefficients that OpenCV and COLMAP have too, in their order; theirs that follow divide."""
IN_PIXELS = PARAMETERS[: -len(COEFFICIENTS)]
"""Lens parameters with a unit; the others have none."""
RADIAL = [PARAMETERS.index(name) for name, one in DISTORTION.items() if one.radial]
"""Where the radial coefficients stand in a row."""
HELD = ("skew", *(name for name, one in DISTORTION.items() if one.wide == 0))
"""Not estimated unless that is asked for."""

LENS_SIZE = len(PARAMETERS)
POSE_SIZE = 6
FROM_CORNER_PX = 0.5
"""COLMAP counts pixels from the picture's corner, we from its first pixel's middle."""

_UNDISTORT_STEPS = 20
_EXACT = float(np.nextafter(0.0, 1.0))
"""Only steps of nothing are smaller: the iteration ends where it stands still."""


@inlined
def distorted(x: Any, y: Any, k1: Any, k2: Any, p1: Any, p2: Any, k3: Any):
    """Distorted of ideal normalized coordinates, as (xd, yd).

    Numbers, arrays and complex numbers are taken alike.
    """
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return xd, yd


@inlined
def distorted_with_slopes(x: Any, y: Any, k1: Any, k2: Any, p1: Any, p2: Any, k3: Any):
    """The same with its derivatives: (xd, yd, d xd/dx, d xd/dy = d yd/dx, d yd/dy)."""
    xd, yd = distorted(x, y, k1, k2, p1, p2, k3)
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3))
    xd_x = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    xd_y = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    yd_y = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    return xd, yd, xd_x, xd_y, yd_y


@inlined
def coefficient_slopes(x: Any, y: Any):
    """Derivatives of (xd, yd) by k1, k2, p1, p2 and k3."""
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
    """`distorted` by a packed lens."""
    return distorted(x, y, lens[5], lens[6], lens[7], lens[8], lens[9])


@inlined
def distorted_in(view: Any, x: Any, y: Any):
    """`distorted_with_slopes` by the lens of a packed view."""
    k1, k2, p1, p2, k3 = view[17], view[18], view[19], view[20], view[21]
    return distorted_with_slopes(x, y, k1, k2, p1, p2, k3)


@lru_cache(maxsize=256)
def fold_of(*radial: float, slope: float = 0.0) -> float:
    """Ideal distance from the axis where the radial distortion turns back; infinite without one.

    What lies farther aside would be drawn over what lies nearer: no lens shows it there. With a
    `slope`, where places still part by only so much of what their rays do.

    Args:
        radial: Coefficients of the distance's second, fourth, sixth power and so on.
    """
    terms = [(2.0 * n + 1.0) * one for n, one in enumerate(radial, start=1)]
    terms = np.array([*reversed(terms), 1.0 - slope])  # by the distance's square
    if not np.isfinite(terms).all():
        return 0.0
    roots = np.roots(terms)
    squares = roots.real[(roots.imag == 0.0) & (roots.real > 0.0)]
    return float(np.sqrt(squares.min(initial=np.inf)))


@njit(cache=True, nogil=True, error_model="numpy")
def ideal_of(x_px: float, y_px: float, lens: np.ndarray, steps: int, tolerance: float):
    """Ideal normalized coordinates of a pixel: the inverse of the projection, by fixed points.

    Ends after `steps`, or where a step is smaller than `tolerance`.
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
class _Picture:
    """Fields that stand before those of the lens wherever a camera is written."""

    width_px: int
    height_px: int


@dataclass(frozen=True, kw_only=True)
class Camera(LensParameters, _Picture):
    """Intrinsics and distortion of one camera at one focus setting, for one image size.

    x, y = X/Z, Y/Z; r2 = x^2 + y^2; d = 1 + k1 r2 + k2 r2^2 + k3 r2^3
    xd = x d + 2 p1 x y + p2 (r2 + 2 x^2);  yd = y d + p1 (r2 + 2 y^2) + 2 p2 x y
    u = fx xd + skew yd + cx;  v = fy yd + cy          (Brown 1971; Conrady 1919)
    """

    @property
    def matrix(self) -> Matrix3:
        """K."""
        return np.array([[self.fx, self.skew, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def distortion(self) -> Float64[np.ndarray, " coefficients"]:
        """In the order of COEFFICIENTS, whose first five are OpenCV's."""
        return self.packed[len(IN_PIXELS) :]

    def coefficients(
        self, program: str, known: Sequence[str], error: type[LimbgramError]
    ) -> tuple[float, ...]:
        """Coefficients as another program has them: those that it knows, in its order.

        Raises:
            error: the lens has another one, without which its pixels would lie elsewhere.
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
        """The camera of an image reduced by `factor` (< 1), pixel centres kept right."""
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
        """Pixels of points in the camera frame; NaN for points that the lens cannot show.

        Those are behind the camera, or so far aside that the distortion has turned back.
        """
        depth = np.where(points_in_camera[..., 2] > 0, points_in_camera[..., 2], np.nan)
        ideal = points_in_camera[..., :2] / depth[..., None]
        shown = (ideal**2).sum(axis=-1) <= fold_of(*self.packed[RADIAL]) ** 2
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

    def pixel_at(self, points_in_world: Points3) -> Float64[np.ndarray, " n"]:
        """Width of a pixel of this photo on the object, in units of the world."""
        depth = self.camera_from_world.apply(points_in_world)[:, 2]
        return np.abs(depth) / np.sqrt(self.camera.fx * self.camera.fy)

    def shows(self, points_in_world: AnyPoints3, margin_px: float = 0.0) -> np.ndarray:
        """Whether points lie before the camera, in its frame and this far from its border.

        What stands before them is not looked at.
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
    """Pixels as the same camera without skew would have them."""
    straight = xy_px.copy()
    straight[:, 0] -= camera.skew * (xy_px[:, 1] - camera.cy) / camera.fy
    return straight


class LensSlopes(NamedTuple):
    """Pixels with their derivatives by the ideal coordinates and by the lens."""

    xy_px: Points2
    by_ideal: Float64[np.ndarray, "n 2 2"]
    by_lens: Float64[np.ndarray, "n 2 lens"]


def lens_slopes(
    x: Float64[np.ndarray, " n"], y: Float64[np.ndarray, " n"], lens: Float64[np.ndarray, " lens"]
) -> LensSlopes:
    """Pixels of ideal coordinates (X/Z, Y/Z), with derivatives."""
    fx, fy, cx, cy, skew = lens[:5]
    xd, yd, xd_x, xd_y, yd_y = distorted_with_slopes(x, y, *lens[5:])
    by_ideal = np.empty((len(x), 2, 2))
    by_ideal[:, 0, 0], by_ideal[:, 0, 1] = fx * xd_x + skew * xd_y, fx * xd_y + skew * yd_y
    by_ideal[:, 1, 0], by_ideal[:, 1, 1] = fy * xd_y, fy * yd_y
    by_lens = np.zeros((len(x), 2, LENS_SIZE))
    by_lens[:, 0, 0], by_lens[:, 1, 1] = xd, yd
    by_lens[:, 0, 2] = by_lens[:, 1, 3] = 1.0
    by_lens[:, 0, 4] = yd
    for column, (dx, dy) in enumerate(coefficient_slopes(x, y), start=5):
        by_lens[:, 0, column], by_lens[:, 1, column] = fx * dx + skew * dy, fy * dy
    return LensSlopes(np.stack([fx * xd + skew * yd + cx, fy * yd + cy], axis=1), by_ideal, by_lens)


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
    by_k1, by_k2, by_p1, by_p2, by_k3 = coefficient_slopes(x, y)
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
    move: tuple[float, float],
    fx: float,
    fy: float,
    skew: float,
):
    """Write how pixels move when distorted coordinates move by `move`."""
    by_lens[0, column] = fx * move[0] + skew * move[1]
    by_lens[1, column] = fy * move[1]


@njit(cache=True, nogil=True, error_model="numpy")
def _normalize_all(xy_px: np.ndarray, lens: np.ndarray, ideal: np.ndarray) -> None:
    """Fill the ideal coordinates of all pixels."""
    for k in range(len(xy_px)):
        ideal[k, 0], ideal[k, 1] = ideal_of(
            xy_px[k, 0], xy_px[k, 1], lens, _UNDISTORT_STEPS, _EXACT
        )


def turned(
    view: Float64[np.ndarray, " view"], step: Float64[np.ndarray, "6"]
) -> Float64[np.ndarray, " view"]:
    """The view after the pose step (w, d); the rotation stays orthogonal to rounding."""
    from_axis = np.zeros((3, 3))
    angle = float(np.linalg.norm(step[:3]))
    wx, wy, wz = step[:3] if angle == 0.0 else step[:3] / angle
    from_axis[:] = [[0.0, -wz, wy], [wz, 0.0, -wx], [-wy, wx, 0.0]]
    small = np.eye(3) + np.sin(angle) * from_axis
    small += (1.0 - np.cos(angle)) * (from_axis @ from_axis)
    moved = view.copy()
    moved[:9] = (small @ view[:9].reshape(3, 3)).ravel()
    moved[9:12] += step[3:]
    return moved
