"""The region: the part of the world that is the limb."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool
from scipy import ndimage

from limbgram.geometry.arrays import Points3, Vector3


@dataclass(frozen=True, kw_only=True)
class Region:
    """A grid of cubes, true where the limb's surface may be.

    Cube (i, j, k) spans origin_mm + cell_mm * (i..i+1, j..j+1, k..k+1), world axes.
    """

    origin_mm: Vector3
    cell_mm: float
    occupied: Bool[np.ndarray, "i j k"]

    @property
    def box_mm(self) -> tuple[Vector3, Vector3]:
        """Lowest and highest corner of what is occupied."""
        cells = np.argwhere(self.occupied)
        low = self.origin_mm + self.cell_mm * cells.min(0)
        return low, self.origin_mm + self.cell_mm * (cells.max(0) + 1)

    def contains(self, points_mm: Points3) -> Bool[np.ndarray, " n"]:
        cells = np.floor((points_mm - self.origin_mm) / self.cell_mm).astype(np.int64)
        inside = np.all((cells >= 0) & (cells < self.occupied.shape), axis=-1)
        cells = np.where(inside[..., None], cells, 0)
        return inside & self.occupied[cells[..., 0], cells[..., 1], cells[..., 2]]

    def centres_mm(self, cells: Bool[np.ndarray, "i j k"]) -> Points3:
        """Centres of the cubes that `cells` marks."""
        return self.origin_mm + self.cell_mm * (np.argwhere(cells) + 0.5)

    def skin(self) -> Bool[np.ndarray, "i j k"]:
        """The occupied cubes that share a side with an empty one or with the grid's border."""
        return self.occupied & ~ndimage.binary_erosion(self.occupied)
