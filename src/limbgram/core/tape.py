"""Tape: the sigma of a taped girth, and when a reading contradicts a surface.

One rule for the measuring table, the verdict, the app and the record: the difference between
reading and surface in combined standard deviations, of the tape (its reading, and the height at
which it lay) and of the girth on the surface.
"""

import math
import re
from collections.abc import Iterable

from limbgram.core.errors import OptionsError
from limbgram.core.interval import COVER

READING_SIGMA_MM = 1.5
"""Standard deviation of one reading, if none is stated. Lengths on below-knee limbs repeat
within 1 % (Commean et al. 1996, Arch Phys Med Rehabil 77:477-486): 3 mm on a girth of 300 mm, taken
as two standard deviations. Where several people tape at a line drawn on the calf, 96 % of pairs
lie within 6 mm (Tunc et al. 2007, Angiology 58:593-596): 2.1 mm for one reading."""
PLACING_SIGMA_MM = 3.0
"""Standard deviation of the height at which a tape was laid."""
TAPER_SHARES = (1.0, 0.5, 0.25, 0.125)
"""Of that: how far beside the tape another girth is looked for; nearer beside a brim or a hole."""
AGREES_SIGMAS = 2.0
"""Up to here a reading agrees, as 95 % of the readings of a correct surface do."""
CONTRADICTS_SIGMAS = 4.0
"""Beyond, the reading contradicts: on 350 mm this is 6 mm, three plies of sock."""


def require_tape(girth_mm: float, sigma_mm: float) -> None:
    """Refuse a girth or a sigma that no tape on a limb has."""
    if not (math.isfinite(girth_mm) and 10 < girth_mm < 3000):
        raise OptionsError("mesh.girth.impossible", girth_mm=girth_mm)
    if not 0 < sigma_mm < girth_mm:
        raise OptionsError("mesh.girth.sigma", sigma_mm=sigma_mm, usual_sigma_mm=READING_SIGMA_MM)


def read_girth(text: str) -> tuple[float, float]:
    """Girth and its standard deviation, mm, from a text: 354, or 354+-4 with a 95 % interval.

    Both are NaN if the text is no girth.

    >>> read_girth("354")
    (354.0, 1.5)
    >>> read_girth("354 ± 1.96")
    (354.0, 1.0)
    """
    girth, *stated = re.split(r"±|\+-|\+/-", text, maxsplit=1)
    try:
        return float(girth), float(stated[0]) / COVER if stated else READING_SIGMA_MM
    except ValueError:
        return math.nan, math.nan


def taper_beside_mm(girth_mm: float, beside_mm: Iterable[float]) -> float:
    """Change of the girth over the tape's placing error to one side; 0 where no girth is known.

    In proportion from the first of `beside_mm` that is a number: the girths at `TAPER_SHARES`.
    """
    off_mm = (one - girth_mm for one in beside_mm)
    changes_mm = (abs(one) / share for share, one in zip(TAPER_SHARES, off_mm, strict=True))
    return next(filter(math.isfinite, changes_mm), 0.0)


def tape_sigma_mm(reading_sigma_mm: float, taper_mm: float) -> float:
    """Standard deviation of a taped girth.

    Args:
        taper_mm: Change of the girth over `PLACING_SIGMA_MM` along the limb.
    """
    return math.hypot(reading_sigma_mm, taper_mm)


def sigmas_apart(difference_mm: float, *sigmas_mm: float) -> float:
    """A difference in combined standard deviations."""
    return abs(difference_mm) / math.hypot(*sigmas_mm)
