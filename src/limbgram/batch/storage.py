"""Storage: captures and cases in a shared folder or an object store, written by many machines.

In      what stands for FOLDER or after -o: a folder that every machine sees, or a URL of an object
        store such as s3://bucket/captures (extra `s3`; what else fsspec knows, too).
Out     captures that are fetched; cases that are there complete or not at all.
Method  No machine writes into a case. It uploads its attempt to a folder of its own, whose name
        nobody else has. The one process that distributed the work accepts one attempt at a case,
        and only while the case still is what that attempt began from: so an attempt of a machine
        that was given up for lost changes nothing, however late it comes. In a folder an attempt is
        accepted by renaming it, with the case locked. An object store renames nothing: there a
        case is CASE/ATTEMPT/... and a record CASE/00000001.json names the attempt that counts; to
        accept one is to create the next record, which only one process can.
Fails   CaseError: the storage does not answer, is full, or the case was changed by somebody else.
"""

import hashlib
import json
import os
import shutil
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path, PurePosixPath
from typing import Any

from limbgram.cases.folder import CaseFolder, locked
from limbgram.core.errors import CaseError, OptionsError, disk_finding, is_full
from limbgram.reconstruction.photos.quality import PICTURE_SUFFIXES
from limbgram.reconstruction.photos.video import is_video

ATTEMPTS = ".attempts"
"""Folder beside the cases in which attempts wait."""
_TRY, _OLDER = "try-", "old-"
_LOCK = ".lock"
_PLANNING_SUFFIXES = (".toml", ".json")
"""Of files that a plan is made from: they are fetched before any capture is."""
_LARGEST_BYTES = 16_000_000
_DIGITS = 8
_HTTP_CONFLICT = ("PreconditionFailed", "ConditionalRequestConflict", "412", "409")


def batch_folder(case: CaseFolder) -> CaseFolder:
    """Where a batch keeps its own files of a case; its lock keeps two batches apart."""
    return CaseFolder(case.root / "batch")


def is_url(text: str) -> bool:
    """Whether a text names a place behind a URL."""
    return "://" in text


@dataclass(frozen=True)
class CaptureFolder:
    """Captures in a folder that every machine sees under the same name."""

    root: Path

    def fetch(self, place: str, to: Path, check: Callable[[], None]) -> Path:  # noqa: ARG002
        """Where the capture can be read: where it lies."""
        return self.root / place


@dataclass(frozen=True)
class CaptureUrl:
    """Captures behind a URL."""

    url: str

    def fetch(self, place: str, to: Path, check: Callable[[], None]) -> Path:
        """Copy the files of a capture, or the one file that it is, into the folder `to`."""
        with _store_errors_as_advice(self.url):
            self._bucket.get_all(place, to / PurePosixPath(place).name, check)
        return to / PurePosixPath(place).name

    def outline(self, to: Path) -> None:
        """Write what a plan needs: folders, settings, and stubs of zips, videos, loose photos."""
        with _store_errors_as_advice(self.url):
            for key, size in self._bucket.sizes("").items():
                name = _inside(key)
                file = to.joinpath(*name.parts)
                if any(part.startswith(".") for part in name.parts):
                    continue
                file.parent.mkdir(parents=True, exist_ok=True)
                suffix = file.suffix.lower()
                if suffix in _PLANNING_SUFFIXES and size <= _LARGEST_BYTES:
                    self._bucket.get(key, file)
                elif suffix == ".zip" or is_video(file):
                    file.touch()
                elif len(name.parts) == 1 and suffix in PICTURE_SUFFIXES:
                    file.write_bytes(b"\xff\xd8\xff")

    @cached_property
    def _bucket(self) -> "_Bucket":
        return _Bucket(self.url)


