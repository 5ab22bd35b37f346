"""Landmark uses: what each landmark of a kind of limb is needed for.

And which of them an edit or a device goes by, for what is said of those that nobody confirmed.
"""

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, Literal, get_args

from limbgram.workbench.anatomy.kind import Kind
from limbgram.workbench.devices.device import devices
from limbgram.workbench.recipe.recipe import Recipe

Use = Literal["axes", "sheet", "joint", "device", "no pressure", "build-up"]
USES: tuple[Use, ...] = get_args(Use)
"""It turns the limb into its frame; the measuring sheet, the turn of a joint or a device goes by
it; nothing should press there; it is built up by the preset."""


def uses_of(kind: Kind) -> Mapping[str, tuple[Use, ...]]:
    """The uses of each place of a kind, by its identity; empty where only its name is known."""
    sore = {name for one in kind.sensitive for name in (one.name, *one.also)}
    made = {name for one in devices().values() if one.kind == kind.name for name in one.landmarks}
    frame = {one.identity for one in kind.asked} | _names_in(kind.upright, kind)
    serving: Mapping[Use, set[str]] = {
        "axes": frame,
        "sheet": _names_in((kind.sheet, kind.centreline if kind.sheet else None), kind),
        "joint": _names_in(kind.joints, kind),
        "device": made,
        "no pressure": sore,
        "build-up": set(kind.presets),
    }
    return {
        place.identity: tuple(use for use in USES if place.identity in serving[use])
        for place in kind.places
    }


def landmarks_of_edits(recipe: Recipe, kind: Kind) -> frozenset[str]:
    """Names of the places and joints that a recipe's switched-on edits refer to.

    Among them may be words that name no landmark.
    """
    done = [one.edit for one in recipe.entries if one.on]
    said = {word for edit in done for word in _strings_in(edit)}
    joints = tuple(one for one in kind.joints if one.name in said)
    return frozenset(said | _names_in(joints, kind))


def _names_in(what: Any, kind: Kind) -> set[str]:
    """All strings inside items and joints, and inside the directions that they refer to."""
    directions = {one.name: one for one in kind.directions}
    found: set[str] = set()
    due = list(_strings_in(what))
    while due:
        word = due.pop()
        if word not in found:
            found.add(word)
            due += _strings_in(directions.get(word))
    return found


def _strings_in(what: Any) -> Iterator[str]:
    if isinstance(what, str):
        yield what
    elif isinstance(what, list | tuple):
        for one in what:
            yield from _strings_in(one)
    elif is_dataclass(what):
        for one in fields(what):
            yield from _strings_in(getattr(what, one.name))
