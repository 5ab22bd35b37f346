"""Workspace of a case: the surface that people edit, its recipe, and files made of it.

In the case's folder:

work/surface.ply         the surface as it was delivered, and its limb file beside it
work/recipe.toml         the edits in order; work/history.json its states for undo and redo
work/tape.json           girths taped on the patient
work/rectified-HASH.ply  a shape after a recipe, and its limb file; HASH is of that shape;
                         the present one, and those that files for machines were made from
work/files/              files for machines
work/shapes/             shapes from elsewhere, to compare with
work/.taken/             a complete surface with its limb file, on the way to its place

The copy keeps the work when the case is computed again: the hash of the new surface differs, and
people decide when to take it. The commands of `limbgram` read and write the same files, with the
same bytes.
"""

import json
import os
import shutil
import threading
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import ClassVar, Literal

from limbgram.cases.case_record import read_kept, set_aside, unreadable, utc_now, write_json
from limbgram.cases.deliverables import surface_of
from limbgram.cases.fingerprint import Fingerprints, file_sha256
from limbgram.cases.shelf import ShelvedCase
from limbgram.core.errors import CaseError, LimbgramError, OptionsError
from limbgram.core.files import json_of, read_content, without_mark, write_bytes, written_whole
from limbgram.core.typed import tree_of
from limbgram.formats.limb_file import write_limb, write_limb_file
from limbgram.formats.reading import ShapeFile, read_shape
from limbgram.formats.sidecar import (
    LIMB_FILE_ENDING,
    LimbProgress,
    hash_of,
    limb_file_beside,
    progress_of,
)
from limbgram.workbench.frame.landmarks import with_landmarks
from limbgram.workbench.limb import Limb, marked_red
from limbgram.workbench.measures.tape import TapeReading, require_girth
from limbgram.workbench.recipe.file import encode_recipe, parse_recipe
from limbgram.workbench.recipe.recipe import Recipe, Replayed

MIRROR_ENDING = ".mirror.png"
"""Of the picture beside each file for machines."""
_LARGEST_BYTES = 40_000_000
_MOST_STATES = 200
"""Recipes in the history of undo."""
_MOST_READINGS = 100
_MOST_ACTS = 2000
_HASH_DIGITS = 12
"""In the name of a file that is made from a shape."""


@dataclass
class CaseLocks:
    """A lock for each case: work on one case never waits for another."""

    _known: dict[Path, threading.RLock] = field(default_factory=dict[Path, threading.RLock])
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def of(self, root: Path) -> threading.RLock:
        """The lock of the case with this work folder."""
        with self._lock:
            return self._known.setdefault(root, threading.RLock())


_TAKING = CaseLocks()
"""Held while a surface is copied in: who asks meanwhile gets the same complete copy."""
MAKING = CaseLocks()
"""Held while a file is made from a shape: who asks for it meanwhile gets the same complete file."""


TapeDeed = Literal["read", "taken back", "accepted"]


@dataclass(frozen=True, kw_only=True)
class TapeAct:
    """An event of a tape reading."""

    made: str
    """ISO 8601, UTC; empty for a reading from before times were kept."""
    deed: TapeDeed
    reading: TapeReading


@dataclass(frozen=True, kw_only=True)
class TapeStanding:
    """The state of a tape reading: withdrawn or not, accepted or not.

    A withdrawn reading does not count any more, nor does its acceptance.
    """

    read: TapeAct
    withdrawn: str
    """When it was taken back; empty where it was not."""
    accepted: str
    """When somebody last accepted its conflict, before it was taken back; empty where nobody."""


@dataclass(frozen=True)
class _Tapes:
    readings: tuple[TapeReading, ...]
    acts: tuple[TapeAct, ...] = ()
    """In the order of time."""


def _new_act(deed: TapeDeed, reading: TapeReading) -> TapeAct:
    return TapeAct(made=utc_now(), deed=deed, reading=reading)


