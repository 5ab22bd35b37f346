"""EXIF: the few fields that say something about the camera; everything else is left unread.

Focal-plane resolution tags are not used: they are wrong once a picture was reduced. The focal
length is nominal; focused near, the true principal distance is a few per cent longer.
"""

import math
from collections.abc import Mapping

from PIL import Image
from PIL.ExifTags import IFD, Base

from limbgram.photos.decoding import DECODING_FAULTS
from limbgram.photos.photo import Exif

_LONGEST_TEXT = 64

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
        focal_mm=_positive(details.get(Base.FocalLength)),
        focal_35mm=_positive(details.get(Base.FocalLengthIn35mmFilm)),
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


def _positive(value: object) -> float | None:
    try:
        number = float(value)  # pyright: ignore[reportArgumentType]
    except (TypeError, ValueError, ArithmeticError):
        return None
    return number if math.isfinite(number) and 0 < number < 1e5 else None


def _whole(value: object) -> int:
    return value if isinstance(value, int) else 1
