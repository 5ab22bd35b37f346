"""Calibrated cameras: lens, covariance, and where they come from.

Cameras of a photo set: given calibrations where they fit, a guess from EXIF elsewhere.

In      a PhotoSet, and the calibrations at hand.
Out     Cameras, one calibration for each camera group.
Method  a calibration fits photos of its own size, or of a smaller copy of it, by the same camera,
        lens and zoom. The most particular one counts: that of this very body before that of its
        model, that of this very size before a reduced one. Photos that a program turned by a
        quarter take it turned: to which side nobody can tell, so the principal point stands in
        the middle, with a sigma that holds either place, and the photos settle it.
        Photos that were cut out of others of the same camera have that one's lens, its middle and
        its focal length in pixels left open.
        Without any, the focal length comes from EXIF: 35-mm equivalent, else focal length over
        the model's sensor width. EXIF is nominal (focused near, 50 mm is 51.5), and has sigmas to
        match. Where it tells nothing, a usual angle is guessed, with a wide sigma.
Fails   CalibrationError: calibrations were given and none fits a group, or two do equally.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import CalibrationError
from limbgram.core.geometry.lens import (
    DISTORTION,
    FROM_CORNER_PX,
    IN_PIXELS,
    LENS_SIZE,
    PARAMETERS,
    RADIAL,
    Camera,
)
from limbgram.findings import Finding, fault
from limbgram.reconstruction.photos.lenses import cut_from
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, PhotoSet, first_of

LensSource = Literal["board", "exif", "guess"]
"""Where a lens is known from: a board calibrated it, EXIF told its focal length, or nothing did."""


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """One camera's lens with its uncertainty.

    `covariance` follows lens.PARAMETERS (px for those IN_PIXELS, none for the rest);
    rows and columns of parameters that were held fixed are zero.
    """

    camera: Camera
    covariance: Float64[np.ndarray, "lens lens"]
    source: LensSource
    label: str = ""
    """Make, model and lens, as in EXIF."""
    focal_mm: float | None = None
    """Nominal focal length of the calibration photos, to tell another zoom setting."""
    focal_35mm: float | None = None
    """The same as told for film of 36 x 24 mm, which counts what was cut off and enlarged."""
    digital_zoom: float | None = None
    body: str | None = None
    """Tells the body from others of its model (`Exif.body`)."""
    rms_px: float = float("nan")
    edge_px: float | None = None
    """Width of the sharpest edges in a typical one of the calibration photos."""
    instead_of: "Calibration | None" = None
    """The camera file that was given and that the photos contradict."""

    @property
    def sigmas(self) -> Float64[np.ndarray, " lens"]:
        return np.sqrt(np.diag(self.covariance))


SQUARE_WITHIN = 0.001
"""Largest deviation from square of a sensor's pixels. Sound calibrations find
0.00000 to 0.00007; one from photos with a rolling shutter 0.0037."""
_ROUNDED_PX = 0.5
"""A reduced picture has whole pixels: by so much its height and width are rounded."""
_ANAMORPHIC = 0.02
"""From here on they are meant to be oblong: those of film and video are, by 7 % and more."""
_SQUARE_SIGMA = 1e-4
"""Of a sensor's ratio of width and height."""


def square_pixel_tolerance(width_px: int, height_px: int) -> float:
    """Largest deviation from square pixels, as a fraction, that rounding of the size explains."""
    return max(SQUARE_WITHIN, _ROUNDED_PX / min(width_px, height_px))


def with_square_pixels(given: Calibration) -> Calibration:
    """The calibration with square pixels, where they are nearly so.

    Sensors are made with square pixels. A calibration that finds others found something else: rows
    that were read while the camera moved, or a board that is stretched. It is conditioned on their
    being square: the other parameters follow by their covariance.
    """
    camera, across = given.camera, np.zeros(len(given.covariance))
    across[0], across[1] = 1.0, -1.0
    off = (camera.fx - camera.fy) / camera.fy
    variance_px2 = float(across @ given.covariance @ across)
    if not (
        square_pixel_tolerance(camera.width_px, camera.height_px) < abs(off) < _ANAMORPHIC
        and variance_px2 > 0
    ):
        return given
    gain = given.covariance @ across / (variance_px2 + (_SQUARE_SIGMA * camera.fx) ** 2)
    return replace(
        given,
        camera=camera.with_parameters(camera.packed - gain * (camera.fx - camera.fy)),
        covariance=given.covariance - np.outer(gain, across @ given.covariance),
    )