def _standing(act: TapeAct, later: tuple[TapeAct, ...]) -> TapeStanding:
    since = [one for one in later if one.reading == act.reading]
    ended = next((k for k, one in enumerate(since) if one.deed == "taken back"), len(since))
    accepted = [one.made for one in since[:ended] if one.deed == "accepted"]
    return TapeStanding(
        read=act,
        withdrawn=since[ended].made if ended < len(since) else "",
        accepted=accepted[-1] if accepted else "",
    )


@dataclass(frozen=True)
class History:
    """Earlier and later states of the recipe for undo and redo, oldest first."""

    recipes: tuple[str, ...]
    present: int

    @property
    def can_undo(self) -> bool:
        return self.present > 0

    @property
    def can_redo(self) -> bool:
        return self.present + 1 < len(self.recipes)


@dataclass(frozen=True, kw_only=True)
class Progress:
    """Counts that tell how far the work by hand is."""

    aligned: bool
    landmarks: int
    tapes: int
    edits: int
    files: int


@dataclass(frozen=True, kw_only=True)
class Work:
    """A consistent snapshot of a case's work, from which a file or a record is made.

    The files of the case may change meanwhile.
    """

    scan: ShapeFile
    limb_file_sha256: str | None
    """Of the limb file beside the scan; None without one."""
    recipe: Recipe
    recipe_sha256: str
    """Of its file."""
    done: Replayed
    """The shape after the recipe."""


