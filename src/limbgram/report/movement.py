"""Movement in words: how far the limb moved, in which photos, and what was done about it."""

import math
from collections.abc import Sequence

import numpy as np

from limbgram.reconstruction.mapping.scene import Movement, Scene

_NAMED_AT_MOST = 6


def moved_mm(movement: Movement | None) -> float:
    """Largest shift between any two photos, in the scene's unit; NaN where it is not known."""
    if movement is None or movement.kind == "unknown":
        return math.nan
    if not movement.moved:
        return 0.0
    largest = float(np.nanmax(movement.shift))
    # a drift is counted from its middle, and so half of it on either side
    ends = movement.shift[np.isfinite(movement.shift)][[0, -1]]
    return float(ends.sum()) if movement.kind == "drift" else largest


def movement_sentence(movement: Movement, names: Sequence[str], unit: str) -> str:
    """What happened, in a sentence."""
    if movement.kind == "unknown":
        return f"Whether the limb kept still is not known: {movement.reason}."
    far = f"{moved_mm(movement):.1f} {unit}"
    turn = f"{float(np.nanmax(movement.turn_deg)):.1f} degrees"
    match movement.kind:
        case "still":
            return "The limb kept still against its surroundings."
        case "drift":
            return f"The limb moved slowly through all photos, by {far} in all."
        case "restless":
            return (
                "Limb and surroundings lie otherwise against each other in every photo, by up to "
                f"{far} and {turn}: the limb swayed, things round it were moved, or the camera's "
                "stabiliser or rolling shutter bent the photos."
            )
        case "step":
            return (
                f"The limb moved by up to {far} and turned by {turn} between the photos: it lies "
                f"elsewhere in {_listed(moved_photos(movement, names))}."
            )


def bending_sentence(bending: Movement, names: Sequence[str], unit: str) -> str:
    """Whether the limb kept its shape, in a sentence."""
    if bending.kind == "unknown":
        return f"Whether the limb kept its shape is not known: {bending.reason}."
    if not bending.moved:
        return "Both halves of the limb kept still against each other."
    where = "from photo to photo"
    if bending.kind == "step":
        where = f"in {_listed(moved_photos(bending, names))}"
    return (
        f"The limb bent: one half of its length moved by {moved_mm(bending):.1f} {unit} and "
        f"{float(np.nanmax(bending.turn_deg)):.1f} degrees against the other {where}."
    )


def moved_photos(movement: Movement, names: Sequence[str]) -> tuple[str, ...]:
    """Photos that show the limb elsewhere than the largest group does."""
    return tuple(name for name, far in zip(names, movement.shift, strict=True) if far > 0.0)


def movement_remark(scene: Scene, photo_idx: int, unit: str) -> tuple[str, ...]:
    """What is odd about one photo; nothing where the limb kept still in it."""
    movement = scene.movement
    if movement is None or not movement.shift[photo_idx] > 0.0:
        return ()
    others = "most photos" if movement.kind == "step" else "the middle of the walk"
    return (f"the limb lies {movement.shift[photo_idx]:.1f} {unit} from where {others} show it",)


def _listed(names: Sequence[str]) -> str:
    more = len(names) - _NAMED_AT_MOST
    shown = ", ".join(names[:_NAMED_AT_MOST])
    return f"{shown} and {more} more" if more > 0 else shown
