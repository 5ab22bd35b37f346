"""Measurement pass: one round of matching over the surface, by single patches or jointly.

In      a mesh, the photos' crops and the photos that see each vertex.
Out     moves along the normals.
Fails   SurfaceError: patches correlate at hardly any vertex.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Float32, Float64, Int32, Int64

from limbgram.core.errors import SurfaceError
from limbgram.core.geometry.lens import View
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.imagery import Imagery, apparent_lift_mm
from limbgram.reconstruction.measuring.joint import (
    GAIN,
    LIFT,
    MEAN,
    MEAN_PER_MM,
    FaceEquations,
    NoiseModel,
    assemble,
    local_gains,
)
from limbgram.reconstruction.measuring.patches import MEASURED, measure_patches
from limbgram.reconstruction.measuring.sampling import Patches
from limbgram.reconstruction.measuring.thin_plate import (
    ThinPlate,
    quadrics,
    smoothed_moves,
    stiffness_of,
    tangent_axes,
    thin_plate_of,
)

_PRIOR_SIGMA_PX = 1.0
"""Prior sigma of the given surface."""
_FIXED_SIGMA_PX, _FREE_SIGMA_PX = 0.02, 20.0
"""Sigmas of vertices that stay in place, and of those whose position was guessed."""
_GAIN_STEP_PX = 0.73
"""Sample distance of the windows for local gain and mean: their Gaussian has 3 such steps."""
_REUSE_PHOTOMETRY_PX = 0.2
"""Move from which a vertex's gains and means are computed anew."""
_REMAINING_PRIOR = 0.1
"""Share of the prior that remains after two rounds: the smallest with which errors on bare skin
stay bounded."""
_SIGNAL_STEP_PX, _SIGNAL_RINGS, _MIN_SIGNAL = 0.1, 3, 0.05
"""Step of the finite difference for the signal; rings over which it is summed, as it is noisy where
texture is low; and its lower limit."""
_MIN_DENSITY_RATIO = 0.3
"""Lower limit of the typical density over that above which half of the signal lies. Two captures
with paint all over have 0.33 and 0.35, and so keep their median."""
_SYMMETRIC_IDX = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
"""Indices of a symmetric 3 x 3 matrix in its upper triangle."""
_OUTER, _INNER = (2 + 7**0.5) / 6, 1 / 6
_FACE_POINTS = np.array(
    [
        np.roll([first, (1 - first) / 2, (1 - first) / 2], turn)
        for first in (_OUTER, _INNER)
        for turn in range(3)
    ]
)
"""Barycentric samples of a face. The mean of ab + bc + ca is 1/4, as over the whole face, so that
the positions of the samples do not displace flat faces on a round surface."""


@cache
def face_points(parts: int) -> Float64[np.ndarray, "s 3"]:
    """Barycentric samples of a face whose edges are divided into so many parts.

    With them, long edges still have samples about a pixel apart.
    """
    steps = [(i, j) for i in range(parts) for j in range(parts - i)]
    upright = [[(i + 1, j), (i, j + 1), (i, j)] for i, j in steps]
    turned = [[(i + 1, j + 1), (i, j + 1), (i + 1, j)] for i, j in steps if i + j <= parts - 2]
    corners = np.array([*upright, *turned], float) / parts
    whole = np.concatenate([corners, 1.0 - corners.sum(axis=2, keepdims=True)], axis=2)
    return (_FACE_POINTS @ whole).reshape(-1, 3) if parts > 1 else _FACE_POINTS


_PATCH_THIN_PLATE_PX = 2.5
"""Plate length for patches: at shorter distances the plate dominates the data."""
_JOINT_THIN_PLATE_PX = 3.0
"""Plate length for joint matching."""


MAX_VIEWS = 6
"""Photos per vertex, the most frontal ones of those that lie apart."""
MAX_INCIDENCE_DEG = 65.0
"""Photos that see a vertex at a larger incidence angle are left out, unless"""
_LEAST_VIEWS = 3
"""fewer photos than this see it within that angle: then oblique ones are used, up to"""
_STEEP_INCIDENCE_DEG = 82.0
"""this angle."""
_MIN_CORRELATION = 0.6
"""Mean correlation between the photos below which a patch is rejected."""
MAX_MOVE_PX = 4.0
"""Largest accepted move of a vertex, in pixels of the round's photos."""
_NOISE_GREY = 1.5
"""Sensor noise of a pixel, grey levels."""
_NOISE_PX = 0.02
"""Unmodelled errors, as a shift of the photos, px."""
EARLY_ROBUST_SIGMAS = 10.0
"""Robust limit of residuals in all rounds but the last: vertices that are still off by a part of a
pixel must keep their weight."""


