"""The recipe: an ordered list of edits, each switched on or off, made for one scan, and its replay.

A recipe is a value. Adding, undoing, moving and switching give another recipe; the scan itself is
never changed. Numbers of edits count from 1, as people do.

In      a Recipe and a Limb.
Out     the Limb after the edits that are on, and the ledger of what each of them did.
Method  The same recipe on the same limb gives the same bytes, whenever and on however many threads.
        Bodies inside the limb, such as bones, take no part and are left out first: edits would push
        them into its skin. So are loose bodies beside it.
Fails   EditError: an edit is refused, or presses on a sensitive place or goes unusually deep and
        the recipe does not accept that. For a record of what was done, `replay_as_it_is` only marks
        it in the ledger.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from difflib import SequenceMatcher

import numpy as np

from limbgram.core.errors import EditError, OptionsError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.notebook import brief
from limbgram.core.run import track
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.bodies import outside_of
from limbgram.workbench.edits.closing import enclosure_finding
from limbgram.workbench.edits.edit import Edit, Effect, name_of
from limbgram.workbench.edits.editing import do_edit, require_valid
from limbgram.workbench.edits.pressing import (
    LEAST_PRESSURE_MM,
    PlaceEffects,
    SkinHistory,
    depths_from_start,
    effects_at_places,
)
from limbgram.workbench.edits.regions import displaced
from limbgram.workbench.edits.thickness import solid_wall, wall_thickness
from limbgram.workbench.edits.wall import Wall, require_thickness_kept
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.lengths import barycentric_on_mesh
from limbgram.workbench.recipe.consent import (
    Concern,
    as_typed_words,
    carves,
    concerns_of,
    concerns_on_limb,
    findings_of,
    not_accepted,
    plain_words,
    words_for,
)
from limbgram.workbench.recipe.ledger import (
    Figures,
    Ledger,
    Line,
    choose_levels,
    cover_spans_mm,
    covers_after,
    cut_cover,
    displacement_between,
    extreme_girth,
    figures_of,
    volume_change,
)

_MOST_STATES = 12
"""Surfaces that are kept of replays; one of 250,000 triangles with its colours takes 12 MB."""
_LONGEST_TEXT = 60
"""Letters of a text that a line about an edit shows: a template is one, and fills pages."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """An edit in a recipe, with its switch and what is accepted."""

    edit: Edit
    on: bool = True
    """Whether replay does it."""
    accept: tuple[str, ...] = ()
    """What somebody means to do though it is unusual: see accepting."""


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """The edits of a scan, in order."""

    name: str
    scan_sha256: str = ""
    """Of the scan's file; empty for a recipe that is meant for any limb."""
    entries: tuple[Entry, ...] = ()
    notes: tuple[Finding, ...] = field(default=(), compare=False)
    """What was odd about its file and how it was taken; no part of what is written."""

    __repr__ = brief


@dataclass(frozen=True, kw_only=True)
class Replayed:
    """A limb after the edits of a recipe, with their ledger."""

    limb: Limb
    ledger: Ledger

    __repr__ = brief


@dataclass
class ReplayCache:
    """States of earlier replays of one limb, so that a changed recipe is replayed from its change.

    The figures and the shape are those of a replay from the start, to the last bit.
    """

    limb: Limb
    """The cache serves replays of this limb alone."""
    _states: "dict[tuple[Entry, ...], _ReplayState]" = field(
        default_factory=lambda: dict[tuple[Entry, ...], _ReplayState]()
    )

    def after(self, entries: tuple[Entry, ...]) -> "_ReplayState | None":
        return self._states.get(entries)

    def keep(self, entries: tuple[Entry, ...], reached: "_ReplayState") -> None:
        """Keep a state, and drop the oldest of too many: each holds a surface."""
        self._states[entries] = reached
        while len(self._states) > _MOST_STATES:
            del self._states[next(iter(self._states))]


def replay(recipe: Recipe, limb: Limb, kept: ReplayCache | None = None) -> Replayed:
    """Do the edits that are switched on, in order.

    Args:
        kept: States of earlier replays of this limb; used and extended.

    Raises:
        EditError: an edit was refused, or needs a word that the recipe does not say; the message
            says which.
    """
    for number, entry in enumerate(recipe.entries, start=1):
        if entry.on:
            _require_consent(number, entry, tuple(concerns_of(entry.edit, entry.accept, limb.kind)))
    done = replay_as_it_is(recipe, limb, kept)
    for line in done.ledger.lines:
        _require_consent(line.number, recipe.entries[line.number - 1], line.concerns)
    return done


