"""The world frame: which way is up, where the floor and the origin are."""

from limbgram.scale.frame.floor import Plane, find_floor
from limbgram.scale.frame.upright import centre_of_object, common_up, rotation_to_z

__all__ = ["Plane", "centre_of_object", "common_up", "find_floor", "rotation_to_z"]
