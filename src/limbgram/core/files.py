"""Files: read with a bound and strictly, written whole or not at all.

A device has no end and a pipe keeps its reader waiting, so only regular files are opened. JSON and
TOML are taken as their standards have them, and without what no file of ours or of a caring
program holds: numbers that no measure has, texts that cannot be written again, trees without end.

What is written lies beside its place at first, in a name of its own (16 letters of the name's hash,
the process, a number, `part`); it is synced, read back where somebody can tell what it should hold,
and only then takes its name.
"""

import errno
import hashlib
import itertools
import json
import lzma
import math
import os
import re
import shutil
import stat
import sys
import tomllib
import zipfile
import zlib
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, cast

from limbgram.core.errors import ExportError, LimbgramError, is_full, reason_of, system_reason
from limbgram.findings import Finding, fault

_DAMAGED_ZIP = (
    zipfile.BadZipFile,
    zipfile.LargeZipFile,
    NotImplementedError,
    EOFError,
    zlib.error,
    lzma.LZMAError,
)
_DEEPEST = 64
"""Levels of lists and tables in each other; no format of ours has ten."""
_LARGEST_WHOLE = 2**53
"""Whole numbers beyond cannot be told from their neighbours in floating point."""
_LONGEST_SUFFIX = 16
_WRITES = itertools.count()
_LONGEST_KEY = re.compile(r"^[^=,\n]{4000}", re.MULTILINE)
"""A line that would be a dotted key of thousands of parts: tomllib takes their square in time."""


class ContentError(LimbgramError, ValueError):
    """What a file holds is not of its format; whoever reads the file says which file it is."""


def read_content(
    path: Path, most_bytes: int, refusal: type[LimbgramError], advice: Finding | str = ""
) -> bytes:
    """The bytes of a regular file; what else the path may be is never opened.

    Raises:
        refusal: no such file, a folder, device or pipe, or more bytes than such a file can have.
    """
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):
            why = fault("file.no_file", folder=stat.S_ISDIR(about.st_mode))
            raise _unread(path, refusal, why, advice)
        size = min(about.st_size, most_bytes)  # room is made for as much as is asked for
        with path.open("rb") as stream:
            content = stream.read(size + 1)
            if len(content) > size:
                content += stream.read(most_bytes - size)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        why = system_reason(error) if isinstance(error, OSError) else reason_of(error)
        raise _unread(path, refusal, why, advice) from error
    if len(content) > most_bytes:
        most_mb = most_bytes >> 20 if most_bytes >= 1 << 20 else most_bytes / 1e6
        raise refusal.of(fault("file.too_large", path=str(path), most_mb=most_mb, advice=advice))
    return content


def json_of(content: bytes) -> Any:
    """The tree of a JSON text; ValueError, in words, for anything else."""
    try:
        text = content.decode(json.detect_encoding(content))
        tree = json.loads(text, parse_constant=_no_number, object_pairs_hook=_once_each)
    except RecursionError as error:
        raise ContentError("file.tree.deep") from error
    _require_plain(tree)
    return tree


def toml_of(text: str | bytes) -> dict[str, Any]:
    """The tree of a TOML text; ValueError, in words, for anything else.

    The bytes of a file may begin with a mark of their order, as Windows' editor writes it. The
    format has words for what is no number: who takes a value refuses those by its name.
    """
    if isinstance(text, bytes):
        try:
            text = text.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise ContentError("file.no_text") from error
    if _LONGEST_KEY.search(text):
        raise ContentError("file.toml.long_key")
    try:
        tree = tomllib.loads(text)
    except RecursionError as error:
        raise ContentError("file.tree.deep") from error
    _require_plain(tree, numbers_only=False)
    return tree


