"""The sock of the scan, taken off its surface."""

from dataclasses import replace
from typing import Annotated

from limbgram.core.errors import EditError
from limbgram.core.request_fields import Within
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.offset import offset
from limbgram.workbench.edits.regions import displaced
from limbgram.workbench.limb import Limb

THICKEST_SOCK_MM = 20.0


@edit(
    group="scan",
    order=2,
    effect=Effect(start="follows"),
    everyday=True,
    guarded=False,
    example={"thickness_mm": 0.5},
)
class Sock(Edit):
    """Take the sock that was worn in the scan off the surface, once; the limb file remembers it."""

    thickness_mm: Annotated[float, Within(0, THICKEST_SOCK_MM, above=True)] = 0.3
    """As worn: about 0.3 for a nylon sheath, 2.3 for a thick terry sock."""

    words = spoken(
        en=Words(name="Take sock off", title="The removal of the sock"),
        de=Words(
            name="Strumpf abziehen",
            title="Das Abziehen des Strumpfs",
            does="Den Strumpf, der beim Scan getragen wurde, einmal von der Fläche abziehen; die "
            "Datei des Gliedmaßes merkt es sich.",
            labels={"thickness_mm": "Dicke"},
            help={
                "thickness_mm": "Wie getragen: etwa 0,3 bei dünnem Nylon, 2,3 bei dickem Frottee."
            },
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Move the surface inwards by the sock.

        Raises:
            EditError: a sock is off already, or the surface would fold.
        """
        if limb.sock_mm:
            raise EditError("edit.sock.twice", sock_mm=limb.sock_mm)
        bare = displaced(limb, offset(limb.mesh, -self.thickness_mm).vertices_mm)
        return replace(bare, sock_mm=self.thickness_mm)
