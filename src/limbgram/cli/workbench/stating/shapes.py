"""Shapes: a shape and its unit, stated and read alike by every command."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.errors import OptionsError
from limbgram.shape.reading import SUFFIXES, ShapeFile, mm_per_unit_of, read_shape
from limbgram.shape.reading.sidecar import LIMB_FILE_ENDING

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


def require_output(path: Path | None, ending: str, what: str) -> None:
    """Refuse a name that would hide what the file is, or take the place of a scan.

    Raises:
        OptionsError: the name ends otherwise than files of this kind do.
    """
    if path is not None and path.suffix.lower() != ending:
        raise OptionsError(f"{path.name} is no name for {what}. Let it end in {ending}.")
    if path is not None and path.name.lower().endswith(LIMB_FILE_ENDING):
        raise OptionsError(
            f"{path.name} is the name of the landmarks and axes of a shape. Choose another one for "
            f"{what}."
        )


def require_no_shape(path: Path, what: str) -> None:
    """Refuse to write what is no shape under the name of one.

    Raises:
        OptionsError: the name ends as a shape's does.
    """
    if path.suffix.lower() in SUFFIXES:
        raise OptionsError(
            f"{path.name} is the name of a shape, and {what} is to be written. Choose another "
            "ending, so that no scan is lost."
        )


def require_apart(path: Path | None, read: Path) -> None:
    """Refuse to write over a file that is read.

    Raises:
        OptionsError: they are one file.
    """
    if path is not None and path.resolve() == read.resolve():
        raise OptionsError(f"{path.name} would take the place of the shape. Choose another name.")
