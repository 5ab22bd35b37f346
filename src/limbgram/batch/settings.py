"""Settings: the schema of a batch file (TOML); unknown names and wrong values are refused.

In      batch.toml beside the captures, or capture.toml inside one.
Out     Settings; None where nothing is set, so that one file can override another.
Fails   OptionsError: the file cannot be read or holds an unknown name or value, with its place.

Settings of all captures are overridden by those that batch.toml has for one ([capture.NAME]), and
these by the capture.toml in the capture's own folder. A table, such as [align], is taken whole from
the last file that has it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, cast, get_origin

from limbgram.core.errors import OptionsError, printable
from limbgram.core.files import read_content, toml_of
from limbgram.core.request_fields import Declared, declared
from limbgram.core.typed import Mismatch, Strictness, any_value_of, fields_of, value_of
from limbgram.services.align import Axes
from limbgram.services.export import EXPORTS, FOR_CARVERS, Export, Gcode
from limbgram.services.measure import MeasureRequest
from limbgram.services.parse_capture import Box, box_of, names_board_file
from limbgram.services.reconstruct import ReconstructRequest
from limbgram.services.report import ReportRequest
from limbgram.workbench.limb import KindName, Side

BATCH_FILE = "batch.toml"
CAPTURE_FILE = "capture.toml"

_LARGEST_BYTES = 1_000_000


@dataclass(frozen=True, kw_only=True)
class Align(Axes):
    """How the surface gets its axes, and the files of its landmarks."""

    stickers: str | None = None
    """File of the names of coded stickers."""
    landmarks: str | None = None
    """File of landmarks: {"fibula head": [x, y, z]} in mm in the frame of the surface."""


@dataclass(frozen=True, kw_only=True)
class RecipeUse:
    """Which edits are made: what `limbgram edit apply` takes."""

    file: str
    other_scan: bool = False


@dataclass(frozen=True, kw_only=True)
class ExportUse:
    """One file for another program or machine: `to` and what the request of that kind takes."""

    to: str
    ask: Export

    @property
    def machine(self) -> str | None:
        """File of a carver."""
        machine = self.ask.machine if isinstance(self.ask, Gcode) else None
        return None if machine is None else machine.as_posix()


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What is done with a capture."""

    photos: str | None = None
    """Folder inside the capture in which its photos lie."""
    reconstruct: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Fields of `ReconstructRequest` that are set; they stand at the file's top level."""
    side: Side | None = None
    kind: KindName | None = None
    align: Align | None = None
    measure: MeasureRequest | None = None
    recipe: RecipeUse | None = None
    export: tuple[ExportUse, ...] | None = None
    report: ReportRequest | None = None

    @property
    def files(self) -> tuple[str, ...]:
        """Files and folders that the settings name."""
        align = self.align or Align()
        board: str | None = self.reconstruct.get("board")
        named = (
            self.photos,
            board if names_board_file(board or "") else None,
            *(one.as_posix() for name in _FILES for one in self.reconstruct.get(name, ())),
            align.stickers,
            align.landmarks,
            None if self.recipe is None else self.recipe.file,
            *(one.machine for one in self.export or ()),
        )
        return tuple(name for name in named if name is not None)

    def overlaid(self, later: "Settings") -> "Settings":
        """These settings, overridden by the later ones."""
        later_values = {one.name: getattr(later, one.name) for one in fields(later)}
        later_values["reconstruct"] = {**self.reconstruct, **later.reconstruct}
        return replace(self, **{name: one for name, one in later_values.items() if one is not None})

    def request(self, located: Callable[[str], Path]) -> ReconstructRequest:
        """The reconstruction request, the files in it located.

        Raises:
            OptionsError: a file is not there.
        """
        values = dict(self.reconstruct)
        for name in _FILES:
            values[name] = tuple(located(one.as_posix()) for one in values.get(name, ()))
        if names_board_file(values.get("board", "")):
            values["board"] = str(located(values["board"]))
        return ReconstructRequest(**values)


_RECONSTRUCT_FIELDS = {one.name: one for one in declared(ReconstructRequest)}
_FILES = tuple(name for name, one in _RECONSTRUCT_FIELDS.items() if one.hint == tuple[Path, ...])


