"""Verifying a kit: the acceptance certificate, from finished cases of a calibrated artefact."""

from collections.abc import Iterator, Sequence
from datetime import date
from importlib.metadata import version

from limbgram.capture.acceptance import MeasuredCapture, accept
from limbgram.capture.artefact import Artefact
from limbgram.capture.certificate import (
    ArtefactTested,
    CameraTested,
    CaptureTested,
    Certificate,
)
from limbgram.capture.permissible import Limits
from limbgram.capture.probing import surface_of
from limbgram.cases.assessing import kept_evidence, require_unaltered
from limbgram.cases.certificates import cameras_of
from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.folder import CaseFolder
from limbgram.cases.record import read_record
from limbgram.core.errors import CaseError, OptionsError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.run import track
from limbgram.formats.reading import read_limb
from limbgram.reconstruction.scale.marks import marks_of_label
from limbgram.reconstruction.scale.metric import Scale
from limbgram.report.accuracy.assessment import assess
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.parts import part_file
from limbgram.workbench.marks.stickers import find_stickers

_ID_DIGITS = 8


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
    scene = evidence.metric.scene
    photos = [evidence.photos.photos[idx] for idx in scene.placed]
    require_unaltered(photos)
    placed = find_stickers(photos, scene.views).placed
    return {one.mark_id: one.position_mm for one in placed}


def _pairs_that_scaled(scale: Scale) -> Iterator[frozenset[int]]:
    for length in scale.lengths:
        marks = marks_of_label(length.label)
        if length.role == "control" and marks is not None:
            yield marks


def _in_words(scale: Scale) -> str:
    control = sum(one.role == "control" for one in scale.lengths)
    source = "the scale board" if scale.source == "board" else f"{control} known lengths"
    return f"{source}, sure to {scale.relative_sigma:.3%} (one sigma)"
