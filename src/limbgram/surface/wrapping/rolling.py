"""The rolling ball, compiled: Bernardini, Mittleman, Rushmeier, Silva and Taubin (1999).

A face (a, b, o) is counter-clockwise seen from outside, where the ball lies. A front edge runs
a to b as in its one face; the ball rolls over it, away from o, until it touches a point k; the
new face is (b, a, k). Edges are found by their ends in a hash table, so gluing is one look-up
(the loops of the paper need no lists of their own). Records are worked on in the order of
their making, so the front grows evenly and the result depends on nothing but the points.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from limbgram.surface.wrapping.grid import Grid, bucket_of

INNER, ACTIVE, BORDER = 0, 1, 2
_SEED_NEIGHBOURS = 12


class Front(NamedTuple):
    """The growing surface; everything is allocated once."""

    points: np.ndarray
    normals: np.ndarray
    faces: np.ndarray
    ends: np.ndarray
    opposite: np.ndarray
    centres: np.ndarray
    """Centre of the ball that made each edge's face."""
    states: np.ndarray
    table: np.ndarray
    """Open addressing: edge record + 1 by its ends, 0 where free."""
    degree: np.ndarray
    """Front edges at each point; -1 where the point has no face yet."""
    counts: np.ndarray
    """Faces and edge records made so far."""


