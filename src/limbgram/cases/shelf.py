"""The shelf: a folder of cases, each a folder under a random id, and what is known of each.

SHELF/
  K7Q-4F2/        a case, as `limbgram reconstruct -o` makes it (see `folder`), and in it
    label.json    kind and side of the limb, a note, the day, whether it is archived
    received      photos as they came in, without places and serial numbers (see `uploads`)
    work          landmarks, tape readings, recipe, shapes and files made by hand
  cameras         camera files and their board photos
  removed         cases on their way out; empty unless the program was ended meanwhile

The folders are the truth. What is listed is read of them each time, so that a case that was copied,
restored or removed by hand is listed, or is not, without any repair. Ids are random: no name of a
patient is in the name of any file.
"""

import re
import secrets
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from limbgram.cases.case_record import read_kept, utc_now, write_json
from limbgram.cases.folder import CaseFolder, locked
from limbgram.core.errors import CaseError, MissingError, OptionsError, disk_finding, printable
from limbgram.core.typed import tree_of
from limbgram.workbench.limb import KindName, Side

ID_PATTERN = "^[2-9A-HJKMNP-Z]{3}-[2-9A-HJKMNP-Z]{3}$"
"""Of a case. Without letters and digits that are taken for each other: 0 O, 1 I L."""
_LETTERS = "23456789ABCDEFGHJKMNPQRSTUVWXYZ"
_ID = re.compile(ID_PATTERN)
_SCHEMA = "limbgram-label/1"
_LONGEST_NOTE = 200
_TRIES = 100

Holding = Literal["photos", "results", "work", "record", "intermediate products", "earlier results"]
"""What a case's folder holds, by what it is for."""
_HOLDINGS: dict[str, Holding] = {
    "received": "photos",
    "photos": "photos",
    "photos-left-out": "photos",
    "frames": "photos",
    "stages": "intermediate products",
    "superseded": "earlier results",
    "work": "work",
    "deliverables": "results",
    "report": "results",
    "report.html": "results",
}


@dataclass(frozen=True, kw_only=True)
class Label:
    """What people say of a case."""

    made: str
    """Date and time, UTC."""
    kind: KindName | None = None
    side: Side | None = None
    flexion_deg: float = 0.0
    """Of the joint, as its axes were set with it."""
    note: str = ""
    """A few words to find it by; never a patient's name."""
    archived: bool = False
    sample: bool = False
    """Made by the program to try it out."""
    schema: str = _SCHEMA


@dataclass(frozen=True, kw_only=True)
class Held:
    """Disk space that a case uses for one purpose."""

    what: Holding
    files: int
    bytes: int


@dataclass(frozen=True)
class ShelvedCase:
    """One case on the shelf."""

    case_id: str
    folder: CaseFolder

    @property
    def label_file(self) -> Path:
        return self.folder.label_file

    @property
    def received(self) -> Path:
        return self.folder.root / "received"

    @property
    def photos_given(self) -> Path | None:
        """Folder of the photos of a case that the command line made; None where the app receives
        them, and CASE/photos holds no more than the copies of a run."""
        given = self.folder.photos
        return given if given.is_dir() and not self.received.is_dir() else None

    @property
    def work(self) -> Path:
        return self.folder.root / "work"

    @property
    def label(self) -> Label:
        """What people say of it; a folder without a label is a case made elsewhere.

        Raises:
            CaseError: the label is there and cannot be read.
        """
        kept = read_kept(self.label_file, Label, "label")
        return self.unlabelled if kept is None else kept

    @property
    def unlabelled(self) -> Label:
        """The label of a case of which nothing was said."""
        made = datetime.fromtimestamp(self.folder.root.stat().st_mtime, UTC)
        return Label(made=made.isoformat(timespec="seconds"))

    def relabel(self, label: Label) -> Label:
        """Write another label.

        Raises:
            OptionsError: the note is too long, or holds what cannot be shown.
        """
        _require_note(label.note)
        write_json(self.label_file, tree_of(label))
        return label

    @property
    def thumbnail(self) -> Path | None:
        """A picture of its surface, once there is one."""
        picture = self.folder.surface_picture
        return picture if picture.is_file() else None

    def require_here(self) -> None:
        """Refuse where it was deleted since it was looked up.

        Raises:
            LookupError: its folder is gone.
        """
        if not self.folder.root.is_dir():
            raise _no_case(self.case_id)

    def holdings(self) -> tuple[Held, ...]:
        """What its folder holds."""
        found: dict[Holding, Held] = {}
        for entry in self.folder.root.iterdir():
            what = _HOLDINGS.get(entry.name, "record")
            before = found.get(what, Held(what=what, files=0, bytes=0))
            sizes = [_size(file) for file in _files(entry)]
            found[what] = replace(
                before, files=before.files + len(sizes), bytes=before.bytes + sum(sizes)
            )
        return tuple(found.values())

    def clear_intermediate(self) -> int:
        """Remove what a run can make again from the photos; returns the bytes that it freed.

        Results of an earlier run stay until another one finishes: they may be all there are.

        The products of a finished case are its evidence (accuracy, marks in photos, the photos that
        measured a point): without them the case must be computed again for these.

        Raises:
            CaseError: a run is working in it.
        """
        with locked(self.folder):
            gone = self.folder.stages
            freed = sum(_size(file) for file in _files(gone)) if gone.is_dir() else 0
            shutil.rmtree(gone, ignore_errors=True)
        return freed


