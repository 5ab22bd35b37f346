"""Over time: one limb at several visits, and how far repeated scans of it lie apart.

In      visits: a scan and its day, where several scans of one day are repeats; or repeats alone.
Out     a Series: volume and girths at each visit, and their trends. Where a change lies within its
        uncertainty, it says so. Repeats: how far captures of one unchanged limb lie apart.
Method  All scans are laid on the first and measured at the same heights. A trend is a straight line
        by weighted least squares; from three values on, their scatter about it makes its interval,
        which is never less than what the scans know of their own errors.
        A scan's sigma is its own if it has one, else the spread of repeats on one day, else the
        assumed share of the options. Repeatability is the coefficient t sqrt(2) s_w (Bland and
        Altman 1999), ICC(2,1) for absolute agreement (Shrout and Fleiss 1979), and Bland-Altman
        bias and limits (1986). Quantiles are Student's, as values are few; girths of one capture
        err together, which leaves fewer of them (Bartlett 1946).
Fails   OptionsError: fewer than two days. MeasureError: scans that cannot be compared.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from datetime import date
from typing import Any, Literal

import numpy as np
from jaxtyping import Float64
from scipy.special import ndtr, stdtr

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.interval import COVER, widening
from limbgram.core.notebook import brief, data_frame, html_of
from limbgram.core.spreadsheet import Table
from limbgram.findings import Finding, note, told
from limbgram.workbench.compare.comparison import CompareOptions, align_shapes, mismatch_findings
from limbgram.workbench.compare.frames import (
    Axes,
    axes_of,
    mesh_in_frame,
    outside_by_name,
)
from limbgram.workbench.compare.levels import (
    PLY_SHARE,
    changes_by_level,
    equally_detailed,
    shared_heights_mm,
)
from limbgram.workbench.compare.registration import Alignment
from limbgram.workbench.compare.skins import skins_to_compare
from limbgram.workbench.limb import Limb

_FEWEST_REPEATS = 2
SigmaSource = Literal["scans", "repeats", "assumed"]


@dataclass(frozen=True, kw_only=True)
class FollowOptions:
    """How scans are compared, and what is taken for their repeatability where none is known."""

    compare: CompareOptions = field(default_factory=CompareOptions)
    assumed_volume_share: float = 0.01
    """One standard deviation of a volume; half of it for a girth."""


DEFAULTS = FollowOptions()


@dataclass(frozen=True, kw_only=True)
class ScanStack:
    """Measures of n scans at k heights."""

    axes: Axes
    alignments: tuple[Alignment, ...]
    """Of all but the first."""
    heights_mm: Float64[np.ndarray, " k"]
    from_mm: float | None
    """Lower bound of the volume; None for the distal end."""
    volumes_mm3: Float64[np.ndarray, " n"]
    volume_sigmas_mm3: Float64[np.ndarray, " n"]
    """NaN where a scan carries no sigmas."""
    tapes_mm: Float64[np.ndarray, "n k"]
    """Girths as a tape reads them; NaN where there is no whole section."""
    tape_sigmas_mm: Float64[np.ndarray, "n k"]
    notes: tuple[Finding, ...]


@dataclass(frozen=True, kw_only=True)
class Trend:
    """A linear trend by weighted least squares; uncertainties hold with 95 %."""

    per_week: float
    """Slope, in the values' unit."""
    per_week_95: float
    """Half the width of its interval."""
    at_start: float
    """The line's value on the first day."""
    scatter: float | None
    """Root mean square of residuals over their sigmas; None for two values."""
    probability: float
    """That the values go the way they seem to: 0.5 where nothing tells it, 0.975 where the slope is
    as large as its interval."""

    @property
    def is_clear(self) -> bool:
        """Whether the change is larger than its uncertainty."""
        return abs(self.per_week) > self.per_week_95


@dataclass(frozen=True, kw_only=True)
class Visit:
    """A scan and when it was taken."""

    limb: Limb
    day: date

    __repr__ = brief


