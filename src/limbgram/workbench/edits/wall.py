"""Wall: a second surface at a thickness from the first, joined to it at the brim."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.mesh.mesh import Mesh, lengths, unit
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    boundary_loops,
    edge_lengths,
    face_components,
    find_edges,
    with_any,
    with_faces,
)
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.edits.clearance import Clearance
from limbgram.workbench.edits.cover import covered
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.edit import AboveZeroMm, Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.guard import require_sound, spoilt_vertices
from limbgram.workbench.edits.level_edges import Plane, planes_of
from limbgram.workbench.edits.offset import Offsetting, require_not_turned
from limbgram.workbench.edits.regions import (
    averaging,
    with_added,
)
from limbgram.workbench.edits.thickness import Thickness, between_skins, narrow_strip, thin_lip
from limbgram.workbench.limb import Limb

_RETRIES = 5
"""Times that a wall is evened out where it would cut through itself."""
_TRIMMINGS, _MOST_TRIMMED = 12, 0.03
"""Times that a ragged open edge is trimmed, and the most of the area that it may lose."""
_ROW, _DEEPER, _EVENED = 1.0, 1 / 3, 3
"""Edges of a usual triangle by which it is trimmed at first, by how many more each later time, and
how often the distances from it are evened out, so that the new edge is smooth."""
_TOOTH = np.radians(75)
"""A corner of the open edge that is sharper than this is a tooth, and would end in a lip."""
_THINNER_MM, _FILLED = 0.05, 1.05
"""A wall that is thinner than asked by more than this somewhere is made anew, by a level; what is
thicker by more than the second one, a factor, is told."""
LEAST_WALL_MM = 1.0
"""A free-standing wall that printers of every kind make: two beads of the usual nozzles (0.8 to
1.2 mm), and what makers ask for powder (sintered or fused nylon) and resin. It says nothing of
strength: sockets are made, and were studied, from 2 mm on."""
_STUDIED_MM = 2.0
"""The thinnest socket of P. Lenka, A. Choudhury, J Biomed Sci Eng 4, 2011, 762-768, who found 3 mm
of laminate best."""
_LEVEL_MM = 0.05
"""A brim that leaves the plane in which it was cut by less is told as level."""
_ROUNDING = 1 - 1e-6
"""A wall that is as thick as its least is not refused for a rounding."""


@edit(
    group="solids",
    order=2,
    effect=Effect(reports_displacement=False, volume="becomes", start="anew"),
    everyday=True,
    rarely=("least_mm",),
    guarded=False,
    example={"thickness_mm": 4.0},
)
class Wall(Edit):
    """Make a solid: a second surface at the wall's thickness, joined to the first at the brim."""

    thickness_mm: float
    """Of the wall, all over."""
    side: Literal["outward", "inward"] = "outward"
    """On which side of the surface the wall lies: outward for a socket over the shape."""
    least_mm: AboveZeroMm = LEAST_WALL_MM
    """Thinner than this nowhere: the wall is refused if it is, as a ragged brim can make it."""

    words = spoken(
        en=Words(
            name="Make a wall",
            title="The wall",
            labels={"side": "On which side", "least_mm": "Thinnest place"},
            choices={"outward": "outside", "inward": "inside"},
        ),
        de=Words(
            name="Wand machen",
            title="Die Wand",
            does="Einen Körper machen: eine zweite Fläche in der Dicke der Wand, am Rand mit der "
            "ersten verbunden.",
            labels={
                "thickness_mm": "Dicke",
                "side": "Auf welcher Seite",
                "least_mm": "Dünnste Stelle",
            },
            help={
                "thickness_mm": "Der Wand, überall.",
                "side": "Auf welcher Seite der Fläche die Wand liegt: außen für einen Schaft über "
                "der Form.",
                "least_mm": "Nirgends dünner als dies: sonst wird die Wand abgelehnt; ein zackiger "
                "Rand kann dazu führen.",
            },
            choices={"outward": "außen", "inward": "innen"},
        ),
    )

    def check(self) -> None:
        """Refuse a thickness that no wall has.

        Raises:
            EditError: it is thinner than the least that is asked for.
        """
        if not self.thickness_mm >= self.least_mm:
            raise EditError(
                "edit.wall.thickness_asked",
                least_mm=self.least_mm,
                thickness_mm=self.thickness_mm,
            )

    def apply(self, limb: Limb) -> Limb:
        """Give the surface a thickness; the result is watertight.

        Raises:
            EditError: the shape is closed already, or the wall would cut through itself, or be
                thinner somewhere than its least.
        """
        mesh = limb.mesh
        border = boundary_half_edges(mesh.faces)
        parts = face_components(mesh.faces)
        if len(np.unique(parts[_faces_at(mesh, border)])) <= int(parts.max()):
            raise EditError("edit.wall.closed")
        made = _made(mesh, self)
        if made.refusal is not None:
            raise made.refusal
        return replace(limb, mesh=made.solid, notes=(*limb.notes, *made.notes))