@dataclass(frozen=True)
class Workspace:
    """The work folder of a case."""

    case: ShelvedCase
    SCANS: ClassVar[tuple[str, ...]] = ("surface.ply", "surface-RED.ply")
    """Names of the surface that is edited."""

    @property
    def root(self) -> Path:
        return self.case.work

    @property
    def tape_file(self) -> Path:
        return self.root / "tape.json"

    @property
    def files(self) -> Path:
        return self.root / "files"

    @property
    def shapes(self) -> Path:
        return self.root / "shapes"

    @property
    def recipe_file(self) -> Path:
        return self.root / "recipe.toml"

    def make_folder(self, folder: Path) -> Path:
        """Make a folder of the work if it is missing; the case's own folder has to be there.

        Raises:
            LookupError: the case was deleted meanwhile.
        """
        self.case.require_here()
        for one in (self.root, folder):
            one.mkdir(exist_ok=True)
        return folder

    @property
    def limb_file(self) -> Path | None:
        """The limb file beside the edited surface; None before there is a surface."""
        scan = self._kept_scan() or self._delivered()
        return None if scan is None else limb_file_beside(scan)

    def has_scan(self) -> bool:
        """Whether there is a surface to edit."""
        return self._kept_scan() is not None or self._delivered() is not None

    def scan_file(self) -> Path:
        """The surface that is edited; copied from the deliverables at the first call.

        Raises:
            CaseError: the case has no surface yet.
        """
        with _TAKING.of(self.root):
            self._put_in_place()
            return self._kept_scan() or self._take_scan()

    def take_scan(self) -> Path:
        """Copy the surface of the last run to edit it; landmarks are carried over to it.

        Landmarks keep their world coordinates, which a board fixes for all runs, and move to the
        nearest point of the new surface; those that lie off it have to be placed again.

        Raises:
            CaseError: the case has no surface yet.
        """
        with _TAKING.of(self.root):
            self._put_in_place()
            return self._take_scan()

    def is_stale(self) -> bool:
        """Whether the last run made another surface than the one that is edited."""
        kept, delivered = self._kept_scan(), self._delivered()
        if kept is None or delivered is None:
            return False
        return kept.name != delivered.name or not _same_bytes(kept, delivered)

    def progress(self) -> Progress:
        """Counts of the work, without reading any surface.

        Raises:
            LimbgramError: the tape's readings or the limb file are there and cannot be read.
        """
        limb_file, limb = self.limb_file, LimbProgress()
        if limb_file is not None and limb_file.is_file():
            limb = progress_of(limb_file)
        recipe = self.recipe_file.read_bytes() if self.recipe_file.is_file() else b""
        files = list(self.files.iterdir()) if self.files.is_dir() else []
        return Progress(
            aligned=limb.aligned,
            landmarks=limb.landmarks,
            tapes=len(self.tape()),
            edits=recipe.count(b"[[edit]]"),
            files=sum(one.name.endswith(MIRROR_ENDING) for one in files),
        )

    def read(self) -> ShapeFile:
        """The scan with what is known of it."""
        return read_shape(self.scan_file())

    def save_limb(self, limb: Limb, read: ShapeFile) -> None:
        """Keep landmarks, kind, side and axes beside the scan."""
        scan = self.scan_file()
        write_limb_file(limb, scan, mm_per_unit=read.mm_per_unit, sha256=read.sha256)

    def recipe(self) -> Recipe:
        """The recipe; an empty one before the first edit."""
        if not self.recipe_file.is_file():
            return Recipe(name=self.case.case_id, scan_sha256=file_sha256(self.scan_file()))
        content = read_content(self.recipe_file, _LARGEST_BYTES, CaseError)
        try:
            text = without_mark(content).decode("utf-8")
        except UnicodeDecodeError as error:
            raise unreadable(self.recipe_file, "recipe") from error
        return parse_recipe(text, self.recipe_file.name)

    def require_recipe(self) -> None:
        """Check that the recipe can be read; each version of its file is read once.

        Raises:
            LimbgramError: it cannot.
        """
        status = self.recipe_file.stat()
        _require_recipe(self, status.st_ino, status.st_mtime_ns, status.st_size)

    def save_recipe(self, recipe: Recipe) -> None:
        """Make another recipe the present one; undo goes back to the one before."""
        history, text = self.history(), encode_recipe(recipe).decode()
        if history.recipes[history.present] == text:
            return
        kept = (*history.recipes[: history.present + 1], text)[-_MOST_STATES:]
        self._put(History(kept, len(kept) - 1))

    def step(self, by: int) -> Recipe:
        """Undo (-1) or redo (+1) one change.

        Raises:
            OptionsError: there is none.
        """
        history = self.history()
        at = history.present + by
        if not 0 <= at < len(history.recipes):
            raise OptionsError("case.nothing_to_undo" if by < 0 else "case.nothing_undone")
        self._put(replace(history, present=at))
        return self.recipe()

    def history(self) -> History:
        """The states for undo and redo; the present one is the recipe's file, whoever wrote it.

        A history that cannot be read begins anew, and its file is kept (`notes`).
        """
        now = encode_recipe(self.recipe()).decode()
        try:
            kept = self._kept_history()
        except CaseError:
            kept = None
        if kept is None:
            return History((now,), 0)
        if 0 <= kept.present < len(kept.recipes) and kept.recipes[kept.present] == now:
            return kept
        return History((*kept.recipes[: kept.present + 1], now), kept.present + 1)

    def notes(self) -> tuple[str, ...]:
        """Notes on files of the recipe that could not be read."""
        aside = sorted(self.root.glob("history.unreadable-*.json"))
        found = [
            f"What undo went back to could not be read; it is kept in {one.name}." for one in aside
        ]
        try:
            self._kept_history()
        except CaseError as error:
            found.append(str(error))
        return tuple(found)

    def recipe_sha256(self) -> str:
        """Of the recipe's file; before there is one, of what it would hold."""
        if self.recipe_file.is_file():
            return hash_of(read_content(self.recipe_file, _LARGEST_BYTES, CaseError))
        return hash_of(encode_recipe(self.recipe()))

    def rectified(self, limb: Limb) -> Path:
        """The file of a shape after a recipe, written if it is missing.

        Its name has the hash of the shape, so that no other shape overwrites it, and says where the
        capture was red. Earlier shapes that no record cites are removed: hold `MAKING` until the
        file is read.
        """
        path = self.root / f"rectified-{digits_of(limb)}.ply"
        path = marked_red(path) if limb.doubt else path
        with MAKING.of(self.root):
            if not (path.is_file() and limb_file_beside(path).is_file()):
                write_limb(limb, path)
                self._remove_uncited(path)
        return path

    def _remove_uncited(self, present: Path) -> None:
        """Remove shapes of earlier recipes that no file for machines was made from."""
        cited = [_cited_shape(one) for one in self.export_records()]
        if None in cited:
            return
        needed = {present, *(self.root / name for name in cited if name)}
        needed |= {limb_file_beside(one) for one in needed}
        for one in set(self.root.glob("rectified-*")) - needed:
            one.unlink(missing_ok=True)

    def export_records(self) -> tuple[Path, ...]:
        """The JSON records of files for machines; limb files lie among them in the folder."""
        found = sorted(self.files.glob("*.json")) if self.files.is_dir() else []
        return tuple(one for one in found if not one.name.endswith(LIMB_FILE_ENDING))

    def tape(self) -> tuple[TapeReading, ...]:
        """Girths that were taped on the patient, with their heights in the limb.

        Raises:
            CaseError: they are there and cannot be read.
        """
        return self._tapes().readings

    def tape_acts(self) -> tuple[TapeAct, ...]:
        """Events of all readings, also of withdrawn ones, in the order of time."""
        kept = self._tapes()
        noted = {act.reading for act in kept.acts}
        before = [one for one in kept.readings if one not in noted]
        return (*(TapeAct(made="", deed="read", reading=one) for one in before), *kept.acts)

    def tape_standings(self) -> tuple[TapeStanding, ...]:
        """The state of every reading, also of withdrawn ones, in the order of time."""
        acts = self.tape_acts()
        return tuple(
            _standing(act, acts[k + 1 :]) for k, act in enumerate(acts) if act.deed == "read"
        )

    def accept_tape(self, reading: TapeReading) -> None:
        """Note that somebody accepted a reading that contradicts the shape.

        Raises:
            OptionsError: there is no such reading.
        """
        kept = self._tapes()
        if reading not in kept.readings:
            raise OptionsError(
                "case.no_such_reading", girth_mm=reading.girth_mm, height_mm=reading.height_mm
            )
        self._put_tapes(kept.readings, (*self.tape_acts(), _new_act("accepted", reading)))

    def _tapes(self) -> _Tapes:
        kept = read_kept(self.tape_file, _Tapes, "tapes")
        return _Tapes(()) if kept is None else kept

    def _put_tapes(self, readings: Sequence[TapeReading], acts: Sequence[TapeAct]) -> None:
        self.make_folder(self.root)
        write_json(self.tape_file, tree_of(_Tapes(tuple(readings), tuple(acts[-_MOST_ACTS:]))))

    def save_tape(self, readings: tuple[TapeReading, ...]) -> None:
        """Keep these girths in place of those before.

        Raises:
            OptionsError: one is no girth, or there are too many.
            CaseError: those before cannot be read, and would be lost.
        """
        if len(readings) > _MOST_READINGS:
            raise OptionsError("case.too_many_readings", given=len(readings), most=_MOST_READINGS)
        for reading in readings:
            require_girth(reading)
        kept = self._tapes()
        withdrawn = [one for one in kept.readings if one not in readings]
        added = [one for one in readings if one not in kept.readings]
        acts = (
            *self.tape_acts(),
            *(_new_act("taken back", one) for one in withdrawn),
            *(_new_act("read", one) for one in added),
        )
        self._put_tapes(readings, acts)

    @property
    def _taken(self) -> Path:
        return self.root / ".taken"

    @property
    def _history_file(self) -> Path:
        return self.root / "history.json"

    def _kept_history(self) -> History | None:
        return read_kept(self._history_file, History, "history")

    def _put(self, history: History) -> None:
        """The recipe's file last: if the program is ended in between, history follows the file."""
        self.make_folder(self.root)
        try:
            self._kept_history()
        except CaseError:
            set_aside(self._history_file)
        content = {"recipes": list(history.recipes), "present": history.present}
        with written_whole(self._history_file) as beside:
            beside.write_text(json.dumps(content), encoding="utf-8")
        write_bytes(self.recipe_file, history.recipes[history.present].encode())

    def _kept_scan(self) -> Path | None:
        return next((self.root / name for name in self.SCANS if (self.root / name).is_file()), None)

    def _delivered(self) -> Path | None:
        found = surface_of(self.case.folder.deliverables)
        return found if found.is_file() else None

    def _take_scan(self) -> Path:
        delivered = self._delivered()
        if delivered is None:
            raise CaseError("case.no_surface")
        before = self._kept_scan()
        carried = None if before is None else read_shape(before).limb
        self.make_folder(self.root)
        with written_whole(self._taken) as beside:
            beside.mkdir()
            shutil.copyfile(delivered, beside / delivered.name)
            written = delivered.stat()  # by time and size the two are known to be the same
            os.utime(beside / delivered.name, ns=(written.st_atime_ns, written.st_mtime_ns))
            aligned = limb_file_beside(delivered)
            if carried is not None:
                self._carry_over(carried, beside / delivered.name)
            elif aligned.is_file():
                shutil.copyfile(aligned, beside / aligned.name)
        self._put_in_place()
        return self.root / delivered.name

    def _put_in_place(self) -> None:
        """Move a surface from `.taken` to its place, with its limb file.

        Until `.taken` is complete, the surface before stays as it is with all that belongs to it;
        from then on files are only renamed, which needs no disk space. If the program is ended in
        between, the next call goes on here: old files are removed before the surface is moved, and
        the limb file is moved last.
        """
        if not self._taken.is_dir():
            return
        new = {file.name for file in self._taken.iterdir()}
        for surface in new.intersection(self.SCANS):
            for name in self.SCANS:
                old = self.root / name
                limb_file_beside(old).unlink(missing_ok=True)
                if name != surface:
                    old.unlink(missing_ok=True)
            (self._taken / surface).replace(self.root / surface)
        for name in new.difference(self.SCANS):
            (self._taken / name).replace(self.root / name)
        self._taken.rmdir()

    def _carry_over(self, before: Limb, surface: Path) -> None:
        """Write the limb file of a new surface with landmarks and kind of the one before."""
        read = read_shape(surface)
        limb = replace(read.limb, kind=before.kind)
        for mark in before.landmarks:
            try:
                limb = with_landmarks(limb, [mark])
            except LimbgramError:
                continue  # it lies off the new surface, and must be placed again
        if limb.landmarks or limb.kind:
            write_limb_file(limb, surface, mm_per_unit=read.mm_per_unit, sha256=read.sha256)


