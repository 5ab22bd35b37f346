"""The brim: fills and marks the notches of the open end, up to the level of the brim.

In      a manifold mesh whose open end is ragged: photos saw less of some sides than of others.
Out     the mesh with its notches filled and marked; measured vertices keep their positions, unless
        closing a ragged rim folds them.
Method  A thin plate that continues the surface caps the whole opening. The parts of the cap that
        continue as a wall above the brim's level, within the brim's convex hull, stay: a notch lies
        between measured parts. Folds are flattened, and marked too.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int32
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import ConvexHull, KDTree

from limbgram.core.geometry.arrays import Faces, Points3, Vector3
from limbgram.core.geometry.frames import plane_basis
from limbgram.core.mesh.folds import unfolded
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import (
    boundary_loops,
    face_components,
    find_edges,
    select_vertices,
    with_faces,
)
from limbgram.reconstruction.surface.cleaning import face_normals, largest_manifold
from limbgram.reconstruction.surface.holes import fill_holes, loop_area

_NOTCH_EDGES = 4.0
"""A brim that rises less than this many edge lengths above its level has no notches."""
_FLOOR_DEG = 25.0
"""Parts of the cap at a smaller angle to the brim's plane are its floor, and are removed."""
_FLOOR_SHARE = 0.05
"""Parts of the floor smaller than this share of the largest one stay closed, as the walls do."""


@dataclass(frozen=True, kw_only=True)
class BrimOptions:
    """How much may be filled."""

    most_share: float = 0.1
    """Notches of more than this share of the surface stay open: the filling would be a guess."""


DEFAULTS = BrimOptions()
_LEVEL = 0.2
"""Share of the brim's length that lies below its level, which keeps it off single tongues."""
_PLANE_ITERATIONS = 30
_CAP_EDGES = 1.5
"""Edge length of the cap, in edges of the mesh."""
_PASSAGE_SLACK_FACES = 4
"""Faces by which a path from one floor to the next may exceed the shortest one and still belong to
the passage between them."""


def level_brim(mesh: Mesh, options: BrimOptions = DEFAULTS) -> Mesh:
    """The mesh with the notches of its largest opening closed; the mesh itself if it has none."""
    loops = boundary_loops(mesh.faces)
    if not loops:
        return mesh
    areas = [loop_area(mesh.vertices_mm[loop]) for loop in loops]
    sizes = [float(np.linalg.norm(area)) for area in areas]
    if not max(sizes) > 0:
        return mesh  # only slits
    brim = loops[int(np.argmax(sizes))]
    upward, level_mm, edge_mm = _quantile_plane(mesh.vertices_mm[brim], mesh.vertices_mm, _LEVEL)
    notch_mm = level_mm + _NOTCH_EDGES * edge_mm
    if (mesh.vertices_mm[brim] @ upward).max() < notch_mm:
        return mesh
    capped = fill_holes(mesh.vertices_mm, mesh.faces, [brim], _CAP_EDGES * edge_mm)
    opened = capped.faces[~_faces_to_open(mesh, brim, capped, upward, level_mm, notch_mm)]
    opened = largest_manifold(capped.vertices_mm, opened)
    result = with_faces(_with_attributes(mesh, capped), opened)
    too_much = _filled_area(result) - _filled_area(mesh) > options.most_share * result.area_mm2()
    if too_much or len(boundary_loops(result.faces)) > len(loops):
        return mesh
    return unfolded(result).mesh


def _quantile_plane(
    brim: Points3, body: Float64[np.ndarray, "m 3"], share: float
) -> tuple[Vector3, float, float]:
    """Unit normal towards the body, height along it, and median edge length of the brim's level.

    The level is the plane under which `share` of the brim's length lies: a quantile regression
    (Koenker and Bassett 1978), which notches do not tilt.
    """
    area = loop_area(brim)
    normal = area / np.linalg.norm(area)
    normal *= -1.0 if (body.mean(0) - brim.mean(0)) @ normal < 0 else 1.0
    across = plane_basis(normal)
    edges = np.linalg.norm(np.roll(brim, -1, axis=0) - brim, axis=1)
    length = (edges + np.roll(edges, 1)) / 2
    middle = brim.mean(0)
    terms = np.column_stack([(brim - middle) @ across.T, np.ones(len(brim))])
    heights = (brim - middle) @ normal
    plane = np.zeros(3)
    for _ in range(_PLANE_ITERATIONS):
        above = heights - terms @ plane
        weight = length * np.where(above > 0, share, 1 - share) / np.maximum(abs(above), edges)
        plane = np.linalg.solve((terms * weight[:, None]).T @ terms, terms.T @ (weight * heights))
    tilted = normal - plane[:2] @ across
    norm = float(np.linalg.norm(tilted))
    return tilted / norm, float(tilted @ middle + plane[2]) / norm, float(np.median(edges))