def require_thickness_kept(edit: Wall, found: Thickness | None) -> None:
    """Refuse what later edits made of a wall, if it is thinner than the wall's least.

    Raises:
        EditError: says where.
    """
    if found is not None and found.thinnest_mm < _ROUNDING * edit.least_mm:
        raise EditError(
            "edit.wall.thinned",
            thinnest_mm=found.thinnest_mm,
            point_mm=found.point_mm,
            median_mm=found.median_mm,
            least_mm=edit.least_mm,
        )


def _faces_at(mesh: Mesh, border: np.ndarray) -> np.ndarray:
    """Faces with a vertex on an open edge."""
    rim = np.zeros(len(mesh), np.bool_)
    rim[border] = True
    return np.asarray(rim[mesh.faces].any(1))


@dataclass(frozen=True)
class _Tried:
    """A wall, and why it cannot be left so."""

    solid: Mesh
    spoilt: Bool[np.ndarray, " n"]
    """Vertices of the given skin where it cannot."""
    thinnest_mm: float
    refusal: EditError | None
    notes: tuple[Finding, ...] = ()


def _made(mesh: Mesh, edit: Wall) -> _Tried:
    """The wall, by the way that keeps its thickness best.

    The given skin moved is the quickest, and right where it bends less tightly than the wall is
    thick. A level of the distance is right everywhere.
    """
    planes = planes_of(mesh)
    moved = _moved(mesh, edit, planes)
    if moved.refusal is None and moved.thinnest_mm >= edit.thickness_mm - _THINNER_MM:
        return moved
    levelled = _levelled(mesh, edit, planes)
    return moved if levelled.refusal is not None and moved.refusal is None else levelled


def _levelled(mesh: Mesh, edit: Wall, planes: tuple[Plane, ...]) -> _Tried:
    """The wall by a level, of as much of a surface as its open edges allow.

    These are trimmed where they are spoilt, until a wall is made or no more may go.
    """
    whole_mm2 = mesh.area_mm2()
    tried = _covered(mesh, edit, planes)
    for number in range(_TRIMMINGS):
        if tried.refusal is None:
            break
        trimmed = _trimmed(mesh, _ragged_first(mesh, tried.spoilt), rows=_ROW + number * _DEEPER)
        if trimmed is None or trimmed.area_mm2() < (1 - _MOST_TRIMMED) * whole_mm2:
            break
        mesh = trimmed
        tried = _covered(mesh, edit, planes)
    left_mm2 = whole_mm2 - mesh.area_mm2()
    if tried.refusal is not None or not left_mm2 > 0:
        return tried
    left_out = note("edit.wall.trimmed", area_mm2=left_mm2)
    return replace(tried, notes=(left_out, *tried.notes))


def _ragged_first(mesh: Mesh, spoilt: Bool[np.ndarray, " n"]) -> Bool[np.ndarray, " n"]:
    """What is spoilt of ragged open edges; if nothing is, all that is spoilt.

    So an edge that was cut level is trimmed last.
    """
    ragged = np.zeros(len(mesh), np.bool_)
    for loop in boundary_loops(mesh.faces):
        if Plane.of_loop(mesh, loop.astype(np.int64)) is None:
            ragged[loop] = True
    first = spoilt & ragged
    return first if first.any() else spoilt


