"""Toe bridge: gaps between the toes closed, as a plaster cast or a sock's toe cap does it.

A toe plate lies under all toes and round them; between bare toes its edge would follow every gap.

Method  Beyond a plane across both metatarsal heads the foot is closed in the sense of mathematical
        morphology: grown by half of the widest gap, then shrunk by as much (Serra 1982). A ball of
        that radius fits into no gap that is left; elsewhere the surface stays where it was. It is
        made anew there as a level of the distance on a grid, moved to the level itself, and joined
        to the rest of the foot by a strip. The grid lies as the foot does, lateral, ahead and up,
        so a scan that lies otherwise, or the other foot, is filled alike. What is filled is
        shallower by up to half a cell: the grid rounds the valley of the grown foot.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.spatial import KDTree

from limbgram.core.errors import EditError, MeasureError
from limbgram.core.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.core.mesh.isosurface import level_surface
from limbgram.core.mesh.mesh import VERTEX_FIELDS, Mesh, unit
from limbgram.core.mesh.signed_distance import SignedSurface
from limbgram.core.mesh.topology import (
    boundary_loops,
    face_components,
    largest_piece,
    select_vertices,
    unmeasured_at,
)
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.core.request_fields import Within
from limbgram.reconstruction.surface.remeshing import refine
from limbgram.workbench.anatomy.kind import Midpoint
from limbgram.workbench.edits.cutting import ON_CUT_MM, keep_positive
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.regions import with_surface_added
from limbgram.workbench.edits.triangle_strip import strip
from limbgram.workbench.limb import Kind, Limb

_PLACES = ("plantar", "foot", "first metatarsal head", "fifth metatarsal head", "second toe")
"""Directions and landmarks by which toes are bridged."""
_CELLS_PER_RADIUS = 4.0
"""Cells of the grid across half of the gap."""
_COARSEST_MM = 2.0
_EDGE_CELLS = 0.85
"""Edge length of the triangles, in cells."""
_GRID_DIGITS = 6
"""Decimals of millimetres to which the grid and its values are rounded: remeshing on a grid depends
on ties, which the rounding of a turned scan would decide differently."""
_NEWTON_STEPS, _ON_LEVEL_MM = 6, 2e-3
"""Newton steps of vertices towards the level, and how near counts as on it."""
_STRIP_CELLS = 1.5
"""Width in cells of the strip between the unchanged foot and the new surface."""
_OWN_SURFACE_MM = 0.02
"""The closed surface lies this much inside the foot's own, so that the latter stays."""
_FILLED_MM = 0.1
"""Surface farther than this from the original foot counts as filled."""


@edit(
    group="orthosis",
    order=9,
    effect=Effect(moves_skin=True, reports_displacement=False),
    kinds=("foot",),
    example={"gap_mm": 10.0},
)
class ToeBridge(Edit):
    """Close the gaps between the toes, so that a toe plate runs under and round all of them."""

    gap_mm: Annotated[float, Within(2, 40)] = 20.0
    """Width of the widest gap that is closed."""

    words = spoken(
        en=Words(name="Bridge the toes", title="The toe bridge", labels={"gap_mm": "Gap"}),
        de=Words(
            name="Zehen überbrücken",
            title="Die Zehenüberbrückung",
            does="Die Lücken zwischen den Zehen schließen, damit eine Zehenplatte unter und um "
            "alle Zehen läuft.",
            labels={"gap_mm": "Lücke"},
            help={"gap_mm": "Breite der breitesten Lücke, die geschlossen wird."},
        ),
    )

    def places_of(self, kind: Kind) -> set[str]:
        return kind.names_in(_PLACES)

    def apply(self, limb: Limb) -> Limb:
        """Make the foot anew beyond the metatarsal heads, its gaps closed.

        Raises:
            EditError: a landmark is missing, or the foot ends, or is open, before its toes.
        """
        try:
            up = limb.anatomy.axis("plantar").direction
            forward = limb.anatomy.axis("foot").direction
            first, fifth, toe = (
                limb.anatomy.at(Midpoint((name,)))
                for name in ("first metatarsal head", "fifth metatarsal head", "second toe")
            )
        except MeasureError as error:
            reason = error.finding
            raise EditError("edit.repose.not_told", reason=reason) from error
        across = _BallPlane.of(first, fifth, toe, up, forward)
        return limb.with_mesh(_with_toes_bridged(limb.mesh, across, self))


