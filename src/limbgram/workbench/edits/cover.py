"""Cover: a wall that is nowhere thinner than asked: what is too narrow for it is filled.

In      an open Mesh that looks to where the wall is to lie, the wall's thickness, and the planes in
        which open edges lie.
Out     the wall: the given skin as it was, the skin over it, and the rim between them.
Method  The skin over it is a level of the distance, which goes on round the open edge as a tube.
        It is cut off where what is nearest is the open edge and lies below: square to the given
        skin, or level where the edge is. Bubbles that reach no opening are filled. Edges that lie
        in one plane are joined flat, others by a strip.
Fails   EditError: an edge crosses itself; the wall fills the shape up to its openings.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.folds import ANY_SHAPE, unfolded
from limbgram.core.mesh.isosurface import level_surface
from limbgram.core.mesh.mesh import Mesh, dots, lengths, unit
from limbgram.core.mesh.signed_distance import Signed
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    face_components,
    sheets_apart,
    with_any,
    with_faces,
)
from limbgram.reconstruction.surface.resampling import refine
from limbgram.workbench.edits.clearance import FINE_TO, FINER, Clearance
from limbgram.workbench.edits.closing import joined
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.fineness import refine_where
from limbgram.workbench.edits.level_edges import Plane, held_level
from limbgram.workbench.edits.membrane import mended
from limbgram.workbench.edits.regions import averaging, calm_normals, with_added

_NEAR = 2.5
"""Thicknesses from an open edge within which its plane cuts, and up to which it is told how far
from it a place is: more than what is made finer round it."""
_ALONG = 20
"""Places on each piece of an open edge that stand for it."""
_EVENED = 4
"""Times that distances beyond a ragged edge are evened out, so that the new edge is smooth."""
_SNAPPED = 0.1
"""Of an edge: vertices so near to where the level is cut are moved there, so that no slivers are
left."""
_SETTLED = 4
"""Times that the new edge is moved to the thickness, along the cut."""


@dataclass(frozen=True, kw_only=True)
class Covered:
    """A wall; the given skin's faces come first, turned, and its vertices as they were."""

    solid: Mesh
    over: int
    """Faces of the skin over the given one, which come next; the rest is the rim."""
    like: Int64[np.ndarray, " k"]
    """For each of the added vertices the nearest one of the given skin."""


class _Beyond(NamedTuple):
    square_mm: Float64[np.ndarray, " n"]
    helds: list[Float64[np.ndarray, " n"]]


@dataclass(frozen=True)
class _Edge:
    """The open edge of a skin that is to become a wall."""

    clearance: Clearance
    planes: tuple[Plane, ...]

    @cached_property
    def _pieces(self) -> Int64[np.ndarray, "e 2"]:
        return boundary_half_edges(self.clearance.mesh.faces).astype(np.int64)

    @cached_property
    def _places(self) -> KDTree:
        ends = self.clearance.mesh.vertices_mm[self._pieces]
        share = (np.arange(_ALONG) / _ALONG)[:, None, None]
        return KDTree((ends[:, 0] + share * (ends[:, 1] - ends[:, 0])).reshape(-1, 3))

    @cached_property
    def _normals(self) -> Points3:
        return calm_normals(self.clearance.mesh)

    def beyond_mm(self, over: Mesh) -> Float64[np.ndarray, " n"]:
        """How far vertices of the level lie beyond the edge, along the level; negative over the
        skin, and positive under it."""
        square, helds = self._found(over.vertices_mm)
        mean = averaging(over)
        for _ in range(_EVENED):
            square = mean @ square
        for plane, held in zip(self.planes, helds, strict=True):
            square -= held * (plane.above_mm(over.vertices_mm) + square)  # it looks to the skin
        return square

    def _found(self, points: Points3) -> "_Beyond":
        """The same without planes, and how much each of these holds."""
        thickness_mm = self.clearance.thickness_mm
        found = self.clearance.surface.signed(points)
        far_mm = _NEAR * thickness_mm
        away_mm, place = self._places.query(found.points_mm, distance_upper_bound=far_mm)
        away_mm = np.minimum(away_mm, far_mm)
        start = self._pieces[np.asarray(place) % len(self._pieces), 0]
        square = self._square_mm(points, found, away_mm)
        near = (away_mm < far_mm) & (square < np.pi / 2 * thickness_mm)
        helds: list[Float64[np.ndarray, " n"]] = []
        for plane in self.planes:
            at = near & plane.holds(self.clearance.mesh.vertices_mm)[start]
            at &= plane.above_mm(found.points_mm) > -self.clearance.edge_mm
            helds.append(np.where(at, held_level(plane, self._normals[start]), 0.0))
        return _Beyond(square, helds)

    def _square_mm(
        self, points: Points3, found: Signed, away_mm: Float64[np.ndarray, " n"]
    ) -> Float64[np.ndarray, " n"]:
        """The same for an edge that lies in no plane."""
        corners = self._normals[self.clearance.mesh.faces[found.faces]]
        normals = unit((found.shares[:, :, None] * corners).sum(1))
        ways = unit(points - found.points_mm)
        turned = np.arctan2(lengths(np.cross(normals, ways)), dots(normals, ways))
        thickness_mm = self.clearance.thickness_mm
        inside = np.where(found.signed_mm > 0, -away_mm, np.pi * thickness_mm + away_mm)
        return np.where(found.at_brim, turned * thickness_mm, inside)

    def settled(self, points_mm: Points3) -> Points3:
        """Places where the level was cut, moved to the thickness, those that a plane holds in
        it."""
        places = points_mm.copy()
        flat = [held == 1 for held in self._found(places).helds]
        for plane, at in zip(self.planes, flat, strict=True):
            places[at] -= plane.above_mm(places[at])[:, None] * plane.normal
        for _ in range(_SETTLED):
            nearest = self.clearance.tree.closest(places)
            lacking_mm = self.clearance.thickness_mm - nearest.distances_mm
            step = unit(places - nearest.points_mm)
            for plane, at in zip(self.planes, flat, strict=True):
                step[at] -= np.einsum("ij,j->i", step[at], plane.normal)[:, None] * plane.normal
            places += (lacking_mm / np.maximum(dots(step, step), 0.25))[:, None] * step
        return places


