"""Features: places in a photo that can be recognised in others."""

from limbgram.reconstruction.features.detection import (
    FeatureOptions,
    Features,
    Keypoints,
    detect,
    find_keypoints,
)

__all__ = ["FeatureOptions", "Features", "Keypoints", "detect", "find_keypoints"]
