"""Reading a folder: what counts as a photo, in which order, from which camera."""

import struct
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image, ImageOps

from limbgram.core.errors import OptionsError, PhotoError
from limbgram.findings import note, told
from limbgram.reconstruction.calibration.cameras import cameras_for
from limbgram.reconstruction.photos.decoding import halvings_to, load_colour, load_luma
from limbgram.reconstruction.photos.reading import PhotoOptions, read_photos

Writer = Callable[..., Path]


def test_photos_come_in_the_order_of_their_numbers(write_photo: Writer, tmp_path: Path) -> None:
    for seed, name in enumerate(("b10.jpg", "b9.png", "B8.tif", "a100.jpg")):
        write_photo(name, seed)
    assert read_photos([tmp_path]).names == ("a100.jpg", "B8.tif", "b9.png", "b10.jpg")


def test_cameras_are_told_apart_by_model_focal_length_and_size(
    write_photo: Writer, tmp_path: Path
) -> None:
    write_photo("1.jpg", 1)
    write_photo("2.jpg", 2, model="Model 2")
    write_photo("3.jpg", 3, focal_mm=35.0)
    write_photo("4.jpg", 4, size=(90, 120))
    write_photo("5.jpg", 5)
    photos = read_photos([tmp_path])
    assert [photo.camera_idx for photo in photos.photos] == [0, 1, 2, 3, 0]
    assert [camera.label for camera in photos.cameras][:3] == [
        "Maker Model 1, 50 mm",
        "Maker Model 2, 50 mm",
        "Maker Model 1, 35 mm",
    ]
    assert (photos.cameras[3].width_px, photos.cameras[3].height_px) == (90, 120)


def test_each_lens_and_zoom_of_a_phone_is_a_camera_of_its_own(
    write_photo: Writer, tmp_path: Path
) -> None:
    main = {"lens": "back camera 5.7mm f/1.5", "focal_mm": 5.7, "film_mm": 26}
    tele = {"lens": "back camera 9mm f/2.8", "focal_mm": 9.0, "film_mm": 77}
    write_photo("1 main.jpg", 1, **main)
    write_photo("2 main upright.jpg", 2, **main, orientation=6)
    write_photo("3 tele.jpg", 3, **tele)
    write_photo("4 main zoomed.jpg", 4, **{**main, "film_mm": 39}, zoom=1.5)
    write_photo("5 main zoomed, film as before.jpg", 5, **main, zoom=1.5)
    write_photo("6 main cropped.jpg", 6, **{**main, "film_mm": 39})
    write_photo("7 main no zoom.jpg", 7, **main, zoom=0.0)
    photos = read_photos([tmp_path])
    assert [photo.camera_idx for photo in photos.photos] == [0, 0, 1, 2, 3, 4, 0]
    assert "enlarged 1.5 times" in photos.cameras[2].label


def test_two_bodies_of_one_model_are_told_apart_but_not_named(
    write_photo: Writer, tmp_path: Path
) -> None:
    for number, serial in enumerate(("1234567", "7654321", "1234567", "0000000")):
        write_photo(f"{number}.jpg", number, serial=serial)
    photos = read_photos([tmp_path])
    assert [photo.camera_idx for photo in photos.photos] == [0, 1, 0, 2]
    assert photos.cameras[2].exif.body is None
    assert "1234567" not in repr(photos)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_pixels_stay_as_the_sensor_stored_them(
    write_photo: Writer, tmp_path: Path, orientation: int
) -> None:
    path = write_photo("turned.png", 1, orientation=orientation)
    write_photo("other.png", 2)
    photo = read_photos([tmp_path]).photos[1]
    stored = np.asarray(Image.open(path))
    np.testing.assert_array_equal(load_colour(photo), stored)
    mirrored = stored[:, ::-1] if photo.exif.mirrored else stored
    upright = np.rot90(mirrored, -photo.exif.quarter_turns)
    np.testing.assert_array_equal(upright, np.asarray(ImageOps.exif_transpose(Image.open(path))))


