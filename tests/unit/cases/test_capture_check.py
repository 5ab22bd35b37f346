"""Small copies of photos: what the sizes of the files tell is kept."""

import os
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from PIL import Image

from limbgram.capture.coach import Coach
from limbgram.capture.limb_in_photos import known_by
from limbgram.cases import capture_check
from limbgram.cases.capture_check import CaptureWatch, reduce_photos
from limbgram.core.run import Run
from limbgram.reconstruction.photos.decoding import load_luma
from limbgram.reconstruction.photos.lenses import copies_of, cut_from
from limbgram.reconstruction.photos.masks import load_mask
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.photos.reading import read_photos


def test_sizes_whose_small_copies_come_out_alike_stay_apart(tmp_path: Path) -> None:
    """3:2 photos, a smaller copy, and a cut of another shape, all larger than small copies are."""
    random = np.random.default_rng(1)
    sizes = [(2400, 1600), (2400, 1600), (1860, 1240), (1600, 1560)]
    for number, (width, height) in enumerate(sizes):
        coarse = random.integers(0, 255, (30, 40, 3), dtype=np.uint8)
        picture = Image.fromarray(coarse).resize((width, height))
        picture.save(tmp_path / f"{number}.jpg", quality=90)
    photos = read_photos([tmp_path])
    small = reduce_photos(photos, tmp_path)
    alike = [(one.width_px, one.height_px) for one in small.cameras[:2]]
    assert alike == [(1500, 1000)] * 2
    assert [one.camera_idx for one in small.photos] == [0, 0, 1, 2]
    assert (copies_of(small), cut_from(small)) == ({1: 0}, {2: 0})
    assert (copies_of(photos), cut_from(photos)) == ({1: 0}, {2: 0})


def take_two_photos(folder: Path) -> None:
    random = np.random.default_rng(2)
    for name in ("a.jpg", "b.jpg"):
        coarse = Image.fromarray(random.integers(0, 256, (30, 40, 3), dtype=np.uint8))
        coarse.resize((400, 300)).save(folder / name)


def paint_mask(folder: Path, columns: int) -> None:
    """Of the first photo: so many columns are white, and the time of the file says how many."""
    mask = np.zeros((300, 400), np.uint8)
    mask[:, :columns] = 255
    Image.fromarray(mask).save(folder / "a.png")
    os.utime(folder / "a.png", (columns, columns))


class Listening:
    """Stands for a Coach, and keeps the small copies that it was shown."""

    def __init__(self, watch: CaptureWatch) -> None:
        self.shown: list[PhotoSet] = []
        watch._coach = cast(Coach, self)

    def check(self, _photos: PhotoSet, small: PhotoSet, _run: Run) -> None:
        self.shown.append(small)


def test_while_photos_arrive_a_mask_counts_from_when_it_is_there(tmp_path: Path) -> None:
    """First there is none, then one beside its photo, then that one is painted anew."""
    take_two_photos(tmp_path)
    with CaptureWatch((), None) as watch:
        shown = Listening(watch).shown
        watch.check([tmp_path])
        for columns in (200, 100):
            paint_mask(tmp_path, columns)
            watch.check([tmp_path])
        masks = [load_mask(one.photos[0]) for one in shown]
    assert masks[0] is None
    assert [int(one.sum()) for one in masks[1:] if one is not None] == [200 * 300, 100 * 300]
    assert all(one.photos[1].mask_path is None for one in shown)


def test_what_is_known_of_a_photo_goes_with_its_bit_depth(tmp_path: Path) -> None:
    """A dark photo of fourteen bits seems to have twelve until a bright one arrives."""
    draw = np.random.default_rng(5)

    def take(name: str, brightest: int) -> None:
        grey = draw.integers(0, brightest, (300, 400), dtype=np.uint16)
        Image.fromarray(grey).save(tmp_path / name)

    take("a.tif", 4095)
    take("b.tif", 4095)
    with CaptureWatch((), None) as watch:
        shown = Listening(watch).shown
        watch.check([tmp_path])
        take("c.tif", 16383)
        watch.check([tmp_path])
        watch.check([tmp_path])
        before, after, again = (one.photos[0] for one in shown)
        assert load_luma(before).mean() > 3 * load_luma(after).mean()
    assert known_by(before) != known_by(after)
    assert known_by(after) == known_by(again)


def test_a_mask_that_is_painted_anew_while_copies_are_made_counts_from_the_next_check(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def reduce_and_paint(photos: PhotoSet, folder: Path) -> PhotoSet:
        copies = reduce_photos(photos, folder)
        paint_mask(tmp_path, 100)
        return copies

    take_two_photos(tmp_path)
    paint_mask(tmp_path, 200)
    monkeypatch.setattr(capture_check, "reduce_photos", reduce_and_paint)
    with CaptureWatch((), None) as watch:
        shown = Listening(watch).shown
        watch.check([tmp_path])
        watch.check([tmp_path])
        masks = [load_mask(one.photos[0]) for one in shown]
    assert [int(one.sum()) for one in masks if one is not None] == [200 * 300, 100 * 300]


def test_a_mask_that_is_removed_while_copies_are_made_does_not_end_the_check(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def reduce_and_remove(photos: PhotoSet, folder: Path) -> PhotoSet:
        copies = reduce_photos(photos, folder)
        (tmp_path / "a.png").unlink()
        return copies

    take_two_photos(tmp_path)
    paint_mask(tmp_path, 200)
    monkeypatch.setattr(capture_check, "reduce_photos", reduce_and_remove)
    with CaptureWatch((), None) as watch:
        shown = Listening(watch).shown
        watch.check([tmp_path])
        mask = load_mask(shown[0].photos[0])
    assert mask is not None
    assert mask.sum() == 200 * 300
