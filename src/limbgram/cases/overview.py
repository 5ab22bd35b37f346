"""Overview: disk use, photos and state of a case for the list of cases, cached until files change.

In      a case.
Out     the disk space it uses by purpose, its photos, and whether its surface was computed anew.
Method  A file that is renamed into place changes the time of its folder: the times of a fixed
        number of folders and files tell whether the case has to be read again. What changed in the
        last two seconds is not cached: file systems have time steps of up to that.
"""

import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

from limbgram.cases.shelf import Held, ShelvedCase
from limbgram.cases.uploads import photos_in
from limbgram.cases.workspace import Workspace
from limbgram.reconstruction.photos.shots import files_not_used

_STEP_NS = 2_000_000_000

Stamp = tuple[tuple[int, int, int] | None, ...]
"""Time, size and inode of each path; None where there is nothing."""


@dataclass(frozen=True, kw_only=True)
class Overview:
    """What the list of cases says of a case's files."""

    held: tuple[Held, ...]
    photos: int
    """That are here and can be used, of several files of one shot one."""
    stale: bool
    """The last run made another surface than the one that is edited."""

    @property
    def bytes(self) -> int:
        return sum(one.bytes for one in self.held)

    @property
    def clearable_bytes(self) -> int:
        return sum(one.bytes for one in self.held if one.what == "intermediate products")


@dataclass
class Overviews:
    """Cached overviews of the cases of a shelf."""

    _known: dict[Path, tuple[Stamp, Overview]] = field(
        default_factory=dict[Path, tuple[Stamp, Overview]]
    )
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def of(self, case: ShelvedCase) -> Overview:
        """The overview of a case as it is now."""
        root, stamp = case.folder.root, _stamp(case)
        with self._lock:
            known = self._known.get(root)
        if known is not None and known[0] == stamp:
            return known[1]
        found = _read(case)
        newest_ns = max((one[0] for one in stamp if one is not None), default=0)
        if time.time_ns() - newest_ns > _STEP_NS:
            with self._lock:
                self._known[root] = stamp, found
        return found

    def forget(self, case: ShelvedCase) -> None:
        """Drop a case from the cache."""
        with self._lock:
            self._known.pop(case.folder.root, None)


def _read(case: ShelvedCase) -> Overview:
    photos = photos_in(case.received)
    if case.photos_given is not None:
        files = [one for one in case.photos_given.iterdir() if one.is_file()]
        photos = len(files) - len(files_not_used(files))
    workspace = Workspace(case)
    return Overview(held=case.holdings(), photos=photos, stale=workspace.is_stale())


def _stamp(case: ShelvedCase) -> Stamp:
    folder, workspace = case.folder, Workspace(case)
    scan_folders = (workspace.root, folder.deliverables)
    paths = (
        *(case.received, case.received / ".records", folder.photos, folder.stages),
        *(folder.superseded, folder.deliverables, folder.report, folder.record, case.label_file),
        *(workspace.root, workspace.files, workspace.shapes),
        *(one / name for one in scan_folders for name in Workspace.SCANS),
    )
    return tuple(_status(path) for path in paths)


def _status(path: Path) -> tuple[int, int, int] | None:
    try:
        status = path.stat()
    except FileNotFoundError:
        return None
    return status.st_mtime_ns, status.st_size, status.st_ino
