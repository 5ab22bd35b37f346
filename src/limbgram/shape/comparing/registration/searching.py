"""Searching: the best of many starts where nobody says how two shapes lie to each other.

In      two Limbs, the first also as a Ground.
Out     the best Fit, and whether another pose does nearly as well.
Fails   MeasureError: a shape has no measured surface away from its brim.
"""

import numpy as np

from limbgram.errors import MeasureError
from limbgram.geometry.arrays import Points3
from limbgram.geometry.rigid import angle_between_deg
from limbgram.shape.comparing.counterparts import Ground, measured_faces
from limbgram.shape.comparing.registration.icp import FEWEST, Fit, IcpOptions, settle
from limbgram.shape.comparing.registration.starts import possible_starts
from limbgram.shape.comparing.sampling import sample_evenly
from limbgram.shape.limb import Limb

COARSE, MIDDLE, FINE = 300, 1500, 10_000
"""Places on the second surface while starts are tried, while the best compete, and at last."""
_KEPT = 3
_RIVAL_COST, _RIVAL_DEG = 1.05, 10.0


def tried_starts(
    first: Limb, second: Limb, ground: Ground, brim_mm: float, icp: IcpOptions
) -> tuple[Fit, bool]:
    """The best fit of many starts, and whether another one does nearly as well."""
    coarse_mm, middle_mm = places_of(second, COARSE, brim_mm), places_of(second, MIDDLE, brim_mm)
    quick = IcpOptions(tolerance_mm=0.05, max_rounds=10, cap_mm=icp.cap_mm)
    starts = possible_starts(places_of(first, MIDDLE, brim_mm), middle_mm)
    fits = sorted(
        (settle(coarse_mm, ground, start, quick) for start in starts),
        key=lambda fit: fit.cost_mm,
    )
    apart: list[Fit] = []
    for fit in fits:
        if len(apart) < _KEPT and all(_turned(fit, other) for other in apart):
            apart.append(fit)
    longer = IcpOptions(tolerance_mm=0.01, max_rounds=40, cap_mm=icp.cap_mm)
    better = sorted(
        (settle(middle_mm, ground, fit.first_from_second, longer) for fit in apart),
        key=lambda fit: fit.cost_mm,
    )
    best = better[0]
    rival = any(
        other.cost_mm < _RIVAL_COST * best.cost_mm and _turned(best, other) for other in better[1:]
    )
    return best, rival


def _turned(one: Fit, other: Fit) -> bool:
    turn = angle_between_deg(one.first_from_second.rotation, other.first_from_second.rotation)
    return turn > _RIVAL_DEG


def places_of(limb: Limb, count: int, brim_mm: float) -> Points3:
    """Evenly spread places that were measured and lie away from the brim."""
    samples = sample_evenly(limb.mesh, count)
    kept = measured_faces(limb.mesh, brim_mm)[samples.faces]
    if np.count_nonzero(kept) < FEWEST:
        raise MeasureError(
            f"{limb.name or 'A shape'} has no measured surface farther than {brim_mm:g} mm "
            "from its open edges. Leave less of the brim out, or fill its holes."
        )
    return samples.points_mm[kept]
