"""Scale: scene units to millimetres, with proof.

In      a Scene; BoardDetections of a board lying in it, known distances, both or neither.
Out     a MetricScene.
"""

from limbgram.reconstruction.scale.distances import KnownDistance, Pick
from limbgram.reconstruction.scale.marks import distance_between_marks, mark_distances
from limbgram.reconstruction.scale.metric import LengthCheck, MetricScene, Scale
from limbgram.reconstruction.scale.scaling import ScaleOptions, to_millimetres

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
