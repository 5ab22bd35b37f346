"""Verdict: what a comparison means for the fit of a socket, in a sentence.

Limits: a mean radial error beyond 0.25 mm was found in every socket that had to be remade for its
size, an interquartile range beyond 0.40 mm in many that had to be changed (Sanders et al. 2012).
Both are blind to a small place that was moved by much, so that is looked for by its area.
"""

from dataclasses import dataclass
from typing import Literal

from limbgram.geometry.interval import HOLDS, Interval, plus_minus
from limbgram.shape.comparing.comparing import ByShape, Comparison
from limbgram.shape.comparing.deviation import LOCAL_LIMIT_MM
from limbgram.shape.comparing.levels import PLY_SHARE, Change

MRE_LIMIT_MM = 0.25
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


@dataclass(frozen=True)
class Verdict:
    """A grade for machines, and a sentence for people."""

    grade: Grade
    sentence: str


def verdict(comparison: Comparison) -> Verdict:
    """Size by the mean radial error, shape by its interquartile range."""
    radial = comparison.radial
    if radial is None:
        figures = comparison.deviation.on_first.figures
        return Verdict(
            "not graded",
            f"{_volume(comparison)} Not graded: no radial errors; the surfaces are "
            f"{figures.rms_mm:.2f} mm apart (RMS). Alignment: {comparison.alignment.sentence}.",
        )
    figures = comparison.deviation.on_first.figures
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
    meaning = {
        "alike": "alike, as far as a socket's fit can tell",
        "differs in places": "alike but for places",
        "size differs": "of another size, the same shape",
        "shape differs": "of the same size, another shape",
        "size and shape differ": "of another size and another shape",
    }[grade]
    places = (
        f"{figures.far_mm2 / 100:.0f} cm2 differ by more than {LOCAL_LIMIT_MM:g} mm, the most by "
        f"{figures.largest_mm:.1f} mm. "
        if local
        else ""
    )
    return Verdict(
        grade,
        f"The shapes are {meaning}: mean radial error {_signed(radial.mre_mm)} mm (limit "
        f"{MRE_LIMIT_MM:.2f}), interquartile range {radial.iqr_mm:.2f} mm (limit "
        f"{IQR_LIMIT_MM:.2f}). {places}{_volume(comparison)} Alignment: "
        f"{comparison.alignment.sentence}.",
    )


def _signed(value_mm: float) -> str:
    return f"{round(value_mm, 2) + 0.0:+.2f}"


def _volume(comparison: Comparison) -> str:
    """The headline: the volume's change with its interval, twice where two ways of laying the
    shapes on each other contradict."""
    levels = comparison.levels
    change, plies = levels.volume, levels.plies
    if change is None or plies is None:
        return "The volume could not be compared."
    reach = volume_reach(change, levels.laid_sigma_mm3)
    start = "the distal end" if levels.from_mm is None else f"{levels.from_mm:g} mm"
    span = f"from {start} to {levels.to_mm:g} mm"
    by_shape = comparison.by_shape
    after = _holds(change) if reach else ""
    if by_shape is not None and by_shape.at_odds:
        after += f" {by_shape_sentence(by_shape)}"
    if abs(change.share) < PLY_SHARE / 20:
        same = f"{change.difference / 1000:+.1f}{reach} mL"
        return f"The volumes {span} are the same ({same}).{after}"
    size = "larger" if change.difference > 0 else "smaller"
    return (
        f"The second is {abs(change.difference) / 1000:.1f}{reach} mL ({abs(change.share):.1%}) "
        f"{size} {span}, like {abs(plies):.1f} sock plies.{after}"
    )


def volume_reach(change: Change, laid_sigma_mm3: float) -> str:
    """ " ± 3.1", mL, by what is known: the scans' errors and how they were laid, or that alone."""
    sigma = change.sigma if change.sigma is not None else laid_sigma_mm3
    return f" {plus_minus(Interval.of_sigma(sigma / 1000), 1)}" if sigma > 0 else ""


def by_shape_sentence(by_shape: ByShape) -> str:
    """What the volume would be by shape, and whether that contradicts."""
    change = by_shape.volume
    told = f"{change.difference / 1000:+.1f}{volume_reach(change, by_shape.laid_sigma_mm3)} mL"
    if not by_shape.at_odds:
        return f"Laid by their shape alone the change would be {told}, which agrees."
    return (
        f"Laid by their shape alone the change would be {told}: the two ways disagree, and which "
        "is right depends on where the second belongs along the axis. Look at the picture."
    )


def _holds(change: Change) -> str:
    """What the ± says, and of what."""
    if change.sigma is None:
        return (
            f" {HOLDS}, as far as it is how they were laid: the scans tell no error of their own."
        )
    return f" {HOLDS}."
