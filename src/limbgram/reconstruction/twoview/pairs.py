"""Verified pairs: the epipolar geometry of two photos and the matches that obey it.

`fit_sampson` finds any parametrised epipolar geometry by least squares of Sampson distances. Their
derivative by F is exact; F's derivative by its few parameters is a central difference of 3 x 3
matrices.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Literal, Protocol, Self, TypeVar, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.arrays import Matrix3, Points2
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.triangulation import sampson_by_matrix, sampson_px
from limbgram.core.optimisation import Descent, Trial, minimise
from limbgram.reconstruction.matching.matching import PairMatches


@dataclass(frozen=True, kw_only=True)
class VerifiedPair:
    """Two photos whose matches share one epipolar geometry.

    `fundamental` obeys x2^T F x1 = 0 in pixels freed of lens distortion (ideal pixels: K times
    normalized coordinates). `second_from_first` has a translation of unit length; it is None
    where the pair is a pure rotation, and one of two possible poses where it shows a plane.
    """

    matches: PairMatches
    """Only the inliers."""
    fundamental: Matrix3
    second_from_first: Rigid | None
    kind: Literal["general", "planar", "rotation"]
    residual_px: Float64[np.ndarray, " m"]
    """Per match: sqrt((d(x, x^)^2 + d(x', x'^)^2) / 4), the paper's residual of one point."""
    median_angle_deg: float
    """Median intersection angle of the rays."""

    @property
    def rms_residual_px(self) -> float:
        """The paper's residual error function over all inliers."""
        return float(np.sqrt(np.mean(self.residual_px**2)))

    def chosen(self, keep: Bool[np.ndarray, " m"]) -> "VerifiedPair":
        """The pair with some of its matches."""
        return replace(self, matches=self.matches.some(keep), residual_px=self.residual_px[keep])


@dataclass(frozen=True)
class Pairs:
    """All verified pairs, and the number of tried ones that had no common geometry."""

    verified: tuple[VerifiedPair, ...]
    rejected: int


_DESCENT = Descent(iterations=30, smallest_gain=1e-7)
_DIFFERENCE = 1e-6


@runtime_checkable
class EpipolarModel(Protocol):
    """Epipolar geometry with `size` parameters; `moved` takes a small step from it."""

    @property
    def size(self) -> int: ...
    @property
    def matrix(self) -> Matrix3: ...
    def moved(self, step: Float64[np.ndarray, " k"]) -> Self: ...


Model = TypeVar("Model", bound=EpipolarModel)


@dataclass(frozen=True)
class _Fitted(Generic[Model]):
    """A model with its signed distances."""

    model: Model
    residuals: Float64[np.ndarray, " n"]


def fit_sampson(start: Model, xy_first: Points2, xy_second: Points2) -> Model:
    """The model nearby with the least sum of squared Sampson distances."""

    def linearised(state: _Fitted[Model]) -> Callable[[float], Trial[_Fitted[Model]]]:
        model, residuals = state.model, state.residuals
        by_step = sampson_by_matrix(model.matrix, xy_first, xy_second) @ _matrix_by_step(model)
        normal, gradient = by_step.T @ by_step, by_step.T @ residuals

        def step(damping: float) -> Trial[_Fitted[Model]]:
            lifted = normal + damping * np.diag(np.diag(normal) + 1e-12)
            return tried(model.moved(-np.linalg.solve(lifted, gradient)))

        return step

    def tried(model: Model) -> Trial[_Fitted[Model]]:
        residuals = sampson_px(model.matrix, xy_first, xy_second)
        return Trial(_Fitted(model, residuals), float(residuals @ residuals))

    first = tried(start)
    return minimise(first.state, first.cost, linearised, _DESCENT).model


def _matrix_by_step(model: EpipolarModel) -> Float64[np.ndarray, "9 k"]:
    columns: list[np.ndarray] = []
    for step in np.eye(model.size) * _DIFFERENCE:
        change = model.moved(step).matrix - model.moved(-step).matrix
        columns.append(change.ravel() / (2 * _DIFFERENCE))
    return np.column_stack(columns)
