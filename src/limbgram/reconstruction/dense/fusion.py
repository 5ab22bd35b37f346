"""Fusion: many depth maps to one cloud of evenly spaced, oriented points.

In      depth maps, and the photos for colour.
Out     a Cloud.
Method  All measured points together; evenly spaced ones among them become the cloud and move to
        the curved surface that all photos' points round them agree on. Points that too few photos
        confirm, points that more photos see through, and crumbs away from the surface are left out.
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

import cv2
import numpy as np
from jaxtyping import Float32, Float64, Int64, UInt8, UInt16
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import KDTree

from limbgram.core.errors import DenseError
from limbgram.core.geometry.lens import View
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Cloud
from limbgram.core.run import in_parallel, worker_count
from limbgram.core.solvers import solve_positive
from limbgram.reconstruction.dense.depth import DepthMap
from limbgram.reconstruction.dense.region import Region
from limbgram.reconstruction.photos.decoding import halvings_to, in_flight_mb, load_colour
from limbgram.reconstruction.photos.photo import Photo, PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene

_MULTIPLIER = 0x9E3779B1
_AXIS_BITS = 21
"""Cubes along each axis are counted with this many bits."""


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Points in the order of their cubes."""

    order: Int64[np.ndarray, " n"]
    """Index of each sorted point in the original order."""
    low_mm: Float64[np.ndarray, "3"]
    cell_mm: float
    keys: Int64[np.ndarray, " slots"]
    """Hash table: key of a cube, -1 for an empty slot."""
    spans: Int64[np.ndarray, "slots 2"]
    """First sorted point of the cube and one past the last."""


def grid_of(points_mm: Float32[np.ndarray, "n 3"], cell_mm: float) -> Grid:
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
    _fill(ordered[first], first, count, keys, spans)
    return Grid(order=order, low_mm=low, cell_mm=cell_mm, keys=keys, spans=spans)


@njit(inline="always")
def span_of(keys: np.ndarray, spans: np.ndarray, i: int, j: int, k: int):
    """Sorted points of cube (i, j, k): first and one past the last."""
    key = (i << 2 * _AXIS_BITS) | (j << _AXIS_BITS) | k
    slot = _slot_of(key, len(keys))
    while keys[slot] != key and keys[slot] >= 0:
        slot = (slot + 1) & (len(keys) - 1)
    if keys[slot] < 0:
        return 0, 0
    return spans[slot, 0], spans[slot, 1]


@njit(inline="always")
def _slot_of(key: int, slots: int):
    mixed = (key ^ (key >> 29)) * _MULTIPLIER
    return (mixed ^ (mixed >> 17)) & (slots - 1)


@njit(cache=True, nogil=True)
def _fill(
    unique: np.ndarray, first: np.ndarray, count: np.ndarray, keys: np.ndarray, spans: np.ndarray
):
    for k in range(len(unique)):
        slot = _slot_of(unique[k], len(keys))
        while keys[slot] >= 0:
            slot = (slot + 1) & (len(keys) - 1)
        keys[slot] = unique[k]
        spans[slot, 0] = first[k]
        spans[slot, 1] = first[k] + count[k]


@njit(cache=True, nogil=True)
def thin(
    points: np.ndarray,
    order: np.ndarray,
    low: np.ndarray,
    cell: float,
    keys: np.ndarray,
    spans: np.ndarray,
    spacing: float,
):
    """Poisson-disk thinning: of `points` (in the grid's order), visited in `order`, those that are
    kept lie at least `spacing` (at most one cell) apart, and no dropped one has room for itself."""
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
                    first, last = span_of(keys, spans, i + di, j + dj, k + dk)
                    for q in range(first, last):
                        x = points[q, 0] - points[p, 0]
                        y = points[q, 1] - points[p, 1]
                        z = points[q, 2] - points[p, 2]
                        if x * x + y * y + z * z < spacing * spacing:
                            blocked[q] = True
    return kept


