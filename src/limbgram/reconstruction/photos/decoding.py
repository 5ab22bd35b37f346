"""Decoding: pixels of an image file, in the sensor's orientation.

In      a picture file of a capture.
Out     its brightness or its colours in eight bits; the few EXIF fields that describe the camera.
Method  Only JPEG, PNG and TIFF are tried, and HEIF and raw files where their extras are installed,
        so that no rarely used decoder meets a foreign file. Pillow decodes (`heif` and `raw` their
        own); a JPEG's brightness comes without its colours.
        Deep pictures, of sixteen bits a sample: converters write the 12 or 14 bits of a sensor at
        the lower end of sixteen. The largest sample of a capture shows how many there are, rounded
        up to a depth that sensors have. Of 16-bit colours Pillow keeps the upper byte; decoded once
        more with the bytes swapped it keeps the lower one.
        EXIF: focal-plane resolution tags are not used, because they are wrong once a picture was
        reduced. The focal length is nominal; focused near, the true principal distance is a few per
        cent longer.
"""

import hashlib
import math
import os
import struct
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from PIL import Image, UnidentifiedImageError
from PIL.ExifTags import IFD, Base
from PIL.ImageFile import ImageFile

from limbgram.core.errors import PhotoError
from limbgram.core.geometry.arrays import ColourImage, GreyImage
from limbgram.findings import Finding, fault
from limbgram.reconstruction.photos.heif import (
    HAS_HEIF,
    HEIF_BRANDS,
    HEIF_SUFFIXES,
    NO_HEIF,
    HeifPicture,
)
from limbgram.reconstruction.photos.photo import Exif, Photo
from limbgram.reconstruction.photos.raw import BAD_RAW, HAS_RAW, NO_RAW, RAW_SUFFIXES, RawPicture

_DEPTHS = (8, 10, 12, 14, 16)
_LARGEST_TAGS = (341, 281)
"""SMaxSampleValue and MaxSampleValue of TIFF 6.0."""
_OTHER = "B" if sys.byteorder == "little" else "L"
_SWAPPED = {"L": "B", "B": "L", "N": _OTHER}
_COLOURS = ("RGB;16", "RGBA;16", "RGBX;16")


def is_deep(picture: ImageFile) -> bool:
    """Whether a file, whose pixels are not decoded yet, holds sixteen bits a sample."""
    return _is_grey(picture) or bool(picture.tile and _raw_mode(picture)[:-1] in _COLOURS)


def bits_used(picture: ImageFile) -> int:
    """Depth, 8 to 16, that holds the largest sample, and the largest one that the file claims."""
    if _is_grey(picture):
        largest = int(_grey(picture).max(initial=0))
    else:
        upper = np.asarray(picture)[:, :, :3]
        largest = (int(upper.max(initial=0)) << 8) | 0xFF
    claimed = _claimed(picture)
    largest = max(largest, claimed if claimed < 0xFFFF else 0)
    return next(depth for depth in _DEPTHS if largest < 1 << depth)


def grey_of(picture: ImageFile, bits: int) -> GreyImage | None:
    """Eight bits of a grey picture whose capture uses so many; None of one in colours."""
    if not _is_grey(picture):
        return None
    return np.minimum(_grey(picture) >> (bits - 8), 255).astype(np.uint8)


def colours_of(picture: ImageFile, bits: int, again: Callable[[], ImageFile]) -> ColourImage:
    """Eight bits of a picture in colours whose capture uses so many.

    Args:
        again: Opens the same picture once more.
    """
    upper = np.asarray(picture.convert("RGB"))
    if bits == 16:
        return upper
    with again() as other:
        other.tile = [tile._replace(args=_swapped(tile.args)) for tile in other.tile]
        value = np.asarray(other.convert("RGB")).astype(np.uint16)
    value |= upper.astype(np.uint16) << 8
    value >>= bits - 8
    return np.minimum(value, 255).astype(np.uint8)


def _is_grey(picture: ImageFile) -> bool:
    return picture.mode.startswith("I")


def _grey(picture: ImageFile) -> np.ndarray:
    return np.clip(np.asarray(picture), 0, 0xFFFF).astype(np.uint16)


def _raw_mode(picture: ImageFile) -> str:
    """How the file's samples lie, such as RGB;16L: 16 bits, the lower byte first."""
    args = picture.tile[0].args
    return str(args[0] if isinstance(args, tuple) and args else args)