def measure_stack(limbs: Sequence[Limb], options: CompareOptions) -> ScanStack:
    """Align all scans on the first and measure them at the heights that all have.

    Raises:
        MeasureError: a scan cannot be laid on the first, or its volume is open.
    """
    limbs, walls = skins_to_compare([outside_by_name(limb) for limb in limbs])
    first = limbs[0]
    axes = axes_of(first)
    alignments = tuple(align_shapes(first, limb, axes, options.registration) for limb in limbs[1:])
    meshes = [mesh_in_frame(first.mesh, axes.limb_from_mesh)] + [
        mesh_in_frame(limb.mesh, axes.limb_from_mesh @ alignment.first_from_second)
        for limb, alignment in zip(limbs[1:], alignments)
    ]
    meshes = equally_detailed(meshes)
    shared = set(shared_heights_mm(meshes[0], meshes[0], options.spacing_mm))
    for mesh in meshes[1:]:
        shared &= set(shared_heights_mm(meshes[0], mesh, options.spacing_mm))
    heights = tuple(sorted(shared))
    if not heights:
        raise MeasureError("compare.series.no_level")
    loose_mm = [0.0, *(alignment.slide_sigma_mm for alignment in alignments)]
    against = [
        changes_by_level(meshes[0], mesh, heights, sigma_mm)
        for mesh, sigma_mm in zip(meshes, loose_mm)
    ]
    for limb, change in zip(limbs, against):
        if change.volume is None:
            raise MeasureError("compare.series.no_volume", name=limb.name, reason=change.reason)
    starts = {change.from_mm for change in against}
    if len(starts) > 1:
        raise MeasureError("compare.series.ends_differ")
    volumes = [change.volume.second for change in against if change.volume is not None]
    tapes = [
        [level.measures["tape_mm"].second if level.measures else None for level in change.levels]
        for change in against
    ]
    notes = [*walls, *(one for limb in limbs for one in limb.notes)]
    notes += [one for alignment in alignments for one in alignment.notes]
    notes += [one for limb in limbs[1:] for one in mismatch_findings(first, limb)]
    notes += [] if axes.doubt is None else [axes.doubt]
    return ScanStack(
        axes=axes,
        alignments=alignments,
        heights_mm=np.array(heights),
        from_mm=starts.pop(),
        volumes_mm3=np.array([figure.value for figure in volumes]),
        volume_sigmas_mm3=np.array([_sigma_or_nan(figure.sigma) for figure in volumes]),
        tapes_mm=np.array([[np.nan if f is None else f.value for f in row] for row in tapes]),
        tape_sigmas_mm=np.array(
            [[np.nan if f is None else _sigma_or_nan(f.sigma) for f in row] for row in tapes]
        ),
        notes=tuple(dict.fromkeys(notes)),
    )


