"""Adjustment: lens, shape of the board and all poses at once, by least squares.

In      corners of one board in many photos, a start, and which shared unknowns are free.
Out     the solution with residuals and the covariance of the shared unknowns.
Method  Levenberg-Marquardt; poses are eliminated photo by photo (Schur complement), so the system
        to solve has the size of the lens alone. The unknowns that all photos share are the lens
        (lens.PARAMETERS) followed by the board's shape (BOARD_TERMS). Each photo adds a pose of
        six: a small rotation applied after the present one, and a translation in millimetres.
Fails   CalibrationError: the photos leave the free unknowns undetermined.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int32

from limbgram.core.errors import CalibrationError
from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, lens_derivatives
from limbgram.core.optimisation import ArrowheadEquations, Descent, Trial, minimise

BOARD_TERMS = ("stretch", "shear", "bend_xx", "bend_xy", "bend_yy")
"""How a print differs from its drawing, as fractions of half the board's long side: y grows by
`stretch` of itself, x leans by `shear` of y, and z is a quadratic form of x and y."""

SHARED = LENS_SIZE + len(BOARD_TERMS)


class Projection(NamedTuple):
    """Pixels, and their derivatives by the shared unknowns and by the photo's pose."""

    xy_px: Points2
    by_shared: Float64[np.ndarray, "n 2 shared"]
    by_pose: Float64[np.ndarray, "n 2 6"]


def bent_board(corners_mm: Points3, terms: Float64[np.ndarray, "5"], board_mm: Points3) -> Points3:
    """Corners of the board as printed and bent, for the whole board they belong to."""
    return corners_mm + np.einsum("nit,t->ni", board_slopes(corners_mm, board_mm), terms)


def project_board(
    corners_mm: Points3,
    slopes: Float64[np.ndarray, "n 3 5"],
    shared: Float64[np.ndarray, " shared"],
    pose: Rigid,
) -> Projection:
    """Corners in pixels, with derivatives.

    Args:
        slopes: Of these corners by the terms of the board's shape (`board_slopes`).
        pose: camera_from_board.
    """
    on_board = corners_mm + slopes @ shared[LENS_SIZE:]
    turned = on_board @ pose.rotation.T
    in_camera = turned + pose.translation
    inverse = 1.0 / in_camera[:, 2]
    x, y = in_camera[:, 0] * inverse, in_camera[:, 1] * inverse
    xy_px, by_ideal, by_lens = lens_derivatives(x, y, shared[:LENS_SIZE])

    by_point = np.empty((len(x), 2, 3))
    by_point[:, :, 0] = by_ideal[:, :, 0] * inverse[:, None]
    by_point[:, :, 1] = by_ideal[:, :, 1] * inverse[:, None]
    by_point[:, :, 2] = -(by_point[:, :, 0] * x[:, None] + by_point[:, :, 1] * y[:, None])

    by_pose = np.empty((len(x), 2, POSE_SIZE))
    by_pose[:, :, :3] = np.cross(turned[:, None, :], by_point)
    by_pose[:, :, 3:] = by_point
    by_board = np.einsum("nij,jk,nkt->nit", by_point, pose.rotation, slopes)
    return Projection(xy_px, np.concatenate([by_lens, by_board], axis=2), by_pose)


def moved(pose: Rigid, step: Float64[np.ndarray, "6"]) -> Rigid:
    """A pose after a step of its six unknowns."""
    turn = Rigid.from_rotation_vector(step[:3], np.zeros(3))
    return Rigid(turn.rotation @ pose.rotation, pose.translation + step[3:])


_DESCENT = Descent(
    iterations=50, smallest_gain=1e-12, least_gain=1e-14, damping=1e-4, least_damping=1e-12
)
_BOARD_SIGMAS = np.array([0.01, 0.01, 0.02, 0.02, 0.02])
"""What is known beforehand of a print and its mounting (BOARD_TERMS): little."""
_TYPICAL_PX = 0.1
"""Sigma of a corner that gives the board's prior its weight against the corners."""


