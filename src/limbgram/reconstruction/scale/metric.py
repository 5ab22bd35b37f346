"""The metric scene: a scene in millimetres, with the evidence for its scale."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.geometry.arrays import Vector3
from limbgram.core.notebook import brief
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.scale.stated_lengths import LengthEnds

StretchDoubt = Literal["none", "uncalibrated", "rolling shutter"]
"""A lens that no board calibrated stretches the scene, and the board with it. A rolling shutter is
solved for as if all lay equally far away: what it leaves of the board is a stretch too."""


@dataclass(frozen=True, kw_only=True)
class LengthCheck:
    """One known length against the length in the scaled scene."""

    label: str
    known_mm: float
    measured_mm: float
    sigma_mm: float
    role: Literal["control", "check"]
    """control: it helped to set the scale; check: it did not, so it tests it."""
    between: LengthEnds
    marks: tuple[int, ...]
    """Ids of the two marks that it lies between; none of another length."""

    @property
    def error(self) -> float:
        """Fraction of the known length; positive where the scene is too large."""
        return self.measured_mm / self.known_mm - 1


@dataclass(frozen=True, kw_only=True)
class Scale:
    """How the scale was found and how well it holds on lengths that did not set it."""

    unit: Literal["mm", "unitless"]
    source: Literal["board", "distances", "none"]
    relative_sigma: float
    """One standard deviation of the scale factor, as a fraction; NaN without scale.

    It holds the measurement of corners and picks, the errors of single photos, and half of
    `board_stretch`; not what all photos share (the lens), nor an error that all of a board or a
    typed length has, which only another length can tell.
    """
    board_stretch: float = 0.0
    """How much longer the board is along its x than along its y, as a fraction, where that is
    beyond noise; 0 where it is not, and without a board."""
    stretch_doubt: StretchDoubt = "none"
    """What may have stretched the scene; and the board, beside its print."""
    by_cameras: Float64[np.ndarray, " u"] | None = None
    """How much larger, as a fraction, the scene would be for one unit of each number of
    `Scene.camera_covariance`, because the known lengths are measured by the same cameras; None
    where there is no scale or no covariance."""
    lengths: tuple[LengthCheck, ...] = ()
    set_aside: tuple[SetAside, ...] = ()
    """Boards, markers or distances that were not used, and why."""

    @property
    def checked(self) -> bool:
        """Whether a length that did not set the scale confirms it."""
        return any(one.role == "check" for one in self.lengths)


@dataclass(frozen=True, kw_only=True)
class MetricScene:
    """A scene whose unit is one millimetre (or says that it has none).

    World frame: right-handed, +Z away from the plane the object stands on where that plane is
    known (`floor_z_mm`), otherwise along the cameras' common up direction.
    """

    scene: Scene
    scale: Scale
    floor_z_mm: float | None = None
    """Height of the board's plane: nothing below it belongs to the limb. None: no plane known."""
    board_corners_mm: tuple[Vector3, ...] = ()
    """Outline of the scale board in the world: for pictures, and to keep it out of the region."""

    __repr__ = brief
