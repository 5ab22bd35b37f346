"""Spots: round marks of one plain colour, painted over all dabs at known places of the skin."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from limbgram.geometry.arrays import Vector3
from limbgram.synthetic.props.limb import Limb

MAGENTA = (235, 20, 200)
"""A colour that no dab has."""
_LOWEST, _HIGHEST = 0.25, 0.85
_GOLDEN = 0.381966


@dataclass(frozen=True, kw_only=True)
class PaintedSpot:
    """A disc on the skin."""

    around: float
    """Share of the way round the limb, 0 to 1."""
    height: float
    """Share of the limb's height, 0 at the cut and 1 at the distal end."""
    colour: tuple[int, int, int] = MAGENTA
    diameter_mm: float = 9.0


def scattered_spots(count: int) -> tuple[PaintedSpot, ...]:
    """Spots spread evenly round the limb and along it."""
    heights = np.linspace(_LOWEST, _HIGHEST, count)
    return tuple(
        PaintedSpot(around=(k * _GOLDEN) % 1.0, height=float(height))
        for k, height in enumerate(heights)
    )


def chart_place(limb: Limb, spot: PaintedSpot) -> tuple[int, int]:
    """Row and column of the chart's point that is the middle of the spot."""
    columns = limb.grid_mm.shape[1] - 1
    column = int(spot.around * columns) % columns
    skin = np.flatnonzero(np.diff(limb.grid_mm[:, column, 2]) > 0)
    heights = limb.grid_mm[skin, column, 2] - limb.base_mm
    return int(skin[np.argmin(np.abs(heights - spot.height * limb.height_mm))]), column


def places_mm(limb: Limb, spots: Sequence[PaintedSpot]) -> tuple[Vector3, ...]:
    """Middles of the spots on the true surface, in the world."""
    at = (chart_place(limb, spot) for spot in spots)
    return tuple(limb.grid_mm[row, column].astype(np.float64) for row, column in at)
