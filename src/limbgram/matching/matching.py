"""Matching: keypoints of photos to matches between pairs of photos.

In      photos and their Features.
Out     Matches, the points of the second photo moved to sub-pixel agreement with the first.
Method  pairs by a coarse comparison; minimum Euclidean distance of descriptors with ratio and
        mutual tests; correlation of the windows round each pair.
Fails   MatchingError: the photos show too little, or hardly any pair matches.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from jaxtyping import Float32

from limbgram.errors import MatchingError
from limbgram.features import Features, Keypoints
from limbgram.matching.descriptors import ScaleBand, Turn, comparable, match_descriptors
from limbgram.matching.matches import Matches, PairMatches
from limbgram.matching.pyramid import Pyramid, build_pyramid
from limbgram.matching.selection import Candidate, SelectionOptions, select_pairs, turning_alike
from limbgram.matching.windows import WindowOptions, correlate
from limbgram.photos import PhotoSet, common_fault, in_flight_mb, load_luma
from limbgram.run import in_parallel, spare_mb, worker_count

_UNKNOWN_CHANGE = 2.0
"""Factor by which more change of scale is allowed where the pair's own is not known."""
_NAMED_AT_MOST = 6
_PYRAMID_BYTES = 4 / 3
"""All levels of a photo, a pixel."""
_PLAIN = (
    "No blur and no wrong exposure was measured, so the sock is probably plain. Paint irregular "
    "spots of several sizes all over it."
)
_APART = (
    "The photos probably lie too far apart, or the limb has too few marks. Walk round it with 15 "
    "or more photos a round, so that each shows most of what the one before shows, and paint "
    "irregular spots all over the sock."
)


@dataclass(frozen=True, kw_only=True)
class MatchingOptions:
    """Which pairs are matched, and what a match must stand."""

    selection: SelectionOptions = field(default_factory=SelectionOptions)
    """Which pairs are matched."""
    windows: WindowOptions = field(default_factory=WindowOptions)
    """What window correlation accepts."""
    max_ratio: float = 0.8
    """Largest ratio of the best to the second best distance."""
    max_scale_change: float = 1.5
    """Keypoints whose scales change by a larger factor than the pair does are not compared."""
    min_matches: int = 16
    """Pairs with fewer matches that turn the picture by about the same angle are left out."""
    few_keypoints: int = 200
    """A photo with fewer shows too little to be matched."""
    memory_mb: float = 400.0
    """Memory for the photos of the pairs in hand."""


DEFAULTS = MatchingOptions()


@dataclass(frozen=True)
class _Prepared:
    """What pairs need of one photo."""

    keypoints: Keypoints
    descriptors: Float32[np.ndarray, "n 128"]
    pyramid: Pyramid


def match(photos: PhotoSet, features: Features, options: MatchingOptions = DEFAULTS) -> Matches:
    """Match the photos that are likely to show the same places.

    Raises:
        MatchingError: most photos show too little, or most match no other.
    """
    _refuse_bare(photos, features, options)
    candidates = select_pairs(features, options.selection)

    memory = _memory(photos, features, options.memory_mb)

    @lru_cache(maxsize=memory.photos)
    def prepared(photo_idx: int) -> _Prepared:
        keypoints = features.keypoints[photo_idx]
        return _Prepared(
            keypoints,
            comparable(keypoints.descriptors),
            build_pyramid(load_luma(photos.photos[photo_idx])),
        )

    def match_one(pair: Candidate) -> _Matched:
        return _match_pair(pair, prepared(pair.first), prepared(pair.second), options)

    matched = in_parallel(match_one, candidates, memory.workers)
    pairs = tuple(m.pair for m in matched if m.turning_alike >= options.min_matches)
    _refuse_strangers(photos, pairs)
    return Matches(
        pairs=pairs,
        pairs_tried=len(candidates),
        descriptor_matches=sum(m.descriptor_matches for m in matched),
    )


