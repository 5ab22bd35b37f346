"""Measurement: every vertex of the surface measured again in the photos that see it.

In      photos, a metric scene and a mesh within about two pixels of the truth.
Out     the mesh with its vertices moved along their normals; what no photo measured is `filled`.
Method  one small patch per vertex by multi-photo least-squares matching, coarse to fine, the
        whole surface held together as a thin plate (docs/method/measuring.md).
Fails   SurfaceError: hardly a vertex is seen by two photos.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.errors import SurfaceError
from limbgram.geometry.camera import View
from limbgram.measuring.imagery import Imagery, load_crops, prepare
from limbgram.measuring.patches import MEASURED, measure_patches
from limbgram.measuring.plate import plate_of, quadrics, settle, tangent_axes
from limbgram.measuring.visibility import best_views, incidence_cosines
from limbgram.photos.photo import PhotoSet
from limbgram.run import track
from limbgram.scale.metric import MetricScene
from limbgram.surface.mesh import Mesh

_UNMEASURED_PX = 1.0
"""What is believed of the given surface where no patch could be measured: one pixel, in sigma."""


@dataclass(frozen=True, kw_only=True)
class MeasureOptions:
    """How the surface is measured."""

    halvings: tuple[int, ...] = (1, 0)
    """Photo reductions of the rounds, coarse to fine: 1 is half size, 0 full size."""

    max_views: int = 6
    """Photos per patch, the most frontal ones."""

    max_incidence_deg: float = 65.0
    """Photos that see a patch at a flatter angle than this are left out."""

    min_correlation: float = 0.6
    """Mean correlation between the photos below which a patch is not believed."""

    plate_length_px: float = 2.5
    """Below this length, in pixels of the round's photos, the surface bends like a plate."""

    max_move_px: float = 4.0
    """A patch that wants to move further, in pixels of the round's photos, is not believed."""


DEFAULTS = MeasureOptions()


def measure(
    photos: PhotoSet, metric: MetricScene, mesh: Mesh, options: MeasureOptions = DEFAULTS
) -> Mesh:
    """Measure the surface at the full resolution of the photos."""
    scene = metric.scene
    views = scene.views
    crops = load_crops([photos.photos[k] for k in scene.placed], views, mesh.vertices_mm)
    measured = np.zeros(len(mesh), bool)
    for halvings in track(options.halvings):
        mesh, measured = _round(mesh, prepare(crops, views, halvings), views, options)
    if mesh.filled is not None:
        measured &= ~mesh.filled
    return replace(mesh, filled=~measured)


def _round(
    mesh: Mesh, imagery: Imagery, views: Sequence[View], options: MeasureOptions
) -> tuple[Mesh, Bool[np.ndarray, " n"]]:
    """One pass over all vertices: patches, then the plate."""
    plate = plate_of(mesh)
    axes = tangent_axes(mesh.vertex_normals())
    cosines = incidence_cosines(mesh, views, options.max_incidence_deg)
    seen_by = best_views(cosines, options.max_views)
    pixel_mm = _pixel_mm(mesh, views, seen_by[:, 0]) / imagery.factor
    state = np.zeros((len(mesh), 3))
    report = measure_patches(
        imagery.coefficients,
        imagery.crops,
        imagery.factor,
        imagery.views,
        seen_by,
        mesh.vertices_mm,
        axes,
        quadrics(mesh, plate, axes),
        pixel_mm,
        8,
        state,
    )
    offsets = state[:, 0]
    good = (
        (report[:, 0] == MEASURED)
        & (report[:, 3] >= options.min_correlation)
        & (np.abs(offsets) < options.max_move_px * pixel_mm)
    )
    if good.mean() < 0.05:
        raise SurfaceError(
            f"Only {good.sum()} of {len(mesh)} surface points look alike in two photos. The "
            "cameras or the surface are wrong, or the limb carries no paint. Check the pictures "
            "of the placed photos; paint more densely and photograph again."
        )
    sigma = np.where(good, np.maximum(report[:, 1], 0.02 * pixel_mm), _UNMEASURED_PX * pixel_mm)
    length_mm = options.plate_length_px * float(np.median(pixel_mm))
    moves = settle(mesh, plate, np.where(good, offsets, 0.0), 1 / sigma**2, length_mm)
    moves = np.clip(moves, -options.max_move_px * pixel_mm, options.max_move_px * pixel_mm)
    return mesh.with_vertices(mesh.vertices_mm + moves[:, None] * axes[:, 2]), good


def _pixel_mm(mesh: Mesh, views: Sequence[View], photo: np.ndarray) -> Float64[np.ndarray, " n"]:
    """Size of a full-size pixel on the object, in each vertex's most frontal photo."""
    sizes = np.full(len(mesh), np.nan)
    for k, view in enumerate(views):
        rows = photo == k
        depth = view.camera_from_world.apply(mesh.vertices_mm[rows])[:, 2]
        sizes[rows] = depth / np.sqrt(view.camera.fx * view.camera.fy)
    return np.where(np.isfinite(sizes), sizes, np.nanmedian(sizes))
