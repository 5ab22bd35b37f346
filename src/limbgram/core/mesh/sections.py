"""Sections: exact cuts of a mesh by parallel planes, and which of their outlines are one limb's.

`cut` gives polylines, `level_segments` loose segments. `workbench/edits/cutting.py` splits faces
instead and keeps a part of the mesh, `workbench/measures/levels.py` integrates over the part of a
face below a height, and `core/mesh/axis.py` needs centroids alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32, Int64
from scipy.spatial import KDTree

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import Points2, Points3, Vector3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import find_edges

LEAST_SPACING_MM = 0.05
"""Least distance between sections."""
_TRACKING_LEVELS = 64
"""Heights at which a limb is tracked from end to end."""
_CLEARLY = 0.5
"""A distance or an overlap is clearly less than another at less than this share of it."""
_SHRUNK = 0.7
"""Factor to half an outline's area: overlap is measured with the shrunk outline, so that outlines
that only graze do not overlap."""
_NEAR = 0.1
"""Share of an outline's size within which, on average, the next outline of the same limb lies."""

Outline = Float64[np.ndarray, "_ 2"]
"""A closed polyline in a plane; `_` because each has its own number of points."""


@dataclass(frozen=True, kw_only=True)
class Section:
    """One polyline of a cut; a cut has several where the limb branches.

    Counter-clockwise round the inside, seen from the side to which the normal points. The first
    point is not repeated at the end.
    """

    offset_mm: float
    """Distance of the plane from the origin, along the normal."""
    points_mm: Points3
    closed: bool
    """False where the cut runs into the open brim."""
    crossed: Int32[np.ndarray, "n 2"]
    """Vertices of the edge that each point lies on."""
    shares: Float64[np.ndarray, " n"]
    """Position on that edge, 0 at its first vertex and 1 at its second."""

    @property
    def length_mm(self) -> float:
        ends = np.roll(self.points_mm, -1, axis=0) if self.closed else self.points_mm[1:]
        return float(np.linalg.norm(ends - self.points_mm[: len(ends)], axis=1).sum())

    def area_mm2(self, normal: Vector3) -> float:
        """Enclosed area, negative round a hollow; an open polyline is closed by a straight line."""
        centred = self.points_mm - self.points_mm.mean(0)
        return float(0.5 * np.cross(centred, np.roll(centred, -1, axis=0)).sum(0) @ normal)


Z_AXIS = np.array([0.0, 0.0, 1.0])


def area_and_centroid(points: Points3) -> tuple[float, float, float]:
    """Area in mm2, negative round a hollow, and centroid x, y of a closed polyline across z."""
    base = points[0, :2]
    here = points[:, :2] - base
    after = np.roll(here, -1, axis=0)
    doubled = here[:, 0] * after[:, 1] - here[:, 1] * after[:, 0]
    area = float(doubled.sum()) / 2
    if abs(area) < 1e-9:
        return 0.0, float(base[0]), float(base[1])
    centroid = ((here + after) * doubled[:, None]).sum(0) / (6 * area) + base
    return area, float(centroid[0]), float(centroid[1])


def centroid_mm(points: Points3) -> Vector3:
    """Centroid of the area inside a closed polyline across z."""
    _, x, y = area_and_centroid(points)
    return np.array([x, y, points[0, 2]])


def cut(mesh: Mesh, offsets_mm: Sequence[float], normal: Vector3 = Z_AXIS) -> tuple[Section, ...]:
    """Cut an edge-manifold mesh by planes across a unit normal, in the order of the offsets.

    A vertex on a plane counts as above it, so every cut is a clean chain of edge crossings. A
    plane that misses the mesh gives no section.
    """
    heights = mesh.vertices_mm @ normal
    edges = find_edges(mesh.faces)
    face_edges = edges.of_half_edge.reshape(-1, 3)
    a, b, c = (heights[mesh.faces[:, k]] for k in range(3))
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
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


