"""Messages: comparisons, series and repeats for people, the verdict first, and as trees for JSON.

A verdict is what a comparison means for the fit of a socket. Its limits: a mean radial error beyond
0.25 mm was found in every socket that had to be remade for its size, an interquartile range beyond
0.40 mm in many that had to be changed (Sanders et al. 2012). Both are blind to a small place that
was moved by much, so that is looked for by its area. Trees have lengths in mm and volumes in mL.
"""

import math
from dataclasses import asdict, dataclass
from typing import Any, Literal

from limbgram.core.geometry.smoothed_length import SMOOTHED_OVER
from limbgram.core.interval import COVER, HOLDS, Interval, plus_minus
from limbgram.core.units import MM3_PER_ML
from limbgram.findings import LANGUAGES, Finding, as_json, doubt, note, told
from limbgram.workbench.compare.comparison import Comparison, VolumeByShape
from limbgram.workbench.compare.deviation import LOCAL_LIMIT_MM
from limbgram.workbench.compare.levels import Change, LevelChange
from limbgram.workbench.compare.over_time import Repeats, ScanStack, Series, Trend
from limbgram.workbench.compare.registration import FAR_MM, Alignment
from limbgram.workbench.compare.sheets import FigureCourse, SheetTrend

MRE_LIMIT_MM = 0.25
_SURE_PROBABILITY = 0.999
"""No probability of ours is known more closely."""
IQR_LIMIT_MM = 0.40
_LOCAL_MM2 = 100.0
"""Area from which places beyond the local limit count: a finger tip."""
Grade = Literal[
    "alike",
    "differs in places",
    "size differs",
    "shape differs",
    "size and shape differ",
    "not graded",
]
_HEADING = (
    f"{'height':>8}{'tape mm':>10}{'change':>9}{'ML change':>11}{'AP change':>11}"
    f"{'mL since last':>15}{'change':>9}"
)
_SAME_PLIES = 0.05
"""Volumes that differ by less are the same."""


@dataclass(frozen=True)
class Verdict:
    """A grade, and the finding that states it with figures."""

    grade: Grade
    finding: Finding


def verdict(comparison: Comparison) -> Verdict:
    """The verdict: size by the mean radial error, shape by its interquartile range."""
    radial, how = comparison.radial, comparison.alignment.how
    figures, volume = comparison.deviation.on_first.figures, _volume(comparison)
    if radial is None:
        found = note("compare.not_graded", volume=volume, rms_mm=figures.rms_mm, how=how)
        return Verdict("not graded", found)
    local = figures.far_mm2 >= _LOCAL_MM2
    size, shape = abs(radial.mre_mm) > MRE_LIMIT_MM, radial.iqr_mm > IQR_LIMIT_MM
    grade: Grade = (
        "size and shape differ"
        if size and shape
        else "size differs"
        if size
        else "shape differs"
        if shape
        else "differs in places"
        if local
        else "alike"
    )
    return Verdict(
        grade,
        note(
            "compare.graded",
            grade=grade,
            mean_radial_error_mm=round(radial.mre_mm, 2) + 0.0,
            mean_limit_mm=MRE_LIMIT_MM,
            interquartile_range_mm=radial.iqr_mm,
            range_limit_mm=IQR_LIMIT_MM,
            places=local,
            far_cm2=figures.far_mm2 / 100,
            far_limit_mm=LOCAL_LIMIT_MM,
            largest_mm=figures.largest_mm,
            volume=volume,
            how=how,
        ),
    )


def comparison_lines(comparison: Comparison, language: str = LANGUAGES[0]) -> tuple[str, ...]:
    """A comparison for people; its findings in their language."""
    found = comparison.deviation
    figures = found.on_first.figures
    by_shape = comparison.by_shape
    return (
        told(verdict(comparison).finding, language),
        *(
            ()
            if by_shape is None or by_shape.at_odds
            else (told(shape_finding(by_shape), language),)
        ),
        *(f"Note: {told(one, language)}" for one in comparison.notes),
        f"Surface: mean {figures.mean_mm:+z.3f} mm, mean absolute {figures.mean_abs_mm:.3f}, RMS "
        f"{figures.rms_mm:.3f}, 95 % within {figures.p95_mm:.3f}, largest "
        f"{figures.largest_mm:.3f}; both ways 95 % within {found.hausdorff95_mm:.3f}; "
        f"{figures.compared_share:.1%} of the first compared.",
        f"Normals: turned by {found.snae_mean_deg:.1f} degrees on average, 95 % by less than "
        f"{found.snae_p95_deg:.1f}.",
        "Levels: heights in mm from the origin of the first's frame; tape and mL are the second's, "
        "mL of the slab since the last level (the first from where the volume begins); changes are "
        "second less first.",
        _HEADING,
        *(
            f"{level.height_mm:8.1f}  {told(level.reason, language)}"
            if level.reason is not None
            else f"{level.height_mm:8.1f}"
            f"{_second(level.measures.get('tape_mm'), 10)}"
            f"{_difference(level.measures.get('tape_mm'), 9)}"
            f"{_difference(level.measures.get('ml_mm'), 11)}"
            f"{_difference(level.measures.get('ap_mm'), 11)}"
            f"{_second(level.since_last, 15, 1000)}{_difference(level.since_last, 9, 1000)}"
            f"{_other_limbs_line(level)}"
            for level in comparison.levels.levels
        ),
    )


