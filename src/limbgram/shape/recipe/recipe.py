"""The recipe: an ordered list of edits, each switched on or off, made for one scan.

A recipe is a value. Adding, undoing, moving and switching give another recipe; the scan itself is
never changed. Numbers of edits count from 1, as people do.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from difflib import SequenceMatcher

from limbgram.errors import EditError, OptionsError
from limbgram.shape.edits.editing import Edit, name_of, require_sense
from limbgram.shape.recipe.accepting import concerns_of, plain_words, require_accepted


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One edit of a recipe."""

    edit: Edit
    on: bool = True
    """Whether replay does it."""
    accept: tuple[str, ...] = ()
    """What somebody means to do though it is unusual: see accepting."""


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """What is done to a scan, in order."""

    name: str
    scan_sha256: str = ""
    """Of the scan's file; empty for a recipe that is meant for any limb."""
    entries: tuple[Entry, ...] = ()
    notes: tuple[str, ...] = field(default=(), compare=False)
    """What was odd about its file and how it was taken; no part of what is written."""


def added(recipe: Recipe, edit: Edit, at: int | None = None, accept: Sequence[str] = ()) -> Recipe:
    """The recipe with one more edit: at its end, or so that it has the given number.

    Raises:
        OptionsError: there is no such place, the edit's numbers make sense on no limb, or it
            needs a word that is not among what is accepted.
    """
    words = plain_words(accept, "The new edit")
    place = len(recipe.entries) + 1 if at is None else at
    if not 1 <= place <= len(recipe.entries) + 1:
        raise OptionsError(
            f"An edit can be added as number 1 to {len(recipe.entries) + 1}, not as {place}."
        )
    try:
        require_sense(edit)
        require_accepted(concerns_of(edit, words), "this edit", "--accept")
    except EditError as error:
        raise OptionsError(f"Not added: {error}") from error
    entries = list(recipe.entries)
    entries.insert(place - 1, Entry(edit=edit, accept=words))
    return replace(recipe, entries=tuple(entries))


def undone(recipe: Recipe, steps: int = 1) -> Recipe:
    """The recipe without its last edits."""
    if not 1 <= steps <= len(recipe.entries):
        raise OptionsError(f"The recipe has {len(recipe.entries)} edits; {steps} cannot be undone.")
    return replace(recipe, entries=recipe.entries[:-steps])


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
    """The recipe with one edit that somebody means as it is, by the words said for it.

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
        lines += _change(old.entries[i:j], new.entries[k:m], i + 1, k + 1)
    return tuple(lines)


def described(entry: Entry) -> str:
    """An edit in one line: its name and the parameters that differ from their defaults, or all."""
    values = {one.name: getattr(entry.edit, one.name) for one in fields(entry.edit)}
    usual = {one.name: one.default for one in fields(entry.edit)}
    own = {name: value for name, value in values.items() if value != usual[name]}
    given = [f"{name} = {_shown(value)}" for name, value in (own or values).items()]
    off = "" if entry.on else " (off)"
    meant = f" (accepted: {', '.join(entry.accept)})" if entry.accept else ""
    return f"{name_of(type(entry.edit))}{off}: {', '.join(given)}{meant}"


def _entry(recipe: Recipe, number: int) -> Entry:
    if not 1 <= number <= len(recipe.entries):
        raise OptionsError(f"The recipe has edits 1 to {len(recipe.entries)}; none is {number}.")
    return recipe.entries[number - 1]


def _change(old: Sequence[Entry], new: Sequence[Entry], first: int, second: int) -> list[str]:
    """Lines for a run of entries that became another: pairs of one kind first, then the rest."""
    lines: list[str] = []
    shared = min(len(old), len(new))
    for step in range(shared):
        one, two = old[step], new[step]
        if type(one.edit) is type(two.edit):
            lines.append(_difference(one, two, first + step, second + step))
        else:
            lines.append(f"- {first + step}. {described(one)}")
            lines.append(f"+ {second + step}. {described(two)}")
    lines += [f"- {first + k}. {described(old[k])}" for k in range(shared, len(old))]
    lines += [f"+ {second + k}. {described(new[k])}" for k in range(shared, len(new))]
    return lines


def _difference(one: Entry, two: Entry, old_number: int, number: int) -> str:
    """What changed within an edit of one kind."""
    changes = [
        f"{given.name} {_shown(getattr(one.edit, given.name))} -> "
        f"{_shown(getattr(two.edit, given.name))}"
        for given in fields(one.edit)
        if getattr(one.edit, given.name) != getattr(two.edit, given.name)
    ]
    if one.accept != two.accept:
        changes.append(f"accept {_shown(one.accept)} -> {_shown(two.accept)}")
    if one.on != two.on:
        changes.append("switched on" if two.on else "switched off")
    place = f"{number}" if number == old_number else f"{old_number} (now {number})"
    return f"~ {place}. {name_of(type(one.edit))}: {', '.join(changes)}"


def _shown(value: object) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return f"[{', '.join(_shown(part) for part in value)}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)