def _swapped(args: object) -> object:
    """A decoder's arguments with the other byte first."""
    first, *rest = args if isinstance(args, tuple) else (args,)
    raw = str(first)[:-1] + _SWAPPED[str(first)[-1]]
    return (raw, *rest) if isinstance(args, tuple) else raw


def _claimed(picture: ImageFile) -> int:
    """Largest sample by the file's own word; 0 where it says nothing."""
    tags = getattr(picture, "tag_v2", {})
    for tag in _LARGEST_TAGS:
        said = tags.get(tag)
        values = said if isinstance(said, tuple) else (said,)
        whole = [value for value in values if isinstance(value, int) and 0 < value <= 0xFFFF]
        if whole:
            return max(whole)
    return 0


FORMATS = ("JPEG", "PNG", "TIFF")
FORMATS_FOR_PEOPLE = "JPEG, PNG or TIFF"

MEGAPIXELS_DECODER = 178
"""Pillow refuses larger pictures as decompression bombs."""

_BAND_PX = 4_000_000
"""Pixels that are turned into an array at a time: whole copies would double what decoding takes."""
_JPEG_SUFFIXES = (".jpg", ".jpeg")
_LUMA_BYTES, _LUMA_BYTES_JPEG, _COLOUR_BYTES, _DEEP_BYTES = 6.5, 2.7, 9.5, 29.0
"""Bytes a pixel while a photo is decoded, with the array that is handed on. Measured on 24 MP:
luma 2.7 of a JPEG, 6.3 of a PNG; colour 9.3; 6 of 16 bits grey, 29 of 16 bits in colours."""
_LUMA_BYTES_HEIF, _COLOUR_BYTES_HEIF, _RAW_BYTES = 10.0, 12.0, 13.5
"""The same of 12 MP: HEIF 9.5 and 11.8, a raw file 13.2 either way."""
_DECODED_BYTES = 4.0
"""What Pillow keeps of a decoded pixel in colours."""
_MOST_HALVINGS = 3
"""As often as a JPEG's blocks of 8 pixels can be halved while they are decoded."""

_SRGB = np.arange(256) / 255
LINEAR_OF_SRGB = np.where(_SRGB <= 0.04045, _SRGB / 12.92, ((_SRGB + 0.055) / 1.055) ** 2.4)
"""Linear light of the 256 values that a pixel's red, green or blue may have."""

DECODING_FAULTS = (
    OSError,
    SyntaxError,
    ValueError,
    TypeError,
    LookupError,
    ArithmeticError,
    EOFError,
    MemoryError,
    NotImplementedError,
    struct.error,
    Image.DecompressionBombError,
)
"""What Pillow's decoders raise on broken files."""

# What is wrong with a file is told by its reason; what Pillow warns of besides, such as a damaged
# header or a large picture, would stand on the terminal between the answers.
warnings.filterwarnings("ignore", module=r"PIL\.")


def load_luma(photo: Photo, halvings: int = 0) -> GreyImage:
    """Brightness of a photo, in the sensor's orientation, halved `halvings` times.

    Pixel centres are kept. Of a JPEG only what the reduced photo shows is decoded.

    Raises:
        PhotoError: the file changed or vanished since it was read first.
    """
    try:
        with open_picture(photo.path) as picture:
            bits = photo.bits or (16 if is_deep(picture) else None)
            return _of_size(photo, luma_of(picture, bits, halvings), halvings)
    except DECODING_FAULTS as fault:
        raise gone(photo) from fault


def load_colour(photo: Photo, halvings: int = 0) -> ColourImage:
    """Red, green, blue of a photo, in the sensor's orientation, halved `halvings` times.

    Pixel centres are kept. Of a JPEG only what the reduced photo shows is decoded: a quarter of the
    memory and half of the time for one halving.

    Raises:
        PhotoError: the file changed or vanished since it was read first.
    """
    try:
        with open_picture(photo.path) as picture:
            if is_deep(picture):
                deep = Image.fromarray(_deep_colour(picture, photo.bits or 16))
                colours = np.asarray(deep.reduce(1 << halvings) if halvings else deep)
            else:
                colours = _as_array(picture, "RGB", halvings)
            return _of_size(photo, colours, halvings)
    except DECODING_FAULTS as fault:
        raise gone(photo) from fault


def halvings_to(width_px: int, least_px: float) -> int:
    """How often a photo can be halved, three times at most, to be no narrower than `least_px`."""
    return int(np.clip(np.floor(np.log2(width_px / least_px)), 0, _MOST_HALVINGS))