@dataclass(frozen=True)
class _BallPlane:
    """The plane across both metatarsal heads, with the foot's axes."""

    through_mm: Vector3
    axes: Matrix3
    """Rows: lateral, ahead, up; a mirror too, on one of the feet."""
    toe_mm: Vector3

    @classmethod
    def of(
        cls, first_mm: Vector3, fifth_mm: Vector3, toe_mm: Vector3, up: Vector3, forward: Vector3
    ) -> "_BallPlane":
        ahead = np.cross(first_mm - fifth_mm, up)
        ahead = unit((ahead * np.sign(ahead @ forward))[None])[0]
        lateral = np.cross(ahead, up)
        lateral *= np.sign(lateral @ (fifth_mm - first_mm))
        return cls(first_mm, np.stack([lateral, ahead, up]), toe_mm)

    def along_mm(self, points_mm: Points3) -> Float64[np.ndarray, " n"]:
        return (points_mm - self.through_mm) @ self.axes[1]

    def in_foot_axes(self, mesh: Mesh) -> Mesh:
        """A surface brought to the foot's own axes."""
        return self._with_vertices_at(mesh, (mesh.vertices_mm - self.through_mm) @ self.axes.T)

    def in_mesh_axes(self, mesh: Mesh) -> Mesh:
        """A surface in the foot's own axes, brought back to the mesh's."""
        return self._with_vertices_at(mesh, mesh.vertices_mm @ self.axes + self.through_mm)

    def _with_vertices_at(self, mesh: Mesh, vertices_mm: Points3) -> Mesh:
        mirrored = np.linalg.det(self.axes) < 0
        faces = np.ascontiguousarray(mesh.faces[:, ::-1]) if mirrored else mesh.faces
        return Mesh(vertices_mm=vertices_mm, faces=faces)

    def toe_vertices(self, mesh: Mesh, from_mm: float) -> Bool[np.ndarray, " n"]:
        """Vertices of the toes beyond a distance along the foot; no knee that is there too."""
        beyond = self.along_mm(mesh.vertices_mm) > from_mm
        faces = np.flatnonzero(beyond[mesh.faces].any(1))
        seed = tree_on(mesh).closest(self.toe_mm[None]).faces[0]
        found = np.zeros(len(mesh), np.bool_)
        pieces = face_components(mesh.faces[faces])
        own = pieces[faces == seed]
        if len(own):
            found[mesh.faces[faces[pieces == own[0]]]] = True
        return found & beyond


@dataclass(frozen=True)
class _ClosedFoot:
    """The implicit function whose zero level is the foot with its gaps closed; negative inside."""

    foot: SignedSurface
    grown: SignedSurface
    radius_mm: float

    on_grid: Float64[np.ndarray, " g"]
    """Values at the grid's points: exact where the level passes between them and a neighbour."""

    @classmethod
    def of(cls, foot: SignedSurface, grid: "_Grid", radius_mm: float) -> "_ClosedFoot":
        places = grid.points_mm
        values = foot.query(places).signed_mm
        solid = grid.positive_surface(radius_mm - values)
        grown = SignedSurface(solid.vertices_mm, solid.faces)
        near = (values < radius_mm) & ((values > -2 * grid.cell_mm) | grid.beside_border)
        shrunk_mm = grown.query(places[near]).signed_mm + radius_mm + _OWN_SURFACE_MM
        values[near] = np.minimum(values[near], shrunk_mm)
        return cls(foot, grown, radius_mm, values)

    def at(self, points_mm: Points3) -> tuple[Float64[np.ndarray, " n"], Points3]:
        """Values and gradients of the function."""
        own, grown = self.foot.query(points_mm), self.grown.query(points_mm)
        values = np.stack([own.signed_mm, grown.signed_mm + self.radius_mm + _OWN_SURFACE_MM])
        nearest = np.stack([own.points_mm, grown.points_mm])
        away = np.stack([own.signed_mm, grown.signed_mm])
        normals = np.stack([own.normals, grown.normals])
        least, rows = values.argmin(0), np.arange(len(points_mm))
        off = away[least, rows]
        steady = np.abs(off) > 1e-6
        gradients = normals[least, rows]
        gradients[steady] = ((points_mm - nearest[least, rows])[steady]) / off[steady, None]
        return values[least, rows], gradients


@dataclass(frozen=True)
class _Grid:
    lowest_mm: Vector3
    cell_mm: float
    counts: tuple[int, int, int]

    @classmethod
    def round(cls, points_mm: Points3, margin_mm: float, cell_mm: float) -> "_Grid":
        low, high = points_mm.min(0) - margin_mm, points_mm.max(0) + margin_mm
        low, high = np.round(low, _GRID_DIGITS), np.round(high, _GRID_DIGITS)
        x, y, z = (np.ceil((high - low) / cell_mm).astype(int) + 1).tolist()
        return cls(low, cell_mm, (x, y, z))

    @property
    def points_mm(self) -> Points3:
        return self.lowest_mm + self.cell_mm * np.indices(self.counts).reshape(3, -1).T

    @property
    def beside_border(self) -> Bool[np.ndarray, " n"]:
        """Points of which a neighbour lies on the border."""
        inner = np.zeros(self.counts, np.bool_)
        inner[2:-2, 2:-2, 2:-2] = True
        return ~inner.ravel()

    def positive_surface(self, values: Float64[np.ndarray, " n"]) -> Mesh:
        """The surface round positive values, cut straight at the grid's border."""
        box = np.round(values, _GRID_DIGITS).reshape(self.counts)
        for axis in range(3):
            for end in (0, -1):
                box[tuple(end if k == axis else slice(None) for k in range(3))] = -self.cell_mm
        return level_surface(box, self.lowest_mm, self.cell_mm)


