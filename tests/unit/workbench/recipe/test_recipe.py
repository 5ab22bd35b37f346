"""Recipes: read, changed, compared; what is not known is an error that lists what is."""

import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
from tests.unit.file_sizes import require_takes_up_to

from limbgram.core.errors import EditError, OptionsError, ShapeFileError
from limbgram.core.request_fields import Declared, declared
from limbgram.findings import LANGUAGES, Finding, doubt, told
from limbgram.findings.tell import terms
from limbgram.workbench.edits.edit import Edit, name_of, words_in
from limbgram.workbench.edits.editing import EDIT_NAMED, EDITS, require_valid
from limbgram.workbench.edits.load import Load
from limbgram.workbench.edits.offset import Offset
from limbgram.workbench.edits.relieve import Relieve
from limbgram.workbench.edits.smoothing import Smoothing
from limbgram.workbench.recipe.file import encode_recipe, make_edit, parse_recipe, read_recipe
from limbgram.workbench.recipe.recipe import (
    Entry,
    Recipe,
    added,
    described_entry,
    differences,
    moved,
    removed,
    require_scan,
    switched,
    undone,
)

TEXT = """
format = "limbgram recipe"
version = 2
name = "first fitting"

[[edit]]
do = "load"
at = "patellar tendon"
depth_mm = 5
falloff_mm = 18.0

[[edit]]
do = "smoothing"
on = false
passes = 8
leave = ["fibula head", [1, 2.5, 3]]
"""
FIRST = Entry(edit=Load(at="patellar tendon", depth_mm=5.0, falloff_mm=18.0))
SECOND = Entry(
    edit=Smoothing(passes=8, leave=("fibula head", (1.0, 2.5, 3.0))),
    on=False,
)
RECIPE = Recipe(name="first fitting", entries=(FIRST, SECOND))


def test_a_written_recipe_is_read_as_meant() -> None:
    assert parse_recipe(TEXT, "a.toml") == RECIPE
    assert parse_recipe(encode_recipe(RECIPE).decode(), "b.toml") == RECIPE


@pytest.mark.parametrize("kind", EDITS, ids=name_of)
def test_a_recipe_stands_by_itself_whatever_its_parameters(kind: type[Edit]) -> None:
    """Defaults are written too: a later version may have others."""
    made = make_edit(name_of(kind), kind.about.example, "the test")
    recipe = Recipe(name="x", entries=(Entry(edit=made),))
    text = encode_recipe(recipe).decode()
    assert parse_recipe(text, "a.toml") == recipe
    (written,) = tomllib.loads(text)["edit"]
    given = {name for name, value in asdict(made).items() if value is not None}
    assert set(written) == given | {"do"}


@pytest.mark.parametrize("kind", EDITS, ids=name_of)
def test_every_edit_says_what_it_does_and_what_its_parameters_mean(kind: type[Edit]) -> None:
    assert kind.title.startswith("The ")
    names = {one.name for one in declared(kind)}
    choices = {choice for one in declared(kind) for choice in one.choices}
    english = words_in(kind, "en")
    for language in LANGUAGES:
        words = words_in(kind, language)
        own = vars(kind)["words"][language]
        assert own.name
        assert own.title
        assert words.does.endswith(".")
        assert set(words.labels) == set(words.help) == names
        assert all(text.endswith(".") for text in words.help.values())
        assert all(words.labels.values())
        assert set(words.choices) <= choices
        if language != "en":
            assert words.does != english.does
            alike = {name for name in names if words.help[name] == english.help[name]}
            assert not alike, "their help is English"
    assert set(kind.about.rarely) <= names
    assert {one.name for one in declared(kind) if one.required} <= set(kind.about.example)


def test_refusals_call_every_edit_in_every_language() -> None:
    for kind in EDITS:
        assert terms("de")[kind.title] == words_in(kind, "de").title


@pytest.mark.parametrize("kind", EDITS, ids=name_of)
def test_every_edit_is_a_file_of_its_own(kind: type[Edit]) -> None:
    files = Counter(one.__module__ for one in EDITS)
    assert files[kind.__module__] == 1
    assert kind.__module__.rpartition(".")[2] == name_of(kind).replace("-", "_")


def ranges() -> Iterator[tuple[type[Edit], Declared]]:
    for kind in EDITS:
        for one in declared(kind):
            if one.within is not None:
                yield kind, one


