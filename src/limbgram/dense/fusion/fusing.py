"""Fusion: many depth maps to one cloud of evenly spaced, oriented points.

In      depth maps, and the photos for colour.
Out     a Cloud.
Method  all measured points together; evenly spaced ones among them become the cloud and move to
        the curved surface that all photos' points round them agree on; points that too few photos
        confirm, that more photos see through, and crumbs away from the surface, are left out.
Fails   DenseError: too few points agree.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import KDTree

from limbgram.dense.depth import DepthMap
from limbgram.dense.fusion.grid import Grid, grid_of, thin
from limbgram.dense.fusion.sighting import sight
from limbgram.dense.fusion.smoothing import project_to_surface
from limbgram.dense.region import Region
from limbgram.errors import DenseError, OptionsError
from limbgram.geometry.cloud import Cloud
from limbgram.photos.photo import PhotoSet
from limbgram.run import in_parallel, worker_count
from limbgram.scale.metric import MetricScene


@dataclass(frozen=True, kw_only=True)
class FusionOptions:
    """How dense and how smooth the cloud is."""

    spacing_mm: float | None = None
    """Distance between neighbours; None: 3.5 pixels of the depth maps."""
    smoothing: float = 2.5
    """Reach of the smoothing, in spacings."""
    least_views: int = 2
    """Photos that must agree on a point. Two show sides near the ground that three rarely see; a
    rim that is wrong is cut back when the surface is measured."""
    least_share: float = 0.01
    """Pieces with less than this share of the points are crumbs."""
    least_points: int = 300
    """Fewer points are refused."""
    seed: int = 1
    """Decides which of the measured points are kept."""


DEFAULTS = FusionOptions()

_SPACING_PX = 3.5
_NOISE_PX = 0.4
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
    spacing_mm = options.spacing_mm or _SPACING_PX * pixel_mm
    if not spacing_mm > 0 or not options.smoothing >= 1:
        raise OptionsError("spacing_mm must be positive and smoothing at least 1.")
    stride = max(1, round(0.5 * spacing_mm / pixel_mm))
    parts = in_parallel(lambda depth_map: _measured(depth_map, stride), depth_maps)
    measured = Measured(
        points_mm=np.concatenate([part.points_mm for part in parts]),
        normals=np.concatenate([part.normals for part in parts]),
        weights=np.concatenate([part.weights for part in parts]),
        windows_mm2=np.concatenate([part.windows_mm2 for part in parts]),
    )
    if len(measured.points_mm) < options.least_points:
        raise _too_few(len(measured.points_mm), options)
    points, normals = _surface(measured, spacing_mm, _NOISE_PX * pixel_mm, options)
    inside = region.contains(points.astype(float))
    points, normals = points[inside], normals[inside]
    sightings = sight(photos, metric, depth_maps, points, normals, spacing_mm / 2)
    kept = sightings.views >= min(options.least_views, len(depth_maps))
    kept &= sightings.through <= sightings.views
    kept[kept] = _in_large_pieces(points[kept], _PIECE_REACH * spacing_mm, options.least_share)
    if kept.sum() < options.least_points:
        raise _too_few(int(kept.sum()), options)
    return Cloud(
        points_mm=points[kept],
        normals=normals[kept],
        colours=sightings.colours[kept],
        views=sightings.views[kept],
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
        raise DenseError(
            "The depth maps are empty: nothing on the limb could be measured. Paint the sock with "
            "dense, irregular spots, and photograph again with more overlap."
        )
    return float(np.median(sizes))


def _measured(depth_map: DepthMap, stride: int) -> Measured:
    """Every stride-th pixel of every stride-th row as an oriented point in the world."""
    depth_mm = depth_map.depth_mm[::stride, ::stride].astype(float)
    rows, columns = np.nonzero(np.isfinite(depth_mm))
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
    radius_mm = options.smoothing * spacing_mm
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


def _too_few(count: int, options: FusionOptions) -> DenseError:
    return DenseError(
        f"Only {count} points of the surface could be measured that several photos agree on; "
        f"{options.least_points} are needed. The sock is probably unpainted, or the photos "
        "overlap too little. Paint it with dense, irregular spots, and photograph again."
    )
