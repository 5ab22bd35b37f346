"""Holes: hole filling, and which openings of a mesh are holes.

In      a manifold mesh with boundary loops.
Out     the brim, which is the limb's own open end, and the holes; the mesh with its holes filled.
Method  A hole's boundary loop is triangulated with its own vertices (Barequet and Sharir 1995;
        Liepa 2003); the new triangles are remeshed, and the new vertices lie on a thin plate that
        continues the surface round the hole. There the plate only approximates the vertices, so
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
from limbgram.core.mesh.topology import (
    boundary_loops,
    dilated,
    edge_lengths,
    find_edges,
    half_edges,
)
from limbgram.reconstruction.surface.remeshing import WorkingMesh, find_twins, remesh_once

_MAX_RING_VERTICES = 250
"""Larger loops lose their sharpest corners first: the search takes time with the cube of this."""
_BRIM_SHARE_AT_END = 0.1
"""An opening at the low or high end is the brim if its area is at least this share of the mesh's
area projected along its normal."""
_BRIM_SHARE = 0.35
"""The same for an opening anywhere else."""
_WALL_SINE = 0.5
"""Mean sine of the angle between an opening's axis and the surface round it, up to which that is a
wall. Two feet cut at six heights of the shank have 0.04 to 0.45; of a ball, round holes that a brim
could have, 0.75 to 0.90."""


def triangulate(loop: Points3, forbidden: Bool[np.ndarray, "l l"]) -> Faces | None:
    """Triangles of small area that close a loop, as indices into it; None if none are allowed.

    The loop runs along the half-edges of the faces round the hole; the new faces run against it.
    `forbidden[i, j]` excludes a chord that the mesh already has as an edge.
    """
    ears, kept = _cut_ears(loop, forbidden, max(len(loop) - _MAX_RING_VERTICES, 0))
    ring = np.ascontiguousarray(loop[kept])
    split = np.full((len(kept), len(kept)), -1, np.int32)
    if not _min_weight_triangulation(
        ring, np.ascontiguousarray(forbidden[np.ix_(kept, kept)]), split
    ):
        return None
    faces = ears
    pending = [(0, len(kept) - 1)]
    while pending:
        first, last = pending.pop()
        if last - first < 2:
            continue
        middle = int(split[first, last])
        faces.append((kept[first], kept[last], kept[middle]))
        pending += [(first, middle), (middle, last)]
    return np.array(faces, np.int32).reshape(-1, 3)


def _cut_ears(
    loop: Points3, forbidden: Bool[np.ndarray, "l l"], count: int
) -> tuple[list[tuple[int, int, int]], Int32[np.ndarray, " r"]]:
    """The triangles of `count` ears, sharpest first, and the vertices that are left."""
    kept = np.arange(len(loop), dtype=np.int32)
    ears: list[tuple[int, int, int]] = []
    while count > 0:
        before, after = np.roll(kept, 1), np.roll(kept, -1)
        u, v = loop[before] - loop[kept], loop[after] - loop[kept]
        cosine = (u * v).sum(1) / np.maximum(
            np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1), 1e-30
        )
        cosine[forbidden[before, after]] = -2
        sharper = (cosine > np.roll(cosine, 1)) & (cosine >= np.roll(cosine, -1)) & (cosine > -2)
        chosen = np.flatnonzero(sharper)
        chosen = chosen[np.argsort(-cosine[chosen], kind="stable")][: max(1, min(count, 40))]
        if not len(chosen):
            break
        for k in chosen:
            ears.append((int(kept[k]), int(before[k]), int(after[k])))
            forbidden[before[k], after[k]] = forbidden[after[k], before[k]] = True
        kept = np.delete(kept, chosen)
        count -= len(chosen)
    return ears, kept


@njit(cache=True, nogil=True)
def _min_weight_triangulation(ring: np.ndarray, forbidden: np.ndarray, split: np.ndarray):
    """Fill split[i, j], the third corner of the triangle on chord i..j; False if none is allowed.

    The weight of a triangulation is its area plus a small penalty for long edges, so that among
    triangulations of equal area the one with rounder triangles wins.
    """
    n = ring.shape[0]
    weight = np.zeros((n, n))
    for span in range(2, n):
        for i in range(n - span):
            j = i + span
            weight[i, j] = np.inf
            if forbidden[i, j] and not (i == 0 and j == n - 1):
                continue
            for m in range(i + 1, j):
                parts_weight = weight[i, m] + weight[m, j]
                if parts_weight >= weight[i, j]:
                    continue
                whole_weight = parts_weight + _triangle_weight(ring[i], ring[m], ring[j])
                if whole_weight < weight[i, j]:
                    weight[i, j] = whole_weight
                    split[i, j] = m
    return np.isfinite(weight[0, n - 1])


@njit(cache=True, nogil=True)
def _triangle_weight(a: np.ndarray, b: np.ndarray, c: np.ndarray):
    """Area of a triangle plus the penalty for long edges."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    wx, wy, wz = c[0] - b[0], c[1] - b[1], c[2] - b[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    area = 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz)
    edges2 = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz + wx * wx + wy * wy + wz * wz
    return area + 1e-3 * edges2


