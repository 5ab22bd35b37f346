"""Mirroring: whether the mirror image of a shape fits another one much better than it does itself.

Only shapes that fit badly are asked, so a limb that is nearly its own mirror image is no suspect.
"""

from dataclasses import replace

import numpy as np

from limbgram.shape.comparing.counterparts import Ground
from limbgram.shape.comparing.registration.icp import Fit, IcpOptions, settle
from limbgram.shape.comparing.registration.searching import FINE, places_of, tried_starts
from limbgram.shape.comparing.registration.starts import width_mm
from limbgram.shape.limb import Limb

_SUSPECT = 0.005
"""Distance, as a share of the width, from which shapes fit badly enough to ask."""
_BETTER = 0.5
_ACROSS = np.array([-1.0, 1.0, 1.0])


def about_mirrors(
    first: Limb, second: Limb, ground: Ground, fit: Fit, brim_mm: float, icp: IcpOptions
) -> tuple[str, ...]:
    """A hint where the mirror image of the second fits the first far better."""
    if not fit.rms_mm > _SUSPECT * width_mm(first.mesh.vertices_mm):
        return ()
    mirrored = replace(
        second,
        mesh=replace(
            second.mesh,
            vertices_mm=second.mesh.vertices_mm * _ACROSS,
            faces=second.mesh.faces[:, ::-1].copy(),
        ),
    )
    best, _ = tried_starts(first, mirrored, ground, brim_mm, icp)
    image = settle(places_of(mirrored, FINE, brim_mm), ground, best.first_from_second, icp)
    if not (image.rms_mm < _BETTER * fit.rms_mm and image.cost_mm < _BETTER * fit.cost_mm):
        return ()
    return (
        f"The mirror image of the second shape fits much better ({image.rms_mm:.2f} mm RMS against "
        f"{fit.rms_mm:.2f}): one of the two is mirrored, or they are a left and a right limb.",
    )
