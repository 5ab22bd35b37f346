"""The network of photos and points: its strength, its residuals, its poses and its lenses.

Network    Redundancy is the number of measured coordinates (and calibrated lens parameters) beyond
           the unknowns; sigma0 is the standard deviation of one measured coordinate that the
           residuals show.
Residuals  Measured minus projected, px, one coordinate at a time; x to the right, y down. What the
           lens model misses shows as a pattern over the picture: the mean residual of a cell of
           the grid, over all photos of one camera, is then larger than chance makes it.
"""

import math

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.geometry.arrays import Points2
from limbgram.core.geometry.frames import SIMILARITY_SIZE, cross_matrix
from limbgram.core.geometry.lens import IN_PIXELS, PARAMETERS, POSE_SIZE, Camera
from limbgram.core.geometry.triangulation import triangulate
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.figures import (
    Angles,
    CameraResiduals,
    ContradictedFile,
    Correlations,
    LensFigures,
    LensParameter,
    NetworkFigures,
    Overlap,
    PhotoPose,
    PhotoResiduals,
    PixelHistogram,
    PointSigma,
    PoseFigures,
    Rays,
    ResidualFigures,
    ResidualGrid,
    RingFigures,
    Zone,
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
        crossed = cross_matrix(view.camera_from_world.translation)
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
    unknowns = POSE_SIZE * len(scene.placed) + 3 * len(scene.points_in_world) - SIMILARITY_SIZE
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
        rays=_ray_figures(seen.sum(1)),
        angles=_angle_figures(widest_angles_deg(scene, seen)),
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


def _ray_figures(rays: Int64[np.ndarray, " n"]) -> Rays:
    numbers = np.bincount(np.clip(rays, 2, _MOST_RAYS), minlength=_MOST_RAYS + 1)
    return Rays(
        mean=float(rays.mean()),
        median=float(np.median(rays)),
        two_share=float(np.mean(rays == 2)),
        numbers=tuple(range(2, _MOST_RAYS + 1)),
        points=tuple(numbers[2:].tolist()),
    )


def _angle_figures(angles: Float64[np.ndarray, " n"]) -> Angles:
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
"""Residuals without which a cell of the picture tells no pattern; a matter of smoothness."""


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
        beyond_3_sigma_share=_share_beyond_3_sigma(off, scene.sigma_px),
        histogram=_histogram(off, scene.sigma_px),
        by_photo=_by_photo(scene, photo_idx, off),
        by_camera=tuple(
            _camera_residuals(idx, camera, xy_px[cameras == idx], off[cameras == idx])
            for idx, camera in enumerate(scene.cameras)
        ),
    )


def _rms_px(off: Points2) -> float:
    """RMS of one coordinate of residuals."""
    return float(np.sqrt(np.mean(off**2))) if len(off) else math.nan


def _share_beyond_3_sigma(off: Points2, sigma_px: float) -> float:
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


def _camera_residuals(idx: int, camera: Camera, xy_px: Points2, off: Points2) -> CameraResiduals:
    return CameraResiduals(
        camera=idx,
        observations=len(off),
        grid=_residual_grid(camera, xy_px, off),
        zones=_zone_residuals(camera, xy_px, off),
        systematic_px=systematic_px(_cells(camera, xy_px), off),
    )


def _grid_shape(camera: Camera) -> tuple[int, int]:
    """Rows and columns of the grid: cells about square."""
    rows = max(2, round(_CELLS_ACROSS * camera.height_px / camera.width_px))
    return rows, _CELLS_ACROSS


def _cells(camera: Camera, xy_px: Points2) -> Int64[np.ndarray, " m"]:
    rows, columns = _grid_shape(camera)
    size = np.array([camera.width_px, camera.height_px])
    column, row = ((xy_px + 0.5) / size * (columns, rows)).astype(np.int64).T
    return np.clip(row, 0, rows - 1) * columns + np.clip(column, 0, columns - 1)


def _residual_grid(camera: Camera, xy_px: Points2, off: Points2) -> ResidualGrid:
    """Cells row after row, from the top left: observations, mean residual, RMS."""
    rows, columns = _grid_shape(camera)
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


def _zone_residuals(camera: Camera, xy_px: Points2, off: Points2) -> tuple[Zone, ...]:
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


_LEAST_LEARNED = 1e-4
"""Of the variance before: less than this is rounding."""


def camera_figures(evidence: Evidence) -> tuple[LensFigures, ...]:
    """Figures of each camera of the capture."""
    scene = evidence.metric.scene
    covariances = scene.lens_covariance
    return tuple(
        _lens_figures(idx, given, camera, None if covariances is None else covariances[idx])
        for idx, (given, camera) in enumerate(
            zip(evidence.cameras.calibrations, scene.cameras, strict=True)
        )
    )


def _contradicted(given: Calibration, camera: Camera, sigma_px: float) -> ContradictedFile | None:
    """The camera file in whose place the lens was found from the photos."""
    if given.instead_of is None:
        return None
    file_px, file_sigma_px = given.instead_of.camera.fx, float(given.instead_of.sigmas[0])
    off = abs(camera.fx - file_px) / math.hypot(file_sigma_px, sigma_px)
    return ContradictedFile(given_px=file_px, shown_px=camera.fx, sigmas=off)


def _lens_figures(
    idx: int,
    given: Calibration,
    camera: Camera,
    covariance: Float64[np.ndarray, "lens lens"] | None,
) -> LensFigures:
    before, after = given.camera.packed, camera.packed
    sigmas = np.full(len(PARAMETERS), np.nan) if covariance is None else _sigmas(covariance)
    return LensFigures(
        camera=idx,
        label=given.label,
        source=given.source,
        contradicted=_contradicted(given, camera, float(sigmas[0])),
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


def _sigmas(covariance: Float64[np.ndarray, "lens lens"]) -> Float64[np.ndarray, " lens"]:
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


def _correlations(covariance: Float64[np.ndarray, "lens lens"] | None) -> Correlations | None:
    """Correlations of the free parameters; None where the scene keeps no covariance."""
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
