"""Stereo: depth maps, one a photo."""

from limbgram.dense.stereo.estimation import estimate_depth
from limbgram.dense.stereo.solving import DenseOptions

__all__ = ["DenseOptions", "estimate_depth"]
