"""Shading: a picture of a mesh by a z-buffer, parallel projection, three soft lights."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, UInt8

from limbgram.core.geometry.arrays import Faces, Matrix3, Points3
from limbgram.core.geometry.frames import rotated, towards
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.run import in_parallel

CLAY = np.array([214.0, 206.0, 196.0])
FILLED = (222.0, 138.0, 70.0)
"""Colour of what no photo measured."""
_LIGHTS = (
    (np.array([-0.45, -0.55, -0.70]), 0.75),
    (np.array([0.80, -0.20, -0.55]), 0.28),
    (np.array([0.10, 0.90, -0.40]), 0.12),
)
"""Directions towards the lights in the picture's frame (x right, y down, z away), and strengths."""
_AMBIENT = 0.16
_PAINT_RELIEF = 0.45
"""Share of the shading on painted surfaces: their colours have to be read."""
_OVERSAMPLING = 2


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Parallel projection: which way to look, what is in the middle, how large a pixel is."""

    picture_from_world: Matrix3
    """Rotation to x right, y down, z away from the viewer."""
    middle_mm: Float64[np.ndarray, "3"]
    pixel_mm: float
    width_px: int
    height_px: int

    def project(self, points_mm: Points3) -> Points3:
        """Pixels x and y, and depth in pixels."""
        seen = rotated(points_mm - self.middle_mm, self.picture_from_world) / self.pixel_mm
        return seen + np.array([(self.width_px - 1) / 2, (self.height_px - 1) / 2, 0.0])


def looking_along(azimuth_deg: float, elevation_deg: float = 0.0) -> Matrix3:
    """Rotation of a picture seen from this side of the world's z axis, z up."""
    azimuth, elevation = np.radians([azimuth_deg, elevation_deg])
    viewer = towards(azimuth, elevation)
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    return np.stack([right, np.cross(-viewer, right), -viewer])


def shade(
    mesh: Mesh, frame: Frame, paint: Float64[np.ndarray, "n 3"] | None = None
) -> UInt8[np.ndarray, "h w 4"]:
    """The mesh in clay, its filled part coloured; transparent where nothing is.

    paint: colour of every vertex, 0 to 255, instead of clay.
    """
    return shade_all(mesh, [frame], paint)[0]


def shade_all(
    mesh: Mesh, frames: Sequence[Frame], paint: Float64[np.ndarray, "n 3"] | None = None
) -> list[UInt8[np.ndarray, "h w 4"]]:
    """`shade` for several frames, side by side on the processors."""
    return [picture for (picture,) in shade_each(mesh, frames, [paint])]


def shade_each(
    mesh: Mesh, frames: Sequence[Frame], paints: Sequence[Float64[np.ndarray, "n 3"] | None]
) -> list[list[UInt8[np.ndarray, "h w 4"]]]:
    """For each frame a picture in each paint; what is in sight is found once a frame."""
    n = _OVERSAMPLING
    normals = mesh.vertex_normals()
    filled = (~mesh.measured).astype(float)
    toward = np.array([direction / np.linalg.norm(direction) for direction, _ in _LIGHTS])
    lights = toward * np.array([[strength] for _, strength in _LIGHTS])

    def pictures(frame: Frame) -> list[UInt8[np.ndarray, "h w 4"]]:
        pixels = frame.project(mesh.vertices_mm)
        pixels[:, :2] = (pixels[:, :2] + 0.5) * n - 0.5
        face_idx, weights = rasterise(pixels, mesh.faces, frame.height_px * n, frame.width_px * n)
        facing = rotated(normals, frame.picture_from_world)
        # matplotlib 3.9 draws no array that a kernel from numba's cache made: its type is a copy.
        lit = [np.zeros((frame.height_px, frame.width_px, 4), np.uint8) for _ in paints]
        for paint, picture in zip(paints, lit):
            _shade_pixels(
                face_idx,
                weights,
                mesh.faces,
                facing,
                lights,
                filled,
                np.array([CLAY]) if paint is None else np.ascontiguousarray(paint, np.float64),
                1.0 if paint is None else _PAINT_RELIEF,
                picture,
            )
        return lit

    return in_parallel(pictures, frames)


@njit(cache=True, nogil=True)
def _shade_pixels(
    face_idx: np.ndarray,
    weights: np.ndarray,
    faces: np.ndarray,
    normals: np.ndarray,
    lights: np.ndarray,
    filled: np.ndarray,
    paint: np.ndarray,
    relief: float,
    picture: np.ndarray,
) -> None:
    """Fill colour by light, of the ground or of what is filled, and opacity.

    Each is the mean of the samples of a pixel, as many along each side as `face_idx` has more rows.
    """
    height, width, _ = picture.shape
    n = face_idx.shape[0] // height
    normal, ground, total = np.empty(3), np.empty(3), np.empty(3)
    painted = len(paint) > 1
    for row in range(height):
        for column in range(width):
            total[:] = 0.0
            covered = 0
            for sample in range(n * n):
                y, x = n * row + sample // n, n * column + sample % n
                f = face_idx[y, x]
                if f < 0:
                    continue
                covered += 1
                normal[:] = 0.0
                ground[:] = 0.0
                share = 0.0
                for corner in range(3):
                    at, weight = faces[f, corner], weights[y, x, corner]
                    share += weight * filled[at]
                    for axis in range(3):
                        normal[axis] += weight * normals[at, axis]
                        ground[axis] += weight * paint[at if painted else 0, axis]
                length = max(np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2), 1e-12)
                light = _AMBIENT
                for k in range(len(lights)):
                    facing = normal[0] * lights[k, 0] + normal[1] * lights[k, 1]
                    light += max((facing + normal[2] * lights[k, 2]) / length, 0.0)
                light = 1 + relief * (light - 1)
                for axis in range(3):
                    colour = FILLED[axis] if share > 0.5 else ground[axis]
                    total[axis] += min(max(colour * light, 0.0), 255.0)
            if covered:
                for axis in range(3):
                    picture[row, column, axis] = round(total[axis] / covered)
                picture[row, column, 3] = round(255 * covered / (n * n))


@njit(cache=True, nogil=True)
def rasterise(pixels: Points3, faces: Faces, height: int, width: int):
    """Nearest face at each pixel (-1: none) and the weights of its three corners."""
    depth = np.full((height, width), np.inf)
    face_idx = np.full((height, width), -1, np.int32)
    weights = np.zeros((height, width, 3))
    for f in range(len(faces)):
        ax, ay, az = pixels[faces[f, 0], 0], pixels[faces[f, 0], 1], pixels[faces[f, 0], 2]
        bx, by, bz = pixels[faces[f, 1], 0], pixels[faces[f, 1], 1], pixels[faces[f, 1], 2]
        cx, cy, cz = pixels[faces[f, 2], 0], pixels[faces[f, 2], 1], pixels[faces[f, 2], 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0:
            continue
        left = max(0, int(np.ceil(min(ax, bx, cx))))
        right = min(width - 1, int(np.floor(max(ax, bx, cx))))
        top = max(0, int(np.ceil(min(ay, by, cy))))
        bottom = min(height - 1, int(np.floor(max(ay, by, cy))))
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                wa = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
                wb = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
                wc = 1 - wa - wb
                if wa < 0 or wb < 0 or wc < 0:
                    continue
                z = wa * az + wb * bz + wc * cz
                if z < depth[y, x]:
                    depth[y, x] = z
                    face_idx[y, x] = f
                    weights[y, x, 0], weights[y, x, 1], weights[y, x, 2] = wa, wb, wc
    return face_idx, weights
