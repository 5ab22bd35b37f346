"""Uploads: resumable uploads of photos, received in pieces and stored whole in a case.

In      pieces of a file, each with the place where it belongs; zip files of photos, videos.
Out     RECEIVED/NAME, the photo without places, names and serial numbers in its header (see
        `photos.privacy`), and RECEIVED/.records/NAME.json: hashes of the sent and the kept file.
Method  A file grows under a temporary name; its size on the disk tells how much has arrived,
        whatever the sender believes. Once it is complete it is hashed, its header is cleaned, and
        it is renamed. The same file may be sent again; another file of the same name is refused. A
        growing file belongs to one upload: another upload of the same name waits until it is
        complete or given up, so that no photo is assembled from two.
Fails   OptionsError: a name that no photo can have, a piece that does not follow, too many bytes.
        CaseError: another file of that name is here, or is being uploaded.
"""

import re
import secrets
import threading
import time
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import IO, Self

from limbgram.cases.case_record import write_json
from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.zips import copy_member, expands_too_far
from limbgram.core.errors import CaseError, MissingError, OptionsError, printable
from limbgram.core.files import damaged_zip_refused, json_of, read_content, written_whole
from limbgram.core.typed import Mismatch, tree_of, value_of
from limbgram.findings import Finding, doubt
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.photos.privacy import remove_video_location, without_personal_data
from limbgram.reconstruction.photos.quality import PICTURE_SUFFIXES, VIDEO_SUFFIXES
from limbgram.reconstruction.photos.reading import names_apart, read_photo
from limbgram.reconstruction.photos.shots import files_not_used

MOST_PHOTO_BYTES = 300_000_000
MOST_VIDEO_BYTES = 8_000_000_000
"""Also of a zip, and of what is unpacked from it."""
MOST_FILES = 1000
_ZIP = (".zip",)
_LONGEST_NAME = 120
_NAME = re.compile(r"[^\x00-\x1f/\\:*?\"<>|.~ ][^\x00-\x1f/\\:*?\"<>|]*")
_DEVICE_NAMES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
_LARGEST_RECORD_BYTES = 100_000
WHOLE, PIECES = "whole", "pieces"
"""Ids of uploads to which the sender gave none: in one request, and in several."""
GIVEN_UP_S = 60.0
"""Time without a byte after which another upload may replace an incomplete one."""


@dataclass(frozen=True, kw_only=True)
class Received:
    """A file that has arrived completely."""

    name: str
    bytes: int
    """As sent."""
    sha256: str
    """As sent, for the sender to compare with."""
    kept_sha256: str
    """As kept, without what identifies place or person."""
    removed: tuple[str, ...] = ()
    """Parts of the header that were removed."""
    kept: tuple[str, ...] = ()
    """Parts that had to stay though they may identify the camera."""
    width_px: int = 0
    height_px: int = 0
    problem: Finding | None = None
    """Why the photo cannot be used, or why its record cannot be read; None for a good one."""

    @property
    def usable(self) -> bool:
        """Whether a run can use it, as far as is known."""
        return self.problem is None or self.problem.code != "photo.unusable"


@dataclass(frozen=True, kw_only=True)
class Arriving:
    """A file that has arrived in part."""

    name: str
    bytes: int
    """That have arrived."""
    total: int | None
    """That were announced."""


@dataclass(frozen=True, kw_only=True)
class _Announced:
    """Size and upload id that were announced for a file that has arrived in part."""

    total: int | None = None
    upload: str = WHOLE


class Piece:
    """An open piece of a growing file; nobody else writes to the file until it is closed."""

    def __init__(self, stream: IO[bytes], part: Path) -> None:
        self._stream, self._part = stream, part
        self._lock = threading.Lock()
        self._gave_way = False
        self.closed = False
        """Whether all is written; the piece may stay open until the file has its name."""
        self.last_write_s = time.monotonic()

    def write(self, content: bytes | bytearray, /) -> int:
        """Append to the file.

        Raises:
            CaseError: another request goes on with the same file.
        """
        with self._lock:
            self.last_write_s = time.monotonic()
            if self._gave_way:
                raise CaseError("case.upload.given_up")
            written = self._stream.write(content)
            self._stream.flush()  # the list of photos tells the size on the disk
            return written

    def close(self) -> None:
        """Write all of it to the disk."""
        with self._lock:
            self._stream.close()
            self.closed = True

    def give_way(self) -> None:
        """Close it for another request that goes on with the same file."""
        with self._lock:
            self._gave_way = True
            self._stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.close()
        finally:
            with _OPEN_PIECES_LOCK:
                if _OPEN_PIECES.get(self._part) is self:
                    del _OPEN_PIECES[self._part]


