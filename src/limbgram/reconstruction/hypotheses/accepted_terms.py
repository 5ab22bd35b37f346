"""Accepted terms: those that a search keeps so far, and the residuals that they leave."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.core.interval import length_within
from limbgram.reconstruction.hypotheses.evidence import MOVE
from limbgram.reconstruction.hypotheses.spread import Left
from limbgram.reconstruction.hypotheses.terms import Term
from limbgram.reconstruction.mapping.score_tests import ScoreTest, pseudo_inverse


@dataclass(frozen=True)
class Found:
    """Terms that chance does not explain, and what is left."""

    terms: tuple[Term, ...]
    left: Left
    chances: tuple[float, ...]
    candidates: tuple[int, ...]

    @property
    def columns(self) -> Float64[np.ndarray, "m k"]:
        return columns_of(self.terms, self.left.photos)

    def others(self, term: Term) -> Float64[np.ndarray, "m k"]:
        return columns_of([one for one in self.terms if one is not term], self.left.photos)

    @property
    def rest(self) -> ScoreTest:
        return ScoreTest.of(self.left.only(self.left.motion).eliminating(self.columns))

    def motions(self, told: Sequence[bool]) -> Float64[np.ndarray, "n 6"]:
        """By photo, of the terms that are facts."""
        columns = self.columns
        if not columns.shape[1]:
            return np.zeros((self.left.photos, MOVE))
        seen = self.left.only(self.left.motion).restricted_to(columns)
        values = pseudo_inverse(seen.normal) @ seen.right
        kept = np.repeat(told, [one.columns.shape[1] for one in self.terms])
        return (columns[:, kept] @ values[kept]).reshape(-1, MOVE)


def columns_of(terms: Sequence[Term], photos: int) -> Float64[np.ndarray, "m k"]:
    return np.hstack([np.zeros((MOVE * photos, 0)), *(one.columns for one in terms)])


@dataclass(frozen=True)
class Effect:
    size: float
    low: float
    high: float


def motion_size(
    motion: Float64[np.ndarray, "6"], covariance: Float64[np.ndarray, "6 6"], radius: float
) -> Effect:
    weight = np.array([radius] * 3 + [1.0] * 3)
    moved = weight * motion
    spread = covariance * np.outer(weight, weight)
    return Effect(*length_within(moved, spread))
