"""Membrane: openings closed by surfaces of least area.

In      an open Mesh; its open edges may be ragged, and have edges of micrometres where it was cut.
Out     the same without openings.
Method  A lip goes round each opening first, from its edge to an even, smooth curve a little farther
        in; the membrane spans that curve. On the edge itself it would fold: corners of teeth become
        ears over the teeth, and triangles on three points of a short edge may face anywhere.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64, Int32, Int64
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.geometry.polyline import distances_along, resampled
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.folds import find_bent
from limbgram.core.mesh.mesh import Mesh, dots, unit
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    boundary_loops,
    edge_lengths,
    faces_touching,
    find_edges,
    is_vertex_manifold,
)
from limbgram.reconstruction.surface.holes import edge_table, loop_area, loop_triangles
from limbgram.workbench.edits.regions import with_holes_closed, with_surface_added
from limbgram.workbench.edits.triangle_strip import strip

_ACUTE_DEG = 120.0
"""Angle between neighbouring normals from which a cap is fitted again."""
_LIP_SMOOTHING, _LIP_WINDOW, _FEWEST_LIP_POINTS = 2.0, 9, 12
"""In median edges: length over which a lip's inner curve is smoothed, and over which it avoids a
tooth; an opening with fewer edges needs no lip."""
_REFITS = 6
"""How often folded caps are fitted again."""


def with_openings_spanned(mesh: Mesh) -> Mesh:
    """The mesh with its openings closed by least area; its own faces come first.

    No vertex of it moves. Of the new ones, which come after them, some may have no face.
    """
    if not len(boundary_half_edges(mesh.faces)):
        return mesh
    lipped = _with_lips(mesh)
    closed = with_holes_closed(lipped, boundary_loops(lipped.faces), curved=False)
    count, own = len(closed), mesh.faces
    new = ~np.isin(_face_keys(closed.faces, count), _face_keys(own, count))
    return with_caps_refitted(closed, own, closed.faces[new])


def _with_lips(mesh: Mesh) -> Mesh:
    """The mesh with a lip round each opening, in the opening's mean plane."""
    from scipy.ndimage import (  # a tenth of a second, for openings that are closed
        gaussian_filter1d,
        maximum_filter1d,
    )

    edge_mm = float(np.median(edge_lengths(mesh.vertices_mm, find_edges(mesh.faces).ends)))
    for loop in boundary_loops(mesh.faces):
        rim = mesh.vertices_mm[loop]
        line = _resampled(
            gaussian_filter1d(_resampled(rim, edge_mm), _LIP_SMOOTHING, 0, mode="wrap"), edge_mm
        )
        if len(line) < _FEWEST_LIP_POINTS:
            continue
        ahead = np.roll(line, -1, axis=0) - np.roll(line, 1, axis=0)
        inwards = unit(np.cross(loop_area(line), ahead))
        nearest = KDTree(line).query(rim)[1]
        reach_mm = np.zeros(len(line))
        np.maximum.at(reach_mm, nearest, dots(rim - line[nearest], inwards[nearest]))
        reach_mm = maximum_filter1d(reach_mm, _LIP_WINDOW, mode="wrap")
        reach_mm = gaussian_filter1d(reach_mm, _LIP_SMOOTHING, mode="wrap")
        inner = line + (edge_mm + reach_mm)[:, None] * inwards
        like = loop[KDTree(rim).query(inner)[1]].astype(np.int64)
        numbers = np.concatenate([loop, len(mesh) + np.arange(len(inner))])
        mesh = with_surface_added(mesh, inner, like, numbers[strip(rim, inner)].astype(np.int32))
    return mesh


def _resampled(loop: Points3, edge_mm: float) -> Float64[np.ndarray, "m 3"]:
    """Points at about equal distances along a closed polyline."""
    whole = np.concatenate([loop, loop[:1]])
    return resampled(whole, max(3, round(distances_along(whole)[-1] / edge_mm)) + 1)[:-1]


def _face_keys(faces: Faces, count: int) -> Int64[np.ndarray, " f"]:
    """A key of each face that identifies its corners in any order."""
    low, middle, high = np.sort(faces.astype(np.int64), axis=1).T
    return (low * count + middle) * count + high


def with_caps_refitted(closed: Mesh, own: Faces, caps: Int32[np.ndarray, "k 3"]) -> Mesh:
    """The closed shape with its caps fitted again, without inner vertices, where they fold onto it;
    of all attempts the one with the fewest folds."""
    best, fewest = closed, (len(closed.faces),) * 2
    for rings in range(_REFITS):
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
            near[caps[faces_touching(near, caps)]] = True
        left = caps[~faces_touching(near, caps)]
        laid = _least_area_caps(closed.vertices_mm, np.concatenate([own, left]))
        if laid is not None:
            caps = np.concatenate([left, laid])
    return best


def _least_area_caps(vertices: Points3, faces: Faces) -> Int32[np.ndarray, "k 3"] | None:
    """Triangulations of least area over all openings; None where there is no answer."""
    if not is_vertex_manifold(faces):
        return None
    edges = edge_table(vertices, faces)
    laid: list[Faces] = []
    for loop in boundary_loops(faces):
        found = loop_triangles(vertices, edges, loop)
        if found is None:
            return None
        laid.append(found)
    return np.concatenate(laid) if laid else None
