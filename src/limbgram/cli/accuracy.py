"""`limbgram accuracy`: how accurate a finished case is, and what limits it."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from limbgram.cases.case_assessment import assess_case
from limbgram.cases.folder import CaseFolder
from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, advised, answered, spoken
from limbgram.core.run import Run
from limbgram.report.accuracy.assessment import Assessment
from limbgram.report.accuracy.figures import TruthFigures

_SHOWN = 5


class AlignBy(StrEnum):
    """How the surface is laid onto the truth; never by a scale."""

    SURFACE = "surface"
    CAMERAS = "cameras"
    FRAME = "frame"


@answered
def accuracy_command(
    case: Annotated[Path, typer.Argument(help="Case folder of `limbgram reconstruct`.")],
    truth: Annotated[
        Path | None,
        typer.Option(help="True surface: a mesh file in mm, or a capture with its truth folder."),
    ] = None,
    align: Annotated[
        AlignBy,
        typer.Option(
            help="Lay the surface onto the truth by a rigid fit of the surface, of the camera "
            "places alone, or not at all (both in one frame)."
        ),
    ] = AlignBy.SURFACE,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Say how accurate a finished case is: one page, a PDF of two pages, and JSON.

    Reads what the case keeps and computes nothing again: residuals, rays and angles, known
    lengths, cameras, completeness, uncertainty, and what to do for a better result. Beside a truth
    the files are called accuracy-truth, and those without it stay.
    """
    folder = CaseFolder(case)
    with display(as_json) as screen:
        found = Run(listener=screen.listen)(assess_case, folder, truth, align.value)
    return Reply(accuracy_lines(folder, found), found.tree, found.light)


def accuracy_lines(case: CaseFolder, assessment: Assessment) -> tuple[str, ...]:
    """The assessment for people at a terminal."""
    found, truth = assessment.findings, assessment.figures.truth
    limiting = map(advised, found[:_SHOWN])
    more = [f"  and {len(found) - _SHOWN} more on the page"] if len(found) > _SHOWN else []
    return (
        spoken(assessment.headline),
        *(() if truth is None else _truth_lines(truth)),
        *(("What limits it:", *limiting, *more) if found else ()),
        f"Look at it: {case.accuracy('html', against_truth=truth is not None)}",
        f"To print or file: {case.accuracy('pdf', against_truth=truth is not None)}",
    )


def _truth_lines(truth: TruthFigures) -> tuple[str, ...]:
    girths = ", ".join(f"{one.error_mm:+z.2f} at {one.height_mm:.1f}" for one in truth.girths)
    sigma = truth.sigma
    return (
        f"Against {truth.kind} ({truth.alignment}):",
        f"  surface   RMS {truth.rms_mm:.4f} mm ({truth.rms_px:.3f} px), 95 % within "
        f"{truth.p95_mm:.4f} mm, mean {truth.mean_mm:+z.4f} mm",
        f"  within    0.1 mm {truth.within['0.1 mm']:.2%}, 0.25 mm "
        f"{truth.within['0.25 mm']:.2%} of the measured surface",
        f"  covered   0.1 mm {truth.covered['0.1 mm']:.2%}, 0.25 mm "
        f"{truth.covered['0.25 mm']:.2%} of the visible truth",
        f"  scale     {truth.scale_error:+z.4%}; volume {truth.volume_error:+z.3%}",
        f"  girths    {girths} mm of height in the truth",
        *(
            ()
            if sigma is None
            else (
                f"  sigma     robust spread of error / sigma {sigma.robust_spread:.2f}, "
                f"{sigma.within_95_share:.1%} inside the 95 % interval",
            )
        ),
    )