def series_lines(series: Series, language: str = LANGUAGES[0]) -> tuple[str, ...]:
    """A limb over time for people; its findings in their language."""
    scans = series.stack
    source = {
        "scans": "the scans' own",
        "repeats": "from repeats on one day",
        "assumed": "assumed: the scans carry none (--repeatability)",
    }[series.sigma_source]
    start = float(scans.volumes_mm3[0])
    return (
        told(series.finding, language),
        *(f"Note: {told(one, language)}" for one in scans.notes),
        f"{HOLDS}; for the volumes it is {source}. Alignment to the first: "
        f"{told(scans.alignments[0].how, language)}",
        *(
            f"{day.isoformat()}  {volume / 1000:8.1f} "
            f"{plus_minus(Interval.of_sigma(sigma / 1000), 1)} mL ({volume / start - 1:+z.1%})  "
            f"{name}"
            for day, volume, sigma, name in zip(
                series.days, scans.volumes_mm3, series.volume_sigmas_mm3, series.names
            )
        ),
        f"Girths, taut tape, {SMOOTHED_OVER}:",
        *(
            f"{height:8.1f} mm  no whole section on two days"
            if trend is None
            else f"{height:8.1f} mm  {trend.per_week:+z.2f} "
            f"{plus_minus(Interval.of_half_width(trend.per_week_95), 2)} mm a week"
            + ("" if trend.is_clear else ": within the uncertainty")
            for height, trend in zip(scans.heights_mm, series.girths)
        ),
    )


def sheet_trend_lines(trend: SheetTrend, language: str = LANGUAGES[0]) -> tuple[str, ...]:
    """Each figure of the measuring sheets: from, to, change and how real it is.

    Findings are told in the language.
    """
    words = {row.name: row.words["en"] for one in trend.visits for row in one.sheet.rows}
    return (
        told(trend.finding, language),
        *(f"Note: {told(one, language)}" for one in trend.notes),
        *(f"{one.day.isoformat()}  {one.sheet.shape}" for one in trend.visits),
        f"{'first':>9}{'last':>9}{'change':>9}{'':15}{'real':>8}  {HOLDS}",
        *map(_course_line, trend.courses),
        *(f"{'':50}  {words[name]}: not on two days with a ±" for name in trend.left_out),
        told(note("trend.real"), language),
    )


def _course_line(course: FigureCourse) -> str:
    first, last = course.figures[0].value, course.figures[-1].value
    within = f"{plus_minus(course.change_within, 1)} {course.unit}"
    sure = course.trend.probability
    real = f"{sure:.1%}" if sure < _SURE_PROBABILITY else f"> {_SURE_PROBABILITY:.1%}"
    return (
        f"{first:9.1f}{last:9.1f}{course.change:+z9.1f} {within:14}{real:>8}"
        f"  {course.words['en']}" + ("" if course.trend.is_clear else ": within the uncertainty")
    )


def repeats_lines(found: Repeats, language: str = LANGUAGES[0]) -> tuple[str, ...]:
    """Repeated captures for people; their findings in the language."""
    agreement = found.agreement
    return (
        told(found.finding, language),
        *(f"Note: {told(one, language)}" for one in found.stack.notes),
        *(
            f"{volume / 1000:8.1f} mL  {name}"
            for volume, name in zip(found.stack.volumes_mm3, found.names)
        ),
        f"Alignment to the first: {told(found.stack.alignments[0].how, language)}",
        *(
            ()
            if agreement is None
            else (
                f"Girths of these two captures, second less first: {agreement.bias:+z.2f} mm, "
                f"limits of agreement {agreement.low:+z.2f} to {agreement.high:+z.2f} mm.",
            )
        ),
    )


