"""Verdict: whether the known lengths agree well enough to be believed."""

from limbgram.errors import ScaleError
from limbgram.scale.metric import LengthCheck, Scale
from limbgram.scale.plate import Plate

_SURE_SIGMAS = 3.0
"""A stretch within this many standard deviations of none is noise."""


def check_plate(plate: Plate, max_disagreement: float) -> None:
    """Refuse a board that is seen too poorly, is stretched, or whose halves disagree."""
    sigma = plate.ruler.relative_sigma
    if not sigma <= max_disagreement:
        raise ScaleError(
            f"The board gives the scale only to {sigma:.2%} (one standard deviation); "
            f"{max_disagreement:.2%} is allowed. It is too small, too far away or seen in too "
            "few photos. Lay it close beside the limb, flat and in view of most photos."
        )
    if abs(plate.stretch) > max(max_disagreement, _SURE_SIGMAS * plate.stretch_sigma):
        longer, shorter = ("x", "y") if plate.stretch > 0 else ("y", "x")
        raise ScaleError(
            f"The board is {abs(plate.stretch):.2%} longer along its {longer} than along its "
            f"{shorter}; {max_disagreement:.2%} is allowed. It was printed at different scales "
            "across and along the paper, or it is bent. Print it at 100 %, without fitting to "
            "the page, glue it to a flat plate and measure both ways; or give a known distance."
        )
    if abs(plate.check_error) > max_disagreement:
        raise ScaleError(
            f"The corners that check the board disagree with those that set the scale by "
            f"{plate.check_error:+.2%}; {max_disagreement:.2%} is allowed. The board is bent or "
            "moved, or few of its corners are seen well. Glue it to a flat plate beside the limb."
        )


def check_lengths(scale: Scale, max_disagreement: float) -> None:
    """Refuse where a length, whether it set the scale or checks it, contradicts the scale."""
    wrong = [one for one in scale.lengths if not abs(one.error) <= max_disagreement]
    if wrong:
        worst = max(wrong, key=lambda one: abs(one.error))
        others = ", ".join(one.label for one in scale.lengths if one.role == "control")
        raise ScaleError(
            f"{worst.label} is {worst.known_mm:g} mm long but measures {worst.measured_mm:.2f} mm "
            f"({worst.error:+.2%}, sigma {worst.sigma_mm:.2f} mm) where the scale is set by "
            f"{others}; {max_disagreement:.2%} is allowed. {_advice(scale, worst)}"
        )


def _advice(scale: Scale, worst: LengthCheck) -> str:
    if worst.sigma_mm > abs(worst.measured_mm - worst.known_mm) / 2:
        return "It is measured too poorly: pick its ends in more photos, from more sides."
    if scale.source == "distances":
        return (
            "A length was mistyped, a mark moved, or a wrong point was picked. Check the lengths "
            "and the picks, or leave out the odd one."
        )
    return (
        "The board's squares are not as large as given, or the typed length is wrong. Measure a "
        "long row of squares and the length again; the board may have been printed fitted to "
        "the page."
    )
