"""Landmark uses: what each landmark of a kind of limb is needed for.

And which of them an edit or a device goes by, for what is said of those that nobody confirmed.
"""

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, Literal, get_args

from limbgram.workbench.anatomy.kind import Angle, Kind
from limbgram.workbench.devices.device import devices
from limbgram.workbench.edits.arch_fill import ArchFill
from limbgram.workbench.edits.build_ups import BuildUps
from limbgram.workbench.edits.edit import Edit
from limbgram.workbench.edits.expansion import Expansion
from limbgram.workbench.edits.heel_skive import HeelSkive
from limbgram.workbench.edits.plantar_board import PlantarBoard
from limbgram.workbench.edits.repose import Repose
from limbgram.workbench.edits.toe_bridge import ToeBridge
from limbgram.workbench.recipe.recipe import Recipe

_OF_TOES = ("plantar", "foot", "first metatarsal head", "fifth metatarsal head", "second toe")
_OF_SOLE = (*_OF_TOES, "lateral", "heel", "navicular")
"""Directions and places by which toes are bridged, and by which a sole is edited."""
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
    """Names of the places and joints that a recipe's switched-on edits go by.

    Among them may be words that name no landmark.
    """
    done = (one.edit for one in recipe.entries if one.on)
    return frozenset(name for edit in done for name in _names_of_edit(edit, kind))


def _names_of_edit(edit: Edit, kind: Kind) -> set[str]:
    """Names that an edit says, and those that its work goes by."""
    match edit:
        case BuildUps():
            return set(edit.places_of(kind))
        case ArchFill() | Expansion() | HeelSkive() | PlantarBoard():
            return _names_in(_OF_SOLE, kind)
        case ToeBridge():
            return _names_in(_OF_TOES, kind)
        case Repose():
            joints = tuple(one for one in kind.joints if one.name == edit.joint)
            read = {one.reads for one in joints if edit.to_deg is not None}
            angles = [one for one in kind.sheet if isinstance(one, Angle) and one.name in read]
            return _names_in((joints, [(one.of, one.to, one.about) for one in angles]), kind)
        case _:
            return set(_strings_in(edit))


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
