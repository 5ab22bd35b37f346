"""Matching: which keypoint of one photo is which keypoint of another."""

from limbgram.reconstruction.matching.matching import (
    Matches,
    MatchingOptions,
    PairMatches,
    SelectionOptions,
    match,
)
from limbgram.reconstruction.matching.windows import WindowOptions

__all__ = [
    "Matches",
    "MatchingOptions",
    "PairMatches",
    "SelectionOptions",
    "WindowOptions",
    "match",
]
