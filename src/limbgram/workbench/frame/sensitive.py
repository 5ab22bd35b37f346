"""Sensitive places: landmarks over bone, nerve or tendon that bear no pressure, by kind of limb.

A place that no table knows may lie over any of them: it is asked about, like these.

Sources, by what they were taken for:

transtibial    S. Kapp, D. Cummings, Atlas of Limb Prosthetics (2nd ed. 1992) ch. 18B, and the
               tradition since C. Radcliffe, J. Foort, The Patellar-Tendon-Bearing Below-Knee
               Prosthesis (1961): tibial crest and tubercle, distal tibia, fibular head, distal
               fibula and hamstring tendons bear little; the patellar tendon, the medial tibial
               flare, the popliteal area and the muscles beside the tibia bear. W. Lee, M. Zhang,
               A. Mak, Arch Phys Med Rehabil 86(4), 2005: pain is tolerated least over the fibular
               head and the distal ends, most over the patellar tendon. C. Epps, J. Hile,
               Inter-Clinic Inf Bull 3(11), 1964: before casting are marked patella, tubercle,
               fibular head and crest, bone spurs, adherent scars and neuromas. G. Nehme, S.
               Ghalambor, J Prosthet Orthot 26(4), 2014: relief areas.
peroneal nerve W. Ryan et al., Clin Anat 16(6), 2003: 32 +- 10 mm from the apex of the fibular head
               the common peroneal nerve enters its tunnel on the fibula's neck; C. Thi et al.,
               Int J Morphol Physiol 6(1), 2018: its deep branch leaves 26 mm (19 to 38) from it.
transfemoral   C. M. Schuch, Atlas of Limb Prosthetics ch. 20B; E. Neumann et al., J Prosthet Orthot
               17(1), 2005, found the peaks at ischium, adductor longus tendon and in Scarpa's
               triangle. The ischial tuberosity is no place of this list: it is meant to bear.
foot           International Committee of the Red Cross, Ankle-Foot Orthosis, manufacturing
               guidelines: malleoli, navicular and the fifth metatarsal's base are built up.
torso          EPUAP, NPIAP, PPPIA, Prevention and Treatment of Pressure Ulcers/Injuries (2019):
               bony prominences; axillae for the vessels and nerves that run through them.

A reach is how far from the landmark, straight, the place is taken to go. Those of the peroneal
nerve are from the papers; the others are the rounded half width of the bone under the skin, and
general trade knowledge.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from types import MappingProxyType

from limbgram.workbench.frame.landmark_names import names_of, told_by, words_of
from limbgram.workbench.limb import KINDS, Kind

_ALIKE = 0.8
"""Names that share so much of their letters are one, with a slip of the pen (difflib's ratio)."""


@dataclass(frozen=True, kw_only=True)
class SensitivePlace:
    """A place on which nothing should press unless somebody means it."""

    name: str
    why: str
    reach_mm: float
    also: tuple[str, ...] = ()
    """Identities of other landmarks that lie on it; its own is its name."""


def _places(*rows: tuple[str, str, float, tuple[str, ...]]) -> tuple[SensitivePlace, ...]:
    return tuple(
        SensitivePlace(name=name, why=why, reach_mm=reach, also=also)
        for name, why, reach, also in rows
    )


_FIBULA_HEAD = (
    "fibula head",
    "bone, and the common peroneal nerve winds round the fibula's neck under the skin",
    25.0,
    ("fibula neck", "peroneal nerve"),
)
_TIBIAL_CREST = ("tibial crest", "bone edge under the skin", 8.0, ())
_TIBIAL_TUBERCLE = ("tibial tubercle", "bone under the skin", 5.0, ())

SENSITIVE: Mapping[Kind, tuple[SensitivePlace, ...]] = MappingProxyType(
    {
        "transtibial": _places(
            ("mid patella", "bone under the skin", 15.0, ()),
            _TIBIAL_TUBERCLE,
            _TIBIAL_CREST,
            _FIBULA_HEAD,
            ("fibula end", "cut end of bone", 12.0, ()),
            ("tibia end", "cut end of bone", 15.0, ()),
            ("distal end", "the cut ends of bone lie under it", 15.0, ()),
            (
                "hamstring tendon",
                "tendon that rises when the knee bends",
                8.0,
                ("medial hamstring tendon", "lateral hamstring tendon"),
            ),
            (
                "femoral condyle",
                "bone under the skin",
                12.0,
                (
                    *("medial femoral condyle", "lateral femoral condyle", "adductor tubercle"),
                    *("medial femoral epicondyle", "lateral femoral epicondyle"),
                ),
            ),
        ),
        "transfemoral": _places(
            (
                "anterior superior iliac spine",
                "bone under the skin",
                12.0,
                ("right iliac spine", "left iliac spine", "iliac crest"),
            ),
            ("greater trochanter", "bone under the skin", 15.0, ()),
            ("adductor longus tendon", "tendon under the skin", 10.0, ()),
            ("perineum", "soft tissue that bears no pressure", 15.0, ()),
            ("pubic ramus", "bone under the skin", 12.0, ()),
            ("femur end", "cut end of bone", 15.0, ()),
        ),
        "foot": _places(
            _TIBIAL_TUBERCLE,
            _FIBULA_HEAD,
            _TIBIAL_CREST,
            ("medial malleolus", "bone under the skin", 12.0, ()),
            ("lateral malleolus", "bone under the skin", 12.0, ()),
            ("navicular", "bone under the skin", 10.0, ()),
            ("first metatarsal head", "bone under the skin", 10.0, ()),
            ("fifth metatarsal head", "bone under the skin", 8.0, ()),
            ("fifth metatarsal base", "bone under the skin", 8.0, ()),
            ("achilles tendon", "tendon under the skin", 8.0, ()),
        ),
        "torso": _places(
            ("seventh cervical vertebra", "bone under the skin", 10.0, ()),
            ("sternal notch", "windpipe and bone under the skin", 10.0, ()),
            ("right axilla", "vessels and nerves of the arm", 15.0, ("axilla",)),
            ("left axilla", "vessels and nerves of the arm", 15.0, ()),
            ("xiphoid", "thin bone under the skin", 10.0, ()),
            ("right iliac spine", "bone under the skin", 12.0, ("iliac crest",)),
            ("left iliac spine", "bone under the skin", 12.0, ()),
            ("sacrum", "bone under the skin", 12.0, ()),
            ("right trochanter", "bone under the skin", 15.0, ()),
            ("left trochanter", "bone under the skin", 15.0, ()),
            ("pubic symphysis", "bone under the skin", 12.0, ()),
        ),
    }
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
def sensitive_place(name: str, kind: Kind | None) -> SensitivePlace | None:
    """The sensitive place that a landmark's name means; None where the place bears pressure.

    The name may be in any language of the table. Capitals, hyphens, a side, a number and a slip of
    the pen do not matter. What is neither known to bear nor to be sensitive is an unknown place.
    """
    by_identity = _by_identity(kind)
    told, words = told_by(name), words_of(name)
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
    near = get_close_matches(" ".join(words), names, n=1, cutoff=_ALIKE)
    found = bone or (names[near[0]] if near else part)
    return _UNKNOWN if found is None else by_identity[found]


def _by_identity(kind: Kind | None) -> dict[str, SensitivePlace]:
    """The places of the kind, or else of any kind, by the identity of each landmark on them."""
    first = () if kind is None else (kind,)
    places = [place for one in (*first, *KINDS) for place in SENSITIVE[one]]
    return {told: place for place in reversed(places) for told in (place.name, *place.also)}
