"""Raw files: a sensor's samples, demosaiced by LibRaw through rawpy (the extra `raw`).

In      a camera's raw file, such as .dng, .nef or .cr3.
Out     an opened picture for Pillow: eight bits of red, green and blue in the sensor's frame.
        Its header opens at once; it is developed on demand.
Method  White balance is the camera's, and all photos of a capture are developed alike: none is
        brightened by its own content, no lens correction is applied, and the whole sensor is kept.
        That is a few pixels larger than the camera's JPEG, so a camera whose raw files are measured
        is calibrated from raw files too.
        EXIF comes from the file where it is a TIFF (most are), else from the JPEG that it holds,
        else from what LibRaw knows of the lens.
Fails   OSError or SyntaxError: the file is broken, its camera is not known to LibRaw, or rawpy is
        not there.
"""

import io
import os
import struct
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from PIL import Image
from PIL.ExifTags import IFD, Base
from PIL.ImageFile import ImageFile

from limbgram.findings import fault

HAS_RAW = find_spec("rawpy") is not None
RAW_SUFFIXES = (".3fr", ".arw", ".cr2", ".cr3", ".dng", ".nef", ".orf", ".pef", ".raf", ".rw2")
NO_RAW = fault("photo.file.no_raw")
"""Why such a file is set aside where rawpy is not installed."""
BAD_RAW = fault("photo.file.bad_raw")

_ORIENTATION_OF_FLIP = {0: 1, 3: 3, 5: 8, 6: 6}
TIFF_MAGIC = (b"II*\0", b"MM\0*")
_READING_FAULTS = (OSError, SyntaxError, ValueError, TypeError, LookupError, EOFError, struct.error)


class RawPicture(ImageFile):
    """The developed picture of a raw file."""

    format = "RAW"
    format_description = "Camera raw file, developed"

    _developed = False

    def _open(self) -> None:
        library = _rawpy()
        with library.RawPy() as raw:
            try:
                raw.open_file(os.fsdecode(self.filename))
                sizes = raw.sizes
                self._exif = _exif_of(raw, Path(os.fsdecode(self.filename)))
            except library.LibRawError as error:
                raise SyntaxError(f"LibRaw: {error}") from error
        self._size = (sizes.width, sizes.height)
        self._mode = "RGB"
        self.tile = []
        orientation = _ORIENTATION_OF_FLIP.get(sizes.flip, 1)
        self._exif[Base.Orientation] = orientation

    def getexif(self) -> Image.Exif:
        return self._exif or Image.Exif()

    def load(self) -> Any:
        """Develop the picture, once."""
        if self._developed:
            return super().load()
        library = _rawpy()
        with library.RawPy() as raw:
            try:
                raw.open_file(os.fsdecode(self.filename))
                raw.unpack()
                pixels = raw.postprocess(
                    user_flip=0, use_camera_wb=True, no_auto_bright=True, output_bps=8
                )
            except library.LibRawError as error:
                raise OSError(f"LibRaw: {error}") from error
        developed = Image.fromarray(pixels)
        self._developed = True
        self._size = developed.size
        self.im = developed.im
        return super().load()


def _rawpy() -> Any:
    try:
        return import_module("rawpy")
    except ImportError as error:
        raise SyntaxError("rawpy is not installed") from error


def _exif_of(raw: Any, path: Path) -> Image.Exif:
    """EXIF of a raw file, from its header, its preview or LibRaw."""
    exif = Image.Exif()
    try:
        with path.open("rb") as stream:
            if stream.read(4) in TIFF_MAGIC:
                stream.seek(0)
                exif.load_from_fp(stream)
                return _camera_fields(exif)
        return _camera_fields(
            Image.open(io.BytesIO(raw.extract_thumb().data), formats=("JPEG",)).getexif()
        )
    except (*_READING_FAULTS, _rawpy().LibRawError):
        return _exif_from_libraw(raw)


def _camera_fields(read: Image.Exif) -> Image.Exif:
    """A copy of the fields that describe the camera, which needs no open file."""
    exif = Image.Exif()
    exif.update({tag: read[tag] for tag in (Base.Make, Base.Model) if tag in read})
    exif.get_ifd(IFD.Exif).update(read.get_ifd(IFD.Exif))
    return exif


def _exif_from_libraw(raw: Any) -> Image.Exif:
    exif = Image.Exif()
    details = exif.get_ifd(IFD.Exif)
    details[Base.LensModel] = raw.lens.model
    details[Base.FocalLength] = raw.other.focal_length
    details[Base.FNumber] = raw.other.aperture
    return exif
