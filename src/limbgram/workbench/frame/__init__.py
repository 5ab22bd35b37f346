"""Frame: landmarks and the limb's axes."""

from limbgram.core.mesh.axis import Axis, axis_along, fit_axis
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.frame.landmarks import (
    NAMES,
    landmark,
    with_landmarks,
)
from limbgram.workbench.frame.painted_marks import Mark, find_marks
from limbgram.workbench.limb import KINDS, KindName

__all__ = [
    "KINDS",
    "NAMES",
    "AlignOptions",
    "Axis",
    "KindName",
    "Mark",
    "align",
    "axis_along",
    "find_marks",
    "fit_axis",
    "landmark",
    "with_landmarks",
]
