"""Tree cache: an edit asks the same surface for nearest places again and again.

A mesh is never changed once it is made, so its tree stays right as long as it lives, and so do the
normals that tell a side. Those of the few meshes that were asked last are kept, and none longer
than its mesh.
"""

from threading import RLock
from weakref import ref

from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.signed_distance import SignedSurface

MOST_KEPT = 4
"""Meshes; of one of 250,000 triangles the tree takes 30 MB, and what tells the side as much."""

_KEPT: "dict[int, tuple[ref[Mesh], SignedSurface]]" = {}
"""By the number of the object, the last asked last."""
_LOCK = RLock()
"""A mesh may end while its thread holds it."""


def tree_on(mesh: Mesh) -> TriangleTree:
    """The tree of a mesh.

    Raises:
        ValueError: it has no face.
    """
    return signed_on(mesh).tree


def signed_on(mesh: Mesh) -> SignedSurface:
    """A mesh, ready to be asked on which side places lie."""
    number = id(mesh)
    with _LOCK:
        known, surface = _KEPT.pop(number, (None, None))
        if known is None or surface is None or known() is not mesh:
            known = ref(mesh, lambda _: _forget(number))
            surface = SignedSurface(mesh.vertices_mm, mesh.faces)
        _KEPT[number] = known, surface
        while len(_KEPT) > MOST_KEPT:
            del _KEPT[next(iter(_KEPT))]
    return surface


def _forget(number: int) -> None:
    with _LOCK:
        _KEPT.pop(number, None)
