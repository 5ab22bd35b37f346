"""`limbgram verify-setup`: a clinic proves its own kit on a calibrated artefact."""

from datetime import date
from pathlib import Path
from typing import Annotated

import typer

from limbgram.capture.artefact import read_artefact
from limbgram.capture.certificate import USUAL_MONTHS, CameraTested, Certificate
from limbgram.capture.permissible import parse_limits
from limbgram.capture.setup import Outcome
from limbgram.cases.certificates import (
    SUFFIX,
    certificate_beside,
    require_certificate_place,
    write_certificate,
)
from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.folder import CaseFolder
from limbgram.cases.order import Job
from limbgram.cases.verifying import verify_kit
from limbgram.cli.captures import DEFAULT_BOARD, parse_board
from limbgram.cli.progress import display
from limbgram.cli.reconstruct import run_job
from limbgram.cli.replies import Reply, answered
from limbgram.core.errors import (
    RED_EXIT_CODE,
    UNDECIDED_EXIT_CODE,
    Cancelled,
    LimbgramError,
    OptionsError,
)
from limbgram.core.files import write_bytes
from limbgram.core.run import Run
from limbgram.core.typed import tree_of
from limbgram.formats.camera import read_camera
from limbgram.reconstruction.choices import Choices
from limbgram.report.acceptance import COLOURS, acceptance_lines, acceptance_report
from limbgram.report.html import html_of
from limbgram.report.pdf import pdf_of

_EXIT_CODES: dict[Outcome, int] = {
    "pass": 0,
    "fail": RED_EXIT_CODE,
    "cannot tell": UNDECIDED_EXIT_CODE,
}


@answered
def verify_setup_command(
    artefact: Annotated[
        Path, typer.Argument(help="Artefact file (TOML or JSON): its calibrated values.")
    ],
    captures: Annotated[
        list[Path],
        typer.Argument(
            help="Captures of it: folders of photos, or finished cases of `limbgram reconstruct`. "
            "Several are repeats: walk round it anew, the artefact in another place each time."
        ),
    ],
    mpe: Annotated[
        list[str],
        typer.Option(
            help="Permissible error, mm: 0.3 for all, or of one kind, such as "
            "length=0.05+L/1000. Kinds: form, form-all, size, spacing, length, surface. Repeat it.",
        ),
    ],
    camera: Annotated[
        Path | None,
        typer.Option(
            help="Camera file of the kit. The certificate is kept beside it, and every report made "
            "with it cites it."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            help="Certificate to write; .html and .pdf lie beside it.",
            show_default=f"CAMERA{SUFFIX} beside the camera file",
        ),
    ] = None,
    board: Annotated[
        str | None,
        typer.Option(
            help="Scale board in the photos, or its board file.", show_default=DEFAULT_BOARD
        ),
    ] = None,
    cases: Annotated[
        Path | None,
        typer.Option(
            help="Folder for the cases of photos that are reconstructed here.",
            show_default="beside the certificate",
        ),
    ] = None,
    valid_months: Annotated[
        int, typer.Option(min=1, max=120, help="After how long reports ask for a new test.")
    ] = USUAL_MONTHS,
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
    known, limits = read_artefact(artefact), parse_limits(mpe)
    path = _certificate_path(camera, out)
    require_certificate_place(path)
    tested = None
    if camera is not None:
        tested = CameraTested(label=read_camera(camera).label, sha256=file_sha256(camera))
    folder = cases or path.with_name(f"{path.name.removesuffix('.json')}-cases")
    finished = [
        _finished(
            one,
            Job(
                case=folder / f"capture-{number + 1}",
                sources=(one,),
                camera_files=() if camera is None else (camera,),
                board=parse_board(board or DEFAULT_BOARD),
                choices=Choices(gap_mm=known.gap_mm),
            ),
            as_json,
        )
        for number, one in enumerate(captures)
    ]
    with display(as_json) as screen:
        certificate = Run(listener=screen.listen)(
            verify_kit,
            known,
            finished,
            limits,
            today=date.today(),
            valid_months=valid_months,
            camera=tested,
        )
    written = _write(path, certificate)
    outcome = certificate.acceptance.outcome
    light = COLOURS[outcome]
    return Reply(
        (*acceptance_lines(certificate.acceptance), *_ways(written, camera)),
        {**tree_of(certificate), "written": [str(one) for one in written]},
        light if light != "blue" else "",
        exit_code=_EXIT_CODES[outcome],
    )


def _certificate_path(camera: Path | None, out: Path | None) -> Path:
    if out is not None:
        return out
    if camera is None:
        raise OptionsError("options.certificate_place")
    return certificate_beside(camera)


def _finished(capture: Path, job: Job, as_json: bool) -> CaseFolder:
    """The capture, if it is a finished case, or the case that the job makes of its photos."""
    if (capture / "case.json").is_file():
        return CaseFolder(capture)
    try:
        run_job(job, as_json)
    except Cancelled:
        raise
    except LimbgramError as error:
        raise type(error)(f"The capture {capture} gave no surface. {error}") from error
    return CaseFolder(job.case)


def _write(path: Path, certificate: Certificate) -> tuple[Path, Path, Path]:
    """The certificate, its page and its PDF."""
    report = acceptance_report(certificate)
    write_certificate(path, certificate)
    stem = path.name.removesuffix(".json")
    page, sheet = path.with_name(f"{stem}.html"), path.with_name(f"{stem}.pdf")
    write_bytes(page, html_of(report).encode())
    write_bytes(sheet, pdf_of(report))
    return path, page, sheet


def _ways(written: tuple[Path, Path, Path], camera: Path | None) -> tuple[str, ...]:
    path, page, sheet = written
    kept = camera is not None and path.resolve() == certificate_beside(camera).resolve()
    cited = (
        "every report made with this camera file cites it"
        if kept
        else f"reports cite the one that lies beside their camera file as CAMERA{SUFFIX}"
    )
    return (
        f"Certificate: {path} ({cited})",
        f"Look at it: {page}",
        f"To print or file: {sheet}",
    )
