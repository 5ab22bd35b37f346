"""Offset: the surface moved along its normals so that its faces move by the distance.

In      a Mesh and a distance in mm, negative inwards.
Out     the Mesh with moved vertices; faces, colours, filled marks and sigmas as they were.
Method  each vertex goes where the planes of its faces meet once they have moved; directions that
        they leave open stay unused. On a plane, a cylinder and a sphere every face moves by the
        distance as far as its triangles follow the shape.
Fails   EditError: the surface would fold or cut through itself.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64
from scipy.sparse import csr_array

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh, dots, lengths, summed
from limbgram.core.mesh.topology import faces_touching
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.guard import require_sound
from limbgram.workbench.edits.level_edges import Plane, with_edges_in_planes
from limbgram.workbench.edits.regions import displaced, neighbour_averaging
from limbgram.workbench.limb import Limb

_NORMAL_WEIGHT = 1e-3
"""Weight of moving along the normal, as a share of the faces'; it decides open directions."""
_MITRE_LIMIT = 2.0
"""A vertex moves at most this many distances, so that sharp corners do not shoot out."""
_LEAST_COSINE = 0.5
"""Faces keep their direction in an offset; one below this cosine (60 degrees) has turned away."""
_MOST_SMOOTHED = 0.05
"""Share of the faces whose moves may be smoothed besides those asked for; beyond it the offset is
refused."""
_SMOOTHING_ROUNDS = 60
_SCRAP_MM = 0.05
"""Triangles less high than this have no direction of their own and follow their longest side."""
_SCRAP_ROUNDS = 20


