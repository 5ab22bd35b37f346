"""Proof: that a device is one closed solid, and as thick as was asked.

In      a shell and its layout; the finished solid.
Out     WallThickness: figures; or a refusal with the place.
Method  Closed and manifold by its edges, without crossings by the tree of its triangles. The
        thickness is measured on the triangles alone: between the outer skin and the inner
        one, which are told apart by the way they look. Edges, and blocks on the shell, are no wall
        and are not measured.
Fails   EditError: open, in pieces, crossing itself, or without a wall.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.errors import EditError
from limbgram.core.mesh.closest_point import TriangleTree, nearest_barycentric
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.folds import ANY_SHAPE, find_folds
from limbgram.core.mesh.mesh import Mesh, dots, unit
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    face_components,
    is_edge_manifold,
    is_vertex_manifold,
)
from limbgram.findings import Finding, doubt
from limbgram.workbench.devices.blocks import Block
from limbgram.workbench.devices.shell import Layout

_SKIN_COSINE = 0.7
"""Least cosine between the normals of a skin's faces and of the positive under them."""
_EDGE_THICKNESSES = 1.5
"""No wall is measured nearer to an edge than this many thicknesses; its rounding takes half."""
_BESIDE_BLOCK_MM = 1.0
"""Places nearer to a block than this belong to the block and are not measured."""
_DEVIATION_QUANTILE = 0.99


@dataclass(frozen=True, kw_only=True)
class WallThickness:
    """The measured wall thickness of a shell."""

    thinnest_mm: float
    thinnest_point_mm: tuple[float, float, float]
    """In the limb frame, on the inner side."""
    thickest_mm: float
    off_mm: float
    """Largest deviation from the thickness asked for, in 99 of 100 places of the wall."""
    at_vertices_mm: Float64[np.ndarray, " n"]
    """At each of its vertices; NaN on edges and blocks."""


def measure_wall(shell: Mesh, layout: Layout, blocks: Sequence[Block] = ()) -> WallThickness:
    """Measure a shell before anything is fitted to it.

    Raises:
        EditError: it has no wall that is wider than its edges.
    """
    skins = _find_skins(shell, layout, blocks)
    inner, outer = skins.inner, skins.outer
    inside = np.unique(shell.faces[inner & skins.clear])
    outside = np.unique(shell.faces[outer & skins.clear])
    if not len(inside) or not len(outside):
        raise EditError("device.no_wall")
    measured = np.full(len(shell), np.nan)
    for places, other in ((inside, outer), (outside, inner)):
        tree = TriangleTree.of(shell.vertices_mm, shell.faces[other])
        measured[places] = tree.closest(shell.vertices_mm[places]).distances_mm
    thinnest = int(inside[np.argmin(measured[inside])])
    x, y, z = shell.vertices_mm[thinnest].tolist()
    return WallThickness(
        thinnest_mm=float(measured[thinnest]),
        thinnest_point_mm=(x, y, z),
        thickest_mm=float(measured[outside].max()),
        off_mm=float(np.quantile(np.abs(measured - skins.asked_mm)[outside], _DEVIATION_QUANTILE)),
        at_vertices_mm=measured,
    )


def require_solid(solid: Mesh) -> None:
    """Refuse a mesh that is not a single closed solid.

    Raises:
        EditError: it is open, in pieces, or crosses itself; says where.
    """
    border = boundary_half_edges(solid.faces)
    if len(border) or not (is_edge_manifold(solid.faces) and is_vertex_manifold(solid.faces)):
        at = border[0, 0] if len(border) else 0
        x, y, z = solid.vertices_mm[at].tolist()
        raise EditError("device.open", point_mm=(x, y, z))
    pieces = face_components(solid.faces)
    if pieces.max():
        sizes = np.bincount(pieces)
        small = solid.faces[pieces == sizes.argmin()][0, 0]
        x, y, z = solid.vertices_mm[small].tolist()
        raise EditError("device.pieces", pieces=len(sizes), point_mm=(x, y, z))
    crossing = find_crossings(solid.vertices_mm, solid.faces)
    if len(crossing):
        x, y, z = solid.vertices_mm[solid.faces[crossing[0, 0]]].mean(0).tolist()
        raise EditError("device.crosses", count=len(crossing), point_mm=(x, y, z))


def fold_findings(solid: Mesh) -> tuple[Finding, ...]:
    """A doubt where a finished solid folds over.

    Only fittings and imported bodies can cause this: their form is not changed.
    """
    folds = find_folds(solid, ANY_SHAPE)
    if not len(folds):
        return ()
    x, y, z = folds.first_mm(solid).tolist()
    return (doubt("device.folded", count=len(folds), point_mm=(x, y, z)),)


@dataclass(frozen=True)
class _WallSkins:
    inner: Bool[np.ndarray, " f"]
    outer: Bool[np.ndarray, " f"]
    clear: Bool[np.ndarray, " f"]
    """Faces away from edges and blocks."""
    asked_mm: Float64[np.ndarray, " n"]


def _find_skins(solid: Mesh, layout: Layout, blocks: Sequence[Block]) -> _WallSkins:
    mesh = layout.positive
    found = TriangleTree.of(mesh.vertices_mm, mesh.faces).closest(solid.vertices_mm)
    corners = mesh.faces[found.faces]
    shares = nearest_barycentric(mesh.vertices_mm[corners], solid.vertices_mm)
    asked = dots(shares, layout.thickness_mm[corners])
    beyond = dots(shares, layout.beyond_mm[corners])
    clear = beyond < -_EDGE_THICKNESSES * asked
    for block in blocks:
        clear &= block.distance_mm(solid.vertices_mm) > _BESIDE_BLOCK_MM
    looks = unit(solid.face_normals())
    under = unit(mesh.face_normals())[found.faces]
    faces = solid.faces
    near = found.distances_mm < 0.5 * asked
    cosine = dots(looks, unit(under[faces].sum(1)))
    return _WallSkins(
        inner=(cosine < -_SKIN_COSINE) & near[faces].all(1),
        outer=(cosine > _SKIN_COSINE) & ~near[faces].any(1),
        clear=np.asarray(clear[faces].all(1)),
        asked_mm=asked,
    )
