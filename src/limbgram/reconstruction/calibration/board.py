"""Calibration: the lens from photos of a board of known size.

In      a PhotoSet of one camera, and the Board in it.
Out     a BoardCalibration: the camera with its covariance, and everything needed to judge it.
Method  plane-based calibration (Zhang 2000) started by OpenCV and finished by our own
        adjustment, which also tests skew, the sixth-order distortion and the board's flatness.
Fails   CalibrationError: too few photos, mixed cameras, a board of another size, views that
        leave the camera open.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.core.geometry.arrays import Points2
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE, Camera
from limbgram.core.notebook import brief
from limbgram.findings import Finding
from limbgram.reconstruction.calibration.adjustment import (
    BOARD_TERMS,
    BoardObservation,
    Solution,
    scatter,
)
from limbgram.reconstruction.calibration.cameras import Calibration, label_of
from limbgram.reconstruction.calibration.screening import (
    K3,
    SKEW,
    Estimate,
    ModelChoice,
    Screened,
    free_unknowns,
    screen,
    select_model,
)
from limbgram.reconstruction.calibration.verdicts import (
    Coverage,
    coverage,
    doubts,
    edge_sigmas_px,
    refuse_contradiction,
    refuse_few,
    refuse_mixed,
    refuse_uncovered,
    refuse_undetermined,
)
from limbgram.reconstruction.photos.photo import Photo, PhotoSet, SetAside, naming_left_out
from limbgram.reconstruction.targets.board import Board, BoardDetections
from limbgram.reconstruction.targets.board_detection import find_board

_MAX_RMS_PX = 1.0
"""RMS of the corners beyond which calibration is refused (see `max_rms`)."""
_MAX_RMS = 0.0003
"""The same over the picture's longer side, for large pictures; the larger of both holds."""
_MAX_FOCAL_SIGMA = 0.01
"""Relative sigma of the focal length beyond which calibration is refused."""


MIN_PHOTOS = 3
"""Photos of the board without which calibration is refused."""
_FEW_PHOTOS = 6
"""Photos below which the result is doubted; the board's shape is not tested below it."""
_PHOTO_FACTOR = 3.0
"""A photo is set aside when its RMS is this many times the median of all photos."""
_CORNER_SIGMAS = 5.0
"""A corner is left out when it is this many robust sigmas off."""
_GOOD_REACH = 0.5
"""Reach from which the result is not doubted."""


@dataclass(frozen=True, kw_only=True)
class CalibrationOptions:
    """When a term of the model is kept."""

    board_gain: float = 0.03
    """Relative decrease of the RMS from which the board's print and flatness are estimated too."""


DEFAULTS = CalibrationOptions()

_MAX_SIGMA_FACTOR = 5.0
"""Times the accepted sigma of the focal length beyond which no choice of model can help."""


@dataclass(frozen=True, kw_only=True)
class PhotoFit:
    """Pose and residuals of one calibration photo."""

    name: str
    camera_from_board: Rigid
    ids: Int32[np.ndarray, " n"]
    xy_px: Points2
    residuals_px: Points2
    """Seen minus projected."""
    dropped: int
    """Corners left out, here and at detection."""

    @property
    def rms_px(self) -> float:
        return float(np.sqrt((self.residuals_px**2).sum(axis=1).mean()))


@dataclass(frozen=True, kw_only=True)
class BoardCalibration:
    """A camera calibrated from a board, with what is needed to judge it."""

    calibration: Calibration
    board: Board
    photos: tuple[PhotoFit, ...]
    set_aside: tuple[SetAside, ...]
    """Files that are no photos that can be used, photos without the board, and those that fit
    badly."""
    sigma0_px: float
    """Standard deviation of one coordinate of one corner."""
    inflation: float
    """Factor on all sigmas for errors that the corners of one photo share; 1 where none show."""
    correlations: Float64[np.ndarray, "lens lens"]
    """Correlations of the lens parameters (lens.PARAMETERS); zero rows for fixed ones."""
    aspect: Estimate
    """fy / fx."""
    skew: Estimate
    """Estimated for the test against zero, delivered or not."""
    skew_delivered: bool
    k3: Estimate
    """The same for the sixth-order distortion."""
    k3_delivered: bool
    board_shape: tuple[Estimate, ...] | None
    """How the board differs from flat and true (adjustment.BOARD_TERMS); None: it does not."""
    coverage: Coverage
    edge_sigmas_px: Float64[np.ndarray, "4"]
    """Sigma of a ray's place in the four corners of the picture (order of Coverage.reach)."""
    doubts: tuple[Finding, ...]

    __repr__ = brief


def calibrate(
    photos: PhotoSet, board: Board, options: CalibrationOptions = DEFAULTS
) -> BoardCalibration:
    """Calibrate the one camera that took these photos of a board."""
    with naming_left_out(photos.set_aside):
        return calibrate_detections(photos, find_board(photos, board), options)


