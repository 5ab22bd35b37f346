"""Privacy: removes place, names and serial numbers from a photo's header.

In      the bytes of a JPEG, PNG, TIFF, raw or HEIF file, or of a film.
Out     bytes of the same picture to the last sample, and what was taken out of its header.
Method  Only headers are rewritten. Tags of EXIF are taken out of their lists and their values set
        to zero where they stand, so that nothing else moves; serial numbers become a keyed hash of
        the same length, so that a camera's calibration still knows the body and nobody else does.
        Of a JPEG and a PNG the parts for comments, XMP and IPTC are left out, and what follows a
        JPEG's end (moving pictures, second pictures with headers of their own). A raw file keeps
        its maker's note, because the decoder needs it; that is told in what is answered. The raw
        files of Olympus and Panasonic have the structure of TIFF under numbers of their own.
Fails   never: a file whose header is not known here (RAF, CR3, BigTIFF, any other), or that is
        damaged at its beginning, keeps it, and the answer says so.
"""

import hashlib
import hmac
import re
import struct
import zlib
from dataclasses import dataclass, field, replace
from pathlib import Path

from limbgram.reconstruction.photos.raw import RAW_SUFFIXES, TIFF

_EXIF, _INTEROPERABILITY, _SUB, _PLACE = 0x8769, 0xA005, 0x014A, 0x8825
_SERIALS = {0xA431: "serial number", 0xA435: "serial number of the lens", 0xC62F: "serial number"}
_MAKER = {0x927C: "maker's note", 0xC634: "maker's note"}
_PERSONAL = {
    0x010E: "description",
    0x013B: "photographer",
    0x013C: "name of the computer",
    0x8298: "copyright",
    0x8649: "editing program's data",
    0x83BB: "caption",
    0x02BC: "XMP",
    0x9286: "comment",
    0x9C9B: "title",
    0x9C9C: "comment",
    0x9C9D: "photographer",
    0x9C9E: "keywords",
    0x9C9F: "subject",
    0xA420: "unique number",
    0xA430: "owner of the camera",
}
"""Tags of TIFF 6.0, EXIF 2.32, DNG 1.6 and Windows that may name a person."""
_BYTES_OF_TYPE = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8, 13: 4}
_LARGEST_HEADER = 100_000_000
"""Of a film."""
_MOST_LISTS = 64
_MOST_TAGS = 4096
_WHOLE_HEADER = "the whole header"
"""What is told of a file whose header is not known here."""
_RAW_TIFF = (b"IIRO", b"IIRS", b"MMOR", b"IIU\0")
"""First bytes of ORF (Olympus) and RW2 (Panasonic): else they are built as TIFF is."""
_LARGEST_SEGMENT = 65_533
"""Bytes of one part of a JPEG's header."""
_AFTER_SCAN = re.compile(rb"\xff[^\x00\xd0-\xd7\xff]")
"""A marker within or after the compressed data of a JPEG."""
_EXIF_ITEM = re.compile(rb"Exif\x00\x00(?:II\*\x00|MM\x00\*)")
_XMP_ITEM = re.compile(rb"<x:xmpmeta.*?</x:xmpmeta>", re.DOTALL)
_XMP = (_XMP_ITEM, "XMP")
_ISO_6709 = re.compile(rb"[+-]\d{2,}\.\d+[+-]\d{2,3}\.\d+(?:[+-]\d+(?:\.\d+)?)?/")
"""A place as films carry it (ISO 6709)."""
_FILM_PLACE = (_ISO_6709, "place")
_CR3 = b"crx "
"""Brand of Canon's raw files: boxes that are not known here hold the header, place and all."""


@dataclass(frozen=True)
class Cleaned:
    """A file's bytes, and what was taken out."""

    content: bytes
    removed: tuple[str, ...]
    kept: tuple[str, ...] = ()
    """What had to stay though it may tell the camera."""


