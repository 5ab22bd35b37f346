"""The limb: a surface with what a clinician knows of it.

A surface whose capture was judged red goes on saying so: by its name, which travels with every
copy, and from there by the limb file of whatever is made from it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Literal, get_args

from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.notebook import brief
from limbgram.findings import Finding

Side = Literal["left", "right", "none"]
Kind = Literal["transtibial", "transfemoral", "foot", "torso"]
"""Of limb: it tells what the names of landmarks mean."""
KINDS: tuple[Kind, ...] = get_args(Kind)
_MARK = "-RED"
RED = (
    "this surface comes from a capture whose verdict is RED: much of the limb is missing, or its "
    "size or shape may be wrong by a ply of sock or more; report.html of the case says why. Make "
    "nothing from it unchecked"
)


@dataclass(frozen=True, kw_only=True)
class Landmark:
    """A named point on the surface."""

    name: str
    position_mm: Vector3
    """In the mesh's frame."""


@dataclass(frozen=True, kw_only=True)
class LimbFrame:
    """Where the limb's axes lie: origin on the long axis at the distal end,

    +Z proximal, +Y anterior, +X the patient's right.
    """

    limb_from_mesh: Rigid
    side: Side
    """As the clinician confirmed it; geometry is never flipped by it."""
    front_told: bool = True
    """False only of what a file declares that leaves the front open, as an AOP of ampscan does: it
    is no limb's frame until somebody says where the front lies."""


@dataclass(frozen=True, kw_only=True)
class Origin:
    """A file that a shape was read of, or made from."""

    sha256: str
    mm_per_unit: float
    """As it was read."""
    mesh_from_origin: Rigid
    """From that file's axes to those of the shape's mesh, in millimetres."""


@dataclass(frozen=True, kw_only=True)
class Limb:
    """What every step of the workbench takes and gives."""

    mesh: Mesh
    landmarks: tuple[Landmark, ...] = ()
    frame: LimbFrame | None = None
    """None until aligned."""
    kind: Kind | None = None
    """None until somebody said it."""
    sock_mm: float = 0.0
    """Thickness of the sock that has been taken off the surface already."""
    name: str = ""
    """Of the file it came from, without folder; never a patient's."""
    origins: tuple[Origin, ...] = ()
    """Files that it is known to come from, the nearest first: by these a shape and what was made
    from it lie as they were made. Who gives the mesh other axes moves these along."""
    doubt: str = ""
    """Why nothing may be made of it unchecked; kept in the limb file of whatever comes of it."""
    notes: tuple[Finding, ...] = ()
    """What was odd about that file and how it was taken."""

    __repr__ = brief

    def with_mesh(self, mesh: Mesh) -> "Limb":
        return replace(self, mesh=mesh)


def names_apart(names: Sequence[str]) -> tuple[str, ...]:
    """Names each of which stands once: those that stood before get a number behind them."""
    taken = set(names)
    found: list[str] = []
    for name in names:
        own, number = name, 1
        while own in found or (number > 1 and own in taken):
            number += 1
            own = f"{name} ({number})"
        found.append(own)
    return tuple(found)


def likeliest(name: str, known: Iterable[str]) -> str | None:
    """The name that was probably meant; None if none is like.

    Capitals do not count, and a slip of the pen leaves more than half of the letters (difflib).
    """
    by_small = {one.casefold(): one for one in known}
    near = get_close_matches(name.strip().casefold(), by_small, n=1)
    return by_small[near[0]] if near else None


def marked_red(path: Path) -> Path:
    """The name of a red result: surface.stl becomes surface-RED.stl."""
    return path.with_name(f"{path.stem}{_MARK}{path.suffix}")


def doubt_of_name(name: str) -> str:
    """What a file's name says against it; empty where it says nothing."""
    stem = Path(name).stem
    return RED if stem.removesuffix("-unitless").endswith(_MARK) else ""
