"""The lens: pinhole with skew and Brown-Conrady distortion, in OpenCV's convention.

Pixel (0, 0) is the CENTRE of the top left pixel. The camera looks along +z, x right, y down.
Photos are used in the sensor's orientation; EXIF orientation only turns pictures for people.

One projection with all its derivatives: the kernel of triangulation and adjustment.

A view is a row of `View.packed`: rotation (9), translation (3), lens (10). The derivative by the
pose is for x_camera = exp(w) (R x_world) + t + d, with w a small rotation vector in the camera's
frame and d a shift: six numbers (w, d).
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64
from numba import njit

from limbgram.core.geometry.arrays import AnyPoints2, AnyPoints3, Matrix3, Points2
from limbgram.core.geometry.frames import Rigid

PARAMETERS = ("fx", "fy", "cx", "cy", "skew", "k1", "k2", "p1", "p2", "k3")
"""Order of the lens parameters in every packed row and covariance matrix."""

_UNDISTORT_STEPS = 20


@dataclass(frozen=True, kw_only=True)
class Camera:
    """Intrinsics and distortion of one camera at one focus setting, for one image size.

    x, y = X/Z, Y/Z; r2 = x^2 + y^2; d = 1 + k1 r2 + k2 r2^2 + k3 r2^3
    xd = x d + 2 p1 x y + p2 (r2 + 2 x^2);  yd = y d + p1 (r2 + 2 y^2) + 2 p2 x y
    u = fx xd + skew yd + cx;  v = fy yd + cy          (Brown 1971; Conrady 1919)
    """

    width_px: int
    height_px: int
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

    @property
    def matrix(self) -> Matrix3:
        """K."""
        return np.array([[self.fx, self.skew, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def distortion(self) -> Float64[np.ndarray, "5"]:
        """k1, k2, p1, p2, k3: OpenCV's order."""
        return np.array([self.k1, self.k2, self.p1, self.p2, self.k3])

    @property
    def packed(self) -> Float64[np.ndarray, "10"]:
        """The lens as one row in the order of PARAMETERS, for kernels."""
        return np.array([getattr(self, name) for name in PARAMETERS], float)

    def with_parameters(self, packed: Float64[np.ndarray, "10"]) -> "Camera":
        return replace(self, **dict(zip(PARAMETERS, map(float, packed), strict=True)))

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
        r2 = x * x + y * y
        radial = 1 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
        return np.stack(
            [
                x * radial + 2 * self.p1 * x * y + self.p2 * (r2 + 2 * x * x),
                y * radial + self.p1 * (r2 + 2 * y * y) + 2 * self.p2 * x * y,
            ],
            axis=-1,
        )

    def project(self, points_in_camera: AnyPoints3) -> AnyPoints2:
        """Pixels of points in the camera frame; points behind the camera give NaN."""
        depth = np.where(points_in_camera[..., 2] > 0, points_in_camera[..., 2], np.nan)
        distorted = self.distort(points_in_camera[..., :2] / depth[..., None])
        return np.stack(
            [
                self.fx * distorted[..., 0] + self.skew * distorted[..., 1] + self.cx,
                self.fy * distorted[..., 1] + self.cy,
            ],
            axis=-1,
        )

    def normalize(self, xy_px: AnyPoints2) -> AnyPoints2:
        """Ideal normalized coordinates (X/Z, Y/Z) of pixels, by fixed-point iteration."""
        yd = (xy_px[..., 1] - self.cy) / self.fy
        xd = (xy_px[..., 0] - self.cx - self.skew * yd) / self.fx
        target = np.stack([xd, yd], axis=-1)
        ideal = target
        for _ in range(_UNDISTORT_STEPS):
            ideal = ideal + (target - self.distort(ideal))
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

    @property
    def centre_in_world(self) -> np.ndarray:
        return self.camera_from_world.centre

    @property
    def packed(self) -> Float64[np.ndarray, "22"]:
        """Rotation (9, row-major), translation (3), lens (10): one row for kernels."""
        pose = self.camera_from_world
        return np.concatenate([pose.rotation.ravel(), pose.translation, self.camera.packed])


def without_skew(camera: Camera, xy_px: Points2) -> Points2:
    """Pixels as the same camera without skew would have them."""
    straight = xy_px.copy()
    straight[:, 0] -= camera.skew * (xy_px[:, 1] - camera.cy) / camera.fy
    return straight


POSE_SIZE = 6
LENS_SIZE = 10


@njit(cache=True, nogil=True)
def project_and_differentiate(
    view: np.ndarray,
    point: np.ndarray,
    xy: np.ndarray,
    by_point: np.ndarray,
    by_pose: np.ndarray,
    by_lens: np.ndarray,
) -> float:
    """Fill pixel `xy` (2) and its derivatives by point (2, 3), pose (2, 6) and lens (2, 10).

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
    k1, k2, p1, p2, k3 = view[17], view[18], view[19], view[20], view[21]

    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3))
    xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    xy[0] = fx * xd + skew * yd + cx
    xy[1] = fy * yd + cy

    xd_x = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    xd_y = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    yd_y = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
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
    _by_distortion(by_lens, 5, x * r2, y * r2, fx, fy, skew)
    _by_distortion(by_lens, 6, x * r2 * r2, y * r2 * r2, fx, fy, skew)
    _by_distortion(by_lens, 7, 2.0 * x * y, r2 + 2.0 * y * y, fx, fy, skew)
    _by_distortion(by_lens, 8, r2 + 2.0 * x * x, 2.0 * x * y, fx, fy, skew)
    _by_distortion(by_lens, 9, x * r2 * r2 * r2, y * r2 * r2 * r2, fx, fy, skew)
    return depth


@njit(cache=True, nogil=True)
def differentiate_all(
    view: np.ndarray,
    points: np.ndarray,
    by_point: np.ndarray,
    by_pose: np.ndarray,
    by_lens: np.ndarray,
) -> None:
    """Fill the derivatives of every point's pixel: (n, 2, 3), (n, 2, 6) and (n, 2, 10)."""
    xy = np.empty(2)
    for k in range(len(points)):
        project_and_differentiate(view, points[k], xy, by_point[k], by_pose[k], by_lens[k])


@njit(cache=True, nogil=True, inline="always")
def _by_distortion(
    by_lens: np.ndarray, column: int, dx: float, dy: float, fx: float, fy: float, skew: float
) -> None:
    """Write how pixels move when distorted coordinates move by (dx, dy)."""
    by_lens[0, column] = fx * dx + skew * dy
    by_lens[1, column] = fy * dy


def turned(
    view: Float64[np.ndarray, "22"], step: Float64[np.ndarray, "6"]
) -> Float64[np.ndarray, "22"]:
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
