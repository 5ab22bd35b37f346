"""Lines: comparisons, series and repeats as people read them, the verdict first."""

from limbgram.geometry.interval import HOLDS, Interval, plus_minus
from limbgram.shape.comparing.comparing import Comparison
from limbgram.shape.comparing.following.repeats import Repeats
from limbgram.shape.comparing.following.series import Series
from limbgram.shape.comparing.levels import Change
from limbgram.shape.comparing.telling.verdict import by_shape_sentence, verdict

_HEADING = (
    f"{'height':>8}{'tape mm':>10}{'change':>9}{'ML change':>11}{'AP change':>11}"
    f"{'mL since last':>15}{'change':>9}"
)


def comparison_lines(comparison: Comparison) -> tuple[str, ...]:
    found = comparison.deviation
    figures = found.on_first.figures
    by_shape = comparison.by_shape
    return (
        verdict(comparison).sentence,
        *(() if by_shape is None or by_shape.at_odds else (by_shape_sentence(by_shape),)),
        *(f"Note: {note}" for note in comparison.notes),
        f"Surface: mean {figures.mean_mm:+.3f} mm, mean absolute {figures.mean_abs_mm:.3f}, RMS "
        f"{figures.rms_mm:.3f}, 95 % within {figures.p95_mm:.3f}, largest "
        f"{figures.largest_mm:.3f}; both ways 95 % within {found.hausdorff95_mm:.3f}; "
        f"{figures.compared_share:.1%} of the first compared.",
        f"Normals: turned by {found.snae_mean_deg:.1f} degrees on average, 95 % by less than "
        f"{found.snae_p95_deg:.1f}.",
        "Levels: tape and mL are the second's, mL of the slab since the last level (the first from "
        "where the volume begins); changes are second less first.",
        _HEADING,
        *(
            f"{level.height_mm:8.1f}  {level.reason}"
            if level.reason
            else f"{level.height_mm:8.1f}"
            f"{_second(level.measures.get('tape_mm'), 10)}"
            f"{_difference(level.measures.get('tape_mm'), 9)}"
            f"{_difference(level.measures.get('ml_mm'), 11)}"
            f"{_difference(level.measures.get('ap_mm'), 11)}"
            f"{_second(level.since_last, 15, 1000)}{_difference(level.since_last, 9, 1000)}"
            for level in comparison.levels.levels
        ),
    )


def series_lines(series: Series) -> tuple[str, ...]:
    scans = series.stack
    source = {
        "scans": "the scans' own",
        "repeats": "from repeats on one day",
        "assumed": "assumed: the scans carry none (--repeatability)",
    }[series.sigma_source]
    start = float(scans.volumes_mm3[0])
    return (
        series.sentence,
        *(f"Note: {note}" for note in scans.notes),
        f"{HOLDS}; for the volumes it is {source}. Alignment to the first: "
        f"{scans.alignments[0].sentence}.",
        *(
            f"{day.isoformat()}  {volume / 1000:8.1f} "
            f"{plus_minus(Interval.of_sigma(sigma / 1000), 1)} mL ({volume / start - 1:+.1%})  "
            f"{name}"
            for day, volume, sigma, name in zip(
                series.days, scans.volumes_mm3, series.volume_sigmas_mm3, series.names
            )
        ),
        "Girths, taut tape:",
        *(
            f"{height:8.1f} mm  no whole section on two days"
            if trend is None
            else f"{height:8.1f} mm  {trend.per_week:+.2f} "
            f"{plus_minus(Interval.of_half_width(trend.per_week_95), 2)} mm a week"
            + ("" if trend.told else ": within the uncertainty")
            for height, trend in zip(scans.heights_mm, series.girths)
        ),
    )


def repeats_lines(found: Repeats) -> tuple[str, ...]:
    agreement = found.agreement
    return (
        found.sentence,
        *(f"Note: {note}" for note in found.stack.notes),
        *(
            f"{volume / 1000:8.1f} mL  {name}"
            for volume, name in zip(found.stack.volumes_mm3, found.names)
        ),
        f"Alignment to the first: {found.stack.alignments[0].sentence}.",
        *(
            ()
            if agreement is None
            else (
                f"Girths, second less first: {agreement.bias:+.2f} mm, limits of agreement "
                f"{agreement.low:+.2f} to {agreement.high:+.2f} mm.",
            )
        ),
    )


def _second(change: Change | None, width: int, per: float = 1.0) -> str:
    return f"{'-':>{width}}" if change is None else f"{change.second.value / per:{width}.1f}"


def _difference(change: Change | None, width: int, per: float = 1.0) -> str:
    return f"{'-':>{width}}" if change is None else f"{change.difference / per:+{width}.1f}"
