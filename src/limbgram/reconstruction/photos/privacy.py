"""Privacy: removes place, names and serial numbers from a photo's header.

In      the bytes of a JPEG, PNG, TIFF, raw or HEIF file, or of a film.
Out     bytes of the same picture to the last sample, and what was taken out of its header.
Method  Only headers are rewritten. EXIF tags are removed from their IFDs (image file directories)
        and their values set to zero in place, so that nothing else moves; serial numbers become a
        keyed hash of the same length, so that a camera's calibration still recognises the body and
        nobody else does. Segments and chunks of a JPEG and a PNG with comments, XMP and IPTC are
        removed, and what follows a JPEG's end (moving pictures, second pictures with headers of
        their own). A raw file keeps its maker's note, because the decoder needs it; the result says
        so. Raw files of Olympus and Panasonic are TIFF files with magic numbers of their own.
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

from limbgram.reconstruction.photos.raw import RAW_SUFFIXES, TIFF_MAGIC

_EXIF_IFD, _INTEROPERABILITY_IFD, _SUB_IFDS, _GPS_IFD = 0x8769, 0xA005, 0x014A, 0x8825
_SERIAL_TAGS = {
    0xA431: "serial number",
    0xA435: "serial number of the lens",
    0xC62F: "serial number",
}
_MAKER_NOTE_TAGS = {0x927C: "maker's note", 0xC634: "maker's note"}
_PERSONAL_TAGS = {
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
"""Bytes of a video's header that are read at most."""
_MOST_IFDS = 64
_MOST_TAGS = 4096
_WHOLE_HEADER = "the whole header"
"""Reported as kept for a file whose header is not known here."""
_RAW_MAGIC = (b"IIRO", b"IIRS", b"MMOR", b"IIU\0")
"""First bytes of ORF (Olympus) and RW2 (Panasonic), which are TIFF files otherwise."""
_LARGEST_SEGMENT = 65_533
"""Bytes of one part of a JPEG's header."""
_JPEG_MARKER = re.compile(rb"\xff[^\x00\xd0-\xd7\xff]")
"""A marker in or after the compressed data of a JPEG."""
_EXIF_HEADER = re.compile(rb"Exif\x00\x00(?:II\*\x00|MM\x00\*)")
_XMP_PACKET = re.compile(rb"<x:xmpmeta.*?</x:xmpmeta>", re.DOTALL)
_XMP = (_XMP_PACKET, "XMP")
_ISO_6709 = re.compile(rb"[+-]\d{2,}\.\d+[+-]\d{2,3}\.\d+(?:[+-]\d+(?:\.\d+)?)?/")
"""A location as videos carry it (ISO 6709)."""
_VIDEO_LOCATION = (_ISO_6709, "place")
_CR3_BRAND = b"crx "
"""Brand of Canon's raw files, whose header lies in boxes that are not known here."""


@dataclass(frozen=True)
class Cleaned:
    """A file's bytes, and what was removed from its header."""

    content: bytes
    removed: tuple[str, ...]
    kept: tuple[str, ...] = ()
    """What had to stay though it may identify the camera."""


