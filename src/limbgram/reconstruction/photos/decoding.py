"""Decoding: pixels of an image file, in the sensor's orientation.

In      a picture file of a capture.
Out     its brightness or its colours in eight bits; the few EXIF fields that describe the camera.
Method  Only JPEG, PNG and TIFF are tried, and HEIF and raw files where their extras are installed,
        so that no rarely used decoder meets a foreign file. Pillow decodes (`heif` and `raw` their
        own); a JPEG's brightness comes without its colours.
        Pictures of sixteen bits a sample: converters write the 12 or 14 bits of a sensor at the
        lower end of sixteen. The largest sample of a capture shows the bit depth, rounded up to one
        that sensors have. Of 16-bit colours Pillow keeps the upper byte; decoded once more with the
        bytes swapped it keeps the lower one.
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
from PIL.TiffImagePlugin import TiffImageFile

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
from limbgram.reconstruction.photos.tiff import as_stored

_BIT_DEPTHS = (8, 10, 12, 14, 16)
_LARGEST_TAGS = (341, 281)
"""SMaxSampleValue and MaxSampleValue of TIFF 6.0."""
_OTHER_BYTE_ORDER = "B" if sys.byteorder == "little" else "L"
_SWAPPED_BYTE_ORDER = {"L": "B", "B": "L", "N": _OTHER_BYTE_ORDER}
_COLOUR_MODES_16_BIT = ("RGB;16", "RGBA;16", "RGBX;16")


def has_16_bits(picture: ImageFile) -> bool:
    """Whether a picture whose pixels are not decoded yet holds sixteen bits a sample."""
    return _is_grey(picture) or bool(
        picture.tile and _sample_layout(picture)[:-1] in _COLOUR_MODES_16_BIT
    )


def used_bits(picture: ImageFile) -> int:
    """Bit depth, 8 to 16, that holds the largest sample and the largest that the file states."""
    if _is_grey(picture):
        largest = int(_grey_16_bit(picture).max(initial=0))
    else:
        upper = np.asarray(picture)[:, :, :3]
        largest = (int(upper.max(initial=0)) << 8) | 0xFF
    claimed = _claimed_maximum(picture)
    largest = max(largest, claimed if claimed < 0xFFFF else 0)
    return next(depth for depth in _BIT_DEPTHS if largest < 1 << depth)


def grey_8_bit(picture: ImageFile, bits: int) -> GreyImage | None:
    """A grey picture of a capture with this bit depth, in eight bits; None of one in colours."""
    if not _is_grey(picture):
        return None
    return np.minimum(_grey_16_bit(picture) >> (bits - 8), 255).astype(np.uint8)


def colours_8_bit(picture: ImageFile, bits: int, reopen: Callable[[], ImageFile]) -> ColourImage:
    """A picture in colours of a capture with this bit depth, in eight bits.

    Args:
        reopen: Opens the same picture once more.
    """
    upper = np.asarray(picture.convert("RGB"))
    if bits == 16:
        return upper
    with reopen() as swapped:
        swapped.tile = [tile._replace(args=_with_swapped_bytes(tile.args)) for tile in swapped.tile]
        value = np.asarray(swapped.convert("RGB")).astype(np.uint16)
    value |= upper.astype(np.uint16) << 8
    value >>= bits - 8
    return np.minimum(value, 255).astype(np.uint8)


def _is_grey(picture: ImageFile) -> bool:
    return picture.mode.startswith("I")


def _grey_16_bit(picture: ImageFile) -> np.ndarray:
    return np.clip(np.asarray(picture), 0, 0xFFFF).astype(np.uint16)


def _sample_layout(picture: ImageFile) -> str:
    """Pillow's raw mode, such as RGB;16L: 16 bits, the lower byte first."""
    args = picture.tile[0].args
    return str(args[0] if isinstance(args, tuple) and args else args)


def _with_swapped_bytes(args: object) -> object:
    """Arguments of Pillow's decoder with the other byte order."""
    first, *rest = args if isinstance(args, tuple) else (args,)
    raw = str(first)[:-1] + _SWAPPED_BYTE_ORDER[str(first)[-1]]
    return (raw, *rest) if isinstance(args, tuple) else raw


