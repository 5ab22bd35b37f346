"""Names: one place in every language, and nothing that may be bone or nerve passes unasked."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import OptionsError
from limbgram.findings import told
from limbgram.findings.tell import LANGUAGES, terms
from limbgram.workbench.anatomy.names import (
    NAMES_IN,
    identity_of,
    known_identity,
    landmark_named,
    without_accents,
)
from limbgram.workbench.compare.registration import by_landmarks
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.relieve import Relieve
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.frame.landmarks import NAMES, likely_meant
from limbgram.workbench.frame.sensitive import SENSITIVE, sensitive_place
from limbgram.workbench.limb import KINDS, Landmark, Limb

SENSITIVE_ONES = {
    one for kind in KINDS for place in SENSITIVE[kind] for one in (place.name, *place.also)
}
TEMPLATES = {row.identity for kind in KINDS for row in NAMES[kind]}
GERMAN = {one: names[0] for one, names in NAMES_IN["de"].items()}


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_place_has_a_name_in_every_language_and_no_name_means_two(language: str) -> None:
    table = NAMES_IN[language]  # type: ignore[index]
    assert set(table) == set(NAMES_IN["en"]) >= SENSITIVE_ONES | TEMPLATES
    for identity, names in table.items():
        assert identity == NAMES_IN["en"][identity][0]
        for name in names:
            assert known_identity(name) == identity
            assert known_identity(without_accents(name).upper()) == identity
            assert known_identity(name.replace(" ", "-")) == identity


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_findings_call_a_place_is_its_first_name(language: str) -> None:
    known = terms(language)
    for identity, names in NAMES_IN[language].items():  # type: ignore[index]
        assert known.get(identity, identity) == names[0]


def test_sensitive_places_and_their_reasons_have_german_words() -> None:
    german = terms("de")
    places = [place for kind in KINDS for place in SENSITIVE[kind]]
    asked = (sensitive_place(name, None) for name in ("scar", "whatever"))
    places += [place for place in asked if place is not None]
    assert {"marked place", "unknown place"} <= {place.name for place in places}
    assert {place.name for place in places} <= set(german)
    assert {place.why for place in places} <= set(german)


@pytest.mark.parametrize("identity", sorted(NAMES_IN["en"]))
def test_a_name_is_as_sensitive_in_every_language(identity: str) -> None:
    meant = sensitive_place(identity, None)
    assert (meant is not None) == (identity in SENSITIVE_ONES)
    for language in LANGUAGES:
        for name in NAMES_IN[language][identity]:
            assert sensitive_place(name, None) == meant
            assert sensitive_place(f"{name} (2)", None) == meant


@pytest.mark.parametrize(
    ("name", "place"),
    [
        *(("Fibulakopf", "fibula head"), ("fibulaköpfchen links", "fibula head")),
        *(("Fibulakopf rechts", "fibula head"), ("Wadenbeinkoepfchen", "fibula head")),
        *(("N. peroneus", "fibula head"), ("Fibulaköpfle", "fibula head")),
        *(("FIB (2)", "fibula head"), ("Fibulakopf2", "fibula head")),
        *(
            ("Tibiakante", "tibial crest"),
            ("Schienbein", "tibial crest"),
            ("TIB 2", "tibial crest"),
        ),
        *(("Kniescheibe", "mid patella"), ("medial tibial crest", "tibial crest")),
        *(("Narbe medial", "marked place"), ("Druckstelle", "marked place")),
        *(("Hautnerv", "marked place"), ("scar on the patellar tendon", "marked place")),
        *(("above the patellar tendon", "unknown place"), ("K7", "unknown place")),
        *(("tête du péroné", "fibula head"), ("rótula", "unknown place"), ("", "unknown place")),
    ],
)
def test_what_may_be_bone_or_nerve_is_asked_about(name: str, place: str) -> None:
    found = sensitive_place(name, "transtibial")
    assert found is not None
    assert found.name == place


@pytest.mark.parametrize(
    "name", ["Patellasehne", "patellasehne rechts", "Kniekehle", "left calf", "Wade 2", "Ferse"]
)
def test_what_is_known_to_bear_is_not(name: str) -> None:
    assert sensitive_place(name, "transtibial") is None


def in_german(limb: Limb) -> Limb:
    return replace(
        limb,
        landmarks=tuple(replace(one, name=GERMAN[one.name]) for one in limb.landmarks),
    )


def test_german_landmarks_turn_a_limb_as_english_ones_do(stump: Limb) -> None:
    options = AlignOptions(side="right", kind="transtibial")
    one, other = align(stump, options), align(in_german(stump), options)
    np.testing.assert_array_equal(
        one.frame.limb_from_mesh.matrix_3x4, other.frame.limb_from_mesh.matrix_3x4
    )
    assert [mark.name for mark in other.landmarks] == [
        GERMAN[mark.name] for mark in stump.landmarks
    ]
    assert likely_meant("Fibulakof", None) == "fibula head"


def test_a_recipe_finds_its_place_by_any_name(stump: Limb) -> None:
    framed = align(stump, AlignOptions(side="right", kind="transtibial"))
    edit = Relieve(at="fibula head", depth_mm=3, falloff_mm=15)
    wanted = do_edit(framed, edit).mesh.vertices_mm
    german = do_edit(in_german(framed), replace(edit, at="Fibulakopf")).mesh.vertices_mm
    np.testing.assert_array_equal(german, wanted)
    np.testing.assert_array_equal(do_edit(in_german(framed), edit).mesh.vertices_mm, wanted)


def test_shapes_are_laid_by_places_in_two_languages(stump: Limb) -> None:
    marks = tuple(
        Landmark(name=name, position_mm=np.array(place))
        for name, place in {
            "fibula head": (50.0, 0, 90),
            "tibial crest": (0.0, 50, 40),
            "own mark": (-50.0, 0, 60),
        }.items()
    )
    GERMAN_TOO = GERMAN | {"own mark": "own mark"}
    german = tuple(replace(one, name=GERMAN_TOO[one.name]) for one in marks)
    found = by_landmarks(
        replace(stump, landmarks=marks), replace(stump, landmarks=german), {"Fibulakopf": 2.0}
    )
    np.testing.assert_allclose(found.first_from_second.translation, 0, atol=1e-9)
    assert found.rms_mm == pytest.approx(0, abs=1e-9)


PLACES = {
    "Fibulakopf": (50.0, 0, 90),
    "fibula head": (54.0, 0, 86),
    "tibial crest": (0.0, 50, 40),
    "own mark": (-50.0, 0, 60),
    "patella": (0.0, 60, 110),
}


def marked(limb: Limb, *names: str) -> Limb:
    marks = [Landmark(name=name, position_mm=np.array(PLACES[name])) for name in names]
    return replace(limb, landmarks=tuple(marks))


def test_a_weight_is_of_the_landmark_of_that_very_name(stump: Limb) -> None:
    first = marked(stump, *PLACES)
    off = tuple(
        replace(
            one, position_mm=one.position_mm + np.array([0, 0, 30.0 * (one.name == "Fibulakopf")])
        )
        for one in first.landmarks
    )
    second = replace(stump, landmarks=off)
    found = by_landmarks(first, second, {"Fibulakopf": 0.0})
    assert found.rms_mm == pytest.approx(0, abs=1e-9)
    kept = by_landmarks(first, second, {"fibula head": 0.0})
    assert kept.rms_mm is not None
    assert kept.rms_mm > 1
    with pytest.raises(OptionsError, match="must name a landmark"):
        by_landmarks(first, second, {"Wadenbeinkopf": 0.0})


@pytest.mark.parametrize("turned", [False, True])
def test_a_landmark_is_laid_on_the_one_of_its_own_name(stump: Limb, turned: bool) -> None:
    limbs = marked(stump, *PLACES), marked(stump, "Fibulakopf", "tibial crest", "own mark")
    found = by_landmarks(*(limbs[::-1] if turned else limbs), {})
    assert found.rms_mm == pytest.approx(0, abs=1e-9)
    assert told(found.how).startswith("by 3 landmarks")


def test_an_epicondyle_is_another_place_than_its_condyle() -> None:
    for side in ("medial", "lateral"):
        assert identity_of(f"{side} epicondyle of the femur") != identity_of(
            f"{side} femoral condyle"
        )
        assert sensitive_place(f"{side} epicondyle of the femur", "transtibial") is not None


def test_two_landmarks_of_one_place_go_by_their_own_names() -> None:
    one, two = (
        Landmark(name=name, position_mm=np.zeros(3)) for name in ("Fibulakopf", "fibula head")
    )
    assert landmark_named("fibula head", (one, two)) is two
    assert landmark_named("Fibulakopf", (one, two)) is one
    assert landmark_named("Fibulaköpfchen", (one, two)) is two
    assert landmark_named("Fibulaköpfchen", (one,)) is one
    assert landmark_named("patella", (one, two)) is None
    assert identity_of(" my mark ") == "my mark"
