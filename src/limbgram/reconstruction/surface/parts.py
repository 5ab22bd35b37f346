"""Parts: the large connected components of the surface, and which of them was meant.

In      a Mesh as it was wrapped, the Cloud it was made from, the placed views.
Out     Parts: the cleaned mesh, which part each triangle belongs to, what each part is.
Method  what is no surface is taken away; pieces of a twentieth of the surface are parts, smaller
        ones crumbs. Parts are numbered by what the photos look at: area times the number of photos
        that measured it, counted most in the middle of the picture. Number 1 is meant, or the one
        that the user names.
Fails   SurfaceError: nothing is left. OptionsError: there is no part of the wanted number.

A thing of two sides (a pot, a socket) has a wall whose rim no photo may show: its outside and its
inside are two bodies, both whole. A limb with a bare strip is torn in two as well, and then each
body lacks the other. So parts are also told apart by how they lie to each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int32
from scipy.spatial import KDTree

from limbgram.core.errors import OptionsError, SurfaceError
from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Cloud, Mesh, Part, Relation
from limbgram.core.mesh.topology import boundary_half_edges, face_components, with_faces
from limbgram.reconstruction.surface.cleaning import (
    drop_flat_and_double,
    drop_folds,
    drop_tongues,
    make_manifold,
)

FEWEST_FACES = 50
"""Fewer triangles are no surface."""

_MIDDLE_SHARE = 0.25
"""A photo looks at its middle: weights fall as a Gaussian of this part of its shorter side."""
_WALL_SHARE = 0.1
"""Two sides of one wall lie nearer to each other than this part of the larger one's size."""
_WHOLE_WALL = 0.9
"""A surface that joins two sides of a wall has at least this part of their area: a pot on a sheet
has 0.98, and what is missing of it are the crumbs of its rim."""
_OPPOSITE_COSINE = -0.5
_MOST_OF_IT = 0.5
_GOES_ON_COSINE = 0.7
"""Where a surface is torn its normals on both sides are within 45 degrees of each other."""
_ALONG_SINE = 0.5
"""And the way across leaves both by less than 30 degrees."""
_GAP_SHARE = 0.25
"""And it is no longer than this part of the larger piece's size."""
_TORN_RIM = 0.5
"""Length of such a rim that makes a tear, in roots of the smaller piece's area: two halves of a
tube have 1 or more."""


_LEAST_SHARE = 0.05
"""A piece of at least this part of the wrapped surface's area is a part."""


@dataclass(frozen=True, kw_only=True)
class PartOptions:
    """What is a part, and which is meant."""

    chosen: int | None = None
    """Number of the part that is meant; None: the one that the photos look at most."""


DEFAULTS = PartOptions()


@dataclass(frozen=True, kw_only=True)
class Parts:
    """The wrapped surface, cleaned, and its parts."""

    mesh: Mesh
    number: Int32[np.ndarray, " f"]
    """Of the part that each triangle belongs to; 0: a crumb."""
    parts: tuple[Part, ...]
    """In the order of their numbers, from 1."""
    chosen: int
    """Number of the part that is meant."""
    given: bool
    """Whether the user named it."""
    crumbs: int
    """Pieces that are too small to be parts."""
    crumb_area_mm2: float

    @property
    def others(self) -> tuple[Part, ...]:
        """All but the one that is meant."""
        return tuple(part for part in self.parts if part.number != self.chosen)

    def faces(self, number: int) -> Faces:
        """The triangles of one part."""
        return self.mesh.faces[self.number == number]

    @property
    def left_out_share(self) -> float:
        """What the meant part lacks: crumbs and what was torn off it, of all that would be it."""
        areas = {part.number: part.area_mm2 for part in self.parts}
        torn = sum(part.area_mm2 for part in self.others if part.relation == "torn off")
        left_out = self.crumb_area_mm2 + torn
        return left_out / (left_out + areas[self.chosen])

    @property
    def sides_of_a_wall(self) -> bool:
        """Whether two sides of one wall are two bodies, and nobody chose one of them."""
        return not self.given and any(part.relation == "other side" for part in self.parts)

    def joins(self, torn: "Parts") -> bool:
        """Whether the meant part here is all that was meant there, with the other side of it."""
        area = {part.number: part.area_mm2 for part in self.parts}[self.chosen]
        wall = sum(
            part.area_mm2 for part in torn.parts if part.relation in ("chosen", "other side")
        )
        return area > _WHOLE_WALL * wall


def tell_parts(
    mesh: Mesh, cloud: Cloud, views: Sequence[View] = (), options: PartOptions = DEFAULTS
) -> Parts:
    """Clean a wrapped surface and tell its parts apart."""
    faces = _cleaned(mesh)
    pieces = face_components(faces)
    areas = 0.5 * np.linalg.norm(
        Mesh(vertices_mm=mesh.vertices_mm, faces=faces).face_normals(), axis=1
    )
    of_piece = np.bincount(pieces, areas)
    least = min(_LEAST_SHARE * of_piece.sum(), of_piece.max())
    sizeable = np.flatnonzero(of_piece >= least)
    bodies = [with_faces(_bare(mesh), faces[pieces == piece]) for piece in sizeable]
    looked = np.ones(1)
    if len(bodies) > 1:
        bodies = [outwards(body, cloud) for body in bodies]
        looked = _looked_at(bodies, cloud, views)
    order = np.argsort(-looked, kind="stable")
    chosen = _chosen(options.chosen, len(bodies))
    main = bodies[order[chosen - 1]]
    numbers = np.zeros(len(of_piece), np.int32)
    numbers[sizeable[order]] = np.arange(1, len(order) + 1)
    parts = [
        _part(k + 1, bodies[at], main, float(looked[at] / looked.sum()))
        for k, at in enumerate(order)
    ]
    return Parts(
        mesh=Mesh(vertices_mm=mesh.vertices_mm, faces=faces),
        number=numbers[pieces],
        parts=tuple(parts),
        chosen=chosen,
        given=options.chosen is not None,
        crumbs=len(of_piece) - len(sizeable),
        crumb_area_mm2=float(of_piece.sum() - of_piece[sizeable].sum()),
    )


