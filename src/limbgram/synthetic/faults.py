"""Faults of real cameras: what a photo has that an ideal camera would not give.

In      a Faults, the ideal camera, a seed, which photo.
Out     that photo's own camera.
Limits  each fault is drawn from the seed and the photo's number alone, so that a capture with two
        of them has each as it is alone. A stabilised lens is taken to shift its whole image, with
        the middle of its distortion; that it also tilts a little is left out.
"""

from dataclasses import dataclass, fields, replace
from enum import Enum

import numpy as np

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.lens import Camera


class Session(Enum):
    """Which photos: those of the limb or those of the calibration board."""

    RING = 30
    CALIBRATION = 31


@dataclass(frozen=True, kw_only=True)
class Faults:
    """How strong each fault is; 0 is an ideal camera."""

    stabiliser_px: float = 0.0
    """Optical stabilisation: how far the principal point wanders from photo to photo, one standard
    deviation of x and of y each, in pixels of the photo. Usual: 0.0025 of the photo's width (10 px
    of 4000), a tenth to a fifth of the travel of a phone's lens, which turns the picture by up to
    a degree: hands that hold still for a photo tremble by a tenth of that."""
    breathing: float = 0.0
    """Refocusing: how far the principal distance changes from photo to photo, one standard
    deviation, as a share of it. A thin lens refocused from D to D' changes it by
    f (1/D' - 1/D): 0.0005 for a phone (f 4.3 mm, 0.5 m give or take 6 %), 0.002 for a 50 mm lens
    at 1.5 m."""

    def __post_init__(self) -> None:
        if any(getattr(self, one.name) < 0 for one in fields(self)):
            raise OptionsError(
                "This camera cannot be made: the strength of a fault is 0 or more. "
                "Change that option."
            )


def camera_in_photo(
    ideal: Camera, faults: Faults, seed: int, session: Session, photo_idx: int
) -> Camera:
    """The camera as it was when one photo was taken."""
    camera = ideal
    if faults.stabiliser_px > 0:
        dx, dy = _rng(seed, session, photo_idx, 1).normal(0.0, faults.stabiliser_px, 2)
        camera = replace(camera, cx=camera.cx + dx, cy=camera.cy + dy)
    if faults.breathing > 0:
        longer = 1.0 + _rng(seed, session, photo_idx, 2).normal(0.0, faults.breathing)
        camera = replace(camera, fx=camera.fx * longer, fy=camera.fy * longer)
    return camera


def _rng(seed: int, session: Session, photo_idx: int, fault: int) -> np.random.Generator:
    return np.random.default_rng((seed, session.value, photo_idx, fault))
