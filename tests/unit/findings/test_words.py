"""Every code that the source says has its words in both languages, and values for them."""

import ast
import json
import re
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import limbgram
from limbgram.findings import LANGUAGES, Finding, tell
from limbgram.findings.tell import Words, all_words, placeholders

SOURCE = Path(limbgram.__file__).parent
CODE = re.compile(r"[a-z][a-z0-9_]*(\.[a-z0-9_]+)+")
SHARED: dict[str, Any] = json.loads(
    (Path(__file__).parents[2] / "data/words.json").read_text(encoding="utf-8")
)
MAKERS = re.compile(
    r"[A-Z]\w*(Error|Died|Refused|Cancelled)|Cancelled|note|doubt|fault|Finding|judge|says|missing"
)
"""What is called with a code first and values behind it."""
ABOUT = {"EditError": frozenset({"what", "labels"})}
"""What the runner of an edit or a device adds: see core.errors.refusals_about and its tests, and
devices.making."""


class Call(NamedTuple):
    """A code that is said, with the names of its values: None where they are handed on."""

    code: str
    names: frozenset[str] | None
    where: str


class Said(NamedTuple):
    """What the source says."""

    calls: list[Call]
    literals: set[str]
    """Every text that looks like a code."""


@cache
def said() -> Said:
    """The source is parsed once: that takes longer than all that is asked of it."""
    found = Said([], set())
    for file in sorted(SOURCE.rglob("*.py")):
        text = file.read_text(encoding="utf-8")
        if re.search(rf"[\"']{CODE.pattern}[\"']", text) is None:
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Call):
                found.calls.extend(calls_of(node, file))
            elif isinstance(node, ast.Constant):
                found.literals.update(codes_of(node))
    return found


def calls_of(node: ast.Call, file: Path) -> Iterator[Call]:
    maker = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    if not node.args or not MAKERS.fullmatch(maker):
        return
    handed_on = any(keyword.arg is None for keyword in node.keywords)
    given = frozenset(keyword.arg for keyword in node.keywords if keyword.arg)
    names = None if handed_on else given | ABOUT.get(maker, frozenset())
    for code in codes_of(node.args[0]):
        yield Call(code, names, f"{file.name}:{node.lineno}")


def codes_of(node: ast.expr) -> Iterator[str]:
    """A code, or the two of a conditional expression."""
    if (
        isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and CODE.fullmatch(node.value)
    ):
        yield node.value
    elif isinstance(node, ast.IfExp):
        yield from codes_of(node.body)
        yield from codes_of(node.orelse)


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_code_has_words_whose_values_are_given(language: str) -> None:
    words = all_words(language)
    faults: list[str] = []
    for code, names, where in said().calls:
        if code not in words:
            faults.append(f"{where}: {code} has no words")
            continue
        asked = asked_by(words[code])
        if names is not None and not asked <= names:
            faults.append(f"{where}: {code} lacks {', '.join(sorted(asked - names))}")
    assert not faults, "\n".join(faults)


def asked_by(words: Words) -> set[str]:
    templates = (words.sentence, words.do, words.app or "", words.short)
    return set[str]().union(*map(placeholders, templates))


def test_both_languages_tell_the_same_values_of_the_same_codes() -> None:
    english, *others = (all_words(language) for language in LANGUAGES)
    for other in others:
        assert set(other) == set(english)
        differing = [
            code
            for code, words in english.items()
            if placeholders(other[code].sentence) != placeholders(words.sentence)
            or placeholders(other[code].short) != placeholders(words.short)
            or bool(other[code].short) != bool(words.short)
            or bool(other[code].do) != bool(words.do)
            or (other[code].app is None) != (words.app is None)
        ]
        assert not differing


def test_both_languages_tell_a_number_by_as_many_decimals() -> None:
    """What a number stands in may be said otherwise: only how it is written has to agree."""
    number = re.compile(r"\{(\w+):([+±]?,?(?:\.\d+)?[fg%])\}")
    english, *others = (all_words(language) for language in LANGUAGES)
    for other in others:
        differing = [
            code
            for code, words in english.items()
            if set(number.findall(words.sentence)) != set(number.findall(other[code].sentence))
        ]
        assert not differing


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_plus_minus_says_what_it_holds(language: str) -> None:
    """Wherever a sentence with an interval is shown, it may be the only one."""
    interval = re.compile(r"± ?\{|:±")
    bare = [
        code
        for code, words in all_words(language).items()
        if interval.search(words.sentence) and "95" not in words.sentence
    ]
    assert not bare


