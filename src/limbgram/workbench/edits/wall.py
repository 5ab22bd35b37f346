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
    faces_touching,
    find_edges,
    with_faces,
)
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.edits.clearance import Clearance
from limbgram.workbench.edits.cover import cover_skin
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.edit import AboveZeroMm, Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.guard import require_sound, unsound_vertices
from limbgram.workbench.edits.level_edges import Plane, open_edge_planes
from limbgram.workbench.edits.offset import Offsetter, require_not_turned
from limbgram.workbench.edits.regions import (
    neighbour_averaging,
    with_surface_added,
)
from limbgram.workbench.edits.thickness import (
    Thickness,
    narrow_strip,
    thickness_between_skins,
    thin_lip,
)
from limbgram.workbench.limb import Limb

_RETRIES = 5
"""How often a wall is smoothed where it would cut through itself."""
_TRIM_ROUNDS, _MOST_TRIMMED = 12, 0.03
"""How often a ragged open edge is trimmed, and the greatest share of area that it may lose."""
_FIRST_TRIM_EDGES, _MORE_TRIM_EDGES, _TRIM_SMOOTHINGS = 1.0, 1 / 3, 3
"""Depth of the first trim in median edges, by how many more each later one is deeper, and how often
the distances from the edge are averaged, so that the new edge is smooth."""
_TOOTH_RAD = np.radians(75)
"""A corner of the open edge that is sharper than this is a tooth, and would end in a lip."""
_THINNER_MM, _THICKER_FACTOR = 0.05, 1.05
"""A wall that is thinner than asked by more than this somewhere is made anew, as a level surface;
where it is thicker by more than this factor, a note says so."""
LEAST_WALL_MM = 1.0
"""A free-standing wall that printers of every kind make: two beads of the usual nozzles (0.8 to
1.2 mm), and what makers ask for powder (sintered or fused nylon) and resin. It says nothing of
strength: sockets are made, and were studied, from 2 mm on."""
_STUDIED_MM = 2.0
"""The thinnest socket of P. Lenka, A. Choudhury, J Biomed Sci Eng 4, 2011, 762-768, who found 3 mm
of laminate best."""
_LEVEL_TOLERANCE_MM = 0.05
"""A brim that leaves the plane of its cut by less counts as level."""
_ROUNDING_FACTOR = 1 - 1e-6
"""Allows for rounding, so that a wall exactly as thick as its least is not refused."""


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
        if len(np.unique(parts[_faces_at_open_edge(mesh, border)])) <= int(parts.max()):
            raise EditError("edit.wall.closed")
        made = _best_wall(mesh, self)
        if made.refusal is not None:
            raise made.refusal
        return replace(limb, mesh=made.solid, notes=(*limb.notes, *made.notes))


def require_thickness_kept(edit: Wall, found: Thickness | None) -> None:
    """Refuse a wall that later edits made thinner than its least.

    Raises:
        EditError: says where.
    """
    if found is not None and found.thinnest_mm < _ROUNDING_FACTOR * edit.least_mm:
        raise EditError(
            "edit.wall.thinned",
            thinnest_mm=found.thinnest_mm,
            point_mm=found.point_mm,
            median_mm=found.median_mm,
            least_mm=edit.least_mm,
        )


def _faces_at_open_edge(mesh: Mesh, border: np.ndarray) -> np.ndarray:
    """Faces with a vertex on an open edge."""
    rim = np.zeros(len(mesh), np.bool_)
    rim[border] = True
    return np.asarray(rim[mesh.faces].any(1))


@dataclass(frozen=True)
class _Attempt:
    """A wall that was tried, and the reason to refuse it, if there is one."""

    solid: Mesh
    unsound: Bool[np.ndarray, " n"]
    """Vertices of the given skin at which it is refused."""
    thinnest_mm: float
    refusal: EditError | None
    notes: tuple[Finding, ...] = ()


def _best_wall(mesh: Mesh, edit: Wall) -> _Attempt:
    """The wall, by the method that keeps its thickness best.

    Offsetting the skin is quickest, and right where its radius of curvature is larger than the
    thickness. A level surface of the distance is right everywhere.
    """
    planes = open_edge_planes(mesh)
    moved = _wall_by_offset(mesh, edit, planes)
    if moved.refusal is None and moved.thinnest_mm >= edit.thickness_mm - _THINNER_MM:
        return moved
    levelled = _wall_by_cover(mesh, edit, planes)
    return moved if levelled.refusal is not None and moved.refusal is None else levelled


