"""Significance: where a mean over few pairs is more than their differences make by chance.

In      fields (h a) of the pairs on one chart, NaN where a pair knows nothing.
Out     robust mean and spread of each node; the nodes where all pairs did alike.
Method  the mean over its standard error is held against what it comes to where nothing was done:
        on fields drawn at random, as rough as what the pairs differ by. No table of Student's
        fits: the mean is robust, spreads are pooled over nodes, and neighbours are alike. False
        discoveries by Benjamini and Hochberg (1995), at a level at which drawn limbs, in which
        every discovery is false, have any no more often than asked.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.ndimage import gaussian_filter, median_filter

from limbgram.shape.templates.fields import Field

Fields = Float64[np.ndarray, "p h a"]

_HUBER = 1.5
_ROUNDS = 20
_SMALLEST_SPREAD_MM = 0.02
_POOLED_NODES = 1.5
_DRAWN = 150
"""Limbs to which nothing was done; their nodes together tell small chances."""
_SEED = 1995
_SOFT_NODES = 0.7
_PAD = 8


def robust(fields: Fields) -> tuple[Field, Field]:
    """Huber's mean over the pairs, and their standard deviation, pooled with near nodes."""
    known = np.isfinite(fields)
    count = known.sum(0)
    filled = np.where(known, fields, 0.0)
    centre = _median(fields, count)
    scale = 1.4826 * _median(np.abs(fields - centre), count)
    scale = np.maximum(scale, _SMALLEST_SPREAD_MM)
    weights = known.astype(float)
    for _ in range(_ROUNDS):
        size = np.maximum(np.abs(filled - centre), 1e-12)
        weights = np.where(known, np.minimum(1.0, _HUBER * scale / size), 0.0)
        centre = (weights * filled).sum(0) / np.maximum(weights.sum(0), 1e-12)
    square = (weights * (filled - centre) ** 2).sum(0) / np.maximum(weights.sum(0), 1e-12)
    square *= count / np.maximum(count - 1, 1)
    several = (count >= 2).astype(float)
    pooled = _blurred(square * several, _POOLED_NODES) / np.maximum(
        _blurred(several, _POOLED_NODES), 1e-12
    )
    spread = np.where(count >= 2, np.maximum(np.sqrt(pooled), _SMALLEST_SPREAD_MM), np.nan)
    return np.where(count > 0, centre, np.nan), spread


def found_alike(fields: Fields, false_share: float) -> Bool[np.ndarray, "h a"]:
    """Nodes whose mean is more than chance; of one pair alone, every node that it knows."""
    tested = np.isfinite(fields).sum(0) >= 2
    if not tested.any():
        return np.asarray(np.isfinite(fields).any(0))
    drawn = np.stack([np.sort(_ratios(some)[tested]) for some in _drawn(fields)])
    by_chance = np.sort(drawn, axis=None)
    chance = _chances(_ratios(fields)[tested], by_chance)
    least = np.array([_simes(np.sort(_chances(one, by_chance))) for one in drawn])
    level = min(false_share, float(np.quantile(least, false_share)))
    order = np.sort(chance)
    passed = order[order <= level * np.arange(1, len(order) + 1) / len(order)]
    kept = np.zeros(tested.shape)
    kept[tested] = chance <= (passed.max() if len(passed) else -1.0)
    return _wrapped(median_filter(_padded(kept), 3)) > 0


def softened(kept: Bool[np.ndarray, "h a"]) -> Field:
    """1 well within what is kept, 0 well outside, and no step between."""
    return _blurred(kept.astype(float), _SOFT_NODES)


def _median(fields: Fields, count: Int64[np.ndarray, "h a"]) -> Field:
    """Of what is known; 0 where nothing is."""
    order = np.sort(fields, axis=0)  # NaN comes last
    low, high = np.maximum(count - 1, 0) // 2, np.minimum(count // 2, len(fields) - 1)
    middle = [np.take_along_axis(order, place[None], axis=0)[0] for place in (low, high)]
    return np.nan_to_num((middle[0] + middle[1]) / 2)


def _ratios(fields: Fields) -> Field:
    """The mean in standard errors, without sign."""
    mean, spread = robust(fields)
    return np.abs(mean) / spread * np.sqrt(np.isfinite(fields).sum(0))


def _drawn(fields: Fields) -> Iterator[Fields]:
    """Limbs to which nothing was done alike, each of as many pairs, that know what these know.

    Each is what the pairs differ by, mixed at random and turned at random round the limb wave by
    wave: every height stays as rough as it is, and goes on into the next as it does.
    """
    known = np.isfinite(fields)
    mean = np.where(known, fields, 0.0).sum(0) / np.maximum(known.sum(0), 1)
    waves = np.fft.rfft(np.where(known, fields - mean, 0.0), axis=2)
    pairs, _, columns = fields.shape
    dice = np.random.default_rng(_SEED)
    for _ in range(_DRAWN):
        noise = np.fft.rfft(dice.normal(size=(pairs, pairs, columns)), axis=2)
        mixed = np.einsum("pqm,qhm->phm", noise, waves) / np.sqrt(columns * max(pairs - 1, 1))
        yield np.where(known, np.fft.irfft(mixed, n=columns, axis=2), np.nan)


def _chances(
    ratios: Float64[np.ndarray, " n"], by_chance: Float64[np.ndarray, " m"]
) -> Float64[np.ndarray, " n"]:
    """Share of the drawn ratios that are as large."""
    larger = len(by_chance) - np.searchsorted(by_chance, ratios, side="left")
    return (larger + 1.0) / (len(by_chance) + 1)


def _simes(order: Float64[np.ndarray, " n"]) -> float:
    """Level at which the first false discovery would be made."""
    return float((order * len(order) / np.arange(1, len(order) + 1)).min())


def _blurred(values: Field, nodes: float) -> Field:
    return _wrapped(gaussian_filter(_padded(values), nodes))


def _padded(values: Field) -> Field:
    """The first row goes on below and the last above; columns go on round the limb."""
    return np.pad(np.pad(values, ((_PAD, _PAD), (0, 0)), "edge"), ((0, 0), (_PAD, _PAD)), "wrap")


def _wrapped(padded: Field) -> Field:
    return np.asarray(padded)[_PAD:-_PAD, _PAD:-_PAD]
