"""Trees: comparisons, series and repeats for machines. Lengths in mm, volumes in mL."""

import math
from dataclasses import asdict
from typing import Any

from limbgram.shape.comparing.comparing import Comparison
from limbgram.shape.comparing.following.repeats import Repeats
from limbgram.shape.comparing.following.series import Series
from limbgram.shape.comparing.following.stack import Stack
from limbgram.shape.comparing.following.trend import Trend
from limbgram.shape.comparing.levels import Change, LevelChange
from limbgram.shape.comparing.registration import Alignment
from limbgram.shape.comparing.telling.verdict import IQR_LIMIT_MM, MRE_LIMIT_MM, verdict

_MM3_PER_ML = 1000.0


def comparison_tree(comparison: Comparison) -> dict[str, Any]:
    """Everything but the maps."""
    found, radial, levels = comparison.deviation, comparison.radial, comparison.levels
    judged, by_shape = verdict(comparison), comparison.by_shape
    return {
        "format": "limbgram-comparison/1",
        "verdict": judged.sentence,
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
            "ml": _change(levels.volume, _MM3_PER_ML),
            "sock_plies": levels.plies,
            "laid_sigma_ml": levels.laid_sigma_mm3 / _MM3_PER_ML,
            "reason": levels.reason,
        },
        "by_shape": None
        if by_shape is None
        else {
            "alignment": _alignment(by_shape.alignment),
            "volume_ml": _change(by_shape.volume, _MM3_PER_ML),
            "laid_sigma_ml": by_shape.laid_sigma_mm3 / _MM3_PER_ML,
            "at_odds": by_shape.at_odds,
        },
        "levels": [_level(level) for level in levels.levels],
        "anatomical_frame": comparison.axes.anatomical,
        "notes": list(comparison.notes),
    }


def series_tree(series: Series) -> dict[str, Any]:
    """Visits in the order of their days."""
    scans = series.stack
    return {
        "format": "limbgram-series/1",
        "verdict": series.sentence,
        "sigma_source": series.sigma_source,
        "volume_trend_ml": _trend(series.volume, _MM3_PER_ML),
        "volume_per_week_share": series.volume.per_week / float(scans.volumes_mm3[0]),
        "change_ml": series.change_mm3 / _MM3_PER_ML,
        "change_95_ml": series.change_95_mm3 / _MM3_PER_ML,
        "girth_trends_mm": [
            {"height_mm": float(height), "trend": None if trend is None else _trend(trend, 1.0)}
            for height, trend in zip(scans.heights_mm, series.girths)
        ],
        "visits": [
            {
                "day": day.isoformat(),
                "name": name,
                "volume_ml": float(volume) / _MM3_PER_ML,
                "volume_sigma_ml": float(sigma) / _MM3_PER_ML,
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


def repeats_tree(repeats: Repeats) -> dict[str, Any]:
    """Volumes in mL, girths in mm."""
    scans, volume = repeats.stack, repeats.volume
    return {
        "format": "limbgram-repeats/1",
        "verdict": repeats.sentence,
        "volume": {
            "within_sd_ml": volume.within_sd / _MM3_PER_ML,
            "coefficient_ml": volume.coefficient / _MM3_PER_ML,
            "coefficient_share": volume.coefficient / float(scans.volumes_mm3.mean()),
        },
        "girths_mm": asdict(repeats.girths),
        "bland_altman_mm": None if repeats.agreement is None else asdict(repeats.agreement),
        "captures": [
            {
                "name": name,
                "volume_ml": float(value) / _MM3_PER_ML,
                "girths_mm": [_number(girth) for girth in girths],
            }
            for name, value, girths in zip(repeats.names, scans.volumes_mm3, scans.tapes_mm)
        ],
        **_stack(scans),
    }


def _stack(scans: Stack) -> dict[str, Any]:
    return {
        "heights_mm": scans.heights_mm.tolist(),
        "volume_from_mm": scans.from_mm,
        "volume_to_mm": float(scans.heights_mm[-1]),
        "alignments": [_alignment(alignment) for alignment in scans.alignments],
        "notes": list(scans.notes),
    }


def _alignment(alignment: Alignment) -> dict[str, Any]:
    motion = alignment.first_from_second
    return {
        "way": alignment.way,
        "in_words": alignment.sentence,
        "rms_mm": None if alignment.rms_mm is None else _number(alignment.rms_mm),
        "slide_sigma_mm": None if alignment.looseness is None else alignment.slide_sigma_mm,
        "slid_from_frames_mm": alignment.slid_mm,
        "first_from_second": {
            "rotation": motion.rotation.tolist(),
            "translation_mm": motion.translation.tolist(),
        },
    }


def _level(level: LevelChange) -> dict[str, Any]:
    return {
        "height_mm": level.height_mm,
        **{name: _change(change, 1.0) for name, change in level.measures.items()},
        "volume_since_last_level_ml": _change(level.since_last, _MM3_PER_ML),
        "reason": level.reason,
    }


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


def _trend(trend: Trend, per: float) -> dict[str, Any]:
    return {
        "per_week": trend.per_week / per,
        "per_week_95": trend.per_week_95 / per,
        "told": trend.told,
        "scatter": trend.scatter,
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
