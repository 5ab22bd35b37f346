"""`limbgram warm-up`: what is compiled at first use, compiled now."""

import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from limbgram.cli.calibrate import calibrate_from
from limbgram.cli.parsing import DEFAULT_BOARD, parse_board
from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.pipeline import Capture, reconstruct
from limbgram.report.pictures import draw
from limbgram.run import Run
from limbgram.shape.edits.offset import offset
from limbgram.shape.measures.geodesic import shortest_path
from limbgram.synthetic import CALIBRATION_BOARD, SMALL, make_capture

_CAPTURE = replace(SMALL, photos=14)
"""The smallest that goes all the way."""


@answered
def warm_up_command(
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Compile the fast parts once, so that the first capture does not wait for it.

    Run it after installing: a small synthetic capture goes through every stage, and what was
    compiled is kept beside the program. Later runs start at once; running it again is harmless.
    """
    begin = time.perf_counter()
    with display(as_json) as shown, TemporaryDirectory(prefix="limbgram-") as folder:
        run = Run(listener=shown.listen)
        capture = Path(folder) / "capture"
        run(make_capture, capture, _CAPTURE)
        board = CALIBRATION_BOARD.board
        camera = calibrate_from([capture / "calibration"], board, run).calibration
        given = Capture(
            sources=(capture / "images",),
            calibrations=(camera,),
            board=parse_board(DEFAULT_BOARD),
        )
        done = reconstruct(given, run=run)
        run(draw, done.photos, done.features, done.pairs, done.metric, done.cloud, done.mesh)
        mesh = done.mesh
        offset(mesh, -0.5)
        shortest_path(mesh, mesh.vertices_mm[0], mesh.vertices_mm[-1])
    seconds = time.perf_counter() - begin
    return Reply(
        (f"Ready: compiled and tried in {seconds:.0f} s.",), {"seconds": round(seconds, 1)}
    )