@dataclass(frozen=True)
class LevelSegments:
    """Where level planes cut faces: a segment each, the inside to its left, seen from above."""

    plane: Int64[np.ndarray, " s"]
    """Which of the planes."""
    start_mm: Points2
    end_mm: Points2

    def at(self, plane: int) -> Float64[np.ndarray, "n 2 2"]:
        """Segments of one plane: start and end."""
        own = self.plane == plane
        return np.stack([self.start_mm[own], self.end_mm[own]], axis=1)


def level_segments(mesh: Mesh, z_mm: Float64[np.ndarray, " m"]) -> LevelSegments:
    """Cut any mesh, non-manifold ones too, at rising heights; the segments are not chained.

    A vertex on a plane counts as above it, as for `cut`.
    """
    heights = mesh.vertices_mm[:, 2]
    of_corners = heights[mesh.faces]
    a, b, c = of_corners.T
    first = np.searchsorted(z_mm, np.minimum(np.minimum(a, b), c), side="right")
    count = np.searchsorted(z_mm, np.maximum(np.maximum(a, b), c), side="right") - first
    face = np.repeat(np.arange(len(mesh.faces)), count)
    plane = np.arange(len(face)) - np.repeat(np.cumsum(count) - count - first, count)
    above = of_corners[face] >= z_mm[plane][:, None]
    after = np.roll(above, -1, axis=1)
    start = _crossing(mesh, face, (above & ~after).argmax(1), z_mm[plane])
    end = _crossing(mesh, face, (~above & after).argmax(1), z_mm[plane])
    return LevelSegments(plane, start, end)


def _crossing(
    mesh: Mesh,
    face: Int64[np.ndarray, " s"],
    corner: Int64[np.ndarray, " s"],
    z_mm: Float64[np.ndarray, " s"],
) -> Points2:
    """Where edges cross their planes; the same to the bit from both faces of an edge."""
    one, two = mesh.faces[face, corner], mesh.faces[face, (corner + 1) % 3]
    low, high = np.minimum(one, two), np.maximum(one, two)
    p, q = mesh.vertices_mm[low], mesh.vertices_mm[high]
    fraction = ((z_mm - p[:, 2]) / (q[:, 2] - p[:, 2]))[:, None]
    # In this form an edge that ends on the plane gives exactly its vertex, as all edges there do.
    return (1 - fraction) * p[:, :2] + fraction * q[:, :2]


def _outermost_round(rings: Sequence[Outline], point: Float64[np.ndarray, "2"]) -> int | None:
    """Index of the outermost outline that contains a point; None if none does."""
    round_it = [k for k, ring in enumerate(rings) if contains_point(ring, point)]
    return max(round_it, key=lambda k: float(np.ptp(rings[k], axis=0).prod()), default=None)


RingsAt = Callable[[Sequence[float]], Sequence[Sequence[Outline]]]
"""The closed outlines at each height, none inside another; empty where there is none."""


def outlines_of_limb(
    rings_at: RingsAt,
    ends_mm: tuple[float, float],
    heights_mm: Sequence[float],
    found: Sequence[Sequence[Outline]],
    point: Float64[np.ndarray, "2"],
) -> list[int | None]:
    """At each height, the index of the outline of the limb round a line along z.

    That is the outline that contains the line. Where none does, the limb is tracked from where one
    does, from outline to overlapping outline; from a fork on, from where an outline is clearly the
    nearest to the line. None where the limb has ended or cannot be told from others. The answer at
    one height does not depend on the other heights asked for.

    Args:
        ends_mm: The heights between which the limb is tracked.
        found: The outlines at each of `heights_mm`.
        point: Where the line passes, x and y.
    """
    chosen = [_outermost_round(rings, point) for rings in found]
    unknown = [k for k, one in enumerate(chosen) if one is None and found[k]]
    if not unknown:
        return chosen
    steps = (np.arange(_TRACKING_LEVELS) + 0.5) / _TRACKING_LEVELS
    tracking_mm = (ends_mm[0] + (ends_mm[1] - ends_mm[0]) * steps).tolist()
    closed = [(height, rings) for height, rings in zip(tracking_mm, rings_at(tracking_mm)) if rings]
    tracked_mm = np.array([height for height, _ in closed])
    levels = [rings for _, rings in closed]
    limb = _tracked(levels, point)
    for k in unknown:
        above = int(np.searchsorted(tracked_mm, heights_mm[k]))
        neighbours = [
            levels[at][one]
            for at in (above - 1, above)
            if 0 <= at < len(levels) and (one := limb[at]) is not None
        ]
        next_rings = [_overlapping(ring, found[k]) for ring in neighbours]
        candidates = {one[0] for one in next_rings if len(one) == 1}
        chosen[k] = candidates.pop() if len(candidates) == 1 else None
    return chosen