@dataclass(frozen=True, kw_only=True)
class ResidualOptions:
    """Robust limit and sampling of the residuals of a round."""

    robust_sigmas: float = 1.5
    """Residuals beyond this are down-weighted."""

    face_parts: int = 1
    """Parts of a face's edge that are sampled separately: more where edges are long in pixels."""


@dataclass(frozen=True, kw_only=True)
class ObservedSurface:
    """The surface before a round: its geometry and the photos that see it."""

    thin_plate: ThinPlate
    axes: Float64[np.ndarray, "n 3 3"]
    """Two tangents and the normal, rows."""
    quadric: Float64[np.ndarray, "n 3"]
    """Curvature (uu, uv, vv) along the tangents, 1/mm."""
    seen_by: Int32[np.ndarray, "n c"]
    pixel_mm: Float64[np.ndarray, " n"]
    """Size of a pixel of the round's photos on the object."""


def measuring_views(cosines: Float[np.ndarray, "n v"]) -> Bool[np.ndarray, "n v"]:
    """Which photos measure each vertex, by the cosines of their angles of incidence."""
    frontal = cosines >= np.cos(np.radians(MAX_INCIDENCE_DEG))
    few = frontal.sum(axis=1, keepdims=True) < _LEAST_VIEWS
    return frontal | few & (cosines >= np.cos(np.radians(_STEEP_INCIDENCE_DEG)))


def observe_surface(
    mesh: Mesh, imagery: Imagery, views: Sequence[View], seen_by: Int32[np.ndarray, "n c"]
) -> ObservedSurface:
    """The surface with the frame, curvature and pixel size at every vertex."""
    thin_plate = thin_plate_of(mesh)
    axes = tangent_axes(mesh.vertex_normals())
    return ObservedSurface(
        thin_plate=thin_plate,
        axes=axes,
        quadric=quadrics(mesh, thin_plate, axes),
        seen_by=seen_by,
        pixel_mm=_pixel_mm(mesh, views, seen_by[:, 0]) / imagery.factor,
    )


def match_patches(
    mesh: Mesh,
    imagery: Imagery,
    observed: ObservedSurface,
    dense: Bool[np.ndarray, " n"],
) -> tuple[Float64[np.ndarray, " n"], Float32[np.ndarray, " n"]]:
    """Moves of a plate through independent patches, and the patches' mean correlation.

    The correlation is 0 where no patch is accepted. No two neighbours have a patch, except at
    `dense` vertices: a patch is wider than an edge, so that one in between adds little.
    """
    near = observed.thin_plate.neighbours
    selected = dense | independent_set(near.indptr, near.indices)
    found = _measured_patches(mesh, imagery, observed, selected)
    accepted = found.accepted
    if accepted.sum() < 0.05 * selected.sum():
        raise SurfaceError("surface.unlike", good=int(accepted.sum()), asked=int(selected.sum()))
    sigma_mm = np.where(accepted, found.sigma_mm, _PRIOR_SIGMA_PX * observed.pixel_mm)
    # The plate is as stiff as if every vertex had a patch.
    typical = float(np.median(1 / sigma_mm[selected] ** 2))
    plate_weights = np.where(selected, 1 / sigma_mm**2, typical)
    moves_mm = _plate_through(mesh, observed, found, sigma_mm, plate_weights)
    return moves_mm, np.where(accepted, found.correlation, 0.0)


@njit(cache=True, nogil=True)
def independent_set(starts: np.ndarray, neighbours: np.ndarray):
    """A maximal independent set: vertices in order, each without an earlier chosen neighbour."""
    count = len(starts) - 1
    chosen, excluded = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    for vertex in range(count):
        if not excluded[vertex]:
            chosen[vertex] = True
            for k in range(starts[vertex], starts[vertex + 1]):
                excluded[neighbours[k]] = True
    return chosen