@dataclass(frozen=True, kw_only=True)
class Batch:
    """What a batch file says."""

    captures: tuple[str, ...] = ("*",)
    """Patterns of what is a capture, relative to the folder."""
    leave_out: tuple[str, ...] = ()
    """Patterns of what is no capture."""
    of_all: Settings = field(default_factory=Settings)
    of_one: Mapping[str, Settings] = field(default_factory=dict[str, Settings])
    """By the name of the capture."""


@dataclass(frozen=True, kw_only=True)
class _Patterns:
    captures: tuple[str, ...] = ("*",)
    leave_out: tuple[str, ...] = ()


def read_batch(path: Path) -> Batch:
    """The settings of a batch.

    Raises:
        OptionsError: the file cannot be read, or something in it has no place there.
    """
    tree = _tree(path)
    of_one = tree.pop("capture", {})
    if not isinstance(of_one, dict):
        raise OptionsError("batch.capture_is_no_table", path=str(path))
    patterns = {name: tree.pop(name) for name in ("captures", "leave_out") if name in tree}
    try:
        chosen = value_of(patterns, _Patterns)
        return Batch(
            captures=chosen.captures,
            leave_out=chosen.leave_out,
            of_all=_settings(tree, ""),
            of_one={
                name: _settings(one, f"capture.{name}")
                for name, one in cast(dict[str, Any], of_one).items()
            },
        )
    except ValueError as error:
        raise _misfit(path, error) from error


def read_settings(path: Path) -> Settings:
    """The settings of one capture.

    Raises:
        OptionsError: as for a batch.
    """
    tree = _tree(path)
    try:
        settings = _settings(tree, "")
    except ValueError as error:
        raise _misfit(path, error) from error
    for name in settings.files:
        if not is_inside(name):
            raise OptionsError(
                "batch.file_outside",
                path=str(path),
                name=printable(name, keep=""),
                settings=BATCH_FILE,
            )
    return settings


def is_inside(name: str) -> bool:
    """Whether a path stays in the folder that it is relative to, on every system."""
    path = PurePosixPath(name)
    return not (path.is_absolute() or ".." in path.parts or "\\" in name or ":" in name)


def require_complete(settings: Settings) -> None:
    """Refuse a step whose input no step before it makes.

    Raises:
        OptionsError: says which, and what to add.
    """
    if settings.align is not None and settings.side is None:
        raise OptionsError("batch.side_missing")
    if settings.align is not None and settings.reconstruct.get("unscaled"):
        raise OptionsError("batch.unscaled_not_aligned")
    unaligned = settings.measure is not None and settings.measure.unaligned
    after = {
        "[measure]": settings.measure is not None and not unaligned,
        "[recipe]": settings.recipe is not None,
        "[report]": settings.report is not None,
        "[[export]] to aop or gcode": any(one.to in FOR_CARVERS for one in settings.export or ()),
    }
    missing = [name for name, wanted in after.items() if wanted and settings.align is None]
    if missing:
        raise OptionsError("batch.not_aligned", tables=tuple(missing))


def _tree(path: Path) -> dict[str, Any]:
    content = read_content(path, _LARGEST_BYTES, OptionsError)
    try:
        return toml_of(content)
    except ValueError as error:
        raise _misfit(path, error) from error


def _settings(tree: object, at: str) -> Settings:
    """Settings from a table that holds fields of the reconstruction beside tables of the steps."""
    if not isinstance(tree, dict):
        raise Mismatch(f"{at} must be a table, not {tree!r:.60}")
    given = cast(dict[str, Any], tree)
    names = [one.name for one in fields(Settings) if one.name != "reconstruct"]
    unknown = [name for name in given if name not in (*names, *_RECONSTRUCT_FIELDS)]
    if unknown:
        has = ", ".join((*names, *_RECONSTRUCT_FIELDS))
        raise Mismatch(f"{at or 'it'} has no {', '.join(unknown):.80}. It has: {has}")
    steps = {name: given[name] for name in names if name in given}
    reconstruct = {
        name: any_value_of(given[name], _hint(one), f"{at}.{name}" if at else name, _SHORT_FORMS)
        for name, one in _RECONSTRUCT_FIELDS.items()
        if name in given
    }
    return replace(value_of(steps, Settings, at, _EXPORTS), reconstruct=reconstruct)


def _hint(one: Declared) -> Any:
    """The type of a field, with its bounds."""
    return one.hint if one.within is None else Annotated[one.hint, one.within]


