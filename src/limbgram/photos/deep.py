"""Deep pictures: sixteen bits a sample in the file, of which a camera may fill fewer.

In      an opened picture of sixteen bits a sample.
Out     how many bits it uses, and its pixels in eight.
Method  converters write the 12 or 14 bits of a sensor at the lower end of sixteen. The largest
        sample of a capture tells how many there are, rounded up to a depth that sensors have. Of
        16-bit colours Pillow keeps the upper byte; decoded once more with the bytes swapped it
        keeps the lower one.
"""

import sys
from collections.abc import Callable

import numpy as np
from PIL.ImageFile import ImageFile

from limbgram.geometry.arrays import ColourImage, GreyImage

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
