"""Scale: its names, each imported when it is first used."""

from .marks import distance_between_marks, mark_distances
from .metric import LengthCheck, MetricScene, Scale
from .scaling import ScaleOptions, to_millimetres
from .stated_lengths import KnownDistance, Pick

__all__ = [
    "KnownDistance",
    "LengthCheck",
    "MetricScene",
    "Pick",
    "Scale",
    "ScaleOptions",
    "distance_between_marks",
    "mark_distances",
    "to_millimetres",
]