@edit(
    group="surface",
    order=1,
    effect=Effect(moves_skin=True),
    everyday=True,
    guarded=False,
    example={"distance_mm": 1.0},
)
class Offset(Edit):
    """Move the whole surface along its normals."""

    distance_mm: float
    """Outwards; negative inwards."""

    words = spoken(
        en=Words(name="Offset all over", title="The offset"),
        de=Words(
            name="Überall versetzen",
            title="Das Versetzen",
            does="Die ganze Fläche senkrecht zu sich selbst versetzen.",
            labels={"distance_mm": "Abstand"},
            help={"distance_mm": "Nach außen; negativ nach innen."},
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Move every face by a distance.

        Raises:
            EditError: the surface would fold or cut through itself.
        """
        return displaced(limb, offset(limb.mesh, self.distance_mm).vertices_mm)


def offset(mesh: Mesh, distance_mm: float) -> Mesh:
    """Move every face by a distance along its outward normal.

    Raises:
        EditError: the surface would fold or cut through itself.
    """
    if distance_mm == 0.0:
        return mesh
    found = Offsetter(mesh).by_vertex(np.full(len(mesh), float(distance_mm)), None)
    require_not_turned(mesh, found, distance_mm)
    require_sound(mesh, found.mesh)
    return found.mesh


@dataclass(frozen=True)
class OffsetResult:
    """An offset surface, and its faces that turned inside out."""

    mesh: Mesh
    turned: Bool[np.ndarray, " f"]


@dataclass(frozen=True)
class Offsetter:
    """A surface to be offset, with the data that several trial offsets share."""

    mesh: Mesh
    planes: tuple[Plane, ...] = ()
    """Planes in which open edges stay."""

    @cached_property
    def unit_moves(self) -> Points3:
        """Displacement of each vertex for an offset of 1 mm outwards."""
        return unit_offsets(self.mesh)

    @cached_property
    def averaging(self) -> csr_array:
        """Matrix that averages vertex values over each vertex's neighbours."""
        return neighbour_averaging(self.mesh)

    def by_vertex(
        self, distances_mm: Float64[np.ndarray, " n"], smooth_at: Bool[np.ndarray, " n"] | None
    ) -> OffsetResult:
        """The offset by a distance for each vertex, for edits that check the surface themselves.

        Args:
            smooth_at: Vertices whose moves are averaged with their neighbours' in any case.

        Raises:
            EditError: a distance is no number.
        """
        if not np.isfinite(distances_mm).all():
            raise EditError("edit.offset.no_number")
        mesh = self.mesh
        moves = self._smoothed_moves(distances_mm[:, None] * self.unit_moves, smooth_at)
        moves = with_edges_in_planes(mesh, self.planes, moves)
        turned = _normal_cosines(mesh.face_normals(), mesh, moves) <= 0
        if turned.any():
            moves = _with_scraps_carried(mesh, moves)
            turned = _normal_cosines(mesh.face_normals(), mesh, moves) <= 0
        return OffsetResult(mesh.with_vertices(mesh.vertices_mm + moves), turned)

    def _smoothed_moves(self, moves: Points3, smooth_at: Bool[np.ndarray, " n"] | None) -> Points3:
        """The moves, smoothed in place round faces that turn away, in an area that grows until
        none does."""
        mesh = self.mesh
        before = mesh.face_normals()
        turned = _normal_cosines(before, mesh, moves) < _LEAST_COSINE
        touched = np.zeros(len(mesh), np.bool_) if smooth_at is None else smooth_at.copy()
        if not turned.any() and not touched.any():
            return moves
        if smooth_at is not None:
            mean = self.averaging[smooth_at]
            for _ in range(_SMOOTHING_ROUNDS // 4):
                moves[smooth_at] = mean @ moves
        given = (~faces_touching(~touched, mesh.faces)).mean()
        for _ in range(_SMOOTHING_ROUNDS):
            touched[mesh.faces[turned]] = True
            if (~faces_touching(~touched, mesh.faces)).mean() - given > _MOST_SMOOTHED:
                break
            around = touched.copy()
            around[mesh.faces[faces_touching(touched, mesh.faces)]] = True
            moves[around] = self.averaging[around] @ moves
            changed = faces_touching(around, mesh.faces)
            near = replace(mesh, faces=mesh.faces[changed])
            turned[changed] = _normal_cosines(before[changed], near, moves) < _LEAST_COSINE
            if not turned.any():
                break
        return moves


def require_not_turned(mesh: Mesh, found: OffsetResult, distance_mm: float) -> None:
    """Refuse an offset that turns faces inside out.

    Raises:
        EditError: says how many, and where.
    """
    if not found.turned.any():
        return
    place = mesh.vertices_mm[mesh.faces[found.turned.argmax()]].mean(0)
    raise EditError(
        "edit.offset.turned",
        distance_mm=distance_mm,
        count=int(found.turned.sum()),
        point_mm=tuple(place.tolist()),
    )


def unit_offsets(mesh: Mesh) -> Points3:
    """Displacement of each vertex for an offset of 1 mm outwards.

    Least squares of n . x = 1 over the faces at the vertex, weighted by area, because slivers have
    poor normals.
    """
    weighted = mesh.face_normals()
    units = weighted / np.maximum(lengths(weighted), 1e-30)[:, None]
    normals = summed(weighted, mesh.faces, len(mesh))
    products = _normal_products(weighted, units, mesh.faces, len(mesh))
    along = normals / np.maximum(lengths(normals), 1e-30)[:, None]
    tie = np.maximum(_NORMAL_WEIGHT * np.trace(products, axis1=1, axis2=2), 1e-30)
    system = products + tie[:, None, None] * np.eye(3)
    moves = np.linalg.solve(system, (normals + tie[:, None] * along)[:, :, None])[:, :, 0]
    far = lengths(moves)
    return moves * np.minimum(1.0, _MITRE_LIMIT / np.maximum(far, 1e-30))[:, None]


def _normal_cosines(
    before: Float64[np.ndarray, "f 3"], mesh: Mesh, moves: Points3
) -> Float64[np.ndarray, " f"]:
    """Cosine between each face's normal and its normal once it has moved."""
    after = mesh.with_vertices(mesh.vertices_mm + moves).face_normals()
    sizes = lengths(before) * lengths(after)
    return dots(before, after) / np.maximum(sizes, 1e-30)


def _with_scraps_carried(mesh: Mesh, moves: Points3) -> Points3:
    """The moves, with the apex of each flat scrap that turns away carried by its longest side.

    The few micrometres by which its corners move differently would turn it over, and mean nothing.
    """
    before = mesh.face_normals()
    moves = moves.copy()
    for _ in range(_SCRAP_ROUNDS):
        faces = mesh.faces[_normal_cosines(before, mesh, moves) < _LEAST_COSINE]
        points = mesh.vertices_mm[faces]
        longest = np.linalg.norm(np.roll(points, -1, axis=1) - points, axis=2).argmax(1)
        rows = np.arange(len(faces))
        start, end, apex = (faces[rows, (longest + step) % 3] for step in range(3))
        side = mesh.vertices_mm[end] - mesh.vertices_mm[start]
        to_apex = mesh.vertices_mm[apex] - mesh.vertices_mm[start]
        share = (to_apex * side).sum(1) / np.maximum((side * side).sum(1), 1e-30)
        flat = np.linalg.norm(to_apex - share[:, None] * side, axis=1) < _SCRAP_MM
        if not flat.any():
            break
        along = moves[start] + share[:, None] * (moves[end] - moves[start])
        moves[apex[flat]] = along[flat]
    return moves


@njit(cache=True, nogil=True)
def _normal_products(weighted: np.ndarray, units: np.ndarray, faces: np.ndarray, count: int):
    """Area-weighted sum of n n' over the faces at each vertex; first, second and third corners are
    summed separately."""
    total = np.zeros((count, 3, 3))
    for corner in range(3):
        part = np.zeros((count, 3, 3))
        for f in range(len(faces)):
            at = faces[f, corner]
            for i in range(3):
                for j in range(i, 3):
                    part[at, i, j] += weighted[f, i] * units[f, j]
        total += part
    for i, j in ((0, 1), (0, 2), (1, 2)):
        for at in range(count):
            total[at, j, i] = total[at, i, j]
    return total
