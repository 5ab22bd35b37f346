"""`limbgram frames`: the frames of a video that serve as photos."""

import math
from pathlib import Path
from typing import Annotated

import typer

from limbgram.cases.video_frames import take_frames
from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.core.run import Run
from limbgram.reconstruction.photos.video import DEFAULTS, FrameOptions


@answered
def frames_command(
    video: Annotated[Path, typer.Argument(help="Video of one slow walk round the limb.")],
    folder: Annotated[Path, typer.Option("-o", "--out", help="Folder to make.")],
    count: Annotated[
        int, typer.Option(min=4, max=500, help="Frames to take from the whole film.")
    ] = DEFAULTS.count,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Take the sharp, well-spread frames out of a video, and say why each was taken or not.

    `limbgram reconstruct VIDEO` does the same by itself. Frames of a video of the checkerboard
    serve `limbgram calibrate`, if it was filmed with the same lens and settings.
    """
    with display(as_json) as screen:
        run = Run(listener=screen.listen)
        made = take_frames(video, folder, run, FrameOptions(count=count))
    length = "" if math.isnan(made.duration_s) else f" ({made.duration_s:.1f} s)"
    return Reply(
        (
            f"{made.taken} of {made.frames:,} frames{length} are in {made.photos}.",
            f"The reason for each: {made.record}",
            f"At a glance: {made.sheet}",
        ),
        {
            "photos": str(made.photos),
            "taken": made.taken,
            "frames": made.frames,
            "record": str(made.record),
            "sheet": str(made.sheet),
        },
    )
