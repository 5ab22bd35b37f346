"""Small copies of photos: what the sizes of the files tell is kept."""

import os
from pathlib import Path
from typing import cast

import numpy as np
from PIL import Image

from limbgram.capture.coach import Coach
from limbgram.cases.capture_check import CaptureWatch, reduce_photos
from limbgram.core.run import Run
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


def test_while_photos_arrive_a_mask_counts_from_when_it_is_there(tmp_path: Path) -> None:
    """First there is none, then one beside its photo, then that one is painted anew."""
    shown: list[PhotoSet] = []

    class Listening:
        def check(self, _photos: PhotoSet, small: PhotoSet, _run: Run) -> None:
            shown.append(small)

    random = np.random.default_rng(2)
    for name in ("a.jpg", "b.jpg"):
        coarse = Image.fromarray(random.integers(0, 256, (30, 40, 3), dtype=np.uint8))
        coarse.resize((400, 300)).save(tmp_path / name)
    with CaptureWatch((), None) as watch:
        watch._coach = cast(Coach, Listening())
        watch.check([tmp_path])
        for columns in (200, 100):
            mask = np.zeros((300, 400), np.uint8)
            mask[:, :columns] = 255
            Image.fromarray(mask).save(tmp_path / "a.png")
            os.utime(tmp_path / "a.png", (columns, columns))
            watch.check([tmp_path])
        masks = [load_mask(one.photos[0]) for one in shown]
    assert masks[0] is None
    assert [int(one.sum()) for one in masks[1:] if one is not None] == [200 * 300, 100 * 300]
    assert all(one.photos[1].mask_path is None for one in shown)
