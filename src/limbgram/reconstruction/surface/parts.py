"""Parts: the large connected components of the surface, and which of them was meant.

In      the Mesh as meshing made it, the Cloud it was made from, the placed views.
Out     Parts: the cleaned mesh, the part of each triangle, and a description of each part.
Method  Faces that are no surface are removed; pieces of at least a twentieth of the surface are
        parts, smaller ones crumbs. Parts are numbered by how much the photos look at them: area
        times the number of photos that measured it, weighted towards the image centre. The chosen
        part is number 1, or the one that the user names.
Fails   SurfaceError: nothing is left. OptionsError: there is no part of the wanted number.

An object of two sides (a pot, a socket) has a wall whose rim may be in no photo: its outside and
its inside are then two complete bodies. A limb with a bare strip is torn in two as well, but then
each body lacks the other. Parts are therefore also classified by how they lie to each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int32
from scipy.spatial import KDTree

from limbgram.core.errors import OptionsError, SurfaceError
from limbgram.core.geometry.arrays import Faces
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Cloud, Mesh, Part, Relation
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    edge_lengths,
    face_components,
    with_faces,
)
from limbgram.reconstruction.surface.cleaning import (
    drop_degenerate_and_duplicate,
    drop_folds,
    drop_tongues,
    make_manifold,
)

MIN_FACES = 50
"""Triangles of a surface, at least."""

_CENTRE_SIGMA_SHARE = 0.25
"""Standard deviation of the Gaussian weight round the image centre, over the shorter side."""
_MAX_WALL_SHARE = 0.1
"""Two sides of one wall lie nearer to each other than this share of the larger one's size."""
_MIN_JOINED_SHARE = 0.9
"""A surface that joins two sides of a wall has at least this share of their area: a pot on a sheet
has 0.98, and lacks the crumbs of its rim."""
_OPPOSITE_COSINE = -0.5
_MIN_BACK_SHARE = 0.5
_CONTINUATION_COSINE = 0.7
"""Normals on both sides of a tear are within 45 degrees of each other,"""
_MAX_STEP_SINE = 0.5
"""the vector across it is within 30 degrees of both tangent planes,"""
_MAX_GAP_SHARE = 0.25
"""and is no longer than this share of the larger piece's size."""
_MIN_TORN_RIM = 0.5
"""Length of such a rim from which it is a tear, over the square root of the smaller piece's area:
two halves of a tube have 1 or more."""


_MIN_PART_SHARE = 0.05
"""A piece of at least this share of the surface's area is a part."""


@dataclass(frozen=True, kw_only=True)
class PartOptions:
    """Which part is chosen."""

    chosen: int | None = None
    """Number of the chosen part; None: the one that the photos look at most."""


DEFAULTS = PartOptions()


@dataclass(frozen=True, kw_only=True)
class Parts:
    """The cleaned surface and its parts."""

    mesh: Mesh
    number: Int32[np.ndarray, " f"]
    """Number of each triangle's part; 0: a crumb."""
    parts: tuple[Part, ...]
    """In the order of their numbers, from 1."""
    chosen: int
    """Number of the chosen part."""
    given: bool
    """Whether the user named it."""
    crumbs: int
    """Pieces that are too small to be parts."""
    crumb_area_mm2: float

    @property
    def others(self) -> tuple[Part, ...]:
        """All parts but the chosen one."""
        return tuple(part for part in self.parts if part.number != self.chosen)

    def faces(self, number: int) -> Faces:
        """The triangles of one part."""
        return self.mesh.faces[self.number == number]

    @property
    def left_out_share(self) -> float:
        """Area of crumbs and torn-off parts over the area of these and the chosen part."""
        areas = {part.number: part.area_mm2 for part in self.parts}
        torn = sum(part.area_mm2 for part in self.others if part.relation == "torn off")
        left_out = self.crumb_area_mm2 + torn
        return left_out / (left_out + areas[self.chosen])

    @property
    def sides_of_a_wall(self) -> bool:
        """Whether two sides of one wall are two bodies, and the user chose neither."""
        return not self.given and any(part.relation == "other side" for part in self.parts)

    def joins(self, torn: "Parts") -> bool:
        """Whether the chosen part here covers the chosen part there and its other side."""
        area = {part.number: part.area_mm2 for part in self.parts}[self.chosen]
        wall = sum(
            part.area_mm2 for part in torn.parts if part.relation in ("chosen", "other side")
        )
        return area > _MIN_JOINED_SHARE * wall


