"""`limbgram warm-up`: compiles now what would be compiled at first use."""

import subprocess
import sys
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from limbgram.cases.child_process import environment
from limbgram.cases.deliverables import deliver
from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.cli.warm_up_worker import CAPTURE, work_on_shape
from limbgram.core.run import NEUTRAL_FOLDER, Run, worker_count
from limbgram.formats.reading import read_limb
from limbgram.reconstruction.pipeline import Capture, reconstruct
from limbgram.report.pictures import draw
from limbgram.services.calibrate import calibrate_photos
from limbgram.services.parse_capture import DEFAULT_BOARD, parse_board
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.props.board import CALIBRATION_BOARD


@answered
def warm_up_command(
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Compile the fast parts once, so that the first capture does not wait for it.

    Run it after installing: a small synthetic capture goes through every stage and its shape as
    far as a carver's program, and what was compiled is kept beside the program. Later runs start
    at once; running it again is harmless.
    """
    begin = time.perf_counter()
    with display(as_json) as shown, TemporaryDirectory(prefix="limbgram-") as folder:
        run, capture = Run(listener=shown.listen), Path(folder) / "capture"
        with second_process(capture, Path(folder)):
            _go_all_the_way(capture, Path(folder), run)
    seconds = time.perf_counter() - begin
    return Reply(
        (f"Ready: compiled and tried in {seconds:.0f} s.",), {"seconds": round(seconds, 1)}
    )


def _go_all_the_way(capture: Path, folder: Path, run: Run) -> None:
    """Run all stages, from rendered photos to a carver's program."""
    run(make_capture, capture, CAPTURE)
    camera = calibrate_photos([capture / "calibration"], CALIBRATION_BOARD.board, run).calibration
    given = Capture(
        sources=(capture / "images",),
        calibrations=(camera,),
        board=parse_board(DEFAULT_BOARD),
    )
    done = reconstruct(given, run=run)
    run(draw, done.photos, done.features, done.pairs, done.metric, done.cloud, done.mesh)
    deliver(done, folder / "deliverables", unscaled=False)
    run(work_on_shape, read_limb(capture / "truth" / "mesh.ply"), folder / "carve.gcode")


@contextmanager
def second_process(capture: Path, folder: Path) -> Generator[None]:
    """Run `warm_up_worker` in parallel, if there is a second processor."""
    if worker_count() == 1:
        yield
        return
    command = [sys.executable, "-P", "-m", "limbgram.cli.warm_up_worker", str(capture), str(folder)]
    quiet = subprocess.DEVNULL
    worker = subprocess.Popen(
        command, cwd=NEUTRAL_FOLDER, env=environment(), stdout=quiet, stderr=quiet
    )
    try:
        yield
    finally:
        worker.kill()
        worker.wait()