def _tracked(
    levels: Sequence[Sequence[Outline]], point: Float64[np.ndarray, "2"]
) -> list[int | None]:
    """The limb's outline at each level, tracked from the levels at which it contains the line."""
    chosen = [_outermost_round(rings, point) for rings in levels]
    starts = [k for k, one in enumerate(chosen) if one is not None]
    if not starts:
        seed = _clearest(levels, range(len(levels)), point)
        if seed is None:
            return chosen
        chosen[seed[0]] = seed[1]
        starts = [seed[0]]
    forks = [
        fork for start in starts for step in (-1, 1) for fork in _walk(levels, chosen, start, step)
    ]
    while forks:
        fork, before, step = forks.pop()
        if chosen[fork] is not None:
            continue
        end = fork
        while 0 <= end < len(levels) and chosen[end] is None:
            end += step
        seed = _clearest(levels, range(fork, end, step), point)
        if seed is None:
            continue
        trial = chosen.copy()
        trial[seed[0]] = seed[1]
        more = [one for sign in (-step, step) for one in _walk(levels, trial, seed[0], sign)]
        if trial[fork] in _overlapping(levels[before][chosen[before] or 0], levels[fork]):
            chosen, forks = trial, forks + more
    return chosen


def _walk(
    levels: Sequence[Sequence[Outline]], chosen: list[int | None], start: int, step: int
) -> list[tuple[int, int, int]]:
    """Fill in `chosen` from one level on until the limb ends or forks.

    Returns of a fork its level, the level before it and the step between them.
    """
    at = start
    while 0 <= at + step < len(levels) and chosen[at + step] is None:
        found = _overlapping(levels[at][chosen[at] or 0], levels[at + step])
        if len(found) != 1:
            return [(at + step, at, step)] if found else []
        at += step
        chosen[at] = found[0]
    return []


def _clearest(
    levels: Sequence[Sequence[Outline]], among: Sequence[int], point: Float64[np.ndarray, "2"]
) -> tuple[int, int] | None:
    """The level at which one outline is most clearly the nearest to a point, and that outline."""
    several = [k for k in among if len(levels[k]) > 1]
    best: tuple[float, int, int] | None = None
    for k in several or among:
        distances_mm = np.array([_distance_mm(ring, point) for ring in levels[k]])
        nearest = int(distances_mm.argmin())
        ambiguity = float(distances_mm[nearest])
        if several:
            ambiguity /= max(float(np.sort(distances_mm)[1]), np.finfo(float).tiny)
        if best is None or ambiguity < best[0]:
            best = ambiguity, k, nearest
    if best is None or (several and best[0] > _CLEARLY):
        return None
    return best[1:]


def _overlapping(ring: Outline, rings: Sequence[Outline]) -> list[int]:
    """The outlines at the next height that overlap this one; several if none clearly most."""
    overlap = np.array([max(_share_inside(ring, one), _share_inside(one, ring)) for one in rings])
    if not overlap.any():  # thin and bent, as the section of half a shell: judged by distance
        tree, size_mm = KDTree(ring), float(np.linalg.norm(np.ptp(ring, axis=0)))
        away_mm = np.array([float(tree.query(one)[0].mean()) for one in rings])
        overlap = np.where(away_mm < _NEAR * size_mm, 1 / np.maximum(away_mm, 1e-9 * size_mm), 0.0)
    return np.flatnonzero((overlap > 0) & (overlap >= _CLEARLY * overlap.max(initial=0.0))).tolist()


