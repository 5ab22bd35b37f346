"""Self-calibration: what it costs that the lens was found from the photos of the limb alone.

In      the cameras of an assessment and the error that is expected.
Out     a SelfCalibration, in mm and as a finding; None where every camera had a camera file.
Method  The adjustment frees the lens of a camera that has no file, and its covariance goes into
        the sigma of every vertex: the part that cameras and lens have in it is the most that a
        calibration could take away. It knows nothing of a lens that no polynomial describes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from limbgram.core.interval import COVER
from limbgram.findings import Finding, note
from limbgram.reconstruction.measuring.uncertainty import CAMERAS
from limbgram.report.accuracy.figures import ExpectedError, LensFigures

MEASURED_COST_MM = 0.002
"""Most that the RMS error of rendered captures grew without their camera file
(benchmarks/results/selfcalibration.md)."""
_FOCAL = "fx"
_FINE_MM, _FINE_PERCENT = 0.0005, 0.005
"""What is less is told by its first digit, as it would round to nothing."""


@dataclass(frozen=True, kw_only=True)
class SelfCalibration:
    """Cameras without a camera file, and what that costs."""

    cameras: tuple[str, ...]
    focal_sigma: float
    """One standard deviation of the focal length as a part of it, of the least sure camera."""
    sigma_mm: float
    """One standard deviation on the surface, root mean square, of cameras and lens together; NaN
    where the surface carries no sigmas or nothing is known in mm."""
    finding: Finding


def self_calibration(
    cameras: Sequence[LensFigures], expected: ExpectedError, unit: str
) -> SelfCalibration | None:
    """What the missing camera files cost."""
    found = [one for one in cameras if one.source != "board"]
    if not found:
        return None
    focal = max((_focal_sigma(one) for one in found), default=math.nan)
    part_mm = next((one.sigma_mm for one in expected.budget if one.part == CAMERAS), math.nan)
    sigma_mm = part_mm if unit == "mm" else math.nan
    return SelfCalibration(
        cameras=tuple(one.name for one in found),
        focal_sigma=focal,
        sigma_mm=sigma_mm,
        finding=_finding(found, focal, sigma_mm),
    )


def _focal_sigma(lens: LensFigures) -> float:
    one = next(one for one in lens.parameters if one.name == _FOCAL)
    return one.sigma / one.value


def _finding(found: Sequence[LensFigures], focal: float, sigma_mm: float) -> Finding:
    exif = tuple(one.name for one in found if one.source == "exif")
    guess = tuple(one.name for one in found if one.source == "guess")
    not_used = any(one.contradicted is not None for one in found)
    focal_percent = 100 * COVER * focal if math.isfinite(focal) else None
    fine_focal = focal_percent is not None and focal_percent < _FINE_PERCENT
    if not math.isfinite(sigma_mm):
        return note(
            "verdict.no_camera_file.cost_unknown",
            not_used=not_used,
            exif=exif or None,
            guess=guess or None,
            focal_percent=focal_percent,
            fine_focal=fine_focal,
        )
    return note(
        "verdict.no_camera_file",
        not_used=not_used,
        exif=exif or None,
        guess=guess or None,
        focal_percent=focal_percent,
        fine_focal=fine_focal,
        cost_mm=COVER * sigma_mm,
        fine_cost=COVER * sigma_mm < _FINE_MM,
        rendered_mm=MEASURED_COST_MM,
    )