@dataclass(frozen=True)
class Cameras:
    """One calibration for each camera group of a PhotoSet, in its order."""

    calibrations: tuple[Calibration, ...]

    def reduced(self, groups: Sequence[CameraGroup]) -> "Cameras":
        """The same for smaller copies of the photos."""
        pairs = zip(self.calibrations, groups, strict=True)
        return Cameras(tuple(_resized(one, group) for one, group in pairs))


def label_of(exif: Exif) -> str:
    """Make, model and lens, without the make repeated; empty where EXIF says nothing."""
    make, model = exif.make or "", exif.model or ""
    body = model if make and model.lower().startswith(make.lower()) else f"{make} {model}"
    return " ".join(f"{body} {exif.lens or ''}".split())


_FOCAL_TOLERANCE = 0.02
"""Accepted difference of nominal focal lengths between calibration and photos."""
_TOLERANCE_35MM = 0.6
"""The same of what is written for film, in mm: whole ones are."""
_USUAL_FOCAL = 1.2
"""Focal length over the longer side where EXIF says nothing."""
_SIGMA_FROM_35MM = 0.05
"""Relative sigma of a focal length from its 35-mm equivalent."""
_SIGMA_FROM_SENSOR = 0.07
"""The same from focal length and sensor width."""
_SIGMA_FROM_NOTHING = 0.3
"""The same where EXIF says nothing."""
_SIGMA_CENTRE = 0.015
"""Sigma of the principal point over the longer side."""
_SIGMA_DISTORTION = 0.02
"""Sigma of each radial term's shift at the picture's corner, over its distance there."""


_FAR_SIGMAS = 4.0
"""Sigmas of EXIF's focal length beyond which a calibration is that of another camera: 20 to 28 %,
and where EXIF says nothing more than any lens is long."""

_CUT_ASIDE = 0.15
"""Of its sides, how far the lens's middle lies from that of a picture which was cut (sigma): of one
that is half as wide as the whole and was cut anywhere it is 0.14 to 0.29."""
_SENSORS_MM: tuple[tuple[str, float], ...] = (
    (r"canon eos[ -]?(5ds?|6d|1ds|1d ?x|ra?|rp|r[13568](m\d)?)\b", 36.0),
    (r"canon eos[ -]?1d\b", 28.1),
    (r"canon eos", 22.3),
    (r"nikon.*(d[3456]|d6[01]0|d7[058]0|d8[015]0e?|df|z ?([56789]|6ii|7ii))( |$|_)", 35.9),
    (r"nikon.*(d\d{2,4}|z ?\d+)", 23.5),
    (r"sony.*ilce-[179](\b|[a-z])", 35.8),
    (r"sony.*(ilce|nex|slt|dslr)", 23.5),
    (r"pentax k-1\b", 35.9),
    (r"(fujifilm.*x-|pentax|ricoh.*gr)", 23.5),
    (r"(olympus.*(e-|pen)|om digital|panasonic.*(dmc|dc)-g)", 17.3),
    (r"gopro.*hero", 6.17),
    (r"meizu.*m1 note", 4.65),
)
"""Longer side of the sensor by make and model, in lower case; the first that fits counts."""


def cameras_for(photos: PhotoSet, given: Sequence[Calibration]) -> Cameras:
    """A calibration for each camera group, given or from EXIF."""
    cut = cut_from(photos)

    def whole(idx: int) -> Calibration:
        group = photos.cameras[idx]
        if not given:
            return from_exif(group)
        names = [photo.name for photo in photos.photos if photo.camera_idx == idx]
        return _best_calibration(group, names, given)

    def lens(idx: int) -> Calibration:
        group = photos.cameras[idx]
        if idx not in cut or any(_misfit(group, one) is None for one in given):
            return whole(idx)
        return _cut_out(whole(cut[idx]), group)

    return Cameras(tuple(map(lens, range(len(photos.cameras)))))


def from_exif(group: CameraGroup) -> Calibration:
    """Focal length from EXIF or guessed, everything else as in an ideal lens, all uncertain."""
    guess = focal_from_exif(group.exif, group.width_px, group.height_px)
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
        covariance=wide_covariance(camera, guess.relative_sigma),
        source=guess.source,
        label=label_of(group.exif),
        focal_mm=group.exif.focal_mm,
        focal_35mm=group.exif.focal_35mm,
        digital_zoom=group.exif.digital_zoom,
        body=group.exif.body,
    )


