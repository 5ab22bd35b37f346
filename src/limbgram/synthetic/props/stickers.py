"""Stickers: coded marks on the limb's skin, printed at exact size, at known places.

In      a Limb, the texture of its skin, and which mark is stuck where.
Out     the texture with the marks on it, and the true centres.
Method  texels near a sticker's centre are projected onto the tangent plane there, and take the
        share of black that the print has in them. On skin of 50 mm radius a mark of 16 mm is so
        0.07 mm narrower than its print; its centre is exact.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, UInt8
from scipy.ndimage import map_coordinates

from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import rotation_to_axes
from limbgram.reconstruction.targets.board import KIT_DICTIONARY, marker_dictionary
from limbgram.synthetic.props.limb import Limb
from limbgram.synthetic.props.paint import SockSpot, chart_place

_BLACK, _WHITE = 52.0, 226.0
_BORDER_CELLS = 1
_SAMPLES = 3
"""Along a texel's side."""


@dataclass(frozen=True, kw_only=True)
class SockSticker:
    """A coded mark on the skin."""

    mark_id: int
    around: float
    """Share of the way round the limb, 0 to 1."""
    height: float
    """Share of the limb's height, 0 at the cut and 1 at the distal end."""
    side_mm: float = 16.0
    """Side of the mark, without its white border."""
    twist_deg: float = 0.0

    @property
    def spot(self) -> SockSpot:
        """A spot at the same place."""
        return SockSpot(around=self.around, height=self.height)


def sticker_places_mm(limb: Limb, stickers: Sequence[SockSticker]) -> tuple[Vector3, ...]:
    """Centres on the true surface, in the world."""
    at = (chart_place(limb, one.spot) for one in stickers)
    return tuple(limb.grid_mm[row, column].astype(np.float64) for row, column in at)


def stick(
    texture: UInt8[np.ndarray, "rows columns 4"], limb: Limb, stickers: Sequence[SockSticker]
) -> None:
    """Paint the stickers over a texture."""
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
    bottom, top = max(rows[0] - 1, 0), min(rows[-1] + 1, len(grid) - 1)
    texel_rows = np.arange(bottom * fine, top * fine + 1)
    first, stop = _column_range(columns, grid.shape[1] - 1)
    texel_columns = (first * fine + np.arange((stop - first) * fine)) % (texture.shape[1] - 1)
    white_samples = np.zeros((len(texel_rows), len(texel_columns)))
    covered = np.zeros(white_samples.shape, bool)
    frame = _frame(grid, row, column, np.radians(one.twist_deg))
    offsets = (np.arange(_SAMPLES) + 0.5) / _SAMPLES - 0.5
    for down in offsets:
        for right in offsets:
            at = np.stack(
                np.meshgrid(
                    (texel_rows + down) / fine, (texel_columns + right) / fine, indexing="ij"
                )
            ).reshape(2, -1)
            points = [map_coordinates(grid[..., k], at, order=1, mode="nearest") for k in range(3)]
            from_centre = np.stack(points, axis=-1) - grid[row, column]
            white, on_sticker = _printed(from_centre @ frame.T, one)
            white_samples += white.reshape(covered.shape)
            covered |= on_sticker.reshape(covered.shape)
    tone = _BLACK + (_WHITE - _BLACK) * white_samples / _SAMPLES**2
    patch = texture[np.ix_(texel_rows, texel_columns)]
    patch[covered, :3] = np.rint(tone)[covered, None].astype(np.uint8)
    texture[np.ix_(texel_rows, texel_columns)] = patch


def _column_range(columns: np.ndarray, count: int) -> tuple[int, int]:
    """First column and the one behind the last, with a margin; may run over the chart's seam."""
    gaps = np.diff(np.append(columns, columns[0] + count))
    widest = int(np.argmax(gaps))
    first = int(columns[(widest + 1) % len(columns)])
    last = int(columns[widest])
    return first - 1, (last if last >= first else last + count) + 2


def _frame(
    grid: Float64[np.ndarray, "r c 3"], row: int, column: int, twist_rad: float
) -> Float64[np.ndarray, "3 3"]:
    """Axes of the print as rows: right, down, and into the skin."""
    across = grid[row, column + 1] - grid[row, column - 1 if column else -2]
    along = grid[row + 1, column] - grid[row - 1, column]
    outward = np.cross(across, along)
    middle = grid[row].mean(0)
    outward *= np.sign(outward @ (grid[row, column] - middle)) / np.linalg.norm(outward)
    right, down, inward = rotation_to_axes(-outward, across)
    turn = np.cos(twist_rad), np.sin(twist_rad)
    return np.stack([turn[0] * right + turn[1] * down, -turn[1] * right + turn[0] * down, inward])


def _printed(
    places_mm: Float64[np.ndarray, "n 3"], one: SockSticker
) -> tuple[Float64[np.ndarray, " n"], np.ndarray]:
    """Whether each point is white, 0 or 1, and whether it lies on the sticker."""
    codes = marker_dictionary(KIT_DICTIONARY)
    cells = codes.markerSize + 2
    pattern = np.asarray(codes.generateImageMarker(one.mark_id, cells))
    at = (places_mm[:, :2] / one.side_mm + 0.5) * cells
    off = np.abs(at - cells / 2).max(1)
    # The depth excludes the far side of the limb, which projects onto the same plane.
    on_sticker = (off <= cells / 2 + _BORDER_CELLS) & (np.abs(places_mm[:, 2]) < one.side_mm / 2)
    inside = on_sticker & (off < cells / 2)
    i, j = np.floor(np.where(inside[:, None], at, 0)).astype(int).T
    white = np.where(inside, (pattern[j, i] > 0).astype(float), 1.0)
    return white, on_sticker
