"""Landmark options: landmarks typed, painted or stuck on, for commands that need them named."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from jaxtyping import UInt8

from limbgram.cli.replies import Reply, spoken
from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.interval import Interval, plus_minus, what_it_means
from limbgram.core.request_fields import Flag
from limbgram.core.typed import tree_of
from limbgram.findings import note
from limbgram.services.parse_text import COLOUR, asks_for_marks, landmarks_of, sticker_names
from limbgram.workbench.limb import Landmark, Limb

_SHOWN_AT_MOST = 12
_MOST_SHARED = 0.4


@dataclass(frozen=True, kw_only=True)
class MarksRequest:
    """Which landmarks there are, and where they are looked for."""

    landmarks: Annotated[tuple[str, ...], Flag("landmark")] = ()
    """NAME=X,Y,Z in mm in the frame of the shape, or NAME=#2 for a painted mark; it is moved to
    the nearest place on the surface."""
    marks: bool = False
    """Only list the painted marks that are seen."""
    photos: Path | None = None
    """Look for painted marks in the photos of the case that made the shape, a CASE folder; without
    it in the shape's own colours."""
    stickers: Path | None = None
    """Names of coded stickers, a JSON file such as {"12": "fibula head"}: with --photos each is
    the landmark of its name."""
    colour: Annotated[tuple[int, int, int] | None, COLOUR] = None
    """Colour of the painted marks: magenta, or red,green,blue from 0 to 255; without it any that
    the sock's paint does not have."""


@dataclass(frozen=True, kw_only=True)
class ProposalRequest:
    """Landmarks that another scan of the limb tells, and which of them somebody has looked at."""

    landmarks_from: Path | None = None
    """Propose the landmarks of a marked scan of the same limb, such as an earlier visit's, each
    with its error. What is made of them says so until they are confirmed."""
    confirm: tuple[str, ...] = ()
    """A proposal that you have looked at on the shape, by its name; all for every one."""

    def __post_init__(self) -> None:
        """Refuse to confirm what nobody can have looked at yet."""
        if self.landmarks_from is not None and self.confirm:
            raise OptionsError("carried.confirm_later")


@dataclass(frozen=True)
class Seen:
    """Marks in the order of their numbers, and a reply that lists them."""

    places_mm: tuple[Vector3, ...]
    reply: Reply


def marks_seen(limb: Limb, ask: MarksRequest) -> Seen | None:
    """The painted marks, from the photos of a case or else from the shape's colours.

    None where nobody asks for any.

    Raises:
        OptionsError: options that say nothing without others.
    """
    wanted = ask.marks or asks_for_marks(ask.landmarks)
    if ask.stickers is not None and ask.photos is None:
        raise OptionsError("landmark.stickers.no_photos")
    if wanted:
        if ask.photos is None:
            return _on_shape(limb, ask.colour)
        return _in_photos(limb, ask.photos, ask.colour)
    if (ask.photos is not None and ask.stickers is None) or ask.colour is not None:
        raise OptionsError("landmark.marks.not_asked")
    return None


def landmarks_asked(limb: Limb, ask: MarksRequest, seen: Seen | None) -> tuple[Landmark, ...]:
    """The landmarks that are named, typed or by stickers.

    Raises:
        OptionsError: one has no place.
    """
    named = landmarks_of(ask.landmarks, () if seen is None else seen.places_mm)
    if ask.stickers is None or ask.photos is None:
        return named
    return (*named, *_sticker_landmarks(limb, ask.photos, sticker_names(ask.stickers)))


def _on_shape(limb: Limb, colour: tuple[int, int, int] | None) -> Seen:
    from limbgram.workbench.frame.painted_marks import find_marks

    found = find_marks(limb.mesh, colour)
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
    from limbgram.cases.case_assessment import painted_marks_of
    from limbgram.cases.folder import CaseFolder

    found = painted_marks_of(CaseFolder(case), limb.mesh, colour)
    sure = [Interval.of_sigma(mark.sigma_mm) for mark in found.marks]
    lines = [
        f"#{number}: {mark.diameter_mm:4.1f} mm across, colour {_rgb(mark.colour)}, at "
        f"{_place(mark.position_mm)} {plus_minus(interval, 2)} mm, in "
        f"{len(mark.photos)} of {mark.looking} photos that look at it"
        for number, (mark, interval) in enumerate(zip(found.marks, sure, strict=True), 1)
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
        f"{spoken(spot.reason)}."
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
                "reason": tree_of(spot.reason),
            }
            for spot in found.left_out
        ],
    }
    reply = Reply((*lines, *what_it_means(sure)), content)
    return Seen(tuple(mark.position_mm for mark in found.marks), reply)


def _sticker_landmarks(limb: Limb, case: Path, names: dict[int, str]) -> tuple[Landmark, ...]:
    """The stickers that have a name, where the photos of the case put them.

    Raises:
        OptionsError: a named one has no place.
    """
    from limbgram.cases.case_assessment import stickers_of
    from limbgram.cases.folder import CaseFolder

    found = stickers_of(CaseFolder(case), limb.mesh)
    places = {one.mark_id: one.position_mm for one in found.placed}
    reasons = {one.mark_id: one.reason for one in found.lost}
    missing = tuple(
        note("landmark.stickers.one", number=number, name=name, reason=reasons.get(number))
        for number, name in names.items()
        if number not in places
    )
    if missing:
        raise OptionsError(
            "landmark.stickers.unplaced", missing=missing, seen=tuple(places) or None
        )
    return tuple(
        Landmark(name=name, position_mm=places[number], placed="painted")
        for number, name in names.items()
    )


def _rgb(colour: UInt8[np.ndarray, "3"]) -> tuple[int, ...]:
    return tuple(colour.tolist())


def _place(position_mm: Vector3) -> str:
    return ",".join(f"{value:.1f}" for value in position_mm)
