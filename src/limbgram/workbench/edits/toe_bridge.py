"""Toe bridge: gaps between the toes closed, as the plaster of a cast or a sock's toe cap does.

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
    taking_vertices,
    unmeasured_at,
)
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.core.request_fields import Within
from limbgram.reconstruction.surface.resampling import refine
from limbgram.workbench.anatomy.kind import Mid
from limbgram.workbench.edits.cutting import ON_IT_MM, keep_positive
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.regions import with_added
from limbgram.workbench.edits.triangle_strip import strip
from limbgram.workbench.limb import Limb

_CELLS = 4.0
"""Cells of the grid across half of the gap."""
_COARSEST_MM = 2.0
_EDGE = 0.85
"""Of a cell: edges of the triangles."""
_DIGITS = 6
"""Of millimetres, to which the grid and its values are rounded: how triangles are made even on a
grid hangs on ties, which the rounding of a turned scan would decide otherwise."""
_MOVES, _LEVEL_MM = 6, 2e-3
"""Times that vertices are moved to the level, and how near counts as on it."""
_STRIP = 1.5
"""Cells between the foot as it was and what is made anew."""
_STAYS_MM = 0.02
"""The closed surface yields to the foot's own by so much, so that this stays where it was."""
_FILLED_MM = 0.1
"""What lies farther from the foot as it was is filled."""


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

    def apply(self, limb: Limb) -> Limb:
        """Make the foot anew beyond the metatarsal heads, its gaps closed.

        Raises:
            EditError: a landmark is missing, or the foot ends, or is open, before its toes.
        """
        try:
            up = limb.anatomy.axis("plantar").direction
            forward = limb.anatomy.axis("foot").direction
            first, fifth, toe = (
                limb.anatomy.at(Mid((name,)))
                for name in ("first metatarsal head", "fifth metatarsal head", "second toe")
            )
        except MeasureError as error:
            reason = error.finding
            raise EditError("edit.repose.not_told", reason=reason) from error
        across = _Across.of(first, fifth, toe, up, forward)
        return limb.with_mesh(_bridged(limb.mesh, across, self))


@dataclass(frozen=True)
class _Across:
    """The plane across both metatarsal heads."""

    through_mm: Vector3
    axes: Matrix3
    """Rows: lateral, ahead, up; a mirror too, on one of the feet."""
    toe_mm: Vector3

    @classmethod
    def of(
        cls, first_mm: Vector3, fifth_mm: Vector3, toe_mm: Vector3, up: Vector3, forward: Vector3
    ) -> "_Across":
        ahead = np.cross(first_mm - fifth_mm, up)
        ahead = unit((ahead * np.sign(ahead @ forward))[None])[0]
        lateral = np.cross(ahead, up)
        lateral *= np.sign(lateral @ (fifth_mm - first_mm))
        return cls(first_mm, np.stack([lateral, ahead, up]), toe_mm)

    def along_mm(self, points_mm: Points3) -> Float64[np.ndarray, " n"]:
        return (points_mm - self.through_mm) @ self.axes[1]

    def seen(self, mesh: Mesh) -> Mesh:
        """A surface in the foot's own axes."""
        return self._turned(mesh, (mesh.vertices_mm - self.through_mm) @ self.axes.T)

    def back(self, mesh: Mesh) -> Mesh:
        """A surface in the foot's own axes where the foot lies."""
        return self._turned(mesh, mesh.vertices_mm @ self.axes + self.through_mm)

    def _turned(self, mesh: Mesh, vertices_mm: Points3) -> Mesh:
        mirrored = np.linalg.det(self.axes) < 0
        faces = np.ascontiguousarray(mesh.faces[:, ::-1]) if mirrored else mesh.faces
        return Mesh(vertices_mm=vertices_mm, faces=faces)

    def of_toes(self, mesh: Mesh, from_mm: float) -> Bool[np.ndarray, " n"]:
        """Vertices beyond a plane so far along, without a knee that reaches beyond it too."""
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
class _Closed:
    """The function whose level is the foot with its gaps closed; negative inside."""

    foot: SignedSurface
    grown: SignedSurface
    radius_mm: float

    @classmethod
    def of(cls, foot: SignedSurface, grid: "_Grid", radius_mm: float) -> "_Closed":
        away_mm = foot.signed(grid.points_mm).signed_mm
        grown = grid.level(radius_mm - away_mm)
        return cls(foot, SignedSurface(grown.vertices_mm, grown.faces), radius_mm)

    def at(self, points_mm: Points3) -> tuple[Float64[np.ndarray, " n"], Points3]:
        """Values, and the ways in which they grow fastest."""
        own, grown = self.foot.signed(points_mm), self.grown.signed(points_mm)
        values = np.stack([own.signed_mm, grown.signed_mm + self.radius_mm + _STAYS_MM])
        nearest = np.stack([own.points_mm, grown.points_mm])
        away = np.stack([own.signed_mm, grown.signed_mm])
        normals = np.stack([own.normals, grown.normals])
        least, rows = values.argmin(0), np.arange(len(points_mm))
        off = away[least, rows]
        steady = np.abs(off) > 1e-6
        ways = normals[least, rows]
        ways[steady] = ((points_mm - nearest[least, rows])[steady]) / off[steady, None]
        return values[least, rows], ways


