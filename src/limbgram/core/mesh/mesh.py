"""Cloud, the oriented points that a surface is made of, and Mesh, the surface itself."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from jaxtyping import Bool, Float32, Float64, UInt8, UInt16

from limbgram.core.geometry.arrays import Faces, Points3, Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.kernels import njit
from limbgram.core.mesh.vertex_fields import VertexField, of_vertices, vertex_fields
from limbgram.core.notebook import brief, library

if TYPE_CHECKING:
    from trimesh import Trimesh


@dataclass(frozen=True, kw_only=True)
class Cloud:
    """Oriented points of the surface."""

    points_mm: Float32[np.ndarray, "n 3"]
    normals: Float32[np.ndarray, "n 3"]
    """Unit, outwards."""
    colours: UInt8[np.ndarray, "n 3"]
    views: UInt16[np.ndarray, " n"]
    """Number of photos that agree on the point."""
    spacing_mm: float
    """Typical distance between neighbours."""

    __repr__ = brief

    def __len__(self) -> int:
        return len(self.points_mm)


Relation = Literal["chosen", "other side", "torn off", "apart"]
"""How a body relates to the chosen one: the other side of its wall; a piece of it beyond a bare
strip; or something else."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A sizeable connected component of the surface, before holes were filled."""

    number: int
    """From 1, in falling order of `looked_at`."""
    area_mm2: float
    middle_mm: Vector3
    """Of its bounding box."""
    size_mm: float
    """Longest side of its bounding box."""
    looked_at: float
    """Its share of what the photos look at."""
    relation: Relation


