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

from limbgram.surface.wrapping.balls import (
    apart2,
    cell_along,
    faces_outwards,
    find_centre,
    roll_angle,
)
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
    axis /= np.sqrt(apart2(points, a, points[b]))
    start = front.centres[edge] - middle
    trial = np.empty(3)
    # Typed, or numba would compile a variant for the literal.
    best, best_angle = int(np.int64(-1)), 2 * np.pi
    ci = cell_along(grid, middle[0], 0)
    cj = cell_along(grid, middle[1], 1)
    ck = cell_along(grid, middle[2], 2)
    for cell in range(27):
        bucket = bucket_of(grid, ci + cell // 9 - 1, cj + cell // 3 % 3 - 1, ck + cell % 3 - 1)
        for s in range(grid.starts[bucket], grid.starts[bucket + 1]):
            k = grid.order[s]
            if apart2(points, k, middle) > 4 * radius * radius:
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
    """Try to start a surface at an unused point, nearest neighbours first."""
    points = front.points
    near = np.empty(_SEED_NEIGHBOURS, np.int64)
    distances = np.full(_SEED_NEIGHBOURS, 4 * radius * radius)
    count = 0
    place = points[a]
    ci = cell_along(grid, place[0], 0)
    cj = cell_along(grid, place[1], 1)
    ck = cell_along(grid, place[2], 2)
    for cell in range(27):
        bucket = bucket_of(grid, ci + cell // 9 - 1, cj + cell // 3 % 3 - 1, ck + cell % 3 - 1)
        for s in range(grid.starts[bucket], grid.starts[bucket + 1]):
            k = grid.order[s]
            distance = apart2(points, k, place)
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
        for axis in range(3):
            front.centres[edge, axis] = centre[axis]
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
def _is_empty(
    front: Front, grid: Grid, centre: np.ndarray, radius: float, a: int, b: int, c: int
) -> bool:
    limit = radius * radius * (1 - 1e-6)
    low0 = cell_along(grid, centre[0] - radius, 0)
    high0 = cell_along(grid, centre[0] + radius, 0)
    low1 = cell_along(grid, centre[1] - radius, 1)
    high1 = cell_along(grid, centre[1] + radius, 1)
    low2 = cell_along(grid, centre[2] - radius, 2)
    high2 = cell_along(grid, centre[2] + radius, 2)
    for i in range(low0, high0 + 1):
        for j in range(low1, high1 + 1):
            for k in range(low2, high2 + 1):
                bucket = bucket_of(grid, i, j, k)
                for s in range(grid.starts[bucket], grid.starts[bucket + 1]):
                    q = grid.order[s]
                    if q != a and q != b and q != c and apart2(front.points, q, centre) < limit:
                        return False
    return True
