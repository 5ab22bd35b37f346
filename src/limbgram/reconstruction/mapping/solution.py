"""Bundle adjustment: photos, lenses and points together, with what calibration knows as a prior.

In      a scene close to its solution, and the calibrations its lenses start from.
Out     the scene of the least robust sum of squares, without observations that contradict it.
Method  Levenberg-Marquardt on pixels through the whole lens model, points eliminated (Schur
        complement), Cauchy weights; each lens is drawn to its calibration by the inverse of that
        calibration's covariance, so that a board's well-known focal length stays and its poorly
        known principal point may move. Parameters of zero variance are held. A lens that no board
        calibrated stays one that shows its whole picture (monotonic_lens.py).
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
from limbgram.reconstruction.calibration.cameras import Calibration, squared
from limbgram.reconstruction.mapping.body import Body, BodyEquations
from limbgram.reconstruction.mapping.bundle import CAUCHY_SIGMAS, Bundle
from limbgram.reconstruction.mapping.lens_deviations import Ties
from limbgram.reconstruction.mapping.monotonic_lens import Held, Pictures
from limbgram.reconstruction.mapping.normals import (
    point_steps,
    reduce_equations,
    robust_cost,
)
from limbgram.reconstruction.mapping.quadratic import pseudo_inverse, solved_for
from limbgram.reconstruction.mapping.scene import Scene

_ITERATIONS = 40
_ROUGH_GAIN = 1e-3
_FINE_GAIN = 1e-5
OUTLIER_SIGMAS = 4.0
"""Observations further off than this contradict the scene."""
_ALMOST_NONE = 1e-8
"""Damping that keeps equations solvable whose world frame is free."""
_WALLS = 8
"""How often a step is solved again because lenses would turn back within their pictures."""
_GAUGE = 1e-6
"""Share of the largest eigenvalue below which a motion is one that the whole scene may make."""
SHARED_ERROR = 3.0
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
    lens_covariance: Float64[np.ndarray, "c lens lens"]
    """Of every camera's lens after the adjustment; zero where held."""


class Unheld(np.linalg.LinAlgError):
    """Photos lost all their observations."""

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
    """Adjust, less weak points and, after each round, observations over `outlier_sigmas`.

    A `body` of known shape takes part with the corners that photos show of it. What photos have
    for themselves in their lenses (`Scene.own`) is held, or with `solve_own` solved for.

    Raises:
        Unheld: photos lost all their observations.
    """
    prior = LensPrior.of(priors, hold_board_lenses)
    bundle = Bundle.of(scene).without_weak_points()
    if scene.own is not None:
        cameras = [given.camera for given in priors]
        bundle = replace(bundle, ties=Ties.of(scene, cameras, solve=solve_own))
    if body is None:
        _refuse_unheld(bundle, scene)
    sigma_px = bundle.sigma_px(scene)
    for attempt in track(range(rounds)):
        last = attempt == rounds - 1
        gain = _FINE_GAIN if last else _ROUGH_GAIN
        bundle, body = _descend(bundle, body, prior, sigma_px, gain)
        sigma_px = bundle.sigma_px(scene)
        bundle = _respread(bundle, body, prior, sigma_px)
        bundle = bundle.without_outliers(scene, sigma_px, outlier_sigmas)
        if body is None:
            _refuse_unheld(bundle, scene)
    covariance = _Equations.at(bundle, body, prior, sigma_px, 0.0).covariance()
    first, cameras = POSE_SIZE * len(bundle.views), len(scene.cameras)
    rows = [slice(first + LENS_SIZE * k, first + LENS_SIZE * (k + 1)) for k in range(cameras)]
    of_lenses = np.array([covariance[part, part] for part in rows])
    if bundle.ties is not None:
        covariance = bundle.ties.map @ (bundle.ties.map @ covariance).T
    return Adjusted(bundle.scene(scene), sigma_px, covariance, of_lenses)


