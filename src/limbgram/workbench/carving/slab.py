"""Slab: the part of a surface between two heights, its volume, and how far it lies from another."""

from dataclasses import dataclass

import numpy as np

from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.edits.cutting import keep_positive


@dataclass(frozen=True, kw_only=True)
class SurfaceDistance:
    """Unsigned distance of a surface from another, weighted by area."""

    max_mm: float
    rms_mm: float
    area_mm2: float

    def __or__(self, other: "SurfaceDistance") -> "SurfaceDistance":
        """The distance of two parts of a surface together."""
        area = self.area_mm2 + other.area_mm2
        squares = self.rms_mm**2 * self.area_mm2 + other.rms_mm**2 * other.area_mm2
        return SurfaceDistance(
            max_mm=max(self.max_mm, other.max_mm),
            rms_mm=float(np.sqrt(squares / area)),
            area_mm2=area,
        )


def clip_between_heights(mesh: Mesh, low_mm: float, high_mm: float) -> Mesh:
    """The surface between two heights, its triangles cut; open where it is cut."""
    for height_mm, up in ((low_mm, 1.0), (high_mm, -1.0)):
        mesh = keep_positive(mesh, up * (mesh.vertices_mm[:, 2] - height_mm)).mesh
    return mesh


_SIDES = (
    "front", "front and right", "right", "back and right",
    "back", "back and left", "left", "front and left",
)  # fmt: skip
"""Of the patient, clockwise seen from above."""


@dataclass(frozen=True, kw_only=True)
class UncarvedTop:
    """The part of a shape above the last carved row, which is not carved."""

    last_mm: float
    """Height of that row."""
    rise_mm: float
    """Of the shape's highest point over it."""
    theta_deg: float
    """Of that point, from the front towards the patient's right."""
    share: float
    """Part of the shape's surface that lies above."""

    @property
    def side(self) -> str:
        """The side of the highest point, for people."""
        return _SIDES[round(self.theta_deg / 360 * len(_SIDES)) % len(_SIDES)]


def uncarved_top(mesh: Mesh, last_mm: float) -> UncarvedTop:
    """The uncarved part above a row, of a mesh in the limb frame."""
    x, y, high_mm = mesh.vertices_mm[np.argmax(mesh.vertices_mm[:, 2])].tolist()
    return UncarvedTop(
        last_mm=last_mm,
        rise_mm=max(0.0, high_mm - last_mm),
        theta_deg=float(np.degrees(np.arctan2(x, y))) % 360,
        share=clip_between_heights(mesh, last_mm, high_mm).area_mm2() / mesh.area_mm2(),
    )


def volume_between_mm3(part: Mesh) -> float:
    """Volume of a clipped surface closed by level planes.

    The flux of (x, 0, 0) through a level plane is nothing, so the planes need not be there.
    """
    corners = part.vertices_mm[part.faces]
    return float((corners[:, :, 0].mean(1) * part.face_normals()[:, 0]).sum() / 2)


def distance_to(part: Mesh, target: Mesh) -> SurfaceDistance:
    """Distance of a surface from another, at its vertices and face centres."""
    tree = TriangleTree.of(target.vertices_mm, target.faces)
    at_vertices = tree.closest(part.vertices_mm).distances_mm
    at_middles = tree.closest(part.vertices_mm[part.faces].mean(1)).distances_mm
    areas = np.linalg.norm(part.face_normals(), axis=1) / 2
    # Exact for quadrics: 1/12 of the area at each corner, 3/4 in the middle.
    squares = (at_vertices[part.faces] ** 2).sum(1) / 12 + 0.75 * at_middles**2
    return SurfaceDistance(
        max_mm=float(max(at_vertices.max(), at_middles.max())),
        rms_mm=float(np.sqrt((squares * areas).sum() / areas.sum())),
        area_mm2=float(areas.sum()),
    )