@dataclass(frozen=True, kw_only=True)
class Series:
    """Volumes and girths over time, in the order of the days."""

    days: tuple[date, ...]
    names: tuple[str, ...]
    stack: ScanStack
    sigma_source: SigmaSource
    volume_sigmas_mm3: Float64[np.ndarray, " n"]
    volume: Trend
    """mm3 per week."""
    girths: tuple[Trend | None, ...]
    """mm per week, by level; None where too few visits have the level."""

    __repr__ = brief

    def to_frame(self) -> Any:
        """A pandas.DataFrame with a row for each visit: volume, and girths at all heights.

        Raises:
            MissingError: pandas is not installed.
        """
        return data_frame(self._table())

    def _repr_html_(self) -> str:
        """The same table, for notebooks."""
        return html_of(self._table(), told(self.finding))

    def _table(self) -> Table:
        girths = tuple(f"tape_at_{height:g}_mm" for height in self.stack.heights_mm)
        volumes = np.column_stack([self.stack.volumes_mm3, self.volume_sigmas_mm3]) / 1000
        return Table(
            title="visits",
            columns=("day", "name", "volume_ml", "sigma_volume_ml", *girths),
            rows=tuple(
                (day.isoformat(), name, *row.tolist())
                for day, name, row in zip(
                    self.days,
                    self.names,
                    np.hstack([volumes, self.stack.tapes_mm]),
                    strict=True,
                )
            ),
        )

    @property
    def change_mm3(self) -> float:
        """Last visit less first."""
        return float(self.stack.volumes_mm3[-1] - self.stack.volumes_mm3[0])

    @property
    def change_95_mm3(self) -> float:
        """Uncertainty of that change, 95 %."""
        return COVER * float(np.hypot(self.volume_sigmas_mm3[-1], self.volume_sigmas_mm3[0]))

    @property
    def finding(self) -> Finding:
        """Whether the limb grows or shrinks, and by how much."""
        start = float(self.stack.volumes_mm3[0])
        share = self.change_mm3 / start
        return note(
            "trend.told" if self.volume.is_clear else "trend.none",
            grows=self.volume.per_week > 0,
            per_week_ml=self.volume.per_week / 1000,
            per_week_within_ml=self.volume.per_week_95 / 1000,
            per_week_share=self.volume.per_week / start,
            days=(self.days[-1] - self.days[0]).days,
            change_ml=self.change_mm3 / 1000,
            change_within_ml=self.change_95_mm3 / 1000,
            change_share=share,
            plies=abs(share) / PLY_SHARE,
            clear=abs(self.change_mm3) > self.change_95_mm3,
        )


@dataclass(frozen=True, kw_only=True)
class Repeatability:
    """Repeatability from a table of subjects by captures."""

    within_sd: float
    """Standard deviation of one capture about its subject's mean."""
    coefficient: float
    """Two captures of one thing differ by less than this 95 times of 100."""
    icc_2_1: float | None
    """Share of the variance that is the subjects' own; None for one subject."""


@dataclass(frozen=True, kw_only=True)
class BlandAltman:
    """Bias and limits of agreement of pairs of captures, second less first."""

    bias: float
    low: float
    high: float
    """Limits of agreement: 95 of 100 differences lie between them."""


@dataclass(frozen=True, kw_only=True)
class Repeats:
    """Figures of captures of one limb."""

    names: tuple[str, ...]
    stack: ScanStack
    volume: Repeatability
    """mm3."""
    girths: Repeatability
    """mm, over all levels that every capture has."""
    agreement: BlandAltman | None
    """Of the girths of two captures; None where there are more."""

    @property
    def finding(self) -> Finding:
        """A note of how far captures of this limb differ."""
        return note(
            "trend.repeats",
            captures=len(self.names),
            volume_ml=self.volume.coefficient / 1000,
            volume_share=self.volume.coefficient / float(self.stack.volumes_mm3.mean()),
            girth_mm=self.girths.coefficient,
            icc_2_1=self.girths.icc_2_1,
        )


def follow(visits: Sequence[Visit], options: FollowOptions = DEFAULTS) -> Series:
    """Volumes, girths and trends of a limb that was scanned on several days."""
    ordered = sorted(visits, key=lambda visit: visit.day)
    if len({visit.day for visit in ordered}) < 2:
        raise OptionsError("trend.one_day")
    if not 0 < options.assumed_volume_share < 0.5:
        raise OptionsError("trend.repeatability", share=options.assumed_volume_share)
    scans = measure_stack([visit.limb for visit in ordered], options.compare)
    days = np.array([visit.day.toordinal() for visit in ordered], np.float64)
    volume_sigmas, source = _sigmas(
        scans.volumes_mm3, scans.volume_sigmas_mm3, days, options.assumed_volume_share
    )
    return Series(
        days=tuple(visit.day for visit in ordered),
        names=tuple(visit.limb.name for visit in ordered),
        stack=scans,
        sigma_source=source,
        volume_sigmas_mm3=volume_sigmas,
        volume=fit_trend(days, scans.volumes_mm3, volume_sigmas, known=source != "assumed"),
        girths=tuple(
            _girth_trend(days, tapes, sigmas, options.assumed_volume_share / 2)
            for tapes, sigmas in zip(scans.tapes_mm.T, scans.tape_sigmas_mm.T)
        ),
    )