def open_picture(path: Path) -> ImageFile:
    """The picture's header; pixels decode on demand. Raises one of DECODING_FAULTS."""
    if HAS_RAW and path.suffix.lower() in RAW_SUFFIXES:
        return RawPicture(path)
    if HAS_HEIF and is_heif(path):
        return HeifPicture(path)
    return Image.open(path, formats=FORMATS)


def is_heif(path: Path) -> bool:
    """Whether a file begins as HEIF does, whatever its name."""
    with path.open("rb") as stream:
        first = stream.read(12)
    return first[4:8] == b"ftyp" and first[8:] in HEIF_BRANDS


def depth_of(picture: ImageFile) -> int | None:
    """Bits a sample that a deep picture uses; None of one that has eight."""
    return bits_used(picture) if is_deep(picture) else None


def luma_of(picture: ImageFile, bits: int | None, halvings: int = 0) -> GreyImage:
    """Brightness of an opened picture: a JPEG's own Y, else 0.299 R + 0.587 G + 0.114 B."""
    if bits is None:
        return _as_array(picture, "L", halvings)
    grey = grey_of(picture, bits)
    if grey is None:
        grey = np.asarray(Image.fromarray(_deep_colour(picture, bits)).convert("L"))
    return np.asarray(Image.fromarray(grey).reduce(1 << halvings)) if halvings else grey


def decoding_mb(
    path: Path, pixels: int, *, colour: bool = False, deep: bool = False, halvings: int = 0
) -> float:
    """Memory that a photo takes while it is decoded and looked at.

    deep: it holds sixteen bits a sample (`photos.deep`).
    halvings: of its colours (`load_colour`).
    """
    if deep:
        return pixels * _DEEP_BYTES / 2**20
    suffix = path.suffix.lower()
    if suffix in RAW_SUFFIXES:
        return pixels * _RAW_BYTES / 2**20
    is_jpeg, is_heif = suffix in _JPEG_SUFFIXES, suffix in HEIF_SUFFIXES
    if not colour:
        luma_bytes = _LUMA_BYTES_HEIF if is_heif else _LUMA_BYTES
        return pixels * (_LUMA_BYTES_JPEG if is_jpeg else luma_bytes) / 2**20
    whole_bytes = 0.0 if is_jpeg or halvings == 0 else _DECODED_BYTES
    colour_bytes = _COLOUR_BYTES_HEIF if is_heif else _COLOUR_BYTES
    return pixels * (whole_bytes + colour_bytes / 4**halvings) / 2**20


def in_flight_mb(
    photos: Sequence[Photo], bytes_a_pixel: float = 0.0, *, colour: bool = False, halvings: int = 0
) -> float:
    """Memory for the largest of these photos while it is decoded and worked on."""

    def each(photo: Photo) -> float:
        pixels = photo.width_px * photo.height_px
        deep = photo.bits is not None
        decoding = decoding_mb(photo.path, pixels, colour=colour, deep=deep, halvings=halvings)
        return decoding + pixels * bytes_a_pixel / 2**20

    return max(map(each, photos), default=0.0)


def decoding_fault(path: Path, error: BaseException) -> Finding:
    """Why a file could not be decoded."""
    if path.suffix.lower() in RAW_SUFFIXES and isinstance(error, OSError | SyntaxError):
        return BAD_RAW if HAS_RAW else NO_RAW
    if isinstance(error, Image.DecompressionBombError):
        return fault("photo.file.bomb", most_megapixels=MEGAPIXELS_DECODER)
    if isinstance(error, PermissionError):
        return fault("photo.file.forbidden")
    if isinstance(error, UnidentifiedImageError):
        if not HAS_HEIF and (path.suffix.lower() in HEIF_SUFFIXES or is_heif(path)):
            return NO_HEIF
        return fault("photo.file.unknown_kind", formats=FORMATS_FOR_PEOPLE)
    if isinstance(error, MemoryError):
        return fault("photo.file.memory")
    if "truncated" in str(error).lower():
        return fault("photo.file.cut_off")
    return fault("photo.file.broken")


def _deep_colour(picture: ImageFile, bits: int) -> ColourImage:
    grey = grey_of(picture, bits)
    if grey is not None:
        return np.repeat(grey[:, :, None], 3, axis=2)
    return colours_of(picture, bits, lambda: open_picture(Path(os.fsdecode(picture.filename))))


