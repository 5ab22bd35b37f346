"""Shape options: arguments and checks that all commands on shapes share."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from limbgram.core.errors import OptionsError
from limbgram.core.files import require_place
from limbgram.formats.reading import SUFFIXES, ShapeFile, read_shape
from limbgram.formats.sidecar import LIMB_FILE_ENDING
from limbgram.formats.units import mm_per_unit_of

_NAMES = [suffix[1:].upper() for suffix in SUFFIXES]
Output = Literal["picture", "recipe", "program", "machine", "table", "map", "template", "sheet"]
"""What is written, as the words of `options.output` name it."""
READ = f"{', '.join(_NAMES[:-1])} or {_NAMES[-1]}"
"""The formats that are read, for help."""
ShapeArgument = Annotated[Path, typer.Argument(help=f"The shape: {READ}.")]
AlignedShape = Annotated[Path, typer.Argument(help=f"The aligned shape: {READ}.")]
UnitOption = Annotated[
    str | None,
    typer.Option("--unit", help="Unit of the file: mm, cm, m, inch, or so many mm."),
]
UnitOfAll = Annotated[
    str | None,
    typer.Option("--unit", help="Unit of all files: mm, cm, m, inch, or so many mm."),
]


def shape_of(path: Path, unit: str | None) -> ShapeFile:
    """Read a shape; the unit is the one given, else the limb file's, else the file's, else mm.

    Raises:
        OptionsError: the unit is not known.
        ShapeFileError: the file cannot be read, or is no limb in that unit.
    """
    return read_shape(path, None if unit is None else mm_per_unit_of(unit))


def require_output(path: Path | None, ending: str, what: Output) -> None:
    """Refuse an output path with another ending, or that could not be written.

    Raises:
        OptionsError: another ending, or a limb file's name.
        ExportError: its folder is missing, or may not be written to.
    """
    if path is not None and path.suffix.lower() != ending:
        raise OptionsError("options.output.no_name", name=path.name, what=what, ending=ending)
    if path is not None and path.name.lower().endswith(LIMB_FILE_ENDING):
        raise OptionsError("options.output.limb_file", name=path.name, what=what)
    if path is not None:
        require_place(path)


def require_no_shape(path: Path, what: Output) -> None:
    """Refuse a shape's ending for a file that is no shape.

    Raises:
        OptionsError: the path has such an ending.
    """
    if path.suffix.lower() in SUFFIXES:
        raise OptionsError("options.output.shape_name", name=path.name, what=what)


def require_apart(path: Path | None, read: Path) -> None:
    """Refuse an output path that is the input, or that could not be written.

    Raises:
        OptionsError: both are one file.
        ExportError: its folder is missing, or may not be written to.
    """
    if path is not None and path.resolve() == read.resolve():
        raise OptionsError("options.output.takes_place", name=path.name)
    if path is not None:
        require_place(path)