def test_a_picture_that_cannot_be_in_its_file_is_set_aside(
    write_photo: Writer, tmp_path: Path
) -> None:
    """A TIFF whose width was damaged: its decoder gives the rows that are there, and black."""
    write_photo("1.jpg", 1)
    write_photo("2.png", 2)
    path = tmp_path / "3.tif"
    grey = np.random.default_rng(3).integers(0, 2**16, (96, 100), np.uint16)
    Image.fromarray(grey).save(path)
    content = bytearray(path.read_bytes())
    entry = content.index(struct.pack("<HHII", 256, 4, 1, 100))  # the tag of its width
    content[entry + 8 : entry + 12] = (589_826).to_bytes(4, "little")
    path.write_bytes(content)
    found = read_photos([tmp_path])
    assert found.names == ("1.jpg", "2.png")
    assert "589826 x 96 pixels are not in its" in told(found.set_aside[0].reason)


@pytest.mark.parametrize("orientation", [2, 3, 5, 6, 8])
@pytest.mark.parametrize(
    ("mode", "compression"), [("RGB", None), ("RGB", "tiff_lzw"), ("L", None), ("I;16", None)]
)
def test_a_tiff_is_read_in_the_frame_of_its_sensor_as_a_png_is(
    mode: str, compression: str | None, orientation: int, tmp_path: Path
) -> None:
    grey = np.random.default_rng(7).integers(0, 200, (80, 120)).astype(np.uint8)
    grey[0, 0] = 255
    stored = grey.astype(np.uint16) << 8 if mode == "I;16" else grey
    picture = Image.fromarray(stored)
    picture = picture.convert("RGB") if mode == "RGB" else picture
    exif = Image.Exif()
    exif[0x0112] = orientation
    picture.save(tmp_path / "a.png", exif=exif)
    picture.save(tmp_path / "b.tif", exif=exif, compression=compression)
    other, photo = read_photos([tmp_path]).photos
    assert (photo.width_px, photo.height_px) == (120, 80)
    assert photo.exif == other.exif
    assert (photo.exif.quarter_turns, photo.exif.mirrored) != (0, False)
    np.testing.assert_array_equal(load_luma(photo), grey)
    np.testing.assert_array_equal(load_colour(photo)[:, :, 1], grey)


def test_luma_is_the_weighted_mean_of_the_colours(write_photo: Writer, tmp_path: Path) -> None:
    write_photo("1.jpg", 1)
    write_photo("2.png", 2)
    for photo in read_photos([tmp_path]).photos:
        weighted = load_colour(photo) @ np.array([0.299, 0.587, 0.114])
        assert np.abs(load_luma(photo) - weighted).mean() < 0.7