@dataclass(frozen=True)
class _Grid:
    lowest_mm: Vector3
    cell_mm: float
    counts: tuple[int, int, int]

    @classmethod
    def round(cls, points_mm: Points3, margin_mm: float, cell_mm: float) -> "_Grid":
        low, high = points_mm.min(0) - margin_mm, points_mm.max(0) + margin_mm
        low, high = np.round(low, _DIGITS), np.round(high, _DIGITS)
        x, y, z = (np.ceil((high - low) / cell_mm).astype(int) + 1).tolist()
        return cls(low, cell_mm, (x, y, z))

    @property
    def points_mm(self) -> Points3:
        return self.lowest_mm + self.cell_mm * np.indices(self.counts).reshape(3, -1).T

    def level(self, values: Float64[np.ndarray, " n"]) -> Mesh:
        """Round the places above zero; cut straight at the grid's border."""
        box = np.round(values, _DIGITS).reshape(self.counts)
        for axis in range(3):
            for end in (0, -1):
                box[tuple(end if k == axis else slice(None) for k in range(3))] = -self.cell_mm
        return level_surface(box, self.lowest_mm, self.cell_mm)


def _bridged(mesh: Mesh, across: _Across, asked: ToeBridge) -> Mesh:
    """The foot with its gaps closed beyond a plane.

    Raises:
        EditError: it does not reach beyond it, or is open there.
    """
    gap_mm = asked.gap_mm
    radius_mm = 0.5 * gap_mm
    cell_mm = min(radius_mm / _CELLS, _COARSEST_MM)
    toes = across.of_toes(mesh, 0.0)
    if not toes.any():
        raise EditError("edit.toe_bridge.no_toes")
    seen = across.seen(mesh)
    near = seen.vertices_mm[across.of_toes(mesh, -1.5 * gap_mm)]
    grid = _Grid.round(near, radius_mm + 2 * cell_mm, cell_mm)
    field = _Closed.of(SignedSurface(seen.vertices_mm, seen.faces), grid, radius_mm)
    level = refine(grid.level(-field.at(grid.points_mm)[0]), _EDGE * cell_mm)
    beyond = level.vertices_mm[:, 1]
    rough = keep_positive(level, beyond + 2 * cell_mm).mesh  # without the grid's own border
    settled = rough.with_vertices(_settled(field, rough.vertices_mm, cell_mm))
    beyond = settled.vertices_mm[:, 1]
    anew = across.back(largest_piece(keep_positive(settled, beyond - _STRIP * cell_mm).mesh)[0])
    along = across.along_mm(mesh.vertices_mm)
    behind = keep_positive(mesh, np.where(toes, -along, np.maximum(np.abs(along), ON_IT_MM))).mesh
    one, two = _edge(behind, across, 0.0), _edge(anew, across, _STRIP * cell_mm)[::-1]
    between = strip(behind.vertices_mm[one], anew.vertices_mm[two])
    like = np.asarray(KDTree(behind.vertices_mm).query(anew.vertices_mm)[1], np.int64)
    numbers = np.concatenate([one, len(behind) + two])
    faces = np.concatenate([anew.faces + len(behind), numbers[between]]).astype(np.int32)
    whole = with_added(behind, anew.vertices_mm, like, faces)
    return _known_again(whole, mesh, len(behind))


def _settled(field: _Closed, points_mm: Points3, cell_mm: float) -> Points3:
    """Places moved to the level, by Newton's method, each by less than a cell at once."""
    places = points_mm.copy()
    for _ in range(_MOVES):
        values, ways = field.at(places)
        if np.abs(values).max() < _LEVEL_MM:
            break
        places -= np.clip(values, -0.5 * cell_mm, 0.5 * cell_mm)[:, None] * ways
    return places


def _edge(mesh: Mesh, across: _Across, along_mm: float) -> Int64[np.ndarray, " k"]:
    """The one open edge that lies so far along.

    Raises:
        EditError: there are several: toes that part before the plane, or a hole.
    """
    off = np.abs(across.along_mm(mesh.vertices_mm) - along_mm)
    found = [loop for loop in boundary_loops(mesh.faces) if (off[loop] < ON_IT_MM).any()]
    if len(found) != 1 or not (off[found[0]] < ON_IT_MM).all():
        x, y, z = across.through_mm.tolist()
        raise EditError("edit.toe_bridge.parted", point_mm=(x, y, z))
    return found[0].astype(np.int64)


def _known_again(whole: Mesh, before: Mesh, kept: int) -> Mesh:
    """With what was known of the foot where what was made anew lies on it as it was."""
    places = whole.vertices_mm[kept:]
    there = tree_on(before).closest(places).distances_mm < _FILLED_MM
    like = np.asarray(KDTree(before.vertices_mm).query(places)[1], np.int64)
    known = unmeasured_at(taking_vertices(before, like), ~there)
    again: dict[str, np.ndarray] = {}
    for name, one in VERTEX_FIELDS.items():
        values, new = getattr(whole, name), getattr(known, name)
        if one.kind != "colour" and values is not None:  # its colours go on with the foot's
            again[name] = np.concatenate([values[:kept], new])
    return replace(whole, **again)
