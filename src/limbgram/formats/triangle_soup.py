"""Triangle soup: turns the unchecked triangles of a file into a sound mesh.

In      triangles or polygons as a reader found them.
Out     a Mesh: finite, valid indices, consistent winding, normals outward, edge-manifold.
Method  no triangle moves: where sheets meet at an edge, vertices are duplicated; where two open
        sides lie on each other, as at the seams of textures and shading, their ends are merged.
Fails   ShapeFileError: no surface, coordinates that are no numbers, invalid indices, or triangles
        that lie side by side without shared corners.
"""

from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64

from limbgram.core.errors import ShapeFileError
from limbgram.core.files import ContentError
from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    components,
    find_edges,
    half_edges,
    is_edge_manifold,
    number_pairs,
    split_nonmanifold_vertices,
    volume_mm3,
    with_faces,
)
from limbgram.findings import Finding, note
from limbgram.reconstruction.surface.cleaning import drop_degenerate_and_duplicate, make_manifold
from limbgram.workbench.carving.radius_map import Grid
from limbgram.workbench.limb import Landmark, LimbFrame

_MOST_FACES = 20_000_000
_LOOSE_SHARE = 0.5
"""Largest share of open triangle sides: at half, most triangles have lost their neighbours."""
_FEW_TRIANGLES = 100
"""A surface of fewer triangles may consist of brim alone."""


@dataclass(frozen=True, kw_only=True)
class Soup:
    """The unchecked triangles of a file, with what else it holds."""

    mesh: Mesh
    """In the file's unit, unless that was converted; unchecked."""
    stated_unit: str | None = None
    """The unit that the file states: "mm", "m", "unitless"; None without one."""
    converted_by: float = 1.0
    """Millimetres in one unit of the file, where the reader has multiplied by them already."""
    landmarks: tuple[Landmark, ...] = ()
    frame: LimbFrame | None = None
    grid: Grid | None = None
    """Angles and heights of the radii, if the file holds radii."""
    notes: tuple[Finding, ...] = ()
    """Peculiarities of the file, and how they were interpreted."""


@dataclass(frozen=True)
class Sound:
    """A sound mesh, and notes of the repairs."""

    mesh: Mesh
    notes: tuple[Finding, ...]


def triangles_merged(corners: Float64[np.ndarray, "f 3 3"]) -> Mesh:
    """A mesh of loose triangles; corners with equal coordinates become one vertex."""
    merged = _merged(corners.reshape(-1, 3))
    return Mesh(vertices_mm=merged.places, faces=merged.number.reshape(-1, 3))


@dataclass(frozen=True)
class _Merged:
    """Points without repetitions."""

    places: Points3
    """Each once."""
    number: Int32[np.ndarray, " k"]
    """Which of them each given point is."""


def _merged(points: Float64[np.ndarray, "k 3"]) -> _Merged:
    points = points + 0.0  # takes the sign off zero
    order = np.lexsort(points.T)
    apart = np.ones(len(points), np.bool_)
    apart[1:] = (points[order[1:]] != points[order[:-1]]).any(1)
    number = np.empty(len(points), np.int32)
    number[order] = np.cumsum(apart) - 1
    return _Merged(points[order[apart]], number)


def fans_of(polygons: list[list[int]]) -> Faces:
    """Triangles of polygons, each a fan round its first corner."""
    sizes = np.array([len(corners) for corners in polygons], np.int64)
    try:
        corners = np.fromiter(chain.from_iterable(polygons), np.int64, int(sizes.sum()))
    except OverflowError:
        corners = np.array([-1])
    if len(corners) and not 0 <= corners.min() <= corners.max() < 2**31:
        raise ContentError("file.face.vertex")
    triangles = sizes - 2
    first = np.repeat(np.cumsum(sizes) - sizes, triangles)
    second = np.arange(len(first)) + np.repeat(2 * np.arange(len(sizes)) + 1, triangles)
    return corners[np.column_stack([first, second, second + 1])].astype(np.int32).reshape(-1, 3)


def of_polygons(faces: Faces, polygons: int) -> tuple[Finding, ...]:
    """A note that polygons were split into triangles, which is ambiguous if they are not flat.

    polygons: Number of faces in the file.
    """
    more = len(faces) - polygons
    return (note("file.polygons_split", triangles=len(faces), polygons=polygons),) if more else ()


def require_corners(count: int, vertices: int) -> None:
    """Refuse a polygon with more corners than vertices, before memory is taken for it.

    Raises:
        ContentError: it has more corners than its file has vertices.
    """
    if count > vertices:
        raise ContentError("file.face.corners", corners=count, vertices=vertices)


