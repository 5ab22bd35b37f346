"""Self-calibration: what it costs that the lens was found from the photos of the limb alone.

In      the cameras of an assessment and the error that is expected.
Out     a SelfCalibration, in mm and in words; None where every camera had a camera file.
Method  The adjustment frees the lens of a camera that has no file, and its covariance goes into
        the sigma of every vertex: the part that cameras and lens have in it is the most that a
        calibration could take away. It knows nothing of a lens that no polynomial describes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from limbgram.core.interval import HOLDS, Interval, plus_minus
from limbgram.reconstruction.measuring.uncertainty import CAMERAS
from limbgram.report.accuracy.figures import LENS_SOURCES, ExpectedError, LensFigures

MEASURED_COST_MM = 0.002
"""Most that the RMS error of rendered captures grew without their camera file
(benchmarks/results/selfcalibration.md)."""
_FOCAL = "fx"


@dataclass(frozen=True, kw_only=True)
class SelfCalibration:
    """Cameras without a camera file, and what that costs."""

    cameras: tuple[str, ...]
    focal_sigma: float
    """One standard deviation of the focal length as a part of it, of the least sure camera."""
    sigma_mm: float
    """One standard deviation on the surface, root mean square, of cameras and lens together; NaN
    where the surface carries no sigmas or nothing is known in mm."""
    sentence: str


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
        sentence=_sentence(found, focal, sigma_mm),
    )


def _focal_sigma(lens: LensFigures) -> float:
    one = next(one for one in lens.parameters if one.name == _FOCAL)
    return one.sigma / one.value


def _sentence(found: Sequence[LensFigures], focal: float, sigma_mm: float) -> str:
    lenses = " and ".join(
        f"the lens of {names} was {words}"
        for source, words in LENS_SOURCES.items()
        if (names := ", ".join(one.name for one in found if one.source == source))
    )
    told = f"No camera file was given: {lenses}, and found from these photos alone"
    if math.isfinite(focal):
        told += f", its focal length {plus_minus(Interval.of_sigma(100 * focal), 2)} %"
    if not math.isfinite(sigma_mm):
        return f"{told}. What that costs on the surface is not known."
    cost = plus_minus(Interval.of_sigma(sigma_mm), 3)
    return (
        f"{told}. With the places of the cameras that costs {cost} mm on the surface ({HOLDS}). On "
        f"renders the same photos came out {MEASURED_COST_MM:.3f} mm worse at most (RMS); a lens "
        "of another kind than theirs may cost more, which only a calibration or a known length "
        "shows."
    )
