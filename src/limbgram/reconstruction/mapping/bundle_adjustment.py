"""Bundle adjustment: photos, lenses and points together, with what calibration knows as a prior.

In      a scene close to its solution, and the calibrations its lenses start from.
Out     the scene of the least robust sum of squares, without observations that contradict it.
Method  Levenberg-Marquardt on pixels through the whole lens model, points eliminated (Schur
        complement), Cauchy weights; each lens has its calibration as a Gaussian prior, so that a
        board's well-known focal length stays and its poorly known principal point may move.
        Parameters of zero variance are fixed. A lens that no board calibrated stays monotonic over
        its whole picture (monotonic_lens.py).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.linalg import block_diag, cho_factor, cho_solve

from limbgram.core.geometry.frames import SIMILARITY_SIZE
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE
from limbgram.core.optimisation import Descent, Trial, minimise
from limbgram.core.run import track
from limbgram.reconstruction.calibration.cameras import Calibration, with_square_pixels
from limbgram.reconstruction.mapping.body import Body, BodyEquations
from limbgram.reconstruction.mapping.bundle import CAUCHY_SIGMAS, Bundle
from limbgram.reconstruction.mapping.bundle_equations import (
    point_steps,
    reduce_equations,
    robust_cost,
)
from limbgram.reconstruction.mapping.lens_deviations import PhotoLenses
from limbgram.reconstruction.mapping.monotonic_lens import LinearConstraint, MonotonicityConstraints
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.mapping.score_tests import pseudo_inverse, solve_semidefinite

_ITERATIONS = 40
_ROUGH_GAIN = 1e-3
_FINE_GAIN = 1e-5
OUTLIER_SIGMAS = 4.0
"""Residual, in sigmas, beyond which an observation is an outlier."""
_ALMOST_NONE = 1e-8
"""Relative damping that keeps equations with a free world frame solvable."""
_CONSTRAINT_ROUNDS = 8
"""How often a step is solved again with further monotonicity constraints."""
_GAUGE = 1e-6
"""Share of the largest eigenvalue below which a motion is a gauge freedom of the scene."""
SIGMA_INFLATION = 3.0
"""Factor on the residuals' sigma, because neighbouring observations are not independent.

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
    lens_covariance: Float64[np.ndarray, "c lens lens"]
    """Of every camera's lens after the adjustment; zero where held."""


class UnconstrainedPhotos(np.linalg.LinAlgError):
    """Some photos lost all their observations."""

    def __init__(self, photos: tuple[int, ...]) -> None:
        super().__init__(f"nothing is observed that would hold photos {photos}")
        self.photos = photos


def adjust(
    scene: Scene,
    priors: Sequence[Calibration],
    *,
    hold_board_lenses: bool = False,
    outlier_sigmas: float = OUTLIER_SIGMAS,
    rounds: int = 3,
    body: Body | None = None,
    solve_own: bool = False,
) -> Adjusted:
    """Bundle adjustment, without weak points and, after each round, without outliers.

    A `body` of known shape takes part with the corners that photos show of it. Lens deviations of
    photos (`Scene.own`) are fixed, or with `solve_own` solved for.

    Raises:
        UnconstrainedPhotos: photos lost all their observations.
    """
    prior = LensPrior.of(priors, hold_board_lenses)
    bundle = Bundle.of(scene).without_weak_points()
    if scene.own is not None:
        cameras = [given.camera for given in priors]
        bundle = replace(bundle, photo_lenses=PhotoLenses.of(scene, cameras, solve=solve_own))
    if body is None:
        _require_observations(bundle, scene)
    sigma_px = bundle.sigma_px(scene)
    for attempt in track(range(rounds)):
        last = attempt == rounds - 1
        gain = _FINE_GAIN if last else _ROUGH_GAIN
        bundle, body = _descend(bundle, body, prior, sigma_px, gain)
        sigma_px = bundle.sigma_px(scene)
        bundle = _with_estimated_spread(bundle, body, prior, sigma_px)
        bundle = bundle.without_outliers(scene, sigma_px, outlier_sigmas)
        if body is None:
            _require_observations(bundle, scene)
    covariance = _Equations.at(bundle, body, prior, sigma_px, 0.0).covariance()
    first, cameras = POSE_SIZE * len(bundle.views), len(scene.cameras)
    rows = [slice(first + LENS_SIZE * k, first + LENS_SIZE * (k + 1)) for k in range(cameras)]
    of_lenses = np.array([covariance[part, part] for part in rows])
    if bundle.photo_lenses is not None:
        covariance = bundle.photo_lenses.jacobian @ (bundle.photo_lenses.jacobian @ covariance).T
    return Adjusted(bundle.scene(scene), sigma_px, covariance, of_lenses)


