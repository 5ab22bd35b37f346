"""Case assessment: the accuracy report of a finished case, by itself or against a truth.

In      a finished case, unchanged since: case.json has the keys of its products, which are checked
        by hash, as are the photos. A truth is the truth folder of a capture, or any mesh file.
        Nothing is computed again.
Out     CASE/accuracy.json, accuracy.html and accuracy.pdf; compared with a truth accuracy-truth.*,
        so that the case's own verdict, which others cite, stays as it is. Also the case as a source
        that records cite, and the painted marks of its photos on its surface.
Fails   CaseError: no finished case, or changed since; OptionsError: the truth or the shape does not
        belong to it.
"""

import math
from collections.abc import Iterable
from dataclasses import replace
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from jaxtyping import Float64
from scipy.spatial import KDTree

from limbgram.cases.accuracy import write_accuracy
from limbgram.cases.case_record import CaseRecord, StageEntry, read_record
from limbgram.cases.certificates import cited_setups
from limbgram.cases.encoding import unsealed
from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.folder import CaseFolder, locked
from limbgram.cases.scoring import LEAST_PHOTOS, centres_mm, read_truth_mesh
from limbgram.cases.stage_cache import read_product
from limbgram.core.errors import CaseError, MeasureError, OptionsError
from limbgram.core.files import json_of, read_content, written_whole
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.tree_cache import signed_on
from limbgram.core.typed import TOLERANT, Mismatch, value_of
from limbgram.formats.reading import read_limb
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.lens_groups import ByLens
from limbgram.reconstruction.photos.photo import Photo, PhotoSet, digest_of
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.taped_girths import TapeWitnesses
from limbgram.reconstruction.targets.board import BoardDetections
from limbgram.report.accuracy.assessment import READ_SCHEMAS, Assessment, assess
from limbgram.report.accuracy.charts import accuracy_pictures
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.layout import accuracy_report
from limbgram.report.accuracy.truth import FEWEST_CAMERAS, Alignment, KnownTruth
from limbgram.report.alignment import Truth
from limbgram.report.pdf import pdf_of
from limbgram.report.record.sources import CaseAccuracy, CaseSource
from limbgram.workbench.marks.finding import PaintedMarks, find_painted_marks
from limbgram.workbench.marks.stickers import PlacedStickers, find_stickers

T = TypeVar("T")


def kept_evidence(case: CaseFolder) -> Evidence:
    """The evidence that a finished case keeps.

    Raises:
        CaseError: the folder is no finished case, or its products are not those it was
            finished with.
    """
    record = _finished(case)
    kept = _kept_stages(record)
    # where object and surroundings moved apart, the board counts only where it kept its place
    boards = ("still_board", "board_of_object", "find_board")
    board = next((one for one in boards if one in kept), "find_board")
    metric = _read(case, kept, "to_millimetres", MetricScene)
    given = "without_files" if "without_files" in kept else "cameras_for"
    photos, cameras = _read(case, kept, "read_photos", PhotoSet), _read(case, kept, given, Cameras)
    split = len(metric.scene.cameras) != len(cameras.calibrations)  # two lenses were found
    if split or "by_cut" in kept:
        lenses = _read(case, kept, "by_lens" if split else "by_cut", ByLens)
        photos, cameras = lenses.photos, lenses.cameras
    return Evidence(
        photos=replace(photos, set_aside=record.set_aside),
        cameras=cameras,
        detections=_read(case, kept, board, BoardDetections) if board in kept else None,
        metric=metric,
        mesh=_read(case, kept, "measure", Mesh),
        tapes=_read(case, kept, "hold_tapes", TapeWitnesses)
        if "hold_tapes" in kept
        else TapeWitnesses(),
        setups=cited_setups(case, _day_of(record)),
    )


def _day_of(record: CaseRecord) -> date:
    """The day on which a case was computed, to which the age of its kit's test refers.

    So the verdict of an unchanged case stays the same. Today if the record has no day.
    """
    try:
        return datetime.fromisoformat(record.written).astimezone(UTC).date()
    except ValueError:
        return datetime.now(UTC).date()


def require_unaltered(photos: Iterable[Photo]) -> None:
    """Refuse photos whose files no longer hold what was reconstructed.

    Raises:
        CaseError: a photo is gone, or holds other bytes.
    """
    for photo in photos:
        try:
            same = file_sha256(photo.path) == photo.sha256
        except OSError:
            same = False
        if not same:
            raise CaseError("case.photo_altered", photo=str(photo.path))


def _unaltered_photos(evidence: Evidence) -> list[Photo]:
    """The placed photos, whose files still hold what was reconstructed.

    Raises:
        CaseError: a photo is gone, or holds other bytes.
    """
    photos = [evidence.photos.photos[idx] for idx in evidence.metric.scene.placed]
    require_unaltered(photos)
    return photos