def _refuse_unheld(bundle: Bundle, scene: Scene) -> None:
    seen = np.bincount(bundle.photo_idx, minlength=len(bundle.views))
    if not seen.all():
        raise Unheld(tuple(scene.placed[k] for k in np.flatnonzero(seen == 0).tolist()))


def _respread(bundle: Bundle, body: Body | None, prior: "LensPrior", sigma_px: float) -> Bundle:
    """The bundle with the spread of its photos' own numbers as the capture shows it."""
    ties = bundle.ties
    if ties is None or not ties.solved:
        return bundle
    covariance = _Equations.at(bundle, body, prior, sigma_px, 0.0).covariance()
    variance = np.diag(covariance)[-ties.values.size :].reshape(ties.values.shape)
    return replace(bundle, ties=ties.respread(variance))


def turn_sigma_deg(scene: Scene, photo: int) -> float:
    """Standard deviation of a placed photo's turn, were the other photos and all lenses held.

    About the axis of which least is known. Without a calibration all photos of a part of a ring
    turn with the focal length, by a degree from end to end: that is left out here.
    """
    bundle = Bundle.of(scene)
    first = POSE_SIZE * scene.placed.index(photo)
    own = np.arange(first, first + POSE_SIZE)
    normal = _Measured.at(bundle, bundle.sigma_px(scene), 0.0).only(own).normal
    scale = np.outer(*[1.0 / np.sqrt(np.diag(normal))] * 2)
    turn = (np.linalg.inv(normal * scale) * scale)[:3, :3]
    return float(np.degrees(np.sqrt(np.linalg.eigvalsh(turn)[-1])))


