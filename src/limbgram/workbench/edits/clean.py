"""Clean: removes scraps, doubled sheets and spikes from a scan, and closes small holes.

In      a Limb, and how large each kind of fault may be.
Out     the Limb without them; a note of every kind that was found.
Method  scraps and doubled sheets are loose open pieces that lie on the rest; a spike is a vertex at
        which the surface comes to a point, and is laid back among its neighbours; a hole is an
        opening that is not the brim, and is closed by surface that goes on as its surroundings do.
Fails   EditError: what is closed would fold.
"""

from dataclasses import replace
from typing import Annotated

import numpy as np
from jaxtyping import Int32

from limbgram.core.errors import EditError
from limbgram.core.mesh.folds import find_spikes
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_loops, touches_itself, unmeasured_at
from limbgram.core.request_fields import Within
from limbgram.findings import Finding, doubt, note
from limbgram.reconstruction.surface.holes import find_openings
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.guard import require_sound, unsound_vertices
from limbgram.workbench.edits.regions import (
    displaced,
    neighbour_averaging,
    on_open_edge,
    upright_mm,
    with_holes_closed,
)
from limbgram.workbench.limb import Limb
from limbgram.workbench.loose_pieces import open_pieces, without_pieces

_LARGEST_MM = 60.0
"""A wider hole, or a longer scrap, is a part of the limb that is missing or lies loose: for a
person to judge."""
_SHEET_SHARE = 0.5
"""A sheet with a larger share of the largest piece's area is no double, but another surface."""
_SPIKE_ROUNDS = 20
"""Rounds of flattening spikes: where two are neighbours, one goes down after the other."""
_PUT_BACK_ROUNDS = 5
"""Rounds of putting points back whose new place would fold the surface."""


_SizeMm = Annotated[float, Within(0, _LARGEST_MM)]


@edit(
    group="scan",
    order=1,
    effect=Effect(reports_displacement=False),
    everyday=True,
    rarely=("sheets_mm", "spikes"),
    guarded=False,
    example={"holes_mm": 20.0},
)
class Clean(Edit):
    """Clean a scan of what scanners leave: loose scraps, doubled sheets, spikes, small holes."""

    scraps_mm: _SizeMm = 10.0
    """Loose pieces of surface up to this long, and as near to the limb, are taken away; 0: none."""
    sheets_mm: _SizeMm = 1.5
    """Loose sheets of any size that lie as near to the surface all over are taken away; 0: none."""
    spikes: bool = True
    """Whether single points that stand out like thorns are laid back among their neighbours."""
    holes_mm: _SizeMm = 15.0
    """Holes up to this wide are closed; the brim never is; 0: none."""

    words = spoken(
        en=Words(
            name="Clean the scan",
            title="The cleaning",
            labels={
                "scraps_mm": "Loose pieces up to",
                "sheets_mm": "Doubled sheets up to",
                "spikes": "Lay spikes back",
                "holes_mm": "Holes up to",
            },
        ),
        de=Words(
            name="Scan säubern",
            title="Das Säubern",
            does="Einen Scan von dem säubern, was Scanner zurücklassen: lose Fetzen, doppelte "
            "Blätter, Spitzen, kleine Löcher.",
            labels={
                "scraps_mm": "Lose Stücke bis",
                "sheets_mm": "Doppelte Blätter bis",
                "spikes": "Spitzen zurücklegen",
                "holes_mm": "Löcher bis",
            },
            help={
                "scraps_mm": "Lose Flächenstücke bis zu dieser Länge, die so nah am Gliedmaß "
                "liegen, werden entfernt; 0: keine.",
                "sheets_mm": "Lose Blätter jeder Größe, die überall so nah an der Fläche liegen, "
                "werden entfernt; 0: keine.",
                "spikes": "Ob einzelne Punkte, die wie Dornen herausstehen, zwischen ihre Nachbarn "
                "zurückgelegt werden.",
                "holes_mm": "Löcher bis zu dieser Breite werden geschlossen; der Rand nie; 0: "
                "keine.",
            },
        ),
    )

    def check(self) -> None:
        """Refuse to do nothing.

        Raises:
            EditError: nothing is asked for.
        """
        if not (self.spikes or self.scraps_mm or self.sheets_mm or self.holes_mm):
            raise EditError("edit.nothing_asked")

    def apply(self, limb: Limb) -> Limb:
        """The limb without what its scanner left.

        Raises:
            EditError: what is closed would fold.
        """
        cleared = _without_scraps(limb, self)
        smooth = _without_spikes(cleared) if self.spikes else cleared
        whole = _without_holes(smooth, self) if self.holes_mm else smooth
        if whole is limb:
            return replace(limb, notes=(*limb.notes, note("edit.clean.nothing")))
        require_sound(cleared.mesh, whole.mesh)
        return whole


