"""Options of the command line are what requests say that they take."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal, get_args

import pytest
import typer
from typer.testing import CliRunner

from limbgram.cli.request_options import Kinds, asking
from limbgram.core.errors import OptionsError
from limbgram.core.request_fields import Flag, Within


@dataclass(frozen=True, kw_only=True)
class Ask:
    """What is measured."""

    spacing_mm: Annotated[float, Within(0.5, 50), Flag("every")] = 10.0
    """Between levels."""
    heights_mm: tuple[Annotated[float, Within(-50, 500)], ...] = ()
    """Only there."""
    axis: Literal["limb", "fit"] = "limb"
    inside: bool = False
    """What a wall holds."""
    sock_mm: float | None = None


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """A drawing."""

    spacing_mm: Annotated[float, Flag("spacing")] = 10.0


@dataclass(frozen=True, kw_only=True)
class Program:
    """A program."""

    spacing_mm: Annotated[float, Flag("spacing")] = 2.0
    tool_mm: Annotated[float, Within(1, 60), Flag("tool")] = 12.0


def asked(*words: str) -> tuple[Ask | None, Any]:
    heard: list[Ask] = []
    app = typer.Typer()

    @app.command()
    @asking
    def command(shape: str, ask: Ask) -> None:
        assert shape == "limb.ply"
        heard.append(ask)

    result = CliRunner().invoke(app, ["limb.ply", *words])
    return (heard[0] if heard else None), result


def test_what_is_not_typed_has_its_default() -> None:
    assert asked()[0] == Ask()


def test_what_is_typed_comes_with_its_type() -> None:
    words = [
        "--every",
        "5",
        "--heights-mm",
        "20",
        "--heights-mm",
        "30.5",
        "--axis",
        "fit",
        "--inside",
    ]
    assert asked(*words)[0] == Ask(spacing_mm=5, heights_mm=(20, 30.5), axis="fit", inside=True)


def test_help_says_meaning_default_and_choices() -> None:
    said = " ".join(asked("--help")[1].output.split())
    for part in ("Between levels.", "Default: 10.", "limb|fit", "What a wall holds."):
        assert part in said


def test_help_says_of_which_kind_a_default_is_where_they_differ() -> None:
    kinds = Kinds({"dxf": Drawing, "gcode": Program}, by="to")
    told = [get_args(one.annotation)[1].help for one in kinds.options()]
    assert told[0].endswith(" Default: dxf 10, gcode 2.")
    assert told[1].endswith(" Default: 12.")


@dataclass(frozen=True, kw_only=True)
class Sections:
    """A drawing of sections."""

    spacing_mm: float = 10.0
    """Between sections."""
    to_mm: float | None = None
    """Height of the last section."""


@dataclass(frozen=True, kw_only=True)
class Carving:
    """A program that stops."""

    spacing_mm: float = 10.0
    """Between sections."""
    to_mm: float | None = None
    """Where carving stops."""


def test_help_says_of_each_kind_what_an_option_means_for_it() -> None:
    kinds = Kinds({"dxf": Sections, "aop": Sections, "gcode": Carving}, by="to")
    told = [get_args(one.annotation)[1].help for one in kinds.options()]
    assert told == [
        "dxf, aop, gcode: Between sections. Default: 10.",
        "dxf, aop: Height of the last section. gcode: Where carving stops.",
    ]


@pytest.mark.parametrize(
    ("words", "value"), [(("--every", "0.4"), 0.4), (("--heights-mm", "501"), 501)]
)
def test_numbers_beyond_their_limits_are_refused(words: tuple[str, ...], value: float) -> None:
    error = asked(*words)[1].exception
    assert isinstance(error, OptionsError)
    assert error.finding.code == "ask.beyond_limits"
    assert error.finding.values["value"] == value


def test_words_that_are_no_choice_are_refused() -> None:
    assert asked("--axis", "mesh")[1].exit_code == 2


def test_an_option_of_another_kind_is_refused() -> None:
    kinds = Kinds({"dxf": Drawing, "gcode": Program}, by="to")
    assert [one.name for one in kinds.options()] == ["spacing_mm", "tool_mm"]
    typed = {"tool_mm": 8.0, "spacing_mm": None}
    assert kinds.made(dict(typed), "gcode") == Program(tool_mm=8.0)
    with pytest.raises(OptionsError) as refused:
        kinds.made(dict(typed), "dxf")
    assert refused.value.finding.code == "ask.other_kind"
    assert refused.value.finding.values == {
        "options": ("--tool",),
        "kinds": ("gcode",),
        "kind": "dxf",
    }


@dataclass(frozen=True, kw_only=True)
class Spindle:
    """A program whose spindle may be left to the operator."""

    spindle_rpm: Annotated[int | None, Flag("spindle")] = None
    quiet: bool = False


def test_a_zero_that_is_typed_is_no_option_left_out() -> None:
    kinds = Kinds({"dxf": Drawing, "gcode": Spindle}, by="to")
    typed = {"spacing_mm": None, "spindle_rpm": 0, "quiet": False}
    assert kinds.made(dict(typed), "gcode") == Spindle(spindle_rpm=0)
    with pytest.raises(OptionsError) as refused:
        kinds.made(dict(typed), "dxf")
    assert refused.value.finding.values["options"] == ("--spindle",)