def _require_observations(bundle: Bundle, scene: Scene) -> None:
    """Raise if a photo has no observation."""
    seen = np.bincount(bundle.photo_idx, minlength=len(bundle.views))
    if not seen.all():
        raise UnconstrainedPhotos(
            tuple(scene.placed[k] for k in np.flatnonzero(seen == 0).tolist())
        )


def _with_estimated_spread(
    bundle: Bundle, body: Body | None, prior: "LensPrior", sigma_px: float
) -> Bundle:
    """The bundle with the spread of its lens deviations re-estimated."""
    photo_lenses = bundle.photo_lenses
    if photo_lenses is None or not photo_lenses.is_solved:
        return bundle
    covariance = _Equations.at(bundle, body, prior, sigma_px, 0.0).covariance()
    variance = np.diag(covariance)[-photo_lenses.values.size :].reshape(photo_lenses.values.shape)
    return replace(bundle, photo_lenses=photo_lenses.with_estimated_spread(variance))


def rotation_sigma_deg(scene: Scene, photo: int) -> float:
    """Standard deviation of a placed photo's rotation, with the other photos and all lenses fixed.

    About the axis of which least is known. Without a calibration all photos of a part of a ring
    turn with the focal length, by a degree from end to end: that is left out here.
    """
    bundle = Bundle.of(scene)
    first = POSE_SIZE * scene.placed.index(photo)
    own = np.arange(first, first + POSE_SIZE)
    normal = _ObservationEquations.at(bundle, bundle.sigma_px(scene), 0.0).only(own).normal
    scale = np.outer(*[1.0 / np.sqrt(np.diag(normal))] * 2)
    rotation = (np.linalg.inv(normal * scale) * scale)[:3, :3]
    return float(np.degrees(np.sqrt(np.linalg.eigvalsh(rotation)[-1])))