def sound_mesh(mesh: Mesh, name: str) -> Sound:
    """The same surface as a sound mesh.

    Raises:
        ShapeFileError: no surface, numbers that are none, faces without their vertices, or
            triangles that share no corners.
    """
    _check(mesh, name)
    faces = _sewn(mesh, drop_degenerate_and_duplicate(mesh.vertices_mm, mesh.faces))
    if not len(faces):
        raise ShapeFileError("file.no_area", name=name)
    _require_joined(faces, name)
    wound = _wound_alike(faces)
    turned = int((wound != faces).any(1).sum())
    whole = split_nonmanifold_vertices(replace(mesh, faces=wound))
    kept = whole.faces
    if not is_edge_manifold(kept):
        kept = make_manifold(kept)
        whole = split_nonmanifold_vertices(with_faces(whole, kept))
    else:
        whole = with_faces(whole, kept)
    if volume_mm3(whole) < 0:
        whole = replace(whole, faces=whole.faces[:, ::-1].copy())
    notes = (
        note("file.left_out.flat", triangles=len(mesh.faces) - len(faces)),
        note("file.turned", triangles=turned),
        note("file.left_out.branching", triangles=len(faces) - len(kept)),
    )
    return Sound(whole, tuple(one for one in notes if one.values["triangles"]))


def _check(mesh: Mesh, name: str) -> None:
    if len(mesh.faces) > _MOST_FACES:
        raise ShapeFileError(
            "file.too_many_triangles", name=name, triangles=len(mesh.faces), most=_MOST_FACES
        )
    used = mesh.faces.ravel()
    if len(used) and (used.min() < 0 or used.max() >= len(mesh.vertices_mm)):
        raise ShapeFileError(
            "file.face.missing_vertex",
            name=name,
            vertex=int(used.max()),
            vertices=len(mesh.vertices_mm),
        )
    bad = int((~np.isfinite(mesh.vertices_mm)).any(1).sum())
    if bad or np.abs(mesh.vertices_mm).max(initial=0.0) > 1e9:
        raise ShapeFileError(
            "file.vertices_without_place", name=name, bad=bad, vertices=len(mesh.vertices_mm)
        )


def _sewn(mesh: Mesh, faces: Faces) -> Faces:
    """The faces with one edge where two open sides lie on each other.

    Formats with one normal or texture place a vertex have several vertices along a seam.
    """
    border = boundary_half_edges(faces)
    ends = np.unique(border)
    merged = _merged(mesh.vertices_mm[ends])
    if len(merged.places) == len(ends):
        return faces
    place_of = np.zeros(len(mesh), np.int32)
    place_of[ends] = merged.number
    tails, heads = place_of[border].T
    pairs = number_pairs(np.minimum(tails, heads), np.maximum(tails, heads))
    first = pairs.starts[:-1][np.diff(pairs.starts) == 2]
    one, two = pairs.order[first], pairs.order[first + 1]
    opposite = (tails[one] == heads[two])[:, None]
    joined = np.where(opposite, border[two][:, ::-1], border[two])
    links = np.stack([border[one], joined], axis=-1).reshape(-1, 2)
    label = components(links.astype(np.int64), len(mesh))
    _, kept = np.unique(label, return_index=True)
    return drop_degenerate_and_duplicate(mesh.vertices_mm, kept[label[faces]].astype(np.int32))


def _require_joined(faces: Faces, name: str) -> None:
    """Refuse triangles that do not share corners: their sections would be in pieces.

    Some programs round the corners of each triangle separately, so that those of neighbours differ.
    """
    loose = len(boundary_half_edges(faces))
    if len(faces) > _FEW_TRIANGLES and loose > _LOOSE_SHARE * faces.size:
        raise ShapeFileError(
            "file.triangles_apart",
            name=name,
            triangles=len(faces),
            sides_open_share=loose / faces.size,
        )


def _wound_alike(faces: Faces) -> Faces:
    """Flip the fewest faces so that neighbours have a consistent winding.

    Each face is two nodes of a graph, as it is and flipped; a component of the graph is one of the
    two windings of a part of the surface.
    """
    pairs = _neighbours(faces)
    if not pairs.contrary.any():
        return faces
    count = len(faces)
    here, there = pairs.faces[:, 0], pairs.faces[:, 1]
    other = np.where(pairs.contrary, count, 0)
    nodes = np.concatenate([here, here + count])
    neighbours = np.concatenate([there + other, there + count - other])
    labels = components(np.column_stack([nodes, neighbours]), 2 * count)
    way = np.minimum(labels[:count], labels[count:])
    as_way = labels[:count] == way
    in_favour = np.bincount(way, np.where(as_way, 1, -1), minlength=int(labels.max()) + 1)
    turned = as_way != (in_favour[way] >= 0)
    return np.where(turned[:, None], faces[:, ::-1], faces)


@dataclass(frozen=True)
class _Neighbours:
    faces: Int64[np.ndarray, "p 2"]
    contrary: Bool[np.ndarray, " p"]
    """Whether both use their edge in the same direction: one of them is to be flipped."""


def _neighbours(faces: Faces) -> _Neighbours:
    edges = find_edges(faces)
    order = edges.half_edges
    first = (np.cumsum(edges.uses) - edges.uses)[edges.uses == 2]
    one, two = order[first], order[first + 1]
    tails = half_edges(faces)[:, 0]
    return _Neighbours(np.column_stack([one, two]) // 3, tails[one] == tails[two])