def of_one_file(one: Calibration, other: Calibration) -> bool:
    """Whether two groups have their lens from one camera file, perhaps at two sizes.

    What has no unit stays as it is where pictures are reduced or turned.
    """
    radial = one.camera.packed[RADIAL], other.camera.packed[RADIAL]
    return one.source == other.source == "board" and np.array_equal(*radial)


@dataclass(frozen=True)
class FocalGuess:
    """A focal length that was not measured."""

    focal_px: float
    relative_sigma: float
    source: Literal["exif", "guess"]


def without_files(
    cameras: Cameras, groups: tuple[CameraGroup, ...], wrong: tuple[int, ...]
) -> Cameras:
    """These cameras as if no file of theirs had been given."""
    return Cameras(
        tuple(
            replace(from_exif(group), instead_of=one) if idx in wrong else one
            for idx, (one, group) in enumerate(zip(cameras.calibrations, groups, strict=True))
        )
    )


def focal_from_exif(exif: Exif, width_px: int, height_px: int) -> FocalGuess:
    """Focal length in pixels of this size, from the most telling tag."""
    long_side_px = max(width_px, height_px)
    if exif.focal_35mm is not None:
        diagonal_px = float(np.hypot(width_px, height_px))
        # EXIF 3.0 leaves open whether this counts a digital zoom; most phones do so.
        doubt = 0.0 if exif.digital_zoom is None else abs(exif.digital_zoom - 1.0)
        return FocalGuess(
            exif.focal_35mm / float(np.hypot(36.0, 24.0)) * diagonal_px,
            max(_SIGMA_FROM_35MM, min(doubt, _SIGMA_FROM_NOTHING)),
            "exif",
        )
    zoom = exif.digital_zoom or 1.0
    sensor_mm = _sensor_mm(exif)
    if exif.focal_mm is not None and sensor_mm is not None:
        focal_px = exif.focal_mm / sensor_mm * long_side_px * zoom
        return FocalGuess(focal_px, _SIGMA_FROM_SENSOR, "exif")
    focal_px = _USUAL_FOCAL * long_side_px * zoom
    return FocalGuess(focal_px, _SIGMA_FROM_NOTHING, "guess")


def contradicting_exif(photos: PhotoSet, cameras: Cameras) -> Finding | None:
    """The finding that EXIF contradicts a measured calibration; None where it does not.

    Where EXIF tells nothing, one that is more than any lens is long cannot.
    """
    for group, calibration in zip(photos.cameras, cameras.calibrations):
        guess = focal_from_exif(group.exif, group.width_px, group.height_px)
        ratio = calibration.camera.fx / guess.focal_px
        far = max(ratio, 1.0 / ratio) > 1.0 + _FAR_SIGMAS * guess.relative_sigma
        if calibration.source == "board" and far:
            shown_by = "exif" if guess.source == "exif" else "usual"
            return foreign_camera(calibration.camera.fx, guess.focal_px, shown_by)
    return None


def foreign_camera(
    given_px: float, shown_px: float, shown_by: Literal["exif", "usual", "placed", "board"]
) -> Finding:
    """The finding that photos show another focal length than the camera file."""
    return fault(
        "lens.foreign", given_px=float(given_px), shown_px=float(shown_px), shown_by=shown_by
    )


def _sensor_mm(exif: Exif) -> float | None:
    body = f"{exif.make or ''} {exif.model or ''}".lower()
    for pattern, width_mm in _SENSORS_MM:
        if re.search(pattern, body):
            return width_mm
    return None


def wide_covariance(camera: Camera, relative_sigma: float) -> Float64[np.ndarray, "lens lens"]:
    """Of a lens that no board calibrated, its focal length known with this relative sigma.

    Pixels are square to a thousandth; skew and what `DISTORTION` says is held at zero.
    """
    corner = 0.5 * float(np.hypot(camera.width_px, camera.height_px)) / camera.fx
    focal = (relative_sigma * camera.fx) ** 2
    centre = (_SIGMA_CENTRE * max(camera.width_px, camera.height_px)) ** 2
    bends = np.array([one.wide * _SIGMA_DISTORTION for one in DISTORTION.values()])
    bends /= corner ** np.array([float(one.power) for one in DISTORTION.values()])
    covariance = np.diag([focal, focal, centre, centre, 0.0, *bends**2])
    covariance[0, 1] = covariance[1, 0] = focal
    covariance[1, 1] += (0.001 * camera.fy) ** 2
    return covariance