@dataclass(frozen=True, kw_only=True)
class Repairs:
    """What was repaired in a mesh."""

    islands_dropped: int
    """Loose components too small to be parts, left out."""
    island_share: float
    """Area of the measured surface that was left out, islands and parts torn off, as a share of
    this mesh's area."""
    holes_filled: int
    laid_back: int = 0
    """Vertices moved to remove folds of the measurement (`core/mesh/folds`)."""
    part: int = 1
    """Number of the part that this is."""
    part_given: bool = False
    """Whether the user named it."""
    others: tuple[Part, ...] = ()
    """The other parts, each with a file of its own."""


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """Triangles, counter-clockwise seen from outside; world frame of the MetricScene."""

    vertices_mm: Points3
    faces: Faces
    colours: UInt8[np.ndarray, "n 3"] | None = field(
        default=None, metadata=of_vertices("colour", "red", "green", "blue", shown_as="RGB")
    )
    filled: Bool[np.ndarray, " n"] | None = field(
        default=None, metadata=of_vertices("mark", "filled", unmeasured=True, shown_as="filled")
    )
    """True at vertices that no photo measured: the part closed by us."""
    sigma_mm: Float32[np.ndarray, " n"] | None = field(
        default=None,
        metadata=of_vertices(
            "number",
            "scalar_sigma",
            older=("sigma",),
            unmeasured=np.nan,
            least=(0.0,),
            known_everywhere=False,
            in_mm=True,
            shown_as="sigma_mm",
        ),
    )
    """One standard deviation along the normal; NaN at filled vertices."""
    shared_mm: Float32[np.ndarray, "n k"] | None = field(
        default=None,
        metadata=of_vertices("number", "shared_", counted=True, known_everywhere=False, in_mm=True),
    )
    """Displacement along the normal for one standard deviation of each of k sources of error
    that all vertices share (scale, cameras); part of `sigma_mm`."""
    shared_sources: tuple[str, ...] = ()
    """What each column of `shared_mm` comes from; a source may have several. Empty: not known."""
    correlation_mm: float | None = None
    """Correlation length of the rest of the error."""
    lost_length: Float32[np.ndarray, "n 2"] | None = field(
        default=None,
        metadata=of_vertices("number", "lost", "lost_sigma", least=(-np.inf, 0.0), detail=True),
    )
    """Relative length that a line on this surface lacks against one on the limb, both smoothed
    (`core/geometry/smoothed_length`): fine relief lost, less what noise adds. The mean over all
    directions, and its standard deviation."""
    lost_across: Float32[np.ndarray, "n 3"] | None = field(
        default=None,
        metadata=of_vertices(
            "number", "lost_across_x", "lost_across_y", "lost_across_z", axis=True, detail=True
        ),
    )
    """Anisotropy of `lost_length`: an axis across the lost relief, of either sign. A line at the
    angle t to it lacks cos 2t times its length more than the mean."""
    repairs: Repairs | None = None

    __repr__ = brief

    def __len__(self) -> int:
        return len(self.vertices_mm)

    def with_vertices(self, vertices_mm: Points3) -> "Mesh":
        """The mesh with other vertex positions; directions along the surface stay as they are."""
        return replace(self, vertices_mm=vertices_mm)

    def moved(self, motion: Rigid) -> "Mesh":
        """The mesh in another frame."""
        rotation = motion.rotation.T.astype(np.float32)
        known = self.of_vertices(lambda one, values: values @ rotation if one.axis else values)
        return replace(self, vertices_mm=motion.apply(self.vertices_mm), **known)

    def of_vertices(
        self, change: Callable[[VertexField, np.ndarray], np.ndarray | None]
    ) -> dict[str, Any]:
        """The per-vertex fields, each changed, as arguments for `replace`."""
        known = {name: (one, getattr(self, name)) for name, one in VERTEX_FIELDS.items()}
        return {
            name: None if values is None else change(one, values)
            for name, (one, values) in known.items()
        }

    def shown(self) -> dict[str, np.ndarray]:
        """The per-vertex fields that other programs show, by their names there, numbers first."""
        known = [(one, getattr(self, name)) for name, one in VERTEX_FIELDS.items() if one.shown_as]
        known.sort(key=lambda row: _SHOWN_ORDER.index(row[0].kind))
        return {one.shown_as: values for one, values in known if values is not None}

    def face_normals(self) -> Float64[np.ndarray, "f 3"]:
        """Outward normals, twice as long as the face's area."""
        return crosses(self.vertices_mm, self.faces)

    def area_mm2(self) -> float:
        """Area of all faces."""
        return float(lengths(self.face_normals()).sum()) / 2

    def vertex_normals(self) -> Float64[np.ndarray, "n 3"]:
        """Unit, area-weighted."""
        return unit(summed(self.face_normals(), self.faces, len(self.vertices_mm)))

    def to_trimesh(self) -> "Trimesh":
        """The same triangles for trimesh, with colours; sigma and filled marks as attributes."""
        from trimesh import Trimesh  # a fifth of a second, for notebooks alone

        known = {name: one for name, one in self.shown().items() if one is not self.colours}
        return Trimesh(
            self.vertices_mm,
            self.faces,
            vertex_colors=self.colours,
            vertex_attributes={name: unsigned(one) for name, one in known.items()},
            process=False,
        )

    def to_pyvista(self) -> Any:
        """The same triangles as a pyvista.PolyData, with sigma, filled marks and colours.

        Raises:
            MissingError: pyvista is not installed.
        """
        surface = library("pyvista").PolyData.from_regular_faces(self.vertices_mm, self.faces)
        for name, values in self.shown().items():
            surface.point_data[name] = values
        return surface

    def vertex_areas_mm2(self) -> Float64[np.ndarray, " n"]:
        """A third of the area of the triangles round each vertex."""
        return _summed_at_vertices(lengths(self.face_normals()) / 6, self.faces, len(self))

    @property
    def measured(self) -> Bool[np.ndarray, " n"]:
        """True at vertices that photos measured: at all of them where none are flagged."""
        return np.ones(len(self), np.bool_) if self.filled is None else ~self.filled

    def filled_share(self) -> float:
        """Share of the area at vertices that no photo measured; 0 where they are not flagged."""
        if self.measured.all():
            return 0.0
        areas_mm2 = self.vertex_areas_mm2()
        return float(areas_mm2[~self.measured].sum() / areas_mm2.sum())

    def chordal_deviations_mm(self) -> Float64[np.ndarray, " n"]:
        """How far the faces round each vertex lie inside the smooth surface, on average.

        A quadratic surface with normals n_i at a face's corners x_i lies off the face by
        sum (x_i - mean x) . (n_i - mean n) / 8 on average: by e^2 / 8 R on a sphere with edges e.
        """
        corners, normals = self.vertices_mm[self.faces], self.vertex_normals()[self.faces]
        of_face = np.einsum("fkd,fkd->f", corners - corners.mean(1, keepdims=True), normals) / 8
        thirds_mm2 = lengths(self.face_normals()) / 6
        sums = _summed_at_vertices(of_face * thirds_mm2, self.faces, len(self))
        areas_mm2 = _summed_at_vertices(thirds_mm2, self.faces, len(self))
        return sums / np.maximum(areas_mm2, 1e-12)


VERTEX_FIELDS = vertex_fields(Mesh)
"""The per-vertex fields, in the order in which files have them."""
_SHOWN_ORDER = ("number", "mark", "colour")
"""Programs colour a surface by the field that comes first."""


