"""Bundle adjustment: photos, lenses and points together, with what calibration knows as a prior.

In      a scene close to its solution, and the calibrations its lenses start from.
Out     the scene of the least robust sum of squares, without observations that contradict it.
Method  Levenberg-Marquardt on pixels through the whole lens model, points eliminated (Schur
        complement), Cauchy weights; each lens is drawn to its calibration by the inverse of that
        calibration's covariance, so that a board's well-known focal length stays and its poorly
        known principal point may move. Parameters of zero variance are held.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64
from scipy.linalg import cho_factor, cho_solve

from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE
from limbgram.core.optimisation import Descent, Trial, minimise
from limbgram.core.run import track
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.body import Body, BodyEquations
from limbgram.reconstruction.mapping.bundle import Bundle
from limbgram.reconstruction.mapping.normals import point_steps, reduce_equations, robust_cost
from limbgram.reconstruction.mapping.scene import Scene

_ITERATIONS = 40
_ROUGH_GAIN = 1e-3
_FINE_GAIN = 1e-5
_CAUCHY_SIGMAS = 2.5
_GAUGE_FREEDOM = 7
_SHARED_ERROR = 3.0
"""How much less the residuals tell about photos and lenses than if all were independent.

Neighbouring keypoints share window matches and shading. With 1 instead, 72,000 observations of
0.044 px moved a focal length known to 0.13 px from 0.24 to 0.51 px beside the truth (foot_ring24),
and centres of eight captures were 1.7 to 4.5 of their sigmas off.
"""


_State = tuple[Bundle, Body | None]


@dataclass(frozen=True)
class Adjusted:
    """The adjusted scene and what the residuals say about the measurements."""

    scene: Scene
    sigma_px: float
    """Standard deviation of a measured coordinate, robustly from the residuals."""
    covariance: Float64[np.ndarray, "u u"]
    """Of placed photos and lenses together, zero where held; see Scene.camera_covariance."""

    @property
    def lens_covariance(self) -> Float64[np.ndarray, "c 10 10"]:
        """Of every camera's lens after the adjustment; zero where held."""
        cameras = len(self.scene.cameras)
        first = len(self.covariance) - LENS_SIZE * cameras
        rows = [slice(first + LENS_SIZE * k, first + LENS_SIZE * (k + 1)) for k in range(cameras)]
        return np.array([self.covariance[part, part] for part in rows])


def adjust(
    scene: Scene,
    priors: Sequence[Calibration],
    *,
    hold_board_lenses: bool = False,
    outlier_sigmas: float = 4.0,
    rounds: int = 3,
    body: Body | None = None,
) -> Adjusted:
    """Adjust; after each round drop observations over `outlier_sigmas` and points left too weak.

    A `body` of known shape takes part with the corners that photos show of it.
    """
    prior = _Prior.of(priors, hold_board_lenses)
    bundle = Bundle.of(scene)
    sigma_px = bundle.sigma_px(scene)
    for attempt in track(range(rounds)):
        last = attempt == rounds - 1
        gain = _FINE_GAIN if last else _ROUGH_GAIN
        bundle, body = _descend(bundle, body, prior, sigma_px, gain)
        sigma_px = bundle.sigma_px(scene)
        bundle = bundle.without_outliers(scene, outlier_sigmas * sigma_px)
    equations = _Equations.at(bundle, body, prior, sigma_px, 0.0)
    return Adjusted(bundle.scene(scene), sigma_px, equations.covariance())


@dataclass(frozen=True)
class _Prior:
    """Lens parameters as calibrated, their information, and which of them may move."""

    packed: Float64[np.ndarray, " l"]
    information: Float64[np.ndarray, "l l"]
    free: Bool[np.ndarray, " l"]

    @classmethod
    def of(cls, priors: Sequence[Calibration], hold_board_lenses: bool) -> "_Prior":
        size = LENS_SIZE * len(priors)
        information, free = np.zeros((size, size)), np.zeros(size, bool)
        for idx, given in enumerate(priors):
            if given.source == "board" and hold_board_lenses:
                continue
            moves = np.flatnonzero(given.sigmas > 0)
            rows = moves + LENS_SIZE * idx
            scale = np.outer(given.sigmas[moves], given.sigmas[moves])
            correlation = given.covariance[np.ix_(moves, moves)] / scale
            inverse = np.linalg.pinv(correlation, rcond=1e-9, hermitian=True)
            information[np.ix_(rows, rows)] = inverse / scale
            free[rows] = True
        return cls(np.concatenate([given.camera.packed for given in priors]), information, free)

    def offset(self, bundle: Bundle) -> Float64[np.ndarray, " l"]:
        """Calibrated minus present lens parameters."""
        packed = self.packed.copy()
        for photo, idx in enumerate(bundle.lens_idx):
            packed[LENS_SIZE * idx : LENS_SIZE * (idx + 1)] = bundle.views[photo, 12:]
        return self.packed - packed

    def cost(self, bundle: Bundle) -> float:
        offset = self.offset(bundle)
        return float(offset @ self.information @ offset)


