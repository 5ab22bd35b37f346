"""Consent: the words with which somebody accepts what an edit does beyond the usual.

An edit that carves at a sensitive place, as a load or a pad does, or beyond USUAL_DEPTH_MM at any
chosen place, needs a word that stands with it in the recipe: `accept = ["load on fibula head"]`,
`accept = ["depth to 12 mm"]`. The place may be named, or be found near a
landmark when the edit is done. What presses as a whole (per cent, liners, plies, offsets,
templates) is stated in the ledger, and needs no word.
"""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from limbgram.core.errors import OptionsError
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.anatomy.names import identity_of
from limbgram.workbench.edits.edit import Edit
from limbgram.workbench.edits.pressing import USUAL_DEPTH_MM, PlaceEffects
from limbgram.workbench.frame.sensitive import SENSITIVE, sensitive_place
from limbgram.workbench.limb import KindName

_DEPTH_TOLERANCE_MM = 0.1
"""Tolerance to which a depth is found again on a triangle mesh."""
_LOAD = re.compile(r"load on (.+)")
_DEPTH = re.compile(r"depth to (\d{1,3}(?:\.\d{1,3})?) ?mm")
_PLACE_NAMES = frozenset(place.name for places in SENSITIVE.values() for place in places)
"""One place may have several: an iliac spine is another one on a trunk than on a thigh."""


@dataclass(frozen=True, kw_only=True)
class Concern:
    """A finding about an edit that somebody has to accept, or to know."""

    finding: Finding
    word: str
    """The word that accepts it; empty where none is needed."""
    accepted: bool
    """Whether the recipe says the word; True where none is needed."""


class _PlacedDepth(NamedTuple):
    """The depth of an edit at a place that somebody chose."""

    carves: bool
    depth_mm: float
    landmark: str | None
    """The place's name; None of coordinates and of a region."""


def plain_words(words: Iterable[str], what: str) -> tuple[str, ...]:
    """Words of acceptance in their one form, each once.

    Raises:
        OptionsError: a word that accepts nothing.
    """
    return tuple(dict.fromkeys(_plain_word(word, what) for word in words))


def concerns_of(
    edit: Edit, words: Sequence[str], kind: KindName | None = None
) -> Iterator[Concern]:
    """Concerns from the edit's parameters alone, before there is a limb."""
    placed = _placed_depth(edit)
    if placed is None:
        return
    words = _words_in_kind(words, kind)
    if placed.carves and placed.landmark is not None:
        place = sensitive_place(placed.landmark, kind)
        if place is not None:
            found = doubt("recipe.load_on", place=place.name, why=place.why)
            yield _concern_of_finding(found, f"load on {place.name}", words)
    yield from _depth_concerns(placed, (0.0, 0.0), words)


def concerns_on_limb(
    edit: Edit,
    words: Sequence[str],
    found: PlaceEffects,
    reach_mm: tuple[float, float],
    kind: KindName | None = None,
) -> Iterator[Concern]:
    """Concerns from the edited limb: places that the edit presses on, and depths there.

    reach_mm: how far inward and outward of the scan the edit leaves what it moved.
    """
    placed = _placed_depth(edit)
    if placed is not None:
        words = _words_in_kind(words, kind)
        for one in found.pressures:
            pressing = doubt("recipe.presses", depth_mm=one.depth_mm, place=one.place, why=one.why)
            yield _concern_of_finding(pressing, f"load on {one.place}", words)
        yield from _depth_concerns(placed, reach_mm, words)
    elif found.pressures:
        each = tuple(
            note("recipe.pressure", place=one.place, depth_mm=one.depth_mm)
            for one in found.pressures
        )
        yield Concern(finding=note("recipe.presses_on", each=each), word="", accepted=True)


def carves(edit: Edit) -> bool:
    """Whether it carves in at a place that somebody chooses, which presses there."""
    return edit.about.effect.at_place == "carves"


def not_accepted(concerns: Iterable[Concern]) -> tuple[Concern, ...]:
    """The concerns that need a word which nobody has said."""
    return tuple(one for one in concerns if not one.accepted)


def findings_of(concerns: Iterable[Concern]) -> tuple[Finding, ...]:
    """The findings of concerns, each once."""
    return tuple(dict.fromkeys(one.finding for one in concerns))


def words_for(concerns: Iterable[Concern]) -> tuple[str, ...]:
    """The words that accept concerns, each once."""
    return tuple(dict.fromkeys(one.word for one in concerns))


def as_typed_words(words: Iterable[str]) -> str:
    """Words quoted as they are typed in a command."""
    return " ".join(f'"{word}"' for word in words)


def _placed_depth(edit: Edit) -> _PlacedDepth | None:
    if edit.about.effect.at_place is None:
        return None
    given = vars(edit)
    at = given["at"]
    return _PlacedDepth(carves(edit), given["depth_mm"], at if isinstance(at, str) else None)


def _depth_concerns(
    placed: _PlacedDepth, reach_mm: tuple[float, float], words: Sequence[str]
) -> Iterator[Concern]:
    """A concern about the depth asked for, or reached by all edits together, if unusual."""
    together, where = (reach_mm[0], "inside") if placed.carves else (reach_mm[1], "outside")
    depth = round(max(together, placed.depth_mm), 1)
    if depth <= USUAL_DEPTH_MM:
        return
    deep = doubt("recipe.deep", depth_mm=placed.depth_mm, usual_mm=USUAL_DEPTH_MM)
    if together > placed.depth_mm + _DEPTH_TOLERANCE_MM:
        deep = doubt("recipe.deep_together", depth_mm=depth, where=where, usual_mm=USUAL_DEPTH_MM)
    limits = [float(found[1]) for word in words if (found := _DEPTH.fullmatch(word))]
    yield Concern(
        finding=deep,
        word=f"depth to {math.ceil(depth)} mm",
        accepted=max(limits, default=0.0) >= depth,
    )


def _concern_of_finding(found: Finding, word: str, words: Sequence[str]) -> Concern:
    return Concern(finding=found, word=word, accepted=word in words)


def _plain_word(word: str, what: str) -> str:
    plain = " ".join(word.casefold().split())
    depth = _DEPTH.fullmatch(plain)
    if depth is not None:
        return f"depth to {float(depth[1]):g} mm"
    load = _LOAD.fullmatch(plain)
    named = "" if load is None else load[1].removeprefix("the ")
    place = sensitive_place(named, None) if named else None
    if place is None:
        raise OptionsError("recipe.word", what=what, word=word)
    own = identity_of(named)
    return f"load on {own if own in _PLACE_NAMES else place.name}"


def _words_in_kind(words: Sequence[str], kind: KindName | None) -> tuple[str, ...]:
    """The words with places under the names that the kind has for them."""
    return tuple(_word_in_kind(word, kind) for word in words)


def _word_in_kind(word: str, kind: KindName | None) -> str:
    load = _LOAD.fullmatch(word)
    place = None if load is None else sensitive_place(load[1], kind)
    return word if place is None else f"load on {place.name}"
