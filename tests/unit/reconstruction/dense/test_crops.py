"""Pinhole crops: a picture that is a straight ramp in the pinhole tells where each pixel lies."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.dense.crops import crop_photo
from limbgram.reconstruction.dense.region import Region
from limbgram.reconstruction.photos.photo import Exif, Photo

CAMERA = Camera(
    width_px=160, height_px=120, fx=300, fy=310, cx=81.7, cy=57.2, k1=-0.3, k2=0.1, p1=2e-3
)
VIEW = View("ramp", CAMERA, Rigid(np.eye(3), np.zeros(3)))
REGION = Region(
    origin_mm=np.array([-40.0, -30.0, 280.0]), cell_mm=10.0, occupied=np.ones((8, 6, 3), bool)
)
GREY_PER_UNIT = 283.0


def ramp_photo(folder: Path, axis: int, *, sign: int = 1, masked: bool = False) -> Photo:
    """Grey = 128 +- 283 X/Z (axis 0) or Y/Z (axis 1) of each pixel's ray: about 1 grey a pixel."""
    x, y = np.meshgrid(np.arange(160.0), np.arange(120.0))
    grey = 128 + sign * GREY_PER_UNIT * CAMERA.normalize(np.stack([x, y], -1))[..., axis]
    grey += np.random.default_rng(0).uniform(-0.5, 0.5, grey.shape)
    cv2.imwrite(str(folder / "ramp.png"), np.rint(grey).astype(np.uint8))
    mask = np.zeros((120, 160), np.uint8)
    mask[:, 80:] = 255
    cv2.imwrite(str(folder / "mask.png"), mask)
    return Photo(
        name="ramp.png", path=folder / "ramp.png", width_px=160, height_px=120, exif=Exif(),
        sha256="", camera_idx=0, mask_path=folder / "mask.png" if masked else None,
    )  # fmt: skip


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("reduction", [1.0, 1.37, 2.0, 3.0])
def test_pixel_centres_survive_undistortion_and_reduction(
    tmp_path: Path, axis: int, reduction: float
) -> None:
    """Half the difference of a rising and a falling ramp: the rounding of greys falls out."""
    errors = []
    for sign in (1, -1):
        crop = crop_photo(ramp_photo(tmp_path, axis, sign=sign), 0, VIEW, REGION, reduction)
        assert crop is not None
        rows, columns = np.nonzero(crop.wanted)
        xy = np.stack([columns + crop.x0, rows + crop.y0], 1).astype(float)
        ideal = crop.view.camera.normalize(xy)[:, axis]
        grey = crop.grey[rows, columns]
        errors.append((sign * (grey - 128.0) - GREY_PER_UNIT * ideal)[np.abs(ideal) < 0.17])
    off_px = (errors[0] + errors[1]) / 2
    assert len(off_px) > 5000 / reduction**2
    assert abs(off_px.mean()) < 0.03
    assert 0.05 < off_px.std() < 0.5


def test_crops_can_be_halved_twice_in_step_with_the_photo(tmp_path: Path) -> None:
    crop = crop_photo(ramp_photo(tmp_path, 0), 0, VIEW, REGION, 1.0)
    assert crop is not None
    assert all(value % 4 == 0 for value in (crop.x0, crop.y0, *crop.grey.shape))
    coarse, fine = crop.matrix_at(2), crop.matrix_at(0)
    point = np.array([3.0, -2.0, 290.0])
    (u, v), (x, y) = [(k @ point / point[2])[:2] for k in (coarse, fine)]
    assert (u, v) == pytest.approx(((x + 0.5) / 4 - 0.5, (y + 0.5) / 4 - 0.5))


def test_a_mask_is_honoured(tmp_path: Path) -> None:
    crop = crop_photo(ramp_photo(tmp_path, 0, masked=True), 0, VIEW, REGION, 1.0)
    assert crop is not None
    columns = np.nonzero(crop.wanted)[1] + crop.x0
    assert 78 <= columns.min() <= 82
    assert columns.max() > 110


def test_a_region_out_of_sight_gives_no_crop(tmp_path: Path) -> None:
    behind = Region(
        origin_mm=np.array([0.0, 0.0, -300.0]), cell_mm=10.0, occupied=np.ones((2, 2, 2), bool)
    )
    assert crop_photo(ramp_photo(tmp_path, 0), 0, VIEW, behind, 1.0) is None
