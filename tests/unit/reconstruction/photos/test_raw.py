"""Raw files: what LibRaw develops lies where the sensor saw it, and EXIF tells the camera."""

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageOps

from limbgram.core.errors import PhotoError
from limbgram.core.geometry.arrays import ColourImage
from limbgram.reconstruction.photos import decoding, reading
from limbgram.reconstruction.photos.decoding import load_colour, load_luma
from limbgram.reconstruction.photos.raw import HAS_RAW
from limbgram.reconstruction.photos.reading import read_photos

Writer = Callable[..., Path]
needs_rawpy = pytest.mark.skipif(not HAS_RAW, reason="rawpy, the extra `raw`, is not installed")


@needs_rawpy
@pytest.mark.parametrize("orientation", [1, 3, 6, 8])
def test_a_raw_file_is_developed_in_the_sensor_s_frame(tmp_path: Path, orientation: int) -> None:
    scene = smooth_scene()
    write_dng(tmp_path / "1.dng", scene, orientation)
    write_dng(tmp_path / "2.dng", smooth_scene(5), 1)
    photos = read_photos([tmp_path])
    photo = photos.photos[0]
    assert (photo.width_px, photo.height_px) == (scene.shape[1], scene.shape[0])
    difference = load_colour(photo).astype(float) - scene
    assert np.abs(difference).mean() < 1.0  # colours between the filters are interpolated
    luma = scene @ np.array([0.299, 0.587, 0.114])
    assert np.abs(load_luma(photo) - luma).mean() < 1.0
    stored = Image.fromarray(scene)
    stored.getexif()[0x0112] = orientation
    upright = np.rot90(scene, -photo.exif.quarter_turns)
    np.testing.assert_array_equal(upright, np.asarray(ImageOps.exif_transpose(stored)))
    assert [one.label for one in photos.cameras] == ["Maker Model 1, 35 mm"]


@needs_rawpy
def test_a_raw_file_and_its_jpeg_are_one_photo(tmp_path: Path, write_photo: Writer) -> None:
    for k in (1, 2):
        write_dng(tmp_path / f"IMG_{k}.DNG", smooth_scene(k))
        write_photo(f"IMG_{k}.JPG", k, size=(316, 236), taken="2026:03:01 10:00:07")
    photos = read_photos([tmp_path])
    assert photos.names == ("IMG_1.DNG", "IMG_2.DNG")
    assert len(photos.cameras) == 1
    assert [one.name for one in photos.set_aside] == ["IMG_1.JPG", "IMG_2.JPG"]


@needs_rawpy
def test_photos_of_one_capture_are_not_brightened_each_for_itself(tmp_path: Path) -> None:
    scene = smooth_scene()
    write_dng(tmp_path / "1.dng", scene)
    write_dng(tmp_path / "2.dng", scene // 2)
    bright, dark = (load_luma(photo).mean() for photo in read_photos([tmp_path]).photos)
    assert dark == pytest.approx(bright / 2, rel=0.02)


@needs_rawpy
def test_a_cut_off_raw_file_is_set_aside(tmp_path: Path, write_photo: Writer) -> None:
    write_photo("1.jpg", 1)
    write_photo("2.jpg", 2)
    whole = write_dng(tmp_path / "3.dng", smooth_scene()).read_bytes()
    (tmp_path / "3.dng").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "4.nef").write_bytes(whole[:100])
    photos = read_photos([tmp_path])
    assert photos.names == ("1.jpg", "2.jpg")
    assert [one.name for one in photos.set_aside] == ["3.dng", "4.nef"]


def test_without_rawpy_the_reason_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (decoding, reading):
        monkeypatch.setattr(module, "HAS_RAW", False)
    write_dng(tmp_path / "1.dng", smooth_scene())
    write_dng(tmp_path / "2.nef", smooth_scene(5))
    with pytest.raises(PhotoError, match=r"pip install 'limbgram\[raw\]'"):
        read_photos([tmp_path])


