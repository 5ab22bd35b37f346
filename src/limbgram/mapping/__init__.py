"""Mapping: photos placed in one scene, with its sparse points and a verdict for every photo."""

from limbgram.mapping.ring import MappingOptions, place
from limbgram.mapping.scene import Observations, PhotoVerdict, Ring, Scene

__all__ = ["MappingOptions", "Observations", "PhotoVerdict", "Ring", "Scene", "place"]