_CONTEXT_RINGS = 5
"""Rings of faces round a hole whose curvature the filling continues."""
_PLATE_LENGTH_EDGES = 1.0
"""Length of the plate: bends shorter than a few times this count as noise round a hole; a longer
plate flattens round caps."""
_MAX_SMALL_LOOP = 5
"""Loops of at most so many vertices are closed without new vertices."""
_SHAPE_ROUNDS = 2
_REMESH_ROUNDS = 3


def fill_holes(
    vertices: Points3,
    faces: Faces,
    holes: list[Int32[np.ndarray, " l"]],
    edge_mm: float | None = None,
    *,
    curved: bool = True,
) -> Mesh:
    """The mesh with these holes closed and new vertices marked as filled.

    holes: loops along the half-edges of the faces round them.
    edge_mm: length of the new edges; None: the median length of the mesh's own.
    curved: whether the filling continues the surface's curvature; else it is a minimal surface.
    """
    edges = edge_table(vertices, faces)
    small = [loop for loop in holes if len(loop) <= _MAX_SMALL_LOOP]
    large = [loop for loop in holes if len(loop) > _MAX_SMALL_LOOP]
    triangles = [loop_triangles(vertices, edges, loop) for loop in small]
    large += [loop for loop, made in zip(small, triangles, strict=True) if made is None]
    faces = np.concatenate([faces, *(made for made in triangles if made is not None)])
    if not large:
        return Mesh(vertices_mm=vertices, faces=faces, filled=np.zeros(len(vertices), np.bool_))
    work, far = _initial_patches(vertices, faces, large)
    edge = float(np.median(edge_lengths(vertices, find_edges(faces).ends)))
    for _ in range(_SHAPE_ROUNDS):
        for _ in range(_REMESH_ROUNDS):
            work = remesh_once(work, edge_mm or edge)
        work = (
            _with_thin_plate(work, _PLATE_LENGTH_EDGES * edge) if curved else _with_membrane(work)
        )
    return _merged(vertices, faces[far], work)


