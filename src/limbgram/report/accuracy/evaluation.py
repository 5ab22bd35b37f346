"""Evaluation: every figure of a case, read from its products; nothing is computed again.

Around     How much of the limb is missing, seen from its own middle. Every height has a middle of
           its own, that of the circle through what was measured there: it lies where the limb's
           axis is even if only one side was measured, where a centre of gravity would move towards
           that side and see half of the gap. Directions are level ones: the way up is that of the
           board's plane or of the photos, so the sole of a standing foot and the brim of a cast
           are not asked for. An open rim counts by the surface that would be needed to close it.
Network    Redundancy is the number of measured coordinates (and calibrated lens parameters) beyond
           the unknowns; sigma0 is the standard deviation of one measured coordinate that the
           residuals show.
Residuals  Measured minus projected, px, one coordinate at a time; x to the right, y down. What the
           lens model misses shows as a pattern over the picture: the mean residual of a cell of
           the grid, over all photos of one camera, is then larger than chance makes it.
"""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import ConvexHull, QhullError
from scipy.special import erf

from limbgram.core.errors import PhotoError
from limbgram.core.geometry.arrays import GreyImage, Points2, Points3
from limbgram.core.geometry.lens import PARAMETERS, POSE_SIZE, Camera, View
from limbgram.core.geometry.triangulation import triangulate
from limbgram.core.mesh.mesh import Mesh, Part
from limbgram.core.mesh.topology import boundary_half_edges
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.measuring.visibility import incidence_cosines
from limbgram.reconstruction.photos.decoding import load_luma
from limbgram.reconstruction.photos.photo import Photo
from limbgram.reconstruction.photos.quality import remarks
from limbgram.reconstruction.scale.marks import marks_of_label
from limbgram.reconstruction.scale.metric import LengthCheck
from limbgram.reconstruction.scale.taping import TapeWitness
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.figures import (
    Angles,
    Around,
    BoardSeen,
    CameraResiduals,
    Correlations,
    ImageFigures,
    KnownLength,
    LeftOut,
    LengthFigures,
    LensFigures,
    LensParameter,
    MovementFigures,
    NetworkFigures,
    Opening,
    OtherBody,
    Overlap,
    PhotoFigures,
    PhotoPose,
    PhotoResiduals,
    PhotosPerPlace,
    PixelHistogram,
    PointSigma,
    PoseFigures,
    Rays,
    ResidualFigures,
    ResidualGrid,
    RingFigures,
    SurfaceFigures,
    SurfaceSigma,
    TapedLength,
    Zone,
)
from limbgram.report.drawings.charts import image_scales
from limbgram.report.movement import (
    bending_sentence,
    lens_doubt,
    moved_mm,
    moved_photos,
    movement_remark,
    movement_sentence,
)

_HEIGHTS = 30
_DIRECTIONS = 60
_FRINGE = 0.02
"""Share of the area that is left out at either end: a slanted brim is no gap."""
_LEAST_POINTS = 8
_FARTHEST = 1.0
"""A circle wider than the whole shape is none; the middle of what is there is taken instead."""
_ON_FLOOR = 0.05
"""A rim this near to the floor, in heights of the shape, is where the shape stands on it."""
_SLANTED = 1.25
"""A brim may be this much larger than the widest level section, being cut at a slant."""


def around_figures(mesh: Mesh, floor_z: float | None) -> Around:
    """Directions without measured surface, the widest gap, and what is open beyond one brim."""
    measured = np.ones(len(mesh), bool) if mesh.filled is None else ~mesh.filled
    faces = mesh.faces[measured[mesh.faces].any(1)]
    corners = np.unique(faces)
    corners = corners[measured[corners]]
    places = np.concatenate([mesh.vertices_mm[faces].mean(1), mesh.vertices_mm[corners]])
    if len(places) < _LEAST_POINTS:
        return Around(missing_share=math.nan, widest_gap_deg=math.nan, open_share=0.0)
    low, high = np.quantile(places[:, 2], (_FRINGE, 1 - _FRINGE))
    inside = (places[:, 2] >= low) & (places[:, 2] <= high)
    places = places[inside]
    height = ((places[:, 2] - low) / max(high - low, 1e-12) * _HEIGHTS).astype(np.int64)
    height = np.minimum(height, _HEIGHTS - 1)
    seen = _seen(places[:, :2], height)
    return Around(
        missing_share=float(1 - seen.mean()),
        widest_gap_deg=float(np.median([_widest_gap(row) for row in seen])),
        open_share=_open_share(mesh, floor_z, _widest_section(places[:, :2], height)),
    )