def _same_bytes(one: Path, other: Path) -> bool:
    """Whether two files hold the same; hashed once, and only where time and size do not tell."""
    first, second = one.stat(), other.stat()
    if first.st_size != second.st_size:
        return False
    return first.st_mtime_ns == second.st_mtime_ns or (
        _sha256(one, first.st_ino, first.st_mtime_ns, first.st_size)
        == _sha256(other, second.st_ino, second.st_mtime_ns, second.st_size)
    )


@lru_cache(maxsize=4096)
def _sha256(file: Path, _inode: int, _changed_ns: int, _size: int) -> str:
    return file_sha256(file)


def _cited_shape(record: Path) -> str | None:
    """The rectified shape that a file was made from; empty for the scan, None if unreadable."""
    try:
        tree = json_of(read_content(record, _LARGEST_BYTES, CaseError))
        return str(tree["shape"]) if tree["recipe_edits"] else ""
    except (CaseError, ValueError, KeyError, TypeError):
        return None


@lru_cache(maxsize=4096)
def _require_recipe(workspace: Workspace, _inode: int, _changed_ns: int, _size: int) -> None:
    workspace.recipe()


def digits_of(*made_of: object) -> str:
    """The first digits of the hash of what a file is made from, for its name."""
    return Fingerprints().of(made_of)[:_HASH_DIGITS]