def _share_inside(ring: Outline, other: Outline) -> float:
    """Share of an outline's points, shrunk towards their mean, that lie inside another."""
    if (ring.min(0) > other.max(0)).any() or (ring.max(0) < other.min(0)).any():
        return 0.0
    mean = ring.mean(0)
    shrunk = mean + _SHRUNK * (ring - mean)
    (x, y), (x_next, y_next) = other.T, np.roll(other, -1, axis=0).T
    ray_y = shrunk[:, 1, None]
    straddles = (y > ray_y) != (y_next > ray_y)
    rise = np.where(y_next == y, 1.0, y_next - y)
    right = x + (ray_y - y) * (x_next - x) / rise > shrunk[:, 0, None]
    return float(((right & straddles).sum(1) % 2).mean())


def contains_point(ring: Outline, point: Float64[np.ndarray, "2"]) -> bool:
    """Whether a point lies inside a ring: a ray to +x crosses it an odd number of times."""
    (x, y), (x_next, y_next) = (ring - point).T, (np.roll(ring, -1, axis=0) - point).T
    straddles = (y > 0) != (y_next > 0)
    rise = np.where(straddles, y_next - y, 1.0)
    return bool(((x - y * (x_next - x) / rise > 0) & straddles).sum() % 2)


def _distance_mm(ring: Outline, point: Float64[np.ndarray, "2"]) -> float:
    """Distance of a point from a ring."""
    from_start, segments = point - ring, np.roll(ring, -1, axis=0) - ring
    squares = np.maximum((segments**2).sum(1), np.finfo(float).tiny)
    fractions = np.clip((from_start * segments).sum(1) / squares, 0.0, 1.0)
    return float(np.linalg.norm(from_start - fractions[:, None] * segments, axis=1).min())


def heights_between(mesh: Mesh, spacing_mm: float) -> Float64[np.ndarray, " k"]:
    """Multiples of the spacing that lie within the mesh's extent along z.

    Raises:
        OptionsError: the spacing is less than `LEAST_SPACING_MM`.
    """
    if not spacing_mm >= LEAST_SPACING_MM:
        raise OptionsError("mesh.sections.close", spacing_mm=spacing_mm, least_mm=LEAST_SPACING_MM)
    low, high = float(mesh.vertices_mm[:, 2].min()), float(mesh.vertices_mm[:, 2].max())
    first, last = np.floor(low / spacing_mm) + 1, np.ceil(high / spacing_mm) - 1
    return spacing_mm * np.arange(first, last + 1)


@dataclass(frozen=True)
class _Chain:
    edges: Int64[np.ndarray, " k"]
    closed: bool


def _chains(enters: Int64[np.ndarray, " k"], leaves: Int64[np.ndarray, " k"]) -> list[_Chain]:
    """Edge crossings in order: first chains that start at the boundary, then the loops."""
    next_edge = dict(zip(enters.tolist(), leaves.tolist(), strict=True))
    starts = sorted(set(next_edge) - set(next_edge.values()))
    chains = [_Chain(_follow(next_edge, start), closed=False) for start in starts]
    while next_edge:
        chains.append(_Chain(_follow(next_edge, min(next_edge))[:-1], closed=True))
    return chains


def _follow(next_edge: dict[int, int], start: int) -> Int64[np.ndarray, " k"]:
    """The chain from an edge on; its links are taken out of `next_edge`."""
    chain = [start]
    while chain[-1] in next_edge:
        chain.append(next_edge.pop(chain[-1]))
    return np.array(chain, np.int64)