def _wall_by_cover(mesh: Mesh, edit: Wall, planes: tuple[Plane, ...]) -> _Attempt:
    """The wall as a level surface, over as much of the skin as its open edges allow.

    They are trimmed where the wall is unsound, until it is sound or no more may be lost.
    """
    whole_mm2 = mesh.area_mm2()
    attempt = _cover_attempt(mesh, edit, planes)
    for number in range(_TRIM_ROUNDS):
        if attempt.refusal is None:
            break
        trimmed = _with_edge_trimmed(
            mesh,
            _ragged_first(mesh, attempt.unsound),
            rows=_FIRST_TRIM_EDGES + number * _MORE_TRIM_EDGES,
        )
        if trimmed is None or trimmed.area_mm2() < (1 - _MOST_TRIMMED) * whole_mm2:
            break
        mesh = trimmed
        attempt = _cover_attempt(mesh, edit, planes)
    left_mm2 = whole_mm2 - mesh.area_mm2()
    if attempt.refusal is not None or not left_mm2 > 0:
        return attempt
    left_out = note("edit.wall.trimmed", area_mm2=left_mm2)
    return replace(attempt, notes=(left_out, *attempt.notes))


def _ragged_first(mesh: Mesh, unsound: Bool[np.ndarray, " n"]) -> Bool[np.ndarray, " n"]:
    """The unsound vertices on ragged open edges; if there are none, all unsound ones.

    So an edge that was cut level is trimmed last.
    """
    ragged = np.zeros(len(mesh), np.bool_)
    for loop in boundary_loops(mesh.faces):
        if Plane.of_loop(mesh, loop.astype(np.int64)) is None:
            ragged[loop] = True
    first = unsound & ragged
    return first if first.any() else unsound


def _wall_by_offset(mesh: Mesh, edit: Wall, planes: tuple[Plane, ...]) -> _Attempt:
    """The wall whose second skin is the first one offset, smoothed where it would cut through
    itself. A brim that was cut level stays level."""
    border = boundary_half_edges(mesh.faces)
    sign = 1.0 if edit.side == "outward" else -1.0
    distance_mm = np.full(len(mesh), sign * edit.thickness_mm)
    offsetting = Offsetter(mesh, planes)
    found = offsetting.by_vertex(distance_mm, None)
    wall = _joined_skins(mesh, found.mesh, border, sign)
    unsound = unsound_vertices(mesh, wall.solid)
    smooth_at = np.zeros(len(mesh), np.bool_)
    for _ in range(_RETRIES):
        at = wall.on_skin(unsound)
        at[mesh.faces[found.turned]] = True
        if not at.any():
            break
        smooth_at |= at
        for _ in range(2):
            smooth_at[mesh.faces[smooth_at[mesh.faces].any(1)]] = True
        last = wall.solid
        found = offsetting.by_vertex(distance_mm, smooth_at)
        wall = _joined_skins(mesh, found.mesh, border, sign)
        changed = (wall.solid.vertices_mm != last.vertices_mm).any(1)
        unsound = unsound_vertices(mesh, wall.solid, unsound | changed)
    attempt = _refused_if_thin(mesh, edit, wall)
    try:
        require_not_turned(mesh, found, sign * edit.thickness_mm)
    except EditError as error:
        attempt = replace(attempt, refusal=error)
    attempt = _refused_if_unsound(mesh, wall, attempt)
    return replace(attempt, notes=(*attempt.notes, *_slant_notes(mesh, planes, wall)))


def _cover_attempt(mesh: Mesh, edit: Wall, planes: tuple[Plane, ...]) -> _Attempt:
    """The wall whose second skin is a level surface of the distance from the first one."""
    upwards = mesh if edit.side == "outward" else replace(mesh, faces=mesh.faces[:, ::-1])
    try:
        found = cover_skin(Clearance(upwards, edit.thickness_mm), planes)
    except EditError as error:
        return _Attempt(mesh, np.zeros(len(mesh), np.bool_), 0.0, error)
    like = np.concatenate([np.arange(len(mesh)), found.like])
    solid = _with_vertex_fields(mesh, found.solid, found.like)
    wall = _WallSolid(solid, like, len(mesh.faces), found.cover_faces)
    attempt = _checked_cover(mesh, edit, wall)
    return replace(attempt, notes=(*attempt.notes, *_slant_notes(mesh, planes, wall)))