def _moved(mesh: Mesh, edit: Wall, planes: tuple[Plane, ...]) -> _Tried:
    """The wall whose second skin is the first one moved, evened out where it would cut through
    itself. A brim that was cut level stays level."""
    border = boundary_half_edges(mesh.faces)
    sign = 1.0 if edit.side == "outward" else -1.0
    distance_mm = np.full(len(mesh), sign * edit.thickness_mm)
    offsetting = Offsetting(mesh, planes)
    found = offsetting.by_places(distance_mm, None)
    wall = _between(mesh, found.mesh, border, sign)
    spoilt = spoilt_vertices(mesh, wall.solid)
    ease = np.zeros(len(mesh), np.bool_)
    for _ in range(_RETRIES):
        at = wall.on_skin(spoilt)
        at[mesh.faces[found.turned]] = True
        if not at.any():
            break
        ease |= at
        for _ in range(2):
            ease[mesh.faces[ease[mesh.faces].any(1)]] = True
        last = wall.solid
        found = offsetting.by_places(distance_mm, ease)
        wall = _between(mesh, found.mesh, border, sign)
        changed = (wall.solid.vertices_mm != last.vertices_mm).any(1)
        spoilt = spoilt_vertices(mesh, wall.solid, spoilt | changed)
    tried = _thick_enough(mesh, edit, wall)
    try:
        require_not_turned(mesh, found, sign * edit.thickness_mm)
    except EditError as error:
        tried = replace(tried, refusal=error)
    tried = _require_sound(mesh, wall, tried)
    return replace(tried, notes=(*tried.notes, *_aslant(mesh, planes, wall)))


def _covered(mesh: Mesh, edit: Wall, planes: tuple[Plane, ...]) -> _Tried:
    """The wall whose second skin lies over the first one, or under it, as far from it as asked."""
    upwards = mesh if edit.side == "outward" else replace(mesh, faces=mesh.faces[:, ::-1])
    try:
        found = covered(Clearance(upwards, edit.thickness_mm), planes)
    except EditError as error:
        return _Tried(mesh, np.zeros(len(mesh), np.bool_), 0.0, error)
    like = np.concatenate([np.arange(len(mesh)), found.like])
    solid = _told(mesh, found.solid, found.like)
    wall = _Solid(solid, like, len(mesh.faces), found.over)
    tried = _finished(mesh, edit, wall)
    return replace(tried, notes=(*tried.notes, *_aslant(mesh, planes, wall)))


def _trimmed(mesh: Mesh, spoilt: Bool[np.ndarray, " n"], rows: float) -> Mesh | None:
    """The surface cut along a smooth line so many triangles behind its open edge, where that is
    spoilt; None where the spoilt places do not lie at an open edge.

    No tooth is left near there, and nothing that hangs by a corner.
    """
    near = spoilt.copy()
    for _ in range(2):
        near[mesh.faces[with_any(near, mesh.faces)]] = True
    at = np.zeros(len(mesh), np.bool_)
    at[boundary_half_edges(mesh.faces)] = True
    at &= near
    if not at.any():
        return None
    ends = find_edges(mesh.faces).ends
    sizes_mm = edge_lengths(mesh.vertices_mm, ends)
    depth_mm = rows * float(np.median(sizes_mm))
    farthest_mm = 3 * depth_mm
    links = csr_array((sizes_mm, (ends[:, 0], ends[:, 1])), shape=(len(mesh), len(mesh)))
    away_mm: Float64[np.ndarray, " n"] = np.minimum(
        dijkstra(
            links, directed=False, indices=np.flatnonzero(at), min_only=True, limit=farthest_mm
        ),
        farthest_mm,
    )
    mean = averaging(mesh)
    for _ in range(_EVENED):
        away_mm = mean @ away_mm
    cut = keep_positive(mesh, away_mm - depth_mm).mesh
    around = KDTree(mesh.vertices_mm[at]).query(cut.vertices_mm)[0] < farthest_mm
    faces = cut.faces
    while True:
        starts = np.bincount(boundary_half_edges(faces)[:, 0], minlength=len(cut))
        angles = _corner_angles(cut.vertices_mm[faces])
        opening = np.bincount(faces.ravel(), angles.ravel(), len(cut))
        tooth = (starts > 1) | ((starts == 1) & around & (opening < _TOOTH))
        if not tooth.any():
            break
        faces = faces[~with_any(tooth, faces)]
    parts = face_components(faces)
    kept = parts == np.bincount(parts).argmax()
    return with_faces(cut, faces[kept])


