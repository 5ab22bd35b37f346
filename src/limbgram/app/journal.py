"""Journal: the access log of the app on a network, one line an act.

In      a name, an address, the act (the route's name in the API), the case's id, how it ended.
Out     SHELF/access/log.jsonl, to which lines are only appended. None identifies a patient: no
        note, no file name, no landmark; the case's id is random.
Method  Each line has a seal: an HMAC of the seal before it and of its own text. The key and the
        last seal are kept outside the shelf, in the account's own folder: whoever can write in the
        shelf alone can neither seal a line nor cut off the end unnoticed. Lines from before there
        was a key, or from another machine, are not proved: a digest says whether they are as they
        were when the key was made.
Fails   OSError: the line cannot be written. OptionsError: the key cannot be written.
        CaseError: the key is gone.
"""

import hashlib
import hmac
import io
import json
import os
import secrets
import sys
import threading
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from limbgram.app.users import make_private
from limbgram.cases.case_record import read_kept, write_json
from limbgram.core.errors import CaseError, OptionsError, disk_finding, in_words
from limbgram.core.files import file_lock
from limbgram.core.typed import Mismatch, tree_of, value_of

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
    """A line of the log, and whether its seal is right."""

    act: Act | None
    """None: it cannot be read, or stands for lines that were cut off."""
    whole: bool
    """False: it was changed, or a line before it was removed or inserted; of a line that is not
    proved: since there is the key."""
    proved: bool
    """By the key; False: it was written before there was one, or on another machine."""
    cut_off: bool = False
    """No line: those at the end were cut off here."""


@dataclass(frozen=True, kw_only=True)
class _Anchor:
    """The key and the last seal of a log, kept outside its shelf."""

    key: str
    last: str
    """Seal of the last line."""
    since: int
    """Bytes of the log that were written before there was this key."""
    earlier: str = ""
    """SHA-256 of these bytes; empty where nobody noted it."""


def state_folder() -> Path:
    """The account's folder for state of this program (XDG Base Directory)."""
    given = os.environ.get("LOCALAPPDATA" if sys.platform == "win32" else "XDG_STATE_HOME", "")
    base = Path(given) if Path(given).is_absolute() else Path.home() / ".local" / "state"
    return base / "limbgram"