def _seen(xy: Points2, height: Int64[np.ndarray, " n"]) -> Bool[np.ndarray, "h d"]:
    """Whether there is surface at a height in a direction from the middle there."""
    away = xy - _middles(xy, height)[height]
    turn = np.arctan2(away[:, 1], away[:, 0]) / (2 * np.pi) % 1.0
    cell = height * _DIRECTIONS + np.minimum((turn * _DIRECTIONS).astype(np.int64), _DIRECTIONS - 1)
    count = np.bincount(cell, minlength=_HEIGHTS * _DIRECTIONS)
    return count.reshape(_HEIGHTS, _DIRECTIONS) > 0


def _middles(xy: Points2, height: Int64[np.ndarray, " n"]) -> Float64[np.ndarray, "heights 2"]:
    """Middle of the circle through the points of each height (Kasa 1976), of all heights at once.

    x^2 + y^2 = 2 a x + 2 b y + c is linear in the middle (a, b).
    """
    origin = xy.mean(0)
    x, y = (xy - origin).T
    terms = np.stack([x, y, np.ones_like(x)], axis=1)
    square = x * x + y * y

    def summed(values: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " h"]:
        return np.bincount(height, values, _HEIGHTS)

    normal = np.stack(
        [np.stack([summed(terms[:, i] * terms[:, j]) for j in range(3)], 1) for i in range(3)], 1
    )
    right = np.stack([summed(terms[:, i] * square) for i in range(3)], 1)
    solved = (np.linalg.pinv(normal, rcond=1e-10) @ right[..., None])[..., 0]
    middle = solved[:, :2] / 2
    squared_radius = solved[:, 2] + (middle**2).sum(1)
    number = np.maximum(summed(np.ones_like(x)), 1)
    plain = np.stack([summed(x) / number, summed(y) / number], 1)
    size = float(np.ptp(xy, axis=0).max())
    good = (squared_radius > 0) & (squared_radius < (_FARTHEST * size) ** 2)
    return origin + np.where(good[:, None], middle, plain)


def _widest_gap(seen: Bool[np.ndarray, " d"]) -> float:
    """Degrees in a row without surface."""
    if not seen.any():
        return 360.0
    there = np.flatnonzero(seen)
    steps = np.diff(np.append(there, there[0] + len(seen))) - 1
    return float(steps.max() * 360.0 / len(seen))


def _widest_section(xy: Points2, height: Int64[np.ndarray, " n"]) -> float:
    """Area within a tape round the shape, at the height where that is largest."""
    order = np.argsort(height, kind="stable")
    found = [0.0]
    for part in np.split(xy[order], np.flatnonzero(np.diff(height[order])) + 1):
        try:
            found.append(float(ConvexHull(part).volume))  # of two dimensions: its area
        except (QhullError, ValueError):
            continue  # too few points, or all on a line: no section
    return max(found)


def _open_share(mesh: Mesh, floor_z: float | None, section: float) -> float:
    """What would close the rims beyond one brim, as a share of the closed whole."""
    border = boundary_half_edges(mesh.faces)
    if not len(border):
        return 0.0
    ones = np.ones(len(border), np.int8)
    graph = sparse.coo_array((ones, (border[:, 0], border[:, 1])), (len(mesh), len(mesh)))
    rim = csgraph.connected_components(graph, directed=False)[1][border[:, 0]]
    _, rim = np.unique(rim, return_inverse=True)
    open_area = _fans(mesh.vertices_mm, border, rim)
    if floor_z is not None:
        z = mesh.vertices_mm[:, 2]
        top = np.full(len(open_area), -np.inf)
        np.maximum.at(top, rim, z[border[:, 0]])
        open_area = open_area[top > floor_z + _ON_FLOOR * (z.max() - floor_z)]
    brim = min(float(open_area.max(initial=0.0)), _SLANTED * section)
    beyond = float(open_area.sum()) - brim
    surface = float(np.linalg.norm(mesh.face_normals(), axis=1).sum()) / 2
    return beyond / (surface + beyond + brim)


def _fans(
    vertices: Points3, border: Int32[np.ndarray, "b 2"], rim: Int64[np.ndarray, " b"]
) -> Float64[np.ndarray, " r"]:
    """Area of triangles from each rim's middle to its edges."""
    number = np.maximum(np.bincount(rim), 1)
    first, second = vertices[border[:, 0]], vertices[border[:, 1]]
    middle = np.stack([np.bincount(rim, first[:, k]) / number for k in range(3)], 1)[rim]
    twice = np.linalg.norm(np.cross(first - middle, second - middle), axis=1)
    return np.bincount(rim, twice) / 2


_NOISE_PHOTOS = 2
_NOISE_SIDE_PX = 1000
_FLAT_SHARE = 0.5
"""Part of the pixels, those with the least slope, in which noise is looked for."""
_MIDDLE_GREY = (20, 235)