def _cost(bundle: Bundle, body: Body | None, prior: _Prior, sigma_px: float) -> float:
    measured = robust_cost(
        bundle.views,
        bundle.photo_idx,
        bundle.bounds,
        bundle.xy_px,
        bundle.points,
        _CAUCHY_SIGMAS * sigma_px,
    )
    of_body = 0.0 if body is None else body.cost(bundle, _SHARED_ERROR)
    return measured / (_SHARED_ERROR * sigma_px) ** 2 + prior.cost(bundle) + of_body


def _descend(
    bundle: Bundle, body: Body | None, prior: _Prior, sigma_px: float, smallest_gain: float
) -> _State:
    """Least squares until a step gains less than `smallest_gain` of the cost."""

    def linearised(state: _State) -> Callable[[float], Trial[_State]]:
        def step(damping: float) -> Trial[_State]:
            trial = _Equations.at(*state, prior, sigma_px, damping).solved(*state)
            return Trial(trial, _cost(*trial, prior, sigma_px))

        return step

    return minimise(
        (bundle, body),
        _cost(bundle, body, prior, sigma_px),
        linearised,
        Descent(iterations=_ITERATIONS, smallest_gain=smallest_gain, damping=1e-4),
    )


@dataclass(frozen=True)
class _Equations:
    """Reduced normal equations of photos and lenses, prior included, in units of sigma."""

    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]
    free: Bool[np.ndarray, " u"]
    sigma_px: float
    damping: float
    of_body: BodyEquations | None

    @classmethod
    def at(
        cls, bundle: Bundle, body: Body | None, prior: _Prior, sigma_px: float, damping: float
    ) -> "_Equations":
        size = bundle.unknowns
        normal, right, diagonal = np.empty((size, size)), np.empty(size), np.empty(size)
        reduce_equations(
            bundle.views,
            bundle.lens_idx,
            bundle.photo_idx,
            bundle.bounds,
            bundle.xy_px,
            bundle.points,
            _CAUCHY_SIGMAS * sigma_px,
            damping,
            normal,
            right,
            diagonal,
        )
        lens = slice(POSE_SIZE * len(bundle.views), size)
        free = np.ones(size, bool)
        free[lens] = prior.free
        variance = (_SHARED_ERROR * sigma_px) ** 2
        normal, right, diagonal = normal / variance, right / variance, diagonal / variance
        normal[lens, lens] += prior.information
        right[lens] += prior.information @ prior.offset(bundle)
        diagonal[lens] += np.diag(prior.information)
        normal[np.arange(size), np.arange(size)] += damping * diagonal
        of_body = None if body is None else body.equations(bundle, _SHARED_ERROR)
        if of_body is not None:
            more, more_right = of_body.of_cameras()
            normal, right = normal + more, right + more_right
        return cls(normal, right, free, sigma_px, damping, of_body)

    def solved(self, bundle: Bundle, body: Body | None) -> tuple[Bundle, Body | None]:
        """Bundle and body after the step that solves these equations.

        Raises:
            LinAlgError: a photo lost all its observations.
        """
        step = np.zeros(len(self.right))
        weights = np.diag(self.normal)[self.free]
        if not (weights > 0.0).all():
            raise np.linalg.LinAlgError("nothing is observed that would hold a photo or a lens")
        scale = 1.0 / np.sqrt(weights)
        scaled = self.normal[np.ix_(self.free, self.free)] * np.outer(scale, scale)
        step[self.free] = scale * cho_solve(cho_factor(scaled), scale * self.right[self.free])
        points = np.empty_like(bundle.points)
        point_steps(
            bundle.views,
            bundle.lens_idx,
            bundle.photo_idx,
            bundle.bounds,
            bundle.xy_px,
            bundle.points,
            _CAUCHY_SIGMAS * self.sigma_px,
            self.damping,
            step,
            points,
        )
        if body is not None and self.of_body is not None:
            body = body.moved(*self.of_body.follow(step))
        return bundle.moved(step, points), body

    def covariance(self) -> Float64[np.ndarray, "u u"]:
        """Of photos and lenses: seven directions of the world's frame carry nothing."""
        covariance = np.zeros_like(self.normal)
        both = np.ix_(self.free, self.free)
        covariance[both] = _pseudo_inverse(self.normal[both])
        return covariance


def _pseudo_inverse(normal: Float64[np.ndarray, "m m"]) -> Float64[np.ndarray, "m m"]:
    """Inverse less the seven directions of the world's own frame."""
    scale = 1.0 / np.sqrt(np.diag(normal))
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    known = slice(_GAUGE_FREEDOM, None)
    inverse = (vectors[:, known] / values[known]) @ vectors[:, known].T
    return inverse * np.outer(scale, scale)
