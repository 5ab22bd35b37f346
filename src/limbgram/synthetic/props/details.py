"""Details: fine relief of a skin or its sock: knit, veins, scars, wrinkles. Part of the truth.

In      the rings of a skin, the height of each kind of detail, a seed.
Out     the height of every point above the skin.
Method  The knit is a regular weave round the limb; on the slim end, where its stitches would run
        together, it is a flat piece of the same fabric. Veins are random walks up the skin, with
        branches, and scars short, nearly straight ones; a point has the height of the nearest one.
        Wrinkles are folds round the limb in a band above the cut, highest on one side.
Limits  the mesh resolves a detail with four edges or more to its finest length.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.ndimage import map_coordinates
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points3

RingGrid = Float64[np.ndarray, "rows columns 3"]
"""Points in rings: rows from the cut upwards, columns round the limb."""
_WALK_MM = 0.5
_VEINS, _BRANCHES, _SCARS = 4, 2, 3
_VEIN_WIDTHS_MM, _SCAR_WIDTHS_MM = (2.0, 5.0), (1.0, 3.0)
"""At half their height."""
_FOLDS_MM = (5.0, 15.0)
"""Distance between neighbouring folds."""
_FADE_MM = 8.0
_SLIM = 0.65, 0.8
"""Shares of the median girth between which the knit blends into the flat piece."""
_EDGES_TO_FINEST = 4


@dataclass(frozen=True, kw_only=True)
class SkinDetails:
    """Height of each kind of detail, 0 for none; places and sizes follow from the seed."""

    knit_mm: float = 0.0
    """Peak to valley; usual 0.1."""
    knit_period_mm: float = 1.5
    """Distance between stitches."""
    veins_mm: float = 0.0
    """Height of the widest, 5 mm wide; narrower ones are lower, down to 2 mm. Usual 0.7."""
    scars_mm: float = 0.0
    """Depth of the deepest groove; they are 1 to 3 mm wide. Usual 0.7."""
    wrinkles_mm: float = 0.0
    """Height of the highest fold; they lie 5 to 15 mm apart. Usual 1.0."""

    @property
    def any(self) -> bool:
        return max(self.knit_mm, self.veins_mm, self.scars_mm, self.wrinkles_mm) > 0

    @property
    def coarsest_step_mm(self) -> float:
        """The longest edge of the truth's triangles that carries them all."""
        finest = (
            (self.knit_mm, self.knit_period_mm),
            (self.veins_mm, 2 * _VEIN_WIDTHS_MM[0]),
            (self.scars_mm, 2 * _SCAR_WIDTHS_MM[0]),
            (self.wrinkles_mm, _FOLDS_MM[0]),
        )
        return min((long for high, long in finest if high > 0), default=np.inf) / _EDGES_TO_FINEST


PLAIN = SkinDetails()


def details_mm(
    skin: RingGrid, details: SkinDetails, seed: int
) -> Float64[np.ndarray, "rows columns"]:
    """Height of each point of the rings, from the rim to the pole, along its normal.

    Each kind has its own random numbers, so that it is the same with and without the others.
    """
    raised = np.zeros(skin.shape[:2])
    if details.knit_mm > 0:
        raised += details.knit_mm * _knit(skin, details.knit_period_mm)
    if details.veins_mm > 0:
        cords = _veins(skin, np.random.default_rng((seed, 41)))
        raised += details.veins_mm * _height_of(skin, cords)
    if details.scars_mm > 0:
        cords = _scars(skin, np.random.default_rng((seed, 42)))
        raised -= details.scars_mm * _height_of(skin, cords)
    if details.wrinkles_mm > 0:
        raised += details.wrinkles_mm * _wrinkles(skin, np.random.default_rng((seed, 43)))
    return raised


def _knit(skin: RingGrid, period_mm: float) -> Float64[np.ndarray, "rows columns"]:
    """A plain weave, heights from -0.5 to 0.5."""
    girth = _girths_mm(skin)
    stitches = round(float(np.median(girth)) / period_mm)
    around = np.cos(2 * np.pi * stitches * np.arange(skin.shape[1]) / skin.shape[1])
    along = np.cos(2 * np.pi * _lengths_mm(skin) / period_mm)
    flat = np.cos(2 * np.pi * skin[..., :2] / period_mm).prod(-1)
    share = (girth / float(np.median(girth)) - _SLIM[0]) / (_SLIM[1] - _SLIM[0])
    tube = np.clip(share, 0.0, 1.0)[:, None]
    return 0.5 * (tube * along[:, None] * around + (1 - tube) * flat)


