"""Verdicts: whether board photos determine the camera, and which photos to add if not.

A doubt is told to the user; a refusal is raised.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.core.errors import CalibrationError
from limbgram.core.geometry.arrays import Points2
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE, Camera, lens_derivatives
from limbgram.findings import Finding, doubt, note
from limbgram.reconstruction.calibration.adjustment import Solution
from limbgram.reconstruction.calibration.cameras import label_of
from limbgram.reconstruction.photos.photo import Photo, left_out
from limbgram.reconstruction.targets.board import BoardDetections

_MIN_REACH = 0.1
"""Smallest reach of the board towards each corner of the picture, 0 to 1."""
_MAX_EDGE_SIGMA_PX = 5.0
"""Uncertainty of a ray in a corner of the picture beyond which calibration is refused."""
_CELLS = (12, 8)


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """Where in the picture the board was seen."""

    counts: Int32[np.ndarray, "rows columns"]
    """Corners in each cell of the picture."""
    reach: Float64[np.ndarray, "4"]
    """How far the corners reach from the middle towards each corner of the picture, 0 to 1:
    top left, top right, bottom left, bottom right."""

    @property
    def seen(self) -> float:
        """Share of cells with a corner in them."""
        return float((self.counts > 0).mean())


def coverage(xy_px: Points2, size_px: tuple[int, int]) -> Coverage:
    """Coverage of a picture by all corners of all photos."""
    width, height = size_px
    columns, rows = _CELLS if width >= height else _CELLS[::-1]
    counts, _, _ = np.histogram2d(
        xy_px[:, 1], xy_px[:, 0], bins=(rows, columns), range=((0, height), (0, width))
    )
    from_middle = (xy_px + 0.5) / np.array(size_px) * 2.0 - 1.0
    signs = np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]])
    inward = np.minimum(
        from_middle[:, None, 0] * signs[:, 0], from_middle[:, None, 1] * signs[:, 1]
    )
    reach = np.maximum(inward.max(axis=0), 0.0)
    return Coverage(counts=counts.astype(np.int32), reach=reach)


def tilts_deg(poses: tuple[Rigid, ...]) -> Float64[np.ndarray, " k"]:
    """Angle between the camera's axis and the board's normal, photo by photo."""
    return np.degrees(np.arccos(np.clip([abs(pose.rotation[2, 2]) for pose in poses], 0, 1)))


def refuse_contradiction(solution: Solution, limit_px: float) -> None:
    """Raise CalibrationError where no camera explains the photos together."""
    if solution.rms_px > limit_px:
        raise _contradiction(solution)


def _contradiction(solution: Solution) -> CalibrationError:
    return CalibrationError("lens.contradiction", rms_px=float(solution.rms_px))


def refuse_undetermined(solution: Solution, inflation: float, max_focal_sigma: float) -> None:
    """Raise CalibrationError where the photos leave the focal length open, or disagree on it."""
    sigma = inflation * float(np.sqrt(np.diag(solution.covariance)[:2].max()))
    share = sigma / float(solution.shared[:2].min())
    if share <= max_focal_sigma:
        return
    if share <= inflation * max_focal_sigma:
        raise _contradiction(solution)
    tilts = tilts_deg(solution.poses)
    raise CalibrationError(
        "lens.focal_uncertain",
        share=share,
        most=max_focal_sigma,
        least_deg=float(tilts.min()),
        most_deg=float(tilts.max()),
        photos=len(tilts),
    )


def edge_sigmas_px(
    lens: Camera, covariance: Float64[np.ndarray, "lens lens"]
) -> Float64[np.ndarray, "4"]:
    """What the lens leaves uncertain of a ray's pixel at the four corners of the picture.

    What a small turn of the camera or another focal length would make good over the whole
    picture does not count: this is the distortion's part.
    NaN where no ray leads to the corner: a very wide lens, beyond what this model describes.
    """
    right, bottom = lens.width_px - 1.0, lens.height_px - 1.0
    corners = np.array([[0, 0], [right, 0], [0, bottom], [right, bottom]])
    grid = np.mgrid[0:right:9j, 0:bottom:7j].reshape(2, -1).T  # pyright: ignore
    xy_px = np.concatenate([corners, grid])
    with np.errstate(over="ignore", invalid="ignore"):
        ideal = lens.normalize(xy_px)
        back_px = lens.project(np.column_stack([ideal, np.ones(len(ideal))]))
    known = np.abs(back_px - xy_px).max(axis=1) < 0.01 * lens.width_px
    x, y = ideal[known].T
    slopes = lens_derivatives(x, y, lens.packed)
    turns = np.empty((len(x), 2, 4))
    turns[:, 0] = np.stack([-x * y, 1.0 + x * x, -y, x], axis=1)
    turns[:, 1] = np.stack([-1.0 - y * y, x * y, x, y], axis=1)
    by_turn = (slopes.by_ideal @ turns).reshape(-1, 4)
    by_lens = slopes.by_lens.reshape(-1, LENS_SIZE)
    left = by_lens - by_turn @ np.linalg.lstsq(by_turn, by_lens, rcond=None)[0]
    variances = np.full((len(xy_px), 2), np.nan)
    variances[known] = np.einsum("ni,ij,nj->n", left, covariance, left).reshape(-1, 2)
    return np.sqrt(np.maximum(variances[:4].max(axis=1), 0.0))


def refuse_uncovered(seen: Coverage, edge_sigmas_px: Float64[np.ndarray, "4"]) -> None:
    """Raise CalibrationError where the distortion is unknown in a corner of the picture."""
    bare = tuple(
        name
        for name, reach, sigma_px in zip(_CORNERS, seen.reach, edge_sigmas_px)
        if reach < _MIN_REACH or sigma_px > _MAX_EDGE_SIGMA_PX
    )
    if bare:
        raise CalibrationError("lens.uncovered", corners=bare)


_CORNERS = ("top left", "top right", "bottom left", "bottom right")


def doubts(
    seen: Coverage,
    edge_sigmas_px: Float64[np.ndarray, "4"],
    solution: Solution,
    inflation: float,
    *,
    few_photos: int,
    good_reach: float,
) -> tuple[Finding, ...]:
    """What is accepted but not as it should be."""
    found: list[Finding] = []
    photos = len(solution.poses)
    if photos < few_photos:
        found.append(doubt("lens.doubt.few_photos", photos=photos))
    weak = tuple(name for name, reach in zip(_CORNERS, seen.reach) if reach < good_reach)
    if weak:
        found.append(doubt("lens.doubt.reach", corners=weak, good=good_reach))
    if np.isnan(edge_sigmas_px).any():
        found.append(doubt("lens.doubt.too_wide"))
    if inflation > 2.0:
        found.append(doubt("lens.doubt.spread", times=float(inflation)))
    if solution.rms_px > 0.5:
        found.append(doubt("lens.doubt.residuals", rms_px=float(solution.rms_px)))
    tilts = tilts_deg(solution.poses)
    if tilts.max() < 15.0:
        found.append(doubt("lens.doubt.tilt", most_deg=float(tilts.max())))
    return tuple(found)


def refuse_few(detections: BoardDetections, min_photos: int) -> None:
    if len(detections.photos) >= min_photos:
        return
    found, count = len(detections.photos), len(detections.photos) + len(detections.set_aside)
    board = detections.board.finding
    cause = detections.cause
    if cause is None:
        unseen = left_out(detections.set_aside[:3])
        cause = doubt("lens.board_unseen", count=len(unseen), photos=unseen)
    raise CalibrationError(
        "lens.few_photos", board=board, found=found, count=count, least=min_photos, cause=cause
    )


def refuse_mixed(photos: tuple[Photo, ...]) -> None:
    """Refuse photos of several sizes, cameras or zoom settings, with names.

    Two bodies of one model are two cameras; a file that names no body may be of either.
    """
    several = len({photo.exif.body for photo in photos} - {None}) > 1
    groups: dict[tuple[str | float | None, ...], list[Photo]] = {}
    for photo in photos:
        exif = photo.exif
        zooms = exif.focal_mm, exif.focal_35mm, exif.digital_zoom
        body = exif.body if several else None
        key = photo.width_px, photo.height_px, label_of(exif), body, *zooms
        groups.setdefault(key, []).append(photo)
    if len(groups) > 1:
        told = tuple(map(_group, groups.values()))
        raise CalibrationError("lens.mixed", count=len(groups), groups=told)


def _group(photos: Sequence[Photo]) -> Finding:
    """Photos of one camera and zoom."""
    first = photos[0]
    return note(
        "lens.group",
        width_px=first.width_px,
        height_px=first.height_px,
        label=label_of(first.exif) or None,
        focal_mm=first.exif.focal_mm,
        film_mm=first.exif.focal_35mm,
        zoom=first.exif.digital_zoom,
        names=tuple(photo.name for photo in photos),
    )
