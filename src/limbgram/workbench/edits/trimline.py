"""Trimline: the limb cut along a curve drawn on its surface; a wall is cut straight through."""

from dataclasses import replace

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Bool, Float64

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.topology import with_faces
from limbgram.workbench.edits.cutting import Part, keep_positive
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.regions import (
    Curve,
    FrameName,
    Place,
    draw_curve,
    find_sides,
    on_surface,
    points_in_limb_frame,
    position_mm,
    refined_along,
    require_ring,
    section_centres_mm,
)
from limbgram.workbench.edits.thickness import INSET_MM, solid_wall
from limbgram.workbench.limb import Limb

_EDGE_MM = 1.5
"""Edges along a trimline before it is cut."""
_NORMAL_SMOOTHING = 1.0
"""Thicknesses of a wall over which the directions through it are smoothed along a trimline: on a
rough scan they would cross."""
_MOST_THICKNESSES = 3.0
"""Greatest distance through a wall, in thicknesses; beyond, there is no wall."""


@edit(
    group="cuts",
    order=2,
    effect=Effect(reports_displacement=False, volume="cuts"),
    rarely=("positions_in",),
    example={"through": ["fibula head", [1.0, 2.5, 3.0], "patellar tendon"]},
)
class Trimline(Edit):
    """Cut along a closed curve drawn on the surface."""

    through: tuple[Place, ...]
    """Points in order round the limb, on the surface; the curve through them is smooth."""
    keep: Part = "distal"
    """Which part stays."""
    positions_in: FrameName = "limb"
    """Frame of coordinates."""

    words = spoken(
        en=Words(
            name="Trimline",
            title="The trimline",
            labels={"keep": "Which part stays"},
            choices={"distal": "the distal part", "proximal": "the proximal part"},
        ),
        de=Words(
            name="Randlinie",
            title="Die Randlinie",
            does="Längs einer geschlossenen, auf die Fläche gezeichneten Linie schneiden.",
            labels={
                "through": "Durch die Punkte",
                "keep": "Welcher Teil bleibt",
                "positions_in": "Koordinaten gelten",
            },
            help={
                "through": "Punkte der Reihe nach um das Gliedmaß, auf der Fläche; die Linie durch "
                "sie ist glatt.",
                "keep": "Welcher Teil bleibt.",
                "positions_in": "Koordinatensystem der Punkte.",
            },
            choices={"distal": "der distale Teil", "proximal": "der proximale Teil"},
        ),
    )

    def check(self) -> None:
        require_ring(self.through)

    def apply(self, limb: Limb) -> Limb:
        """Cut along a curve; triangles across it are split, so the new brim follows it.

        Raises:
            EditError: the curve does not part the surface in two.
        """
        picked = np.stack([position_mm(limb, place, self.positions_in) for place in self.through])
        curves = _cut_curves(limb, picked)
        fine = limb.mesh
        for curve in curves:
            fine = refined_along(fine, curve, _EDGE_MM)
        sides = find_sides(fine, curves)
        heights = points_in_limb_frame(limb.with_mesh(fine))[:, 2]
        left_is_kept = _left_is_kept(fine, sides.left, heights, self.keep)
        apart = np.where(
            np.isfinite(sides.signed_mm), sides.signed_mm, np.where(sides.left, 1e3, -1e3)
        )
        cut = keep_positive(fine, apart if left_is_kept else -apart)
        return limb.with_mesh(cut.mesh)


def _cut_curves(limb: Limb, picked_mm: Points3) -> tuple[Curve, ...]:
    """The curve through the points; of a wall also where a cut straight through it comes out.

    Of a wall the curve is drawn on the outside, on whichever side of it its points lie.
    """
    mesh = limb.mesh
    wall = solid_wall(mesh)
    if wall is None:
        return (draw_curve(mesh, on_surface(limb, picked_mm)),)
    from scipy.ndimage import gaussian_filter1d  # a tenth of a second, for walls alone

    outside = with_faces(mesh, mesh.faces[_faces_outward(limb)])
    on_it = on_surface(limb.with_mesh(outside), picked_mm)
    curve = draw_curve(outside, on_it)
    step_mm = curve.length_mm / len(curve.points_mm)
    normals = gaussian_filter1d(
        curve.normals, _NORMAL_SMOOTHING * wall.median_mm / step_mm, 0, mode="wrap"
    )
    across = replace(curve, normals=unit(normals))
    return across, replace(across, points_mm=_other_side_mm(mesh, across, wall.median_mm))


def _faces_outward(limb: Limb) -> Bool[np.ndarray, " f"]:
    """Faces of a wall that look away from the middle of the limb."""
    points = points_in_limb_frame(limb)
    corners = points[limb.mesh.faces]
    places = corners.mean(1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(((places - section_centres_mm(limb, places)) * normals).sum(1) > 0)


def _other_side_mm(mesh: Mesh, curve: Curve, usual_mm: float) -> Points3:
    """Where straight lines inwards from a curve leave a wall on the other side.

    Raises:
        EditError: it is no wall there.
    """
    scene = EmbreeScene()
    TriangleMesh(scene, mesh.vertices_mm[mesh.faces].astype(np.float32))
    starts = curve.points_mm - INSET_MM * curve.normals
    ways = -curve.normals
    met = np.asarray(scene.run(starts.astype(np.float32), ways.astype(np.float32)))
    corners = mesh.vertices_mm[mesh.faces[met]]
    normals = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    leaving = (ways * normals).sum(1)
    reach_mm = ((corners[:, 0] - starts) * normals).sum(1) / np.where(leaving > 0, leaving, np.nan)
    lost = ~((met >= 0) & (reach_mm < _MOST_THICKNESSES * usual_mm))
    if lost.any():
        point_mm = tuple(curve.points_mm[int(lost.argmax())].tolist())
        raise EditError("edit.trimline.no_wall", point_mm=point_mm)
    return starts + reach_mm[:, None] * ways


def _left_is_kept(
    mesh: Mesh, left: Bool[np.ndarray, " n"], heights: Float64[np.ndarray, " n"], keep: Part
) -> bool:
    """Whether the part left of the curve is the one to keep, by the mean heights of both."""
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    middle, share = heights[mesh.faces].mean(1), left[mesh.faces].mean(1)
    of_left = (areas * share * middle).sum() / (areas * share).sum()
    of_right = (areas * (1 - share) * middle).sum() / (areas * (1 - share)).sum()
    return bool((of_left > of_right) == (keep == "proximal"))
