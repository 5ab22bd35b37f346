"""Files: read strictly and with a size limit, written atomically and verified.

Only regular files are opened: a device has no end, and a pipe blocks its reader. JSON and TOML are
read by their standards; refused are non-finite and huge numbers, text that cannot be encoded, and
deep nesting.

A file is written to a temporary name beside its place (hash of the name, process id, a counter,
`part`), synced, read back where its content is known, and then renamed.
"""

import codecs
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
"""Nesting of lists and tables; our formats need fewer than ten levels."""
_LARGEST_INTEGER = 2**53
"""Larger integers are not exact in floating point."""
_LONGEST_SUFFIX = 16
_WRITES = itertools.count()
_LONGEST_KEY = re.compile(r"^[^=,\n]{4000}", re.MULTILINE)
"""A line that may be a dotted key of thousands of parts, for which tomllib takes quadratic time."""


class ContentError(LimbgramError, ValueError):
    """A file's content is not of its format; the caller adds the file's name."""


def read_content(
    path: Path, most_bytes: int, refusal: type[LimbgramError], advice: Finding | str = ""
) -> bytes:
    """The bytes of a regular file.

    Raises:
        refusal: no such file, a folder, device or pipe, or more than `most_bytes`.
    """
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):
            why = fault("file.no_file", folder=stat.S_ISDIR(about.st_mode))
            raise _unread(path, refusal, why, advice)
        size = min(about.st_size, most_bytes)  # read() allocates what it is asked for
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
    """The tree of a JSON text; ContentError or ValueError for anything else."""
    try:
        text = content.decode(json.detect_encoding(content))
        tree = json.loads(
            text, parse_constant=_refuse_constant, object_pairs_hook=_without_duplicates
        )
    except RecursionError as error:
        raise ContentError("file.tree.deep") from error
    _require_plain(tree)
    return tree


def toml_of(text: str | bytes) -> dict[str, Any]:
    """The tree of a TOML text; ContentError or ValueError for anything else.

    A byte order mark is accepted. TOML has words for NaN and infinity: whoever takes a number
    refuses them.
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


def without_mark(content: bytes) -> bytes:
    """The bytes of a text without the byte order mark that some editors put before it."""
    return content.removeprefix(codecs.BOM_UTF8)


def write_file(
    path: Path, encode: Callable[[BinaryIO], None], check: Callable[[Path], None]
) -> Path:
    """Write a file by `encode` and verify it by `check`, which reads it back.

    Raises:
        ExportError: the disk is full or refuses, or `check` found another content.
    """
    with _disk(path), written_whole(path, check) as beside, beside.open("wb") as stream:
        encode(stream)
    return path


def write_bytes(path: Path, content: bytes, check: Callable[[Path], None] | None = None) -> Path:
    """Write a file whose bytes are at hand and verify it by `check`, or by the same bytes.

    Raises:
        ExportError: the disk is full or refuses, or the content read back is another.
    """

    def encode(stream: BinaryIO) -> None:
        stream.write(content)

    def same_bytes(written: Path) -> None:
        require(written.read_bytes() == content, other(path.name, "bytes"))

    return write_file(path, encode, check or same_bytes)


def write_folder(
    path: Path, files: dict[str, Callable[[BinaryIO], None]], check: Callable[[Path], None]
) -> Path:
    """Write a folder of files; an older folder of the name is replaced once it is verified."""
    with _disk(path), written_whole(path, check) as beside:
        beside.mkdir()
        for name, encode in files.items():
            with (beside / name).open("wb") as stream:
                encode(stream)
    return path


def require_place(path: Path) -> None:
    """Refuse a path to which no file could be written, before any work is done for it.

    Raises:
        ExportError: its folder is missing, is none, or may not be written to.
    """
    with _disk(path):
        _require_writable(path.parent)


def require_folder(folder: Path) -> None:
    """Refuse a folder that does not exist and cannot be made, before any work is done for it.

    Raises:
        ExportError: a file is in its way, or its parent may not be written to.
    """
    try:
        _require_writable(next(one for one in (folder, *folder.absolute().parents) if one.exists()))
    except OSError as error:
        raise _no_folder(folder, error) from error


def make_folder(folder: Path) -> None:
    """Make a folder and its parents where they are missing.

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
    """Atomic write: yields a temporary path beside `path`, for a file or a folder.

    What was written there is synced, verified by `check` if given, and renamed to `path`. Until
    then, and if anything fails, the old content stays. Temporary files of killed processes are
    removed. Threads may write the same file at once: the last one's stays. An OSError passes as it
    is.
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
        _put_back(older, path)
    _sync_entry(path.parent)


@contextmanager
def file_lock(path: Path, *, wait: bool) -> Generator[bool]:
    """Exclusive lock on a file, which the system releases even if the process dies.

    Yields:
        Whether the lock is held; with `wait` it always is.

    Raises:
        OSError: the file cannot be made.
    """
    with path.open("a+b") as file:
        try:
            _lock(file, wait=wait)
        except OSError:
            if wait:
                raise
            yield False
            return
        yield True


def _lock(file: BinaryIO, *, wait: bool) -> None:
    """Lock a file until it is closed."""
    if sys.platform == "win32":
        import msvcrt

        while True:
            file.seek(0)
            try:
                msvcrt.locking(file.fileno(), msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
                return
            except OSError as error:
                if not wait or error.errno != errno.EDEADLOCK:  # LK_LOCK gives up after 10 s
                    raise
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def damaged_zip_refused(refusal: Callable[[Exception], LimbgramError]) -> Generator[None]:
    """Raise this refusal for whatever zipfile and its decompressors raise for damaged bytes."""
    try:
        yield
    except _DAMAGED_ZIP as error:
        raise refusal(error) from error
    except OSError as error:
        if error.errno is not None:
            raise
        raise refusal(error) from error  # bzip2 raises one without a number


def require(condition: bool, found: Finding) -> None:
    """Refuse a file that did not read back as it was written."""
    if not condition:
        raise ExportError("export.read_back", found=found)


def other(name: str, what: str) -> Finding:
    """The finding that a file read back with a different `what`, in the plural."""
    return fault("export.other", name=name, what=what)


def other_count(name: str, what: str, found: int, written: int) -> Finding:
    """The finding that a file read back with a different number of `what`."""
    return fault("export.other_count", name=name, what=what, found=found, written=written)


def short_name(path: Path) -> str:
    """Hash of a file's name in 16 letters: the name itself may be too long to be added to."""
    name = path.name.encode("utf-8", "surrogateescape")
    return hashlib.blake2b(name, digest_size=8).hexdigest()