@dataclass(frozen=True)
class _Cords:
    """Round ridges on the skin, as points along their crests."""

    points_mm: Points3
    width_mm: Float64[np.ndarray, " n"]
    """Full width at half height."""
    height: Float64[np.ndarray, " n"]
    """Relative to the highest."""


@dataclass(frozen=True, kw_only=True)
class _Start:
    """Start of a walk."""

    along_mm: float
    """Length along the skin from the rim."""
    around: float
    """Share of the way round."""
    heading_rad: float
    """From straight up, towards growing `around`."""


@dataclass(frozen=True)
class _Walk:
    """Points of a walk, `_WALK_MM` apart; the fields as in `_Start`."""

    along_mm: Float64[np.ndarray, " n"]
    around: Float64[np.ndarray, " n"]
    heading_rad: Float64[np.ndarray, " n"]


def _veins(skin: RingGrid, rng: np.random.Generator) -> _Cords:
    whole_mm = float(_lengths_mm(skin)[-1])
    cords: list[_Cords] = []
    for number in range(_VEINS):
        start = _Start(
            along_mm=rng.uniform(0.04, 0.25) * whole_mm,
            around=(number + rng.uniform(0.0, 0.7)) / _VEINS,
            heading_rad=rng.uniform(-0.4, 0.4),
        )
        wide = rng.uniform(0.7, 1.0) * _VEIN_WIDTHS_MM[1]
        walk = _walked(skin, start, rng.uniform(0.4, 0.7) * whole_mm, 0.06, rng)
        cords.append(_vein(skin, walk, wide, both_ends=True))
        for side in rng.permutation([-1.0, 1.0])[:_BRANCHES]:
            at = int(rng.uniform(0.2, 0.7) * len(walk.around))
            fork = _Start(
                along_mm=float(walk.along_mm[at]),
                around=float(walk.around[at]),
                heading_rad=float(walk.heading_rad[at] + side * rng.uniform(0.5, 0.9)),
            )
            branch = _walked(skin, fork, rng.uniform(0.15, 0.3) * whole_mm, 0.06, rng)
            cords.append(_vein(skin, branch, 0.7 * wide, both_ends=False))
    return _together(cords)


def _vein(skin: RingGrid, walk: _Walk, wide_mm: float, *, both_ends: bool) -> _Cords:
    """A vein that narrows towards its end and fades there or, with `both_ends`, at its root too."""
    count = len(walk.around)
    share = np.arange(count) / max(1, count - 1)
    width = np.maximum(_VEIN_WIDTHS_MM[0], wide_mm * (1.0 - 0.5 * share))
    faded = _faded(count, both_ends=both_ends)
    return _Cords(_points(skin, walk), width, faded * width / _VEIN_WIDTHS_MM[1])


def _scars(skin: RingGrid, rng: np.random.Generator) -> _Cords:
    whole_mm = float(_lengths_mm(skin)[-1])
    cords: list[_Cords] = []
    for number in range(_SCARS):
        start = _Start(
            along_mm=rng.uniform(0.2, 0.75) * whole_mm,
            around=(number + rng.uniform(0.0, 0.7)) / _SCARS,
            heading_rad=rng.uniform(-np.pi, np.pi),
        )
        walk = _walked(skin, start, rng.uniform(30.0, 80.0), 0.02, rng)
        count = len(walk.around)
        width = np.full(count, rng.uniform(*_SCAR_WIDTHS_MM))
        deep = rng.uniform(0.5, 1.0) if number else 1.0
        cords.append(_Cords(_points(skin, walk), width, deep * _faded(count, both_ends=True)))
    return _together(cords)


def _together(cords: list[_Cords]) -> _Cords:
    return _Cords(
        np.concatenate([one.points_mm for one in cords]),
        np.concatenate([one.width_mm for one in cords]),
        np.concatenate([one.height for one in cords]),
    )


def _faded(count: int, *, both_ends: bool) -> Float64[np.ndarray, " n"]:
    """1, falling to 0 over the last `_FADE_MM`."""
    from_end = _WALK_MM * np.arange(count)[::-1]
    if both_ends:
        from_end = np.minimum(from_end, from_end[::-1])
    return np.sin(0.5 * np.pi * np.clip(from_end / _FADE_MM, 0.0, 1.0)) ** 2


