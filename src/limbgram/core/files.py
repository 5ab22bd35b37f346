"""Files: read with a bound and strictly, written whole or not at all.

A device has no end and a pipe keeps its reader waiting, so only regular files are opened. JSON and
TOML are taken as their standards have them, and without what no file of ours or of a caring
program holds: numbers that no measure has, texts that cannot be written again, trees without end.

What is written lies beside its place at first, in a name of its own (16 letters of the name's hash,
the process, a number, `part`); it is synced, read back where somebody can tell what it should hold,
and only then takes its name.
"""

import hashlib
import itertools
import json
import math
import os
import re
import shutil
import stat
import sys
import tomllib
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, cast

from limbgram.core.errors import ExportError, LimbgramError, is_full

_DEEPEST = 64
"""Levels of lists and tables in each other; no format of ours has ten."""
_LARGEST_WHOLE = 2**53
"""Whole numbers beyond cannot be told from their neighbours in floating point."""
_LONGEST_SUFFIX = 16
_WRITES = itertools.count()
_LONGEST_KEY = re.compile(r"^[^=,\n]{4000}", re.MULTILINE)
"""A line that would be a dotted key of thousands of parts: tomllib takes their square in time."""


def read_content(
    path: Path, most_bytes: int, refusal: type[LimbgramError], advice: str = ""
) -> bytes:
    """The bytes of a regular file; what else the path may be is never opened.

    Raises:
        refusal: no such file, a folder, device or pipe, or more bytes than such a file can have.
    """
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):
            what = "a folder" if stat.S_ISDIR(about.st_mode) else "a device or pipe"
            raise refusal(f"{path} cannot be read: it is {what}, no file. {advice}".rstrip())
        size = min(about.st_size, most_bytes)  # room is made for as much as is asked for
        with path.open("rb") as stream:
            content = stream.read(size + 1)
            if len(content) > size:
                content += stream.read(most_bytes - size)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        told = getattr(error, "strerror", None) or error
        raise refusal(f"{path} cannot be read: {told}. {advice}".rstrip()) from error
    if len(content) > most_bytes:
        told = f"{path} is too large for what it should be: more than {_size(most_bytes)}. {advice}"
        raise refusal(told.rstrip())
    return content


def json_of(content: bytes) -> Any:
    """The tree of a JSON text; ValueError, in words, for anything else."""
    try:
        text = content.decode(json.detect_encoding(content))
        tree = json.loads(text, parse_constant=_no_number, object_pairs_hook=_once_each)
    except RecursionError as error:
        raise ValueError("its lists lie too deep in each other") from error
    _require_plain(tree)
    return tree


def toml_of(text: str) -> dict[str, Any]:
    """The tree of a TOML text; ValueError, in words, for anything else.

    The format has words for what is no number: who takes a value refuses those by its name.
    """
    if _LONGEST_KEY.search(text):
        raise ValueError("a line of it is too long for a key")
    try:
        tree = tomllib.loads(text)
    except RecursionError as error:
        raise ValueError("its lists lie too deep in each other") from error
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
        require(written.read_bytes() == content, f"{path.name}: other bytes")

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


def require(holds: bool, finding: str) -> None:
    """Refuse a file that did not read back as it was written."""
    if not holds:
        raise ExportError(
            f"Reading back found {finding}. The file was not kept. The disk or its connection is "
            "probably failing: write to another disk."
        )


def short_name(path: Path) -> str:
    """Sixteen letters for a file's name: with an addition the name itself may be too long."""
    name = path.name.encode("utf-8", "surrogateescape")
    return hashlib.blake2b(name, digest_size=8).hexdigest()


def _require_plain(tree: Any, *, numbers_only: bool = True) -> None:
    """Refuse numbers that no measure has, texts that cannot be written, and trees without end.

    Raises:
        ValueError: says which.
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
                        raise ValueError("it holds a number without a value or beyond all measure")
                case int():
                    if abs(item) > _LARGEST_WHOLE:
                        raise ValueError("it holds a number beyond all measure")
                case _:
                    pass
        if not below:
            return
        level = below
    raise ValueError("its lists lie too deep in each other")


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is no number in JSON")


def _once_each(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    tree = dict(pairs)
    if len(tree) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice[:40]!r} stands there twice")
    return tree


def _size(count: int) -> str:
    return f"{count >> 20} MB" if count >= 1 << 20 else f"{count / 1e6:g} MB"


@contextmanager
def _disk(path: Path) -> Generator[None]:
    """Turn what the system says about a disk into advice."""
    try:
        yield
    except OSError as error:
        if is_full(error):
            raise ExportError(
                f"{path.name} was not written: the disk of {path.parent} is full. Free some "
                "space, or choose another folder, and run again; what is finished is kept."
            ) from error
        raise ExportError(
            f"{path.name} was not written to {path.parent}: {error.strerror or error}. Check "
            "that the folder exists and may be written to, and that the name is not too long."
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
