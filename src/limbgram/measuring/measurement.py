"""Measurement: every vertex of the surface measured again in the photos that see it.

In      photos, a metric scene and a mesh within about two pixels of the truth.
Out     the mesh with its vertices moved along their normals. `filled` are the vertices that were
        given as filled and those that fewer than two photos see; where the photos show too little
        to match, a vertex stays as the depth maps measured it.
Method  multi-photo least-squares matching, coarse to fine: a small patch per vertex first, then
        all vertices at once; the surface is held together as a thin plate (docs/method).
Fails   SurfaceError: hardly a vertex looks alike in two photos.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float64

from limbgram.measuring.imagery import load_crops, prepare
from limbgram.measuring.rounds import MatchingOptions, Sight, look, match_jointly, match_patches
from limbgram.measuring.visibility import best_views, incidence_cosines
from limbgram.photos.photo import PhotoSet
from limbgram.run import track
from limbgram.scale.metric import MetricScene
from limbgram.surface.mesh import Mesh
from limbgram.surface.repair.trimming import cut_back

_GRAZING_DEG = 85.0
"""A photo that looks along the surface more closely than this does not see it."""


@dataclass(frozen=True, kw_only=True)
class MeasureOptions:
    """Which rounds are made."""

    patch_halvings: tuple[int, ...] = (1, 0)
    """Photo reductions of the rounds of patches, coarse to fine: 1 is half size, 0 full size."""

    joint_rounds: int = 2
    """Rounds at full size in which all vertices are measured at once."""

    rim_rings: int = 8
    """Rows of vertices by which an opening's rim is cut back where patches found no agreement."""

    matching: MatchingOptions = field(default_factory=MatchingOptions)


DEFAULTS = MeasureOptions()


def measure(
    photos: PhotoSet, metric: MetricScene, mesh: Mesh, options: MeasureOptions = DEFAULTS
) -> Mesh:
    """Measure the surface at the full resolution of the photos."""
    scene = metric.scene
    views = scene.views
    crops = load_crops([photos.photos[k] for k in scene.placed], views, mesh.vertices_mm)
    matching = options.matching
    cosines = incidence_cosines(mesh, views, _GRAZING_DEG)
    unseen = (cosines > 0).sum(axis=1) < 2
    cosines[cosines < np.cos(np.radians(matching.max_incidence_deg))] = 0
    seen_by = best_views(cosines, matching.max_views)  # moves are too small to change what is seen
    believed = np.zeros(len(mesh), bool)
    for halvings in track(options.patch_halvings):
        imagery = prepare(crops, views, halvings)
        sight = look(mesh, imagery, views, seen_by)
        moves, believed = match_patches(mesh, imagery, sight, matching)
        mesh = _moved(mesh, moves, sight, matching)
    imagery = prepare(crops, views, 0)
    for _ in track(range(options.joint_rounds)):
        sight = look(mesh, imagery, views, seen_by)
        mesh = _moved(mesh, match_jointly(mesh, imagery, sight, matching), sight, matching)
    filled = unseen if mesh.filled is None else unseen | mesh.filled
    return cut_back(replace(mesh, filled=filled), ~believed, options.rim_rings)


def _moved(
    mesh: Mesh, moves_mm: Float64[np.ndarray, " n"], sight: Sight, options: MatchingOptions
) -> Mesh:
    """The vertices moved along their normals, no further than is believed."""
    limit = options.max_move_px * sight.pixel_mm
    moves_mm = np.clip(moves_mm, -limit, limit)
    return mesh.with_vertices(mesh.vertices_mm + moves_mm[:, None] * sight.axes[:, 2])
