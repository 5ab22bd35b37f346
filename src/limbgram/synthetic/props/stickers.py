"""Stickers: coded marks stuck on the limb's skin, printed true, at known places.

In      a Limb, the texture of its skin, and which mark is stuck where.
Out     the same texture with the marks on it, and the true middles.
Method  every texel near a sticker's middle is laid on the plane that touches the skin there, and
        takes the share of black that the print has round it. On skin of 50 mm radius a mark of
        16 mm is 0.07 mm narrower than its print by this; its middle is exact.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, UInt8
from scipy.ndimage import map_coordinates

from limbgram.core.geometry.arrays import Vector3
from limbgram.reconstruction.targets.board import KIT_DICTIONARY, marker_dictionary
from limbgram.synthetic.props.limb import Limb
from limbgram.synthetic.props.paint import SockSpot, chart_place

_BLACK, _WHITE = 52.0, 226.0
_BORDER_CELLS = 1
_PARTS = 3
"""Samples along a texel's side."""


@dataclass(frozen=True, kw_only=True)
class SockSticker:
    """A coded mark on the skin."""

    mark_id: int
    around: float
    """Share of the way round the limb, 0 to 1."""
    height: float
    """Share of the limb's height, 0 at the cut and 1 at the distal end."""
    side_mm: float = 16.0
    """Of the mark, without its white border."""
    twist_deg: float = 0.0

    @property
    def spot(self) -> SockSpot:
        """Where it is, as a spot."""
        return SockSpot(around=self.around, height=self.height)


def sticker_places_mm(limb: Limb, stickers: Sequence[SockSticker]) -> tuple[Vector3, ...]:
    """Middles on the true surface, in the world."""
    at = (chart_place(limb, one.spot) for one in stickers)
    return tuple(limb.grid_mm[row, column].astype(np.float64) for row, column in at)


def stick(
    texture: UInt8[np.ndarray, "rows columns 4"], limb: Limb, stickers: Sequence[SockSticker]
) -> None:
    """Lay the stickers over whatever the texture has."""
    fine = (texture.shape[0] - 1) // (limb.grid_mm.shape[0] - 1)
    for one in stickers:
        _lay_one(texture, limb, fine, one)
    texture[:, -1] = texture[:, 0]


def _lay_one(
    texture: UInt8[np.ndarray, "rows columns 4"], limb: Limb, fine: int, one: SockSticker
) -> None:
    grid = limb.grid_mm.astype(np.float64)
    row, column = chart_place(limb, one.spot)
    reach_mm = one.side_mm
    near = np.linalg.norm(grid - grid[row, column], axis=2) < reach_mm
    rows = np.flatnonzero(near.any(1))
    columns = np.flatnonzero(near[:, :-1].any(0))
    high = np.arange(max(rows[0] - 1, 0) * fine, (rows[-1] + 1) * fine + 1)
    wide = _stretch(columns, grid.shape[1] - 1)
    texels = (wide[0] * fine + np.arange((wide[1] - wide[0]) * fine)) % (texture.shape[1] - 1)
    share = np.zeros((len(high), len(texels)))
    counted = np.zeros((len(high), len(texels)), bool)
    frame = _frame(grid, row, column, np.radians(one.twist_deg))
    offsets = (np.arange(_PARTS) + 0.5) / _PARTS - 0.5
    for down in offsets:
        for right in offsets:
            at = np.stack(
                np.meshgrid((high + down) / fine, ((texels + right) / fine), indexing="ij")
            ).reshape(2, -1)
            arms = (
                np.stack(
                    [map_coordinates(grid[..., k], at, order=1, mode="nearest") for k in range(3)],
                    axis=-1,
                )
                - grid[row, column]
            )
            white, inside = _printed(arms @ frame.T, one)
            share += white.reshape(share.shape)
            counted |= inside.reshape(share.shape)
    tone = _BLACK + (_WHITE - _BLACK) * share / _PARTS**2
    patch = texture[np.ix_(high, texels)]
    patch[counted, :3] = np.rint(tone)[counted, None].astype(np.uint8)
    texture[np.ix_(high, texels)] = patch


def _stretch(columns: np.ndarray, count: int) -> tuple[int, int]:
    """First column and the one behind the last, perhaps beyond the seam of the chart."""
    gaps = np.diff(np.append(columns, columns[0] + count))
    widest = int(np.argmax(gaps))
    first = int(columns[(widest + 1) % len(columns)])
    last = int(columns[widest])
    return first - 1, (last if last >= first else last + count) + 2


def _frame(
    grid: Float64[np.ndarray, "r c 3"], row: int, column: int, twist_rad: float
) -> Float64[np.ndarray, "3 3"]:
    """Rows: right and down on the print, seen from outside, and inwards."""
    across = grid[row, column + 1] - grid[row, column - 1 if column else -2]
    along = grid[row + 1, column] - grid[row - 1, column]
    outward = np.cross(across, along)
    middle = grid[row].mean(0)
    outward *= np.sign(outward @ (grid[row, column] - middle)) / np.linalg.norm(outward)
    inward = -outward
    right = across - (across @ inward) * inward
    right /= np.linalg.norm(right)
    down = np.cross(inward, right)
    turn = np.cos(twist_rad), np.sin(twist_rad)
    return np.stack([turn[0] * right + turn[1] * down, -turn[1] * right + turn[0] * down, inward])


def _printed(
    places_mm: Float64[np.ndarray, "n 3"], one: SockSticker
) -> tuple[Float64[np.ndarray, " n"], np.ndarray]:
    """Whether the print is white there, 0 or 1, and whether the sticker reaches there at all."""
    codes = marker_dictionary(KIT_DICTIONARY)
    cells = codes.markerSize + 2
    pattern = np.asarray(codes.generateImageMarker(one.mark_id, cells))
    at = (places_mm[:, :2] / one.side_mm + 0.5) * cells
    off = np.abs(at - cells / 2).max(1)
    # the other side of the limb lies on the same lines
    reaches = (off <= cells / 2 + _BORDER_CELLS) & (np.abs(places_mm[:, 2]) < one.side_mm / 2)
    inside = reaches & (off < cells / 2)
    i, j = np.floor(np.where(inside[:, None], at, 0)).astype(int).T
    white = np.where(inside, (pattern[j, i] > 0).astype(float), 1.0)
    return white, reaches
