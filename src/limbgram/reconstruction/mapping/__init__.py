"""Mapping: camera poses and sparse points in one scene, with a verdict for every photo.

The last step is one adjustment of photos, lenses and points, with the calibration as a prior.
"""

from limbgram.reconstruction.mapping.body import Body
from limbgram.reconstruction.mapping.bundle_adjustment import Adjusted, adjust
from limbgram.reconstruction.mapping.placement import MappingOptions, place
from limbgram.reconstruction.mapping.scene import Observations, PhotoVerdict, Ring, Scene

__all__ = [
    "Adjusted",
    "Body",
    "MappingOptions",
    "Observations",
    "PhotoVerdict",
    "Ring",
    "Scene",
    "adjust",
    "place",
]