_OPEN_PIECES_LOCK = threading.Lock()
_OPEN_PIECES: dict[Path, Piece] = {}
"""By the growing file; also while a complete file is hashed and cleaned."""


@dataclass(frozen=True)
class Intake:
    """A folder that receives photos, over any number of connections at once."""

    folder: Path
    key: bytes
    """Secret with which serial numbers are replaced by pseudonyms."""

    @property
    def _records(self) -> Path:
        return self.folder / ".records"

    def received(self) -> tuple[Received, ...]:
        """Files that have arrived completely, by name."""
        found = (self.record(path.name) for path in self._whole_files())
        return tuple(one for one in found if one is not None)

    def arriving(self) -> tuple[Arriving, ...]:
        """Files that have arrived in part, by name."""
        if not self._records.is_dir():
            return ()
        parts = sorted(self._records.glob("*.part"))
        return tuple(self._arriving(part.name.removesuffix(".part")) for part in parts)

    def record(self, name: str) -> Received | None:
        """The record of a file; None where it has not arrived completely."""
        path = self._records / f"{name}.json"
        if not (self.folder / name).is_file() or not path.is_file():
            return None
        try:
            return value_of(json_of(read_content(path, _LARGEST_RECORD_BYTES, CaseError)), Received)
        except (CaseError, Mismatch, ValueError):
            return Received(  # without a hash no file that is sent counts as the same
                name=name,
                bytes=(self.folder / name).stat().st_size,
                sha256="",
                kept_sha256="",
                problem=doubt("photo.record_unreadable"),
            )

    def arrived(self, name: str) -> int:
        """Bytes of an incomplete file that have arrived."""
        part = self._part(name)
        return part.stat().st_size if part.is_file() else 0

    def begin(self, name: str, start: int, total: int | None, upload: str = WHOLE) -> Piece:
        """Open a piece that begins at the byte `start`.

        Keep it open until the file has its name, so that nobody changes the file meanwhile.

        Args:
            upload: Tells uploads of one name apart: an id of the sender's choice, `PIECES` or
                `WHOLE`.

        Raises:
            OptionsError: the piece does not follow what has arrived, or the file is too large.
            CaseError: another upload of the name is under way.
            LookupError: the case or the camera was deleted meanwhile.
        """
        most = limit_of(name)
        if total is not None and total > most:
            raise OptionsError(
                "case.upload.too_large", name=name, size_mb=total / 1e6, most_mb=most / 1e6
            )
        if start == 0 and len(self._whole_files()) >= MOST_FILES:
            raise OptionsError("case.upload.too_many", most=MOST_FILES)
        if not self.folder.parent.is_dir():
            raise MissingError("case.upload.deleted")
        for made in (self.folder, self._records):
            made.mkdir(exist_ok=True)
        with _OPEN_PIECES_LOCK:
            self._require_free(name, start, total, upload)
            here = self.arrived(name)
            if start > here:
                raise OptionsError("case.upload.gap", name=name, here=here, start=start)
            part = self._part(name)
            write_json(
                self._announcement_file(name), tree_of(_Announced(total=total, upload=upload))
            )
            stream = part.open("r+b" if here else "wb")
            stream.truncate(start)
            stream.seek(start)
            _OPEN_PIECES[part] = Piece(stream, part)
            return _OPEN_PIECES[part]

    def _require_free(self, name: str, start: int, total: int | None, upload: str) -> None:
        """Refuse a piece that would be written into the file of another upload."""
        part, known = self._part(name), self._announcement(name)
        own_id = upload not in (WHOLE, PIECES) and upload == known.upload
        coming = _OPEN_PIECES.get(part)
        if coming is not None:
            quiet = time.monotonic() - coming.last_write_s > GIVEN_UP_S
            if coming.closed or not (own_id or quiet):
                raise _other_upload(name, "coming")
            coming.give_way()  # its connection is dead, and its sender has come back
        if not self.arrived(name):
            return
        if start > 0:
            same = upload == known.upload or (upload, known.upload) == (PIECES, WHOLE)
            if not same or (None not in (total, known.total) and total != known.total):
                raise _other_upload(name, "begun")
            return
        again = own_id or (upload, known.upload) == (WHOLE, WHOLE)
        if not again and time.time() - part.stat().st_mtime < GIVEN_UP_S:
            raise _other_upload(name, "begun", self.arrived(name))

    def finish(self, name: str, *, replace: bool = False) -> tuple[Received, bool]:
        """Give a complete file its name; returns its record, and whether it is new.

        Raises:
            CaseError: another file of the name is here.
        """
        part = self._part(name)
        sha256, size = file_sha256(part), part.stat().st_size
        known = self.record(name)
        if known is not None and known.sha256 == sha256:
            self._discard_part(name)
            return known, False
        if known is not None and not replace:
            self._discard_part(name)
            raise CaseError("case.upload.other_content", name=name)
        with _CLEANING_LOCK:  # one photo in memory at a time
            received = self._keep(name, part, sha256, size)
        write_json(self._records / f"{name}.json", tree_of(received))
        self._discard_part(name)
        return received, True

    def unpack(self, name: str, *, replace: bool = False) -> tuple[tuple[Received, bool], ...]:
        """Take the photos out of a zip that has arrived, and delete the zip.

        Raises:
            OptionsError: it is no zip, or holds too much.
        """

        def damaged(_: Exception) -> OptionsError:
            return OptionsError("archive.sent_damaged", name=name)

        part = self._part(name)
        found: list[tuple[Received, bool]] = []
        try:
            with damaged_zip_refused(damaged), zipfile.ZipFile(part) as archive:
                members = [
                    one
                    for one in archive.infolist()
                    if not one.is_dir()
                    and suffix_of(one.filename) in PICTURE_SUFFIXES
                    and not PurePosixPath(one.filename).name.startswith((".", "__"))
                ]
                _require_reasonable(name, members)
                stem = PurePosixPath(name).stem
                files = [Path("/", stem, one.filename.replace("\\", "/")) for one in members]
                called = names_apart(files)
                for member, file in zip(members, files):
                    inner = checked_name(called[file])
                    with self.begin(inner, 0, None, f"{name}/{inner}") as target:
                        try:
                            copy_member(archive, member, target)
                            target.close()
                            found.append(self.finish(inner, replace=replace))
                        finally:
                            self._discard_part(inner)
        except RuntimeError as error:  # zipfile's refusal of an encrypted member
            raise damaged(error) from error
        finally:
            self._discard_part(name)
        if not found:
            raise OptionsError("archive.sent_without_photos", name=name)
        return tuple(found)

    def remove(self, name: str) -> bool:
        """Delete a file and its record; returns whether there was one."""
        there = (self.folder / name).is_file() or self._part(name).is_file()
        with _OPEN_PIECES_LOCK:
            coming = _OPEN_PIECES.get(self._part(name))
            if coming is not None and coming.closed:
                raise _other_upload(name, "whole")
            if coming is not None:
                coming.give_way()
        (self.folder / name).unlink(missing_ok=True)
        (self._records / f"{name}.json").unlink(missing_ok=True)
        self._discard_part(name)
        return there

    def _whole_files(self) -> list[Path]:
        if not self.folder.is_dir():
            return []
        return sorted(file for file in self.folder.iterdir() if not file.name.startswith("."))

    def _keep(self, name: str, part: Path, sha256: str, size: int) -> Received:
        """Clean a complete file, put it in its place, and check whether it can be used."""
        place = self.folder / name
        if suffix_of(name) in VIDEO_SUFFIXES:
            removed = remove_video_location(part)
            part.replace(place)
            kept = file_sha256(place) if removed else sha256
            return Received(name=name, bytes=size, sha256=sha256, kept_sha256=kept, removed=removed)
        cleaned = without_personal_data(part.read_bytes(), suffix_of(name), self.key)
        with written_whole(place) as beside:
            beside.write_bytes(cleaned.content)
        seen = read_photo(place)
        unusable = isinstance(seen, SetAside)
        return Received(
            name=name,
            bytes=size,
            sha256=sha256,
            kept_sha256=file_sha256(place),
            removed=cleaned.removed,
            kept=cleaned.kept,
            width_px=0 if unusable else seen.width_px,
            height_px=0 if unusable else seen.height_px,
            problem=doubt("photo.unusable", reason=seen.reason) if unusable else None,
        )

    def _arriving(self, name: str) -> Arriving:
        return Arriving(name=name, bytes=self.arrived(name), total=self._announcement(name).total)

    def _announcement(self, name: str) -> _Announced:
        try:
            content = read_content(self._announcement_file(name), _LARGEST_RECORD_BYTES, CaseError)
            return value_of(json_of(content), _Announced)
        except (CaseError, Mismatch, ValueError):
            return _Announced()

    def _discard_part(self, name: str) -> None:
        self._part(name).unlink(missing_ok=True)
        self._announcement_file(name).unlink(missing_ok=True)

    def _part(self, name: str) -> Path:
        return self._records / f"{name}.part"

    def _announcement_file(self, name: str) -> Path:
        return self._records / f"{name}.announced"


