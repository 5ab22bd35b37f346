"""Reduction: sections made smaller at levels."""

from typing import Annotated

from limbgram.core.request_fields import Within
from limbgram.workbench.edits.edit import Effect, Words, edit, spoken
from limbgram.workbench.edits.levels import Levels, change_by_levels, require_on_limb
from limbgram.workbench.limb import Limb


@edit(
    group="levels",
    order=1,
    effect=Effect(moves_skin=True),
    example={"heights_mm": [10.0, 90.0], "per_cent": [0.0, 3.0], "of": "girth"},
)
class Reduction(Levels):
    """Make sections smaller by per cent at levels, in between in proportion."""

    per_cent: tuple[Annotated[float, Within(0, 50)], ...]
    """One for each level; below the first and above the last the same as there. For the other way
    there is an increase."""

    words = spoken(
        en=Words(name="Smaller by levels", title="The reduction"),
        de=Words(
            name="Kleiner nach Höhe",
            title="Die Verkleinerung",
            does="Schnitte nach Höhe um Prozente kleiner machen, dazwischen anteilig.",
            help={
                "per_cent": "Ein Wert je Höhe; unter der ersten und über der letzten wie dort. Für "
                "die andere Richtung gibt es die Vergrößerung."
            },
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Scale sections towards their middles.

        Raises:
            EditError: the levels make no sense on this limb.
        """
        require_on_limb(limb, self)
        return change_by_levels(limb, self, -1.0)