def _finished(case: CaseFolder) -> CaseRecord:
    """The record of a finished case."""
    try:
        record = read_record(case)
    except LookupError as error:
        raise CaseError("case.none", folder=str(case.root)) from error
    if record.state != "finished":
        raise CaseError("case.not_finished", case=str(case.root), state=record.state)
    return record


_STAGES_BEFORE_PLACING = ("read_photos", "cameras_for", "find_board")


def _kept_stages(record: CaseRecord) -> dict[str, StageEntry]:
    """The first valid run of each stage, by the stage's name.

    Where photos were placed again without a camera file, the runs with it are not valid.
    """
    runs = list(record.stages)
    again = next((k for k, one in enumerate(runs) if one.stage == "without_files"), 0)
    counted = [one for one in runs[:again] if one.stage in _STAGES_BEFORE_PLACING] + runs[again:]
    return {one.stage.split("-")[0]: one for one in reversed(counted)}


def _read(case: CaseFolder, kept: dict[str, StageEntry], stage: str, hint: type[T]) -> T:
    entry = kept[stage]
    folder = case.stages / entry.stage
    try:
        product, _ = read_product(folder, entry.key, hint, case.root)
    except LookupError as error:
        raise CaseError("case.stage_altered", folder=str(folder)) from error
    return cast(T, product)


_LARGEST_BYTES = 4_000_000


def read_truth(path: Path, evidence: Evidence, alignment: Alignment) -> KnownTruth:
    """The truth at `path`: a capture's folder, its truth folder, or a mesh file in mm.

    Raises:
        MeasureError: the case has no scale.
        CaseError: there is no truth at this path.
        OptionsError: cameras are to be aligned, and the truth has none of ours.
    """
    if evidence.metric.scale.unit != "mm":
        raise MeasureError("case.truth_without_scale")
    folder = next((one for one in (path / "truth", path) if (one / "mesh.ply").is_file()), None)
    if folder is not None:
        known = _capture_truth(folder, evidence, alignment)
    elif path.is_file():
        known = _mesh_truth(path, alignment)
    else:
        raise CaseError("case.no_truth", path=str(path))
    if alignment == "cameras" and len(known.centres_mm) < FEWEST_CAMERAS:
        raise OptionsError("case.truth_without_places", path=str(path))
    return known


def _capture_truth(folder: Path, evidence: Evidence, alignment: Alignment) -> KnownTruth:
    vertices, faces = read_truth_mesh(folder / "mesh.ply")
    ours = {view.name: view.centre_in_world for view in evidence.metric.scene.views}
    true = centres_mm(folder / "cameras.json")
    shared = sorted(ours.keys() & true.keys())
    truth = Truth(
        vertices_mm=vertices["xyz"].astype(float),
        faces=faces,
        seen=(vertices["ncam"] >= LEAST_PHOTOS)
        & (vertices["cap"] == 0)
        & (vertices["xyz"][:, 2] >= _lowest_mm(folder / "notes.json")),
        centres_mm=_stack([true[name] for name in shared]),
    )
    return KnownTruth(
        kind="the truth of a capture",
        truth=truth,
        centres_mm=_stack([ours[name] for name in shared]),
        alignment=alignment,
    )


def _lowest_mm(notes: Path) -> float:
    """Height below which the truth excludes its surface: the rim of the cut."""
    if not notes.is_file():
        return -math.inf
    try:
        region: Any = json_of(read_content(notes, _LARGEST_BYTES, CaseError)).get("roi", {})
        return float(region.get("z_min", -math.inf))
    except (ValueError, TypeError, AttributeError) as error:
        raise CaseError("case.truth_unclear", path=str(notes), why=str(error)) from error


def _mesh_truth(path: Path, alignment: Alignment) -> KnownTruth:
    mesh = read_limb(path).mesh
    truth = Truth(
        vertices_mm=mesh.vertices_mm,
        faces=mesh.faces,
        seen=np.ones(len(mesh), bool),
        centres_mm=_stack([]),
    )
    return KnownTruth(kind="a mesh file", truth=truth, centres_mm=_stack([]), alignment=alignment)


def _stack(points: list[Float64[np.ndarray, "3"]]) -> Points3:
    return np.array(points, float).reshape(-1, 3)


