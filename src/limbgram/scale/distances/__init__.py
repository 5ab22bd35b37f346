"""Known distances between points that were picked in photos, or between coded marks."""

from limbgram.scale.distances.known import KnownDistance, Pick, measure_distances

__all__ = ["KnownDistance", "Pick", "measure_distances"]
