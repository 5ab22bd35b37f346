"""Reading a limb: a mesh from any known format, and its limb file.

In      the path of a file of a format that has a reader in table.py.
Out     a Limb in millimetres: one sound mesh, outward; landmarks, frame, side and sock from the
        limb file beside it.
Fails   ShapeFileError: unreadable, damaged, of a size that no limb has, or the limb file of
        another shape.
"""

from dataclasses import dataclass, replace
from pathlib import Path

from limbgram.core.errors import ShapeFileError
from limbgram.core.files import read_content
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.notebook import brief
from limbgram.findings import Finding, note
from limbgram.formats.sidecar import LimbRecord, OfAnother, hash_of, limb_file_beside, read_record
from limbgram.formats.table import FORMATS, format_of
from limbgram.formats.triangle_soup import Sound, Soup, sound_mesh
from limbgram.formats.units import check_size
from limbgram.workbench.carving.radius_map import Grid
from limbgram.workbench.frame.landmarks import unconfirmed_finding
from limbgram.workbench.limb import Limb, LimbFrame, Origin, file_name_doubt
from limbgram.workbench.loose_pieces import without_scraps

_LARGEST_BYTES = 1 << 30
_MM_PER_STATED = {"mm": 1.0, "m": 1000.0}
SUFFIXES = tuple(one.suffix for one in FORMATS if one.read is not None)
"""Extensions of the files that can be read, lower case."""


@dataclass(frozen=True, kw_only=True)
class ShapeFile:
    """A limb, with the hash and unit of the file that it was read from."""

    limb: Limb
    sha256: str
    mm_per_unit: float
    """Millimetres in one unit of the file; 1 for a file in the unit that it states itself, if its
    reader converts it, as that of 3MF does."""
    declared: LimbFrame | None = None
    """Side, front and proximal end that the shape's own file states, as an AOP does; not those of
    its limb file."""
    grid: Grid | None = None
    """Angles and heights of its radii, if it holds radii, as an AOP does."""

    __repr__ = brief


def read_limb(path: Path | str, mm_per_unit: float | None = None) -> Limb:
    """Read a shape and its limb file.

    Args:
        mm_per_unit: Millimetres in one unit of the file; None takes what the limb file or the
            file itself says, and otherwise millimetres if the size is that of a limb.
    """
    return read_shape(path, mm_per_unit).limb


def read_shape(path: Path | str, mm_per_unit: float | None = None) -> ShapeFile:
    """Read a shape as `read_limb` does, with its file's hash and unit."""
    path = Path(path)
    content = _content(path)
    sha256 = hash_of(content)
    found = read_record(limb_file_beside(path), path, sha256)
    record = None if isinstance(found, OfAnother) else found
    soup = _soup(path, content)
    factor = _factor(soup, record, mm_per_unit, path.name)
    if factor is not None and soup.frame is not None:
        soup = replace(soup, frame=_scaled_frame(soup.frame, factor))
    _require_one_side(soup.frame, record, path)
    limb = _limb(path, soup, record, factor)
    own = Origin(sha256=sha256, mm_per_unit=factor or 1.0, mesh_from_origin=Rigid.identity())
    doubt = (None if record is None else record.doubt) or file_name_doubt(path.name)
    if doubt is not None:
        limb = replace(limb, doubt=doubt, notes=(doubt, *limb.notes))
    open_marks = unconfirmed_finding(limb)
    if open_marks is not None:
        limb = replace(limb, notes=(open_marks, *limb.notes))
    limb = replace(limb, origins=(own, *(() if record is None else record.made_from)))
    if isinstance(found, OfAnother):
        limb = replace(limb, notes=(*limb.notes, _unused(path, found)))
    return ShapeFile(
        limb=limb,
        sha256=sha256,
        mm_per_unit=factor or 1.0,
        declared=soup.frame,
        grid=soup.grid if factor in (None, 1.0) else None,
    )


