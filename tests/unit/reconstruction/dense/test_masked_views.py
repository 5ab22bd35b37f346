"""Photos that were cut out say what the limb is, as those with masks beside them do."""

from pathlib import Path

import numpy as np
from PIL import Image

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.dense.region import masked_views
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.photos.reading import read_photos

LENS = Camera(width_px=240, height_px=160, fx=300.0, fy=300.0, cx=119.5, cy=79.5)


def test_a_photo_that_was_cut_out_counts_as_one_with_a_mask(tmp_path: Path) -> None:
    draw = np.random.default_rng(3)
    nothing = np.zeros(0, np.int32)
    scene = Scene(
        names=("1", "2", "3"), cameras=(LENS,), camera_idx=(0, 0, 0),
        camera_from_world=(Rigid.identity(), Rigid.identity(), None),
        points_in_world=np.zeros((0, 3)), verdicts=(),
        observations=Observations(nothing, nothing, np.zeros((0, 2))),
    )  # fmt: skip
    for way in ("masks", "cut out", "whole"):
        (tmp_path / way).mkdir()
    for number in range(3):
        colours = draw.integers(0, 256, (160, 240, 3), dtype=np.uint8)
        white = np.zeros((160, 240), np.uint8)
        white[40:120, 60 + 10 * number : 160] = 255
        for way in ("masks", "whole"):
            Image.fromarray(colours).save(tmp_path / way / f"{number}.jpg")
        Image.fromarray(white).save(tmp_path / "masks" / f"{number}.png")
        Image.fromarray(np.dstack([colours, white])).save(tmp_path / "cut out" / f"{number}.png")
    masks, cut_out, whole = (
        masked_views(read_photos([tmp_path / way]), scene) for way in ("masks", "cut out", "whole")
    )
    assert len(masks) == len(cut_out) == 2
    for one, other in zip(masks, cut_out, strict=True):
        np.testing.assert_array_equal(one.outside_px, other.outside_px)
    assert whole == ()
