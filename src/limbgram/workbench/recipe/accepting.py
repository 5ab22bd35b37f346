"""Accepting: what of an edit is done only if somebody says that it is meant.

A load on a sensitive place, and a depth beyond DEEPEST_MM, need a word that stands with the edit in
the recipe: `accept = ["load on fibula head"]`, `accept = ["depth to 12 mm"]`. A load's place may
be named, or be found near a landmark when the edit is done. What presses as a whole (per cent,
liners, plies, offsets, templates) is stated in the ledger, and needs no word.
"""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from limbgram.core.errors import EditError, OptionsError
from limbgram.workbench.edits.edit import Edit
from limbgram.workbench.edits.pressing import DEEPEST_MM, AtPlaces, Pressure
from limbgram.workbench.edits.regional import Load, Relieve
from limbgram.workbench.frame.sensitive import sensitive_place
from limbgram.workbench.limb import Kind

_FINDING_MM = 0.1
"""What a depth is found again to, on a surface of triangles."""
_LOAD = re.compile(r"load on (.+)")
_DEPTH = re.compile(r"depth to (\d{1,3}(?:\.\d{1,3})?) ?mm")
_FORMS = '"load on PLACE", such as "load on fibula head", or "depth to N mm"'


@dataclass(frozen=True, kw_only=True)
class Concern:
    """What somebody has to mean, or to know."""

    what: str
    word: str
    """What accepts it; empty where nothing needs to be said."""
    accepted: bool
    """Whether the recipe says the word; True where none is needed."""


def plain_words(words: Iterable[str], what: str) -> tuple[str, ...]:
    """Words of acceptance in their one form, each once.

    Raises:
        OptionsError: a word that accepts nothing.
    """
    return tuple(dict.fromkeys(_plain_word(word, what) for word in words))


def concerns_of(edit: Edit, words: Sequence[str], kind: Kind | None = None) -> Iterator[Concern]:
    """What the edit's own parameters say needs a word, before there is a limb."""
    if not isinstance(edit, Load | Relieve):
        return
    if isinstance(edit, Load) and isinstance(edit.at, str):
        place = sensitive_place(edit.at, kind)
        if place is not None:
            what = f"the load is put on the {place.name}: {place.why}"
            yield _concern(what, f"load on {place.name}", words)
    yield from _depths(edit, (0.0, 0.0), words)


def concerns_on_limb(
    edit: Edit, words: Sequence[str], found: AtPlaces, reach_mm: tuple[float, float]
) -> Iterator[Concern]:
    """What shows when the edit is done: places that it presses on, and how deep all goes there.

    reach_mm: how far inward and outward of the scan the edit leaves what it moved.
    """
    if isinstance(edit, Load):
        for one in found.pressures:
            yield _concern(_pressing(one), f"load on {one.place}", words)
    elif found.pressures:
        each = ", ".join(f"{one.place} {one.depth_mm:.1f} mm" for one in found.pressures)
        yield Concern(what=f"presses on {each}", word="", accepted=True)
    if isinstance(edit, Load | Relieve):
        yield from _depths(edit, reach_mm, words)


def require_accepted(concerns: Iterable[Concern], which: str, how: str) -> None:
    """Refuse what needs a word that nobody has said.

    Raises:
        EditError: says the words.
    """
    missing = [one for one in concerns if not one.accepted]
    if not missing:
        return
    said = " ".join(f'"{word}"' for word in dict.fromkeys(one.word for one in missing))
    raise EditError(
        f"{which}: {'; '.join(dict.fromkeys(one.what for one in missing))}. A load carves the "
        "positive in, so that what is made over it presses there; for room use relieve. If it is "
        f"meant, say so: {how} {said}."
    )


def _pressing(one: Pressure) -> str:
    return f"presses {one.depth_mm:.1f} mm on the {one.place}: {one.why}"


def _depths(
    edit: Load | Relieve, reach_mm: tuple[float, float], words: Sequence[str]
) -> Iterator[Concern]:
    """The depth that was asked for, or what all edits together come to there, if unusual."""
    together, where = (
        (reach_mm[0], "inside") if isinstance(edit, Load) else (reach_mm[1], "outside")
    )
    depth = round(max(together, edit.depth_mm), 1)
    if depth <= DEEPEST_MM:
        return
    what = f"the depth is {edit.depth_mm:g} mm"
    if together > edit.depth_mm + _FINDING_MM:
        what = f"with the edits before it the surface lies {depth:.1f} mm {where} the scan"
    limits = [float(found[1]) for word in words if (found := _DEPTH.fullmatch(word))]
    yield Concern(
        what=f"{what}, and more than {DEEPEST_MM:g} mm is unusual",
        word=f"depth to {math.ceil(depth)} mm",
        accepted=max(limits, default=0.0) >= depth,
    )


def _concern(what: str, word: str, words: Sequence[str]) -> Concern:
    return Concern(what=what, word=word, accepted=word in words)


def _plain_word(word: str, what: str) -> str:
    plain = " ".join(word.casefold().split())
    depth = _DEPTH.fullmatch(plain)
    if depth is not None:
        return f"depth to {float(depth[1]):g} mm"
    load = _LOAD.fullmatch(plain)
    place = None if load is None else sensitive_place(load[1].removeprefix("the "), None)
    if place is None:
        raise OptionsError(f"{what}: {word!r} accepts nothing. Say {_FORMS}.")
    return f"load on {place.name}"
