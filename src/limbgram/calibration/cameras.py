"""Calibrated cameras: lens, covariance, and where they come from."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.geometry.camera import Camera
from limbgram.photos.photo import Exif


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """One camera's lens with its uncertainty.

    `covariance` follows geometry.camera.PARAMETERS (px for the first five, none for the rest);
    rows and columns of parameters that were held fixed are zero.
    """

    camera: Camera
    covariance: Float64[np.ndarray, "10 10"]
    source: Literal["board", "exif"]
    label: str = ""
    """Make, model and lens, as in EXIF."""
    focal_mm: float | None = None
    """Nominal focal length of the calibration photos, to tell another zoom setting."""
    rms_px: float = float("nan")

    @property
    def sigmas(self) -> Float64[np.ndarray, "10"]:
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True)
class Cameras:
    """One calibration for each camera group of a PhotoSet, in its order."""

    calibrations: tuple[Calibration, ...]


def label_of(exif: Exif) -> str:
    """Make, model and lens, without the make repeated; empty where EXIF says nothing."""
    make, model = exif.make or "", exif.model or ""
    body = model if make and model.lower().startswith(make.lower()) else f"{make} {model}"
    return " ".join(f"{body} {exif.lens or ''}".split())
