"""Landmark: a named point on the surface, and how well it was placed."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from limbgram.core.geometry.arrays import Vector3

Placed = Literal["click", "painted", "proposed"]
"""By a click on the surface; at a mark that was painted on the limb; proposed by the program from
the shape, and confirmed."""
PLACING_MM: Mapping[Placed, float] = MappingProxyType(
    {"click": 2.0, "painted": 1.0, "proposed": 3.0}
)
"""Standard deviation in each direction along the surface, by the way of placing, where nobody says
another. Assumed, without a source: they do not hold what a finger errs in feeling for the bone. Who
knows better states `Landmark.sigma_mm`."""


@dataclass(frozen=True, kw_only=True)
class Landmark:
    """A named point on the surface."""

    name: str
    position_mm: Vector3
    """In the mesh's frame."""
    placed: Placed = "click"
    sigma_mm: float | None = None
    """How well it was placed: one standard deviation in each direction along the surface; None for
    what is usual of the way of placing."""

    @property
    def placing_mm(self) -> float:
        """How well it was placed, as stated or as is usual."""
        return PLACING_MM[self.placed] if self.sigma_mm is None else self.sigma_mm
