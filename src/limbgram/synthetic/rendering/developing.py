"""Developing: from linear light to a JPEG with EXIF, as a camera writes it.

In      a linear picture, and the amounts of blur and noise.
Out     8-bit sRGB; a JPEG file.
"""

from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float32, Float64, UInt8
from PIL import Image
from PIL.TiffImagePlugin import IFDRational

from limbgram.core.geometry.arrays import ColourImage
from limbgram.synthetic.photographer import Lens

_READ_NOISE, _SHOT_NOISE = 0.0008, 6e-5
_TONES = 1 << 14
_LIGHT = np.arange(_TONES) / (_TONES - 1)
_TONE_OF_LIGHT: UInt8[np.ndarray, " tones"] = np.rint(
    255 * np.where(_LIGHT <= 0.0031308, 12.92 * _LIGHT, 1.055 * _LIGHT ** (1 / 2.4) - 0.055)
).astype(np.uint8)

LinearPicture = Float32[np.ndarray, "h w 3"]
"""Linear RGB, as the renderer gives it."""


def softened(picture: LinearPicture, blur_px: float) -> LinearPicture:
    """Blurred by the lens."""
    if blur_px <= 0:
        return picture
    return cv2.GaussianBlur(picture, (0, 0), blur_px, borderType=cv2.BORDER_REPLICATE)


def shaken(picture: LinearPicture, length_px: float, angle_rad: float) -> LinearPicture:
    """Motion blur along a straight line, centred so that nothing shifts."""
    half = int(np.ceil(length_px / 2)) + 1
    kernel = np.zeros((2 * half + 1, 2 * half + 1), np.float32)
    for along in np.linspace(-length_px / 2, length_px / 2, 16 * half + 1):
        x, y = half + along * np.cos(angle_rad), half + along * np.sin(angle_rad)
        i, j = int(y), int(x)
        for di, dj in ((0, 0), (0, 1), (1, 0), (1, 1)):
            kernel[i + di, j + dj] += (1 - abs(y - i - di)) * (1 - abs(x - j - dj))
    return cv2.filter2D(picture, -1, kernel / kernel.sum(), borderType=cv2.BORDER_REPLICATE)


def exposed(picture: LinearPicture, factors: Float64[np.ndarray, "3"]) -> LinearPicture:
    """Scaled by factors of red, green and blue, as by automatic exposure and white balance."""
    return picture if (factors == 1.0).all() else picture * factors.astype(np.float32)


def developed(picture: LinearPicture, noise: float, rng: np.random.Generator) -> ColourImage:
    """Photon and read noise, then sRGB tones."""
    sigma = noise * np.sqrt(_READ_NOISE**2 + _SHOT_NOISE * np.maximum(picture, 0))
    noisy = picture + sigma * rng.standard_normal(picture.shape, np.float32)
    return _TONE_OF_LIGHT[(np.clip(noisy, 0, 1) * (_TONES - 1) + 0.5).astype(np.uint16)]


def defocused(
    picture: LinearPicture,
    inverse_depth: Float32[np.ndarray, "h w"],
    focus_mm: float,
    pupil_mm_px: float,
) -> LinearPicture:
    """Defocus blur by discs of `pupil_mm_px` x |1 / depth - 1 / focus| pixels of diameter.

    A pixel is interpolated between two pictures blurred as a whole such that the second moment of
    its blur fits its own depth. At depth edges blurred light does not spill over what is sharp.

    Args:
        pupil_mm_px: Diameter of the pupil in mm times focal length in px.
    """
    radius = 0.5 * pupil_mm_px * np.abs(inverse_depth - 1.0 / focus_mm)
    radius = np.minimum(radius, _DISCS_PX[-1]).astype(np.float32)
    blurred = np.zeros_like(picture)
    for small, large in pairwise(_DISCS_PX):
        here = (radius >= small) & ((radius < large) | (large == _DISCS_PX[-1]))
        if not here.any():
            continue
        share = (radius**2 - small**2) / (large**2 - small**2)
        share = np.clip(share, 0.0, 1.0)[..., None]
        mixed = (1 - share) * _through_disc(picture, small) + share * _through_disc(picture, large)
        blurred[here] = mixed[here]
    return blurred