def replay_as_it_is(recipe: Recipe, limb: Limb, kept: ReplayCache | None = None) -> Replayed:
    """Replay a recipe whatever it accepts, for the record of what was done.

    Raises:
        EditError: an edit was refused; the message says which.
    """
    memory = kept if kept is not None and kept.limb is limb else ReplayCache(limb)
    reached = memory.after(()) or _first_state(limb)
    memory.keep((), reached)
    began, levels = reached.limb, reached.levels_mm
    for number, entry in enumerate(track(recipe.entries), start=1):
        before = recipe.entries[:number]
        reached = memory.after(before) or _state_after(reached, number, entry)
        memory.keep(before, reached)
    ledger = Ledger(
        levels_mm=levels,
        lines=reached.lines,
        volume=volume_change(
            began,
            reached.positive.limb,
            cover_spans_mm(reached.positive.limb, reached.positive.covers_mm),
        )
        if reached.lines
        else None,
        places_mm=_shifts_with_pressure_mm(reached, began),
    )
    return Replayed(limb=reached.limb, ledger=ledger)


@dataclass(frozen=True)
class _Positive:
    """The last shape that encloses the limb, as a wall does not."""

    limb: Limb
    covers_mm: tuple[Points3, ...] = ()
    """Vertices of the cover of each of its cuts."""


@dataclass(frozen=True)
class _ReplayState:
    """The state of a replay after some edits."""

    limb: Limb
    figures: Figures
    levels_mm: tuple[float, ...]
    start: Limb
    """The skin from which depths count."""
    positive: "_Positive"
    """The last one, before a wall was made over it."""
    places_mm: Mapping[str, float]
    """How far each sensitive place's own landmark moved."""
    skin_history: SkinHistory
    covers_mm: tuple[Points3, ...] = ()
    """Vertices of what covers the cuts so far, those of a wall too."""
    lines: tuple[Line, ...] = ()
    wall_edit: Wall | None = None
    began_as_wall: bool = False
    """Whether the shape was a closed wall from the start, as a socket read from a file is."""


def _first_state(limb: Limb) -> _ReplayState:
    limb = outside_of(limb, as_bones=True)
    levels = choose_levels(limb)
    skin_history = SkinHistory.unmoved(limb)
    return _ReplayState(
        limb,
        figures_of(limb, levels),
        levels,
        limb,
        _Positive(limb),
        {},
        skin_history,
        began_as_wall=solid_wall(limb.mesh) is not None,
    )


def _shifts_with_pressure_mm(reached: _ReplayState, began: Limb) -> dict[str, float]:
    """The shift of the surface at each place by all edits; where they press, the deepest."""
    pressed_mm = reached.skin_history.pressed_mm(began)
    return {
        name: -pressed_mm[name]
        if pressed_mm[name] > max(LEAST_PRESSURE_MM, -moved_mm)
        else moved_mm
        for name, moved_mm in reached.places_mm.items()
    }


def _state_after(reached: _ReplayState, number: int, entry: Entry) -> _ReplayState:
    """The state of a replay after one more entry."""
    if not entry.on:
        return reached
    limb, places = reached.limb, dict(reached.places_mm)
    try:
        after = do_edit(limb, entry.edit)
        if reached.wall_edit is not None:
            require_thickness_kept(reached.wall_edit, wall_thickness(after.mesh))
    except EditError as error:
        raise EditError(
            "recipe.edit.refused", number=number, edit=described_entry(entry), reason=error.finding
        ) from error
    effect = entry.edit.about.effect
    covered = cut_cover(limb, after) if effect.volume == "cuts" else None
    covers = () if covered is None else (covered,)
    all_covers = (*covers_after(reached.covers_mm, limb, after), *covers)
    wall = entry.edit if isinstance(entry.edit, Wall) else reached.wall_edit
    gained = figures_of(after, reached.levels_mm, cover_spans_mm(after, all_covers), wall)
    found = PlaceEffects(pressures=(), shifts_mm={})
    reach_mm = (0.0, 0.0)
    if effect.moves_skin:
        found = effects_at_places(limb, after)
        for name, moved_mm in found.shifts_mm.items():
            places[name] = places.get(name, 0.0) + moved_mm
    if effect.at_place is not None:
        reach_mm = depths_from_start(reached.start.mesh, limb.mesh, after.mesh)
    moved = displacement_between(limb.mesh, after.mesh) if effect.reports_displacement else None
    becomes = effect.volume == "becomes"
    is_wall = becomes or reached.limb is not reached.positive.limb
    line = Line(
        number=number,
        edit=described_entry(entry),
        before=reached.figures,
        after=gained,
        volume=None if becomes else volume_change(limb, after, cover_spans_mm(after, covers)),
        extreme=extreme_girth(limb, after, moved, wall),
        displacement=moved,
        told=(
            *after.notes[len(limb.notes) :],
            *_wall_findings(reached, effect),
            enclosure_finding(after.mesh),
        ),
        concerns=tuple(concerns_on_limb(entry.edit, entry.accept, found, reach_mm, limb.kind)),
        becomes=becomes,
    )
    return _ReplayState(
        limb=after,
        figures=gained,
        levels_mm=reached.levels_mm,
        start=_reference_skin_after(entry.edit, reached.start, limb, after),
        positive=reached.positive if is_wall else _Positive(after, all_covers),
        covers_mm=all_covers,
        places_mm=places,
        skin_history=reached.skin_history.after(limb, after, moves_skin=effect.moves_skin),
        lines=(*reached.lines, line),
        wall_edit=wall,
        began_as_wall=reached.began_as_wall,
    )


