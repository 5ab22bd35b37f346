"""Thickness: the local thickness of a wall, and its thinnest place.

Between two known skins, as the edit `wall` makes them, it is the distance to the closest place on
the other: exact, and blind to the rim that joins them. In a shape of unknown making a ray goes
straight in from each face and ends where it meets a face that looks the other way, and the distance
to that face's plane counts. Rays alone call the acute edges of a raw brim thin: on walls of 3 mm
over three scans they found 0.05, 0.02 and 0.02 mm where the skins come no nearer than 1.36, 2.20
and 2.70 mm; with faces within 18 degrees of each other they find 2.08, 2.44 and 2.80 mm.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Bool, Float64, Int64
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.interval import weighted_quantile
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.rays import intersects_any
from limbgram.core.mesh.topology import components, is_watertight
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.findings import Finding, note

_OPPOSED_COSINE = -0.95
"""Greatest cosine between the normals of two opposite faces of a wall."""
_ACUTE_COSINE = -0.5
"""The same for the two sides of an acute edge (60 degrees)."""
INSET_MM = 1e-3
"""How far below its face a ray starts, so that it misses the face."""
_LONG_SIDE_MM = 3.0
"""Faces with a longer side are sampled in several places."""
_SAMPLE_WEIGHTS = np.array(
    [[1, 1, 1], [8, 1, 1], [1, 8, 1], [1, 1, 8], [4, 4, 1], [1, 4, 4], [4, 1, 4]], np.float64
)
"""Barycentric weights of the samples: the centre first, then near corners and sides."""
_SAMPLED_FACES = 3000
"""Number of faces sampled to tell a wall from a limb."""
_PATCH_MM2, _PATCH_MM = 1.0, 2.0
"""Area that has to be as thin: triangles in an edge that are smaller are no wall; and how far apart
faces of one patch of it lie at most."""
_THICKEST_MM, _THICKEST_SHARE = 20.0, 0.25
"""A shape whose sides lie nearer, in the middle of its area, is a wall: no socket or orthosis is
thicker, and every limb is, against this share of its second largest size."""


@dataclass(frozen=True, kw_only=True)
class Thickness:
    """The thickness of a wall, at each vertex and where it is thinnest."""

    at_vertices_mm: Float64[np.ndarray, " n"]
    """NaN where nothing lies opposite, as on a brim."""
    thinnest_mm: float
    place_mm: Vector3
    """Where that is, in the mesh's frame."""
    median_mm: float
    """Half of the area is thicker."""

    @property
    def point_mm(self) -> tuple[float, ...]:
        """The thinnest place, as findings have it."""
        return tuple(self.place_mm.tolist())

    def finding(self, axes: Literal["file", "limb"]) -> Finding:
        """A note of the thickness; `axes` are those in which the place is given."""
        return note(
            "edit.wall.thickness",
            thinnest_mm=self.thinnest_mm,
            point_mm=self.point_mm,
            axes=axes,
            median_mm=self.median_mm,
        )


@dataclass(frozen=True, kw_only=True)
class Lip:
    """A place where a wall becomes too thin or too narrow."""

    thickness_mm: float
    place_mm: Vector3
    faces: Int64[np.ndarray, " k"]
    """All faces that are thinner than the least."""


def thickness_between_skins(solid: Mesh, first_faces: int, second_faces: int) -> Thickness:
    """The thickness of a solid whose first faces are one skin, the next ones another.

    Args:
        first_faces: Number of faces of the first skin.
        second_faces: Number of faces of the second skin.
    """
    one, two = solid.faces[:first_faces], solid.faces[first_faces : first_faces + second_faces]
    away = np.full(len(solid), np.nan)
    for skin, other in ((one, two), (two, one)):
        used = np.unique(skin)
        tree = TriangleTree.of(solid.vertices_mm, other)
        away[used] = tree.closest(solid.vertices_mm[used]).distances_mm
    thinnest = int(np.nanargmin(away))
    known = np.isfinite(away)
    return Thickness(
        at_vertices_mm=away,
        thinnest_mm=float(away[thinnest]),
        place_mm=solid.vertices_mm[thinnest],
        median_mm=weighted_quantile(away[known], solid.vertex_areas_mm2()[known], 0.5),
    )


