"""Crops: the part of each photo that shows the region, without lens distortion and reduced.

A plane maps straight lines to straight lines only through a pinhole, so every photo is resampled
once, to a pinhole camera of the same focal length and principal point, and reduced in the same
step: the mean of samples that are spread evenly over each reduced pixel, so that its centre stays
right. Half a pixel here would be a tenth of a millimetre on the surface. One photo and its sources
make a level of the pyramid, as the kernels take them; a level's result starts the next finer one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Float32, Float64, Int32, Int64, UInt8, UInt32

from limbgram.core.geometry.arrays import GreyImage, Mask, Matrix3
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.dense.patchmatch import packed
from limbgram.reconstruction.dense.region import Footprint, Region, footprint
from limbgram.reconstruction.photos.decoding import load_luma
from limbgram.reconstruction.photos.masks import load_mask
from limbgram.reconstruction.photos.photo import Photo

HALVINGS = 2
"""The coarsest pyramid level is a crop halved this often."""
_ALIGNED = 1 << HALVINGS
_BAND = 32
"""Rows of a crop for which pixels of the photo are computed at once: what they need stays in the
cache."""


@dataclass(frozen=True, kw_only=True)
class Crop:
    """Pixel (r, c) of the arrays is pixel (x0 + c, y0 + r) of the reduced pinhole photo.

    Sides and corner are multiples of the coarsest pyramid level's pixel.
    """

    photo_idx: int
    view: View
    """Pinhole camera of the whole reduced photo, and its pose."""
    x0: int
    y0: int
    grey: GreyImage
    wanted: Mask
    """Pixels that can show the region, inside the photo and its mask."""
    near_mm: float
    far_mm: float
    """Depths between which the region lies, along the camera's z axis."""

    def matrix_at(self, halvings: int) -> Matrix3:
        """K of the crop at a pyramid level; pixel (0, 0) is the crop's first."""
        camera = self.view.camera.scaled(0.5**halvings)
        matrix = camera.matrix
        matrix[0, 2] -= self.x0 >> halvings
        matrix[1, 2] -= self.y0 >> halvings
        return matrix


def reduction_for(region: Region, views: Sequence[View], most_px: int) -> float:
    """By how much to reduce the photos so that the region covers `most_px` of all together."""
    covered = sum(int(footprint(region, pinhole(view), 1 / 8).mask.sum()) * 64 for view in views)
    return max(1.0, float(np.sqrt(covered / most_px)))


def pinhole(view: View) -> View:
    """The same view through a lens without distortion."""
    camera = replace(view.camera, k1=0.0, k2=0.0, p1=0.0, p2=0.0, k3=0.0)
    return View(view.name, camera, view.camera_from_world)


def crop_photo(
    photo: Photo, photo_idx: int, view: View, region: Region, reduction: float
) -> Crop | None:
    """The region in one photo; None where the photo does not show it."""
    straight = pinhole(view)
    seen = footprint(region, straight, 1 / reduction)
    seen = _aligned(seen)
    if not seen.mask.any():
        return None
    grey, inside = _resampled(photo, seen, straight.camera, view.camera, reduction)
    return Crop(
        photo_idx=photo_idx,
        view=View(view.name, straight.camera.scaled(1 / reduction), view.camera_from_world),
        x0=seen.x0,
        y0=seen.y0,
        grey=grey,
        wanted=seen.mask & inside,
        near_mm=float(np.nanmin(seen.near_mm)),
        far_mm=float(np.nanmax(seen.far_mm)),
    )


def _resampled(
    photo: Photo, seen: Footprint, straight: Camera, lens: Camera, reduction: float
) -> tuple[GreyImage, Mask]:
    """Grey crop, and which of its pixels lie in the photo and its mask: by bands of rows, for
    the samples of a whole crop take a dozen times the memory of the photo."""
    samples = int(np.ceil(reduction))
    luma, given = load_luma(photo), load_mask(photo)
    white = None if given is None else given.astype(np.uint8)
    grey, inside = np.empty(seen.mask.shape, np.uint8), np.empty(seen.mask.shape, bool)
    for first in range(0, len(grey), _BAND):
        rows = slice(first, min(first + _BAND, len(grey)))
        map_x, map_y = _source_pixels(seen, rows, straight, lens, reduction, samples)
        light = cv2.remap(luma, map_x, map_y, cv2.INTER_LANCZOS4, borderMode=cv2.BORDER_REPLICATE)
        within = (map_x >= 0) & (map_y >= 0)
        within &= (map_x <= lens.width_px - 1) & (map_y <= lens.height_px - 1)
        if white is not None:
            within &= cv2.remap(white, map_x, map_y, cv2.INTER_NEAREST) > 0
        grey[rows] = reduced(light.astype(np.uint8, copy=False), samples)
        inside[rows] = reduced(within.astype(np.uint8) * 255, samples) == 255
    return grey, inside


def _aligned(seen: Footprint) -> Footprint:
    """Grown so that corner and sides can be halved without a rest."""
    height, width = seen.mask.shape
    left, top = seen.x0 % _ALIGNED, seen.y0 % _ALIGNED
    grow = ((top, -(height + top) % _ALIGNED), (left, -(width + left) % _ALIGNED))
    return replace(
        seen,
        x0=seen.x0 - left,
        y0=seen.y0 - top,
        mask=np.pad(seen.mask, grow),
        near_mm=np.pad(seen.near_mm, grow, constant_values=np.nan),
        far_mm=np.pad(seen.far_mm, grow, constant_values=np.nan),
    )


def _source_pixels(
    seen: Footprint, rows: slice, straight: Camera, lens: Camera, reduction: float, samples: int
) -> tuple[np.ndarray, np.ndarray]:
    """Where in the photo the samples of each crop pixel in some rows lie: samples x samples, evenly
    spread."""
    height, width = seen.mask.shape
    part = (np.arange(max(width, height) * samples) + 0.5) / samples
    x = (seen.x0 + part[: width * samples]) * reduction - 0.5
    band = slice(rows.start * samples, rows.stop * samples)
    y = ((seen.y0 + part[band]) * reduction - 0.5)[:, None]
    y_ideal = (y - straight.cy) / straight.fy
    x_ideal = (x - straight.cx - straight.skew * y_ideal) / straight.fx
    ideal = np.stack([x_ideal, y_ideal + 0 * x_ideal, np.ones_like(x_ideal)], axis=-1)
    map_x, map_y = np.moveaxis(lens.project(ideal).astype(np.float32), -1, 0)
    return np.ascontiguousarray(map_x), np.ascontiguousarray(map_y)


def reduced(grey: GreyImage, factor: int) -> UInt8[np.ndarray, "rows columns"]:
    """Means of factor x factor blocks: pixel centres are kept, see geometry.camera."""
    if factor == 1:
        return grey
    height, width = grey.shape
    size = (width // factor, height // factor)
    return cv2.resize(grey, size, interpolation=cv2.INTER_AREA).astype(np.uint8)


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