@dataclass
class _Header:
    """A TIFF structure whose bytes are changed in place."""

    content: bytearray
    base: int
    end: int
    key: bytes
    raw: bool
    removed: list[str] = field(default_factory=list[str])
    kept: list[str] = field(default_factory=list[str])
    byte_order: str = ""
    """Byte order as `struct` writes it; empty before it is read."""

    def clean(self) -> None:
        order = bytes(self.content[self.base : self.base + 2])
        self.byte_order = {b"II": "<", b"MM": ">"}.get(order, "")
        first = self._uint(self.base + 4, 4) if self.byte_order else 0
        if not self._has_ifd(self.base + first):
            self.kept.append(_WHOLE_HEADER)
            return
        pending = [first]
        seen: set[int] = set()
        while pending and len(seen) < _MOST_IFDS:
            offset = pending.pop()
            if offset and offset not in seen:
                seen.add(offset)
                pending += self._clean_ifd(self.base + offset)

    def _clean_ifd(self, start: int) -> list[int]:
        """Remove personal tags from an IFD; returns the offsets of the IFDs below and after it."""
        if not self._has_ifd(start):
            return []
        count = self._uint(start, 2)
        further: list[int] = []
        kept: list[bytes] = []
        for entry_idx in range(count):
            entry = start + 2 + 12 * entry_idx
            tag = self._uint(entry, 2)
            where, size = self._value_span(entry)
            if tag in (_EXIF_IFD, _INTEROPERABILITY_IFD, _SUB_IFDS):
                further += [self._uint(at, 4) for at in range(where, where + size - 3, 4)]
            if tag == _GPS_IFD:
                self.removed.append("place")
                self._zero_ifd(self.base + self._uint(entry + 8, 4))
                continue
            if tag in _PERSONAL_TAGS or (tag in _MAKER_NOTE_TAGS and not self.raw):
                self.removed.append({**_PERSONAL_TAGS, **_MAKER_NOTE_TAGS}[tag])
                self.content[where : where + size] = bytes(size)
                continue
            if tag in _MAKER_NOTE_TAGS:
                self.kept.append(_MAKER_NOTE_TAGS[tag])
            if tag in _SERIAL_TAGS and size > 1:
                self.removed.append(_SERIAL_TAGS[tag])
                self.content[where : where + size] = self._keyed_hash(where, size)
            kept.append(bytes(self.content[entry : entry + 12]))
        end = start + 2 + 12 * count
        following = bytes(self.content[end : end + 4]) if end + 4 <= self.end else b""
        ifd = struct.pack(f"{self.byte_order}H", len(kept)) + b"".join(kept) + following
        ifd_bytes = 2 + 12 * count + len(following)
        self.content[start : start + ifd_bytes] = ifd.ljust(ifd_bytes, b"\0")
        if len(following) == 4:
            further.append(struct.unpack(f"{self.byte_order}I", following)[0])
        return further

    def _zero_ifd(self, start: int) -> None:
        """Set an IFD and all its values to zero."""
        if not self._has_ifd(start):
            return
        count = self._uint(start, 2)
        for entry_idx in range(count):
            where, size = self._value_span(start + 2 + 12 * entry_idx)
            self.content[where : where + size] = bytes(size)
        self.content[start : start + 2 + 12 * count] = bytes(2 + 12 * count)

    def _has_ifd(self, start: int) -> bool:
        """Whether a whole IFD can lie there."""
        if not self.base < start <= self.end - 2:
            return False
        count = self._uint(start, 2)
        return count <= _MOST_TAGS and start + 2 + 12 * count <= self.end

    def _value_span(self, entry: int) -> tuple[int, int]:
        """Position and size of a tag's value; size 0 where it lies outside."""
        size = _BYTES_OF_TYPE.get(self._uint(entry + 2, 2), 0) * self._uint(entry + 4, 4)
        where = entry + 8 if size <= 4 else self.base + self._uint(entry + 8, 4)
        return (where, size) if where + size <= self.end else (entry + 8, 0)

    def _keyed_hash(self, where: int, size: int) -> bytes:
        """Keyed hash of a serial number, of the same length."""
        value = bytes(self.content[where : where + size]).rstrip(b"\0 ")
        letters = hmac.new(self.key, value, hashlib.sha256).hexdigest().encode()
        return (letters * (size // len(letters) + 1))[: size - 1] + b"\0"

    def _uint(self, at: int, size: int) -> int:
        order = "little" if self.byte_order == "<" else "big"
        return int.from_bytes(self.content[at : at + size], order)


def without_personal_data(content: bytes, suffix: str, key: bytes) -> Cleaned:
    """A photo's file without data that identify place, person or camera body.

    Args:
        suffix: Of the file's name, in lower case: raw files look like other TIFF files.
        key: Secret of whoever keeps the photos, for the hash of serial numbers.
    """
    if content.startswith(b"\xff\xd8\xff"):
        return _clean_jpeg(content, key)
    if content.startswith(b"\x89PNG\r\n\x1a\n"):
        return _clean_png(content, key)
    if content[:4] in _RAW_MAGIC or (content[:4] in TIFF_MAGIC and suffix in RAW_SUFFIXES):
        return _clean_raw(content, key)
    if content[:4] in TIFF_MAGIC:
        return _clean_headers(content, key, [(0, len(content))])
    if content[4:8] == b"ftyp":
        return _clean_boxes(content, key)
    return Cleaned(content, (), (_WHOLE_HEADER,))


def remove_video_location(path: Path) -> tuple[str, ...]:
    """Blank the location in a video's header (MP4, MOV) in place; returns what was removed.

    Only the header is read: a video may be larger than memory. Metadata tracks of some cameras are
    not known here, and stay.
    """
    removed: list[str] = []
    with path.open("r+b") as video:
        end = video.seek(0, 2)
        offset = 0
        while offset + 8 <= end:
            video.seek(offset)
            size, kind = struct.unpack(">I4s", video.read(8))
            box_bytes = int.from_bytes(video.read(8), "big") if size == 1 else size or end - offset
            if box_bytes < 8:
                break
            if kind == b"moov" and box_bytes <= _LARGEST_HEADER:
                video.seek(offset)
                content = video.read(box_bytes)
                for found in _ISO_6709.finditer(content):
                    video.seek(offset + found.start())
                    video.write(b" " * (found.end() - found.start()))
                    removed.append("place")
            offset += box_bytes
    return tuple(dict.fromkeys(removed))


def _clean_headers(
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


def _clean_raw(content: bytes, key: bytes) -> Cleaned:
    """A raw file without personal data, also in the headers of the pictures it holds."""
    spans = [(0, len(content))]
    for found in _EXIF_HEADER.finditer(content):
        base = found.start() + 6
        spans.append((base, min(len(content), base + _LARGEST_SEGMENT)))
    cleaned = _clean_headers(content, key, spans, raw=True)
    return _blanked(cleaned, (_XMP,))


def _clean_jpeg(content: bytes, key: bytes) -> Cleaned:
    parts: list[bytes] = [content[:2]]
    removed: list[str] = []
    kept: list[str] = []
    offset = 2
    while offset + 4 <= len(content) and content[offset] == 0xFF:
        marker = content[offset + 1]
        if marker == 0xFF:  # a filler
            offset += 1
            continue
        size = int.from_bytes(content[offset + 2 : offset + 4], "big")
        segment = content[offset : offset + 2 + size]
        if marker == 0xDA or size < 2 or len(segment) < 2 + size:
            break
        offset += 2 + size
        body = segment[4:]
        if marker == 0xE1 and body.startswith(b"Exif\0\0"):
            inner = _clean_headers(body, key, [(6, len(body))])
            removed += inner.removed
            kept += inner.kept
            parts.append(segment[:4] + inner.content)
        elif marker == 0xFE or (0xE0 <= marker <= 0xEF and not _needed_for_decoding(marker, body)):
            removed.append("XMP" if body.startswith(b"http") else "other header")
        else:
            parts.append(segment)
    end = _end_of_jpeg(content, offset)
    if end < len(content):
        removed.append("what follows the picture")
    parts.append(content[offset:end])
    return Cleaned(b"".join(parts), tuple(dict.fromkeys(removed)), tuple(dict.fromkeys(kept)))


def _needed_for_decoding(marker: int, body: bytes) -> bool:
    """Whether decoding needs a segment: JFIF, colour profile, Adobe's colour transform."""
    profile = marker == 0xE2 and body.startswith(b"ICC_PROFILE\0")
    return profile or marker == 0xEE or (marker == 0xE0 and body.startswith((b"JFIF", b"JFXX")))


def _end_of_jpeg(content: bytes, scan: int) -> int:
    """Position after the picture's end; in a damaged file, after all bytes."""
    offset = scan
    while True:
        found = _JPEG_MARKER.search(content, offset)
        if found is None:
            return len(content)
        if content[found.start() + 1] == 0xD9:
            return found.end()
        size = int.from_bytes(content[found.end() : found.end() + 2], "big")
        offset = found.end() + max(size, 2)


def _clean_png(content: bytes, key: bytes) -> Cleaned:
    parts = [content[:8]]
    removed: list[str] = []
    kept: list[str] = []
    offset = 8
    while offset + 12 <= len(content):
        size, kind = struct.unpack(">I4s", content[offset : offset + 8])
        chunk = content[offset : offset + 12 + size]
        offset += 12 + size
        if kind == b"eXIf":
            inner = _clean_headers(chunk[8:-4], key, [(0, size)])
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


def _clean_boxes(content: bytes, key: bytes) -> Cleaned:
    """HEIF and video files without personal data; values are blanked in place, so no box moves."""
    spans = [(found.start() + 6, len(content)) for found in _EXIF_HEADER.finditer(content)]
    cleaned = _blanked(_clean_headers(content, key, spans), (_XMP, _VIDEO_LOCATION))
    if content[8:12] == _CR3_BRAND:
        rest = "the rest of the header" if cleaned.removed else _WHOLE_HEADER
        return replace(cleaned, kept=(rest,))
    return cleaned


def _blanked(cleaned: Cleaned, patterns: tuple[tuple[re.Pattern[bytes], str], ...]) -> Cleaned:
    """The file with all matches of the patterns replaced by blanks."""
    changed, removed = bytearray(cleaned.content), list(cleaned.removed)
    for pattern, what in patterns:
        for found in pattern.finditer(cleaned.content):
            changed[found.start() : found.end()] = b" " * (found.end() - found.start())
            removed.append(what)
    return replace(cleaned, content=bytes(changed), removed=tuple(dict.fromkeys(removed)))
