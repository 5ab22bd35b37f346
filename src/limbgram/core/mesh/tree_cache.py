"""Tree cache: an edit asks the same surface for nearest places again and again.

A mesh is never changed once it is made, so its tree stays right as long as it lives, and so do the
normals that tell a side. Those of the few meshes that were asked last are kept, and none longer
than its mesh. So are answers to what is asked of a mesh often, word for word.
"""

from collections.abc import Callable, Hashable
from threading import RLock
from typing import Generic, TypeVar
from weakref import ref

from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.signed_distance import SignedSurface

MOST_KEPT = 4
"""Meshes; of one of 250,000 triangles the tree takes 30 MB, and what tells the side as much."""

Made = TypeVar("Made")


class ByMesh(Generic[Made]):
    """What was made of a mesh, made once."""

    def __init__(self, make: Callable[[Mesh], Made]) -> None:
        self._make = make
        self._kept: dict[int, tuple[ref[Mesh], Made]] = {}
        """By the number of the object, the last asked last."""
        self._lock = RLock()
        """A mesh may end while its thread holds it."""

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
    """What was found out about a mesh, by what was asked; found again once it was long not asked.

    An answer must not hold the mesh, which would live as long as its answers.
    """

    def __init__(self, most: int) -> None:
        """most: answers that are kept of each mesh."""
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
"""A mesh, ready to be asked on which side places lie."""


def tree_on(mesh: Mesh) -> TriangleTree:
    """The tree of a mesh.

    Raises:
        ValueError: it has no face.
    """
    return signed_on(mesh).tree