@dataclass(frozen=True)
class BoardObservation:
    """The board's corners in one photo."""

    name: str
    ids: Int32[np.ndarray, " n"]
    xy_px: Points2

    def only(self, keep: Bool[np.ndarray, " n"]) -> "BoardObservation":
        return replace(self, ids=self.ids[keep], xy_px=self.xy_px[keep])


@dataclass(frozen=True, kw_only=True)
class Solution:
    """An adjusted lens, board and poses."""

    shared: Float64[np.ndarray, " shared"]
    """Lens (lens.PARAMETERS), then the board's terms (BOARD_TERMS)."""
    free: Bool[np.ndarray, " shared"]
    poses: tuple[Rigid, ...]
    """camera_from_board, one a photo."""
    residuals_px: tuple[Points2, ...]
    """Seen minus projected, photo by photo."""
    cofactors: Float64[np.ndarray, "shared shared"]
    """Inverse of the reduced normal matrix; zero where not free."""

    @property
    def squares(self) -> float:
        """Sum of the squared residuals, px^2."""
        return float(sum((residual**2).sum() for residual in self.residuals_px))

    @property
    def rms_px(self) -> float:
        """Root mean square distance per corner, as OpenCV's calibration reports it."""
        return float(np.sqrt(self.squares / sum(len(one) for one in self.residuals_px)))

    @property
    def sigma0_px(self) -> float:
        """A posteriori standard deviation of one coordinate."""
        observations = sum(2 * len(one) for one in self.residuals_px)
        unknowns = int(self.free.sum()) + POSE_SIZE * len(self.poses)
        return float(np.sqrt(self.squares / max(1, observations - unknowns)))

    @property
    def covariance(self) -> Float64[np.ndarray, "shared shared"]:
        return self.cofactors * self.sigma0_px**2


_State = tuple[Float64[np.ndarray, " shared"], tuple[Rigid, ...], ArrowheadEquations]


def adjust(
    observations: tuple[BoardObservation, ...],
    board_mm: Points3,
    shared: Float64[np.ndarray, " shared"],
    poses: tuple[Rigid, ...],
    free: Bool[np.ndarray, " shared"],
) -> Solution:
    """The least-squares solution from a start near it.

    Raises:
        CalibrationError: the free unknowns cannot be told apart in these photos.
    """

    def tried(shared: Float64[np.ndarray, " shared"], poses: tuple[Rigid, ...]) -> Trial[_State]:
        equations, cost = _equations(observations, board_mm, shared, poses)
        return Trial((shared, poses, equations), cost)

    def linearised(state: _State) -> Callable[[float], Trial[_State]]:
        shared, poses, equations = state

        def step(damping: float) -> Trial[_State]:
            damped = equations.damped(damping)
            reduced, right = damped.reduced()
            by_shared = np.zeros(SHARED)
            by_shared[free] = _inverse(reduced[np.ix_(free, free)]) @ right[free]
            by_pose = damped.back_substituted(by_shared)
            return tried(
                shared + by_shared, tuple(moved(pose, one) for pose, one in zip(poses, by_pose))
            )

        return step

    start = tried(shared, poses)
    shared, poses, equations = minimise(start.state, start.cost, linearised, _DESCENT)
    slopes = board_slopes(board_mm, board_mm)
    both, cofactors = np.ix_(free, free), np.zeros((SHARED, SHARED))
    cofactors[both] = _inverse(equations.reduced()[0][both])
    return Solution(
        shared=shared,
        free=free,
        poses=poses,
        residuals_px=tuple(
            one.xy_px - project_board(board_mm[one.ids], slopes[one.ids], shared, pose).xy_px
            for one, pose in zip(observations, poses)
        ),
        cofactors=cofactors,
    )


