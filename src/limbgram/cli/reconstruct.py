"""`limbgram reconstruct`: photos to a surface in millimetres, in a case folder."""

import math
import sys
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from limbgram.cases.folder import CaseFolder
from limbgram.cases.job import Job
from limbgram.cases.supervision import JobBug, Supervision
from limbgram.cli.captures import (
    DEFAULT_BOARD,
    parse_board,
    parse_box,
    parse_tape,
    plates_of,
    read_distances,
)
from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.core.errors import OptionsError, printable
from limbgram.core.files import json_of
from limbgram.core.typed import tree_of
from limbgram.reconstruction.dense.region import RegionOptions
from limbgram.reconstruction.pipeline import DEFAULTS, PipelineOptions
from limbgram.reconstruction.surface.parts import PartOptions
from limbgram.reconstruction.surface.pivoting import PivotOptions
from limbgram.reconstruction.surface.poisson import PoissonOptions
from limbgram.report.parts import part_lines
from limbgram.report.stages import stage_title
from limbgram.report.summary import StageSummary, Summary, summary_of


class SurfaceMethod(StrEnum):
    """How points become a surface."""

    BALL_PIVOTING = "ball-pivoting"
    POISSON = "poisson"


@answered
def reconstruct_command(
    photos: Annotated[
        list[Path],
        typer.Argument(
            help="Photos of the limb, folders of them, or a video of a walk round it; NAME.png is "
            "a mask of NAME."
        ),
    ],
    case: Annotated[Path, typer.Option("-o", "--out", help="Case folder: new, or to continue.")],
    camera: Annotated[
        list[Path] | None,
        typer.Option(help="Camera file of `limbgram calibrate`; without it EXIF is a first guess."),
    ] = None,
    board: Annotated[
        str | None,
        typer.Option(
            help="Scale board in the scene, or the board file of `limbgram print`.",
            show_default=DEFAULT_BOARD,
        ),
    ] = None,
    no_board: Annotated[bool, typer.Option("--no-board", help="Look for no scale board.")] = False,
    known_distance: Annotated[
        list[Path] | None,
        typer.Option(help="JSON file of known distances between points picked in the photos."),
    ] = None,
    marks: Annotated[
        list[Path] | None,
        typer.Option(
            help="File that `limbgram print` wrote beside scale bars, a mat or a ring: their "
            "lengths set the scale, or with --board check it. Repeat it.",
        ),
    ] = None,
    tape: Annotated[
        list[str] | None,
        typer.Option(
            help="Girth that a tape read on the limb, in mm, to test the size: 150=354 at 150 mm "
            "above the table on which the board lies, or widest=354. Repeat it.",
            show_default=False,
        ),
    ] = None,
    unscaled: Annotated[
        bool, typer.Option("--unscaled", help="Go on without a scale: the size stays unknown.")
    ] = False,
    surface: Annotated[
        SurfaceMethod, typer.Option(help="How points become a surface.")
    ] = SurfaceMethod.BALL_PIVOTING,
    box: Annotated[
        str | None,
        typer.Option(help="Only what lies in this box, mm in the world: x,y,z,x,y,z."),
    ] = None,
    part: Annotated[
        int | None,
        typer.Option(
            help="Which body is the limb where the photos show several: its number in the report.",
            show_default="the one that the photos look at",
        ),
    ] = None,
    triangles: Annotated[
        int,
        typer.Option(min=10_000, max=20_000_000, help="Triangles at most, of all parts together."),
    ] = DEFAULTS.most_triangles,
    memory: Annotated[
        float | None,
        typer.Option(min=0.5, help="Memory to keep to, GB.", show_default="half of the machine's"),
    ] = None,
    profile: Annotated[
        bool, typer.Option("--profile", help="Tell time and memory of every stage.")
    ] = False,
    as_json: Annotated[
        bool,
        typer.Option("--json", help="Events as JSON lines on stderr, the summary on stdout."),
    ] = False,
) -> Reply:
    """Make the surface of a limb, in millimetres, from photos taken round it.

    Ctrl-C stops; the same command continues. A second run computes only what has changed.
    """
    job = Job(
        case=case,
        sources=tuple(photos),
        camera_files=tuple(camera or ()),
        board=None
        if _boardless(board, no_board, [*(known_distance or ()), *(marks or ())], unscaled)
        else parse_board(board or DEFAULT_BOARD),
        distances=tuple(d for file in known_distance or () for d in read_distances(file)),
        tapes=tuple(parse_tape(text) for text in tape or ()),
        plates=tuple(plate for file in marks or () for plate in plates_of(file)),
        unscaled=unscaled,
        options=pipeline_options(surface, box, part, triangles),
        memory_mb=None if memory is None else 1024 * memory,
    )
    summary = run_job(job, as_json)
    return Reply(
        reply_lines(CaseFolder(case), summary, profile), tree_of(summary), summary.verdict.light
    )