def start_front(points: np.ndarray, normals: np.ndarray) -> Front:
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

    The grid's cell is twice the radius.
    """
    centre = np.empty(3)
    for edge in range(front.counts[1]):
        if front.states[edge] == BORDER:
            a, b = front.ends[edge, 0], front.ends[edge, 1]
            o = front.opposite[edge]
            if _find_centre(front, a, b, o, radius, centre) and _is_empty(
                front, grid, centre, radius, a, b, o
            ):
                front.states[edge] = ACTIVE
                front.centres[edge] = centre
    _advance(front, grid, radius, 0)
    for point in range(front.points.shape[0]):
        if front.degree[point] < 0:
            first_new = front.counts[1]
            if _seed(front, grid, radius, point):
                _advance(front, grid, radius, first_new)


@njit(cache=True, nogil=True)
def _advance(front: Front, grid: Grid, radius: float, edge: int) -> None:
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
    """First point that the ball touches as it rolls over an edge, or -1; fills in its centre."""
    points = front.points
    a, b = front.ends[edge, 0], front.ends[edge, 1]
    o = front.opposite[edge]
    middle = 0.5 * (points[a] + points[b])
    axis = points[b] - points[a]
    axis /= np.sqrt(_dot(axis, axis))
    start = front.centres[edge] - middle
    trial = np.empty(3)
    best, best_angle = -1, 2 * np.pi
    ci, cj, ck = _cell(grid, middle, 0), _cell(grid, middle, 1), _cell(grid, middle, 2)
    for cell in range(27):
        bucket = bucket_of(grid, ci + cell // 9 - 1, cj + cell // 3 % 3 - 1, ck + cell % 3 - 1)
        for s in range(grid.starts[bucket], grid.starts[bucket + 1]):
            k = grid.order[s]
            if k == a or k == b or k == o or _apart2(points[k], middle) > 4 * radius * radius:
                continue
            if not _find_centre(front, b, a, k, radius, trial):
                continue
            angle = _angle(start, trial, middle, axis)
            if angle < best_angle:
                best, best_angle = k, angle
                centre[:] = trial
    if best < 0 or front.degree[best] == 0 or not _faces_outwards(front, b, a, best):
        return -1
    return best if _is_empty(front, grid, centre, radius, a, b, best) else -1


@njit(cache=True, nogil=True)
def _seed(front: Front, grid: Grid, radius: float, a: int) -> bool:
    """Try to start a surface at an unused point, nearest neighbours first."""
    points = front.points
    near = np.empty(_SEED_NEIGHBOURS, np.int64)
    distances = np.full(_SEED_NEIGHBOURS, 4 * radius * radius)
    count = 0
    ci, cj, ck = _cell(grid, points[a], 0), _cell(grid, points[a], 1), _cell(grid, points[a], 2)
    for cell in range(27):
        bucket = bucket_of(grid, ci + cell // 9 - 1, cj + cell // 3 % 3 - 1, ck + cell % 3 - 1)
        for s in range(grid.starts[bucket], grid.starts[bucket + 1]):
            k = grid.order[s]
            distance = _apart2(points[k], points[a])
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
            if not _faces_outwards(front, a, b, c):
                b, c = c, b
            if (
                _faces_outwards(front, a, b, c)
                and _find_centre(front, a, b, c, radius, centre)
                and _is_empty(front, grid, centre, radius, a, b, c)
            ):
                _add_face(front, a, b, c, centre)
                return True
    return False


@njit(cache=True, nogil=True)
def _add_face(front: Front, a: int, b: int, c: int, centre: np.ndarray) -> None:
    """Add a face and glue its edges to the front where they meet it, else extend the front."""
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
        front.centres[edge] = centre
        front.states[edge] = ACTIVE
        front.degree[tail] = max(front.degree[tail], 0) + 1
        front.degree[head] = max(front.degree[head], 0) + 1


@njit(cache=True, nogil=True)
def _may_join(front: Front, tail: int, head: int) -> bool:
    """Whether a new face may run tail to head: the edge is new, or open and runs head to tail."""
    found = front.table[_slot(front, tail, head)]
    return found == 0 or (front.states[found - 1] != INNER and front.ends[found - 1, 0] == head)


@njit(cache=True, nogil=True)
def _slot(front: Front, tail: int, head: int) -> int:
    """Place of an edge in the table, in whichever direction it runs, or of its absence."""
    low, high = min(tail, head), max(tail, head)
    mask = front.table.shape[0] - 1
    slot = ((low * 73856093) ^ (high * 19349663)) & mask
    while front.table[slot]:
        a, b = front.ends[front.table[slot] - 1, 0], front.ends[front.table[slot] - 1, 1]
        if min(a, b) == low and max(a, b) == high:
            break
        slot = (slot + 1) & mask
    return slot


@njit(cache=True, nogil=True)
def _find_centre(front: Front, a: int, b: int, c: int, radius: float, out: np.ndarray) -> bool:
    """Centre of the ball on three points, on the outside of (a, b, c); False if none fits."""
    p, q, r = front.points[a], front.points[b], front.points[c]
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
def _is_empty(
    front: Front, grid: Grid, centre: np.ndarray, radius: float, a: int, b: int, c: int
) -> bool:
    limit = radius * radius * (1 - 1e-6)
    low0, high0 = _cell(grid, centre - radius, 0), _cell(grid, centre + radius, 0)
    low1, high1 = _cell(grid, centre - radius, 1), _cell(grid, centre + radius, 1)
    low2, high2 = _cell(grid, centre - radius, 2), _cell(grid, centre + radius, 2)
    for i in range(low0, high0 + 1):
        for j in range(low1, high1 + 1):
            for k in range(low2, high2 + 1):
                bucket = bucket_of(grid, i, j, k)
                for s in range(grid.starts[bucket], grid.starts[bucket + 1]):
                    q = grid.order[s]
                    if q != a and q != b and q != c and _apart2(front.points[q], centre) < limit:
                        return False
    return True


@njit(cache=True, nogil=True)
def _faces_outwards(front: Front, a: int, b: int, c: int) -> bool:
    """Whether a face looks the way of the normals measured at all its corners."""
    p, q, r = front.points[a], front.points[b], front.points[c]
    ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    vx, vy, vz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    m = front.normals
    return (
        nx * m[a, 0] + ny * m[a, 1] + nz * m[a, 2] > 0
        and nx * m[b, 0] + ny * m[b, 1] + nz * m[b, 2] > 0
        and nx * m[c, 0] + ny * m[c, 1] + nz * m[c, 2] > 0
    )


@njit(cache=True, nogil=True)
def _angle(start: np.ndarray, centre: np.ndarray, middle: np.ndarray, axis: np.ndarray) -> float:
    """Angle from one ball centre to the next round the edge, 0 to 2 pi, rolling forwards."""
    x, y, z = centre[0] - middle[0], centre[1] - middle[1], centre[2] - middle[2]
    cosine = start[0] * x + start[1] * y + start[2] * z
    sine = (
        axis[0] * (start[1] * z - start[2] * y)
        + axis[1] * (start[2] * x - start[0] * z)
        + axis[2] * (start[0] * y - start[1] * x)
    )
    angle = np.arctan2(sine, cosine)
    # Points on one sphere differ by rounding: just behind means touched at once.
    return angle + 2 * np.pi if angle < -1e-7 else max(angle, 0.0)


@njit(cache=True, nogil=True)
def _cell(grid: Grid, place: np.ndarray, axis: int) -> int:
    return int(np.floor((place[axis] - grid.low[axis]) / grid.cell))


@njit(cache=True, nogil=True)
def _apart2(p: np.ndarray, q: np.ndarray) -> float:
    x, y, z = p[0] - q[0], p[1] - q[1], p[2] - q[2]
    return x * x + y * y + z * z


@njit(cache=True, nogil=True)
def _dot(p: np.ndarray, q: np.ndarray) -> float:
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