def unsigned(values: np.ndarray) -> np.ndarray:
    """Booleans as uint8, for files that have none."""
    return values.astype(np.uint8) if values.dtype == np.bool_ else values


def unit(vectors: Points3) -> Points3:
    """Rows normalized to length 1; a zero row stays zero."""
    lengths = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return vectors / np.maximum(lengths, 1e-30)[:, None]


def changed_rows(old: np.ndarray, new: np.ndarray) -> Bool[np.ndarray, " n"]:
    """Rows of three that differ from the old row of the same index, or are new."""
    shared = min(len(old), len(new))
    changed = np.ones(len(new), np.bool_)
    x, y, z = (old[:shared] != new[:shared]).T
    changed[:shared] = x | y | z
    return changed


@njit(cache=True, nogil=True)
def dots(ones: np.ndarray, twos: np.ndarray):
    """Row-wise dot product: (ones * twos).sum(1) to the last bit."""
    found = np.empty(len(ones))
    for i in range(len(ones)):
        found[i] = ones[i, 0] * twos[i, 0] + ones[i, 1] * twos[i, 1] + ones[i, 2] * twos[i, 2]
    return found


@njit(cache=True, nogil=True)
def lengths(vectors: np.ndarray):
    """Row-wise norm: np.linalg.norm(vectors, axis=1) to the last bit."""
    found = np.empty(len(vectors))
    for i in range(len(vectors)):
        x, y, z = vectors[i, 0], vectors[i, 1], vectors[i, 2]
        found[i] = np.sqrt(x * x + y * y + z * z)
    return found


def crosses(vertices: Points3, faces: Faces) -> Float64[np.ndarray, "f 3"]:
    """Cross product of two sides of each face: its normal, twice as long as its area."""
    return _crosses(
        np.ascontiguousarray(vertices, np.float64), np.ascontiguousarray(faces, np.int32)
    )


@njit(cache=True, nogil=True)
def _crosses(vertices: np.ndarray, faces: np.ndarray):
    found = np.empty((len(faces), 3))
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        x, y, z = vertices[a, 0], vertices[a, 1], vertices[a, 2]
        ux, uy, uz = vertices[b, 0] - x, vertices[b, 1] - y, vertices[b, 2] - z
        vx, vy, vz = vertices[c, 0] - x, vertices[c, 1] - y, vertices[c, 2] - z
        found[f, 0] = uy * vz - uz * vy
        found[f, 1] = uz * vx - ux * vz
        found[f, 2] = ux * vy - uy * vx
    return found


def longest_sides_mm(vertices: Points3, faces: Faces) -> Float64[np.ndarray, " f"]:
    """Longest side of each face."""
    return _longest_sides(
        np.ascontiguousarray(vertices, np.float64), np.ascontiguousarray(faces, np.int32)
    )


@njit(cache=True, nogil=True)
def _longest_sides(vertices: np.ndarray, faces: np.ndarray):
    found = np.empty(len(faces))
    for f in range(len(faces)):
        longest2 = 0.0
        for corner in range(3):
            a, b = faces[f, corner], faces[f, corner - 1]
            x = vertices[a, 0] - vertices[b, 0]
            y = vertices[a, 1] - vertices[b, 1]
            z = vertices[a, 2] - vertices[b, 2]
            longest2 = max(longest2, x * x + y * y + z * z)
        found[f] = np.sqrt(longest2)
    return found


@njit(cache=True, nogil=True)
def _summed_at_vertices(values: np.ndarray, faces: np.ndarray, count: int):
    """Sum of a face value over the faces of each vertex."""
    total = np.zeros(count)
    for f in range(len(faces)):
        for corner in range(3):
            total[faces[f, corner]] += values[f]
    return total


@njit(cache=True, nogil=True)
def summed(vectors: np.ndarray, faces: np.ndarray, count: int):
    """Sum of a face vector over the faces of each vertex, first, second and third corners apart."""
    parts = np.zeros((count, 3, 3))
    for f in range(len(faces)):
        x, y, z = vectors[f, 0], vectors[f, 1], vectors[f, 2]
        for corner in range(3):
            at = faces[f, corner]
            parts[at, corner, 0] += x
            parts[at, corner, 1] += y
            parts[at, corner, 2] += z
    total = np.empty((count, 3))
    for at in range(count):
        for axis in range(3):
            total[at, axis] = parts[at, 0, axis] + parts[at, 1, axis] + parts[at, 2, axis]
    return total