@pytest.mark.parametrize(
    ("kind", "one"), list(ranges()), ids=lambda each: getattr(each, "name", None) or name_of(each)
)
def test_both_ends_of_every_range_are_taken_as_it_says_and_nothing_beyond(
    kind: type[Edit], one: Declared
) -> None:
    assert one.within is not None
    low, high = one.within.least, one.within.most

    def refused(number: float) -> Finding | None:
        given: Any = [number] * 2 if one.several else number
        values = {**kind.about.example, one.name: int(given) if one.hint is int else given}
        try:
            require_valid(make_edit(name_of(kind), values, "the test"))
        except EditError as error:
            return error.finding
        return None

    beyond = [low - 1, high + 1, *([low] if one.within.above else [])]
    for number in beyond:
        found = refused(number)
        assert found is not None
        assert found.values["name"] == one.name
        assert found.code == "edit.out_of_range"
        for language in LANGUAGES:
            assert words_in(kind, language).help[one.name] in told(found, language)
    for number in [high, *([] if one.within.above else [low])]:
        found = refused(number)
        assert found is None or found.code != "edit.out_of_range"


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('do = "load"', 'do = "loda"', "relieve, load, "),
        ("depth_mm = 5", "deph_mm = 5", "depth_mm, falloff_mm"),
        ("depth_mm = 5", "", "needs depth_mm"),
        ("depth_mm = 5", 'depth_mm = "5"', "a number"),
        ("depth_mm = 5", "depth_mm = nan", "a number"),
        ("depth_mm = 5", "depth_mm = true", "a number"),
        ("passes = 8", "passes = 8.5", "a whole number"),
        ("on = false", 'on = "no"', "true or false"),
        ("[1, 2.5, 3]", "[1, 2.5]", "3 numbers"),
        ("[1, 2.5, 3]", "7", "landmark's name"),
        ('name = "first fitting"', 'title = "x"', "allowed are"),
    ],
)
def test_what_is_not_known_is_told(old: str, new: str, reason: str) -> None:
    with pytest.raises(OptionsError, match=reason):
        parse_recipe(TEXT.replace(old, new), "a.toml")


@pytest.mark.parametrize("text", ["", "format =", "format = 'x'\nversion = 2", "version = 2"])
def test_what_is_no_recipe_is_refused(text: str) -> None:
    with pytest.raises(ShapeFileError, match=r"a\.toml"):
        parse_recipe(text, "a.toml")


OLD = """
format = "limbgram recipe"
version = 1
name = "of last year"

[[edit]]
do = "relief"
at = "patellar tendon"
depth_mm = 5.0
falloff_mm = 18.0

[[edit]]
do = "build-up"
at = "tibia end"
depth_mm = 3.0
falloff_mm = 16.0

[[edit]]
do = "relief"
on = false
at = [1.0, 2.0, 3.0]
depth_mm = 2.0
falloff_mm = 10.0
"""


def test_an_old_recipe_is_read_as_it_was_meant_and_written_in_words_that_say_so() -> None:
    """What version 1 called a relief carved the positive in; its build-up built it up."""
    read = parse_recipe(OLD, "old.toml")
    first, second, third = (entry.edit for entry in read.entries)
    assert first == Load(at="patellar tendon", depth_mm=5.0, falloff_mm=18.0)
    assert second == Relieve(at="tibia end", depth_mm=3.0, falloff_mm=16.0)
    assert isinstance(third, Load)
    assert [entry.on for entry in read.entries] == [True, True, False]
    (note,) = read.notes
    assert note == doubt("recipe.relief_was_load", count=2, numbers=(1, 3))
    text = encode_recipe(read).decode()
    assert "version = 2" in text
    assert "relief" not in text
    again = parse_recipe(text, "new.toml")
    assert again == read
    assert again.notes == ()


def test_relief_is_refused_where_nobody_can_know_what_was_meant() -> None:
    with pytest.raises(OptionsError, match=r"relieve for room, or load for pressure"):
        parse_recipe(OLD.replace("version = 1", "version = 2"), "a.toml")
    with pytest.raises(OptionsError, match=r"relieve for room, or load for pressure"):
        make_edit("relief", {"at": "fibula head", "depth_mm": 5.0, "falloff_mm": 9.0}, "the test")