def _initial_patches(
    vertices: Points3, faces: Faces, holes: list[Int32[np.ndarray, " l"]]
) -> tuple[WorkingMesh, Bool[np.ndarray, " f"]]:
    """The first triangles of all holes with the faces round them, and a mask of the other faces."""
    edges = edge_table(vertices, faces)
    patches: list[np.ndarray] = []
    centres: list[np.ndarray] = []
    for loop in holes:
        triangles = loop_triangles(vertices, edges, loop)
        if triangles is None:
            after = np.roll(loop, -1)
            middle = np.full(len(loop), len(vertices) + len(centres), np.int32)
            patches.append(np.column_stack([after, loop, middle]))
            centres.append(vertices[loop].mean(0))
        else:
            patches.append(triangles)
    new = np.concatenate(patches).astype(np.int32)
    at_holes = np.zeros(len(vertices), np.bool_)
    at_holes[np.concatenate(holes)] = True
    near = dilated(at_holes, faces, _CONTEXT_RINGS)
    near_faces = np.asarray(near[faces].all(1))
    places = np.concatenate([vertices, np.array(centres).reshape(-1, 3)])
    local_faces = np.concatenate([faces[near_faces], new])
    used, compact = np.unique(local_faces, return_inverse=True)
    frozen = np.arange(len(local_faces)) < near_faces.sum()
    compact = compact.reshape(-1, 3).astype(np.int32)
    return WorkingMesh(places[used], compact, frozen, used.astype(np.int64)), ~near_faces


def edge_table(vertices: Points3, faces: Faces) -> csr_array:
    """(n, n) nonzero where an edge joins two vertices."""
    ends = half_edges(faces)
    shape = (len(vertices), len(vertices))
    table = csr_array((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), shape=shape)
    return csr_array(table + table.T)


def loop_triangles(
    vertices: Points3, edges: csr_array, loop: Int32[np.ndarray, " l"]
) -> Faces | None:
    """Triangles on the loop's own vertices; None if the mesh's edges forbid all of them."""
    adjacency = edges[loop][:, loop].toarray() > 0
    triangles = triangulate(vertices[loop], adjacency)
    return None if triangles is None else loop[triangles]


