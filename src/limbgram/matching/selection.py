"""Selection: which pairs of photos are worth matching.

Method  the largest keypoints of every photo, their descriptors compressed to a few
        principal directions, are matched for all pairs. A pair's score is the number of matches
        that turn the picture by about the same angle. Each photo keeps its best partners, and
        its neighbours in the order of names, which is the walk round the limb.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from jaxtyping import Bool, Float32, Int32

from limbgram.features import Features, Keypoints
from limbgram.matching.descriptors import comparable, match_descriptors
from limbgram.run import in_parallel

_DIRECTIONS = 48
_SECTORS = 18
"""Sectors of turning angle; three neighbouring ones count together."""
_FEWEST_FOR_CHANGE = 8
"""Agreeing matches from which their change of scale is believed,"""
_SHARE_FOR_TURN = 0.5
"""and share of all matches from which their turn is: a few agree by chance."""


@dataclass(frozen=True, kw_only=True)
class SelectionOptions:
    """How many pairs to match."""

    keypoints: int = 1200
    """Largest keypoints of each photo in the coarse comparison."""
    max_ratio: float = 0.8
    """Largest ratio of the best to the second best distance in the coarse comparison."""
    partners: int = 7
    """Best partners of each photo."""
    neighbours: int = 2
    """Photos before and after in the order of names (the last meets the first): always matched."""
    min_score: int = 5
    """Pairs below this score are hopeless."""


@dataclass(frozen=True)
class Candidate:
    """A pair of photos worth matching, and how much scales change from first to second."""

    first: int
    second: int
    score: int
    scale_change: float | None
    """None where too few coarse matches tell."""
    turn_deg: float | None
    """How far the second photo is turned; None where the coarse matches do not agree."""


def select_pairs(features: Features, options: SelectionOptions) -> tuple[Candidate, ...]:
    """Pairs worth matching, in order of their photos."""
    largest = [_largest(keypoints, options.keypoints) for keypoints in features.keypoints]
    compressed = _compress([keypoints.descriptors for keypoints in largest])

    def compare(pair: tuple[int, int]) -> Candidate:
        first, second = pair
        matches = match_descriptors(compressed[first], compressed[second], options.max_ratio)
        return _score(pair, largest[first], largest[second], matches)

    count = len(largest)
    candidates = in_parallel(compare, list(combinations(range(count), 2)))
    kept = _neighbours(count, options.neighbours) | _partners(candidates, count, options)
    return tuple(c for c in candidates if (c.first, c.second) in kept)


def _largest(keypoints: Keypoints, count: int) -> Keypoints:
    return Keypoints(
        xy_px=keypoints.xy_px[:count],
        scale_px=keypoints.scale_px[:count],
        angle_deg=keypoints.angle_deg[:count],
        descriptors=keypoints.descriptors[:count],
    )


def _compress(descriptors: Sequence[np.ndarray]) -> list[Float32[np.ndarray, "n d"]]:
    """Descriptors along the directions in which they differ most, at unit length again."""
    rows = [comparable(part) for part in descriptors]
    scatter = sum(
        (part.T.astype(np.float64) @ part.astype(np.float64) for part in rows),
        np.zeros((128, 128)),
    )
    directions = np.linalg.eigh(scatter).eigenvectors[:, -_DIRECTIONS:].astype(np.float32)
    short = [part @ directions for part in rows]
    return [part / np.maximum(np.linalg.norm(part, axis=1, keepdims=True), 1e-6) for part in short]


def _score(
    pair: tuple[int, int], first: Keypoints, second: Keypoints, matches: Int32[np.ndarray, "k 2"]
) -> Candidate:
    """Matches that agree on how far the picture turns, and by how much it grows."""
    agreeing = matches[turning_alike(first, second, matches)]
    if len(agreeing) < _FEWEST_FOR_CHANGE:
        return Candidate(*pair, len(agreeing), scale_change=None, turn_deg=None)
    ratio = second.scale_px[agreeing[:, 1]] / first.scale_px[agreeing[:, 0]]
    clear = len(agreeing) > _SHARE_FOR_TURN * len(matches)
    return Candidate(
        *pair,
        len(agreeing),
        scale_change=float(np.median(ratio)),
        turn_deg=_mean_turn_deg(first, second, agreeing) if clear else None,
    )


def _mean_turn_deg(first: Keypoints, second: Keypoints, matches: Int32[np.ndarray, "k 2"]) -> float:
    turn = np.radians(second.angle_deg[matches[:, 1]] - first.angle_deg[matches[:, 0]])
    return float(np.degrees(np.arctan2(np.sin(turn).sum(), np.cos(turn).sum())))


def turning_alike(
    first: Keypoints, second: Keypoints, matches: Int32[np.ndarray, "k 2"]
) -> Bool[np.ndarray, " k"]:
    """Matches whose keypoints turn by about the same angle as most: within 60 degrees."""
    turn = second.angle_deg[matches[:, 1]] - first.angle_deg[matches[:, 0]]
    sector = (np.mod(turn, 360) * (_SECTORS / 360)).astype(np.int64) % _SECTORS
    votes = np.bincount(sector, minlength=_SECTORS)
    together = votes + np.roll(votes, 1) + np.roll(votes, -1)
    return (sector - int(together.argmax()) + 1) % _SECTORS <= 2


def _neighbours(count: int, reach: int) -> set[tuple[int, int]]:
    """Pairs at most `reach` apart in the ring."""
    pairs = {(i, (i + step) % count) for i in range(count) for step in range(1, reach + 1)}
    return {(min(pair), max(pair)) for pair in pairs if pair[0] != pair[1]}


def _partners(
    candidates: Sequence[Candidate], count: int, options: SelectionOptions
) -> set[tuple[int, int]]:
    """Pairs that are among the best of one of their photos."""
    hopeful = [c for c in candidates if c.score >= options.min_score]
    kept: set[tuple[int, int]] = set()
    for photo in range(count):
        own = [c for c in hopeful if photo in (c.first, c.second)]
        own.sort(key=lambda c: (-c.score, c.first, c.second))
        kept |= {(c.first, c.second) for c in own[: options.partners]}
    return kept
