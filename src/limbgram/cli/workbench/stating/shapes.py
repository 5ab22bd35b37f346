"""Shapes: a shape and its unit, stated and read alike by every command."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.shape.reading import ShapeFile, mm_per_unit_of, read_shape

ShapeArgument = Annotated[Path, typer.Argument(help="The shape: STL, PLY, OBJ, GLB or AOP.")]
AlignedShape = Annotated[Path, typer.Argument(help="The aligned shape: STL, PLY, OBJ, GLB or AOP.")]
UnitOption = Annotated[
    str | None,
    typer.Option("--unit", help="Unit of the file: mm, cm, m, inch, or so many mm."),
]
UnitOfAll = Annotated[
    str | None,
    typer.Option("--unit", help="Unit of all files: mm, cm, m, inch, or so many mm."),
]


def shape_of(path: Path, unit: str | None) -> ShapeFile:
    """Read a shape; without a typed unit its limb file says it, else the file, else millimetres.

    Raises:
        OptionsError: the unit is none.
        ShapeFileError: the file cannot be read, or is no limb in that unit.
    """
    return read_shape(path, None if unit is None else mm_per_unit_of(unit))
