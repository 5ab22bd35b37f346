"""Shell: a solid of given thickness on a part of a surface, its edges rounded.

In      a Layout: the positive, how far each vertex lies beyond the device's edges, how thick the
        device is there; and blocks, which thicken it into a solid of another form.
Out     one closed mesh. Its inner side lies on the positive, its outer side at the thickness.
Method  With h the height above the positive and s the distance beyond the edge, both at the
        nearest place of the positive, the solid is where hypot(max(s + r, 0), h - r) < r, r being
        half of the thickness: a slab that ends in a half circle. What surrounds it is a level of
        that function on a grid (core/mesh/levels), its triangles made even and its vertices moved
        to the level itself. So it does not open, whatever the positive's creases are: narrow ones
        are bridged on the outer side. Where a crease is so narrow for the grid that vertices on
        the level cross, they go back towards the grid's surface, which does not cross itself; what
        still folds over is laid back (core/mesh/folds).
Fails   EditError: nothing of the surface is inside the edges, the grid would be too large, or a
        fold cannot be laid back.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.folds import ANY_SHAPE, unfolded
from limbgram.core.mesh.isosurface import level_surface
from limbgram.core.mesh.mesh import Mesh, crosses, dots
from limbgram.core.mesh.signed_distance import SignedSurface
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    face_components,
    faces_touching,
    find_edges,
    with_faces,
)
from limbgram.reconstruction.surface.remeshing import refine
from limbgram.workbench.devices.blocks import Block
from limbgram.workbench.edits.refinement import split_edges

_CELLS_ACROSS = 2.5
"""Cells of the grid across the thinnest wall."""
_FINEST_MM, _COARSEST_MM = 0.5, 2.0
_MOST_NODES = 60e6
"""Nodes of the whole grid: 60 million take half a gigabyte."""
_WALL_STEP_MM = 0.1
"""Steps in which a wall thick enough for a device's size is looked for."""
_BOX_NODES = 4
"""Nodes along a side of the boxes that are evaluated together."""
_EDGE_CELLS = 0.85
"""Edge length of the triangles, in cells."""
_NEWTON_STEPS = 8
"""Newton steps of the vertices towards the level."""
_ON_LEVEL_MM = 2e-3
"""A vertex this near counts as on the level."""
_CHORD_ERROR_MM = 0.02
"""An edge whose midpoint lies farther from the level is halved: a wall between two skins is off by
the chord errors of both."""
_HALVINGS = 3
"""Rounds of halving: all edges in the first, later only those of the wall."""
_RETREATS, _RETREAT_SHARE = 8, 0.5
"""How often crossing vertices go back towards the grid's surface, and by which share of the way;
then as often all of it."""
_SCRAP_SHARE = 1e-3
"""Pieces smaller than this share of the area are artefacts of the grid."""
_BEYOND_BRIM_MM = 1e3


@dataclass(frozen=True, kw_only=True)
class Layout:
    """A device on the surface of its positive, before it has a body."""

    positive: Mesh
    """Fine along the edges of the device; in the limb frame."""
    beyond_mm: Float64[np.ndarray, " n"]
    """Signed distance of each vertex over the surface beyond the nearest edge; negative inside."""
    thickness_mm: Float64[np.ndarray, " n"]


@dataclass(frozen=True, kw_only=True)
class Shell:
    """The solid of a device before anything is fitted to it."""

    solid: Mesh
    cell_mm: float
    """Cell size of the grid; smaller details may be lost."""
    pieces_left_out: int


def make_shell(layout: Layout, blocks: Sequence[Block] = ()) -> Shell:
    """The solid of a layout.

    Raises:
        EditError: the edges leave nothing of the surface, the device is too large, or it folds.
    """
    inside = layout.beyond_mm < 0
    if not inside.any():
        raise EditError("device.nothing_left")
    field = _ShellField.of(layout, blocks)
    thinnest_mm = float(layout.thickness_mm[inside].min())
    cell_mm = float(np.clip(thinnest_mm / _CELLS_ACROSS, _FINEST_MM, _COARSEST_MM))
    level = _level_surface(field, cell_mm)
    even = refine(level, _EDGE_CELLS * cell_mm)
    settled = _without_crossings(even, _moved_to_level(field, even.vertices_mm, cell_mm))
    known = 0
    for _ in range(_HALVINGS):
        finer = _with_chords_split(field, settled, known)
        if len(finer) == len(settled):
            break
        known = len(settled)
        settled = _without_crossings(finer, _moved_to_level(field, finer.vertices_mm, cell_mm))
    pieces = face_components(settled.faces)
    areas = np.bincount(pieces, np.linalg.norm(settled.face_normals(), axis=1))
    large = areas > _SCRAP_SHARE * areas.sum()
    solid = settled if large.all() else with_faces(settled, settled.faces[large[pieces]])
    flat = without_folds(solid)
    return Shell(solid=flat, cell_mm=cell_mm, pieces_left_out=int((~large).sum()))


