"""Guard: refuses edits that tear a surface, fold it, or push it through itself.

A scan may come with such places of its own. An edit is refused for those it adds elsewhere.
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.folds import find_bent
from limbgram.core.mesh.mesh import Mesh, changed_rows
from limbgram.core.mesh.topology import faces_touching, is_edge_manifold, is_vertex_manifold

_SAME_PLACE_SIZES = 2.0
"""A pair this near to one of the scan's own, in triangle sizes, is no new one; sizes before the
edit count too, as some edits refine first."""

PairFinder = Callable[[Mesh, Bool[np.ndarray, " f"]], Int64[np.ndarray, "k 2"]]


def require_sound(before: Mesh, after: Mesh) -> None:
    """Refuse an edit that leaves no manifold, or adds folds or crossings.

    Raises:
        EditError: says how many triangles are concerned, and where.
    """
    if not np.isfinite(after.vertices_mm).all():
        raise EditError("edit.no_numbers")
    same_faces = np.array_equal(before.faces, after.faces)
    moved = _moved_faces(before, after)
    if not same_faces and not (is_edge_manifold(after.faces) and is_vertex_manifold(after.faces)):
        raise EditError("edit.branches")
    for how, find in _FINDERS:
        pairs = _new_pairs(before, after, find, moved)
        if len(pairs):
            place = after.vertices_mm[after.faces[pairs[0]]].reshape(-1, 3).mean(0)
            raise EditError(
                "edit.unsound", count=len(pairs), how=how, point_mm=tuple(place.tolist())
            )


def unsound_vertices(
    before: Mesh, after: Mesh, watched: Bool[np.ndarray, " n"] | None = None
) -> Bool[np.ndarray, " n"]:
    """Vertices of the triangles for which `require_sound` would refuse an edit.

    watched: only triangles with one of these vertices after the edit are looked at; None: all.
    """
    spoilt = np.zeros(len(after), np.bool_)
    moved = _moved_faces(before, after)
    if watched is not None:
        moved &= watched[after.faces].any(1)
    for _, find in _FINDERS:
        spoilt[after.faces[_new_pairs(before, after, find, moved)]] = True
    return spoilt


def _crossings(mesh: Mesh, concerned: Bool[np.ndarray, " f"]) -> Int64[np.ndarray, "k 2"]:
    return find_crossings(mesh.vertices_mm, mesh.faces, concerned)


def _moved_faces(before: Mesh, after: Mesh) -> Bool[np.ndarray, " f"]:
    """Faces that are new or have a moved corner."""
    moved = changed_rows(before.vertices_mm, after.vertices_mm)
    return changed_rows(before.faces, after.faces) | faces_touching(moved, after.faces)


def _new_pairs(
    before: Mesh, after: Mesh, find: PairFinder, moved: Bool[np.ndarray, " f"]
) -> Int64[np.ndarray, "k 2"]:
    """The pairs found after an edit, without those near a pair found before."""
    pairs = find(after, moved)
    if not len(pairs):
        return pairs
    own = find(before, np.ones(len(before.faces), np.bool_))
    if not len(own):
        return pairs
    numbered_alike = np.array_equal(before.faces, after.faces)
    stood = (before if numbered_alike else after).vertices_mm[after.faces[pairs]]
    had = before.vertices_mm[before.faces[own]]
    distance, at = KDTree(had.mean((1, 2))).query(stood.mean(2))
    size = np.maximum(_triangle_sizes(stood), _triangle_sizes(had).max(1)[at])
    return pairs[(distance > _SAME_PLACE_SIZES * size).any(1)]


def _triangle_sizes(corners: Float64[np.ndarray, "k 2 3 3"]) -> Float64[np.ndarray, "k 2"]:
    """The size of both triangles of each pair."""
    return np.linalg.norm(np.ptp(corners, axis=2), axis=2)


_FINDERS: tuple[tuple[str, PairFinder], ...] = (
    ("fold", find_bent),
    ("cross", _crossings),
)