def comparison_tree(comparison: Comparison) -> dict[str, Any]:
    """Everything but the maps."""
    found, radial, levels = comparison.deviation, comparison.radial, comparison.levels
    judged, by_shape = verdict(comparison), comparison.by_shape
    return {
        "format": "limbgram-comparison/2",
        "verdict": as_json(judged.finding),
        "grade": judged.grade,
        "first": comparison.names[0],
        "second": comparison.names[1],
        "alignment": _alignment(comparison.alignment),
        "sign": "second less first; positive where the second lies outside",
        "radial": None
        if radial is None
        else {
            "mean_radial_error_mm": radial.mre_mm,
            "mean_limit_mm": MRE_LIMIT_MM,
            "interquartile_range_mm": radial.iqr_mm,
            "range_limit_mm": IQR_LIMIT_MM,
            "known_share": radial.known_share,
        },
        "surface": {
            "on_first": asdict(found.on_first.figures),
            "on_second": asdict(found.on_second.figures),
            "hausdorff95_mm": found.hausdorff95_mm,
            "normal_angle_mean_deg": found.snae_mean_deg,
            "normal_angle_p95_deg": found.snae_p95_deg,
        },
        "volume": {
            "from_mm": levels.from_mm,
            "to_mm": levels.to_mm,
            "ml": _change(levels.volume, MM3_PER_ML),
            "sock_plies": levels.plies,
            "laid_sigma_ml": levels.laid_sigma_mm3 / MM3_PER_ML,
            "within_ml": None
            if levels.volume is None
            else _interval_ml(levels.volume, levels.laid_sigma_mm3),
            "reason": _reason(levels.reason),
        },
        "by_shape": None
        if by_shape is None
        else {
            "alignment": _alignment(by_shape.alignment),
            "volume_ml": _change(by_shape.volume, MM3_PER_ML),
            "laid_sigma_ml": by_shape.laid_sigma_mm3 / MM3_PER_ML,
            "at_odds": by_shape.at_odds,
        },
        "levels": [_level(level) for level in levels.levels],
        "anatomical_frame": comparison.axes.anatomical,
        "notes": [as_json(one) for one in comparison.notes],
    }


def series_tree(series: Series) -> dict[str, Any]:
    """Visits in the order of their days."""
    scans = series.stack
    return {
        "format": "limbgram-series/2",
        "verdict": as_json(series.finding),
        "sigma_source": series.sigma_source,
        "volume_trend_ml": _trend(series.volume, MM3_PER_ML),
        "volume_per_week_share": series.volume.per_week / float(scans.volumes_mm3[0]),
        "change_ml": series.change_mm3 / MM3_PER_ML,
        "change_95_ml": series.change_95_mm3 / MM3_PER_ML,
        "girth_trends_mm": [
            {"height_mm": float(height), "trend": None if trend is None else _trend(trend, 1.0)}
            for height, trend in zip(scans.heights_mm, series.girths)
        ],
        "visits": [
            {
                "day": day.isoformat(),
                "name": name,
                "volume_ml": float(volume) / MM3_PER_ML,
                "volume_sigma_ml": float(sigma) / MM3_PER_ML,
                "girths_mm": [_number(girth) for girth in girths],
            }
            for day, name, volume, sigma, girths in zip(
                series.days,
                series.names,
                scans.volumes_mm3,
                series.volume_sigmas_mm3,
                scans.tapes_mm,
            )
        ],
        **_stack(scans),
    }


def sheet_trend_tree(trend: SheetTrend) -> dict[str, Any]:
    """Figures in the units of the sheet."""
    return {
        "format": "limbgram-sheet-trend/1",
        "verdict": as_json(trend.finding),
        "kind": trend.visits[0].sheet.kind,
        "side": trend.visits[0].sheet.side,
        "visits": [{"day": one.day.isoformat(), "name": one.sheet.shape} for one in trend.visits],
        "measures": [
            {
                "name": one.name,
                "words": dict(one.words),
                "unit": one.unit,
                "change": one.change,
                "change_95": one.change_within.above,
                "trend": _trend(one.trend, 1.0),
                "values": [
                    {"day": day.isoformat(), "value": figure.value, "sigma": figure.sigma}
                    for day, figure in zip(one.days, one.figures, strict=True)
                ],
            }
            for one in trend.courses
        ],
        "left_out": list(trend.left_out),
        "notes": [as_json(one) for one in trend.notes],
    }


def repeats_tree(repeats: Repeats) -> dict[str, Any]:
    """Volumes in mL, girths in mm."""
    scans, volume = repeats.stack, repeats.volume
    return {
        "format": "limbgram-repeats/2",
        "verdict": as_json(repeats.finding),
        "volume": {
            "within_sd_ml": volume.within_sd / MM3_PER_ML,
            "coefficient_ml": volume.coefficient / MM3_PER_ML,
            "coefficient_share": volume.coefficient / float(scans.volumes_mm3.mean()),
        },
        "girths_mm": asdict(repeats.girths),
        "bland_altman_mm": None if repeats.agreement is None else asdict(repeats.agreement),
        "captures": [
            {
                "name": name,
                "volume_ml": float(value) / MM3_PER_ML,
                "girths_mm": [_number(girth) for girth in girths],
            }
            for name, value, girths in zip(repeats.names, scans.volumes_mm3, scans.tapes_mm)
        ],
        **_stack(scans),
    }


