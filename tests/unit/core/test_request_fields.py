"""What a dataclass says of its own fields is what doors get to know of them."""

import gc
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import MISSING, dataclass
from typing import Annotated, Literal

import pytest

from limbgram.core.request_fields import Flag, Within, declared, purpose_of
from limbgram.core.typed import Mismatch, value_of
from limbgram.workbench.edits.editing import EDITS


@dataclass(frozen=True, kw_only=True)
class Cut:
    """Cut a shape.

    A second paragraph.
    """

    height_mm: Annotated[float, Within(0, 300), Flag("height")]
    """Over the distal end,
    along the axis."""
    side: Literal["left", "right"] = "left"
    """Of the patient."""
    at_mm: tuple[Annotated[float, Within(-5, 5)], ...] = ()
    turn_deg: Annotated[float | None, Within(-30, 30)] = None


@dataclass(frozen=True, kw_only=True)
class Deep(Cut):
    """Cut deeply."""

    depth_mm: float = 2.0
    """How deep."""


def test_fields_tell_type_default_limits_meaning_and_flag() -> None:
    height, side, at, turn = declared(Cut)
    assert (height.name, height.hint, height.default, height.required) == (
        "height_mm",
        float,
        MISSING,
        True,
    )
    assert (height.flag, height.unit, height.within) == ("height", "mm", Within(0, 300))
    assert height.meaning == "Over the distal end, along the axis."
    assert (side.choices, side.default, side.flag) == (("left", "right"), "left", "side")
    assert at.within == Within(-5, 5)
    assert turn.optional
    assert turn.hint is float
    assert turn.unit == "deg"
    assert purpose_of(Cut) == "Cut a shape."


def test_what_is_inherited_is_declared_too() -> None:
    named = {one.name: one.meaning for one in declared(Deep)}
    assert named["depth_mm"] == "How deep."
    assert named["side"] == "Of the patient."


@pytest.mark.parametrize(
    ("tree", "fits"),
    [
        ({"height_mm": 0}, True),
        ({"height_mm": 300.0, "turn_deg": None}, True),
        ({"height_mm": 300.1}, False),
        ({"height_mm": float("nan")}, False),
        ({"height_mm": 1, "at_mm": [5, -5]}, True),
        ({"height_mm": 1, "at_mm": [0, 5.5]}, False),
        ({"height_mm": 1, "turn_deg": 31}, False),
    ],
)
def test_files_are_held_to_the_limits(tree: dict[str, object], fits: bool) -> None:
    if fits:
        assert value_of(tree, Cut).height_mm == tree["height_mm"]
    else:
        with pytest.raises(Mismatch):
            value_of(tree, Cut)


def test_the_app_is_held_to_the_limits() -> None:
    pydantic = pytest.importorskip("pydantic")
    cut = pydantic.TypeAdapter(Cut)
    assert cut.validate_python({"height_mm": 3.0}) == Cut(height_mm=3.0)
    for wrong in (
        {"height_mm": 301},
        {"height_mm": 3, "at_mm": [6]},
        {"height_mm": 3, "turn_deg": 31},
    ):
        with pytest.raises(pydantic.ValidationError):
            cut.validate_python(wrong)


def test_threads_that_ask_at_once_are_all_answered() -> None:
    """As a page does that asks for edits and exports: one got "AST constructor recursion depth
    mismatch" where a collection of garbage gave way to another thread."""

    def gives_way(*_: object) -> None:
        sum(range(200))

    rare, often = gc.get_threshold(), sys.getswitchinterval()
    try:
        gc.callbacks.append(gives_way)
        gc.set_threshold(300)
        sys.setswitchinterval(1e-6)
        with ThreadPoolExecutor(8) as threads:
            told = list(threads.map(declared.__wrapped__, 2 * EDITS))
    finally:
        sys.setswitchinterval(often)
        gc.set_threshold(*rare)
        gc.callbacks.remove(gives_way)
    assert told == [declared(one) for one in 2 * EDITS]
