"""Landmark names: what clinicians call a place in each language, and which place a name means.

A landmark keeps the name that somebody typed. What it is, its identity, is the place that the table
finds for that name; by it landmarks of two shapes, a limb and a template, a recipe and a limb are
the same. The identity of a place is its first name in English, as in every file. A name that the
table lacks is its own identity.

To add a language: another member of `Language`, and a table of it in `NAMES_IN`. The first name of
a place is the one shown; the others are understood. Capitals, accents, umlauts written with e,
hyphens and spaces do not matter.
"""

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, get_args

from limbgram.workbench.limb import Landmark

Language = Literal["en", "de"]
LANGUAGES: tuple[Language, ...] = get_args(Language)

_ENGLISH: Mapping[str, tuple[str, ...]] = {
    # transtibial
    "mid patella": ("mid patella", "patella", "kneecap", "middle of the patella"),
    "patellar tendon": (
        *("patellar tendon", "patellar tendon bar", "patella tendon", "patella tendon bar"),
        *("patellar ligament", "mpt", "mid patellar tendon", "ptb"),
    ),
    "medial tibial condyle": ("medial tibial condyle", "medial tibial plateau"),
    "medial tibial flare": ("medial tibial flare", "medial flare"),
    "lateral tibial condyle": ("lateral tibial condyle", "lateral tibial plateau"),
    "popliteal crease": ("popliteal crease", "popliteal area", "popliteal fossa", "popliteal"),
    "tibial tubercle": ("tibial tubercle", "tibial tuberosity", "tuberosity of the tibia"),
    "fibula head": (
        *("fibula head", "fibular head", "head of fibula", "head of the fibula"),
        *("fib", "fib head", "apex of the fibula"),
    ),
    "fibula neck": ("fibula neck", "fibular neck", "neck of the fibula"),
    "peroneal nerve": ("peroneal nerve", "common peroneal nerve", "common fibular nerve"),
    "tibial crest": (*("tibial crest", "crest of the tibia", "shin", "tib", "anterior tibia"),),
    "fibula end": ("fibula end", "distal fibula", "end of fibula", "end of the fibula"),
    "tibia end": ("tibia end", "te", "distal tibia", "end of tibia", "end of the tibia"),
    "distal end": ("distal end", "end of the stump", "end of the limb"),
    "hamstring tendon": ("hamstring tendon", "hamstrings", "hamstring"),
    "medial hamstring tendon": ("medial hamstring tendon", "medial hamstrings"),
    "lateral hamstring tendon": (
        *("lateral hamstring tendon", "lateral hamstrings", "biceps femoris tendon"),
    ),
    "femoral condyle": ("femoral condyle", "condyle of the femur"),
    "medial femoral condyle": ("medial femoral condyle",),
    "lateral femoral condyle": ("lateral femoral condyle",),
    "medial femoral epicondyle": ("medial femoral epicondyle", "medial epicondyle of the femur"),
    "lateral femoral epicondyle": (
        *("lateral femoral epicondyle", "lateral epicondyle of the femur"),
    ),
    "adductor tubercle": ("adductor tubercle",),
    "anterior compartment": (
        *("anterior compartment", "pretibial muscles", "anterior tibial muscle"),
        *("tibialis anterior", "lateral tibial flare"),
    ),
    "calf": ("calf", "gastrocnemius", "calf muscle"),
    # transfemoral
    "anterior superior iliac spine": (*("anterior superior iliac spine", "asis", "iliac spine"),),
    "iliac crest": ("iliac crest",),
    "greater trochanter": ("greater trochanter", "trochanter", "trochanter major"),
    "ischial tuberosity": ("ischial tuberosity", "ischium", "sit bone"),
    "adductor longus tendon": ("adductor longus tendon", "adductor tendon", "adductor longus"),
    "perineum": ("perineum", "crotch"),
    "pubic ramus": ("pubic ramus", "pubis", "ischiopubic ramus"),
    "femur end": ("femur end", "distal femur", "end of femur", "end of the femur"),
    "gluteal fold": ("gluteal fold", "gluteal crease"),
    # foot
    "medial malleolus": ("medial malleolus", "inner ankle"),
    "lateral malleolus": ("lateral malleolus", "outer ankle"),
    "navicular": ("navicular", "navicular tuberosity", "tuberosity of the navicular"),
    "heel": ("heel",),
    "first metatarsal head": ("first metatarsal head", "mt1 head", "1st metatarsal head"),
    "fifth metatarsal head": ("fifth metatarsal head", "mt5 head", "5th metatarsal head"),
    "fifth metatarsal base": (
        *("fifth metatarsal base", "base of the fifth metatarsal", "mt5 base"),
        *("5th metatarsal base", "styloid process"),
    ),
    "achilles tendon": ("achilles tendon", "calcaneal tendon"),
    "second toe": ("second toe", "tip of the second toe"),
    # torso
    "seventh cervical vertebra": ("seventh cervical vertebra", "c7", "vertebra prominens"),
    "sternal notch": ("sternal notch", "suprasternal notch", "jugular notch"),
    "axilla": ("axilla", "armpit"),
    "right axilla": ("right axilla", "right armpit"),
    "left axilla": ("left axilla", "left armpit"),
    "xiphoid": ("xiphoid", "xiphoid process"),
    "navel": ("navel", "umbilicus", "belly button"),
    "right iliac spine": ("right iliac spine", "right asis"),
    "left iliac spine": ("left iliac spine", "left asis"),
    "sacrum": ("sacrum",),
    "right trochanter": ("right trochanter", "right greater trochanter"),
    "left trochanter": ("left trochanter", "left greater trochanter"),
    "pubic symphysis": ("pubic symphysis", "symphysis"),
}
_GERMAN: Mapping[str, tuple[str, ...]] = {
    # transtibial
    "mid patella": (
        *("Mitte der Kniescheibe", "Kniescheibe", "Kniescheibenmitte", "Patellamitte"),
        *("Patella Mitte", "Mitte Patella"),
    ),
    "patellar tendon": ("Patellasehne", "Kniescheibensehne", "Kniescheibenband", "Patellaband"),
    "medial tibial condyle": (
        *("innerer Schienbeinkopf", "medialer Tibiakondylus", "Condylus medialis tibiae"),
        *("mediales Tibiaplateau", "medialer Schienbeinkopf"),
    ),
    "medial tibial flare": ("innere Schienbeinfläche", "mediale Tibiafläche", "Tibiaflanke medial"),
    "lateral tibial condyle": (
        *("äußerer Schienbeinkopf", "lateraler Tibiakondylus", "Condylus lateralis tibiae"),
        *("laterales Tibiaplateau", "lateraler Schienbeinkopf"),
    ),
    "popliteal crease": ("Kniekehlenfalte", "Kniekehle", "Fossa poplitea"),
    "tibial tubercle": (
        *("Schienbeinhöcker", "Tuberositas tibiae", "Tuberositas", "Tibiahöcker"),
        *("Schienbeinrauigkeit",),
    ),
    "fibula head": (
        *("Wadenbeinköpfchen", "Fibulakopf", "Fibulaköpfchen", "Wadenbeinkopf", "Caput fibulae"),
        *("Fibulakopfspitze", "Fibulaspitze"),
    ),
    "fibula neck": ("Wadenbeinhals", "Fibulahals", "Collum fibulae"),
    "peroneal nerve": (
        *("Wadenbeinnerv", "Nervus peroneus", "Nervus fibularis", "Peroneusnerv"),
        *("Nervus peroneus communis", "Nervus fibularis communis", "N. peroneus"),
    ),
    "tibial crest": (
        *("Schienbeinkante", "Tibiakante", "Tibiavorderkante", "Crista tibiae"),
        *("Schienbeinvorderkante", "Margo anterior tibiae", "Tibiakamm"),
    ),
    "fibula end": (
        *("Wadenbeinende", "Fibulaende", "distale Fibula", "distales Fibulaende"),
        *("Fibulastumpf", "Fibulastumpfende", "Wadenbeinstumpf"),
    ),
    "tibia end": (
        *("Schienbeinende", "Tibiaende", "distale Tibia", "distales Tibiaende"),
        *("Tibiastumpf", "Tibiastumpfende", "Schienbeinstumpf"),
    ),
    "distal end": ("distales Ende", "Stumpfende", "Stumpfspitze"),
    "hamstring tendon": ("Kniesehne", "Hamstringsehne", "Kniebeugersehne", "ischiokrurale Sehne"),
    "medial hamstring tendon": (
        *("innere Kniesehne", "mediale Kniebeugersehne", "Semitendinosussehne"),
        *("mediale Hamstringsehne",),
    ),
    "lateral hamstring tendon": (
        *("äußere Kniesehne", "laterale Kniebeugersehne", "Bizepssehne", "Bicepssehne"),
        *("laterale Hamstringsehne",),
    ),
    "femoral condyle": ("Oberschenkelknorren", "Femurkondylus", "Femurkondyle"),
    "medial femoral condyle": (
        *("innerer Oberschenkelknorren", "medialer Femurkondylus", "Condylus medialis femoris"),
        *("mediale Femurkondyle",),
    ),
    "lateral femoral condyle": (
        *("äußerer Oberschenkelknorren", "lateraler Femurkondylus", "Condylus lateralis femoris"),
        *("laterale Femurkondyle",),
    ),
    "medial femoral epicondyle": (
        *("innerer Oberschenkelepikondylus", "medialer Femurepikondylus"),
        *("Epicondylus medialis femoris", "mediale Femurepikondyle"),
    ),
    "lateral femoral epicondyle": (
        *("äußerer Oberschenkelepikondylus", "lateraler Femurepikondylus"),
        *("Epicondylus lateralis femoris", "laterale Femurepikondyle"),
    ),
    "adductor tubercle": ("Adduktorenhöcker", "Tuberculum adductorium"),
    "anterior compartment": (
        *("Schienbeinmuskel", "vordere Muskelloge", "Tibialis-anterior-Loge"),
        *("Musculus tibialis anterior", "M. tibialis anterior"),
    ),
    "calf": ("Wade", "Wadenmuskel", "Gastroknemius", "Musculus gastrocnemius"),
    # transfemoral
    "anterior superior iliac spine": (
        *("vorderer oberer Darmbeinstachel", "Darmbeinstachel", "Spina iliaca anterior superior"),
        *("SIAS",),
    ),
    "iliac crest": ("Beckenkamm", "Darmbeinkamm", "Crista iliaca"),
    "greater trochanter": ("großer Rollhügel", "Rollhügel", "Trochanter major"),
    "ischial tuberosity": ("Sitzbein", "Sitzbeinhöcker", "Tuber ischiadicum", "Sitzbeinknorren"),
    "adductor longus tendon": (
        *("Sehne des langen Anziehers", "Adduktorensehne", "Adduktorenstrang"),
        *("Adductor-longus-Sehne", "Adduktor-longus-Sehne"),
    ),
    "perineum": ("Damm", "Schritt"),
    "pubic ramus": ("Schambeinast", "Schambein", "Ramus", "Ramus ossis ischii", "Sitzbeinast"),
    "femur end": (
        *("Oberschenkelknochenende", "Femurende", "distaler Femur", "distales Femurende"),
        *("Femurstumpf", "Femurstumpfende"),
    ),
    "gluteal fold": ("Gesäßfalte", "Glutealfalte"),
    # foot
    "medial malleolus": (
        *("Innenknöchel", "medialer Malleolus", "Malleolus medialis", "Knöchel innen"),
    ),
    "lateral malleolus": (
        *("Außenknöchel", "lateraler Malleolus", "Malleolus lateralis", "Knöchel außen"),
    ),
    "navicular": ("Kahnbein", "Os naviculare", "Tuberositas ossis navicularis", "Naviculare"),
    "heel": ("Ferse", "Fersenpunkt"),
    "first metatarsal head": (
        *("Großzehenballen", "Mittelfußköpfchen 1", "Metatarsalköpfchen 1", "MFK 1", "MTK 1"),
        *("erstes Mittelfußköpfchen", "Großzehengrundgelenk"),
    ),
    "fifth metatarsal head": (
        *("Kleinzehenballen", "Mittelfußköpfchen 5", "Metatarsalköpfchen 5", "MFK 5", "MTK 5"),
        *("fünftes Mittelfußköpfchen", "Kleinzehengrundgelenk"),
    ),
    "fifth metatarsal base": (
        *("Basis des fünften Mittelfußknochens", "Metatarsale-5-Basis", "Basis Metatarsale 5"),
        *("Mittelfußbasis 5",),
    ),
    "achilles tendon": ("Achillessehne",),
    "second toe": ("zweite Zehe", "Zehe 2", "D2"),
    # torso
    "seventh cervical vertebra": ("siebter Halswirbel", "7. Halswirbel", "HWK 7", "Prominens"),
    "sternal notch": ("Drosselgrube", "Jugulum", "Incisura jugularis"),
    "axilla": ("Achsel", "Achselhöhle"),
    "right axilla": ("rechte Achsel", "Achsel rechts", "rechte Achselhöhle"),
    "left axilla": ("linke Achsel", "Achsel links", "linke Achselhöhle"),
    "xiphoid": ("Schwertfortsatz", "Processus xiphoideus"),
    "navel": ("Nabel", "Bauchnabel"),
    "right iliac spine": ("rechter Darmbeinstachel", "Darmbeinstachel rechts", "SIAS rechts"),
    "left iliac spine": ("linker Darmbeinstachel", "Darmbeinstachel links", "SIAS links"),
    "sacrum": ("Kreuzbein",),
    "right trochanter": ("rechter Rollhügel", "Rollhügel rechts", "Trochanter rechts"),
    "left trochanter": ("linker Rollhügel", "Rollhügel links", "Trochanter links"),
    "pubic symphysis": ("Schambeinfuge", "Symphyse"),
}
NAMES_IN: Mapping[Language, Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {"en": _ENGLISH, "de": _GERMAN}
)
"""By language and identity. Every language has every place."""

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
    """The place that a name means, in any language; None where the table lacks it."""
    return _IDENTITIES.get(_squeezed(name))


def identity_of(name: str) -> str:
    """What tells a landmark: its place, or the name itself where the table lacks it."""
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
