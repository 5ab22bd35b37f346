"""Crops: the part of each photo that shows the region, undistorted and downsampled.

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
from jaxtyping import Bool, Float32, Float64, Int32, Int64, UInt8, UInt32

from limbgram.core.geometry.arrays import GreyImage, Mask, Matrix3
from limbgram.core.geometry.lens import Camera, View, distorted_by
from limbgram.core.kernels import njit
from limbgram.reconstruction.dense.patchmatch import pack_neighbourhoods
from limbgram.reconstruction.dense.region import Footprint, Region, footprint
from limbgram.reconstruction.photos.decoding import halvings_to, load_luma
from limbgram.reconstruction.photos.masks import load_mask
from limbgram.reconstruction.photos.photo import Photo

HALVINGS = 2
"""The coarsest pyramid level is a crop halved this often."""
_ALIGNMENT_PX = 1 << HALVINGS
_BAND_ROWS = 32
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
    """Factor by which to reduce the photos so that the region covers at most `most_px` of all."""
    covered = sum(int(footprint(region, pinhole(view), 1 / 8).mask.sum()) * 64 for view in views)
    return max(1.0, float(np.sqrt(covered / most_px)))


def pinhole(view: View) -> View:
    """The same view through a lens without distortion."""
    return View(view.name, view.camera.undistorted, view.camera_from_world)


def crop_photo(
    photo: Photo, photo_idx: int, view: View, region: Region, reduction: float
) -> Crop | None:
    """The crop of one photo; None where the photo does not show the region."""
    straight = pinhole(view)
    seen = footprint(region, straight, 1 / reduction)
    seen = _aligned(seen)
    if not seen.mask.any():
        return None
    grey, inside = _resampled_crop(photo, seen, straight.camera, view.camera, reduction)
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


def _resampled_crop(
    photo: Photo, seen: Footprint, straight: Camera, lens: Camera, reduction: float
) -> tuple[GreyImage, Mask]:
    """Grey crop, and which of its pixels lie in the photo and its mask.

    Bands of rows keep memory small: the samples of a whole crop take several times the photo's.
    """
    halvings = halvings_to(lens.width_px, lens.width_px / reduction)
    factor = 1 << halvings
    step = reduction / factor
    samples = int(np.ceil(step))
    luma, mask = load_luma(photo, halvings), load_mask(photo)
    mask_levels = None if mask is None else mask.astype(np.uint8)
    pinhole, lens_packed = straight.scaled(1 / factor).packed, lens.scaled(1 / factor).packed
    high = np.array([lens.width_px, lens.height_px]) / factor - 0.5 - 0.5 / factor
    height, width = seen.mask.shape
    grey, inside = np.empty(seen.mask.shape, np.uint8), np.empty(seen.mask.shape, bool)
    for first in range(0, height, _BAND_ROWS):
        rows = slice(first, min(first + _BAND_ROWS, height))
        shape = samples * (rows.stop - first), samples * width
        map_x, map_y = np.empty(shape, np.float32), np.empty(shape, np.float32)
        _sample_positions(
            samples * seen.x0, samples * (seen.y0 + first), step / samples, pinhole, lens_packed,
            map_x, map_y,
        )  # fmt: skip
        light = cv2.remap(luma, map_x, map_y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        grey[rows] = block_means(light.astype(np.uint8, copy=False), samples)
        low = -0.5 + 0.5 / factor
        within = (map_x >= low) & (map_y >= low) & (map_x <= high[0]) & (map_y <= high[1])
        if mask_levels is not None:
            map_x, map_y = factor * (map_x + 0.5) - 0.5, factor * (map_y + 0.5) - 0.5
            within &= cv2.remap(mask_levels, map_x, map_y, cv2.INTER_NEAREST) > 0
        inside[rows] = block_means(within.astype(np.uint8) * 255, samples) == 255
    return grey, inside


def _aligned(seen: Footprint) -> Footprint:
    """The footprint, enlarged so that corner and sides can be halved without remainder."""
    height, width = seen.mask.shape
    left, top = seen.x0 % _ALIGNMENT_PX, seen.y0 % _ALIGNMENT_PX
    grow = ((top, -(height + top) % _ALIGNMENT_PX), (left, -(width + left) % _ALIGNMENT_PX))
    return replace(
        seen,
        x0=seen.x0 - left,
        y0=seen.y0 - top,
        mask=np.pad(seen.mask, grow),
        near_mm=np.pad(seen.near_mm, grow, constant_values=np.nan),
        far_mm=np.pad(seen.far_mm, grow, constant_values=np.nan),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _sample_positions(
    first_x: int,
    first_y: int,
    step: float,
    straight: np.ndarray,
    lens: np.ndarray,
    map_x: np.ndarray,
    map_y: np.ndarray,
):
    """Compute where in the photo the samples of a crop lie, `step` pixels apart from a corner on.

    straight, lens   the pinhole and the photo's own lens, packed, of one size
    """
    height, width = map_x.shape
    for row in range(height):
        y = ((first_y + row + 0.5) * step - 0.5 - straight[3]) / straight[1]
        centre = straight[2] + straight[4] * y
        for column in range(width):
            x = ((first_x + column + 0.5) * step - 0.5 - centre) / straight[0]
            xd, yd = distorted_by(lens, x, y)
            map_x[row, column] = lens[0] * xd + lens[4] * yd + lens[2]
            map_y[row, column] = lens[1] * yd + lens[3]


def block_means(grey: GreyImage, factor: int) -> UInt8[np.ndarray, "rows columns"]:
    """Means of factor x factor blocks; pixel centres keep their place."""
    if factor == 1:
        return grey
    height, width = grey.shape
    size = (width // factor, height // factor)
    return cv2.resize(grey, size, interpolation=cv2.INTER_AREA).astype(np.uint8)


_BORDER_PLACES = 6
"""Places nearer to a crop's border have no whole window, or no far neighbour."""


