"""Masks: found by name, checked, and brought to the sensor's frame."""

from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageOps

from limbgram.core.errors import PhotoError
from limbgram.findings import note, told
from limbgram.reconstruction.photos.masks import load_mask, mask_as_png, mask_notes, upright
from limbgram.reconstruction.photos.quality import remarks
from limbgram.reconstruction.photos.reading import read_photos, with_masks_in

Writer = Callable[..., Path]


def corner_mask(width_px: int, height_px: int) -> np.ndarray:
    """White in the top left quarter of the width and half of the height."""
    mask = np.zeros((height_px, width_px), np.uint8)
    mask[: height_px // 2, : width_px // 4] = 255
    return mask


def as_people_see(mask: np.ndarray, orientation: int) -> np.ndarray:
    """Turned by Pillow as EXIF's orientation says."""
    stored = Image.fromarray(mask)
    stored.getexif()[0x0112] = orientation
    return np.asarray(ImageOps.exif_transpose(stored))


@pytest.mark.parametrize("place", ["1.png", "1.jpg.png", "1.PNG", "masks/1.png", "masks/1.jpg.png"])
def test_a_mask_is_found_and_is_no_photo(write_photo: Writer, tmp_path: Path, place: str) -> None:
    write_photo("1.jpg", 1)
    write_photo("2.jpg", 2)
    (tmp_path / "masks").mkdir()
    Image.fromarray(corner_mask(120, 90)).save(tmp_path / place)
    photos = read_photos([tmp_path])
    assert photos.names == ("1.jpg", "2.jpg")
    np.testing.assert_array_equal(load_mask(photos.photos[0]), corner_mask(120, 90) > 0)
    assert load_mask(photos.photos[1]) is None


def test_png_photos_have_masks_too(write_photo: Writer, tmp_path: Path) -> None:
    write_photo("1.png", 1)
    write_photo("2.png", 2)
    (tmp_path / "masks").mkdir()
    Image.fromarray(corner_mask(120, 90)).save(tmp_path / "masks" / "2.png")
    photos = read_photos([tmp_path])
    assert [photo.mask_path is None for photo in photos.photos] == [True, False]


@pytest.mark.parametrize("orientation", [5, 6, 7, 8])
def test_a_mask_drawn_upright_is_turned_back(
    write_photo: Writer, tmp_path: Path, orientation: int
) -> None:
    write_photo("1.jpg", 1, orientation=orientation)
    write_photo("2.jpg", 2)
    upright = as_people_see(corner_mask(120, 90), orientation)
    assert upright.shape == (120, 90)
    Image.fromarray(upright).save(tmp_path / "1.png")
    photo = read_photos([tmp_path]).photos[0]
    mask = load_mask(photo)
    np.testing.assert_array_equal(mask, corner_mask(120, 90) > 0)
    written = Image.open(BytesIO(mask_as_png(corner_mask(120, 90) > 0, photo.exif)))
    np.testing.assert_array_equal(np.asarray(written), upright)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("size_px", [(120, 90), (90, 90)])
def test_the_orientation_in_a_mask_s_header_tells_how_it_lies(
    write_photo: Writer, tmp_path: Path, orientation: int, size_px: tuple[int, int]
) -> None:
    """Drawn on the photo as stored, whose orientation it keeps, or as seen, which is upright."""
    stored = corner_mask(*size_px)
    header = Image.Exif()
    for k, (pixels, own) in enumerate(
        [(stored, orientation), (as_people_see(stored, orientation), 1)], 1
    ):
        write_photo(f"{k}.jpg", k, size_px, orientation=orientation)
        header[0x0112] = own
        Image.fromarray(pixels).save(tmp_path / f"{k}.png", exif=header)
    photos = read_photos([tmp_path])
    for photo in photos.photos:
        np.testing.assert_array_equal(load_mask(photo), stored > 0)
    assert mask_notes(photos) == (note("photo.mask.all", photos=2),)


@pytest.mark.parametrize(
    ("orientation", "size_px", "told"),
    [(1, (120, 90), True), (6, (120, 90), True), (6, (90, 90), False)]
    + [(k, (120, 90), False) for k in (2, 3, 4)],
)
def test_a_mask_is_named_that_may_lie_either_way(
    write_photo: Writer, tmp_path: Path, orientation: int, size_px: tuple[int, int], told: bool
) -> None:
    for k in (1, 2, 3):
        write_photo(f"{k}.jpg", k, size_px, orientation=orientation)
    seen = as_people_see(corner_mask(*size_px), orientation)
    Image.fromarray(seen).save(tmp_path / "1.png")
    same = np.full_like(seen, 255)
    same[10:-10, 10:-10] = 0  # the same turned and mirrored
    Image.fromarray(same).save(tmp_path / "2.png")
    exif = read_photos([tmp_path]).photos[2].exif
    (tmp_path / "3.png").write_bytes(mask_as_png(corner_mask(*size_px) > 0, exif))
    photos = read_photos([tmp_path])
    np.testing.assert_array_equal(load_mask(photos.photos[2]), corner_mask(*size_px) > 0)
    doubts = [one for one in mask_notes(photos) if one.code == "photo.mask.as_stored"]
    assert [one.values["names"] for one in doubts] == ([] if told else [("1.jpg",)])
    masks = tmp_path / "elsewhere"
    masks.mkdir()
    assert all(one.mask_told for one in with_masks_in(photos, masks).photos)
    (tmp_path / "1.png").rename(masks / "1.png")
    assert [one.mask_told for one in with_masks_in(photos, masks).photos] == [told, True, True]


def cut_out(tmp_path: Path, name: str, seed: int, ground: int = 255) -> np.ndarray:
    """A photo on transparent ground, of which a fifth is left; its opacity."""
    coarse = np.random.default_rng(seed).integers(60, 180, (9, 12, 3), dtype=np.uint8)
    pixels = np.asarray(Image.fromarray(coarse).resize((400, 300), Image.Resampling.BICUBIC))
    opacity = np.zeros((300, 400), np.uint8)
    opacity[60:260, 100:220] = 255
    opacity[59, 100:220] = 100  # a soft edge, more transparent than not
    pixels = np.where(opacity[:, :, None] == 0, ground, pixels).astype(np.uint8)
    Image.fromarray(np.dstack([pixels, opacity])).save(tmp_path / name)
    return opacity


@pytest.mark.parametrize("ground", [0, 255])
def test_a_photo_that_was_cut_out_is_a_mask_of_itself(tmp_path: Path, ground: int) -> None:
    """And its exposure and its edges are those of what is left."""
    opacities = [cut_out(tmp_path, f"{number}.png", number, ground) for number in range(3)]
    photos = read_photos([tmp_path])
    assert photos.set_aside == ()
    assert mask_notes(photos) == (note("photo.mask.all", photos=3),)
    for photo, opacity in zip(photos.photos, opacities, strict=True):
        mask = load_mask(photo)
        assert mask is not None
        np.testing.assert_array_equal(mask, opacity > 127)
        assert photo.burnt == 0.0
        assert 120 < photo.brightest < 200
        # the cut is sharper than anything of the photo, and counts for no edge
        assert not photo.sharpness < 3.0
    assert not [one for one in remarks(photos) if "exposed" in one.finding.code]


def test_a_mask_beside_a_cut_out_hides_more_of_it(tmp_path: Path) -> None:
    opacity = cut_out(tmp_path, "1.png", 1)
    cut_out(tmp_path, "2.png", 2)
    drawn = np.zeros((300, 400), np.uint8)
    drawn[100:, :] = 255
    Image.fromarray(drawn).save(tmp_path / "1.png.png")
    mask = load_mask(read_photos([tmp_path]).photos[0])
    assert mask is not None
    np.testing.assert_array_equal(mask, (opacity > 127) & (drawn > 0))


def test_a_photo_that_is_transparent_everywhere_is_set_aside(tmp_path: Path) -> None:
    for number in range(3):
        cut_out(tmp_path, f"{number}.png", number)
    Image.fromarray(np.zeros((300, 400, 4), np.uint8)).save(tmp_path / "nothing.png")
    (part,) = read_photos([tmp_path]).set_aside
    assert part.name == "nothing.png"
    assert "transparent everywhere" in told(part.reason)


def test_a_cut_out_counts_by_its_opacity(write_photo: Writer, tmp_path: Path) -> None:
    write_photo("1.jpg", 1)
    write_photo("2.jpg", 2)
    layers = np.full((90, 120, 4), 30, np.uint8)
    layers[:, :, 3] = corner_mask(120, 90)
    Image.fromarray(layers).save(tmp_path / "1.png")
    mask = load_mask(read_photos([tmp_path]).photos[0])
    np.testing.assert_array_equal(mask, corner_mask(120, 90) > 0)


@pytest.mark.parametrize(
    ("mask", "reason"),
    [
        (Image.new("L", (60, 45), 255), "size"),
        (Image.new("L", (120, 90), 0), "black everywhere"),
        (Image.new("RGB", (120, 90), (200, 30, 30)), "coloured"),
    ],
)
def test_what_is_no_mask_is_set_aside_and_the_photo_stays(
    write_photo: Writer, tmp_path: Path, mask: Image.Image, reason: str
) -> None:
    write_photo("1.jpg", 1)
    write_photo("2.jpg", 2)
    mask.save(tmp_path / "1.png")
    photos = read_photos([tmp_path])
    assert photos.photos[0].mask_path is None
    (part,) = photos.set_aside
    assert part.name == "1.png"
    assert reason in told(part.reason)


def test_a_broken_mask_is_set_aside(write_photo: Writer, tmp_path: Path) -> None:
    write_photo("1.jpg", 1)
    write_photo("2.jpg", 2)
    (tmp_path / "1.png").write_bytes(b"\x89PNG\r\n\x1a\nno")
    photos = read_photos([tmp_path])
    assert [part.name for part in photos.set_aside] == ["1.png"]
    assert photos.names == ("1.jpg", "2.jpg")


@pytest.mark.parametrize("orientation", range(1, 9))
def test_pictures_are_turned_as_people_see_their_photo(
    write_photo: Writer, tmp_path: Path, orientation: int
) -> None:
    write_photo("1.jpg", 1, orientation=orientation)
    write_photo("2.jpg", 2)
    seen = as_people_see(corner_mask(120, 90), orientation)
    exif = read_photos([tmp_path]).photos[0].exif
    np.testing.assert_array_equal(upright(corner_mask(120, 90), exif), seen)


def test_a_folder_of_masks_takes_the_place_of_those_beside_the_photos(
    write_photo: Writer, tmp_path: Path
) -> None:
    for k in (1, 2, 3):
        write_photo(f"{k}.jpg", k)
    Image.fromarray(255 - corner_mask(120, 90)).save(tmp_path / "1.png")
    folder = tmp_path / "corrected"
    folder.mkdir()
    Image.fromarray(corner_mask(120, 90)).save(folder / "1.png")
    (folder / "3.png").write_bytes(b"no picture")
    photos = with_masks_in(read_photos([tmp_path]), folder)
    np.testing.assert_array_equal(load_mask(photos.photos[0]), corner_mask(120, 90) > 0)
    assert [one.mask_path is None for one in photos.photos] == [False, True, True]
    assert [one.name for one in photos.set_aside] == ["3.png"]
    (some,) = mask_notes(photos)
    assert told(some) == (
        "1 of 3 photos have masks: only what is white in them was used. Used whole, for want of a "
        "mask: 2.jpg, 3.jpg."
    )
    with pytest.raises(PhotoError, match="no folder of masks"):
        with_masks_in(photos, tmp_path / "elsewhere")
