"""Cover: a wall over a skin, nowhere thinner than asked; what is too narrow for it is filled.

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
from limbgram.core.mesh.signed_distance import SignedDistances
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    face_components,
    faces_touching,
    split_nonmanifold_vertices,
    with_faces,
)
from limbgram.reconstruction.surface.remeshing import refine
from limbgram.workbench.edits.clearance import RIM_CELLS, RIM_EDGE_SHARE, Clearance
from limbgram.workbench.edits.closing import with_openings_joined
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.level_edges import Plane, plane_hold
from limbgram.workbench.edits.membrane import with_caps_refitted
from limbgram.workbench.edits.refinement import refine_where
from limbgram.workbench.edits.regions import neighbour_averaging, smooth_normals, with_surface_added

_NEAR_THICKNESSES = 2.5
"""Thicknesses from an open edge within which its plane cuts and distances from it are computed;
more than the zone that is refined round it."""
_SAMPLES_PER_EDGE = 20
"""Samples on each segment of an open edge."""
_SMOOTHINGS = 4
"""How often distances beyond a ragged edge are averaged, so that the new edge is smooth."""
_SNAP_SHARE = 0.1
"""Share of an edge: vertices this near to the cut through the level are moved onto it, so that no
slivers are left."""
_SETTLE_ROUNDS = 4
"""How often the new edge is moved to the thickness, along the cut."""


@dataclass(frozen=True, kw_only=True)
class CoverWall:
    """A wall over a skin; the skin's faces come first, reversed, and its vertices unchanged."""

    solid: Mesh
    cover_faces: int
    """Number of faces of the covering skin, which come next; the rest is the rim."""
    like: Int64[np.ndarray, " k"]
    """For each of the added vertices the nearest one of the given skin."""


class _EdgeDistances(NamedTuple):
    distance_mm: Float64[np.ndarray, " n"]
    plane_holds: list[Float64[np.ndarray, " n"]]


@dataclass(frozen=True)
class _OpenEdge:
    """The open edge of a skin that is to become a wall."""

    clearance: Clearance
    planes: tuple[Plane, ...]

    @cached_property
    def _segments(self) -> Int64[np.ndarray, "e 2"]:
        return boundary_half_edges(self.clearance.mesh.faces).astype(np.int64)

    @cached_property
    def _samples(self) -> KDTree:
        ends = self.clearance.mesh.vertices_mm[self._segments]
        share = (np.arange(_SAMPLES_PER_EDGE) / _SAMPLES_PER_EDGE)[:, None, None]
        return KDTree((ends[:, 0] + share * (ends[:, 1] - ends[:, 0])).reshape(-1, 3))

    @cached_property
    def _normals(self) -> Points3:
        return smooth_normals(self.clearance.mesh)

    def beyond_mm(self, level: Mesh) -> Float64[np.ndarray, " n"]:
        """Signed distance of the level's vertices beyond the edge, along the level; negative over
        the skin, positive under it."""
        square, plane_holds = self._distances(level.vertices_mm)
        mean = neighbour_averaging(level)
        for _ in range(_SMOOTHINGS):
            square = mean @ square
        for plane, held in zip(self.planes, plane_holds, strict=True):
            square -= held * (plane.above_mm(level.vertices_mm) + square)  # it looks to the skin
        return square

    def _distances(self, points: Points3) -> "_EdgeDistances":
        """Distances beyond the edge before planes count, and each plane's hold on every point."""
        thickness_mm = self.clearance.thickness_mm
        found = self.clearance.surface.query(points)
        far_mm = _NEAR_THICKNESSES * thickness_mm
        away_mm, place = self._samples.query(found.points_mm, distance_upper_bound=far_mm)
        away_mm = np.minimum(away_mm, far_mm)
        start = self._segments[np.asarray(place) % len(self._segments), 0]
        square = self._distance_without_planes(points, found, away_mm)
        near = (away_mm < far_mm) & (square < np.pi / 2 * thickness_mm)
        plane_holds: list[Float64[np.ndarray, " n"]] = []
        for plane in self.planes:
            at = near & plane.holds(self.clearance.mesh.vertices_mm)[start]
            at &= plane.above_mm(found.points_mm) > -self.clearance.edge_mm
            plane_holds.append(np.where(at, plane_hold(plane, self._normals[start]), 0.0))
        return _EdgeDistances(square, plane_holds)

    def _distance_without_planes(
        self, points: Points3, found: SignedDistances, away_mm: Float64[np.ndarray, " n"]
    ) -> Float64[np.ndarray, " n"]:
        """Distance beyond the edge, for an edge that lies in no plane."""
        corners = self._normals[self.clearance.mesh.faces[found.faces]]
        normals = unit((found.shares[:, :, None] * corners).sum(1))
        ways = unit(points - found.points_mm)
        turned = np.arctan2(lengths(np.cross(normals, ways)), dots(normals, ways))
        thickness_mm = self.clearance.thickness_mm
        inside = np.where(found.signed_mm > 0, -away_mm, np.pi * thickness_mm + away_mm)
        return np.where(found.at_brim, turned * thickness_mm, inside)

    def moved_to_thickness(self, points_mm: Points3) -> Points3:
        """Points on the cut through the level, moved to the thickness, within a plane that holds
        them."""
        places = points_mm.copy()
        flat = [held == 1 for held in self._distances(places).plane_holds]
        for plane, at in zip(self.planes, flat, strict=True):
            places[at] -= plane.above_mm(places[at])[:, None] * plane.normal
        for _ in range(_SETTLE_ROUNDS):
            nearest = self.clearance.tree.closest(places)
            lacking_mm = self.clearance.thickness_mm - nearest.distances_mm
            step = unit(places - nearest.points_mm)
            for plane, at in zip(self.planes, flat, strict=True):
                step[at] -= np.einsum("ij,j->i", step[at], plane.normal)[:, None] * plane.normal
            places += (lacking_mm / np.maximum(dots(step, step), 0.25))[:, None] * step
        return places