@dataclass(frozen=True, kw_only=True)
class StereoProblem:
    """A crop and its sources at one pyramid level, as the kernels take them.

    Pixel (x, y) at inverse depth w lies in source s at the homogeneous a[s] (x, y, 1) + b[s] w.
    """

    grey: UInt8[np.ndarray, " pixels"]
    width: int
    step: int
    """Planes are sought at every step-th pixel of every step-th row: at the places."""
    wanted: Mask
    """Places that are sought, in rows and columns of places."""
    words: UInt32[np.ndarray, " total"]
    """Packed pictures, the sources among them."""
    table: Int64[np.ndarray, "s 3"]
    """By source: start in `words`, width, height."""
    a: Float32[np.ndarray, "s 9"]
    b: Float32[np.ndarray, "s 3"]
    focal_px: float
    w_per_px: float
    """Change of inverse depth that moves the sources by one pixel (median)."""

    @property
    def red_and_black(self) -> tuple[Int32[np.ndarray, " r"], Int32[np.ndarray, " b"]]:
        """Wanted places of a chessboard's two colours."""
        places = np.flatnonzero(self.wanted).astype(np.int32)
        across = self.wanted.shape[1]
        red = (places // across + places % across) % 2 == 0
        return places[red], places[~red]


@dataclass(frozen=True, kw_only=True)
class PyramidLevel:
    """All crops at one pyramid level, packed for sampling."""

    crops: Sequence[Crop]
    halvings: int
    greys: tuple[GreyImage, ...]
    words: UInt32[np.ndarray, " total"]
    """Packed pictures, one after another."""
    starts: Int64[np.ndarray, " crops"]
    """Where each begins."""


def pyramid_level(crops: Sequence[Crop], halvings: int) -> PyramidLevel:
    """The crops, each halved `halvings` times."""
    greys = tuple(block_means(crop.grey, 1 << halvings) for crop in crops)
    ends = np.cumsum([0, *(grey.size for grey in greys)])
    words = np.empty(int(ends[-1]), np.uint32)
    for k, grey in enumerate(greys):
        words[ends[k] : ends[k + 1]] = pack_neighbourhoods(grey)
    return PyramidLevel(
        crops=crops, halvings=halvings, greys=greys, words=words, starts=ends[:-1].astype(np.int64)
    )


def stereo_problem(
    level: PyramidLevel, reference_idx: int, sources: Sequence[int], wanted: Mask, step: int
) -> StereoProblem:
    """A crop and its sources, with a place at every step-th pixel.

    Args:
        reference_idx: Which of the crops; the sources are numbered likewise.
        wanted: Pixels of the crop itself that are sought.
    """
    halvings = level.halvings
    crop, grey = level.crops[reference_idx], level.greys[reference_idx]
    homographies = [_homography(crop, level.crops[k], halvings) for k in sources]
    a = np.array([rotation for rotation, _ in homographies])
    b = np.array([translation for _, translation in homographies])
    return StereoProblem(
        grey=grey.ravel(),
        width=grey.shape[1],
        step=step,
        wanted=_wanted_places(wanted, step << halvings),
        words=level.words,
        table=np.array([(level.starts[k], *level.greys[k].shape[::-1]) for k in sources], np.int64),
        a=a.reshape(-1, 9).astype(np.float32),
        b=b.astype(np.float32),
        focal_px=crop.view.camera.fx / (1 << halvings),
        w_per_px=_inverse_depth_per_px(a, b, crop, grey.shape),
    )


def upsample_planes(
    planes: Float32[np.ndarray, "3 n"],
    coarse_shape: tuple[int, int],
    step: int,
    wanted: Mask,
    to_step: int,
) -> Float32[np.ndarray, "3 m"]:
    """Planes of the next finer level: each place continues the nearest coarse plane to itself.

    Places that are not wanted, or whose coarse place was not, get no plane (zeros).

    Args:
        coarse_shape: Rows and columns of coarse places, `step` coarse pixels apart.
        to_step: Pixels from one place of the next level to the next one.
    """
    rows, columns = (np.arange(count) for count in wanted.shape)
    coarse_row, coarse_column = (to_step * k // (2 * step) for k in (rows, columns))
    fine = planes.reshape(3, *coarse_shape)[:, coarse_row[:, None], coarse_column]
    # A pixel's centre lies at half its number less a quarter, in coarse pixels.
    right = (to_step * columns / 2 - 0.25 - step * coarse_column).astype(np.float32)
    down = (to_step * rows / 2 - 0.25 - step * coarse_row).astype(np.float32)
    fine[0] += fine[1] * right + fine[2] * down[:, None]
    fine[1:] *= np.float32(0.5)
    return np.ascontiguousarray((fine * wanted).reshape(3, -1))


def _homography(
    crop: Crop, source: Crop, halvings: int
) -> tuple[Float64[np.ndarray, "3 3"], Float64[np.ndarray, "3"]]:
    """Plane-induced homography into a source: A + b m^T for the plane w = m (x, y, 1)."""
    own, other = crop.matrix_at(halvings), source.matrix_at(halvings)
    source_from_crop = source.view.camera_from_world @ crop.view.camera_from_world.inverse
    rotation = other @ source_from_crop.rotation @ np.linalg.inv(own)
    return rotation, other @ source_from_crop.translation


def _inverse_depth_per_px(
    a: Float64[np.ndarray, "s 3 3"],
    b: Float64[np.ndarray, "s 3"],
    crop: Crop,
    shape: tuple[int, int],
) -> float:
    """Change of inverse depth that moves the crop's central pixel by one pixel in the sources."""
    w = 2 / (crop.near_mm + crop.far_mm)
    centre = np.array([shape[1] / 2, shape[0] / 2, 1.0])
    u, v, depth = (a @ centre + b * w).T
    speed = np.hypot(b[:, 0] - u / depth * b[:, 2], b[:, 1] - v / depth * b[:, 2]) / depth
    return float(1 / np.median(speed))


def _wanted_places(wanted: Mask, side: int) -> Bool[np.ndarray, "rows columns"]:
    """Places, each of side x side pixels of the crop, that hold a wanted pixel."""
    height, width = wanted.shape
    places = wanted.reshape(height // side, side, width // side, side).any(axis=(1, 3))
    inner = np.zeros_like(places)
    inner[_BORDER_PLACES:-_BORDER_PLACES, _BORDER_PLACES:-_BORDER_PLACES] = True
    return places & inner
