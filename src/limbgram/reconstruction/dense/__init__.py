"""Dense: the limb's region, depth maps of it, and one cloud of oriented points."""

from limbgram.core.mesh.mesh import Cloud
from limbgram.reconstruction.dense.depth import DepthMap
from limbgram.reconstruction.dense.estimation import estimate_depth
from limbgram.reconstruction.dense.fusion import FusionOptions, fuse
from limbgram.reconstruction.dense.photo_depth import DenseOptions
from limbgram.reconstruction.dense.region import Region, RegionOptions, find_region

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