def score_statistics(
    scenes: Sequence[Scene], priors: Sequence[Calibration], sigma_px: float, observations: int
) -> Float64[np.ndarray, " s"]:
    """Score statistic of each scene: predicted decrease of squares by one Gauss-Newton step.

    The scenes differ only in the kinds of lens deviation that are free; the observations' normal
    matrix over all of them together is summed up once.

    Args:
        observations: At most about so many are used.
    """
    prior, cameras = LensPrior.of(priors, hold_board_lenses=False), [one.camera for one in priors]
    bundle = Bundle.of(scenes[0])
    bundle = bundle.with_points_thinned(-(-len(bundle.xy_px) // observations))
    photo_lenses = [PhotoLenses.of(scene, cameras, solve=True) for scene in scenes]
    basis = np.concatenate([one.basis for one in photo_lenses], axis=2)
    measured = _ObservationEquations.of(
        bundle, photo_lenses[0].camera_idx, basis, sigma_px, _ALMOST_NONE
    )
    shared = len(measured.right) - basis.shape[2] * len(bundle.views)
    first, statistics = 0, list[float]()
    for one in photo_lenses:
        kinds = first + np.arange(one.basis.shape[2])
        own = basis.shape[2] * np.arange(len(bundle.views))[:, None] + kinds
        part = measured.only(np.concatenate([np.arange(shared), shared + own.ravel()]))
        tied = replace(bundle, photo_lenses=one)
        equations = _Equations.of(part, tied, None, prior, sigma_px, _ALMOST_NONE)
        statistics.append(equations.decrease_by(equations.step()))
        first += len(kinds)
    return np.array(statistics)


def split_statistics(
    scene: Scene,
    priors: Sequence[Calibration],
    sigma_px: float,
    observations: int,
    parts: Sequence[Bool[np.ndarray, " n"]],
    courses: Float64[np.ndarray, "p m"] | None = None,
) -> Float64[np.ndarray, "h more"]:
    """Score statistics of models in which some of the points move against the others.

    First with a motion of its own in every photo, with separate poses and lenses; then along each
    course, with one motion for all photos.

    Args:
        observations: At most about so many are used, as by `score_statistics`.
        parts: By point of the scene, whether it is in the moving part.
        courses: How much of the motion each placed photo shows.
    """
    prior, cameras = LensPrior.of(priors, hold_board_lenses=False), [one.camera for one in priors]
    bundle = Bundle.of(scene)
    every = -(-len(bundle.xy_px) // observations)
    bundle = replace(
        bundle.with_points_thinned(every), photo_lenses=PhotoLenses.of(scene, cameras, solve=True)
    )

    def equations(of: Bundle, measured: _ObservationEquations) -> _Equations:
        return _Equations.of(measured, of, None, prior, sigma_px, _ALMOST_NONE)

    together = equations(bundle, _ObservationEquations.at(bundle, sigma_px, _ALMOST_NONE))
    jacobians = np.zeros((0, POSE_SIZE * len(bundle.views), POSE_SIZE))
    if courses is not None:
        jacobians = np.array([bundle.pose_by_motion(one) for one in courses.T])
    statistics: list[Float64[np.ndarray, " more"]] = []
    for part in [part[::every] for part in parts]:
        bundles = [bundle.with_points(part), bundle.with_points(~part)]
        measured = [_ObservationEquations.at(one, sigma_px, _ALMOST_NONE) for one in bundles]
        apart = sum(equations(*one).decrease() for one in zip(bundles, measured, strict=True))
        along_courses = together.motion_statistics(measured[0], jacobians)
        statistics.append(np.concatenate([[apart - together.decrease()], along_courses]))
    return np.array(statistics)


@dataclass(frozen=True)
class LensPrior:
    """Gaussian prior of the lenses: calibrated parameters, their information, which are free.

    Lens deviations of photos follow them, with a zero-mean prior of their spread.
    """

    packed: Float64[np.ndarray, " l"]
    information: Float64[np.ndarray, "l l"]
    free: Bool[np.ndarray, " l"]
    monotonicity: MonotonicityConstraints

    @classmethod
    def of(cls, priors: Sequence[Calibration], hold_board_lenses: bool) -> "LensPrior":
        """The prior by some calibrations."""
        size = LENS_SIZE * len(priors)
        information, free = np.zeros((size, size)), np.zeros(size, bool)
        if not hold_board_lenses:
            priors = [
                with_square_pixels(given) if given.source == "board" else given for given in priors
            ]
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
        sizes_px = tuple(
            None if one.source == "board" else (one.camera.width_px, one.camera.height_px)
            for one in priors
        )
        packed = np.concatenate([given.camera.packed for given in priors])
        return cls(packed, information, free, MonotonicityConstraints(sizes_px, free))

    def add_to(
        self,
        normal: Float64[np.ndarray, "u u"],
        right: Float64[np.ndarray, " u"],
        present: Float64[np.ndarray, " l"],
        first: int,
    ) -> None:
        """Add the prior, in units of sigma, to normal equations whose lenses start at `first`.

        Args:
            present: Lens parameters at which the equations are linearised.
        """
        lens = slice(first, first + len(self.packed))
        normal[lens, lens] += self.information
        right[lens] += self.information @ (self.packed - present)

    def lenses(self, bundle: Bundle) -> Float64[np.ndarray, " l"]:
        """Present parameters of the cameras' lenses."""
        return self.packed - self.offset(bundle)[: len(self.packed)]

    def offset(self, bundle: Bundle) -> Float64[np.ndarray, " l"]:
        """Calibrated minus present lens parameters."""
        if bundle.photo_lenses is not None:
            return np.concatenate(
                [
                    self.packed - bundle.photo_lenses.camera_lenses.ravel(),
                    -bundle.photo_lenses.values.ravel(),
                ]
            )
        packed = self.packed.copy()
        for photo, idx in enumerate(bundle.lens_idx):
            packed[LENS_SIZE * idx : LENS_SIZE * (idx + 1)] = bundle.views[photo, 12:]
        return self.packed - packed

    def cost(self, bundle: Bundle) -> float:
        """The prior\'s part of the cost, with that of violated monotonicity."""
        offset = self.offset(bundle)
        violated = self.monotonicity.cost(self.lenses(bundle))
        return float(offset @ self.information_of(bundle) @ offset) + violated

    def information_of(self, bundle: Bundle) -> Float64[np.ndarray, "l l"]:
        """Information of the lenses, and of lens deviations if there are any."""
        if bundle.photo_lenses is None:
            return self.information
        return np.asarray(block_diag(self.information, np.diag(bundle.photo_lenses.information)))

    def free_of(self, bundle: Bundle) -> Bool[np.ndarray, " l"]:
        """Which of the same are solved for."""
        if bundle.photo_lenses is None:
            return self.free
        return np.concatenate([self.free, np.ones(bundle.photo_lenses.values.size, bool)])


def _cost(bundle: Bundle, body: Body | None, prior: LensPrior, sigma_px: float) -> float:
    """Robust sum of squares of observations, priors and body, in units of sigma."""
    measured = robust_cost(
        bundle.views,
        bundle.photo_idx,
        bundle.bounds,
        bundle.xy_px,
        bundle.points,
        CAUCHY_SIGMAS * sigma_px,
    )
    of_body = 0.0 if body is None else body.cost(bundle, SIGMA_INFLATION)
    return measured / (SIGMA_INFLATION * sigma_px) ** 2 + prior.cost(bundle) + of_body


def _descend(
    bundle: Bundle, body: Body | None, prior: LensPrior, sigma_px: float, smallest_gain: float
) -> _State:
    """Levenberg-Marquardt until a step gains less than `smallest_gain` of the cost."""

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
class _ObservationEquations:
    """Reduced equations of the observations over poses, lenses, deviations, in units of sigma."""

    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]
    diagonal: Float64[np.ndarray, " u"]

    @classmethod
    def at(cls, bundle: Bundle, sigma_px: float, damping: float) -> "_ObservationEquations":
        if bundle.photo_lenses is None:
            none = np.zeros((bundle.lenses, LENS_SIZE, 0))
            return cls.of(bundle, bundle.lens_idx, none, sigma_px, damping)
        return cls.of(
            bundle, bundle.photo_lenses.camera_idx, bundle.photo_lenses.basis, sigma_px, damping
        )

    @classmethod
    def of(
        cls,
        bundle: Bundle,
        lens_idx: Int64[np.ndarray, " p"],
        basis: Float64[np.ndarray, "c lens q"],
        sigma_px: float,
        damping: float,
    ) -> "_ObservationEquations":
        """The equations with lenses of these cameras and a basis of lens deviations."""
        normal, right, diagonal = reduced_equations(bundle, lens_idx, basis, sigma_px, damping)
        variance = (SIGMA_INFLATION * sigma_px) ** 2
        return cls(normal / variance, right / variance, diagonal / variance)

    def only(self, kept: Int64[np.ndarray, " k"]) -> "_ObservationEquations":
        """The equations over some unknowns, with the others fixed."""
        return _ObservationEquations(
            self.normal[np.ix_(kept, kept)], self.right[kept], self.diagonal[kept]
        )


def reduced_equations(
    bundle: Bundle,
    lens_idx: Int64[np.ndarray, " p"],
    basis: Float64[np.ndarray, "c lens q"],
    sigma_px: float,
    damping: float,
    fields: Float64[np.ndarray, "n 3 f"] | None = None,
) -> tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"], Float64[np.ndarray, " u"]]:
    """Normal matrix, right-hand side and diagonal over poses, lenses and numbers of single photos.

    In pixels squared, points eliminated; the diagonal is that before the elimination.

    Args:
        fields: By point, its displacement by further numbers of each photo (a deformation field).
    """
    if fields is None:
        fields = np.zeros((len(bundle.points), 3, 0))
    own = (basis.shape[2] + fields.shape[2]) * len(bundle.views)
    size = POSE_SIZE * len(bundle.views) + LENS_SIZE * len(basis) + own
    normal, right, diagonal = np.empty((size, size)), np.empty(size), np.empty(size)
    reduce_equations(
        bundle.views,
        lens_idx,
        np.ascontiguousarray(basis),
        np.ascontiguousarray(fields),
        bundle.photo_idx,
        bundle.bounds,
        bundle.xy_px,
        bundle.points,
        CAUCHY_SIGMAS * sigma_px,
        damping,
        normal,
        right,
        diagonal,
    )
    return normal, right, diagonal


@dataclass(frozen=True)
class _Equations:
    """Reduced camera system with priors and body, in units of sigma.

    Over poses and lenses; where photos have lens deviations, over poses, cameras' lenses and
    deviations.
    """

    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]
    free: Bool[np.ndarray, " u"]
    sigma_px: float
    damping: float
    of_body: BodyEquations | None
    of_lenses: slice
    """Rows of the cameras' lenses."""
    lenses: Float64[np.ndarray, " l"]
    """Present parameters of the cameras' lenses."""
    monotonicity: MonotonicityConstraints

    @classmethod
    def at(
        cls, bundle: Bundle, body: Body | None, prior: LensPrior, sigma_px: float, damping: float
    ) -> "_Equations":
        measured = _ObservationEquations.at(bundle, sigma_px, damping)
        return cls.of(measured, bundle, body, prior, sigma_px, damping)

    @classmethod
    def of(
        cls,
        measured: "_ObservationEquations",
        bundle: Bundle,
        body: Body | None,
        prior: LensPrior,
        sigma_px: float,
        damping: float,
    ) -> "_Equations":
        """The observations' equations with the priors and the body added."""
        normal, right, diagonal = measured.normal, measured.right, measured.diagonal
        size = len(right)
        lens = slice(POSE_SIZE * len(bundle.views), size)
        information = prior.information_of(bundle)
        free = np.ones(size, bool)
        free[lens] = prior.free_of(bundle)
        normal, right, diagonal = normal.copy(), right.copy(), diagonal.copy()
        normal[lens, lens] += information
        right[lens] += information @ prior.offset(bundle)
        diagonal[lens] += np.diag(information)
        normal[np.arange(size), np.arange(size)] += damping * diagonal
        of_body = None if body is None else body.equations(bundle, SIGMA_INFLATION)
        if of_body is not None:
            body_normal, body_right = of_body.of_cameras()
            if bundle.photo_lenses is not None:
                jacobian = bundle.photo_lenses.jacobian
                body_normal = jacobian.T @ (jacobian.T @ body_normal).T
                body_right = jacobian.T @ body_right
            normal, right = normal + body_normal, right + body_right
        lenses = prior.lenses(bundle)
        of_lenses = slice(lens.start, lens.start + len(lenses))
        return cls(
            normal, right, free, sigma_px, damping, of_body, of_lenses, lenses, prior.monotonicity
        )

    def solved(self, bundle: Bundle, body: Body | None) -> tuple[Bundle, Body | None]:
        """Bundle and body after the step that solves these equations.

        Raises:
            LinAlgError: a photo lost all its observations.
        """
        step = self.step()
        own = step[POSE_SIZE * len(bundle.views) :]
        if bundle.photo_lenses is not None:
            step = bundle.photo_lenses.jacobian @ step
        points = np.empty_like(bundle.points)
        point_steps(
            bundle.views,
            bundle.lens_idx,
            bundle.photo_idx,
            bundle.bounds,
            bundle.xy_px,
            bundle.points,
            CAUCHY_SIGMAS * self.sigma_px,
            self.damping,
            step,
            points,
        )
        if body is not None and self.of_body is not None:
            body = body.moved(*self.of_body.follow(step))
        moved = bundle.moved(step, points)
        if bundle.photo_lenses is not None:
            moved = replace(moved, photo_lenses=bundle.photo_lenses.moved(own))
        return moved, body

    def step(self) -> Float64[np.ndarray, " u"]:
        """Step of poses and lenses that keeps the uncalibrated lenses monotonic."""
        constrained = self
        for _ in range(_CONSTRAINT_ROUNDS):
            step = constrained._unconstrained_step()
            violated = self.monotonicity.violated_by(self.lenses, step[self.of_lenses])
            if not violated:
                return step
            constrained = constrained._with_constraints(violated)
        return constrained._unconstrained_step()

    def _with_constraints(self, constraints: Sequence[LinearConstraint]) -> "_Equations":
        """The equations with some constraints active."""
        normal, right = self.normal.copy(), self.right.copy()
        for one in constraints:
            normal[self.of_lenses, self.of_lenses] += one.information
            right[self.of_lenses] += one.right
        return replace(self, normal=normal, right=right)

    def _unconstrained_step(self) -> Float64[np.ndarray, " u"]:
        """Solution of the equations by Cholesky decomposition; zero where fixed."""
        step = np.zeros(len(self.right))
        weights = np.diag(self.normal)[self.free]
        if not (weights > 0.0).all():
            raise np.linalg.LinAlgError("nothing is observed that would hold a photo or a lens")
        scale = 1.0 / np.sqrt(weights)
        scaled = self.normal[np.ix_(self.free, self.free)] * np.outer(scale, scale)
        step[self.free] = scale * cho_solve(cho_factor(scaled), scale * self.right[self.free])
        return step

    def decrease_by(self, step: Float64[np.ndarray, " u"]) -> float:
        """Predicted decrease of the sum of squares by a step that need not solve the equations."""
        return float(self.right @ step + step @ (self.right - self.normal @ step))

    def decrease(self) -> float:
        """Predicted decrease of the sum of squares by the unconstrained step (score statistic).

        Photos without observations do not contribute.
        """
        right = self.right[self.free]
        return float(right @ self.solved_for(right[:, None])[:, 0])

    def solved_for(self, right: Float64[np.ndarray, "f k"]) -> Float64[np.ndarray, "f k"]:
        """Solutions for other right sides; unobserved unknowns stay where they are."""
        return solve_semidefinite(self.normal[np.ix_(self.free, self.free)], right)

    def motion_statistics(
        self, part: _ObservationEquations, poses: Float64[np.ndarray, "m c k"]
    ) -> Float64[np.ndarray, " m"]:
        """Score statistics of bodies that move by themselves, one for each motion.

        Args:
            part: The equations of that body's observations.
            poses: Derivatives of the photos' poses by the numbers of each motion.
        """
        motions, rows, numbers = poses.shape
        along = poses.transpose(1, 0, 2).reshape(rows, motions * numbers)
        cross = part.normal[:, :rows] @ along
        solved = self.solved_for(np.column_stack([self.right, cross])[self.free])
        score = along.T @ part.right[:rows] - cross[self.free].T @ solved[:, 0]
        statistics = np.zeros(motions)
        for one in range(motions):
            own = slice(numbers * one, numbers * (one + 1))
            explained = cross[self.free, own].T @ solved[:, 1:][:, own]
            information = along[:, own].T @ cross[:rows, own] - explained
            statistics[one] = score[own] @ pseudo_inverse(information, _GAUGE) @ score[own]
        return statistics

    def covariance(self) -> Float64[np.ndarray, "u u"]:
        """Covariance of poses and lenses, without the seven gauge freedoms of the world frame."""
        covariance = np.zeros_like(self.normal)
        both = np.ix_(self.free, self.free)
        covariance[both] = _gauge_free_inverse(self.normal[both])
        return covariance


def _gauge_free_inverse(normal: Float64[np.ndarray, "m m"]) -> Float64[np.ndarray, "m m"]:
    """Inverse without the seven gauge freedoms of the world frame."""
    scale = 1.0 / np.sqrt(np.diag(normal))
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    known = slice(SIMILARITY_SIZE, None)
    inverse = (vectors[:, known] / values[known]) @ vectors[:, known].T
    return inverse * np.outer(scale, scale)
