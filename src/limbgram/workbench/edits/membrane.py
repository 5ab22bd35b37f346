"""Membrane: openings closed by the surface of least area, as by the skin of a drum.

In      an open Mesh; its open edges may be ragged, and have edges of micrometres where it was cut.
Out     the same without openings.
Method  A lip goes round each opening first, from its edge to an even, smooth line a little farther
        in; the drum spans that line. On the edge itself a drum folds: corners of teeth are cut off
        it as ears, over the teeth, and triangles on three points of a short edge look anywhere.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64, Int32, Int64
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.folds import find_bent
from limbgram.core.mesh.mesh import Mesh, dots, lengths, unit
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    boundary_loops,
    edge_lengths,
    find_edges,
    half_edges,
    is_vertex_manifold,
    with_any,
)
from limbgram.reconstruction.surface.holes import loop_area, triangulate
from limbgram.workbench.edits.regions import with_added, with_closed
from limbgram.workbench.edits.triangle_strip import strip

_ACUTE_DEG = 120.0
"""Angle between the normals of neighbours from which a cap is laid anew."""
_CALM, _AROUND, _FEWEST = 2.0, 9, 12
"""Edges of the usual length over which a lip's line is smoothed, and over which it heeds a tooth
that stands farther in than the rest; an opening with fewer round it needs no lip."""
_MENDINGS = 6
"""Times that folds of what was closed are mended."""


def spanned(mesh: Mesh) -> Mesh:
    """The mesh with its openings closed straight across; its own faces come first.

    No vertex of it moves. Of the new ones, which come after them, some may have no face.
    """
    if not len(boundary_half_edges(mesh.faces)):
        return mesh
    lipped = _with_lips(mesh)
    closed = with_closed(lipped, boundary_loops(lipped.faces), bent=False)
    count, own = len(closed), mesh.faces
    new = ~np.isin(_names(closed.faces, count), _names(own, count))
    return mended(closed, own, closed.faces[new])


def _with_lips(mesh: Mesh) -> Mesh:
    """With a lip round each opening, in the direction of its mean plane."""
    from scipy.ndimage import (  # a tenth of a second, for openings that are closed
        gaussian_filter1d,
        maximum_filter1d,
    )

    edge_mm = float(np.median(edge_lengths(mesh.vertices_mm, find_edges(mesh.faces).ends)))
    for loop in boundary_loops(mesh.faces):
        rim = mesh.vertices_mm[loop]
        line = _even(gaussian_filter1d(_even(rim, edge_mm), _CALM, 0, mode="wrap"), edge_mm)
        if len(line) < _FEWEST:
            continue
        ahead = np.roll(line, -1, axis=0) - np.roll(line, 1, axis=0)
        inwards = unit(np.cross(loop_area(line), ahead))
        nearest = KDTree(line).query(rim)[1]
        reach_mm = np.zeros(len(line))
        np.maximum.at(reach_mm, nearest, dots(rim - line[nearest], inwards[nearest]))
        reach_mm = maximum_filter1d(reach_mm, _AROUND, mode="wrap")
        reach_mm = gaussian_filter1d(reach_mm, _CALM, mode="wrap")
        inner = line + (edge_mm + reach_mm)[:, None] * inwards
        like = loop[KDTree(rim).query(inner)[1]].astype(np.int64)
        numbers = np.concatenate([loop, len(mesh) + np.arange(len(inner))])
        mesh = with_added(mesh, inner, like, numbers[strip(rim, inner)].astype(np.int32))
    return mesh


def _even(loop: Points3, edge_mm: float) -> Float64[np.ndarray, "m 3"]:
    """Places on a closed polyline, about as far from each other as asked."""
    whole = np.concatenate([loop, loop[:1]])
    walked = np.concatenate([[0.0], np.cumsum(lengths(np.diff(whole, axis=0)))])
    count = max(3, round(walked[-1] / edge_mm))
    at = np.linspace(0.0, walked[-1], count + 1)[:-1]
    return np.stack([np.interp(at, walked, axis) for axis in whole.T], axis=1)


def _names(faces: Faces, count: int) -> Int64[np.ndarray, " f"]:
    """A number for each face that tells its corners."""
    low, middle, high = np.sort(faces.astype(np.int64), axis=1).T
    return (low * count + middle) * count + high


def mended(closed: Mesh, own: Faces, caps: Int32[np.ndarray, "k 3"]) -> Mesh:
    """The closed shape whose caps are laid anew, without places inside, where they fold onto it;
    of all that was tried the one that folds least."""
    best, fewest = closed, (len(closed.faces),) * 2
    for rings in range(_MENDINGS):
        closed = replace(closed, faces=np.concatenate([own, caps]))
        new = np.arange(len(closed.faces)) >= len(own)
        bent = find_bent(closed, new, _ACUTE_DEG)
        crossing = find_crossings(closed.vertices_mm, closed.faces, new)
        spoilt = np.unique(closed.faces[np.concatenate([bent, crossing]).ravel()])
        folded = len(find_bent(closed, new)) + len(crossing)
        if (folded, len(spoilt)) < fewest:
            best, fewest = closed, (folded, len(spoilt))
        if not len(spoilt):
            break
        near = np.zeros(len(closed), np.bool_)
        near[spoilt] = True
        for _ in range(rings):
            near[caps[with_any(near, caps)]] = True
        left = caps[~with_any(near, caps)]
        laid = _laid(closed.vertices_mm, np.concatenate([own, left]))
        if laid is not None:
            caps = np.concatenate([left, laid])
    return best


def _laid(vertices: Points3, faces: Faces) -> Int32[np.ndarray, "k 3"] | None:
    """Triangles of the least area over all openings; None where there is none, or no answer."""
    if not is_vertex_manifold(faces):
        return None
    ends = half_edges(faces)
    laid: list[Faces] = []
    for loop in boundary_loops(faces):
        place = np.full(len(vertices), -1)
        place[loop] = np.arange(len(loop))
        chords = place[ends]
        chords = chords[(chords >= 0).all(1)]
        taken = np.zeros((len(loop), len(loop)), np.bool_)
        taken[chords[:, 0], chords[:, 1]] = taken[chords[:, 1], chords[:, 0]] = True
        found = triangulate(vertices[loop], taken)
        if found is None:
            return None
        laid.append(loop[found])
    return np.concatenate(laid) if laid else None