def covered(clearance: Clearance, planes: tuple[Plane, ...]) -> Covered:
    """The wall over a skin.

    Raises:
        EditError: an edge crosses itself, or the wall fills the shape up to its openings.
    """
    mesh = clearance.mesh
    over = _over(clearance, _Edge(clearance, planes))
    if not len(over.faces):
        raise EditError("edit.wall.no_hollow")
    like = np.asarray(KDTree(mesh.vertices_mm).query(over.vertices_mm)[1], np.int64)
    turned = Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces[:, ::-1])
    skins = with_added(turned, over.vertices_mm, like, over.faces + np.int32(len(mesh)))
    solid = joined(skins)
    own = len(skins.faces)
    solid = mended(solid, solid.faces[:own], solid.faces[own:])
    added = solid.vertices_mm[len(mesh) :]
    like = np.asarray(KDTree(mesh.vertices_mm).query(added)[1], np.int64)
    return Covered(
        solid=with_added(
            replace(mesh, faces=turned.faces), added, like, solid.faces[len(mesh.faces) :]
        ),
        over=len(over.faces),
        like=like,
    )


def _over(clearance: Clearance, edge: _Edge) -> Mesh:
    """The skin over the given one, open where that is."""
    level = _level(clearance)
    level = with_faces(level, level.faces[_within(level, edge.beyond_mm(level), clearance)])
    if not len(level.faces):
        return level
    level = refine(level, clearance.edge_mm)
    near = np.abs(edge.beyond_mm(level)) < FINE_TO * clearance.cell_mm
    level = refine_where(level, with_any(near, level.faces), FINER * clearance.edge_mm)
    level = level.with_vertices(clearance.settled(level.vertices_mm, level.faces))
    level = unfolded(level, ANY_SHAPE).mesh
    beyond_mm = edge.beyond_mm(level)
    beyond_mm[np.abs(beyond_mm) < _SNAPPED * FINER * clearance.edge_mm] = 0.0
    cut = keep_positive(level, -beyond_mm)
    over = cut.mesh
    places = over.vertices_mm.copy()
    places[cut.on_cut] = edge.settled(places[cut.on_cut])
    parts = face_components(over.faces)
    rim = np.zeros(len(over), np.bool_)
    rim[boundary_half_edges(over.faces)] = True
    opened = np.isin(parts, parts[with_any(rim, over.faces)])
    return sheets_apart(with_faces(over.with_vertices(places), over.faces[opened]))


def _level(clearance: Clearance) -> Mesh:
    """All round the skin."""
    cell_mm = clearance.cell_mm
    reach_mm = clearance.thickness_mm + 2 * cell_mm
    lowest = clearance.mesh.vertices_mm.min(0) - reach_mm
    highest = clearance.mesh.vertices_mm.max(0) + reach_mm
    counts = np.ceil((highest - lowest) / cell_mm).astype(np.int64) + 1
    return level_surface(-clearance.farther_mm(lowest, counts), lowest, cell_mm)


def _within(
    level: Mesh, beyond_mm: Float64[np.ndarray, " n"], clearance: Clearance
) -> Bool[np.ndarray, " f"]:
    """Faces of the level that lie over the skin, or a little beyond its edge."""
    margin_mm = FINE_TO * clearance.cell_mm
    return np.asarray((beyond_mm[level.faces] < margin_mm).all(1))
