"""Presets: the sock of the scan, reductions that have been published for liners, and the sock ply.

Liners      P. Jasken, J. Hall, J Prosthet Orthot 30(3), 2018, 140-144, as the makers state them.
            Ossur Iceross Original: 3-5 % of girth proximally, tapering to 0 % distally.
            WillowWood Alpha: 3 mm 3-5 %, 6 mm 5-7 %, 9 mm 7-9 %, called volume.
Sock ply    one ply is about 1.1 % of volume: J. Sanders et al., J Rehabil Res Dev 49(4), 2012.
"""

from dataclasses import dataclass, replace
from typing import ClassVar, Literal

from limbgram.core.errors import EditError
from limbgram.workbench.edits.edit import Effect
from limbgram.workbench.edits.offset import offset
from limbgram.workbench.edits.percent import Increase, PerCentOf, Reduction, change_by_levels
from limbgram.workbench.edits.regions import displaced, height_mm, points_in_limb_frame
from limbgram.workbench.limb import Limb

LinerName = Literal["iceross-original", "alpha-3mm", "alpha-6mm", "alpha-9mm"]
PLY_VOLUME_PER_CENT = 1.1
THICKEST_SOCK_MM = 20.0
_MOST_PLIES = 20
_MOST_LENGTHS = 2.0
"""Of the shape, at which a taper may be full: a scan may be cut short of where it is meant."""


@dataclass(frozen=True, kw_only=True)
class Published:
    """What a maker states."""

    least_per_cent: float
    most_per_cent: float
    of: PerCentOf
    tapers: bool
    """To 0 % at the distal end."""


LINERS: dict[LinerName, Published] = {
    "iceross-original": Published(least_per_cent=3, most_per_cent=5, of="girth", tapers=True),
    "alpha-3mm": Published(least_per_cent=3, most_per_cent=5, of="volume", tapers=False),
    "alpha-6mm": Published(least_per_cent=5, most_per_cent=7, of="volume", tapers=False),
    "alpha-9mm": Published(least_per_cent=7, most_per_cent=9, of="volume", tapers=False),
}


@dataclass(frozen=True, kw_only=True)
class Liner:
    """Reduce for a liner by the maker's published per cent.

    iceross-original: 3-5 % of girth proximally, tapering to 0 % distally; alpha-3mm 3-5 %,
    alpha-6mm 5-7 %, alpha-9mm 7-9 % of volume (Jasken and Hall 2018).
    """

    name: LinerName
    share: float = 0.5
    """Where in the published range: 0 its lower, 1 its upper end."""
    proximal_mm: float | None = None
    """Height at which a taper reaches its full per cent; without it the shape's top."""
    above: str = ""
    """Landmark from which that height counts; without it the distal end's origin."""

    title: ClassVar[str] = "The liner preset"
    effect: ClassVar[Effect] = Effect(moves_skin=True)

    def check(self) -> None:
        """Refuse a choice that no maker's range has, or a height where it has none.

        Raises:
            EditError: the share is out of its range, or a height is given that nothing counts by.
        """
        what = f"The liner preset {self.name}"
        if not 0 <= self.share <= 1:
            raise EditError("edit.liner.share", what=what, share=self.share)
        if not LINERS[self.name].tapers and (self.proximal_mm is not None or self.above):
            raise EditError("edit.liner.even", what=what)
        if self.proximal_mm is None and self.above:
            raise EditError("edit.liner.above", what=what, above=self.above)
        if self.proximal_mm is not None and self.proximal_mm <= 0 and not self.above:
            raise EditError("edit.liner.at_end", what=what, height_mm=self.proximal_mm)

    def apply(self, limb: Limb) -> Limb:
        """Reduce for a liner.

        Raises:
            EditError: the share or the height makes no sense.
        """
        what = f"The liner preset {self.name}"
        made = LINERS[self.name]
        per_cent = made.least_per_cent + self.share * (made.most_per_cent - made.least_per_cent)
        heights = points_in_limb_frame(limb, what)[:, 2]
        low, high = float(heights.min()), float(heights.max())
        if not made.tapers:
            levels = Reduction(heights_mm=(low,), per_cent=(per_cent,), of=made.of)
            return change_by_levels(limb, what, levels, -1.0)
        if self.proximal_mm is not None:
            high = height_mm(limb, self.proximal_mm, self.above, what)
            top = float(heights.max())
            if not low < high <= low + _MOST_LENGTHS * (top - low):
                raise EditError(
                    "edit.liner.off_shape", what=what, height_mm=high, low_mm=low, top_mm=top
                )
        levels = Reduction(heights_mm=(low, high), per_cent=(0.0, per_cent), of=made.of)
        return change_by_levels(limb, what, levels, -1.0)


@dataclass(frozen=True, kw_only=True)
class SockPly:
    """Make the shape larger by sock plies of 1.1 % of volume each, or smaller by negative ones."""

    plies: float

    title: ClassVar[str] = "The change by sock plies"
    effect: ClassVar[Effect] = Effect(moves_skin=True)

    def check(self) -> None:
        """Refuse more plies than anybody wears.

        Raises:
            EditError: there are more.
        """
        if abs(self.plies) > _MOST_PLIES:
            raise EditError("edit.plies", plies=self.plies, most=_MOST_PLIES)

    def apply(self, limb: Limb) -> Limb:
        """Change the volume of every section by plies.

        Raises:
            EditError: more plies than anybody wears.
        """
        per_cent = (PLY_VOLUME_PER_CENT * abs(self.plies),)
        what = f"The change by {self.plies:g} sock plies"
        if self.plies < 0:
            levels = Reduction(heights_mm=(0.0,), per_cent=per_cent, of="volume")
            return change_by_levels(limb, what, levels, -1.0)
        more = Increase(heights_mm=(0.0,), per_cent=per_cent, of="volume")
        return change_by_levels(limb, what, more, 1.0)


@dataclass(frozen=True, kw_only=True)
class Sock:
    """Take the sock that was worn in the scan off the surface, once; the limb file remembers it."""

    thickness_mm: float = 0.3
    """As worn: about 0.3 for a nylon sheath, 2.3 for a thick terry sock."""

    title: ClassVar[str] = "The sock"
    effect: ClassVar[Effect] = Effect(start="follows")

    def check(self) -> None:
        """Refuse a thickness that no sock has.

        Raises:
            EditError: it is not above 0 mm, or larger than any sock's.
        """
        if not 0 < self.thickness_mm <= THICKEST_SOCK_MM:
            raise EditError("edit.sock.thickness", thickness_mm=self.thickness_mm)

    def apply(self, limb: Limb) -> Limb:
        """Move the surface inwards by the sock.

        Raises:
            EditError: a sock is off already, or the surface would fold.
        """
        if limb.sock_mm:
            raise EditError("edit.sock.twice", sock_mm=limb.sock_mm)
        bare = displaced(limb, offset(limb.mesh, -self.thickness_mm).vertices_mm)
        return replace(bare, sock_mm=self.thickness_mm)
