"""Features: places in a photo that can be recognised in others."""

from limbgram.features.detection import FeatureOptions, detect, find_keypoints
from limbgram.features.keypoints import Features, Keypoints

__all__ = ["FeatureOptions", "Features", "Keypoints", "detect", "find_keypoints"]
