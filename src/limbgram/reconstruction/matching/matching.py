"""Matching: keypoints of photos to matches between pairs of photos.

In      photos and their Features.
Out     Matches, the points of the second photo moved to sub-pixel agreement with the first.
Method  Which pairs are worth it: the largest keypoints of every photo, their descriptors compressed
        to a few principal directions, are matched for all pairs. A pair's score is the number of
        matches of consistent rotation. Each photo keeps its best partners,
        and its neighbours in the order of names, which is the walk round the limb.
        These are matched by nearest descriptors with ratio and mutual tests, and by correlation of
        the windows round each pair of keypoints.
Fails   MatchingError: the photos show too little, or hardly any pair matches.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int32

from limbgram.core.errors import MatchingError
from limbgram.core.run import in_parallel, spare_mb, worker_count
from limbgram.findings import doubt
from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.matching.descriptors import (
    RotationBand,
    ScaleBand,
    comparable,
    match_descriptors,
)
from limbgram.reconstruction.matching.windows import (
    Pyramid,
    build_pyramid,
    correlate,
)
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.photo import PhotoSet, first_of
from limbgram.reconstruction.photos.quality import common_fault


@dataclass(frozen=True, kw_only=True)
class PairMatches:
    """Matches between photo `first` and photo `second` (indices into PhotoSet.photos).

    `xy_first_px` are the keypoints of the first photo; `xy_second_px` those of the second, moved
    to sub-pixel agreement with the first by least-squares window matching where that was done.
    """

    first: int
    second: int
    keypoint_idx: Int32[np.ndarray, "m 2"]
    xy_first_px: Float64[np.ndarray, "m 2"]
    xy_second_px: Float64[np.ndarray, "m 2"]
    correlation: Float32[np.ndarray, " m"]
    """Normalized cross-correlation of the windows after refinement; NaN where not correlated."""

    @property
    def photos(self) -> tuple[int, int]:
        return self.first, self.second

    def __len__(self) -> int:
        return len(self.keypoint_idx)

    def some(self, keep: Bool[np.ndarray, " m"]) -> "PairMatches":
        """A subset, in the same order."""
        return replace(
            self,
            keypoint_idx=self.keypoint_idx[keep],
            xy_first_px=self.xy_first_px[keep],
            xy_second_px=self.xy_second_px[keep],
            correlation=self.correlation[keep],
        )


@dataclass(frozen=True, kw_only=True)
class Matches:
    """Matches of all pairs that were tried, and how many passed each test."""

    pairs: tuple[PairMatches, ...]
    pairs_tried: int
    descriptor_matches: int
    """Matches that passed ratio and mutual tests, before window correlation."""


_DIRECTIONS = 48
_SECTORS = 18
"""Sectors of turning angle; three neighbouring ones count together."""
_FEWEST_FOR_CHANGE = 10
"""Fewest agreeing matches that determine the change of scale."""
_SHARE_FOR_TURN = 0.5
"""Smallest share of matches that determine the rotation: a few agree by chance."""


_COARSE_RATIO = 0.8
"""Largest ratio of the best to the second best distance in the coarse comparison."""
_MIN_SCORE = 5
"""Score below which a pair is not matched."""
_SURVEY_KEYPOINTS = 400
"""Largest keypoints of each photo that are compared first where there are many photos."""
_SURVEY_PARTNERS = 20
"""Best partners by these with which a photo is then compared; of no more photos, all are."""
_COARSE_KEYPOINTS = 1200
"""Largest keypoints of each photo in the coarse comparison."""
_PARTNERS = 7
"""Best partners of each photo that are matched."""
_NEIGHBOURS = 2
"""Photos before and after in the order of names (the last meets the first): always matched."""


@dataclass(frozen=True)
class Candidate:
    """A pair of photos worth matching, and how much scales change from first to second."""

    first: int
    second: int
    score: int
    scale_change: float | None
    """None where too few coarse matches agree."""
    turn_deg: float | None
    """Rotation of the second photo; None where the coarse matches do not agree."""


def select_pairs(features: Features) -> tuple[Candidate, ...]:
    """Pairs worth matching, in order of their photos."""
    largest = [_largest(keypoints, _COARSE_KEYPOINTS) for keypoints in features.keypoints]
    compressed = _compress([keypoints.descriptors for keypoints in largest])

    def compare(pair: tuple[int, int], keypoints: int = _COARSE_KEYPOINTS) -> Candidate:
        first, second = (compressed[photo][:keypoints] for photo in pair)
        matches = match_descriptors(first, second, _COARSE_RATIO)
        return _score(pair, largest[pair[0]], largest[pair[1]], matches)

    def survey(pair: tuple[int, int]) -> Candidate:
        return compare(pair, _SURVEY_KEYPOINTS)

    count = len(largest)
    hopeful = list(combinations(range(count), 2))
    neighbours = _neighbours(count, _NEIGHBOURS)
    if count > _SURVEY_PARTNERS + 1:
        hopeful = sorted(neighbours | _surveyed(in_parallel(survey, hopeful), count))
    candidates = in_parallel(compare, hopeful)
    kept = neighbours | _partners(candidates, count)
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
    """The candidate, scored by its matches of consistent rotation, with its change of scale."""
    agreeing = matches[consistent_rotation(first, second, matches)]
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


def consistent_rotation(
    first: Keypoints, second: Keypoints, matches: Int32[np.ndarray, "k 2"]
) -> Bool[np.ndarray, " k"]:
    """Mask of the matches whose keypoints rotate as most do, within 60 degrees."""
    turn = second.angle_deg[matches[:, 1]] - first.angle_deg[matches[:, 0]]
    sector = (np.mod(turn, 360) * (_SECTORS / 360)).astype(np.int64) % _SECTORS
    votes = np.bincount(sector, minlength=_SECTORS)
    together = votes + np.roll(votes, 1) + np.roll(votes, -1)
    return (sector - int(together.argmax()) + 1) % _SECTORS <= 2


def _neighbours(count: int, reach: int) -> set[tuple[int, int]]:
    """Pairs at most `reach` apart in the ring."""
    pairs = {(i, (i + step) % count) for i in range(count) for step in range(1, reach + 1)}
    return {(min(pair), max(pair)) for pair in pairs if pair[0] != pair[1]}


def _surveyed(candidates: Sequence[Candidate], count: int) -> set[tuple[int, int]]:
    """Pairs of each photo with its best partners by the survey; with all where too few agree."""
    kept: set[tuple[int, int]] = set()
    for photo in range(count):
        own = [c for c in candidates if photo in (c.first, c.second)]
        own.sort(key=lambda c: (-c.score, c.first, c.second))
        agreeing = sum(c.score >= _MIN_SCORE for c in own)
        if agreeing >= _PARTNERS:
            own = own[:_SURVEY_PARTNERS]
        kept |= {(c.first, c.second) for c in own}
    return kept


def _partners(candidates: Sequence[Candidate], count: int) -> set[tuple[int, int]]:
    """Pairs that are among the best of one of their photos."""
    hopeful = [c for c in candidates if c.score >= _MIN_SCORE]
    kept: set[tuple[int, int]] = set()
    for photo in range(count):
        own = [c for c in hopeful if photo in (c.first, c.second)]
        own.sort(key=lambda c: (-c.score, c.first, c.second))
        kept |= {(c.first, c.second) for c in own[:_PARTNERS]}
    return kept


_UNKNOWN_CHANGE = 2.0
"""Factor by which more change of scale is allowed where the pair's own is not known."""
_PYRAMID_BYTES = 4 / 3
"""All levels of a photo, a pixel."""


