"""Increase: sections made larger at levels."""

from typing import Annotated

from limbgram.core.request_fields import Within
from limbgram.workbench.edits.edit import Effect, Words, edit, spoken
from limbgram.workbench.edits.levels import Levels, change_by_levels, require_on_limb
from limbgram.workbench.limb import Limb


@edit(
    group="levels",
    order=2,
    effect=Effect(moves_skin=True),
    example={"heights_mm": [10.0, 90.0], "per_cent": [0.0, 3.0], "of": "girth"},
)
class Increase(Levels):
    """Make sections larger by per cent at levels, in between in proportion."""

    per_cent: tuple[Annotated[float, Within(0, 50)], ...]
    """One for each level; below the first and above the last the same as there. For the other way
    there is a reduction."""

    words = spoken(
        en=Words(name="Larger by levels", title="The increase"),
        de=Words(
            name="Größer nach Höhe",
            title="Die Vergrößerung",
            does="Schnitte nach Höhe um Prozente größer machen, dazwischen anteilig.",
            help={
                "per_cent": "Ein Wert je Höhe; unter der ersten und über der letzten wie dort. Für "
                "die andere Richtung gibt es die Verkleinerung."
            },
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Scale sections away from their middles.

        Raises:
            EditError: the levels make no sense on this limb.
        """
        require_on_limb(limb, self)
        return change_by_levels(limb, self, 1.0)
