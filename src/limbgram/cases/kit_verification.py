"""Kit verification: the acceptance certificate, from finished cases of a calibrated artefact."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

from limbgram.capture.acceptance import MeasuredCapture, accept
from limbgram.capture.artefact import Artefact, read_artefact
from limbgram.capture.certificate import (
    USUAL_MONTHS,
    ArtefactTested,
    CameraTested,
    CaptureTested,
    Certificate,
)
from limbgram.capture.permissible_errors import Limits, parse_limits
from limbgram.capture.probing import surface_of
from limbgram.cases.case_assessment import kept_evidence, stickers_in
from limbgram.cases.case_record import read_record
from limbgram.cases.certificates import (
    cameras_of,
    certificate_beside,
    require_certificate_place,
    write_certificate,
)
from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.folder import CaseFolder
from limbgram.cases.job_messages import Job
from limbgram.core.errors import Cancelled, CaseError, LimbgramError, OptionsError
from limbgram.core.files import write_bytes
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.request_fields import Text, Within
from limbgram.core.run import Run, track
from limbgram.formats.camera import read_camera
from limbgram.formats.reading import read_limb
from limbgram.reconstruction.scale.metric import Scale
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.user_settings import Choices
from limbgram.report.acceptance import acceptance_report
from limbgram.report.accuracy.assessment import assess
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.html import html_of
from limbgram.report.parts import part_file
from limbgram.report.pdf import pdf_of
from limbgram.services.parse_capture import DEFAULT_BOARD, parse_board

_ID_DIGITS = 8


@dataclass(frozen=True, kw_only=True)
class VerifyRequest:
    """By which errors a kit is judged, and what it is."""

    mpe: tuple[str, ...]
    """Permissible error, mm: 0.3 for all, or of one kind, such as length=0.05+L/1000. Kinds: form,
    form-all, size, spacing, length, surface."""
    camera: Path | None = None
    """Camera file of the kit. The certificate is kept beside it, and every report made with it
    cites it."""
    board: Annotated[Board | None, Text(lambda text, _at: parse_board(text))] = None
    """Scale board in the photos, or its board file; without it charuco:7x5:30:22:4X4_50."""
    cases: Path | None = None
    """Folder for the cases of photos that are reconstructed here; without it beside the
    certificate."""
    valid_months: Annotated[int, Within(1, 120)] = USUAL_MONTHS
    """After how long reports ask for a new test."""


@dataclass(frozen=True, kw_only=True)
class SetupTest:
    """The acceptance test of a kit: its files are read, and its certificate has a place."""

    ask: VerifyRequest
    artefact: Artefact
    limits: Limits
    path: Path
    """Of the certificate."""
    camera: CameraTested | None

    @classmethod
    def of(cls, artefact: Path, ask: VerifyRequest, out: Path | None = None) -> "SetupTest":
        """Read what the test needs.

        Args:
            out: The certificate; None: beside the camera file.

        Raises:
            OptionsError: a file or a limit is none, or the certificate has no place.
            CaseError: another file lies at its place.
        """
        known, limits = read_artefact(artefact), parse_limits(ask.mpe)
        path = _certificate_path(ask.camera, out)
        require_certificate_place(path)
        tested = None
        if ask.camera is not None:
            label = read_camera(ask.camera).label
            tested = CameraTested(label=label, sha256=file_sha256(ask.camera))
        return cls(ask=ask, artefact=known, limits=limits, path=path, camera=tested)

    def finished(self, captures: Sequence[Path], do: Callable[[Job], object]) -> list[CaseFolder]:
        """The captures as finished cases; photos are reconstructed.

        Raises:
            LimbgramError: a capture gave no surface.
        """
        stem = self.path.name.removesuffix(".json")
        folder = self.ask.cases or self.path.with_name(f"{stem}-cases")
        return [
            self._finished(one, folder / f"capture-{number}", do)
            for number, one in enumerate(captures, 1)
        ]

    def certified(self, cases: Sequence[CaseFolder], run: Run, today: date) -> "Certified":
        """The certificate of the kit by these cases, its page and its PDF."""
        certificate = run(
            verify_kit,
            self.artefact,
            cases,
            self.limits,
            today=today,
            valid_months=self.ask.valid_months,
            camera=self.camera,
        )
        report = acceptance_report(certificate)
        write_certificate(self.path, certificate)
        stem = self.path.name.removesuffix(".json")
        page, sheet = self.path.with_name(f"{stem}.html"), self.path.with_name(f"{stem}.pdf")
        write_bytes(page, html_of(report).encode())
        write_bytes(sheet, pdf_of(report))
        return Certified(certificate=certificate, path=self.path, page=page, sheet=sheet)

    def _finished(self, capture: Path, case: Path, do: Callable[[Job], object]) -> CaseFolder:
        """The capture, if it is a finished case, or the case that a job makes of its photos."""
        if (capture / "case.json").is_file():
            return CaseFolder(capture)
        job = Job(
            case=case,
            sources=(capture,),
            camera_files=() if self.ask.camera is None else (self.ask.camera,),
            board=self.ask.board or parse_board(DEFAULT_BOARD),
            choices=Choices(gap_mm=self.artefact.gap_mm),
        )
        try:
            do(job)
        except Cancelled:
            raise
        except LimbgramError as error:
            raise type(error)(f"The capture {capture} gave no surface. {error}") from error
        return CaseFolder(job.case)


@dataclass(frozen=True, kw_only=True)
class Certified:
    """A certificate, and where it was written."""

    certificate: Certificate
    path: Path
    page: Path
    sheet: Path
    """For printing."""


def verify_kit(
    artefact: Artefact,
    cases: Sequence[CaseFolder],
    limits: Limits,
    *,
    today: date,
    valid_months: int,
    camera: CameraTested | None = None,
) -> Certificate:
    """Test a kit by the finished cases of an artefact.

    Args:
        camera: The camera file that the certificate is for; all cases must have been made with it.
            None: that of the cases.

    Raises:
        CaseError: a case is not finished or not what it was, or the cases are of several kits.
        OptionsError: no permissible error is for anything on the artefact.
        MeasureError: nothing of it was measured.
    """
    cameras = _one_kit(cases, camera)
    tested = [
        _capture(case, f"capture {number + 1}", artefact)
        for number, case in enumerate(track(cases))
    ]
    _require_several(tested)
    calibrated = None if artefact.mesh is None else read_limb(artefact.mesh.file).mesh
    return Certificate(
        program=f"limbgram {version('limbgram')}",
        made=today.isoformat(),
        valid_months=valid_months,
        cameras=cameras,
        artefact=ArtefactTested(
            name=artefact.name,
            certificate=artefact.certificate,
            calibrated=artefact.calibrated,
            sha256=artefact.sha256,
        ),
        captures=tuple(
            CaptureTested(
                name=one.name, id=one.id, photos=one.photos, light=one.light, scale=one.scale
            )
            for one in tested
        ),
        acceptance=accept(artefact, tested, limits, calibrated),
    )


def _certificate_path(camera: Path | None, out: Path | None) -> Path:
    if out is not None:
        return out
    if camera is None:
        raise OptionsError("options.certificate_place")
    return certificate_beside(camera)


def _one_kit(cases: Sequence[CaseFolder], camera: CameraTested | None) -> tuple[CameraTested, ...]:
    kits = [cameras_of(case) for case in cases]
    for case, kit in zip(cases, kits, strict=True):
        if {one.sha256 for one in kit} != {one.sha256 for one in kits[0]}:
            raise CaseError(
                "case.certificate.other_camera", one=str(case.root), two=str(cases[0].root)
            )
        if camera is not None and camera.sha256 not in {one.sha256 for one in kit}:
            raise CaseError("case.certificate.not_this_camera", case=str(case.root))
    return kits[0]


def _require_several(tested: Sequence[MeasuredCapture]) -> None:
    ids = [one.id for one in tested]
    if len(set(ids)) < len(ids):
        raise OptionsError("case.certificate.same_photos")


def _capture(case: CaseFolder, name: str, artefact: Artefact) -> MeasuredCapture:
    evidence = kept_evidence(case)
    scale = evidence.metric.scale
    if scale.unit != "mm":
        raise CaseError("case.certificate.without_scale", case=str(case.root))
    meshes = (evidence.mesh, *_others(case))
    return MeasuredCapture(
        name=name,
        id=evidence.photos.digest[:_ID_DIGITS],
        photos=len(evidence.photos.photos),
        light=assess(evidence).light,
        scale=_in_words(scale),
        meshes=meshes,
        surface=surface_of(meshes),
        marks_mm=_marks(evidence) if artefact.between_marks else {},
        gave_scale=tuple(_pairs_that_scaled(scale)),
    )


def _others(case: CaseFolder) -> Iterator[Mesh]:
    """The other bodies as they were delivered: spheres on separate feet, say."""
    delivered = {file.sha256 for file in read_record(case).files}
    for path in sorted(case.deliverables.glob(part_file("*", "ply"))):
        if file_sha256(path) not in delivered:
            raise CaseError("case.file_altered", path=str(path))
        yield read_limb(path).mesh


def _marks(evidence: Evidence) -> dict[int, Vector3]:
    return {one.mark_id: one.position_mm for one in stickers_in(evidence).placed}


def _pairs_that_scaled(scale: Scale) -> Iterator[frozenset[int]]:
    for length in scale.lengths:
        if length.role == "control" and length.marks:
            yield frozenset(length.marks)


def _in_words(scale: Scale) -> str:
    control = sum(one.role == "control" for one in scale.lengths)
    source = "the scale board" if scale.source == "board" else f"{control} known lengths"
    return f"{source}, sure to {scale.relative_sigma:.3%} (one sigma)"
