"""Replay: a recipe done to a limb, with the ledger of what each edit did.

The same recipe on the same limb gives the same bytes, whenever and on however many threads. Bodies
inside the limb, such as bones, take no part and are left out first: edits would push them into its
skin. So are loose bodies beside it.

What presses on a sensitive place, or goes unusually deep, is marked in the ledger, and refused
unless the recipe accepts it; a record of what was done is made by `replay_as_it_is`.
"""

from dataclasses import dataclass

from limbgram.errors import EditError, OptionsError
from limbgram.run import track
from limbgram.shape.bodies import outside_of
from limbgram.shape.edits.cleaning import Clean
from limbgram.shape.edits.editing import Edit, do_edit
from limbgram.shape.edits.ends.brim import Extension
from limbgram.shape.edits.presets import Sock
from limbgram.shape.edits.pressing import AtPlaces, at_places, reach_of
from limbgram.shape.edits.regional import Load, Relieve
from limbgram.shape.edits.solids.making import Fill, Mirror, Wall, require_thickness_kept
from limbgram.shape.edits.solids.thickness import wall_of
from limbgram.shape.limb import Limb
from limbgram.shape.recipe.accepting import (
    MOVING,
    Concern,
    concerns_of,
    concerns_on_limb,
    require_accepted,
)
from limbgram.shape.recipe.ledger import (
    Ledger,
    Line,
    choose_levels,
    displacement_between,
    figures_of,
)
from limbgram.shape.recipe.recipe import Entry, Recipe, described


@dataclass(frozen=True, kw_only=True)
class Replayed:
    """What a recipe made of a limb."""

    limb: Limb
    ledger: Ledger


def replay(recipe: Recipe, limb: Limb) -> Replayed:
    """Do the edits that are switched on, in order.

    Raises:
        EditError: an edit was refused, or needs a word that the recipe does not say; the message
            says which.
    """
    for number, entry in enumerate(recipe.entries, start=1):
        if entry.on:
            _require(number, entry, tuple(concerns_of(entry.edit, entry.accept, limb.kind)))
    done = replay_as_it_is(recipe, limb)
    for line in done.ledger.lines:
        _require(line.number, recipe.entries[line.number - 1], line.concerns)
    return done


def replay_as_it_is(recipe: Recipe, limb: Limb) -> Replayed:
    """The same, whatever the recipe accepts: for the record of what was done.

    Raises:
        EditError: an edit was refused; the message says which.
    """
    limb = outside_of(limb, as_bones=True)
    levels = choose_levels(limb)
    lines: list[Line] = []
    figures = figures_of(limb, levels)
    start, places = limb, dict[str, float]()
    walled: Wall | None = None
    for number, entry in enumerate(track(recipe.entries), start=1):
        if not entry.on:
            continue
        try:
            after = do_edit(limb, entry.edit)
            if walled is not None:
                require_thickness_kept(walled, wall_of(after.mesh))
        except EditError as error:
            raise EditError(f"Edit {number} ({described(entry)}): {error}") from error
        walled = entry.edit if isinstance(entry.edit, Wall) else walled
        gained = figures_of(after, levels)
        found = AtPlaces(pressures=(), shifts_mm={})
        reach_mm = (0.0, 0.0)
        if isinstance(entry.edit, MOVING):
            found = at_places(limb, after)
            for name, moved_mm in found.shifts_mm.items():
                places[name] = places.get(name, 0.0) + moved_mm
        if isinstance(entry.edit, Load | Relieve):
            reach_mm = reach_of(start.mesh, limb.mesh, after.mesh)
        start = _start_after(entry.edit, start, limb, after)
        told = not isinstance(entry.edit, Mirror | Extension | Fill | Clean)
        moved = displacement_between(limb.mesh, after.mesh) if told else None
        lines.append(
            Line(
                number=number,
                edit=described(entry),
                before=figures,
                after=gained,
                displacement=moved,
                told=after.notes[len(limb.notes) :],
                concerns=tuple(concerns_on_limb(entry.edit, entry.accept, found, reach_mm)),
            )
        )
        limb, figures = after, gained
    ledger = Ledger(levels_mm=levels, lines=tuple(lines), places_mm=places)
    return Replayed(limb=limb, ledger=ledger)


def _require(number: int, entry: Entry, concerns: tuple[Concern, ...]) -> None:
    how = f"`limbgram edit accept RECIPE {number}`"
    require_accepted(concerns, f"Edit {number} ({described(entry)})", how)


def _start_after(edit: Edit, start: Limb, before: Limb, after: Limb) -> Limb:
    """The skin from which depths count: without its sock, on the side that it has now."""
    if isinstance(edit, Wall):
        return after
    if isinstance(edit, Mirror | Sock):
        return after if start is before else do_edit(start, edit)
    return start


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