def _best_calibration(
    group: CameraGroup, names: list[str], given: Sequence[Calibration]
) -> Calibration:
    """The calibration given for this group, the most specific one."""
    misfits = [_misfit(group, one) for one in given]
    fitting = [one for one, misfit in zip(given, misfits) if misfit is None]
    if fitting:
        best = min(_differences(group, one) for one in fitting)
        chosen = [one for one in fitting if _differences(group, one) == best]
        if any(one.camera != chosen[0].camera for one in chosen):
            raise CalibrationError("lens.ambiguous", count=len(chosen), **first_of(names, 3))
        return _as_taken(chosen[0], group)
    raise CalibrationError(
        "lens.none_fits",
        **first_of(names, 3),
        width_px=group.width_px,
        height_px=group.height_px,
        label=label_of(group.exif) or None,
        misfits=tuple(misfit for misfit in misfits if misfit is not None),
    )


def _misfit(group: CameraGroup, calibration: Calibration) -> Finding | None:
    """Why a calibration is not that of a group; None where it is."""
    camera, exif = calibration.camera, group.exif
    size, calibrated = (group.width_px, group.height_px), (camera.width_px, camera.height_px)
    if _is_turned(group, camera):
        calibrated = calibrated[::-1]
    factor = size[0] / calibrated[0]
    if factor > 1.0 or abs(calibrated[1] * factor - size[1]) > 1.0:
        return fault(
            "lens.misfit.size",
            width_px=camera.width_px,
            height_px=camera.height_px,
            photo_width_px=size[0],
            photo_height_px=size[1],
        )
    label = label_of(exif)
    if not (_begins_with(label, calibration.label) or _begins_with(calibration.label, label)):
        return fault("lens.misfit.label", calibrated=calibration.label, label=label)
    if exif.focal_mm is not None and calibration.focal_mm is not None:
        ratio = exif.focal_mm / calibration.focal_mm
        if abs(ratio - 1.0) > _FOCAL_TOLERANCE:
            return fault(
                "lens.misfit.focal", calibrated_mm=calibration.focal_mm, taken_mm=exif.focal_mm
            )
    return _body_misfit(exif, calibration) or _zoom_misfit(exif, calibration)


def _begins_with(label: str, words: str) -> bool:
    """Whether a label begins with these words: an X10 is no X1 whose lens is named too."""
    return not words or f"{label} ".startswith(f"{words} ")


def _body_misfit(exif: Exif, calibration: Calibration) -> Finding | None:
    if exif.body is None or calibration.body is None or exif.body == calibration.body:
        return None
    return fault("lens.misfit.body", calibrated=calibration.label)


def _zoom_misfit(exif: Exif, calibration: Calibration) -> Finding | None:
    """A digital zoom shows in the zoom ratio, in the focal length for film, or in both."""
    now, then = exif.digital_zoom or 1.0, calibration.digital_zoom or 1.0
    if abs(now / then - 1.0) > _FOCAL_TOLERANCE:
        return fault("lens.misfit.zoom", calibrated=then, taken=now)
    if exif.focal_35mm is None or calibration.focal_35mm is None:
        return None
    off_mm = abs(exif.focal_35mm - calibration.focal_35mm)
    if off_mm <= _TOLERANCE_35MM + _FOCAL_TOLERANCE * calibration.focal_35mm:
        return None
    return fault("lens.misfit.film", calibrated_mm=calibration.focal_35mm, taken_mm=exif.focal_35mm)


def _differences(group: CameraGroup, calibration: Calibration) -> tuple[bool, ...]:
    """Differences of a calibration that fits a group, the most important first."""
    return (
        group.exif.body is not None and calibration.body is None,
        label_of(group.exif) != calibration.label,
        (group.width_px, group.height_px)
        != (calibration.camera.width_px, calibration.camera.height_px),
        _is_turned(group, calibration.camera),
    )


def _cut_out(whole: Calibration, group: CameraGroup) -> Calibration:
    """The lens of pictures that were cut out of those of a calibration, and perhaps reduced.

    Where they were cut nobody knows: the principal point is as likely anywhere that leaves room. An
    upright part of a broad picture may have been cut from it as it is, or turned first.
    """
    unturned_px = room_px = _room_px(whole.camera, group)
    if _is_turned(group, whole.camera):
        whole = _turned(whole)
        room_px = _room_px(whole.camera, group)
    camera = whole.camera
    packed = camera.packed.copy()
    packed[[2, 3]] -= 0.5 * room_px
    cut = replace(camera, width_px=group.width_px, height_px=group.height_px)
    if (unturned_px >= 0.0).all():
        room_px = np.maximum(room_px, unturned_px)
    return _loosened(replace(whole, camera=cut.with_parameters(packed)), room_px / np.sqrt(12.0))


