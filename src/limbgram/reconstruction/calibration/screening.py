"""Screening: a first solution, outlier photos and corners, and model selection.

In      the board's corners in all photos.
Out     a solution with only good photos and good corners, and the reasons for the others.
Method  OpenCV's calibration (Zhang 2000) starts; the worst photo goes while it is far worse
        than the others, then corners go that lie far outside the inflation of all.
"""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, field

import cv2
import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.errors import CalibrationError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import HELD, LENS_SIZE, PARAMETERS, RADIAL
from limbgram.core.interval import rms
from limbgram.findings import doubt
from limbgram.reconstruction.calibration.adjustment import (
    SHARED,
    BoardObservation,
    Solution,
    adjust,
    scatter,
)
from limbgram.reconstruction.photos.photo import SetAside

_SIGNIFICANCE = 5.0
"""Sigmas from zero from which skew or k3 is significant."""
_MEANINGFUL_SKEW_PX = 0.5
"""Shift at the picture's edge below which even a significant skew is not delivered."""
SKEW = PARAMETERS.index("skew")
K3 = PARAMETERS.index("k3")
_LENIENT_PX = 0.05
"""Residual below which no photo or corner is left out, however good the others are."""
_FEWEST_CORNERS = 4
"""Corners that hold the pose of a photo."""


@dataclass(frozen=True)
class Screened:
    """The inlier observations, their solution, and what was left out."""

    observations: tuple[BoardObservation, ...]
    solution: Solution
    set_aside: tuple[SetAside, ...] = ()
    dropped: dict[str, int] = field(default_factory=dict[str, int])
    """Corners left out, by photo."""


def free_unknowns(*, k3: bool, skew: bool, board: bool) -> Bool[np.ndarray, " shared"]:
    """Which shared unknowns an adjustment estimates; the others stay as they are."""
    free = np.ones(SHARED, bool)
    free[[PARAMETERS.index(name) for name in HELD]] = False
    free[K3], free[SKEW] = k3, skew
    free[LENS_SIZE:] = board
    return free


def screen(
    observations: tuple[BoardObservation, ...],
    board_mm: Points3,
    size_px: tuple[int, int],
    free: Bool[np.ndarray, " shared"],
    *,
    min_photos: int,
    photo_factor: float,
    corner_sigmas: float,
) -> Screened:
    """Adjust, leaving out photos and corners that contradict the others.

    Args:
        photo_factor: A photo goes when its RMS is this many times the median of all.
        corner_sigmas: A corner goes when it is this many robust sigmas off.
    """
    solution = _start(observations, board_mm, size_px, free)
    set_aside: list[SetAside] = []
    while len(observations) > min_photos:
        rms_px = np.array([rms(residual) for residual in solution.residuals_px])
        worst, limit = int(rms_px.argmax()), photo_factor * float(np.median(rms_px))
        if rms_px[worst] <= max(limit, _LENIENT_PX):
            break
        set_aside.append(_fits_badly(observations[worst].name, rms_px, worst))
        observations = observations[:worst] + observations[worst + 1 :]
        solution = _start(observations, board_mm, size_px, free)
    return _without_bad_corners(
        observations, board_mm, solution, tuple(set_aside), corner_sigmas, min_photos
    )


def readjust(screened: Screened, board_mm: Points3, free: Bool[np.ndarray, " shared"]) -> Solution:
    """Adjust the same observations with other free unknowns; fixed ones become zero."""
    shared = np.where(free, screened.solution.shared, 0.0)
    return adjust(screened.observations, board_mm, shared, screened.solution.poses, free)


def _without_bad_corners(
    observations: tuple[BoardObservation, ...],
    board_mm: Points3,
    solution: Solution,
    set_aside: tuple[SetAside, ...],
    corner_sigmas: float,
    min_photos: int,
) -> Screened:
    """Without bad corners, and without photos of which too few others are left.

    Raises:
        CalibrationError: too few photos are left.
    """
    dropped = {one.name: 0 for one in observations}
    for _ in range(3):
        off_px = [np.linalg.norm(residual, axis=1) for residual in solution.residuals_px]
        sigma_px = float(np.median(np.concatenate(off_px))) / 1.1774
        limit_px = max(corner_sigmas * sigma_px, _LENIENT_PX)
        keeps = [one <= limit_px for one in off_px]
        if all(keep.all() for keep in keeps):
            break
        for one, keep in zip(observations, keeps):
            dropped[one.name] += int((~keep).sum())
        kept = [one.only(keep) for one, keep in zip(observations, keeps)]
        held = [k for k, one in enumerate(kept) if len(one.ids) >= _FEWEST_CORNERS]
        if len(held) < min_photos:
            raise CalibrationError("lens.contradiction", rms_px=float(solution.rms_px))
        rms_px = np.array([rms(residual) for residual in solution.residuals_px])
        set_aside += tuple(
            _fits_badly(one.name, rms_px, k) for k, one in enumerate(kept) if k not in held
        )
        observations = tuple(kept[k] for k in held)
        poses = tuple(solution.poses[k] for k in held)
        solution = adjust(observations, board_mm, solution.shared, poses, solution.free)
    return Screened(observations, solution, set_aside, dropped)