@dataclass(frozen=True)
class Journal:
    """The log of a shelf."""

    folder: Path
    """SHELF/access."""
    anchors: Path = field(default_factory=state_folder)
    _here: threading.Lock = field(default_factory=threading.Lock)

    @property
    def file(self) -> Path:
        return self.folder / "log.jsonl"

    @property
    def anchor_file(self) -> Path:
        """The file of the key and the last seal."""
        place = hashlib.sha256(str(self.file.resolve()).encode()).hexdigest()
        return self.anchors / f"log-{place[:16]}.json"

    def begin(self) -> None:
        """Make the key if there is none.

        Raises:
            OptionsError: it cannot be written.
        """
        try:
            make_private(self.folder)
            with self._here, file_lock(self.folder / ".log.lock", wait=True):
                self._put(self._anchor())
        except (OSError, RuntimeError) as error:  # RuntimeError: the account has no folder
            why = disk_finding(error) if isinstance(error, OSError) else in_words(f"{error}.")
            raise OptionsError("app.log_key_not_kept", reason=why) from error

    def require_key(self) -> None:
        """Refuse a log without its key: a new key could not prove its lines.

        Raises:
            CaseError: there are lines and no key.
        """
        if not self.anchor_file.exists() and self.file.is_file() and self.file.stat().st_size:
            raise CaseError("app.log_key_missing", folder=str(self.anchors))

    def write(self, who: str, address: str, act: str, case: str = "", status: int = 0) -> None:
        """Add a line.

        Raises:
            OSError: it could not be written.
            CaseError: there are lines and no key, or none that can be read.
        """
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        line = Act(at=now, who=who, address=address, act=act, case=case, status=status)
        make_private(self.folder)
        with self._here, file_lock(self.folder / ".log.lock", wait=True):
            flags = os.O_RDWR | os.O_APPEND | os.O_CREAT | getattr(os, "O_BINARY", 0)
            file = os.open(self.file, flags, 0o600)
            try:
                self.require_key()
                anchor = self._anchor()
                size, before = os.fstat(file).st_size, _last_seal(file, anchor)
                content = _sealed(anchor.key, before, line)
                try:
                    if os.write(file, content) != len(content):
                        raise OSError(28, "No space left on device", str(self.file))
                    self._put(replace(anchor, last=_seal_of(content)))
                except OSError:
                    os.ftruncate(file, size)
                    raise
            finally:
                os.close(file)

    def lines(self) -> Iterator[Line]:
        """All lines, the oldest first; and one that says so where the end was cut off."""
        anchor = self._anchor()  # before the lines: another may be written meanwhile
        seal, at, missing = _FIRST, 0, anchor.last != _FIRST
        with self.file.open("rb") if self.file.is_file() else io.BytesIO() as stream:
            same = _digest(stream.read(anchor.since)) == anchor.earlier
            stream.seek(0)
            for content in iter(lambda: stream.readline(_LONGEST_LINE), b""):
                act, proved = _act(content), at >= anchor.since
                sealed = b"" if act is None else _sealed(anchor.key if proved else "", seal, act)
                earlier = same and not proved and act is not None
                yield Line(act=act, whole=earlier or sealed == content, proved=proved)
                seal, at = _seal_of(content), at + len(content)
                missing = missing and seal != anchor.last
        if missing:
            yield Line(act=None, whole=False, proved=True, cut_off=True)

    def _anchor(self) -> _Anchor:
        """The anchor; a new one where there is none."""
        kept = read_kept(self.anchor_file, _Anchor, "log_key")
        if kept is not None:
            return kept
        content = self.file.read_bytes() if self.file.is_file() else b""
        lines = content.splitlines(keepends=True)
        last = _seal_of(lines[-1]) if lines else _FIRST
        return _Anchor(
            key=secrets.token_hex(32), last=last, since=len(content), earlier=_digest(content)
        )

    def _put(self, anchor: _Anchor) -> None:
        make_private(self.anchors)
        write_json(self.anchor_file, tree_of(anchor))
        self.anchor_file.chmod(0o600)


def _act(content: bytes) -> Act | None:
    try:
        tree: dict[str, Any] = json.loads(content)
        tree.pop("seal", None)
        return value_of(tree, Act)
    except (ValueError, AttributeError, Mismatch):
        return None


def _sealed(key: str, before: str, line: Act) -> bytes:
    """A line with its seal; without a key the seal is a plain hash."""
    text = json.dumps(asdict(line), ensure_ascii=False, separators=(",", ":"))
    chained = f"{before}{text}".encode()
    made = hmac.new(bytes.fromhex(key), chained, "sha256") if key else hashlib.sha256(chained)
    seal = made.hexdigest()[:32]
    return f'{text[:-1]},"seal":"{seal}"}}\n'.encode()


def _last_seal(file: int, anchor: _Anchor) -> str:
    """The seal that the next line continues.

    That of the last line; a line that a loss of power cut off is ended first. If the end of the
    file is not the end that was written, the chain continues from the anchor's seal: the break
    remains visible.
    """
    size = os.lseek(file, 0, os.SEEK_END)
    start = os.lseek(file, max(0, size - 2 * _LONGEST_LINE), os.SEEK_SET)
    content = os.read(file, size - start)
    if content and not content.endswith(b"\n"):
        os.write(file, b"\n")
    lines = content.splitlines()
    last = _seal_of(lines[-1]) if lines else _FIRST
    if last == anchor.last:
        return last
    before = _seal_of(lines[-2]) if len(lines) > 1 else _FIRST
    act = _act(lines[-1]) if lines else None
    # A line may have come without its end, or the power may have gone before it was noted outside.
    ours = lines and (act is None or _sealed(anchor.key, before, act).rstrip() == lines[-1])
    return last if ours and before == anchor.last else anchor.last


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _seal_of(content: bytes) -> str:
    try:
        return str(json.loads(content)["seal"])
    except (ValueError, KeyError, TypeError):  # cut off by a loss of power: the chain goes on
        return hashlib.sha256(content.rstrip(b"\n")).hexdigest()[:32]
