"""Small copies of photos: what the sizes of the files tell is kept."""

from pathlib import Path

import numpy as np
from PIL import Image

from limbgram.cases.capture_check import reduce_photos
from limbgram.reconstruction.photos.lenses import copies_of, cut_from
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
