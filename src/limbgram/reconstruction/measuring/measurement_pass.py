"""Measurement pass over the surface, by single patches or by all vertices jointly.

In      a mesh, the photos' crops and what each vertex is seen by.
Out     moves along the normals.
Fails   SurfaceError: hardly a vertex looks alike in two photos.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float32, Float64, Int32, Int64

from limbgram.core.errors import SurfaceError
from limbgram.core.geometry.lens import View
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.imagery import Imagery, apparent_lift_mm
from limbgram.reconstruction.measuring.joint import (
    DRIFT,
    GAIN,
    LIFT,
    MEAN,
    Trust,
    assemble,
    local_gains,
)
from limbgram.reconstruction.measuring.patches import MEASURED, measure_patches
from limbgram.reconstruction.measuring.thin_plate import (
    ThinPlate,
    quadrics,
    smoothed_moves,
    stiffness_of,
    tangent_axes,
    thin_plate_of,
)

_UNMEASURED_PX = 1.0
"""What is believed of the given surface where nothing was measured: one pixel, in sigma."""
_HELD_PX, _LOOSE_PX = 0.02, 20.0
"""The same where the surface stays as it is, and where it was only guessed."""
_GAIN_STEP_PX = 0.73
"""Sample distance of the windows for local gain and mean: their Gaussian has 3 such steps."""
_SAME_LIGHT_PX = 0.2
"""Moves from which a vertex's gains and means are looked at again."""
_STILL_BELIEVED = 0.1
"""What is left of the belief in the given surface after two rounds of which each asks less of it
than of the photos: the smallest that no error over a bare place grows beyond measure with."""
_SIGNAL_STEP_PX, _SIGNAL_RINGS, _LEAST_SIGNAL = 0.1, 3, 0.05
"""How far the surface is lifted to see what holds it; rings over which that is summed, for it is
itself noisy where little is seen; and the least that is believed."""
_OF_DENSEST = 0.3
"""Median weight of painted skin over the weight from which half of the signal lies denser: 0.33 and
0.35 on two captures painted all over, which are to stay as they are."""
_ROWS = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
"""Where the rows of a face's matrix stand in its upper triangle."""
_OUTER, _INNER = (2 + 7**0.5) / 6, 1 / 6
_FACE_POINTS = np.array(
    [
        np.roll([first, (1 - first) / 2, (1 - first) / 2], turn)
        for first in (_OUTER, _INNER)
        for turn in range(3)
    ]
)
"""Samples of a face, barycentric. The mean of ab + bc + ca is 1/4, as over the whole face, so that
a flat face on a round surface is neither lifted nor sunk by where its samples lie."""


@cache
def face_points(parts: int) -> Float64[np.ndarray, "s 3"]:
    """Samples of a face whose edges are parted so many times, barycentric.

    They serve all pixels where edges are longer than pixels ask for.
    """
    steps = [(i, j) for i in range(parts) for j in range(parts - i)]
    upright = [[(i + 1, j), (i, j + 1), (i, j)] for i, j in steps]
    turned = [[(i + 1, j + 1), (i, j + 1), (i + 1, j)] for i, j in steps if i + j <= parts - 2]
    corners = np.array([*upright, *turned], float) / parts
    whole = np.concatenate([corners, 1.0 - corners.sum(axis=2, keepdims=True)], axis=2)
    return (_FACE_POINTS @ whole).reshape(-1, 3) if parts > 1 else _FACE_POINTS


_PATCH_THIN_PLATE_PX = 2.5
"""Patches: below this length the surface bends like a plate rather than follow the data."""
_JOINT_THIN_PLATE_PX = 3.0
"""All vertices at once: the same length."""


