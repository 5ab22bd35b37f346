"""Landmark: a named point on the surface, and how well it was placed."""

from dataclasses import dataclass
from typing import Literal

from limbgram.core.geometry.arrays import Vector3

Placed = Literal["click", "painted", "proposed"]
"""By a click on the surface; at a mark that was painted on the limb; proposed by the program from
the shape, or from another scan of the limb."""


@dataclass(frozen=True, kw_only=True)
class Landmark:
    """A named point on the surface."""

    name: str
    position_mm: Vector3
    """In the mesh's frame."""
    placed: Placed = "click"
    sigma_mm: float | None = None
    """How well it was placed: one standard deviation in each direction along the surface; None for
    what `Placing` says of the way."""
    confirmed: bool = True
    """False of a proposal that nobody has looked at yet: what is made of it says so."""


@dataclass(frozen=True, kw_only=True)
class Placing:
    """How well landmarks are placed: one standard deviation in each direction along the surface.

    Assumed, without a source, and to be edited: they do not hold what a finger errs in feeling for
    the bone. A landmark that states its own sigma keeps it.
    """

    click_mm: float = 2.0
    """By a click on the surface."""
    painted_mm: float = 1.0
    """At a painted mark."""
    proposed_mm: float = 3.0
    """Proposed by the program and confirmed."""

    def of(self, mark: Landmark) -> float:
        """The placing sigma of one landmark."""
        usual: dict[Placed, float] = {
            "click": self.click_mm,
            "painted": self.painted_mm,
            "proposed": self.proposed_mm,
        }
        return usual[mark.placed] if mark.sigma_mm is None else mark.sigma_mm


USUAL = Placing()