def _room_px(camera: Camera, part: CameraGroup) -> Float64[np.ndarray, "2"]:
    """How far a part of a picture may lie aside and down in it; negative where it is larger."""
    return np.array([camera.width_px - part.width_px, camera.height_px - part.height_px], float)


def cut_lens(copy: Calibration) -> Calibration:
    """The lens of pictures of this size if they were cut and not, as this one has it, reduced."""
    size_px = np.array([copy.camera.width_px, copy.camera.height_px], np.float64)
    return _loosened(copy, _CUT_ASIDE * size_px)


def _loosened(lens: Calibration, middle_px: Float64[np.ndarray, "2"]) -> Calibration:
    """The lens with its principal point uncertain by so much, and its focal length unknown."""
    covariance = lens.covariance.copy()
    covariance[[2, 3], [2, 3]] += middle_px**2
    covariance[:2, :2] += (_SIGMA_FROM_NOTHING * lens.camera.fx) ** 2
    return replace(lens, covariance=covariance, source="guess")


def _is_turned(group: CameraGroup, camera: Camera) -> bool:
    """Whether one is upright where the other is broad."""
    return (group.width_px - group.height_px) * (camera.width_px - camera.height_px) < 0


def _as_taken(calibration: Calibration, group: CameraGroup) -> Calibration:
    """The calibration for turned or smaller copies of its pictures; else itself."""
    if _is_turned(group, calibration.camera):
        calibration = _turned(calibration)
    return _resized(calibration, group)


_PARTNERS = {"fx": "fy", "fy": "fx", "cx": "cy", "cy": "cx", "p1": "p2", "p2": "p1"}
_TURNED = [PARAMETERS.index(_PARTNERS.get(name, name)) for name in PARAMETERS]
"""Which parameter becomes which when the picture is turned by a quarter."""
_CLOCKWISE = np.where(np.isin(PARAMETERS, ["cx", "skew", "p2"]), -1.0, 1.0)
_TURNS_OVER = np.isin(PARAMETERS, ["cx", "cy", "p1", "p2"])
"""Their signs, and those that have the other one anticlockwise."""


def _turned(calibration: Calibration) -> Calibration:
    """The calibration of pictures turned by a quarter, to which side is not known.

    Turned to one side or the other, principal point and tangential distortion lie this much
    beside the middle or as much on its other side; both places are one sigma away.
    """
    camera = calibration.camera
    right_px = camera.cx - 0.5 * (camera.width_px - 1)
    down_px = camera.cy - 0.5 * (camera.height_px - 1)
    aside = np.zeros(LENS_SIZE)
    aside[_TURNS_OVER] = -down_px, right_px, camera.p2, -camera.p1
    covariance = np.outer(aside, aside)
    for side in (1.0, -1.0):
        signs = np.where(_TURNS_OVER, side * _CLOCKWISE, _CLOCKWISE)
        covariance += (
            0.5 * calibration.covariance[np.ix_(_TURNED, _TURNED)] * np.outer(signs, signs)
        )
    return replace(
        calibration,
        camera=replace(
            camera,
            width_px=camera.height_px,
            height_px=camera.width_px,
            fx=camera.fy,
            fy=camera.fx,
            cx=0.5 * (camera.height_px - 1),
            cy=0.5 * (camera.width_px - 1),
            skew=-camera.skew,
            p1=0.0,
            p2=0.0,
        ),
        covariance=covariance,
    )


_DOWN = ["fy", "cy"]
"""Lens parameters that are counted in rows; the others with a unit are in columns."""


def _resized(calibration: Calibration, group: CameraGroup) -> Calibration:
    """The calibration for a smaller copy of its pictures; itself at its own size.

    A copy shows the whole picture in whole pixels, so that rows and columns may shrink by a
    thousandth more or less.
    """
    camera = calibration.camera
    if group.width_px == camera.width_px:
        return calibration
    across, down = group.width_px / camera.width_px, group.height_px / camera.height_px
    by_axis = np.where(np.isin(PARAMETERS, _DOWN), down, across)
    units = np.where(np.isin(PARAMETERS, IN_PIXELS), by_axis, 1.0)
    corner = np.where(np.isin(PARAMETERS, ["cx", "cy"]), FROM_CORNER_PX, 0.0)
    size = replace(camera, width_px=group.width_px, height_px=group.height_px)
    return replace(
        calibration,
        camera=size.with_parameters((camera.packed + corner) * units - corner),
        covariance=calibration.covariance * np.outer(units, units),
        rms_px=calibration.rms_px * across,
    )
