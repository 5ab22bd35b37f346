"""Shots: several files of one shot, as cameras and phones store it, of which one is used.

Two photos from one place tell no depth, and a raw file is a few pixels larger than its JPEG: the
shot would count twice, by two cameras.

Method  Files of one name and folder with different endings hold one shot (DCF 2.0 calls them one
        object), unless what they state of camera or time differs. Elsewhere the name proves
        nothing: there the same number, the same body and the same time do.
        Of each shot the kind of file is used that most photos of the capture are, so that all are
        of one camera; else the one with the most pixels, and then what lies nearest to the sensor:
        raw before HEIF before others.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from limbgram.findings import note
from limbgram.reconstruction.photos.decoding import DECODING_FAULTS, open_picture, read_exif
from limbgram.reconstruction.photos.photo import Exif, Photo, SetAside
from limbgram.reconstruction.photos.quality import PICTURE_SUFFIXES

_NUMBER = re.compile(r"\d*$")


@dataclass(frozen=True)
class Header:
    """What the header of a photo's file says, without decoding it."""

    name: str
    path: Path
    width_px: int
    height_px: int
    exif: Exif


def one_of_each_shot(photos: Sequence[Photo]) -> tuple[list[Photo], list[SetAside]]:
    """The photos, one of each shot, and the files of the same shots that are not used."""
    used = _used_instead(photos)
    kept = [photo for photo in photos if photo.name not in used]
    return kept, [SetAside(name, note("photo.same_shot", used=by)) for name, by in used.items()]


def files_not_used(files: Sequence[Path]) -> dict[str, str]:
    """By name, files of one folder that are not used, and the file of the same shot that is.

    Only headers are read. A file that is no photo, or that cannot be read, is a shot of its own.
    """
    pictures = [file for file in files if file.suffix.lower() in PICTURE_SUFFIXES]
    if len({file.suffix.lower() for file in pictures}) < 2:
        return {}
    headers = (_header_now(file) for file in pictures)
    return _used_instead([one for one in headers if one is not None])


def _header_now(file: Path) -> Header | None:
    try:
        status = file.stat()
    except OSError:  # deleted just now
        return None
    return _header(file, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=4096)
def _header(file: Path, _changed: int, _size: int) -> Header | None:
    """The header of a file as it is; read once, because lists of photos are asked for again."""
    try:
        with open_picture(file) as picture:
            return Header(file.name, file, *picture.size, read_exif(picture))
    except DECODING_FAULTS:
        return None


def _used_instead(photos: Sequence[Photo] | Sequence[Header]) -> dict[str, str]:
    """By name, each photo that is not used, and the one of the same shot that is."""
    by_number: dict[str, list[list[Photo | Header]]] = defaultdict(list)
    for photo in photos:
        alike = by_number[_number(photo) or _stem(photo)]
        shot = next((one for one in alike if all(_of_one_shot(photo, two) for two in one)), None)
        if shot is None:
            alike.append([photo])
        else:
            shot.append(photo)
    kinds = Counter(map(_kind, photos))

    def preference(photo: Photo | Header) -> tuple[int, int, int]:
        kind = _kind(photo)
        nearness = PICTURE_SUFFIXES.index(kind) if kind in PICTURE_SUFFIXES else -1
        return kinds[kind], photo.width_px * photo.height_px, nearness

    used: dict[str, str] = {}
    for shot in (one for alike in by_number.values() for one in alike):
        best = max(shot, key=preference)
        used |= {photo.name: best.name for photo in shot if photo is not best}
    return used


def _of_one_shot(one: Photo | Header, other: Photo | Header) -> bool:
    if _kind(one) == _kind(other):
        return False
    ours, theirs = one.exif, other.exif
    same_body, same_time = _agree(ours.body, theirs.body), _at_one_time(ours.taken, theirs.taken)
    same_model = _agree(ours.make, theirs.make), _agree(ours.model, theirs.model)
    if False in (*same_model, same_body, same_time):
        return False
    if one.path.parent == other.path.parent and _stem(one) == _stem(other):
        return True
    return bool(_number(one) and same_body and same_time)


def _agree(one: str | None, other: str | None) -> bool | None:
    """Whether two files state the same; None where one says nothing."""
    return None if one is None or other is None else one == other


def _at_one_time(one: str | None, other: str | None) -> bool | None:
    """The same of times, as far as both are told: some files leave out the fraction."""
    if one is None or other is None:
        return None
    return one.startswith(other) or other.startswith(one)


def _kind(photo: Photo | Header) -> str:
    return photo.path.suffix.lower()


def _stem(photo: Photo | Header) -> str:
    return photo.path.stem.casefold()


def _number(photo: Photo | Header) -> str:
    """The number that the camera gave; empty where the name ends with none."""
    found = _NUMBER.search(photo.path.stem)
    return "" if found is None else found[0]
