"""Spread: how much the lens differs from photo to photo, by the capture itself.

In      an Evidence, and columns of motions that are taken for granted.
Out     the spread of each number of a photo's lens deviation, and what is left of the evidence
        once these deviations are expected to be of that spread.
Method  Restricted maximum likelihood (Patterson and Thompson 1971): poses, lenses and motions are
        flat, deviations are normal about nought, and the variance of each number maximises the
        likelihood of what is left. It is bounded by what single photos of real cameras do
        (`lens_deviations.WIDE`); where the photos tell nothing of it, it is that of a usual phone.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.reconstruction.hypotheses.evidence import MOVE, Evidence
from limbgram.reconstruction.mapping.lens_evidence import MOST, OWN, USUAL
from limbgram.reconstruction.mapping.score_tests import (
    NormalEquations,
    estimate_spread,
    solve_semidefinite,
)


@dataclass(frozen=True)
class Left:
    """Equations over what the second body alone sees of each lens, and over its motion."""

    photos: int
    spread: Float64[np.ndarray, "9"]
    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]

    @property
    def lens(self) -> slice:
        return slice(0, OWN * self.photos)

    @property
    def motion(self) -> slice:
        return slice(OWN * self.photos, (OWN + MOVE) * self.photos)

    def only(self, part: slice) -> NormalEquations:
        return NormalEquations(self.normal[part, part], self.right[part])


def left_of(evidence: Evidence, spread: Float64[np.ndarray, "9"]) -> Left:
    """What is left where deviations of every photo's lens are expected to be of this spread."""
    own, rest = evidence.own, slice(evidence.own.stop, len(evidence.right))
    normal = evidence.normal[own, own].copy()
    normal[np.diag_indices_from(normal)] += 1.0 / np.tile(spread, len(evidence.photos)) ** 2
    cross = evidence.normal[rest, own]
    solved = solve_semidefinite(normal, np.column_stack([evidence.right[own], cross.T]))
    return Left(
        photos=len(evidence.photos),
        spread=spread,
        normal=evidence.normal[rest, rest] - cross @ solved[:, 1:],
        right=evidence.right[rest] - cross @ solved[:, 0],
    )


def spread_of(
    evidence: Evidence, granted: Float64[np.ndarray, "m k"] | None = None
) -> Float64[np.ndarray, "9"]:
    """The spread that the capture shows.

    Args:
        granted: Columns of motions, 6 a photo, that are free.
    """
    return estimate_spread(seen_of_lenses(evidence, granted), USUAL, MOST).spread


def seen_of_lenses(
    evidence: Evidence, granted: Float64[np.ndarray, "m k"] | None = None
) -> NormalEquations:
    """What is seen of all photos' lens deviations; `granted` as `spread_of` has it."""
    own = evidence.own
    every = NormalEquations(evidence.normal, evidence.right)
    if granted is not None and granted.shape[1]:
        columns = np.zeros((len(evidence.right), granted.shape[1]))
        columns[evidence.motion] = granted
        every = every.eliminating(columns)
    return NormalEquations(every.normal[own, own], every.right[own])
