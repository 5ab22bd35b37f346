"""Deformation fields: how a body bends, by an amount of its own in every photo.

In      normal equations in units of sigma, all but lens deviations and fields eliminated.
Out     what is seen of a field along a course, and which rules of lenses and of single photos it
        does not stand.
Method  Score test (Rao 1948) beside lens deviations of a spread. What fields differ in from photo
        to photo, beyond the course, is the noise.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.reconstruction.mapping.lens_evidence import MOST, OWN, eliminated
from limbgram.reconstruction.mapping.scene import Rule
from limbgram.reconstruction.mapping.score_tests import (
    SIGNIFICANCE_LEVEL,
    SPREAD_MARGIN,
    VERY_STRONG_EVIDENCE,
    NormalEquations,
    ScoreTest,
    f_test_p_value,
    pseudo_inverse,
    solve_semidefinite,
)

Course = Float64[np.ndarray, " p"]
"""How much of a field each photo shows."""


@dataclass(frozen=True)
class FieldEvidence:
    """Normal equations over lens deviations (9 a photo), then fields (`numbers` a photo)."""

    photos: int
    numbers: int
    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]
    facts: int
    """Photos times clusters of points: what is seen independently."""

    @property
    def _lenses(self) -> Int64[np.ndarray, " l"]:
        return np.arange(OWN * self.photos)

    @property
    def _fields(self) -> Int64[np.ndarray, " c"]:
        return np.arange(OWN * self.photos, len(self.right))

    def columns(self, course: Course) -> Float64[np.ndarray, "c k"]:
        """Of fields along a course."""
        return np.kron(course[:, None], np.eye(self.numbers))

    def lenses_beside_fields(self) -> NormalEquations:
        """What is seen of lens deviations where every photo may have a field of its own."""
        return NormalEquations(*eliminated(self.normal, self.right, self._fields, self._lenses))

    def fields(
        self,
        spread: Float64[np.ndarray, "9"],
        free: Float64[np.ndarray, "l k"] | None = None,
    ) -> NormalEquations:
        """What is left of fields among deviations of this spread, and of some that are free."""
        normal, right = self.normal, self.right
        if free is not None:
            whole = np.zeros((len(right), free.shape[1]))
            whole[: len(free)] = free
            beside = NormalEquations(normal, right).eliminating(whole)
            normal, right = beside.normal, beside.right
        normal = normal.copy()
        diagonal = self._lenses
        normal[diagonal, diagonal] += 1.0 / np.tile(spread, self.photos) ** 2
        return NormalEquations(*eliminated(normal, right, self._lenses, self._fields))

    def fall_of_lens(
        self, spread: Float64[np.ndarray, "9"], columns: Float64[np.ndarray, "l k"]
    ) -> float:
        """How far lenses that change so let the sum of squares fall, without any field."""
        lenses = self._lenses
        normal = self.normal[np.ix_(lenses, lenses)].copy()
        drawn = normal.copy()
        drawn[lenses, lenses] += 1.0 / np.tile(spread, self.photos) ** 2
        both = np.column_stack([self.right[lenses], normal])
        solved = normal @ solve_semidefinite(drawn, both)
        left = NormalEquations(normal - solved[:, 1:], self.right[lenses] - solved[:, 0])
        return ScoreTest.of(left.restricted_to(columns)).statistic


@dataclass(frozen=True)
class Along:
    """A field along a course, beside lens deviations of the spread that the capture shows."""

    evidence: FieldEvidence
    spread: Float64[np.ndarray, "9"]
    course: Course
    seen: NormalEquations
    every: ScoreTest
    """Of fields that differ in each photo."""
    one: ScoreTest
    """Of those along the course."""

    @classmethod
    def of(
        cls,
        evidence: FieldEvidence,
        spread: Float64[np.ndarray, "9"],
        course: Course,
        seen: NormalEquations,
        every: ScoreTest,
    ) -> "Along":
        one = ScoreTest.of(seen.restricted_to(evidence.columns(course)))
        return cls(evidence, spread, course, seen, every, one)

    def chance(self, tried: int) -> float:
        return f_test_p_value(self.every, self.one, tried)

    @property
    def rest(self) -> float:
        """Variance of what is left, over that of the adjustments."""
        freedom = self.every.dof - self.one.dof
        return (self.every.statistic - self.one.statistic) / max(freedom, 1)

    @property
    def noise(self) -> float:
        return max(1.0, self.rest)

    @property
    def solved(self) -> tuple[Float64[np.ndarray, " k"], Float64[np.ndarray, "k k"]]:
        """The field's numbers, and their covariance."""
        along, range_ = self.seen.restricted_to(self.evidence.columns(self.course)), self._range
        covariance = pseudo_inverse(along.normal)
        return range_ * covariance @ along.right, self.noise * range_**2 * covariance

    @property
    def _range(self) -> float:
        """Between photos; a course that is alike in all is held against none of it."""
        return float(np.ptp(self.course)) or 1.0

    def failed(self) -> list[Rule]:
        """The rules of lenses and of single photos that it does not stand."""
        wider = self.evidence.fields(np.minimum(SPREAD_MARGIN * self.spread, MOST))
        held: dict[Rule, bool] = {
            "lens": self._beats_lens(),
            "one photo": self._stands_without_any(),
            "lenses of photos": self._stands_among(wider),
        }
        return [rule for rule, holds in held.items() if not holds]

    def _stands_among(self, seen: NormalEquations) -> bool:
        """Whether chance alone does not explain it."""
        one = ScoreTest.of(seen.restricted_to(self.evidence.columns(self.course)))
        return f_test_p_value(ScoreTest.of(seen), one, 1) <= SIGNIFICANCE_LEVEL

    def _beats_lens(self) -> bool:
        """Whether it explains clearly more than lenses that change along its course, and stands
        beside them."""
        changing = np.kron(self.course[:, None], np.eye(OWN))
        by_lens = self.evidence.fall_of_lens(self.spread, changing)
        if (self.one.statistic - by_lens) / self.noise < VERY_STRONG_EVIDENCE:
            return False
        return self._stands_among(self.evidence.fields(self.spread, changing))

    def _stands_without_any(self) -> bool:
        """Whether chance does not explain it either where any one photo may differ by itself."""
        return all(
            self._stands_among(self.seen.eliminating(self.evidence.columns(own)))
            for own in np.eye(self.evidence.photos)
        )
