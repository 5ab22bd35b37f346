"""Where the limb lies in photos of full size, to the half pixel."""

from pathlib import Path

import numpy as np
import pytest

from limbgram.capture import limb_in_photos
from limbgram.capture.limb_in_photos import InspectionCache, Slopes, inspect_limb
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.photos.photo import Exif, Photo, PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene, Scale


def test_slopes_are_read_in_the_block_that_holds_the_pixel() -> None:
    """Blocks of 2 pixels: the first reaches from -0.5 to 1.5, as (0, 0) is a pixel's centre."""
    slopes = Slopes(np.array([[1.0, 4.0, 9.0]], np.float32), (2.0, 2.0))
    x = np.array([-0.4, 1.4, 1.6, 3.4, 5.4, 5.6])
    xy_px = np.column_stack([x, np.zeros(len(x))])
    assert slopes.at(xy_px).tolist() == [1.0, 1.0, 2.0, 2.0, 3.0, 0.0]


def test_blocks_reach_to_the_lowest_row_of_any_photo() -> None:
    """961 rows are 240.25 blocks of 4: the 240 that there are reach over all of them."""
    luma = np.tile(np.arange(960).astype(np.uint8) % 100, (961, 1))
    assert Slopes.of(luma).at(np.array([[480.0, 960.0]])).tolist() == [1.0]


def photo_of(width_px: int, height_px: int) -> PhotoSet:
    one = Photo(
        name="a.jpg",
        path=Path("a.jpg"),
        width_px=width_px,
        height_px=height_px,
        exif=Exif(),
        sha256="a",
        camera_idx=0,
    )
    return PhotoSet((one,), ())


def test_the_outline_in_the_full_size_photo_keeps_pixel_centres(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Reduced to a quarter, the middle of pixel 50 is that of pixels 200 to 203: 201.5."""
    outlines: list[np.ndarray] = []

    def look(photo: Photo, hull_px: np.ndarray, box: tuple[int, int, int, int]) -> InspectionCache:
        outlines.append(hull_px)
        return InspectionCache(box, photo, Slopes(np.zeros((1, 1), np.float32), (1.0, 1.0)))

    monkeypatch.setattr(limb_in_photos, "_at_full_size", look)
    small_px = np.array([[50.0, 40.0], [150.0, 40.0], [100.0, 120.0]])
    lens = Camera(width_px=200, height_px=150, fx=300.0, fy=300.0, cx=99.5, cy=74.5)
    limb = 1000 * np.column_stack([(small_px - [99.5, 74.5]) / 300.0, np.ones(3)])
    scene = Scene(
        names=("a.jpg",),
        cameras=(lens,),
        camera_idx=(0,),
        camera_from_world=(Rigid.identity(),),
        points_in_world=limb,
        observations=Observations(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, 2))),
        verdicts=(),
    )
    metric = MetricScene(scene=scene, scale=Scale(unit="mm", source="board", relative_sigma=1e-4))
    nothing = np.zeros(0, np.float32)
    keypoints = Keypoints(
        xy_px=np.zeros((0, 2), np.float32),
        scale_px=nothing,
        angle_deg=nothing,
        descriptors=np.zeros((0, 128), np.uint8),
    )
    features = Features((keypoints,))
    inspect_limb(photo_of(800, 600), photo_of(200, 150), features, metric, limb, {})
    (outline,) = outlines
    assert outline[:, 0, 0].min() == pytest.approx(201.5, abs=1e-3)
    assert outline[:, 0, 1].max() == pytest.approx(481.5, abs=1e-3)
