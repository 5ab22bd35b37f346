"""Bent shapes: any surface with one open end, as rings of a chart, however it bends.

In      a mesh with one open edge that lies level at the bottom, as a foot with its shank, upside
        down; and the pole, the vertex about which the rings close. `stood` makes them of a mesh as
        it lies in its file: cut level at its longest open edge, with the pole where the way over
        the surface from there is longest, as a toe's tip.
Out     a Limb: what is photographed is the limb built of these rings, and that is the truth.
Method  The surface is laid out on a disc with mean value weights (Floater 2003), its open edge on
        the circle: no triangle turns over. A Moebius map takes the pole to the middle; distances
        from it, as logarithms, are rows, and directions are columns. Such a map is nearly
        conformal, and along a tube its rows and columns are even; what bulges far out of it, as a
        heel, gets fewer. Rays from an axis (scan.py) see no such surface.
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
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.interval import weighted_quantile
from limbgram.core.mesh.closest_point import TriangleTree, nearest_shares
from limbgram.core.mesh.mesh import Mesh, lengths
from limbgram.core.mesh.topology import boundary_loops, find_edges, largest_piece
from limbgram.findings import Finding
from limbgram.synthetic.props.details import PLAIN, SkinDetails
from limbgram.synthetic.props.limb import (
    Limb,
    Relief,
    limb_of_skin,
    relieved,
)
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.measures.geodesic import length_mm

_CLEAR_MM = 0.5
"""Above the highest place of a ragged open edge, where it is cut level."""
_SLOWEST = 0.85
"""So much of the surface has rows and columns as close as asked; bulges have wider ones."""
_BINS = 400


@dataclass(frozen=True, kw_only=True)
class BentShape:
    """A surface with one open edge; two are the same if their names are."""

    sha256: str
    """Of the file, or another name of the shape."""
    name: str = field(default="", compare=False)
    """Of the file, for people; empty where there is none."""
    mm_per_unit: float = 1.0
    side: Literal["left", "right", "none"]
    mesh: Mesh = field(compare=False)
    """Its open edge lies in the plane z = 0, the rest above it; millimetres."""
    pole: int = field(compare=False)
    """Vertex at which the rings close: a toe's tip, the middle of a closed neck."""
    anterior_rad: float = field(default=0.5 * np.pi, compare=False)
    notes: tuple[Finding, ...] = field(default=(), compare=False)

    @property
    def height_mm(self) -> float:
        return float(self.mesh.vertices_mm[:, 2].max())


class Stood(NamedTuple):
    """A surface on its open edge, which lies level in the plane z = 0."""

    mesh: Mesh
    pole: int
    world_from_mesh: Rigid
    cut_mm: float
    """What was cut off the open edge, where it was highest."""


def stood(mesh: Mesh, name: str) -> Stood:
    """Stand a mesh on its longest open edge, cut level, and find where its rings close.

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
    turn = upright(up)
    heights = (rim - middle) @ up
    start = middle + (float(heights.max()) + _CLEAR_MM) * up
    world_from_mesh = Rigid(turn, -turn @ start)
    level = mesh.moved(world_from_mesh)
    level = largest_piece(keep_positive(level, level.vertices_mm[:, 2]).mesh)[0]
    return Stood(level, _farthest(level), world_from_mesh, float(np.ptp(heights)) + _CLEAR_MM)


def upright(up: Vector3) -> Float64[np.ndarray, "3 3"]:
    """A rotation that takes this direction to +z."""
    beside = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = beside - (beside @ up) * up
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(up, x), up])


def _farthest(mesh: Mesh) -> int:
    """The vertex with the longest way along edges from the open one."""
    ends = find_edges(mesh.faces).ends
    long = lengths(mesh.vertices_mm[ends[:, 1]] - mesh.vertices_mm[ends[:, 0]])
    ways = sparse.csr_array((long, (ends[:, 0], ends[:, 1])), shape=(len(mesh), len(mesh)))
    rim = np.concatenate(boundary_loops(mesh.faces))
    far = dijkstra(ways, directed=False, indices=rim, min_only=True)
    return int(np.where(np.isfinite(far), far, -1.0).argmax())


def limb_of_bent(
    shape: BentShape,
    seed: int,
    step_mm: float,
    base_mm: float,
    relief: Relief,
    details: SkinDetails = PLAIN,
) -> Limb:
    """Build the limb, with the fine relief and the details of this seed on it.

    Raises:
        ShapeFileError: see the head of this file.
    """
    skin = _rings(shape, step_mm)
    skin = relieved(skin, relief, np.random.default_rng((seed, 1)))
    side = "left" if shape.side == "left" else "right"
    return limb_of_skin(skin, details, seed, base_mm, side, shape.anterior_rad)


@dataclass(frozen=True)
class _Chart:
    """The surface without its pole, laid out by rows and columns."""

    flat: Points3
    """Row, column in radians (more than once round where a face needs it), and 0."""
    faces: np.ndarray
    vertices: np.ndarray
    """Of the mesh, for each of the chart's."""
    last: float
    """Row of the pole's nearest neighbour."""


