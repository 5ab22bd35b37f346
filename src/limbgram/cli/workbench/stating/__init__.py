"""Stating: what is typed on a command line, as the library takes it."""

from limbgram.cli.workbench.stating.shapes import (
    AlignedShape,
    ShapeArgument,
    UnitOfAll,
    UnitOption,
    require_apart,
    require_no_shape,
    require_output,
    shape_of,
)
from limbgram.cli.workbench.stating.typed import (
    asks_for_marks,
    colour_of,
    direction,
    landmarks_of,
    pair_of,
    reading_of,
    span_of,
)

__all__ = [
    "AlignedShape",
    "ShapeArgument",
    "UnitOfAll",
    "UnitOption",
    "asks_for_marks",
    "colour_of",
    "direction",
    "landmarks_of",
    "pair_of",
    "reading_of",
    "require_apart",
    "require_no_shape",
    "require_output",
    "shape_of",
    "span_of",
]