def cover_skin(clearance: Clearance, planes: tuple[Plane, ...]) -> CoverWall:
    """Make the wall over a skin.

    Raises:
        EditError: an edge crosses itself, or the wall fills the shape up to its openings.
    """
    mesh = clearance.mesh
    over = _cover_surface(clearance, _OpenEdge(clearance, planes))
    if not len(over.faces):
        raise EditError("edit.wall.no_hollow")
    like = np.asarray(KDTree(mesh.vertices_mm).query(over.vertices_mm)[1], np.int64)
    turned = Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces[:, ::-1])
    skins = with_surface_added(turned, over.vertices_mm, like, over.faces + np.int32(len(mesh)))
    solid = with_openings_joined(skins)
    own = len(skins.faces)
    solid = with_caps_refitted(solid, solid.faces[:own], solid.faces[own:])
    added = solid.vertices_mm[len(mesh) :]
    like = np.asarray(KDTree(mesh.vertices_mm).query(added)[1], np.int64)
    return CoverWall(
        solid=with_surface_added(
            replace(mesh, faces=turned.faces), added, like, solid.faces[len(mesh.faces) :]
        ),
        cover_faces=len(over.faces),
        like=like,
    )


def _cover_surface(clearance: Clearance, edge: _OpenEdge) -> Mesh:
    """The covering skin, open where the given one is."""
    level = _level_round_skin(clearance)
    level = with_faces(
        level, level.faces[_faces_over_skin(level, edge.beyond_mm(level), clearance)]
    )
    if not len(level.faces):
        return level
    level = refine(level, clearance.edge_mm)
    near = np.abs(edge.beyond_mm(level)) < RIM_CELLS * clearance.cell_mm
    level = refine_where(
        level, faces_touching(near, level.faces), RIM_EDGE_SHARE * clearance.edge_mm
    )
    level = level.with_vertices(clearance.moved_to_thickness(level.vertices_mm, level.faces))
    level = unfolded(level, ANY_SHAPE).mesh
    beyond_mm = edge.beyond_mm(level)
    beyond_mm[np.abs(beyond_mm) < _SNAP_SHARE * RIM_EDGE_SHARE * clearance.edge_mm] = 0.0
    cut = keep_positive(level, -beyond_mm)
    over = cut.mesh
    places = over.vertices_mm.copy()
    places[cut.on_cut] = edge.moved_to_thickness(places[cut.on_cut])
    parts = face_components(over.faces)
    rim = np.zeros(len(over), np.bool_)
    rim[boundary_half_edges(over.faces)] = True
    opened = np.isin(parts, parts[faces_touching(rim, over.faces)])
    return split_nonmanifold_vertices(with_faces(over.with_vertices(places), over.faces[opened]))


def _level_round_skin(clearance: Clearance) -> Mesh:
    """The level surface of the distance, all round the skin."""
    cell_mm = clearance.cell_mm
    reach_mm = clearance.thickness_mm + 2 * cell_mm
    lowest = clearance.mesh.vertices_mm.min(0) - reach_mm
    highest = clearance.mesh.vertices_mm.max(0) + reach_mm
    counts = np.ceil((highest - lowest) / cell_mm).astype(np.int64) + 1
    return level_surface(-clearance.excess_mm(lowest, counts), lowest, cell_mm)


def _faces_over_skin(
    level: Mesh, beyond_mm: Float64[np.ndarray, " n"], clearance: Clearance
) -> Bool[np.ndarray, " f"]:
    """Faces of the level that lie over the skin, or a little beyond its edge."""
    margin_mm = RIM_CELLS * clearance.cell_mm
    return np.asarray((beyond_mm[level.faces] < margin_mm).all(1))