def _require_plain(tree: Any, *, numbers_only: bool = True) -> None:
    """Refuse non-finite and huge numbers, text that cannot be encoded, and deep nesting.

    Raises:
        ContentError: one of them; UnicodeEncodeError for text.
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
                    if abs(item) > _LARGEST_INTEGER:
                        raise ContentError("file.tree.large_number")
                case _:
                    pass
        if not below:
            return
        level = below
    raise ContentError("file.tree.deep")


def _refuse_constant(word: str) -> float:
    raise ContentError("file.json.no_number", word=word)


def _without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    tree = dict(pairs)
    if len(tree) < len(pairs):
        names = [name for name, _ in pairs]
        duplicate = next(name for name in names if names.count(name) > 1)
        raise ContentError("file.json.twice", name=duplicate[:40])
    return tree


def _unread(
    path: Path, refusal: type[LimbgramError], why: Finding, advice: Finding | str
) -> LimbgramError:
    return refusal.of(fault("file.unread", path=str(path), why=why, advice=advice))


@contextmanager
def _disk(path: Path) -> Generator[None]:
    """Turn an OSError into an ExportError with advice."""
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
    """Remove what killed processes left beside a file; the only whole one is put back."""
    for left in path.parent.glob(f".{short_name(path)}.*"):
        process = left.name.split(".")[2]
        if process.isdecimal() and not _is_alive(int(process)):
            if left.suffix == ".old":
                _put_back(left, path)
            else:
                _remove(left)


def _put_back(older: Path, path: Path) -> None:
    """Give a folder that had to give way its place again, unless another took it."""
    if path.exists():
        _remove(older)
        return
    with suppress(OSError):
        older.replace(path)


def _is_alive(process: int) -> bool:
    """Whether a process may still be running."""
    if sys.platform == "win32":
        return True  # os.kill would end it there
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
    """Flush a file, or a folder with its files, to the disk."""
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
    """Flush a folder's entries, and with them a rename, to the disk where the system can."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
