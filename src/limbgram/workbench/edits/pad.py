"""Pad: an oval carved in, where an orthosis presses."""

from limbgram.workbench.edits.edit import Effect, Words, edit, spoken
from limbgram.workbench.edits.oval import Oval, move_oval
from limbgram.workbench.limb import Limb


@edit(
    group="orthosis",
    order=20,
    effect=Effect(moves_skin=True, at_place="carves"),
    guarded=False,
    example={"at": "mark in front", "depth_mm": 3.0, "width_mm": 30.0, "height_mm": 40.0},
)
class Pad(Oval):
    """Press with a pad: carve the positive in over an oval."""

    words = spoken(
        en=Words(name="Pad", title="The pad"),
        de=Words(
            name="Pelotte",
            title="Die Pelotte",
            does="Mit einer Pelotte drücken: das Positiv über einem Oval abtragen.",
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Move the oval inwards.

        Raises:
            EditError: no such place, or the surface would fold or cut through itself.
        """
        return move_oval(limb, self, -1.0)