@dataclass(frozen=True)
class CasesInFolder:
    """Cases in a folder that every machine sees under the same name."""

    root: Path

    def place(self, name: str) -> str:
        """Where the case lies, for people."""
        return str(self.root / name)

    def fetch(self, name: str, to: Path, check: Callable[[], None]) -> str:
        """Copy a case as it is now into the new folder `to`; returns its state."""
        case = self.root / name
        with _disk_errors_as_advice(case):
            seen = _state(case)
            if seen:
                _copy(case, to, check)
            if _state(case) != seen:
                raise _changed(case)
        return seen

    def bring(self, case: Path, name: str, token: str, check: Callable[[], None]) -> int:  # noqa: ARG002
        """Copy an attempt to where it waits, and sync it; returns its bytes."""
        waiting = self._waiting(token)
        with _disk_errors_as_advice(waiting):
            return _copy(case, waiting, check)

    def accept(self, name: str, token: str, seen: str, total: int) -> None:
        """Make the attempt the case, if the case is still in the state `seen`.

        Args:
            total: Bytes of the attempt.

        Raises:
            CaseError: it is in another state or locked, or the attempt is not complete.
        """
        case, older = CaseFolder(self.root / name), self.root / ATTEMPTS / f"{_OLDER}{name}"
        with _disk_errors_as_advice(case.root):
            brought = sum(file.stat().st_size for file in _files(self._waiting(token)))
            if brought != total:
                raise _not_whole(case.root)
            with locked(case), locked(batch_folder(case)):
                if _state(case.root) != seen:
                    raise _changed(case.root)
                shutil.rmtree(older, ignore_errors=True)
                case.root.replace(older)
                self._waiting(token).replace(case.root)
            _sync(self.root)
        shutil.rmtree(older, ignore_errors=True)

    def begin(self) -> None:
        """Make the folder in which attempts wait; what a killed batch left there is removed."""
        self.end()
        with _disk_errors_as_advice(self.root / ATTEMPTS):
            (self.root / ATTEMPTS).mkdir(parents=True)

    def end(self) -> None:
        """Remove that folder: late attempts find none. A case being exchanged is put back."""
        attempts = self.root / ATTEMPTS
        with _disk_errors_as_advice(attempts):
            for left in sorted(attempts.glob(f"{_OLDER}*")):
                case = self.root / left.name.removeprefix(_OLDER)
                if not case.exists():
                    left.replace(case)
        shutil.rmtree(attempts, ignore_errors=True)

    def _waiting(self, token: str) -> Path:
        return self.root / ATTEMPTS / f"{_TRY}{token}"


@dataclass(frozen=True)
class CasesAtUrl:
    """Cases behind a URL."""

    url: str

    def place(self, name: str) -> str:
        return f"{self.url}/{name}"

    def fetch(self, name: str, to: Path, check: Callable[[], None]) -> str:
        """As from a folder; the state is the number of the last record."""
        with _store_errors_as_advice(self.url):
            number, token = self._record(name)
            if number:
                self._bucket.get_all(f"{name}/{token}", to, check)
        return str(number)

    def bring(self, case: Path, name: str, token: str, check: Callable[[], None]) -> int:
        with _store_errors_as_advice(self.url):
            files = [file for file in sorted(case.rglob("*")) if _is_kept(file)]
            keys = [f"{name}/{token}/{file.relative_to(case).as_posix()}" for file in files]
            check()
            self._bucket.put(files, keys)
            check()
            wanted = {key: file.stat().st_size for key, file in zip(keys, files, strict=True)}
            if self._bucket.sizes(f"{name}/{token}") != wanted:
                raise _not_whole(self.place(name))
            return sum(wanted.values())

    def accept(self, name: str, token: str, seen: str, total: int) -> None:
        with _store_errors_as_advice(self.url):
            number = int(seen) + 1
            if self._record(name)[0] >= number:
                raise _changed(self.place(name))
            if sum(self._bucket.sizes(f"{name}/{token}").values()) != total:
                raise _not_whole(self.place(name))
            record = json.dumps({"schema": "limbgram-batch-record/1", "attempt": token})
            if not self._bucket.create(f"{name}/{number:0{_DIGITS}d}.json", record.encode()):
                raise _changed(self.place(name))
            self._forget(name, number, token)

    def begin(self) -> None:
        """Remove attempts that no record names."""
        self.end()

    def end(self) -> None:
        """Remove attempts that no record names; the next batch removes those that come later."""
        with _store_errors_as_advice(self.url):
            parts = [_inside(key).parts for key in self._bucket.sizes("")]
            for name in sorted({part[0] for part in parts if len(part) > 2}):
                self._forget(name, *self._record(name))

    def read(self, name: str, inside: str) -> bytes | None:
        """A file of the accepted case; None where it has none."""
        with _store_errors_as_advice(self.url):
            number, token = self._record(name)
            return self._bucket.read(f"{name}/{token}/{inside}") if number else None

    def _record(self, name: str) -> tuple[int, str]:
        """Number of the last record and the attempt that it names; 0 where there is none."""
        numbers = [
            int(key.stem) for key in map(PurePosixPath, self._bucket.children(name))
            if key.suffix == ".json" and len(key.stem) == _DIGITS and key.stem.isdecimal()
        ]  # fmt: skip
        if not numbers:
            return 0, ""
        content = self._bucket.read(f"{name}/{max(numbers):0{_DIGITS}d}.json")
        match json.loads(content or b"{}"):
            case {"attempt": str(token)} if token.isalnum():
                return max(numbers), token
            case _:
                raise CaseError("batch.record_unreadable", place=self.place(name))

    def _forget(self, name: str, number: int, token: str) -> None:
        """Remove earlier records, and attempts that this one does not name."""
        kept = {f"{name}/{token}", f"{name}/{number:0{_DIGITS}d}.json"}
        later = [
            child for child in self._bucket.children(name)
            if child.endswith(".json") and child > f"{name}/{number:0{_DIGITS}d}.json"
        ]  # fmt: skip
        if not later:
            self._bucket.remove([one for one in self._bucket.children(name) if one not in kept])

    @cached_property
    def _bucket(self) -> "_Bucket":
        return _Bucket(self.url)


