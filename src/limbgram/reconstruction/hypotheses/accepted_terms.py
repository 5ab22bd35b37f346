"""Accepted terms: the terms that the forward selection has accepted so far, and what they leave."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.core.interval import length_within
from limbgram.reconstruction.hypotheses.lens_spread import SecondBodyEquations
from limbgram.reconstruction.hypotheses.terms import Term
from limbgram.reconstruction.mapping.body_motion import MOTION_SIZE
from limbgram.reconstruction.mapping.score_tests import ScoreTest, pseudo_inverse


@dataclass(frozen=True)
class AcceptedTerms:
    """Significant terms, with the equations at the lens spread estimated beside them."""

    terms: tuple[Term, ...]
    second_body: SecondBodyEquations
    p_values: tuple[float, ...]
    """By term, when it was accepted."""
    candidates: tuple[int, ...]
    """By term, how many of its kind were tried."""

    @property
    def columns(self) -> Float64[np.ndarray, "m k"]:
        """Design matrix of all terms."""
        return design_matrix(self.terms, self.second_body.photos)

    def columns_without(self, term: Term) -> Float64[np.ndarray, "m k"]:
        """Design matrix of the other terms."""
        others = [one for one in self.terms if one is not term]
        return design_matrix(others, self.second_body.photos)

    @property
    def lack_of_fit(self) -> ScoreTest:
        """Test of all motions that the terms leave unexplained."""
        return ScoreTest.of(self.second_body.of_motion.eliminating(self.columns))

    def motions(self, is_fact: Sequence[bool]) -> Float64[np.ndarray, "n 6"]:
        """By photo, the motion that the terms that are facts add up to."""
        columns = self.columns
        if not columns.shape[1]:
            return np.zeros((self.second_body.photos, MOTION_SIZE))
        equations = self.second_body.of_motion.restricted_to(columns)
        values = pseudo_inverse(equations.normal) @ equations.right
        kept = np.repeat(is_fact, [one.columns.shape[1] for one in self.terms])
        return (columns[:, kept] @ values[kept]).reshape(-1, MOTION_SIZE)


def design_matrix(terms: Sequence[Term], photos: int) -> Float64[np.ndarray, "m k"]:
    """Columns of all terms side by side, over the motions of all photos."""
    return np.hstack([np.zeros((MOTION_SIZE * photos, 0)), *(one.columns for one in terms)])


@dataclass(frozen=True)
class Effect:
    """Size of a displacement, with its interval of 95 %."""

    size: float
    low: float
    high: float


def largest_displacement(
    motion: Float64[np.ndarray, "6"], covariance: Float64[np.ndarray, "6 6"], radius: float
) -> Effect:
    """Largest displacement of a point within this radius by a rotation and a shift."""
    weights = np.array([radius] * 3 + [1.0] * 3)
    return Effect(*length_within(weights * motion, covariance * np.outer(weights, weights)))