def _as_array(picture: ImageFile, mode: Literal["L", "RGB"], halvings: int = 0) -> np.ndarray:
    """All pixels in a mode, converted and reduced band by band."""
    factor, stored_px = 1 << halvings, picture.width
    if halvings or mode == "L":
        wanted = "L" if mode == "L" else None
        picture.draft(wanted, (picture.width >> halvings, picture.height >> halvings))
        factor //= round(stored_px / picture.width)  # a JPEG's decoder has done its part
    picture.load()
    width, height = picture.size
    shape = -(-height // factor), -(-width // factor)
    pixels = np.empty(shape if mode == "L" else (*shape, 3), np.uint8)
    rows = max(1, _BAND_PX // max(width, 1)) * factor
    for top in range(0, height, rows):
        band = picture.crop((0, top, width, min(top + rows, height))).convert(mode)
        reduced = band.reduce(factor) if factor > 1 else band
        pixels[top // factor : top // factor + reduced.height] = np.asarray(reduced)
    return pixels


def _of_size(photo: Photo, pixels: np.ndarray, halvings: int = 0) -> np.ndarray:
    part = 1 << halvings
    if pixels.shape[:2] != (-(-photo.height_px // part), -(-photo.width_px // part)):
        raise gone(photo)
    return pixels


def gone(photo: Photo) -> PhotoError:
    """The refusal of a photo that changed or vanished since it was read first."""
    return PhotoError("photo.gone", photo=photo.name, path=str(photo.path))


_LONGEST_TEXT = 64
_FILM_FOCALS_MM = 5.0, 3000.0
"""Shortest and longest focal length, for 35-mm film, that a tag is believed to tell."""
_SERIAL = 0xA431
"""BodySerialNumber of EXIF 2.3."""

_UPRIGHT = {2: (0, True), 3: (2, False), 4: (2, True), 5: (3, True), 6: (1, False)} | {
    7: (1, True),
    8: (3, False),
}
"""EXIF orientation to clockwise quarter turns after, where so, a swap of left and right."""


def read_exif(picture: Image.Image) -> Exif:
    """What an opened picture says about its camera; unreadable fields count as absent."""
    try:
        tags = picture.getexif()
        details: Mapping[int, object] = tags.get_ifd(IFD.Exif)
    except DECODING_FAULTS:
        return Exif()
    turns, mirrored = _UPRIGHT.get(_whole(tags.get(Base.Orientation)), (0, False))
    return Exif(
        make=_text(tags.get(Base.Make)),
        model=_text(tags.get(Base.Model)),
        lens=_text(details.get(Base.LensModel)),
        body=_body(_text(details.get(_SERIAL))),
        focal_mm=_positive(details.get(Base.FocalLength)),
        focal_35mm=_film_focal_mm(details.get(Base.FocalLengthIn35mmFilm)),
        digital_zoom=_enlarged(_positive(details.get(Base.DigitalZoomRatio))),
        aperture=_positive(details.get(Base.FNumber)),
        subject_m=_positive(details.get(Base.SubjectDistance)),
        quarter_turns=turns,
        mirrored=mirrored,
    )


def _text(value: object) -> str | None:
    if not isinstance(value, str):
        return None
    readable = "".join(letter if letter.isprintable() else " " for letter in value)
    return " ".join(readable.split())[:_LONGEST_TEXT] or None


def _body(serial: str | None) -> str | None:
    if serial is None or not serial.strip("0 "):  # left empty by the camera
        return None
    return hashlib.sha256(serial.encode()).hexdigest()[:8]


def _positive(value: object) -> float | None:
    try:
        number = float(value)  # pyright: ignore[reportArgumentType]
    except (TypeError, ValueError, ArithmeticError):
        return None
    return number if math.isfinite(number) and 0 < number < 1e5 else None


def _film_focal_mm(value: object) -> float | None:
    """What no lens has is no focal length: micrometres, or 65535 for one that is not known."""
    number = _positive(value)
    shortest_mm, longest_mm = _FILM_FOCALS_MM
    return number if number is not None and shortest_mm <= number <= longest_mm else None


def _enlarged(zoom: float | None) -> float | None:
    """Zoom 1 is none, and so says a camera that writes 0."""
    return zoom if zoom is not None and abs(zoom - 1.0) > 1e-3 else None


def _whole(value: object) -> int:
    return value if isinstance(value, int) else 1