@dataclass(frozen=True)
class _ShellField:
    """The implicit function whose zero level is the device's surface; negative inside."""

    surface: SignedSurface
    layout: Layout
    edge_gradients: Float64[np.ndarray, "f 3"]
    """Gradient of `beyond_mm` over each face."""
    blocks: Sequence[Block]

    @classmethod
    def of(cls, layout: Layout, blocks: Sequence[Block]) -> "_ShellField":
        mesh = layout.positive
        surface = SignedSurface(mesh.vertices_mm, mesh.faces)
        return cls(surface, layout, _face_gradients(mesh, layout.beyond_mm), blocks)

    def at(self, points_mm: Points3) -> "_FieldValues":
        """Values and gradients of the function at points."""
        found = self.surface.query(points_mm)
        corners = self.layout.positive.faces[found.faces]
        beyond = dots(found.shares, self.layout.beyond_mm[corners])
        beyond[found.at_brim] = _BEYOND_BRIM_MM
        radius = 0.5 * dots(found.shares, self.layout.thickness_mm[corners])
        height = found.signed_mm
        across = np.maximum(beyond + radius, 0.0)
        up = height - radius
        away = np.hypot(across, up)
        normals = np.where(
            (np.abs(height) > 1e-6)[:, None],
            (points_mm - found.points_mm) / np.where(height == 0, 1.0, height)[:, None],
            found.normals,
        )
        gradients = (
            across[:, None] * self.edge_gradients[found.faces] + up[:, None] * normals
        ) / np.maximum(away, 1e-9)[:, None]
        values = away - radius
        of_wall = across == 0
        for block in self.blocks:
            outside = radius - height  # within the wall it joins it, and never reaches the skin
            own = block.distance_mm(points_mm)
            of_block = np.maximum(own, outside)
            nearer = of_block < values
            if not nearer.any():
                continue
            grown = np.where((own > outside)[:, None], _block_gradient(block, points_mm), -normals)
            values = np.where(nearer, of_block, values)
            gradients = np.where(nearer[:, None], grown, gradients)
            of_wall &= ~nearer
        return _FieldValues(values, gradients, of_wall)


@dataclass(frozen=True)
class _FieldValues:
    values_mm: Float64[np.ndarray, " n"]
    gradients: Points3
    of_wall: Bool[np.ndarray, " n"]
    """Where a skin is nearest, rather than a rounded edge or a block."""


def _block_gradient(block: Block, points_mm: Points3) -> Points3:
    step = 1e-3
    return np.stack(
        [
            (block.distance_mm(points_mm + move) - block.distance_mm(points_mm - move)) / (2 * step)
            for move in step * np.eye(3)
        ],
        axis=1,
    )


def _face_gradients(mesh: Mesh, values: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, "f 3"]:
    """Gradient over each face of a piecewise linear function."""
    corners = mesh.vertices_mm[mesh.faces]
    normals = crosses(mesh.vertices_mm, mesh.faces)
    size = np.maximum((normals * normals).sum(1), 1e-30)[:, None]
    total = np.zeros((len(mesh.faces), 3))
    for k in range(3):
        across = corners[:, (k + 2) % 3] - corners[:, (k + 1) % 3]
        total += values[mesh.faces[:, k]][:, None] * np.cross(normals, across) / size
    return total


