"""`limbgram check`: is a capture good, or which photos are missing."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from limbgram.capture.answer import CaptureCheck
from limbgram.cases.capture_check import (
    CaptureWatch,
    CheckRequest,
    check_sources,
    require_sources,
    stamps_of,
)
from limbgram.cli.progress import Display, display
from limbgram.cli.reconstruct import NoBoard, board_word
from limbgram.cli.replies import Reply, answered, spoken
from limbgram.cli.request_options import asking
from limbgram.core.errors import OptionsError, PhotoError, disk_finding, printable
from limbgram.core.files import write_bytes
from limbgram.core.run import Run
from limbgram.core.typed import tree_of
from limbgram.reconstruction.photos.video import is_video
from limbgram.report.drawings.coverage import coverage_picture

_POLL_S = 0.5
"""Interval between two looks at a folder; a file that changes in it is still being written."""


@answered
@asking
def check_command(
    photos: Annotated[
        list[Path], typer.Argument(help="Photos of the limb, folders of them, or a video.")
    ],
    ask: CheckRequest,
    no_board: NoBoard = False,
    picture: Annotated[
        Path | None,
        typer.Option(
            help="Write a picture (PNG): where the photos stand, where to add some, and the "
            "expected interval on the unrolled limb."
        ),
    ] = None,
    watch: Annotated[
        bool,
        typer.Option("--watch", help="Stay and check again whenever a photo comes, until GO."),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Say within a minute whether a capture is good, or which photos to add and from where.

    GO ends with exit code 0, anything else with 7. What is checked: sharpness and exposure on the
    limb, whether the photos join all round, the scale board, whether every side is seen by enough
    photos, and how sure the surface will be there. Photos to add are named by the hour at which to
    stand, seen from above with the first photo at 12, and by the height of the camera.
    """
    asked = replace(ask, board=board_word(ask.board, no_board))
    with display(as_json) as screen:
        if watch:
            found = _watched(photos, asked, picture, screen)
        else:
            run = Run(listener=screen.listen)
            found = check_sources(
                photos, asked.calibrations(), asked.scale_board(), run, masks=asked.masks
            )
    lines = check_lines(found)
    if picture is not None:
        write_bytes(picture, coverage_picture(found).tobytes())
        lines = (*lines, f"Picture: {printable(str(picture))}")
    return Reply(lines, tree_of(found), "green" if found.go else "red")


def check_lines(found: CaptureCheck) -> tuple[str, ...]:
    """The answer, findings, notes, and remarks on single photos."""
    notes = [f"  {one.name}: {spoken(remark)}" for one in found.photos for remark in one.remarks]
    more = map(spoken, (*found.findings[1:], *found.notes))
    return (
        spoken(found.headline),
        *(f"  {text}" for text in (*more, *_texture(found))),
        *notes,
    )


def _texture(found: CaptureCheck) -> tuple[str, ...]:
    """Density of feature points on the limb, if its size is known."""
    dense = sorted(
        (one.features_per_cm2, one.name)
        for one in found.photos
        if math.isfinite(one.features_per_cm2)
    )
    if not dense:
        return ()
    least, name = dense[0]
    return (
        f"Texture: {dense[len(dense) // 2][0]:.1f} feature points a cm² of the limb in the middle "
        f"one of the photos, {least:.1f} in the poorest ({name}).",
    )


def _watched(
    sources: Sequence[Path], ask: CheckRequest, picture: Path | None, screen: Display
) -> CaptureCheck:
    """The first GO; answers before it are shown as they come."""
    if any(is_video(source) for source in sources):
        raise OptionsError("options.check.watch_of_video")
    require_sources(sources)
    checked: Mapping[Path, tuple[int, int]] | None = None
    with CaptureWatch(ask.calibrations(), ask.scale_board(), masks=ask.masks) as watch:
        while True:
            there = stamps_of(sources)
            time.sleep(_POLL_S)
            if there == checked or there != stamps_of(sources):
                continue  # nothing new, or a file is still being written
            checked = there
            try:
                found = watch.check(sources, Run(listener=screen.listen))
            except PhotoError as waiting:
                screen.say(printable(spoken(waiting.finding)))
                continue
            except FileNotFoundError as gone:  # a file that vanished during the check
                screen.say(printable(spoken(disk_finding(gone))))
                continue
            if found.go:
                return found
            for line in check_lines(found):
                screen.say(printable(line))
            if picture is not None:
                write_bytes(picture, coverage_picture(found).tobytes())