def _corner_angles(corners: Float64[np.ndarray, "f 3 3"]) -> Float64[np.ndarray, "f 3"]:
    """In radians."""
    ways = unit((np.roll(corners, -1, axis=1) - corners).reshape(-1, 3)).reshape(corners.shape)
    return np.arccos(np.clip(-(ways * np.roll(ways, 1, axis=1)).sum(2), -1.0, 1.0))


@dataclass(frozen=True)
class _Solid:
    """A wall: two skins and what joins them."""

    solid: Mesh
    like: Int64[np.ndarray, " n"]
    """For each of its vertices one of the given skin."""
    ones: int
    twos: int
    """Faces of its first skin, and of the second one; the rest is the rim."""

    @cached_property
    def thickness(self) -> Thickness:
        return between_skins(self.solid, self.ones, self.twos)

    def on_skin(self, vertices: Bool[np.ndarray, " n"]) -> Bool[np.ndarray, " k"]:
        """Which vertices of the given skin these belong to."""
        found = np.zeros(int(self.like.max()) + 1, np.bool_)
        found[self.like[vertices]] = True
        return found


def _between(mesh: Mesh, other: Mesh, border: np.ndarray, sign: float) -> _Solid:
    """The surface and its offset, joined along the open edges."""
    outer, inner = (other, mesh) if sign > 0 else (mesh, other)
    count = len(mesh)
    a, b = border[:, 0], border[:, 1]
    rim = np.concatenate(
        [np.column_stack([b, a, a + count]), np.column_stack([b, a + count, b + count])]
    )
    faces = np.concatenate([inner.faces[:, ::-1] + count, rim]).astype(np.int32)
    same = np.arange(count)
    solid = _told(mesh, with_added(outer, inner.vertices_mm, same, faces), same)
    return _Solid(solid, np.concatenate([same, same]), len(mesh.faces), len(mesh.faces))


def _told(mesh: Mesh, solid: Mesh, like: Int64[np.ndarray, " k"]) -> Mesh:
    """A wall whose second skin and rim are told to be as sure as what they are like."""
    known = mesh.of_vertices(lambda _, values: np.concatenate([values, values[like]]))
    return replace(solid, **known)


def _require_sound(mesh: Mesh, wall: _Solid, tried: _Tried) -> _Tried:
    """The same, refused where it folds or passes through itself."""
    try:
        require_sound(mesh, wall.solid)
    except EditError as error:
        spoilt = wall.on_skin(spoilt_vertices(mesh, wall.solid))
        return replace(tried, spoilt=spoilt | tried.spoilt, refusal=error)
    return tried


def _finished(mesh: Mesh, edit: Wall, wall: _Solid) -> _Tried:
    """The wall by a level, with all that there is to say of it."""
    tried = _require_sound(mesh, wall, _thick_enough(mesh, edit, wall))
    tried = _require_joined(wall, tried)
    return replace(tried, notes=(*tried.notes, *_thick_places(mesh, edit, wall)))


def _require_joined(wall: _Solid, tried: _Tried) -> _Tried:
    """The same, refused where its skins are not joined."""
    left = boundary_half_edges(wall.solid.faces)
    if tried.refusal is not None or not len(left):
        return tried
    open_edge = np.zeros(len(wall.solid), np.bool_)
    open_edge[left] = True
    refusal = EditError(
        "edit.wall.unjoined",
        open_edges=len(left),
        point_mm=tuple(wall.solid.vertices_mm[left[0, 0]].tolist()),
    )
    return replace(tried, spoilt=wall.on_skin(open_edge) | tried.spoilt, refusal=refusal)