@dataclass(frozen=True)
class Shelf:
    """A folder of cases."""

    root: Path

    @property
    def cameras(self) -> Path:
        return self.root / "cameras"

    @property
    def templates(self) -> Path:
        return self.root / "templates"

    def open(self) -> None:
        """Make the folder where there is none, and end removals that were cut short.

        Raises:
            CaseError: it cannot be made or written.
        """
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            shutil.rmtree(self._removed, ignore_errors=True)
            (self.root / ".writable").write_bytes(b"")
        except OSError as error:
            raise CaseError(
                "case.shelf_fails", folder=str(self.root), reason=disk_finding(error)
            ) from error

    def cases(self) -> tuple[ShelvedCase, ...]:
        """All cases, by id."""
        found = (path for path in self.root.iterdir() if _ID.fullmatch(path.name) and path.is_dir())
        return tuple(ShelvedCase(path.name, CaseFolder(path)) for path in sorted(found))

    def case(self, case_id: str) -> ShelvedCase:
        """One case.

        Raises:
            LookupError: there is none of that id.
        """
        folder = self.root / case_id
        if not _ID.fullmatch(case_id) or folder.is_symlink() or not folder.is_dir():
            raise _no_case(case_id)
        return ShelvedCase(case_id, CaseFolder(folder))

    def new_case(
        self, kind: KindName | None, side: Side | None, note: str = "", *, sample: bool = False
    ) -> ShelvedCase:
        """A case without photos, under an id that no other has.

        Raises:
            OptionsError: the note is too long, or holds what cannot be shown.
        """
        _require_note(note)
        for _ in range(_TRIES):
            letters = "".join(secrets.choice(_LETTERS) for _ in range(6))
            case_id = f"{letters[:3]}-{letters[3:]}"
            folder = self.root / case_id
            try:
                folder.mkdir()
            except FileExistsError:
                continue
            case = ShelvedCase(case_id, CaseFolder(folder))
            case.relabel(Label(made=utc_now(), kind=kind, side=side, note=note, sample=sample))
            return case
        raise CaseError("case.no_free_id", folder=str(self.root))

    def take_out(self, case: ShelvedCase) -> Path:
        """Take a case out of the list at once; returns the folder that is left to be deleted.

        Raises:
            CaseError: a run is working in it.
        """
        with locked(case.folder):
            self._removed.mkdir(exist_ok=True)
            going = self._removed / f"{case.case_id}-{secrets.token_hex(4)}"
            return case.folder.root.rename(going)

    @property
    def _removed(self) -> Path:
        return self.root / "removed"


def _require_note(note: str) -> None:
    if len(note) > _LONGEST_NOTE or printable(note, keep="") != note:
        raise OptionsError("case.note_length", most=_LONGEST_NOTE)


def _no_case(case_id: str) -> LookupError:
    return MissingError("case.no_such_case", name=printable(case_id, keep="")[:20])


def last_change(case: ShelvedCase) -> str:
    """When something of the case was changed last: date and time, UTC."""
    places = (
        case.folder.root,
        case.label_file,
        case.received,
        case.work,
        case.folder.record,
        case.folder.job_file,
    )
    newest = max(place.stat().st_mtime for place in places if place.exists())
    return datetime.fromtimestamp(newest, UTC).isoformat(timespec="seconds")


def _files(path: Path) -> Iterator[Path]:
    if path.is_symlink() or not path.is_dir():
        yield path
        return
    for entry in path.iterdir():
        yield from _files(entry)


def _size(path: Path) -> int:
    try:
        return path.lstat().st_size
    except OSError:
        return 0
