"""Ball Pivoting: a mesh whose vertices are the cloud's own points.

In      a Cloud: merged points with outward normals.
Out     a Mesh: edge-manifold, consistently oriented; it may have holes and islands (`repair`).
Method  Bernardini, Mittleman, Rushmeier, Silva and Taubin 1999 with balls of increasing radius;
        points closer to each other than half the typical spacing are thinned first.
        Points lie in a hash grid, so far outliers cost nothing; a bucket may hold points of several
        cells, so every reader checks distances.
        A face (a, b, o) is counter-clockwise seen from outside, where the ball lies. A front edge
        runs a to b as in its one face; the ball rolls over it, away from o, until it touches a
        point k; the new face is (b, a, k). A hash table finds edges by their ends, so gluing is one
        look-up and the loops of the paper need no lists. Edges are processed in the order in which
        they were made, so the front grows evenly and the result depends on the points alone.
Fails   SurfaceError: the points do not make a surface.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from limbgram.core.errors import SurfaceError
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Cloud, Mesh
from limbgram.core.run import track

_HASH_X, _HASH_Y, _HASH_Z = 73856093, 19349663, 83492791
"""Primes of the spatial hash."""


class Grid(NamedTuple):
    """A hash grid: the points of bucket b are order[starts[b]:starts[b + 1]]."""

    low: np.ndarray
    cell: float
    starts: np.ndarray
    order: np.ndarray


def build_grid(points: np.ndarray, cell: float) -> Grid:
    """The hash grid of these points, with cells of this size."""
    low = points.min(0)
    buckets = 1 << max(4, int(len(points) - 1).bit_length())
    i, j, k = np.floor((points - low) / cell).astype(np.int64).T
    keys = ((i * _HASH_X) ^ (j * _HASH_Y) ^ (k * _HASH_Z)) & (buckets - 1)
    order = np.argsort(keys, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(keys, minlength=buckets))])
    return Grid(low, cell, starts.astype(np.int64), order)


@njit(cache=True, nogil=True)
def bucket_of(grid: Grid, i: int, j: int, k: int) -> int:
    """The bucket of a cell."""
    return ((i * _HASH_X) ^ (j * _HASH_Y) ^ (k * _HASH_Z)) & (grid.starts.shape[0] - 2)


def in_cell_order(points: np.ndarray, cell: float) -> np.ndarray:
    """Indices that sort points by cell, so that neighbours in space lie close in memory."""
    i, j, k = np.floor((points - points.min(0)) / cell).astype(np.int64).T
    return np.lexsort((*points.T, i, j, k))


@njit(cache=True, nogil=True)
def thinned(points: np.ndarray, grid: Grid, distance: float) -> np.ndarray:
    """Mask of points, chosen greedily in order, none closer than `distance` to an earlier one.

    The grid's cells must not be smaller than the distance.
    """
    kept = np.zeros(points.shape[0], np.bool_)
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        ci = int(np.floor((x - grid.low[0]) / grid.cell))
        cj = int(np.floor((y - grid.low[1]) / grid.cell))
        ck = int(np.floor((z - grid.low[2]) / grid.cell))
        free = True
        for cell in range(27):
            b = bucket_of(grid, ci + cell // 9 - 1, cj + cell // 3 % 3 - 1, ck + cell % 3 - 1)
            for s in range(grid.starts[b], grid.starts[b + 1]):
                q = grid.order[s]
                if kept[q]:
                    dx, dy, dz = points[q, 0] - x, points[q, 1] - y, points[q, 2] - z
                    if dx * dx + dy * dy + dz * dz < distance * distance:
                        free = False
                        break
            if not free:
                break
        kept[p] = free
    return kept


@njit(cache=True, nogil=True)
def find_centre(points: np.ndarray, a: int, b: int, c: int, radius: float, out: np.ndarray) -> bool:
    """Fill the centre of the ball through three points, outside (a, b, c); False if none exists."""
    p, q, r = points[a], points[b], points[c]
    ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    vx, vy, vz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    uu, vv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
    nn = nx * nx + ny * ny + nz * nz
    if nn < 1e-12 * uu * vv:
        return False
    # Circumcentre from p: n x (v^2 u - u^2 v) ... / 2 n^2, then up along the normal.
    wx, wy, wz = vv * ux - uu * vx, vv * uy - uu * vy, vv * uz - uu * vz
    cx = (ny * wz - nz * wy) / (2 * nn)
    cy = (nz * wx - nx * wz) / (2 * nn)
    cz = (nx * wy - ny * wx) / (2 * nn)
    height2 = radius * radius - (cx * cx + cy * cy + cz * cz)
    if height2 < 0:
        return False
    lift = np.sqrt(height2 / nn)
    out[0], out[1], out[2] = p[0] + cx + lift * nx, p[1] + cy + lift * ny, p[2] + cz + lift * nz
    return True


@njit(cache=True, nogil=True)
def faces_outwards(points: np.ndarray, normals: np.ndarray, a: int, b: int, c: int) -> bool:
    """Whether a face's normal agrees in direction with those of all its corners."""
    p, q, r = points[a], points[b], points[c]
    ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    vx, vy, vz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    normal_of = normals
    return (
        nx * normal_of[a, 0] + ny * normal_of[a, 1] + nz * normal_of[a, 2] > 0
        and nx * normal_of[b, 0] + ny * normal_of[b, 1] + nz * normal_of[b, 2] > 0
        and nx * normal_of[c, 0] + ny * normal_of[c, 1] + nz * normal_of[c, 2] > 0
    )


