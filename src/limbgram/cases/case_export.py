"""Case export: exports a case's shape for machines and programs, and reads each file back.

In      the work on an aligned case, a kind of file, and the side as somebody confirms it now.
Out     WORK/files/NAME, its limb file where it is a shape, NAME.mirror.png drawn from what was read
        back, and NAME.json: figures, hashes, doubts and who signed. NAME has the hash of the shape
        and of the options, so that no file is overwritten by another one.
Method  The same services as `limbgram edit apply` and `limbgram export`, so the bytes are the same.
Fails   as they do: not aligned, another side, a surface that folds, a shape that the format cannot
        hold, no room.
"""

from dataclasses import dataclass, field
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

from limbgram.cases.case_record import set_aside, unreadable, utc_now, write_json
from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.workspace import MAKING, MIRROR_ENDING, Work, Workspace, digits_of
from limbgram.core.errors import CarveError, CaseError
from limbgram.core.files import json_of, read_content
from limbgram.core.typed import TOLERANT, Mismatch, tree_of, value_of
from limbgram.findings import Finding
from limbgram.formats.reading import read_shape
from limbgram.services.export import Export, Triangles, export, file_name
from limbgram.workbench.limb import Side

_LARGEST_BYTES = 4_000_000


@dataclass(frozen=True, kw_only=True)
class ExportOptions:
    """What the receiver expects."""

    kind: str
    """Of the file, by the names of `services.export.EXPORTS`."""
    side: Side
    """As it is confirmed now, not as it was kept."""
    signed_by: str = ""
    """Who takes responsibility for the shape of a red capture, and why."""
    ask: Export = field(default_factory=Triangles)


@dataclass(frozen=True, kw_only=True)
class ExportedFile:
    """A file that was written, and what was read back of it."""

    name: str
    kind: str
    made: str
    """Date and time, UTC."""
    bytes: int
    sha256: str
    side: Side
    unit: str
    scan_sha256: str
    recipe_sha256: str = ""
    """Of the recipe's file; empty in what was written before this was kept."""
    recipe_edits: int
    shape: str = ""
    """Name of the shape after the recipe, from which it was made; empty where that is the scan, and
    in what was written before this was kept."""
    said: tuple[Finding, ...] = ()
    """Findings from reading it back."""
    surface_within_mm: float | None = None
    """Largest distance between the shape and the file."""
    girth_change_mm: float | None = None
    volume_change: float | None = None
    """As a fraction."""
    minutes: float | None = None
    """Of carving."""
    doubt: Finding | None = None
    """Why nothing may be made of it unchecked."""
    signed_by: str = ""
    notes: tuple[Finding, ...] = ()


def export_shape(workspace: Workspace, work: Work, options: ExportOptions) -> ExportedFile:
    """Write a file and read it back; an equal file that was written before is returned.

    Args:
        work: A recipe without edits hands over the scan itself.

    Raises:
        CarveError: a red capture that nobody signed for; not aligned, or another side.
    """
    with MAKING.of(workspace.root):
        return _exported(workspace, work, options)


def _exported(workspace: Workspace, work: Work, options: ExportOptions) -> ExportedFile:
    edits = len(work.done.ledger.lines)
    rectified = workspace.rectified(work.done.limb) if edits else None
    read = work.scan if rectified is None else read_shape(rectified)
    if read.limb.doubt is not None and not options.signed_by.strip():
        raise CarveError("exported.red", doubt=read.limb.doubt)
    workspace.make_folder(workspace.files)
    digits = digits_of(read.limb, options, version("limbgram"))
    name = file_name(workspace.case.case_id, options.kind, options.side, digits)
    path = workspace.files / name
    record_file = workspace.files / f"{name}.json"
    known = _read(record_file)
    if known is not None and path.is_file() and file_sha256(path) == known.sha256:
        return known
    if known is None and record_file.is_file():
        set_aside(record_file)  # who signed, and when, is not overwritten
    made = export(read, options.ask, path, options.side, mirror_picture(workspace, name))
    exported = ExportedFile(
        name=name,
        kind=options.kind,
        made=utc_now(),
        bytes=path.stat().st_size,
        sha256=file_sha256(path),
        side=options.side,
        unit=made.unit,
        scan_sha256=work.scan.sha256,
        recipe_sha256=work.recipe_sha256,
        recipe_edits=edits,
        shape="" if rectified is None else rectified.name,
        said=made.said,
        surface_within_mm=made.surface_within_mm,
        girth_change_mm=made.girth_change_mm,
        volume_change=made.volume_change,
        minutes=made.minutes,
        doubt=read.limb.doubt,
        signed_by=options.signed_by.strip(),
        notes=tuple(dict.fromkeys((*work.done.limb.notes, *made.limb.notes))),
    )
    write_json(record_file, tree_of(exported))
    return exported


def mirror_picture(workspace: Workspace, name: str) -> Path:
    """The picture to hold against the patient, drawn from what was read back of a file."""
    return workspace.files / f"{name}{MIRROR_ENDING}"


def exported_files(workspace: Workspace) -> tuple[ExportedFile, ...]:
    """The files that were written, the newest first."""
    found = (_read(path) for path in workspace.export_records())
    there = (one for one in found if one is not None and (workspace.files / one.name).is_file())
    return tuple(sorted(there, key=lambda one: one.made, reverse=True))


def unreadable_exports(workspace: Workspace) -> tuple[Finding, ...]:
    """Records of written files that cannot be read, also those that were set aside."""
    records = workspace.export_records()
    return tuple(unreadable(one, "export").finding for one in records if _read(one) is None)


def exported_file(workspace: Workspace, name: str) -> ExportedFile:
    """One file that was written.

    Raises:
        LookupError: there is none of that name.
    """
    found = next((one for one in exported_files(workspace) if one.name == name), None)
    if found is None:
        raise LookupError("There is no such file.")
    return found


def _read(path: Path) -> ExportedFile | None:
    try:
        status = path.stat()
        return _read_version(path, status.st_ino, status.st_mtime_ns, status.st_size)
    except (OSError, CaseError, Mismatch, ValueError):
        return None


@lru_cache(maxsize=4096)
def _read_version(path: Path, _inode: int, _changed_ns: int, _size: int) -> ExportedFile:
    """Read a record once for each version of its file: every answer about the recipe needs all."""
    tree = json_of(read_content(path, _LARGEST_BYTES, CaseError))
    return value_of(tree, ExportedFile, strictness=TOLERANT)
