"""Usual faults of camera, board, light and patient, at a multiple of their usual strength.

In      CaptureOptions, which faults, and the multiple.
Out     the same capture with each of them at that strength; `Faults`, `PrintedBoard` and `Lighting`
        say where the usual ones come from.
"""

from collections.abc import Iterable
from dataclasses import replace
from enum import Enum

from limbgram.synthetic.faults import Faults
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.photographer import Lens
from limbgram.synthetic.rendering.shading import Shadow

PHONE = Lens(
    make="Phone",
    model="Main camera",
    name="4.25 mm f/1.8",
    focal_mm=4.25,
    sensor_width_mm=5.885,
    aperture=1.8,
    k1=0.06,
    k2=-0.12,
    p1=0.0003,
    p2=-0.0002,
    principal_x=0.003,
    principal_y=-0.002,
)
"""A phone's main camera: as wide as 26 mm on film."""


class Fault(Enum):
    """Faults that real captures have."""

    STABILISER = "stabiliser"
    """The principal point wanders from photo to photo."""
    BREATHING = "breathing"
    """Focused anew for each photo: the principal distance changes."""
    ROLLING = "rolling"
    """The rows of a photo are read one after the other while the hand moves."""
    BLUR = "blur"
    """Depth of field: what is not in focus is blurred."""
    PROCESSING = "processing"
    """Noise reduction and sharpening of a phone."""
    JPEG = "jpeg"
    """A phone's JPEG, stored a second time by a browser."""
    LIGHT = "light"
    """Uneven light of two colours, a shadow that moves, automatic exposure and white balance."""
    WET = "wet"
    """Highlights on wet paint or on film."""
    BENT = "bent"
    """The scale board is bent by 0.5 mm over its length."""
    STRETCHED = "stretched"
    """The scale board is printed 0.2 % too long one way."""
    CREEP = "creep"
    """The cloth creeps by 0.3 mm while photos are taken."""
    BACKGROUND = "background"
    """Things round the limb are moved between photos."""


def with_faults(
    options: CaptureOptions, faults: Iterable[Fault], strength: float = 1.0
) -> CaptureOptions:
    """The capture with these faults at `strength` times their usual strength."""
    for fault in faults:
        options = _with_fault(options, fault, strength)
    return options


def _with_fault(options: CaptureOptions, fault: Fault, strength: float) -> CaptureOptions:
    lens, faults = options.lens, options.faults
    match fault:
        case Fault.STABILISER:
            return _faulty(
                options, replace(faults, stabiliser_px=strength * 0.0025 * options.width_px)
            )
        case Fault.BREATHING:
            focus_per_mm = strength * 0.06 / options.distance_mm
            return _faulty(options, replace(faults, breathing=lens.focal_mm * focus_per_mm))
        case Fault.ROLLING:
            return _faulty(options, replace(faults, readout_s=strength * 0.02))
        case Fault.BLUR:
            return _faulty(
                options, replace(faults, pupil_mm=strength * lens.focal_mm / lens.aperture)
            )
        case Fault.PROCESSING:
            return _faulty(options, replace(faults, denoise=strength, sharpen=strength * 0.8))
        case Fault.JPEG:
            again = _faulty(options, replace(faults, stored_again=_jpeg(strength * 20)))
            return replace(again, jpeg_quality=_jpeg(strength * 12))
        case Fault.LIGHT:
            lamp = (1.0 + strength * 0.35, 1.0, max(0.0, 1.0 - strength * 0.45))
            mixed = replace(options.lighting, lamp_colour=lamp, shadow=Shadow.MOVING)
            lit = _faulty(
                options, replace(faults, exposure_ev=strength * 0.15, tint=strength * 0.04)
            )
            return replace(lit, lighting=mixed)
        case Fault.WET:
            wet = replace(options.lighting, gloss=1.0 + strength * 11.0)
            return replace(options, lighting=wet)
        case Fault.BENT:
            board = options.board
            return replace(options, board=board and replace(board, sag_mm=strength * 0.5))
        case Fault.STRETCHED:
            board = options.board
            return replace(options, board=board and replace(board, stretch=strength * 0.002))
        case Fault.CREEP:
            return _faulty(options, replace(faults, creep_mm=strength * 0.3))
        case Fault.BACKGROUND:
            return _faulty(options, replace(faults, background_mm=strength * 30.0))


def _jpeg(loss: float) -> int:
    """JPEG quality, 100 less a loss."""
    return max(1, round(100 - loss))


def _faulty(options: CaptureOptions, faults: Faults) -> CaptureOptions:
    """The capture with these faults of the camera."""
    return replace(options, faults=faults)
