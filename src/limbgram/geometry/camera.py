"""The lens: pinhole with skew and Brown-Conrady distortion, in OpenCV's convention.

Pixel (0, 0) is the CENTRE of the top left pixel. The camera looks along +z, x right, y down.
Photos are used in the sensor's orientation; EXIF orientation only turns pictures for people.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from limbgram.geometry.arrays import Matrix3, Points2, Points3
from limbgram.geometry.rigid import Rigid

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

    def distort(self, normalized: Points2) -> Points2:
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

    def project(self, points_in_camera: Points3) -> Points2:
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

    def normalize(self, xy_px: Points2) -> Points2:
        """Ideal normalized coordinates (X/Z, Y/Z) of pixels, by fixed-point iteration."""
        yd = (xy_px[..., 1] - self.cy) / self.fy
        xd = (xy_px[..., 0] - self.cx - self.skew * yd) / self.fx
        target = np.stack([xd, yd], axis=-1)
        ideal = target
        for _ in range(_UNDISTORT_STEPS):
            ideal = ideal + (target - self.distort(ideal))
        return ideal

    def rays(self, xy_px: Points2) -> Points3:
        """Unit directions in the camera frame."""
        ideal = self.normalize(xy_px)
        directions = np.concatenate([ideal, np.ones((*ideal.shape[:-1], 1))], axis=-1)
        return directions / np.linalg.norm(directions, axis=-1, keepdims=True)

    def contains(self, xy_px: Points2, margin_px: float = 0.0) -> np.ndarray:
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

    def project(self, points_in_world: Points3) -> Points2:
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
