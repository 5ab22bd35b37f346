"""Permissible errors: how far off the user lets the kit be, as a manufacturer would declare it.

In      texts such as 0.3 (mm, for every kind of error) or length=0.05+L/1000 (for one kind).
Out     a limit by kind.
Fails   OptionsError: a text that is none, or none at all.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from limbgram.core.errors import OptionsError

Kind = Literal["form", "form-all", "size", "spacing", "length", "surface"]
KINDS: Mapping[Kind, str] = {
    "form": "probing error of form, 95 % of the points",
    "form-all": "probing error of form, all points",
    "size": "probing error of size",
    "spacing": "sphere-spacing error",
    "length": "length measurement error",
    "surface": "distance from the calibrated mesh, 95 % of the points",
}
"""Every error that is tested, in words."""
_NAMES: Mapping[str, Kind] = {kind: kind for kind in KINDS}
_ALWAYS: tuple[Kind, ...] = ("form", "size", "spacing", "length", "surface")
"""What a permissible error without a name is for: all but the one that a single stray point
decides."""
_FORMULA = re.compile(r"(?P<base>[0-9.]+)(?:\+L/(?P<per>[0-9.]+))?")


@dataclass(frozen=True, kw_only=True)
class Permissible:
    """The largest error that the user permits: base + L / per."""

    base_mm: float
    per: float = math.inf

    def at(self, length_mm: float) -> float:
        """The permissible error for a length; a form has no length."""
        return self.base_mm + length_mm / self.per

    def __str__(self) -> str:
        more = "" if math.isinf(self.per) else f" + L/{self.per:g}"
        return f"{self.base_mm:g}{more} mm"


Limits = dict[Kind, Permissible]


def parse_limits(texts: Sequence[str]) -> Limits:
    """Permissible errors: `0.2` for all, `length=0.05+L/1000` for one kind, which counts first.

    Raises:
        OptionsError: a text is none, or there is none.
    """
    general: Permissible | None = None
    limits: Limits = {}
    for text in texts:
        name, equals, formula = text.rpartition("=")
        found = _FORMULA.fullmatch(formula.replace(" ", ""))
        kind = _NAMES.get(name.strip())
        if found is None or (equals and kind is None):
            raise OptionsError("kit.no_permissible", text=text, kinds=tuple(KINDS))
        limit = Permissible(
            base_mm=_number(found["base"], text),
            per=math.inf if found["per"] is None else _number(found["per"], text),
        )
        if kind is None:
            general = limit
        else:
            limits[kind] = limit
    if general is not None:
        limits = {**dict.fromkeys(_ALWAYS, general), **limits}
    if not limits:
        raise OptionsError("kit.nothing_permitted")
    return limits


def _number(text: str, whole: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < 1e6:
        raise OptionsError("kit.not_above_0", whole=whole, text=text)
    return value