def repeats(limbs: Sequence[Limb], options: CompareOptions) -> Repeats:
    """Repeatability of captures, all aligned on the first.

    Raises:
        MeasureError: no level is whole in every capture.
    """
    unchanged = replace(options.registration, mostly_unchanged=True)
    scans = measure_stack(limbs, replace(options, registration=unchanged))
    whole = np.isfinite(scans.tapes_mm).all(0)
    if not whole.any():
        raise MeasureError("trend.no_whole_level")
    tapes = scans.tapes_mm[:, whole]
    pair = len(limbs) == 2 and tapes.shape[1] >= 2
    independent = independent_levels(tapes.T)
    return Repeats(
        names=tuple(limb.name for limb in limbs),
        stack=scans,
        volume=repeatability(scans.volumes_mm3[None, :]),
        girths=repeatability(tapes.T, independent),
        agreement=bland_altman(tapes[0], tapes[1], independent) if pair else None,
    )


def fit_trend(
    days: Float64[np.ndarray, " n"],
    values: Float64[np.ndarray, " n"],
    sigmas: Float64[np.ndarray, " n"],
    *,
    known: bool = True,
) -> Trend:
    """The line through two values or more on two days or more.

    The sigmas weigh the values. How far these lie from the line tells how large the errors are,
    for a limb also changes from day to day by more than a scan errs; of two values alone the sigmas
    have to tell it. Values that lie nearer to a line than they can be known do so by chance: known
    sigmas are the least that the interval tells. So it is with the probability: Student's by the
    scatter, never more than the known sigmas allow.

    Args:
        known: Whether the sigmas are the scans' own or of repeats, and not assumed.
    """
    weeks = (days - days.min()) / 7.0
    columns = np.column_stack([np.ones_like(weeks), weeks]) / sigmas[:, None]
    covariance = np.linalg.inv(columns.T @ columns)
    line = covariance @ columns.T @ (values / sigmas)
    sigma = float(np.sqrt(covariance[1, 1]))
    slope = abs(float(line[1]))
    scatter, free, probability = None, len(values) - 2, float(ndtr(slope / sigma))
    if free > 0:
        residuals = (values - line[0] - line[1] * weeks) / sigmas
        scatter = float(np.sqrt(residuals @ residuals / free))
        told = sigma * scatter * widening(free)
        by_scatter = float(stdtr(free, slope / max(sigma * scatter, 1e-300)))
        sigma = max(sigma, told) if known else told
        probability = min(probability, by_scatter) if known else by_scatter
    return Trend(
        per_week=float(line[1]),
        per_week_95=COVER * sigma,
        at_start=float(line[0]),
        scatter=scatter,
        probability=probability,
    )


def repeatability(
    table: Float64[np.ndarray, "s c"], independent: float | None = None
) -> Repeatability:
    """Subjects in rows, captures in columns.

    Args:
        independent: How many of the subjects err each for itself; all unless told.

    Raises:
        MeasureError: fewer than two captures.
    """
    subjects, captures = table.shape
    if captures < 2 or subjects < 1 or not np.isfinite(table).all():
        raise MeasureError("trend.few_captures", captures=captures, subjects=subjects)
    within = float(((table - table.mean(1, keepdims=True)) ** 2).sum() / subjects / (captures - 1))
    free = (captures - 1) * (subjects if independent is None else independent)
    return Repeatability(
        within_sd=float(np.sqrt(within)),
        coefficient=float(COVER * widening(free) * np.sqrt(2 * within)),
        icc_2_1=None if subjects < 2 else _icc_2_1(table),
    )


