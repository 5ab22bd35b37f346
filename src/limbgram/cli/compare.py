"""`limbgram compare`: two shapes, one limb over time, or repeated captures."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from limbgram.cli.replies import Reply, answered, language, spoken
from limbgram.cli.request_options import asking
from limbgram.cli.shape_options import UnitOfAll, require_output, shape_of
from limbgram.core.errors import OptionsError
from limbgram.core.files import write_bytes
from limbgram.findings import as_json, note
from limbgram.services.compare import CompareRequest, FollowRequest, follow
from limbgram.workbench.compare.comparison import Comparison
from limbgram.workbench.compare.messages import (
    comparison_lines,
    comparison_tree,
    repeats_lines,
    repeats_tree,
    series_lines,
    series_tree,
)
from limbgram.workbench.compare.over_time import Repeats, Series
from limbgram.workbench.limb import Limb


@answered
@asking
def compare_command(
    shapes: Annotated[
        list[Path], typer.Argument(help="The shape to compare with, then the other one or more.")
    ],
    ask: CompareRequest,
    over: FollowRequest,
    picture: Annotated[Path | None, typer.Option(help="Write a picture of it (PNG).")] = None,
    unit: UnitOfAll = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Compare shapes: where they differ, by how much, and whether it matters for the fit.

    Differences are second less first. The alignment is named with the figures, as it moves them.
    Several shapes with --day are one limb over time; with --repeats, captures of an unchanged one.
    """
    over.require_for(len(shapes))
    _require_a_picture_name(picture, repeated=over.repeats)
    limbs = [shape_of(shape, unit).limb for shape in shapes]
    match follow(limbs, ask, over):
        case Repeats() as found:
            reply = Reply(repeats_lines(found, language()), repeats_tree(found))
        case Series() as series:
            written = None if picture is None else write_bytes(picture, _course(series))
            reply = _reply(series_lines(series, language()), series_tree(series), written)
        case Comparison() as compared:
            written = None if picture is None else write_bytes(picture, _differences(compared))
            lines = comparison_lines(compared, language())
            reply = _reply(lines, comparison_tree(compared), written)
    return _doubted(limbs, reply)


def _doubted(limbs: Sequence[Limb], reply: Reply) -> Reply:
    """The reply, preceded by doubts about the shapes."""
    doubts = [
        note("compare.red_shape", name=limb.name, doubt=limb.doubt)
        for limb in limbs
        if limb.doubt is not None
    ]
    lines = (*(f"Note: {spoken(one)}" for one in doubts), *reply.lines)
    content = {**reply.content, "doubts": [as_json(one) for one in doubts]}
    return replace(reply, lines=lines, content=content)


def _course(series: Series) -> bytes:
    """Imports on demand: they take longer than most comparisons."""
    from limbgram.report.drawings.drawing import png
    from limbgram.report.drawings.time_course import course_drawing

    return png(course_drawing(series).figure).tobytes()


def _differences(comparison: Comparison) -> bytes:
    from limbgram.report.drawings.differences import difference_pictures
    from limbgram.report.drawings.drawing import png

    return png(difference_pictures(comparison).figure).tobytes()


def _reply(lines: tuple[str, ...], content: dict[str, Any], written: Path | None) -> Reply:
    if written is None:
        return Reply(lines, {**content, "written": []})
    return Reply((*lines, f"Written: {written}"), {**content, "written": [str(written)]})


def _require_a_picture_name(picture: Path | None, *, repeated: bool) -> None:
    if picture is None:
        return
    if repeated:
        raise OptionsError("options.compare.no_picture")
    require_output(picture, ".png", "picture")
