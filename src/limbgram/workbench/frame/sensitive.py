"""Sensitive places: landmarks over bone, nerve or tendon that bear no pressure, by kind of limb.

A place that no table knows may lie over any of them: it is asked about, like these.
The places of each kind, with their sources, stand in the files of `kinds`.
"""

from collections.abc import Mapping
from difflib import get_close_matches
from functools import lru_cache
from types import MappingProxyType

from limbgram.workbench.anatomy.kind import SensitivePlace
from limbgram.workbench.anatomy.known_kinds import KIND_NAMED
from limbgram.workbench.anatomy.names import names_of, normalised_name, parse_name
from limbgram.workbench.frame.landmarks import ALIKE
from limbgram.workbench.limb import KINDS, KindName

SENSITIVE: Mapping[KindName, tuple[SensitivePlace, ...]] = MappingProxyType(
    {name: kind.sensitive for name, kind in KIND_NAMED.items()}
)
"""By kind of limb, under the names of the kind's landmarks where it has them."""

_MARKED = SensitivePlace(
    name="marked place",
    why="it was marked as sore, scarred or a nerve on this limb",
    reach_mm=10.0,
)
"""What is sensitive on this limb alone. Its landmark's own words may hold a person's name, and are
not repeated."""
_UNKNOWN = SensitivePlace(
    name="unknown place",
    why="its name is in no table, and bone or a nerve may lie under it",
    reach_mm=10.0,
)
_MARKS = frozenset(
    {
        *("neuroma", "nerve", "spur", "exostosis", "scar", "graft", "marked"),
        *("wound", "ulcer", "blister", "sore", "pain", "painful", "tender"),
    }
)
"""Words in a landmark's name that mark such a place."""
_MARK_PARTS = (
    *("neurom", "nerv", "exostose", "knochensporn", "narbe", "transplantat"),
    *("wunde", "wund", "ulkus", "geschwuer", "blase", "schmerz", "druckstelle", "empfindlich"),
)
"""Parts of words that do, in languages that join words."""
_BONES = (
    *(("fibula", "fibula head"), ("wadenbein", "fibula head"), ("peron", "fibula head")),
    *(("patell", "mid patella"), ("kniescheib", "mid patella")),
    *(("tibia", "tibial crest"), ("schienbein", "tibial crest"), ("crista", "tibial crest")),
    *(("malleol", "lateral malleolus"), ("knoechel", "lateral malleolus")),
    *(("trochanter", "greater trochanter"), ("rollhuegel", "greater trochanter")),
    *(("condyl", "femoral condyle"), ("kondyl", "femoral condyle")),
    *(("metatars", "fifth metatarsal head"), ("mittelfuss", "fifth metatarsal head")),
)
"""Words, and parts of words, that name a bone, and the place of it that bears least."""
_SIDES = frozenset(
    {
        *("left", "right", "l", "r", "links", "rechts", "li", "re", "the", "der", "die", "das"),
        *("linke", "linker", "linkes", "rechte", "rechter", "rechtes"),
    }
)
"""Words beside a name that leave the place what it is, as numbers do."""


@lru_cache(maxsize=1024)
def sensitive_place(name: str, kind: KindName | None) -> SensitivePlace | None:
    """The sensitive place that a landmark's name means; None where the place bears pressure.

    The name may be in any language of the table. Capitals, hyphens, a side, a number and a slip of
    the pen do not matter. What is neither known to bear nor to be sensitive is an unknown place.
    """
    by_identity = _sensitive_by_identity(kind)
    told, words = parse_name(name), normalised_name(name)
    within = [by_identity[one] for one in told.identities if one in by_identity]
    if within:
        return max(within, key=lambda place: (place.reach_mm, place.name))
    if _MARKS.intersection(words) or any(part in word for word in words for part in _MARK_PARTS):
        return _MARKED
    if told.identities and all(word in _SIDES or word.isdigit() for word in told.rest):
        return None
    bone = next((one for word, one in _BONES if word in words), None)
    part = next((one for part, one in _BONES if any(part in word for word in told.rest)), None)
    names = names_of(by_identity)
    near = get_close_matches(" ".join(words), names, n=1, cutoff=ALIKE)
    found = bone or (names[near[0]] if near else part)
    return _UNKNOWN if found is None else by_identity[found]


def _sensitive_by_identity(kind: KindName | None) -> dict[str, SensitivePlace]:
    """The places of the kind, or else of any kind, by the identity of each landmark on them.

    Of other kinds the place that has the name itself counts before one on which it lies: what is
    asked before the kind is known is then understood by the kind that has it.
    """
    own = () if kind is None else SENSITIVE[kind]
    every = [place for one in KINDS for place in SENSITIVE[one]]
    found = {place.name: place for place in reversed(every)}
    found = {told: place for place in reversed(every) for told in place.also} | found
    return found | {told: place for place in reversed(own) for told in (place.name, *place.also)}
