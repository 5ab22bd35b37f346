"""Tree cache: search trees of the meshes used last, and answers computed from a mesh.

A mesh is immutable, so its tree and its normals hold as long as it lives. The cache is keyed by
object identity, holds the few meshes used last, and keeps none of them alive.
"""

from collections.abc import Callable, Hashable
from threading import RLock
from typing import Generic, TypeVar
from weakref import ref

from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.signed_distance import SignedSurface

MOST_KEPT = 4
"""Meshes; for 250,000 triangles the tree takes 30 MB, and the signs of distances as much."""

Made = TypeVar("Made")


class ByMesh(Generic[Made]):
    """Memoizes a function of a mesh for the meshes used last."""

    def __init__(self, make: Callable[[Mesh], Made]) -> None:
        self._make = make
        self._kept: dict[int, tuple[ref[Mesh], Made]] = {}
        """By id, the most recently used last."""
        self._lock = RLock()
        """Reentrant: a mesh may be freed, and forgotten, while its thread holds the lock."""

    def __call__(self, mesh: Mesh) -> Made:
        number = id(mesh)
        with self._lock:
            kept = self._kept.pop(number, None)
            if kept is None or kept[0]() is not mesh:
                kept = ref(mesh, lambda _: self._forget(number)), self._make(mesh)
            self._kept[number] = kept
            while len(self._kept) > MOST_KEPT:
                del self._kept[next(iter(self._kept))]
        return kept[1]

    def _forget(self, number: int) -> None:
        with self._lock:
            self._kept.pop(number, None)


class AnswersByMesh(Generic[Made]):
    """Memoizes answers about a mesh by a key, the most recently used ones.

    An answer must not refer to its mesh, which it would keep alive.
    """

    def __init__(self, most: int) -> None:
        """most: answers kept for each mesh."""
        self._most = most
        self._of: ByMesh[dict[Hashable, Made]] = ByMesh(lambda _: {})
        self._lock = RLock()

    def __call__(self, mesh: Mesh, asked: Hashable, find: Callable[[], Made]) -> Made:
        kept = self._of(mesh)
        with self._lock:
            found = kept.pop(asked, None)
        if found is None:
            found = find()
        with self._lock:
            kept[asked] = found
            while len(kept) > self._most:
                del kept[next(iter(kept))]
        return found


signed_on = ByMesh(lambda mesh: SignedSurface(mesh.vertices_mm, mesh.faces))
"""The signed distance field of a mesh."""


def tree_on(mesh: Mesh) -> TriangleTree:
    """The tree of a mesh.

    Raises:
        ValueError: it has no face.
    """
    return signed_on(mesh).tree
