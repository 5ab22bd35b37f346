"""Volume alignment: the second shape slid along the long axis until it holds the same volume.

In      both surfaces, the second as it was laid by its shape, in the first's limb frame.
Out     how far it slides, and the height up to which the volumes agree.
Method  as a limb sinks into a socket until it fills it: below the lower of the two brims both hold
        the same. The difference falls steadily with the slide, so one root is all there is.
Fails   MeasureError: the distal end is open, or no slide makes the volumes equal.
"""

from dataclasses import dataclass

import numpy as np

from limbgram.errors import MeasureError
from limbgram.shape.comparing.frames import brim_height_mm
from limbgram.shape.measures.levels.figures import Sigmas
from limbgram.shape.measures.levels.volumes import DISTAL_END, Volumes
from limbgram.surface.mesh import Mesh

_CLEAR_MM = 1e-3
"""Kept below the brim, so that the level is whole."""
_FARTHEST_MM = 60.0
_CLOSE_MM = 1e-9


@dataclass(frozen=True, kw_only=True)
class Slide:
    """Along the first's long axis, positive proximally."""

    shift_mm: float
    height_mm: float
    """In the first's limb frame: below it both hold the same volume."""


def slide_to_volume(first_in_limb: Mesh, second_in_limb: Mesh) -> Slide:
    """The slide after which both hold the same volume below the lower brim."""
    first, second = _measured(first_in_limb), _measured(second_in_limb)
    first_top, second_top = brim_height_mm(first_in_limb), brim_height_mm(second_in_limb)

    def level(shift_mm: float) -> float:
        return min(first_top, second_top + shift_mm) - _CLEAR_MM

    def excess(shift_mm: float) -> float:
        height = level(shift_mm)
        return (
            second.between(DISTAL_END, height - shift_mm).value
            - first.between(DISTAL_END, height).value
        )

    from scipy.optimize import brentq  # a twentieth of a second, for this way of aligning alone

    length = min(np.ptp(mesh.vertices_mm[:, 2]) for mesh in (first_in_limb, second_in_limb))
    reach = min(_FARTHEST_MM, 0.4 * float(length))
    if excess(-reach) * excess(reach) > 0:
        raise MeasureError(
            f"No slide along the axis within {reach:.0f} mm makes the volumes equal. The shapes "
            "differ too much for it: align by icp or by landmarks."
        )
    shift_mm = float(np.asarray(brentq(excess, -reach, reach, xtol=_CLOSE_MM)))
    return Slide(shift_mm=shift_mm, height_mm=level(shift_mm))


def _measured(mesh: Mesh) -> Volumes:
    return Volumes.of(Sigmas.of(mesh))
