"""Frame: landmarks and the limb's axes."""

from limbgram.shape.frame.alignment import AlignOptions, align
from limbgram.shape.frame.axis import Axis, AxisOptions, axis_along, fit_axis
from limbgram.shape.frame.landmarks import (
    KINDS,
    NAMES,
    Kind,
    LandmarkName,
    PickOptions,
    landmark,
    with_landmarks,
)
from limbgram.shape.frame.marks import Mark, MarkOptions, find_marks

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
    "landmark",
    "with_landmarks",
]
