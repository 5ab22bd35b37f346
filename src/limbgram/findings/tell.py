"""Telling: the sentence of a finding in a language, from the files of words.

A file `words/LANGUAGE/TOPIC.toml` has a table for each code of its topic:

    [conflict]
    says = "At {height_mm:.0f} mm the tape reads {read_mm:.1f} mm, not {measured_mm:.1f} mm."
    why = "The board or the tape is wrong."
    do = "Tape it again."

`says` is what, in one sentence, which the app shows as a title; `why` is what else there is to say
of it, and `do` what to do about it; both may lack. `app` is the advice where `do` names commands or
options, which nobody sees before the browser app. `short` is what alone, for one line of a list;
where it lacks, `says` and `why` stand there. In braces stands a value's name and, after a colon,
how it is told:

    {share:.1%}  {rms_mm:.2f}  {error_mm:+.1f}  {count:,}    a number; German has a decimal comma
    {within_mm:±.2f}                                       half an interval: ± 0.25, or ± 0.003, as
                                                           what is smaller is not nothing
    {count:photo|photos}                                   the first where it is 1
    {where:inside=im|outside=außerhalb}                    by value, `else=` for all others; a truth
                                                           value is true or false, none is none
    {names:and}  {names:or}  {names:first 4}               "a, b and c"; "a or b"; "a, b, c, d ..."
    {heights_mm:.0f}                                       each of several, with commas
    {reasons:lines}                                        each of several, below on its own line
    {place:term}                                           by the table of `LANGUAGE/terms.toml`
    {name:axis}  {kind:kind}  {name:part}                  by what stands there under "axis foot",
                                                           "kind foot", else under "foot"; the
                                                           pieces of "heel, lateral" one by one
    {names:and term}  {kinds:or kind}                      each so, joined
    {name!r}  {name:.60}  {name!r:.60}                     in quotes, cut to so many letters
    {reason}  {reason:says}  {reason:clause}               a finding: whole, without advice, without
                                                           its full stop
    {reason:short}                                         its short words

What stands behind a colon may hold braces itself: `{more:true= ({names})|false=}`. The client words
by the same rules (`web/src/words.ts`); both are held to the cases of `tests/data/words.json`.
"""

import math
import re
import string
import threading
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Literal, cast, get_args

from limbgram.findings.finding import Finding, Value

Language = Literal["en", "de"]
LANGUAGES: tuple[Language, ...] = get_args(Language)
"""The first is the default."""
Door = Literal["command", "app"]
"""Where the reader is: advice for the command line names commands, for the app it does not."""
_WORDS = files("limbgram.findings") / "words"
_JOINED_BY = {"and": {"en": "and", "de": "und"}, "or": {"en": "or", "de": "oder"}}
_CHOICE = re.compile(r"([\w ./-]*)=(.*)", re.DOTALL)
_NUMBER = re.compile(r"([+]?)(,?(?:\.\d+)?[dfg%]?)")
_HALF_WIDTH = re.compile(r"±\.(\d)f")
_FIRST = re.compile(r"first (\d+)")
_NAMED = ("term", "axis", "kind", "part")
"""Kinds of name: one word may name several things, as foot does."""
_PIECES = re.compile(r"(, |: )")
_NamesIn = Callable[[str], Mapping[str, str]]
_ADDED: list[_NamesIn] = []
_ADDING = threading.RLock()


@dataclass(frozen=True)
class Words:
    """The words of one code in one language."""

    says: str
    why: str = ""
    """Said after the first sentence, before the advice."""
    do: str = ""
    app: str | None = None
    """Advice in the app; None: the same as `do`."""
    short: str = ""
    """One line for a list; empty: `says` and `why`."""

    @property
    def sentence(self) -> str:
        """`says` and `why`."""
        return f"{self.says} {self.why}" if self.why else self.says

    def advice(self, door: Door) -> str:
        return self.do if door == "command" or self.app is None else self.app