MAX_VIEWS = 6
"""Photos per vertex, the most frontal ones."""
MAX_INCIDENCE_DEG = 65.0
"""Photos that see a vertex at a flatter angle than this are left out, unless"""
LEAST_VIEWS = 3
"""fewer photos than this see it so squarely: then steeper ones are taken, up to"""
STEEP_INCIDENCE_DEG = 82.0
"""this angle."""
_MIN_CORRELATION = 0.6
"""Mean correlation between the photos below which a patch is not believed."""
MAX_MOVE_PX = 4.0
"""A vertex that wants to move further, in pixels of the round's photos, is not believed."""
_NOISE_GREY = 1.5
"""Noise of a pixel, grey levels."""
_NOISE_PX = 0.02
"""What the model leaves unexplained, as a shift of the photos, px."""
EARLY_ROBUST_SIGMAS = 10.0
"""Residuals beyond this count less and less in all rounds but the last: what is still a part of a
pixel off must pull."""


@dataclass(frozen=True, kw_only=True)
class ResidualOptions:
    """How the residuals of a round are taken."""

    robust_sigmas: float = 1.5
    """Residuals beyond this count less and less."""

    face_parts: int = 1
    """Parts of a face's edge that are sampled each for itself: more where edges are longer than
    the pixels would allow."""


@dataclass(frozen=True, kw_only=True)
class SeenSurface:
    """The surface as the photos see it, before a round."""

    thin_plate: ThinPlate
    axes: Float64[np.ndarray, "n 3 3"]
    """Two tangents and the normal."""
    quadric: Float64[np.ndarray, "n 3"]
    seen_by: Int32[np.ndarray, "n c"]
    pixel_mm: Float64[np.ndarray, " n"]
    """Size of a pixel of the round's photos on the object."""


def look(
    mesh: Mesh, imagery: Imagery, views: Sequence[View], seen_by: Int32[np.ndarray, "n c"]
) -> SeenSurface:
    """Frames and curvature of every vertex, and the size of a pixel on it."""
    thin_plate = thin_plate_of(mesh)
    axes = tangent_axes(mesh.vertex_normals())
    return SeenSurface(
        thin_plate=thin_plate,
        axes=axes,
        quadric=quadrics(mesh, thin_plate, axes),
        seen_by=seen_by,
        pixel_mm=_pixel_mm(mesh, views, seen_by[:, 0]) / imagery.factor,
    )


def match_patches(
    mesh: Mesh,
    imagery: Imagery,
    seen: SeenSurface,
    densely: Bool[np.ndarray, " n"],
) -> tuple[Float64[np.ndarray, " n"], Float32[np.ndarray, " n"]]:
    """Moves by patches, each on its own, and the plate through all of them.

    Also tells the mean correlation of the patches that are believed, 0 of the others. No two
    neighbours have a patch, except where every vertex is asked for (`densely`): it is wider than an
    edge, so that one between says little more.
    """
    near = seen.thin_plate.neighbours
    asked = densely | no_two_neighbours(near.indptr, near.indices)
    found = _patches(mesh, imagery, seen, asked)
    good = found.good
    if good.sum() < 0.05 * asked.sum():
        raise SurfaceError("surface.unlike", good=int(good.sum()), asked=int(asked.sum()))
    sigma_mm = np.where(good, found.sigma_mm, _UNMEASURED_PX * seen.pixel_mm)
    # The plate is as stiff as if every vertex had been asked.
    usual = float(np.median(1 / sigma_mm[asked] ** 2))
    stiff = np.where(asked, 1 / sigma_mm**2, usual)
    return _through(mesh, seen, found, sigma_mm, stiff), np.where(good, found.correlation, 0.0)


@njit(cache=True, nogil=True)
def no_two_neighbours(starts: np.ndarray, others: np.ndarray):
    """Vertices in their order, each unless it has a neighbour among those before."""
    count = len(starts) - 1
    chosen, beside = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    for vertex in range(count):
        if not beside[vertex]:
            chosen[vertex] = True
            for k in range(starts[vertex], starts[vertex + 1]):
                beside[others[k]] = True
    return chosen


