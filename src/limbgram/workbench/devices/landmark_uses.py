"""Landmark uses: what each landmark of a kind of limb is needed for.

And which of them a recipe or a device goes by, for what is said of those that nobody confirmed.
"""

from collections.abc import Mapping
from typing import Literal, get_args

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
    frame = {one.identity for one in kind.asked} | kind.names_in(kind.upright)
    serving: Mapping[Use, set[str]] = {
        "axes": frame,
        "sheet": kind.names_in((kind.sheet, kind.centreline if kind.sheet else None)),
        "joint": kind.names_in(kind.joints),
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
    return frozenset(name for one in recipe.entries if one.on for name in one.edit.places_of(kind))