@pytest.mark.parametrize("halvings", [1, 2, 3])
@pytest.mark.parametrize("name", ["1.jpg", "1.png", "1.tif"])
def test_photos_are_halved_about_the_same_pixel_centres(
    name: str, halvings: int, tmp_path: Path
) -> None:
    rows, columns = np.mgrid[:203, :301]
    spot = np.exp(-((columns - 140.25) ** 2 + (rows - 90.5) ** 2) / (2 * 20.0**2))
    stored = (spot[:, :, None] * (250, 200, 120)).round()
    deep = name.endswith(".tif")
    picture = (256 * stored[:, :, ::-1]).astype(np.uint16) if deep else stored[:, :, ::-1]
    cv2.imwrite(str(tmp_path / name), picture)
    (photo,) = read_photos([tmp_path], PhotoOptions(min_photos=1)).photos
    halved = load_colour(photo, halvings).astype(float)
    part = 1 << halvings
    assert halved.shape == (-(-203 // part), -(-301 // part), 3)
    assert halved.max(axis=(0, 1)) == pytest.approx([250, 200, 120], abs=6)
    luma = load_luma(photo, halvings).astype(float)
    assert luma.shape == halved.shape[:2]
    assert luma.max() == pytest.approx(0.299 * 250 + 0.587 * 200 + 0.114 * 120, abs=6)
    for bright in (halved[:, :, 0], luma):
        weight = bright * (bright > 4)
        y, x = np.mgrid[: weight.shape[0], : weight.shape[1]]
        centre = np.array([(weight * x).sum(), (weight * y).sum()]) / weight.sum()
        np.testing.assert_allclose((centre + 0.5) * part - 0.5, (140.25, 90.5), atol=0.15)


def test_a_photo_is_halved_no_further_than_is_asked() -> None:
    assert [halvings_to(4000, width) for width in (5000, 2001, 2000, 999, 1)] == [0, 0, 1, 2, 3]


def test_the_first_picture_of_a_phone_s_double_file_is_read(
    write_photo: Writer, tmp_path: Path
) -> None:
    write_photo("1.jpg", 1)
    picture = Image.open(write_photo("2.jpg", 2))
    picture.save(tmp_path / "3.jpg", "MPO", save_all=True, append_images=[picture.rotate(180)])
    photo = read_photos([tmp_path]).photos[2]
    difference = load_colour(photo).astype(float) - np.asarray(picture)
    assert np.abs(difference).mean() < 3


def test_sixteen_bits_become_eight(write_photo: Writer, tmp_path: Path) -> None:
    ramp = np.linspace(0, 65535, 100 * 80).astype(np.uint16).reshape(80, 100)
    Image.fromarray(ramp).save(tmp_path / "deep.png")
    write_photo("other.jpg")
    photo = read_photos([tmp_path]).photos[0]
    np.testing.assert_array_equal(load_luma(photo), ramp >> 8)
    np.testing.assert_array_equal(load_colour(photo)[:, :, 2], ramp >> 8)


DEEP_FILES = {
    "grey.png": (),
    "grey.tif": (cv2.IMWRITE_TIFF_COMPRESSION, 1),
    "grey lzw.tif": (cv2.IMWRITE_TIFF_COMPRESSION, 5),
    "colour.png": (),
    "colour.tif": (cv2.IMWRITE_TIFF_COMPRESSION, 1),
    "colour lzw.tif": (cv2.IMWRITE_TIFF_COMPRESSION, 5),
    "colour zip.tif": (cv2.IMWRITE_TIFF_COMPRESSION, 8),
}


@pytest.mark.parametrize("name", DEEP_FILES)
@pytest.mark.parametrize("bits", [8, 10, 12, 14, 16])
def test_the_bits_that_a_sensor_has_become_eight(name: str, bits: int, tmp_path: Path) -> None:
    shape = (90, 120, 3) if "colour" in name else (90, 120)
    chance = np.random.default_rng(bits)
    samples = chance.integers(0, 1 << bits, shape).astype(np.uint16)
    samples[0, 0] = (1 << bits) - 1
    dark = samples >> 3  # of the same capture: less light, not fewer bits
    for number, values in enumerate((samples, dark)):
        cv2.imwrite(str(tmp_path / f"{number} {name}"), values, DEEP_FILES[name])
    photos = read_photos([tmp_path]).photos
    assert [photo.bits for photo in photos] == [bits, bits]
    for photo, values in zip(photos, (samples, dark)):
        expected = (values >> (bits - 8)).astype(np.uint8)
        colours = np.repeat(expected[:, :, None], 3, 2) if expected.ndim == 2 else expected
        np.testing.assert_array_equal(load_colour(photo), colours[:, :, ::-1])
        if expected.ndim == 2:
            np.testing.assert_array_equal(load_luma(photo), expected)
        else:
            grey = Image.fromarray(colours[:, :, ::-1]).convert("L")
            np.testing.assert_array_equal(load_luma(photo), np.asarray(grey))
    bright, shaded = (photo.brightest for photo in photos)
    assert bright > 180
    assert bright / 10 < shaded < bright / 6


def test_a_tiff_may_say_how_many_bits_it_has(tmp_path: Path) -> None:
    ramp = np.linspace(0, 900, 100 * 80).astype(np.uint16).reshape(80, 100)
    for number in range(2):
        picture = Image.fromarray(ramp + number)
        picture.save(tmp_path / f"{number}.tif", tiffinfo={281: 4095})
    photos = read_photos([tmp_path]).photos
    assert [photo.bits for photo in photos] == [12, 12]
    np.testing.assert_array_equal(load_luma(photos[0]), ramp >> 4)


def test_photos_of_eight_bits_are_as_they_are_beside_deep_ones(
    write_photo: Writer, tmp_path: Path
) -> None:
    plain = write_photo("1.png", 1)
    cv2.imwrite(str(tmp_path / "2.png"), np.full((90, 120), 4000, np.uint16))
    photos = read_photos([tmp_path]).photos
    assert [photo.bits for photo in photos] == [None, 12]
    np.testing.assert_array_equal(load_colour(photos[0]), np.asarray(Image.open(plain)))


def test_what_is_no_photo_is_set_aside_by_name(write_photo: Writer, tmp_path: Path) -> None:
    good = write_photo("good1.jpg", 1)
    write_photo("good2.jpg", 2)
    whole = good.read_bytes()
    (tmp_path / "copy.jpg").write_bytes(whole)
    (tmp_path / "cut.jpg").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "empty.jpg").write_bytes(b"")
    (tmp_path / "notes.txt").write_text("not a photo")
    (tmp_path / "live.MOV").write_bytes(b"")
    (tmp_path / "raw.dng").write_bytes(whole)
    (tmp_path / "lost.jpg").symlink_to(tmp_path / "nowhere.jpg")
    Image.new("RGB", (100, 100)).save(tmp_path / "film.gif")
    Image.new("RGB", (16, 16)).save(tmp_path / "icon.png")
    Image.new("F", (100, 100)).save(tmp_path / "float.tif")
    write_photo("large.jpg", 3, size=(500, 400))
    photos = read_photos([tmp_path], PhotoOptions(max_megapixels=0.1))
    reasons = {part.name: told(part.reason) for part in photos.set_aside}
    assert photos.names == ("copy.jpg", "good2.jpg")
    expected = {
        "good1.jpg": "the same file as copy.jpg",
        "cut.jpg": "cut off",
        "empty.jpg": "empty",
        "notes.txt": "not a picture",
        "live.MOV": "a video: name it by itself",
        "raw.dng": "raw file",
        "lost.jpg": "leads nowhere",
        "film.gif": "not a picture",
        "icon.png": "too small",
        "float.tif": "floating-point",
        "large.jpg": "more than 0.1 megapixels",
    }
    assert reasons.keys() == expected.keys()
    for name, part in expected.items():
        assert part in reasons[name], name


def test_a_picture_that_claims_to_be_huge_is_not_decoded(
    write_photo: Writer, tmp_path: Path
) -> None:
    write_photo("1.jpg", 1)
    data = bytearray(write_photo("2.png", 2).read_bytes())
    data[16:24] = (60_000).to_bytes(4, "big") * 2
    (tmp_path / "bomb.png").write_bytes(data)
    (part,) = read_photos([tmp_path]).set_aside
    assert part.name == "bomb.png"


def test_hidden_files_and_sub_folders_are_left_alone(write_photo: Writer, tmp_path: Path) -> None:
    write_photo("1.jpg", 1)
    write_photo("2.jpg", 2)
    write_photo(".hidden.jpg", 3)
    write_photo("old/3.jpg", 4)
    photos = read_photos([tmp_path])
    assert photos.names == ("1.jpg", "2.jpg")
    assert photos.set_aside == ()


def test_photos_of_one_name_in_two_folders_are_two_photos(
    write_photo: Writer, tmp_path: Path
) -> None:
    """As cameras write them that begin to count again."""
    for folder in (0, 1):
        for number in (9, 10):
            write_photo(f"10{folder}APPLE/IMG_{number}.JPG", 10 * folder + number)
    write_photo("extra/2.jpg", 3)
    sources = [tmp_path / name for name in ("101APPLE", "100APPLE", "extra")]
    photos = read_photos(sources)
    assert photos.names == (
        "2.jpg",
        "100APPLE_IMG_9.JPG",
        "100APPLE_IMG_10.JPG",
        "101APPLE_IMG_9.JPG",
        "101APPLE_IMG_10.JPG",
    )
    assert photos.set_aside == ()
    assert photos.photos[3].path == tmp_path / "101APPLE" / "IMG_9.JPG"
    (tmp_path / "101APPLE" / "IMG_11.JPG").write_bytes(b"")
    (left_out,) = read_photos(sources).set_aside
    assert left_out.name == "101APPLE_IMG_11.JPG"


def test_folders_of_one_name_are_told_apart_by_those_above_them(
    write_photo: Writer, tmp_path: Path
) -> None:
    for seed, card in enumerate(("one", "two")):
        write_photo(f"{card}/100APPLE/1.jpg", seed)
    photos = read_photos([tmp_path / "one" / "100APPLE", tmp_path / "two" / "100APPLE"])
    assert photos.names == ("one_100APPLE_1.jpg", "two_100APPLE_1.jpg")


def test_a_file_that_is_named_twice_is_one_photo(write_photo: Writer, tmp_path: Path) -> None:
    first = write_photo("a/1.jpg", 1)
    write_photo("a/2.jpg", 2)
    (tmp_path / "link").symlink_to(tmp_path / "a")
    photos = read_photos([tmp_path / "a", first, tmp_path / "link"])
    assert photos.names == ("1.jpg", "2.jpg")
    assert photos.set_aside == ()


MOMENT = "2026:03:01 10:00:07"


def test_two_files_of_one_shot_are_one_photo(write_photo: Writer, tmp_path: Path) -> None:
    for k in (1, 2):
        write_photo(f"IMG_{k}.JPG", k, size=(116, 86), taken=MOMENT)
        write_photo(f"IMG_{k}.TIF", k, taken=MOMENT, fraction="25")  # some leave out the fraction
    photos = read_photos([tmp_path])
    assert photos.names == ("IMG_1.TIF", "IMG_2.TIF")  # the larger ones
    assert len(photos.cameras) == 1
    assert [(one.name, one.reason) for one in photos.set_aside] == [
        (f"IMG_{k}.JPG", note("photo.same_shot", used=f"IMG_{k}.TIF")) for k in (1, 2)
    ]


def test_of_each_shot_the_kind_of_file_is_used_that_most_photos_are(
    write_photo: Writer, tmp_path: Path
) -> None:
    for k in (1, 2, 3):
        write_photo(f"IMG_{k}.JPG", k, size=(116, 86))
    write_photo("img_2.tif", 2)
    photos = read_photos([tmp_path])
    assert photos.names == ("IMG_1.JPG", "IMG_2.JPG", "IMG_3.JPG")
    assert [one.name for one in photos.set_aside] == ["img_2.tif"]


@pytest.mark.parametrize(
    "other",
    [
        {"taken": "2026:03:01 10:00:08", "fraction": "25"},
        {"taken": MOMENT, "fraction": "75"},
        {"model": "Model 2"},
        {"serial": "7654321"},
    ],
)
def test_files_of_one_name_that_state_another_camera_or_time_are_two_photos(
    write_photo: Writer, tmp_path: Path, other: dict[str, str]
) -> None:
    write_photo("1.jpg", 1, serial="1234567", taken=MOMENT, fraction="25")
    write_photo("1.tif", 2, **{"serial": "1234567", "taken": MOMENT, "fraction": "25"} | other)
    assert read_photos([tmp_path]).names == ("1.jpg", "1.tif")


@pytest.mark.parametrize(
    ("raw", "jpeg", "count"),
    [
        ({"serial": "1234567", "taken": MOMENT}, {"serial": "1234567", "taken": MOMENT}, 1),
        ({"taken": MOMENT}, {"taken": MOMENT}, 2),  # of two phones of one model, perhaps
        ({"serial": "1234567"}, {"serial": "1234567"}, 2),
        ({"serial": "1234567", "taken": "0000:00:00 00:00:00"}, {"serial": "1234567"}, 2),
    ],
)
def test_of_two_folders_only_the_same_camera_and_time_prove_one_shot(
    write_photo: Writer,
    tmp_path: Path,
    raw: dict[str, str],
    jpeg: dict[str, str],
    count: int,
) -> None:
    write_photo("A/IMG_1.TIF", 1, **raw)
    write_photo("B/IMG_1.JPG", 2, **jpeg)
    write_photo("B/IMG_2.JPG", 3, **jpeg)
    assert len(read_photos([tmp_path / "A", tmp_path / "B"]).photos) == count + 1
    # and so where both lie in one folder, named as a zip or a case names them
    for name in ("A/IMG_1.TIF", "B/IMG_1.JPG", "B/IMG_2.JPG"):
        (tmp_path / name).rename(tmp_path / name.replace("/", "_"))
    assert len(read_photos([tmp_path]).photos) == count + 1


def test_a_photo_keeps_its_own_mask_where_folders_share_names(
    write_photo: Writer, tmp_path: Path
) -> None:
    """The PNG of one folder is no mask of the JPEG in the other."""
    write_photo("a/1.jpg", 1)
    write_photo("b/1.png", 2)
    photos = read_photos([tmp_path / "a", tmp_path / "b"])
    assert photos.names == ("a_1.jpg", "b_1.png")
    assert [photo.mask_path for photo in photos.photos] == [None, None]


@pytest.mark.parametrize("film_mm", [26_000, 65_535, 4, 0])
def test_a_focal_length_that_no_lens_has_is_not_believed(
    write_photo: Writer, tmp_path: Path, film_mm: int
) -> None:
    """Where it is unknown, some phones write the largest number that fits, others micrometres."""
    for number in range(2):
        write_photo(f"{number}.jpg", number, film_mm=film_mm)
    (camera,) = read_photos([tmp_path]).cameras
    assert camera.exif.focal_35mm is None
    (calibration,) = cameras_for(read_photos([tmp_path]), ()).calibrations
    assert calibration.focal_35mm is None
    assert 100 < calibration.camera.fx < 200  # of photos 120 px wide


def test_nothing_is_written(write_photo: Writer, tmp_path: Path) -> None:
    for seed in range(3):
        write_photo(f"{seed}.jpg", seed, orientation=6)
    before = {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in tmp_path.iterdir()}
    for photo in read_photos([tmp_path]).photos:
        load_colour(photo)
    after = {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in tmp_path.iterdir()}
    assert after == before


def test_too_few_photos_are_refused_with_the_reasons(write_photo: Writer, tmp_path: Path) -> None:
    write_photo("1.jpg")
    (tmp_path / "broken.jpg").write_bytes(b"no")
    with pytest.raises(PhotoError, match=r"can be read in .*: 1; 2 are needed(.|\n)*broken\.jpg"):
        read_photos([tmp_path])


def test_a_path_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PhotoError, match="does not exist"):
        read_photos([tmp_path / "nowhere"])


def test_a_limit_beyond_the_decoder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OptionsError):
        read_photos([tmp_path], PhotoOptions(max_megapixels=1000))


def test_a_photo_that_changed_is_not_used(write_photo: Writer, tmp_path: Path) -> None:
    write_photo("1.jpg", 1)
    path = write_photo("2.jpg", 2)
    photo = read_photos([tmp_path]).photos[1]
    Image.new("RGB", (70, 70)).save(path)
    with pytest.raises(PhotoError, match=r"2\.jpg"):
        load_luma(photo)
    path.unlink()
    with pytest.raises(PhotoError, match=r"2\.jpg"):
        load_colour(photo)
