"""`limbgram reconstruct`: photos to a surface in millimetres, in a case folder."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from limbgram.cases.folder import CaseFolder
from limbgram.cases.job_messages import Answer, Job, order
from limbgram.cases.job_supervision import JobBug, Supervision
from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.cli.request_options import asking
from limbgram.core.errors import OptionsError, printable
from limbgram.core.files import json_of
from limbgram.services.reconstruct import NO_BOARD, ReconstructRequest

NoBoard = Annotated[bool, typer.Option("--no-board", help="Look for no scale board.")]


@answered
@asking
def reconstruct_command(
    photos: Annotated[
        list[Path],
        typer.Argument(
            help="Photos of the limb, folders of them, or a video of a walk round it; NAME.png is "
            "a mask of NAME."
        ),
    ],
    case: Annotated[Path, typer.Option("-o", "--out", help="Case folder: new, or to continue.")],
    ask: ReconstructRequest,
    no_board: NoBoard = False,
    masks: Annotated[
        Path | None,
        typer.Option(
            help="Folder of masks, NAME.png for each photo NAME: white is used, black is not. "
            "`limbgram masks` makes them from a case, to be corrected in any paint program. "
            "A photo without one is used whole.",
            show_default="NAME.png beside the photos, or in a folder `masks` there",
        ),
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
    asked = replace(ask, board=board_word(ask.board, no_board))
    job = order(case, photos, asked, asked.known(), camera_files=asked.camera, masks=masks)
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


def board_word(board: str | None, no_board: bool) -> str | None:
    """The board as requests take it."""
    if board is not None and no_board:
        raise OptionsError("options.board_and_none")
    return NO_BOARD if no_board else board