def match_selected(
    mesh: Mesh,
    imagery: Imagery,
    observed: ObservedSurface,
    selected: Bool[np.ndarray, " n"],
) -> tuple[Float64[np.ndarray, " n"], Bool[np.ndarray, " n"]]:
    """Moves by patches at the selected vertices, and which patches are accepted.

    The rest of the surface stays in place. Selected vertices without an accepted patch follow the
    plate through their neighbours: a fill is measured from its rim inwards, round by round.
    """
    found = _measured_patches(mesh, imagery, observed, selected)
    prior_px = np.where(selected, _FREE_SIGMA_PX, _FIXED_SIGMA_PX)
    sigma_mm = np.where(found.accepted, found.sigma_mm, prior_px * observed.pixel_mm)
    return _plate_through(mesh, observed, found, sigma_mm, 1 / sigma_mm**2), found.accepted


@dataclass(frozen=True)
class _PatchOffsets:
    """Offsets that patches measured, by vertex."""

    offsets_mm: Float64[np.ndarray, " n"]
    sigma_mm: Float64[np.ndarray, " n"]
    """Formal standard deviation."""
    correlation: Float32[np.ndarray, " n"]
    """Mean between the photos."""
    accepted: Bool[np.ndarray, " n"]


def _measured_patches(
    mesh: Mesh,
    imagery: Imagery,
    observed: ObservedSurface,
    selected: Bool[np.ndarray, " n"],
) -> _PatchOffsets:
    """The patch offsets of the selected vertices."""
    state = np.zeros((len(mesh), 3))
    report = measure_patches(
        imagery,
        np.where(selected[:, None], observed.seen_by, np.int32(-1)),
        Patches(mesh.vertices_mm, observed.axes, observed.quadric, observed.pixel_mm),
        8,
        state,
    )
    accepted = _accepted(report, state[:, 0], observed.pixel_mm)
    sigma_mm = np.maximum(report[:, 1], _FIXED_SIGMA_PX * observed.pixel_mm)
    return _PatchOffsets(state[:, 0], sigma_mm, report[:, 3], accepted)


def _plate_through(
    mesh: Mesh,
    observed: ObservedSurface,
    found: _PatchOffsets,
    sigma_mm: Float64[np.ndarray, " n"],
    plate_weights: Float64[np.ndarray, " n"],
) -> Float64[np.ndarray, " n"]:
    """Moves of a plate through the accepted offsets; its stiffness follows `plate_weights`."""
    length_mm = _PATCH_THIN_PLATE_PX * float(np.median(observed.pixel_mm))
    right = np.where(found.accepted, found.offsets_mm, 0.0) / sigma_mm**2
    data = sp.csr_matrix(sp.diags(1 / sigma_mm**2))
    density = float(np.median(plate_weights / observed.thin_plate.area_mm2))
    stiffness = stiffness_of(observed.thin_plate, density, length_mm)
    return smoothed_moves(
        mesh, observed.thin_plate, plate_weights, data, right, stiffness, length_mm
    )


@dataclass(frozen=True, kw_only=True)
class JointEquations:
    """The normal equations of all vertices at once, without the plate."""

    weights: Float64[np.ndarray, " n"]
    """Robust information of the photos on each vertex, 1/mm^2."""
    hessian: sp.csr_matrix
    """(n, n), 1/mm^2, second derivatives of the robust cost and the prior; steps use it."""
    right: Float64[np.ndarray, " n"]
    """Right-hand side, 1/mm."""
    right_by_photo: Float32[np.ndarray, "f c"]
    """Share of each photo that sees a face's first vertex in the sum of the right-hand side."""
    photo_count: Int64[np.ndarray, " n"]
    """Number of photos that measured each vertex."""
    length_mm: float
    """Length below which the reference plate dominates the data on painted skin."""
    stiffness: Float64[np.ndarray, " n"]
    """Of the plate that measures, at each vertex."""
    stiffness_share: float = 1.0
    """Stiffness of the plate that measures over that of the reference plate."""
    plate: ThinPlate
    """The plate that measures: isotropic, or anisotropic along the grain of the relief."""
    cross_grain_factor: Float64[np.ndarray, " n"]
    """Its Laplacian across the grain over the isotropic one; 1 for isotropic relief."""
    signal: Float64[np.ndarray, " n"]
    """Share of each vertex's information that is texture, not noise (`signal_share`)."""
    texture_hessian: sp.csr_matrix
    """(n, n), 1/mm^2, the part of the Hessian from texture, and little prior; errors use it."""
    other_hessian: sp.csr_matrix
    """(n, n), 1/mm^2, the other part: the prior of the given surface, and grey slopes of noise."""

    @property
    def measuring_length_mm(self) -> float:
        """Length below which the plate that measures dominates the data on painted skin."""
        return self.length_mm * self.stiffness_share**0.25


