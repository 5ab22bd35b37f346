"""Masks: pictures beside the photos that say which pixels to use (white) and which not (black).

A photo's mask is NAME.png or NAME.jpg.png beside it or in a subfolder `masks`. It has the size
of the stored photo, or of the photo held upright, and is then turned back to the sensor's frame.
A photo that was cut out, on transparent ground, is a mask of itself.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar, cast

import numpy as np
from jaxtyping import Bool, UInt8
from PIL import Image

from limbgram.core.errors import PhotoError
from limbgram.core.geometry.arrays import Mask
from limbgram.findings import Finding, fault, note
from limbgram.reconstruction.photos.decoding import (
    DECODING_FAULTS,
    decoding_fault,
    gone_error,
    open_picture,
)
from limbgram.reconstruction.photos.photo import Exif, Photo, PhotoSet, first_of
from limbgram.reconstruction.photos.quality import PICTURE_SUFFIXES

MASKS_FOLDER = "masks"
_LEAST_COLOUR_DIFFERENCE = 24
"""Difference of two colour channels above which a picture is no mask."""
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
    return mask if opacity_mask is None else mask & opacity_mask


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


def held_upright(mask: Mask, exif: Exif) -> Bool[np.ndarray, "rows columns"]:
    """A mask in the sensor's frame as it is saved, upright; `read_mask` turns it back.

    Half a turn is left out: the size of a file shows only quarter turns.
    """
    return mask if exif.quarter_turns % 2 == 0 else upright(mask, exif)


def upright(picture: Picture, exif: Exif) -> Picture:
    """A picture in the sensor's frame, turned upright."""
    stored = picture[:, ::-1] if exif.mirrored else picture
    return cast(Picture, np.ascontiguousarray(np.rot90(stored, -exif.quarter_turns)))


def read_mask(path: Path, width_px: int, height_px: int, exif: Exif) -> Mask | Finding:
    """A mask in the sensor's frame, or why the file is none. Raises one of DECODING_FAULTS."""
    with Image.open(path, formats=("PNG",)) as picture:
        is_upright = exif.quarter_turns % 2 == 1 and picture.size == (height_px, width_px)
        if picture.size != (width_px, height_px) and not is_upright:
            return fault(
                "photo.mask.size",
                width_px=picture.width,
                height_px=picture.height,
                photo_width_px=width_px,
                photo_height_px=height_px,
            )
        levels = _levels(picture)
    if isinstance(levels, Finding):
        return levels
    mask = _binarised(levels)
    if not mask.any():
        return fault("photo.mask.black")
    return np.ascontiguousarray(_to_sensor_frame(mask, exif) if is_upright else mask)


def mask_fault(path: Path, width_px: int, height_px: int, exif: Exif) -> Finding | None:
    """Why a mask cannot be used; None where it can."""
    try:
        mask = read_mask(path, width_px, height_px, exif)
    except DECODING_FAULTS as error:
        return decoding_fault(path, error)
    return mask if isinstance(mask, Finding) else None


def mask_notes(photos: PhotoSet) -> tuple[Finding, ...]:
    """How many photos have masks, and which have none; nothing where none has one."""
    without_mask = [one.name for one in photos.photos if not one.masked]
    count = len(photos.photos)
    if len(without_mask) == count:
        return ()
    if not without_mask:
        return (note("photo.mask.all", photos=count),)
    masked = count - len(without_mask)
    return (note("photo.mask.some", masked=masked, photos=count, **first_of(without_mask)),)


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
    return stored[:, ::-1] if exif.mirrored else stored


def _mask_gone_error(photo: Photo) -> PhotoError:
    return PhotoError("photo.mask.gone", photo=photo.name, path=str(photo.mask_path))