def _rings(shape: BentShape, step_mm: float) -> Float64[np.ndarray, "rows columns 3"]:
    """Points in rings from the open edge to the pole."""
    mesh = shape.mesh
    chart = _chart(mesh, shape.pole, shape.name or shape.sha256)
    rows, columns = _even(mesh, chart, step_mm)
    around = 2 * np.pi * np.arange(columns) / columns
    at = np.stack(np.broadcast_arrays(rows[:, None], around, 0.0), -1).reshape(-1, 3)
    tree = TriangleTree.of(chart.flat, chart.faces)
    faces = chart.faces[tree.closest(at).faces]
    shares = nearest_shares(chart.flat[faces], at)
    corners = mesh.vertices_mm[chart.vertices[faces]]
    skin = (shares[..., None] * corners).sum(1).reshape(len(rows), columns, 3)
    pole: Vector3 = mesh.vertices_mm[shape.pole]
    return np.concatenate([skin, np.broadcast_to(pole, (1, columns, 3))])


def _chart(mesh: Mesh, pole: int, name: str) -> _Chart:
    disc = _on_disc(mesh, name)
    middle = disc[pole]
    moved = (disc - middle) / (1 - np.conj(middle) * disc)
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
    """Places of the vertices on the unit disc."""
    loops = boundary_loops(mesh.faces)
    count = len(mesh)
    handles = 2 - count + len(find_edges(mesh.faces).ends) - len(mesh.faces) - len(loops)
    if len(loops) != 1 or handles:
        raise ShapeFileError("made.bent.no_disc", name=name, openings=len(loops))
    rim = loops[0].astype(np.int64)
    walked = np.cumsum(lengths(mesh.vertices_mm[np.roll(rim, -1)] - mesh.vertices_mm[rim]))
    places = np.zeros(count, np.complex128)
    places[rim] = np.exp(2j * np.pi * np.concatenate([[0.0], walked[:-1]]) / walked[-1])
    free = np.ones(count, np.bool_)
    free[rim] = False
    weights = _mean_value(mesh)
    system = sparse.csc_array(sparse.diags_array(np.asarray(weights.sum(1)).ravel()) - weights)
    inner = system[free][:, free]
    held = -(system[free][:, ~free] @ places[~free])
    solved = splu(inner).solve(np.column_stack([held.real, held.imag]))
    places[free] = solved[:, 0] + 1j * solved[:, 1]
    return places


def _mean_value(mesh: Mesh) -> sparse.csr_array:
    """Weights of a vertex's neighbours, all positive."""
    count = len(mesh)
    total = sparse.csr_array((count, count))
    for k in range(3):
        here, first, second = (mesh.faces[:, (k + step) % 3] for step in range(3))
        one = mesh.vertices_mm[first] - mesh.vertices_mm[here]
        two = mesh.vertices_mm[second] - mesh.vertices_mm[here]
        long_one, long_two = lengths(one), lengths(two)
        cosine = (one * two).sum(1) / np.maximum(long_one * long_two, 1e-12)
        half = np.tan(0.5 * np.arccos(np.clip(cosine, -1.0, 1.0)))
        for end, long in ((first, long_one), (second, long_two)):
            weight = half / np.maximum(long, 1e-9)
            total = total + sparse.csr_array((weight, (here, end)), shape=(count, count))
    return sparse.csr_array(total)


def _even(mesh: Mesh, chart: _Chart, step_mm: float) -> tuple[Float64[np.ndarray, " r"], int]:
    """Rows that are about a step apart, and how many columns are."""
    corners = mesh.vertices_mm[chart.vertices[chart.faces]]
    flat = chart.flat[chart.faces]
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    a, b = (flat[:, 1] - flat[:, 0])[:, :2], (flat[:, 2] - flat[:, 0])[:, :2]
    turned = np.maximum(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), 1e-30)[:, None]
    by_row = lengths((one * b[:, 1:] - two * a[:, 1:]) / turned)
    by_turn = lengths((two * a[:, :1] - one * b[:, :1]) / turned)
    area = lengths(np.cross(one, two))
    widest = weighted_quantile(by_turn, area, _SLOWEST)
    at = flat[..., 0].mean(1)
    bins = np.linspace(0.0, chart.last, _BINS + 1)
    number = np.clip(np.digitize(at, bins) - 1, 0, _BINS - 1)
    rows = [number == k for k in range(_BINS)]
    speed = np.array(
        [weighted_quantile(by_row[k], area[k], _SLOWEST) if k.any() else np.nan for k in rows]
    )
    known = np.isfinite(speed)
    middles = 0.5 * (bins[1:] + bins[:-1])
    speed = np.interp(middles, middles[known], speed[known])
    walked = np.concatenate([[0.0], np.cumsum(speed * np.diff(bins))])
    count = max(8, round(walked[-1] / step_mm))
    return np.interp(np.linspace(0.0, walked[-1], count + 1), walked, bins), max(
        48, round(2 * np.pi * widest / step_mm)
    )
