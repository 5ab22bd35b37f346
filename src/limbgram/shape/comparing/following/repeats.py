"""Repeats: several captures of one unchanged limb, and how far they lie apart."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from limbgram.errors import MeasureError
from limbgram.shape.comparing.comparing import CompareOptions
from limbgram.shape.comparing.following.repeatability import (
    BlandAltman,
    Repeatability,
    bland_altman,
    repeatability,
)
from limbgram.shape.comparing.following.stack import Stack, stack
from limbgram.shape.limb import Limb


@dataclass(frozen=True, kw_only=True)
class Repeats:
    """Figures of captures of one limb."""

    names: tuple[str, ...]
    stack: Stack
    volume: Repeatability
    """mm3."""
    girths: Repeatability
    """mm, over all levels that every capture has."""
    agreement: BlandAltman | None
    """Of the girths of two captures; None where there are more."""

    @property
    def sentence(self) -> str:
        mean = float(self.stack.volumes_mm3.mean())
        icc = self.girths.icc_2_1
        return (
            f"{len(self.names)} captures: two volumes of this limb differ by less than "
            f"{self.volume.coefficient / 1000:.1f} mL ({self.volume.coefficient / mean:.2%}), two "
            f"girths by less than {self.girths.coefficient:.2f} mm, 95 times of 100"
            + ("." if icc is None else f"; ICC(2,1) of the girths {icc:.4f}.")
        )


def repeats(limbs: Sequence[Limb], options: CompareOptions) -> Repeats:
    """Repeatability of captures, all laid on the first.

    Raises:
        MeasureError: no level is whole in every capture.
    """
    unchanged = replace(options.registration, mostly_unchanged=True)
    scans = stack(limbs, replace(options, registration=unchanged))
    whole = np.isfinite(scans.tapes_mm).all(0)
    if not whole.any():
        raise MeasureError(
            "No level is whole in every capture, so girths cannot be compared. Fill the holes of "
            "the scans, or choose another spacing of levels."
        )
    tapes = scans.tapes_mm[:, whole]
    pair = len(limbs) == 2 and tapes.shape[1] >= 2
    return Repeats(
        names=tuple(limb.name for limb in limbs),
        stack=scans,
        volume=repeatability(scans.volumes_mm3[None, :]),
        girths=repeatability(tapes.T),
        agreement=bland_altman(tapes[0], tapes[1]) if pair else None,
    )
