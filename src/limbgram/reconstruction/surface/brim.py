"""The brim: notches of the open end are filled, and marked, up to the level of the brim.

In      a manifold mesh whose open end is ragged: photos saw less of some sides than of others.
Out     the mesh with its notches filled and marked; what was there stays as it is, unless it
        folds: a ragged rim does where it is closed.
Method  the whole opening is capped by a thin plate that continues the surface; of the cap stays
        what goes on as a wall above the brim's level, within the brim's convex hull: a notch lies
        between measured parts. Folds are laid back, and marked too.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int32
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import ConvexHull, KDTree

from limbgram.core.geometry.arrays import Faces, Points3, Vector3
from limbgram.core.geometry.frames import square_to
from limbgram.core.mesh.folds import unfolded
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import (
    boundary_loops,
    face_components,
    find_edges,
    taking_vertices,
    with_faces,
)
from limbgram.reconstruction.surface.cleaning import face_normals, largest_manifold
from limbgram.reconstruction.surface.holes import fill_holes, loop_area

_NOTCH_EDGES = 4.0
"""A brim that nowhere stands this many edge lengths above its level is even enough."""
_FLOOR_DEG = 25.0
"""Parts of the cap flatter than this to the brim's plane are its floor, and go."""
_FLOOR_SHARE = 0.05
"""Parts of the floor smaller than this part of the largest one stay closed with the walls."""


@dataclass(frozen=True, kw_only=True)
class BrimOptions:
    """What is a notch, and how much may be guessed."""

    level: float = 0.2
    """Part of the brim's length that lies below its level: single tongues do not set it."""

    most_share: float = 0.1
    """Notches of more than this part of the surface stay open: too much would be a guess."""


DEFAULTS = BrimOptions()
_FITS = 30
_CAP_EDGES = 1.5
"""Edge length of the cap, in edges of the mesh."""
_PASSAGE_STEPS = 4
"""How much longer than the shortest a way from one floor to the next may be, in faces of the cap,
to become part of the passage between them."""


def level_brim(mesh: Mesh, options: BrimOptions = DEFAULTS) -> Mesh:
    """Close the notches of the largest opening; the mesh itself where there are none."""
    loops = boundary_loops(mesh.faces)
    if not loops:
        return mesh
    areas = [loop_area(mesh.vertices_mm[loop]) for loop in loops]
    sizes = [float(np.linalg.norm(area)) for area in areas]
    if not max(sizes) > 0:
        return mesh  # slits: nothing is open
    brim = loops[int(np.argmax(sizes))]
    upward, level_mm, edge_mm = _level(mesh.vertices_mm[brim], mesh.vertices_mm, options.level)
    notch_mm = level_mm + _NOTCH_EDGES * edge_mm
    if (mesh.vertices_mm[brim] @ upward).max() < notch_mm:
        return mesh
    capped = fill_holes(mesh.vertices_mm, mesh.faces, [brim], _CAP_EDGES * edge_mm)
    opened = capped.faces[~_opening(mesh, brim, capped, upward, level_mm, notch_mm)]
    opened = largest_manifold(capped.vertices_mm, opened)
    result = with_faces(_carried(mesh, capped), opened)
    much = _filled_area(result) - _filled_area(mesh) > options.most_share * result.area_mm2()
    if much or len(boundary_loops(result.faces)) > len(loops):
        return mesh
    return unfolded(result).mesh


def _level(
    brim: Points3, body: Float64[np.ndarray, "m 3"], share: float
) -> tuple[Vector3, float, float]:
    """Unit normal towards the body, height along it and edge length of the brim's level.

    The level is the plane under which `share` of the brim's length lies: a regression by
    quantiles (Koenker and Bassett 1978), which notches do not tilt.
    """
    area = loop_area(brim)
    normal = area / np.linalg.norm(area)
    normal *= -1.0 if (body.mean(0) - brim.mean(0)) @ normal < 0 else 1.0
    across = square_to(normal)
    edges = np.linalg.norm(np.roll(brim, -1, axis=0) - brim, axis=1)
    length = (edges + np.roll(edges, 1)) / 2
    middle = brim.mean(0)
    terms = np.column_stack([(brim - middle) @ across.T, np.ones(len(brim))])
    heights = (brim - middle) @ normal
    plane = np.zeros(3)
    for _ in range(_FITS):
        above = heights - terms @ plane
        weight = length * np.where(above > 0, share, 1 - share) / np.maximum(abs(above), edges)
        plane = np.linalg.solve((terms * weight[:, None]).T @ terms, terms.T @ (weight * heights))
    tilted = normal - plane[:2] @ across
    size = float(np.linalg.norm(tilted))
    return tilted / size, float(tilted @ middle + plane[2]) / size, float(np.median(edges))