def _with_edge_trimmed(mesh: Mesh, unsound: Bool[np.ndarray, " n"], rows: float) -> Mesh | None:
    """The surface cut along a smooth curve some rows of triangles behind its unsound open edge;
    None where the unsound vertices do not lie at an open edge.

    No tooth is left near there, and nothing that hangs by a corner.
    """
    near = unsound.copy()
    for _ in range(2):
        near[mesh.faces[faces_touching(near, mesh.faces)]] = True
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
    mean = neighbour_averaging(mesh)
    for _ in range(_TRIM_SMOOTHINGS):
        away_mm = mean @ away_mm
    cut = keep_positive(mesh, away_mm - depth_mm).mesh
    around = KDTree(mesh.vertices_mm[at]).query(cut.vertices_mm)[0] < farthest_mm
    faces = cut.faces
    while True:
        starts = np.bincount(boundary_half_edges(faces)[:, 0], minlength=len(cut))
        angles = _corner_angles(cut.vertices_mm[faces])
        opening = np.bincount(faces.ravel(), angles.ravel(), len(cut))
        tooth = (starts > 1) | ((starts == 1) & around & (opening < _TOOTH_RAD))
        if not tooth.any():
            break
        faces = faces[~faces_touching(tooth, faces)]
    parts = face_components(faces)
    kept = parts == np.bincount(parts).argmax()
    return with_faces(cut, faces[kept])


def _corner_angles(corners: Float64[np.ndarray, "f 3 3"]) -> Float64[np.ndarray, "f 3"]:
    """The angles of triangles at their corners, in radians."""
    ways = unit((np.roll(corners, -1, axis=1) - corners).reshape(-1, 3)).reshape(corners.shape)
    return np.arccos(np.clip(-(ways * np.roll(ways, 1, axis=1)).sum(2), -1.0, 1.0))


@dataclass(frozen=True)
class _WallSolid:
    """A wall: two skins and the rim that joins them."""

    solid: Mesh
    like: Int64[np.ndarray, " n"]
    """For each of its vertices, the nearest one of the given skin."""
    first_faces: int
    second_faces: int
    """Number of faces of its first skin, and of the second one; the rest is the rim."""

    @cached_property
    def thickness(self) -> Thickness:
        return thickness_between_skins(self.solid, self.first_faces, self.second_faces)

    def on_skin(self, vertices: Bool[np.ndarray, " n"]) -> Bool[np.ndarray, " k"]:
        """The vertices of the given skin that correspond to vertices of the wall."""
        found = np.zeros(int(self.like.max()) + 1, np.bool_)
        found[self.like[vertices]] = True
        return found


def _joined_skins(mesh: Mesh, other: Mesh, border: np.ndarray, sign: float) -> _WallSolid:
    """The surface and its offset, joined along the open edges."""
    outer, inner = (other, mesh) if sign > 0 else (mesh, other)
    count = len(mesh)
    a, b = border[:, 0], border[:, 1]
    rim = np.concatenate(
        [np.column_stack([b, a, a + count]), np.column_stack([b, a + count, b + count])]
    )
    faces = np.concatenate([inner.faces[:, ::-1] + count, rim]).astype(np.int32)
    same = np.arange(count)
    solid = _with_vertex_fields(
        mesh, with_surface_added(outer, inner.vertices_mm, same, faces), same
    )
    return _WallSolid(solid, np.concatenate([same, same]), len(mesh.faces), len(mesh.faces))


def _with_vertex_fields(mesh: Mesh, solid: Mesh, like: Int64[np.ndarray, " k"]) -> Mesh:
    """The wall with per-vertex fields of its second skin and rim copied from the given skin."""
    known = mesh.of_vertices(lambda _, values: np.concatenate([values, values[like]]))
    return replace(solid, **known)


def _refused_if_unsound(mesh: Mesh, wall: _WallSolid, attempt: _Attempt) -> _Attempt:
    """The attempt, refused where the wall folds or passes through itself."""
    try:
        require_sound(mesh, wall.solid)
    except EditError as error:
        unsound = wall.on_skin(unsound_vertices(mesh, wall.solid))
        return replace(attempt, unsound=unsound | attempt.unsound, refusal=error)
    return attempt


