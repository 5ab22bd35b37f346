"""Verdicts: whether photos of a board determine the camera, and what to photograph if not.

A doubt is told to the user; a refusal is raised.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.calibration.adjustment import Solution
from limbgram.errors import CalibrationError
from limbgram.geometry.arrays import Points2
from limbgram.geometry.rigid import Rigid

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


def refuse_undetermined(solution: Solution, inflation: float, max_focal_sigma: float) -> None:
    """Raise CalibrationError where the photos leave the focal length open."""
    sigma = inflation * float(np.sqrt(np.diag(solution.covariance)[:2].max()))
    share = sigma / float(solution.shared[:2].min())
    if share <= max_focal_sigma:
        return
    tilts = tilts_deg(solution.poses)
    raise CalibrationError(
        f"The focal length stays uncertain by {share:.1%} (at most {max_focal_sigma:.1%} is "
        f"accepted): the board was tilted by {tilts.min():.0f} to {tilts.max():.0f} degrees "
        f"against the sensor in {len(tilts)} photos. Take 12 or more photos with the board "
        "tilted by 20 to 45 degrees to all sides, and some with the camera turned upright."
    )


def refuse_uncovered(seen: Coverage, min_reach: float) -> None:
    """Raise CalibrationError where a corner of the picture was never near the board."""
    bare = [name for name, reach in zip(_CORNERS, seen.reach) if reach < min_reach]
    if bare:
        raise CalibrationError(
            f"The board never came near the {', '.join(bare)} of the picture, so the lens's "
            "distortion is unknown there. Add photos in which the board fills the picture, and "
            "some with it in each corner."
        )


_CORNERS = ("top left", "top right", "bottom left", "bottom right")


def doubts(
    seen: Coverage, solution: Solution, inflation: float, *, few_photos: int, good_reach: float
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
    if inflation > 2.0:
        said.append(
            f"The photos differ {inflation:.1f} times more than their corners' noise explains, "
            "and all sigmas are enlarged by that: the board is probably not flat, or the focus "
            "changed."
        )
    tilts = tilts_deg(solution.poses)
    if tilts.max() < 15.0:
        said.append(
            f"The board was tilted by {tilts.max():.0f} degrees at most; 20 to 45 are better."
        )
    return tuple(said)