def match_within(
    mesh: Mesh,
    imagery: Imagery,
    seen: SeenSurface,
    asked: Bool[np.ndarray, " n"],
) -> tuple[Float64[np.ndarray, " n"], Bool[np.ndarray, " n"]]:
    """Moves by a patch for each vertex asked, and which patches are believed.

    The rest of the surface stays where it is. Vertices asked without a believed patch follow the
    plate through their neighbours: a fill is measured from its rim inwards round by round.
    """
    found = _patches(mesh, imagery, seen, asked)
    believed_px = np.where(asked, _LOOSE_PX, _HELD_PX)
    sigma_mm = np.where(found.good, found.sigma_mm, believed_px * seen.pixel_mm)
    return _through(mesh, seen, found, sigma_mm, 1 / sigma_mm**2), found.good


@dataclass(frozen=True)
class _Patches:
    """What the patches say, by vertex."""

    offsets_mm: Float64[np.ndarray, " n"]
    sigma_mm: Float64[np.ndarray, " n"]
    """Formal."""
    correlation: Float32[np.ndarray, " n"]
    """Mean between the photos."""
    good: Bool[np.ndarray, " n"]
    """Believed."""


def _patches(
    mesh: Mesh,
    imagery: Imagery,
    seen: SeenSurface,
    asked: Bool[np.ndarray, " n"],
) -> _Patches:
    """A patch for each vertex asked."""
    state = np.zeros((len(mesh), 3))
    report = measure_patches(
        imagery,
        np.where(asked[:, None], seen.seen_by, np.int32(-1)),
        mesh.vertices_mm,
        seen.axes,
        seen.quadric,
        seen.pixel_mm,
        8,
        state,
    )
    good = _believed(report, state[:, 0], seen.pixel_mm)
    sigma_mm = np.maximum(report[:, 1], _HELD_PX * seen.pixel_mm)
    return _Patches(state[:, 0], sigma_mm, report[:, 3], good)


def _through(
    mesh: Mesh,
    seen: SeenSurface,
    found: _Patches,
    sigma_mm: Float64[np.ndarray, " n"],
    stiff: Float64[np.ndarray, " n"],
) -> Float64[np.ndarray, " n"]:
    """Moves of the plate through the believed offsets; `stiff` are the weights that it matches."""
    length_mm = _PATCH_THIN_PLATE_PX * float(np.median(seen.pixel_mm))
    right = np.where(found.good, found.offsets_mm, 0.0) / sigma_mm**2
    data = sp.csr_matrix(sp.diags(1 / sigma_mm**2))
    density = float(np.median(stiff / seen.thin_plate.area_mm2))
    stiffness = stiffness_of(seen.thin_plate, density, length_mm)
    return smoothed_moves(mesh, seen.thin_plate, stiff, data, right, stiffness, length_mm)


@dataclass(frozen=True, kw_only=True)
class JointEquations:
    """The normal equations of all vertices at once, without the plate."""

    weights: Float64[np.ndarray, " n"]
    """1/mm^2, as the robust weights have it: how much the photos say about each vertex."""
    soft: sp.csr_matrix
    """(n, n), 1/mm^2, as the robust cost really bends: what steps are solved with."""
    right: Float64[np.ndarray, " n"]
    """1/mm."""
    pull: Float32[np.ndarray, "f c"]
    """What each photo that sees a face's first vertex adds to the right side."""
    photos: Int64[np.ndarray, " n"]
    """Photos that measured each vertex."""
    length_mm: float
    """Below this length the usual plate rules where the limb is painted."""
    stiffness: Float64[np.ndarray, " n"]
    """Of the plate that measures."""
    stiffness_share: float = 1.0
    """What that has of the usual plate's stiffness."""
    plate: ThinPlate
    """The plate that measures: as the surface has it, or leaning with the grain of its relief."""
    across: Float64[np.ndarray, " n"]
    """Its Laplacian across the grain over the usual one; 1 where relief runs all ways."""
    signal: Float64[np.ndarray, " n"]
    """How much of what holds each vertex is texture and not noise (`signal_share`)."""
    held: sp.csr_matrix
    """(n, n), 1/mm^2, what texture alone holds: what errors are solved with."""
    unheld: sp.csr_matrix
    """(n, n), 1/mm^2, what holds steps back and is no texture: belief in the surface as it was
    given, and slopes of noise."""

    @property
    def measuring_length_mm(self) -> float:
        """Below this length the plate that measures rules where the limb is painted."""
        return self.length_mm * self.stiffness_share**0.25