def tell_parts(
    mesh: Mesh, cloud: Cloud, views: Sequence[View] = (), options: PartOptions = DEFAULTS
) -> Parts:
    """The surface, cleaned, and its parts."""
    faces = _cleaned(mesh)
    pieces = face_components(faces)
    areas = 0.5 * np.linalg.norm(
        Mesh(vertices_mm=mesh.vertices_mm, faces=faces).face_normals(), axis=1
    )
    piece_areas = np.bincount(pieces, areas)
    min_area = min(_MIN_PART_SHARE * piece_areas.sum(), piece_areas.max())
    large = np.flatnonzero(piece_areas >= min_area)
    bodies = [with_faces(_geometry_only(mesh), faces[pieces == piece]) for piece in large]
    attention = np.ones(1)
    if len(bodies) > 1:
        bodies = [oriented_outwards(body, cloud) for body in bodies]
        attention = _photo_attention(bodies, cloud, views)
    order = np.argsort(-attention, kind="stable")
    chosen = _chosen_number(options.chosen, len(bodies))
    main = bodies[order[chosen - 1]]
    numbers = np.zeros(len(piece_areas), np.int32)
    numbers[large[order]] = np.arange(1, len(order) + 1)
    parts = [
        _part(k + 1, bodies[at], main, float(attention[at] / attention.sum()))
        for k, at in enumerate(order)
    ]
    return Parts(
        mesh=Mesh(vertices_mm=mesh.vertices_mm, faces=faces),
        number=numbers[pieces],
        parts=tuple(parts),
        chosen=chosen,
        given=options.chosen is not None,
        crumbs=len(piece_areas) - len(large),
        crumb_area_mm2=float(piece_areas.sum() - piece_areas[large].sum()),
    )


def _cleaned(mesh: Mesh) -> Faces:
    """The faces made manifold, without folds, spikes and tongues."""
    vertices = mesh.vertices_mm
    faces = make_manifold(drop_degenerate_and_duplicate(vertices, mesh.faces))
    faces = make_manifold(drop_tongues(vertices, drop_folds(vertices, faces)))
    if len(faces) < MIN_FACES:
        raise too_few_faces(len(mesh.faces), len(faces))
    return faces


def too_few_faces(before: int, after: int) -> SurfaceError:
    """The refusal of a surface that is left with too few triangles."""
    return SurfaceError("surface.shreds", before=before, after=after)


def oriented_outwards(mesh: Mesh, cloud: Cloud) -> Mesh:
    """The mesh with its faces oriented as the cloud's normals."""
    nearest = KDTree(cloud.points_mm).query(mesh.vertices_mm)[1]
    agreement = (mesh.vertex_normals() * cloud.normals[nearest]).sum()
    turned = np.ascontiguousarray(mesh.faces[:, ::-1])
    return mesh if agreement > 0 else replace(mesh, faces=turned)


def _geometry_only(mesh: Mesh) -> Mesh:
    """The mesh without its vertices' attributes."""
    return Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces)


def _chosen_number(wanted: int | None, count: int) -> int:
    """Number of the part that the user wants, or 1."""
    if wanted is not None and not 1 <= wanted <= count:
        raise OptionsError("surface.no_part", wanted=wanted, count=count)
    return wanted or 1


def _photo_attention(
    bodies: Sequence[Mesh], cloud: Cloud, views: Sequence[View]
) -> Float64[np.ndarray, " k"]:
    """How much the photos look at each body."""
    tree = KDTree(cloud.points_mm)
    found: list[float] = []
    for body in bodies:
        measured_by = cloud.views[tree.query(body.vertices_mm)[1]].astype(np.float64)
        weights = body.vertex_areas_mm2() * measured_by * _image_centrality(body, views)
        found.append(float(weights.sum()))
    return np.array(found)