def _from_short_form(tree: object, hint: Any, at: str) -> object:
    """A value that a file may shorten: one string for a list, a box as one row of six numbers."""
    if hint == Box:
        box = box_of(any_value_of(tree, _ROW, at))
        if box is None:
            raise Mismatch(f"{at} has a lowest corner that does not lie below its highest one")
        return box
    if isinstance(tree, str) and get_origin(hint) is tuple:
        return any_value_of([tree], hint, at)
    return NotImplemented


def _export(tree: object, hint: Any, at: str) -> object:
    """An export: `to` says which request the other names are fields of."""
    if hint is not ExportUse or not isinstance(tree, dict):
        return NotImplemented
    given = dict(cast(dict[str, Any], tree))
    kind = given.pop("to", None)
    if kind not in EXPORTS:
        raise Mismatch(f"{at}.to must be one of {', '.join(EXPORTS)}, not {kind!r:.60}")
    if "write_machine" in given:
        raise Mismatch(f"{at} has no write_machine: a batch reads machine files")
    return ExportUse(to=kind, ask=fields_of(given, EXPORTS[kind], at))


_ROW = tuple[float, float, float, float, float, float]
_SHORT_FORMS = Strictness(special=_from_short_form)
_EXPORTS = Strictness(special=_export)


def _misfit(path: Path, error: ValueError) -> OptionsError:
    return OptionsError("batch.settings_misfit", path=str(path), why=str(error))


EXAMPLE = """# What `limbgram batch FOLDER -o CASES` does with each capture in FOLDER.
# Save it as FOLDER/batch.toml. Every line may be left out. A file that is named here is looked
# for in the capture's own folder first, then beside this file.

captures = ["*"]                 # folders of photos, zips and videos that are captures
leave_out = ["calibration*"]     # what is none

camera = "camera.json"           # of `limbgram calibrate`; several in brackets
board = "charuco:7x5:30:22:4X4_50"   # or a board file of `limbgram print`, or "none"
# known_distances = "distances.json"
# marks = "bars.json"            # plates of `limbgram print`
# tapes = ["widest=354"]         # girths read on the limb, to test the size by
# photos = "images"              # folder inside each capture in which its photos lie
# surface = "ball-pivoting"      # or "poisson"
# triangles = 400000
# unscaled = false
# part = 1
# box_mm = [-80, -80, 5, 80, 80, 400]
# memory_gb = 8                  # of each case

side = "left"                    # left, right or none: needed to align
kind = "transtibial"             # transfemoral, foot, torso, head, arm, cast or socket

[align]                          # gives the surface its axes
stickers = "stickers.json"       # {"12": "fibula head"}
# landmarks = "landmarks.json"   # {"fibula head": [12.0, -40.5, 310.2]}, mm
# axis = "fit"
# proximal = "+z"
# anterior = "+y"
# plumb = "UPPER:LOWER"
# flexion_deg = 0.0

[measure]                        # a table as CSV and JSON, and a picture
every_mm = 10
# heights_mm = [50, 100]
# reference = "patella"
# volumes = ["20:150"]
# lengths = ["patella:tibia end"]
# tapes = ["150=354"]
# through = "patella"            # of several limbs, the one to measure
# inside = true                 # what a socket holds
# along = true                  # across the kind's centreline too, in the JSON
# sock_mm = 1.5
# sheet = true                  # the measuring sheet of the kind of limb, in the JSON
# shoe_heel_mm = 20             # of the shoe: it inclines the shank
# shoe_sole_mm = 8
# click_mm = 1.5                # how well landmarks were placed: clicked, painted, proposed
# painted_mm = 0.8
# proposed_mm = 4

# [recipe]                       # edits; what follows is then done to the edited shape
# file = "recipe.toml"
# other_scan = true              # though it was made for another surface

[[export]]                       # one for each file: stl 3mf ply obj glb vtp dxf aop gcode xlsx csv
to = "aop"
# spokes = 120
# spacing_mm = 3.0

[[export]]
to = "stl"

[report]                         # the record of the shape: page, PDF and JSON
every_mm = 20
# reference = "patella"
# align = "as-is"                # with a recipe: how the edited shape is laid on the surface

# [capture.P07]                  # what is other for one of them
# side = "right"
# tapes = ["widest=341"]
"""
