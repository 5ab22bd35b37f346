"""Search result: what the search for relative motion of two bodies found."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.reconstruction.mapping.scene import Deviation, Explanation


@dataclass(frozen=True, kw_only=True)
class SearchResult:
    """The ranked explanations, and the motion that those which are facts add up to."""

    explanations: tuple[Explanation, ...]
    """The highest score first."""
    photos: tuple[int, ...]
    motions: Float64[np.ndarray, "n 6"]
    """Of the second body in these photos: rotation and shift about the first body's centre."""
    course_known: bool = True
    """Whether no other course explains nearly as much as the facts do."""
    instead_of_lenses: tuple[Deviation, ...] = ()
    """As `Movement` has it."""

    @property
    def facts(self) -> tuple[Explanation, ...]:
        """Explanations that pass all rules."""
        return tuple(one for one in self.explanations if one.is_fact)

    @property
    def undecided(self) -> tuple[Explanation, ...]:
        """Explanations that fail a rule, and would matter if they were true."""
        return tuple(one for one in self.explanations if one.is_undecided)

    @property
    def verdict(self) -> Literal["still", "moved", "undecided"]:
        """What is said of the two bodies."""
        if self.facts:
            return "moved"
        return "undecided" if self.undecided else "still"
