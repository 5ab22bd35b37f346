"""Matching: which keypoint of one photo is which keypoint of another."""

from limbgram.matching.matches import Matches, PairMatches
from limbgram.matching.matching import MatchingOptions, match
from limbgram.matching.selection import SelectionOptions
from limbgram.matching.windows import WindowOptions

__all__ = [
    "Matches",
    "MatchingOptions",
    "PairMatches",
    "SelectionOptions",
    "WindowOptions",
    "match",
]