def _level_surface(field: _ShellField, cell_mm: float) -> Mesh:
    """The level surface on a grid that is evaluated only near the device."""
    mesh = field.layout.positive
    reach_mm = float(field.layout.thickness_mm.max()) + 2 * cell_mm
    near = field.layout.beyond_mm < reach_mm
    near &= np.isfinite(field.layout.beyond_mm)
    boxes = [np.stack([mesh.vertices_mm[near].min(0), mesh.vertices_mm[near].max(0)])]
    boxes += [block.box_mm() for block in field.blocks]
    lowest: Vector3 = np.min([box[0] for box in boxes], axis=0) - reach_mm - cell_mm
    highest: Vector3 = np.max([box[1] for box in boxes], axis=0) + reach_mm + cell_mm
    counts = _node_counts(highest - lowest, cell_mm)
    if float(counts.prod()) > _MOST_NODES:
        raise _too_large(field.layout, highest - lowest, cell_mm)
    values = np.full(counts, -1.0)
    nodes = _nodes_near_device(field, near, lowest, cell_mm, counts, reach_mm)
    points = lowest + cell_mm * np.stack(np.unravel_index(nodes, tuple(counts)), axis=1)
    values.ravel()[nodes] = -field.at(points).values_mm
    return level_surface(values, lowest, cell_mm)


def _node_counts(extents_mm: Vector3, cell_mm: float) -> Int64[np.ndarray, "3"]:
    boxes = np.ceil(extents_mm / (cell_mm * _BOX_NODES)).astype(np.int64)
    return np.asarray(boxes * _BOX_NODES + 1)


def _too_large(layout: Layout, extents_mm: Vector3, cell_mm: float) -> EditError:
    """The refusal of a grid that is too large: its extents, and what would make it small enough."""
    thinnest = int(np.argmin(np.where(layout.beyond_mm < 0, layout.thickness_mm, np.inf)))
    thinnest_mm = float(layout.thickness_mm[thinnest])
    walls_mm = np.arange(thinnest_mm, _COARSEST_MM * _CELLS_ACROSS, _WALL_STEP_MM) + _WALL_STEP_MM
    fitting_mm = None
    for wall_mm in np.minimum(walls_mm, _COARSEST_MM * _CELLS_ACROSS).tolist():
        coarser_mm = max(wall_mm / _CELLS_ACROSS, _FINEST_MM)
        grown_mm = 2 * (wall_mm - thinnest_mm) + 6 * (coarser_mm - cell_mm)
        if float(_node_counts(extents_mm + grown_mm, coarser_mm).prod()) <= _MOST_NODES:
            fitting_mm = wall_mm
            break
    longest = int(np.argmax(extents_mm))
    room_nodes = _MOST_NODES / float(np.delete(_node_counts(extents_mm, cell_mm), longest).prod())
    room_mm = (room_nodes - _BOX_NODES - 1) * cell_mm
    across_mm, deep_mm, high_mm = extents_mm.tolist()
    x, y, z = layout.positive.vertices_mm[thinnest].tolist()
    return EditError(
        "device.too_large",
        across_mm=across_mm,
        deep_mm=deep_mm,
        high_mm=high_mm,
        longest=("across", "deep", "high")[longest],
        over_mm=float(extents_mm[longest] - room_mm),
        thinnest_mm=thinnest_mm,
        point_mm=(x, y, z),
        fitting_mm=fitting_mm,
    )


def _nodes_near_device(
    field: _ShellField,
    near: Bool[np.ndarray, " n"],
    lowest: Vector3,
    cell_mm: float,
    counts: Int64[np.ndarray, "3"],
    reach_mm: float,
) -> Int64[np.ndarray, " k"]:
    """Indices of the nodes of all boxes near the device or a block."""
    mesh = field.layout.positive
    side_mm = cell_mm * _BOX_NODES
    boxes = (counts - 1) // _BOX_NODES + 1
    middles = lowest + side_mm * (np.indices(tuple(boxes)).reshape(3, -1).T + 0.5)
    faces = mesh.faces[near[mesh.faces].any(1)]
    longest_mm = float(
        np.linalg.norm(
            mesh.vertices_mm[faces] - mesh.vertices_mm[np.roll(faces, 1, axis=1)], axis=2
        ).max()
    )
    far_mm = reach_mm + 0.5 * np.sqrt(3.0) * side_mm + longest_mm
    away_mm = KDTree(mesh.vertices_mm[np.unique(faces)]).query(
        middles, distance_upper_bound=far_mm, workers=1
    )[0]
    chosen = np.isfinite(away_mm)
    half_mm = 0.5 * np.sqrt(3.0) * side_mm
    margin_mm = half_mm + 2 * cell_mm  # an edge of the grid that the level cuts is no longer
    chosen[chosen] = _boxes_at_wall(field, middles[chosen], half_mm, margin_mm)
    for block in field.blocks:
        chosen |= block.distance_mm(middles) < margin_mm
    first = np.stack(np.unravel_index(np.flatnonzero(chosen), tuple(boxes)), axis=1) * _BOX_NODES
    own = np.indices((_BOX_NODES,) * 3).reshape(3, -1).T
    nodes = (first[:, None] + own).reshape(-1, 3)
    nodes = nodes[(nodes < counts).all(1)]
    strides = np.array([counts[1] * counts[2], counts[2], 1])
    return np.asarray((nodes * strides).sum(1), np.int64)