_FINE_RATIO = 0.8
"""Largest ratio of the best to the second best distance."""
_MAX_SCALE_CHANGE = 1.5
"""Keypoints whose scales change by a larger factor than the pair does are not compared."""
FEW_KEYPOINTS = 200
"""A photo with fewer shows too little to be matched."""
_MEMORY_MB = 400.0
"""Memory for the photos of the pairs that are matched at a time."""
_FEWEST_MATCHES = 16
"""Of consistent rotation, of a pair."""


@dataclass(frozen=True)
class _Prepared:
    """Keypoints, descriptors and image pyramid of one photo."""

    keypoints: Keypoints
    descriptors: Float32[np.ndarray, "n 128"]
    pyramid: Pyramid


@dataclass(frozen=True)
class MatchedPair:
    """The matches of a pair, before it is accepted."""

    pair: PairMatches
    descriptor_matches: int
    consistent_rotation: int
    """Number of matches of consistent rotation."""


def match(photos: PhotoSet, features: Features) -> Matches:
    """Match the photos that are likely to show the same places.

    Raises:
        MatchingError: most photos show too little, or most match no other.
    """
    candidates = pairs_worth_matching(photos, features)
    return joined(photos, match_pairs(photos, features, candidates))


def match_what_there_is(photos: PhotoSet, features: Features) -> Matches:
    """As `match`, but photos with few keypoints are no refusal, since something else joins them."""
    candidates = select_pairs(features)
    matched = match_pairs(photos, features, candidates)
    return _joined(matched)


def pairs_worth_matching(photos: PhotoSet, features: Features) -> tuple[Candidate, ...]:
    """Pairs of photos that probably show the same places.

    Raises:
        MatchingError: most photos show too little.
    """
    _refuse_few_keypoints(photos, features)
    return select_pairs(features)