def match_jointly(mesh: Mesh, equations: JointEquations) -> Float64[np.ndarray, " n"]:
    """Moves of all vertices at once."""
    return smoothed_moves(
        mesh,
        equations.plate,
        equations.weights,
        equations.soft,
        equations.right,
        equations.stiffness,
        equations.length_mm,
    )


def light_at(
    mesh: Mesh,
    imagery: Imagery,
    seen: SeenSurface,
    asked: Int64[np.ndarray, " m"],
) -> Float32[np.ndarray, "m c 4"]:
    """What is known of the photos at these vertices: GAIN, MEAN, DRIFT and LIFT."""
    vertices, axes = mesh.vertices_mm[asked], seen.axes[asked]
    quadric, seen_by = seen.quadric[asked], seen.seen_by[asked]
    light = np.zeros((*seen_by.shape, 4), np.float32)
    light[..., LIFT] = apparent_lift_mm(vertices, axes, quadric, imagery.views, seen_by)
    local_gains(
        imagery,
        seen_by,
        vertices,
        axes,
        quadric,
        _GAIN_STEP_PX * seen.pixel_mm[asked],
        _NOISE_GREY,
        light,
    )
    return light


def light_after(
    light: Float32[np.ndarray, "n c 4"],
    mesh: Mesh,
    imagery: Imagery,
    seen: SeenSurface,
    moves_mm: Float64[np.ndarray, " n"],
) -> Float32[np.ndarray, "n c 4"]:
    """The same once the surface has moved; a window that moved by little hardly sees anything new.

    `mesh` and `seen` are those after the moves.
    """
    light = light.copy()
    light[..., MEAN] += light[..., DRIFT] * moves_mm[:, None].astype(np.float32)
    far = np.flatnonzero(np.abs(moves_mm) > _SAME_LIGHT_PX * seen.pixel_mm)
    light[far] = light_at(mesh, imagery, seen, far)
    return light


def joint_equations(
    mesh: Mesh,
    imagery: Imagery,
    seen: SeenSurface,
    light: Float32[np.ndarray, "n c 4"],
    signal: Float64[np.ndarray, " n"],
    options: ResidualOptions,
) -> JointEquations:
    """What the photos say about all vertices at once, by samples on the faces."""
    matrix, right, pull, curvature = _assembled(mesh, imagery, seen, light, options)
    believed = 1 / (_UNMEASURED_PX * seen.pixel_mm) ** 2
    data = _sparse(matrix, mesh.faces, len(mesh))
    soft = data - _sparse(matrix * (1 - curvature[:, None]), mesh.faces, len(mesh))
    shares = sp.diags(np.sqrt(signal))
    weights = data.diagonal() + believed
    textured = shares @ soft @ shares
    length_mm = _JOINT_THIN_PLATE_PX * float(np.median(seen.pixel_mm))
    density = _painted_density(weights / seen.thin_plate.area_mm2, signal)
    return JointEquations(
        weights=weights,
        soft=sp.csr_matrix(soft + sp.diags(believed)),
        right=np.bincount(mesh.faces.ravel(), right.ravel(), len(mesh)),
        pull=pull,
        photos=(light[..., GAIN] > 0).sum(1),
        length_mm=length_mm,
        stiffness=stiffness_of(seen.thin_plate, density, length_mm),
        plate=seen.thin_plate,
        across=np.ones(len(mesh)),
        signal=signal,
        held=sp.csr_matrix(textured + sp.diags(_STILL_BELIEVED * believed)),
        unheld=sp.csr_matrix(soft - textured + sp.diags(believed)),
    )


