"""Masks: pictures beside the photos that say which pixels to use (white) and which not (black).

A photo's mask is NAME.png or NAME.jpg.png beside it or in a subfolder `masks`. It was drawn on the
photo as stored, or as seen, upright; then it is turned back to the sensor's frame. An orientation
in its own header tells which, else its size. Half a turn and a swap of sides keep the size: there
it counts as drawn on the stored photo, and `mask_notes` names it.
A photo that was cut out, on transparent ground, is a mask of itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TypeVar, cast

import numpy as np
from jaxtyping import Bool, UInt8
from PIL import Image
from PIL.ExifTags import Base
from PIL.PngImagePlugin import PngInfo

from limbgram.core.errors import PhotoError
from limbgram.core.geometry.arrays import Mask
from limbgram.findings import Finding, doubt, fault, note
from limbgram.reconstruction.photos.decoding import (
    DECODING_FAULTS,
    decoding_fault,
    gone_error,
    open_picture,
    read_exif,
)
from limbgram.reconstruction.photos.photo import Exif, Photo, PhotoSet, first_of
from limbgram.reconstruction.photos.quality import PICTURE_SUFFIXES

MASKS_FOLDER = "masks"
_LEAST_COLOUR_DIFFERENCE = 24
"""Difference of two colour channels above which a picture is no mask."""
_LIES = "limbgram"
"""Keyword in the header of masks that the program wrote; its text is how they lie."""
_AS_STORED, _AS_SEEN = "as its photo is stored", "as its photo is seen"
Picture = TypeVar("Picture", bound=np.ndarray)


def load_mask(photo: Photo) -> Mask | None:
    """Pixels of a photo to be used, in the sensor's frame; None where it has no mask.

    Raises:
        PhotoError: the mask changed or vanished since the photos were read.
    """
    opacity_mask = _opacity_mask(photo) if photo.cut_out else None
    if photo.mask_path is None:
        return opacity_mask
    try:
        mask = read_mask(photo.mask_path, photo.width_px, photo.height_px, photo.exif)
    except DECODING_FAULTS as fault:
        raise _mask_gone_error(photo) from fault
    if isinstance(mask, Finding):
        raise _mask_gone_error(photo)
    return mask.pixels if opacity_mask is None else mask.pixels & opacity_mask


def _opacity_mask(photo: Photo) -> Mask:
    """Mask of a cut-out photo: pixels that are more opaque than not."""
    try:
        with open_picture(photo.path) as picture:
            opacity = opacity_of(picture)
    except DECODING_FAULTS as fault:
        raise gone_error(photo) from fault
    if opacity is None or opacity.shape != (photo.height_px, photo.width_px):
        raise gone_error(photo)
    return _binarised(opacity)


def opacity_of(picture: Image.Image) -> UInt8[np.ndarray, "rows columns"] | None:
    """Opacity of each pixel of a picture; None where all are fully opaque."""
    if picture.mode in ("LA", "RGBA", "PA"):
        opacity = np.asarray(picture.getchannel("A"))
    elif picture.mode in ("1", "L", "P", "RGB") and "transparency" in picture.info:
        opacity = np.asarray(picture.convert("RGBA").getchannel("A"))
    else:
        return None
    return opacity if opacity.min(initial=255) < 255 else None


def _binarised(levels: np.ndarray) -> Mask:
    """Pixels above half of the highest level."""
    return levels > levels.max() / 2


def masks_among(files: Sequence[Path]) -> set[Path]:
    """The files that are named as the mask of another."""
    photos = [file for file in files if file.suffix.lower() in PICTURE_SUFFIXES]
    return {mask for photo in photos if (mask := find_mask(photo)) is not None}


def find_mask(photo: Path) -> Path | None:
    """The mask of a photo, beside it or in the subfolder."""
    beside = mask_in(photo.parent, photo)
    return mask_in(photo.parent / MASKS_FOLDER, photo) if beside is None else beside


def mask_in(folder: Path, photo: Path, name: str | None = None) -> Path | None:
    """The mask of a photo in a folder; `name` where it is called otherwise than its file."""
    called = Path(photo.name if name is None else name)
    for stem in (called.name, called.stem):
        candidate = _png_named(folder / stem)
        if candidate is not None and candidate != photo:
            return candidate
    return None


def require_masks_folder(folder: Path) -> None:
    """Raise PhotoError where there is no such folder."""
    if not folder.is_dir():
        raise PhotoError("photo.mask.no_folder", folder=str(folder))


def no_mask_fits(folder: Path, photo: Path) -> PhotoError:
    """The refusal of a folder in which no picture is the mask of a photo."""
    return PhotoError("photo.mask.none_fits", folder=str(folder), photo=photo.name, stem=photo.stem)


def mask_as_png(mask: Mask, exif: Exif) -> bytes:
    """A mask in the sensor's frame as a file, held upright; `read_mask` turns it back.

    Half a turn and a swap of sides are left out, which the file says.
    """
    lies = _lies(exif)
    levels = (upright(mask, exif) if lies == _AS_SEEN else mask).astype(np.uint8) * 255
    header, stream = PngInfo(), BytesIO()
    header.add_text(_LIES, lies)
    Image.fromarray(levels).save(stream, "PNG", pnginfo=header)
    return stream.getvalue()


def _lies(exif: Exif) -> str:
    """How the program's own mask of a photo lies."""
    return _AS_SEEN if exif.quarter_turns % 2 == 1 else _AS_STORED


