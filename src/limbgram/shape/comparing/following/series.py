"""Series: one limb over time: volume and girths at each visit, and their trends.

In      visits: a scan and its day; several scans of one day are repeats.
Out     a Series. Where a change lies within its uncertainty, it says so.
Method  all scans laid on the first; weighted least squares. A scan's sigma is its own if it has
        one, else the spread of repeats on one day, else the assumed share of the options.
Fails   OptionsError: fewer than two days. MeasureError: scans that cannot be compared.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import date
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.errors import OptionsError
from limbgram.geometry.interval import COVER, Interval, plus_minus
from limbgram.shape.comparing.comparing import CompareOptions
from limbgram.shape.comparing.following.stack import Stack, stack
from limbgram.shape.comparing.following.trend import Trend, fit_trend
from limbgram.shape.comparing.levels import PLY_SHARE
from limbgram.shape.limb import Limb

_FEWEST_REPEATS = 2

SigmaSource = Literal["scans", "repeats", "assumed"]


@dataclass(frozen=True, kw_only=True)
class Visit:
    """A scan and when it was taken."""

    limb: Limb
    day: date


@dataclass(frozen=True, kw_only=True)
class FollowOptions:
    """How scans are compared, and what is taken for their repeatability where none is known."""

    compare: CompareOptions = field(default_factory=CompareOptions)
    assumed_volume_share: float = 0.01
    """One standard deviation of a volume; half of it for a girth."""


DEFAULTS = FollowOptions()


@dataclass(frozen=True, kw_only=True)
class Series:
    """Volumes and girths over time, in the order of the days."""

    days: tuple[date, ...]
    names: tuple[str, ...]
    stack: Stack
    sigma_source: SigmaSource
    volume_sigmas_mm3: Float64[np.ndarray, " n"]
    volume: Trend
    """mm3 per week."""
    girths: tuple[Trend | None, ...]
    """mm per week, by level; None where too few visits have the level."""

    @property
    def change_mm3(self) -> float:
        """Last visit less first."""
        return float(self.stack.volumes_mm3[-1] - self.stack.volumes_mm3[0])

    @property
    def change_95_mm3(self) -> float:
        """Uncertainty of that change, 95 %."""
        return COVER * float(np.hypot(self.volume_sigmas_mm3[-1], self.volume_sigmas_mm3[0]))

    @property
    def sentence(self) -> str:
        start = float(self.stack.volumes_mm3[0])
        change, reach = self.change_mm3 / 1000, self.change_95_mm3 / 1000
        rate = self.volume.per_week / 1000
        about = plus_minus(Interval.of_half_width(self.volume.per_week_95 / 1000), 1)
        within = plus_minus(Interval.of_half_width(reach), 1)
        span = f"{(self.days[-1] - self.days[0]).days} days"
        share = self.change_mm3 / start
        rates = f"{rate:+.1f} {about} mL a week ({self.volume.per_week / start:+.2%} a week)"
        if not self.volume.told:
            return (
                f"No trend can be told: the volume's {rates} over {span} lies within its "
                f"uncertainty (95 %). Last scan less first: {change:+.1f} {within} mL."
            )
        word = "grows" if rate > 0 else "shrinks"
        return (
            f"The limb {word}: {rates}, 95 %. Last scan less first, {span}: {change:+.1f} "
            f"{within} mL ({share:+.1%}, like {abs(share) / PLY_SHARE:.1f} sock plies)"
            + ("." if abs(change) > reach else ", within its uncertainty by itself.")
        )


def follow(visits: Sequence[Visit], options: FollowOptions = DEFAULTS) -> Series:
    """Volumes, girths and trends of a limb that was scanned on several days."""
    ordered = sorted(visits, key=lambda visit: visit.day)
    if len({visit.day for visit in ordered}) < 2:
        raise OptionsError(
            "All scans are of one day, so there is no trend. Give the day of each scan; for "
            "repeated scans of an unchanged limb ask for their repeatability instead."
        )
    if not 0 < options.assumed_volume_share < 0.5:
        raise OptionsError(
            f"A repeatability of {options.assumed_volume_share:.2%} of the volume cannot be used. "
            "Write one standard deviation in per cent, such as 1."
        )
    scans = stack([visit.limb for visit in ordered], options.compare)
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
        volume=fit_trend(days, scans.volumes_mm3, volume_sigmas),
        girths=tuple(
            _girth_trend(days, tapes, sigmas, options.assumed_volume_share / 2)
            for tapes, sigmas in zip(scans.tapes_mm.T, scans.tape_sigmas_mm.T)
        ),
    )


def _girth_trend(
    days: Float64[np.ndarray, " n"],
    tapes_mm: Float64[np.ndarray, " n"],
    sigmas_mm: Float64[np.ndarray, " n"],
    assumed_share: float,
) -> Trend | None:
    known = np.isfinite(tapes_mm)
    if len(np.unique(days[known])) < 2:
        return None
    sigmas, _ = _sigmas(tapes_mm[known], sigmas_mm[known], days[known], assumed_share)
    return fit_trend(days[known], tapes_mm[known], sigmas)


def _sigmas(
    values: Float64[np.ndarray, " n"],
    own: Float64[np.ndarray, " n"],
    days: Float64[np.ndarray, " n"],
    assumed_share: float,
) -> tuple[Float64[np.ndarray, " n"], SigmaSource]:
    """The best known standard deviation of each value, and where it is from."""
    if np.isfinite(own).all() and (own > 0).all():
        return own, "scans"
    _, day = np.unique(days, return_inverse=True)
    repeats = len(values) - int(day.max()) - 1
    if repeats >= _FEWEST_REPEATS:
        means = np.bincount(day, values) / np.bincount(day)
        within = float(((values - means[day]) ** 2).sum()) / repeats
        if within > 0:
            return np.full(len(values), np.sqrt(within)), "repeats"
    return assumed_share * np.abs(values), "assumed"