_DISCS_PX = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 9.0, 14.0)
"""Radii of the discs by which whole pictures are blurred; larger ones count as the last."""
_FINE = 15
"""Samples along a pixel's side when a disc is rasterised."""
_PIXEL_MOMENT = 1 / 12
"""Second moment of a pixel along one axis, px^2."""


def _through_disc(picture: LinearPicture, radius_px: float) -> LinearPicture:
    if radius_px == 0:
        return picture
    moment = radius_px**2 / 4
    if moment < _PIXEL_MOMENT:
        narrow = np.array([moment / 2, 1 - moment, moment / 2], np.float32)
        return cv2.sepFilter2D(picture, -1, narrow, narrow, borderType=cv2.BORDER_REPLICATE)
    half = int(np.ceil(radius_px))
    side = (np.arange((2 * half + 1) * _FINE) + 0.5) / _FINE - half - 0.5
    radius2 = 4 * (moment - _PIXEL_MOMENT)  # rasterising adds the moment of a pixel
    disc = (side[:, None] ** 2 + side**2 <= max(radius2, 1 / _FINE**2)).astype(np.float32)
    kernel = disc.reshape(2 * half + 1, _FINE, 2 * half + 1, _FINE).sum((1, 3))
    return cv2.filter2D(picture, -1, kernel / kernel.sum(), borderType=cv2.BORDER_REPLICATE)


def denoised(picture: ColourImage, strength: float) -> ColourImage:
    """Noise reduction of a phone: edge-preserving, slight in luma, strong in chroma."""
    if strength == 0:
        return picture
    ycc = cv2.cvtColor(picture, cv2.COLOR_RGB2YCrCb)
    luma, *colours = cv2.split(ycc)
    luma = cv2.bilateralFilter(luma, 5, _NOISE_TONES * strength, _NOISE_PX)
    smooth = [
        cv2.bilateralFilter(one, 9, 4 * _NOISE_TONES * strength, 2 * _NOISE_PX) for one in colours
    ]
    return np.asarray(cv2.cvtColor(cv2.merge([luma, *smooth]), cv2.COLOR_YCrCb2RGB), np.uint8)


_NOISE_TONES, _NOISE_PX = 6.0, 1.5
_SHARPENED_PX = 1.0


def sharpened(picture: ColourImage, amount: float) -> ColourImage:
    """Unsharp mask of the luma, with a blur of 1 px, after tone mapping."""
    if amount == 0:
        return picture
    ycc = cv2.cvtColor(picture, cv2.COLOR_RGB2YCrCb).astype(np.float32)
    blurred = cv2.GaussianBlur(ycc[..., 0], (0, 0), _SHARPENED_PX)
    ycc[..., 0] += amount * (ycc[..., 0] - blurred)
    tones = np.clip(np.rint(ycc), 0, 255).astype(np.uint8)
    return np.asarray(cv2.cvtColor(tones, cv2.COLOR_YCrCb2RGB), np.uint8)


def store_again(path: Path, quality: int) -> None:
    """Re-encode a photo in place, with chroma at half resolution; EXIF is kept."""
    with Image.open(path) as photo:
        exif = photo.getexif()
        picture = photo.convert("RGB")
    picture.save(path, "JPEG", quality=quality, subsampling="4:2:0", exif=exif)


def write_jpeg(picture: ColourImage, path: Path, lens: Lens, taken: str, quality: int) -> None:
    """Write a photo with the EXIF of its camera; `taken` as 2024:03:06 10:13:41."""
    exif = Image.Exif()
    exif[0x010F], exif[0x0110], exif[0x0112] = lens.make, lens.model, 1
    exif[0x0131] = "limbgram synthetic capture"
    exif[0x0132] = taken
    detail = exif.get_ifd(0x8769)
    detail[0x829A] = IFDRational(1, 200)
    detail[0x829D] = IFDRational(round(lens.aperture * 10), 10)
    detail[0x8827] = 100
    detail[0x9003] = detail[0x9004] = taken
    detail[0x9209] = 9
    detail[0x920A] = IFDRational(round(lens.focal_mm * 100), 100)
    detail[0xA002], detail[0xA003] = picture.shape[1], picture.shape[0]
    detail[0xA405] = round(lens.focal_mm * 36.0 / lens.sensor_width_mm)
    detail[0xA434] = lens.name
    Image.fromarray(picture).save(path, "JPEG", quality=quality, exif=exif)
