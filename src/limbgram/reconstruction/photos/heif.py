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

_ORIENTATIONS = {
    (0, False): 1,
    (0, True): 2,
    (2, False): 3,
    (2, True): 4,
    (3, True): 5,
    (1, False): 6,
    (1, True): 7,
    (3, False): 8,
}
"""EXIF's number for a swap of left and right, where so, and clockwise quarter turns after it."""


@dataclass(frozen=True)
class Turn:
    """How stored pixels become upright: a swap of left and right, then clockwise quarter turns."""

    quarter_turns: int = 0
    mirrored: bool = False

    @property
    def orientation(self) -> int:
        return _ORIENTATIONS[self.quarter_turns, self.mirrored]


class HeifPicture(ImageFile):
    """The main picture of a HEIF file, in the sensor's frame."""

    format = "HEIF"
    format_description = "HEIF picture, in the sensor's frame"

    _found: Any = None
    _turn = Turn()

    def _open(self) -> None:
        self._turn = turn_of(Path(os.fsdecode(self.filename)).read_bytes())
        try:
            heif = import_module("pi_heif").open_heif(self.fp, convert_hdr_to_8bit=True)
            self._found = heif[heif.primary_index]
        except (ImportError, RuntimeError, ValueError, EOFError, IndexError) as error:
            raise SyntaxError(str(error)) from error
        width, height = self._found.size
        self._size = (height, width) if self._turn.quarter_turns % 2 else (width, height)
        self._mode = self._found.mode
        self.tile = []
        said = self._found.info.get("exif")
        if said:
            self.info["exif"] = said
        self.getexif()[Base.Orientation] = self._turn.orientation

    def load(self) -> Any:
        """Decode the pixels, once."""
        found, self._found = self._found, None
        if found is None:
            return super().load()
        try:
            pixels = found.data
        except (RuntimeError, ValueError, EOFError) as error:
            raise OSError(str(error)) from error
        shown = Image.frombytes(self._mode, found.size, pixels, "raw", self._mode, found.stride)
        del pixels, found
        for _ in range(self._turn.quarter_turns):
            shown = shown.transpose(Image.Transpose.ROTATE_90)
        if self._turn.mirrored:
            shown = shown.transpose(Image.Transpose.FLIP_LEFT_RIGHT)
        self._size = shown.size
        self.im = shown.im
        return super().load()


def turn_of(content: bytes) -> Turn:
    """How the main picture of a HEIF file is turned for people, by its properties."""
    turns, mirrored = 0, False
    for kind, body in _properties(content):
        if kind == b"irot":
            turns = (turns - (body[0] & 3)) % 4
        elif kind == b"imir":
            # Axis 1 swaps left and right; axis 0 top and bottom, which is that and half a turn.
            half = 0 if body[0] & 1 else 2
            turns, mirrored = (half - turns) % 4, not mirrored
    return Turn(turns, mirrored)


def _properties(content: bytes) -> list[tuple[bytes, bytes]]:
    """Kind and content of the main picture's properties, in the order in which they count."""
    top = dict(_boxes(content))
    inside = dict(_boxes(top[b"meta"][4:]))
    main = inside[b"pitm"]
    main_id = int.from_bytes(main[4:6] if main[0] == 0 else main[4:8])
    described = dict(_boxes(inside[b"iprp"]))
    listed = list(_boxes(described[b"ipco"]))
    return [listed[number - 1] for number in _numbers(described[b"ipma"], main_id) if number]


def _numbers(ipma: bytes, wanted_id: int) -> list[int]:
    """Numbers, from 1, of an item's properties (ISO/IEC 23008-12, ItemPropertyAssociation)."""
    id_bytes = 2 if ipma[0] == 0 else 4
    number_bytes = 2 if ipma[3] & 1 else 1
    (items,) = struct.unpack_from(">I", ipma, 4)
    place = 8
    for _ in range(items):
        item_id = int.from_bytes(ipma[place : place + id_bytes])
        count = ipma[place + id_bytes]
        place += id_bytes + 1
        end = place + count * number_bytes
        if item_id == wanted_id:
            essential = 1 << (8 * number_bytes - 1)
            return [
                int.from_bytes(ipma[at : at + number_bytes]) & ~essential
                for at in range(place, end, number_bytes)
            ]
        place = end
    return []


def _boxes(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Kind and content of each box (ISO/IEC 14496-12)."""
    place = 0
    while place + 8 <= len(content):
        size, kind = struct.unpack_from(">I4s", content, place)
        head = 8
        if size == 1:
            (size,) = struct.unpack_from(">Q", content, place + 8)
            head = 16
        end = len(content) if size == 0 else place + size
        if size != 0 and size < head:
            return
        yield kind, content[place + head : end]
        place = end