def _image_centrality(body: Mesh, views: Sequence[View]) -> Float64[np.ndarray, " n"]:
    """Mean Gaussian weight of each vertex in the photos that it faces; 1 at the image centre."""
    normals = body.vertex_normals()
    total, facing = np.zeros(len(body)), np.zeros(len(body))
    for view in views:
        faces_camera = ((view.centre_in_world - body.vertices_mm) * normals).sum(1) > 0
        camera = view.camera
        middle = np.array([camera.width_px - 1, camera.height_px - 1]) / 2
        reach = _CENTRE_SIGMA_SHARE * min(camera.width_px, camera.height_px)
        offset = (view.project(body.vertices_mm) - middle) / reach
        weight = np.exp(-0.5 * (offset**2).sum(1))
        total += np.where(faces_camera & np.isfinite(weight), weight, 0.0)  # NaN: not shown at all
        facing += faces_camera
    return (
        np.divide(total, facing, out=np.zeros(len(body)), where=facing > 0) if views else facing + 1
    )


def _part(number: int, body: Mesh, main: Mesh, looked_at: float) -> Part:
    low, high = body.vertices_mm.min(0), body.vertices_mm.max(0)
    return Part(
        number=number,
        area_mm2=body.area_mm2(),
        middle_mm=(low + high) / 2,
        size_mm=float((high - low).max()),
        looked_at=looked_at,
        relation="chosen" if body is main else _relation(body, main),
    )


def _relation(one: Mesh, two: Mesh) -> Relation:
    """How two bodies lie to each other; symmetric."""
    smaller, larger = (one, two) if one.area_mm2() < two.area_mm2() else (two, one)
    size_mm = float(np.linalg.norm(np.ptp(larger.vertices_mm, axis=0)))
    if _back_to_back_share(smaller, larger, _MAX_WALL_SHARE * size_mm) > _MIN_BACK_SHARE:
        return "other side"
    torn_mm = _torn_rim_mm(smaller, larger, _MAX_GAP_SHARE * size_mm)
    return "torn off" if torn_mm > _MIN_TORN_RIM * np.sqrt(smaller.area_mm2()) else "apart"


def _back_to_back_share(body: Mesh, other: Mesh, max_mm: float) -> float:
    """Share of a body's area behind which the other lies near and faces the opposite way."""
    distance, nearest = KDTree(other.vertices_mm).query(body.vertices_mm)
    normals = body.vertex_normals()
    offset = other.vertices_mm[nearest] - body.vertices_mm
    behind = (offset * normals).sum(1) < 0
    opposite = (normals * other.vertex_normals()[nearest]).sum(1) < _OPPOSITE_COSINE
    areas = body.vertex_areas_mm2()
    return float(areas[behind & opposite & (distance < max_mm)].sum() / areas.sum())


def _torn_rim_mm(body: Mesh, other: Mesh, max_gap_mm: float) -> float:
    """Length of the body's rim from which the other body continues in the same direction."""
    rim, across = boundary_half_edges(body.faces), boundary_half_edges(other.faces)[:, 0]
    if not (len(rim) and len(across)):
        return 0.0
    places, normals = body.vertices_mm[rim[:, 0]], body.vertex_normals()[rim[:, 0]]
    distance, nearest = KDTree(other.vertices_mm[across]).query(places)
    beyond = across[nearest]
    facing = other.vertex_normals()[beyond]
    gap = other.vertices_mm[beyond] - places
    along = np.maximum(np.abs((gap * normals).sum(1)), np.abs((gap * facing).sum(1)))
    continues = ((normals * facing).sum(1) > _CONTINUATION_COSINE) & (
        along <= _MAX_STEP_SINE * distance
    )
    lengths = edge_lengths(body.vertices_mm, rim)
    return float(lengths[continues & (distance <= max_gap_mm)].sum())
