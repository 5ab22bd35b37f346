"""What is taken out of photos and films, and that the pixels stay what they were."""

import io
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from limbgram.reconstruction.photos.privacy import remove_video_location, without_personal_data

KEY = b"a secret"
PLACE = b"+48.1371+011.5754+519.000/"


def picture(kind: str) -> bytes:
    exif = Image.Exif()
    exif[0x013B] = "Somebody"
    exif.get_ifd(0x8769).update({0xA431: "SERIAL-4711", 0x920A: 35.0})
    exif.get_ifd(0x8825).update({1: "N", 2: (48.0, 8.0, 14.2)})
    made = io.BytesIO()
    pixels = np.random.default_rng(1).integers(0, 255, (30, 40, 3), np.uint8)
    Image.fromarray(pixels).save(made, kind, exif=exif)
    return made.getvalue()


@pytest.mark.parametrize("kind", ["JPEG", "PNG"])
def test_the_picture_stays_and_the_person_goes(kind: str) -> None:
    content = picture(kind)
    cleaned = without_personal_data(content, f".{kind.lower()}", KEY)
    for told in (b"Somebody", b"SERIAL-4711"):
        assert told in content
        assert told not in cleaned.content
    before, after = Image.open(io.BytesIO(content)), Image.open(io.BytesIO(cleaned.content))
    np.testing.assert_array_equal(np.asarray(before), np.asarray(after))
    assert dict(after.getexif().get_ifd(0x8825)) == {}
    assert float(after.getexif().get_ifd(0x8769)[0x920A]) == 35.0


def test_a_tiff_keeps_its_samples_and_loses_its_names() -> None:
    content = picture("TIFF")
    cleaned = without_personal_data(content, ".tif", KEY)
    assert b"Somebody" in content
    assert b"Somebody" not in cleaned.content
    assert len(cleaned.content) == len(content)
    before, after = Image.open(io.BytesIO(content)), Image.open(io.BytesIO(cleaned.content))
    np.testing.assert_array_equal(np.asarray(before), np.asarray(after))


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "TIFF"])
def test_cleaning_again_changes_nothing_but_the_pseudonym(kind: str) -> None:
    once = without_personal_data(picture(kind), ".x", KEY)
    again = without_personal_data(once.content, ".x", KEY)
    assert len(again.content) == len(once.content)
    assert "place" not in again.removed


def test_bodies_are_told_apart_only_with_the_key() -> None:
    def body(key: bytes) -> object:
        cleaned = without_personal_data(picture("JPEG"), ".jpg", key)
        return Image.open(io.BytesIO(cleaned.content)).getexif().get_ifd(0x8769)[0xA431]

    assert body(KEY) == body(KEY)
    assert body(KEY) != body(b"of another clinic")


def test_what_follows_a_picture_is_left_out() -> None:
    content = picture("JPEG")
    cleaned = without_personal_data(content + b"a film with a place", ".jpg", KEY)
    assert cleaned.content.endswith(b"\xff\xd9")
    assert "what follows the picture" in cleaned.removed


@given(cut=st.integers(0, 400), flips=st.lists(st.integers(0, 399), max_size=8))
def test_damaged_headers_are_no_fault(cut: int, flips: list[int]) -> None:
    for kind in ("JPEG", "PNG", "TIFF"):
        content = bytearray(picture(kind))
        for flip in flips:
            content[flip % len(content)] ^= 0xFF
        without_personal_data(bytes(content[: len(content) - cut]), ".x", KEY)


def test_a_film_loses_its_place_and_nothing_moves(tmp_path: Path) -> None:
    def box(kind: bytes, inner: bytes) -> bytes:
        return struct.pack(">I4s", 8 + len(inner), kind) + inner

    picture_data = bytes(1000) + PLACE  # looks like a place, and is the picture
    header = box(b"moov", box(b"udta", box(b"\xa9xyz", b"\0\x1a\x15\xc7" + PLACE)))
    film = tmp_path / "walk.mp4"
    film.write_bytes(box(b"ftyp", b"isom") + box(b"mdat", picture_data) + header)
    size = film.stat().st_size
    assert remove_video_location(film) == ("place",)
    assert film.stat().st_size == size
    assert film.read_bytes().count(PLACE) == 1
    assert remove_video_location(film) == ()


