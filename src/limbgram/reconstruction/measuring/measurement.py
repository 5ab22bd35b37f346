"""Measurement: measures every vertex of the surface in the photos at full resolution.

In      photos, a metric scene and a mesh within about two pixels of the truth.
Out     the mesh with its vertices moved along their normals. `filled` are vertices that were given
        as filled, or guessed to close a notch of the brim, unless common texture measures them, and
        those that fewer than two photos see; where the photos show too little texture, a vertex
        stays as the depth maps measured it. With `lay_back_overshoot`, vertices that stand out past
        a sharp edge are pulled back and count as filled (`edge_overshoot`); so do those that the
        measurement folds (`core.mesh.folds`).
Method  multi-photo least-squares matching, coarse to fine: a small patch per vertex first, then
        all vertices jointly, regularised by a thin plate (docs/method).
Fails   SurfaceError: patches correlate at hardly any vertex.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float32, Float64, Int32, Int64

from limbgram.core.geometry.lens import View
from limbgram.core.mesh.folds import find_folds, unfolded
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_vertices, dilated, faces_touching, with_faces
from limbgram.core.run import track
from limbgram.reconstruction.measuring.anisotropic_plate import with_anisotropic_plate
from limbgram.reconstruction.measuring.edge_overshoot import without_overshoot
from limbgram.reconstruction.measuring.imagery import Imagery, build_imagery, load_crops
from limbgram.reconstruction.measuring.measurement_pass import (
    EARLY_ROBUST_SIGMAS,
    MAX_MOVE_PX,
    MAX_VIEWS,
    JointEquations,
    ObservedSurface,
    ResidualOptions,
    joint_equations,
    match_jointly,
    match_patches,
    match_selected,
    measuring_views,
    observe_surface,
    photometry_after,
    photometry_at,
    signal_share,
)
from limbgram.reconstruction.measuring.reference_plate import (
    ReferencePlateFit,
    fit_reference_plate,
    with_softer_plate,
)
from limbgram.reconstruction.measuring.uncertainty import with_sigma
from limbgram.reconstruction.measuring.visibility import (
    best_views,
    incidence_cosine_blocks,
    views_apart,
)
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.surface.brim import BrimOptions, level_brim
from limbgram.reconstruction.surface.cleaning import cut_back, largest_manifold

_CONTEXT_RINGS = 6
"""Rings round a fill that are matched together with it."""
GRAZING_DEG = 85.0
"""Incidence angle beyond which a photo does not see the surface."""
_RIM_RINGS = 8
"""Rows of vertices by which a rim is cut back at most where no patch is confirmed."""
_DOUBTFUL_QUANTILE = 0.02
"""Quantile of the interior patches' correlation below which a patch near a rim is doubtful."""
_BRIM_ROUNDS = 4
"""Rounds in which a closed notch is measured, from its rim inwards."""


@dataclass(frozen=True, kw_only=True)
class MeasureOptions:
    """Resolution, rounds and matching of the measurement."""

    photo_halvings: int = 0
    """Halvings of the photos for the whole measurement, which then uses 1 / 4^n of the pixels; all
    sizes in pixels refer to the reduced photos."""

    joint_rounds: int = 3
    """Rounds of joint matching after the one of patches. Two suffice where paint is dense; between
    dabs each corrects some more of the depth maps' errors."""

    brim: BrimOptions = field(default_factory=BrimOptions)
    """Which notches of the open end are closed."""

    lay_back_overshoot: bool = False
    """Whether poorly measured surface that stands out past a sharp edge is pulled back; for closed
    surfaces of objects with a cut."""

    matching: ResidualOptions = field(default_factory=ResidualOptions)


DEFAULTS = MeasureOptions()