_BEHIND = 4.0
"""Something this many tolerances behind a point is another surface."""


@dataclass(frozen=True, kw_only=True)
class PointVisibility:
    """By point: photos whose depth map has it, and its mean colour in them."""

    views: UInt16[np.ndarray, " n"]
    through: UInt16[np.ndarray, " n"]
    """Photos that saw something behind the point: it would have hidden that."""
    colours: UInt8[np.ndarray, "n 3"]


def point_visibility(
    photos: PhotoSet,
    metric: MetricScene,
    depth_maps: Sequence[DepthMap],
    points_mm: Float32[np.ndarray, "n 3"],
    normals: Float32[np.ndarray, "n 3"],
    agree_mm: float,
) -> PointVisibility:
    """Look for each point in each depth map; where it is, the photo's colour counts by cosine^2."""

    def one(depth_map: DepthMap) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        seen, cosine, through = _seen(depth_map, points_mm, normals, agree_mm)
        view = metric.scene.view(depth_map.photo_idx)
        colours = _colours(photos.photos[depth_map.photo_idx], view, halvings, points_mm[seen])
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
    for seen, weight, colours, behind in in_parallel(one, depth_maps, each_mb=each_mb):
        views[seen] += 1
        through[behind] += 1
        weights[seen] += weight
        sums[seen] += weight[:, None] * colours
    colours = np.round(sums / weights[:, None]).astype(np.uint8)
    return PointVisibility(views=views, through=through, colours=colours)


