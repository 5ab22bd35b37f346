"""Units: what one unit of a file is in millimetres, and whether a limb can be that large."""

import math
import re

from limbgram.core.errors import OptionsError, ShapeFileError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.units import MM_PER_INCH

_MM_PER = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "inch": MM_PER_INCH, "in": MM_PER_INCH}
LIKELY_MM = (60.0, 1500.0)
"""Extents that pass unasked: from a child's forearm to a whole leg or a torso."""
_POSSIBLE_MM = (5.0, 5000.0)


def mm_per_unit_of(text: str) -> float:
    """Millimetres in a unit: mm, cm, m, inch, or a number for a file with a unit of its own."""
    if text in _MM_PER:
        return _MM_PER[text]
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise OptionsError("file.no_unit", text=text)
    return value


def stated_unit(header: bytes) -> str | None:
    """What a header of ours says of the unit."""
    found = re.search(rb"limbgram.*unit: (\w+)", header)
    return found[1].decode("ascii") if found else None


def check_size(mesh: Mesh, name: str, *, asked: bool) -> None:
    """Refuse a limb of a size that limbs do not have.

    asked: Somebody said what the unit is, so only the impossible is refused.

    Raises:
        ShapeFileError: too small or too large, with the units in which it would be right.
    """
    extent_mm = float((mesh.vertices_mm.max(0) - mesh.vertices_mm.min(0)).max())
    low, high = _POSSIBLE_MM if asked else LIKELY_MM
    if low <= extent_mm <= high:
        return
    if asked:
        raise ShapeFileError("file.size_in_unit", name=name, extent_mm=extent_mm)
    fitting = [unit for unit in ("cm", "inch", "m") if _fits(extent_mm * _MM_PER[unit])]
    unit, other = (*fitting, None, None)[:2]  # three never fit: from cm to m is 1 to 100
    raise ShapeFileError(
        "file.size", name=name, extent_mm=extent_mm, fitting_unit=unit, other_unit=other
    )


def _fits(extent_mm: float) -> bool:
    return LIKELY_MM[0] <= extent_mm <= LIKELY_MM[1]
