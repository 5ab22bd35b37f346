"""Learning: the clinic's own rectification, from shapes before and after it.

In      pairs of Limbs: before (aligned, with landmarks) and after.
Out     a Template.
Method  lay the after on the before; displacement along the before's normals; all on one chart;
        robust mean and spread over the pairs; kept where it is significant and not negligible.
Fails   MeasureError: a pair without frame or shared landmark. OptionsError: sides mixed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from limbgram.errors import MeasureError, OptionsError
from limbgram.shape.comparing.frames import axes_of, brim_height_mm, in_limb_frame, outside_of
from limbgram.shape.limb import Limb
from limbgram.shape.templates.charts import LimbChart, marks_on, plain_chart, pulled_chart
from limbgram.shape.templates.fields import Field, fit_field, node_heights
from limbgram.shape.templates.learning.displacing import (
    LearnOptions,
    Pair,
    about_pair,
    displacements,
)
from limbgram.shape.templates.learning.significance import found_alike, robust, softened
from limbgram.shape.templates.template import Template, TemplateMark

_TOP = 1.6
_DECIMALS = 2
"""Of displacements, as the file keeps them: one from a file is the one that was learned."""


DEFAULTS = LearnOptions()


@dataclass(frozen=True, kw_only=True)
class Learned:
    """A template, and how far to trust it."""

    template: Template
    notes: tuple[str, ...]
    """How each after was laid on its before, and what is odd about the pairs."""


def learn(pairs: Sequence[Pair], name: str, options: LearnOptions = DEFAULTS) -> Learned:
    """Average what was done to the limbs of several pairs, or keep what was done to one."""
    sides = {pair.before.frame.side for pair in pairs if pair.before.frame is not None}
    if not pairs or ("none" in sides and len(sides) > 1):
        raise OptionsError(
            "Some of the limbs have a side and others none, so their lateral sides cannot be "
            "matched. Say the side of all by `limbgram align --side`."
            if pairs
            else "No pair is given. Name a shape before and one after the rectification."
        )
    for pair in pairs:
        _require_one_side(pair)
    pairs = [Pair(before=outside_of(one.before), after=outside_of(one.after)) for one in pairs]
    reference = _reference(pairs, options.reference)
    charts = [plain_chart(pair.before, reference) for pair in pairs]
    marks = _marks([pair.before for pair in pairs], charts)
    places = {mark.name: mark.place for mark in marks}
    tops = [_top(pair.before, chart) for pair, chart in zip(pairs, charts, strict=True)]
    heights = node_heights(min(_TOP, float(np.median(tops))))
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
    mean, spread = robust(fields)
    kept = found_alike(fields, options.false_share)
    kept &= np.nan_to_num(np.abs(mean)) >= options.least_mm
    if not kept.any():
        raise MeasureError(_nothing_kept(mean, spread, len(pairs), options))
    template = Template(
        name=name,
        pairs=len(pairs),
        sided="none" not in sides,
        reference=reference,
        marks=marks,
        heights=heights,
        displacement_mm=np.round(np.nan_to_num(mean) * softened(kept), _DECIMALS) + 0.0,
        spread_mm=np.round(spread, _DECIMALS),
        known_pairs=known,
    )
    notes = [note for pair, move in zip(pairs, moves) for note in about_pair(pair, move)]
    return Learned(template=template, notes=tuple(notes))


def _require_one_side(pair: Pair) -> None:
    before, after = pair.before, pair.after
    if before.frame is None or after.frame is None:
        return
    if {before.frame.side, after.frame.side} == {"left", "right"}:
        raise OptionsError(
            f"{before.name} is a {before.frame.side} limb and {after.name} a {after.frame.side} "
            "one: what lies between them is a mirror, no rectification. Mirror one of them back "
            "by `limbgram edit`."
        )


def _reference(pairs: Sequence[Pair], asked: str | None) -> str:
    if asked is not None:
        return asked
    heights: dict[str, list[float]] = {}
    for pair in pairs:
        frame = pair.before.frame
        if frame is None:
            raise MeasureError(
                f"{pair.before.name or 'A limb'} has no limb frame. Run `limbgram align` on every "
                "shape before its rectification."
            )
        for mark in pair.before.landmarks:
            height = float(frame.limb_from_mesh.apply(mark.position_mm[None])[0, 2])
            heights.setdefault(mark.name, []).append(height)
    shared = {name: np.mean(found) for name, found in heights.items() if len(found) == len(pairs)}
    if not shared:
        raise MeasureError(
            "The shapes before rectification share no landmark, so a template would not know "
            "where to go on another limb. Mark the same places on all with `limbgram align`."
        )
    return max(shared, key=lambda name: (shared[name], name))


def _marks(limbs: Sequence[Limb], charts: Sequence[LimbChart]) -> tuple[TemplateMark, ...]:
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


def _top(limb: Limb, chart: LimbChart) -> float:
    """Chart height of the brim."""
    brim_mm = brim_height_mm(in_limb_frame(limb.mesh, axes_of(limb).limb_from_mesh))
    return (brim_mm - chart.dome_mm) / (chart.reference_mm - chart.dome_mm)


def _nothing_kept(mean: Field, spread: Field, pairs: int, options: LearnOptions) -> str:
    most = np.unravel_index(np.nanargmax(np.abs(np.nan_to_num(mean))), mean.shape)
    if not abs(mean[most]) >= options.least_mm:
        return (
            f"Nothing was done to these limbs that is {options.least_mm:g} mm or more on the mean "
            "of the pairs. Name each shape before its rectification first, and after it second."
        )
    return (
        f"Nothing was done alike to these limbs: where the {pairs} pairs differ most from before, "
        f"by {mean[most]:+.1f} mm on the mean, they spread by {spread[most]:.1f} mm. Check that "
        "landmarks stand at the same places on all limbs and that the right shapes are paired, or "
        "learn from more pairs."
    )
