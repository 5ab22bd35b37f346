"""Content: what a record holds, in the order in which it is written as JSON.

In mm and mL. Measures and comparison are the trees that `limbgram measure` and `limbgram compare`
reply with, so that whoever reads one reads the others.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from limbgram.capture.setup import SetupCited
from limbgram.findings import Finding
from limbgram.report.intended_use import OF_SHAPES
from limbgram.report.record.bias import Bias
from limbgram.report.verdict_light import Light
from limbgram.workbench.limb import Side
from limbgram.workbench.recipe.ledger import Line

SCHEMA = "limbgram-report/2"
NAMES_NOTE = (
    "No name is printed here: files are told by the first digits of their SHA-256, landmarks "
    "with names of their own by numbers in the order of the limb file."
)

Json = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Mark:
    """A landmark under the name that is printed."""

    name: str
    in_limb_mm: tuple[float, ...]
    confirmed: bool = True
    """False of a proposal that nobody has looked at."""


@dataclass(frozen=True, kw_only=True)
class RecipeDone:
    """A recipe that was done to its scan again, and its ledger."""

    id: str
    scan: str
    apart_mm: float | None
    """Largest distance between what it makes and the shape; None where the record is of the scan
    itself."""
    notes: tuple[str, ...]
    levels_mm: tuple[float, ...]
    places_mm: Mapping[str, float]
    """How far all edits together moved the surface at each sensitive place."""
    lines: tuple[Line, ...]


@dataclass(frozen=True, kw_only=True)
class CaseCited:
    """What the case of the scan says of itself."""

    id: str
    light: Light
    headline: str
    """The verdict of the capture."""
    delivered: bool
    """Whether a shape of the record is a file of the case."""
    check_lengths: int
    check_worst: float | None
    expected_p95_mm: float | None
    setups: tuple[SetupCited, ...] = ()
    """Acceptance tests of the kit."""


@dataclass(frozen=True, kw_only=True)
class TapeRead:
    """A girth read by tape, the scan's girth there, and what was decided about both."""

    made: str
    """When it was read, ISO 8601; empty where nobody noted it."""
    height_mm: float
    """From the distal end."""
    read_mm: float
    measured_mm: float | None
    within_mm: float | None
    """± of the difference, of tape and scan together; holds in 95 of 100."""
    conflict: bool
    reason: Finding | None = None
    """Why there is nothing to compare with."""
    withdrawn: str = ""
    """When it was taken back."""
    accepted: str = ""
    """When somebody went on in spite of the conflict."""


@dataclass(frozen=True, kw_only=True)
class SourceFile:
    """A file that the record stands on."""

    what: str
    id: str
    kind: str
    sha256: str


@dataclass(frozen=True, kw_only=True)
class Content:
    """Everything that is kept of a shape."""

    schema: str = SCHEMA
    id: str
    side: Side
    unit: Literal["mm"] = "mm"
    intended_use: str = OF_SHAPES
    names: str = NAMES_NOTE
    size_mm: tuple[float, ...]
    triangles: int
    notes: tuple[str, ...]
    measures: Json
    sheet: Json | None
    """The measuring sheet of the kind of limb; None where no kind was said, or it has none."""
    inside: Json | None
    """The measures of what a wall holds; None without a wall."""
    landmarks: tuple[Mark, ...]
    comparison: Json | None
    recipe: RecipeDone | None
    case: CaseCited | None
    case_untold: bool = False
    """There is a verdict on the capture that cannot be cited."""
    case_id: str = ""
    """Under which the case is kept; it has no name in it."""
    tape: tuple[TapeRead, ...] = ()
    bias: tuple[Bias, ...]
    files: tuple[SourceFile, ...]
    versions: dict[str, str]
    findings: tuple[Finding, ...] = ()
    """The grave ones first."""
