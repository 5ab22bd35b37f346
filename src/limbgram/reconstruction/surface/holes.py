"""Holes: which openings of a mesh are holes, and how they are closed.

In      a manifold mesh with boundary loops.
Out     the brim, which is the limb's own open end, told from the holes; the mesh with holes closed.
Method  A hole's loop is triangulated with its own vertices (Barequet and Sharir 1995; Liepa 2003);
        the new triangles are made even, and the new vertices take the shape of a thin plate that
        continues the surface round the hole. There the plate may leave the points a little, so
        that their noise does not set its slope.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int32
from scipy.sparse import csc_array, csr_array, diags_array
from scipy.sparse.linalg import splu

from limbgram.core.geometry.arrays import Faces, Points3, Vector3
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_loops, find_edges, half_edges
from limbgram.reconstruction.surface.resampling import Triangles, even_out, find_twins

_MOST_CORNERS = 250
"""Larger loops lose their sharpest corners first: the search costs the cube of the number."""


def triangulate(loop: Points3, taken: Bool[np.ndarray, "l l"]) -> Faces | None:
    """Triangles of small area and gentle folds that close a loop, as indices into it.

    The loop runs along the half-edges of the faces round the hole; the new faces run against it.
    `taken[i, j]` forbids a chord: the mesh already has that edge. None: no allowed answer.
    """
    ears, rest = _cut_ears(loop, taken, max(len(loop) - _MOST_CORNERS, 0))
    ring = np.ascontiguousarray(loop[rest])
    split = np.full((len(rest), len(rest)), -1, np.int32)
    if not _least_area(ring, np.ascontiguousarray(taken[np.ix_(rest, rest)]), split):
        return None
    faces = ears
    waiting = [(0, len(rest) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        middle = int(split[first, last])
        faces.append((rest[first], rest[last], rest[middle]))
        waiting += [(first, middle), (middle, last)]
    return np.array(faces, np.int32).reshape(-1, 3)


def _cut_ears(
    loop: Points3, taken: Bool[np.ndarray, "l l"], count: int
) -> tuple[list[tuple[int, int, int]], Int32[np.ndarray, " r"]]:
    """Cut `count` corners, smallest angle first, no two neighbours in one round."""
    rest = np.arange(len(loop), dtype=np.int32)
    ears: list[tuple[int, int, int]] = []
    while count > 0:
        before, after = np.roll(rest, 1), np.roll(rest, -1)
        u, v = loop[before] - loop[rest], loop[after] - loop[rest]
        cosine = (u * v).sum(1) / np.maximum(
            np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1), 1e-30
        )
        cosine[taken[before, after]] = -2
        sharper = (cosine > np.roll(cosine, 1)) & (cosine >= np.roll(cosine, -1)) & (cosine > -2)
        chosen = np.flatnonzero(sharper)
        chosen = chosen[np.argsort(-cosine[chosen], kind="stable")][: max(1, min(count, 40))]
        if not len(chosen):
            break
        for k in chosen:
            ears.append((int(rest[k]), int(before[k]), int(after[k])))
            taken[before[k], after[k]] = taken[after[k], before[k]] = True
        rest = np.delete(rest, chosen)
        count -= len(chosen)
    return ears, rest


@njit(cache=True, nogil=True)
def _least_area(ring: np.ndarray, taken: np.ndarray, split: np.ndarray):
    """Fill split[i, j]: third corner of the triangle on chord i..j; False where none is allowed.

    Weight of a triangulation: its area, each triangle's raised by its thinness, so that of two
    answers of the same area the one of rounder triangles wins.
    """
    n = ring.shape[0]
    weight = np.zeros((n, n))
    for span in range(2, n):
        for i in range(n - span):
            j = i + span
            weight[i, j] = np.inf
            if taken[i, j] and not (i == 0 and j == n - 1):
                continue
            for m in range(i + 1, j):
                below = weight[i, m] + weight[m, j]
                if below >= weight[i, j]:
                    continue
                total = below + _cost(ring[i], ring[m], ring[j])
                if total < weight[i, j]:
                    weight[i, j] = total
                    split[i, j] = m
    return np.isfinite(weight[0, n - 1])


@njit(cache=True, nogil=True)
def _cost(a: np.ndarray, b: np.ndarray, c: np.ndarray):
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    wx, wy, wz = c[0] - b[0], c[1] - b[1], c[2] - b[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    area = 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz)
    edges2 = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz + wx * wx + wy * wy + wz * wz
    return area + 1e-3 * edges2


_RINGS = 5
"""Rings of faces round a hole whose bend is carried on."""
_STIFFNESS_EDGES = 1.0
"""Bends shorter than a few times this count as noise round a hole; more flattens round caps."""
_SMALL = 5
"""Loops of so few vertices need no new ones."""
_BENDS = 2
_ROUNDS = 3


def fill_holes(
    vertices: Points3,
    faces: Faces,
    holes: list[Int32[np.ndarray, " l"]],
    edge_mm: float | None = None,
    *,
    bent: bool = True,
) -> Mesh:
    """Close holes, each a loop along the half-edges of the faces round it; marks new vertices.

    edge_mm: length of the new edges; None: as long as the mesh's own.
    bent: whether the filling goes on as the surface does; else it spans the hole, as over a drum.
    """
    neighbours = _neighbours(vertices, faces)
    small = [loop for loop in holes if len(loop) <= _SMALL]
    large = [loop for loop in holes if len(loop) > _SMALL]
    chords = [_close(vertices, neighbours, loop) for loop in small]
    large += [loop for loop, made in zip(small, chords, strict=True) if made is None]
    faces = np.concatenate([faces, *(made for made in chords if made is not None)])
    if not large:
        return Mesh(vertices_mm=vertices, faces=faces, filled=np.zeros(len(vertices), np.bool_))
    work, away = _cover(vertices, faces, large)
    ends = find_edges(faces).ends
    edge = float(np.median(np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)))
    for _ in range(_BENDS):
        for _ in range(_ROUNDS):
            work = even_out(work, edge_mm or edge)
        work = _bend(work, _STIFFNESS_EDGES * edge) if bent else _stretch(work)
    return _put_back(vertices, faces[away], work)


def _cover(
    vertices: Points3, faces: Faces, holes: list[Int32[np.ndarray, " l"]]
) -> tuple[Triangles, Bool[np.ndarray, " f"]]:
    """First triangles of all holes with the faces round them, and which faces are far away."""
    neighbours = _neighbours(vertices, faces)
    patches: list[np.ndarray] = []
    centres: list[np.ndarray] = []
    for loop in holes:
        chords = _close(vertices, neighbours, loop)
        if chords is None:
            after = np.roll(loop, -1)
            middle = np.full(len(loop), len(vertices) + len(centres), np.int32)
            patches.append(np.column_stack([after, loop, middle]))
            centres.append(vertices[loop].mean(0))
        else:
            patches.append(chords)
    new = np.concatenate(patches).astype(np.int32)
    near = np.zeros(len(vertices), np.bool_)
    near[np.concatenate(holes)] = True
    for _ in range(_RINGS):
        near[faces[near[faces].any(1)]] = True
    touched = np.asarray(near[faces].all(1))
    places = np.concatenate([vertices, np.array(centres).reshape(-1, 3)])
    together = np.concatenate([faces[touched], new])
    used, compact = np.unique(together, return_inverse=True)
    frozen = np.arange(len(together)) < touched.sum()
    compact = compact.reshape(-1, 3).astype(np.int32)
    return Triangles(places[used], compact, frozen, used.astype(np.int64)), ~touched


def _neighbours(vertices: Points3, faces: Faces) -> csr_array:
    ends = half_edges(faces)
    shape = (len(vertices), len(vertices))
    table = csr_array((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), shape=shape)
    return csr_array(table + table.T)


def _close(vertices: Points3, neighbours: csr_array, loop: Int32[np.ndarray, " l"]) -> Faces | None:
    """Triangles on the loop's own vertices; None where the mesh's edges leave no room."""
    joined = neighbours[loop][:, loop].toarray() > 0
    chords = triangulate(vertices[loop], joined)
    return None if chords is None else loop[chords]


def _bend(work: Triangles, stiffness: float) -> Triangles:
    """Let the vertices without a frozen face take the shape of a thin plate."""
    measured = np.zeros(len(work.vertices), np.bool_)
    measured[work.faces[work.frozen]] = True
    if measured.all():
        return work
    laplacian, area = _laplacian(work.vertices, work.faces)
    whole = np.ones(len(work.vertices), np.bool_)
    whole[half_edges(work.faces)[find_twins(work.faces) < 0]] = False
    bending = laplacian.T @ diags_array(whole / area) @ laplacian
    pull = measured * area / stiffness**4
    solver = splu(
        csc_array(bending + diags_array(pull)),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    plate = solver.solve(pull[:, None] * work.vertices)
    return work._replace(vertices=np.where(measured[:, None], work.vertices, plate))


def _stretch(work: Triangles) -> Triangles:
    """Let the vertices without a frozen face take the shape of a membrane held at the others."""
    held = np.zeros(len(work.vertices), np.bool_)
    held[work.faces[work.frozen]] = True
    if held.all():
        return work
    laplacian, _ = _laplacian(work.vertices, work.faces)
    rows = csc_array(laplacian[~held])
    vertices = work.vertices.copy()
    vertices[~held] = splu(rows[:, ~held]).solve(-(rows[:, held] @ vertices[held]))
    return work._replace(vertices=vertices)


def _laplacian(vertices: Points3, faces: Faces) -> tuple[csr_array, Float64[np.ndarray, " n"]]:
    """Cotangent Laplacian, weights kept positive, and the area that belongs to each vertex."""
    count = len(vertices)
    area = np.zeros(count)
    rows: list[np.ndarray] = []
    weights: list[np.ndarray] = []
    for k in range(3):
        tip, a, b = faces[:, k], faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        u, v = vertices[a] - vertices[tip], vertices[b] - vertices[tip]
        double = np.linalg.norm(np.cross(u, v), axis=1)
        area += np.bincount(tip, double / 6, count)
        cotangent = (u * v).sum(1) / np.maximum(double, 1e-30)
        rows.append(np.column_stack([a, b]))
        weights.append(np.clip(cotangent, 0.05, 20.0) / 2)
    ends, weight = np.concatenate(rows), np.concatenate(weights)
    half = csr_array((weight, (ends[:, 0], ends[:, 1])), shape=(count, count))
    joined = half + half.T
    area = np.maximum(area, 1e-3 * area.mean())
    return csr_array(diags_array(np.asarray(joined.sum(1)).ravel()) - joined), area


def _put_back(vertices: Points3, away: Faces, work: Triangles) -> Mesh:
    """The whole mesh again: its own vertices keep their numbers, new ones follow."""
    kept = np.zeros(len(work.vertices), np.bool_)
    kept[work.faces[work.frozen]] = True
    number = np.where(kept, work.origin, len(vertices) + np.cumsum(~kept) - 1)
    return Mesh(
        vertices_mm=np.concatenate([vertices, work.vertices[~kept]]),
        faces=np.concatenate([away, number[work.faces].astype(np.int32)]),
        filled=np.arange(len(vertices) + int((~kept).sum())) >= len(vertices),
    )


@dataclass(frozen=True)
class Openings:
    """The brim (None where the mesh has no open end) and the holes, as loops of vertices."""

    brim: Int32[np.ndarray, " b"] | None
    holes: list[Int32[np.ndarray, " l"]]


def find_openings(
    vertices: Points3, faces: Faces, min_share_at_end: float, min_share: float
) -> Openings:
    """Tell the brim from the holes by size and place.

    The loop of the largest area is the brim if it opens a large enough share of what the mesh
    shows from that side: `min_share_at_end` where it lies at the low or high end of the mesh
    (the world's z axis stands on the floor), `min_share` anywhere else.
    """
    loops = boundary_loops(faces)
    if not loops:
        return Openings(None, [])
    areas = [loop_area(vertices[loop]) for loop in loops]
    largest = int(np.argmax([np.linalg.norm(area) for area in areas]))
    size = float(np.linalg.norm(areas[largest]))
    shown = _silhouette(vertices, faces, areas[largest] / max(size, 1e-30))
    needed = min_share_at_end if _is_at_end(vertices, loops[largest]) else min_share
    if size < needed * shown:
        return Openings(None, loops)
    return Openings(loops[largest], loops[:largest] + loops[largest + 1 :])


def loop_area(loop: Points3) -> Vector3:
    """Area vector of a closed polyline: the largest that any view of it shows."""
    from_centre = loop - loop.mean(0)
    return 0.5 * np.cross(from_centre, np.roll(from_centre, -1, axis=0)).sum(0)


def _silhouette(vertices: Points3, faces: Faces, direction: Vector3) -> float:
    """Area of the mesh seen along a direction: the larger of its two sides."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    seen = 0.5 * np.cross(b - a, c - a) @ direction
    return float(max(seen[seen > 0].sum(), -seen[seen < 0].sum()))


def _is_at_end(vertices: Points3, loop: Int32[np.ndarray, " l"]) -> bool:
    """Whether the loop's middle lies in the lowest or highest tenth of the mesh."""
    low, high = vertices[:, 2].min(), vertices[:, 2].max()
    place = (vertices[loop, 2].mean() - low) / max(high - low, 1e-30)
    return bool(place < 0.1 or place > 0.9)