_CLEANING_LOCK = threading.Lock()
_SECRET_LOCK = threading.Lock()


def _other_upload(name: str, state: str, bytes_here: int | None = None) -> CaseError:
    return CaseError("case.upload.another", name=name, state=state, bytes_here=bytes_here)


def checked_name(name: str) -> str:
    """A file name from a request, checked: no path, of a photo, video or zip.

    Raises:
        OptionsError: the name is refused.
    """
    odd = (
        not _NAME.fullmatch(name)
        or len(name.encode("utf-8", "replace")) > _LONGEST_NAME
        or printable(name, keep="") != name
        or _DEVICE_NAMES.fullmatch(name)
        or name.endswith((" ", "."))
    )
    if odd:
        raise OptionsError("case.upload.no_name", name=printable(name, keep="")[:60])
    if suffix_of(name) not in (*PICTURE_SUFFIXES, *VIDEO_SUFFIXES, *_ZIP):
        raise OptionsError("case.upload.no_photo", name=name)
    return name


def photos_in(folder: Path) -> int:
    """Number of photos received: complete, usable, of several files of one shot one."""
    received = Intake(folder, b"").received()
    return len(one_of_each(folder, received))


def one_of_each(folder: Path, received: Sequence[Received]) -> list[Received]:
    """The usable ones, of several files of one shot the one that a run uses."""
    spare = used_instead(folder, received)
    return [one for one in received if one.usable and one.name not in spare]