def match_jointly(mesh: Mesh, equations: JointEquations) -> Float64[np.ndarray, " n"]:
    """Moves of all vertices by joint matching."""
    return smoothed_moves(
        mesh,
        equations.plate,
        equations.weights,
        equations.hessian,
        equations.right,
        equations.stiffness,
        equations.length_mm,
    )


def photometry_at(
    mesh: Mesh,
    imagery: Imagery,
    observed: ObservedSurface,
    selected: Int64[np.ndarray, " m"],
) -> Float32[np.ndarray, "m c 4"]:
    """Photometric parameters at the selected vertices: GAIN, MEAN, MEAN_PER_MM and LIFT."""
    vertices, axes = mesh.vertices_mm[selected], observed.axes[selected]
    quadric, seen_by = observed.quadric[selected], observed.seen_by[selected]
    photometry = np.zeros((*seen_by.shape, 4), np.float32)
    photometry[..., LIFT] = apparent_lift_mm(vertices, axes, quadric, imagery.views, seen_by)
    local_gains(
        imagery,
        seen_by,
        Patches(vertices, axes, quadric, _GAIN_STEP_PX * observed.pixel_mm[selected]),
        _NOISE_GREY,
        photometry,
    )
    return photometry


def photometry_after(
    photometry: Float32[np.ndarray, "n c 4"],
    mesh: Mesh,
    imagery: Imagery,
    observed: ObservedSurface,
    moves_mm: Float64[np.ndarray, " n"],
) -> Float32[np.ndarray, "n c 4"]:
    """Photometric parameters after the moves; small moves extrapolate them.

    `mesh` and `observed` are those after the moves.
    """
    photometry = _extrapolated(photometry, moves_mm)
    far = np.flatnonzero(np.abs(moves_mm) > _REUSE_PHOTOMETRY_PX * observed.pixel_mm)
    photometry[far] = photometry_at(mesh, imagery, observed, far)
    return photometry


def joint_equations(
    mesh: Mesh,
    imagery: Imagery,
    observed: ObservedSurface,
    photometry: Float32[np.ndarray, "n c 4"],
    signal: Float64[np.ndarray, " n"],
    options: ResidualOptions,
) -> JointEquations:
    """Normal equations of all vertices' offsets from samples on the faces."""
    matrix, right, right_by_photo, curvature = _face_equations(
        mesh, imagery, observed, photometry, options
    )
    prior = 1 / (_PRIOR_SIGMA_PX * observed.pixel_mm) ** 2
    data = _sparse_matrix(matrix, mesh.faces, len(mesh))
    hessian = data - _sparse_matrix(matrix * (1 - curvature[:, None]), mesh.faces, len(mesh))
    shares = sp.diags(np.sqrt(signal))
    weights = data.diagonal() + prior
    texture = shares @ hessian @ shares
    length_mm = _JOINT_THIN_PLATE_PX * float(np.median(observed.pixel_mm))
    density = _painted_density(weights / observed.thin_plate.area_mm2, signal)
    return JointEquations(
        weights=weights,
        hessian=sp.csr_matrix(hessian + sp.diags(prior)),
        right=np.bincount(mesh.faces.ravel(), right.ravel(), len(mesh)),
        right_by_photo=right_by_photo,
        photo_count=(photometry[..., GAIN] > 0).sum(1),
        length_mm=length_mm,
        stiffness=stiffness_of(observed.thin_plate, density, length_mm),
        plate=observed.thin_plate,
        cross_grain_factor=np.ones(len(mesh)),
        signal=signal,
        texture_hessian=sp.csr_matrix(texture + sp.diags(_REMAINING_PRIOR * prior)),
        other_hessian=sp.csr_matrix(hessian - texture + sp.diags(prior)),
    )


