"""Capture figures: of its photos, of the limb's movement, and of the lengths that set its scale."""

import math

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from limbgram.core.errors import PhotoError
from limbgram.core.geometry.arrays import GreyImage
from limbgram.core.geometry.frames import Rigid
from limbgram.core.interval import rms
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import Z_AXIS
from limbgram.reconstruction.mapping.scene import Explanation, Scene
from limbgram.reconstruction.movement import (
    bending_found,
    in_report_unit,
    lens_doubt,
    moved_mm,
    moved_photos,
    movement_found,
    movement_remark,
)
from limbgram.reconstruction.photos.decoding import load_luma
from limbgram.reconstruction.photos.photo import Photo
from limbgram.reconstruction.photos.quality import remarks_by_photo
from limbgram.reconstruction.scale.metric import LengthCheck
from limbgram.reconstruction.scale.taped_girths import TapePlane, TapeWitness
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.figures import (
    BoardSeen,
    ExplanationFigures,
    ImageFigures,
    KnownLength,
    LengthFigures,
    MovementFigures,
    PhotoFigures,
    TapedLength,
    independent_checks,
)
from limbgram.report.image_scale import image_scales
from limbgram.workbench.measures.levels import Figure, Refused, Sigmas, levels_at, tape_mm

_NOISE_PHOTOS = 2
_NOISE_SIDE_PX = 1000
_FLAT_SHARE = 0.5
"""Part of the pixels, those with the least slope, in which noise is looked for."""
_MIDDLE_GREY = (20, 235)


def movement_figures(evidence: Evidence) -> MovementFigures | None:
    """Figures of movement; None in cases of older versions, which did not look for it."""
    scene = evidence.metric.scene
    movement = scene.movement
    if movement is None:
        return None
    known = movement.kind != "unknown"
    as_told, unit = in_report_unit(evidence.metric, evidence.mesh.vertices_mm)
    return MovementFigures(
        kind=movement.kind,
        found=movement_found(as_told.movement or movement, scene.names, unit),
        photos=moved_photos(movement, scene.names),
        alone=movement.alone,
        shift=moved_mm(movement),
        turn_deg=float(np.nanmax(movement.turn_deg)) if known else math.nan,
        misfit=movement.misfit,
        unexplained=_unexplained_movement(scene),
        explanations=tuple(
            _explanation_figures(one, scene.names)
            for seen in (
                movement.explanations,
                () if scene.bending is None else scene.bending.explanations,
                scene.lens_explanations,
            )
            for one in seen
        ),
        chance=movement.chance if known or movement.misfit else math.nan,
        bent=None
        if as_told.bending is None
        else bending_found(as_told.bending, scene.names, unit, lens_doubt(scene, evidence.cameras)),
        bending_misfit=scene.bending is not None and scene.bending.misfit,
        bending=moved_mm(scene.bending),
    )


def _unexplained_movement(scene: Scene) -> bool:
    """Surroundings do not matter where the limb's points alone place the photos."""
    movement, bending = scene.movement, scene.bending
    by_room = movement is not None and bool(movement.undecided) and not movement.alone
    return by_room or (bending is not None and bool(bending.undecided))


def _explanation_figures(one: Explanation, names: tuple[str, ...]) -> ExplanationFigures:
    return ExplanationFigures(
        bodies=one.bodies,
        kind=one.kind,
        photos=tuple(names[k] for k in one.photos),
        told=one.is_fact,
        matters=one.high >= one.floor,
        failed=one.failed,
        score=one.score,
        chance=one.chance,
        effect=one.effect,
        low=one.low,
        high=one.high,
        is_share=one.is_share,
        variance_before=one.variance_before,
        variance_after=one.variance_after,
    )


def image_figures(evidence: Evidence) -> ImageFigures:
    """Figures of image quality; the noise is NaN where the photos' files are gone."""
    scene, photos = evidence.metric.scene, evidence.photos
    as_told, unit = in_report_unit(evidence.metric, evidence.mesh.vertices_mm)
    scales = {one.name: one for one in image_scales(photos, evidence.metric)}
    said = remarks_by_photo(photos)
    rows: list[PhotoFigures] = []
    stated: list[float] = []
    in_mm = evidence.metric.scale.unit == "mm"
    for number, (photo, verdict) in enumerate(zip(photos.photos, scene.verdicts, strict=True)):
        scale = scales.get(photo.name)
        if scale is not None and in_mm and photo.exif.subject_m is not None:
            stated.append(scale.distance_mm / (1000 * photo.exif.subject_m))
        rows.append(
            PhotoFigures(
                name=photo.name,
                placed=verdict.placed,
                reason=verdict.reason,
                remarks=(
                    *said.get(photo.name, ()),
                    *([verdict.remark] if verdict.remark else []),
                    *movement_remark(as_told, number, unit),
                ),
                zoomed=verdict.remark is not None,
                points=verdict.points,
                edge_width_px=photo.sharpness,
                burnt_share=photo.burnt,
                distance=math.nan if scale is None else scale.distance_mm,
                pixel=math.nan if scale is None else scale.pixel_mm,
            )
        )
    return ImageFigures(
        photos=len(rows),
        placed=sum(row.placed for row in rows),
        set_aside=(*photos.set_aside, *evidence.metric.scale.set_aside),
        pixel=_median([row.pixel for row in rows]),
        distance=_median([row.distance for row in rows]),
        distance_over_stated=_median(stated),
        edge_width_px=_median([row.edge_width_px for row in rows]),
        noise_grey=_median_noise(evidence),
        by_photo=tuple(rows),
    )