def raw_like(first: bytes, inside: bytes = b"") -> bytes:
    """A header of TIFF's structure under other first bytes, and what else lies in the file."""
    exif = Image.Exif()
    exif[0x013B] = "Somebody"
    exif.get_ifd(0x8769).update({0xA431: "SERIAL-4711", 0x920A: 35.0})
    exif.get_ifd(0x8825).update({1: "N", 2: (48.0, 8.0, 14.2)})
    exif.endian = "<" if first.startswith(b"II") else ">"
    header = exif.tobytes().removeprefix(b"Exif\0\0")
    assert header.startswith((b"II*\0", b"MM\0*"))
    return first + header[4:] + bytes(100) + inside


@pytest.mark.parametrize(
    ("first", "suffix"),
    [
        (b"IIRO", ".orf"),
        (b"IIRS", ".orf"),
        (b"MMOR", ".orf"),
        (b"IIU\0", ".rw2"),
        (b"IIU\0", ".jpg"),
    ],
)
def test_raw_files_that_are_tiff_by_another_number_are_cleaned(first: bytes, suffix: str) -> None:
    content = raw_like(first)
    cleaned = without_personal_data(content, suffix, KEY)
    assert cleaned.content[:4] == first
    assert len(cleaned.content) == len(content)
    degrees = struct.pack("<II" if first.startswith(b"II") else ">II", 48, 1)
    for told in (b"Somebody", b"SERIAL-4711", degrees):
        assert told in content
        assert told not in cleaned.content
    assert {"photographer", "serial number", "place"} <= set(cleaned.removed)
    assert "the whole header" not in cleaned.kept


def test_a_picture_within_a_raw_file_loses_its_header_too() -> None:
    inside = picture("JPEG") + b"<x:xmpmeta>Somebody</x:xmpmeta>"
    content = raw_like(b"IIU\0", inside)
    cleaned = without_personal_data(content, ".rw2", KEY)
    assert b"Somebody" not in cleaned.content
    assert b"SERIAL-4711" not in cleaned.content
    at = len(content) - len(inside)
    before = Image.open(io.BytesIO(picture("JPEG")))
    after = Image.open(io.BytesIO(cleaned.content[at : at + len(picture("JPEG"))]))
    np.testing.assert_array_equal(np.asarray(before), np.asarray(after))


@pytest.mark.parametrize(
    ("first", "suffix"),
    [
        (b"FUJIFILMCCD-RAW 0201", ".raf"),
        (struct.pack(">I", 24) + b"ftypcrx \0\0\0\1crx isom", ".cr3"),
        (b"II+\0\x08\0\0\0", ".tif"),
        (b"MM\0+\0\x08\0\0", ".tif"),
        (b"an unknown camera", ".raw"),
        (b"II*\0\xff\xff\xff\xff", ".dng"),
        (b"II*\0\xff\xff\xff\xff", ".tif"),
    ],
)
def test_a_header_that_cannot_be_cleaned_is_told(first: bytes, suffix: str) -> None:
    content = first + b"CMT1CMT2CMT3CMT4" + picture("TIFF")
    cleaned = without_personal_data(content, suffix, KEY)
    assert cleaned.content == content
    assert (cleaned.removed, cleaned.kept) == ((), ("the whole header",))


def test_what_is_known_of_a_header_goes_and_the_rest_is_told() -> None:
    content = struct.pack(">I", 16) + b"ftypcrx \0\0\0\1" + b"<x:xmpmeta>Somebody</x:xmpmeta>CMT4"
    cleaned = without_personal_data(content, ".cr3", KEY)
    assert b"Somebody" not in cleaned.content
    assert (cleaned.removed, cleaned.kept) == (("XMP",), ("the rest of the header",))


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "TIFF"])
def test_nothing_is_told_to_stay_of_a_header_that_was_cleaned(kind: str) -> None:
    assert without_personal_data(picture(kind), ".x", KEY).kept == ()
