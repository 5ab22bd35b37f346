"""Verified pairs: the epipolar geometry of two photos and its inlier matches.

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
from limbgram.core.geometry.triangulation import sampson_jacobian, sampson_px
from limbgram.core.interval import rms
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
        return rms(self.residual_px)

    def chosen(self, keep: Bool[np.ndarray, " m"]) -> "VerifiedPair":
        """The pair with some of its matches."""
        return replace(self, matches=self.matches.some(keep), residual_px=self.residual_px[keep])


@dataclass(frozen=True)
class Pairs:
    """All verified pairs, and the number of pairs without an epipolar geometry."""

    verified: tuple[VerifiedPair, ...]
    rejected: int


_DESCENT = Descent(iterations=30, smallest_gain=1e-7)

TURNS: Float64[np.ndarray, "3 3 3"] = np.cross(np.eye(3)[:, None], np.eye(3)).transpose(0, 2, 1)
"""What a small turn about each axis adds to the identity: TURNS[i] @ x is e_i x x."""


@runtime_checkable
class EpipolarModel(Protocol):
    """A parametrised epipolar geometry; `moved` applies a small step of its parameters."""

    @property
    def matrix(self) -> Matrix3: ...
    @property
    def by_step(self) -> Float64[np.ndarray, "k 3 3"]:
        """Derivatives of the matrix, up to multiples of itself, which move no match."""
        ...

    def moved(self, step: Float64[np.ndarray, " k"]) -> Self: ...


Model = TypeVar("Model", bound=EpipolarModel)


@dataclass(frozen=True)
class _Fitted(Generic[Model]):
    """A model with its signed Sampson distances."""

    model: Model
    residuals: Float64[np.ndarray, " n"]


def fit_sampson(start: Model, xy_first: Points2, xy_second: Points2) -> Model:
    """The model that minimises the sum of squared Sampson distances, from a start near by."""

    def linearised(state: _Fitted[Model]) -> Callable[[float], Trial[_Fitted[Model]]]:
        model, residuals = state.model, state.residuals
        by_matrix = sampson_jacobian(model.matrix, xy_first, xy_second)
        by_step = by_matrix @ model.by_step.reshape(-1, 9).T
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