def bland_altman(
    first: Float64[np.ndarray, " n"],
    second: Float64[np.ndarray, " n"],
    independent: float | None = None,
) -> BlandAltman:
    """Bias and limits of agreement of two captures of the same subjects.

    The limits are those of one difference more, whose bias is not known either.

    Args:
        independent: How many of the subjects err each for itself; all unless told. What the others
            err together does not show in how far they lie from their mean. Two captures of one
            thing differ by errors alone, so the differences' whole size tells it.

    Raises:
        MeasureError: fewer than two subjects.
    """
    if len(first) < 2:
        raise MeasureError("trend.few_values", count=len(first))
    off = second - first
    bias, variance, count = float(off.mean()), float(off.var(ddof=1)), float(len(off))
    free = count - 1
    if independent is not None:
        variance, count, free = max(variance, float((off**2).mean())), independent, independent
    spread = COVER * widening(free) * float(np.sqrt(variance * (1 + 1 / count)))
    return BlandAltman(bias=bias, low=bias - spread, high=bias + spread)


def _sigmas(
    values: Float64[np.ndarray, " n"],
    own: Float64[np.ndarray, " n"],
    days: Float64[np.ndarray, " n"],
    assumed_share: float,
) -> tuple[Float64[np.ndarray, " n"], SigmaSource]:
    """The best known standard deviation of each value, and its source."""
    if np.isfinite(own).all() and (own > 0).all():
        return own, "scans"
    _, day = np.unique(days, return_inverse=True)
    repeats = len(values) - int(day.max()) - 1
    if repeats >= _FEWEST_REPEATS:
        means = np.bincount(day, values) / np.bincount(day)
        within = float(((values - means[day]) ** 2).sum()) / repeats
        if within > 0:
            return np.full(len(values), np.sqrt(within) * widening(repeats)), "repeats"
    return assumed_share * np.abs(values), "assumed"


def _girth_trend(
    days: Float64[np.ndarray, " n"],
    tapes_mm: Float64[np.ndarray, " n"],
    sigmas_mm: Float64[np.ndarray, " n"],
    assumed_share: float,
) -> Trend | None:
    known = np.isfinite(tapes_mm)
    if len(np.unique(days[known])) < 2:
        return None
    sigmas, source = _sigmas(tapes_mm[known], sigmas_mm[known], days[known], assumed_share)
    return fit_trend(days[known], tapes_mm[known], sigmas, known=source != "assumed")


def independent_levels(table: Float64[np.ndarray, "k c"]) -> float:
    """The effective number of independent levels in the rows.

    From how alike the errors are at each distance: a variance from k values whose correlations are
    r tells as much as one from k^2 / sum(r^2) independent ones (Bartlett 1946).
    """
    errors = table - table.mean(1, keepdims=True)
    size = float((errors**2).sum())
    if not size > 0:
        return 1.0
    count = len(errors)
    lags = np.arange(1, count)
    products = np.array([float((errors[lag:] * errors[:-lag]).sum()) for lag in lags])
    alike = np.clip(products / (count - lags) * count / size, -1.0, 1.0)
    return float(count / (1 + 2 * ((1 - lags / count) * alike**2).sum()))


def _sigma_or_nan(sigma: float | None) -> float:
    return np.nan if sigma is None else sigma


def _icc_2_1(table: Float64[np.ndarray, "s c"]) -> float:
    """Two-way random effects, absolute agreement, single capture."""
    n, k = table.shape
    mean, rows, columns = table.mean(), table.mean(1), table.mean(0)
    between = k * float(((rows - mean) ** 2).sum()) / (n - 1)
    judges = n * float(((columns - mean) ** 2).sum()) / (k - 1)
    rest = table - rows[:, None] - columns + mean
    error = float((rest**2).sum()) / ((n - 1) * (k - 1))
    below = between + (k - 1) * error + k * (judges - error) / n
    return (between - error) / below if below > 0 else 1.0
