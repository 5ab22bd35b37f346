"""A format: reader, writer and properties of a kind of file that holds a shape.

A format is one file of this folder. Its line `FORMAT = Format(...)` puts it into the table, from
which reading, export, deliverables and the tests of round trips follow.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

from limbgram.core.mesh.mesh import Mesh
from limbgram.findings.tell import Language
from limbgram.formats.triangle_soup import Soup
from limbgram.formats.writing import Unit
from limbgram.workbench.limb import Landmark

Kept = Literal["colours", "filled", "sigma", "shared errors", "lost length"]
"""What a file may keep of each vertex, beside its position."""


class MeshWriter(Protocol):
    """Writes a mesh and reads the file back; returns the path, which has the unit's mark."""

    def __call__(self, mesh: Mesh, path: Path, unit: Unit, *, unscaled: bool = False) -> Path: ...


class MarkedWriter(Protocol):
    """Writes a mesh with its landmarks, in mm, and reads both back."""

    def __call__(self, mesh: Mesh, path: Path, landmarks: Sequence[Landmark]) -> Path: ...


@dataclass(frozen=True, kw_only=True)
class Format:
    """A kind of file that holds a shape."""

    suffix: str
    """Lower case."""
    place: int
    """Order among the formats, in lists and deliverables."""
    used_for: Mapping[Language, str]
    """Which machines or programs take it, in a few words for people."""
    read: Callable[[bytes, str], Soup] | None = None
    write: MeshWriter | None = None
    """None also where writing needs more than a mesh, as AOP needs an aligned limb."""
    write_marked: MarkedWriter | None = None
    """Where the file itself has room for landmarks."""
    keeps: frozenset[Kept] = frozenset()
    within_mm: float = 1e-6
    """How far from its place a vertex may be read back, for a limb of a metre."""
    unit: Literal["mm", "m"] = "mm"
    """Of the files that are written."""

    @property
    def name(self) -> str:
        """Lower case, as `--to` takes it."""
        return self.suffix[1:]

    @property
    def mm_per_unit(self) -> float:
        """Of the files that are written."""
        return {"mm": 1.0, "m": 1000.0}[self.unit]

    @property
    def holds_limbs(self) -> bool:
        """Whether a limb can be stored in it: written, and read again."""
        return self.read is not None and self.write is not None
