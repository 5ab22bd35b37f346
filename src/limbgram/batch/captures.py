"""Captures: lists the captures of a folder and names the case of each.

In      the folder, patterns of what is a capture and of what is none.
Out     Captures in the order of their names: folders of photos or videos, zips, videos.
Fails   OptionsError: nothing is found, or two would become the same case.
"""

import unicodedata
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from limbgram.batch.settings import BATCH_FILE, Batch
from limbgram.core.errors import OptionsError, printable
from limbgram.reconstruction.photos.quality import files_by_kind
from limbgram.reconstruction.photos.video import is_video

CaptureKind = Literal["folder", "zip", "video"]
_ZIP = ".zip"


@dataclass(frozen=True, kw_only=True)
class Capture:
    """One capture: a folder of photos, a zip or a video."""

    name: str
    """Also the name of its case."""
    path: Path
    kind: CaptureKind


def find_captures(folder: Path, batch: Batch, cases: Path) -> tuple[Capture, ...]:
    """The captures of a folder, without hidden files and the folder of the cases.

    Raises:
        OptionsError: there is no capture, or two would become one case.
    """
    if not folder.is_dir():
        raise OptionsError("batch.no_folder", folder=str(folder))
    if cases.resolve() == folder.resolve():
        raise OptionsError(
            "batch.cases_among_captures", folder=str(folder), other=str(folder / "cases")
        )
    found = {
        path
        for pattern in batch.captures
        for path in _matching(folder, pattern)
        if not any(part.startswith(".") for part in path.relative_to(folder).parts)
        and path.resolve() != cases.resolve()
    }
    found -= {path for pattern in batch.leave_out for path in _matching(folder, pattern)}
    captures = [
        Capture(name=_name(folder, path, kind), path=path, kind=kind)
        for path in sorted(found)
        if (kind := _kind(path)) is not None
    ]
    _require_names_apart(captures)
    if not captures:
        raise OptionsError("batch.no_captures", folder=str(folder), settings=BATCH_FILE)
    return tuple(captures)


def loose_photos(folder: Path) -> int:
    """Number of photos that lie beside the captures and belong to none."""
    return len(files_by_kind(path for path in sorted(folder.iterdir()) if path.is_file()).pictures)


def sources_in(folder: Path) -> tuple[Path, ...]:
    """What to reconstruct from a folder: the folder itself, or the videos in one without photos."""
    if not folder.is_dir():
        return (folder,)  # a file; or missing, which reading it reports
    files = [path for path in sorted(folder.iterdir()) if not path.name.startswith(".")]
    videos = tuple(path for path in files if path.is_file() and is_video(path))
    return videos if videos and not files_by_kind(files).pictures else (folder,)


def _matching(folder: Path, pattern: str) -> list[Path]:
    try:
        found = list(folder.glob(pattern))
    except (ValueError, NotImplementedError) as error:
        raise OptionsError(
            "batch.no_pattern", pattern=pattern, folder=str(folder), why=str(error)
        ) from error
    root = folder.resolve()
    outside = [path for path in found if ".." in path.relative_to(folder).parts]
    if outside:
        raise OptionsError("batch.pattern_leaves_folder", pattern=pattern, folder=str(root))
    return found


def _kind(path: Path) -> CaptureKind | None:
    if path.is_dir():
        return "folder"
    if path.suffix.lower() == _ZIP:
        return "zip"
    return "video" if is_video(path) else None


def _name(folder: Path, path: Path, kind: CaptureKind) -> str:
    relative = path.relative_to(folder)
    parts = relative.parts if kind == "folder" else relative.with_suffix("").parts
    return "-".join(parts)


def _require_names_apart(captures: list[Capture]) -> None:
    seen: dict[str, Capture] = {}
    for capture in captures:
        if printable(capture.name, keep="") != capture.name:
            raise OptionsError("batch.name_not_shown", name=printable(str(capture.path), keep=""))
        key = unicodedata.normalize("NFC", capture.name).casefold()
        other = seen.setdefault(key, capture)
        if other is not capture:
            raise OptionsError(
                "batch.same_case", one=str(other.path), two=str(capture.path), case=capture.name
            )
