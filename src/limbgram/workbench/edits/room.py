"""Room: an oval built up, where an orthosis gives way."""

from limbgram.workbench.edits.edit import Effect, Words, edit, spoken
from limbgram.workbench.edits.oval import Oval, move_oval
from limbgram.workbench.limb import Limb


@edit(
    group="orthosis",
    order=21,
    effect=Effect(moves_skin=True, at_place="builds"),
    guarded=False,
    example={"at": "mark in front", "depth_mm": 3.0, "width_mm": 30.0, "height_mm": 40.0},
)
class Room(Oval):
    """Give room, opposite a pad: build the positive up over an oval."""

    words = spoken(
        en=Words(name="Room", title="The room"),
        de=Words(
            name="Freiraum",
            title="Der Freiraum",
            does="Freiraum geben, einer Pelotte gegenüber: das Positiv über einem Oval aufbauen.",
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Move the oval outwards.

        Raises:
            EditError: no such place, or the surface would fold or cut through itself.
        """
        return move_oval(limb, self, 1.0)
