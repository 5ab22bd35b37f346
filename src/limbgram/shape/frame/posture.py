"""Posture: a limb's mesh in its limb frame, and back."""

from limbgram.errors import MeasureError
from limbgram.geometry.arrays import Points3
from limbgram.shape.limb import Limb, LimbFrame
from limbgram.surface.mesh import Mesh


def in_limb_frame(limb: Limb) -> Mesh:
    """The mesh with its vertices in the limb frame.

    Raises:
        MeasureError: the limb is not aligned.
    """
    return limb.mesh.with_vertices(frame_of(limb).limb_from_mesh.apply(limb.mesh.vertices_mm))


def with_vertices_in_limb(limb: Limb, vertices_in_limb_mm: Points3) -> Limb:
    """The limb with its vertices moved to places given in the limb frame."""
    mesh_from_limb = frame_of(limb).limb_from_mesh.inverse
    return limb.with_mesh(limb.mesh.with_vertices(mesh_from_limb.apply(vertices_in_limb_mm)))


def frame_of(limb: Limb) -> LimbFrame:
    """The limb's frame.

    Raises:
        MeasureError: the limb is not aligned.
    """
    if limb.frame is None:
        raise MeasureError(
            "The limb is not aligned, so nobody knows where its axis runs. Run `limbgram align` "
            "first."
        )
    return limb.frame
