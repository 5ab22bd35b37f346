"""The table of formats: which files hold a shape, who reads and writes them, and what they keep.

All that depends on the format follows from here: what is read, as what a limb is kept, what
`limbgram export --to` offers, which files of its surface a case delivers, and what the tests of
round trips demand.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.aop.reading import read_aop_soup
from limbgram.formats.dxf import write_dxf
from limbgram.formats.glb import read_glb, write_glb
from limbgram.formats.obj import read_obj, write_obj
from limbgram.formats.ply import read_ply, write_ply
from limbgram.formats.soup import Soup
from limbgram.formats.stl import read_stl, write_stl
from limbgram.formats.threemf import read_3mf, write_3mf
from limbgram.formats.writing import Unit

Kept = Literal["colours", "filled", "sigma", "shared errors", "lost length"]
"""What a file may keep of each vertex, beside its place."""


class MeshWriter(Protocol):
    """Writes a mesh and reads the file back; returns the path, which has the unit's mark."""

    def __call__(self, mesh: Mesh, path: Path, unit: Unit, *, unscaled: bool = False) -> Path: ...


@dataclass(frozen=True, kw_only=True)
class Format:
    """A kind of file that holds a shape."""

    suffix: str
    """Small letters."""
    read: Callable[[bytes, str], Soup] | None = None
    write: MeshWriter | None = None
    """None also where writing needs more than a mesh, as AOP needs an aligned limb."""
    keeps: frozenset[Kept] = frozenset()
    within_mm: float = 1e-6
    """How far from its place a vertex may be read back, for a limb of a metre."""
    unit: Literal["mm", "m"] = "mm"
    """Of the files that are written."""

    @property
    def name(self) -> str:
        """Small letters, as `--to` takes it."""
        return self.suffix[1:]

    @property
    def mm_per_unit(self) -> float:
        """Of the files that are written."""
        return {"mm": 1.0, "m": 1000.0}[self.unit]

    @property
    def holds_limbs(self) -> bool:
        """Whether a limb can be kept so: written, and read again."""
        return self.read is not None and self.write is not None


FORMATS = (
    Format(suffix=".stl", read=read_stl, write=write_stl, within_mm=1e-4),
    Format(suffix=".3mf", read=read_3mf, write=write_3mf, within_mm=4e-6),
    Format(suffix=".dxf", write=write_dxf),
    Format(
        suffix=".ply",
        read=read_ply,
        write=write_ply,
        keeps=frozenset({"colours", "filled", "sigma", "shared errors", "lost length"}),
        within_mm=1e-4,
    ),
    Format(suffix=".obj", read=read_obj, write=write_obj),
    Format(
        suffix=".glb",
        read=read_glb,
        write=write_glb,
        keeps=frozenset({"colours", "sigma"}),
        within_mm=1e-4,
        unit="m",
    ),
    Format(suffix=".aop", read=read_aop_soup),
)
"""In the order in which they are offered and delivered."""


def format_of(path: Path) -> Format | None:
    """The format by the path's ending; None where it is none of the table."""
    return next((one for one in FORMATS if one.suffix == path.suffix.lower()), None)