Captures = CaptureFolder | CaptureUrl
Cases = CasesInFolder | CasesAtUrl


def captures_at(text: str) -> Captures:
    return CaptureUrl(text.rstrip("/")) if is_url(text) else CaptureFolder(Path(text))


def cases_at(text: str) -> Cases:
    return CasesAtUrl(text.rstrip("/")) if is_url(text) else CasesInFolder(Path(text))


def write_to(url: str, files: Sequence[Path]) -> tuple[str, ...]:
    """Put files behind a URL, each under its name; returns where they are."""
    with _store_errors_as_advice(url):
        _Bucket(url.rstrip("/")).put(list(files), [file.name for file in files])
    return tuple(f"{url.rstrip('/')}/{file.name}" for file in files)


def read_from(url: str, name: str) -> bytes | None:
    """The content of a file behind a URL; None where there is none."""
    with _store_errors_as_advice(url):
        return _Bucket(url.rstrip("/")).read(name)


@dataclass
class _Bucket:
    """The files behind a URL, through fsspec; keys are relative to it."""

    url: str
    root: str = ""
    _system: Any = field(default=None)

    def __post_init__(self) -> None:
        if find_spec("fsspec") is None:
            raise _without_library(self.url, "fsspec")
        try:
            url_to_fs = import_module("fsspec.core").url_to_fs
            self._system, root = url_to_fs(self.url, use_listings_cache=False)
        except ImportError as error:
            raise _without_library(self.url, str(error)) from error
        except ValueError as error:
            raise OptionsError("batch.no_url", url=self.url, why=str(error)) from error
        self.root = str(root).rstrip("/")

    def sizes(self, inside: str) -> dict[str, int]:
        """Bytes of all files below, by key."""
        found: dict[str, Any] = self._system.find(self._full(inside), detail=True)
        return {self._key(key): int(found[key]["size"] or 0) for key in sorted(found)}

    def children(self, inside: str) -> list[str]:
        """Files and folders of one level."""
        self._system.invalidate_cache()
        try:
            found: list[str] = self._system.ls(self._full(inside), detail=False)
        except FileNotFoundError:
            return []
        return sorted({self._key(key) for key in found} - {inside})

    def read(self, key: str) -> bytes | None:
        try:
            return bytes(self._system.cat_file(self._full(key)))
        except FileNotFoundError:
            return None

    def get(self, key: str, to: Path) -> None:
        self._system.get_file(self._full(key), str(to))

    def get_all(self, inside: str, to: Path, check: Callable[[], None]) -> None:
        """Everything below a key, or the one file that it is."""
        for key in self.sizes(inside):
            check()
            file = to.joinpath(*_inside(key).relative_to(_inside(inside)).parts)
            file.parent.mkdir(parents=True, exist_ok=True)
            self.get(key, file)

    def put(self, files: list[Path], keys: list[str]) -> None:
        self._system.put([str(file) for file in files], [self._full(key) for key in keys])

    def create(self, key: str, content: bytes) -> bool:
        """Write a file that is not there yet; False where it was."""
        try:
            self._system.pipe_file(self._full(key), content, mode="create")
        except FileExistsError:
            return False
        except OSError as error:
            if any(word in str(error) for word in _HTTP_CONFLICT):
                return False
            raise
        return True

    def remove(self, keys: list[str]) -> None:
        for key in keys:
            with suppress(FileNotFoundError):
                self._system.rm(self._full(key), recursive=True)

    def _full(self, key: str) -> str:
        return f"{self.root}/{key}" if key else self.root

    def _key(self, full: str) -> str:
        return full.removeprefix(self.root).strip("/")