def _faces_to_open(
    mesh: Mesh,
    brim: Int32[np.ndarray, " b"],
    capped: Mesh,
    upward: Vector3,
    level_mm: float,
    notch_mm: float,
) -> Bool[np.ndarray, " f"]:
    """Faces of the cap to remove again: its floor, in one part, and low remains at the rim."""
    new = ~np.isin(_face_keys(capped.faces), _face_keys(mesh.faces))
    heights = (capped.vertices_mm @ upward)[capped.faces].mean(1)
    flat = np.abs(face_normals(capped.vertices_mm, capped.faces) @ upward) > np.cos(
        np.radians(_FLOOR_DEG)
    )
    beyond = np.zeros(len(new), np.bool_)
    middles = capped.vertices_mm[capped.faces[new]].mean(1)
    beyond[new] = _beyond_hull(middles, mesh.vertices_mm[brim], mesh.vertices_mm.mean(0), upward)
    candidates = np.flatnonzero(new & (flat | (heights < level_mm) | beyond))
    out = np.zeros(len(new), np.bool_)
    if len(candidates):
        labels = face_components(capped.faces[candidates])
        areas = np.bincount(labels, _face_areas(capped)[candidates])
        floors = np.flatnonzero(areas >= _FLOOR_SHARE * areas.max())
        floor_label = np.full(len(new), -1)
        floor_label[candidates] = labels
        parts = [
            floor_label == floor for floor in floors[np.argsort(-areas[floors], kind="stable")]
        ]
        out = _joined_floors(capped.faces, new, parts)
    closed = np.flatnonzero(new & ~out)
    part = face_components(capped.faces[closed])
    highest = np.full(part.max(initial=-1) + 1, -np.inf)
    np.maximum.at(highest, part, heights[closed])
    out[closed[highest[part] < notch_mm]] = True
    return out


def _beyond_hull(
    places_mm: Float64[np.ndarray, "p 3"], brim: Points3, middle_mm: Vector3, upward: Vector3
) -> Bool[np.ndarray, " p"]:
    """Points outside the convex hull of the brim, beyond the limb's end.

    Where one side of a limb ends higher than the others, as under a chin, the level is tilted: it
    runs below the measured rim of the other side, which would grow by a wall that does not exist.
    """
    hull = ConvexHull(np.vstack([brim, middle_mm])).equations
    ends = hull[hull[:, :3] @ upward < -np.cos(np.radians(_FLOOR_DEG))]
    outside: Bool[np.ndarray, "p e"] = places_mm @ ends[:, :3].T + ends[:, 3] > 0
    return np.asarray(outside.any(axis=1))


def _joined_floors(
    faces: Faces, new: Bool[np.ndarray, " f"], floors: list[Bool[np.ndarray, " f"]]
) -> Bool[np.ndarray, " f"]:
    """Faces of all floors joined to one opening by the shortest passages over the cap.

    Under an arch the walls from both sides may meet in a narrow strip; it must not close the floor
    of a heel. A floor that measured faces separate from the others stays closed.
    """
    out = floors[0].copy()
    if len(floors) == 1:
        return out
    adjacent = find_edges(faces).faces()
    adjacent = adjacent[(adjacent >= 0).all(1)]
    adjacent = adjacent[new[adjacent].all(1)]
    links = coo_array((np.ones(len(adjacent)), tuple(adjacent.T)), shape=(len(faces),) * 2).tocsr()
    for floor in floors[1:]:
        steps = [
            dijkstra(links, directed=False, indices=start, unweighted=True, min_only=True)
            for start in (np.flatnonzero(out), np.flatnonzero(floor))
        ]
        path_length = steps[0] + steps[1]
        shortest = float(path_length.min())
        if np.isfinite(shortest):
            out |= floor | (path_length <= shortest + _PASSAGE_SLACK_FACES)
    return out


def _face_keys(faces: Int32[np.ndarray, "f 3"]) -> np.ndarray:
    """One value per triangle, the same for every order of its corners."""
    return np.sort(faces, axis=1).astype(np.int32).copy().view("i4,i4,i4").ravel()


def _with_attributes(mesh: Mesh, capped: Mesh) -> Mesh:
    """The capped mesh with the attributes of the old vertices; new ones are marked as filled."""
    count, added = len(mesh), len(capped) - len(mesh)
    nearest = KDTree(mesh.vertices_mm).query(capped.vertices_mm[count:])[1].astype(np.int64)
    whole = select_vertices(mesh, np.concatenate([np.arange(count), nearest]))
    before = ~mesh.measured
    return replace(
        whole,
        vertices_mm=capped.vertices_mm,
        filled=np.concatenate([before, np.ones(added, np.bool_)]),
    )


def _filled_area(mesh: Mesh) -> float:
    """Area of the faces at filled vertices."""
    if mesh.filled is None:
        return 0.0
    return float(_face_areas(mesh)[mesh.filled[mesh.faces].any(1)].sum())


def _face_areas(mesh: Mesh) -> Float64[np.ndarray, " f"]:
    return 0.5 * np.linalg.norm(mesh.face_normals(), axis=1)
