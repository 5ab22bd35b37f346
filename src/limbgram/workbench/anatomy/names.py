"""Names: the names of anatomical places in each language, and which place a name means.

A landmark keeps the name that somebody typed. What it is, its identity, is the place that a kind of
limb has under that name; by it landmarks of two shapes, a limb and a template, a recipe and a limb
are the same. The identity of a place is its first name in English, as in every file. A name that no
kind has is its own identity.

The names stand in the kinds' files. The first name of a place is the one shown; the others are
understood. Capitals, accents, umlauts written with e, hyphens and spaces do not matter.
"""

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from limbgram.findings.tell import LANGUAGES, Language, add_terms
from limbgram.workbench.anatomy.known_kinds import KIND_NAMED
from limbgram.workbench.anatomy.landmark import Landmark

_PLACES = {one.identity: one for kind in KIND_NAMED.values() for one in kind.places}
NAMES_IN: Mapping[Language, Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "en": {name: (name, *place.en) for name, place in _PLACES.items()},
        "de": {name: place.de for name, place in _PLACES.items()},
    }
)
"""By language and identity. Every language has every place."""


def _terms(language: str) -> dict[str, str]:
    """Names of places, kinds, joints and sheet figures in a language, by the English ones."""
    kinds = KIND_NAMED.values()
    of_kinds = {f"kind {one.name}": one.words[language] for one in kinds}
    if language == LANGUAGES[0]:
        return of_kinds
    joints = [one for kind in kinds for one in kind.joints]
    return {
        **of_kinds,
        **{name: place.de[0] for name, place in _PLACES.items()},
        **{one.en: one.words[language] for kind in kinds for one in kind.sheet},
        **{one.name: one.de for one in joints},
        **{one.turn: f"Stellen: {one.de}" for one in joints},
    }


add_terms(_terms)

_SPELLINGS = str.maketrans(
    {"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss"}
)
_WORD = re.compile(r"[a-z0-9]+")


def normalised_name(name: str) -> tuple[str, ...]:
    """A name in the normalised spelling in which names are compared."""
    return tuple(_WORD.findall(without_accents(name).casefold()))


def without_accents(name: str) -> str:
    """A name in plain letters, which is still recognised as the same."""
    spelt = unicodedata.normalize("NFC", name).translate(_SPELLINGS)
    parted = unicodedata.normalize("NFKD", spelt)
    return "".join(letter for letter in parted if not unicodedata.combining(letter))


def _compact_name(name: str) -> str:
    return "".join(normalised_name(name))


_IDENTITIES: Mapping[str, str] = MappingProxyType(
    {
        _compact_name(name): identity
        for language in reversed(LANGUAGES)
        for identity, names in NAMES_IN[language].items()
        for name in names
    }
)


def known_identity(name: str) -> str | None:
    """The identity of the place that a name means, in any language; None if no kind has it."""
    return _IDENTITIES.get(_compact_name(name))


def identity_of(name: str) -> str:
    """The identity of a landmark: its place, or the name itself if no kind has it."""
    return known_identity(name) or name.strip()


def parse_name(name: str) -> "ParsedName":
    """The places whose names stand in a name, such as "left fibula head" or "Fibulakopf 2".

    A name within a longer one that is known too tells nothing: a patellar tendon is no patella.
    """
    words = normalised_name(name)
    spans = [
        (start, end, identity)
        for start in range(len(words))
        for end in range(start + 1, len(words) + 1)
        if (identity := _IDENTITIES.get("".join(words[start:end]))) is not None
    ]
    whole = [
        (start, end, identity)
        for start, end, identity in spans
        if not any(one <= start and end <= two and two - one > end - start for one, two, _ in spans)
    ]
    taken = {at for start, end, _ in whole for at in range(start, end)}
    return ParsedName(
        identities=frozenset(identity for *_, identity in whole),
        rest=tuple(word for at, word in enumerate(words) if at not in taken),
    )


@dataclass(frozen=True, kw_only=True)
class ParsedName:
    """The places that a name mentions, and the rest of it."""

    identities: frozenset[str]
    rest: tuple[str, ...]
    """Its words that belong to none of them."""


def names_of(identities: Iterable[str]) -> dict[str, str]:
    """All names of these places in all languages, in the one spelling, and the place of each."""
    chosen = set(identities)
    return {
        " ".join(normalised_name(name)): identity
        for language in reversed(LANGUAGES)
        for identity, names in NAMES_IN[language].items()
        if identity in chosen
        for name in names
    }


def landmarks_by_identity(marks: Iterable[Landmark]) -> dict[str, Landmark]:
    """Landmarks by identity; several of one place are kept under their own names."""
    given = tuple(marks)
    count = Counter(identity_of(mark.name) for mark in given)
    return {
        mark.name if count[identity_of(mark.name)] > 1 else identity_of(mark.name): mark
        for mark in given
    }


def match_names(names: Iterable[str], others: Iterable[str]) -> dict[str, str]:
    """The other name that matches each name: the same name, or else the only one of its place.

    Where several of the rest are of one place, none matches, because either could be meant.
    """
    given, known = list(dict.fromkeys(names)), list(dict.fromkeys(others))
    found = {name: name for name in given if name in set(known)}
    rest = _names_by_identity(name for name in given if name not in found)
    free = _names_by_identity(name for name in known if name not in found)
    for place, ours in rest.items():
        theirs = free.get(place, [])
        if len(ours) == len(theirs) == 1:
            found[ours[0]] = theirs[0]
    return found


def paired_landmarks(
    marks: Iterable[Landmark], others: Iterable[Landmark]
) -> tuple[tuple[Landmark, Landmark], ...]:
    """Pairs of landmarks of two shapes that mark the same place, in the order of the first."""
    ours, theirs = ({mark.name: mark for mark in given} for given in (marks, others))
    found = match_names(ours, theirs)
    return tuple((mark, theirs[found[name]]) for name, mark in ours.items() if name in found)


def _names_by_identity(names: Iterable[str]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for name in names:
        found.setdefault(identity_of(name), []).append(name)
    return found


def landmark_named(name: str, marks: Iterable[Landmark]) -> Landmark | None:
    """The landmark of exactly that name, or else of that place."""
    given = tuple(marks)
    exact = next((mark for mark in given if mark.name == name), None)
    return exact or landmarks_by_identity(given).get(identity_of(name))
