"""Bent shapes: a surface with one open end, however it bends, as a grid of rings.

In      a mesh with one open edge, level at the bottom, as a foot with its shank upside down; and
        the pole, the vertex about which the rings close. `stand_on_rim` makes them of a mesh in
        any pose: cut level at its longest open edge, with the pole at the largest distance over
        the surface from there, as a toe's tip.
Out     a Limb, whose rings are what is photographed, and the truth.
Method  The surface is parametrized on a disc with mean value coordinates (Floater 2003), its open
        edge on the circle, so that no triangle flips. A Moebius map takes the pole to the centre;
        the logarithm of the radius gives rows, the angle columns. The map is nearly conformal: even
        along a tube, coarser on bulges such as a heel. Rays from an axis (scan.py) cannot chart
        such a surface.
Fails   ShapeFileError: several open edges, or none, or a handle.
"""

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Complex128, Float64
from scipy import sparse
from scipy.sparse.csgraph import dijkstra
from scipy.sparse.linalg import splu

from limbgram.core.errors import ShapeFileError
from limbgram.core.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.core.geometry.frames import Rigid, rotation_to_axes
from limbgram.core.interval import weighted_quantile
from limbgram.core.mesh.closest_point import TriangleTree, nearest_barycentric
from limbgram.core.mesh.mesh import Mesh, lengths
from limbgram.core.mesh.topology import boundary_loops, find_edges, largest_piece
from limbgram.findings import Finding
from limbgram.synthetic.props.details import PLAIN, SkinDetails
from limbgram.synthetic.props.limb import (
    Limb,
    Relief,
    limb_of_skin,
    with_relief,
)
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.measures.geodesic import length_mm

_CLEAR_MM = 0.5
"""Height of the level cut above the highest point of the ragged open edge."""
_RESOLVED_SHARE = 0.85
"""Share of the surface with rows and columns as dense as asked; bulges have coarser ones."""
_BINS = 400
"""Of the rows, in which their density is measured."""


@dataclass(frozen=True, kw_only=True)
class BentShape:
    """A surface with one open edge; compared by hash, unit and side."""

    sha256: str
    """Of the file, or another unique name."""
    name: str = field(default="", compare=False)
    """File name, for messages; empty if there is none."""
    mm_per_unit: float = 1.0
    side: Literal["left", "right", "none"]
    mesh: Mesh = field(compare=False)
    """In mm; its open edge lies in the plane z = 0, the rest above."""
    pole: int = field(compare=False)
    """Vertex at which the rings close, as a toe's tip."""
    anterior_rad: float = field(default=0.5 * np.pi, compare=False)
    notes: tuple[Finding, ...] = field(default=(), compare=False)

    @property
    def height_mm(self) -> float:
        return float(self.mesh.vertices_mm[:, 2].max())


class StoodOnRim(NamedTuple):
    """A surface that stands on its open edge, level in the plane z = 0."""

    mesh: Mesh
    pole: int
    world_from_mesh: Rigid
    cut_mm: float
    """Height of the strip that was cut off the open edge."""


def stand_on_rim(mesh: Mesh, name: str) -> StoodOnRim:
    """Stand a mesh on its longest open edge, cut level, and find its pole.

    Raises:
        ShapeFileError: it has no open edge.
    """
    loops = boundary_loops(mesh.faces)
    if not loops:
        raise ShapeFileError("made.bent.no_disc", name=name, openings=0)
    closed = (mesh.vertices_mm[[*loop, loop[0]]] for loop in loops)
    rim = max(closed, key=length_mm)[:-1]
    middle = rim.mean(0)
    up: Vector3 = np.linalg.svd(rim - middle, full_matrices=False)[2][2]
    up = up if (mesh.vertices_mm.mean(0) - middle) @ up > 0 else -up
    rotation = rotation_to_upright(up)
    heights = (rim - middle) @ up
    origin = middle + (float(heights.max()) + _CLEAR_MM) * up
    world_from_mesh = Rigid(rotation, -rotation @ origin)
    level = mesh.moved(world_from_mesh)
    level = largest_piece(keep_positive(level, level.vertices_mm[:, 2]).mesh)[0]
    cut_mm = float(np.ptp(heights)) + _CLEAR_MM
    return StoodOnRim(level, _farthest_from_rim(level), world_from_mesh, cut_mm)


