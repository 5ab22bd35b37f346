"""Developing: from linear light to a JPEG as a camera writes it, with EXIF.

In      a linear picture, and how much blur and noise to add.
Out     8-bit sRGB; a JPEG file.
"""

from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float32, UInt8
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


def softened(picture: LinearPicture, blur_px: float) -> LinearPicture:
    """Blurred by the lens."""
    if blur_px <= 0:
        return picture
    return cv2.GaussianBlur(picture, (0, 0), blur_px, borderType=cv2.BORDER_REPLICATE)


def shaken(picture: LinearPicture, length_px: float, angle_rad: float) -> LinearPicture:
    """Blurred along a line that is centred on the true place."""
    half = int(np.ceil(length_px / 2)) + 1
    kernel = np.zeros((2 * half + 1, 2 * half + 1), np.float32)
    for along in np.linspace(-length_px / 2, length_px / 2, 16 * half + 1):
        x, y = half + along * np.cos(angle_rad), half + along * np.sin(angle_rad)
        i, j = int(y), int(x)
        for di, dj in ((0, 0), (0, 1), (1, 0), (1, 1)):
            kernel[i + di, j + dj] += (1 - abs(y - i - di)) * (1 - abs(x - j - dj))
    return cv2.filter2D(picture, -1, kernel / kernel.sum(), borderType=cv2.BORDER_REPLICATE)


def developed(picture: LinearPicture, noise: float, rng: np.random.Generator) -> ColourImage:
    """Photon and read noise, then sRGB tones."""
    sigma = noise * np.sqrt(_READ_NOISE**2 + _SHOT_NOISE * np.maximum(picture, 0))
    noisy = picture + sigma * rng.standard_normal(picture.shape, np.float32)
    return _TONE_OF_LIGHT[(np.clip(noisy, 0, 1) * (_TONES - 1) + 0.5).astype(np.uint16)]


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
