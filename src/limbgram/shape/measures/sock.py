"""The sock: its thickness is taken off before anything is measured on the skin."""

from dataclasses import replace

import numpy as np

from limbgram.errors import OptionsError
from limbgram.shape.edits.offset import offset
from limbgram.shape.edits.presets import THICKEST_SOCK_MM
from limbgram.shape.limb import Limb
from limbgram.surface.closest import TriangleTree


def without_sock(limb: Limb, sock_mm: float) -> Limb:
    """The limb with the surface moved inwards by the sock; landmarks go along.

    What was taken off before counts: asking for the same sock again changes nothing.

    Raises:
        OptionsError: a thickness that no sock has, or less than was taken off already.
        EditError: the surface would cut through itself.
    """
    if not 0 <= sock_mm <= THICKEST_SOCK_MM:
        raise OptionsError(
            f"A sock of {sock_mm:g} mm cannot be. Give its thickness as worn, in millimetres: "
            "about 0.3 for a nylon sheath, 2.3 for a thick terry sock."
        )
    if sock_mm < limb.sock_mm:
        raise OptionsError(
            f"{limb.sock_mm:g} mm of sock were taken off this surface already; {sock_mm:g} mm is "
            "asked for now. Leave --sock out, or start from the scan."
        )
    if sock_mm == limb.sock_mm:
        return limb
    mesh = offset(limb.mesh, limb.sock_mm - sock_mm)
    marks = limb.landmarks
    if marks:
        tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
        places = tree.closest(np.stack([mark.position_mm for mark in marks])).points_mm
        marks = tuple(replace(mark, position_mm=place.copy()) for mark, place in zip(marks, places))
    return replace(limb, mesh=mesh, landmarks=marks, sock_mm=sock_mm)
