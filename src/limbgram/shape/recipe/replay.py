"""Replay: a recipe done to a limb, with the ledger of what each edit did.

The same recipe on the same limb gives the same bytes, whenever and on however many threads. Bodies
inside the limb, such as bones, take no part and are left out first: edits would push them into its
skin. So are loose bodies beside it.
"""

from dataclasses import dataclass

from limbgram.errors import EditError, OptionsError
from limbgram.run import track
from limbgram.shape.bodies import outside_of
from limbgram.shape.edits.editing import do_edit
from limbgram.shape.edits.ends.brim import Extension
from limbgram.shape.edits.solids.making import Fill, Mirror
from limbgram.shape.limb import Limb
from limbgram.shape.recipe.ledger import (
    Ledger,
    Line,
    choose_levels,
    displacement_between,
    figures_of,
)
from limbgram.shape.recipe.recipe import Recipe, described


@dataclass(frozen=True, kw_only=True)
class Replayed:
    """What a recipe made of a limb."""

    limb: Limb
    ledger: Ledger


def replay(recipe: Recipe, limb: Limb) -> Replayed:
    """Do the edits that are switched on, in order.

    Raises:
        EditError: an edit was refused; the message says which.
    """
    limb = outside_of(limb, as_bones=True)
    levels = choose_levels(limb)
    lines: list[Line] = []
    figures = figures_of(limb, levels)
    for number, entry in enumerate(track(recipe.entries), start=1):
        if not entry.on:
            continue
        try:
            after = do_edit(limb, entry.edit)
        except EditError as error:
            raise EditError(f"Edit {number} ({described(entry)}): {error}") from error
        gained = figures_of(after, levels)
        told = not isinstance(entry.edit, Mirror | Extension | Fill)
        moved = displacement_between(limb.mesh, after.mesh) if told else None
        lines.append(
            Line(
                number=number,
                edit=described(entry),
                before=figures,
                after=gained,
                displacement=moved,
            )
        )
        limb, figures = after, gained
    return Replayed(limb=limb, ledger=Ledger(levels_mm=levels, lines=tuple(lines)))


def require_scan(recipe: Recipe, scan_sha256: str, scan_name: str) -> None:
    """Refuse a scan that the recipe was not made for.

    Raises:
        OptionsError: the hash of the scan's file is another.
    """
    if recipe.scan_sha256 and recipe.scan_sha256 != scan_sha256:
        raise OptionsError(
            f'The recipe "{recipe.name}" was made for another file than {scan_name} as it is now. '
            "Its places may lie elsewhere on this one. Take the scan it was made for, or say "
            "--other-scan if you have checked that they fit."
        )
