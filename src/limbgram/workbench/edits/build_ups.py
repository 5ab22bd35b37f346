"""Build-ups: every place of the kind's preset that was marked, built up at once."""

from dataclasses import replace
from typing import Annotated

from limbgram.core.errors import EditError
from limbgram.core.request_fields import Within
from limbgram.findings import note
from limbgram.workbench.anatomy.names import identity_of, landmarks_by_identity
from limbgram.workbench.edits.areas import push_area
from limbgram.workbench.edits.edit import AboveZeroMm, Edit, Effect, FromZeroMm, Words, edit, spoken
from limbgram.workbench.edits.relieve import Relieve
from limbgram.workbench.limb import KIND_NAMED, Kind, Limb


@edit(
    group="orthosis",
    order=2,
    effect=Effect(moves_skin=True),
    everyday=True,
    guarded=False,
    kinds=tuple(name for name, kind in KIND_NAMED.items() if kind.presets),
    example={"times": 1.0},
)
class BuildUps(Edit):
    """Give room over all marked bones of the kind's preset: build the positive up, outwards."""

    times: Annotated[float, Within(0.1, 3)] = 1.0
    """Of the preset's heights, which are general trade knowledge: look at each."""
    falloff_mm: AboveZeroMm = 15.0
    """Width over which each fades."""
    flat_mm: FromZeroMm = 4.0
    """Radius within which each is full."""
    without: tuple[str, ...] = ()
    """Landmarks of the preset that stay as they are."""

    words = spoken(
        en=Words(
            name="Build-ups",
            title="The build-ups",
            labels={"falloff_mm": "Fades over", "flat_mm": "Full within"},
        ),
        de=Words(
            name="Aufbauten",
            title="Das Aufbauen",
            does="Über allen markierten Knochen der Vorgabe Raum geben: das Positiv nach außen "
            "aufbauen.",
            labels={
                "times": "Mal",
                "falloff_mm": "Läuft aus über",
                "flat_mm": "Voll im Umkreis von",
                "without": "Ohne",
            },
            help={
                "times": "Der Höhen der Vorgabe, die allgemeines Fachwissen sind: jede ansehen.",
                "falloff_mm": "Breite, über die jeder ausläuft.",
                "flat_mm": "Radius, in dem jeder voll gilt.",
                "without": "Landmarken der Vorgabe, die bleiben, wie sie sind.",
            },
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Build up one place after the other.

        Raises:
            EditError: no place of the preset was marked, a name of what stays is none of the
                preset, or the surface would fold.
        """
        marks = landmarks_by_identity(limb.landmarks)
        kind = None if limb.kind is None else KIND_NAMED[limb.kind]
        presets = {} if kind is None else kind.presets
        places = () if kind is None else self.places_of(kind)
        unknown = tuple(name for name in self.without if identity_of(name) not in presets)
        if unknown:
            raise EditError("edit.build_ups.without", names=unknown, known=tuple(presets))
        wanted = {one: presets[one] for one in places if one in marks}
        if not wanted:
            raise EditError("edit.build_ups.none", names=tuple(presets))
        for name, height_mm in wanted.items():
            one = Relieve(
                at=marks[name].name,
                depth_mm=height_mm * self.times,
                falloff_mm=self.falloff_mm,
                flat_mm=self.flat_mm,
            )
            limb = push_area(limb, one, 1.0)
        told = note("edit.build_ups.done", names=tuple(wanted), times=self.times)
        return replace(limb, notes=(*limb.notes, told))

    def places_of(self, kind: Kind) -> tuple[str, ...]:
        """The places of a kind's preset that are built up where they are marked."""
        skipped = {identity_of(name) for name in self.without}
        return tuple(one for one in kind.presets if one not in skipped)
