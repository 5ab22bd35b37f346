"""Fusion: many depth maps to one cloud of evenly spaced, oriented points.

In      depth maps, and the photos for colour.
Out     a Cloud.
Method  All measured points together; evenly spaced ones among them become the cloud and move to
        the curved surface that all photos' points round them agree on. Points that too few photos
        confirm, points that more photos see through, and small pieces away from the surface are
        left out.
        Neighbours: points are sorted by the cube they lie in; a hash table gives where each cube's
        points start.
        The curved surface: round each point a quadric, height over the tangent plane = c0 + c1 u +
        c2 v + c3 u^2/2 + c4 u v + c5 v^2/2, is fitted to the measured points with weights that fall
        with distance and with residual; the point moves by c0 along the normal, the normal turns by
        the slopes (Levin 1998; Guennebaud and Gross 2007). The quadratic terms keep a curved
        surface from shrinking, and show by how much flat correlation windows placed it too deep.
Fails   DenseError: too few points agree.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Float32, Float64, Int64, UInt8, UInt16
from scipy.spatial import KDTree

from limbgram.core.errors import DenseError
from limbgram.core.geometry.lens import View
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Cloud
from limbgram.core.mesh.topology import components
from limbgram.core.run import in_parallel, worker_count
from limbgram.core.solvers import solve_positive
from limbgram.reconstruction.dense.depth import DepthMap
from limbgram.reconstruction.dense.region import Region
from limbgram.reconstruction.photos.decoding import halvings_to, in_flight_mb, load_colour
from limbgram.reconstruction.photos.photo import Photo, PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene

_HASH_MULTIPLIER = 0x9E3779B1
_AXIS_BITS = 21
"""Cubes along each axis are counted with this many bits."""


class CubeTable(NamedTuple):
    """Hash table of the cubes that hold points, as the kernels take it."""

    low_mm: Float64[np.ndarray, "3"]
    cell_mm: float
    keys: Int64[np.ndarray, " slots"]
    """Key of a cube, -1 for an empty slot."""
    spans: Int64[np.ndarray, "slots 2"]
    """First sorted point of the cube and one past the last."""


class HashGrid(NamedTuple):
    """Points in the order of their cubes."""

    order: Int64[np.ndarray, " n"]
    """Index of each sorted point in the original order."""
    cubes: CubeTable


def hash_grid(points_mm: Float32[np.ndarray, "n 3"], cell_mm: float) -> HashGrid:
    """Sort points into cubes of `cell_mm`."""
    low = points_mm.min(0).astype(float) - cell_mm
    cells = np.floor((points_mm - low) / cell_mm).astype(np.int64)
    key_of = (cells[:, 0] << 2 * _AXIS_BITS) | (cells[:, 1] << _AXIS_BITS) | cells[:, 2]
    order = np.argsort(key_of, kind="stable")
    ordered = key_of[order]
    first = np.flatnonzero(np.diff(ordered, prepend=-1))
    count = np.diff(first, append=len(ordered))
    slots = 1 << int(np.ceil(np.log2(2 * len(first) + 1)))
    keys = np.full(slots, -1, np.int64)
    spans = np.zeros((slots, 2), np.int64)
    _fill_table(ordered[first], first, count, keys, spans)
    return HashGrid(order, CubeTable(low, cell_mm, keys, spans))


@njit(inline="always")
def points_in_cube(cubes: CubeTable, i: int, j: int, k: int):
    """Sorted points of cube (i, j, k): first and one past the last."""
    keys, spans = cubes.keys, cubes.spans
    key = (i << 2 * _AXIS_BITS) | (j << _AXIS_BITS) | k
    slot = _slot_of(key, len(keys))
    while keys[slot] != key and keys[slot] >= 0:
        slot = (slot + 1) & (len(keys) - 1)
    if keys[slot] < 0:
        return 0, 0
    return spans[slot, 0], spans[slot, 1]


@njit(inline="always")
def _slot_of(key: int, slots: int):
    """Slot of the hash table at which the search for a key begins."""
    mixed = (key ^ (key >> 29)) * _HASH_MULTIPLIER
    return (mixed ^ (mixed >> 17)) & (slots - 1)


@njit(cache=True, nogil=True)
def _fill_table(
    unique: np.ndarray, first: np.ndarray, count: np.ndarray, keys: np.ndarray, spans: np.ndarray
):
    """Enter each cube's key and span, by linear probing."""
    for k in range(len(unique)):
        slot = _slot_of(unique[k], len(keys))
        while keys[slot] >= 0:
            slot = (slot + 1) & (len(keys) - 1)
        keys[slot] = unique[k]
        spans[slot, 0] = first[k]
        spans[slot, 1] = first[k] + count[k]


