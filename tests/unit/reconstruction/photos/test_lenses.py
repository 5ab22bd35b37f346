"""Lenses: pictures that were cut are told from smaller copies, and by whom they were taken."""

from dataclasses import replace
from pathlib import Path

import pytest

from limbgram.reconstruction.photos.lenses import copies_of, cut_from, lens_notes
from limbgram.reconstruction.photos.photo import Exif, Photo, PhotoSet
from limbgram.reconstruction.photos.quality import remarks
from limbgram.reconstruction.photos.reading import grouped_by_camera

WIDE = Exif(make="Phone", model="One", lens="4.25 mm", focal_mm=4.25, focal_35mm=26.0)


def photos_of(*shown: tuple[int, int, Exif]) -> PhotoSet:
    return grouped_by_camera(
        [
            Photo(
                name=f"{k}.jpg", path=Path(f"{k}.jpg"), width_px=width, height_px=height, exif=exif,
                sha256=f"{k}", camera_idx=0,
            )
            for k, (width, height, exif) in enumerate(shown)
        ],
        (),
    )  # fmt: skip


@pytest.mark.parametrize("exif", [WIDE, Exif()])
@pytest.mark.parametrize("size", [(3000, 3000), (4000, 2250), (2250, 4000), (2800, 2050)])
def test_a_picture_of_another_ratio_was_cut(exif: Exif, size: tuple[int, int]) -> None:
    photos = photos_of((4000, 3000, exif), (4000, 3000, exif), (*size, exif))
    assert cut_from(photos) == {1: 0}
    (said,) = lens_notes(photos)
    assert (said.code, said.values["count"], said.values["names"]) == (
        "lens.cut_out", 1, ("2.jpg",),
    )  # fmt: skip
    assert not remarks(photos)


@pytest.mark.parametrize("size", [(2000, 1500), (1600, 1200), (1333, 1000), (1200, 1600)])
def test_a_smaller_copy_has_the_same_lens(size: tuple[int, int]) -> None:
    photos = photos_of((4000, 3000, WIDE), (4000, 3000, WIDE), (*size, WIDE))
    assert cut_from(photos) == {}
    assert not lens_notes(photos)
    assert not remarks(photos)


def test_a_smaller_picture_that_photos_tell_was_cut_is_no_copy() -> None:
    photos = photos_of((4000, 3000, WIDE), (2000, 1500, WIDE))
    assert copies_of(photos) == {1: 0}
    whole, part = photos.cameras
    told = replace(photos, cameras=(whole, replace(part, cut_out=True)))
    assert cut_from(told) == {1: 0}
    (said,) = lens_notes(told)
    assert (said.code, said.values["width_px"]) == ("lens.cut_out", 2000)


def test_sizes_count_as_the_files_have_them() -> None:
    """Small copies of all photos come out nearly alike."""
    photos = photos_of((4000, 3000, WIDE), (2900, 2900, WIDE), (2000, 1500, WIDE))
    files = tuple((one.width_px, one.height_px) for one in photos.cameras)
    alike = tuple(
        replace(one, width_px=1200, height_px=1200, file_px=file_px)
        for one, file_px in zip(photos.cameras, files, strict=True)
    )
    small = replace(photos, cameras=alike)
    assert (cut_from(small), copies_of(small)) == ({1: 0}, {2: 0})
    (said,) = lens_notes(small)
    assert (said.values["width_px"], said.values["of_width_px"]) == (2900, 4000)


@pytest.mark.parametrize(
    "other",
    [
        replace(WIDE, focal_mm=9.0, focal_35mm=77.0),
        replace(WIDE, lens="9 mm"),
        replace(WIDE, model="Two"),
        replace(WIDE, digital_zoom=2.0),
    ],
)
def test_another_lens_is_no_cut(other: Exif) -> None:
    assert cut_from(photos_of((4000, 3000, WIDE), (3000, 3000, other))) == {}


def test_of_a_picture_that_is_larger_one_way_nothing_was_cut() -> None:
    assert cut_from(photos_of((4000, 3000, WIDE), (4600, 2600, WIDE))) == {}


def test_what_photos_told_of_two_lenses_is_said() -> None:
    photos = photos_of((4000, 3000, Exif()), (4000, 3000, Exif()), (4000, 3000, Exif()))
    (group,) = photos.cameras
    by_lens = replace(
        photos,
        photos=tuple(replace(one, camera_idx=k // 2) for k, one in enumerate(photos.photos)),
        cameras=(group, replace(group, longer=2.03)),
    )
    (said,) = lens_notes(by_lens)
    assert (said.code, said.values["names"]) == ("lens.told_by_photos", ("2.jpg",))
    assert said.values["longer"] == pytest.approx(2.03)