def write_file(
    path: Path, encode: Callable[[BinaryIO], None], check: Callable[[Path], None]
) -> Path:
    """Write a file by `encode` and prove it by `check`, which reads it back.

    Raises:
        ExportError: the disk is full or refuses, or `check` found another content.
    """
    with _disk(path), written_whole(path, check) as beside, beside.open("wb") as stream:
        encode(stream)
    return path


def write_bytes(path: Path, content: bytes) -> Path:
    """Write a file whose bytes are at hand; proved by reading the same ones."""

    def encode(stream: BinaryIO) -> None:
        stream.write(content)

    def check(written: Path) -> None:
        require(written.read_bytes() == content, other(path.name, "bytes"))

    return write_file(path, encode, check)


def write_folder(
    path: Path, files: dict[str, Callable[[BinaryIO], None]], check: Callable[[Path], None]
) -> Path:
    """Write a folder of files; an older folder of the name gives way once the new one is proved."""
    with _disk(path), written_whole(path, check) as beside:
        beside.mkdir()
        for name, encode in files.items():
            with (beside / name).open("wb") as stream:
                encode(stream)
    return path


def require_place(path: Path) -> None:
    """Refuse a file, before any work is done for it, that could not be written where it is to lie.

    Raises:
        ExportError: its folder is missing, is none, or may not be written to.
    """
    with _disk(path):
        _require_writable(path.parent)


def require_folder(folder: Path) -> None:
    """Refuse a folder, before any work is done for it, that is not there and cannot be made.

    Raises:
        ExportError: a file stands in its way, or what it would lie in may not be written to.
    """
    try:
        _require_writable(next(one for one in (folder, *folder.absolute().parents) if one.exists()))
    except OSError as error:
        raise _no_folder(folder, error) from error


def make_folder(folder: Path) -> None:
    """Make a folder, and those that it lies in, where they are not there.

    Raises:
        ExportError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _no_folder(folder, error) from error


def _no_folder(folder: Path, error: OSError) -> ExportError:
    """The refusal of a folder that cannot be made."""
    return ExportError(
        "export.disk.no_folder", folder=str(folder), system=str(error.strerror or error)
    )


def _require_writable(folder: Path) -> None:
    if not folder.is_dir():
        code = errno.ENOTDIR if folder.exists() else errno.ENOENT
        raise OSError(code, os.strerror(code))
    if not os.access(folder, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


@contextmanager
def written_whole(path: Path, check: Callable[[Path], None] | None = None) -> Generator[Path]:
    """Give a place beside `path` to write a file or a folder at; it is there whole or not at all.

    What was written is synced, proved by `check` where there is one, and renamed. Until then, and
    if anything fails, what lay at `path` stays. What processes that were killed while they wrote
    the same left beside it is removed. Threads that write the same file at once do not meet: the
    last one's stays. What the system says of the disk passes as it is.
    """
    suffix = path.suffix if len(path.suffix) <= _LONGEST_SUFFIX else ""
    mark = f".{short_name(path)}.{os.getpid()}.{next(_WRITES)}"
    beside, older = path.with_name(f"{mark}.part{suffix}"), path.with_name(f"{mark}.old")
    _sweep(path)
    try:
        yield beside
        _sync(beside)
        if check is not None:
            check(beside)
        if beside.is_dir() and path.exists():
            path.replace(older)
        beside.replace(path)
    finally:
        _remove(beside)
        _remove(older)
    _sync_entry(path.parent)


@contextmanager
def held_alone(place: Path, *, wait: bool) -> Generator[bool]:
    """Hold a file for this process alone; the system lets it go even if the process dies.

    Yields:
        Whether it is held; where `wait`, it always is, once whoever holds it lets it go.

    Raises:
        OSError: the file cannot be made.
    """
    with place.open("a+b") as file:
        try:
            _hold(file, wait=wait)
        except OSError:
            if wait:
                raise
            yield False
            return
        yield True


def _hold(file: BinaryIO, *, wait: bool) -> None:
    """Until it is closed."""
    if sys.platform == "win32":
        import msvcrt

        file.seek(0)
        msvcrt.locking(file.fileno(), msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def damaged_zip_refused(refusal: Callable[[Exception], LimbgramError]) -> Generator[None]:
    """What zipfile and its decompressors raise for damaged bytes is answered by this refusal."""
    try:
        yield
    except _DAMAGED_ZIP as error:
        raise refusal(error) from error
    except OSError as error:
        if error.errno is not None:
            raise
        raise refusal(error) from error  # bzip2 says so


def require(holds: bool, found: Finding) -> None:
    """Refuse a file that did not read back as it was written."""
    if not holds:
        raise ExportError("export.read_back", found=found)


def other(name: str, what: str) -> Finding:
    """That a file which was read back holds other ones than were written; what: in the plural."""
    return fault("export.other", name=name, what=what)


def other_count(name: str, what: str, found: int, written: int) -> Finding:
    """That a file which was read back does not hold as many as were written."""
    return fault("export.other_count", name=name, what=what, found=found, written=written)


def short_name(path: Path) -> str:
    """Sixteen letters for a file's name: with an addition the name itself may be too long."""
    name = path.name.encode("utf-8", "surrogateescape")
    return hashlib.blake2b(name, digest_size=8).hexdigest()