def _boxes_at_wall(
    field: _ShellField, middles: Points3, half_mm: float, margin_mm: float
) -> Bool[np.ndarray, " k"]:
    """Which boxes may hold a part of the level, by the height of their centres over the positive.

    The height varies by at most half of a box's diagonal within it, except where the sides of the
    positive meet beyond its brim; boxes near that are kept.
    """
    height_mm = field.surface.query(middles).signed_mm
    highest_mm = float(field.layout.thickness_mm.max()) + margin_mm
    kept = (height_mm > -margin_mm) & (height_mm < highest_mm)
    brim = np.unique(boundary_half_edges(field.layout.positive.faces))
    if len(brim):
        from_brim_mm = KDTree(field.layout.positive.vertices_mm[brim]).query(middles, workers=1)[0]
        kept |= from_brim_mm < np.abs(height_mm) + 2 * half_mm
    return kept


def _moved_to_level(field: _ShellField, points_mm: Points3, cell_mm: float) -> Points3:
    """Points moved to the level by Newton's method, each step less than a cell."""
    places = points_mm.copy()
    moving = np.arange(len(places))
    for _ in range(_NEWTON_STEPS):
        found = field.at(places[moving])
        steep = np.maximum(dots(found.gradients, found.gradients), 0.25)
        step = np.clip(found.values_mm / steep, -0.5 * cell_mm, 0.5 * cell_mm)
        places[moving] -= step[:, None] * found.gradients
        moving = moving[np.abs(found.values_mm) > _ON_LEVEL_MM]
        if not len(moving):
            break
    return places


def _with_chords_split(field: _ShellField, mesh: Mesh, known: int) -> Mesh:
    """The mesh with edges halved whose midpoint lies off the level, where curvature is high.

    Args:
        known: Number of vertices before the last halving. Edges between two of them
            were checked then; of the others only those of the wall, whose thickness is promised.
    """
    edges = find_edges(mesh.faces)
    new = np.flatnonzero((edges.ends >= known).any(1))
    found = field.at(mesh.vertices_mm[edges.ends[new]].mean(1))
    off = np.zeros(len(edges.ends), np.bool_)
    off[new] = (np.abs(found.values_mm) > _CHORD_ERROR_MM) & (found.of_wall | (known == 0))
    return split_edges(mesh, edges, off, np.full(len(off), 0.5)).mesh


def _without_crossings(even: Mesh, places_mm: Points3) -> Mesh:
    """The mesh with its vertices moved, except where it would intersect itself."""
    places = places_mm.copy()
    near = np.zeros(len(even), np.bool_)
    concerned = np.ones(len(even.faces), np.bool_)
    for share in (_RETREAT_SHARE,) * _RETREATS + (1.0,) * _RETREATS:
        crossing = find_crossings(places, even.faces, concerned)
        if not len(crossing):
            break
        near[even.faces[crossing.ravel()]] = True
        concerned = faces_touching(near, even.faces)
        near[even.faces[concerned]] = True
        concerned = faces_touching(near, even.faces)
        places[near] += share * (even.vertices_mm[near] - places[near])
    return even.with_vertices(places)


def without_folds(solid: Mesh) -> Mesh:
    """A closed solid with its folds removed; unchanged where it has none.

    Raises:
        EditError: what folds cannot be laid back; says where.
    """
    found = unfolded(solid, ANY_SHAPE)
    if len(found.left):
        x, y, z = found.left.first_mm(found.mesh).tolist()
        raise EditError("device.folds", count=len(found.left), point_mm=(x, y, z), causes=None)
    return solid.with_vertices(found.mesh.vertices_mm) if found.vertices else solid