def noise_grey(luma: GreyImage) -> float:
    """Standard deviation of a pixel in plain parts of the picture, grey levels of 256.

    The kernel of Immerkaer (1996) answers to noise and not to planes or edges; it is asked in the
    plainer half of the pixels. JPEG has smoothed away part of the noise before.
    """
    top, left = (max(0, (side - _NOISE_SIDE_PX) // 2) for side in luma.shape)
    grey = luma[top : top + _NOISE_SIDE_PX, left : left + _NOISE_SIDE_PX].astype(np.float32)
    kernel = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32)
    answer = np.abs(cv2.filter2D(grey, cv2.CV_32F, kernel))
    smooth = cv2.GaussianBlur(grey, (0, 0), 3.0)
    slope = np.hypot(
        cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=1), cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=1)
    )
    lit = (smooth > _MIDDLE_GREY[0]) & (smooth < _MIDDLE_GREY[1])
    if lit.sum() < 100:
        return math.nan
    plain = lit & (slope <= np.quantile(slope[lit], _FLAT_SHARE))
    return float(answer[plain].mean()) * np.sqrt(np.pi / 2) / 6.0


def _median_noise(evidence: Evidence) -> float:
    """Median noise of a few photos spread over the capture."""
    placed = [evidence.photos.photos[k] for k in evidence.metric.scene.placed]
    step = max(1, len(placed) // _NOISE_PHOTOS)
    return _median([_photo_figures(photo) for photo in placed[::step][:_NOISE_PHOTOS]])


def _photo_figures(photo: Photo) -> float:
    try:
        return noise_grey(load_luma(photo))
    except PhotoError:
        return math.nan


def _median(values: list[float]) -> float:
    known = [value for value in values if np.isfinite(value)]
    return float(np.median(known)) if known else math.nan


def length_figures(evidence: Evidence) -> LengthFigures:
    """The scale, its control and check lengths apart, and the board's observed corners."""
    scale = evidence.metric.scale
    checks = [one for one in scale.lengths if one.role == "check"]
    controls = [one for one in scale.lengths if one.role == "control"]
    control, check = tuple(map(_known_length, controls)), tuple(map(_known_length, checks))
    return LengthFigures(
        unit=scale.unit,
        source=scale.source,
        relative_sigma=scale.relative_sigma,
        board_stretch=scale.board_stretch,
        stretch_doubt=scale.stretch_doubt,
        control=control,
        check=check,
        control_rms=_relative_rms(controls),
        check_rms=_relative_rms(checks),
        check_worst=max((abs(one.error) for one in checks), default=math.nan),
        check_worst_label=max(checks, key=lambda one: abs(one.error)).label if checks else "",
        checked_by_another_piece=bool(independent_checks(control, check)),
        tapes=tuple(_taped_length(one, evidence.mesh) for one in evidence.tapes.found)
        if scale.unit == "mm"
        else (),
        board=_board_seen(evidence),
    )


def _known_length(one: LengthCheck) -> KnownLength:
    return KnownLength(
        label=one.label,
        between=one.between,
        known_mm=one.known_mm,
        measured_mm=one.measured_mm,
        error_mm=one.measured_mm - one.known_mm,
        error=one.error,
        sigma_mm=one.sigma_mm,
    )


def _taped_length(one: TapeWitness, mesh: Mesh) -> TapedLength:
    girth = Figure(one.measured_mm, None)
    if one.plane is not None:
        girth = _girth(mesh, one.plane) or girth
    off_mm = girth.value - one.taped.girth_mm
    return TapedLength(
        place=one.taped.place,
        height_mm=one.taped.height_mm,
        read_mm=one.taped.girth_mm,
        measured_mm=girth.value,
        error_mm=off_mm,
        error=off_mm / one.taped.girth_mm,
        sigma_mm=math.hypot(one.sigma_mm, girth.sigma or 0.0),
        reason=one.reason,
    )


def _girth(mesh: Mesh, plane: TapePlane) -> Figure | None:
    """The surface's girth there, as a measuring table has it; None where it has none."""
    axis = plane.axis
    upright = Rotation.align_vectors(Z_AXIS[None], axis.direction[None])[0]
    rotation = upright.as_matrix()
    turned = mesh.moved(Rigid(rotation, -rotation @ axis.point_mm))
    level = levels_at(turned, [plane.along_mm - float(axis.point_mm @ axis.direction)])[0]
    if isinstance(level, Refused):
        return None
    return Sigmas.of(turned).figure(level, tape_mm(level))


def _relative_rms(lengths: list[LengthCheck]) -> float:
    """Root mean square of the relative errors."""
    return rms(np.array([one.error for one in lengths]))


def _board_seen(evidence: Evidence) -> BoardSeen | None:
    found, scene = evidence.detections, evidence.metric.scene
    if found is None:
        return None
    placed = {scene.names[k] for k in scene.placed}
    seen = [photo for photo in found.photos if photo.name in placed]
    return BoardSeen(
        board=str(found.board),
        photos=len(seen),
        placed_photos=len(placed),
        corners=len(found.corners_mm),
        corners_per_photo=float(np.mean([len(photo.ids) for photo in seen])) if seen else math.nan,
        diagonal_mm=float(np.linalg.norm(np.ptp(found.corners_mm, axis=0))),
    )
