"""Pyramid levels: one photo and its sources as the kernels take them, and how to go finer."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64, Int32, Int64, UInt8, UInt32

from limbgram.dense.stereo.crops import Crop, reduced
from limbgram.dense.stereo.lanes import packed
from limbgram.geometry.arrays import Mask

_MARGIN_PX = 6
"""Pixels nearer to a crop's border have no whole window."""


@dataclass(frozen=True, kw_only=True)
class Level:
    """A crop and its sources at one scale.

    Pixel (x, y) at inverse depth w lies in source s at the homogeneous a[s] (x, y, 1) + b[s] w.
    """

    grey: UInt8[np.ndarray, " pixels"]
    width: int
    wanted: Mask
    words: UInt32[np.ndarray, " total"]
    """Packed sources, one after another."""
    table: Int64[np.ndarray, "s 3"]
    """By source: start in `words`, width, height."""
    a: Float32[np.ndarray, "s 9"]
    b: Float32[np.ndarray, "s 3"]
    focal_px: float
    w_per_px: float
    """Change of inverse depth that moves the sources by one pixel (median)."""

    @property
    def red_and_black(self) -> tuple[Int32[np.ndarray, " r"], Int32[np.ndarray, " b"]]:
        """Wanted pixels of a chessboard's two colours."""
        pixels = np.flatnonzero(self.wanted).astype(np.int32)
        red = (pixels // self.width + pixels % self.width) % 2 == 0
        return pixels[red], pixels[~red]


def level_of(crop: Crop, sources: Sequence[Crop], halvings: int) -> Level:
    """A crop and its sources, halved."""
    pixels = [reduced(source.grey, 1 << halvings) for source in sources]
    ends = np.cumsum([0, *(picture.size for picture in pixels)])
    homographies = [_homography(crop, source, halvings) for source in sources]
    a = np.array([rotation for rotation, _ in homographies])
    b = np.array([translation for _, translation in homographies])
    grey = reduced(crop.grey, 1 << halvings)
    return Level(
        grey=grey.ravel(),
        width=grey.shape[1],
        wanted=_wanted(crop, halvings),
        words=np.concatenate([packed(picture) for picture in pixels]),
        table=np.array([(ends[s], *pixels[s].shape[::-1]) for s in range(len(pixels))], np.int64),
        a=a.reshape(-1, 9).astype(np.float32),
        b=b.astype(np.float32),
        focal_px=crop.view.camera.fx / (1 << halvings),
        w_per_px=_w_per_px(a, b, crop, grey.shape),
    )


def finer(state: Float32[np.ndarray, "3 coarse"], wanted: Mask) -> Float32[np.ndarray, "3 fine"]:
    """Planes of the next level: each pixel takes its coarse pixel's plane, continued to its centre.

    Pixels that are not wanted, or whose coarse pixel was not, get no plane (zeros).
    """
    height, width = wanted.shape
    coarse = state.reshape(3, height // 2, width // 2)
    fine = np.repeat(np.repeat(coarse, 2, axis=1), 2, axis=2)
    quarter = np.array([-0.25, 0.25], np.float32)
    fine[0] += fine[1] * np.tile(quarter, width // 2)
    fine[0] += fine[2] * np.tile(quarter, height // 2)[:, None]
    fine[1:] *= np.float32(0.5)
    return np.ascontiguousarray((fine * wanted).reshape(3, -1))


def _homography(
    crop: Crop, source: Crop, halvings: int
) -> tuple[Float64[np.ndarray, "3 3"], Float64[np.ndarray, "3"]]:
    own, other = crop.matrix_at(halvings), source.matrix_at(halvings)
    source_from_crop = source.view.camera_from_world @ crop.view.camera_from_world.inverse
    rotation = other @ source_from_crop.rotation @ np.linalg.inv(own)
    return rotation, other @ source_from_crop.translation


def _w_per_px(
    a: Float64[np.ndarray, "s 3 3"],
    b: Float64[np.ndarray, "s 3"],
    crop: Crop,
    shape: tuple[int, int],
) -> float:
    """From the movement, in each source, of the crop's central pixel at the middle depth."""
    w = 2 / (crop.near_mm + crop.far_mm)
    centre = np.array([shape[1] / 2, shape[0] / 2, 1.0])
    u, v, depth = (a @ centre + b * w).T
    speed = np.hypot(b[:, 0] - u / depth * b[:, 2], b[:, 1] - v / depth * b[:, 2]) / depth
    return float(1 / np.median(speed))


def _wanted(crop: Crop, halvings: int) -> Mask:
    side = 1 << halvings
    height, width = crop.wanted.shape
    blocks = crop.wanted.reshape(height // side, side, width // side, side)
    wanted = blocks.any(axis=(1, 3))
    inner = np.zeros_like(wanted)
    inner[_MARGIN_PX:-_MARGIN_PX, _MARGIN_PX:-_MARGIN_PX] = True
    return wanted & inner
