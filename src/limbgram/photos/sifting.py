"""Sifting: which files can be photos or masks, and what is said about the others.

In      files, or what lies in a folder; sub-folders are no candidates.
Out     the candidates, by their ending or by their first bytes, and what was set aside and why.
Method  nothing is decoded; of many files of other kinds a few are named and the rest counted.
"""

import stat
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from limbgram.errors import printable
from limbgram.photos.photo import SetAside

RAW_SUFFIXES = (".3fr", ".arw", ".cr2", ".cr3", ".dng", ".nef", ".orf", ".pef", ".raf", ".rw2")
_SUFFIXES = (".jpg", ".jpeg", ".png", ".tif", ".tiff", ".heic", ".heif", *RAW_SUFFIXES)
_BEGINNINGS = (
    b"\xff\xd8\xff",  # JPEG
    b"\x89PNG\r\n\x1a\n",
    b"II*\0",  # TIFF, and most raw files
    b"MM\0*",
    b"II+\0",  # TIFF for files beyond 4 GB
    b"MM\0+",
)
_HEIF_BRANDS = (b"heic", b"heix", b"hevc", b"mif1", b"msf1")
_NAMED_AT_MOST = 5


@dataclass(frozen=True)
class Sifted:
    """Candidates in the order in which they were given, and the rest."""

    pictures: tuple[Path, ...]
    set_aside: tuple[SetAside, ...]


def sifted(files: Iterable[Path]) -> Sifted:
    """Part what can be a picture from what cannot."""
    pictures: list[Path] = []
    others: list[Path] = []
    set_aside: list[SetAside] = []
    for file in files:
        fault = _fault(file)
        if fault is not None:
            set_aside.append(SetAside(name_for_people(file), fault))
        elif file.suffix.lower() in _SUFFIXES or _begins_as_picture(file):
            pictures.append(file)
        elif not file.is_dir():
            others.append(file)
    return Sifted(tuple(pictures), (*set_aside, *_summed_up(others)))


def name_for_people(path: Path) -> str:
    """A file's name without what a terminal would obey."""
    return printable(path.name or str(path), keep="")


def name_fault(path: Path) -> str | None:
    """Why a file's name cannot stand in results; None where it can."""
    if name_for_people(path) == path.name:
        return None
    return "its name is not valid text, or holds characters that are not shown: rename it"


def _fault(path: Path) -> str | None:
    """Why what is named as a picture is none that can be opened."""
    try:
        mode = path.stat().st_mode
    except PermissionError:
        return "no permission to read it"
    except OSError:
        return "not a file, or a link that leads nowhere"
    if stat.S_ISREG(mode):
        return name_fault(path)
    if path.suffix.lower() not in _SUFFIXES:
        return None
    return "a folder, not a file" if stat.S_ISDIR(mode) else "not a file"


def _begins_as_picture(path: Path) -> bool:
    """Cameras and programs leave endings out, or add one."""
    if not path.is_file():
        return False
    try:
        with path.open("rb") as stream:
            first = stream.read(12)
    except OSError:
        return False
    return first.startswith(_BEGINNINGS) or (first[4:8] == b"ftyp" and first[8:] in _HEIF_BRANDS)


def _summed_up(others: list[Path]) -> list[SetAside]:
    if len(others) <= _NAMED_AT_MOST:
        return [SetAside(name_for_people(file), "not a picture") for file in others]
    some = ", ".join(name_for_people(file) for file in others[:_NAMED_AT_MOST])
    return [SetAside(f"{len(others):,} other files", f"not pictures: {some} and so on")]
