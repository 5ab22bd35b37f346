"""Load: an area carved in."""

from limbgram.workbench.edits.areas import Area, push_area
from limbgram.workbench.edits.edit import AboveZeroMm, Effect, Words, edit, spoken
from limbgram.workbench.limb import Limb


@edit(
    group="areas",
    order=2,
    effect=Effect(moves_skin=True, at_place="carves"),
    rarely=("positions_in",),
    guarded=False,
    example={"at": "patellar tendon", "depth_mm": 3.0, "falloff_mm": 18.0},
)
class Load(Area):
    """Give pressure: carve the positive in, round a place or over a drawn region."""

    depth_mm: AboveZeroMm
    """How far the surface sinks, at the deepest point, exactly;
    for the other way there is relieve."""

    words = spoken(
        en=Words(name="Load", title="The edit load"),
        de=Words(
            name="Belasten",
            title="Das Belasten",
            does="Druck geben: vom Positiv abtragen, "
            "um eine Stelle oder über einem gezeichneten Bereich.",
            help={
                "depth_mm": "Wie weit die Fläche am tiefsten Punkt sinkt, genau; "
                "für die andere Richtung gibt es Entlasten."
            },
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Carve an area in along the surface's normals.

        Raises:
            EditError: no such area, or the surface would fold or cut through itself.
        """
        return push_area(limb, self, -1.0)