def calibrate_detections(
    photos: PhotoSet, detections: BoardDetections, options: CalibrationOptions = DEFAULTS
) -> BoardCalibration:
    """Calibrate from corners already found."""
    seen_by = tuple(photos.photos[one.photo_idx] for one in detections.photos)
    refuse_few(detections, MIN_PHOTOS)
    refuse_mixed(seen_by)
    size_px = (seen_by[0].width_px, seen_by[0].height_px)
    board_mm = detections.corners_mm
    screened, choice = _screened(detections, size_px, options)
    solution = choice.solution
    inflation = max(1.0, scatter(screened.observations, board_mm, solution))
    seen = coverage(np.concatenate([one.xy_px for one in screened.observations]), size_px)
    refuse_contradiction(solution, max(_MAX_RMS_PX, _MAX_RMS * max(size_px)))
    refuse_undetermined(solution, inflation, _MAX_FOCAL_SIGMA)
    covariance = solution.covariance * inflation**2
    lens = Camera(
        width_px=size_px[0], height_px=size_px[1], fx=1.0, fy=1.0, cx=0.0, cy=0.0
    ).with_parameters(solution.shared[:LENS_SIZE])
    edges_px = edge_sigmas_px(lens, covariance[:LENS_SIZE, :LENS_SIZE])
    refuse_uncovered(seen, edges_px)
    return BoardCalibration(
        calibration=_calibration(lens, covariance, solution.rms_px, seen_by),
        board=detections.board,
        photos=_photo_fits(screened, solution, detections),
        set_aside=(*photos.set_aside, *detections.set_aside, *screened.set_aside),
        sigma0_px=solution.sigma0_px,
        inflation=inflation,
        correlations=_correlations(covariance[:LENS_SIZE, :LENS_SIZE]),
        aspect=_aspect(solution.shared, covariance),
        skew=replace(choice.skew, sigma=choice.skew.sigma * inflation),
        skew_delivered=bool(solution.free[SKEW]),
        k3=replace(choice.k3, sigma=choice.k3.sigma * inflation),
        k3_delivered=bool(solution.free[K3]),
        board_shape=_board_shape(solution, covariance),
        coverage=seen,
        edge_sigmas_px=edges_px,
        doubts=doubts(
            seen,
            edges_px,
            solution,
            inflation,
            few_photos=_FEW_PHOTOS,
            good_reach=_GOOD_REACH,
        ),
    )


def _screened(
    detections: BoardDetections, size_px: tuple[int, int], options: CalibrationOptions
) -> tuple[Screened, ModelChoice]:
    """The inlier observations and the selected model."""
    observations = tuple(
        BoardObservation(one.name, one.ids, one.xy_px) for one in detections.photos
    )
    many = len(observations) >= _FEW_PHOTOS
    bend = many and not detections.board.has_quarter_turns
    screened = screen(
        observations,
        detections.corners_mm,
        size_px,
        free_unknowns(k3=many, skew=False, board=bend),
        min_photos=MIN_PHOTOS,
        photo_factor=_PHOTO_FACTOR,
        corner_sigmas=_CORNER_SIGMAS,
    )
    refuse_undetermined(screened.solution, 1.0, _MAX_SIGMA_FACTOR * _MAX_FOCAL_SIGMA)
    choice = select_model(
        screened,
        detections.corners_mm,
        size_px,
        bend=bend and len(screened.observations) >= _FEW_PHOTOS,
        board_gain=options.board_gain,
    )
    return screened, choice


def _calibration(
    lens: Camera, covariance: np.ndarray, rms_px: float, seen_by: Sequence[Photo]
) -> Calibration:
    """The calibration, labelled with the camera that took the photos."""
    exif = seen_by[0].exif
    return Calibration(
        camera=lens,
        covariance=covariance[:LENS_SIZE, :LENS_SIZE].copy(),
        source="board",
        label=label_of(exif),
        focal_mm=exif.focal_mm,
        focal_35mm=exif.focal_35mm,
        digital_zoom=exif.digital_zoom,
        body=exif.body,
        rms_px=rms_px,
        edge_px=_typical_edge_px(seen_by),
    )


def _typical_edge_px(photos: Sequence[Photo]) -> float | None:
    """Median edge width of the photos in which it was measured; None if in none."""
    widths = np.array([one.sharpness for one in photos])
    known = widths[np.isfinite(widths)]
    return float(np.median(known)) if len(known) else None


def _aspect(shared: np.ndarray, covariance: np.ndarray) -> Estimate:
    fx, fy = float(shared[0]), float(shared[1])
    slope = np.array([-fy / fx**2, 1.0 / fx])
    return Estimate(fy / fx, float(np.sqrt(slope @ covariance[:2, :2] @ slope)))


def _board_shape(solution: Solution, covariance: np.ndarray) -> tuple[Estimate, ...] | None:
    if not solution.free[LENS_SIZE:].any():
        return None
    return tuple(
        Estimate(float(solution.shared[row]), float(np.sqrt(covariance[row, row])))
        for row in range(LENS_SIZE, LENS_SIZE + len(BOARD_TERMS))
    )


def _correlations(covariance: np.ndarray) -> Float64[np.ndarray, "lens lens"]:
    sigmas = np.sqrt(np.diag(covariance))
    scale = np.where(sigmas > 0, 1.0 / np.where(sigmas > 0, sigmas, 1.0), 0.0)
    return covariance * np.outer(scale, scale)


def _photo_fits(
    screened: Screened, solution: Solution, detections: BoardDetections
) -> tuple[PhotoFit, ...]:
    doubtful = {one.name: len(one.doubts) for one in detections.photos}
    return tuple(
        PhotoFit(
            name=one.name,
            camera_from_board=pose,
            ids=one.ids,
            xy_px=one.xy_px,
            residuals_px=residuals_px,
            dropped=doubtful[one.name] + screened.dropped[one.name],
        )
        for one, pose, residuals_px in zip(
            screened.observations, solution.poses, solution.residuals_px
        )
    )