def scatter(
    observations: tuple[BoardObservation, ...], board_mm: Points3, solution: Solution
) -> float:
    """How much more the lens scatters from photo to photo than its covariance says.

    Delete-one jackknife over photos, linearized (Bell and McCaffrey 2002, CR3): errors that the
    corners of one photo share, as from a wavy print, show here and not in sigma0. Median over
    the free lens parameters of jackknife over formal sigma; 1 for independent errors.
    """
    free = solution.free
    whole = np.linalg.pinv(solution.cofactors[np.ix_(free, free)], hermitian=True)
    shifts: list[np.ndarray] = []
    for one, pose in zip(observations, solution.poses):
        alone, _ = _equations((one,), board_mm, solution.shared, (pose,), with_prior=False)
        reduced = alone.reduced()[0][np.ix_(free, free)]
        shifts.append(_inverse(whole - reduced) @ alone.shared_right[free])
    count = len(shifts)
    variance = (count - 1) / count * (np.array(shifts) ** 2).sum(axis=0)
    lens = np.flatnonzero(free) < LENS_SIZE
    formal = np.diag(solution.covariance)[free]
    return float(np.sqrt(np.median((variance / formal)[lens])))


def board_slopes(
    corners_mm: Points3, board_mm: Float64[np.ndarray, "all 3"]
) -> Float64[np.ndarray, "n 3 5"]:
    """Derivatives of the corners by the board's terms; its shape is linear in them.

    Args:
        board_mm: All corners of the board: they set the origin and size of its shape's terms.
    """
    middle = 0.5 * (board_mm.min(axis=0) + board_mm.max(axis=0))
    half_mm = 0.5 * float(np.ptp(board_mm, axis=0).max())
    u, v = ((corners_mm - middle)[:, :2] / half_mm).T
    slopes = np.zeros((len(corners_mm), 3, len(BOARD_TERMS)))
    slopes[:, 1, 0] = v
    slopes[:, 0, 1] = v
    slopes[:, 2, 2] = u * u
    slopes[:, 2, 3] = u * v
    slopes[:, 2, 4] = v * v
    return slopes * half_mm


def _equations(
    observations: tuple[BoardObservation, ...],
    board_mm: Points3,
    shared: Float64[np.ndarray, " shared"],
    poses: tuple[Rigid, ...],
    *,
    with_prior: bool = True,
) -> tuple[ArrowheadEquations, float]:
    """Of all photos, with the weak prior on the board's shape; and the sum of squares."""
    matrix, right, cost = np.zeros((SHARED, SHARED)), np.zeros(SHARED), 0.0
    cross = np.empty((len(poses), POSE_SIZE, SHARED))
    posed = np.empty((len(poses), POSE_SIZE, POSE_SIZE))
    pose_right = np.empty((len(poses), POSE_SIZE))
    slopes = board_slopes(board_mm, board_mm)
    for row, (one, pose) in enumerate(zip(observations, poses)):
        projection = project_board(board_mm[one.ids], slopes[one.ids], shared, pose)
        a = projection.by_shared.reshape(-1, SHARED)
        b = projection.by_pose.reshape(-1, POSE_SIZE)
        residual = (one.xy_px - projection.xy_px).ravel()
        cost += float(residual @ residual)
        matrix += a.T @ a
        right += a.T @ residual
        cross[row], posed[row], pose_right[row] = b.T @ a, b.T @ b, b.T @ residual
    weights = np.zeros(SHARED)
    if with_prior:
        weights[LENS_SIZE:] = (_TYPICAL_PX / _BOARD_SIGMAS) ** 2
    cost += float(weights @ shared**2)
    equations = ArrowheadEquations(
        matrix + np.diag(weights), right - weights * shared, posed, cross, pose_right
    )
    return equations, cost


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse of a symmetric positive matrix whose rows differ much in unit."""
    unit = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = matrix * unit[:, None] * unit
    finite = bool(np.isfinite(scaled).all())
    values, vectors = np.linalg.eigh(scaled if finite else np.zeros_like(scaled))
    if not finite or values[0] <= 1e-14 * values[-1]:
        raise CalibrationError("lens.undetermined")
    return (vectors / values) @ vectors.T * np.outer(unit, unit)
