"""Learning: the clinic's own rectification, from shapes before and after it.

In      pairs of Limbs: before (aligned, with landmarks) and after.
Out     a Template.
Method  The after is laid on the before. Rays along the before's normals meet the after, by Newton's
        steps on its nearest triangles; the displacements of all pairs come on one chart. Kept are a
        robust mean and spread over the pairs, where the mean is significant and not negligible: the
        mean over its standard error is held against what it comes to where nothing was done, on
        fields drawn at random, as rough as what the pairs differ by. No table of Student's fits:
        the mean is robust, spreads are pooled over nodes, and neighbours are alike. False
        discoveries are held down by Benjamini and Hochberg (1995), at a level at which drawn limbs,
        in which every discovery is false, have any no more often than asked.
Fails   MeasureError: a pair without frame or shared landmark. OptionsError: sides mixed.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.interval import MAD_TO_SIGMA, rms
from limbgram.core.notebook import brief
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.anatomy.names import landmarks_by_identity
from limbgram.workbench.compare.comparison import align_shapes
from limbgram.workbench.compare.counterparts import CounterpartSurface, measured_faces
from limbgram.workbench.compare.deviation import sample_evenly
from limbgram.workbench.compare.frames import (
    axes_of,
    brim_height_mm,
    mesh_in_frame,
    outside_by_name,
)
from limbgram.workbench.compare.registration import Alignment, RegistrationOptions
from limbgram.workbench.limb import AlignedLimb, Limb
from limbgram.workbench.templates.chart_field import Field, fit_field, node_heights
from limbgram.workbench.templates.charts import (
    Along,
    LimbChart,
    centreline_of_kind,
    marks_on,
    plain_chart,
    pulled_chart,
)
from limbgram.workbench.templates.template import Template, TemplateMark

_SAMPLES = 25_000
_STEPS = 8
_HIT_MM = 0.02
_CONVERGED_MM = 2e-3
_LEAST_COSINE = 0.3
"""Least cosine between the normals of both shapes along which a displacement is taken."""
_MOST_MM, _MOST_RMS_MM = 15.0, 5.0
"""A rectification moves no finger tip of a limb by more, nor the whole of it (root mean square)."""
_NEARLY_ALL = 0.995
Fields = Float64[np.ndarray, "p h a"]
_HUBER = 1.5
_ROUNDS = 20
_SMALLEST_SPREAD_MM = 0.02
_POOLED_NODES = 1.5
_NULL_SAMPLES = 150
"""Limbs to which nothing was done; their nodes together tell small chances."""
_SEED = 1995
_MASK_BLUR_NODES = 0.7
_PAD = 8
_TOPS: Final[Mapping[Along, float]] = {"axis": 1.6, "centreline": 3.0}
"""Chart heights up to which templates are learned: a limb's brim, a shank over its malleoli."""
_DECIMALS = 2
"""Of displacements, as the file keeps them: one from a file is the one that was learned."""


_FALSE_SHARE = 0.05
"""Of the nodes that are kept, at most this share by chance."""
_LEAST_MM, _FARTHEST_MM = 0.1, 30.0
"""Smaller mean displacements are not kept; larger ones are no rectification."""


@dataclass(frozen=True, kw_only=True)
class LearnOptions:
    """How pairs are aligned, and from where heights count."""

    registration: RegistrationOptions = field(
        default_factory=lambda: RegistrationOptions(mostly_unchanged=True)
    )
    reference: str | None = None
    """Landmark from which heights count; None takes the most proximal that all pairs have."""


DEFAULTS = LearnOptions()


@dataclass(frozen=True, kw_only=True)
class Pair:
    """A shape before and after a rectification."""

    before: Limb
    after: Limb

    __repr__ = brief


@dataclass(frozen=True, kw_only=True)
class Displacements:
    """Displacements at n places, with the pair's alignment."""

    points_mm: Points3
    """On the before, in its limb frame."""
    moved_mm: Float64[np.ndarray, " n"]
    """Along its normals, positive outwards."""
    alignment: Alignment


@dataclass(frozen=True, kw_only=True)
class Learned:
    """A learned template, with notes on how far to trust it."""

    template: Template
    notes: tuple[Finding, ...]
    """How each after was laid on its before, and what is odd about the pairs."""

    __repr__ = brief


