"""Editing: every edit there is, and the one function that does any of them.

Edits stand in a recipe under the name of their class in small letters: PlaneCut is "plane-cut".
"""

import re
from collections.abc import Iterator
from dataclasses import fields
from typing import get_args

from limbgram.core.errors import EditError
from limbgram.workbench.edits.cleaning import Clean, clean, require_cleaning
from limbgram.workbench.edits.cutting import PlaneCut, Trimline, plane_cut, require_tilts, trimline
from limbgram.workbench.edits.ends import (
    DistalEnd,
    Extension,
    Flare,
    distal_end,
    extension,
    flare,
    require_end,
    require_flare,
    require_length,
)
from limbgram.workbench.edits.percent import (
    Increase,
    Reduction,
    increase,
    reduction,
    require_levels,
)
from limbgram.workbench.edits.presets import (
    Liner,
    Sock,
    SockPly,
    liner,
    require_plies,
    require_preset,
    require_thickness,
    sock,
    sock_ply,
)
from limbgram.workbench.edits.regional import (
    LOADING,
    RELIEVING,
    Load,
    Relieve,
    load,
    relieve,
    require_area,
)
from limbgram.workbench.edits.regions import require_ring
from limbgram.workbench.edits.smoothing import Smoothing, require_amounts, smoothing
from limbgram.workbench.edits.solids import (
    Fill,
    Mirror,
    Offset,
    Wall,
    fill,
    mirror,
    offset_whole,
    require_wall,
    wall,
)
from limbgram.workbench.limb import Limb

_LONGEST_MM = 2000.0
"""No limb is longer, and nothing on it is."""

Edit = (
    Clean
    | Sock
    | Relieve
    | Load
    | Reduction
    | Increase
    | Liner
    | SockPly
    | Offset
    | Smoothing
    | Extension
    | Flare
    | DistalEnd
    | PlaneCut
    | Trimline
    | Fill
    | Wall
    | Mirror
)


def name_of(edit: type[Edit]) -> str:
    return re.sub(r"(?<!^)([A-Z])", r"-\1", edit.__name__).lower()


EDITS: dict[str, type[Edit]] = {name_of(kind): kind for kind in get_args(Edit)}
"""The kinds of edit by the names that recipes use."""


def require_sense(edit: Edit) -> None:
    """Refuse numbers that make sense on no limb, before there is one; the rest shows on the limb.

    Raises:
        EditError: an amount out of its range, or lists of different lengths.
    """
    what = f"The {name_of(type(edit)).replace('-', ' ')}"
    for name, length_mm in _lengths_mm(edit):
        if not abs(length_mm) <= _LONGEST_MM:
            raise EditError(
                f"{what} has {name} = {length_mm:g}, which is longer than any limb. Give it in "
                "millimetres."
            )
    match edit:
        case Relieve():
            require_area(edit, RELIEVING)
        case Load():
            require_area(edit, LOADING)
        case Reduction() | Increase():
            require_levels(edit, f"The {name_of(type(edit))}")
        case Sock():
            require_thickness(edit)
        case SockPly():
            require_plies(edit)
        case Smoothing():
            require_amounts(edit, "The smoothing")
        case Extension():
            require_length(edit, "The extension")
        case Flare():
            require_flare(edit, "The flare")
        case Liner():
            require_preset(edit)
        case DistalEnd():
            require_end(edit, "The distal end")
        case PlaneCut():
            require_tilts(edit, "The plane cut")
        case Trimline():
            require_ring(edit.through, "The trimline")
        case Wall():
            require_wall(edit, "The wall")
        case Clean():
            require_cleaning(edit, "The cleaning")
        case Offset() | Fill() | Mirror():
            pass


def _lengths_mm(edit: Edit) -> Iterator[tuple[str, float]]:
    """Names and values of all that is given in millimetres, without places."""
    for field in fields(edit):
        if field.name.endswith("_mm"):
            value: float | tuple[float, ...] | None = getattr(edit, field.name)
            several = value if isinstance(value, tuple) else () if value is None else (value,)
            yield from ((field.name, number) for number in several)


def do_edit(limb: Limb, edit: Edit) -> Limb:
    """The limb after an edit.

    Raises:
        EditError: the edit makes no sense on this limb, or would spoil its surface.
    """
    require_sense(edit)
    match edit:
        case Clean():
            return clean(limb, edit)
        case Sock():
            return sock(limb, edit)
        case Relieve():
            return relieve(limb, edit)
        case Load():
            return load(limb, edit)
        case Reduction():
            return reduction(limb, edit)
        case Increase():
            return increase(limb, edit)
        case Liner():
            return liner(limb, edit)
        case SockPly():
            return sock_ply(limb, edit)
        case Offset():
            return offset_whole(limb, edit)
        case Smoothing():
            return smoothing(limb, edit)
        case Extension():
            return extension(limb, edit)
        case Flare():
            return flare(limb, edit)
        case DistalEnd():
            return distal_end(limb, edit)
        case PlaneCut():
            return plane_cut(limb, edit)
        case Trimline():
            return trimline(limb, edit)
        case Fill():
            return fill(limb, edit)
        case Wall():
            return wall(limb, edit)
        case Mirror():
            return mirror(limb, edit)
