"""Liner: reductions that have been published for liners.

P. Jasken, J. Hall, J Prosthet Orthot 30(3), 2018, 140-144, as the makers state them. Ossur Iceross
Original: 3-5 % of girth proximally, tapering to 0 % distally. WillowWood Alpha: 3 mm 3-5 %, 6 mm
5-7 %, 9 mm 7-9 %, called volume.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from limbgram.core.errors import EditError
from limbgram.core.request_fields import Within
from limbgram.workbench.edits.edit import RESIDUAL_LIMBS, Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.levels import PerCentOf, change_by_levels
from limbgram.workbench.edits.reduction import Reduction
from limbgram.workbench.edits.regions import height_mm, points_in_limb_frame
from limbgram.workbench.limb import Limb

LinerName = Literal["iceross-original", "alpha-3mm", "alpha-6mm", "alpha-9mm"]
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


@edit(
    group="levels",
    order=3,
    effect=Effect(moves_skin=True),
    kinds=RESIDUAL_LIMBS,
    example={"name": "alpha-6mm"},
)
class Liner(Edit):
    """Reduce for a liner by the maker's published per cent.
    iceross-original: 3-5 % of girth proximally, tapering to 0 % distally; alpha-3mm 3-5 %,
    alpha-6mm 5-7 %, alpha-9mm 7-9 % of volume (Jasken and Hall 2018).
    """

    name: LinerName
    """Maker and thickness."""
    share: Annotated[float, Within(0, 1)] = 0.5
    """Where in the published range: 0 its lower, 1 its upper end."""
    proximal_mm: float | None = None
    """Height at which a taper reaches its full per cent; without it the shape's top."""
    above: str = ""
    """Landmark from which that height counts; without it the distal end's origin."""

    words = spoken(
        en=Words(
            name="For a liner",
            title="The liner preset",
            labels={
                "name": "Liner",
                "share": "Where in the maker's range, 0 to 1",
                "proximal_mm": "Full per cent from height",
                "above": "Height counts from",
            },
            choices={
                "iceross-original": "Iceross Original",
                "alpha-3mm": "Alpha 3\u00a0mm",
                "alpha-6mm": "Alpha 6\u00a0mm",
                "alpha-9mm": "Alpha 9\u00a0mm",
            },
        ),
        de=Words(
            name="Für einen Liner",
            title="Die Liner-Voreinstellung",
            does="Für einen Liner verkleinern, um die veröffentlichten Prozente des Herstellers. "
            "iceross-original: 3-5 % des Umfangs proximal, auslaufend auf 0 % distal; alpha-3mm "
            "3-5 %, alpha-6mm 5-7 %, alpha-9mm 7-9 % des Volumens (Jasken und Hall 2018).",
            labels={
                "name": "Liner",
                "share": "Wo im Bereich des Herstellers, 0 bis 1",
                "proximal_mm": "Volle Prozent ab Höhe",
                "above": "Höhe zählt ab",
            },
            help={
                "name": "Hersteller und Dicke.",
                "share": "Wo im veröffentlichten Bereich: 0 sein unteres, 1 sein oberes Ende.",
                "proximal_mm": "Höhe, ab der die vollen Prozente gelten; sonst das obere Ende der "
                "Form.",
                "above": "Landmarke, ab der diese Höhe zählt; sonst ab dem distalen Ende.",
            },
        ),
    )

    def check(self) -> None:
        """Refuse a height where the preset has none.

        Raises:
            EditError: a height is given that nothing counts by.
        """
        if not LINERS[self.name].tapers and (self.proximal_mm is not None or self.above):
            raise EditError("edit.liner.even")
        if self.proximal_mm is None and self.above:
            raise EditError("edit.liner.above", above=self.above)
        if self.proximal_mm is not None and self.proximal_mm <= 0 and not self.above:
            raise EditError("edit.liner.at_end", height_mm=self.proximal_mm)

    def apply(self, limb: Limb) -> Limb:
        """Reduce for a liner.

        Raises:
            EditError: the height makes no sense on this limb.
        """
        made = LINERS[self.name]
        per_cent = made.least_per_cent + self.share * (made.most_per_cent - made.least_per_cent)
        heights = points_in_limb_frame(limb)[:, 2]
        low, high = float(heights.min()), float(heights.max())
        if not made.tapers:
            levels = Reduction(heights_mm=(low,), per_cent=(per_cent,), of=made.of)
            return change_by_levels(limb, levels, -1.0)
        if self.proximal_mm is not None:
            high = height_mm(limb, self.proximal_mm, self.above)
            top = float(heights.max())
            if not low < high <= low + _MOST_LENGTHS * (top - low):
                raise EditError("edit.liner.off_shape", height_mm=high, low_mm=low, top_mm=top)
        levels = Reduction(heights_mm=(low, high), per_cent=(0.0, per_cent), of=made.of)
        return change_by_levels(limb, levels, -1.0)