def _with_toes_bridged(mesh: Mesh, across: _BallPlane, asked: ToeBridge) -> Mesh:
    """The foot with its gaps closed beyond a plane.

    Raises:
        EditError: it does not reach beyond it, or is open there.
    """
    gap_mm = asked.gap_mm
    radius_mm = 0.5 * gap_mm
    cell_mm = min(radius_mm / _CELLS_PER_RADIUS, _COARSEST_MM)
    toes = across.toe_vertices(mesh, 0.0)
    if not toes.any():
        raise EditError("edit.toe_bridge.no_toes")
    along = across.along_mm(mesh.vertices_mm)
    behind = keep_positive(mesh, np.where(toes, -along, np.maximum(np.abs(along), ON_CUT_MM))).mesh
    one = _open_edge_at(behind, across, 0.0)
    seen = across.in_foot_axes(mesh)
    near = seen.vertices_mm[across.toe_vertices(mesh, -1.5 * gap_mm)]
    grid = _Grid.round(near, radius_mm + 2 * cell_mm, cell_mm)
    field = _ClosedFoot.of(SignedSurface(seen.vertices_mm, seen.faces), grid, radius_mm)
    level = refine(grid.positive_surface(-field.on_grid), _EDGE_CELLS * cell_mm)
    beyond = level.vertices_mm[:, 1]
    rough = keep_positive(level, beyond + 2 * cell_mm).mesh  # without the grid's own border
    settled = rough.with_vertices(_moved_to_level(field, rough.vertices_mm, cell_mm))
    beyond = settled.vertices_mm[:, 1]
    anew = across.in_mesh_axes(
        largest_piece(keep_positive(settled, beyond - _STRIP_CELLS * cell_mm).mesh)[0]
    )
    two = _open_edge_at(anew, across, _STRIP_CELLS * cell_mm)[::-1]
    between = strip(behind.vertices_mm[one], anew.vertices_mm[two])
    like = np.asarray(KDTree(behind.vertices_mm).query(anew.vertices_mm)[1], np.int64)
    numbers = np.concatenate([one, len(behind) + two])
    faces = np.concatenate([anew.faces + len(behind), numbers[between]]).astype(np.int32)
    whole = with_surface_added(behind, anew.vertices_mm, like, faces)
    return _with_measurements_kept(whole, mesh, len(behind))


def _moved_to_level(field: _ClosedFoot, points_mm: Points3, cell_mm: float) -> Points3:
    """Points moved to the level by Newton's method, each step less than a cell."""
    places = points_mm.copy()
    for _ in range(_NEWTON_STEPS):
        values, gradients = field.at(places)
        if np.abs(values).max() < _ON_LEVEL_MM:
            break
        places -= np.clip(values, -0.5 * cell_mm, 0.5 * cell_mm)[:, None] * gradients
    return places


def _open_edge_at(mesh: Mesh, across: _BallPlane, along_mm: float) -> Int64[np.ndarray, " k"]:
    """The only open edge at a distance along the foot.

    Raises:
        EditError: there are several: toes that part before the plane, or a hole.
    """
    off = np.abs(across.along_mm(mesh.vertices_mm) - along_mm)
    found = [loop for loop in boundary_loops(mesh.faces) if (off[loop] < ON_CUT_MM).any()]
    if len(found) != 1 or not (off[found[0]] < ON_CUT_MM).all():
        x, y, z = across.through_mm.tolist()
        raise EditError("edit.toe_bridge.parted", point_mm=(x, y, z))
    return found[0].astype(np.int64)


def _with_measurements_kept(whole: Mesh, before: Mesh, kept: int) -> Mesh:
    """The new foot with its measurements kept where its surface lies on the original one."""
    places = whole.vertices_mm[kept:]
    there = tree_on(before).closest(places).distances_mm < _FILLED_MM
    like = np.asarray(KDTree(before.vertices_mm).query(places)[1], np.int64)
    known = unmeasured_at(select_vertices(before, like), ~there)
    again: dict[str, np.ndarray] = {}
    for name, one in VERTEX_FIELDS.items():
        values, new = getattr(whole, name), getattr(known, name)
        if one.kind != "colour" and values is not None:  # its colours go on with the foot's
            again[name] = np.concatenate([values[:kept], new])
    return replace(whole, **again)
