"""`limbgram verify-setup`: a clinic proves its own kit on a calibrated artefact."""

from datetime import date
from pathlib import Path
from typing import Annotated

import typer

from limbgram.capture.setup import Outcome
from limbgram.cases.certificates import SUFFIX, certificate_beside
from limbgram.cases.kit_verification import Certified, SetupTest, VerifyRequest
from limbgram.cli.progress import display
from limbgram.cli.reconstruct import run_job
from limbgram.cli.replies import Reply, answered, language
from limbgram.cli.request_options import asking
from limbgram.core.errors import RED_EXIT_CODE, UNDECIDED_EXIT_CODE
from limbgram.core.run import Run
from limbgram.core.typed import tree_of
from limbgram.report.acceptance import COLOURS, acceptance_lines

_EXIT_CODES: dict[Outcome, int] = {
    "pass": 0,
    "fail": RED_EXIT_CODE,
    "cannot tell": UNDECIDED_EXIT_CODE,
}


Artefact = Annotated[
    Path, typer.Argument(help="Artefact file (TOML or JSON): its calibrated values.")
]
Captures = Annotated[
    list[Path],
    typer.Argument(
        help="Captures of it: folders of photos, or finished cases of `limbgram reconstruct`. "
        "Several are repeats: walk round it anew, the artefact in another place each time."
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--out",
        help="Certificate to write; .html and .pdf lie beside it.",
        show_default=f"CAMERA{SUFFIX} beside the camera file",
    ),
]


@answered
@asking
def verify_setup_command(
    artefact: Artefact,
    captures: Captures,
    ask: VerifyRequest,
    out: Out = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Prove your own kit: camera, board, room and hands, on an artefact of known size.

    Put a calibrated artefact where limbs stand, painted or dabbed with fine spots, and take it as
    you take a limb, with the same board. The size of spheres or of a cylinder, their form, the
    distance between spheres and between coded marks, or the distance from a calibrated mesh are
    compared with the calibration, in the manner of VDI/VDE 2634 Part 3 and ISO 10360-13.

    Each error passes or fails with the artefact's uncertainty counted (ISO 14253-1).

    **Exit codes**: 0 passed; 7 failed; 8 cannot tell, because an error lies nearer to its limit
    than the artefact is known, or something was not measured.

    **An artefact file**, lengths in mm, uncertainties expanded (k = 2) as certificates print them:

        format = "limbgram artefact"

        version = 1

        name = "Ball bar 12"

        certificate = "DAkkS 4711"

        spheres = [{name = "A", diameter_mm = 50.012, uncertainty_mm = 0.004},
        {name = "B", diameter_mm = 50.009, uncertainty_mm = 0.004}]

        lengths = [{first = "A", second = "B", length_mm = 150.004, uncertainty_mm = 0.006},
        {first = "mark 7", second = "mark 9", length_mm = 400.02, uncertainty_mm = 0.05}]

    or cylinder = {name = "C", diameter_mm = 100.003, uncertainty_mm = 0.004}, or
    mesh = {name = "Foot 3", file = "foot.stl", uncertainty_mm = 0.02}.
    """
    test = SetupTest.of(artefact, ask, out)
    cases = test.finished(captures, lambda job: run_job(job, as_json))
    with display(as_json) as screen:
        made = test.certified(cases, Run(listener=screen.listen), date.today())
    acceptance = made.certificate.acceptance
    light = COLOURS[acceptance.outcome]
    written = [str(made.path), str(made.page), str(made.sheet)]
    return Reply(
        (*acceptance_lines(acceptance, language()), *_ways(made, ask.camera)),
        {**tree_of(made.certificate), "written": written},
        light if light != "blue" else "",
        exit_code=_EXIT_CODES[acceptance.outcome],
    )


def _ways(made: Certified, camera: Path | None) -> tuple[str, ...]:
    kept = camera is not None and made.path.resolve() == certificate_beside(camera).resolve()
    cited = (
        "every report made with this camera file cites it"
        if kept
        else f"reports cite the one that lies beside their camera file as CAMERA{SUFFIX}"
    )
    return (
        f"Certificate: {made.path} ({cited})",
        f"Look at it: {made.page}",
        f"To print or file: {made.sheet}",
    )