def _claimed_maximum(picture: ImageFile) -> int:
    """Largest sample that the file states; 0 where it states none."""
    tags = getattr(picture, "tag_v2", {})
    for tag in _LARGEST_TAGS:
        value = tags.get(tag)
        values = value if isinstance(value, tuple) else (value,)
        whole = [value for value in values if isinstance(value, int) and 0 < value <= 0xFFFF]
        if whole:
            return max(whole)
    return 0


FORMATS = ("JPEG", "PNG", "TIFF")
FORMATS_FOR_PEOPLE = "JPEG, PNG or TIFF"

MEGAPIXELS_DECODER = 178
"""Pillow refuses larger pictures as decompression bombs."""

_BAND_PX = 4_000_000
"""Pixels that become an array at a time: whole copies would double the memory of decoding."""
_JPEG_SUFFIXES = (".jpg", ".jpeg")
_LUMA_BYTES, _LUMA_BYTES_JPEG, _COLOUR_BYTES, _BYTES_16_BIT = 6.5, 2.7, 9.5, 29.0
"""Bytes a pixel while a photo is decoded, with the array that is handed on. Measured on 24 MP:
luma 2.7 of a JPEG, 6.3 of a PNG; colour 9.3; 6 of 16 bits grey, 29 of 16 bits in colours."""
_LUMA_BYTES_HEIF, _COLOUR_BYTES_HEIF, _RAW_BYTES = 10.0, 12.0, 13.5
"""The same, measured on 12 MP: HEIF 9.5 and 11.8, a raw file 13.2 either way."""
_DECODED_BYTES = 4.0
"""Bytes that Pillow keeps of a decoded pixel in colours."""
_MOST_HALVINGS = 3
"""A JPEG's blocks of 8 pixels can be halved so often while they are decoded."""

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

# A file's reason says what is wrong; Pillow's own warnings, of a damaged header or a large picture,
# would only interrupt the output.
warnings.filterwarnings("ignore", module=r"PIL\.")


def load_luma(photo: Photo, halvings: int = 0) -> GreyImage:
    """Brightness of a photo, in the sensor's orientation, halved `halvings` times.

    Pixel centres are kept. Of a JPEG only what the reduced photo shows is decoded.

    Raises:
        PhotoError: the file changed or vanished since it was read first.
    """
    try:
        with open_picture(photo.path) as picture:
            bits = photo.bits or (16 if has_16_bits(picture) else None)
            return _checked_size(photo, luma_of(picture, bits, halvings), halvings)
    except DECODING_FAULTS as fault:
        raise gone_error(photo) from fault


def load_colour(photo: Photo, halvings: int = 0) -> ColourImage:
    """Red, green, blue of a photo, in the sensor's orientation, halved `halvings` times.

    Pixel centres are kept. Of a JPEG only what the reduced photo shows is decoded: a quarter of the
    memory and half of the time for one halving.

    Raises:
        PhotoError: the file changed or vanished since it was read first.
    """
    try:
        with open_picture(photo.path) as picture:
            if has_16_bits(picture):
                deep = Image.fromarray(_colours_of_16_bit(picture, photo.bits or 16))
                colours = np.asarray(deep.reduce(1 << halvings) if halvings else deep)
            else:
                colours = _decoded_pixels(picture, "RGB", halvings)
            return _checked_size(photo, colours, halvings)
    except DECODING_FAULTS as fault:
        raise gone_error(photo) from fault


def halvings_to(width_px: int, least_px: float) -> int:
    """How often a photo can be halved and stay `least_px` wide, three times at most."""
    return int(np.clip(np.floor(np.log2(width_px / least_px)), 0, _MOST_HALVINGS))


def open_picture(path: Path) -> ImageFile:
    """The picture's header; pixels decode on demand. Raises one of DECODING_FAULTS."""
    if HAS_RAW and path.suffix.lower() in RAW_SUFFIXES:
        return RawPicture(path)
    if HAS_HEIF and is_heif(path):
        return HeifPicture(path)
    picture = Image.open(path, formats=FORMATS)
    return as_stored(picture) if isinstance(picture, TiffImageFile) else picture