@njit(cache=True, nogil=True)
def poisson_disk_thinned(points: np.ndarray, order: np.ndarray, cubes: CubeTable, spacing: float):
    """Which points Poisson-disk thinning keeps, if they are visited in `order`.

    Points come in the grid's order. Those kept lie at least `spacing` (at most one cube) apart,
    and every other one lies nearer than that to one that is kept.
    """
    low, cell = cubes.low_mm, cubes.cell_mm
    blocked = np.zeros(len(points), np.bool_)
    kept = np.zeros(len(points), np.bool_)
    for p in order:
        if blocked[p]:
            continue
        kept[p] = True
        i = int((points[p, 0] - low[0]) / cell)
        j = int((points[p, 1] - low[1]) / cell)
        k = int((points[p, 2] - low[2]) / cell)
        for di in range(-1, 2):
            for dj in range(-1, 2):
                for dk in range(-1, 2):
                    first, last = points_in_cube(cubes, i + di, j + dj, k + dk)
                    for q in range(first, last):
                        x = points[q, 0] - points[p, 0]
                        y = points[q, 1] - points[p, 1]
                        z = points[q, 2] - points[p, 2]
                        if x * x + y * y + z * z < spacing * spacing:
                            blocked[q] = True
    return kept


_SEEN_THROUGH_TOLERANCES = 4.0
"""A surface this many tolerances behind a point is another one."""


@dataclass(frozen=True, kw_only=True)
class PointVisibility:
    """By point: how many photos see it, how many see through it, and its mean colour."""

    views: UInt16[np.ndarray, " n"]
    """Photos whose depth map has the point."""
    through: UInt16[np.ndarray, " n"]
    """Photos whose depth map has a surface behind the point, which the point would hide."""
    colours: UInt8[np.ndarray, "n 3"]


def point_visibility(
    photos: PhotoSet,
    metric: MetricScene,
    depth_maps: Sequence[DepthMap],
    points_mm: Float32[np.ndarray, "n 3"],
    normals: Float32[np.ndarray, "n 3"],
    agree_mm: float,
) -> PointVisibility:
    """Compare each point with each depth map; colours are averaged with weight cosine^2."""

    def visible_in(depth_map: DepthMap) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        seen, cosine, through = _visible_points(depth_map, points_mm, normals, agree_mm)
        view = metric.scene.view(depth_map.photo_idx)
        colours = _sampled_colours(
            photos.photos[depth_map.photo_idx], view, halvings, points_mm[seen]
        )
        return seen, cosine**2, colours, through

    halvings = min(
        (
            halvings_to(metric.scene.view(one.photo_idx).camera.width_px, one.camera.width_px)
            for one in depth_maps
        ),
        default=0,
    )
    each_mb = in_flight_mb(photos.photos, colour=True, halvings=halvings)
    views, through = np.zeros((2, len(points_mm)), np.uint16)
    weights = np.full(len(points_mm), 1e-9)
    sums = np.zeros((len(points_mm), 3))
    for seen, weight, colours, behind in in_parallel(visible_in, depth_maps, each_mb=each_mb):
        views[seen] += 1
        through[behind] += 1
        weights[seen] += weight
        sums[seen] += weight[:, None] * colours
    colours = np.round(sums / weights[:, None]).astype(np.uint8)
    return PointVisibility(views=views, through=through, colours=colours)


