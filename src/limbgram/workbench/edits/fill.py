"""Fill: holes closed with surface that goes on as its surroundings do."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Int32

from limbgram.core.errors import EditError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import touches_itself
from limbgram.findings import Finding, doubt, note
from limbgram.reconstruction.surface.holes import find_openings, loop_area
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.guard import unsound_vertices
from limbgram.workbench.edits.regions import upright_mm, with_holes_closed
from limbgram.workbench.limb import Limb
from limbgram.workbench.loose_pieces import open_pieces

_FLAT_AREA_RATIO = 2.0
"""A piece with less than this multiple of its opening's area is flatter than a hemisphere."""
Loop = Int32[np.ndarray, " _"]
"""Vertices round an opening."""


@edit(
    group="solids",
    order=1,
    effect=Effect(reports_displacement=False),
    everyday=True,
    example={"brim": True},
)
class Fill(Edit):
    """Close holes with surface that goes on as its surroundings do."""

    brim: bool = False
    """Whether the open brim is closed too, straight across where that folds nothing."""

    words = spoken(
        en=Words(name="Close holes", title="The filling", labels={"brim": "Close the brim too"}),
        de=Words(
            name="Löcher schließen",
            title="Das Schließen der Löcher",
            does="Löcher mit einer Fläche schließen, die so weitergeht wie ihre Umgebung.",
            labels={"brim": "Auch den Rand schließen"},
            help={
                "brim": "Ob auch der offene Rand geschlossen wird, gerade hinüber, wo das nichts "
                "faltet."
            },
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Close holes.

        A hole that touches itself in a point has no sound triangle there: it stays, with a note.

        Raises:
            EditError: there is none that can be filled.
        """
        found = _fillable_openings(limb, self)
        grown = _with_filling(limb.mesh, found, curved=False)
        domed = bool(found.brim) and bool(unsound_vertices(limb.mesh, grown).any())
        if domed:
            grown = _with_filling(limb.mesh, found, curved=True)
        notes: list[Finding] = []
        if found.left:
            notes.append(doubt("edit.fill.left", count=found.left))
        if domed:
            notes.append(note("edit.fill.domed"))
        return replace(limb, mesh=grown, notes=(*limb.notes, *notes))


@dataclass(frozen=True)
class _FillableOpenings:
    """The openings of a limb that can be closed."""

    holes: list[Loop]
    brim: list[Loop]
    """The brim, if it is to be closed too."""
    left: int
    """Number of holes that cannot be closed."""


def _fillable_openings(limb: Limb, edit: Fill) -> _FillableOpenings:
    mesh = limb.mesh
    openings = find_openings(upright_mm(limb), mesh.faces)
    brim = [openings.brim] if edit.brim and openings.brim is not None else []
    loops = [*openings.holes, *brim]
    own = _are_of_scraps(mesh, loops)
    loops = [loop for loop, of_scrap in zip(loops, own, strict=True) if not of_scrap]
    if not loops:
        raise EditError("edit.fill.no_hole", scraps=any(own), brim=openings.brim is not None)
    whole = [loop for loop in loops if not touches_itself(mesh, loop)]
    if not whole:
        raise EditError("edit.fill.touching")
    return _FillableOpenings(
        holes=[loop for loop in whole if loop is not openings.brim],
        brim=[loop for loop in whole if loop is openings.brim],
        left=len(loops) - len(whole),
    )


def _are_of_scraps(mesh: Mesh, loops: Sequence[Loop]) -> list[bool]:
    """Which loops bound a flat piece beside the surface: closed, it would be a doubled sheet."""
    pieces = open_pieces(mesh)
    if pieces is None:
        return [False] * len(loops)
    return [
        bool(pieces.loose[piece])
        and float(pieces.area_mm2[piece])
        < _FLAT_AREA_RATIO * float(np.linalg.norm(loop_area(mesh.vertices_mm[loop])))
        for loop, piece in zip(loops, [pieces.of_vertex[loop[0]] for loop in loops], strict=True)
    ]


def _with_filling(mesh: Mesh, found: _FillableOpenings, *, curved: bool) -> Mesh:
    """The mesh with its holes closed, then its brim: straight across, or as the surface curves."""
    return with_holes_closed(with_holes_closed(mesh, found.holes), found.brim, curved=curved)
