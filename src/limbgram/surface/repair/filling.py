"""Filling: holes closed, the new triangles made even and bent to go on as the surface does.

The new vertices take the shape of a thin plate that continues the surface round the hole; there
the plate may leave the points a little, so that their noise does not set its slope.
"""

import numpy as np
from jaxtyping import Bool, Float64, Int32
from scipy.sparse import csc_array, csr_array, diags_array
from scipy.sparse.linalg import splu

from limbgram.geometry.arrays import Faces, Points3
from limbgram.surface.mesh import Mesh
from limbgram.surface.repair.triangulation import triangulate
from limbgram.surface.resampling.passes import Triangles, find_twins
from limbgram.surface.resampling.refinement import even_out
from limbgram.surface.topology import find_edges, half_edges

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
