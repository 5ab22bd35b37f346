"""Parts: the bodies of a reconstruction: number, what each is, its area, place and file.

In      a reconstruction.
Out     their part of the summary, and of that, lines for the terminal. A case of one body needs
        none.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from limbgram.core.mesh.mesh import Mesh, Relation
from limbgram.core.mesh.topology import is_inside_out
from limbgram.findings import told
from limbgram.reconstruction.pipeline import OtherPart, Reconstruction

MAIN_FILE = "surface.stl"
_WORDS = {
    "torn off": "torn off it: a bare strip lies between",
    "apart": "a body apart from it",
}


@dataclass(frozen=True, kw_only=True)
class PartSummary:
    """One body, as summary.json has it."""

    number: int
    relation: Relation
    name: str
    """What it is, for people."""
    area: float
    middle: tuple[float, ...]
    size: float
    file: str | None
    reason: str
    """Why there is no file; empty where there is one."""


def part_file(number: int | str, kind: str) -> str:
    """Name of the file of a part beside the main one."""
    return f"surface-part-{number}.{kind}"


def part_summaries(done: Reconstruction) -> tuple[PartSummary, ...]:
    """Every sizeable body in the order of the numbers, the meant one among them."""
    repairs = done.mesh.repairs
    number = 1 if repairs is None else repairs.part
    meant = _row(number, "chosen", done.mesh, MAIN_FILE)
    if any(one.part.relation == "other side" for one in done.others):
        meant = replace(meant, name=f"{meant.name}, the {_side(done.mesh)} of a wall")
    rows = (meant, *(_other(one) for one in done.others))
    return tuple(sorted(rows, key=lambda row: row.number))


def part_lines(parts: Sequence[PartSummary], unit: str) -> tuple[str, ...]:
    """What people read at the end, where there are several."""
    if len(parts) < 2:
        return ()
    rows = [
        f"  part {row.number}: {row.name}, {area_of(row, unit)}, {place_of(row, unit)}"
        + (f" ({row.file})" if row.file else f". {row.reason}")
        for row in parts
    ]
    return (f"{len(parts)} bodies were measured; --part NUMBER makes another the surface:", *rows)


def area_of(row: PartSummary, unit: str) -> str:
    """A body's area for people."""
    return f"{row.area / 100:.0f} cm\N{SUPERSCRIPT TWO}" if unit == "mm" else f"{row.area:.3g}"


def place_of(row: PartSummary, unit: str) -> str:
    """Where a body is and how large."""
    x, y, z = row.middle
    if unit != "mm":
        return f"round x {x:.3g}, y {y:.3g}, z {z:.3g}, {row.size:.3g} long"
    return f"round x {x:.0f}, y {y:.0f}, z {z:.0f} mm, {row.size:.0f} mm long"


def _side(mesh: Mesh) -> str:
    return "inside" if is_inside_out(mesh) else "outside"


def _name(relation: Relation, mesh: Mesh | None) -> str:
    match relation:
        case "chosen":
            return "the surface"
        case "other side":
            return f"the {'other side' if mesh is None else _side(mesh)} of its wall"
        case _:
            return _WORDS[relation]


def _row(number: int, relation: Relation, mesh: Mesh, file: str) -> PartSummary:
    low, high = mesh.vertices_mm.min(0), mesh.vertices_mm.max(0)
    return PartSummary(
        number=number,
        relation=relation,
        name=_name(relation, mesh),
        area=mesh.area_mm2(),
        middle=tuple(((low + high) / 2).tolist()),
        size=float((high - low).max()),
        file=file,
        reason="",
    )


def _other(one: OtherPart) -> PartSummary:
    part = one.part
    if one.mesh is not None:
        return _row(part.number, part.relation, one.mesh, part_file(part.number, "stl"))
    return PartSummary(
        number=part.number,
        relation=part.relation,
        name=_name(part.relation, None),
        area=part.area_mm2,
        middle=tuple(part.middle_mm.tolist()),
        size=part.size_mm,
        file=None,
        reason="" if one.reason is None else told(one.reason),
    )
