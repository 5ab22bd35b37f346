"""Trees of meshes, kept: an edit asks the same surface for nearest places again and again.

A mesh is never changed once it is made, so its tree stays right as long as it lives. Trees of the
few meshes that were asked last are kept, and none longer than its mesh.
"""

from threading import RLock
from weakref import ref

from limbgram.core.mesh.closest import TriangleTree
from limbgram.core.mesh.mesh import Mesh

MOST_KEPT = 4
"""Trees; one of 250,000 triangles takes 30 MB."""

_KEPT: "dict[int, tuple[ref[Mesh], TriangleTree]]" = {}
"""By the number of the object, the last asked last."""
_LOCK = RLock()
"""A mesh may end while its thread holds it."""


def tree_on(mesh: Mesh) -> TriangleTree:
    """The tree of a mesh.

    Raises:
        ValueError: it has no face.
    """
    number = id(mesh)
    with _LOCK:
        known, tree = _KEPT.pop(number, (None, None))
        if known is not None and tree is not None and known() is mesh:
            _KEPT[number] = known, tree
            return tree
    tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    with _LOCK:
        _KEPT[number] = ref(mesh, lambda _: _forget(number)), tree
        while len(_KEPT) > MOST_KEPT:
            del _KEPT[next(iter(_KEPT))]
    return tree


def _forget(number: int) -> None:
    with _LOCK:
        _KEPT.pop(number, None)