def smooth_scene(seed: int = 4, rows: int = 240, columns: int = 320) -> ColourImage:
    """Soft colours without a symmetry, so that every turn and swap shows."""
    coarse = np.random.default_rng(seed).integers(20, 236, (6, 8, 3), dtype=np.uint8)
    return np.asarray(Image.fromarray(coarse).resize((columns, rows), Image.Resampling.BICUBIC))


def write_dng(path: Path, scene: ColourImage, orientation: int = 1) -> Path:
    """A raw file as a camera with filters red, green, green, blue writes it (DNG 1.4).

    Its sensor sees sRGB, so that the developed picture is the scene.
    """
    rows, columns = scene.shape[:2]
    # What the usual curve of development (BT.709) takes back.
    shown = scene / 255
    light = np.where(shown < 0.081, shown / 4.5, ((shown + 0.099) / 1.099) ** (1 / 0.45))
    mosaic = light[:, :, 1].copy()
    mosaic[0::2, 0::2], mosaic[1::2, 1::2] = light[0::2, 0::2, 0], light[1::2, 1::2, 2]
    samples = np.round(mosaic * 65535).astype("<u2").tobytes()
    srgb_of_xyz = (32406, -15372, -4986, -9689, 18758, 415, 557, -2040, 10570)
    number, byte, text, short, ratio, signed_ratio = 4, 1, 2, 3, 5, 10
    fields: list[tuple[int, int, int, bytes]] = [
        (254, number, 1, _number(0)),  # the main picture
        (256, number, 1, _number(columns)),
        (257, number, 1, _number(rows)),
        (258, short, 1, _number(16)),  # bits
        (259, short, 1, _number(1)),  # not packed
        (262, short, 1, _number(32803)),  # a mosaic of filters
        (271, text, 6, b"Maker\0"),
        (272, text, 8, b"Model 1\0"),
        (273, number, 1, b""),  # where the samples lie: put in below
        (274, short, 1, _number(orientation)),
        (277, short, 1, _number(1)),
        (278, number, 1, _number(rows)),
        (279, number, 1, _number(len(samples))),
        (33421, short, 2, struct.pack("<2H", 2, 2)),
        (33422, byte, 4, bytes((0, 1, 1, 2))),
        (34665, number, 1, b""),  # where EXIF lies
        (50706, byte, 4, bytes((1, 4, 0, 0))),
        (50708, text, 14, b"Maker Model 1\0"),
        (50717, number, 1, _number(65535)),  # white
        (50721, signed_ratio, 9, b"".join(struct.pack("<2i", one, 10000) for one in srgb_of_xyz)),
        (50728, ratio, 3, struct.pack("<6I", 1, 1, 1, 1, 1, 1)),
        (50778, short, 1, _number(21)),  # daylight
    ]
    exif_at = 8 + 2 + 12 * len(fields) + 4
    exif = struct.pack("<HHHIII2I", 1, 0x920A, ratio, 1, exif_at + 18, 0, 35, 1)  # 35 mm
    behind_at = exif_at + len(exif)
    behind = b"".join(value for *_, value in fields if len(value) > 4)
    put_in = {273: _number(behind_at + len(behind)), 34665: _number(exif_at)}
    listed = b""
    for tag, kind, count, value in fields:
        if len(value) > 4:
            value, behind_at = _number(behind_at), behind_at + len(value)
        listed += struct.pack("<HHI", tag, kind, count) + put_in.get(tag, value).ljust(4, b"\0")
    head = b"II*\0" + _number(8) + struct.pack("<H", len(fields))
    path.write_bytes(head + listed + _number(0) + exif + behind + samples)
    return path


def _number(value: int) -> bytes:
    return struct.pack("<I", value)


def test_a_raw_file_that_may_not_be_read_is_not_called_broken() -> None:
    assert decoding.decoding_fault(Path("1.nef"), PermissionError()).code == "photo.file.forbidden"
