"""Sections: exact cuts of a mesh by parallel planes.

`cut` chains them to polylines, `level_segments` leaves them loose. `workbench/edits/cutting.py`
splits faces instead and keeps a part of the mesh, `workbench/measures/levels.py` integrates over
the part of a face below a height, and `core/mesh/axis.py` needs middles alone.
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
"""Closest that sections are put."""
_FOLLOWED = 64
"""Heights at which a limb is followed from end to end."""
_CLEARLY = 0.5
"""One is clearly nearer, or lies clearly less over another, at less than this share of the next."""
_DRAWN_IN = 0.7
"""Half of an outline's area lies within it, drawn in so far: what only grazes lies not over it."""

_BESIDE = 0.1
"""Of an outline's size: so near to it, on average, lies the next one of the same limb."""

Outline = Float64[np.ndarray, "_ 2"]
"""A closed polyline in a plane; several together have each their own number of points."""


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


def area_and_centroid(points: Points3) -> tuple[float, float, float]:
    """Of a closed polyline across z: its area, mm2, negative for a rim, and the place x, y."""
    base = points[0, :2]
    here = points[:, :2] - base
    ahead = np.roll(here, -1, axis=0)
    double = here[:, 0] * ahead[:, 1] - here[:, 1] * ahead[:, 0]
    area = float(double.sum()) / 2
    if abs(area) < 1e-9:
        return 0.0, float(base[0]), float(base[1])
    middle = ((here + ahead) * double[:, None]).sum(0) / (6 * area) + base
    return area, float(middle[0]), float(middle[1])


def centroid_mm(points: Points3) -> Vector3:
    """Middle of the area inside a closed polyline at one height."""
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
    """Cut any mesh, a torn one too, at rising heights, all at once; segments are not chained.

    A vertex on a plane counts as above it, as for `cut`.
    """
    heights = mesh.vertices_mm[:, 2]
    of_corners = heights[mesh.faces]
    one, two, three = of_corners.T
    first = np.searchsorted(z_mm, np.minimum(np.minimum(one, two), three), side="right")
    count = np.searchsorted(z_mm, np.maximum(np.maximum(one, two), three), side="right") - first
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
    """Crossings of edges; the same to the bit from both faces of an edge."""
    one, two = mesh.faces[face, corner], mesh.faces[face, (corner + 1) % 3]
    low, high = np.minimum(one, two), np.maximum(one, two)
    p, q = mesh.vertices_mm[low], mesh.vertices_mm[high]
    share = ((z_mm - p[:, 2]) / (q[:, 2] - p[:, 2]))[:, None]
    # In this form an edge that ends on the plane gives its very vertex, as all edges there do.
    return (1 - share) * p[:, :2] + share * q[:, :2]


def passed_by(rings: Sequence[Outline], place: Float64[np.ndarray, "2"]) -> int | None:
    """Which of several closed outlines a line through a place goes through; None if it misses all.

    Of outlines in each other the outermost.
    """
    held = [k for k, ring in enumerate(rings) if holds(ring, place)]
    return max(held, key=lambda k: float(np.ptp(rings[k], axis=0).prod()), default=None)


RingsAt = Callable[[Sequence[float]], Sequence[Sequence[Outline]]]
"""The whole outlines at each height, none in another; nothing where there is no whole one."""


def of_one_limb(
    rings_at: RingsAt,
    ends_mm: tuple[float, float],
    heights_mm: Sequence[float],
    found: Sequence[Sequence[Outline]],
    place: Float64[np.ndarray, "2"],
) -> list[int | None]:
    """Which outline at each height is of the limb that a line goes through.

    The one that the line goes through. Where it misses all, the limb is followed from where it
    does not, from outline to outline that lies over it; where the limb forks, from where an
    outline is clearly the nearest to the line. None where the limb has ended, or where nothing
    tells which it is. What is asked for at other heights has no part in the answer.

    Args:
        ends_mm: The heights between which the limb is followed.
        found: The outlines at each of the heights that are asked for.
    """
    chosen = [passed_by(rings, place) for rings in found]
    lost = [k for k, one in enumerate(chosen) if one is None and found[k]]
    if not lost:
        return chosen
    steps = (np.arange(_FOLLOWED) + 0.5) / _FOLLOWED
    along = (ends_mm[0] + (ends_mm[1] - ends_mm[0]) * steps).tolist()
    whole = [(height, rings) for height, rings in zip(along, rings_at(along)) if rings]
    known_mm = np.array([height for height, _ in whole])
    levels = [rings for _, rings in whole]
    limb = _followed(levels, place)
    for k in lost:
        above = int(np.searchsorted(known_mm, heights_mm[k]))
        beside = [
            levels[at][one]
            for at in (above - 1, above)
            if 0 <= at < len(levels) and (one := limb[at]) is not None
        ]
        told = {ways[0] for ring in beside if len(ways := _continued(ring, found[k])) == 1}
        chosen[k] = told.pop() if len(told) == 1 else None
    return chosen