def is_heif(path: Path) -> bool:
    """Whether a file begins as HEIF, whatever its name."""
    with path.open("rb") as stream:
        first = stream.read(12)
    return first[4:8] == b"ftyp" and first[8:] in HEIF_BRANDS


def to_look_at(picture: ImageFile) -> Image.Image:
    """An opened picture for people: of sixteen bits a sample, in eight, by the bits it uses."""
    if not has_16_bits(picture):
        return picture
    shown = Image.fromarray(_colours_of_16_bit(picture, used_bits(picture)))
    shown.getexif()[Base.Orientation] = picture.getexif().get(Base.Orientation, 1)
    return shown


def bit_depth(picture: ImageFile) -> int | None:
    """Bit depth that a picture of sixteen bits a sample uses; None of one with eight."""
    return used_bits(picture) if has_16_bits(picture) else None


def luma_of(picture: ImageFile, bits: int | None, halvings: int = 0) -> GreyImage:
    """Brightness of an opened picture: a JPEG's own Y, else 0.299 R + 0.587 G + 0.114 B."""
    if bits is None:
        return _decoded_pixels(picture, "L", halvings)
    grey = grey_8_bit(picture, bits)
    if grey is None:
        grey = np.asarray(Image.fromarray(_colours_of_16_bit(picture, bits)).convert("L"))
    return np.asarray(Image.fromarray(grey).reduce(1 << halvings)) if halvings else grey


def decoding_mb(
    path: Path, pixels: int, *, colour: bool = False, deep: bool = False, halvings: int = 0
) -> float:
    """Memory for a photo while it is decoded.

    Args:
        deep: Whether it holds sixteen bits a sample.
        halvings: How often its colours are halved (`load_colour`).
    """
    if deep:
        return pixels * _BYTES_16_BIT / 2**20
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
    if isinstance(error, PermissionError):
        return fault("photo.file.forbidden")
    if path.suffix.lower() in RAW_SUFFIXES and isinstance(error, OSError | SyntaxError):
        return BAD_RAW if HAS_RAW else NO_RAW
    if isinstance(error, Image.DecompressionBombError):
        return fault("photo.file.bomb", most_megapixels=MEGAPIXELS_DECODER)
    if isinstance(error, UnidentifiedImageError):
        if not HAS_HEIF and (path.suffix.lower() in HEIF_SUFFIXES or is_heif(path)):
            return NO_HEIF
        return fault("photo.file.unknown_kind", formats=FORMATS_FOR_PEOPLE)
    if isinstance(error, MemoryError):
        return fault("photo.file.memory")
    if "truncated" in str(error).lower():
        return fault("photo.file.cut_off")
    return fault("photo.file.broken")


def _colours_of_16_bit(picture: ImageFile, bits: int) -> ColourImage:
    """Eight bits of red, green and blue of a picture of sixteen bits a sample."""
    grey = grey_8_bit(picture, bits)
    if grey is not None:
        return np.repeat(grey[:, :, None], 3, axis=2)
    return colours_8_bit(picture, bits, lambda: open_picture(Path(os.fsdecode(picture.filename))))


