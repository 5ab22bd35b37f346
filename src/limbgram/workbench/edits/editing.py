"""Editing: the table of all edits, and the one function that does any of them."""

from dataclasses import replace
from typing import Final

import numpy as np

from limbgram.core.mesh.planted import tree_on
from limbgram.findings import doubt
from limbgram.workbench.edits.cleaning import Clean
from limbgram.workbench.edits.cutting import ON_IT_MM, PlaneCut, Trimline
from limbgram.workbench.edits.edit import Edit, name_of, require_lengths
from limbgram.workbench.edits.ends import DistalEnd, Extension, Flare
from limbgram.workbench.edits.learned import FromTemplate
from limbgram.workbench.edits.percent import Increase, Reduction
from limbgram.workbench.edits.presets import Liner, Sock, SockPly
from limbgram.workbench.edits.regional import Load, Relieve
from limbgram.workbench.edits.smoothing import Smoothing
from limbgram.workbench.edits.solids import Fill, Mirror, Offset, Wall
from limbgram.workbench.limb import Limb

EDITS: Final[tuple[type[Edit], ...]] = (
    Clean,
    Sock,
    Relieve,
    Load,
    Reduction,
    Increase,
    Liner,
    SockPly,
    Offset,
    Smoothing,
    Extension,
    Flare,
    DistalEnd,
    PlaneCut,
    Trimline,
    Fill,
    Wall,
    Mirror,
    FromTemplate,
)
"""Every kind of edit, in the order in which help lists them. Recipes, ledger, help and tests follow
from this table; edit.py says what a kind consists of."""

EDIT_NAMED: Final[dict[str, type[Edit]]] = {name_of(kind): kind for kind in EDITS}
"""The same by the names that recipes use."""


def require_sense(edit: Edit) -> None:
    """Refuse numbers that make sense on no limb, before there is one; the rest shows on the limb.

    Raises:
        EditError: an amount out of its range, or lists of different lengths.
    """
    require_lengths(edit)
    edit.check()


def do_edit(limb: Limb, edit: Edit) -> Limb:
    """The limb after an edit; a landmark whose part of the surface is cut off goes with it.

    Raises:
        EditError: the edit makes no sense on this limb, or would spoil its surface.
    """
    require_sense(edit)
    return _landmarks_on_it(limb, edit.apply(limb), moved=edit.effect.moves_skin)


def _landmarks_on_it(before: Limb, after: Limb, *, moved: bool) -> Limb:
    """The limb with its landmarks on the surface.

    Those that an edit left in the air go back to the skin where it moved the skin; where it cut
    they are gone, and the notes name them.
    """
    if not after.landmarks:
        return after
    off_mm = {mark.name: 0.0 for mark in after.landmarks} | _off_surface_mm(before)
    left = _off_surface_mm(after)
    lost = [name for name, found_mm in left.items() if found_mm > off_mm[name] + ON_IT_MM]
    if not lost:
        return after
    if moved:
        places = np.stack([mark.position_mm for mark in after.landmarks])
        nearest = tree_on(after.mesh).closest(places).points_mm
        glued = (
            replace(mark, position_mm=place.copy()) if mark.name in lost else mark
            for mark, place in zip(after.landmarks, nearest, strict=True)
        )
        return replace(after, landmarks=tuple(glued))
    kept = tuple(mark for mark in after.landmarks if mark.name not in lost)
    notes = tuple(doubt("edit.landmark.cut_off", name=name) for name in lost)
    return replace(after, landmarks=kept, notes=(*after.notes, *notes))


def _off_surface_mm(limb: Limb) -> dict[str, float]:
    """How far each landmark lies from the surface."""
    if not limb.landmarks:
        return {}
    places = np.stack([mark.position_mm for mark in limb.landmarks])
    found = tree_on(limb.mesh).closest(places).distances_mm
    return {mark.name: float(off) for mark, off in zip(limb.landmarks, found, strict=True)}