def told(finding: Finding, language: str = LANGUAGES[0], door: Door = "command") -> str:
    """Sentence and advice of a finding."""
    parts = (sentence(finding, language, door), advice(finding, language, door))
    return " ".join(filter(None, parts))


def sentence(finding: Finding, language: str = LANGUAGES[0], door: Door = "command") -> str:
    """Sentence of a finding: what, and why."""
    words = _words_of(finding.code, language)
    if words is None:  # a code of a later version, read from a file
        values = ", ".join(f"{name} {value}" for name, value in finding.values.items())
        return f"{finding.code}: {values}." if values else f"{finding.code}."
    return filled(words.sentence, finding.values, language, door)


def advice(finding: Finding, language: str = LANGUAGES[0], door: Door = "command") -> str:
    """Advice of a finding; empty if there is nothing to do."""
    words = _words_of(finding.code, language)
    if words is None:
        return ""
    return filled(words.advice(door), finding.values, language, door)


def in_short(finding: Finding, language: str = LANGUAGES[0], door: Door = "command") -> str:
    """A finding in one line: its short words or, if it has none, its sentence."""
    words = _words_of(finding.code, language)
    if words is None or not words.short:
        return sentence(finding, language, door)
    return filled(words.short, finding.values, language, door)


def as_json(finding: Finding) -> dict[str, Any]:
    """A finding as JSON keeps it, with its English sentence and advice."""
    return {**finding.tree(), "sentence": told(finding)}


def all_words(language: str) -> dict[str, Words]:
    """The words of every code."""
    topics = (_topic(topic, language) for topic in sorted(_topics(language)))
    return {code: words for topic in topics for code, words in topic.items()}


def terms(language: str) -> Mapping[str, str]:
    """Translated names of things, such as landmarks, by their English names."""
    with _ADDING:
        known, taken = _terms(language)
        for names_in in _ADDED[len(taken) :]:
            known.update(names_in(language))
            taken.append(names_in)
    return known


def add_terms(names_in: _NamesIn) -> None:
    """Register a function that gives more names in a language, as of edits, which name themselves.

    It is called when a name is first translated, as importing all edits takes a tenth of a second.
    """
    _ADDED.append(names_in)


def filled(
    template: str,
    values: Mapping[str, Value],
    language: str = LANGUAGES[0],
    door: Door = "command",
) -> str:
    """A template filled with values."""
    return _filled(template, _Put(values, language, door))


def placeholders(template: str) -> set[str]:
    """Names of the values in a template."""
    names: set[str] = set()
    for _text, name, how, _conversion in string.Formatter().parse(template):
        if name is not None:
            names |= {name, *placeholders(how or "")}
    return names


def _named(name: str, what: str, language: str) -> str:
    """A name translated, or its pieces; itself if there is no translation."""
    known = terms(language)
    whole = known.get(f"{what} {name}", known.get(name))
    if whole is not None or not _PIECES.search(name):
        return name if whole is None else whole
    return "".join(
        one if _PIECES.fullmatch(one) else _named(one, what, language)
        for one in _PIECES.split(name)
    )


@cache
def _terms(language: str) -> tuple[dict[str, str], list[_NamesIn]]:
    """The names known so far, and the registered functions whose names are among them."""
    file = _WORDS / language / "terms.toml"
    return cast(dict[str, str], tomllib.loads(file.read_text(encoding="utf-8"))), []


def _topics(language: str) -> Iterator[str]:
    for file in (_WORDS / language).iterdir():
        if file.name.endswith(".toml") and file.name != "terms.toml":
            yield file.name.removesuffix(".toml")


def _words_of(code: str, language: str) -> Words | None:
    topic = code.partition(".")[0]
    return _topic(topic, language).get(code) or _topic(topic, LANGUAGES[0]).get(code)


@cache
def _topic(topic: str, language: str) -> Mapping[str, Words]:
    return dict(_read(topic, language))


def _read(topic: str, language: str) -> Iterator[tuple[str, Words]]:
    file = _WORDS / language / f"{topic}.toml"
    if file.is_file():
        yield from _flat(topic, tomllib.loads(file.read_text(encoding="utf-8")))