@njit(cache=True, nogil=True)
def roll_angle(
    start: np.ndarray, centre: np.ndarray, middle: np.ndarray, axis: np.ndarray
) -> float:
    """Angle about the edge from one ball centre to the next, 0 to 2 pi, rolling forwards."""
    x, y, z = centre[0] - middle[0], centre[1] - middle[1], centre[2] - middle[2]
    cosine = start[0] * x + start[1] * y + start[2] * z
    sine = (
        axis[0] * (start[1] * z - start[2] * y)
        + axis[1] * (start[2] * x - start[0] * z)
        + axis[2] * (start[0] * y - start[1] * x)
    )
    angle = np.arctan2(sine, cosine)
    # Rounding separates points on one sphere: an angle just below 0 means 0.
    return angle + 2 * np.pi if angle < -1e-7 else max(angle, 0.0)


@njit(cache=True, nogil=True)
def cell_index(grid: Grid, value: float, axis: int) -> int:
    """Number of the cell along one axis."""
    return int(np.floor((value - grid.low[axis]) / grid.cell))


@njit(cache=True, nogil=True)
def distance2(points: np.ndarray, k: int, position: np.ndarray) -> float:
    """Squared distance of point k from a position."""
    x, y, z = points[k, 0] - position[0], points[k, 1] - position[1], points[k, 2] - position[2]
    return x * x + y * y + z * z


INNER, ACTIVE, BORDER = 0, 1, 2
_SEED_NEIGHBOURS = 12


class Front(NamedTuple):
    """The growing surface and its front, in arrays allocated once."""

    points: np.ndarray
    normals: np.ndarray
    faces: np.ndarray
    ends: np.ndarray
    opposite: np.ndarray
    centres: np.ndarray
    """Centre of the ball that made each edge's face."""
    states: np.ndarray
    table: np.ndarray
    """Hash table with open addressing: number of an edge + 1, found by its ends; 0 if free."""
    degree: np.ndarray
    """Number of front edges at each point; -1 while the point has no face."""
    counts: np.ndarray
    """Numbers of faces and edges so far."""


def start_front(points: np.ndarray, normals: np.ndarray) -> Front:
    """An empty front over these points."""
    n = len(points)
    max_faces, max_edges = 3 * n + 16, 6 * n + 16
    return Front(
        points=np.ascontiguousarray(points, np.float64),
        normals=np.ascontiguousarray(normals, np.float64),
        faces=np.zeros((max_faces, 3), np.int64),
        ends=np.zeros((max_edges, 2), np.int64),
        opposite=np.zeros(max_edges, np.int64),
        centres=np.zeros((max_edges, 3)),
        states=np.zeros(max_edges, np.int8),
        table=np.zeros(1 << int(max_edges).bit_length(), np.int64),
        degree=np.full(n, -1, np.int64),
        counts=np.zeros(2, np.int64),
    )


@njit(cache=True, nogil=True)
def roll(front: Front, grid: Grid, radius: float) -> None:
    """Grow the surface with a ball of one radius: the old front first, then new seeds.

    The grid's cells are twice the radius.
    """
    centre = np.empty(3)
    for edge in range(front.counts[1]):
        if front.states[edge] == BORDER:
            a, b = front.ends[edge, 0], front.ends[edge, 1]
            o = front.opposite[edge]
            if find_centre(front.points, a, b, o, radius, centre) and _is_empty(
                front, grid, centre, radius, a, b, o
            ):
                front.states[edge] = ACTIVE
                for axis in range(3):
                    front.centres[edge, axis] = centre[axis]
    _advance(front, grid, radius, int(np.int64(0)))
    for point in range(front.points.shape[0]):
        if front.degree[point] < 0:
            first_new = front.counts[1]
            if _seed(front, grid, radius, point):
                _advance(front, grid, radius, first_new)