def shape_finding(by_shape: VolumeByShape) -> Finding:
    """A finding about the volume by shape, and whether that contradicts."""
    change = by_shape.volume
    judge = doubt if by_shape.at_odds else note
    return judge(
        "compare.by_shape.at_odds" if by_shape.at_odds else "compare.by_shape.agrees",
        change_ml=change.difference / MM3_PER_ML,
        within_ml=_interval_ml(change, by_shape.laid_sigma_mm3),
    )


def _interval_ml(change: Change, laid_sigma_mm3: float) -> float | None:
    """± of a change: by the scans' errors and the alignment, or by the alignment alone."""
    sigma = change.sigma if change.sigma is not None else laid_sigma_mm3
    return COVER * sigma / MM3_PER_ML if sigma > 0 else None


def _volume(comparison: Comparison) -> Finding:
    """The headline: the volume's change with its interval, twice where two ways of laying the
    shapes on each other contradict."""
    levels, by_shape = comparison.levels, comparison.by_shape
    change, plies = levels.volume, levels.plies
    if change is None or plies is None:
        return note("compare.volume.none")
    same = abs(plies) < _SAME_PLIES
    difference_ml = change.difference / MM3_PER_ML
    at_odds = by_shape is not None and by_shape.at_odds
    return note(
        "compare.volume.same" if same else "compare.volume.changed",
        difference_ml=difference_ml if same else abs(difference_ml),
        larger=change.difference > 0,
        within_ml=_interval_ml(change, levels.laid_sigma_mm3),
        within_of_scans=change.sigma is not None,
        share=abs(change.share),
        plies=abs(plies),
        from_mm=levels.from_mm,
        to_mm=levels.to_mm,
        at_odds=at_odds,
        by_shape=shape_finding(by_shape) if by_shape is not None and at_odds else None,
    )


def _second(change: Change | None, width: int, per: float = 1.0) -> str:
    return f"{'-':>{width}}" if change is None else f"{change.second.value / per:{width}.1f}"


def _difference(change: Change | None, width: int, per: float = 1.0) -> str:
    return f"{'-':>{width}}" if change is None else f"{change.difference / per:+z{width}.1f}"


def _other_limbs_line(level: LevelChange) -> str:
    """Other limbs at the height, by the length round each, of the first and of the second."""
    others = [" ".join(f"{other:.1f}" for other in both) or "none" for both in level.others_mm]
    return f"   beside it: {others[0]} and {others[1]} mm" if any(level.others_mm) else ""


def _alignment(alignment: Alignment) -> dict[str, Any]:
    motion = alignment.first_from_second
    return {
        "way": alignment.way,
        "how": as_json(alignment.how),
        "rms_mm": None if alignment.rms_mm is None else _number(alignment.rms_mm),
        "far_limit_mm": FAR_MM,
        "slide_sigma_mm": None if alignment.pose_covariance is None else alignment.slide_sigma_mm,
        "slide_within_mm": None
        if alignment.pose_covariance is None
        else COVER * alignment.slide_sigma_mm,
        "slid_from_frames_mm": alignment.slid_mm,
        "first_from_second": {
            "rotation": motion.rotation.tolist(),
            "translation_mm": motion.translation.tolist(),
        },
    }


def _reason(reason: Finding | None) -> dict[str, Any] | None:
    return None if reason is None else as_json(reason)


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _change(change: Change | None, per: float) -> dict[str, Any] | None:
    if change is None:
        return None
    return {
        "first": change.first.value / per,
        "second": change.second.value / per,
        "difference": change.difference / per,
        "share": _number(change.share),
        "sigma": None if change.sigma is None else change.sigma / per,
    }


def _level(level: LevelChange) -> dict[str, Any]:
    return {
        "height_mm": level.height_mm,
        **{name: _change(change, 1.0) for name, change in level.measures.items()},
        "volume_since_last_level_ml": _change(level.since_last, MM3_PER_ML),
        "reason": _reason(level.reason),
        "others_mm": dict(zip(("first", "second"), map(list, level.others_mm))),
    }


def _trend(trend: Trend, per: float) -> dict[str, Any]:
    return {
        "per_week": trend.per_week / per,
        "per_week_95": trend.per_week_95 / per,
        "told": trend.is_clear,
        "scatter": trend.scatter,
        "probability": trend.probability,
    }


def _stack(scans: ScanStack) -> dict[str, Any]:
    return {
        "heights_mm": scans.heights_mm.tolist(),
        "volume_from_mm": scans.from_mm,
        "volume_to_mm": float(scans.heights_mm[-1]),
        "alignments": [_alignment(alignment) for alignment in scans.alignments],
        "notes": [as_json(one) for one in scans.notes],
    }
