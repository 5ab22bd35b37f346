"""Usual faults: a capture as a real camera, board, light and patient would give it.

In      CaptureOptions, and which faults.
Out     the same capture with each of them at the strength that is usual; `Faults`, `PrintedBoard`
        and `Lighting` say where each strength comes from.
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
    """What real captures have that ideal ones do not."""

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


def with_faults(options: CaptureOptions, faults: Iterable[Fault]) -> CaptureOptions:
    """The capture with these faults at their usual strength."""
    for fault in faults:
        options = _with_fault(options, fault)
    return options


def _with_fault(options: CaptureOptions, fault: Fault) -> CaptureOptions:
    lens, had = options.lens, options.faults
    match fault:
        case Fault.STABILISER:
            return _spoiled(options, replace(had, stabiliser_px=0.0025 * options.width_px))
        case Fault.BREATHING:
            focus_per_mm = 0.06 / options.distance_mm
            return _spoiled(options, replace(had, breathing=lens.focal_mm * focus_per_mm))
        case Fault.ROLLING:
            return _spoiled(options, replace(had, readout_s=0.02))
        case Fault.BLUR:
            return _spoiled(options, replace(had, pupil_mm=lens.focal_mm / lens.aperture))
        case Fault.PROCESSING:
            return _spoiled(options, replace(had, denoise=1.0, sharpen=0.8))
        case Fault.JPEG:
            again = _spoiled(options, replace(had, stored_again=80))
            return replace(again, jpeg_quality=88)
        case Fault.LIGHT:
            mixed = replace(options.lighting, lamp_colour=(1.35, 1.0, 0.55), shadow=Shadow.MOVING)
            lit = _spoiled(options, replace(had, exposure_ev=0.15, tint=0.04))
            return replace(lit, lighting=mixed)
        case Fault.WET:
            return replace(options, lighting=replace(options.lighting, gloss=12.0))
        case Fault.BENT:
            board = options.board
            return replace(options, board=board and replace(board, sag_mm=0.5))
        case Fault.STRETCHED:
            board = options.board
            return replace(options, board=board and replace(board, stretch=0.002))
        case Fault.CREEP:
            return _spoiled(options, replace(had, creep_mm=0.3))
        case Fault.BACKGROUND:
            return _spoiled(options, replace(had, background_mm=30.0))


def _spoiled(options: CaptureOptions, faults: Faults) -> CaptureOptions:
    return replace(options, faults=faults)