@njit(cache=True, nogil=True)
def _advance(front: Front, grid: Grid, radius: float, edge: int) -> None:
    """Pivot the ball over all active edges from number `edge` on."""
    centre = np.empty(3)
    while edge < front.counts[1]:
        if front.states[edge] == ACTIVE:
            a, b = front.ends[edge, 0], front.ends[edge, 1]
            k = _pivot(front, grid, radius, edge, centre)
            if k >= 0 and _may_join(front, a, k) and _may_join(front, k, b):
                _add_face(front, b, a, k, centre)
            else:
                front.states[edge] = BORDER
        edge += 1


@njit(cache=True, nogil=True)
def _pivot(front: Front, grid: Grid, radius: float, edge: int, centre: np.ndarray) -> int:
    """The first point that the ball touches as it rolls over an edge, or -1; fills its centre."""
    points = front.points
    a, b = front.ends[edge, 0], front.ends[edge, 1]
    o = front.opposite[edge]
    middle = 0.5 * (points[a] + points[b])
    axis = points[b] - points[a]
    axis /= np.sqrt(distance2(points, a, points[b]))
    start = front.centres[edge] - middle
    trial = np.empty(3)
    # Typed, as numba would compile another variant for the literal.
    best, best_angle = int(np.int64(-1)), 2 * np.pi
    ci = cell_index(grid, middle[0], 0)
    cj = cell_index(grid, middle[1], 1)
    ck = cell_index(grid, middle[2], 2)
    for cell in range(27):
        bucket = bucket_of(grid, ci + cell // 9 - 1, cj + cell // 3 % 3 - 1, ck + cell % 3 - 1)
        for s in range(grid.starts[bucket], grid.starts[bucket + 1]):
            k = grid.order[s]
            if distance2(points, k, middle) > 4 * radius * radius:
                continue
            if k == a or k in (b, o):
                continue
            if not find_centre(front.points, b, a, k, radius, trial):
                continue
            angle = roll_angle(start, trial, middle, axis)
            if angle < best_angle:
                best, best_angle = k, angle
                for axis_idx in range(3):
                    centre[axis_idx] = trial[axis_idx]
    if (
        best < 0
        or front.degree[best] == 0
        or not faces_outwards(front.points, front.normals, b, a, best)
    ):
        return -1
    return best if _is_empty(front, grid, centre, radius, a, b, best) else -1


@njit(cache=True, nogil=True)
def _seed(front: Front, grid: Grid, radius: float, a: int) -> bool:
    """Start a new face at an unused point, nearest neighbours first; False if none fits."""
    points = front.points
    near = np.empty(_SEED_NEIGHBOURS, np.int64)
    distances = np.full(_SEED_NEIGHBOURS, 4 * radius * radius)
    count = 0
    position = points[a]
    ci = cell_index(grid, position[0], 0)
    cj = cell_index(grid, position[1], 1)
    ck = cell_index(grid, position[2], 2)
    for cell in range(27):
        bucket = bucket_of(grid, ci + cell // 9 - 1, cj + cell // 3 % 3 - 1, ck + cell % 3 - 1)
        for s in range(grid.starts[bucket], grid.starts[bucket + 1]):
            k = grid.order[s]
            distance = distance2(points, k, position)
            if k == a or front.degree[k] >= 0 or distance >= distances[-1]:
                continue
            slot = min(count, _SEED_NEIGHBOURS - 1)
            while slot > 0 and distances[slot - 1] > distance:
                distances[slot] = distances[slot - 1]
                near[slot] = near[slot - 1]
                slot -= 1
            if slot > 0 and near[slot - 1] == k and distances[slot - 1] == distance:
                continue
            distances[slot], near[slot] = distance, k
            count = min(count + 1, _SEED_NEIGHBOURS)
    centre = np.empty(3)
    for second in range(1, count):
        for first in range(second):
            b, c = near[first], near[second]
            if not faces_outwards(front.points, front.normals, a, b, c):
                b, c = c, b
            if (
                faces_outwards(front.points, front.normals, a, b, c)
                and find_centre(front.points, a, b, c, radius, centre)
                and _is_empty(front, grid, centre, radius, a, b, c)
            ):
                _add_face(front, a, b, c, centre)
                return True
    return False


@njit(cache=True, nogil=True)
def _add_face(front: Front, a: int, b: int, c: int, centre: np.ndarray) -> None:
    """Add a face; its edges are glued to front edges of the same ends, or extend the front."""
    if front.counts[0] == front.faces.shape[0]:
        return
    corners = front.faces[front.counts[0]]
    corners[0], corners[1], corners[2] = a, b, c
    front.counts[0] += 1
    for k in range(3):
        tail, head, other = corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]
        slot = _slot(front, tail, head)
        if front.table[slot]:
            front.states[front.table[slot] - 1] = INNER
            front.degree[tail] -= 1
            front.degree[head] -= 1
            continue
        edge = front.counts[1]
        front.counts[1] += 1
        front.table[slot] = edge + 1
        front.ends[edge, 0], front.ends[edge, 1] = tail, head
        front.opposite[edge] = other
        for axis in range(3):
            front.centres[edge, axis] = centre[axis]
        front.states[edge] = ACTIVE
        front.degree[tail] = max(front.degree[tail], 0) + 1
        front.degree[head] = max(front.degree[head], 0) + 1


@njit(cache=True, nogil=True)
def _may_join(front: Front, tail: int, head: int) -> bool:
    """Whether a face may have this half-edge: its edge is new, or open and runs head to tail."""
    found = front.table[_slot(front, tail, head)]
    return found == 0 or (front.states[found - 1] != INNER and front.ends[found - 1, 0] == head)


@njit(cache=True, nogil=True)
def _slot(front: Front, tail: int, head: int) -> int:
    """Slot of an edge of either direction in the hash table, or the free slot for it."""
    low, high = min(tail, head), max(tail, head)
    mask = front.table.shape[0] - 1
    slot = ((low * _HASH_X) ^ (high * _HASH_Y)) & mask
    while front.table[slot]:
        a, b = front.ends[front.table[slot] - 1, 0], front.ends[front.table[slot] - 1, 1]
        if min(a, b) == low and max(a, b) == high:
            break
        slot = (slot + 1) & mask
    return slot


@njit(cache=True, nogil=True)
def _is_empty(
    front: Front, grid: Grid, centre: np.ndarray, radius: float, a: int, b: int, c: int
) -> bool:
    """Whether the ball contains no point but its three."""
    limit = radius * radius * (1 - 1e-6)
    low0 = cell_index(grid, centre[0] - radius, 0)
    high0 = cell_index(grid, centre[0] + radius, 0)
    low1 = cell_index(grid, centre[1] - radius, 1)
    high1 = cell_index(grid, centre[1] + radius, 1)
    low2 = cell_index(grid, centre[2] - radius, 2)
    high2 = cell_index(grid, centre[2] + radius, 2)
    for i in range(low0, high0 + 1):
        for j in range(low1, high1 + 1):
            for k in range(low2, high2 + 1):
                bucket = bucket_of(grid, i, j, k)
                for s in range(grid.starts[bucket], grid.starts[bucket + 1]):
                    q = grid.order[s]
                    if q != a and q != b and q != c and distance2(front.points, q, centre) < limit:
                        return False
    return True


_RADII_IN_SPACINGS = (1.0, 1.5, 2.5, 4.0)
"""Increasing radii of the balls, in typical distances between neighbours."""
_MIN_DISTANCE_IN_SPACINGS = 0.5
"""Points closer than this to an earlier one are left out: they would make slivers."""


_MIN_POINTS = 50


def pivot(cloud: Cloud) -> Mesh:
    """The triangles that rolling balls touch."""
    if len(cloud) < _MIN_POINTS:
        raise SurfaceError("surface.few_points", points=len(cloud))
    spacing_mm = measure_spacing_mm(cloud)
    chosen = _thinned_idx(cloud, _MIN_DISTANCE_IN_SPACINGS * spacing_mm)
    front = start_front(cloud.points_mm[chosen], cloud.normals[chosen])
    for radius in track([spacing_mm * r for r in _RADII_IN_SPACINGS]):
        roll(front, build_grid(front.points, 2 * radius), radius)
    faces = front.faces[: front.counts[0]]
    if not len(faces):
        raise SurfaceError("surface.no_ball", points=len(cloud))
    used, compact = np.unique(faces, return_inverse=True)
    return Mesh(
        vertices_mm=front.points[used],
        faces=compact.reshape(-1, 3).astype(np.int32),
        colours=cloud.colours[chosen[used]],
    )


def measure_spacing_mm(cloud: Cloud) -> float:
    """Side of the square that one point covers, at the median point.

    Six neighbours lie within 1.08 sides in a triangular lattice, 1.41 in a square one and 1.38
    for points strewn at random.
    """
    sixth = KDTree(cloud.points_mm).query(cloud.points_mm[:: _sampling_step(cloud)], k=7)[0][:, 6]
    return float(np.median(sixth)) / 1.3


def _sampling_step(cloud: Cloud) -> int:
    """Step through the points that leaves about 20 000 of them."""
    return max(1, len(cloud) // 20_000)


def _thinned_idx(cloud: Cloud, distance_mm: float) -> np.ndarray:
    """Indices of points at least this far from each other, in cell order."""
    points = cloud.points_mm.astype(np.float64)
    order = in_cell_order(points, 4 * distance_mm)
    points = np.ascontiguousarray(points[order])
    return order[thinned(points, build_grid(points, distance_mm), distance_mm)]
