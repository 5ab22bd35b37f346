"""Cloud: oriented points, as depth maps make them and a surface takes them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, UInt8


@dataclass(frozen=True, kw_only=True)
class Cloud:
    """Oriented points of the surface."""

    points_mm: Float32[np.ndarray, "n 3"]
    normals: Float32[np.ndarray, "n 3"]
    """Unit, outwards."""
    colours: UInt8[np.ndarray, "n 3"]
    views: UInt8[np.ndarray, " n"]
    """Number of photos that agree on the point."""
    spacing_mm: float
    """Typical distance between neighbours."""

    def __len__(self) -> int:
        return len(self.points_mm)
