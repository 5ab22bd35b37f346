"""The fundamental matrix: linear, robust, and the minimum of Sampson or of pixel distances.

All pixels are freed of lens distortion; x2^T F x1 = 0 and F has unit Frobenius norm.
Method  normalized 8-point algorithm (Hartley 1997); RANSAC with MAGSAC scores and local
        optimisation (Barath et al. 2020, OpenCV's USAC); least squares of the signed Sampson
        distances over the orthonormal representation F = U diag(cos s, sin s, 0) V^T, which has
        exactly the 7 degrees of freedom (Bartoli and Sturm 2004).
        The Gold Standard estimate is the maximum-likelihood F under Gaussian noise of the pixels
        (Hartley and Zisserman, algorithm 11.3): cameras P = [I | 0] and P' = [M | t], one point
        X = (x, y, 1, w) per match; least squares of d(x, x^)^2 + d(x', x'^)^2 over the 12 numbers
        of P' and the 3 of every point, with the points eliminated (appendix A6.3). F = [t]_x M.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float64
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.arrays import Matrix3, Points2
from limbgram.core.geometry.frames import cross_matrix
from limbgram.core.geometry.triangulation import nearest_matches, sampson_px
from limbgram.core.interval import rms
from limbgram.core.optimisation import ArrowheadEquations, Descent, Trial, minimise
from limbgram.reconstruction.twoview.pairs import TURNS, fit_sampson

FEWEST_MATCHES = 8
SELECTIONS = 10
"""Rounds of choosing the matches that agree and fitting to them, at most."""


@dataclass(frozen=True)
class Framing:
    """Shifts and one scale that bring both photos' pixels to the order of one."""

    to_first: Matrix3
    to_second: Matrix3
    scale: float
    """Normalized units per pixel."""

    @classmethod
    def around(cls, xy_first: Points2, xy_second: Points2) -> "Framing":
        middles = xy_first.mean(0), xy_second.mean(0)
        spread = np.mean([np.std(xy_first - middles[0]), np.std(xy_second - middles[1])])
        scale = float(1.0 / max(spread, 1e-9))
        shifts = [
            np.array([[scale, 0, -scale * x], [0, scale, -scale * y], [0, 0, 1.0]])
            for x, y in middles
        ]
        return cls(shifts[0], shifts[1], scale)

    def first(self, xy_px: Points2) -> Points2:
        return xy_px * self.scale + self.to_first[:2, 2]

    def second(self, xy_px: Points2) -> Points2:
        return xy_px * self.scale + self.to_second[:2, 2]

    def inward(self, fundamental_px: Matrix3) -> Matrix3:
        """F between normalized coordinates from F between pixels."""
        back = np.linalg.inv(self.to_second).T @ fundamental_px @ np.linalg.inv(self.to_first)
        return back / np.linalg.norm(back)

    def outward(self, fundamental: Matrix3) -> Matrix3:
        """F between pixels from F between normalized coordinates."""
        pixels = self.to_second.T @ fundamental @ self.to_first
        return pixels / np.linalg.norm(pixels)


@dataclass(frozen=True)
class RobustFundamental:
    """F from matches with wrong ones among them; `fundamental` is None where none was found."""

    fundamental: Matrix3 | None
    inliers: Bool[np.ndarray, " n"]


def estimate_fundamental_linear(xy_first: Points2, xy_second: Points2) -> Matrix3:
    """The normalized 8-point algorithm; needs 8 matches and trusts them all."""
    framing = Framing.around(xy_first, xy_second)
    first, second = framing.first(xy_first), framing.second(xy_second)
    ones = np.ones((len(first), 1))
    rows = np.einsum("ni,nj->nij", np.hstack([second, ones]), np.hstack([first, ones]))
    solution = np.linalg.eigh(rows.reshape(-1, 9).T @ rows.reshape(-1, 9))[1][:, 0]
    u, singular, vt = np.linalg.svd(solution.reshape(3, 3))
    return framing.outward((u * (singular * [1, 1, 0])) @ vt)


def estimate_fundamental(
    xy_first: Points2, xy_second: Points2, *, threshold_px: float = 1.5, seed: int = 0
) -> RobustFundamental:
    """F by RANSAC, then the least Sampson distances of its inliers until these stay the same."""
    none = RobustFundamental(None, np.zeros(len(xy_first), bool))
    if len(xy_first) < FEWEST_MATCHES:
        return none
    try:
        found, _ = cv2.findFundamentalMat(xy_first, xy_second, ransac(threshold_px, seed))
    except cv2.error:  # it asserts that some sample gave a model
        return none
    fundamental = np.asarray(found, float)
    if fundamental.shape != (3, 3) or not np.isfinite(fundamental).all():
        return none
    fundamental /= np.linalg.norm(fundamental)
    inliers = agreeing(fundamental, xy_first, xy_second, threshold_px)
    for _ in range(SELECTIONS):
        if inliers.sum() < FEWEST_MATCHES:
            return none
        fundamental = refine_fundamental_sampson(fundamental, xy_first[inliers], xy_second[inliers])
        before, inliers = (
            inliers,
            agreeing(fundamental, xy_first, xy_second, threshold_px),
        )
        if np.array_equal(before, inliers):
            break
    return RobustFundamental(fundamental, inliers)


