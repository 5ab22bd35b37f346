"""`limbgram demo`: from nothing to a surface, compared with its truth."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.cases.case_record import write_json
from limbgram.cases.folder import CaseFolder
from limbgram.cases.job_messages import Job
from limbgram.cases.scoring import score_case
from limbgram.cli.progress import display
from limbgram.cli.reconstruct import reply_lines, run_job
from limbgram.cli.replies import Reply, answered
from limbgram.core.files import json_of, make_folder, require_folder
from limbgram.core.run import Run
from limbgram.core.typed import tree_of
from limbgram.report.comparison import TruthComparison
from limbgram.services.calibrate import calibrate_photos, save_calibration
from limbgram.services.parse_capture import DEFAULT_BOARD, parse_board
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.props.board import CALIBRATION_BOARD


@answered
def demo_command(
    folder: Annotated[Path, typer.Option("-o", "--out", help="Folder for everything.")] = Path(
        "limbgram-demo"
    ),
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Photograph a synthetic limb, calibrate, reconstruct, and compare with the truth.

    Takes a few minutes; the first run of a fresh installation also compiles for half a minute.
    """
    capture, camera, case = folder / "capture", folder / "camera.json", folder / "case"
    require_folder(folder)
    with display(as_json) as screen:
        run = Run(listener=screen.listen)
        if not capture.exists():
            make_folder(folder)
            run(make_capture, capture, CaptureOptions())
        if not camera.exists():
            board = CALIBRATION_BOARD.board
            calibrated = calibrate_photos([capture / "calibration"], board, run)
            save_calibration(calibrated, camera, folder / "camera.png")
    job = Job(
        case=case,
        sources=(capture / "images",),
        camera_files=(camera,),
        board=parse_board(DEFAULT_BOARD),
    )
    answer = run_job(job, as_json)
    comparison = score_case(case, capture / "truth")
    figures = tree_of(comparison)
    write_json(folder / "comparison.json", figures)
    return Reply(
        (*reply_lines(CaseFolder(case), answer, profile=False), *comparison_lines(comparison)),
        {"summary": json_of(answer.summary.read_bytes()), "comparison": figures},
        answer.light,
    )


def comparison_lines(comparison: TruthComparison) -> tuple[str, ...]:
    """A comparison for people."""
    girths = ", ".join(
        f"{error:+z.2f} at {height:.1f}"
        for height, error in zip(comparison.girth_heights_mm, comparison.girth_errors_mm)
    )
    return (
        "Against the truth, after a rigid alignment only:",
        f"  surface        RMS {comparison.rms_mm:.3f} mm, 95 % within {comparison.p95_mm:.3f} mm, "
        f"mean {comparison.mean_mm:+z.3f} mm",
        f"  covered        {comparison.covered:.1%} of the visible surface within 0.25 mm",
        f"  scale          {comparison.scale_error:+z.3%}",
        f"  girths         {girths} mm of height in the truth",
        f"  volume         {comparison.volume_error:+z.2%}",
        f"  camera places  RMS {comparison.camera_rms_mm:.2f} mm",
    )
