"""The grid of a file of radii: at which angles and heights they stand."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

_EVEN_DEG = 1e-3
"""Files hold a spacing to six decimals, which adds up over a turn."""


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Angles and heights round the z axis of the mesh that was made of the radii."""

    thetas_deg: Float64[np.ndarray, " n"]
    """Rising, within one turn."""
    z_mm: Float64[np.ndarray, " m"]
    """Rising, from the origin of the file."""

    @property
    def even(self) -> bool:
        """Whether a number of spokes tells their angles, from the front on."""
        count = len(self.thetas_deg)
        off_deg = self.thetas_deg - 360.0 / count * np.arange(count)
        return bool(np.abs(off_deg).max() < _EVEN_DEG)