def learn(pairs: Sequence[Pair], name: str, options: LearnOptions = DEFAULTS) -> Learned:
    """Average what was done to the limbs of several pairs, or keep what was done to one."""
    sides = {pair.before.side for pair in pairs if isinstance(pair.before, AlignedLimb)}
    if not pairs or ("none" in sides and len(sides) > 1):
        raise OptionsError("template.learn.some_sided" if pairs else "template.learn.no_pair")
    for pair in pairs:
        _require_one_side(pair)
    pairs = [
        Pair(before=outside_by_name(one.before), after=outside_by_name(one.after)) for one in pairs
    ]
    kinds = {pair.before.kind for pair in pairs}
    bent = centreline_of_kind(pairs[0].before) if len(kinds) == 1 else None
    along: Along = "axis" if bent is None else "centreline"
    reference = _reference(pairs, options.reference or (bent and bent.reference))
    charts = [plain_chart(pair.before, reference, along) for pair in pairs]
    marks = _mean_landmarks([pair.before for pair in pairs], charts)
    places = {mark.name: mark.place for mark in marks}
    tops = [_brim_height(pair.before, chart) for pair, chart in zip(pairs, charts, strict=True)]
    heights = node_heights(min(_TOPS[along], float(np.median(tops))))
    moves = [displacements(pair, options) for pair in pairs]
    fields = np.stack(
        [
            fit_field(
                pulled_chart(pair.before, chart, places).places(move.points_mm),
                move.moved_mm,
                heights,
            )
            for pair, chart, move in zip(pairs, charts, moves, strict=True)
        ]
    )
    known = np.isfinite(fields).sum(0)
    mean, spread = robust_mean(fields)
    kept = significant_nodes(fields, _FALSE_SHARE)
    kept &= np.nan_to_num(np.abs(mean)) >= _LEAST_MM
    if not kept.any():
        raise _nothing_learned(mean, spread, len(pairs))
    template = Template(
        name=name,
        pairs=len(pairs),
        sided="none" not in sides,
        reference=reference,
        marks=marks,
        heights=heights,
        displacement_mm=np.round(np.nan_to_num(mean) * soft_mask(kept), _DECIMALS) + 0.0,
        spread_mm=np.round(spread, _DECIMALS),
        known_pairs=known,
        along=along,
    )
    said = [one for pair, move in zip(pairs, moves) for one in pair_findings(pair, move)]
    return Learned(template=template, notes=tuple(dict.fromkeys(said)))


def displacements(pair: Pair, options: LearnOptions) -> Displacements:
    """The displacements from the shape before to the shape after.

    Raises:
        MeasureError: no place of the one has a counterpart on the other.
    """
    before = pair.before
    axes = axes_of(before)
    alignment = align_shapes(before, pair.after, axes, options.registration)
    brim_mm = options.registration.brim_mm
    placed = mesh_in_frame(pair.after.mesh, alignment.first_from_second)
    ground = CounterpartSurface.of(placed, brim_mm)
    samples = sample_evenly(before.mesh, _SAMPLES)
    moved = np.zeros(len(samples.points_mm))
    active = np.arange(len(moved))
    for _ in range(_STEPS):
        normals = samples.normals[active]
        there = samples.points_mm[active] + moved[active, None] * normals
        found = ground.counterparts(there)
        lean = np.einsum("nc,nc->n", normals, found.flat_normals)
        gap = np.einsum("nc,nc->n", found.points_mm - there, found.flat_normals)
        step = gap / np.where(np.abs(lean) < _LEAST_COSINE, np.inf, lean)
        moved[active] += step
        active = active[np.abs(step) > _CONVERGED_MM]
    found = ground.counterparts(samples.points_mm + moved[:, None] * samples.normals)
    met = np.abs(found.signed_mm) < _HIT_MM
    own = measured_faces(before.mesh, brim_mm)[samples.faces]
    good = met & own & ~found.at_brim & found.measured & (np.abs(moved) < _FARTHEST_MM)
    if not good.any():
        raise MeasureError("compare.surface.no_counterpart")
    return Displacements(
        points_mm=axes.limb_from_mesh.apply(samples.points_mm[good]),
        moved_mm=moved[good],
        alignment=alignment,
    )