def _inside(key: str) -> PurePosixPath:
    """A key as a path that stays inside.

    Raises:
        CaseError: it would leave the folder that it is unpacked to.
    """
    path = PurePosixPath(key)
    if path.is_absolute() or ".." in path.parts or "\\" in key or "\0" in key:
        raise CaseError("batch.no_file_name", name=key)
    return path


def _is_kept(file: Path) -> bool:
    return file.is_file() and not file.is_symlink() and file.name != _LOCK


def _files(folder: Path) -> Iterator[Path]:
    return (file for file in sorted(folder.rglob("*")) if _is_kept(file))


def _state(case: Path) -> str:
    """Hash of names, sizes and times of a case's files; empty where there are none."""
    listed = [
        (file.relative_to(case).as_posix(), file.stat().st_size, file.stat().st_mtime_ns)
        for file in _files(case)
    ]
    return hashlib.sha256(repr(listed).encode()).hexdigest() if listed else ""


def _copy(source: Path, to: Path, check: Callable[[], None]) -> int:
    """Copy a folder into a new one and sync it; returns its bytes.

    Raises:
        FileExistsError: something lies there already.
    """
    to.mkdir()
    folders, total = {to}, 0
    for file in _files(source):
        check()
        copy = to / file.relative_to(source)
        for parent in reversed(copy.relative_to(to).parents):
            folder = to / parent
            if folder not in folders:
                folder.mkdir()
                folders.add(folder)
        shutil.copy2(file, copy)
        size = file.stat().st_size
        if copy.stat().st_size != size:
            raise _changed(source)
        _sync(copy)
        total += size
    for folder in folders:
        _sync(folder)
    return total


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _changed(case: Path | str) -> CaseError:
    return CaseError("batch.case_changed", case=str(case))


def _not_whole(case: Path | str) -> CaseError:
    return CaseError("batch.files_missing", case=str(case))


def _without_library(url: str, missing: str) -> OptionsError:
    return OptionsError("batch.library_missing", url=url, library=str(missing))


@contextmanager
def _disk_errors_as_advice(place: Path) -> Generator[None]:
    """Turn the system's errors about files into refusals with advice."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        if is_full(error):
            raise CaseError("batch.disk_full", place=str(place)) from error
        raise CaseError.of(disk_finding(error)) from error


@contextmanager
def _store_errors_as_advice(url: str) -> Generator[None]:
    """Turn an object store's errors into refusals with advice."""
    unreachable: tuple[type[BaseException], ...] = (OSError,)
    if find_spec("botocore") is not None:
        unreachable += (import_module("botocore.exceptions").BotoCoreError,)
    try:
        yield
    except unreachable as error:
        raise CaseError("batch.url_fails", url=url, why=str(error)) from error
