"""Files of templates: short readable JSON, a row of numbers for each height.

Rows run from the tip upwards; the numbers in a row from the front towards the lateral side.
"""

import json
import math
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float64

from limbgram.errors import ShapeFileError
from limbgram.shape.templates.charts import DOME
from limbgram.shape.templates.fields import ANGLES, Field, node_heights
from limbgram.shape.templates.template import Template, TemplateMark

_FORMAT, _VERSION = "limbgram template", 1
_LARGEST_BYTES = 2_000_000
_LARGEST_MM = 60.0
_UNKNOWN = "-"


def encode_template(template: Template) -> bytes:
    """The template as UTF-8 JSON."""
    tree = {
        "format": _FORMAT,
        "version": _VERSION,
        "made_by": f"limbgram {version('limbgram')}",
        "name": template.name,
        "pairs": template.pairs,
        "sided": template.sided,
        "displacement": "millimetres along the outward normal; negative goes into the shape",
        "heights": f"{-DOME:g} at the tip, 0 where the round end begins, 1 at the landmark "
        f"{template.reference}",
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


def read_template(path: Path) -> Template:
    """A template from its file.

    Raises:
        ShapeFileError: it cannot be read, is of another kind, or holds what cannot be.
    """
    try:
        if path.stat().st_size > _LARGEST_BYTES:
            raise ValueError("it is too large")
        return decode_template(path.read_bytes())
    except OSError as error:
        raise ShapeFileError(f"{path} cannot be read: {error.strerror or error}.") from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ShapeFileError(
            f"{path.name} is no template that can be read ({type(error).__name__}: {error}). "
            "Choose a file that `limbgram template learn` wrote, or learn it again."
        ) from error


def decode_template(content: bytes) -> Template:
    """The inverse of encoding, to the rounding of the file; ValueError for anything else."""
    tree = json.loads(content)
    if tree["format"] != _FORMAT or tree["version"] != _VERSION:
        raise ValueError("it is of another program or a later version")
    heights = node_heights(float(tree["top"]) + 1e-6)
    shape = (len(heights), ANGLES)
    displacement = _field(tree["displacement_mm"], shape)
    spread = _field(tree["spread_mm"], shape)
    known = _field(tree["known_pairs"], shape)
    if not np.isfinite(displacement).all() or np.abs(displacement).max() > _LARGEST_MM:
        raise ValueError("displacements that cannot be")
    if not np.isfinite(known).all() or known.min() < 0:
        raise ValueError("numbers of pairs that cannot be")
    return Template(
        name=_text(tree["name"]),
        pairs=int(tree["pairs"]),
        sided=_flag(tree["sided"]),
        reference=_text(tree["reference"]),
        marks=tuple(_mark(mark) for mark in tree["landmarks"]),
        heights=heights,
        displacement_mm=displacement,
        spread_mm=spread,
        known_pairs=known.astype(np.int64),
    )


def _rows(field: Field, decimals: int) -> list[str]:
    return [
        " ".join(
            f"{round(value, decimals) + 0.0:.{decimals}f}" if math.isfinite(value) else _UNKNOWN
            for value in row.tolist()
        )
        for row in field
    ]


def _field(rows: Any, shape: tuple[int, int]) -> Float64[np.ndarray, "h a"]:
    field = np.array(
        [[math.nan if cell == _UNKNOWN else float(cell) for cell in row.split()] for row in rows]
    )
    if field.shape != shape or np.isinf(field).any():
        raise ValueError(f"a map of {field.shape} in place of {shape}")
    return field


def _mark(tree: Any) -> TemplateMark:
    height, angle = float(tree["height"]), float(tree["angle_deg"])
    if not (math.isfinite(height) and math.isfinite(angle)):
        raise ValueError("a landmark without a place")
    return TemplateMark(name=_text(tree["name"]), height=height, angle_deg=angle)


def _text(value: Any) -> str:
    if not isinstance(value, str) or not 0 < len(value) <= 80 or not value.isprintable():
        raise ValueError(f"{str(value)[:40]!r} is no name")
    return value


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError(f"{str(value)[:40]!r} in place of true or false")
    return value
