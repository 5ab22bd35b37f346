"""A rendered turntable in a patterned room: the room's keypoints go, those of the limb stay."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.findings import Finding
from limbgram.reconstruction.features.detection import FeatureOptions, detect
from limbgram.reconstruction.matching.static_background import find_still
from limbgram.reconstruction.photos.masks import read_mask
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.synthetic import SMALL, Capture, Turning, make_capture


@pytest.fixture(scope="module")
def turntable(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    options = replace(
        SMALL,
        seed=5,
        photos=8,
        width_px=600,
        height_px=400,
        calibration_photos=0,
        samples=2,
        turning=Turning(sway_mm=4.0, before=True),
    )
    return make_capture(tmp_path_factory.mktemp("turning") / "capture", options)


def test_the_room_goes_and_the_limb_stays(turntable: Capture) -> None:
    photos = read_photos(turntable.photos)
    features = detect(photos, FeatureOptions(max_keypoints=4000))
    still = find_still(features)
    assert still.groups == (tuple(range(8)),)
    on_limb, in_room = [], []
    for photo, keypoints, flags in zip(
        photos.photos, features.keypoints, still.keypoints, strict=True
    ):
        path = Path(turntable.folder, "truth", "masks", photo.name).with_suffix(".png")
        mask = read_mask(path, photo.width_px, photo.height_px, photo.exif)
        assert not isinstance(mask, Finding)
        x, y = np.rint(keypoints.xy_px).astype(int).T
        limb = mask.pixels[y.clip(0, 399), x.clip(0, 599)]
        on_limb.append(flags[limb].mean())
        in_room.append(flags[~limb & (x < 120)].mean())  # the strip on the left
    assert max(on_limb) < 0.03
    assert min(in_room) > 0.75
