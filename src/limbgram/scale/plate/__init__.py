"""A board of known size as a ruler lying in the scene."""

from limbgram.scale.plate.plate import Plate, find_plate

__all__ = ["Plate", "find_plate"]