def pipeline_options(
    surface: SurfaceMethod,
    box: str | None,
    part: int | None = None,
    triangles: int = DEFAULTS.most_triangles,
) -> PipelineOptions:
    """Options of the stages from what the command line tells."""
    return PipelineOptions(
        surface=PivotOptions() if surface is SurfaceMethod.BALL_PIVOTING else PoissonOptions(),
        most_triangles=triangles,
        region=RegionOptions(box_mm=None if box is None else parse_box(box)),
        parts=PartOptions(chosen=part),
    )


def run_job(job: Job, as_json: bool) -> Summary:
    """Do a job in its own process, showing its progress; returns its summary.

    Raises:
        Exit: a bug of ours ended the job; its traceback is shown.
    """
    try:
        with display(as_json) as screen:
            path = Supervision(job, screen.show).wait()
            return summary_of(json_of(path.read_bytes()))
    except JobBug as bug:
        told = printable(str(bug))
        sys.stderr.write(f"{told}\nThis is a bug of limbgram. Please report the lines above.\n")
        raise typer.Exit(1) from bug


def reply_lines(case: CaseFolder, summary: Summary, profile: bool) -> tuple[str, ...]:
    """What people read at the end."""
    mesh = summary.mesh
    unit = "mm" if summary.unit == "mm" else "units of unknown size"
    size = " x ".join(f"{side:.1f}" for side in mesh.size)
    missing = [f"  {photo.name}: {photo.reason}" for photo in summary.photos if photo.reason]
    aside = [f"  {part.name}: {part.reason}" for part in summary.set_aside]
    return (
        summary.verdict.headline,
        summary.verdict.facts,
        *missing,
        *aside,
        f"Surface: {mesh.faces:,} triangles, {size} {unit}.",
        *part_lines(summary.parts, summary.unit),
        *summary.resolution.notes,
        *(profile_lines(summary.stages) if profile else ()),
        f"Look at it: {case.page}",
        f"How accurate it is: {case.accuracy('html')}",
        f"Files for other programs: {case.deliverables}",
    )


def profile_lines(stages: Sequence[StageSummary]) -> tuple[str, ...]:
    """What each stage cost; a stage taken from the last run tells what it cost then."""
    rows = [
        f"  {stage_title(stage.stage):<26}{stage.wall_s:9.2f}{stage.cpu_s:9.2f}"
        + (f"{stage.peak_mb:9.0f}" if not math.isnan(stage.peak_mb) else f"{'?':>9}")
        + "   taken from the last run" * stage.reused
        for stage in stages
    ]
    wall_s, cpu_s = sum(one.wall_s for one in stages), sum(one.cpu_s for one in stages)
    peaks = [stage.peak_mb for stage in stages if not math.isnan(stage.peak_mb)]
    return (
        f"  {'stage':<26}{'wall s':>9}{'CPU s':>9}{'peak MB':>9}",
        *rows,
        f"  {'All':<26}{wall_s:9.2f}{cpu_s:9.2f}" + (f"{max(peaks):9.0f}" if peaks else ""),
    )


def _boardless(board: str | None, no_board: bool, lengths: list[Path], unscaled: bool) -> bool:
    """Whether no board is looked for: told so, or another answer to the scale was given."""
    if board is not None and no_board:
        raise OptionsError("--board and --no-board contradict each other; give one of them.")
    if no_board and not lengths and not unscaled:
        raise OptionsError(
            "Without a board or known distances the size of the surface is unknown. Give "
            "--known-distance or --marks, or --unscaled if the size does not matter."
        )
    return board is None and (no_board or bool(lengths) or unscaled)
