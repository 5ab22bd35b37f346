"""Relieve: an area built up, outwards."""

from limbgram.workbench.edits.areas import Area, push_area
from limbgram.workbench.edits.edit import AboveZeroMm, Effect, Words, edit, spoken
from limbgram.workbench.limb import Limb


@edit(
    group="areas",
    order=1,
    effect=Effect(moves_skin=True, at_place="builds"),
    rarely=("positions_in",),
    guarded=False,
    example={"at": "patellar tendon", "depth_mm": 3.0, "falloff_mm": 18.0},
)
class Relieve(Area):
    """Give room: build the positive up, outwards, round a place or over a drawn region."""

    depth_mm: AboveZeroMm
    """How far the surface rises, at the highest point, exactly;
    for the other way there is load."""

    words = spoken(
        en=Words(name="Relief", title="The edit relieve"),
        de=Words(
            name="Entlasten",
            title="Das Entlasten",
            does="Raum geben: das Positiv nach außen aufbauen, "
            "um eine Stelle oder über einem gezeichneten Bereich.",
            help={
                "depth_mm": "Wie weit die Fläche am höchsten Punkt steigt, genau; "
                "für die andere Richtung gibt es Belasten."
            },
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Build an area up along the surface's normals.

        Raises:
            EditError: no such area, or the surface would fold or cut through itself.
        """
        return push_area(limb, self, 1.0)
