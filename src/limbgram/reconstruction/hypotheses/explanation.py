"""Explanation: the result of the search for two bodies."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.reconstruction.mapping.scene import Deviation, Explanation


@dataclass(frozen=True, kw_only=True)
class Explained:
    """The ranked list, and the motion that its terms make."""

    explanations: tuple[Explanation, ...]
    """The highest score first."""
    photos: tuple[int, ...]
    motions: Float64[np.ndarray, "n 6"]
    """Of the second body in these photos: turn and shift about the first body's middle."""
    instead_of_lenses: tuple[Deviation, ...] = ()
    """As `Movement` has it."""

    @property
    def told(self) -> tuple[Explanation, ...]:
        """Facts."""
        return tuple(one for one in self.explanations if one.told)

    @property
    def undecided(self) -> tuple[Explanation, ...]:
        """What may be, and would matter if it were."""
        return tuple(one for one in self.explanations if one.open_)

    @property
    def verdict(self) -> Literal["still", "moved", "undecided"]:
        if self.told:
            return "moved"
        return "undecided" if self.undecided else "still"