def _opening(
    mesh: Mesh,
    brim: Int32[np.ndarray, " b"],
    capped: Mesh,
    upward: Vector3,
    level_mm: float,
    notch_mm: float,
) -> Bool[np.ndarray, " f"]:
    """Faces of the cap that are taken out again: its floor, in one part, and scraps at the rim."""
    new = ~np.isin(_keys(capped.faces), _keys(mesh.faces))
    heights = (capped.vertices_mm @ upward)[capped.faces].mean(1)
    flat = np.abs(face_normals(capped.vertices_mm, capped.faces) @ upward) > np.cos(
        np.radians(_FLOOR_DEG)
    )
    past = np.zeros(len(new), np.bool_)
    middles = capped.vertices_mm[capped.faces[new]].mean(1)
    past[new] = _past_end(middles, mesh.vertices_mm[brim], mesh.vertices_mm.mean(0), upward)
    going = np.flatnonzero(new & (flat | (heights < level_mm) | past))
    out = np.zeros(len(new), np.bool_)
    if len(going):
        labels = face_components(capped.faces[going])
        areas = np.bincount(labels, _areas(capped)[going])
        floors = np.flatnonzero(areas >= _FLOOR_SHARE * areas.max())
        of_face = np.full(len(new), -1)
        of_face[going] = labels
        parts = [of_face == floor for floor in floors[np.argsort(-areas[floors], kind="stable")]]
        out = _as_one(capped.faces, new, parts)
    staying = np.flatnonzero(new & ~out)
    part = face_components(capped.faces[staying])
    highest = np.full(part.max(initial=-1) + 1, -np.inf)
    np.maximum.at(highest, part, heights[staying])
    out[staying[highest[part] < notch_mm]] = True
    return out


def _past_end(
    places_mm: Float64[np.ndarray, "p 3"], brim: Points3, middle_mm: Vector3, upward: Vector3
) -> Bool[np.ndarray, " p"]:
    """Places that stand out of the convex hull of the brim at the limb's end.

    Where one side of a limb ends higher than the others, as under a chin, the level is tilted: it
    runs below the measured rim of the other side, which would grow by a wall that is not there.
    """
    hull = ConvexHull(np.vstack([brim, middle_mm])).equations
    ends = hull[hull[:, :3] @ upward < -np.cos(np.radians(_FLOOR_DEG))]
    outside: Bool[np.ndarray, "p e"] = places_mm @ ends[:, :3].T + ends[:, 3] > 0
    return np.asarray(outside.any(axis=1))


def _as_one(
    faces: Faces, new: Bool[np.ndarray, " f"], floors: list[Bool[np.ndarray, " f"]]
) -> Bool[np.ndarray, " f"]:
    """All floors as one opening: what of the cap lies between two is opened where it is narrowest.

    Under an arch the walls from both sides may just meet in a strip, or just not: what is the
    floor of a heel must not be closed by that. A floor that measured faces part from the others
    stays closed.
    """
    out = floors[0].copy()
    if len(floors) == 1:
        return out
    sides = find_edges(faces).faces()
    sides = sides[(sides >= 0).all(1)]
    sides = sides[new[sides].all(1)]
    links = coo_array((np.ones(len(sides)), tuple(sides.T)), shape=(len(faces),) * 2).tocsr()
    for floor in floors[1:]:
        steps = [
            dijkstra(links, directed=False, indices=start, unweighted=True, min_only=True)
            for start in (np.flatnonzero(out), np.flatnonzero(floor))
        ]
        across = steps[0] + steps[1]
        nearest = float(across.min())
        if np.isfinite(nearest):
            out |= floor | (across <= nearest + _PASSAGE_STEPS)
    return out


def _keys(faces: Int32[np.ndarray, "f 3"]) -> np.ndarray:
    """One value a triangle, whatever corner comes first."""
    return np.sort(faces, axis=1).astype(np.int32).copy().view("i4,i4,i4").ravel()


def _carried(mesh: Mesh, capped: Mesh) -> Mesh:
    """The capped mesh with what was known of the old vertices; new ones are filled."""
    count, added = len(mesh), len(capped) - len(mesh)
    nearest = KDTree(mesh.vertices_mm).query(capped.vertices_mm[count:])[1].astype(np.int64)
    whole = taking_vertices(mesh, np.concatenate([np.arange(count), nearest]))
    before = np.zeros(count, np.bool_) if mesh.filled is None else mesh.filled
    return replace(
        whole,
        vertices_mm=capped.vertices_mm,
        filled=np.concatenate([before, np.ones(added, np.bool_)]),
    )


def _filled_area(mesh: Mesh) -> float:
    if mesh.filled is None:
        return 0.0
    return float(_areas(mesh)[mesh.filled[mesh.faces].any(1)].sum())


def _areas(mesh: Mesh) -> Float64[np.ndarray, " f"]:
    return 0.5 * np.linalg.norm(mesh.face_normals(), axis=1)
