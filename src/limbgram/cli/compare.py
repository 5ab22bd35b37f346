"""`limbgram compare`: two shapes, one limb over time, or repeated captures."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import date
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from limbgram.cli.replies import Reply, answered
from limbgram.cli.shapes import UnitOfAll, require_output, shape_of
from limbgram.core.errors import OptionsError
from limbgram.core.files import write_bytes
from limbgram.workbench.compare.comparison import CompareOptions, Comparison, compare
from limbgram.workbench.compare.following import FollowOptions, Series, Visit, follow, repeats
from limbgram.workbench.compare.messages import (
    comparison_lines,
    comparison_tree,
    repeats_lines,
    repeats_tree,
    series_lines,
    series_tree,
)
from limbgram.workbench.compare.registration import RegistrationOptions
from limbgram.workbench.limb import Limb


class WayName(StrEnum):
    """How shapes are laid on each other."""

    AUTO = "auto"
    ICP = "icp"
    LANDMARKS = "landmarks"
    VOLUME = "volume"
    AS_IS = "as-is"


@answered
def compare_command(
    shapes: Annotated[
        list[Path], typer.Argument(help="The shape to compare with, then the other one or more.")
    ],
    way: Annotated[
        WayName,
        typer.Option(
            "--align",
            help="How they are laid on each other; never scaled. auto: as they lie where one was "
            "made from the other; else by three landmarks or more that both have; else by both "
            "alignments, where shape alone leaves the place along the axis open; else icp. "
            "Repeated captures go by icp.",
        ),
    ] = WayName.AUTO,
    weight: Annotated[
        list[str] | None,
        typer.Option(help="Weight of a landmark, with --align landmarks: NAME=0.5. Repeat it."),
    ] = None,
    brim: Annotated[float, typer.Option(help="Strip along open edges left out, mm.")] = 5.0,
    every: Annotated[float, typer.Option(help="Spacing of the levels, mm.")] = 20.0,
    day: Annotated[
        list[str] | None,
        typer.Option(help="Day of each shape, 2026-03-31, in their order: follow a limb."),
    ] = None,
    repeatability: Annotated[
        float,
        typer.Option(
            help="With --day: one standard deviation of a volume, %, taken where scans carry none."
        ),
    ] = 1.0,
    repeated: Annotated[
        bool, typer.Option("--repeats", help="The shapes are captures of one unchanged limb.")
    ] = False,
    picture: Annotated[Path | None, typer.Option(help="Write a picture of it (PNG).")] = None,
    unit: UnitOfAll = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Compare shapes: where they differ, by how much, and whether it matters for the fit.

    Differences are second less first. The alignment is named with the figures, as it moves them.
    Several shapes with --day are one limb over time; with --repeats, captures of an unchanged one.
    """
    _require_a_question(shapes, day, repeated=repeated)
    _require_a_picture_name(picture, repeated=repeated)
    options = CompareOptions(
        registration=RegistrationOptions(
            way=way.value, brim_mm=brim, landmark_weights=_weights(weight or [], way)
        ),
        spacing_mm=every,
    )
    days = [_day(text) for text in day or []]
    limbs = [shape_of(shape, unit).limb for shape in shapes]
    if repeated:
        found = repeats(limbs, options)
        return _doubted(limbs, Reply(repeats_lines(found), repeats_tree(found)))
    if days:
        visits = [Visit(limb=limb, day=day) for limb, day in zip(limbs, days)]
        series = follow(
            visits, FollowOptions(compare=options, assumed_volume_share=repeatability / 100)
        )
        written = None if picture is None else write_bytes(picture, _course(series))
        return _doubted(limbs, _reply(series_lines(series), series_tree(series), written))
    comparison = compare(limbs[0], limbs[1], options)
    written = None if picture is None else write_bytes(picture, _differences(comparison))
    reply = _reply(comparison_lines(comparison), comparison_tree(comparison), written)
    return _doubted(limbs, reply)


def _doubted(limbs: Sequence[Limb], reply: Reply) -> Reply:
    """The same reply, which begins with what is to be said against a shape."""
    doubts = [f"{limb.name}: {limb.doubt}" for limb in limbs if limb.doubt]
    lines = (*(f"Note: {one}." for one in doubts), *reply.lines)
    return replace(reply, lines=lines, content={**reply.content, "doubts": doubts})


def _course(series: Series) -> bytes:
    """Drawn only where asked: what draws takes longer to import than most shapes to compare."""
    from limbgram.report.drawings.courses import course
    from limbgram.report.drawings.drawing import png

    return png(course(series).figure).tobytes()


def _differences(comparison: Comparison) -> bytes:
    from limbgram.report.drawings.differences import difference_pictures
    from limbgram.report.drawings.drawing import png

    return png(difference_pictures(comparison).figure).tobytes()


def _reply(lines: tuple[str, ...], content: dict[str, Any], written: Path | None) -> Reply:
    if written is None:
        return Reply(lines, {**content, "written": []})
    return Reply((*lines, f"Written: {written}"), {**content, "written": [str(written)]})


def _require_a_question(shapes: Sequence[Path], day: list[str] | None, *, repeated: bool) -> None:
    if len(shapes) < 2:
        raise OptionsError("options.compare.one_shape")
    if repeated and day:
        raise OptionsError("options.compare.repeats_and_days")
    if day and len(day) != len(shapes):
        raise OptionsError("options.compare.days", days=len(day), shapes=len(shapes))
    if len(shapes) > 2 and not day and not repeated:
        raise OptionsError("options.compare.kind_missing", shapes=len(shapes))


def _require_a_picture_name(picture: Path | None, *, repeated: bool) -> None:
    if picture is None:
        return
    if repeated:
        raise OptionsError("options.compare.no_picture")
    require_output(picture, ".png", "picture")


def _day(text: str) -> date:
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise OptionsError("options.no_day", text=text) from None


def _weights(texts: Sequence[str], way: WayName) -> dict[str, float]:
    if texts and way is not WayName.LANDMARKS:
        raise OptionsError("options.compare.weight")
    weights: dict[str, float] = {}
    for text in texts:
        name, _, number = text.rpartition("=")
        try:
            weights[name.strip()] = float(number)
        except ValueError:
            raise OptionsError("options.no_weight", text=text) from None
    return weights
