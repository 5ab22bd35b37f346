"""Fusion: depth maps to one cloud of oriented points."""

from limbgram.dense.fusion.fusing import FusionOptions, fuse

__all__ = ["FusionOptions", "fuse"]