def signal_share(
    mesh: Mesh,
    imagery: Imagery,
    observed: ObservedSurface,
    photometry: Float32[np.ndarray, "n c 4"],
    options: ResidualOptions,
) -> Float64[np.ndarray, " n"]:
    """Share of each vertex's information that comes from texture common to its photos, 0 to 1.

    The equations count every grey slope as texture, including that of noise. The finite difference
    of the right-hand side over the offset has texture alone: slopes of noise differ between photos,
    and their sum does not change with the offset.
    """
    count = len(mesh)
    corners = mesh.faces.ravel()
    measured, formal = np.zeros(count), np.zeros(count)
    for step_px in (-_SIGNAL_STEP_PX, _SIGNAL_STEP_PX):
        moves_mm = step_px * observed.pixel_mm
        moved_photometry = _extrapolated(photometry, moves_mm)
        moved = mesh.with_vertices(mesh.vertices_mm + moves_mm[:, None] * observed.axes[:, 2])
        matrix, right, _, curvature = _face_equations(
            moved, imagery, observed, moved_photometry, options
        )
        measured -= np.bincount(corners, right.ravel(), count) / (2 * moves_mm)
        rows = (matrix * curvature[:, None])[:, _SYMMETRIC_IDX].sum(axis=2)
        formal += np.bincount(corners, rows.ravel(), count) / 2
    ring = sp.csr_matrix(observed.thin_plate.neighbours + sp.eye(count))
    for _ in range(_SIGNAL_RINGS):
        measured, formal = ring @ measured, ring @ formal
    return np.clip(measured / np.maximum(formal, 1e-12), _MIN_SIGNAL, 1.0)


def _extrapolated(
    photometry: Float32[np.ndarray, "n c 4"], moves_mm: Float64[np.ndarray, " n"]
) -> Float32[np.ndarray, "n c 4"]:
    """The parameters with their means extrapolated to a moved surface."""
    photometry = photometry.copy()
    photometry[..., MEAN] += photometry[..., MEAN_PER_MM] * moves_mm[:, None].astype(np.float32)
    return photometry


def _painted_density(
    density: Float64[np.ndarray, " n"], signal: Float64[np.ndarray, " n"]
) -> float:
    """Typical weight per area where the limb is painted.

    The stiffness of the plate should follow from the limb's relief, not from the painted share. The
    density above which half of all signal lies does not depend on bare skin; where paint is
    everywhere, the median over the surface is a third of it.
    """
    order = np.argsort(density, kind="stable")
    cumulative = np.cumsum((signal * density)[order])
    half = np.searchsorted(cumulative, cumulative[-1] / 2)
    return max(float(np.median(density)), _MIN_DENSITY_RATIO * float(density[order][half]))


def _face_equations(
    mesh: Mesh,
    imagery: Imagery,
    observed: ObservedSurface,
    photometry: Float32[np.ndarray, "n c 4"],
    options: ResidualOptions,
) -> FaceEquations:
    """The normal equations of all faces."""
    return assemble(
        imagery,
        observed.seen_by,
        photometry,
        mesh,
        np.ascontiguousarray(observed.axes[:, 2]),
        face_points(options.face_parts),
        NoiseModel(_NOISE_GREY, _NOISE_PX, options.robust_sigmas),
    )


def _sparse_matrix(
    matrix: Float64[np.ndarray, "f 6"], faces: np.ndarray, count: int
) -> sp.csr_matrix:
    """The faces' 3 x 3 blocks as one symmetric matrix."""
    rows, columns = faces[:, [0, 0, 0, 1, 1, 2]], faces[:, [0, 1, 2, 1, 2, 2]]
    upper = sp.csr_matrix((matrix.ravel(), (rows.ravel(), columns.ravel())), (count, count))
    off = matrix[:, [1, 2, 4]].ravel()
    mirrored = sp.csr_matrix(
        (off, (columns[:, [1, 2, 4]].ravel(), rows[:, [1, 2, 4]].ravel())), (count, count)
    )
    return sp.csr_matrix(upper + mirrored)


def _accepted(
    report: Float32[np.ndarray, "n 5"],
    offsets_mm: Float64[np.ndarray, " n"],
    pixel_mm: Float64[np.ndarray, " n"],
) -> Bool[np.ndarray, " n"]:
    """Patches that converged, correlate and moved little."""
    return (
        (report[:, 0] == MEASURED)
        & (report[:, 3] >= _MIN_CORRELATION)
        & (np.abs(offsets_mm) < MAX_MOVE_PX * pixel_mm)
    )


def _pixel_mm(mesh: Mesh, views: Sequence[View], photo: np.ndarray) -> Float64[np.ndarray, " n"]:
    """Size of a full-size pixel on the object, in each vertex's most frontal photo."""
    sizes = np.full(len(mesh), np.nan)
    for k, view in enumerate(views):
        rows = photo == k
        sizes[rows] = view.pixel_size_at(mesh.vertices_mm[rows])
    return np.where(np.isfinite(sizes), sizes, np.nanmedian(sizes))
