"""Matching: which keypoint of one photo is which keypoint of another."""

from limbgram.reconstruction.matching.matching import (
    Matches,
    PairMatches,
    match,
)

__all__ = [
    "Matches",
    "PairMatches",
    "match",
]
