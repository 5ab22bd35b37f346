"""Closed surface: a rough closed surface of the limb, also where no photo shows it.

In      points of the limb, and towards which side each of them is seen.
Out     a closed mesh; what of it faces down its axis, which a tube of cells does not have: the back
        of a foot that is held up, a fold, the underside of an arm.
Method  Every point stands for a disc as large as its share of the surface, across the direction in
        which its neighbours spread least. The winding number of these discs (Barill et al. 2018) is
        1 inside and 0 outside. The surface lies where it is a quarter: a half would cut off a part
        of which the photos show one side only, a quarter gives it a body.
Limits  Detail smaller than a thirtieth of the limb is smoothed away. A patch that no photo shows
        and that reaches the lower end is taken for the cut, whatever it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64
from manifold3d import Manifold
from scipy.spatial import KDTree

from limbgram.capture.prediction import incidence_cosines
from limbgram.capture.proxy import ENDS, CoarseSkin
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.lens import View
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh, dots, unit
from limbgram.core.mesh.topology import components_among, find_edges
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.measuring.measurement_pass import MAX_INCIDENCE_DEG

_MOST_POINTS = 2000
"""More of them make the surface no finer, and each costs in every place of the field."""
_NEIGHBOURS = 12
_SMOOTHINGS = 2
"""Times that normals become the mean of their neighbours'."""
_EDGES = 30
"""Edges of the mesh along the longest side."""
_MARGIN = 0.15
"""Round the points, of the longest side: a body may bulge behind them."""
_INSIDE = 0.25
_LEAST_ALIKE = 0.5
"""Cosine between two normals of one side."""
_LEAST_DOWN = np.sin(np.radians(20.0))
"""Of the normal, down the axis: sides of a cone are the tube's own."""
_LOWER_END = 0.1
"""Of the length along the axis."""


def camera_directions(scene: Scene) -> Points3:
    """For each scene point, the sum of the unit rays to the photos that show it."""
    seen = scene.observations
    found = np.zeros((len(scene.points_in_world), 3))
    for photo in scene.placed:
        own = seen.point_idx[seen.photo_idx == photo]
        found[own] += unit(scene.view(photo).centre_in_world - scene.points_in_world[own])
    return found


class ClosedSurface(NamedTuple):
    """A closed mesh, and where it is a guess."""

    mesh: Mesh
    guessed: Bool[np.ndarray, " n"]
    """Vertices that none of the nearest points faces like: the far side of what one side shows."""


def closed_surface(points: Points3, towards: Points3) -> ClosedSurface | None:
    """The closed surface through the points; None where they enclose nothing.

    Args:
        towards: Of each point, a direction to the side from which it is seen.
    """
    every = max(1, -(-len(points) // _MOST_POINTS))
    points, towards = np.ascontiguousarray(points[::every]), towards[::every]
    tree = KDTree(points)
    far, near = tree.query(points, k=min(_NEIGHBOURS, len(points) - 1) + 1)
    far, near = np.asarray(far), np.asarray(near)
    about = points[near] - points[near].mean(axis=1, keepdims=True)
    _, directions = np.linalg.eigh(np.einsum("nki,nkj->nij", about, about))
    normals = directions[:, :, 0]
    normals = np.where(dots(normals, towards)[:, None] < 0, -normals, normals)
    for _ in range(_SMOOTHINGS):
        normals = unit(normals[near].mean(axis=1))
    discs = normals * (np.pi * far[:, -1:] ** 2 / near.shape[1])
    size = float(np.ptp(points, axis=0).max())
    edge = size / _EDGES

    def inside(x: float, y: float, z: float) -> float:
        return _winding_number(points, discs, edge, x, y, z) - _INSIDE

    low, high = points.min(axis=0) - _MARGIN * size, points.max(axis=0) + _MARGIN * size
    solid = Manifold.level_set(inside, [*low, *high], edge)
    if solid.is_empty():
        return None
    found = max(solid.decompose(), key=lambda one: one.volume()).to_mesh()
    vertices = np.asarray(found.vert_properties, np.float64)[:, :3]
    mesh = Mesh(vertices_mm=vertices, faces=np.asarray(found.tri_verts, np.int32))
    _, near = tree.query(vertices, k=near.shape[1])
    alike = np.einsum("ni,nki->nk", mesh.vertex_normals(), normals[np.asarray(near)])
    return ClosedSurface(mesh, alike.max(axis=1) < _LEAST_ALIKE)


@njit(cache=True, nogil=True, fastmath=True)
def _winding_number(
    points: Float64[np.ndarray, "n 3"],
    discs: Float64[np.ndarray, "n 3"],
    soft: float,
    x: float,
    y: float,
    z: float,
) -> float:
    """Winding number of the discs about a place; `soft` smooths the field at the discs."""
    total = 0.0
    for k in range(len(points)):
        a, b, c = points[k, 0] - x, points[k, 1] - y, points[k, 2] - z
        apart2 = a * a + b * b + c * c + soft * soft
        total += (a * discs[k, 0] + b * discs[k, 1] + c * discs[k, 2]) / (apart2 * np.sqrt(apart2))
    return total / (4 * np.pi)


@dataclass(frozen=True)
class Underside:
    """The underside of a limb's closed surface, and what of it is hidden."""

    skin: CoarseSkin
    """`known`: what faces down, but for the lower end."""
    squarely: Int64[np.ndarray, " n"]
    """Photos that show each place well enough to measure it."""
    hidden: Bool[np.ndarray, " n"]
    """What faces down and will not be measured: too few photos show it, or it is a guess."""

    @property
    def share(self) -> float:
        """The hidden part, as a share of the whole surface."""
        area = self.skin.area_mm2
        return float(area[self.hidden].sum() / area.sum())


def find_underside(
    surface: ClosedSurface, axis: Vector3, views: Sequence[View], fewest: int
) -> Underside:
    """The underside of a surface, without the hidden patch that holds the lower end."""
    mesh, vertices = surface.mesh, surface.mesh.vertices_mm
    every = np.ones(len(mesh), bool)
    skin = CoarseSkin(
        mesh=mesh, middle=vertices.mean(0), known=every, area_mm2=mesh.vertex_areas_mm2()
    )
    lowest = np.cos(np.radians(MAX_INCIDENCE_DEG))
    squarely = (incidence_cosines(skin, views) >= lowest).sum(axis=1)
    unmeasured = (squarely < fewest) | surface.guessed
    down = mesh.vertex_normals() @ axis < -_LEAST_DOWN
    height = vertices @ axis
    low, high = np.quantile(height, (ENDS, 1 - ENDS))
    patch = _patch_labels(mesh, unmeasured)
    at_end = np.unique(patch[height < low + _LOWER_END * (high - low)])
    known = down & ~((patch >= 0) & np.isin(patch, at_end))
    return Underside(replace(skin, known=known), squarely, known & unmeasured)


def _patch_labels(mesh: Mesh, part: Bool[np.ndarray, " n"]) -> Int32[np.ndarray, " n"]:
    """The connected patch of each vertex of a part; -1 elsewhere."""
    label = np.full(len(mesh), -1, np.int32)
    label[part] = components_among(part, find_edges(mesh.faces).ends)
    return label
