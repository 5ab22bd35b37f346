"""HEIF: pixels as the sensor stored them, whatever the file says of how it is shown.

`blobs.hevc` is one picture, `scene()`, coded by kvazaar (BSD licence) with
`kvazaar -i blobs.yuv --input-res 128x96 -n 1 -q 12 --no-info -o blobs.hevc`; the files here are
built round it.
"""

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from limbgram.core.errors import PhotoError
from limbgram.core.geometry.arrays import ColourImage
from limbgram.reconstruction.photos import decoding
from limbgram.reconstruction.photos.decoding import load_colour, load_luma
from limbgram.reconstruction.photos.heif import HAS_HEIF
from limbgram.reconstruction.photos.reading import read_photos

Writer = Callable[..., Path]
needs_pi_heif = pytest.mark.skipif(not HAS_HEIF, reason="pi-heif, the extra `heif`, is missing")
CODED = (Path(__file__).parent / "blobs.hevc").read_bytes()


@needs_pi_heif
@pytest.mark.parametrize("anticlockwise", range(4))
@pytest.mark.parametrize("mirror_axis", [None, 0, 1])
def test_pixels_stay_as_the_sensor_stored_them(
    tmp_path: Path, write_photo: Writer, anticlockwise: int, mirror_axis: int | None
) -> None:
    write_heic(tmp_path / "1.heic", anticlockwise, mirror_axis)
    write_photo("2.jpg")
    photo = read_photos([tmp_path]).photos[0]
    assert (photo.width_px, photo.height_px) == (128, 96)
    assert np.abs(load_colour(photo).astype(float) - scene()).mean() < 3.0
    luma = scene() @ np.array([0.299, 0.587, 0.114])
    assert np.abs(load_luma(photo) - luma).mean() < 3.0
    stored = load_colour(photo)
    mirrored = stored[:, ::-1] if photo.exif.mirrored else stored
    upright = np.rot90(mirrored, -photo.exif.quarter_turns)
    np.testing.assert_array_equal(upright, as_shown(tmp_path / "1.heic"))


@needs_pi_heif
def test_exif_is_read_but_not_its_orientation(tmp_path: Path) -> None:
    """A phone writes its turn twice; counted twice, a portrait would lie on its side."""
    write_heic(tmp_path / "1.heic", 3, exif_orientation=6)
    write_heic(tmp_path / "2.heic", 0, exif_orientation=6)
    photos = read_photos([tmp_path])
    assert [photo.exif.quarter_turns for photo in photos.photos] == [1, 0]
    assert [one.label for one in photos.cameras] == ["Maker Phone 1, 5.7 mm"]
    assert photos.cameras[0].exif.focal_35mm == 26


@needs_pi_heif
def test_portrait_and_landscape_of_a_phone_are_one_camera(tmp_path: Path) -> None:
    for number, turned in enumerate((0, 1, 3)):
        write_heic(tmp_path / f"{number}.heic", turned)
    photos = read_photos([tmp_path])
    assert [photo.camera_idx for photo in photos.photos] == [0, 0, 0]


@needs_pi_heif
def test_broken_files_are_set_aside(tmp_path: Path, write_photo: Writer) -> None:
    write_photo("1.jpg", 1)
    write_photo("2.jpg", 2)
    whole = write_heic(tmp_path / "whole.heic").read_bytes()
    (tmp_path / "whole.heic").unlink()
    for kept in (12, 40, 200, 400, len(whole) - 1000):
        (tmp_path / f"cut {kept}.heic").write_bytes(whole[:kept])
    noise = np.random.default_rng(5)
    for number in range(30):
        broken = bytearray(whole)
        for place in noise.integers(12, 700, 4):
            broken[place] = noise.integers(256)
        (tmp_path / f"broken {number}.heic").write_bytes(broken)
    photos = read_photos([tmp_path])  # one that is only altered may pass
    assert {"1.jpg", "2.jpg"} <= set(photos.names)
    assert {f"cut {kept}.heic" for kept in (12, 40, 200, 400)} <= {
        one.name for one in photos.set_aside
    }


