"""Marks: painted spots, as the photos of a case show them or as the shape's own colours do."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import UInt8

from limbgram.cli.replies import Reply
from limbgram.cli.workbench.stating.typed import colour_of
from limbgram.geometry.arrays import Vector3
from limbgram.geometry.interval import Interval, explained, plus_minus
from limbgram.shape.limb import Limb

_SHOWN_AT_MOST = 12
_MOST_SHARED = 0.4


@dataclass(frozen=True)
class Seen:
    """Marks in the order of their numbers, and a reply that lists them."""

    places_mm: tuple[Vector3, ...]
    reply: Reply


def marks_seen(limb: Limb, case: Path | None, colour: str | None) -> Seen:
    """The marks on a shape: from the photos of its case if there is one, else from its colours."""
    wanted = colour_of(colour)
    return _on_shape(limb, wanted) if case is None else _in_photos(limb, case, wanted)


def _on_shape(limb: Limb, colour: tuple[int, int, int] | None) -> Seen:
    from limbgram.shape.frame.marks import MarkOptions, find_marks

    found = find_marks(limb.mesh, MarkOptions(colour=colour))
    lines = [
        f"#{number}: {mark.diameter_mm:4.1f} mm across, colour {_rgb(mark.colour)}, at "
        f"{_place(mark.position_mm)}"
        for number, mark in enumerate(found, 1)
    ]
    content = [
        {
            "number": number,
            "position_mm": mark.position_mm.tolist(),
            "colour": mark.colour.tolist(),
            "diameter_mm": mark.diameter_mm,
        }
        for number, mark in enumerate(found, 1)
    ]
    none = "No painted mark is seen: none is round, of one strong colour and size."
    return Seen(
        tuple(mark.position_mm for mark in found),
        Reply(tuple(lines) or (none,), {"marks": content, "left_out": []}),
    )


def _in_photos(limb: Limb, case: Path, colour: tuple[int, int, int] | None) -> Seen:
    from limbgram.cases.assessing.painted import painted_marks_of
    from limbgram.cases.folder import CaseFolder
    from limbgram.shape.painted import PaintedOptions

    found = painted_marks_of(CaseFolder(case), limb.mesh, PaintedOptions(colour=colour))
    lines = [
        f"#{number}: {mark.diameter_mm:4.1f} mm across, colour {_rgb(mark.colour)}, at "
        f"{_place(mark.position_mm)} {plus_minus(Interval.of_sigma(mark.sigma_mm), 2)} mm, in "
        f"{len(mark.photos)} of {mark.looking} photos that look at it"
        for number, mark in enumerate(found.marks, 1)
    ]
    lines = lines or [
        "No mark is seen that several photos agree on. Say its colour with --colour; a mark is a "
        "round spot, 4 to 30 mm across, of a colour that the sock does not have."
    ]
    if found.marks and found.shared_share > _MOST_SHARED:
        lines.append(
            f"The sock has that colour too: {found.shared_share:.0%} of it lies outside round "
            "spots. Look at each place before you name it."
        )
    left_out = [
        f"Not offered: a spot of colour {_rgb(spot.colour)} at {_place(spot.position_mm)}: "
        f"{spot.reason}."
        for spot in found.left_out
    ]
    lines += left_out[:_SHOWN_AT_MOST]
    if len(left_out) > _SHOWN_AT_MOST:
        lines.append(f"... and {len(left_out) - _SHOWN_AT_MOST} more.")
    content: dict[str, Any] = {
        "shared_share": found.shared_share,
        "marks": [
            {
                "number": number,
                "position_mm": mark.position_mm.tolist(),
                "colour": mark.colour.tolist(),
                "diameter_mm": mark.diameter_mm,
                "spread_mm": mark.spread_mm,
                "sigma_mm": mark.sigma_mm,
                "photos": list(mark.photos),
                "photos_looking": mark.looking,
            }
            for number, mark in enumerate(found.marks, 1)
        ],
        "left_out": [
            {
                "position_mm": spot.position_mm.tolist(),
                "colour": spot.colour.tolist(),
                "reason": spot.reason,
            }
            for spot in found.left_out
        ],
    }
    return Seen(tuple(mark.position_mm for mark in found.marks), Reply(explained(lines), content))


def _rgb(colour: UInt8[np.ndarray, "3"]) -> tuple[int, ...]:
    return tuple(colour.tolist())


def _place(position_mm: Vector3) -> str:
    return ",".join(f"{value:.1f}" for value in position_mm)
