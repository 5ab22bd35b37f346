"""Two views: the epipolar geometry of pairs of photos, and their inlier matches."""

from limbgram.reconstruction.twoview.essential import (
    essential_from_fundamental,
    estimate_essential,
    fundamental_from_pose,
    pose_from_essential,
)
from limbgram.reconstruction.twoview.fundamental import (
    estimate_fundamental,
    estimate_fundamental_linear,
    refine_fundamental_gold_standard,
    refine_fundamental_sampson,
)
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair
from limbgram.reconstruction.twoview.verification import verify, verify_pair

__all__ = [
    "Pairs",
    "VerifiedPair",
    "essential_from_fundamental",
    "estimate_essential",
    "estimate_fundamental",
    "estimate_fundamental_linear",
    "fundamental_from_pose",
    "pose_from_essential",
    "refine_fundamental_gold_standard",
    "refine_fundamental_sampson",
    "verify",
    "verify_pair",
]