@dataclass
class _Header:
    """Bytes of a TIFF structure that are being changed where they stand."""

    content: bytearray
    base: int
    end: int
    key: bytes
    raw: bool
    removed: list[str] = field(default_factory=list[str])
    kept: list[str] = field(default_factory=list[str])
    sign: str = ""
    """Which byte of a number comes first, as `struct` says it."""

    def clean(self) -> None:
        order = bytes(self.content[self.base : self.base + 2])
        self.sign = {b"II": "<", b"MM": ">"}.get(order, "")
        first = self._number(self.base + 4, 4) if self.sign else 0
        if not self._has_list(self.base + first):
            self.kept.append(_WHOLE_HEADER)
            return
        lists = [first]
        seen: set[int] = set()
        while lists and len(seen) < _MOST_LISTS:
            place = lists.pop()
            if place and place not in seen:
                seen.add(place)
                lists += self._clean_list(self.base + place)

    def _clean_list(self, start: int) -> list[int]:
        """Take tags out of a list; returns where the lists below and after it lie."""
        if not self._has_list(start):
            return []
        count = self._number(start, 2)
        below: list[int] = []
        kept: list[bytes] = []
        for number in range(count):
            entry = start + 2 + 12 * number
            tag = self._number(entry, 2)
            where, size = self._value(entry)
            if tag in (_EXIF, _INTEROPERABILITY, _SUB):
                below += [self._number(at, 4) for at in range(where, where + size - 3, 4)]
            if tag == _PLACE:
                self.removed.append("place")
                self._wipe_list(self.base + self._number(entry + 8, 4))
                continue
            if tag in _PERSONAL or (tag in _MAKER and not self.raw):
                self.removed.append({**_PERSONAL, **_MAKER}[tag])
                self.content[where : where + size] = bytes(size)
                continue
            if tag in _MAKER:
                self.kept.append(_MAKER[tag])
            if tag in _SERIALS and size > 1:
                self.removed.append(_SERIALS[tag])
                self.content[where : where + size] = self._instead(where, size)
            kept.append(bytes(self.content[entry : entry + 12]))
        after = start + 2 + 12 * count
        following = bytes(self.content[after : after + 4]) if after + 4 <= self.end else b""
        whole = struct.pack(f"{self.sign}H", len(kept)) + b"".join(kept) + following
        room = 2 + 12 * count + len(following)
        self.content[start : start + room] = whole.ljust(room, b"\0")
        if len(following) == 4:
            below.append(struct.unpack(f"{self.sign}I", following)[0])
        return below

    def _wipe_list(self, start: int) -> None:
        """Set a list and all its values to zero."""
        if not self._has_list(start):
            return
        count = self._number(start, 2)
        for number in range(count):
            where, size = self._value(start + 2 + 12 * number)
            self.content[where : where + size] = bytes(size)
        self.content[start : start + 2 + 12 * count] = bytes(2 + 12 * count)

    def _has_list(self, start: int) -> bool:
        """Whether a whole list can lie there."""
        if not self.base < start <= self.end - 2:
            return False
        count = self._number(start, 2)
        return count <= _MOST_TAGS and start + 2 + 12 * count <= self.end

    def _value(self, entry: int) -> tuple[int, int]:
        """Where a tag's value lies and its bytes; no bytes where it lies outside."""
        size = _BYTES_OF_TYPE.get(self._number(entry + 2, 2), 0) * self._number(entry + 4, 4)
        where = entry + 8 if size <= 4 else self.base + self._number(entry + 8, 4)
        return (where, size) if where + size <= self.end else (entry + 8, 0)

    def _instead(self, where: int, size: int) -> bytes:
        """Letters of the same number that tell this body from others, and not which it is."""
        value = bytes(self.content[where : where + size]).rstrip(b"\0 ")
        letters = hmac.new(self.key, value, hashlib.sha256).hexdigest().encode()
        return (letters * (size // len(letters) + 1))[: size - 1] + b"\0"

    def _number(self, at: int, size: int) -> int:
        order = "little" if self.sign == "<" else "big"
        return int.from_bytes(self.content[at : at + size], order)


def without_traces(content: bytes, suffix: str, key: bytes) -> Cleaned:
    """A photo's file without what tells place, person or camera body.

    Args:
        suffix: Of the file's name, small letters: raw files look like others of TIFF.
        key: Secret of whoever keeps the photos, by which serial numbers become other ones.
    """
    if content.startswith(b"\xff\xd8\xff"):
        return _of_jpeg(content, key)
    if content.startswith(b"\x89PNG\r\n\x1a\n"):
        return _of_png(content, key)
    if content[:4] in _RAW_TIFF or (content[:4] in TIFF and suffix in RAW_SUFFIXES):
        return _of_raw(content, key)
    if content[:4] in TIFF:
        return _in_place(content, key, [(0, len(content))])
    if content[4:8] == b"ftyp":
        return _of_boxes(content, key)
    return Cleaned(content, (), (_WHOLE_HEADER,))


def take_place_from_film(path: Path) -> tuple[str, ...]:
    """Wipe the place from a film's header (MP4, MOV), where it stands; returns what was wiped.

    Only the header is read: a film may be larger than memory. Tracks of measurements that some
    cameras write beside the picture are not known here, and stay.
    """
    removed: list[str] = []
    with path.open("r+b") as film:
        end = film.seek(0, 2)
        at = 0
        while at + 8 <= end:
            film.seek(at)
            size, kind = struct.unpack(">I4s", film.read(8))
            whole = int.from_bytes(film.read(8), "big") if size == 1 else size or end - at
            if whole < 8:
                break
            if kind == b"moov" and whole <= _LARGEST_HEADER:
                film.seek(at)
                content = film.read(whole)
                for found in _ISO_6709.finditer(content):
                    film.seek(at + found.start())
                    film.write(b" " * (found.end() - found.start()))
                    removed.append("place")
            at += whole
    return tuple(dict.fromkeys(removed))


def _in_place(
    content: bytes, key: bytes, spans: list[tuple[int, int]], *, raw: bool = False
) -> Cleaned:
    changed = bytearray(content)
    removed: list[str] = []
    kept: list[str] = []
    for base, end in spans:
        header = _Header(changed, base, end, key, raw)
        header.clean()
        removed += header.removed
        kept += header.kept
    return Cleaned(bytes(changed), tuple(dict.fromkeys(removed)), tuple(dict.fromkeys(kept)))


def _of_raw(content: bytes, key: bytes) -> Cleaned:
    """Also of the pictures in it, which some cameras give a whole header of their own."""
    spans = [(0, len(content))]
    for found in _EXIF_ITEM.finditer(content):
        base = found.start() + 6
        spans.append((base, min(len(content), base + _LARGEST_SEGMENT)))
    cleaned = _in_place(content, key, spans, raw=True)
    return _without_texts(cleaned, (_XMP,))


def _of_jpeg(content: bytes, key: bytes) -> Cleaned:
    parts: list[bytes] = [content[:2]]
    removed: list[str] = []
    kept: list[str] = []
    at = 2
    while at + 4 <= len(content) and content[at] == 0xFF:
        marker = content[at + 1]
        if marker == 0xFF:  # a filler
            at += 1
            continue
        size = int.from_bytes(content[at + 2 : at + 4], "big")
        segment = content[at : at + 2 + size]
        if marker == 0xDA or size < 2 or len(segment) < 2 + size:
            break
        at += 2 + size
        body = segment[4:]
        if marker == 0xE1 and body.startswith(b"Exif\0\0"):
            inner = _in_place(body, key, [(6, len(body))])
            removed += inner.removed
            kept += inner.kept
            parts.append(segment[:4] + inner.content)
        elif marker == 0xFE or (0xE0 <= marker <= 0xEF and not _needed(marker, body)):
            removed.append("XMP" if body.startswith(b"http") else "other header")
        else:
            parts.append(segment)
    end = _end_of_jpeg(content, at)
    if end < len(content):
        removed.append("what follows the picture")
    parts.append(content[at:end])
    return Cleaned(b"".join(parts), tuple(dict.fromkeys(removed)), tuple(dict.fromkeys(kept)))


def _needed(marker: int, body: bytes) -> bool:
    """Whether the picture is decoded by it: JFIF, colour profile, Adobe's colour transform."""
    profile = marker == 0xE2 and body.startswith(b"ICC_PROFILE\0")
    return profile or marker == 0xEE or (marker == 0xE0 and body.startswith((b"JFIF", b"JFXX")))


def _end_of_jpeg(content: bytes, scan: int) -> int:
    """Behind the picture's end; of a damaged file, behind all."""
    at = scan
    while True:
        found = _AFTER_SCAN.search(content, at)
        if found is None:
            return len(content)
        if content[found.start() + 1] == 0xD9:
            return found.end()
        size = int.from_bytes(content[found.end() : found.end() + 2], "big")
        at = found.end() + max(size, 2)


def _of_png(content: bytes, key: bytes) -> Cleaned:
    parts = [content[:8]]
    removed: list[str] = []
    kept: list[str] = []
    at = 8
    while at + 12 <= len(content):
        size, kind = struct.unpack(">I4s", content[at : at + 8])
        chunk = content[at : at + 12 + size]
        at += 12 + size
        if kind == b"eXIf":
            inner = _in_place(chunk[8:-4], key, [(0, size)])
            removed += inner.removed
            kept += inner.kept
            check = zlib.crc32(kind + inner.content)
            parts.append(chunk[:8] + inner.content + struct.pack(">I", check))
        elif kind in (b"tEXt", b"zTXt", b"iTXt"):
            removed.append("comment")
        else:
            parts.append(chunk)
        if kind == b"IEND":
            break
    return Cleaned(b"".join(parts), tuple(dict.fromkeys(removed)), tuple(dict.fromkeys(kept)))


def _of_boxes(content: bytes, key: bytes) -> Cleaned:
    """Of HEIF and of films: values become nothing where they stand, so that no box moves."""
    spans = [(found.start() + 6, len(content)) for found in _EXIF_ITEM.finditer(content)]
    cleaned = _without_texts(_in_place(content, key, spans), (_XMP, _FILM_PLACE))
    if content[8:12] == _CR3:
        rest = "the rest of the header" if cleaned.removed else _WHOLE_HEADER
        return replace(cleaned, kept=(rest,))
    return cleaned


def _without_texts(
    cleaned: Cleaned, patterns: tuple[tuple[re.Pattern[bytes], str], ...]
) -> Cleaned:
    """Texts become blanks where they stand."""
    changed, removed = bytearray(cleaned.content), list(cleaned.removed)
    for pattern, what in patterns:
        for found in pattern.finditer(cleaned.content):
            changed[found.start() : found.end()] = b" " * (found.end() - found.start())
            removed.append(what)
    return replace(cleaned, content=bytes(changed), removed=tuple(dict.fromkeys(removed)))