def rotation_to_upright(up: Vector3) -> Matrix3:
    """A rotation that takes a unit direction to +z."""
    beside = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    return rotation_to_axes(up, beside)


def _farthest_from_rim(mesh: Mesh) -> int:
    """The vertex with the longest shortest path along edges from the rim."""
    ends = find_edges(mesh.faces).ends
    edges_mm = lengths(mesh.vertices_mm[ends[:, 1]] - mesh.vertices_mm[ends[:, 0]])
    graph = sparse.csr_array((edges_mm, (ends[:, 0], ends[:, 1])), shape=(len(mesh), len(mesh)))
    rim = np.concatenate(boundary_loops(mesh.faces))
    distances_mm = dijkstra(graph, directed=False, indices=rim, min_only=True)
    return int(np.where(np.isfinite(distances_mm), distances_mm, -1.0).argmax())


def limb_of_bent(
    shape: BentShape,
    seed: int,
    step_mm: float,
    base_mm: float,
    relief: Relief,
    details: SkinDetails = PLAIN,
) -> Limb:
    """Build the limb, with relief and details.

    Raises:
        ShapeFileError: the shape has no open edge, several, or a handle.
    """
    skin = _rings(shape, step_mm)
    skin = with_relief(skin, relief, np.random.default_rng((seed, 1)))
    side = "left" if shape.side == "left" else "right"
    return limb_of_skin(skin, details, seed, base_mm, side, shape.anterior_rad)


@dataclass(frozen=True)
class _Chart:
    """The surface without the faces at its pole, parametrized by row and column."""

    flat: Points3
    """Row, column in radians, and 0; faces at the seam are repeated on its other side."""
    faces: np.ndarray
    vertices: np.ndarray
    """The mesh's vertex of each vertex of the chart."""
    last: float
    """Row of the pole's nearest neighbour."""


def _rings(shape: BentShape, step_mm: float) -> Float64[np.ndarray, "rows columns 3"]:
    """Points in rings from the open edge to the pole."""
    mesh = shape.mesh
    chart = _chart(mesh, shape.pole, shape.name or shape.sha256)
    rows, columns = _even_grid(mesh, chart, step_mm)
    around = 2 * np.pi * np.arange(columns) / columns
    at = np.stack(np.broadcast_arrays(rows[:, None], around, 0.0), -1).reshape(-1, 3)
    tree = TriangleTree.of(chart.flat, chart.faces)
    faces = chart.faces[tree.closest(at).faces]
    shares = nearest_barycentric(chart.flat[faces], at)
    corners = mesh.vertices_mm[chart.vertices[faces]]
    skin = (shares[..., None] * corners).sum(1).reshape(len(rows), columns, 3)
    pole: Vector3 = mesh.vertices_mm[shape.pole]
    return np.concatenate([skin, np.broadcast_to(pole, (1, columns, 3))])


def _chart(mesh: Mesh, pole: int, name: str) -> _Chart:
    disc = _on_disc(mesh, name)
    centre = disc[pole]
    moved = (disc - centre) / (1 - np.conj(centre) * disc)
    others = mesh.faces[(mesh.faces != pole).all(1)]
    row = -np.log(np.maximum(np.abs(moved), 1e-300))
    angle = np.angle(moved)[others]
    angle = angle[:, :1] + (angle - angle[:, :1] + np.pi) % (2 * np.pi) - np.pi
    copies = [angle + turn for turn in (-2 * np.pi, 0.0, 2 * np.pi)]
    flat = np.stack(
        [
            np.tile(row[others].ravel(), 3),
            np.concatenate([one.ravel() for one in copies]),
            np.zeros(9 * len(others)),
        ],
        axis=1,
    )
    near = (flat[:, 1] > -1.0) & (flat[:, 1] < 2 * np.pi + 1.0)
    faces = np.arange(len(flat)).reshape(-1, 3)
    beside = np.unique(mesh.faces[(mesh.faces == pole).any(1)])
    return _Chart(
        flat,
        faces[near[faces].any(1)].astype(np.int32),
        np.tile(others.ravel(), 3),
        float(row[beside[beside != pole]].min()),
    )