def _decoded_pixels(picture: ImageFile, mode: Literal["L", "RGB"], halvings: int = 0) -> np.ndarray:
    """Pixels of a picture in a mode, converted and reduced band by band.

    Pillow copies a picture even where nothing is cut off or converted.
    """
    factor, stored_px = 1 << halvings, picture.width
    if halvings or mode == "L":
        wanted = "L" if mode == "L" else None
        picture.draft(wanted, (picture.width >> halvings, picture.height >> halvings))
        factor //= round(stored_px / picture.width)  # a JPEG's decoder has reduced it
    picture.load()
    width, height = picture.size
    shape = -(-height // factor), -(-width // factor)
    pixels = np.empty(shape if mode == "L" else (*shape, 3), np.uint8)
    rows = max(1, _BAND_PX // max(width, 1)) * factor
    for top in range(0, height, rows):
        whole = rows >= height
        band = picture if whole else picture.crop((0, top, width, min(top + rows, height)))
        converted = band if band.mode == mode else band.convert(mode)
        reduced = converted.reduce(factor) if factor > 1 else converted
        pixels[top // factor : top // factor + reduced.height] = np.asarray(reduced)
    return pixels


def _checked_size(photo: Photo, pixels: np.ndarray, halvings: int = 0) -> np.ndarray:
    """The pixels, refused where they are not those of the photo that was read first."""
    factor = 1 << halvings
    if pixels.shape[:2] != (-(-photo.height_px // factor), -(-photo.width_px // factor)):
        raise gone_error(photo)
    return pixels


def gone_error(photo: Photo) -> PhotoError:
    """The refusal of a photo that changed or vanished since it was read first."""
    return PhotoError("photo.gone", photo=photo.name, path=str(photo.path))


_MOST_LETTERS = 64
_FILM_FOCALS_MM = 5.0, 3000.0
"""Shortest and longest plausible focal length for 35-mm film."""
_BODY_SERIAL_TAG = 0xA431
"""BodySerialNumber of EXIF 2.3."""

_TURNS_OF_ORIENTATION = {2: (0, True), 3: (2, False), 4: (2, True), 5: (3, True), 6: (1, False)} | {
    7: (1, True),
    8: (3, False),
}
"""EXIF orientation: clockwise quarter turns, after a swap of left and right where True."""


def read_exif(picture: Image.Image) -> Exif:
    """EXIF of an opened picture; unreadable fields count as absent."""
    try:
        tags = picture.getexif()
        details: Mapping[int, object] = tags.get_ifd(IFD.Exif)
    except DECODING_FAULTS:
        return Exif()
    turns, mirrored = _TURNS_OF_ORIENTATION.get(
        _orientation_of(tags.get(Base.Orientation)), (0, False)
    )
    return Exif(
        make=_printable_text(tags.get(Base.Make)),
        model=_printable_text(tags.get(Base.Model)),
        lens=_printable_text(details.get(Base.LensModel)),
        body=_hashed_serial(_printable_text(details.get(_BODY_SERIAL_TAG))),
        focal_mm=_positive_number(details.get(Base.FocalLength)),
        focal_35mm=_film_focal_mm(details.get(Base.FocalLengthIn35mmFilm)),
        digital_zoom=_digital_zoom(_positive_number(details.get(Base.DigitalZoomRatio))),
        aperture=_positive_number(details.get(Base.FNumber)),
        subject_m=_positive_number(details.get(Base.SubjectDistance)),
        taken=_moment(details),
        quarter_turns=turns,
        mirrored=mirrored,
    )


def _printable_text(value: object) -> str | None:
    if not isinstance(value, str):
        return None
    readable = "".join(letter if letter.isprintable() else " " for letter in value)
    return " ".join(readable.split())[:_MOST_LETTERS] or None


def _hashed_serial(serial: str | None) -> str | None:
    """Hash of a serial number; None where the camera leaves it empty."""
    if serial is None or not serial.strip("0 "):
        return None
    return hashlib.sha256(serial.encode()).hexdigest()[:8]


def _positive_number(value: object) -> float | None:
    try:
        number = float(value)  # pyright: ignore[reportArgumentType]
    except (TypeError, ValueError, ArithmeticError):
        return None
    return number if math.isfinite(number) and 0 < number < 1e5 else None


def _film_focal_mm(value: object) -> float | None:
    """Focal length unless no lens has it: some files write micrometres, or 65535 for unknown."""
    number = _positive_number(value)
    shortest_mm, longest_mm = _FILM_FOCALS_MM
    return number if number is not None and shortest_mm <= number <= longest_mm else None


def _digital_zoom(zoom: float | None) -> float | None:
    """Digital zoom; None for 1, and for the 0 that some cameras write instead."""
    return zoom if zoom is not None and abs(zoom - 1.0) > 1e-3 else None


def _moment(details: Mapping[int, object]) -> str | None:
    """Date and time with its fraction; None of a camera whose clock was never set."""
    second = _printable_text(details.get(Base.DateTimeOriginal))
    if second is None or not second.strip("0: "):
        return None
    fraction = _printable_text(details.get(Base.SubsecTimeOriginal))
    return second if fraction is None else f"{second}.{fraction}"


def _orientation_of(value: object) -> int:
    """EXIF orientation; 1, upright, where it is missing."""
    return value if isinstance(value, int) else 1