def upright(picture: Picture, exif: Exif) -> Picture:
    """A picture in the sensor's frame, turned upright."""
    stored = picture[:, ::-1] if exif.mirrored else picture
    return cast(Picture, np.ascontiguousarray(np.rot90(stored, -exif.quarter_turns)))


@dataclass(frozen=True)
class ReadMask:
    """A mask in the sensor's frame."""

    pixels: Mask
    told: bool
    """Whether its header or size tells how it lies on its photo, or it is the same either way."""


def read_mask(path: Path, width_px: int, height_px: int, exif: Exif) -> ReadMask | Finding:
    """A mask in the sensor's frame, or why the file is none. Raises one of DECODING_FAULTS."""
    turned = exif.quarter_turns % 2 == 1
    with Image.open(path, formats=("PNG",)) as picture:
        as_seen = turned and picture.size == (height_px, width_px)
        if picture.size != (width_px, height_px) and not as_seen:
            return fault(
                "photo.mask.size",
                width_px=picture.width,
                height_px=picture.height,
                photo_width_px=width_px,
                photo_height_px=height_px,
            )
        levels = _levels(picture)
        said = picture.info.get(_LIES) == _lies(exif)
        own = read_exif(picture) if Base.Orientation in picture.getexif() else None
    if isinstance(levels, Finding):
        return levels
    mask = _binarised(levels)
    if not mask.any():
        return fault("photo.mask.black")
    seen = _to_sensor_frame(mask, exif)
    if own is not None and not said:
        by_header = _to_sensor_frame(upright(mask, own), exif)
        if by_header.shape == (height_px, width_px):
            return ReadMask(by_header, told=True)
    by_size = turned and width_px != height_px
    told = said or by_size or np.array_equal(mask, seen)
    return ReadMask(seen if as_seen else mask, told)


def checked_mask(path: Path, width_px: int, height_px: int, exif: Exif) -> ReadMask | Finding:
    """A mask in the sensor's frame, or why it cannot be used."""
    try:
        return read_mask(path, width_px, height_px, exif)
    except DECODING_FAULTS as error:
        return decoding_fault(path, error)


def mask_notes(photos: PhotoSet) -> tuple[Finding, ...]:
    """How many photos have masks, which have none, and which masks may lie otherwise; nothing where
    no photo has one."""
    without_mask = [one.name for one in photos.photos if not one.masked]
    count = len(photos.photos)
    if len(without_mask) == count:
        return ()
    untold = [one.name for one in photos.photos if not one.mask_told]
    doubts = (doubt("photo.mask.as_stored", **first_of(untold)),) if untold else ()
    if not without_mask:
        return (note("photo.mask.all", photos=count), *doubts)
    masked = count - len(without_mask)
    some = note("photo.mask.some", masked=masked, photos=count, **first_of(without_mask))
    return (some, *doubts)


def _png_named(base: Path) -> Path | None:
    for suffix in (".png", ".PNG"):
        candidate = base.parent / (base.name + suffix)
        try:
            if candidate.is_file():
                return candidate
        except OSError:  # with the suffix the name is too long
            return None
    return None


def _levels(picture: Image.Image) -> np.ndarray | Finding:
    """Levels of a mask: opacity on transparent ground, else brightness; or why it is none."""
    opacity = opacity_of(picture)
    if opacity is not None:
        return opacity
    if picture.mode.startswith("I"):
        return np.asarray(picture)
    colour = np.asarray(picture.convert("RGB"))
    if np.ptp(colour.astype(np.int16), axis=2).max() > _LEAST_COLOUR_DIFFERENCE:
        return fault("photo.mask.coloured")
    return colour[:, :, 1]


def _to_sensor_frame(upright: Mask, exif: Exif) -> Bool[np.ndarray, "rows columns"]:
    """An upright mask in the sensor's frame: the inverse of `upright`."""
    stored = np.rot90(upright, exif.quarter_turns)
    return np.ascontiguousarray(stored[:, ::-1] if exif.mirrored else stored)


def _mask_gone_error(photo: Photo) -> PhotoError:
    return PhotoError("photo.mask.gone", photo=photo.name, path=str(photo.mask_path))
