"""Zips: safe extraction of a capture from an untrusted zip file.

In      a zip file, and a new folder.
Out     its files in that folder; a single folder round all of them is taken off.
Method  Names, sizes and kinds of all members are checked before a byte is written. No more bytes of
        a member are unpacked than the zip's directory announced.
Fails   PhotoError: no zip, damaged, with a password, with names that leave the folder, with links,
        or with more in it than a walk round a limb has. CaseError: the disk has no room for it.
"""

import shutil
import stat
import zipfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Protocol

from limbgram.core.errors import CaseError, PhotoError, printable
from limbgram.core.files import damaged_zip_refused

_MOST_FILES = 2000
_MOST_BYTES = 16_000_000_000
_MOST_EXPANSION = 200
"""Largest ratio of expanded to compressed size: photos hardly shrink."""
_SMALL_BYTES = 100_000
"""Smaller files may expand further: lists and settings shrink much."""
_LONGEST_PART = 200
_PIECE_BYTES = 1 << 20
_LEFT_OUT = ("__MACOSX",)


class Writer(Protocol):
    """Takes the unpacked bytes."""

    def write(self, content: bytes, /) -> object: ...


@dataclass(frozen=True)
class _Member:
    """A file of a zip, and its path in the folder."""

    info: zipfile.ZipInfo
    place: PurePosixPath


def unpack(source: Path, folder: Path) -> Path:
    """Unpack a zip into a folder, in place of what lay there; returns the folder.

    Raises:
        PhotoError: the zip cannot be trusted or read.
        CaseError: there is no room for it.
    """
    shutil.rmtree(folder, ignore_errors=True)
    with damaged_zip_refused(partial(_damaged, source)), zipfile.ZipFile(source) as archive:
        members = _members(source, archive)
        _require_room(source, folder, members)
        for member in members:
            place = folder.joinpath(*member.place.parts)
            place.parent.mkdir(parents=True, exist_ok=True)
            with place.open("wb") as writer:
                copy_member(archive, member.info, writer)
    return folder


def copy_member(archive: zipfile.ZipFile, info: zipfile.ZipInfo, writer: Writer) -> None:
    """Unpack one file, and refuse it if it is larger than the zip's directory says."""
    left = info.file_size
    with archive.open(info) as reader:
        while piece := reader.read(_PIECE_BYTES):
            left -= len(piece)
            if left < 0:
                raise zipfile.BadZipFile(f"{info.filename} is larger than its list says")
            writer.write(piece)


def expands_too_far(info: zipfile.ZipInfo) -> bool:
    """Whether a member grows as only one of a zip bomb does."""
    most_bytes = max(_SMALL_BYTES, _MOST_EXPANSION * max(info.compress_size, 1))
    return info.file_size > most_bytes


def _damaged(source: Path, error: Exception) -> PhotoError:
    return PhotoError("archive.damaged", source=str(source), why=str(error))


def _members(source: Path, archive: zipfile.ZipFile) -> list[_Member]:
    files = [one for one in archive.infolist() if not one.is_dir()]
    places = [_place(source, one) for one in files]
    kept = [
        _Member(info, place)
        for info, place in zip(files, places, strict=True)
        if not any(part.startswith(".") or part in _LEFT_OUT for part in place.parts)
    ]
    _require_reasonable(source, [one.info for one in kept])
    kept = _without_outer_folder(kept)
    seen: dict[str, PurePosixPath] = {}
    for member in kept:
        other = seen.setdefault(str(member.place).casefold(), member.place)
        if other is not member.place:
            raise PhotoError("archive.twice", source=str(source), name=str(other))
    if not kept:
        raise PhotoError("archive.empty", source=str(source))
    return kept


def _place(source: Path, info: zipfile.ZipInfo) -> PurePosixPath:
    """The path of a member, checked to stay inside the folder on every system."""
    name = info.filename
    place = PurePosixPath(name)
    outside = (
        place.is_absolute()
        or ".." in place.parts
        or "\\" in name
        or ":" in name
        or printable(name, keep="") != name
        or any(len(part.encode()) > _LONGEST_PART for part in place.parts)
    )
    if outside:
        raise PhotoError("archive.outside", source=str(source), name=printable(name, keep="")[:80])
    if stat.S_ISLNK(info.external_attr >> 16):
        raise PhotoError("archive.link", source=str(source), name=name)
    if info.flag_bits & 1:
        raise PhotoError("archive.password", source=str(source))
    return place


def _require_reasonable(source: Path, members: list[zipfile.ZipInfo]) -> None:
    whole = sum(one.file_size for one in members)
    bomb = any(expands_too_far(one) for one in members)
    if len(members) > _MOST_FILES or whole > _MOST_BYTES or bomb:
        raise PhotoError(
            "archive.too_large",
            source=str(source),
            size_mb=source.stat().st_size / 1e6,
            unpacked_mb=whole / 1e6,
            files=len(members),
        )


def _without_outer_folder(members: list[_Member]) -> list[_Member]:
    """The members without the one folder that holds all of them, which most programs add."""
    while members:
        tops = {member.place.parts[0] for member in members}
        if len(tops) > 1 or any(len(member.place.parts) == 1 for member in members):
            return members
        members = [
            _Member(member.info, PurePosixPath(*member.place.parts[1:])) for member in members
        ]
    return members


def _require_room(source: Path, folder: Path, members: list[_Member]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    needed = sum(member.info.file_size for member in members)
    free = shutil.disk_usage(folder).free
    if needed > free:
        raise CaseError(
            "archive.no_room",
            source=str(source),
            needed_mb=needed / 1e6,
            free_mb=free / 1e6,
            folder=str(folder.parent),
        )