def _visible_points(
    depth_map: DepthMap,
    points_mm: Float32[np.ndarray, "n 3"],
    normals: Float32[np.ndarray, "n 3"],
    agree_mm: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points on the map's surface, the cosines of their incidence, and points it sees through."""
    pose, camera = depth_map.camera_from_world, depth_map.camera
    in_camera = pose.apply(points_mm.astype(float))
    rays = in_camera / np.linalg.norm(in_camera, axis=1, keepdims=True)
    cosine = -(rays * (normals @ pose.rotation.T)).sum(1)
    xy = camera.project(in_camera) - (depth_map.x0, depth_map.y0)
    height, width = depth_map.depth_mm.shape
    within = np.flatnonzero(np.all((xy > -0.5) & (xy < (width - 0.5, height - 0.5)), axis=1))
    column, row = np.round(xy[within]).astype(int).T
    behind_mm = depth_map.depth_mm[row, column] - in_camera[within, 2]
    tolerance_mm = agree_mm + in_camera[within, 2] / camera.fx
    facing = cosine[within]
    seen = within[(facing > 0.1) & (np.abs(behind_mm) * facing < tolerance_mm)]
    return seen, cosine[seen], within[behind_mm > _SEEN_THROUGH_TOLERANCES * tolerance_mm]


def _sampled_colours(
    photo: Photo, view: View, halvings: int, points_mm: np.ndarray
) -> Float32[np.ndarray, "n 3"]:
    """Colours of the points in a photo that is reduced, but no further than its depth map is."""
    if not len(points_mm):
        return np.zeros((0, 3), np.float32)
    xy = view.project(points_mm.astype(float)) + 0.5
    xy = (xy / (1 << halvings) - 0.5).astype(np.float32)
    colour = load_colour(photo, halvings)
    rows = max(1, -(-len(xy) // 1024))
    x, y = np.resize(xy, (rows * 1024, 2)).T.copy().reshape(2, rows, 1024)
    sampled = cv2.remap(colour, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return sampled.reshape(-1, 3)[: len(xy)].astype(np.float32)


class MeasuredPoints(NamedTuple):
    """Oriented points of one depth map or of all together."""

    points_mm: Float32[np.ndarray, "n 3"]
    normals: Float32[np.ndarray, "n 3"]
    weights: Float32[np.ndarray, " n"]
    windows_mm2: Float32[np.ndarray, " n"]
    """Mean squared reach of the correlation windows on the surface."""


_UNKNOWNS = 6
_LEAST_NEIGHBOURS = 8
_REGULARISATION = 0.001
"""Tikhonov weight of slopes and curvatures, as a fraction of the neighbours' weight: it matters
only where the neighbours lie on a line or to one side."""
_MAX_ITERATIONS = 3
_CONVERGED_SHIFT, _CONVERGED_SLOPE = 0.3, 0.05
"""The iteration ends at a shift below this share of the noise and slopes below this."""
_LEAST_NORMAL_COSINE = 0.5
"""Neighbours whose normals differ by more than 60 degrees belong to another side."""


@njit(cache=True, nogil=True, error_model="numpy")
def project_to_surface(
    measured: MeasuredPoints,
    cubes: CubeTable,
    radius: float,
    noise: float,
    seeds: np.ndarray,
    projected: np.ndarray,
    projected_normals: np.ndarray,
):
    """Project seeds by moving least squares, into `projected` and `projected_normals`.

    measured  all measured points, in the order of the grid (cubes no smaller than the radius)
    noise     residuals of this size lose half of their weight, mm
    Returns for each seed its neighbours' total weight, 0 where there are too few for a surface.
    """
    support = np.zeros(len(seeds), np.float32)
    system = np.empty((_UNKNOWNS, _UNKNOWNS + 1))
    coefficients = np.zeros(_UNKNOWNS)
    position, axes = np.empty(3), np.empty((3, 3))
    for s in range(len(seeds)):
        position[:] = measured.points_mm[seeds[s]]
        axes[2] = measured.normals[seeds[s]]
        support[s] = _project_seed(
            measured, cubes, radius, noise, position, axes, system, coefficients
        )
        if support[s] > 0.0:
            projected[s], projected_normals[s] = position, axes[2]
    return support


@njit(cache=True, error_model="numpy")
def _project_seed(
    measured: MeasuredPoints, cubes: CubeTable, radius: float, noise: float,
    position: np.ndarray, axes: np.ndarray, system: np.ndarray, coefficients: np.ndarray,
):  # fmt: skip
    """Move a position, and its normal axes[2], to the surface of its neighbours.

    Returns the neighbours' total weight, 0 where there are too few for a surface.
    """
    total, depth_bias = 0.0, 0.0
    for _ in range(_MAX_ITERATIONS):
        _complete_axes(axes)
        coefficients[:] = 0.0
        total, count, window_mm2 = _accumulate_quadric(
            measured, cubes, radius, noise, position, axes, system
        )
        if count < _LEAST_NEIGHBOURS or not _solve_quadric(system, total, radius, coefficients):
            return 0.0
        shift, slope_u, slope_v = coefficients[0], coefficients[1], coefficients[2]
        if abs(shift) > radius:
            return 0.0
        length = math.sqrt(1 + slope_u**2 + slope_v**2)
        for i in range(3):
            position[i] += shift * axes[2, i]
        for i in range(3):
            axes[2, i] = (axes[2, i] - slope_u * axes[0, i] - slope_v * axes[1, i]) / length
        depth_bias = -0.5 * (coefficients[3] + coefficients[5]) * window_mm2
        if abs(shift) < _CONVERGED_SHIFT * noise and slope_u**2 + slope_v**2 < _CONVERGED_SLOPE**2:
            break
    for i in range(3):
        position[i] += depth_bias * axes[2, i]
    return total


@njit(cache=True, error_model="numpy")
def _complete_axes(axes: np.ndarray):
    """Normalise axes[2], and set axes[0] and axes[1] to unit vectors across it."""
    n = axes[2]
    n /= math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
    if abs(n[0]) > 0.7:
        axes[0, 0], axes[0, 1], axes[0, 2] = -n[2], 0.0, n[0]
    else:
        axes[0, 0], axes[0, 1], axes[0, 2] = 0.0, n[2], -n[1]
    t = axes[0]
    t /= math.sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
    axes[1, 0] = n[1] * t[2] - n[2] * t[1]
    axes[1, 1] = n[2] * t[0] - n[0] * t[2]
    axes[1, 2] = n[0] * t[1] - n[1] * t[0]


@njit(cache=True, error_model="numpy")
def _accumulate_quadric(
    measured: MeasuredPoints, cubes: CubeTable, radius: float, noise: float,
    position: np.ndarray, axes: np.ndarray, system: np.ndarray,
):  # fmt: skip
    """Set up the normal equations of the quadric round a position (upper triangle, right side).

    Returns the neighbours' total weight, their number, and the weighted mean of their windows.
    """
    points, normals, weights, windows = measured
    low, cell = cubes.low_mm, cubes.cell_mm
    system[:] = 0.0
    row = np.empty(_UNKNOWNS)
    x, y, z = position[0], position[1], position[2]
    total, window, count = 0.0, 0.0, 0
    i, j, k = int((x - low[0]) / cell), int((y - low[1]) / cell), int((z - low[2]) / cell)
    for neighbour in range(27):
        first, last = points_in_cube(
            cubes, i + neighbour // 9 - 1, j + neighbour // 3 % 3 - 1, k + neighbour % 3 - 1
        )
        for q in range(first, last):
            dx, dy, dz = points[q, 0] - x, points[q, 1] - y, points[q, 2] - z
            near = 1 - (dx * dx + dy * dy + dz * dz) / (radius * radius)
            if near <= 0:
                continue
            cosine = (
                normals[q, 0] * axes[2, 0] + normals[q, 1] * axes[2, 1] + normals[q, 2] * axes[2, 2]
            )
            if cosine < _LEAST_NORMAL_COSINE:
                continue
            u = dx * axes[0, 0] + dy * axes[0, 1] + dz * axes[0, 2]
            v = dx * axes[1, 0] + dy * axes[1, 1] + dz * axes[1, 2]
            h = dx * axes[2, 0] + dy * axes[2, 1] + dz * axes[2, 2]
            relative_residual = h / (noise + 0.15 * (abs(u) + abs(v)))
            weight = weights[q] * near * near * cosine / (1 + relative_residual * relative_residual)
            row[0], row[1], row[2] = 1.0, u, v
            row[3], row[4], row[5] = 0.5 * u * u, u * v, 0.5 * v * v
            for a in range(_UNKNOWNS):
                scaled = weight * row[a]
                for b in range(a, _UNKNOWNS):
                    system[a, b] += scaled * row[b]
                system[a, _UNKNOWNS] += scaled * h
            total += weight
            window += weight * windows[q]
            count += 1
    return total, count, window / max(total, 1e-30)


@njit(cache=True, error_model="numpy")
def _solve_quadric(system: np.ndarray, total: float, radius: float, coefficients: np.ndarray):
    """Solve the regularised normal equations; False if they have no solution."""
    for a in range(1, _UNKNOWNS):
        reach = radius if a < 3 else 0.5 * radius * radius
        system[a, a] += _REGULARISATION * total * reach * reach * (0.01 if a < 3 else 1.0)
    return solve_positive(system, 1e-12 * total, coefficients)


_LEAST_POINTS = 300
"""Fewer points are refused."""


_SMOOTHING = 2.5
"""Reach of the smoothing, in spacings."""
LEAST_VIEWS = 2
"""Photos that must agree on a point. Two show sides near the ground that three rarely see; a
rim that is wrong is cut back when the surface is measured."""


@dataclass(frozen=True, kw_only=True)
class FusionOptions:
    """How dense and how smooth the cloud is."""

    least_share: float = 0.01
    """Connected pieces with less than this share of the points are left out."""
    seed: int = 1
    """Decides which of the measured points are kept."""


DEFAULTS = FusionOptions()

_SPACING_PX = 1.75
"""Distance between neighbours of the cloud, in pixels of the depth maps."""
_NOISE_PX = 0.2
"""Distance from the surface, in pixels, at which a measured point's weight halves."""
_PIECE_REACH = 3.0
"""Points within this many spacings belong to one piece."""


def fuse(
    photos: PhotoSet,
    metric: MetricScene,
    depth_maps: Sequence[DepthMap],
    region: Region,
    options: FusionOptions = DEFAULTS,
) -> Cloud:
    """One cloud from all depth maps.

    Raises:
        DenseError: too few points were measured that several photos agree on.
    """
    pixel_mm = _pixel_mm(depth_maps)
    spacing_mm = _SPACING_PX * pixel_mm
    stride = max(1, round(0.5 * spacing_mm / pixel_mm))
    parts = in_parallel(lambda depth_map: _measured_points(depth_map, stride), depth_maps)
    measured = MeasuredPoints(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))
    if len(measured.points_mm) < _LEAST_POINTS:
        raise _too_few(len(measured.points_mm))
    points, normals = _surface_points(measured, spacing_mm, _NOISE_PX * pixel_mm, options)
    inside = region.contains(points.astype(float))
    points, normals = points[inside], normals[inside]
    visibility = point_visibility(photos, metric, depth_maps, points, normals, spacing_mm / 2)
    kept = visibility.views >= min(LEAST_VIEWS, len(depth_maps))
    kept &= visibility.through <= visibility.views
    kept[kept] = _in_large_pieces(points[kept], _PIECE_REACH * spacing_mm, options.least_share)
    if kept.sum() < _LEAST_POINTS:
        raise _too_few(int(kept.sum()))
    return Cloud(
        points_mm=points[kept],
        normals=normals[kept],
        colours=visibility.colours[kept],
        views=visibility.views[kept],
        spacing_mm=spacing_mm,
    )


def _pixel_mm(depth_maps: Sequence[DepthMap]) -> float:
    """Typical size of a depth map's pixel on the surface, across the line of sight."""
    sizes = [
        float(np.nanmedian(depth_map.depth_mm)) / depth_map.camera.fx
        for depth_map in depth_maps
        if np.isfinite(depth_map.depth_mm).any()
    ]
    if not sizes:
        raise DenseError("depth.empty")
    return float(np.median(sizes))


def _measured_points(depth_map: DepthMap, stride: int) -> MeasuredPoints:
    """Every stride-th pixel of every stride-th row as an oriented point in the world."""
    depth_mm = depth_map.depth_mm[::stride, ::stride].astype(float)
    measured = np.isfinite(depth_mm)
    rows, columns = np.nonzero(measured)
    depth_mm = depth_mm[rows, columns]
    rows, columns = rows * stride, columns * stride
    camera, world_from_camera = depth_map.camera, depth_map.camera_from_world.inverse
    y = (rows + depth_map.y0 - camera.cy) / camera.fy
    x = (columns + depth_map.x0 - camera.cx - camera.skew * y) / camera.fx
    in_camera = np.stack([x, y, np.ones_like(x)], axis=1) * depth_mm[:, None]
    normals = depth_map.normal_in_camera[rows, columns].astype(float)
    cosine = -(normals * in_camera).sum(1) / np.linalg.norm(in_camera, axis=1)
    cosine = np.clip(cosine, 0.05, 1)
    confidence = depth_map.confidence[rows, columns]
    pixel_mm = depth_mm / camera.fx
    return MeasuredPoints(
        points_mm=world_from_camera.apply(in_camera).astype(np.float32),
        normals=(normals @ world_from_camera.rotation.T).astype(np.float32),
        weights=(confidence**2 * cosine**2).astype(np.float32),
        windows_mm2=(depth_map.window_px2 * pixel_mm**2 * (1 + cosine**-2) / 2).astype(np.float32),
    )


def _surface_points(
    measured: MeasuredPoints, spacing_mm: float, noise_mm: float, options: FusionOptions
) -> tuple[Float32[np.ndarray, "n 3"], Float32[np.ndarray, "n 3"]]:
    """Evenly spaced points and their normals on the surface of the measured ones."""
    radius_mm = _SMOOTHING * spacing_mm
    grid = hash_grid(measured.points_mm, radius_mm)
    measured = MeasuredPoints(*(array[grid.order] for array in measured))
    visiting_order = np.random.default_rng(options.seed).permutation(len(measured.points_mm))
    seeds = np.flatnonzero(
        poisson_disk_thinned(measured.points_mm, visiting_order, grid.cubes, spacing_mm)
    )

    def project(part: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        points, normals = np.zeros((2, len(part), 3), np.float32)
        support = project_to_surface(
            measured, grid.cubes, radius_mm, noise_mm, part, points, normals
        )
        return points[support > 0], normals[support > 0]

    parts = np.array_split(seeds, 4 * worker_count())
    results = in_parallel(project, parts)
    return np.concatenate([r[0] for r in results]), np.concatenate([r[1] for r in results])


def _in_large_pieces(
    points_mm: Float32[np.ndarray, "n 3"], reach_mm: float, least_share: float
) -> np.ndarray:
    """Which points belong to a connected piece of at least `least_share` of all."""
    pairs = KDTree(points_mm).query_pairs(reach_mm, output_type="ndarray")
    piece = components(pairs, len(points_mm))
    return (np.bincount(piece) >= least_share * len(points_mm))[piece]


def _too_few(count: int) -> DenseError:
    return DenseError("depth.few_points", count=int(count), least=_LEAST_POINTS)