def test_german_calls_a_thing_by_one_word() -> None:
    """Das Gliedmaß, as the app has it; its file, the scale board, the certificate of a kit."""
    other = re.compile(
        r"\b([Ee]iner?|[Dd]ie|[Dd]er) (unveränderten )?Gliedmaße\b|Gliedmaß-|Limb-|Maßstabsbrett"
    )
    words = all_words("de")
    texts = {code: f"{one.sentence} {one.do} {one.app} {one.short}" for code, one in words.items()}
    assert not [code for code, text in texts.items() if other.search(text)]
    kit = [code for code in texts if code.startswith(("kit.", "case.certificate."))]
    assert not [code for code in kit if "Zertifikat" in texts[code]]


def test_names_that_the_program_gives_are_told_in_german() -> None:
    board = Finding("verdict.scale.off", values={"label": "board, other diagonal"})
    assert "„Brett, andere Diagonale“" in tell.sentence(board, "de")
    for code, name in (
        ("verdict.no_camera_file.cost_unknown", "guess"),
        ("verdict.lens.contradicted", "camera"),
        ("limit.lens.pattern", "camera"),
    ):
        value = ("camera 1",) if name == "guess" else "camera 1"
        said = tell.sentence(Finding(code, values={name: value}), "de")
        assert "Kamera 1" in said
        assert "camera" not in said


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_is_found_stands_in_one_sentence_by_itself(language: str) -> None:
    """A title takes `says` whole; what stands in braces may hold sentences of its own."""
    inner = re.compile(r"\{[^{}]*\}")
    longer: list[str] = []
    for code, words in all_words(language).items():
        plain = words.says
        while inner.search(plain):
            plain = inner.sub("x", plain)
        if re.search(r"[.!?] ", plain) and code != "verdict.headline":
            longer.append(f"{code}: {plain}")
    assert not longer


def test_no_words_are_left_that_nothing_says() -> None:
    assert sorted(set(all_words("en")) - said().literals) == []


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_app_names_no_commands(language: str) -> None:
    naming = re.compile(r"`|(?<![\w-])--?[a-z]")
    seen = {
        code: words
        for code, words in all_words(language).items()
        if naming.search(words.advice("app"))
    }
    assert not seen


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_step_that_advice_names_is_one_of_the_app(language: str) -> None:
    """What the workbench does to a shape is an edit there, and a step is a page of a case."""
    texts = (Path(__file__).parents[3] / "web" / "src" / "texts.ts").read_text(encoding="utf-8")
    pairs = re.findall(r'"step\.\w+": \["(\w+)", "(\w+)"\]', texts)
    steps = {name for both in pairs for name in both}
    named = re.compile(r"\b(?:step|Schritt) ([A-ZÄÖÜ`]\w+)")
    found = {
        (code, name)
        for code, words in all_words(language).items()
        for door in ("command", "app")
        for name in named.findall(f"{words.sentence} {words.advice(door)}")
        if name not in steps
    }
    assert "Align" in steps
    assert not found


def test_topics_are_told_apart_by_their_files() -> None:
    of_topics: dict[str, set[str]] = defaultdict(set)
    for language in LANGUAGES:
        for code in all_words(language):
            of_topics[code.partition(".")[0]].add(language)
    assert all(found == set(LANGUAGES) for found in of_topics.values())


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("case", SHARED["cases"], ids=lambda case: case["template"])
def test_templates_are_filled(
    case: dict[str, Any], language: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    values = Finding.from_tree({"code": "a.b", "gravity": "note", "values": case["values"]}).values
    monkeypatch.setattr(tell, "terms", lambda spoken: SHARED["terms"][spoken])
    assert tell.filled(case["template"], values, language) == case[language]


def test_a_finding_survives_json() -> None:
    reason = Finding("said.as_is", values={"message": "torn"})
    finding = Finding("edit.x", values={"k": (1, 2.5, None, True), "why": reason})
    assert Finding.from_tree(json.loads(json.dumps(finding.tree()))) == finding


def test_a_finding_is_printed_as_it_is_told() -> None:
    assert str(Finding("said.as_is", values={"message": "It is torn."})) == "It is torn."


def test_what_is_no_finding_is_refused() -> None:
    for tree in ({}, {"code": "a.b"}, {"code": "a.b", "gravity": "mild", "values": {}}, "a.b"):
        with pytest.raises(ValueError):
            Finding.from_tree(tree)


def test_a_doubtful_verdict_is_told_in_one_line_by_its_first_doubt() -> None:
    verdict = Finding(
        "verdict.doubtful", values={"first": Finding("verdict.gap.wide", values={"gap_deg": 50.0})}
    )
    assert tell.in_short(verdict) == "No photo looks from 50 degrees in a row"
    assert tell.in_short(verdict, "de") == "Über 50 Grad am Stück schaut kein Foto"
    no_short = Finding("verdict.scale.unchecked")
    assert tell.in_short(no_short) == tell.sentence(no_short)