def agreeing(
    fundamental: Matrix3, xy_first: Points2, xy_second: Points2, threshold_px: float
) -> Bool[np.ndarray, " n"]:
    """Whether matches lie within `threshold_px` of F by the Sampson distance."""
    return np.abs(sampson_px(fundamental, xy_first, xy_second)) < threshold_px


def ransac(threshold: float, seed: int) -> cv2.UsacParams:
    """Settings that all robust estimates here share."""
    settings = cv2.UsacParams()
    settings.threshold = threshold
    settings.confidence = 0.9999
    settings.maxIterations = 5_000
    settings.score = cv2.SCORE_METHOD_MAGSAC
    settings.loMethod = cv2.LOCAL_OPTIM_SIGMA
    settings.sampler = cv2.SAMPLING_UNIFORM
    settings.final_polisher = cv2.MAGSAC
    settings.randomGeneratorState = seed
    return settings


def refine_fundamental_sampson(
    fundamental: Matrix3, xy_first: Points2, xy_second: Points2
) -> Matrix3:
    """F of the least sum of squared Sampson distances, from a start nearby."""
    framing = Framing.around(xy_first, xy_second)
    u, singular, vt = np.linalg.svd(framing.inward(fundamental))
    start = _Orthonormal(u, vt.T, float(np.arctan2(singular[1], singular[0])))
    best = fit_sampson(start, framing.first(xy_first), framing.second(xy_second))
    return framing.outward(best.matrix)


@dataclass(frozen=True)
class _Orthonormal:
    """F = U diag(cos s, sin s, 0) V^T."""

    u: Matrix3
    v: Matrix3
    angle: float

    @property
    def matrix(self) -> Matrix3:
        return (self.u * [np.cos(self.angle), np.sin(self.angle), 0.0]) @ self.v.T

    @property
    def by_step(self) -> Float64[np.ndarray, "7 3 3"]:
        singular = np.diag([np.cos(self.angle), np.sin(self.angle), 0.0])
        other = np.diag([-np.sin(self.angle), np.cos(self.angle), 0.0])
        inner = np.concatenate([TURNS @ singular, -singular @ TURNS, other[None]])
        return self.u @ inner @ self.v.T

    def moved(self, step: Float64[np.ndarray, "7"]) -> "_Orthonormal":
        turn_u = Rotation.from_rotvec(step[:3]).as_matrix()
        turn_v = Rotation.from_rotvec(step[3:6]).as_matrix()
        return _Orthonormal(self.u @ turn_u, self.v @ turn_v, self.angle + float(step[6]))


_DESCENT = Descent(iterations=30, smallest_gain=1e-9)
_SILENT = 1e-12

Projection = Float64[np.ndarray, "3 4"]
Structure = Float64[np.ndarray, "n 3"]
"""x, y and w of X = (x, y, 1, w)."""
_State = tuple[Projection, Structure, Float64[np.ndarray, "n 4"]]
"""With the residuals."""


@dataclass(frozen=True)
class GoldStandard:
    """F, the exact matches nearest to the measured ones, and the paper's residuals."""

    fundamental: Matrix3
    exact: Float64[np.ndarray, "n 4"]
    """x^, y^, x'^, y'^ in pixels."""
    residual_px: Float64[np.ndarray, " n"]
    """sqrt((d(x, x^)^2 + d(x', x'^)^2) / 4) of every match: what its histogram shows."""

    @property
    def rms_px(self) -> float:
        """The paper's residual error: sqrt((sum d(x, x^)^2 + sum d(x', x'^)^2) / 4n)."""
        return rms(self.residual_px)