def assess_case(case: CaseFolder, truth: Path | None, alignment: Alignment) -> Assessment:
    """Assess a finished case from its products, and write page, PDF and JSON into it.

    Compared with a truth they have names of their own, and the case's own report stays.

    Raises:
        CaseError: it is no finished case, its products cannot be read, or the truth cannot.
    """
    evidence = kept_evidence(case)
    known = None if truth is None else read_truth(truth, evidence, alignment)
    assessment = assess(evidence, known)
    pictures = accuracy_pictures(evidence, assessment)
    with locked(case):
        write_accuracy(case, assessment, pictures)
        with written_whole(case.accuracy("pdf", against_truth=known is not None)) as beside:
            beside.write_bytes(pdf_of(accuracy_report(assessment, pictures)))
    return assessment


def cited(case: CaseFolder) -> CaseSource:
    """The case's accuracy and the hashes of what it delivered.

    Raises:
        CaseError: the folder is no case with an accuracy.json in millimetres.
    """
    try:
        accuracy: dict[str, Any] = json_of(case.accuracy("json").read_bytes())
        record = read_record(case)
        files = frozenset(file.sha256 for file in record.files)
        schema, unit, truth = accuracy["schema"], accuracy["unit"], accuracy["truth"]
        hash_of_photos = digest_of(photo.sha256 for photo in record.photos)
    except (OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        raise CaseError("case.without_accuracy", case=str(case.root)) from error
    if schema not in READ_SCHEMAS:
        raise CaseError("case.accuracy_of_other_version", case=str(case.root), version=schema)
    try:
        said = value_of(unsealed(accuracy), CaseAccuracy, strictness=TOLERANT)
    except (LookupError, Mismatch) as error:
        raise CaseError("case.accuracy_altered", case=str(case.root)) from error
    if truth is not None:
        raise CaseError("case.accuracy_of_truth", case=str(case.root))
    if unit != "mm":
        raise CaseError("case.without_scale", case=str(case.root))
    return CaseSource(sha256=hash_of_photos, accuracy=said, files=files)


_MOST_COMPARED = 2000
_SAME_VERTEX_MM = 0.01
"""Files have coordinates in single precision, or with six decimals."""
_LEAST_SAME = 0.5
"""Share of the vertices that must be the case's own; the others may have been edited."""
_EVEN_MM = 0.15
"""Largest spread of the distances of a surface that was only decimated or offset."""
_EVEN_SHARE = 0.95
_THICKEST_SOCK_MM = 8.0


def painted_marks_of(
    case: CaseFolder, shape: Mesh, colour: tuple[int, int, int] | None
) -> PaintedMarks:
    """The marks that a case's photos show, in the frame of a shape made from this case.

    Args:
        colour: sRGB of the marks; None: any colour that the rest of the paint does not have.

    Raises:
        CaseError: it is no finished case, or its products or photos are not what they were.
        OptionsError: the shape is not the case's surface as it lies there; a grey colour.
    """
    kept = kept_evidence(case)
    _require_same_place(case, shape, kept.mesh)
    photos = _unaltered_photos(kept)
    return find_painted_marks(photos, kept.metric.scene.views, kept.mesh, colour)


def stickers_of(case: CaseFolder, shape: Mesh) -> PlacedStickers:
    """The coded stickers that a case's photos show, in the frame of a shape made from this case.

    Raises:
        CaseError: it is no finished case, or its products or photos are not what they were.
        OptionsError: the shape is not the case's surface as it lies there.
    """
    kept = kept_evidence(case)
    _require_same_place(case, shape, kept.mesh)
    return stickers_in(kept)


def stickers_in(evidence: Evidence) -> PlacedStickers:
    """The coded stickers that a case's photos show.

    Raises:
        CaseError: a photo is gone, or holds other bytes.
    """
    return find_stickers(_unaltered_photos(evidence), evidence.metric.scene.views)


def _require_same_place(case: CaseFolder, shape: Mesh, kept: Mesh) -> None:
    """Refuse a shape unless half of its vertices are the case's, or it is an offset of its surface.

    Mere nearness proves nothing: a limb that is turned about its axis is near, too.
    """
    compared = shape.vertices_mm[:: max(1, len(shape) // _MOST_COMPARED)]
    own = KDTree(kept.vertices_mm).query(compared)[0] <= _SAME_VERTEX_MM
    if own.mean() >= _LEAST_SAME:
        return
    over_mm = signed_on(kept).query(compared).signed_mm
    middle_mm = float(np.median(over_mm))
    uneven_mm = float(np.quantile(np.abs(over_mm - middle_mm), _EVEN_SHARE))
    if abs(middle_mm) <= _THICKEST_SOCK_MM and uneven_mm <= _EVEN_MM:
        return
    raise OptionsError(
        "case.other_shape",
        photos=str(case.root),
        middle_mm=abs(middle_mm),
        uneven_mm=uneven_mm,
        surface=str(case.deliverables / "surface.ply"),
    )
