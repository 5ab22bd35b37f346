"""Frame: landmarks and the limb's axes."""

from limbgram.shape.frame.alignment import align
from limbgram.shape.frame.axis import Axis, AxisOptions, axis_along, fit_axis
from limbgram.shape.frame.landmarks import (
    NAMES,
    LandmarkName,
    PickOptions,
    landmark,
    with_landmarks,
)
from limbgram.shape.frame.marks import Mark, MarkOptions, find_marks
from limbgram.shape.frame.posture import frame_of, in_limb_frame, with_vertices_in_limb
from limbgram.shape.frame.stated import AlignOptions
from limbgram.shape.limb import KINDS, Kind

__all__ = [
    "KINDS",
    "NAMES",
    "AlignOptions",
    "Axis",
    "AxisOptions",
    "Kind",
    "LandmarkName",
    "Mark",
    "MarkOptions",
    "PickOptions",
    "align",
    "axis_along",
    "find_marks",
    "fit_axis",
    "frame_of",
    "in_limb_frame",
    "landmark",
    "with_landmarks",
    "with_vertices_in_limb",
]
