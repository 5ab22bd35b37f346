"""Whatever lies among the photos, the photos are read and the rest is set aside by name."""

import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from limbgram.findings import told
from limbgram.reconstruction.photos.decoding import load_colour, load_luma
from limbgram.reconstruction.photos.reading import read_photos


def encoded(kind: str, seed: int) -> bytes:
    coarse = np.random.default_rng(seed).integers(0, 256, (8, 10, 3), dtype=np.uint8)
    stream = io.BytesIO()
    Image.fromarray(coarse).resize((160, 120), Image.Resampling.BICUBIC).save(stream, kind)
    return stream.getvalue()


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    """Five good photos."""
    for index in range(5):
        (tmp_path / f"good{index}.jpg").write_bytes(encoded("JPEG", index))
    return tmp_path


def test_thirty_files_of_noise_truncation_and_wrong_types_are_set_aside(capture: Path) -> None:
    rng = np.random.default_rng(1)
    bad: set[str] = set()
    for index in range(30):
        suffix = ("jpg", "png", "tif", "heic", "txt")[index % 5]
        name = f"good{index % 5}_{index}.{suffix}"
        whole = encoded(("JPEG", "PNG", "TIFF", "GIF", "BMP")[index // 6], 100 + index)
        content = (
            rng.bytes(5000),
            whole[: len(whole) * (1 + index % 4) // 6],
            encoded(("GIF", "BMP", "WEBP")[index % 3], 200 + index),
        )[index % 3]
        (capture / name).write_bytes(content)
        bad.add(name)
    photos = read_photos([capture])
    assert photos.names == tuple(f"good{index}.jpg" for index in range(5))
    assert {part.name for part in photos.set_aside} == bad
    assert all(len(told(part.reason)) > 10 for part in photos.set_aside)


@settings(
    max_examples=60,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(
    kind=st.sampled_from(["JPEG", "PNG", "TIFF"]),
    flips=st.lists(st.tuples(st.integers(0, 10_000), st.integers(0, 255)), max_size=20),
    length=st.floats(0, 1),
)
def test_a_damaged_picture_is_either_used_or_set_aside(
    capture: Path, kind: str, flips: list[tuple[int, int]], length: float
) -> None:
    data = bytearray(encoded(kind, 50))
    for place, value in flips:
        data[place % len(data)] = value
    name = "odd.png"
    (capture / name).write_bytes(data[: round(len(data) * length)])
    photos = read_photos([capture])
    aside = [part.name for part in photos.set_aside]
    assert (name in photos.names) != (name in aside)
    assert len(photos.names) + len(aside) == 6
    for photo in photos.photos:
        if photo.name == name:
            assert load_luma(photo).shape == load_colour(photo).shape[:2]
