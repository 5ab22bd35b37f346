"""Photos that show a surface point: only whole patches are compared."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from limbgram.cases.photo_evidence import _patch
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.photos.photo import Photo
from limbgram.reconstruction.photos.reading import read_photos

FOCAL_PX, DISTANCE_MM = 1000.0, 100.0
CAMERA = Camera(width_px=800, height_px=600, fx=FOCAL_PX, fy=FOCAL_PX, cx=399.5, cy=299.5)
VIEW = View("a.png", CAMERA, Rigid.identity())


@pytest.fixture
def photo(tmp_path: Path) -> Photo:
    """A grey picture that shows 80 x 60 mm at the distance of the patch."""
    for name, grey in (("a.png", 128), ("b.png", 127)):
        Image.fromarray(np.full((600, 800, 3), grey, np.uint8)).save(tmp_path / name)
    return read_photos([tmp_path]).photos[0]


@pytest.mark.parametrize(("x_mm", "whole"), [(0.0, True), (36.0, True), (38.0, False)])
def test_a_patch_that_leaves_the_photo_is_none(photo: Photo, x_mm: float, whole: bool) -> None:
    place = np.array([x_mm, 0.0, DISTANCE_MM])
    patch = _patch(photo, VIEW, place, np.array([0.0, 0.0, -1.0]))
    assert (patch is not None) == whole
    if patch is not None:
        np.testing.assert_allclose(patch, 128, atol=1)


def test_a_photo_that_is_gone_has_no_patch(photo: Photo, tmp_path: Path) -> None:
    gone = replace(photo, path=tmp_path / "gone.png")
    assert _patch(gone, VIEW, np.array([0, 0, DISTANCE_MM]), np.array([0, 0, -1.0])) is None