def _without_scraps(limb: Limb, edit: Clean) -> Limb:
    """The limb without short loose pieces near the surface, and without doubled sheets on it."""
    notes: list[Finding] = []
    mesh = limb.mesh
    for reach_mm, of_scraps in ((edit.scraps_mm, True), (edit.sheets_mm, False)):
        pieces = open_pieces(mesh) if reach_mm else None
        if pieces is None:
            continue
        if of_scraps:
            asked = _piece_lengths_mm(mesh, pieces.of_vertex, len(pieces.area_mm2)) <= reach_mm
        else:
            asked = pieces.area_mm2 <= _SHEET_SHARE * pieces.area_mm2.max()
        found = without_pieces(mesh, pieces, asked, reach_mm)
        mesh = found.mesh
        notes += found.findings()
    return limb if mesh is limb.mesh else _with_notes(limb.with_mesh(mesh), notes)


def _piece_lengths_mm(mesh: Mesh, piece: np.ndarray, count: int) -> np.ndarray:
    """Longest side of each piece's bounding box."""
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, piece, mesh.vertices_mm)
    np.maximum.at(high, piece, mesh.vertices_mm)
    return (high - low).max(1)


def _without_spikes(limb: Limb) -> Limb:
    """The limb with spikes flattened, which count as filled, and a doubt of those that stay."""
    mesh = limb.mesh
    mean = neighbour_averaging(mesh)
    held = on_open_edge(mesh)
    vertices = mesh.vertices_mm.copy()
    moved = np.zeros(len(mesh), np.bool_)
    for _ in range(_SPIKE_ROUNDS):
        found = find_spikes(vertices, mesh.faces) & ~held
        if not found.any():
            break
        vertices[found] = (mean @ vertices)[found]
        moved |= found
    if not moved.any():
        return limb
    for _ in range(_PUT_BACK_ROUNDS):
        spoilt = moved & unsound_vertices(mesh, mesh.with_vertices(vertices))
        vertices[spoilt] = mesh.vertices_mm[spoilt]
        moved &= ~spoilt
        if not spoilt.any():
            break
    else:
        vertices, moved = mesh.vertices_mm, np.zeros(len(mesh), np.bool_)
    left = int((find_spikes(vertices, mesh.faces) & ~held).sum())
    notes = [doubt("edit.clean.spikes_left", count=left)] if left else []
    if not moved.any():
        return _with_notes(limb, notes)
    highest_mm = float(np.linalg.norm(vertices - mesh.vertices_mm, axis=1).max())
    laid = displaced(limb, vertices)
    said = note("edit.clean.spikes", count=int(moved.sum()), highest_mm=highest_mm)
    return _with_notes(laid.with_mesh(unmeasured_at(laid.mesh, moved)), [said, *notes])


def _without_holes(limb: Limb, edit: Clean) -> Limb:
    """The limb with small holes closed; one whose filling would fold stays open, with a doubt."""
    mesh = limb.mesh
    brim = find_openings(upright_mm(limb), mesh.faces).brim
    loops = [
        loop for loop in boundary_loops(mesh.faces) if brim is None or loop[0] not in brim.tolist()
    ]
    small = [loop for loop in loops if _hole_width_mm(mesh, loop) <= edit.holes_mm]
    whole = [loop for loop in small if not touches_itself(mesh, loop)]
    closed = with_holes_closed(mesh, whole)
    spoilt = unsound_vertices(mesh, closed)[: len(mesh)]
    if spoilt.any():
        whole = [loop for loop in whole if not spoilt[loop].any()]
        closed = with_holes_closed(mesh, whole)
    if not small:
        return limb
    notes: list[Finding] = []
    if whole:
        widest_mm = max(_hole_width_mm(mesh, loop) for loop in whole)
        notes.append(note("edit.clean.holes", widest_mm=widest_mm, count=len(whole)))
    if len(whole) < len(small):
        notes.append(doubt("edit.clean.holes_left", count=len(small) - len(whole)))
    return _with_notes(limb.with_mesh(closed), notes)


def _hole_width_mm(mesh: Mesh, loop: Int32[np.ndarray, " l"]) -> float:
    places = mesh.vertices_mm[loop]
    return 2 * float(np.linalg.norm(places - places.mean(0), axis=1).max())


def _with_notes(limb: Limb, notes: list[Finding]) -> Limb:
    return replace(limb, notes=(*limb.notes, *notes))