def _require_plain(tree: Any, *, numbers_only: bool = True) -> None:
    """Refuse numbers that no measure has, texts that cannot be written, and trees without end.

    Raises:
        ContentError: says which.
    """
    level: Sequence[Any] = [tree]
    for _ in range(_DEEPEST):
        below: list[Any] = []
        for item in level:
            match item:
                case dict():
                    known = cast(dict[str, Any], item)
                    below += known.keys()
                    below += known.values()
                case list():
                    below += cast(list[Any], item)
                case str():
                    item.encode()
                case float():
                    if numbers_only and not math.isfinite(item):
                        raise ContentError("file.tree.no_value")
                case int():
                    if abs(item) > _LARGEST_WHOLE:
                        raise ContentError("file.tree.large_number")
                case _:
                    pass
        if not below:
            return
        level = below
    raise ContentError("file.tree.deep")


def _no_number(word: str) -> float:
    raise ContentError("file.json.no_number", word=word)


def _once_each(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    tree = dict(pairs)
    if len(tree) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ContentError("file.json.twice", name=twice[:40])
    return tree


def _unread(
    path: Path, refusal: type[LimbgramError], why: Finding, advice: Finding | str
) -> LimbgramError:
    return refusal.of(fault("file.unread", path=str(path), why=why, advice=advice))


@contextmanager
def _disk(path: Path) -> Generator[None]:
    """Turn what the system says about a disk into advice."""
    try:
        yield
    except OSError as error:
        if is_full(error):
            raise ExportError(
                "export.disk.full", name=path.name, folder=str(path.parent)
            ) from error
        raise ExportError(
            "export.disk.refused",
            name=path.name,
            folder=str(path.parent),
            why=system_reason(error),
        ) from error


def _sweep(path: Path) -> None:
    """Remove what processes that were killed while they wrote the same file left beside it."""
    for left in path.parent.glob(f".{short_name(path)}.*"):
        process = left.name.split(".")[2]
        if process.isdecimal() and not _is_alive(int(process)):
            _remove(left)


def _is_alive(process: int) -> bool:
    """Whether a process may still be running."""
    if sys.platform == "win32":
        return True  # to ask by a signal would end it there
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
        return
    with suppress(OSError):
        path.unlink(missing_ok=True)


def _sync(path: Path) -> None:
    """Have the system put a file, or a folder with its files, on the disk."""
    if path.is_dir():
        for inside in path.iterdir():
            _sync(inside)
        _sync_entry(path)
        return
    handle = os.open(path, os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _sync_entry(folder: Path) -> None:
    """Make a renaming last; systems that cannot sync a folder keep it by themselves."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