def movement_figures(evidence: Evidence) -> MovementFigures | None:
    """What is known of movement; None where nobody looked, in cases of older versions."""
    scene = evidence.metric.scene
    movement = scene.movement
    if movement is None:
        return None
    known = movement.kind != "unknown"
    return MovementFigures(
        kind=movement.kind,
        sentence=movement_sentence(movement, scene.names, evidence.unit),
        photos=moved_photos(movement, scene.names),
        alone=movement.alone,
        shift=moved_mm(movement),
        turn_deg=float(np.nanmax(movement.turn_deg)) if known else math.nan,
        misfit=movement.misfit,
        chance=movement.chance if known or movement.misfit else math.nan,
        bending_sentence=""
        if scene.bending is None
        else bending_sentence(
            scene.bending, scene.names, evidence.unit, lens_doubt(scene, evidence.cameras)
        ),
        bending_misfit=scene.bending is not None and scene.bending.misfit,
        bending=moved_mm(scene.bending),
    )


def image_figures(evidence: Evidence) -> ImageFigures:
    """What the photos are worth; NaN for the noise where their files are gone."""
    scene, photos = evidence.metric.scene, evidence.photos
    scales = {one.name: one for one in image_scales(photos, evidence.metric)}
    said: dict[str, list[str]] = {}
    for remark in remarks(photos):
        said.setdefault(remark.name, []).append(remark.text)
    rows: list[PhotoFigures] = []
    stated: list[float] = []
    for number, (photo, verdict) in enumerate(zip(photos.photos, scene.verdicts, strict=True)):
        scale = scales.get(photo.name)
        if scale is not None and photo.exif.subject_m is not None:
            stated.append(scale.distance_mm / (1000 * photo.exif.subject_m))
        rows.append(
            PhotoFigures(
                name=photo.name,
                placed=verdict.placed,
                reason=verdict.reason,
                remarks=(
                    *said.get(photo.name, ()),
                    *([verdict.remark] if verdict.remark else []),
                    *movement_remark(scene, number, evidence.unit),
                ),
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
        set_aside=tuple(
            LeftOut(name=part.name, reason=part.reason)
            for part in (*photos.set_aside, *evidence.metric.scale.set_aside)
        ),
        pixel=_median([row.pixel for row in rows]),
        distance=_median([row.distance for row in rows]),
        distance_over_stated=_median(stated),
        edge_width_px=_median([row.edge_width_px for row in rows]),
        noise_grey=_noise(evidence),
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


def _noise(evidence: Evidence) -> float:
    """Median of a few photos spread over the capture."""
    placed = [evidence.photos.photos[k] for k in evidence.metric.scene.placed]
    step = max(1, len(placed) // _NOISE_PHOTOS)
    return _median([_of_photo(photo) for photo in placed[::step][:_NOISE_PHOTOS]])


def _of_photo(photo: Photo) -> float:
    try:
        return noise_grey(load_luma(photo))
    except PhotoError:
        return math.nan


def _median(values: list[float]) -> float:
    known = [value for value in values if np.isfinite(value)]
    return float(np.median(known)) if known else math.nan


_BOARD_LABEL = "board, "
"""How `scale.board` labels lengths between the board's own corners."""
_MARKS_LABEL = "marks "
"""How `scale.marks` labels lengths between marks on no plate, whose distance was given by hand."""


def length_figures(evidence: Evidence) -> LengthFigures:
    """The scale, its control and check lengths apart, and the board's observed corners."""
    scale = evidence.metric.scale
    checks = [one for one in scale.lengths if one.role == "check"]
    controls = [one for one in scale.lengths if one.role == "control"]
    return LengthFigures(
        unit=scale.unit,
        source=scale.source,
        relative_sigma=scale.relative_sigma,
        board_stretch=scale.board_stretch,
        control=tuple(_length(one) for one in controls),
        check=tuple(_length(one) for one in checks),
        control_rms=_relative_rms(controls),
        check_rms=_relative_rms(checks),
        check_worst=max((abs(one.error) for one in checks), default=math.nan),
        check_worst_label=max(checks, key=lambda one: abs(one.error)).label if checks else "",
        checked_by_another_piece=_checked_by_another_piece(controls, checks),
        tapes=tuple(_tape(one) for one in evidence.tapes.found) if scale.unit == "mm" else (),
        board=_board(evidence),
    )


def _checked_by_another_piece(controls: list[LengthCheck], checks: list[LengthCheck]) -> bool:
    """Whether a check length owes nothing to the lengths that set the scale.

    One printer makes everything printed, so that no print checks another; each distance that was
    given by hand was measured by itself.
    """
    print_set_it = any(_is_printed(one) for one in controls)
    return any(not (print_set_it and _is_printed(one)) for one in checks)


def _is_printed(length: LengthCheck) -> bool:
    """On the board, or on a plate: `scale.marks` begins the label with the plate's name."""
    label = length.label
    on_plate = marks_of_label(label) is not None and not label.startswith(_MARKS_LABEL)
    return on_plate or label.startswith(_BOARD_LABEL)


def _length(one: LengthCheck) -> KnownLength:
    return KnownLength(
        label=one.label,
        known_mm=one.known_mm,
        measured_mm=one.measured_mm,
        error_mm=one.measured_mm - one.known_mm,
        error=one.error,
        sigma_mm=one.sigma_mm,
    )


def _tape(one: TapeWitness) -> TapedLength:
    off_mm = one.measured_mm - one.taped.girth_mm
    return TapedLength(
        place=one.taped.place,
        read_mm=one.taped.girth_mm,
        measured_mm=one.measured_mm,
        error_mm=off_mm,
        error=off_mm / one.taped.girth_mm,
        sigma_mm=one.sigma_mm,
        reason=one.reason,
    )


def _relative_rms(lengths: list[LengthCheck]) -> float:
    """Root mean square of the relative errors."""
    if not lengths:
        return math.nan
    return float(np.sqrt(np.mean([one.error**2 for one in lengths])))


def _board(evidence: Evidence) -> BoardSeen | None:
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


_LEAST_LEARNED = 1e-4
"""Of the variance before: less than this is rounding."""
IN_PIXELS = ("fx", "fy", "cx", "cy", "skew")
"""Lens parameters with a unit; the others have none."""


def camera_figures(evidence: Evidence) -> tuple[LensFigures, ...]:
    """Each camera of the capture."""
    scene = evidence.metric.scene
    covariances = scene.lens_covariance
    return tuple(
        _camera(idx, given, camera, None if covariances is None else covariances[idx])
        for idx, (given, camera) in enumerate(
            zip(evidence.cameras.calibrations, scene.cameras, strict=True)
        )
    )


def _camera(
    idx: int, given: Calibration, camera: Camera, covariance: Float64[np.ndarray, "10 10"] | None
) -> LensFigures:
    before, after = given.camera.packed, camera.packed
    sigmas = np.full(len(PARAMETERS), np.nan) if covariance is None else _sigmas(covariance)
    return LensFigures(
        camera=idx,
        label=given.label,
        source=given.source,
        width_px=camera.width_px,
        height_px=camera.height_px,
        calibration_rms_px=given.rms_px,
        parameters=tuple(
            LensParameter(
                name=name,
                unit="px" if name in IN_PIXELS else "",
                value=float(after[k]),
                sigma=float(sigmas[k]),
                calibrated=float(before[k]),
                calibrated_sigma=float(given.sigmas[k]),
                moved_sigmas=_ratio(after[k] - before[k], given.sigmas[k]),
                contradicted_sigmas=_contradiction(
                    after[k] - before[k], given.sigmas[k], sigmas[k]
                ),
                held=bool(given.sigmas[k] == 0),
            )
            for k, name in enumerate(PARAMETERS)
        ),
        correlations=_correlations(covariance),
    )


def _sigmas(covariance: Float64[np.ndarray, "10 10"]) -> Float64[np.ndarray, "10"]:
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def _ratio(shift: float, sigma: float) -> float:
    return float(shift / sigma) if sigma > 0 else math.nan


def _contradiction(shift: float, before: float, after: float) -> float:
    """The shift over the sigma that it has where calibration and photos agree.

    What is known before and learned from independent photos moves by chance with the variance that
    was lost on the way, before^2 - after^2. A tight calibration hardly moves however wrong it is;
    by this measure it is seen.
    """
    if not (before > 0 and np.isfinite(after)):
        return _ratio(shift, before)
    learned = max(before**2 - after**2, _LEAST_LEARNED * before**2)
    return float(shift / np.sqrt(learned))


def _correlations(covariance: Float64[np.ndarray, "10 10"] | None) -> Correlations | None:
    """Of the parameters that are free; None where the scene keeps no covariance."""
    if covariance is None:
        return None
    free = np.flatnonzero(np.diag(covariance) > 0)
    if not len(free):
        return None
    sigmas = _sigmas(covariance)[free]
    matrix = covariance[np.ix_(free, free)] / np.outer(sigmas, sigmas)
    return Correlations(
        order=tuple(PARAMETERS[k] for k in free), matrix=tuple(map(tuple, matrix.tolist()))
    )


def pose_figures(scene: Scene) -> PoseFigures | None:
    """Sigma of every photo's place and turn; None where the scene keeps no covariance of them.

    Of all three coordinates together (root of the trace), in the frame of the points' own
    average: what moves or turns the whole scene carries nothing.
    """
    covariance = scene.camera_covariance
    if covariance is None:
        return None
    rows: list[PhotoPose] = []
    for k, view in enumerate(scene.views):
        part = slice(POSE_SIZE * k, POSE_SIZE * (k + 1))
        pose = covariance[part, part]
        x, y, z = view.camera_from_world.translation
        crossed = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        # C = -R' t; a turn w and a shift d of t move it by -R' (t x w + d).
        moved = -view.camera_from_world.rotation.T @ np.hstack([crossed, np.eye(3)])
        rows.append(
            PhotoPose(
                name=view.name,
                centre=_root_trace(moved @ pose @ moved.T),
                rotation_deg=float(np.degrees(_root_trace(pose[:3, :3]))),
            )
        )
    return PoseFigures(
        centre_median=float(np.median([row.centre for row in rows])),
        centre_largest=max(row.centre for row in rows),
        rotation_median_deg=float(np.median([row.rotation_deg for row in rows])),
        by_photo=tuple(rows),
    )


def _root_trace(covariance: Float64[np.ndarray, "3 3"]) -> float:
    return float(np.sqrt(max(np.trace(covariance), 0.0)))


_GAUGE_FREEDOM = 7
_ANGLE_STEP_DEG = 5.0
_LARGEST_ANGLE_DEG = 120.0
_MOST_RAYS = 12
_BELOW_DEG = 5.0


def network_figures(scene: Scene) -> NetworkFigures:
    """Rays, angles, redundancy, overlap and the ring.

    A lens parameter that moves is observed too, by its calibration, so it takes nothing away from
    the redundancy.
    """
    seen = _network_seen(scene)
    residuals = scene.residuals_px()
    known = np.isfinite(residuals).all(1)
    coordinates = 2 * int(known.sum())
    unknowns = POSE_SIZE * len(scene.placed) + 3 * len(scene.points_in_world) - _GAUGE_FREEDOM
    redundancy = coordinates - unknowns
    squares = float((residuals[known] ** 2).sum())
    ring = scene.ring
    return NetworkFigures(
        points=len(scene.points_in_world),
        observations=len(scene.observations.xy_px),
        unknowns=unknowns,
        redundancy=redundancy,
        redundancy_share=redundancy / coordinates if coordinates else math.nan,
        sigma0_px=float(np.sqrt(squares / redundancy)) if redundancy > 0 else math.nan,
        sigma0_robust_px=scene.sigma_px,
        rays=_rays(seen.sum(1)),
        angles=_angles(widest_angles_deg(scene, seen)),
        point_sigma=_point_sigma(scene),
        overlap=_overlap(scene, seen),
        ring=None
        if ring is None
        else RingFigures(
            largest_gap_deg=ring.largest_gap_deg,
            weakest_bridge_points=ring.weakest_bridge,
            closed=ring.closed,
        ),
    )


def widest_angles_deg(scene: Scene, seen: Bool[np.ndarray, "n p"]) -> Float64[np.ndarray, " n"]:
    """Largest angle between any two of a point's rays."""
    # Single precision: 0.03 degrees at worst, and half the memory of the largest array here.
    centres = np.array([view.centre_in_world for view in scene.views])
    middle = centres.mean(0)
    rays = (centres - middle).astype(np.float32)[None] - (
        (scene.points_in_world - middle).astype(np.float32)[:, None]
    )
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    smallest = np.ones(len(rays))
    for first in range(len(centres)):
        for second in range(first):
            both = seen[:, first] & seen[:, second]
            cosine = np.einsum("ij,ij->i", rays[both, first], rays[both, second])
            smallest[both] = np.minimum(smallest[both], cosine)
    return np.degrees(np.arccos(np.clip(smallest, -1.0, 1.0)))


def _network_seen(scene: Scene) -> Bool[np.ndarray, "n p"]:
    """Which placed photo sees which point."""
    place = np.full(len(scene.names), -1)
    place[list(scene.placed)] = np.arange(len(scene.placed))
    observed = scene.observations
    used = place[observed.photo_idx] >= 0
    seen = np.zeros((len(scene.points_in_world), len(scene.placed)), bool)
    seen[observed.point_idx[used], place[observed.photo_idx[used]]] = True
    return seen


def _rays(rays: Int64[np.ndarray, " n"]) -> Rays:
    numbers = np.bincount(np.clip(rays, 2, _MOST_RAYS), minlength=_MOST_RAYS + 1)
    return Rays(
        mean=float(rays.mean()),
        median=float(np.median(rays)),
        two_share=float(np.mean(rays == 2)),
        numbers=tuple(range(2, _MOST_RAYS + 1)),
        points=tuple(numbers[2:].tolist()),
    )


def _angles(angles: Float64[np.ndarray, " n"]) -> Angles:
    edges = np.arange(0, _LARGEST_ANGLE_DEG + _ANGLE_STEP_DEG, _ANGLE_STEP_DEG)
    inside = np.clip(angles, 0, _LARGEST_ANGLE_DEG - 1e-9)
    return Angles(
        median_deg=float(np.median(angles)),
        low_deg=float(np.quantile(angles, 0.05)),
        narrow_share=float(np.mean(angles < _BELOW_DEG)),
        edges_deg=tuple(edges.tolist()),
        points=tuple(np.histogram(inside, edges)[0].tolist()),
    )


def _point_sigma(scene: Scene) -> PointSigma:
    """Formal sigma of a point along the direction that its rays fix worst, cameras exact."""
    seen = scene.observations
    place = np.full(len(scene.names), -1, np.int32)
    place[list(scene.placed)] = np.arange(len(scene.placed), dtype=np.int32)
    used = place[seen.photo_idx] >= 0
    found = triangulate(
        scene.views,
        place[seen.photo_idx[used]],
        seen.point_idx[used],
        seen.xy_px[used],
        len(scene.points_in_world),
    )
    covariance = found.covariance[np.isfinite(found.covariance).all((1, 2))]
    if not len(covariance):
        return PointSigma(median=math.nan, p95=math.nan)
    worst = scene.sigma_px * np.sqrt(np.linalg.eigvalsh(covariance)[:, 2])
    return PointSigma(median=float(np.median(worst)), p95=float(np.quantile(worst, 0.95)))


def _overlap(scene: Scene, seen: Bool[np.ndarray, "n p"]) -> Overlap:
    """Points that each pair of placed photos shares; a photo's own points on the diagonal."""
    numbers = seen.astype(np.float32)
    shared = np.rint(numbers.T @ numbers).astype(int)
    apart = shared - np.diag(np.diag(shared))
    return Overlap(
        names=tuple(scene.names[k] for k in scene.placed),
        shared_points=tuple(map(tuple, shared.tolist())),
        best_partner=tuple(apart.max(1).tolist()) if len(apart) else (),
        partners=tuple((apart > 0).sum(1).tolist()) if len(apart) else (),
    )


_BINS = 61
_REACH_SIGMAS = 5.0
_CELLS_ACROSS = 12
_ZONES = 5
_FEWEST_IN_CELL = 5


def residual_figures(scene: Scene) -> ResidualFigures:
    """Histogram, by photo, by distance from the picture's middle, and the systematic part."""
    residuals = scene.residuals_px()
    known = np.isfinite(residuals).all(1)
    off, seen = residuals[known], scene.observations
    photo_idx, xy_px = seen.photo_idx[known], seen.xy_px[known]
    cameras = np.array(scene.camera_idx, np.int64)[photo_idx]
    return ResidualFigures(
        rms_px=_rms_px(off),
        median_distance_px=float(np.median(np.hypot(*off.T))) if len(off) else math.nan,
        largest_px=float(np.hypot(*off.T).max(initial=0.0)),
        beyond_3_sigma_share=_beyond(off, scene.sigma_px),
        histogram=_histogram(off, scene.sigma_px),
        by_photo=_by_photo(scene, photo_idx, off),
        by_camera=tuple(
            _of_camera(idx, camera, xy_px[cameras == idx], off[cameras == idx])
            for idx, camera in enumerate(scene.cameras)
        ),
    )


def _rms_px(off: Points2) -> float:
    """Of one coordinate."""
    return float(np.sqrt(np.mean(off**2))) if len(off) else math.nan


def _beyond(off: Points2, sigma_px: float) -> float:
    """Share of coordinates beyond three robust sigmas; 0.27 % where the errors are Gaussian."""
    return float(np.mean(np.abs(off) > 3 * sigma_px)) if len(off) else math.nan


def _histogram(off: Points2, sigma_px: float) -> PixelHistogram:
    reach = _REACH_SIGMAS * sigma_px if sigma_px > 0 else max(float(np.abs(off).max(initial=0)), 1)
    edges = np.linspace(-reach, reach, _BINS + 1)
    inside = np.clip(off, -reach, reach)
    x, y = (tuple(np.histogram(inside[:, axis], edges)[0].tolist()) for axis in (0, 1))
    return PixelHistogram(edges_px=tuple(edges.tolist()), x=x, y=y)


def _by_photo(scene: Scene, photo_idx: np.ndarray, off: Points2) -> tuple[PhotoResiduals, ...]:
    rows: list[PhotoResiduals] = []
    for photo in scene.placed:
        own = off[photo_idx == photo]
        mean = own.mean(0) if len(own) else np.full(2, np.nan)
        rows.append(
            PhotoResiduals(
                name=scene.names[photo],
                observations=len(own),
                rms_px=_rms_px(own),
                mean_x_px=float(mean[0]),
                mean_y_px=float(mean[1]),
                largest_px=float(np.hypot(*own.T).max(initial=0.0)),
            )
        )
    return tuple(rows)


def _of_camera(idx: int, camera: Camera, xy_px: Points2, off: Points2) -> CameraResiduals:
    return CameraResiduals(
        camera=idx,
        observations=len(off),
        grid=_grid(camera, xy_px, off),
        zones=_zones(camera, xy_px, off),
        systematic_px=systematic_px(_cells(camera, xy_px), off),
    )


def _shape(camera: Camera) -> tuple[int, int]:
    """Rows and columns of the grid: cells about square."""
    rows = max(2, round(_CELLS_ACROSS * camera.height_px / camera.width_px))
    return rows, _CELLS_ACROSS


def _cells(camera: Camera, xy_px: Points2) -> Int64[np.ndarray, " m"]:
    rows, columns = _shape(camera)
    size = np.array([camera.width_px, camera.height_px])
    column, row = ((xy_px + 0.5) / size * (columns, rows)).astype(np.int64).T
    return np.clip(row, 0, rows - 1) * columns + np.clip(column, 0, columns - 1)


def _grid(camera: Camera, xy_px: Points2, off: Points2) -> ResidualGrid:
    """Cells row after row, from the top left: observations, mean residual, RMS."""
    rows, columns = _shape(camera)
    cell, count = _cells(camera, xy_px), rows * columns
    number = np.bincount(cell, minlength=count)
    divisor = np.where(number >= _FEWEST_IN_CELL, number, np.nan)
    sums = [np.bincount(cell, off[:, axis], count) / divisor for axis in (0, 1)]
    squares = np.bincount(cell, (off**2).sum(1) / 2, count) / divisor
    return ResidualGrid(
        rows=rows,
        columns=columns,
        width_px=camera.width_px,
        height_px=camera.height_px,
        observations=tuple(number.tolist()),
        mean_x_px=tuple(sums[0].tolist()),
        mean_y_px=tuple(sums[1].tolist()),
        rms_px=tuple(np.sqrt(squares).tolist()),
    )


def systematic_px(cell: Int64[np.ndarray, " m"], off: Points2) -> float:
    """RMS of one coordinate's mean over a cell, less what chance alone makes of it.

    Unbiased: the sum of squares between cells estimates systematic^2 + variance within / number.
    """
    count = int(cell.max(initial=-1)) + 1
    number = np.bincount(cell, minlength=count)
    used = number >= _FEWEST_IN_CELL
    if not used.any():
        return math.nan
    excess, weight = 0.0, float(number[used].sum())
    for axis in (0, 1):
        mean = np.bincount(cell, off[:, axis], count)[used] / number[used]
        square = np.bincount(cell, off[:, axis] ** 2, count)[used] / number[used]
        by_chance = np.maximum(square - mean**2, 0.0) / (number[used] - 1)
        excess += float(np.sum(number[used] * (mean**2 - by_chance))) / weight / 2
    return float(np.sqrt(max(excess, 0.0)))


def _zones(camera: Camera, xy_px: Points2, off: Points2) -> tuple[Zone, ...]:
    """Rings round the picture's middle: RMS, and the mean residual away from the middle."""
    middle = np.array([camera.width_px - 1, camera.height_px - 1]) / 2
    arm = xy_px - middle
    radius = np.hypot(*arm.T)
    share: Float64[np.ndarray, " m"] = radius / float(np.hypot(*(middle + 0.5)))
    outward = (off * arm).sum(1) / np.maximum(radius, 1e-9)
    zone = np.clip((share * _ZONES).astype(np.int64), 0, _ZONES - 1)
    return tuple(
        Zone(
            from_share=k / _ZONES,
            to_share=(k + 1) / _ZONES,
            observations=int((zone == k).sum()),
            rms_px=_rms_px(off[zone == k]),
            outward_px=float(outward[zone == k].mean()) if (zone == k).any() else math.nan,
        )
        for k in range(_ZONES)
    )


_STEEPEST_DEG = 65.0
"""A photo that looks more closely along the surface than this hardly measures it."""
_RAY_VERTICES = 20_000
_SURFACE_BINS = 50
_SHOWN_QUANTILE = 0.995
_MOST_OPENINGS = 5
_BISECTIONS = 50
UNNAMED = "shared by all vertices"
"""What a shared source is called where the mesh does not tell."""


def surface_figures(evidence: Evidence) -> SurfaceFigures:
    """Completeness, openings, photos per place, and sigma."""
    mesh = evidence.mesh
    areas = mesh.vertex_areas_mm2()
    measured = measured_vertices(mesh)
    repairs = mesh.repairs
    return SurfaceFigures(
        vertices=len(mesh),
        faces=len(mesh.faces),
        size=tuple(np.ptp(mesh.vertices_mm, axis=0).tolist()),
        height_from=float(mesh.vertices_mm[:, 2].min()),
        area=float(areas.sum()),
        measured_share=_share(measured, areas),
        filled_share=_share(~measured, areas),
        left_out_share=0.0 if repairs is None else repairs.island_share,
        other_parts=() if repairs is None else tuple(_body(one) for one in repairs.others),
        part_given=repairs is not None and repairs.part_given,
        holes_filled=0 if repairs is None else repairs.holes_filled,
        openings=openings(mesh),
        around=around_figures(mesh, evidence.metric.floor_z_mm),
        photos_per_place=_photos_per_place(mesh, evidence.metric.scene.views),
        sigma=_sigma(mesh, areas),
    )


def _body(part: Part) -> OtherBody:
    return OtherBody(number=part.number, relation=part.relation, area=part.area_mm2)


def measured_vertices(mesh: Mesh) -> np.ndarray:
    """True where photos measured the surface."""
    return np.ones(len(mesh), bool) if mesh.filled is None else ~mesh.filled


def openings(mesh: Mesh) -> tuple[Opening, ...]:
    """The largest openings: length of the rim, and where its middle is."""
    border = boundary_half_edges(mesh.faces)
    if not np.array_equal(np.sort(border[:, 0]), np.unique(border[:, 1])):
        return ()  # rims that touch or branch: no loops to tell
    following = np.zeros(len(mesh), np.int64)
    following[border[:, 0]] = border[:, 1]
    found: list[Opening] = []
    left = set(border[:, 0].tolist())
    while left:
        loop = [left.pop()]
        while (vertex := int(following[loop[-1]])) in left:
            left.remove(vertex)
            loop.append(vertex)
        rim = mesh.vertices_mm[loop]
        sides = np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1)
        found.append(Opening(rim=float(sides.sum()), middle=tuple(rim.mean(0).tolist())))
    return tuple(sorted(found, key=lambda one: -one.rim)[:_MOST_OPENINGS])


def _share(chosen: np.ndarray, areas: Float64[np.ndarray, " n"]) -> float:
    total = float(areas.sum())
    return float(areas[chosen].sum()) / total if total > 0 else math.nan


def _photos_per_place(mesh: Mesh, views: Sequence[View]) -> PhotosPerPlace:
    """Photos that see a place under `_STEEPEST_DEG` or squarer; some vertices stand for all."""
    step = max(1, len(mesh) // _RAY_VERTICES)
    number = (incidence_cosines(mesh, views, _STEEPEST_DEG, step) > 0).sum(1)
    return PhotosPerPlace(
        median=float(np.median(number)),
        below_3_share=float(np.mean(number < 3)),
        places=tuple(np.bincount(number).tolist()),
    )


def _sigma(mesh: Mesh, areas: Float64[np.ndarray, " n"]) -> SurfaceSigma | None:
    """Along the normal, over the measured surface; None where the mesh carries no sigmas."""
    if mesh.sigma_mm is None:
        return None
    known = np.isfinite(mesh.sigma_mm) & measured_vertices(mesh) & (areas > 0)
    if not known.any():
        return None
    sigmas, weights = mesh.sigma_mm[known].astype(np.float64), areas[known]
    weights = weights / weights.sum()
    shares = _shares(mesh, known, weights)
    shared = math.hypot(*shares.values())
    total = float(np.sqrt(weights @ sigmas**2))
    reach = float(np.quantile(sigmas, _SHOWN_QUANTILE))
    edges = np.linspace(0.0, reach, _SURFACE_BINS + 1)
    area_share = np.histogram(np.minimum(sigmas, reach), edges, weights=weights)[0]
    return SurfaceSigma(
        rms_mm=total,
        median_mm=_weighted_quantile(sigmas, weights, 0.5),
        p95_mm=_weighted_quantile(sigmas, weights, 0.95),
        shared_rms_mm=shared,
        shares_mm=shares,
        own_rms_mm=float(np.sqrt(max(total**2 - shared**2, 0.0))),
        correlation_mm=math.nan if mesh.correlation_mm is None else mesh.correlation_mm,
        expected_error_p95_mm=expected_p95(sigmas, weights),
        edges_mm=tuple(edges.tolist()),
        area_share=tuple(area_share.tolist()),
    )


def _shares(
    mesh: Mesh, known: Bool[np.ndarray, " n"], weights: Float64[np.ndarray, " k"]
) -> dict[str, float]:
    """RMS over the area of what each shared source does to the surface, by the source's name."""
    if mesh.shared_mm is None:
        return {}
    energies = weights @ mesh.shared_mm[known].astype(np.float64) ** 2
    names = mesh.shared_sources or len(energies) * (UNNAMED,)
    return {
        name: float(np.sqrt(sum(e for e, of in zip(energies, names, strict=True) if of == name)))
        for name in dict.fromkeys(names)
    }


def expected_p95(sigmas: Float64[np.ndarray, " n"], weights: Float64[np.ndarray, " n"]) -> float:
    """Error within which 95 % of the surface is expected, its errors being Gaussian."""
    low, high = 0.0, 4.0 * float(sigmas.max())
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        inside = erf(middle / np.maximum(sigmas, 1e-12) / np.sqrt(2))
        low, high = (middle, high) if float(weights @ inside) < 0.95 else (low, middle)
    return (low + high) / 2


def _weighted_quantile(
    values: Float64[np.ndarray, " n"], weights: Float64[np.ndarray, " n"], share: float
) -> float:
    order = np.argsort(values)
    return float(values[order][np.searchsorted(np.cumsum(weights[order]), share)])
