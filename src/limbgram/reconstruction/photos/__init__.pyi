"""Photos: its names, each imported when it is first used."""

from .decoding import in_flight_mb, load_colour, load_luma
from .masks import load_mask
from .photo import CameraGroup, Exif, Photo, PhotoSet, SetAside
from .quality import Remark, common_fault, remarks
from .reading import PhotoOptions, read_photos

__all__ = [
    "CameraGroup",
    "Exif",
    "Photo",
    "PhotoOptions",
    "PhotoSet",
    "Remark",
    "SetAside",
    "common_fault",
    "in_flight_mb",
    "load_colour",
    "load_luma",
    "load_mask",
    "read_photos",
    "remarks",
]