def _wall_findings(reached: _ReplayState, effect: Effect) -> Iterator[Finding]:
    """That the shape becomes a wall, or that it is one whose inside an edit moves too."""
    made = reached.wall_edit
    walled = reached.began_as_wall if made is None else made.side == "outward"
    if effect.moves_skin and walled:
        yield doubt("recipe.on_wall")
    elif effect.volume == "becomes":
        yield note("recipe.becomes_wall")


def require_scan(recipe: Recipe, scan_sha256: str, scan_name: str) -> None:
    """Refuse a scan that the recipe was not made for.

    Raises:
        OptionsError: the hash of the scan's file is another.
    """
    if recipe.scan_sha256 and recipe.scan_sha256 != scan_sha256:
        raise OptionsError("recipe.other_scan", name=recipe.name, scan=scan_name)


def added(recipe: Recipe, edit: Edit, at: int | None = None, accept: Sequence[str] = ()) -> Recipe:
    """The recipe with one more edit: at its end, or so that it has the given number.

    Raises:
        OptionsError: there is no such place, the edit's numbers make sense on no limb, or it
            needs a word that is not among what is accepted.
    """
    words = plain_words(accept, "The new edit")
    place = len(recipe.entries) + 1 if at is None else at
    if not 1 <= place <= len(recipe.entries) + 1:
        raise OptionsError("recipe.number.added", most=len(recipe.entries) + 1, number=place)
    try:
        require_valid(edit)
        missing = not_accepted(concerns_of(edit, words))
        if missing:
            raise EditError(
                "recipe.asks",
                carves=carves(edit),
                concerns=findings_of(missing),
                words=words_for(missing),
                typed=as_typed_words(words_for(missing)),
            )
    except EditError as error:
        raise OptionsError("recipe.not_added", reason=error.finding) from error
    entries = list(recipe.entries)
    entries.insert(place - 1, Entry(edit=edit, accept=words))
    return replace(recipe, entries=tuple(entries))


def undone(recipe: Recipe, steps: int = 1) -> Recipe:
    """The recipe without its last edits."""
    if not 1 <= steps <= len(recipe.entries):
        raise OptionsError("recipe.number.undone", edits=len(recipe.entries), steps=steps)
    return replace(recipe, entries=recipe.entries[:-steps])


def beginning(recipe: Recipe, edits: int) -> Recipe:
    """The recipe as it was with its first edits alone: an earlier state, to compare with.

    Raises:
        OptionsError: it has fewer edits.
    """
    count = len(recipe.entries)
    if not 0 <= edits <= count:
        raise OptionsError("recipe.number.state", edits=count, number=edits)
    return replace(recipe, entries=recipe.entries[:edits])


def removed(recipe: Recipe, number: int) -> Recipe:
    """The recipe without one edit."""
    _entry(recipe, number)
    return replace(recipe, entries=recipe.entries[: number - 1] + recipe.entries[number:])


def moved(recipe: Recipe, number: int, to: int) -> Recipe:
    """The recipe with one edit in another place; it has the number `to` afterwards."""
    entry = _entry(recipe, number)
    _entry(recipe, to)
    entries = list(removed(recipe, number).entries)
    entries.insert(to - 1, entry)
    return replace(recipe, entries=tuple(entries))


def switched(recipe: Recipe, number: int, *, on: bool) -> Recipe:
    """The recipe with one edit switched on or off."""
    entry = replace(_entry(recipe, number), on=on)
    entries = (*recipe.entries[: number - 1], entry, *recipe.entries[number:])
    return replace(recipe, entries=entries)


def accepted(recipe: Recipe, number: int, words: Sequence[str]) -> Recipe:
    """The recipe with words of acceptance added to one edit.

    Raises:
        OptionsError: a word that accepts nothing.
    """
    entry = _entry(recipe, number)
    said = plain_words((*entry.accept, *words), f"Edit {number}")
    entries = list(recipe.entries)
    entries[number - 1] = replace(entry, accept=said)
    return replace(recipe, entries=tuple(entries))


