"""Movement in words: how far the limb moved, in which photos, and what was done about it."""

import math
from collections.abc import Sequence

import numpy as np

from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.mapping.scene import Movement, Scene
from limbgram.reconstruction.photos.photo import listed


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
        case "still" if movement.beside:
            return (
                "Limb and scale board kept still against each other. Other things round them lay "
                "elsewhere from photo to photo, and the surface is made without them."
            )
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
                f"elsewhere in {listed(moved_photos(movement, names))}."
            )


def lens_doubt(scene: Scene, cameras: Cameras) -> str:
    """Why the lenses of photos may be others than were found; empty where they are known."""
    if any(one.source == "exif" for one in cameras.calibrations):
        return "no board calibrated it"
    return "" if scene.own is None else "it differed from photo to photo"


def bending_sentence(bending: Movement, names: Sequence[str], unit: str, doubt: str = "") -> str:
    """Whether the limb kept its shape; what was seen, and what may have caused it.

    Args:
        doubt: Why the lens may be another than was found, which looks the same (`lens_doubt`).
    """
    if bending.kind == "unknown":
        return f"Whether the limb kept its shape is not known: {bending.reason}."
    if not bending.moved:
        return "Both halves of the limb kept still against each other."
    where = "from photo to photo"
    if bending.kind == "step":
        where = f"in {listed(moved_photos(bending, names))}"
    far = f"{moved_mm(bending):.1f} {unit} and {float(np.nanmax(bending.turn_deg)):.1f} degrees"
    rigid = "No rigid surface fits all photos."
    if doubt:
        return (
            f"The two halves of its length lie elsewhere against each other {where}, by up to "
            f"{far}. Either the limb bent, or the lens is not what was found, because {doubt}. "
            f"{rigid}"
        )
    return (
        f"The limb bent: one half of its length moved by {far} against the other {where}. {rigid}"
    )


def moved_photos(movement: Movement, names: Sequence[str]) -> tuple[str, ...]:
    """Photos that show the limb elsewhere than the largest group does."""
    return tuple(name for name, far in zip(names, movement.shift, strict=True) if far > 0.0)


def movement_remark(scene: Scene, photo_idx: int, unit: str) -> tuple[str, ...]:
    """What is odd about one photo; nothing where the limb kept still in it."""
    movement = scene.movement
    if movement is None or not movement.shift[photo_idx] > 0.0:
        return ()
    others = "most photos show" if movement.kind == "step" else "the middle of the walk shows"
    return (f"the limb lies {movement.shift[photo_idx]:.1f} {unit} from where {others} it",)
