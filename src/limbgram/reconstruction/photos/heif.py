"""HEIF: the pictures of phones, through pi-heif (the extra `heif`), as the sensor stored them.

In      a HEIF file whose pixels are coded as HEVC, such as .heic.
Out     an opened picture for Pillow; its pixels decode on demand.
Method  libheif decodes, and turns what it decodes as the file's own properties `irot` and `imir`
        say. A portrait would so be taken for another camera than a landscape of the same phone; it
        is turned back, and its orientation told as EXIF would. EXIF's own orientation does not
        count in these files (ISO/IEC 23008-12).
Fails   OSError, SyntaxError or struct.error: the file is broken, or pi-heif is not there.
"""

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from PIL import Image
from PIL.ExifTags import Base
from PIL.ImageFile import ImageFile

from limbgram.findings import fault

HAS_HEIF = find_spec("pi_heif") is not None
HEIF_SUFFIXES = (".heic", ".heif", ".hif")
HEIF_BRANDS = (b"heic", b"heix", b"hevc", b"mif1", b"msf1")
NO_HEIF = fault("photo.file.no_heif")
"""Why such a picture is set aside where pi-heif is not installed."""

_EXIF_ORIENTATION = {
    (0, False): 1,
    (0, True): 2,
    (2, False): 3,
    (2, True): 4,
    (3, True): 5,
    (1, False): 6,
    (1, True): 7,
    (3, False): 8,
}
"""EXIF orientation by clockwise quarter turns, after a swap of left and right where True."""


@dataclass(frozen=True)
class StoredOrientation:
    """How stored pixels turn upright: a swap of left and right, then clockwise quarter turns."""

    quarter_turns: int = 0
    mirrored: bool = False

    @property
    def exif_orientation(self) -> int:
        return _EXIF_ORIENTATION[self.quarter_turns, self.mirrored]


class HeifPicture(ImageFile):
    """The main picture of a HEIF file, in the sensor's frame."""

    format = "HEIF"
    format_description = "HEIF picture, in the sensor's frame"

    _heif: Any = None
    _orientation = StoredOrientation()

    def _open(self) -> None:
        self._orientation = stored_orientation(Path(os.fsdecode(self.filename)).read_bytes())
        try:
            heif = import_module("pi_heif").open_heif(self.fp, convert_hdr_to_8bit=True)
            self._heif = heif[heif.primary_index]
        except (ImportError, RuntimeError, ValueError, EOFError, IndexError) as error:
            raise SyntaxError(str(error)) from error
        width, height = self._heif.size
        self._size = (height, width) if self._orientation.quarter_turns % 2 else (width, height)
        self._mode = self._heif.mode
        self.tile = []
        exif = self._heif.info.get("exif")
        if exif:
            self.info["exif"] = exif
        self.getexif()[Base.Orientation] = self._orientation.exif_orientation

    def load(self) -> Any:
        """Decode the pixels, once."""
        heif, self._heif = self._heif, None
        if heif is None:
            return super().load()
        try:
            pixels = heif.data
        except (RuntimeError, ValueError, EOFError) as error:
            raise OSError(str(error)) from error
        shown = Image.frombytes(self._mode, heif.size, pixels, "raw", self._mode, heif.stride)
        del pixels, heif
        for _ in range(self._orientation.quarter_turns):
            shown = shown.transpose(Image.Transpose.ROTATE_90)
        if self._orientation.mirrored:
            shown = shown.transpose(Image.Transpose.FLIP_LEFT_RIGHT)
        self._size = shown.size
        self.im = shown.im
        return super().load()


def stored_orientation(content: bytes) -> StoredOrientation:
    """Orientation of the main picture of a HEIF file, from its properties `irot` and `imir`."""
    turns, mirrored = 0, False
    for kind, body in _main_properties(content):
        if kind == b"irot":
            turns = (turns - (body[0] & 3)) % 4
        elif kind == b"imir":
            # Axis 1 swaps left and right; axis 0 top and bottom, which is that and half a turn.
            half = 0 if body[0] & 1 else 2
            turns, mirrored = (half - turns) % 4, not mirrored
    return StoredOrientation(turns, mirrored)


def _main_properties(content: bytes) -> list[tuple[bytes, bytes]]:
    """Kind and content of the main picture's properties, in the order in which they apply."""
    top = dict(_boxes(content))
    inside = dict(_boxes(top[b"meta"][4:]))
    main = inside[b"pitm"]
    main_id = int.from_bytes(main[4:6] if main[0] == 0 else main[4:8])
    described = dict(_boxes(inside[b"iprp"]))
    listed = list(_boxes(described[b"ipco"]))
    return [
        listed[number - 1] for number in _property_indices(described[b"ipma"], main_id) if number
    ]


def _property_indices(ipma: bytes, wanted_id: int) -> list[int]:
    """Property indices of an item, from 1 (ISO/IEC 23008-12, ItemPropertyAssociation)."""
    id_bytes = 2 if ipma[0] == 0 else 4
    index_bytes = 2 if ipma[3] & 1 else 1
    (items,) = struct.unpack_from(">I", ipma, 4)
    offset = 8
    for _ in range(items):
        item_id = int.from_bytes(ipma[offset : offset + id_bytes])
        count = ipma[offset + id_bytes]
        offset += id_bytes + 1
        end = offset + count * index_bytes
        if item_id == wanted_id:
            essential = 1 << (8 * index_bytes - 1)
            return [
                int.from_bytes(ipma[position : position + index_bytes]) & ~essential
                for position in range(offset, end, index_bytes)
            ]
        offset = end
    return []


def _boxes(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Kind and content of each box (ISO/IEC 14496-12)."""
    offset = 0
    while offset + 8 <= len(content):
        size, kind = struct.unpack_from(">I4s", content, offset)
        header_bytes = 8
        if size == 1:
            (size,) = struct.unpack_from(">Q", content, offset + 8)
            header_bytes = 16
        end = len(content) if size == 0 else offset + size
        if size != 0 and size < header_bytes:
            return
        yield kind, content[offset + header_bytes : end]
        offset = end
