"""Frames of a video as photos in a folder, with the reason for each.

FOLDER/photos/    the frames that were taken, named by video and number
FOLDER/frames.json  every frame with its verdict (limbgram-frames/1)
FOLDER/frames.png   the frames taken at a glance, upright

A frame is stored as JPEG at the highest quality, which alters brightness by less than the video's
own compression did. Its EXIF has the orientation; a video does not tell the camera.
"""

import math
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PIL import Image

from limbgram.cases.case_record import write_json
from limbgram.cases.contact_sheet import CaptionedPicture, contact_sheet
from limbgram.cases.fingerprint import code_version, file_sha256
from limbgram.cases.folder import CaseFolder
from limbgram.cases.stage_cache import CachingRun
from limbgram.core.errors import CaseError
from limbgram.core.files import json_of, require_folder, written_whole
from limbgram.core.geometry.arrays import ColourImage
from limbgram.core.run import Run
from limbgram.findings import told
from limbgram.reconstruction.photos.quality import name_for_people
from limbgram.reconstruction.photos.reading import names_apart
from limbgram.reconstruction.photos.video import (
    FrameChoice,
    FrameOptions,
    FrameVerdict,
    choose_frames,
    is_video,
    open_video,
    survey,
)

_FORMAT = "limbgram-frames/1"
_QUALITY = 98
_ORIENTATIONS = (1, 6, 3, 8)
"""EXIF orientation by number of clockwise quarter turns."""
_LARGEST_BYTES = 100_000_000
_THUMB_PX = 240
_COLUMNS = 6


@dataclass(frozen=True)
class FrameFolder:
    """A folder with the frames of a video."""

    folder: Path
    taken: int
    frames: int
    duration_s: float

    @property
    def photos(self) -> Path:
        return self.folder / "photos"

    @property
    def record(self) -> Path:
        return self.folder / "frames.json"

    @property
    def sheet(self) -> Path:
        return self.folder / "frames.png"


def with_frames(case: CaseFolder, sources: Sequence[Path], run: CachingRun) -> tuple[Path, ...]:
    """The sources, each video replaced by the folder of its frames.

    Raises:
        PhotoError: a video cannot be used.
    """
    taken: list[Path] = []
    folders = _folder_names([source for source in sources if is_video(source)])
    for source in sources:
        if source in folders:
            taken.append(take_frames(source, case.frames / folders[source], run).photos)
        else:
            taken.append(source)
    return tuple(taken)


def _folder_names(videos: Collection[Path]) -> dict[Path, str]:
    """A name for each video's folder, numbered where two are alike once cut and without ending."""
    found: dict[Path, str] = {}
    for video, called in names_apart(videos).items():
        stem, number = _stem(video.with_name(called)), 1
        name = stem
        while name.casefold() in {one.casefold() for one in found.values()}:
            number += 1
            name = f"{stem}-{number}"
        found[video] = name
    return found


def take_frames(
    video: Path, folder: Path, run: Run, options: FrameOptions | None = None
) -> FrameFolder:
    """Extract a video's frames into a folder; one that holds them already is left as it is.

    Raises:
        PhotoError: the video cannot be used.
        CaseError: the folder holds something else.
        ExportError: it cannot be made.
    """
    options = options or FrameOptions()
    film = open_video(video)
    key = {
        "video_sha256": file_sha256(video),
        "options": vars(options),
        "code": code_version("limbgram.reconstruction.photos.video"),
    }
    existing = _existing(folder, key)
    if existing is not None:
        return existing
    _require_ours(folder)
    require_folder(folder.parent)
    thumbs: list[ColourImage] = []
    stem = _stem(video)

    def keep(frame: FrameVerdict, pixels: ColourImage) -> None:
        _write_frame(beside / "photos" / _name(stem, frame), pixels, film.quarter_turns)
        thumbs.append(_thumb(pixels, film.quarter_turns))

    call = run.unkept if isinstance(run, CachingRun) else run
    with written_whole(folder) as beside:
        (beside / "photos").mkdir(parents=True)
        choice = call(choose_frames, call(survey, film), keep, options)
        record = _record(choice, stem) | {"key": key}
        write_json(beside / "frames.json", record)
        _write_sheet(beside / "frames.png", thumbs, choice)
    return _folder_of(folder, record)


