"""Known distances between points that were picked in photos, or between coded marks."""

from limbgram.scale.distances.known import KnownDistance, Pick, measure_distances
from limbgram.scale.distances.marks import MarkSighting, distance_between_marks, find_marks

__all__ = [
    "KnownDistance",
    "MarkSighting",
    "Pick",
    "distance_between_marks",
    "find_marks",
    "measure_distances",
]
