"""The region: the part of the world that is the limb, found automatically or given."""

from limbgram.dense.region.cubes import Region
from limbgram.dense.region.footprint import Footprint, footprint
from limbgram.dense.region.localisation import RegionOptions, find_region

__all__ = ["Footprint", "Region", "RegionOptions", "find_region", "footprint"]
