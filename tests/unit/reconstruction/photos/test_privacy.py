"""What is taken out of photos and films, and that the pixels stay what they were."""

import io
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from limbgram.reconstruction.photos.privacy import take_place_from_film, without_traces

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
    cleaned = without_traces(content, f".{kind.lower()}", KEY)
    for told in (b"Somebody", b"SERIAL-4711"):
        assert told in content
        assert told not in cleaned.content
    before, after = Image.open(io.BytesIO(content)), Image.open(io.BytesIO(cleaned.content))
    np.testing.assert_array_equal(np.asarray(before), np.asarray(after))
    assert dict(after.getexif().get_ifd(0x8825)) == {}
    assert float(after.getexif().get_ifd(0x8769)[0x920A]) == 35.0


def test_a_tiff_keeps_its_samples_and_loses_its_names() -> None:
    content = picture("TIFF")
    cleaned = without_traces(content, ".tif", KEY)
    assert b"Somebody" in content
    assert b"Somebody" not in cleaned.content
    assert len(cleaned.content) == len(content)
    before, after = Image.open(io.BytesIO(content)), Image.open(io.BytesIO(cleaned.content))
    np.testing.assert_array_equal(np.asarray(before), np.asarray(after))


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "TIFF"])
def test_cleaning_again_changes_nothing_but_the_pseudonym(kind: str) -> None:
    once = without_traces(picture(kind), ".x", KEY)
    again = without_traces(once.content, ".x", KEY)
    assert len(again.content) == len(once.content)
    assert "place" not in again.removed


def test_bodies_are_told_apart_only_with_the_key() -> None:
    def body(key: bytes) -> object:
        cleaned = without_traces(picture("JPEG"), ".jpg", key)
        return Image.open(io.BytesIO(cleaned.content)).getexif().get_ifd(0x8769)[0xA431]

    assert body(KEY) == body(KEY)
    assert body(KEY) != body(b"of another clinic")


def test_what_follows_a_picture_is_left_out() -> None:
    content = picture("JPEG")
    cleaned = without_traces(content + b"a film with a place", ".jpg", KEY)
    assert cleaned.content.endswith(b"\xff\xd9")
    assert "what follows the picture" in cleaned.removed


@given(cut=st.integers(0, 400), flips=st.lists(st.integers(0, 399), max_size=8))
def test_damaged_headers_are_no_fault(cut: int, flips: list[int]) -> None:
    for kind in ("JPEG", "PNG", "TIFF"):
        content = bytearray(picture(kind))
        for flip in flips:
            content[flip % len(content)] ^= 0xFF
        without_traces(bytes(content[: len(content) - cut]), ".x", KEY)


def test_a_film_loses_its_place_and_nothing_moves(tmp_path: Path) -> None:
    def box(kind: bytes, inner: bytes) -> bytes:
        return struct.pack(">I4s", 8 + len(inner), kind) + inner

    picture_data = bytes(1000) + PLACE  # looks like a place, and is the picture
    header = box(b"moov", box(b"udta", box(b"\xa9xyz", b"\0\x1a\x15\xc7" + PLACE)))
    film = tmp_path / "walk.mp4"
    film.write_bytes(box(b"ftyp", b"isom") + box(b"mdat", picture_data) + header)
    size = film.stat().st_size
    assert take_place_from_film(film) == ("place",)
    assert film.stat().st_size == size
    assert film.read_bytes().count(PLACE) == 1
    assert take_place_from_film(film) == ()
