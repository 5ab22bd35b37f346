"""Sources: the files a record stands on, and what is printed instead of their names.

File names, folder names and landmarks' own names are often patients' names. A record prints none
of them: a file is told by the first digits of its SHA-256, a landmark whose name no template knows
by its number.

Replaying: a recipe done again, so that a record's ledger is computed and not copied.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from limbgram.capture.setup import SetupCited
from limbgram.core.errors import OptionsError
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import Finding
from limbgram.report.verdict_light import Light
from limbgram.workbench.anatomy.names import known_identity
from limbgram.workbench.edits.from_template import FromTemplate
from limbgram.workbench.frame.landmarks import notes_but_unconfirmed
from limbgram.workbench.limb import Limb
from limbgram.workbench.recipe.ledger import Ledger
from limbgram.workbench.recipe.recipe import Recipe, replay_as_it_is

_DIGITS = 8


@dataclass(frozen=True, kw_only=True)
class ShapeSource:
    """A shape and the file it was read from."""

    limb: Limb
    sha256: str
    kind: str
    """Ending of the file, such as PLY."""
    limb_file_sha256: str | None
    """Of the limb file beside it; None without one."""

    @property
    def id(self) -> str:
        return f"shape {self.sha256[:_DIGITS]}"


@dataclass(frozen=True, kw_only=True)
class RecipeSource:
    """A recipe and the hash of its file."""

    recipe: Recipe
    sha256: str

    @property
    def id(self) -> str:
        return f"recipe {self.sha256[:_DIGITS]}"


@dataclass(frozen=True, kw_only=True)
class CheckLength:
    """A known length that did not set the scale, as far as a record cites it."""

    label: str


@dataclass(frozen=True, kw_only=True)
class CheckedScale:
    """How the scale of a case was checked."""

    check: tuple[CheckLength, ...]
    check_rms: float | None
    """None, as in accuracy.json, where nothing checked it."""
    check_worst: float | None


@dataclass(frozen=True, kw_only=True)
class ExpectedOfCase:
    """The error that a case expects on its surface."""

    basis: str
    rms_mm: float | None
    p95_mm: float | None


@dataclass(frozen=True, kw_only=True)
class CaseAccuracy:
    """What a record cites of accuracy.json; its names are the file's."""

    light: Light
    headline: Finding
    lengths: CheckedScale
    expected: ExpectedOfCase
    setups: tuple[SetupCited, ...] = ()
    """Acceptance tests of the kit."""


@dataclass(frozen=True, kw_only=True)
class CaseSource:
    """What a finished case says of its own accuracy."""

    sha256: str
    """Of its photos (`PhotoSet.digest`), as its own pages name it."""
    accuracy: CaseAccuracy
    files: frozenset[str]
    """SHA-256 of every file that it delivered."""

    @property
    def id(self) -> str:
        return f"case {self.sha256[:_DIGITS]}"


def printed_names(recipe: RecipeSource | None, *shapes: ShapeSource | None) -> dict[str, str]:
    """What is printed for each landmark's name: a known place's as it is, others numbered.

    Of the shapes, and of the templates that the recipe holds.
    """
    names = [mark.name for one in shapes if one is not None for mark in one.limb.landmarks]
    for entry in () if recipe is None else recipe.recipe.entries:
        if isinstance(entry.edit, FromTemplate):
            names += [mark.name for mark in entry.edit.template().marks]
    printed: dict[str, str] = {}
    own = 0
    for name in dict.fromkeys(names):
        known = known_identity(name) is not None
        own += not known
        printed[name] = name if known else f"own landmark {own}"
    return printed


def with_printed_names(source: ShapeSource, printed: Mapping[str, str]) -> ShapeSource:
    """The shape under its id, with landmarks under the names that are printed."""
    limb = source.limb
    return replace(
        source,
        limb=replace(
            limb,
            name=source.id,
            landmarks=tuple(
                replace(mark, name=printed.get(mark.name, mark.name)) for mark in limb.landmarks
            ),
            notes=tuple(
                _with_name_replaced(note, limb.name, source.id)
                for note in notes_but_unconfirmed(limb)
            ),
        ),
    )


def text_with_printed_names(text: str, printed: Mapping[str, str]) -> str:
    """An edit, or what it says, in words, its landmarks under the names that are printed."""
    for name, printed_name in printed.items():
        text = text.replace(f'"{name}"', f'"{printed_name}"')
    return text


def _with_name_replaced(note: Finding, name: str, instead: str) -> Finding:
    return note.with_texts(lambda text: text.replace(name, instead)) if name else note


SAME_MM = 0.01
"""A shape nearer than this to what the recipe makes is what the recipe made."""


@dataclass(frozen=True, kw_only=True)
class ReplayedRecipe:
    """A recipe replayed on the scan that it is for."""

    recipe: RecipeSource
    scan: ShapeSource
    ledger: Ledger
    apart_mm: float | None
    """Largest distance between what it makes of the scan and the shape of the record; None where
    the record is of the scan itself."""
    told: tuple[Finding, ...] = ()
    """What was said of the scan before the first edit."""


def replayed_on(
    recipe: RecipeSource, shape: ShapeSource, against: ShapeSource | None
) -> ReplayedRecipe:
    """Do a recipe to the scan it is for: the other shape or, if it is for that, the shape itself.

    Raises:
        OptionsError: it is for neither of them.
    """
    scan = _scan(recipe, shape, against)
    done = replay_as_it_is(recipe.recipe, scan.limb)
    apart = None if scan is shape else _apart_mm(done.limb.mesh, shape.limb.mesh)
    said = {one for line in done.ledger.lines for one in line.told}
    told = tuple(
        _with_name_replaced(note, scan.limb.name, scan.id)
        for note in done.limb.notes
        if note not in {*said, *shape.limb.notes}
    )
    return ReplayedRecipe(recipe=recipe, scan=scan, ledger=done.ledger, apart_mm=apart, told=told)


def _scan(recipe: RecipeSource, shape: ShapeSource, against: ShapeSource | None) -> ShapeSource:
    wanted = recipe.recipe.scan_sha256
    others = [source for source in (against, shape) if source is not None]
    for source in others:
        if wanted in ("", source.sha256):
            return source
    raise OptionsError("record.recipe.other_scan", scans=tuple(one.limb.name for one in others))


def _apart_mm(one: Mesh, other: Mesh) -> float:
    """Largest distance between two surfaces, at their vertices."""
    if one.vertices_mm.shape == other.vertices_mm.shape:
        direct = float(np.abs(one.vertices_mm - other.vertices_mm).max())
        if direct <= SAME_MM:
            return direct
    trees = (TriangleTree.of(mesh.vertices_mm, mesh.faces) for mesh in (other, one))
    both = zip(trees, (one, other), strict=True)
    return max(float(tree.closest(mesh.vertices_mm).distances_mm.max()) for tree, mesh in both)