def measure(
    photos: PhotoSet, metric: MetricScene, mesh: Mesh, options: MeasureOptions = DEFAULTS
) -> Mesh:
    """The mesh measured in the photos, at their full size unless the options reduce them."""
    scene = metric.scene
    views = scene.views
    placed = [photos.photos[k] for k in scene.placed]
    crops = load_crops(placed, views, mesh.vertices_mm, options.photo_halvings)
    seen_by = _measuring_photos(mesh, views)[0]  # moves are too small to change it
    at_rim = boundary_vertices(mesh.faces, len(mesh))
    near_rim = dilated(at_rim, mesh.faces, _RIM_RINGS + 1)
    imagery = build_imagery(crops, views)
    del crops  # the imagery has its own copy
    mesh, confirmed = _matched_by_patches(mesh, imagery, views, seen_by, near_rim)
    mesh = cut_back(mesh, near_rim & ~confirmed, _RIM_RINGS)
    mesh, guessed = _with_even_brim(mesh, imagery, views, options)
    seen_by, unseen = _measuring_photos(mesh, views)
    mesh, last_round = _matched_jointly(mesh, imagery, views, seen_by, options)
    mesh = replace(mesh, filled=unseen | ~mesh.measured)
    if last_round is not None:
        mesh = with_sigma(mesh, *last_round, metric, guessed)
        mesh = without_overshoot(mesh) if options.lay_back_overshoot else mesh
    return _without_folds(mesh)


def _without_folds(mesh: Mesh) -> Mesh:
    """The mesh with its folds flattened, counted and marked as filled.

    Folds that cannot be flattened are removed, and the surface is open there.
    """
    result = unfolded(mesh)
    area_mm2 = result.mesh.area_mm2()
    flat = torn_open(result.mesh) if len(result.left) else result.mesh
    if flat.repairs is None:
        return flat
    removed_share = 1 - flat.area_mm2() / area_mm2 if area_mm2 else 0.0
    missing_share = flat.repairs.island_share + removed_share
    repairs = replace(flat.repairs, laid_back=result.vertices, island_share=missing_share)
    return replace(flat, repairs=repairs)


def torn_open(mesh: Mesh) -> Mesh:
    """The largest component of the surface without its folds; no vertex moves."""
    folds = find_folds(mesh)
    while len(folds):
        kept = mesh.faces[~faces_touching(folds.vertices(mesh), mesh.faces)]
        mesh = with_faces(mesh, largest_manifold(mesh.vertices_mm, kept))
        folds = find_folds(mesh)
    return mesh


def _matched_by_patches(
    mesh: Mesh,
    imagery: Imagery,
    views: Sequence[View],
    seen_by: Int32[np.ndarray, "n c"],
    near_rim: Bool[np.ndarray, " n"],
) -> tuple[Mesh, Bool[np.ndarray, " n"]]:
    """The mesh moved by patches, one per vertex near rims, and which patches are confirmed."""
    observed = observe_surface(mesh, imagery, views, seen_by)
    moves, correlation = match_patches(mesh, imagery, observed, near_rim)
    confirmed = confirmed_patches(observed.thin_plate.neighbours, correlation, near_rim)
    return _moved(mesh, moves, observed), confirmed


def confirmed_patches(
    neighbours: sp.csr_matrix,
    correlation: Float32[np.ndarray, " n"],
    near_rim: Bool[np.ndarray, " n"],
) -> Bool[np.ndarray, " n"]:
    """Accepted patches; near rims only those of high correlation or among other confirmed ones.

    Depth maps reach past a sharp edge. Beyond it some patches correlate by chance, less than the
    limb's own do, and would support tongues of a surface that does not exist. A patch near a rim
    that correlates less than nearly all interior ones is confirmed while most of its neighbours
    are.

    Args:
        neighbours: (n, n), 1 where an edge joins two vertices.
        correlation: Mean correlation of each accepted patch, 0 elsewhere.
    """
    confirmed = correlation > 0
    inside = correlation[confirmed & ~near_rim]
    if not len(inside):
        return confirmed
    doubtful = near_rim & confirmed & (correlation < np.quantile(inside, _DOUBTFUL_QUANTILE))
    neighbour_count = neighbours @ np.ones(len(correlation))
    while True:
        isolated = doubtful & confirmed & (2 * (neighbours @ confirmed) <= neighbour_count)
        if not isolated.any():
            return confirmed
        confirmed &= ~isolated