def test_a_build_up_is_another_word_for_relieve() -> None:
    values: dict[str, object] = {"at": "fibula head", "depth_mm": 3.0, "falloff_mm": 18.0}
    assert make_edit("build-up", values, "a") == make_edit("relieve", values, "a")


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(ShapeFileError, match="cannot be read"):
        read_recipe(tmp_path / "none.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ShapeFileError, match="UTF-8"):
        read_recipe(tmp_path / "binary.toml")


def test_changes_leave_the_old_recipe_and_do_what_they_say() -> None:
    more = added(RECIPE, Offset(distance_mm=-0.3))
    third = more.entries[2]
    assert more.entries == (FIRST, SECOND, third)
    assert moved(more, 3, 1).entries == (third, FIRST, SECOND)
    assert moved(more, 1, 3).entries == (SECOND, third, FIRST)
    assert removed(more, 2).entries == (FIRST, third)
    assert undone(more) == RECIPE
    assert undone(more, 3).entries == ()
    assert switched(RECIPE, 2, on=True).entries[1].on
    assert added(RECIPE, Offset(distance_mm=1.0), 1).entries[1:] == RECIPE.entries
    assert RECIPE.entries == (FIRST, SECOND)
    for wrong in (0, 3):
        with pytest.raises(OptionsError, match="1 to 2"):
            switched(RECIPE, wrong, on=True)
    with pytest.raises(OptionsError, match="cannot be undone"):
        undone(RECIPE, 3)


@pytest.mark.parametrize(
    ("kind", "values", "reason"),
    [
        (
            "load",
            {"at": "a", "depth_mm": -5.0, "falloff_mm": 18.0},
            r"depth_mm\) goes above 0",
        ),
        ("relieve", {"depth_mm": 5.0, "falloff_mm": 18.0}, "either a place"),
        ("reduction", {"heights_mm": [1.0], "per_cent": [2.0, 3.0], "of": "girth"}, "one for each"),
        ("increase", {"heights_mm": [9.0, 1.0], "per_cent": [2.0, 3.0], "of": "girth"}, "rising"),
        ("sock", {"thickness_mm": 40.0}, r"thickness_mm\) goes above 0 and up to 20 mm, not 40"),
        ("sock-ply", {"plies": 99.0}, r"plies\) goes from -20 to 20, not 99"),
        ("smoothing", {"passes": 0}, r"passes\) goes from 1 to 500, not 0"),
        ("extension", {"length_mm": -1.0}, r"length_mm\) goes above 0"),
        ("flare", {"depth_mm": 0.0, "height_mm": 5.0}, r"depth_mm\) goes above 0"),
    ],
)
def test_what_makes_sense_on_no_limb_is_not_added(
    kind: str, values: dict[str, object], reason: str
) -> None:
    with pytest.raises(OptionsError, match=rf"Not added: .*{reason}"):
        added(RECIPE, make_edit(kind, values, "the test"))


def test_differences_say_what_changed_and_nothing_else() -> None:
    assert differences(RECIPE, RECIPE) == ()
    deeper = make_edit(
        "load", {"at": "patellar tendon", "depth_mm": 6, "falloff_mm": 18}, "the test"
    )
    changed = Recipe(name="first fitting", entries=(Entry(edit=deeper), SECOND))
    assert differences(RECIPE, changed) == ("~ 1. load: depth_mm 5 -> 6",)
    assert differences(RECIPE, switched(RECIPE, 2, on=True)) == ("~ 2. smoothing: switched on",)
    (line,) = differences(RECIPE, added(RECIPE, Offset(distance_mm=-0.3)))
    assert line == "+ 3. offset: distance_mm = -0.3"
    (line,) = differences(RECIPE, removed(RECIPE, 1))
    assert line.startswith("- 1. load")


def test_a_recipe_for_another_scan_is_refused() -> None:
    made = Recipe(name="x", scan_sha256="a" * 64)
    require_scan(made, "a" * 64, "scan.ply")
    require_scan(Recipe(name="x"), "b" * 64, "scan.ply")
    with pytest.raises(OptionsError, match="another file"):
        require_scan(made, "b" * 64, "scan.ply")


def test_every_kind_of_edit_has_a_name_for_people() -> None:
    named = {"relieve", "load", "plane-cut", "sock", "sock-ply", "mirror", "clean"}
    assert named <= set(EDIT_NAMED)
    assert len(EDITS) == len(EDIT_NAMED) >= 18


def test_an_edit_that_is_all_default_says_what_it_does() -> None:
    made = make_edit("sock", {}, "The new edit")
    assert described_entry(Entry(edit=made)) == "sock: thickness_mm = 0.3"


def test_a_recipe_holds_a_thousand_edits_and_no_more() -> None:
    one = '[[edit]]\ndo = "offset"\ndistance_mm = 1.0\n'
    head = 'format = "limbgram recipe"\nversion = 2\n'
    assert len(parse_recipe(head + 1000 * one, "long").entries) == 1000
    with pytest.raises(OptionsError) as refused:
        parse_recipe(head + 1001 * one, "long")
    assert refused.value.finding.code == "recipe.file.edits"
    assert refused.value.finding.values["most"] == 1000


def test_a_file_is_read_up_to_4_mb(tmp_path: Path) -> None:
    require_takes_up_to(read_recipe, tmp_path / "recipe.toml", 4_000_000)


def test_a_recipe_has_a_thousand_edits_at_most() -> None:
    head = 'format = "limbgram recipe"\nversion = 2\n'
    one = '[[edit]]\ndo = "offset"\ndistance_mm = 1.0\n'
    assert len(parse_recipe(head + 1000 * one, "long.toml").entries) == 1000
    with pytest.raises(OptionsError) as refused:
        parse_recipe(head + 1001 * one, "long.toml")
    assert refused.value.finding.code == "recipe.file.edits"
