"""Keypoints of one photo: place, scale, orientation and descriptor."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, UInt8


@dataclass(frozen=True, kw_only=True)
class Keypoints:
    """SIFT keypoints, strongest and largest first.

    `scale_px` is the Gaussian sigma of detection in the photo; `angle_deg` as OpenCV has it
    (clockwise from +x, since y points down). Descriptors are RootSIFT, unit length times 512,
    so a squared distance of bytes is 512^2 times the squared Euclidean distance.
    """

    xy_px: Float32[np.ndarray, "n 2"]
    scale_px: Float32[np.ndarray, " n"]
    angle_deg: Float32[np.ndarray, " n"]
    descriptors: UInt8[np.ndarray, "n 128"]

    def __len__(self) -> int:
        return len(self.xy_px)


@dataclass(frozen=True)
class Features:
    """Keypoints of every photo of a PhotoSet, in its order."""

    keypoints: tuple[Keypoints, ...]
