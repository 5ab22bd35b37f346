"""What was learned from the clinic's own pairs, as an edit: a template done at a limb's own places.

The recipe holds the whole template, so that it stands by itself and makes the same shape wherever
it is replayed, whatever becomes of the template's file.
"""

from dataclasses import replace

from limbgram.core.errors import EditError, MeasureError, OptionsError
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.limb import Kind, Limb
from limbgram.workbench.templates.files import decode_template
from limbgram.workbench.templates.template import Template, apply_template


@edit(
    group="learned",
    order=1,
    effect=Effect(moves_skin=True),
    guarded=False,
    example={"learned": '{\n "format": "limbgram template"}'},
)
class FromTemplate(Edit):
    """Do what a template learned, at the limb's own landmarks."""

    learned: str
    """The template as its file has it; `limbgram template learn` writes one."""
    strength: float = 1.0
    """Factor of all displacements; 1 is as learned."""

    words = spoken(
        en=Words(name="Template", title="The template", labels={"learned": "Template"}),
        de=Words(
            name="Vorlage",
            title="Die Vorlage",
            does="Tun, was eine Vorlage gelernt hat, an den Landmarken dieses Gliedmaßes.",
            labels={"learned": "Vorlage", "strength": "Stärke"},
            help={
                "learned": "Die Vorlage, wie ihre Datei sie hat; `limbgram template learn` "
                "schreibt eine.",
                "strength": "Faktor aller Verschiebungen; 1 ist wie gelernt.",
            },
        ),
    )

    def places_of(self, kind: Kind) -> set[str]:
        template = self.template()
        curve = kind.centreline if template.along == "centreline" else None
        return kind.names_in((template.reference, [one.name for one in template.marks], curve))

    def check(self) -> None:
        """Refuse a text that is no template.

        Raises:
            EditError: it cannot be read, or is of another kind.
        """
        self.template()

    def apply(self, limb: Limb) -> Limb:
        """Move the surface as the template tells.

        Raises:
            EditError: the limb lacks its front, side or landmark of reference, or it would fold.
        """
        try:
            applied = apply_template(limb, self.template(), self.strength)
        except (MeasureError, OptionsError) as error:
            raise EditError.of(error.finding) from error
        return replace(applied.limb, notes=(*applied.limb.notes, *applied.notes))

    def template(self) -> Template:
        """The template.

        Raises:
            EditError: it cannot be read, or is of another kind.
        """
        try:
            return decode_template(self.learned.encode())
        except ValueError as error:
            raise EditError("edit.template.unreadable", reason=str(error)) from error
