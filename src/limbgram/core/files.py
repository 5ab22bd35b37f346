"""Files: what somebody names on a command line or hands over, read with a bound and strictly.

A device has no end and a pipe keeps its reader waiting, so only regular files are opened. JSON and
TOML are taken as their standards have them, and without what no file of ours or of a caring
program holds: numbers that no measure has, texts that cannot be written again, trees without end.
"""

import hashlib
import json
import math
import os
import re
import stat
import tomllib
from collections.abc import Generator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, cast

from limbgram.core.errors import LimbgramError

_DEEPEST = 64
"""Levels of lists and tables in each other; no format of ours has ten."""
_LARGEST_WHOLE = 2**53
"""Whole numbers beyond cannot be told from their neighbours in floating point."""
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
        mode = path.stat().st_mode
        if not stat.S_ISREG(mode):
            what = "a folder" if stat.S_ISDIR(mode) else "a device or pipe"
            raise refusal(f"{path} cannot be read: it is {what}, no file. {advice}".rstrip())
        with path.open("rb") as stream:
            content = stream.read(most_bytes + 1)
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


@contextmanager
def written_whole(path: Path) -> Generator[Path]:
    """Write a file beside its place, sync it, rename it: it is there whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    half = path.with_name(f".{short_name(path)}.half")
    try:
        yield half
        sync(half)
        half.replace(path)
    except BaseException:
        with suppress(OSError):
            half.unlink(missing_ok=True)
        raise


def sync(path: Path) -> None:
    """Have the system put a file on the disk."""
    handle = os.open(path, os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


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
