"""Resizing: a photo's brightness with fewer pixels."""

import cv2
import numpy as np
from jaxtyping import UInt8

from limbgram.core.geometry.arrays import GreyImage


def downsampled(luma: GreyImage, factor: float) -> UInt8[np.ndarray, "small_h small_w"]:
    """The picture with sides `factor` times as long, by area averaging; as it is from 1 on.

    Pixel centres keep their place: x_small = (x + 0.5) * factor - 0.5, but for rounded sides.
    """
    if factor >= 1.0:
        return luma
    height_px, width_px = luma.shape
    size = (round(width_px * factor), round(height_px * factor))
    small = cv2.resize(luma, size, interpolation=cv2.INTER_AREA)
    return small.astype(np.uint8, copy=False)