def used_instead(folder: Path, received: Sequence[Received]) -> dict[str, str]:
    """By name, usable files that no run uses, and the file of the same shot that it does use."""
    return files_not_used([folder / one.name for one in received if one.usable])


def is_zip(name: str) -> bool:
    return suffix_of(name) in _ZIP


def suffix_of(name: str) -> str:
    """Extension of a file name, lower case."""
    return PurePosixPath(name).suffix.lower()


def limit_of(name: str) -> int:
    """Most bytes that a file of this name may have."""
    return MOST_PHOTO_BYTES if suffix_of(name) in PICTURE_SUFFIXES else MOST_VIDEO_BYTES


def secret_of(folder: Path) -> bytes:
    """The secret of a shelf, made at the first call; only its owner can read the file."""
    file = folder / ".secret"
    with _SECRET_LOCK:
        if not file.is_file():
            with written_whole(file) as beside:
                beside.touch(mode=0o600)
                beside.write_bytes(secrets.token_bytes(32))
        return file.read_bytes()


def _require_reasonable(name: str, members: list[zipfile.ZipInfo]) -> None:
    """Refuse a zip with too many or too large files, or one that expands like a zip bomb."""
    total_bytes = sum(one.file_size for one in members)
    too_large = any(one.file_size > MOST_PHOTO_BYTES for one in members)
    if (
        len(members) > MOST_FILES
        or total_bytes > MOST_VIDEO_BYTES
        or too_large
        or any(expands_too_far(one) for one in members)
    ):
        raise OptionsError(
            "archive.too_large_sent", name=name, files=len(members), size_mb=total_bytes / 1e6
        )
