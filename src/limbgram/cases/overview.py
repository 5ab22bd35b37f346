"""Overview: disk use, photos and state of a case for the list of cases, cached until files change.

In      a case.
Out     the disk it uses by purpose, its photos, and whether its surface was computed anew.
Method  Whatever is written whole changes the time of the folder in which it gets its name: a fixed
        number of folders and files tells whether anything else has to be looked at. What changed in
        the last two seconds is not remembered: disks tell times in steps of up to that.
"""

import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

from limbgram.cases.shelf import Held, ShelvedCase
from limbgram.cases.uploads import photos_in
from limbgram.cases.workspace import Workspace

_STEP_NS = 2_000_000_000

Stamp = tuple[tuple[int, int, int] | None, ...]
"""Time, size and number of each place; None where there is nothing."""


@dataclass(frozen=True, kw_only=True)
class Overview:
    """What is told of a case's files."""

    held: tuple[Held, ...]
    photos: int
    """That are here whole."""
    stale: bool
    """The last run made another surface than the one that is worked on."""

    @property
    def bytes(self) -> int:
        return sum(one.bytes for one in self.held)

    @property
    def clearable_bytes(self) -> int:
        return sum(one.bytes for one in self.held if one.what == "intermediate products")


@dataclass
class Overviews:
    """Overviews of the cases of a shelf."""

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
        found = _looked_at(case)
        newest_ns = max((one[0] for one in stamp if one is not None), default=0)
        if time.time_ns() - newest_ns > _STEP_NS:
            with self._lock:
                self._known[root] = stamp, found
        return found

    def forget(self, case: ShelvedCase) -> None:
        """Let go what is known of a case."""
        with self._lock:
            self._known.pop(case.folder.root, None)


def _looked_at(case: ShelvedCase) -> Overview:
    given = case.folder.photos  # of a case that was made by the command line
    photos = photos_in(case.received)
    if not photos and given.is_dir():
        photos = sum(one.is_file() for one in given.iterdir())
    workspace = Workspace(case)
    return Overview(held=case.holdings(), photos=photos, stale=workspace.is_stale())


def _stamp(case: ShelvedCase) -> Stamp:
    folder = case.folder
    work, delivered = case.work, folder.deliverables
    places = (
        *(case.received, case.received / ".records", folder.photos, folder.stages),
        *(folder.superseded, delivered, folder.report, folder.record, case.label_file),
        *(work, work / "files", work / "shapes"),
        *(place / name for place in (work, delivered) for name in Workspace.SCANS),
    )
    return tuple(_status(place) for place in places)


def _status(place: Path) -> tuple[int, int, int] | None:
    try:
        status = place.stat()
    except FileNotFoundError:
        return None
    return status.st_mtime_ns, status.st_size, status.st_ino