def refine_fundamental_gold_standard(
    fundamental: Matrix3, xy_first: Points2, xy_second: Points2
) -> GoldStandard:
    """The maximum-likelihood F from a start nearby, such as the minimum of the Sampson distance."""
    framing = Framing.around(xy_first, xy_second)
    first, second = framing.first(xy_first), framing.second(xy_second)
    projection = canonical_projection(framing.inward(fundamental))
    points = _structure(framing.inward(fundamental), projection, first, second)
    projection, points = _adjust(projection, points, first, second)

    exact = np.hstack([points[:, :2], _project(projection, points)])
    residual = np.linalg.norm(np.hstack([first, second]) - exact, axis=1) / (2 * framing.scale)
    shift = np.concatenate([framing.to_first[:2, 2], framing.to_second[:2, 2]])
    matrix = cross_matrix(projection[:, 3]) @ projection[:, :3]
    return GoldStandard(framing.outward(matrix), (exact - shift) / framing.scale, residual)


def canonical_projection(fundamental: Matrix3) -> Projection:
    """P' = [[e']_x F | e'] of P = [I | 0]; e' is F's left null vector (H and Z, result 9.14)."""
    epipole = np.linalg.svd(fundamental)[0][:, 2]
    return np.column_stack([cross_matrix(epipole) @ fundamental, epipole])


def _structure(
    fundamental: Matrix3, projection: Projection, first: Points2, second: Points2
) -> Structure:
    exact = nearest_matches(fundamental, first, second)
    far = np.hstack([exact[:, :2], np.ones((len(first), 1))]) @ projection[:, :3].T
    epipole = projection[:, 3]
    # x' (m3 X + w e3) = m1 X + w e1, and the same for y': two equations in w, least squares
    factor = exact[:, 2:] * epipole[2] - epipole[:2]
    constant = far[:, :2] - exact[:, 2:] * far[:, 2:]
    w = (factor * constant).sum(1) / np.maximum((factor**2).sum(1), 1e-18)
    return np.column_stack([exact[:, :2], w])


def _project(projection: Projection, points: Structure) -> Points2:
    image = points[:, :2] @ projection[:, :2].T + projection[:, 2]
    image += points[:, 2:] * projection[:, 3]
    return image[:, :2] / image[:, 2:]


def _adjust(
    projection: Projection, points: Structure, first: Points2, second: Points2
) -> tuple[Projection, Structure]:
    def linearised(state: _State) -> Callable[[float], Trial[_State] | None]:
        projection, points, residuals = state
        equations = normal_equations(projection, points, residuals)

        def step(damping: float) -> Trial[_State] | None:
            try:
                by_projection, by_point = damped_step(equations, damping)
            except np.linalg.LinAlgError:  # too few matches tell too little: hold them harder
                return None
            return tried(projection + by_projection, points + by_point)

        return step

    def tried(projection: Projection, points: Structure) -> Trial[_State]:
        residuals = _residuals(projection, points, first, second)
        return Trial((projection, points, residuals), float((residuals**2).sum()))

    start = tried(projection, points)
    return minimise(start.state, start.cost, linearised, _DESCENT)[:2]


def _residuals(
    projection: Projection, points: Structure, first: Points2, second: Points2
) -> Float64[np.ndarray, "n 4"]:
    return np.hstack([first - points[:, :2], second - _project(projection, points)])


def normal_equations(
    projection: Projection, points: Structure, residuals: Float64[np.ndarray, "n 4"]
) -> ArrowheadEquations:
    """Of the projection's twelve numbers, which all points share, and of three for each point."""
    count = len(points)
    whole = np.column_stack([points[:, :2], np.ones(count), points[:, 2]])
    image = whole @ projection.T
    by_image = np.zeros((count, 2, 3))
    by_image[:, 0, 0] = by_image[:, 1, 1] = 1.0 / image[:, 2]
    by_image[:, :, 2] = -image[:, :2] / image[:, 2:] ** 2
    a = (by_image[:, :, :, None] * whole[:, None, None, :]).reshape(count, 2, 12)
    b = by_image @ projection[:, [0, 1, 3]]
    blocks = b.transpose(0, 2, 1) @ b
    blocks[:, [0, 1], [0, 1]] += 1.0
    by_point = np.einsum("nij,ni->nj", b, residuals[:, 2:])
    by_point[:, :2] += residuals[:, :2]
    flat, cross = a.reshape(-1, 12), b.transpose(0, 2, 1) @ a
    return ArrowheadEquations(
        flat.T @ flat, flat.T @ residuals[:, 2:].ravel(), blocks, cross, by_point
    )


def damped_step(equations: ArrowheadEquations, damping: float) -> tuple[Projection, Structure]:
    """Of the projection and of every point."""
    # At the epipole, or infinitely near, a match says nothing of its depth: that stays.
    damped = equations.damped(
        damping, least_shared=1e-12, least_block=np.array([0.0, 0.0, _SILENT])
    )
    by_projection = np.linalg.solve(*damped.reduced())
    return by_projection.reshape(3, 4), damped.back_substituted(by_projection)