def _existing(folder: Path, key: dict[str, Any]) -> FrameFolder | None:
    """The frames that lie there, if they are complete and were made with the same key."""
    record = _read_record(folder)
    if record is None or record.get("key") != key:
        return None
    names = [frame["name"] for frame in record["frames"] if frame["taken"]]
    complete = all((folder / "photos" / name).is_file() for name in names)
    return _folder_of(folder, record) if complete else None


def _read_record(folder: Path) -> dict[str, Any] | None:
    """The record in a folder of frames; None where another folder lies there, or none."""
    file = folder / "frames.json"
    if not file.is_file() or file.stat().st_size > _LARGEST_BYTES:
        return None
    try:
        record = json_of(file.read_bytes())
    except ValueError:
        return None
    return record if isinstance(record, dict) and record.get("format") == _FORMAT else None


def _require_ours(folder: Path) -> None:
    if folder.exists() and any(folder.iterdir()) and _read_record(folder) is None:
        raise CaseError("case.frames_folder_taken", folder=str(folder))


def _folder_of(folder: Path, record: dict[str, Any]) -> FrameFolder:
    taken = sum(frame["taken"] for frame in record["frames"])
    rate = record["video"]["frames_per_s"]
    count = len(record["frames"])
    return FrameFolder(folder, taken, count, count / rate if rate else math.nan)


def _record(choice: FrameChoice, stem: str) -> dict[str, Any]:
    video = choice.video
    rate = video.frames_per_s if math.isfinite(video.frames_per_s) else None
    return {
        "format": _FORMAT,
        "video": {
            "name": name_for_people(video.path),
            "width_px": video.width_px,
            "height_px": video.height_px,
            "quarter_turns": video.quarter_turns,
            "frames_per_s": rate,
        },
        "frames": [
            {
                "number": frame.number,
                "time_s": None if rate is None else round(frame.number / rate, 3),
                "way": round(frame.way, 4),
                "edge_px": round(frame.edge_px, 3) if math.isfinite(frame.edge_px) else None,
                "taken": frame.taken,
                "name": _name(stem, frame) if frame.taken else None,
                "reason": told(frame.reason),
            }
            for frame in choice.frames
        ],
    }


def _stem(video: Path) -> str:
    return re.sub(r"[^\w-]", "_", name_for_people(video.with_suffix("")))[:40]


def _name(stem: str, frame: FrameVerdict) -> str:
    return f"{stem}-{frame.number:06d}.jpg"


def _write_frame(path: Path, pixels: ColourImage, quarter_turns: int) -> None:
    exif = Image.Exif()
    exif[0x0112] = _ORIENTATIONS[quarter_turns]
    exif[0x0131] = "limbgram frames"
    Image.fromarray(pixels).save(path, "JPEG", quality=_QUALITY, subsampling=0, exif=exif)


def _thumb(pixels: np.ndarray, quarter_turns: int) -> ColourImage:
    height_px = max(1, round(pixels.shape[0] * _THUMB_PX / pixels.shape[1]))
    small = cv2.resize(pixels, (_THUMB_PX, height_px), interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(np.rot90(small, -quarter_turns))


def _write_sheet(path: Path, thumbs: Sequence[ColourImage], choice: FrameChoice) -> None:
    """The frames taken in their order, with number, time and width of the edges."""
    if not thumbs:
        return
    rate = choice.video.frames_per_s
    pictures: list[CaptionedPicture] = []
    for frame, thumb in zip(choice.taken, thumbs):
        seconds = "" if math.isnan(rate) else f" {frame.number / rate:.1f}s"
        caption = f"{frame.number}{seconds} {frame.edge_px:.1f}px"
        pictures.append(CaptionedPicture(caption, thumb))
    Image.fromarray(contact_sheet(pictures, _COLUMNS)).save(path, "PNG")