def pair_findings(pair: Pair, move: Displacements) -> tuple[Finding, ...]:
    """What was odd about its files, how the pair was laid, and whether what differs can be a
    rectification at all.
    """
    before, after = pair.before.name or None, pair.after.name or None
    notes = [*pair.before.notes, *pair.after.notes]
    notes.append(note("template.pair.aligned", before=before, after=after, how=move.alignment.how))
    notes += move.alignment.notes
    most_mm = float(np.quantile(np.abs(move.moved_mm), _NEARLY_ALL))
    rms_mm = rms(move.moved_mm)
    if most_mm > _MOST_MM or rms_mm > _MOST_RMS_MM:
        notes.append(
            doubt(
                "template.pair.unlike",
                before=before,
                after=after,
                low_mm=float(move.moved_mm.min()),
                high_mm=float(move.moved_mm.max()),
                rms_mm=rms_mm,
                most_mm=_MOST_MM,
                most_rms_mm=_MOST_RMS_MM,
            )
        )
    return tuple(notes)


def robust_mean(fields: Fields) -> tuple[Field, Field]:
    """Huber's mean over the pairs, and their standard deviation, pooled with near nodes."""
    known = np.isfinite(fields)
    count = known.sum(0)
    filled = np.where(known, fields, 0.0)
    centre = _median(fields, count)
    scale = MAD_TO_SIGMA * _median(np.abs(fields - centre), count)
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


def significant_nodes(fields: Fields, false_share: float) -> Bool[np.ndarray, "h a"]:
    """Nodes with a significant mean; for one pair alone, every known node."""
    tested = np.isfinite(fields).sum(0) >= 2
    if not tested.any():
        return np.asarray(np.isfinite(fields).any(0))
    from scipy.ndimage import median_filter  # a tenth of a second, for learning alone

    drawn = np.stack([np.sort(_t_ratios(some)[tested]) for some in _null_samples(fields)])
    by_chance = np.sort(drawn, axis=None)
    chance = _p_values(_t_ratios(fields)[tested], by_chance)
    least = np.array([_simes_level(np.sort(_p_values(one, by_chance))) for one in drawn])
    level = min(false_share, float(np.quantile(least, false_share)))
    order = np.sort(chance)
    passed = order[order <= level * np.arange(1, len(order) + 1) / len(order)]
    kept = np.zeros(tested.shape)
    kept[tested] = chance <= (passed.max() if len(passed) else -1.0)
    return _unpadded(median_filter(_padded(kept), 3)) > 0


def soft_mask(kept: Bool[np.ndarray, "h a"]) -> Field:
    """A smooth mask: 1 well within the kept nodes, 0 well outside."""
    return _blurred(kept.astype(float), _MASK_BLUR_NODES)


def _require_one_side(pair: Pair) -> None:
    before, after = pair.before, pair.after
    if {before.side, after.side} == {"left", "right"}:
        raise OptionsError(
            "template.learn.mirror",
            before=before.name,
            before_side=before.side,
            after=after.name,
            after_side=after.side,
        )


def _reference(pairs: Sequence[Pair], asked: str | None) -> str:
    if asked is not None:
        return asked
    heights: dict[str, list[float]] = {}
    for pair in pairs:
        limb = pair.before.aligned()
        for one, mark in landmarks_by_identity(limb.landmarks).items():
            height = float(limb.landmark_in_limb_mm(mark)[2])
            heights.setdefault(one, []).append(height)
    shared = {name: np.mean(found) for name, found in heights.items() if len(found) == len(pairs)}
    if not shared:
        raise MeasureError("template.learn.no_shared")
    return max(shared, key=lambda name: (shared[name], name))


def _mean_landmarks(limbs: Sequence[Limb], charts: Sequence[LimbChart]) -> tuple[TemplateMark, ...]:
    """Mean chart places of the landmarks that all limbs have."""
    each = [marks_on(limb, chart) for limb, chart in zip(limbs, charts, strict=True)]
    shared = sorted(set.intersection(*(set(marks) for marks in each)))
    marks: list[TemplateMark] = []
    for name in shared:
        places = np.stack([own[name] for own in each])
        angle = np.angle(np.exp(1j * places[:, 1]).mean())
        marks.append(
            TemplateMark(
                name=name,
                height=round(float(places[:, 0].mean()), 4),
                angle_deg=round(float(np.degrees(angle)), 2),
            )
        )
    return tuple(marks)


