"""Projection of board corners into one photo, with its derivatives.

The unknowns that all photos share are the lens (geometry.camera.PARAMETERS) followed by the
board's shape (BOARD_TERMS); each photo adds a pose of six: a small rotation applied after the
present one, and a translation in millimetres.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from limbgram.geometry.arrays import Points2, Points3
from limbgram.geometry.camera import PARAMETERS
from limbgram.geometry.rigid import Rigid

BOARD_TERMS = ("stretch", "shear", "bend_xx", "bend_xy", "bend_yy")
"""How a print differs from its drawing, as fractions of half the board's long side: y grows by
`stretch` of itself, x leans by `shear` of y, and z is a quadratic form of x and y."""

LENS = len(PARAMETERS)
SHARED = LENS + len(BOARD_TERMS)
POSE = 6


class Projection(NamedTuple):
    """Pixels, and their derivatives by the shared unknowns and by the photo's pose."""

    xy_px: Points2
    by_shared: Float64[np.ndarray, "n 2 15"]
    by_pose: Float64[np.ndarray, "n 2 6"]


def bent_board(corners_mm: Points3, terms: Float64[np.ndarray, "5"], plate: Points3) -> Points3:
    """Corners of the board as printed and bent, for the whole `plate` they belong to."""
    return corners_mm + np.einsum("nit,t->ni", _board_slopes(corners_mm, plate), terms)


def project_board(
    corners_mm: Points3, plate: Points3, shared: Float64[np.ndarray, "15"], pose: Rigid
) -> Projection:
    """Corners in pixels, with derivatives.

    Args:
        plate: All corners of the board: they set the origin and size of its shape's terms.
        pose: camera_from_board.
    """
    slopes = _board_slopes(corners_mm, plate)
    on_board = corners_mm + slopes @ shared[LENS:]
    turned = on_board @ pose.rotation.T
    in_camera = turned + pose.translation
    inverse = 1.0 / in_camera[:, 2]
    x, y = in_camera[:, 0] * inverse, in_camera[:, 1] * inverse
    xy_px, by_ideal, by_lens = lens_slopes(x, y, shared[:LENS])

    by_point = np.empty((len(x), 2, 3))
    by_point[:, :, 0] = by_ideal[:, :, 0] * inverse[:, None]
    by_point[:, :, 1] = by_ideal[:, :, 1] * inverse[:, None]
    by_point[:, :, 2] = -(by_point[:, :, 0] * x[:, None] + by_point[:, :, 1] * y[:, None])

    by_pose = np.empty((len(x), 2, POSE))
    by_pose[:, :, :3] = np.cross(turned[:, None, :], by_point)
    by_pose[:, :, 3:] = by_point
    by_board = np.einsum("nij,jk,nkt->nit", by_point, pose.rotation, slopes)
    return Projection(xy_px, np.concatenate([by_lens, by_board], axis=2), by_pose)


def moved(pose: Rigid, step: Float64[np.ndarray, "6"]) -> Rigid:
    """A pose after a step of its six unknowns."""
    turn = Rigid.from_rotation_vector(step[:3], np.zeros(3))
    return Rigid(turn.rotation @ pose.rotation, pose.translation + step[3:])


def _board_slopes(corners_mm: Points3, plate: Points3) -> Float64[np.ndarray, "n 3 5"]:
    """Derivatives of the corners by the board's terms; its shape is linear in them."""
    middle = 0.5 * (plate.min(axis=0) + plate.max(axis=0))
    half_mm = 0.5 * float(np.ptp(plate, axis=0).max())
    u, v = ((corners_mm - middle)[:, :2] / half_mm).T
    slopes = np.zeros((len(corners_mm), 3, len(BOARD_TERMS)))
    slopes[:, 1, 0] = v
    slopes[:, 0, 1] = v
    slopes[:, 2, 2] = u * u
    slopes[:, 2, 3] = u * v
    slopes[:, 2, 4] = v * v
    return slopes * half_mm


class LensSlopes(NamedTuple):
    """Pixels with their derivatives by the ideal coordinates and by the lens."""

    xy_px: Points2
    by_ideal: Float64[np.ndarray, "n 2 2"]
    by_lens: Float64[np.ndarray, "n 2 10"]


def lens_slopes(x: np.ndarray, y: np.ndarray, lens: Float64[np.ndarray, "10"]) -> LensSlopes:
    """geometry.camera.Camera.project with its derivatives by (X/Z, Y/Z) and by the lens."""
    fx, fy, cx, cy, skew, k1, k2, p1, p2, k3 = lens
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3))
    xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y

    cross = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    by_ideal = np.empty((len(x), 2, 2))
    xd_by_x = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    yd_by_y = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    by_ideal[:, 0, 0] = fx * xd_by_x + skew * cross
    by_ideal[:, 0, 1] = fx * cross + skew * yd_by_y
    by_ideal[:, 1, 0] = fy * cross
    by_ideal[:, 1, 1] = fy * yd_by_y

    by_lens = np.zeros((len(x), 2, LENS))
    by_lens[:, 0, 0], by_lens[:, 1, 1] = xd, yd
    by_lens[:, 0, 2] = by_lens[:, 1, 3] = 1.0
    by_lens[:, 0, 4] = yd
    for column, power in ((5, r2), (6, r2**2), (9, r2**3)):
        by_lens[:, 0, column] = fx * x * power + skew * y * power
        by_lens[:, 1, column] = fy * y * power
    tilt_x, tilt_y = r2 + 2.0 * x * x, r2 + 2.0 * y * y
    by_lens[:, 0, 7] = fx * 2.0 * x * y + skew * tilt_y
    by_lens[:, 1, 7] = fy * tilt_y
    by_lens[:, 0, 8] = fx * tilt_x + skew * 2.0 * x * y
    by_lens[:, 1, 8] = fy * 2.0 * x * y
    return LensSlopes(np.stack([fx * xd + skew * yd + cx, fy * yd + cy], axis=1), by_ideal, by_lens)