def _with_thin_plate(work: WorkingMesh, plate_length: float) -> WorkingMesh:
    """The mesh with the vertices without a frozen face on a thin plate."""
    fixed = work.of_frozen_faces()
    if fixed.all():
        return work
    laplacian, area = _laplacian(work.vertices, work.faces)
    interior = np.ones(len(work.vertices), np.bool_)
    interior[half_edges(work.faces)[find_twins(work.faces) < 0]] = False
    bending = laplacian.T @ diags_array(interior / area) @ laplacian
    point_weight = fixed * area / plate_length**4
    solver = splu(
        csc_array(bending + diags_array(point_weight)),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    plate = solver.solve(point_weight[:, None] * work.vertices)
    return work._replace(vertices=np.where(fixed[:, None], work.vertices, plate))


def _with_membrane(work: WorkingMesh) -> WorkingMesh:
    """The mesh with the vertices without a frozen face on a membrane fixed at the others."""
    fixed = work.of_frozen_faces()
    if fixed.all():
        return work
    laplacian, _ = _laplacian(work.vertices, work.faces)
    rows = csc_array(laplacian[~fixed])
    vertices = work.vertices.copy()
    vertices[~fixed] = splu(rows[:, ~fixed]).solve(-(rows[:, fixed] @ vertices[fixed]))
    return work._replace(vertices=vertices)


def _laplacian(vertices: Points3, faces: Faces) -> tuple[csr_array, Float64[np.ndarray, " n"]]:
    """Cotangent Laplacian with positive weights, and the barycentric area of each vertex."""
    count = len(vertices)
    area = np.zeros(count)
    rows: list[np.ndarray] = []
    weights: list[np.ndarray] = []
    for k in range(3):
        tip, a, b = faces[:, k], faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        u, v = vertices[a] - vertices[tip], vertices[b] - vertices[tip]
        double_area = np.linalg.norm(np.cross(u, v), axis=1)
        area += np.bincount(tip, double_area / 6, count)
        cotangent = (u * v).sum(1) / np.maximum(double_area, 1e-30)
        rows.append(np.column_stack([a, b]))
        weights.append(np.clip(cotangent, 0.05, 20.0) / 2)
    ends, weight = np.concatenate(rows), np.concatenate(weights)
    half = csr_array((weight, (ends[:, 0], ends[:, 1])), shape=(count, count))
    adjacency = half + half.T
    area = np.maximum(area, 1e-3 * area.mean())
    return csr_array(diags_array(np.asarray(adjacency.sum(1)).ravel()) - adjacency), area


def _merged(vertices: Points3, far: Faces, work: WorkingMesh) -> Mesh:
    """The whole mesh with the filled part: old vertices keep their numbers, new ones follow."""
    kept = work.of_frozen_faces()
    number = np.where(kept, work.origin, len(vertices) + np.cumsum(~kept) - 1)
    return Mesh(
        vertices_mm=np.concatenate([vertices, work.vertices[~kept]]),
        faces=np.concatenate([far, number[work.faces].astype(np.int32)]),
        filled=np.arange(len(vertices) + int((~kept).sum())) >= len(vertices),
    )


@dataclass(frozen=True)
class Openings:
    """The brim (None where the mesh has no open end) and the holes, as loops of vertices."""

    brim: Int32[np.ndarray, " b"] | None
    holes: list[Int32[np.ndarray, " l"]]


def find_openings(vertices: Points3, faces: Faces) -> Openings:
    """The brim and the holes, told apart by size and position.

    The loop of the largest area is the brim if its area is a large enough share of the mesh's
    area projected along its normal. Less suffices at an end of the mesh: the low or high one (the
    world's z axis is vertical), or, as of a foot whose shank lies, one to which a wall leads.
    """
    loops = boundary_loops(faces)
    if not loops:
        return Openings(None, [])
    areas = [loop_area(vertices[loop]) for loop in loops]
    largest = int(np.argmax([np.linalg.norm(area) for area in areas]))
    size = float(np.linalg.norm(areas[largest]))
    direction = areas[largest] / max(size, 1e-30)
    projected = _projected_area(vertices, faces, direction)
    at_end = _is_at_end(vertices[:, 2], loops[largest]) or (
        _is_at_end(vertices @ direction, loops[largest])
        and _is_end_of_wall(vertices, faces, loops[largest], direction)
    )
    needed = _BRIM_SHARE_AT_END if at_end else _BRIM_SHARE
    if size < needed * projected:
        return Openings(None, loops)
    return Openings(loops[largest], loops[:largest] + loops[largest + 1 :])


def loop_area(loop: Points3) -> Vector3:
    """Area vector of a closed polyline; its length is the largest projected area."""
    from_centre = loop - loop.mean(0)
    return 0.5 * np.cross(from_centre, np.roll(from_centre, -1, axis=0)).sum(0)


def _projected_area(vertices: Points3, faces: Faces, direction: Vector3) -> float:
    """Projected area of the mesh along a direction: the larger of its two sides."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    seen = 0.5 * np.cross(b - a, c - a) @ direction
    return float(max(seen[seen > 0].sum(), -seen[seen < 0].sum()))


def _is_at_end(heights: Float64[np.ndarray, " n"], loop: Int32[np.ndarray, " l"]) -> bool:
    """Whether the loop's middle lies in the lowest or highest tenth of the mesh."""
    low, high = heights.min(), heights.max()
    place = (heights[loop].mean() - low) / max(high - low, 1e-30)
    return bool(place < 0.1 or place > 0.9)


def _is_end_of_wall(
    vertices: Points3, faces: Faces, loop: Int32[np.ndarray, " l"], direction: Vector3
) -> bool:
    """Whether the surface runs up to a loop along its axis; round a hole it lies across."""
    at_loop = np.zeros(len(vertices), np.bool_)
    at_loop[loop] = True
    near = faces[dilated(at_loop, faces, _CONTEXT_RINGS)[faces].all(1)]
    a, b, c = (vertices[near[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)
    across = np.abs(areas @ direction).sum()
    return bool(across < _WALL_SINE * np.linalg.norm(areas, axis=1).sum())
