"""Names: what clinicians call a place in each language, and which place a name means.

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
    """Places, kinds of limb, joints and figures of the sheet."""
    kinds = KIND_NAMED.values()
    named = {f"kind {one.name}": one.words[language] for one in kinds}
    if language == LANGUAGES[0]:
        return named
    joints = [one for kind in kinds for one in kind.joints]
    return {
        **named,
        **{name: place.de[0] for name, place in _PLACES.items()},
        **{one.en: one.words[language] for kind in kinds for one in kind.sheet},
        **{one.name: one.de for one in joints},
        **{one.turn: f"Stellen: {one.de}" for one in joints},
    }


add_terms(_terms)

_SPELT = str.maketrans(
    {"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss"}
)
_WORD = re.compile(r"[a-z0-9]+")


def words_of(name: str) -> tuple[str, ...]:
    """A name's words in the one spelling in which names are compared."""
    return tuple(_WORD.findall(without_accents(name).casefold()))


def without_accents(name: str) -> str:
    """A name for where only plain letters stand, still the same one here."""
    spelt = unicodedata.normalize("NFC", name).translate(_SPELT)
    parted = unicodedata.normalize("NFKD", spelt)
    return "".join(letter for letter in parted if not unicodedata.combining(letter))


def _squeezed(name: str) -> str:
    return "".join(words_of(name))


_IDENTITIES: Mapping[str, str] = MappingProxyType(
    {
        _squeezed(name): identity
        for language in reversed(LANGUAGES)
        for identity, names in NAMES_IN[language].items()
        for name in names
    }
)


def known_identity(name: str) -> str | None:
    """The place that a name means, in any language; None where no kind has it."""
    return _IDENTITIES.get(_squeezed(name))


def identity_of(name: str) -> str:
    """What tells a landmark: its place, or the name itself where no kind has it."""
    return known_identity(name) or name.strip()


def told_by(name: str) -> "Told":
    """The places whose names stand in a name, such as "left fibula head" or "Fibulakopf 2".

    A name within a longer one that is known too tells nothing: a patellar tendon is no patella.
    """
    words = words_of(name)
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
    return Told(
        identities=frozenset(identity for *_, identity in whole),
        rest=tuple(word for at, word in enumerate(words) if at not in taken),
    )


@dataclass(frozen=True, kw_only=True)
class Told:
    """What a name says."""

    identities: frozenset[str]
    rest: tuple[str, ...]
    """Its words that belong to none of them."""


def names_of(identities: Iterable[str]) -> dict[str, str]:
    """All names of these places in all languages, in the one spelling, and the place of each."""
    chosen = set(identities)
    return {
        " ".join(words_of(name)): identity
        for language in reversed(LANGUAGES)
        for identity, names in NAMES_IN[language].items()
        if identity in chosen
        for name in names
    }


def by_identity(marks: Iterable[Landmark]) -> dict[str, Landmark]:
    """Landmarks by what they are; several of one place go by their own names."""
    given = tuple(marks)
    count = Counter(identity_of(mark.name) for mark in given)
    return {
        mark.name if count[identity_of(mark.name)] > 1 else identity_of(mark.name): mark
        for mark in given
    }


def alike(names: Iterable[str], others: Iterable[str]) -> dict[str, str]:
    """Which of other names each name means: itself first; of the rest, the one of its place.

    Where several of the rest are of one place, nothing tells which is meant, and none is.
    """
    given, known = list(dict.fromkeys(names)), list(dict.fromkeys(others))
    found = {name: name for name in given if name in set(known)}
    rest = _by_place(name for name in given if name not in found)
    free = _by_place(name for name in known if name not in found)
    for place, ours in rest.items():
        theirs = free.get(place, [])
        if len(ours) == len(theirs) == 1:
            found[ours[0]] = theirs[0]
    return found


def paired(
    marks: Iterable[Landmark], others: Iterable[Landmark]
) -> tuple[tuple[Landmark, Landmark], ...]:
    """Landmarks of two shapes that mark the same, in the order of the first."""
    ours, theirs = ({mark.name: mark for mark in given} for given in (marks, others))
    found = alike(ours, theirs)
    return tuple((mark, theirs[found[name]]) for name, mark in ours.items() if name in found)


def _by_place(names: Iterable[str]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for name in names:
        found.setdefault(identity_of(name), []).append(name)
    return found


def named(name: str, marks: Iterable[Landmark]) -> Landmark | None:
    """The landmark of that very name, or else of that place."""
    given = tuple(marks)
    exact = next((mark for mark in given if mark.name == name), None)
    return exact or by_identity(given).get(identity_of(name))
