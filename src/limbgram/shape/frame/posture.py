"""Posture: a limb's mesh in its limb frame, and back."""

from limbgram.errors import MeasureError
from limbgram.geometry.arrays import Points3
from limbgram.geometry.rigid import Rigid
from limbgram.shape.limb import Limb
from limbgram.surface.mesh import Mesh


def in_limb_frame(limb: Limb) -> Mesh:
    """The mesh with its vertices in the limb frame.

    Raises:
        MeasureError: the limb is not aligned.
    """
    return limb.mesh.with_vertices(_frame(limb).apply(limb.mesh.vertices_mm))


def with_vertices_in_limb(limb: Limb, vertices_in_limb_mm: Points3) -> Limb:
    """The limb with its vertices moved to places given in the limb frame."""
    return limb.with_mesh(limb.mesh.with_vertices(_frame(limb).inverse.apply(vertices_in_limb_mm)))


def _frame(limb: Limb) -> Rigid:
    if limb.frame is None:
        raise MeasureError(
            "The limb is not aligned, so nobody knows where its axis runs. Run `limbgram align` "
            "first."
        )
    return limb.frame.limb_from_mesh