def _on_disc(mesh: Mesh, name: str) -> Complex128[np.ndarray, " n"]:
    """The vertices parametrized on the unit disc, as complex numbers."""
    loops = boundary_loops(mesh.faces)
    count = len(mesh)
    handles = 2 - count + len(find_edges(mesh.faces).ends) - len(mesh.faces) - len(loops)
    if len(loops) != 1 or handles:
        raise ShapeFileError("made.bent.no_disc", name=name, openings=len(loops))
    rim = loops[0].astype(np.int64)
    walked = np.cumsum(lengths(mesh.vertices_mm[np.roll(rim, -1)] - mesh.vertices_mm[rim]))
    disc = np.zeros(count, np.complex128)
    disc[rim] = np.exp(2j * np.pi * np.concatenate([[0.0], walked[:-1]]) / walked[-1])
    free = np.ones(count, np.bool_)
    free[rim] = False
    weights = _mean_value_weights(mesh)
    system = sparse.csc_array(sparse.diags_array(np.asarray(weights.sum(1)).ravel()) - weights)
    inner = system[free][:, free]
    held = -(system[free][:, ~free] @ disc[~free])
    solved = splu(inner).solve(np.column_stack([held.real, held.imag]))
    disc[free] = solved[:, 0] + 1j * solved[:, 1]
    return disc


def _mean_value_weights(mesh: Mesh) -> sparse.csr_array:
    """Mean value weights of each vertex's neighbours, not normalized; all positive."""
    count = len(mesh)
    total = sparse.csr_array((count, count))
    for k in range(3):
        here, first, second = (mesh.faces[:, (k + step) % 3] for step in range(3))
        one = mesh.vertices_mm[first] - mesh.vertices_mm[here]
        two = mesh.vertices_mm[second] - mesh.vertices_mm[here]
        length_one, length_two = lengths(one), lengths(two)
        cosine = (one * two).sum(1) / np.maximum(length_one * length_two, 1e-12)
        half_tangent = np.tan(0.5 * np.arccos(np.clip(cosine, -1.0, 1.0)))
        for end, length in ((first, length_one), (second, length_two)):
            weight = half_tangent / np.maximum(length, 1e-9)
            total = total + sparse.csr_array((weight, (here, end)), shape=(count, count))
    return sparse.csr_array(total)


def _even_grid(mesh: Mesh, chart: _Chart, step_mm: float) -> tuple[Float64[np.ndarray, " r"], int]:
    """Rows about a step apart, and the number of columns at which they are too."""
    corners = mesh.vertices_mm[chart.vertices[chart.faces]]
    flat = chart.flat[chart.faces]
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    a, b = (flat[:, 1] - flat[:, 0])[:, :2], (flat[:, 2] - flat[:, 0])[:, :2]
    doubled = np.maximum(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), 1e-30)[:, None]
    mm_per_row = lengths((one * b[:, 1:] - two * a[:, 1:]) / doubled)
    mm_per_rad = lengths((two * a[:, :1] - one * b[:, :1]) / doubled)
    area = lengths(np.cross(one, two))
    radius_mm = weighted_quantile(mm_per_rad, area, _RESOLVED_SHARE)
    at = flat[..., 0].mean(1)
    bins = np.linspace(0.0, chart.last, _BINS + 1)
    bin_idx = np.clip(np.digitize(at, bins) - 1, 0, _BINS - 1)
    in_bins = [bin_idx == k for k in range(_BINS)]
    of_bins = np.array(
        [
            weighted_quantile(mm_per_row[k], area[k], _RESOLVED_SHARE) if k.any() else np.nan
            for k in in_bins
        ]
    )
    known = np.isfinite(of_bins)
    middles = 0.5 * (bins[1:] + bins[:-1])
    of_bins = np.interp(middles, middles[known], of_bins[known])
    walked = np.concatenate([[0.0], np.cumsum(of_bins * np.diff(bins))])
    count = max(8, round(walked[-1] / step_mm))
    return np.interp(np.linspace(0.0, walked[-1], count + 1), walked, bins), max(
        48, round(2 * np.pi * radius_mm / step_mm)
    )