def _matched_jointly(
    mesh: Mesh,
    imagery: Imagery,
    views: Sequence[View],
    seen_by: Int32[np.ndarray, "n c"],
    options: MeasureOptions,
) -> tuple[Mesh, tuple[ObservedSurface, JointEquations, ReferencePlateFit] | None]:
    """The mesh moved by joint matching, and the surface and equations of the last round."""
    photometry: Float32[np.ndarray, "n c 4"] | None = None
    moves_mm, signal = np.zeros(len(mesh)), np.ones(len(mesh))
    matching = options.matching
    early = replace(matching, robust_sigmas=EARLY_ROBUST_SIGMAS)
    for number in track(range(options.joint_rounds)):
        observed = observe_surface(mesh, imagery, views, seen_by)
        if photometry is None:
            photometry = photometry_at(mesh, imagery, observed, np.arange(len(mesh)))
            signal = signal_share(mesh, imagery, observed, photometry, matching)
        else:
            photometry = photometry_after(photometry, mesh, imagery, observed, moves_mm)
        last = number + 1 == options.joint_rounds
        round_options = matching if last else early
        equations = joint_equations(mesh, imagery, observed, photometry, signal, round_options)
        moved = _moved(mesh, match_jointly(mesh, equations), observed)
        if last:
            reference = fit_reference_plate(moved, observed, equations)
            equations = with_softer_plate(observed, equations, reference)
            equations = with_anisotropic_plate(observed, equations, reference)
            moved = _moved(mesh, match_jointly(mesh, equations), observed)
            return moved, (observed, equations, reference)
        moves_mm = np.einsum("ni,ni->n", moved.vertices_mm - mesh.vertices_mm, observed.axes[:, 2])
        mesh = moved
    return mesh, None


def _measuring_photos(
    mesh: Mesh,
    views: Sequence[View],
    selected: Int64[np.ndarray, " n"] | None = None,
) -> tuple[Int32[np.ndarray, "n c"], Bool[np.ndarray, " n"]]:
    """The photos that measure each vertex, and which vertices fewer than two photos see.

    All vertices are meant, or the selected ones.
    """
    apart = views_apart(views, mesh.vertices_mm.mean(0))
    best: list[Int32[np.ndarray, "b c"]] = []
    unseen: list[Bool[np.ndarray, " b"]] = []
    for cosines in incidence_cosine_blocks(mesh, views, GRAZING_DEG, selected):
        unseen.append((cosines > 0).sum(axis=1) < 2)
        cosines[~measuring_views(cosines)] = 0
        best.append(best_views(cosines, MAX_VIEWS, apart))
    return np.concatenate(best), np.concatenate(unseen)


def _with_even_brim(
    mesh: Mesh, imagery: Imagery, views: Sequence[View], options: MeasureOptions
) -> tuple[Mesh, Bool[np.ndarray, " n"]]:
    """The mesh with the brim's notches closed and, where photos show them, measured.

    Also returns which vertices, in a notch or elsewhere, were guessed before that.
    """
    closed = level_brim(mesh, options.brim)
    if closed is mesh or closed.filled is None:
        return mesh, ~mesh.measured
    guessed = closed.filled
    part, chosen = _submesh(closed, dilated(guessed, closed.faces, _CONTEXT_RINGS))
    accepted = np.zeros(len(part), bool)
    seen_by, _ = _measuring_photos(closed, views, chosen)
    for _ in track(range(_BRIM_ROUNDS)):
        observed = observe_surface(part, imagery, views, seen_by)
        moves, accepted = match_selected(part, imagery, observed, guessed[chosen])
        part = _moved(part, moves, observed)
        closed = closed.with_vertices(_with_values(closed.vertices_mm, chosen, part.vertices_mm))
    return replace(closed, filled=_with_values(guessed, chosen[accepted], np.False_)), guessed


def _submesh(mesh: Mesh, near: Bool[np.ndarray, " n"]) -> tuple[Mesh, Int64[np.ndarray, " k"]]:
    """The faces with all corners among these vertices, and the original numbers of its vertices."""
    faces = mesh.faces[near[mesh.faces].all(axis=1)]
    return with_faces(mesh, faces), np.unique(faces).astype(np.int64)


def _with_values(values: np.ndarray, idx: np.ndarray, new: np.ndarray | np.bool_) -> np.ndarray:
    """A copy with new values at these indices."""
    changed = values.copy()
    changed[idx] = new
    return changed


def _moved(mesh: Mesh, moves_mm: Float64[np.ndarray, " n"], observed: ObservedSurface) -> Mesh:
    """The mesh with its vertices moved along their normals, by no more than the limit."""
    limit = MAX_MOVE_PX * observed.pixel_mm
    moves_mm = np.clip(moves_mm, -limit, limit)
    return mesh.with_vertices(mesh.vertices_mm + moves_mm[:, None] * observed.axes[:, 2])