def _checked_cover(mesh: Mesh, edit: Wall, wall: _WallSolid) -> _Attempt:
    """The attempt of a wall as a level surface, after all checks, with its notes."""
    attempt = _refused_if_unsound(mesh, wall, _refused_if_thin(mesh, edit, wall))
    attempt = _refused_if_open(wall, attempt)
    return replace(attempt, notes=(*attempt.notes, *_thick_place_notes(mesh, edit, wall)))


def _refused_if_open(wall: _WallSolid, attempt: _Attempt) -> _Attempt:
    """The attempt, refused where the skins are not joined."""
    left = boundary_half_edges(wall.solid.faces)
    if attempt.refusal is not None or not len(left):
        return attempt
    open_edge = np.zeros(len(wall.solid), np.bool_)
    open_edge[left] = True
    refusal = EditError(
        "edit.wall.unjoined",
        open_edges=len(left),
        point_mm=tuple(wall.solid.vertices_mm[left[0, 0]].tolist()),
    )
    return replace(attempt, unsound=wall.on_skin(open_edge) | attempt.unsound, refusal=refusal)


def _refused_if_lipped(edit: Wall, wall: _WallSolid, attempt: _Attempt) -> _Attempt:
    """The attempt, refused where the brim ends in a thin lip."""
    lip = thin_lip(wall.solid, wall.first_faces + wall.second_faces, edit.least_mm)
    if lip is None:
        return attempt
    at = np.zeros(len(wall.solid), np.bool_)
    at[wall.solid.faces[lip.faces]] = True
    refusal = EditError(
        "edit.wall.lip",
        thickness_mm=lip.thickness_mm,
        point_mm=tuple(lip.place_mm.tolist()),
        least_mm=edit.least_mm,
    )
    return replace(attempt, unsound=wall.on_skin(at) | attempt.unsound, refusal=refusal)


def _refused_if_thin(mesh: Mesh, edit: Wall, wall: _WallSolid) -> _Attempt:
    """The attempt with a note of its thinnest place, refused where it is too thin."""
    found = wall.thickness
    below = found.at_vertices_mm < _ROUNDING_FACTOR * edit.least_mm
    attempt = _Attempt(wall.solid, wall.on_skin(below), found.thinnest_mm, None)
    attempt = _refused_if_lipped(edit, wall, attempt)
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
        attempt = replace(attempt, refusal=refusal)
    if attempt.refusal is not None:
        return attempt
    notes = [found.finding("file")]
    if found.thinnest_mm < _STUDIED_MM:
        notes.append(doubt("edit.wall.unstudied", least_mm=_STUDIED_MM))
    strip = narrow_strip(
        wall.solid, wall.first_faces + wall.second_faces, edit.thickness_mm - _THINNER_MM
    )
    if strip is not None:
        place = tuple(strip.place_mm.tolist())
        notes.append(doubt("edit.wall.narrow", width_mm=strip.thickness_mm, point_mm=place))
    return replace(attempt, notes=tuple(notes))


def _slant_notes(mesh: Mesh, planes: tuple[Plane, ...], wall: _WallSolid) -> list[Finding]:
    """A note of how far the brim leaves the planes of the open edges."""
    border = np.unique(boundary_half_edges(mesh.faces)).astype(np.int64)
    rim = np.unique(wall.solid.faces[wall.first_faces + wall.second_faces :])
    rim_like = wall.like[rim]
    off_mm = 0.0
    for plane in planes:
        at_edge = np.zeros(len(mesh), np.bool_)
        at_edge[border] = plane.holds(mesh.vertices_mm[border])
        leaving_mm = np.abs(plane.above_mm(wall.solid.vertices_mm[rim[at_edge[rim_like]]]))
        off_mm = max(off_mm, float(leaving_mm.max(initial=0.0)))
    return [] if off_mm < _LEVEL_TOLERANCE_MM else [note("edit.wall.aslant", off_mm=off_mm)]


def _thick_place_notes(mesh: Mesh, edit: Wall, wall: _WallSolid) -> list[Finding]:
    """A note of where a wall is thicker than asked, because the shape is narrow there."""
    deep_mm = wall.thickness.at_vertices_mm[: len(mesh)]
    thick = deep_mm > _THICKER_FACTOR * edit.thickness_mm
    if not thick.any():
        return []
    point_mm = tuple(mesh.vertices_mm[int(deep_mm.argmax())].tolist())
    area_mm2 = float(mesh.vertex_areas_mm2()[thick].sum())
    return [note("edit.wall.solid", area_mm2=area_mm2, point_mm=point_mm)]
