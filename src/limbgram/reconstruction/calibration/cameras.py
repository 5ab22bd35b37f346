"""Calibrated cameras: lens, covariance, and where they come from.

Cameras of a photo set: given calibrations where they fit, a guess from EXIF elsewhere.

In      a PhotoSet, and the calibrations at hand.
Out     Cameras, one calibration for each camera group.
Method  a calibration fits photos of its own size, or of a smaller copy of it, by the same
        camera at the same focal length. Without any, the focal length comes from EXIF: 35-mm
        equivalent, else focal length over the model's sensor width, else a usual angle. EXIF is
        nominal (focused near, 50 mm is 51.5), and a guess has sigmas to match.
Fails   CalibrationError: calibrations were given and none fits a group.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import CalibrationError
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, PhotoSet


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


@dataclass(frozen=True, kw_only=True)
class CameraOptions:
    """How closely calibrations must fit, and how far EXIF is believed."""

    focal_tolerance: float = 0.02
    """Accepted difference of nominal focal lengths between calibration and photos."""
    usual_focal: float = 1.2
    """Focal length over the longer side where EXIF says nothing."""
    sigma_from_35mm: float = 0.05
    """Relative sigma of a focal length from its 35-mm equivalent."""
    sigma_from_sensor: float = 0.07
    """The same from focal length and sensor width."""
    sigma_from_nothing: float = 0.3
    """The same where EXIF says nothing."""
    sigma_centre: float = 0.015
    """Sigma of the principal point over the longer side."""
    sigma_distortion: float = 0.02
    """Sigma of each radial term's shift at the picture's corner, over its distance there."""


DEFAULTS = CameraOptions()
_FAR_SIGMAS = 4.0
"""Sigmas of EXIF's focal length beyond which a calibration is that of another camera: 20 to 28 %,
and where EXIF says nothing more than any lens is long."""

_SENSORS_MM: tuple[tuple[str, float], ...] = (
    (r"canon eos[ -]?(5ds?|6d|1ds|1d ?x|r|rp|r[13568])\b", 36.0),
    (r"canon eos[ -]?1d\b", 28.1),
    (r"canon eos", 22.3),
    (r"nikon.*(d[3456]|d6[01]0|d7[058]0|d8[015]0e?|df|z ?([56789]|6ii|7ii))( |$|_)", 35.9),
    (r"nikon.*(d\d{2,4}|z ?\d+)", 23.5),
    (r"sony.*ilce-[179](\b|[a-z])", 35.8),
    (r"sony.*(ilce|nex|slt|dslr)", 23.5),
    (r"(fujifilm.*x-|pentax|ricoh.*gr)", 23.5),
    (r"(olympus.*(e-|pen)|om digital|panasonic.*(dmc|dc)-g)", 17.3),
    (r"gopro.*hero", 6.17),
    (r"meizu.*m1 note", 4.65),
)
"""Longer side of the sensor by make and model, in lower case; the first that fits counts."""


def cameras_for(
    photos: PhotoSet, given: Sequence[Calibration], options: CameraOptions = DEFAULTS
) -> Cameras:
    """A calibration for each camera group, given or from EXIF."""
    if not given:
        return Cameras(tuple(from_exif(group, options) for group in photos.cameras))
    return Cameras(
        tuple(
            _fitting(group, [p.name for p in photos.photos if p.camera_idx == idx], given, options)
            for idx, group in enumerate(photos.cameras)
        )
    )


def from_exif(group: CameraGroup, options: CameraOptions = DEFAULTS) -> Calibration:
    """A guess: focal length from EXIF, everything else as in an ideal lens, all uncertain."""
    guess = focal_from_exif(group.exif, group.width_px, group.height_px, options)
    camera = Camera(
        width_px=group.width_px,
        height_px=group.height_px,
        fx=guess.focal_px,
        fy=guess.focal_px,
        cx=0.5 * (group.width_px - 1),
        cy=0.5 * (group.height_px - 1),
    )
    return Calibration(
        camera=camera,
        covariance=_wide_covariance(camera, guess.relative_sigma, options),
        source="exif",
        label=label_of(group.exif),
        focal_mm=group.exif.focal_mm,
    )


@dataclass(frozen=True)
class FocalGuess:
    """A focal length that was not measured."""

    focal_px: float
    relative_sigma: float


def focal_from_exif(
    exif: Exif, width_px: int, height_px: int, options: CameraOptions = DEFAULTS
) -> FocalGuess:
    """Focal length in pixels of this size, from the most telling tag."""
    long_side_px = max(width_px, height_px)
    if exif.focal_35mm is not None and 5 <= exif.focal_35mm <= 3000:
        diagonal_px = float(np.hypot(width_px, height_px))
        return FocalGuess(
            exif.focal_35mm / float(np.hypot(36.0, 24.0)) * diagonal_px, options.sigma_from_35mm
        )
    sensor_mm = _sensor_mm(exif)
    if exif.focal_mm is not None and sensor_mm is not None:
        return FocalGuess(exif.focal_mm / sensor_mm * long_side_px, options.sigma_from_sensor)
    return FocalGuess(options.usual_focal * long_side_px, options.sigma_from_nothing)


def contradicting_exif(
    photos: PhotoSet, cameras: Cameras, options: CameraOptions = DEFAULTS
) -> str | None:
    """Why a measured calibration cannot be that of its photos, by their EXIF; None where it can."""
    for group, calibration in zip(photos.cameras, cameras.calibrations):
        guess = focal_from_exif(group.exif, group.width_px, group.height_px, options)
        ratio = calibration.camera.fx / guess.focal_px
        far = max(ratio, 1.0 / ratio) > 1.0 + _FAR_SIGMAS * guess.relative_sigma
        if calibration.source == "board" and far:
            return foreign_camera(calibration.camera.fx, guess.focal_px, "their EXIF tells")
    return None


def foreign_camera(given_px: float, shown_px: float, shown_by: str) -> str:
    """What to say where photos show another focal length than the camera file has."""
    return (
        f"The camera file is not that of these photos: its focal length is {given_px:.0f} px, "
        f"where {shown_by} about {shown_px:.0f} px. It was made with another camera, lens, zoom or "
        "focus. Give the file of the camera and lens that took the photos, made at the same zoom, "
        "or give none."
    )


def _sensor_mm(exif: Exif) -> float | None:
    body = f"{exif.make or ''} {exif.model or ''}".lower()
    for pattern, width_mm in _SENSORS_MM:
        if re.search(pattern, body):
            return width_mm
    return None


def _wide_covariance(
    camera: Camera, relative_sigma: float, options: CameraOptions
) -> Float64[np.ndarray, "10 10"]:
    """Pixels are square to a thousandth; skew and k3 are held at zero."""
    corner = 0.5 * float(np.hypot(camera.width_px, camera.height_px)) / camera.fx
    focal = (relative_sigma * camera.fx) ** 2
    centre = (options.sigma_centre * max(camera.width_px, camera.height_px)) ** 2
    radial = options.sigma_distortion / corner ** np.array([2.0, 4.0])
    tangential = 0.1 * options.sigma_distortion / corner
    covariance = np.diag(
        [focal, focal, centre, centre, 0.0, *radial**2, tangential**2, tangential**2, 0.0]
    )
    covariance[0, 1] = covariance[1, 0] = focal
    covariance[1, 1] += (0.001 * camera.fy) ** 2
    return covariance


def _fitting(
    group: CameraGroup, names: list[str], given: Sequence[Calibration], options: CameraOptions
) -> Calibration:
    """The calibration of this group, the one of its very size first."""
    faults: list[str] = []
    for calibration in sorted(given, key=lambda one: one.camera.width_px != group.width_px):
        fault = _misfit(group, calibration, options)
        if fault is None:
            return _resized(calibration, group)
        faults.append(fault)
    raise CalibrationError(
        f"No calibration given fits {_described(names)} ({group.width_px} x {group.height_px}"
        f"{' ' + label_of(group.exif) if label_of(group.exif) else ''}): {'; '.join(faults)}."
    )


def _misfit(group: CameraGroup, calibration: Calibration, options: CameraOptions) -> str | None:
    """Why a calibration is not that of a group; None where it is."""
    camera, exif = calibration.camera, group.exif
    size, calibrated = (group.width_px, group.height_px), (camera.width_px, camera.height_px)
    if size == calibrated[::-1] and size[0] != size[1]:
        return (
            f"the calibration is for {calibrated[0]} x {calibrated[1]}, the photos are turned by "
            "a quarter. Use the photos as they come from the camera, not turned by a program, "
            "or calibrate from photos turned alike"
        )
    factor = size[0] / calibrated[0]
    if factor > 1.0 or abs(calibrated[1] * factor - size[1]) > 1.0:
        return (
            f"the calibration is for {calibrated[0]} x {calibrated[1]}, the photos are "
            f"{size[0]} x {size[1]}. Calibrate with the same camera at the size of the photos"
        )
    label = label_of(exif)
    if not (label.startswith(calibration.label) or calibration.label.startswith(label)):
        return (
            f"the calibration is of {calibration.label}, the photos are by {label}. Calibrate "
            "the camera and lens that took the photos"
        )
    if exif.focal_mm is not None and calibration.focal_mm is not None:
        ratio = exif.focal_mm / calibration.focal_mm
        if abs(ratio - 1.0) > options.focal_tolerance:
            return (
                f"the calibration is for {calibration.focal_mm:g} mm, the photos were taken at "
                f"{exif.focal_mm:g} mm. Leave the zoom as it was, or calibrate at this setting"
            )
    return None


def _resized(calibration: Calibration, group: CameraGroup) -> Calibration:
    """The calibration for a smaller copy of its pictures; itself at its own size."""
    camera = calibration.camera
    if group.width_px == camera.width_px:
        return calibration
    factor = group.width_px / camera.width_px
    units = np.array([factor] * 5 + [1.0] * 5)
    return replace(
        calibration,
        camera=replace(camera.scaled(factor), height_px=group.height_px),
        covariance=calibration.covariance * np.outer(units, units),
        rms_px=calibration.rms_px * factor,
    )


def _described(names: list[str]) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