def _seen(
    depth_map: DepthMap,
    points_mm: Float32[np.ndarray, "n 3"],
    normals: Float32[np.ndarray, "n 3"],
    agree_mm: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points that the map has, the cosines of their incidence, and points it saw behind of."""
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
    return seen, cosine[seen], within[behind_mm > _BEHIND * tolerance_mm]


def _colours(
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


_UNKNOWNS = 6
_LEAST_NEIGHBOURS = 8
_BEND_PRIOR = 0.001
"""Weight of the wish for a plane, as a fraction of the neighbours' weight: it decides only where
the neighbours lie on a line or to one side."""
_ROUNDS = 3
_STILL, _STILL_SLOPE = 0.3, 0.05
"""A point that moved by less than this share of the noise, and turned by less than this, stays."""
_FACING = 0.5
"""Neighbours whose normals turn away by more than 60 degrees belong to another side."""


@njit(cache=True, nogil=True, error_model="numpy")
def project_to_surface(
    points: np.ndarray,
    normals: np.ndarray,
    weights: np.ndarray,
    windows: np.ndarray,
    low: np.ndarray,
    cell: float,
    keys: np.ndarray,
    spans: np.ndarray,
    radius: float,
    noise: float,
    seeds: np.ndarray,
    moved: np.ndarray,
    turned: np.ndarray,
):
    """Move seeds[k] to the surface of their neighbours, into moved[k] and turned[k].

    points, normals, weights   all measured points, in the grid's order (cell >= radius)
    windows   (n,) mean squared reach of the correlation windows on the surface, mm^2
    noise     residuals of this size lose half of their weight, mm
    Returns for each seed its neighbours' total weight, 0 where there are too few for a surface.
    """
    support = np.zeros(len(seeds), np.float32)
    system = np.empty((_UNKNOWNS, _UNKNOWNS + 1))
    axes = np.empty((3, 3))
    coefficients = np.zeros(_UNKNOWNS)
    for s in range(len(seeds)):
        p = seeds[s]
        x, y, z = np.float64(points[p, 0]), np.float64(points[p, 1]), np.float64(points[p, 2])
        axes[2, 0], axes[2, 1], axes[2, 2] = normals[p, 0], normals[p, 1], normals[p, 2]
        sunk = 0.0
        solved = False
        for _ in range(_ROUNDS):
            _tangents(axes)
            coefficients[:] = 0.0
            total, count, sunk_window = _gather(
                points, normals, weights, windows, low, cell, keys, spans, radius, noise,
                x, y, z, axes, system,
            )  # fmt: skip
            solved = count >= _LEAST_NEIGHBOURS and _solve(system, total, radius, coefficients)
            if not solved or abs(coefficients[0]) > radius:
                solved = False
                break
            support[s] = total
            step, along_u, along_v = coefficients[0], coefficients[1], coefficients[2]
            x += step * axes[2, 0]
            y += step * axes[2, 1]
            z += step * axes[2, 2]
            length = math.sqrt(1 + along_u**2 + along_v**2)
            for i in range(3):
                axes[2, i] = (axes[2, i] - along_u * axes[0, i] - along_v * axes[1, i]) / length
            sunk = -0.5 * (coefficients[3] + coefficients[5]) * sunk_window
            if abs(step) < _STILL * noise and along_u**2 + along_v**2 < _STILL_SLOPE**2:
                break
        if not solved:
            support[s] = 0.0
            continue
        moved[s, 0] = x + sunk * axes[2, 0]
        moved[s, 1] = y + sunk * axes[2, 1]
        moved[s, 2] = z + sunk * axes[2, 2]
        turned[s, 0], turned[s, 1], turned[s, 2] = axes[2, 0], axes[2, 1], axes[2, 2]
    return support


@njit(cache=True, error_model="numpy")
def _tangents(axes: np.ndarray):
    """Two unit vectors across axes[2], which is made unit too."""
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
def _gather(
    points: np.ndarray, normals: np.ndarray, weights: np.ndarray, windows: np.ndarray,
    low: np.ndarray, cell: float, keys: np.ndarray, spans: np.ndarray, radius: float, noise: float,
    x: float, y: float, z: float, axes: np.ndarray, system: np.ndarray,
):  # fmt: skip
    """Normal equations (upper triangle and right side) of the neighbours of (x, y, z).

    Returns their weight, their number, and their mean window.
    """
    system[:] = 0.0
    row = np.empty(_UNKNOWNS)
    total, window, count = 0.0, 0.0, 0
    i, j, k = int((x - low[0]) / cell), int((y - low[1]) / cell), int((z - low[2]) / cell)
    for neighbour in range(27):
        first, last = span_of(
            keys, spans, i + neighbour // 9 - 1, j + neighbour // 3 % 3 - 1, k + neighbour % 3 - 1
        )
        for q in range(first, last):
            dx, dy, dz = points[q, 0] - x, points[q, 1] - y, points[q, 2] - z
            near = 1 - (dx * dx + dy * dy + dz * dz) / (radius * radius)
            if near <= 0:
                continue
            alike = (
                normals[q, 0] * axes[2, 0] + normals[q, 1] * axes[2, 1] + normals[q, 2] * axes[2, 2]
            )
            if alike < _FACING:
                continue
            u = dx * axes[0, 0] + dy * axes[0, 1] + dz * axes[0, 2]
            v = dx * axes[1, 0] + dy * axes[1, 1] + dz * axes[1, 2]
            h = dx * axes[2, 0] + dy * axes[2, 1] + dz * axes[2, 2]
            off = h / (noise + 0.15 * (abs(u) + abs(v)))
            weight = weights[q] * near * near * alike / (1 + off * off)
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
def _solve(system: np.ndarray, total: float, radius: float, coefficients: np.ndarray):
    """Solve the normal equations, slopes and bends held a little; False if they have none."""
    for a in range(1, _UNKNOWNS):
        reach = radius if a < 3 else 0.5 * radius * radius
        system[a, a] += _BEND_PRIOR * total * reach * reach * (0.01 if a < 3 else 1.0)
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
    """Pieces with less than this share of the points are crumbs."""
    seed: int = 1
    """Decides which of the measured points are kept."""


DEFAULTS = FusionOptions()

_SPACING_PX = 1.75
"""Distance between neighbours of the cloud, in pixels of the depth maps."""
_NOISE_PX = 0.2
"""Distance from the surface, in pixels, at which a measured point's weight halves."""
_PIECE_REACH = 3.0
"""Points within this many spacings belong to one piece."""


@dataclass(frozen=True, kw_only=True)
class Measured:
    """Points of all depth maps together."""

    points_mm: Float32[np.ndarray, "n 3"]
    normals: Float32[np.ndarray, "n 3"]
    weights: Float32[np.ndarray, " n"]
    windows_mm2: Float32[np.ndarray, " n"]

    def sorted_by(self, grid: Grid) -> "Measured":
        return Measured(
            points_mm=self.points_mm[grid.order],
            normals=self.normals[grid.order],
            weights=self.weights[grid.order],
            windows_mm2=self.windows_mm2[grid.order],
        )


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
    parts = in_parallel(lambda depth_map: _measured(depth_map, stride), depth_maps)
    measured = Measured(
        points_mm=np.concatenate([part.points_mm for part in parts]),
        normals=np.concatenate([part.normals for part in parts]),
        weights=np.concatenate([part.weights for part in parts]),
        windows_mm2=np.concatenate([part.windows_mm2 for part in parts]),
    )
    if len(measured.points_mm) < _LEAST_POINTS:
        raise _too_few(len(measured.points_mm))
    points, normals = _surface(measured, spacing_mm, _NOISE_PX * pixel_mm, options)
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


def _measured(depth_map: DepthMap, stride: int) -> Measured:
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
    return Measured(
        points_mm=world_from_camera.apply(in_camera).astype(np.float32),
        normals=(normals @ world_from_camera.rotation.T).astype(np.float32),
        weights=(confidence**2 * cosine**2).astype(np.float32),
        windows_mm2=(depth_map.window_px2 * pixel_mm**2 * (1 + cosine**-2) / 2).astype(np.float32),
    )


def _surface(
    measured: Measured, spacing_mm: float, noise_mm: float, options: FusionOptions
) -> tuple[Float32[np.ndarray, "n 3"], Float32[np.ndarray, "n 3"]]:
    """Evenly spaced points and their normals on the surface of the measured ones."""
    radius_mm = _SMOOTHING * spacing_mm
    grid = grid_of(measured.points_mm, radius_mm)
    measured = measured.sorted_by(grid)
    lookup = (grid.low_mm, grid.cell_mm, grid.keys, grid.spans)
    visits = np.random.default_rng(options.seed).permutation(len(measured.points_mm))
    seeds = np.flatnonzero(thin(measured.points_mm, visits, *lookup, spacing_mm))

    def project(share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        points, normals = np.zeros((2, len(share), 3), np.float32)
        support = project_to_surface(
            measured.points_mm, measured.normals, measured.weights, measured.windows_mm2,
            *lookup, radius_mm, noise_mm, share, points, normals,
        )  # fmt: skip
        return points[support > 0], normals[support > 0]

    shares = np.array_split(seeds, 4 * worker_count())
    results = in_parallel(project, shares)
    return np.concatenate([r[0] for r in results]), np.concatenate([r[1] for r in results])


def _in_large_pieces(
    points_mm: Float32[np.ndarray, "n 3"], reach_mm: float, least_share: float
) -> np.ndarray:
    """Whether each point belongs to a connected piece of some size."""
    pairs = KDTree(points_mm).query_pairs(reach_mm, output_type="ndarray")
    ones = np.ones(len(pairs), np.int8)
    graph = sparse.coo_array((ones, (pairs[:, 0], pairs[:, 1])), (len(points_mm),) * 2)
    piece = csgraph.connected_components(graph, directed=False)[1]
    return (np.bincount(piece) >= least_share * len(points_mm))[piece]


def _too_few(count: int) -> DenseError:
    return DenseError("depth.few_points", count=int(count), least=_LEAST_POINTS)
