"""Deformation fields: how a body deforms, by an amount of its own in every photo.

In      normal equations in units of sigma, all but lens deviations and fields eliminated.
Out     the score test of a field along a course, and the rules of lenses and of single photos that
        it fails.
Method  Score test (Rao 1948) beside lens deviations of a given spread. What the fields of single
        photos differ by beyond the course is the noise.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.reconstruction.mapping.lens_equations import DEVIATION_SIZE, MAX_SPREAD, eliminate
from limbgram.reconstruction.mapping.scene import Rule
from limbgram.reconstruction.mapping.score_tests import (
    SPREAD_MARGIN,
    VERY_STRONG_EVIDENCE,
    NormalEquations,
    ScoreTest,
    f_test_p_value,
    is_significant,
    pseudo_inverse,
    solve_semidefinite,
)

Course = Float64[np.ndarray, " p"]
"""How much of a field each photo shows."""


@dataclass(frozen=True)
class FieldEquations:
    """Normal equations over lens deviations (9 a photo), then fields (`numbers` a photo)."""

    photos: int
    numbers: int
    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]
    sample_size: int
    """Number of independent observations: clusters of points times photos."""

    @property
    def _lens_rows(self) -> Int64[np.ndarray, " l"]:
        return np.arange(DEVIATION_SIZE * self.photos)

    @property
    def _field_rows(self) -> Int64[np.ndarray, " c"]:
        return np.arange(DEVIATION_SIZE * self.photos, len(self.right))

    def columns(self, course: Course) -> Float64[np.ndarray, "c k"]:
        """Design columns of a field along a course."""
        return np.kron(course[:, None], np.eye(self.numbers))

    def of_lenses(self) -> NormalEquations:
        """The equations over lens deviations, with a free field in every photo eliminated."""
        return NormalEquations(
            *eliminate(self.normal, self.right, self._field_rows, self._lens_rows)
        )

    def of_fields(
        self,
        spread: Float64[np.ndarray, "9"],
        free: Float64[np.ndarray, "l k"] | None = None,
    ) -> NormalEquations:
        """The equations over the fields, with lens deviations of this spread marginalised.

        Args:
            free: Directions of the lens deviations without a prior.
        """
        normal, right = self.normal, self.right
        if free is not None:
            columns = np.zeros((len(right), free.shape[1]))
            columns[: len(free)] = free
            remaining = NormalEquations(normal, right).eliminating(columns)
            normal, right = remaining.normal, remaining.right
        normal, rows = normal.copy(), self._lens_rows
        normal[rows, rows] += 1.0 / np.tile(spread, self.photos) ** 2
        return NormalEquations(*eliminate(normal, right, rows, self._field_rows))

    def lens_statistic(
        self, spread: Float64[np.ndarray, "9"], columns: Float64[np.ndarray, "l k"]
    ) -> float:
        """Score statistic of lenses that change along these columns, without any field."""
        rows = self._lens_rows
        normal = self.normal[np.ix_(rows, rows)].copy()
        with_prior = normal.copy()
        with_prior[rows, rows] += 1.0 / np.tile(spread, self.photos) ** 2
        both = np.column_stack([self.right[rows], normal])
        solved = normal @ solve_semidefinite(with_prior, both)
        remaining = NormalEquations(normal - solved[:, 1:], self.right[rows] - solved[:, 0])
        return ScoreTest.of(remaining.restricted_to(columns)).statistic


@dataclass(frozen=True)
class FieldTest:
    """Score test of a field along a course, beside lens deviations of a given spread."""

    equations: FieldEquations
    spread: Float64[np.ndarray, "9"]
    course: Course
    of_fields: NormalEquations
    each_photo: ScoreTest
    """Of a field of its own in each photo."""
    along_course: ScoreTest
    """Of one field along the course."""

    @classmethod
    def of(
        cls,
        equations: FieldEquations,
        spread: Float64[np.ndarray, "9"],
        course: Course,
        of_fields: NormalEquations,
        each_photo: ScoreTest,
    ) -> "FieldTest":
        """The test of one course; `of_fields` and `each_photo` are the same for all courses."""
        along_course = ScoreTest.of(of_fields.restricted_to(equations.columns(course)))
        return cls(equations, spread, course, of_fields, each_photo, along_course)

    def p_value(self, candidates: int) -> float:
        """The best of so many courses counted."""
        return f_test_p_value(self.each_photo, self.along_course, candidates)

    @property
    def residual_variance(self) -> float:
        """Variance factor of what the course leaves unexplained."""
        dof = self.each_photo.dof - self.along_course.dof
        return (self.each_photo.statistic - self.along_course.statistic) / max(dof, 1)

    @property
    def noise(self) -> float:
        """The residual variance, but never below what the equations assume."""
        return max(1.0, self.residual_variance)

    @property
    def estimate(self) -> tuple[Float64[np.ndarray, " k"], Float64[np.ndarray, "k k"]]:
        """The field's numbers over the range of the course, and their covariance."""
        equations = self.of_fields.restricted_to(self.equations.columns(self.course))
        covariance, range_ = pseudo_inverse(equations.normal), self._range
        return range_ * covariance @ equations.right, self.noise * range_**2 * covariance

    @property
    def _range(self) -> float:
        """Range of the course over the photos; 1 for a course that is constant."""
        return float(np.ptp(self.course)) or 1.0

    def failed_rules(self) -> list[Rule]:
        """The rules of lenses and of single photos that it fails."""
        wider = self.equations.of_fields(np.minimum(SPREAD_MARGIN * self.spread, MAX_SPREAD))
        passed: dict[Rule, bool] = {
            "lens": self._beats_lens(),
            "one photo": self._is_significant_without_any_photo(),
            "lenses of photos": self._is_significant_in(wider),
        }
        return [rule for rule, passes in passed.items() if not passes]

    def _is_significant_in(self, of_fields: NormalEquations) -> bool:
        return is_significant(of_fields, self.equations.columns(self.course))

    def _beats_lens(self) -> bool:
        """Whether it explains clearly more than lenses that change along its course, and is
        significant beside them."""
        changing = np.kron(self.course[:, None], np.eye(DEVIATION_SIZE))
        by_lens = self.equations.lens_statistic(self.spread, changing)
        if (self.along_course.statistic - by_lens) / self.noise < VERY_STRONG_EVIDENCE:
            return False
        return self._is_significant_in(self.equations.of_fields(self.spread, changing))

    def _is_significant_without_any_photo(self) -> bool:
        """Whether it is significant whichever photo has a field of its own."""
        return all(
            self._is_significant_in(self.of_fields.eliminating(self.equations.columns(own)))
            for own in np.eye(self.equations.photos)
        )
