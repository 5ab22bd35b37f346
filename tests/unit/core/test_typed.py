"""What does not fit its type is refused at the exact place; what fits comes back as it was."""

import json
import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from limbgram.core.request_fields import Within
from limbgram.core.typed import (
    Mismatch,
    Strictness,
    any_value_of,
    tree_of,
    value_of,
    words_of_type,
)
from limbgram.findings import Finding, note


@dataclass(frozen=True, kw_only=True)
class Lens:
    k1: float
    k2: float = 0.0


@dataclass(frozen=True, kw_only=True)
class File:
    version: Literal[1]
    parameters: Lens
    at: str | tuple[float, float, float] = ""
    feed: Literal["fast", "slow"] | None = None
    count: int = 1
    flag: bool = False
    rows: tuple[tuple[int, ...], ...] = ()


GOOD: dict[str, Any] = {"version": 1, "parameters": {"k1": 1}}


def test_what_fits_is_read_and_whole_numbers_become_floats() -> None:
    read = value_of({**GOOD, "at": [1, 2.5, 3], "rows": [[1], []], "feed": "slow"}, File)
    assert read == File(
        version=1, parameters=Lens(k1=1.0), at=(1.0, 2.5, 3.0), rows=((1,), ()), feed="slow"
    )
    assert type(read.parameters.k1) is float


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"parameters": {"k1": "1"}}, "parameters.k1 must be a number, not '1'"),
        ({"parameters": {"k1": True}}, "parameters.k1 must be a number, not True"),
        ({"parameters": {"k1": math.nan}}, "parameters.k1 must be a number within reason, not nan"),
        ({"parameters": {"k1": 10**400}}, "parameters.k1 must be a number within reason"),
        ({"parameters": {"k1": None}}, "parameters.k1 must be a number, not None"),
        ({"parameters": {"k2": 1}}, "parameters needs k1"),
        ({"parameters": {"k1": 1, "k9": 1}}, "parameters has no k9. It has: k1, k2"),
        ({"parameters": []}, "parameters must be a table, not []"),
        ({"more": 1}, "it has no more. It has: version, parameters"),
        ({"version": True}, "version must be 1, not True"),
        ({"version": 2}, "version must be 1, not 2"),
        ({"count": 1.0}, "count must be a whole number, not 1.0"),
        ({"count": True}, "count must be a whole number, not True"),
        ({"flag": 1}, "flag must be true or false, not 1"),
        ({"at": [1, 2]}, "at must have 3 numbers, not 2"),
        ({"at": [1, 2, "x"]}, "at[2] must be a number, not 'x'"),
        ({"at": 7}, "at must be a text or a list in brackets, not 7"),
        ({"feed": "swift"}, "feed must be one of fast, slow, not 'swift'"),
        ({"rows": [[1], [2, "x"]]}, "rows[1][1] must be a whole number, not 'x'"),
        ({"rows": {}}, "rows must be a list in brackets, not {}"),
    ],
)
def test_what_does_not_fit_is_named_by_its_place(change: dict[str, Any], told: str) -> None:
    with pytest.raises(Mismatch) as caught:
        value_of({**GOOD, **change}, File)
    assert str(caught.value).startswith(told)


@pytest.mark.parametrize("tree", [None, [], "x", 1, True])
def test_what_is_no_table_is_no_dataclass(tree: object) -> None:
    with pytest.raises(Mismatch, match=r"a\.json must be a table"):
        value_of(tree, File, "a.json")


def test_unknown_names_and_bounds_are_as_strict_as_is_asked() -> None:
    later = {**GOOD, "more": 1, "parameters": {"k1": 5, "k9": 1}}
    assert value_of(later, File, strictness=Strictness(pass_over_unknown=True)).parameters.k1 == 5
    with pytest.raises(Mismatch, match="k1 must be a number within reason, not 5"):
        value_of({"k1": 5}, Lens, strictness=Strictness(below=5.0))


def test_what_is_not_known_is_null_in_json() -> None:
    tree = tree_of({"a": (math.nan, -math.inf, 1.5), "b": Lens(k1=math.inf), "c": None})
    assert tree == {"a": [None, None, 1.5], "b": {"k1": None, "k2": 0.0}, "c": None}
    with pytest.raises(TypeError, match="object has no place"):
        tree_of([object()])


@given(st.floats(-1e299, 1e299), st.integers(-(2**53), 2**53), st.text(max_size=8))
def test_what_is_written_is_read_again(number: float, count: int, text: str) -> None:
    for at in (text, (number, 0.5, -number)):
        file = File(version=1, parameters=Lens(k1=number), at=at, count=count, rows=((count,), ()))
        assert value_of(json.loads(json.dumps(tree_of(file), allow_nan=False)), File) == file


TREES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda below: st.lists(below, max_size=4) | st.dictionaries(st.text(), below, max_size=4),
    max_leaves=8,
)


@given(TREES, st.sampled_from([File, Lens, float, str | None, tuple[int, ...], Literal["a"]]))
def test_any_tree_is_read_or_refused(tree: object, hint: Any) -> None:
    """Never another error, and never another type."""
    try:
        read = any_value_of(tree, hint)
    except Mismatch:
        return
    assert hint not in (File, Lens)
    assert hint is not float or type(read) is float


@dataclass(frozen=True, kw_only=True)
class Said:
    headline: Finding
    reason: Finding | None = None
    facts: tuple[Finding, ...] = ()


def test_a_sentence_of_an_earlier_version_is_read_as_a_finding_of_its_words() -> None:
    first, second = (note("said.as_is", message=words) for words in ("GREEN. It is.", "So."))
    old = value_of({"headline": "GREEN. It is.", "reason": "So."}, Said)
    assert old == Said(headline=first, reason=second)
    assert value_of(tree_of(old), Said) == old
    assert value_of({"headline": "GREEN. It is.", "facts": "So."}, Said).facts == (second,)
    assert value_of({"headline": "GREEN. It is.", "facts": ""}, Said).facts == ()
    for tree in (3, {"code": "a.b"}, None):
        with pytest.raises(Mismatch):
            value_of({"headline": tree}, Said)


def test_a_bounded_number_is_a_number_to_people() -> None:
    assert words_of_type(Annotated[float, Within(0, 80)]) == "a number"
