"""Sole: a foot's vertices in the frame of its plantar plane, for edits of the plantar side.

x to the lateral side on both feet, y forwards along the foot from the heel, z up from the plantar
plane. Lengths of the foot's own stand beside it, so that an edit is told by shares of the foot.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.errors import EditError, MeasureError
from limbgram.core.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.workbench.anatomy.kind import Midpoint
from limbgram.workbench.edits.refinement import refine_where
from limbgram.workbench.edits.regions import displaced
from limbgram.workbench.limb import Limb

_PLANTAR_COSINE = 0.25
"""Normals that point down by less than this do not belong to the sole."""
SOLE_PLACES = (
    *("plantar", "foot", "lateral", "heel"),
    *("first metatarsal head", "fifth metatarsal head", "navicular"),
)
"""Directions and landmarks by which a sole is edited."""
_LOW_SHARE, _EDGE_SHARE, _FINEST_MM = 0.4, 0.015, 1.0
"""Height up to which the foot is refined, and edge length there, as shares of heel to ball."""


@dataclass(frozen=True, kw_only=True)
class Sole:
    """A foot in the frame of its plantar plane, refined near the sole."""

    limb: Limb
    rotation: Matrix3
    origin_mm: Vector3
    points_mm: Points3
    """The mesh's vertices: lateral, forward, up."""
    normals: Points3
    length_mm: float
    """From the heel to the ball."""
    medial_mm: float
    """x of the first metatarsal head; negative."""
    lateral_mm: float
    """x of the fifth."""
    arch: Vector3
    """Place of the navicular, in this frame."""

    @classmethod
    def of(cls, limb: Limb) -> "Sole":
        """The frame of a foot.

        Raises:
            EditError: a landmark that it goes by is missing, or the side is not said.
        """
        try:
            anatomy = limb.anatomy
            up, forward = anatomy.axis("plantar"), anatomy.axis("foot").direction
            rotation = np.stack([anatomy.axis("lateral").direction, forward, up.direction])
            heel = anatomy.at(Midpoint(("heel",)))
            origin = heel - up.direction * ((heel - up.point_mm) @ up.direction)
            marks = [
                rotation @ (anatomy.at(Midpoint((name,))) - origin)
                for name in ("first metatarsal head", "fifth metatarsal head", "navicular")
            ]
        except MeasureError as error:
            raise EditError("edit.repose.not_told", reason=error.finding) from error
        length_mm = float((marks[0][1] + marks[1][1]) / 2)
        high = (limb.mesh.vertices_mm - origin) @ rotation[2]
        low = np.asarray((high < _LOW_SHARE * length_mm)[limb.mesh.faces].any(1))
        limb = limb.with_mesh(
            refine_where(limb.mesh, low, max(_EDGE_SHARE * length_mm, _FINEST_MM))
        )
        return cls(
            limb=limb,
            rotation=rotation,
            origin_mm=origin,
            points_mm=(limb.mesh.vertices_mm - origin) @ rotation.T,
            normals=limb.mesh.vertex_normals() @ rotation.T,
            length_mm=length_mm,
            medial_mm=float(marks[0][0]),
            lateral_mm=float(marks[1][0]),
            arch=marks[2],
        )

    @classmethod
    def over_marked_places(cls, limb: Limb) -> "Sole":
        """The frame of a foot whose heights count from the places marked under it.

        Raises:
            EditError: as `of`; or one of the places under heel and metatarsal heads is not marked,
                without which the plane lies up to 25 mm above the sole.
        """
        try:
            limb.anatomy.axis("sole")
        except MeasureError as error:
            raise EditError("edit.repose.not_told", reason=error.finding) from error
        return cls.of(limb)

    @property
    def plantar(self) -> Bool[np.ndarray, " n"]:
        """Vertices that look down, below the navicular."""
        low = self.points_mm[:, 2] < max(float(self.arch[2]), 0.0)
        return low & (self.normals[:, 2] < -_PLANTAR_COSINE)

    def moved(self, steps_mm: Points3) -> Limb:
        """The limb with its vertices moved by steps in this frame."""
        return displaced(self.limb, self.limb.mesh.vertices_mm + steps_mm @ self.rotation)


def bump(share: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    """A smooth bump: 1 at 0, falling to 0 with zero slope at -1 and 1."""
    x = np.clip(np.abs(share), 0, 1)
    return (1 - x * x) ** 2


def normalised(share: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    """Values scaled so that their maximum is 1."""
    return share / max(float(share.max(initial=0.0)), 1e-9)
