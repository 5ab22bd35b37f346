"""Starts: poses from which a surface may find another when nobody says how they lie."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.geometry.rigid import Rigid

_TURNS = 8
_SAME_MM = 5.0
"""Starts nearer to each other than this along the axis count as one."""
_END_SHARE = 0.005


@dataclass(frozen=True)
class _Trunk:
    """A shape's middle and main directions, the longest last."""

    middle: Vector3
    axes: Matrix3
    """Columns; right-handed."""
    ends_mm: Float64[np.ndarray, "2"]
    """Lowest and highest place along the last axis, from the middle."""


def possible_starts(first_mm: Points3, second_mm: Points3) -> list[Rigid]:
    """Poses first_from_second: as the files lie, and long axis on long axis both ways round,

    turned in steps, with the middles, the lower ends or the upper ends together.
    """
    first, second = _trunk(first_mm), _trunk(second_mm)
    starts = [Rigid.identity()]
    for flip in (np.eye(3), np.diag([1.0, -1.0, -1.0])):
        low, high = second.ends_mm if flip[2, 2] > 0 else -second.ends_mm[::-1]
        shifts = [0.0]
        for shift in (first.ends_mm[0] - low, first.ends_mm[1] - high):
            if min(abs(shift - other) for other in shifts) > _SAME_MM:
                shifts.append(float(shift))
        for turn in 2 * np.pi * np.arange(_TURNS) / _TURNS:
            about = Rigid.from_rotation_vector(np.array([0, 0, turn]), np.zeros(3)).rotation
            rotation = first.axes @ about @ flip @ second.axes.T
            for shift in shifts:
                middle = first.middle + shift * first.axes[:, 2]
                starts.append(Rigid(rotation, middle - rotation @ second.middle))
    return starts


def width_mm(places_mm: Points3) -> float:
    """Mean diameter across the long axis, however the shape lies; exact for a tube."""
    across = np.linalg.eigvalsh(np.cov(places_mm.T))[:2].sum()
    return 2 * float(np.sqrt(max(across, 1e-18)))


def _trunk(points_mm: Points3) -> _Trunk:
    middle = points_mm.mean(0)
    _, axes = np.linalg.eigh(np.cov((points_mm - middle).T))
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    along = (points_mm - middle) @ axes[:, 2]
    return _Trunk(middle, axes, np.quantile(along, [_END_SHARE, 1 - _END_SHARE]))
