"""`limbgram warm-up`: what is compiled at first use, compiled now."""

import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer

from limbgram.cases.deliverables import deliver
from limbgram.cli.calibrate import calibrate_from
from limbgram.cli.captures import DEFAULT_BOARD, parse_board
from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.core.run import Run
from limbgram.formats.gcode.writing import write_gcode
from limbgram.formats.reading import read_limb
from limbgram.reconstruction.pipeline import Capture, reconstruct
from limbgram.report.pictures import draw
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.options import SMALL
from limbgram.synthetic.props.board import CALIBRATION_BOARD
from limbgram.workbench.carving.setup import CarveOptions
from limbgram.workbench.edits.cutting import PlaneCut
from limbgram.workbench.edits.offset import offset
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.geodesic import shortest_path

_CAPTURE = replace(SMALL, photos=14)
"""The smallest that goes all the way."""


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
        deliver(done, Path(folder) / "deliverables", unscaled=False)
        run(work_on_shape, read_limb(capture / "truth" / "mesh.ply"), Path(folder) / "carve.gcode")
    seconds = time.perf_counter() - begin
    return Reply(
        (f"Ready: compiled and tried in {seconds:.0f} s.",), {"seconds": round(seconds, 1)}
    )


def work_on_shape(limb: Limb, program: Path) -> None:
    """What the workbench compiles besides."""
    up = np.array([0.0, 0.0, 1.0])
    limb = align(limb, AlignOptions(side="none", axis=up, anterior=np.array([0.0, 1.0, 0.0])))
    offset(limb.mesh, -0.5)
    shortest_path(limb.mesh, limb.mesh.vertices_mm[0], limb.mesh.vertices_mm[-1])
    middle_mm = float(np.ptp(limb.mesh.vertices_mm[:, 2])) / 2
    PlaneCut(height_mm=middle_mm, capped=True).apply(limb)
    write_gcode(limb, program, CarveOptions(scallop_mm=0.5, tolerance_mm=0.04))