def _flat(code: str, table: dict[str, Any]) -> Iterator[tuple[str, Words]]:
    own = {name: item for name, item in table.items() if isinstance(item, str)}
    if own:
        yield code, Words(**own)
    for name, item in table.items():
        if isinstance(item, dict):
            yield from _flat(f"{code}.{name}", cast(dict[str, Any], item))


@dataclass(frozen=True)
class _Put:
    """Values for a template, its language and its door."""

    values: Mapping[str, Value]
    language: str
    door: Door


def _filled(template: str, put: _Put) -> str:
    parts: list[str] = []
    for text, name, how, conversion in string.Formatter().parse(template):
        parts.append(text)
        if name is not None:
            value = put.values.get(name)
            parts.append(
                format(repr(value), how or "") if conversion else _said(value, how or "", put)
            )
    return "".join(parts)


def _said(value: Value, how: str, put: _Put) -> str:
    if "|" in how:
        return _filled(_chosen(value, how), put)
    match value:
        case Finding():
            return _clause(value, how, put)
        case tuple():
            return _several(value, how, put)
        case None:
            return "?"
        case bool():
            return str(value).lower()
        case int() | float():
            return _number(value, how, put.language)
        case str():
            return _named(value, how, put.language) if how in _NAMED else format(value, how)


def _chosen(value: Value, how: str) -> str:
    """One of the alternatives between bars: by the key before `=`, or singular and plural."""
    alternatives = _split(how)
    keyed = [_CHOICE.fullmatch(one) for one in alternatives]
    if all(keyed):
        by_key = {found[1]: found[2] for found in keyed if found}
        key = str(value).lower() if isinstance(value, bool) or value is None else str(value)
        return by_key.get(key, by_key.get("else", ""))
    one, more = alternatives
    return one if value == 1 else more


def _split(how: str) -> list[str]:
    """Split at the bars that are not inside braces."""
    parts, depth = [""], 0
    for letter in how:
        depth += {"{": 1, "}": -1}.get(letter, 0)
        if letter == "|" and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


def _clause(reason: Finding, how: str, put: _Put) -> str:
    if not how:
        return told(reason, put.language, put.door)
    if how == "short":
        return in_short(reason, put.language, put.door)
    said = sentence(reason, put.language, put.door)
    return said.removesuffix(".") if how == "clause" else said


def _several(items: tuple[Value, ...], how: str, put: _Put) -> str:
    first = _FIRST.fullmatch(how)
    joint, _, named = how.partition(" ")
    joined = _JOINED_BY.get(joint)
    each = named if joined else "" if first or how == "lines" else how
    said = [_said(one, each, put) for one in items]
    if how == "lines":
        return "".join(f"\n  {one}" for one in said)
    if first and len(said) > int(first[1]):
        return f"{', '.join(said[: int(first[1])])} ..."
    if joined and len(said) > 1:
        return f"{', '.join(said[:-1])} {joined[put.language]} {said[-1]}"
    between = "; " if items and isinstance(items[0], Finding) else ", "
    return between.join(said)


def _number(value: float, how: str, language: str) -> str:
    half, known = _HALF_WIDTH.fullmatch(how), _NUMBER.fullmatch(how)
    if not (half or known):
        raise ValueError(f"{how!r} is no format of a number")
    if not abs(value) < float("inf"):
        return "?"
    if half:
        text = f"± {half_width_text(value, int(half[1]))}"
    elif known and how.endswith(("f", "%")):
        text = format(value, f"{known[1]}z{known[2]}")  # z: no -0.0
    else:
        text = format(value, how) if how else repr(value).removesuffix(".0")
    return text if language == "en" else text.translate(str.maketrans(".,", ",."))


def half_width_text(value: float, decimals: int) -> str:
    """Half an interval as a text; what would round to zero keeps one significant digit."""
    if 0 < value < 0.5 * 10.0**-decimals:
        decimals = min(-math.floor(math.log10(value)), 9)
    return f"{value:.{decimals}f}"