@dataclass(frozen=True)
class _Matched:
    pair: PairMatches
    descriptor_matches: int
    turning_alike: int


def _match_pair(
    pair: Candidate, first: _Prepared, second: _Prepared, options: MatchingOptions
) -> _Matched:
    band = _scale_band(pair, first.keypoints, second.keypoints, options.max_scale_change)
    turn = _turn(pair, first.keypoints, second.keypoints)
    found = match_descriptors(first.descriptors, second.descriptors, options.max_ratio, band, turn)
    windows = correlate(
        first.pyramid, second.pyramid, first.keypoints, second.keypoints, found, options.windows
    )
    kept = found[windows.kept]
    matches = PairMatches(
        first=pair.first,
        second=pair.second,
        keypoint_idx=kept,
        xy_first_px=first.keypoints.xy_px[kept[:, 0]].astype(np.float64),
        xy_second_px=windows.xy_second_px[windows.kept],
        correlation=windows.correlation[windows.kept],
    )
    alike = turning_alike(first.keypoints, second.keypoints, kept)
    return _Matched(matches, len(found), int(alike.sum()))


def _scale_band(
    pair: Candidate, first: Keypoints, second: Keypoints, max_change: float
) -> ScaleBand:
    if pair.scale_change is None:
        factor = max_change * _UNKNOWN_CHANGE
        return ScaleBand(first.scale_px, second.scale_px, 1 / factor, factor)
    usual = pair.scale_change
    return ScaleBand(first.scale_px, second.scale_px, usual / max_change, usual * max_change)


def _turn(pair: Candidate, first: Keypoints, second: Keypoints) -> Turn | None:
    if pair.turn_deg is None:
        return None
    return Turn(first.angle_deg, second.angle_deg, pair.turn_deg)


@dataclass(frozen=True)
class _Memory:
    """What there is room for at a time."""

    workers: int
    photos: int


def _memory(photos: PhotoSet, features: Features, most_mb: float) -> _Memory:
    """As many pairs at a time as fit, and then as many photos kept for the next ones."""
    pixels = max((photo.width_px * photo.height_px for photo in photos.photos), default=1)
    described = max(map(len, features.keypoints), default=0)
    kept_mb = (pixels * _PYRAMID_BYTES + described * 128 * 4) / 2**20
    making_mb = in_flight_mb(photos.photos, _PYRAMID_BYTES)  # its levels lie there twice
    workers = int(np.clip(spare_mb() / (2 * kept_mb + making_mb), 1, worker_count()))
    room_mb = min(most_mb, spare_mb() - workers * making_mb)
    return _Memory(workers, max(2 * workers, int(room_mb / kept_mb)))


def _refuse_bare(photos: PhotoSet, features: Features, options: MatchingOptions) -> None:
    counts = [len(keypoints) for keypoints in features.keypoints]
    bare = [name for name, n in zip(photos.names, counts) if n < options.few_keypoints]
    if 2 * len(bare) > len(counts):
        raise MatchingError(
            f"{len(bare)} of {len(counts)} photos show hardly anything that can be recognised "
            f"({int(np.median(counts))} keypoints in the middle one): {_named(bare)}. "
            + (common_fault(photos.photos) or _PLAIN)
        )


def _refuse_strangers(photos: PhotoSet, pairs: Sequence[PairMatches]) -> None:
    met = {photo for pair in pairs for photo in (pair.first, pair.second)}
    strangers = [name for index, name in enumerate(photos.names) if index not in met]
    if 2 * len(strangers) > len(photos.names):
        raise MatchingError(
            f"{len(strangers)} of {len(photos.names)} photos show nothing that another photo shows "
            f"too: {_named(strangers)}. " + (common_fault(photos.photos) or _APART)
        )


def _named(names: Sequence[str]) -> str:
    more = len(names) - _NAMED_AT_MOST
    return ", ".join(names[:_NAMED_AT_MOST]) + (f" and {more} more" if more > 0 else "")