def _fits_badly(name: str, rms_px: Float64[np.ndarray, " photos"], photo: int) -> SetAside:
    """One of the photos, with its RMS beside that of the others."""
    others_px = float(np.median(rms_px))
    off = doubt("lens.photo.off", rms_px=float(rms_px[photo]), others_px=others_px)
    return SetAside(name, off)


def _start(
    observations: tuple[BoardObservation, ...],
    board_mm: Points3,
    size_px: tuple[int, int],
    free: Bool[np.ndarray, " shared"],
) -> Solution:
    """The initial solution by OpenCV, adjusted with our unknowns."""
    flags = cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_ASPECT_RATIO
    guess = np.diag([float(max(size_px)), float(max(size_px)), 1.0])
    try:
        with _opencv_on_one_thread():
            _, matrix, distortion, turns, shifts = cv2.calibrateCamera(
                [board_mm[one.ids].astype(np.float32) for one in observations],
                [one.xy_px.astype(np.float32).reshape(-1, 1, 2) for one in observations],
                size_px,
                guess,
                np.zeros(5),
                flags=flags,
            )
    except cv2.error as error:
        raise CalibrationError("lens.unexplained") from error
    shared = np.zeros(SHARED)
    shared[:4] = np.asarray(matrix)[[0, 1, 0, 1], [0, 1, 2, 2]]
    shared[RADIAL[:2]] = np.asarray(distortion).ravel()[:2]
    poses = tuple(
        Rigid.from_rotation_vector(np.ravel(turn), np.ravel(shift))
        for turn, shift in zip(turns, shifts)
    )
    if not np.isfinite(shared).all() or min(shared[:2]) <= 0:
        raise CalibrationError("lens.parallel")
    return adjust(observations, board_mm, shared, poses, free)


@contextmanager
def _opencv_on_one_thread() -> Generator[None]:
    """Let OpenCV add its photos up in their order, so that the same photos give the same bytes.

    On several threads `cv2.calibrateCamera` sums the normal equations in the order in which the
    threads end; then the lens differed at 1e-11 from run to run, and every surface with it.
    """
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


@dataclass(frozen=True)
class Estimate:
    """A number with its standard deviation."""

    value: float
    sigma: float

    @property
    def sigmas_from_zero(self) -> float:
        return abs(self.value) / self.sigma if self.sigma > 0 else 0.0


@dataclass(frozen=True)
class ModelChoice:
    """The selected model, with the estimates of skew and k3 that decided."""

    solution: Solution
    skew: Estimate
    k3: Estimate


def select_model(
    screened: Screened,
    board_mm: Points3,
    size_px: tuple[int, int],
    *,
    bend: bool,
    board_gain: float,
) -> ModelChoice:
    """Select the model: k3, the board's shape and skew are kept only where they are significant.

    Args:
        bend: Whether the photos can determine the board's shape.
    """
    if bend:
        flat = readjust(screened, board_mm, free_unknowns(k3=True, skew=False, board=False))
        bent = readjust(screened, board_mm, free_unknowns(k3=True, skew=False, board=True))
        bend = bent.rms_px < (1.0 - board_gain) * flat.rms_px
    with_k3 = readjust(screened, board_mm, free_unknowns(k3=True, skew=False, board=bend))
    k3 = _estimate(with_k3, K3)
    inflation = max(1.0, scatter(screened.observations, board_mm, with_k3))
    keeps_k3 = k3.sigmas_from_zero > _SIGNIFICANCE * inflation
    with_skew = readjust(screened, board_mm, free_unknowns(k3=keeps_k3, skew=True, board=bend))
    skew = _estimate(with_skew, SKEW)
    inflation = max(1.0, scatter(screened.observations, board_mm, with_skew))
    shift_px = abs(skew.value) * 0.5 * size_px[1] / float(with_skew.shared[1])
    if skew.sigmas_from_zero > _SIGNIFICANCE * inflation and shift_px > _MEANINGFUL_SKEW_PX:
        return ModelChoice(with_skew, skew, k3)
    plain = readjust(screened, board_mm, free_unknowns(k3=keeps_k3, skew=False, board=bend))
    return ModelChoice(plain, skew, k3)


def _estimate(solution: Solution, row: int) -> Estimate:
    return Estimate(
        float(solution.shared[row]), float(np.sqrt(max(0.0, solution.covariance[row, row])))
    )
