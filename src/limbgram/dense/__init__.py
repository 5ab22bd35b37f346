"""Dense: the limb's region, depth maps of it, and one cloud of oriented points."""

from limbgram.dense.depth import DepthMap
from limbgram.dense.fusion import FusionOptions, fuse
from limbgram.dense.region import Region, RegionOptions, find_region
from limbgram.dense.stereo import DenseOptions, estimate_depth
from limbgram.geometry.cloud import Cloud

__all__ = [
    "Cloud",
    "DenseOptions",
    "DepthMap",
    "FusionOptions",
    "Region",
    "RegionOptions",
    "estimate_depth",
    "find_region",
    "fuse",
]
