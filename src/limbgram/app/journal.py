"""Journal: who did what on a network, one line after the other.

In      a name, an address, the act (the route's name in the API), the case's id, how it ended.
Out     SHELF/access/log.jsonl, to which lines are only added. None holds what a patient is known
        by: no note, no name of a file, no landmark; the case's id is random.
Method  Each line has a seal: the SHA-256 of the seal before it and of its own text. A line that was
        changed, taken out or put in breaks the chain there. Lines cut off at the end leave no
        trace in the file: keep a copy elsewhere, or note the last seal.
Fails   OSError: the disk takes no more.
"""

import hashlib
import json
import os
import sys
import threading
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from limbgram.app.users import made_private
from limbgram.core.typed import Mismatch, value_of

_LONGEST_LINE = 4096
_FIRST = "0" * 32


@dataclass(frozen=True, kw_only=True)
class Act:
    """One line."""

    at: str
    """Date and time, UTC."""
    who: str
    """The user; "phone of NAME"; "this machine" for the command line; empty: nobody signed in."""
    address: str
    act: str
    """Name of the route, as in the API's description: start_job, delete_case."""
    case: str = ""
    status: int = 0
    """Of the answer: below 400 it was done."""


@dataclass(frozen=True, kw_only=True)
class Line:
    """What stands in a line, and whether it follows the line before it."""

    act: Act | None
    """None: it cannot be read."""
    whole: bool
    """False: it was changed, or a line before it was taken out or put in."""


@dataclass(frozen=True)
class Journal:
    """The log of a shelf."""

    folder: Path
    """SHELF/access."""
    _here: threading.Lock = field(default_factory=threading.Lock)

    @property
    def file(self) -> Path:
        return self.folder / "log.jsonl"

    def write(self, who: str, address: str, act: str, case: str = "", status: int = 0) -> None:
        """Add a line.

        Raises:
            OSError: it could not be written.
        """
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        line = Act(at=now, who=who, address=address, act=act, case=case, status=status)
        made_private(self.folder)
        with self._here, _alone(self.folder / ".log.lock"):
            flags = os.O_RDWR | os.O_APPEND | os.O_CREAT | getattr(os, "O_BINARY", 0)
            file = os.open(self.file, flags, 0o600)
            try:
                content = _sealed(_last_seal(file), line)
                if os.write(file, content) != len(content):
                    raise OSError(28, "No space left on device", str(self.file))
            finally:
                os.close(file)

    def lines(self) -> Iterator[Line]:
        """All lines, the oldest first."""
        if not self.file.is_file():
            return
        seal = _FIRST
        with self.file.open("rb") as stream:
            for content in iter(lambda: stream.readline(_LONGEST_LINE), b""):
                act = _act(content)
                yield Line(act=act, whole=act is not None and _sealed(seal, act) == content)
                seal = _seal_of(content.rstrip(b"\n"))


def _act(content: bytes) -> Act | None:
    try:
        tree: dict[str, Any] = json.loads(content)
        tree.pop("seal", None)
        return value_of(tree, Act)
    except (ValueError, AttributeError, Mismatch):
        return None


def _sealed(before: str, line: Act) -> bytes:
    text = json.dumps(asdict(line), ensure_ascii=False, separators=(",", ":"))
    seal = hashlib.sha256(f"{before}{text}".encode()).hexdigest()[:32]
    return f'{text[:-1]},"seal":"{seal}"}}\n'.encode()


def _last_seal(file: int) -> str:
    """Of the last line; a line that was cut off by a loss of power is ended first."""
    size = os.lseek(file, 0, os.SEEK_END)
    if not size:
        return _FIRST
    start = os.lseek(file, max(0, size - _LONGEST_LINE), os.SEEK_SET)
    content = os.read(file, size - start)
    if not content.endswith(b"\n"):
        os.write(file, b"\n")
    return _seal_of(content.rstrip(b"\n").rpartition(b"\n")[2])


def _seal_of(content: bytes) -> str:
    try:
        return str(json.loads(content)["seal"])
    except (ValueError, KeyError, TypeError):  # cut off by a loss of power: the chain goes on
        return hashlib.sha256(content).hexdigest()[:32]


@contextmanager
def _alone(place: Path) -> Generator[None]:
    """One program writes at a time: the app, and the command line beside it."""
    with place.open("a+b") as lock:
        if sys.platform == "win32":
            import msvcrt

            lock.seek(0)
            msvcrt.locking(lock.fileno(), msvcrt.LK_LOCK, 1)
            try:
                yield
            finally:
                lock.seek(0)
                msvcrt.locking(lock.fileno(), msvcrt.LK_UNLCK, 1)
        else:
            import fcntl

            fcntl.flock(lock, fcntl.LOCK_EX)
            yield