def wall_thickness(mesh: Mesh) -> Thickness | None:
    """The thickness of a shape that is a wall; None for one that is not, such as a limb."""
    tried = np.arange(0, len(mesh.faces), max(1, len(mesh.faces) // _SAMPLED_FACES))
    size = float(np.sort(np.ptp(mesh.vertices_mm, axis=0))[1])
    thickest_mm = min(_THICKEST_MM, _THICKEST_SHARE * size)
    if _is_clear(mesh, tried, thickest_mm / -_OPPOSED_COSINE):
        return None
    cast = _InwardRays.of(mesh)
    first = cast.across(tried, cast.corners[tried].mean(1), _OPPOSED_COSINE)
    if not np.median(first) < thickest_mm:
        return None
    least, places = cast.least_across(_OPPOSED_COSINE)
    known = np.isfinite(least)
    at_vertices = np.full(len(mesh), np.inf)
    np.minimum.at(at_vertices, mesh.faces.ravel(), np.repeat(least, 3))
    thinnest = _thinnest_patch(least, cast.areas_mm2)
    return Thickness(
        at_vertices_mm=np.where(np.isfinite(at_vertices), at_vertices, np.nan),
        thinnest_mm=float(least[thinnest]),
        place_mm=places[thinnest],
        median_mm=weighted_quantile(least[known], cast.areas_mm2[known], 0.5),
    )


def solid_wall(mesh: Mesh) -> Thickness | None:
    """The thickness of a wall that is closed all round, its inside too; None for other shapes."""
    return wall_thickness(mesh) if is_watertight(mesh.faces) else None


def thin_lip(solid: Mesh, rim: int, least_mm: float) -> Lip | None:
    """Where a wall ends in a lip or an acute edge thinner than the least; None where it does not.

    One of two opposite faces lies on the rim, which joins the skins; `thickness_between_skins`
    measures between these. Faces count whose normals are opposite to within 60 degrees, and that
    are as thin over more than a sliver: a cut brim has none, a scan's own ragged brim has.

    Args:
        rim: Number of faces of both skins; those after them are the rim.
    """
    cast = _InwardRays.of(solid)
    least, places = cast.least_across(_ACUTE_COSINE, _RimRule(rim))
    return _lip_under(least, places, cast.areas_mm2, least_mm)


def narrow_strip(solid: Mesh, rim: int, least_mm: float) -> Lip | None:
    """Where a wall is narrower along its skins than the least; None where it is not.

    Both of two opposite faces lie on the rim, at two sides of a tongue between notches of a ragged
    edge, or of what is left between two openings. From skin to skin it is as thick there as
    elsewhere.

    Args:
        rim: Number of faces of both skins; those after them are the rim.
    """
    cast = _InwardRays.of(solid)
    across, places = cast.least_across(_OPPOSED_COSINE, _RimRule(rim, faces_on_rim=2))
    return _lip_under(across, places, cast.areas_mm2, least_mm)


def _lip_under(
    across_mm: Float64[np.ndarray, " f"],
    places_mm: Points3,
    areas_mm2: Float64[np.ndarray, " f"],
    least_mm: float,
) -> Lip | None:
    """The faces across which there is less than the least, over a patch that counts."""
    thin = np.flatnonzero(across_mm < least_mm)
    thin = thin[_in_patches(places_mm[thin], areas_mm2[thin])]
    if not len(thin):
        return None
    one = int(thin[across_mm[thin].argmin()])
    return Lip(thickness_mm=float(across_mm[one]), place_mm=places_mm[one], faces=thin)


class _RimRule(NamedTuple):
    """Which faces are the rim between the skins, and how many of two opposite ones must be rim."""

    first: int = 0
    """The faces from here on are the rim's."""
    faces_on_rim: int = 1


_ANY_FACES = _RimRule()


@dataclass(frozen=True)
class _InwardRays:
    """Rays through a mesh, inwards along the normals of its faces."""

    scene: EmbreeScene
    corners: Float64[np.ndarray, "f 3 3"]
    normals: Points3
    areas_mm2: Float64[np.ndarray, " f"]

    @classmethod
    def of(cls, mesh: Mesh) -> "_InwardRays":
        corners = mesh.vertices_mm[mesh.faces]
        weighted = mesh.face_normals()
        scene = EmbreeScene()
        TriangleMesh(scene, corners.astype(np.float32))
        return cls(scene, corners, unit(weighted), np.linalg.norm(weighted, axis=1) / 2)

    def least_across(
        self, opposed: float, rim: _RimRule = _ANY_FACES
    ) -> tuple[Float64[np.ndarray, " f"], Points3]:
        """The least distance across from each face (infinite if none), and its place there."""
        first = rim.first if rim.faces_on_rim == 2 else 0
        corners = self.corners
        sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(1)
        least = np.full(len(corners), np.inf)
        places = corners.mean(1)
        for k, share in enumerate(_SAMPLE_WEIGHTS / _SAMPLE_WEIGHTS.sum(1, keepdims=True)):
            looked = np.flatnonzero(sides > _LONG_SIDE_MM) if k else np.arange(len(corners))
            looked = looked[looked >= first]
            points = np.einsum("k,fkd->fd", share, corners[looked])
            reach = self.across(looked, points, opposed, rim)
            nearer = reach < least[looked]
            least[looked[nearer]] = reach[nearer]
            places[looked[nearer]] = points[nearer]
        return least, places

    def across(
        self,
        looked: Int64[np.ndarray, " k"],
        points: Points3,
        opposed: float,
        rim: _RimRule = _ANY_FACES,
    ) -> Float64[np.ndarray, " k"]:
        """Distance of a place on each face from the plane of the opposite face."""
        inward = -self.normals[looked]
        start = (points + INSET_MM * inward).astype(np.float32)
        met = np.asarray(self.scene.run(start, inward.astype(np.float32)))
        facing = np.einsum("fd,fd->f", self.normals[looked], self.normals[met])
        drop = np.einsum("fd,fd->f", self.corners[met, 0] - points, self.normals[met])
        on_rim = (looked >= rim.first) * 1 + (met >= rim.first)
        counts = (met >= 0) & (facing < opposed) & (on_rim >= rim.faces_on_rim)
        return np.where(counts, np.maximum(drop, 0.0), np.inf)


def _in_patches(places_mm: Points3, areas_mm2: Float64[np.ndarray, " n"]) -> Bool[np.ndarray, " n"]:
    """Which faces lie with others in a patch of enough area to count.

    Corners of the triangles of an edge are thin everywhere; over a whole brim they add up.
    """
    if not len(places_mm):
        return np.zeros(0, np.bool_)
    near = KDTree(places_mm).query_pairs(_PATCH_MM, output_type="ndarray")
    patch = components(near, len(places_mm))
    return np.asarray(np.bincount(patch, areas_mm2)[patch] >= _PATCH_MM2)


def _is_clear(mesh: Mesh, tried: Int64[np.ndarray, " k"], reach_mm: float) -> bool:
    """Whether most rays inwards from these faces hit nothing within a reach, as in a limb.

    The tree takes a tenth of the time of the rays' own scene.
    """
    inward = -unit(mesh.face_normals()[tried])
    starts = mesh.vertices_mm[mesh.faces[tried]].mean(1) + INSET_MM * inward
    return bool(intersects_any(tree_on(mesh), starts, reach_mm * inward).mean() < 0.5)


def _thinnest_patch(
    thickness_mm: Float64[np.ndarray, " f"], areas_mm2: Float64[np.ndarray, " f"]
) -> int:
    """The face up to whose thickness enough area is that thin: no single sliver."""
    order = np.argsort(thickness_mm, kind="stable")
    order = order[np.isfinite(thickness_mm[order])]
    passed = np.cumsum(areas_mm2[order])
    return int(order[min(int(np.searchsorted(passed, _PATCH_MM2)), len(order) - 1)])