def _followed(
    levels: Sequence[Sequence[Outline]], place: Float64[np.ndarray, "2"]
) -> list[int | None]:
    """The limb's outline at each level, from where the line goes through it."""
    chosen = [passed_by(rings, place) for rings in levels]
    starts = [k for k, one in enumerate(chosen) if one is not None]
    if not starts:
        seed = _clearest(levels, range(len(levels)), place)
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
        seed = _clearest(levels, range(fork, end, step), place)
        if seed is None:
            continue
        tried = chosen.copy()
        tried[seed[0]] = seed[1]
        more = [one for way in (-step, step) for one in _walk(levels, tried, seed[0], way)]
        if tried[fork] in _continued(levels[before][chosen[before] or 0], levels[fork]):
            chosen, forks = tried, forks + more
    return chosen


def _walk(
    levels: Sequence[Sequence[Outline]], chosen: list[int | None], start: int, step: int
) -> list[tuple[int, int, int]]:
    """Choose from one level on until the limb ends, or forks: there, from where, and the way."""
    at = start
    while 0 <= at + step < len(levels) and chosen[at + step] is None:
        found = _continued(levels[at][chosen[at] or 0], levels[at + step])
        if len(found) != 1:
            return [(at + step, at, step)] if found else []
        at += step
        chosen[at] = found[0]
    return []


def _clearest(
    levels: Sequence[Sequence[Outline]], among: Sequence[int], place: Float64[np.ndarray, "2"]
) -> tuple[int, int] | None:
    """The level at which one outline is most clearly the nearest to a place, and that outline."""
    several = [k for k in among if len(levels[k]) > 1]
    best: tuple[float, int, int] | None = None
    for k in several or among:
        away_mm = np.array([_distance_mm(ring, place) for ring in levels[k]])
        nearest = int(away_mm.argmin())
        unclear = float(away_mm[nearest])
        if several:
            unclear /= max(float(np.sort(away_mm)[1]), np.finfo(float).tiny)
        if best is None or unclear < best[0]:
            best = unclear, k, nearest
    if best is None or (several and best[0] > _CLEARLY):
        return None
    return best[1:]


def _continued(ring: Outline, rings: Sequence[Outline]) -> list[int]:
    """The outlines at the next height that lie over one: several where it is clearly none."""
    over = np.array([max(_share_in(ring, one), _share_in(one, ring)) for one in rings])
    if not over.any():  # thin and bent, as the section of half a shell, whose middle is air
        tree, own_mm = KDTree(ring), float(np.linalg.norm(np.ptp(ring, axis=0)))
        away_mm = np.array([float(tree.query(one)[0].mean()) for one in rings])
        over = np.where(away_mm < _BESIDE * own_mm, 1 / np.maximum(away_mm, 1e-9 * own_mm), 0.0)
    return np.flatnonzero((over > 0) & (over >= _CLEARLY * over.max(initial=0.0))).tolist()


def _share_in(ring: Outline, other: Outline) -> float:
    """How much of an outline, drawn in towards its middle, lies in another."""
    if (ring.min(0) > other.max(0)).any() or (ring.max(0) < other.min(0)).any():
        return 0.0
    middle = ring.mean(0)
    inner = middle + _DRAWN_IN * (ring - middle)
    (x, y), (x_next, y_next) = other.T, np.roll(other, -1, axis=0).T
    across = inner[:, 1, None]
    astride = (y > across) != (y_next > across)
    rise = np.where(y_next == y, 1.0, y_next - y)
    beyond = x + (across - y) * (x_next - x) / rise > inner[:, 0, None]
    return float(((beyond & astride).sum(1) % 2).mean())


def holds(ring: Outline, place: Float64[np.ndarray, "2"]) -> bool:
    """Whether a place lies inside a ring: a ray to +x crosses it an odd number of times."""
    (x, y), (x_next, y_next) = (ring - place).T, (np.roll(ring, -1, axis=0) - place).T
    astride = (y > 0) != (y_next > 0)
    rise = np.where(astride, y_next - y, 1.0)
    return bool(((x - y * (x_next - x) / rise > 0) & astride).sum() % 2)


def _distance_mm(ring: Outline, place: Float64[np.ndarray, "2"]) -> float:
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
