"""Editing: the table of all edits, and the one function that does any of them."""

from typing import Final

from limbgram.workbench.edits.cleaning import Clean
from limbgram.workbench.edits.cutting import PlaneCut, Trimline
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
    """The limb after an edit.

    Raises:
        EditError: the edit makes no sense on this limb, or would spoil its surface.
    """
    require_sense(edit)
    return edit.apply(limb)
