"""Files of templates: short readable JSON, a row of numbers for each height.

Rows run from the tip upwards; the numbers in a row from the front towards the lateral side.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Final, Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import ShapeFileError
from limbgram.core.files import json_of, read_content
from limbgram.core.typed import TOLERANT, value_of
from limbgram.workbench.templates.chart_field import ANGLES, Field, node_heights
from limbgram.workbench.templates.charts import DOME, Along
from limbgram.workbench.templates.template import Template, TemplateMark

_FORMAT = "limbgram template"
_VERSIONS: Final[Mapping[Along, int]] = {"axis": 1, "centreline": 2}
"""Programs that know no centreline refuse a file whose heights count along it."""
_LARGEST_BYTES = 2_000_000
_LARGEST_MM = 60.0
_MOST_PAIRS = 100_000
_TALLEST = 100.0
"""Chart heights count in distances from the round end to the landmark of reference."""
_LONGEST_NAME = 80
_UNKNOWN = "-"


@dataclass(frozen=True, kw_only=True)
class _TemplateFile:
    """What a template's file holds, as far as it is read."""

    format: Literal["limbgram template"]
    version: Literal[1, 2]
    name: str
    pairs: int
    sided: bool
    reference: str
    landmarks: tuple[TemplateMark, ...]
    top: float
    displacement_mm: tuple[str, ...]
    spread_mm: tuple[str, ...]
    known_pairs: tuple[str, ...]
    along: Along = "axis"


def encode_template(template: Template) -> bytes:
    """The template as UTF-8 JSON."""
    tree = {
        "format": _FORMAT,
        "version": _VERSIONS[template.along],
        "made_by": f"limbgram {version('limbgram')}",
        "name": template.name,
        "pairs": template.pairs,
        "sided": template.sided,
        "displacement": "millimetres along the outward normal; negative goes into the shape",
        "heights": f"{-DOME:g} at the tip, 0 where the round end begins, 1 at the landmark "
        f"{template.reference}",
        **({"along": template.along} if template.along != "axis" else {}),
        "angles": f"{ANGLES} in a row, from the front (0 degrees) towards the lateral side (90)",
        "reference": template.reference,
        "landmarks": [
            {
                "name": mark.name,
                "height": round(mark.height, 4),
                "angle_deg": round(mark.angle_deg, 2),
            }
            for mark in template.marks
        ],
        "top": round(float(template.heights[-1]), 4),
        "displacement_mm": _rows(template.displacement_mm, 2),
        "spread_mm": _rows(template.spread_mm, 2),
        "known_pairs": _rows(template.known_pairs.astype(np.float64), 0),
    }
    return (json.dumps(tree, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()


def read_template(path: Path | str) -> Template:
    """A template from its file.

    Raises:
        ShapeFileError: it cannot be read, is of another kind, or holds what cannot be.
    """
    path = Path(path)
    try:
        return decode_template(read_content(path, _LARGEST_BYTES, ShapeFileError))
    except ValueError as error:
        raise ShapeFileError(
            "template.file.unreadable", name=path.name, reason=str(error)
        ) from error


def decode_template(content: bytes) -> Template:
    """The inverse of encoding, to the rounding of the file; ValueError for anything else."""
    file = value_of(json_of(content), _TemplateFile, strictness=TOLERANT)
    if not 0 < file.top <= _TALLEST:
        raise ValueError("top is a height that cannot be")
    if file.version != _VERSIONS[file.along]:
        raise ValueError("heights along a curve that its version does not know")
    heights = node_heights(file.top + 1e-6)
    shape = (len(heights), ANGLES)
    displacement = _field(file.displacement_mm, shape)
    spread = _field(file.spread_mm, shape)
    known = _field(file.known_pairs, shape)
    if not np.isfinite(displacement).all() or np.abs(displacement).max() > _LARGEST_MM:
        raise ValueError("displacements that cannot be")
    if not 1 <= file.pairs <= _MOST_PAIRS:
        raise ValueError("a number of pairs that cannot be")
    if not ((known >= 0) & (known <= file.pairs) & (known == np.floor(known))).all():
        raise ValueError("numbers of pairs that cannot be")
    if (spread < 0).any() or np.nanmax(spread, initial=0.0) > _LARGEST_MM:
        raise ValueError("a spread that cannot be")
    for name in (file.name, file.reference, *(mark.name for mark in file.landmarks)):
        if not 0 < len(name) <= _LONGEST_NAME or not name.isprintable():
            raise ValueError(f"{name[:40]!r} is no name")
    if any(abs(one.height) > _TALLEST or abs(one.angle_deg) > 360 for one in file.landmarks):
        raise ValueError("a landmark without a place")
    return Template(
        name=file.name,
        pairs=file.pairs,
        sided=file.sided,
        reference=file.reference,
        marks=file.landmarks,
        heights=heights,
        displacement_mm=displacement,
        spread_mm=spread,
        known_pairs=known.astype(np.int64),
        along=file.along,
    )


def _rows(field: Field, decimals: int) -> list[str]:
    return [
        " ".join(
            f"{round(value, decimals) + 0.0:.{decimals}f}" if math.isfinite(value) else _UNKNOWN
            for value in row.tolist()
        )
        for row in field
    ]


def _field(rows: tuple[str, ...], shape: tuple[int, int]) -> Float64[np.ndarray, "h a"]:
    field = np.array(
        [[math.nan if cell == _UNKNOWN else float(cell) for cell in row.split()] for row in rows]
    )
    if field.shape != shape or np.isinf(field).any():
        raise ValueError(f"a map of {field.shape} in place of {shape}")
    return field