def _brim_height(limb: Limb, chart: LimbChart) -> float:
    """Chart height of the brim."""
    brim_mm = brim_height_mm(mesh_in_frame(limb.mesh, axes_of(limb).limb_from_mesh))
    middle_mm = np.zeros(2) if chart.curve is None else chart.curve.points_mm[0, :2]
    return float(chart.unpulled(np.array([[*middle_mm, brim_mm]]))[0, 0])


def _nothing_learned(mean: Field, spread: Field, pairs: int) -> MeasureError:
    most = np.unravel_index(np.nanargmax(np.abs(np.nan_to_num(mean))), mean.shape)
    if not abs(mean[most]) >= _LEAST_MM:
        return MeasureError("template.learn.nothing", least_mm=_LEAST_MM)
    return MeasureError(
        "template.learn.unlike",
        pairs=pairs,
        mean_mm=float(mean[most]),
        spread_mm=float(spread[most]),
    )


def _median(fields: Fields, count: Int64[np.ndarray, "h a"]) -> Field:
    """The median of known values at each node; 0 where none is known."""
    order = np.sort(fields, axis=0)  # NaN comes last
    low, high = np.maximum(count - 1, 0) // 2, np.minimum(count // 2, len(fields) - 1)
    middle = [np.take_along_axis(order, place[None], axis=0)[0] for place in (low, high)]
    return np.nan_to_num((middle[0] + middle[1]) / 2)


def _blurred(values: Field, nodes: float) -> Field:
    from scipy.ndimage import gaussian_filter  # a tenth of a second, for learning alone

    return _unpadded(gaussian_filter(_padded(values), nodes))


def _unpadded(padded: Field) -> Float64[np.ndarray, "inner_h inner_a"]:
    return np.asarray(padded)[_PAD:-_PAD, _PAD:-_PAD]


def _padded(values: Field) -> Float64[np.ndarray, "padded_h padded_a"]:
    """Values padded by the end rows below and above, and periodically round the limb."""
    return np.pad(np.pad(values, ((_PAD, _PAD), (0, 0)), "edge"), ((0, 0), (_PAD, _PAD)), "wrap")


def _t_ratios(fields: Fields) -> Field:
    """The absolute mean in standard errors."""
    mean, spread = robust_mean(fields)
    return np.abs(mean) / spread * np.sqrt(np.isfinite(fields).sum(0))


def _null_samples(fields: Fields) -> Iterator[Fields]:
    """Random samples without common displacement, with the same known nodes as the pairs.

    Each is what the pairs differ by, mixed at random and turned at random round the limb wave by
    wave: every height stays as rough as it is, and goes on into the next as it does.
    """
    known = np.isfinite(fields)
    mean = np.where(known, fields, 0.0).sum(0) / np.maximum(known.sum(0), 1)
    waves = np.fft.rfft(np.where(known, fields - mean, 0.0), axis=2)
    pairs, _, columns = fields.shape
    dice = np.random.default_rng(_SEED)
    for _ in range(_NULL_SAMPLES):
        noise = np.fft.rfft(dice.normal(size=(pairs, pairs, columns)), axis=2)
        mixed = np.einsum("pqm,qhm->phm", noise, waves) / np.sqrt(columns * max(pairs - 1, 1))
        yield np.where(known, np.fft.irfft(mixed, n=columns, axis=2), np.nan)


def _p_values(
    ratios: Float64[np.ndarray, " n"], by_chance: Float64[np.ndarray, " m"]
) -> Float64[np.ndarray, " n"]:
    """Share of the null ratios that are at least as large."""
    larger = len(by_chance) - np.searchsorted(by_chance, ratios, side="left")
    return (larger + 1.0) / (len(by_chance) + 1)


def _simes_level(order: Float64[np.ndarray, " n"]) -> float:
    """The level at which Simes' procedure would make the first discovery."""
    return float((order * len(order) / np.arange(1, len(order) + 1)).min())
