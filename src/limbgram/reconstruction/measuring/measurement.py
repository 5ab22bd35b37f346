"""Measurement: every vertex of the surface measured again in the photos that see it.

In      photos, a metric scene and a mesh within about two pixels of the truth.
Out     the mesh with its vertices moved along their normals. `filled` are the vertices that were
        given as filled, or guessed to close a notch of the brim, unless texture that photos share
        holds them, and those that fewer than two photos see; where the photos show too little
        to match, a vertex stays as the depth maps measured it. Where `lay_back_overshoot` is asked
        for, what stands out past a sharp edge is laid back and counts as filled
        (`edge_overshoot`); so does what the measurement folds (`core.mesh.folds`).
Method  multi-photo least-squares matching, coarse to fine: a small patch per vertex first, then
        all vertices at once; the surface is held together as a thin plate (docs/method).
Fails   SurfaceError: hardly a vertex looks alike in two photos.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float32, Float64, Int32, Int64

from limbgram.core.geometry.arrays import Faces
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.folds import find_folds, unfolded
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_half_edges, with_any, with_faces
from limbgram.core.run import track
from limbgram.reconstruction.measuring.edge_overshoot import without_overshoot
from limbgram.reconstruction.measuring.grain import grained
from limbgram.reconstruction.measuring.imagery import Imagery, load_crops, prepare
from limbgram.reconstruction.measuring.measurement_pass import (
    EARLY_ROBUST_SIGMAS,
    LEAST_VIEWS,
    MAX_INCIDENCE_DEG,
    MAX_MOVE_PX,
    MAX_VIEWS,
    STEEP_INCIDENCE_DEG,
    JointEquations,
    ResidualOptions,
    SeenSurface,
    joint_equations,
    light_after,
    light_at,
    look,
    match_jointly,
    match_patches,
    match_within,
    signal_share,
)
from limbgram.reconstruction.measuring.uncertainty import with_sigma
from limbgram.reconstruction.measuring.usual_plate import ByUsualPlate, by_usual_plate, softened
from limbgram.reconstruction.measuring.visibility import best_views, incidences
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.surface.brim import BrimOptions, level_brim
from limbgram.reconstruction.surface.cleaning import cut_back, largest_manifold

_RINGS_ROUND = 6
"""Rings round a fill whose bend it goes on with."""
GRAZING_DEG = 85.0
"""A photo that looks along the surface more closely than this does not see it."""


_RIM_RINGS = 8
"""Rows of vertices by which an opening's rim is cut back where patches found no agreement."""
_LEAST_ALIKE = 0.02
"""Share of the patches inside that are less alike than one by an opening has to be."""
_BRIM_ROUNDS = 4
"""Rounds in which a closed notch is measured from its rim inwards."""


@dataclass(frozen=True, kw_only=True)
class MeasureOptions:
    """Which rounds are made."""

    photo_halvings: int = 0
    """Reductions of the photos for the whole measurement, which then holds 1 / 4^n of the pixels;
    every size below is relative to it."""

    joint_rounds: int = 3
    """Rounds after the one of patches, in which all vertices are measured at once. Two do where
    paint is dense; between dabs each takes some more of what the depth maps got wrong."""

    brim: BrimOptions = field(default_factory=BrimOptions)
    """What counts as a notch of the open end, to be closed."""

    lay_back_overshoot: bool = False
    """Whether what stands out past a sharp edge without being measured is laid back; for closed
    surfaces of objects with a cut."""

    matching: ResidualOptions = field(default_factory=ResidualOptions)


DEFAULTS = MeasureOptions()