def _require_no_lips(edit: Wall, wall: _Solid, tried: _Tried) -> _Tried:
    """The same, refused where its brim runs out thin."""
    lip = thin_lip(wall.solid, wall.ones + wall.twos, edit.least_mm)
    if lip is None:
        return tried
    at = np.zeros(len(wall.solid), np.bool_)
    at[wall.solid.faces[lip.faces]] = True
    refusal = EditError(
        "edit.wall.lip",
        thickness_mm=lip.thickness_mm,
        point_mm=tuple(lip.place_mm.tolist()),
        least_mm=edit.least_mm,
    )
    return replace(tried, spoilt=wall.on_skin(at) | tried.spoilt, refusal=refusal)


def _thick_enough(mesh: Mesh, edit: Wall, wall: _Solid) -> _Tried:
    """The wall, if it is thick enough everywhere, with a note of where it is thinnest."""
    found = wall.thickness
    below = found.at_vertices_mm < _ROUNDING * edit.least_mm
    tried = _Tried(wall.solid, wall.on_skin(below), found.thinnest_mm, None)
    tried = _require_no_lips(edit, wall, tried)
    if below.any():
        edge = mesh.vertices_mm[np.unique(boundary_half_edges(mesh.faces))]
        thinnest = wall.like[np.nanargmin(found.at_vertices_mm)]
        away_mm = lengths(edge - mesh.vertices_mm[thinnest]).min()
        refusal = EditError(
            "edit.wall.thin",
            thinnest_mm=found.thinnest_mm,
            point_mm=found.point_mm,
            median_mm=found.median_mm,
            least_mm=edit.least_mm,
            near_edge=bool(away_mm < edit.thickness_mm),
        )
        tried = replace(tried, refusal=refusal)
    if tried.refusal is not None:
        return tried
    notes = [found.told("file")]
    if found.thinnest_mm < _STUDIED_MM:
        notes.append(doubt("edit.wall.unstudied", least_mm=_STUDIED_MM))
    strip = narrow_strip(wall.solid, wall.ones + wall.twos, edit.thickness_mm - _THINNER_MM)
    if strip is not None:
        place = tuple(strip.place_mm.tolist())
        notes.append(doubt("edit.wall.narrow", width_mm=strip.thickness_mm, point_mm=place))
    return replace(tried, notes=tuple(notes))


def _aslant(mesh: Mesh, planes: tuple[Plane, ...], wall: _Solid) -> list[Finding]:
    """A note of how far the brim leaves the planes in which the open edges lie."""
    border = np.unique(boundary_half_edges(mesh.faces)).astype(np.int64)
    rim = np.unique(wall.solid.faces[wall.ones + wall.twos :])
    rim_like = wall.like[rim]
    off_mm = 0.0
    for plane in planes:
        at_edge = np.zeros(len(mesh), np.bool_)
        at_edge[border] = plane.holds(mesh.vertices_mm[border])
        leaving_mm = np.abs(plane.above_mm(wall.solid.vertices_mm[rim[at_edge[rim_like]]]))
        off_mm = max(off_mm, float(leaving_mm.max(initial=0.0)))
    return [] if off_mm < _LEVEL_MM else [note("edit.wall.aslant", off_mm=off_mm)]


def _thick_places(mesh: Mesh, edit: Wall, wall: _Solid) -> list[Finding]:
    """A note of where a wall is thicker than asked, as where the shape is too narrow for two."""
    deep_mm = wall.thickness.at_vertices_mm[: len(mesh)]
    thick = deep_mm > _FILLED * edit.thickness_mm
    if not thick.any():
        return []
    point_mm = tuple(mesh.vertices_mm[int(deep_mm.argmax())].tolist())
    area_mm2 = float(mesh.vertex_areas_mm2()[thick].sum())
    return [note("edit.wall.solid", area_mm2=area_mm2, point_mm=point_mm)]