def _limb(path: Path, soup: Soup, record: LimbRecord | None, factor: float | None) -> Limb:
    sound = _measured(soup, factor, path.name)
    limb = Limb(mesh=sound.mesh, name=path.name, notes=(*soup.notes, *sound.notes))
    if record is None:
        marks = tuple(
            replace(mark, position_mm=mark.position_mm * (factor or 1.0)) for mark in soup.landmarks
        )
        limb = replace(limb, landmarks=marks)
        told = soup.frame is not None and soup.frame.front_told
        return limb.with_frame(soup.frame) if told and soup.frame else limb
    limb = replace(limb, landmarks=record.landmarks, sock_mm=record.sock_mm, kind=record.kind)
    return limb if record.frame is None else limb.with_frame(record.frame)


def _require_one_side(declared: LimbFrame | None, record: LimbRecord | None, path: Path) -> None:
    """Refuse a limb file that contradicts the side in the shape's own file."""
    if declared is None or record is None or record.frame is None:
        return
    sides = {declared.side, record.frame.side}
    if sides == {"left", "right"}:
        raise ShapeFileError(
            "file.limb.other_side",
            name=path.name,
            side=declared.side,
            limb_file=limb_file_beside(path).name,
            limb_file_side=record.frame.side,
        )


def _unused(path: Path, record: OfAnother) -> Finding:
    return note(
        "file.limb.unused",
        limb_file=limb_file_beside(path).name,
        owner=record.mesh_name,
        name=path.name,
    )


def read_mesh(path: Path, mm_per_unit: float | None = None) -> Mesh:
    """The surface without its limb file.

    Args:
        mm_per_unit: None takes the file's own unit and, where it states none, millimetres.
    """
    soup = _soup(path, _content(path))
    factor = mm_per_unit or _MM_PER_STATED.get(soup.stated_unit or "", 1.0)
    return _measured(soup, factor, path.name).mesh


def _soup(path: Path, content: bytes) -> Soup:
    known_as = format_of(path)
    if known_as is None or known_as.read is None:
        known = tuple(suffix[1:].upper() for suffix in SUFFIXES)
        raise ShapeFileError("file.unknown_kind", name=path.name, known=known)
    return known_as.read(content, path.name)


def _measured(soup: Soup, mm_per_unit: float | None, name: str) -> Sound:
    sound = sound_mesh(_scaled(soup.mesh, mm_per_unit or 1.0), name)
    check_size(sound.mesh, name, asked=mm_per_unit is not None)
    strays = without_scraps(sound.mesh)
    return Sound(strays.mesh, (*sound.notes, *strays.findings()))


def _content(path: Path) -> bytes:
    return read_content(path, _LARGEST_BYTES, ShapeFileError, note("file.name_the_export"))


def _factor(soup: Soup, record: LimbRecord | None, asked: float | None, name: str) -> float | None:
    """Millimetres in one unit of the soup; None if neither file nor caller states it."""
    if asked is not None:
        factor = asked / soup.converted_by
        if record is not None and abs(record.mm_per_unit / factor - 1) > 1e-9:
            raise ShapeFileError(
                "file.limb.other_unit",
                name=name,
                mm_per_unit=record.mm_per_unit * soup.converted_by,
                asked_mm_per_unit=asked,
            )
        return factor
    if record is not None:
        return record.mm_per_unit
    if soup.stated_unit == "unitless":
        raise ShapeFileError("file.unitless", name=name)
    return _MM_PER_STATED.get(soup.stated_unit or "")


def _scaled_frame(frame: LimbFrame, factor: float) -> LimbFrame:
    """A frame that a file states in its own unit, for the scaled mesh."""
    motion = frame.limb_from_mesh
    return replace(frame, limb_from_mesh=Rigid(motion.rotation, motion.translation * factor))


def _scaled(mesh: Mesh, factor: float) -> Mesh:
    if factor == 1.0:
        return mesh
    known = mesh.of_vertices(
        lambda one, values: (values * factor).astype("f4") if one.in_mm else values
    )
    return replace(
        mesh,
        vertices_mm=mesh.vertices_mm * factor,
        correlation_mm=None if mesh.correlation_mm is None else mesh.correlation_mm * factor,
        **known,
    )