def measure(
    photos: PhotoSet, metric: MetricScene, mesh: Mesh, options: MeasureOptions = DEFAULTS
) -> Mesh:
    """Measure the surface in the photos, at their full size unless the options reduce them."""
    scene = metric.scene
    views = scene.views
    placed = [photos.photos[k] for k in scene.placed]
    crops = load_crops(placed, views, mesh.vertices_mm, options.photo_halvings)
    seen_by = _seen_by(mesh, views)[0]  # moves are too small to change what is seen
    at_rim = np.zeros(len(mesh), bool)
    at_rim[boundary_half_edges(mesh.faces).ravel()] = True
    rim = _near(at_rim, mesh.faces, _RIM_RINGS + 1)
    imagery = prepare(crops, views)
    del crops  # all photos are in the imagery a second time
    mesh, believed = _by_patches(mesh, imagery, views, seen_by, rim)
    mesh = cut_back(mesh, rim & ~believed, _RIM_RINGS)
    mesh, guessed = _with_even_brim(mesh, imagery, views, options)
    seen_by, unseen = _seen_by(mesh, views)
    mesh, found = _jointly(mesh, imagery, views, seen_by, options)
    mesh = replace(mesh, filled=unseen if mesh.filled is None else unseen | mesh.filled)
    if found is not None:
        mesh = with_sigma(mesh, *found, metric, guessed)
        mesh = without_overshoot(mesh) if options.lay_back_overshoot else mesh
    return _without_folds(mesh)


def _without_folds(mesh: Mesh) -> Mesh:
    """The mesh with what the measurement folded laid back, counted and marked as filled in.

    What cannot be laid back is left out, and the surface is open there.
    """
    found = unfolded(mesh)
    whole = found.mesh.area_mm2()
    laid = torn_open(found.mesh) if len(found.left) else found.mesh
    if laid.repairs is None:
        return laid
    lacks = laid.repairs.island_share + (1 - laid.area_mm2() / whole if whole else 0.0)
    return replace(
        laid, repairs=replace(laid.repairs, laid_back=found.vertices, island_share=lacks)
    )


def torn_open(mesh: Mesh) -> Mesh:
    """The largest piece of the surface without what is folded; nothing of it moves."""
    folds = find_folds(mesh)
    while len(folds):
        kept = mesh.faces[~with_any(folds.vertices(mesh), mesh.faces)]
        mesh = with_faces(mesh, largest_manifold(mesh.vertices_mm, kept))
        folds = find_folds(mesh)
    return mesh


def _by_patches(
    mesh: Mesh,
    imagery: Imagery,
    views: Sequence[View],
    seen_by: Int32[np.ndarray, "n c"],
    rim: Bool[np.ndarray, " n"],
) -> tuple[Mesh, Bool[np.ndarray, " n"]]:
    """The mesh moved by patches all over it, densely by the rim, and which of them count."""
    seen = look(mesh, imagery, views, seen_by)
    moves, alike = match_patches(mesh, imagery, seen, rim)
    counts = borne_out(seen.thin_plate.neighbours, alike, rim)
    return _moved(mesh, moves, seen), counts


def borne_out(
    neighbours: sp.csr_matrix, alike: Float32[np.ndarray, " n"], rim: Bool[np.ndarray, " n"]
) -> Bool[np.ndarray, " n"]:
    """Believed patches; by openings those alone that are alike beyond doubt or stand together.

    Depth maps reach past a sharp edge. Beyond it some patches look alike by chance, less than the
    limb's own do, and would hold up tongues of a surface that is not there. A patch by an opening
    that is less alike than nearly all inside counts while most of its neighbours count.

    Args:
        neighbours: (n, n), 1 where an edge joins two vertices.
        alike: Mean correlation of each believed patch, 0 elsewhere.
    """
    counts = alike > 0
    inside = alike[counts & ~rim]
    if not len(inside):
        return counts
    doubtful = rim & counts & (alike < np.quantile(inside, _LEAST_ALIKE))
    around = neighbours @ np.ones(len(alike))
    while True:
        alone = doubtful & counts & (2 * (neighbours @ counts) <= around)
        if not alone.any():
            return counts
        counts &= ~alone


def _jointly(
    mesh: Mesh,
    imagery: Imagery,
    views: Sequence[View],
    seen_by: Int32[np.ndarray, "n c"],
    options: MeasureOptions,
) -> tuple[Mesh, tuple[SeenSurface, JointEquations, ByUsualPlate] | None]:
    """The mesh moved by all vertices at once, and what moved it last."""
    light: Float32[np.ndarray, "n c 4"] | None = None
    moves_mm, signal = np.zeros(len(mesh)), np.ones(len(mesh))
    matching = options.matching
    early = replace(matching, robust_sigmas=EARLY_ROBUST_SIGMAS)
    for number in track(range(options.joint_rounds)):
        seen = look(mesh, imagery, views, seen_by)
        if light is None:
            light = light_at(mesh, imagery, seen, np.arange(len(mesh)))
            signal = signal_share(mesh, imagery, seen, light, matching)
        else:
            light = light_after(light, mesh, imagery, seen, moves_mm)
        last = number + 1 == options.joint_rounds
        robust = matching if last else early
        equations = joint_equations(mesh, imagery, seen, light, signal, robust)
        moved = _moved(mesh, match_jointly(mesh, equations), seen)
        if last:
            usual = by_usual_plate(moved, seen, equations)
            equations = grained(seen, softened(seen, equations, usual), usual)
            moved = _moved(mesh, match_jointly(mesh, equations), seen)
            return moved, (seen, equations, usual)
        moves_mm = np.einsum("ni,ni->n", moved.vertices_mm - mesh.vertices_mm, seen.axes[:, 2])
        mesh = moved
    return mesh, None


