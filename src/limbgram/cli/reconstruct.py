"""`limbgram reconstruct`: photos to a surface in millimetres, in a case folder."""

import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from limbgram.cases.folder import CaseFolder
from limbgram.cases.order import Answer, Job
from limbgram.cases.supervision import JobBug, Supervision
from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.core.errors import OptionsError, printable
from limbgram.core.files import json_of
from limbgram.reconstruction.choices import MOST_TRIANGLES, Choices
from limbgram.services.captures import (
    DEFAULT_BOARD,
    parse_board,
    parse_box,
    parse_tape,
    plates_of,
    read_distances,
)


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
        typer.Option(
            help="JSON file of known distances between points picked in the photos; "
            "length_sigma_mm beside length_mm says how surely a tape read it, such as 0.5."
        ),
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
            "above the table on which the board lies, or widest=354. It counts as read to 3 mm in "
            "95 of 100; state another as 150=354+-2. Repeat it.",
            show_default=False,
        ),
    ] = None,
    unscaled: Annotated[
        bool, typer.Option("--unscaled", help="Go on without a scale: the size stays unknown.")
    ] = False,
    masks: Annotated[
        Path | None,
        typer.Option(
            help="Folder of masks, NAME.png for each photo NAME: white is used, black is not. "
            "`limbgram masks` makes them from a case, to be corrected in any paint program. "
            "A photo without one is used whole.",
            show_default="NAME.png beside the photos, or in a folder `masks` there",
        ),
    ] = None,
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
    ] = MOST_TRIANGLES,
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
        masks=masks,
        camera_files=tuple(camera or ()),
        board=None
        if boardless(board, no_board, [*(known_distance or ()), *(marks or ())], unscaled)
        else parse_board(board or DEFAULT_BOARD),
        distances=tuple(d for file in known_distance or () for d in read_distances(file)),
        tapes=tuple(parse_tape(text) for text in tape or ()),
        plates=tuple(plate for file in marks or () for plate in plates_of(file)),
        unscaled=unscaled,
        choices=Choices(
            surface=surface.value,
            box_mm=None if box is None else parse_box(box),
            part=part,
            most_triangles=triangles,
        ),
        memory_mb=None if memory is None else 1024 * memory,
    )
    answer = run_job(job, as_json)
    content = json_of(answer.summary.read_bytes())
    return Reply(reply_lines(CaseFolder(case), answer, profile), content, answer.light)


def run_job(job: Job, as_json: bool) -> Answer:
    """Do a job in its own process, showing its progress; returns its answer.

    Raises:
        Exit: a bug of ours ended the job; its traceback is shown.
    """
    try:
        with display(as_json) as screen:
            return Supervision(job, screen.show).wait()
    except JobBug as bug:
        told = printable(str(bug))
        sys.stderr.write(f"{told}\nThis is a bug of limbgram. Please report the lines above.\n")
        raise typer.Exit(1) from bug


def reply_lines(case: CaseFolder, answer: Answer, profile: bool) -> tuple[str, ...]:
    """What people read at the end."""
    return (
        *answer.lines,
        *(answer.costs if profile else ()),
        f"Look at it: {case.page}",
        f"How accurate it is: {case.accuracy('html')}",
        f"Files for other programs: {case.deliverables}",
    )


def boardless(board: str | None, no_board: bool, lengths: list[Path], unscaled: bool) -> bool:
    """Whether no board is looked for: told so, or another answer to the scale was given."""
    if board is not None and no_board:
        raise OptionsError("options.board_and_none")
    if no_board and not lengths and not unscaled:
        raise OptionsError("options.no_size")
    return board is None and (no_board or bool(lengths) or unscaled)
