"""Verdicts: whether photos of a board determine the camera, and what to photograph if not.

A doubt is told to the user; a refusal is raised.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.core.errors import CalibrationError
from limbgram.core.geometry.arrays import Points2
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE, Camera, lens_slopes
from limbgram.reconstruction.calibration.adjustment import Solution
from limbgram.reconstruction.calibration.cameras import label_of
from limbgram.reconstruction.photos.photo import Photo
from limbgram.reconstruction.targets.board import BoardDetections

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
    return CalibrationError(
        "No one camera explains these photos of the board together: the corners are "
        f"{solution.rms_px:.2f} px off. The zoom or focus changed between the photos, the board "
        "bends, or the lens is a fisheye. Fix zoom and focus, mount the board on a stiff plate, "
        "and take the photos again."
    )


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
        f"The focal length stays uncertain by {share:.1%} (at most {max_focal_sigma:.1%} is "
        f"accepted): the board was tilted by {tilts.min():.0f} to {tilts.max():.0f} degrees "
        f"against the sensor in {len(tilts)} photos. Take 12 or more photos with the board "
        "tilted by 20 to 45 degrees to all sides, and some with the camera turned upright."
    )


def edge_sigmas_px(
    lens: Camera, covariance: Float64[np.ndarray, "10 10"]
) -> Float64[np.ndarray, "4"]:
    """How uncertain the lens leaves a ray's pixel in the four corners of the picture.

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
    slopes = lens_slopes(x, y, lens.packed)
    turns = np.empty((len(x), 2, 4))
    turns[:, 0] = np.stack([-x * y, 1.0 + x * x, -y, x], axis=1)
    turns[:, 1] = np.stack([-1.0 - y * y, x * y, x, y], axis=1)
    by_turn = (slopes.by_ideal @ turns).reshape(-1, 4)
    by_lens = slopes.by_lens.reshape(-1, LENS_SIZE)
    left = by_lens - by_turn @ np.linalg.lstsq(by_turn, by_lens, rcond=None)[0]
    variances = np.full((len(xy_px), 2), np.nan)
    variances[known] = np.einsum("ni,ij,nj->n", left, covariance, left).reshape(-1, 2)
    return np.sqrt(np.maximum(variances[:4].max(axis=1), 0.0))


def refuse_uncovered(
    seen: Coverage,
    edge_sigmas_px: Float64[np.ndarray, "4"],
    min_reach: float,
    max_edge_sigma_px: float,
) -> None:
    """Raise CalibrationError where the distortion is unknown in a corner of the picture."""
    bare = [
        name
        for name, reach, sigma_px in zip(_CORNERS, seen.reach, edge_sigmas_px)
        if reach < min_reach or sigma_px > max_edge_sigma_px
    ]
    if bare:
        raise CalibrationError(
            f"The board never came near the {', '.join(bare)} of the picture, so the lens's "
            "distortion is unknown there. Add photos in which the board fills the picture, and "
            "some with it in each corner."
        )


_CORNERS = ("top left", "top right", "bottom left", "bottom right")


def doubts(
    seen: Coverage,
    edge_sigmas_px: Float64[np.ndarray, "4"],
    solution: Solution,
    inflation: float,
    *,
    few_photos: int,
    good_reach: float,
) -> tuple[str, ...]:
    """What is accepted but not as it should be."""
    said: list[str] = []
    photos = len(solution.poses)
    if photos < few_photos:
        said.append(f"{photos} photos are few; 12 to 20 make sigmas trustworthy.")
    weak = [name for name, reach in zip(_CORNERS, seen.reach) if reach < good_reach]
    if weak:
        said.append(
            f"Towards the {', '.join(weak)} the board covers less than {good_reach:.0%} of the "
            "way from the middle; distortion is extrapolated there."
        )
    if np.isnan(edge_sigmas_px).any():
        said.append(
            "The lens is too wide for this lens model in the picture's corners; points there "
            "are not usable."
        )
    if inflation > 2.0:
        said.append(
            f"The photos differ {inflation:.1f} times more than their corners' noise explains, "
            "and all sigmas are enlarged by that: the board is probably not flat, the focus "
            "changed, or a stabiliser shifted the pictures."
        )
    if solution.rms_px > 0.5:
        said.append(
            f"The corners are {solution.rms_px:.2f} px off; 0.1 to 0.3 px is usual. Look at the "
            "residuals: blur, a bent board or a changed focus."
        )
    tilts = tilts_deg(solution.poses)
    if tilts.max() < 15.0:
        said.append(
            f"The board was tilted by {tilts.max():.0f} degrees at most; 20 to 45 are better."
        )
    return tuple(said)


def refuse_few(detections: BoardDetections, min_photos: int) -> None:
    if len(detections.photos) >= min_photos:
        return
    said = (
        f"The {detections.board} was found in {len(detections.photos)} of "
        f"{len(detections.photos) + len(detections.set_aside)} photos; {min_photos} are the "
        "least, 12 to 20 are good. "
    )
    if detections.cause:
        raise CalibrationError(said + detections.cause)
    reasons = [f"{one.name}: {one.reason}" for one in detections.set_aside[:3]]
    raise CalibrationError(
        f"{said}Check the board's size and kind, and that it is seen whole, sharp and evenly lit."
        + "".join(f" {reason}." for reason in reasons)
    )


def refuse_mixed(photos: tuple[Photo, ...]) -> None:
    """Refuse photos of several sizes, cameras or zoom settings, with names."""
    groups: dict[str, list[str]] = {}
    for photo in photos:
        exif = photo.exif
        focal = "" if exif.focal_mm is None else f" at {exif.focal_mm:g} mm"
        film = "" if exif.focal_35mm is None else f" ({exif.focal_35mm:g} mm for 35-mm film)"
        zoom = "" if exif.digital_zoom is None else f" enlarged {exif.digital_zoom:g} times"
        size = f"{photo.width_px} x {photo.height_px}"
        key = f"{size} {label_of(exif)}{focal}{film}{zoom}".strip()
        groups.setdefault(key, []).append(photo.name)
    if len(groups) == 1:
        return
    told = "; ".join(
        f"{key}: {', '.join(names[:4])}{' ...' if len(names) > 4 else ''}"
        for key, names in groups.items()
    )
    raise CalibrationError(
        f"The photos of the board are of {len(groups)} cameras, sizes or zoom settings ({told}). "
        "A calibration holds for one of them: calibrate each apart."
    )