def _seen_by(
    mesh: Mesh,
    views: Sequence[View],
    asked: Int64[np.ndarray, " n"] | None = None,
) -> tuple[Int32[np.ndarray, "n c"], Bool[np.ndarray, " n"]]:
    """The photos that measure each vertex, and which vertices fewer than two photos see.

    Of all vertices, or of those asked.
    """
    best: list[Int32[np.ndarray, "b c"]] = []
    unseen: list[Bool[np.ndarray, " b"]] = []
    for cosines in incidences(mesh, views, GRAZING_DEG, asked):
        unseen.append((cosines > 0).sum(axis=1) < 2)
        squarely = cosines >= np.cos(np.radians(MAX_INCIDENCE_DEG))
        few = squarely.sum(axis=1, keepdims=True) < LEAST_VIEWS
        steeply = few & (cosines >= np.cos(np.radians(STEEP_INCIDENCE_DEG)))
        cosines[~(squarely | steeply)] = 0
        best.append(best_views(cosines, MAX_VIEWS))
    return np.concatenate(best), np.concatenate(unseen)


def _with_even_brim(
    mesh: Mesh, imagery: Imagery, views: Sequence[View], options: MeasureOptions
) -> tuple[Mesh, Bool[np.ndarray, " n"]]:
    """The brim's notches closed, and of what closes them measured what the photos show.

    Also tells which vertices, in a notch or elsewhere, were guessed before that.
    """
    whole = level_brim(mesh, options.brim)
    if whole is mesh or whole.filled is None:
        return mesh, np.zeros(len(mesh), bool) if mesh.filled is None else mesh.filled
    guessed = whole.filled
    part, chosen = _part(whole, _near(guessed, whole.faces))
    good = np.zeros(len(part), bool)
    seen_by, _ = _seen_by(whole, views, chosen)
    for _ in track(range(_BRIM_ROUNDS)):
        seen = look(part, imagery, views, seen_by)
        moves, good = match_within(part, imagery, seen, guessed[chosen])
        part = _moved(part, moves, seen)
        whole = whole.with_vertices(_put(whole.vertices_mm, chosen, part.vertices_mm))
    return replace(whole, filled=_put(guessed, chosen[good], np.False_)), guessed


def _near(
    chosen: Bool[np.ndarray, " n"], faces: Faces, rings: int = _RINGS_ROUND
) -> Bool[np.ndarray, " n"]:
    """The chosen vertices and some rings round them."""
    near = chosen.copy()
    for _ in range(rings):
        near[faces[near[faces].any(axis=1)]] = True
    return near


def _part(mesh: Mesh, near: Bool[np.ndarray, " n"]) -> tuple[Mesh, Int64[np.ndarray, " k"]]:
    """The faces with all corners among these, and the numbers of its vertices in the whole."""
    faces = mesh.faces[near[mesh.faces].all(axis=1)]
    return with_faces(mesh, faces), np.unique(faces).astype(np.int64)


def _put(values: np.ndarray, idx: np.ndarray, new: np.ndarray | np.bool_) -> np.ndarray:
    changed = values.copy()
    changed[idx] = new
    return changed


def _moved(mesh: Mesh, moves_mm: Float64[np.ndarray, " n"], seen: SeenSurface) -> Mesh:
    """The vertices moved along their normals, no further than is believed."""
    limit = MAX_MOVE_PX * seen.pixel_mm
    moves_mm = np.clip(moves_mm, -limit, limit)
    return mesh.with_vertices(mesh.vertices_mm + moves_mm[:, None] * seen.axes[:, 2])
