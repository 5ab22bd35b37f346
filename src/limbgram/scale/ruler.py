"""Rulers: known lengths, measured in the unit of the scene."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.photos.photo import SetAside


@dataclass(frozen=True, kw_only=True)
class RulerLength:
    """One known length, as it is in the scene."""

    label: str
    known_mm: float
    measured: float
    """In scene units."""
    sigma: float
    """In scene units: one standard deviation of the measured length."""
    role: Literal["control", "check"]


@dataclass(frozen=True, kw_only=True)
class Ruler:
    """What one source of known lengths says about the scale."""

    units_per_mm: float
    relative_sigma: float
    lengths: tuple[RulerLength, ...]
    set_aside: tuple[SetAside, ...]


def jackknife_sigma(replicates: Float64[np.ndarray, " p"]) -> float:
    """Standard deviation of a figure from its values without each photo in turn (Tukey 1958).

    It holds whatever a photo's errors have in common, such as its pose.
    """
    count = len(replicates)
    return float(np.sqrt((count - 1) / count * np.sum((replicates - replicates.mean()) ** 2)))
