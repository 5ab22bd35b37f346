"""Measuring: from a coarse mesh and the photos to a surface at the resolution of the pixels."""

from limbgram.reconstruction.measuring.measurement import MeasureOptions, measure

__all__ = ["MeasureOptions", "measure"]
