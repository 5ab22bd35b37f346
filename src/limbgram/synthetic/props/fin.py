"""A thin part: an upright fin on the limb's side, as an ear or the blade of a bone.

The fin is pushed out of the skin, so that the limb stays one closed surface; the chart's columns
crowd on its two sides, which stand steeply.
"""

import numpy as np
from jaxtyping import Float64
from numpy.typing import NDArray

from limbgram.geometry.rigid import turn_rad

HEIGHT_MM = 12.0
"""How far the fin stands out."""
_LENGTH_MM = 60.0
_MIDDLE = 0.45
"""Its middle, as a fraction of the limb's height."""
_ANGLE = np.radians(-40.0)
_FINE = 20_000


def fin_rise_mm(
    angles: NDArray[np.float64],
    height: NDArray[np.float64],
    radius_mm: NDArray[np.float64],
    limb_mm: float,
    thickness_mm: float,
) -> Float64[np.ndarray, "n c"]:
    """Rise of the skin; the fin has `thickness_mm` at half its height."""
    aside = turn_rad(angles, _ANGLE) * radius_mm
    along = 1 / (1 + np.abs((height - _MIDDLE * limb_mm) / (_LENGTH_MM / 2)) ** 6)
    return HEIGHT_MM * along / (1 + np.abs(aside / (thickness_mm / 2)) ** 8)


def columns_round(radius_mm: float, step_mm: float, thickness_mm: float) -> NDArray[np.float64]:
    """Angles in equal steps along the section through the fin's middle; 0 to nearly 2 pi."""
    if thickness_mm == 0:
        count = round(2 * np.pi * radius_mm / step_mm)
        return 2 * np.pi * np.arange(count) / count
    angles = np.linspace(0, 2 * np.pi, _FINE + 1)
    at = np.array([[_MIDDLE]])
    rise = fin_rise_mm(angles, at, np.array([[radius_mm]]), 1.0, thickness_mm)[0]
    length = np.concatenate([[0], np.cumsum(np.hypot(np.diff(angles) * radius_mm, np.diff(rise)))])
    count = round(length[-1] / step_mm)
    return np.interp(length[-1] * np.arange(count) / count, length, angles)