def signal_share(
    mesh: Mesh,
    imagery: Imagery,
    seen: SeenSurface,
    light: Float32[np.ndarray, "n c 4"],
    options: ResidualOptions,
) -> Float64[np.ndarray, " n"]:
    """How much of what holds each vertex is texture that its photos have in common, 0 to 1.

    The equations take every grey slope for texture, that of noise as well. How the photos' pull
    changes when the surface is lifted and sunk by a tenth of a pixel is what truly holds it: the
    slopes of noise are of one photo alone, and their sum does not change with the height.
    """
    count = len(mesh)
    corners = mesh.faces.ravel()
    held, believed = np.zeros(count), np.zeros(count)
    for step_px in (-_SIGNAL_STEP_PX, _SIGNAL_STEP_PX):
        moves_mm = step_px * seen.pixel_mm
        lit = light.copy()
        lit[..., MEAN] += lit[..., DRIFT] * moves_mm[:, None].astype(np.float32)
        lifted = mesh.with_vertices(mesh.vertices_mm + moves_mm[:, None] * seen.axes[:, 2])
        matrix, right, _, curvature = _assembled(lifted, imagery, seen, lit, options)
        held -= np.bincount(corners, right.ravel(), count) / (2 * moves_mm)
        rows = (matrix * curvature[:, None])[:, _ROWS].sum(axis=2)
        believed += np.bincount(corners, rows.ravel(), count) / 2
    ring = sp.csr_matrix(seen.thin_plate.neighbours + sp.eye(count))
    for _ in range(_SIGNAL_RINGS):
        held, believed = ring @ held, ring @ believed
    return np.clip(held / np.maximum(believed, 1e-12), _LEAST_SIGNAL, 1.0)


def _painted_density(
    density: Float64[np.ndarray, " n"], signal: Float64[np.ndarray, " n"]
) -> float:
    """Typical weight per area where the limb is painted.

    How stiff the plate is follows from the limb's relief and not from the share that is painted.
    Half of all signal lies where it is denser than some weight, of which bare skin takes nothing
    away; where paint is everywhere, the median over the surface is a third of that weight.
    """
    order = np.argsort(density, kind="stable")
    below = np.cumsum((signal * density)[order])
    half = np.searchsorted(below, below[-1] / 2)
    return max(float(np.median(density)), _OF_DENSEST * float(density[order][half]))


def _assembled(
    mesh: Mesh,
    imagery: Imagery,
    seen: SeenSurface,
    light: Float32[np.ndarray, "n c 4"],
    options: ResidualOptions,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Matrix, right side, pull and curvature of all faces, as `assemble` has them."""
    return assemble(
        imagery,
        seen.seen_by,
        light,
        mesh,
        np.ascontiguousarray(seen.axes[:, 2]),
        face_points(options.face_parts),
        Trust(_NOISE_GREY, _NOISE_PX, options.robust_sigmas),
    )


def _sparse(matrix: Float64[np.ndarray, "f 6"], faces: np.ndarray, count: int) -> sp.csr_matrix:
    """The faces' 3 x 3 blocks as one symmetric matrix."""
    rows, columns = faces[:, [0, 0, 0, 1, 1, 2]], faces[:, [0, 1, 2, 1, 2, 2]]
    upper = sp.csr_matrix((matrix.ravel(), (rows.ravel(), columns.ravel())), (count, count))
    off = matrix[:, [1, 2, 4]].ravel()
    mirrored = sp.csr_matrix(
        (off, (columns[:, [1, 2, 4]].ravel(), rows[:, [1, 2, 4]].ravel())), (count, count)
    )
    return sp.csr_matrix(upper + mirrored)


def _believed(
    report: Float32[np.ndarray, "n 5"],
    offsets_mm: Float64[np.ndarray, " n"],
    pixel_mm: Float64[np.ndarray, " n"],
) -> Bool[np.ndarray, " n"]:
    """Patches that converged, correlate and stayed near."""
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
        sizes[rows] = view.pixel_at(mesh.vertices_mm[rows])
    return np.where(np.isfinite(sizes), sizes, np.nanmedian(sizes))
