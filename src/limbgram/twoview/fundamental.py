"""The fundamental matrix: linear estimate, robust estimate, and minimum of the Sampson distance.

All pixels are freed of lens distortion; x2^T F x1 = 0 and F has unit Frobenius norm.
Method  normalized 8-point algorithm (Hartley 1997); RANSAC with MAGSAC scores and local
        optimisation (Barath et al. 2020, OpenCV's USAC); Levenberg-Marquardt on the signed
        Sampson distances over the orthonormal representation F = U diag(cos s, sin s, 0) V^T,
        which has exactly the 7 degrees of freedom (Bartoli and Sturm 2004).
"""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float64
from scipy.spatial.transform import Rotation

from limbgram.geometry.arrays import Matrix3, Points2
from limbgram.geometry.sampson import sampson_px
from limbgram.twoview.refinement import fit_sampson

FEWEST_MATCHES = 8
_SELECTIONS = 10


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
    found, _ = cv2.findFundamentalMat(xy_first, xy_second, ransac(threshold_px, seed))
    fundamental = np.asarray(found, float)
    if fundamental.shape != (3, 3) or not np.isfinite(fundamental).all():
        return none
    fundamental /= np.linalg.norm(fundamental)
    inliers = agreeing(fundamental, xy_first, xy_second, threshold_px)
    for _ in range(_SELECTIONS):
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
    def size(self) -> int:
        return 7

    @property
    def matrix(self) -> Matrix3:
        return (self.u * [np.cos(self.angle), np.sin(self.angle), 0.0]) @ self.v.T

    def moved(self, step: Float64[np.ndarray, "7"]) -> "_Orthonormal":
        turn_u = Rotation.from_rotvec(step[:3]).as_matrix()
        turn_v = Rotation.from_rotvec(step[3:6]).as_matrix()
        return _Orthonormal(self.u @ turn_u, self.v @ turn_v, self.angle + float(step[6]))