def _walked(
    skin: RingGrid, start: _Start, length_mm: float, sway: float, rng: np.random.Generator
) -> _Walk:
    """A random walk on the skin about a heading; it ends before the rim or the pole."""
    lengths, girths = _lengths_mm(skin), _girths_mm(skin)
    along, around, heading = start.along_mm, start.around, start.heading_rad
    kept: list[tuple[float, float, float]] = []
    for turn in rng.normal(0.0, sway, max(2, round(length_mm / _WALK_MM))):
        if kept and not 0.02 * lengths[-1] < along < 0.92 * lengths[-1]:
            break
        kept.append((along, around, heading))
        heading += turn - 0.02 * (heading - start.heading_rad)
        along += _WALK_MM * np.cos(heading)
        around += _WALK_MM * np.sin(heading) / float(np.interp(along, lengths, girths))
    walk = np.array(kept)
    return _Walk(walk[:, 0], walk[:, 1], walk[:, 2])


def _points(skin: RingGrid, walk: _Walk) -> Points3:
    """The points of a walk in space."""
    rows = np.interp(walk.along_mm, _lengths_mm(skin), np.arange(len(skin)))
    at = np.stack([rows, walk.around * skin.shape[1]])
    wrapped = np.concatenate([skin, skin[:, :1]], axis=1)
    at[1] %= skin.shape[1]
    return np.stack([map_coordinates(wrapped[..., k], at, order=1) for k in range(3)], -1)


def _height_of(skin: RingGrid, cords: _Cords) -> Float64[np.ndarray, "rows columns"]:
    """Height of each point on the nearest ridge, whose cross-section is a Gaussian."""
    reach = 2.0 * float(cords.width_mm.max())
    points = skin.reshape(-1, 3)
    found = KDTree(cords.points_mm).query(points, distance_upper_bound=reach)
    away, nearest = np.asarray(found[0]), np.asarray(found[1])
    near = np.isfinite(away)
    crest = nearest[near]
    height = np.zeros(len(points))
    gaussian = np.exp(-4 * np.log(2.0) * (away[near] / cords.width_mm[crest]) ** 2)
    height[near] = cords.height[crest] * gaussian
    return height.reshape(skin.shape[:2])


def _wrinkles(skin: RingGrid, rng: np.random.Generator) -> Float64[np.ndarray, "rows columns"]:
    """Folds with narrow valleys between them, heights from 0 to 1."""
    lengths = _lengths_mm(skin)
    middle, spread = rng.uniform(0.22, 0.3) * lengths[-1], rng.uniform(0.08, 0.12) * lengths[-1]
    angle = 2 * np.pi * np.arange(skin.shape[1]) / skin.shape[1]
    waves, phases = rng.uniform(-3.0, 3.0, 3), rng.uniform(0, 2 * np.pi, 3)
    turns = np.arange(1, 4)
    wobble = (waves / turns) @ np.cos(turns[:, None] * angle + phases[:, None])
    gaps = rng.uniform(*_FOLDS_MM, round(2 * lengths[-1] / _FOLDS_MM[0]))
    valleys = np.cumsum(gaps) - 10.0 - rng.uniform(*_FOLDS_MM)
    number = np.interp(lengths[:, None] + wobble, valleys, np.arange(len(valleys)))
    heights = rng.uniform(0.5, 1.0, len(valleys))
    fold = np.abs(np.sin(np.pi * number)) ** 0.75
    behind = rng.uniform(0, 2 * np.pi)
    on_side = 0.3 + 0.7 * (0.5 + 0.5 * np.cos(angle - behind)) ** 2
    band = np.exp(-0.5 * ((lengths - middle) / spread) ** 2)
    folds = fold * heights[number.astype(int)] * band[:, None] * on_side
    return folds / folds.max()


def _lengths_mm(skin: RingGrid) -> Float64[np.ndarray, " rows"]:
    """Length along the skin from the rim, the mean of all columns."""
    steps = np.linalg.norm(np.diff(skin, axis=0), axis=2).mean(1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _girths_mm(skin: RingGrid) -> Float64[np.ndarray, " rows"]:
    around = np.linalg.norm(np.roll(skin, -1, axis=1) - skin, axis=2).sum(1)
    return np.maximum(around, 1e-6)
