"""Photos: files to a PhotoSet, and pixels on demand."""

from limbgram.reconstruction.photos.decoding import in_flight_mb, load_colour, load_luma
from limbgram.reconstruction.photos.masks import load_mask
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet, SetAside
from limbgram.reconstruction.photos.quality import QualityOptions, Remark, common_fault, remarks
from limbgram.reconstruction.photos.reading import PhotoOptions, read_photos

__all__ = [
    "CameraGroup",
    "Exif",
    "Photo",
    "PhotoOptions",
    "PhotoSet",
    "QualityOptions",
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
