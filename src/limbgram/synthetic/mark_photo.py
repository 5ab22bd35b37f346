"""Mark photo: a rendered photo of one coded mark on flat or cylindrical skin.

In      the mark, its size, the radius of the skin, the camera and its pose.
Out     a grey photo and the exact pixels of the mark's corners.
Method  every pixel is the mean of FINE x FINE rays, in linear light; then blur, photon and read
        noise, and sRGB tones, as `rendering/developing` has them.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float64, UInt8

from limbgram.core.geometry.arrays import GreyImage, Points2, Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.targets.board import KIT_DICTIONARY, marker_dictionary
from limbgram.synthetic.rendering.developing import developed, softened

FINE = 6
"""Rays along a pixel's side."""
_BLACK, _WHITE, _SKIN = 0.04, 0.75, 0.35


@dataclass(frozen=True, kw_only=True)
class MarkShot:
    """A mark before a camera."""

    camera: Camera
    camera_from_mark: Rigid
    """Mark frame: origin in its middle on the skin, x right and y down as printed, z inwards."""
    mark_id: int = 0
    dictionary: str = KIT_DICTIONARY
    side_mm: float = 16.0
    radius_mm: float = float("inf")
    """Radius of the cylinder that it is stuck on."""
    twist_deg: float = 0.0
    """Angle of the mark's x from the direction round the cylinder."""
    blur_px: float = 0.5
    noise: float = 1.0
    seed: int = 0


@dataclass(frozen=True)
class MarkPhoto:
    """The photo, and the exact corners and centre of the mark."""

    luma: GreyImage
    corners_px: Float64[np.ndarray, "4 2"]
    centre_px: Float64[np.ndarray, "2"]


def photograph_mark(shot: MarkShot) -> MarkPhoto:
    """Render the photo."""
    half = shot.side_mm / 2
    printed = np.array([(-half, -half), (half, -half), (half, half), (-half, half), (0, 0)])
    exact = shot.camera.project(shot.camera_from_mark.apply(_on_skin(shot, printed)))
    camera = shot.camera
    picture = np.full((camera.height_px, camera.width_px), _SKIN, np.float32)
    low = np.floor(exact.min(0) - 0.4 * np.ptp(exact, axis=0) - 8).astype(int)
    high = np.ceil(exact.max(0) + 0.4 * np.ptp(exact, axis=0) + 8).astype(int)
    left, top = np.maximum(low, 0).tolist()
    right, bottom = np.minimum(high, [camera.width_px, camera.height_px]).tolist()
    seen = _reflectance(shot, _hits(shot, _rays(camera, left, top, right, bottom)))
    seen = seen.reshape(bottom - top, FINE, right - left, FINE)
    picture[top:bottom, left:right] = seen.mean(axis=(1, 3))
    colour = softened(np.repeat(picture[..., None], 3, axis=2), shot.blur_px)
    pixels = developed(colour, shot.noise, np.random.default_rng((shot.seed, 20)))
    luma = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY), np.uint8)
    return MarkPhoto(luma, exact[:4], exact[4])


def _on_skin(shot: MarkShot, printed_mm: Points2) -> Points3:
    """Points of the print in the mark's frame."""
    if np.isinf(shot.radius_mm):
        return np.column_stack([printed_mm, np.zeros(len(printed_mm))])
    around = printed_mm @ _turn(shot)
    angle = around[:, 0] / shot.radius_mm
    round_it = np.column_stack(
        [
            shot.radius_mm * np.sin(angle),
            around[:, 1],
            shot.radius_mm * (1 - np.cos(angle)),
        ]
    )
    round_it[:, :2] = round_it[:, :2] @ _turn(shot).T
    return round_it


def _turn(shot: MarkShot) -> Float64[np.ndarray, "2 2"]:
    """Columns: the directions round the cylinder and along it, on the print."""
    twist = np.radians(shot.twist_deg)
    return np.array([[np.cos(twist), -np.sin(twist)], [np.sin(twist), np.cos(twist)]])


def _rays(camera: Camera, left: int, top: int, right: int, bottom: int) -> Points3:
    """Directions of the rays of all pixels; the lens is linear within a pixel."""
    x, y = np.arange(left, right + 1) - 0.5, np.arange(top, bottom + 1) - 0.5
    lattice = camera.normalize(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))
    ideal = lattice.reshape(len(y), len(x), 2)
    share = ((np.arange(FINE) + 0.5) / FINE)[:, None]
    rows = ideal[:-1, None] * (1 - share[:, None]) + ideal[1:, None] * share[:, None]
    rows = rows.reshape(-1, len(x), 2)
    columns = rows[:, :-1, None] * (1 - share) + rows[:, 1:, None] * share
    flat = columns.reshape(-1, 2)
    return np.column_stack([flat, np.ones(len(flat))])


def _hits(shot: MarkShot, rays: Points3) -> Points2:
    """Points of the print that rays hit; NaN beside the skin."""
    mark_from_camera = shot.camera_from_mark.inverse
    directions = rays @ mark_from_camera.rotation.T
    start = mark_from_camera.translation
    if np.isinf(shot.radius_mm):
        distance = -start[2] / directions[:, 2]
        return (start + distance[:, None] * directions)[:, :2]
    turn = _turn(shot)
    directions = np.column_stack([directions[:, :2] @ turn, directions[:, 2]])
    start = np.append(start[:2] @ turn, start[2])
    # (x, z) of the ray on the circle x^2 + (z - radius)^2 = radius^2, the nearer crossing
    dx, dz = directions[:, 0], directions[:, 2]
    x, z = start[0], start[2] - shot.radius_mm
    a, b = dx**2 + dz**2, x * dx + z * dz
    root = b**2 - a * (x**2 + z**2 - shot.radius_mm**2)
    distance = (-b - np.sqrt(np.where(root >= 0, root, np.nan))) / a
    hit = start + distance[:, None] * directions
    around = shot.radius_mm * np.arctan2(hit[:, 0], shot.radius_mm - hit[:, 2])
    return np.column_stack([around, hit[:, 1]]) @ turn.T


def _reflectance(shot: MarkShot, printed_mm: Points2) -> Float64[np.ndarray, " n"]:
    """Reflectance of mark, paper or skin."""
    codes = marker_dictionary(shot.dictionary)
    cells = codes.markerSize + 2
    pattern: UInt8[np.ndarray, "c c"] = codes.generateImageMarker(shot.mark_id, cells)
    at = (printed_mm / shot.side_mm + 0.5) * cells
    paper = np.abs(at - cells / 2).max(1) <= cells / 2 + 1.5
    inside = np.abs(at - cells / 2).max(1) < cells / 2
    i, j = np.floor(np.where(inside[:, None], at, 0)).astype(int).T
    shade = np.where(pattern[j, i] > 0, _WHITE, _BLACK)
    return np.where(inside, shade, np.where(paper, _WHITE, _SKIN))