def match_pairs(
    photos: PhotoSet,
    features: Features,
    candidates: Sequence[Candidate],
) -> tuple[MatchedPair, ...]:
    """Match these pairs, each on its own."""
    described = max(map(len, features.keypoints), default=0)
    memory = PairMemory.of(photos, _MEMORY_MB, described=described)

    @lru_cache(maxsize=memory.photos)
    def prepared(photo_idx: int) -> _Prepared:
        keypoints = features.keypoints[photo_idx]
        return _Prepared(
            keypoints,
            comparable(keypoints.descriptors),
            build_pyramid(load_luma(photos.photos[photo_idx])),
        )

    def match_one(pair: Candidate) -> MatchedPair:
        return _match_pair(pair, prepared(pair.first), prepared(pair.second))

    return tuple(in_parallel(match_one, candidates, memory.workers))


def joined(photos: PhotoSet, matched: Sequence[MatchedPair]) -> Matches:
    """The pairs with enough matches of consistent rotation.

    Raises:
        MatchingError: most photos match no other.
    """
    found = _joined(matched)
    _refuse_unmatched(photos, found.pairs)
    return found


def _joined(matched: Sequence[MatchedPair]) -> Matches:
    return Matches(
        pairs=tuple(one.pair for one in matched if one.consistent_rotation >= _FEWEST_MATCHES),
        pairs_tried=len(matched),
        descriptor_matches=sum(one.descriptor_matches for one in matched),
    )


def _match_pair(pair: Candidate, first: _Prepared, second: _Prepared) -> MatchedPair:
    band = _scale_band(pair, first.keypoints, second.keypoints, _MAX_SCALE_CHANGE)
    turn = _turn(pair, first.keypoints, second.keypoints)
    found = match_descriptors(first.descriptors, second.descriptors, _FINE_RATIO, band, turn)
    windows = correlate(first.pyramid, second.pyramid, first.keypoints, second.keypoints, found)
    kept = found[windows.kept]
    matches = PairMatches(
        first=pair.first,
        second=pair.second,
        keypoint_idx=kept,
        xy_first_px=first.keypoints.xy_px[kept[:, 0]].astype(np.float64),
        xy_second_px=windows.xy_second_px[windows.kept],
        correlation=windows.correlation[windows.kept],
    )
    alike = consistent_rotation(first.keypoints, second.keypoints, kept)
    return MatchedPair(matches, len(found), int(alike.sum()))


def _scale_band(
    pair: Candidate, first: Keypoints, second: Keypoints, max_change: float
) -> ScaleBand:
    if pair.scale_change is None:
        factor = max_change * _UNKNOWN_CHANGE
        return ScaleBand(first.scale_px, second.scale_px, 1 / factor, factor)
    usual = pair.scale_change
    return ScaleBand(first.scale_px, second.scale_px, usual / max_change, usual * max_change)


def _turn(pair: Candidate, first: Keypoints, second: Keypoints) -> RotationBand | None:
    if pair.turn_deg is None:
        return None
    return RotationBand(first.angle_deg, second.angle_deg, pair.turn_deg)


@dataclass(frozen=True)
class PairMemory:
    """How many pairs are matched at a time, and photos kept, within a limit of memory."""

    workers: int
    photos: int

    @classmethod
    def of(
        cls, photos: PhotoSet, most_mb: float, *, described: int = 0, halvings: int = 0
    ) -> "PairMemory":
        """As many pairs at a time as fit, and then as many photos kept for the next ones.

        `described` descriptors are kept of a photo at most; photos are halved `halvings` times.
        """
        pixels = max((photo.width_px * photo.height_px for photo in photos.photos), default=1)
        levels_bytes = _PYRAMID_BYTES / 4**halvings
        kept_mb = (pixels * levels_bytes + described * 128 * 4) / 2**20
        # its levels lie there twice
        making_mb = in_flight_mb(photos.photos, levels_bytes, halvings=halvings)
        workers = int(np.clip(spare_mb() / (2 * kept_mb + making_mb), 1, worker_count()))
        room_mb = min(most_mb, spare_mb() - workers * making_mb)
        return cls(workers, max(2 * workers, int(room_mb / kept_mb)))


def _refuse_few_keypoints(photos: PhotoSet, features: Features) -> None:
    counts = [len(keypoints) for keypoints in features.keypoints]
    bare = [name for name, n in zip(photos.names, counts) if n < FEW_KEYPOINTS]
    if 2 * len(bare) > len(counts):
        raise MatchingError(
            "pairs.bare",
            bare=len(bare),
            count=len(counts),
            keypoints=int(np.median(counts)),
            **first_of(bare),
            cause=common_fault(photos.photos) or doubt("pairs.plain"),
        )


def _refuse_unmatched(photos: PhotoSet, pairs: Sequence[PairMatches]) -> None:
    met = {photo for pair in pairs for photo in (pair.first, pair.second)}
    strangers = [name for index, name in enumerate(photos.names) if index not in met]
    if 2 * len(strangers) > len(photos.names):
        raise MatchingError(
            "pairs.strangers",
            strangers=len(strangers),
            count=len(photos.names),
            **first_of(strangers),
            cause=common_fault(photos.photos) or doubt("pairs.apart"),
        )