def test_without_pi_heif_the_reason_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(decoding, "HAS_HEIF", False)
    write_heic(tmp_path / "1.heic")
    write_heic(tmp_path / "2")  # without an ending
    with pytest.raises(PhotoError, match=r"pip install 'limbgram\[heif\]'") as refused:
        read_photos([tmp_path])
    assert str(refused.value).count("limbgram[heif]") == 2


def scene() -> ColourImage:
    """Soft colours without a symmetry, so that every turn and swap shows."""
    coarse = np.random.default_rng(7).integers(20, 236, (6, 8, 3), dtype=np.uint8)
    return np.asarray(Image.fromarray(coarse).resize((128, 96), Image.Resampling.BICUBIC))


def as_shown(path: Path) -> ColourImage:
    """The picture as libheif itself turns it for people."""
    import pi_heif

    return np.asarray(pi_heif.read_heif(path).to_pillow())


def write_heic(
    path: Path, anticlockwise: int = 0, mirror_axis: int | None = None, exif_orientation: int = 1
) -> Path:
    """A HEIF file as phones write it, turned for people by its properties."""
    units = [unit.rstrip(b"\0") for unit in CODED.replace(b"\0\0\0\1", b"\0\0\1").split(b"\0\0\1")]
    by_kind = {unit[0] >> 1 & 63: unit for unit in units if unit}
    heads = [by_kind[kind] for kind in (32, 33, 34)]  # parameters of video, sequence, picture
    coded = next(unit for kind, unit in by_kind.items() if kind < 32)
    sample = struct.pack(">I", len(coded)) + coded
    exif = Image.Exif()
    exif[0x010F], exif[0x0110], exif[0x0112] = "Maker", "Phone 1", exif_orientation
    exif.get_ifd(0x8769).update({0x920A: 5.7, 0xA405: 26})
    said = struct.pack(">I", 6) + exif.tobytes()
    profile = heads[1][3:15]  # as the sequence's parameters tell it
    config = b"\1" + profile + bytes.fromhex("f000fcfdf8f800000f") + bytes((3,))
    for head in heads:
        config += struct.pack(">BHH", head[0] >> 1 & 63, 1, len(head)) + head
    properties = [box(b"hvcC", config), box(b"ispe", struct.pack(">III", 0, 128, 96))]
    if anticlockwise:
        properties.append(box(b"irot", bytes((anticlockwise,))))
    if mirror_axis is not None:
        properties.append(box(b"imir", bytes((mirror_axis,))))
    numbers = bytes(range(1, len(properties) + 1))
    joined = struct.pack(">IIHB", 0, 1, 1, len(numbers)) + numbers
    listed = box(b"infe", struct.pack(">IHH4sB", 2 << 24, 1, 0, b"hvc1", 0))
    listed += box(b"infe", struct.pack(">IHH4sB", 2 << 24, 2, 0, b"Exif", 0))

    def described(first_at: int) -> bytes:
        places = b"".join(
            struct.pack(">HHHII", item, 0, 1, place, size)
            for item, place, size in (
                (1, first_at, len(sample)),
                (2, first_at + len(sample), len(said)),
            )
        )
        return box(
            b"meta",
            bytes(4)
            + box(b"hdlr", bytes(8) + b"pict" + bytes(13))
            + box(b"pitm", struct.pack(">IH", 0, 1))
            + box(b"iloc", struct.pack(">IHH", 0, 0x4400, 2) + places)
            + box(b"iinf", struct.pack(">IH", 0, 2) + listed)
            + box(b"iref", bytes(4) + box(b"cdsc", struct.pack(">HHH", 2, 1, 1)))
            + box(b"iprp", box(b"ipco", b"".join(properties)) + box(b"ipma", joined)),
        )

    kind = box(b"ftyp", b"heic" + bytes(4) + b"mif1heic")
    first_at = len(kind) + len(described(0)) + 8
    path.write_bytes(kind + described(first_at) + box(b"mdat", sample + said))
    return path


def box(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I4s", 8 + len(content), kind) + content
