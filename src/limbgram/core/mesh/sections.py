"""Sections: exact cuts of a mesh by parallel planes, chained to polylines.

This is the one cut that gives lines. `workbench/edits/cutting.py` splits faces instead and keeps a
part of the mesh, `workbench/measures/levels.py` integrates over the part of a face below a height,
and `core/mesh/axis.py` needs middles alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32, Int64

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import Points2, Points3, Vector3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import find_edges

LEAST_SPACING_MM = 0.05
"""Closest that sections are put."""


@dataclass(frozen=True, kw_only=True)
class Section:
    """One polyline of a cut; a cut has several where the limb branches.

    Counter-clockwise round the inside, seen from the side to which the normal points. The first
    point is not repeated at the end.
    """

    offset_mm: float
    """Distance of the plane from the world's origin, along the normal."""
    points_mm: Points3
    closed: bool
    """False where the cut runs into the open brim."""
    crossed: Int32[np.ndarray, "n 2"]
    """The mesh's vertices at the ends of the edge that each point lies on."""
    shares: Float64[np.ndarray, " n"]
    """How far along that edge, 0 at its first end."""

    @property
    def length_mm(self) -> float:
        ends = np.roll(self.points_mm, -1, axis=0) if self.closed else self.points_mm[1:]
        return float(np.linalg.norm(ends - self.points_mm[: len(ends)], axis=1).sum())

    def area_mm2(self, normal: Vector3) -> float:
        """Enclosed area, negative for the rim of a hollow; an open one is closed straight."""
        around = self.points_mm - self.points_mm.mean(0)
        return float(0.5 * np.cross(around, np.roll(around, -1, axis=0)).sum(0) @ normal)


Z_AXIS = np.array([0.0, 0.0, 1.0])


def cut(mesh: Mesh, offsets_mm: Sequence[float], normal: Vector3 = Z_AXIS) -> tuple[Section, ...]:
    """Cut an edge-manifold mesh by planes across a unit normal, in the order of the offsets.

    A vertex on a plane counts as above it, so every cut is a clean chain of edge crossings. A
    plane that misses the mesh gives no section.
    """
    heights = mesh.vertices_mm @ normal
    edges = find_edges(mesh.faces)
    face_edges = edges.of_half_edge.reshape(-1, 3)
    first, second, third = (heights[mesh.faces[:, k]] for k in range(3))
    low = np.minimum(np.minimum(first, second), third)
    high = np.maximum(np.maximum(first, second), third)
    sections: list[Section] = []
    for offset_mm in offsets_mm:
        crossed = np.flatnonzero((low < offset_mm) & (high >= offset_mm))
        if not len(crossed):
            continue
        above = heights[mesh.faces[crossed]] >= offset_mm
        # With the inside to the left, a section enters a face where its half-edges come down.
        rises = ~above & np.roll(above, -1, axis=1)
        falls = above & ~np.roll(above, -1, axis=1)
        enters, leaves = face_edges[crossed][falls], face_edges[crossed][rises]
        for chain in _chains(enters, leaves):
            ends = edges.ends[chain.edges]
            share = (offset_mm - heights[ends[:, 0]]) / (heights[ends[:, 1]] - heights[ends[:, 0]])
            first, second = mesh.vertices_mm[ends[:, 0]], mesh.vertices_mm[ends[:, 1]]
            points_mm = first + share[:, None] * (second - first)
            sections.append(
                Section(
                    offset_mm=float(offset_mm),
                    points_mm=points_mm,
                    closed=chain.closed,
                    crossed=ends,
                    shares=share,
                )
            )
    return tuple(sections)


def passed_by(rings: Sequence[Points2], place: Float64[np.ndarray, "2"]) -> int:
    """Which of several closed outlines a line through a place goes through.

    Of outlines in each other the outermost; where the line misses them all, the nearest.
    """
    held = [k for k, ring in enumerate(rings) if holds(ring, place)]
    if held:
        return max(held, key=lambda k: float(np.ptp(rings[k], axis=0).prod()))
    return min(range(len(rings)), key=lambda k: _distance_mm(rings[k], place))


def holds(ring: Points2, place: Float64[np.ndarray, "2"]) -> bool:
    """Whether a place lies inside a ring: a ray to +x crosses it an odd number of times."""
    (x, y), (x_next, y_next) = (ring - place).T, (np.roll(ring, -1, axis=0) - place).T
    astride = (y > 0) != (y_next > 0)
    rise = np.where(astride, y_next - y, 1.0)
    return bool(((x - y * (x_next - x) / rise > 0) & astride).sum() % 2)


def _distance_mm(ring: Points2, place: Float64[np.ndarray, "2"]) -> float:
    """Of a place from a ring."""
    from_start, steps = place - ring, np.roll(ring, -1, axis=0) - ring
    size = np.maximum((steps**2).sum(1), np.finfo(float).tiny)
    shares = np.clip((from_start * steps).sum(1) / size, 0.0, 1.0)
    return float(np.linalg.norm(from_start - shares[:, None] * steps, axis=1).min())


def heights_between(mesh: Mesh, spacing_mm: float) -> Float64[np.ndarray, " k"]:
    """Multiples of the spacing that lie within the mesh's extent along z.

    Raises:
        OptionsError: the spacing is none, or so small that nobody could read the sections.
    """
    if not spacing_mm >= LEAST_SPACING_MM:
        raise OptionsError(
            f"Sections {spacing_mm:g} mm apart cannot be: take {LEAST_SPACING_MM:g} mm or more "
            "(10 is usual)."
        )
    low, high = float(mesh.vertices_mm[:, 2].min()), float(mesh.vertices_mm[:, 2].max())
    first, last = np.floor(low / spacing_mm) + 1, np.ceil(high / spacing_mm) - 1
    return spacing_mm * np.arange(first, last + 1)


@dataclass(frozen=True)
class _Chain:
    edges: Int64[np.ndarray, " k"]
    closed: bool


def _chains(enters: Int64[np.ndarray, " k"], leaves: Int64[np.ndarray, " k"]) -> list[_Chain]:
    """Edge crossings in order: first chains that start at the boundary, then the loops."""
    following = dict(zip(enters.tolist(), leaves.tolist(), strict=True))
    starts = sorted(set(following) - set(following.values()))
    chains = [_Chain(_follow(following, start), closed=False) for start in starts]
    while following:
        chains.append(_Chain(_follow(following, min(following))[:-1], closed=True))
    return chains


def _follow(following: dict[int, int], start: int) -> Int64[np.ndarray, " k"]:
    chain = [start]
    while chain[-1] in following:
        chain.append(following.pop(chain[-1]))
    return np.array(chain, np.int64)