def predicted_falls(
    scenes: Sequence[Scene], priors: Sequence[Calibration], sigma_px: float, observations: int
) -> Float64[np.ndarray, " s"]:
    """By how much the sum of squares falls by one Gauss-Newton step in each scene.

    The scenes differ only in what photos may have for themselves; what is measured of all of that
    together is summed up once.

    Args:
        observations: At most about so many are asked.
    """
    prior, cameras = LensPrior.of(priors, hold_board_lenses=False), [one.camera for one in priors]
    bundle = Bundle.of(scenes[0])
    bundle = bundle.with_points_thinned(-(-len(bundle.xy_px) // observations))
    ties = [Ties.of(scene, cameras, solve=True) for scene in scenes]
    basis = np.concatenate([one.basis for one in ties], axis=2)
    measured = _Measured.of(bundle, ties[0].camera, basis, sigma_px, _ALMOST_NONE)
    shared = len(measured.right) - basis.shape[2] * len(bundle.views)
    first, falls = 0, list[float]()
    for one in ties:
        kinds = first + np.arange(one.basis.shape[2])
        own = basis.shape[2] * np.arange(len(bundle.views))[:, None] + kinds
        part = measured.only(np.concatenate([np.arange(shared), shared + own.ravel()]))
        tied = replace(bundle, ties=one)
        equations = _Equations.of(part, tied, None, prior, sigma_px, _ALMOST_NONE)
        falls.append(equations.fall_by(equations.step()))
        first += len(kinds)
    return np.array(falls)


def falls_apart(
    scene: Scene,
    priors: Sequence[Calibration],
    sigma_px: float,
    observations: int,
    halves: Sequence[Bool[np.ndarray, " n"]],
    courses: Float64[np.ndarray, "p m"] | None = None,
) -> Float64[np.ndarray, "h more"]:
    """By how much it would fall if a part of the points moved against the others between photos.

    First where it moves in every photo by itself, with poses and a lens of its own; then along
    each course, with one motion for all photos.

    Args:
        observations: At most about so many are asked, as by `predicted_falls`.
        halves: By point of the scene, whether it is of that part.
        courses: How much of the motion each placed photo shows.
    """
    prior, cameras = LensPrior.of(priors, hold_board_lenses=False), [one.camera for one in priors]
    bundle = Bundle.of(scene)
    every = -(-len(bundle.xy_px) // observations)
    bundle = replace(bundle.with_points_thinned(every), ties=Ties.of(scene, cameras, solve=True))

    def equations(part: Bundle, measured: _Measured) -> _Equations:
        return _Equations.of(measured, part, None, prior, sigma_px, _ALMOST_NONE)

    together = equations(bundle, _Measured.at(bundle, sigma_px, _ALMOST_NONE))
    along = np.zeros((0, POSE_SIZE * len(bundle.views), POSE_SIZE))
    if courses is not None:
        along = np.array([bundle.motions(one) for one in courses.T])
    falls: list[Float64[np.ndarray, " more"]] = []
    for half in [half[::every] for half in halves]:
        parts = [bundle.with_points(half), bundle.with_points(~half)]
        measured = [_Measured.at(part, sigma_px, _ALMOST_NONE) for part in parts]
        apart = sum(equations(*one).fall() for one in zip(parts, measured, strict=True))
        along_courses = together.more_by(measured[0], along)
        falls.append(np.concatenate([[apart - together.fall()], along_courses]))
    return np.array(falls)


@dataclass(frozen=True)
class LensPrior:
    """Lens parameters as calibrated, their information, and which of them may move.

    Where photos have numbers of their own these follow, drawn to nought by their spread.
    """

    packed: Float64[np.ndarray, " l"]
    information: Float64[np.ndarray, "l l"]
    free: Bool[np.ndarray, " l"]
    pictures: Pictures

    @classmethod
    def of(cls, priors: Sequence[Calibration], hold_board_lenses: bool) -> "LensPrior":
        size = LENS_SIZE * len(priors)
        information, free = np.zeros((size, size)), np.zeros(size, bool)
        if not hold_board_lenses:
            priors = [squared(given) if given.source == "board" else given for given in priors]
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
        return cls(packed, information, free, Pictures(sizes_px, free))

    def join(
        self,
        normal: Float64[np.ndarray, "u u"],
        right: Float64[np.ndarray, " u"],
        present: Float64[np.ndarray, " l"],
        first: int,
    ) -> None:
        """Add what the calibrations say, in units of sigma, to the unknowns from `first` on.

        Args:
            present: Lens parameters about which the equations are linear.
        """
        lens = slice(first, first + len(self.packed))
        normal[lens, lens] += self.information
        right[lens] += self.information @ (self.packed - present)

    def lenses(self, bundle: Bundle) -> Float64[np.ndarray, " l"]:
        """Present parameters of the cameras' lenses."""
        return self.packed - self.offset(bundle)[: len(self.packed)]

    def offset(self, bundle: Bundle) -> Float64[np.ndarray, " l"]:
        """Calibrated minus present lens parameters."""
        if bundle.ties is not None:
            return np.concatenate(
                [self.packed - bundle.ties.shared.ravel(), -bundle.ties.values.ravel()]
            )
        packed = self.packed.copy()
        for photo, idx in enumerate(bundle.lens_idx):
            packed[LENS_SIZE * idx : LENS_SIZE * (idx + 1)] = bundle.views[photo, 12:]
        return self.packed - packed

    def cost(self, bundle: Bundle) -> float:
        offset = self.offset(bundle)
        folded = self.pictures.cost(self.lenses(bundle))
        return float(offset @ self.information_of(bundle) @ offset) + folded

    def information_of(self, bundle: Bundle) -> Float64[np.ndarray, "l l"]:
        if bundle.ties is None:
            return self.information
        return np.asarray(block_diag(self.information, np.diag(bundle.ties.information)))

    def free_of(self, bundle: Bundle) -> Bool[np.ndarray, " l"]:
        if bundle.ties is None:
            return self.free
        return np.concatenate([self.free, np.ones(bundle.ties.values.size, bool)])


def _cost(bundle: Bundle, body: Body | None, prior: LensPrior, sigma_px: float) -> float:
    measured = robust_cost(
        bundle.views,
        bundle.photo_idx,
        bundle.bounds,
        bundle.xy_px,
        bundle.points,
        CAUCHY_SIGMAS * sigma_px,
    )
    of_body = 0.0 if body is None else body.cost(bundle, SHARED_ERROR)
    return measured / (SHARED_ERROR * sigma_px) ** 2 + prior.cost(bundle) + of_body


def _descend(
    bundle: Bundle, body: Body | None, prior: LensPrior, sigma_px: float, smallest_gain: float
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
class _Measured:
    """What the observations say about poses, lenses and own numbers, in units of sigma."""

    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]
    diagonal: Float64[np.ndarray, " u"]

    @classmethod
    def at(cls, bundle: Bundle, sigma_px: float, damping: float) -> "_Measured":
        if bundle.ties is None:
            none = np.zeros((bundle.lenses, LENS_SIZE, 0))
            return cls.of(bundle, bundle.lens_idx, none, sigma_px, damping)
        return cls.of(bundle, bundle.ties.camera, bundle.ties.basis, sigma_px, damping)

    @classmethod
    def of(
        cls,
        bundle: Bundle,
        lens_idx: Int64[np.ndarray, " p"],
        basis: Float64[np.ndarray, "c lens q"],
        sigma_px: float,
        damping: float,
    ) -> "_Measured":
        """With the lenses of these cameras, and numbers that move those of single photos."""
        normal, right, diagonal = reduced_equations(bundle, lens_idx, basis, sigma_px, damping)
        variance = (SHARED_ERROR * sigma_px) ** 2
        return cls(normal / variance, right / variance, diagonal / variance)

    def only(self, kept: Int64[np.ndarray, " k"]) -> "_Measured":
        """As if the other unknowns were held."""
        return _Measured(self.normal[np.ix_(kept, kept)], self.right[kept], self.diagonal[kept])


def reduced_equations(
    bundle: Bundle,
    lens_idx: Int64[np.ndarray, " p"],
    basis: Float64[np.ndarray, "c lens q"],
    sigma_px: float,
    damping: float,
    fields: Float64[np.ndarray, "n 3 f"] | None = None,
) -> tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"], Float64[np.ndarray, " u"]]:
    """Normal matrix, right side and diagonal of poses, lenses and single photos' numbers in pixels
    squared, points eliminated.

    Args:
        fields: How numbers that each photo has after those of its lens move the points in it.
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
    """Reduced normal equations of photos and lenses, prior included, in units of sigma.

    Where photos have lenses of their own: of poses, cameras' lenses and own numbers.
    """

    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]
    free: Bool[np.ndarray, " u"]
    sigma_px: float
    damping: float
    of_body: BodyEquations | None
    of_lenses: slice
    """Where the cameras' lenses stand among the unknowns."""
    lenses: Float64[np.ndarray, " l"]
    """Present parameters of the cameras' lenses."""
    pictures: Pictures

    @classmethod
    def at(
        cls, bundle: Bundle, body: Body | None, prior: LensPrior, sigma_px: float, damping: float
    ) -> "_Equations":
        measured = _Measured.at(bundle, sigma_px, damping)
        return cls.of(measured, bundle, body, prior, sigma_px, damping)

    @classmethod
    def of(
        cls,
        measured: "_Measured",
        bundle: Bundle,
        body: Body | None,
        prior: LensPrior,
        sigma_px: float,
        damping: float,
    ) -> "_Equations":
        """Of what the observations say, with the priors and the body."""
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
        of_body = None if body is None else body.equations(bundle, SHARED_ERROR)
        if of_body is not None:
            more, more_right = of_body.of_cameras()
            if bundle.ties is not None:
                tied = bundle.ties.map
                more, more_right = tied.T @ (tied.T @ more).T, tied.T @ more_right
            normal, right = normal + more, right + more_right
        lenses = prior.lenses(bundle)
        of_lenses = slice(lens.start, lens.start + len(lenses))
        return cls(
            normal, right, free, sigma_px, damping, of_body, of_lenses, lenses, prior.pictures
        )

    def solved(self, bundle: Bundle, body: Body | None) -> tuple[Bundle, Body | None]:
        """Bundle and body after the step that solves these equations.

        Raises:
            LinAlgError: a photo lost all its observations.
        """
        step = self.step()
        own = step[POSE_SIZE * len(bundle.views) :]
        if bundle.ties is not None:
            step = bundle.ties.map @ step
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
        if bundle.ties is not None:
            moved = replace(moved, ties=bundle.ties.moved(own))
        return moved, body

    def step(self) -> Float64[np.ndarray, " u"]:
        """Of photos and lenses; those that no board calibrated go on showing their pictures."""
        tried = self
        for _ in range(_WALLS):
            step = tried._step()
            walls = self.pictures.walls(self.lenses, step[self.of_lenses])
            if not walls:
                return step
            tried = tried._with(walls)
        return tried._step()

    def _with(self, walls: Sequence[Held]) -> "_Equations":
        """With lenses held to walls."""
        normal, right = self.normal.copy(), self.right.copy()
        for one in walls:
            normal[self.of_lenses, self.of_lenses] += one.information
            right[self.of_lenses] += one.right
        return replace(self, normal=normal, right=right)

    def _step(self) -> Float64[np.ndarray, " u"]:
        step = np.zeros(len(self.right))
        weights = np.diag(self.normal)[self.free]
        if not (weights > 0.0).all():
            raise np.linalg.LinAlgError("nothing is observed that would hold a photo or a lens")
        scale = 1.0 / np.sqrt(weights)
        scaled = self.normal[np.ix_(self.free, self.free)] * np.outer(scale, scale)
        step[self.free] = scale * cho_solve(cho_factor(scaled), scale * self.right[self.free])
        return step

    def fall_by(self, step: Float64[np.ndarray, " u"]) -> float:
        """Of the sum of squares by a step, which need not be the one that solves the equations."""
        return float(self.right @ step + step @ (self.right - self.normal @ step))

    def fall(self) -> float:
        """Of the sum of squares by the step; a photo of which nothing is seen says nothing."""
        right = self.right[self.free]
        return float(right @ self.solved_for(right[:, None])[:, 0])

    def solved_for(self, right: Float64[np.ndarray, "f k"]) -> Float64[np.ndarray, "f k"]:
        """Solutions for other right sides; what nothing is seen of stays."""
        return solved_for(self.normal[np.ix_(self.free, self.free)], right)

    def more_by(
        self, part: _Measured, poses: Float64[np.ndarray, "m c k"]
    ) -> Float64[np.ndarray, " m"]:
        """How much farther the sum of squares falls if a part of what is seen moves by itself.

        Args:
            part: What its observations say.
            poses: How the numbers of each motion move the photos' poses.
        """
        motions, rows, numbers = poses.shape
        along = poses.transpose(1, 0, 2).reshape(rows, motions * numbers)
        moves = part.normal[:, :rows] @ along
        solved = self.solved_for(np.column_stack([self.right, moves])[self.free])
        pull = along.T @ part.right[:rows] - moves[self.free].T @ solved[:, 0]
        falls = np.zeros(motions)
        for one in range(motions):
            own = slice(numbers * one, numbers * (one + 1))
            meant = moves[self.free, own].T @ solved[:, 1:][:, own]
            hold = along[:, own].T @ moves[:rows, own] - meant
            falls[one] = pull[own] @ pseudo_inverse(hold, _GAUGE) @ pull[own]
        return falls

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
    known = slice(SIMILARITY_SIZE, None)
    inverse = (vectors[:, known] / values[known]) @ vectors[:, known].T
    return inverse * np.outer(scale, scale)
