"""Units: what one unit of a file is in millimetres, and whether a limb can be that large."""

import math
import re

import numpy as np

from limbgram.core.errors import OptionsError, ShapeFileError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.units import MM_PER_INCH

_MM_PER = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "inch": MM_PER_INCH, "in": MM_PER_INCH}
_LIKELY_MM = (60.0, 1500.0)
"""Extents of limbs, from a child's forearm to a whole leg or a torso: accepted in any unit."""
_POSSIBLE_MM = (5.0, 5000.0)
"""Extents that are accepted if somebody stated the unit."""


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
    """The unit that a header written by this program states."""
    found = re.search(rb"limbgram.*unit: (\w+)", header)
    return found[1].decode("ascii") if found else None


def check_size(mesh: Mesh, name: str, *, asked: bool) -> None:
    """Refuse a mesh of a size that no limb has.

    asked: Somebody stated the unit, so that only impossible sizes are refused.

    Raises:
        ShapeFileError: too small or too large, with the units in which it would be right.
    """
    extent_mm = extent_of(mesh)
    least_mm, most_mm = _POSSIBLE_MM
    if least_mm <= extent_mm <= most_mm if asked else is_likely(extent_mm):
        return
    if asked:
        raise ShapeFileError("file.size_in_unit", name=name, extent_mm=extent_mm)
    fitting = [unit for unit in ("cm", "inch", "m") if is_likely(extent_mm * _MM_PER[unit])]
    unit, other = (*fitting, None, None)[:2]  # never three: a metre is 100 cm
    raise ShapeFileError(
        "file.size", name=name, extent_mm=extent_mm, fitting_unit=unit, other_unit=other
    )


def extent_of(mesh: Mesh) -> float:
    """Longest side of a mesh's bounding box, mm."""
    return float(np.ptp(mesh.vertices_mm, axis=0).max())


def is_likely(extent_mm: float) -> bool:
    """Whether a limb may have this extent."""
    return _LIKELY_MM[0] <= extent_mm <= _LIKELY_MM[1]