def _cleaned(mesh: Mesh) -> Faces:
    """The manifold faces without folds, spikes and tongues."""
    vertices = mesh.vertices_mm
    faces = make_manifold(drop_flat_and_double(vertices, mesh.faces))
    faces = make_manifold(drop_tongues(vertices, drop_folds(vertices, faces)))
    if len(faces) < FEWEST_FACES:
        raise nothing_left(len(mesh.faces), len(faces))
    return faces


def nothing_left(before: int, after: int) -> SurfaceError:
    """The refusal where so few triangles are left that they are no surface."""
    return SurfaceError("surface.shreds", before=before, after=after)


def outwards(mesh: Mesh, cloud: Cloud) -> Mesh:
    """The mesh with its faces turned so that the normals look the way of the cloud's."""
    nearest = KDTree(cloud.points_mm).query(mesh.vertices_mm)[1]
    agreement = (mesh.vertex_normals() * cloud.normals[nearest]).sum()
    turned = np.ascontiguousarray(mesh.faces[:, ::-1])
    return mesh if agreement > 0 else replace(mesh, faces=turned)


def _bare(mesh: Mesh) -> Mesh:
    return Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces)


def _chosen(wanted: int | None, count: int) -> int:
    if wanted is not None and not 1 <= wanted <= count:
        raise OptionsError("surface.no_part", wanted=wanted, count=count)
    return wanted or 1


def _looked_at(
    bodies: Sequence[Mesh], cloud: Cloud, views: Sequence[View]
) -> Float64[np.ndarray, " k"]:
    """How much the photos look at each body."""
    tree = KDTree(cloud.points_mm)
    found: list[float] = []
    for body in bodies:
        measured_by = cloud.views[tree.query(body.vertices_mm)[1]].astype(np.float64)
        weights = body.vertex_areas_mm2() * measured_by * _in_the_middle(body, views)
        found.append(float(weights.sum()))
    return np.array(found)


def _in_the_middle(body: Mesh, views: Sequence[View]) -> Float64[np.ndarray, " n"]:
    """How near to the middle of the photos that it faces each vertex lies: 1 in the middle."""
    normals = body.vertex_normals()
    total, facing = np.zeros(len(body)), np.zeros(len(body))
    for view in views:
        towards = ((view.centre_in_world - body.vertices_mm) * normals).sum(1) > 0
        camera = view.camera
        middle = np.array([camera.width_px - 1, camera.height_px - 1]) / 2
        reach = _MIDDLE_SHARE * min(camera.width_px, camera.height_px)
        away = (view.project(body.vertices_mm) - middle) / reach
        total += np.where(towards, np.exp(-0.5 * (away**2).sum(1)), 0.0)
        facing += towards
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
    """How two bodies lie to each other; the order does not matter."""
    smaller, larger = (one, two) if one.area_mm2() < two.area_mm2() else (two, one)
    size_mm = float(np.linalg.norm(np.ptp(larger.vertices_mm, axis=0)))
    if _backs(smaller, larger, _WALL_SHARE * size_mm) > _MOST_OF_IT:
        return "other side"
    torn_mm = _torn_rim_mm(smaller, larger, _GAP_SHARE * size_mm)
    return "torn off" if torn_mm > _TORN_RIM * np.sqrt(smaller.area_mm2()) else "apart"


def _backs(body: Mesh, other: Mesh, most_mm: float) -> float:
    """Share of a body that is the back of the other: behind it lies, near, what faces away."""
    distance, nearest = KDTree(other.vertices_mm).query(body.vertices_mm)
    normals = body.vertex_normals()
    away = other.vertices_mm[nearest] - body.vertices_mm
    behind = (away * normals).sum(1) < 0
    opposite = (normals * other.vertex_normals()[nearest]).sum(1) < _OPPOSITE_COSINE
    areas = body.vertex_areas_mm2()
    return float(areas[behind & opposite & (distance < most_mm)].sum() / areas.sum())


def _torn_rim_mm(body: Mesh, other: Mesh, widest_mm: float) -> float:
    """Length of the body's rim across from which the other goes on in the same direction."""
    rim, across = boundary_half_edges(body.faces), boundary_half_edges(other.faces)[:, 0]
    if not (len(rim) and len(across)):
        return 0.0
    places, normals = body.vertices_mm[rim[:, 0]], body.vertex_normals()[rim[:, 0]]
    distance, nearest = KDTree(other.vertices_mm[across]).query(places)
    beyond = across[nearest]
    facing = other.vertex_normals()[beyond]
    gap = other.vertices_mm[beyond] - places
    along = np.maximum(np.abs((gap * normals).sum(1)), np.abs((gap * facing).sum(1)))
    goes_on = ((normals * facing).sum(1) > _GOES_ON_COSINE) & (along <= _ALONG_SINE * distance)
    lengths = _lengths(body.vertices_mm, rim)
    return float(lengths[goes_on & (distance <= widest_mm)].sum())


def _lengths(vertices: Points3, ends: Int32[np.ndarray, "b 2"]) -> Float64[np.ndarray, " b"]:
    return np.linalg.norm(vertices[ends[:, 1]] - vertices[ends[:, 0]], axis=1)