def differences(old: Recipe, new: Recipe) -> tuple[str, ...]:
    """What changed from one recipe to another, a line for each change; none where they agree."""
    lines: list[str] = []
    if old.name != new.name:
        lines.append(f'name: "{old.name}" is "{new.name}" now')
    if old.scan_sha256 != new.scan_sha256:
        lines.append("scan: made for another file")
    before, after = [repr(entry) for entry in old.entries], [repr(entry) for entry in new.entries]
    for how, i, j, k, m in SequenceMatcher(None, before, after, autojunk=False).get_opcodes():
        if how == "equal":
            continue
        lines += _change_lines(old.entries[i:j], new.entries[k:m], i + 1, k + 1)
    return tuple(lines)


def described_entry(entry: Entry) -> str:
    """An edit in one line: its name and the parameters that differ from their defaults, or all."""
    given = [
        f"{name} = {_text_of(getattr(entry.edit, name))}"
        for name in distinctive_parameters(entry.edit)
    ]
    off = "" if entry.on else " (off)"
    meant = f" (accepted: {', '.join(entry.accept)})" if entry.accept else ""
    return f"{name_of(type(entry.edit))}{off}: {', '.join(given)}{meant}"


def distinctive_parameters(edit: Edit) -> tuple[str, ...]:
    """The parameters of an edit that differ from their defaults, or all if none does."""
    every = fields(edit)
    own = tuple(one.name for one in every if getattr(edit, one.name) != one.default)
    return own or tuple(one.name for one in every)


def _require_consent(number: int, entry: Entry, concerns: tuple[Concern, ...]) -> None:
    missing = not_accepted(concerns)
    if missing:
        raise EditError(
            "recipe.edit.asks",
            number=number,
            edit=described_entry(entry),
            carves=carves(entry.edit),
            concerns=findings_of(missing),
            words=words_for(missing),
            typed=as_typed_words(words_for(missing)),
        )


def _reference_skin_after(edit: Edit, start: Limb, before: Limb, after: Limb) -> Limb:
    """The skin from which depths count: without its sock, on the side that it has now."""
    match edit.about.effect.start:
        case "stays":
            return start
        case "follows":
            return after if start is before else _followed(edit, start, before, after)
        case "anew":
            return after


def _followed(edit: Edit, start: Limb, before: Limb, after: Limb) -> Limb:
    """A skin after the edit that was done to another one.

    Where the edit is refused on this one, as on a scan before it was cleaned, each place moves as
    the other skin moved next to it.
    """
    try:
        return do_edit(start, edit.repeated(after))
    except EditError:
        ids, shares = barycentric_on_mesh(before.mesh, start.mesh.vertices_mm)
        moves = (after.mesh.vertices_mm - before.mesh.vertices_mm)[ids]
        moved = displaced(start, start.mesh.vertices_mm + np.einsum("pk,pkd->pd", shares, moves))
        return replace(moved, sock_mm=after.sock_mm)


def _entry(recipe: Recipe, number: int) -> Entry:
    if not 1 <= number <= len(recipe.entries):
        raise OptionsError("recipe.number.none", edits=len(recipe.entries), number=number)
    return recipe.entries[number - 1]


def _change_lines(old: Sequence[Entry], new: Sequence[Entry], first: int, second: int) -> list[str]:
    """Lines for a run of entries that became another: pairs of one kind first, then the rest."""
    lines: list[str] = []
    shared = min(len(old), len(new))
    for step in range(shared):
        one, two = old[step], new[step]
        if type(one.edit) is type(two.edit):
            lines.append(_difference_line(one, two, first + step, second + step))
        else:
            lines.append(f"- {first + step}. {described_entry(one)}")
            lines.append(f"+ {second + step}. {described_entry(two)}")
    lines += [f"- {first + k}. {described_entry(old[k])}" for k in range(shared, len(old))]
    lines += [f"+ {second + k}. {described_entry(new[k])}" for k in range(shared, len(new))]
    return lines


def _difference_line(one: Entry, two: Entry, old_number: int, number: int) -> str:
    """What changed within an edit of one kind."""
    changes = [
        f"{given.name} {_text_of(getattr(one.edit, given.name))} -> "
        f"{_text_of(getattr(two.edit, given.name))}"
        for given in fields(one.edit)
        if getattr(one.edit, given.name) != getattr(two.edit, given.name)
    ]
    if one.accept != two.accept:
        changes.append(f"accept {_text_of(one.accept)} -> {_text_of(two.accept)}")
    if one.on != two.on:
        changes.append("switched on" if two.on else "switched off")
    place = f"{number}" if number == old_number else f"{old_number} (now {number})"
    return f"~ {place}. {name_of(type(one.edit))}: {', '.join(changes)}"


def _text_of(value: object) -> str:
    if isinstance(value, str):
        if len(value) > _LONGEST_TEXT:
            value = f"{' '.join(value[:_LONGEST_TEXT].split())} ..."
        return f'"{value}"'
    if isinstance(value, tuple):
        return f"[{', '.join(_text_of(part) for part in value)}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)
