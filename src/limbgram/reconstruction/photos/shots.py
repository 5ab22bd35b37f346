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

from limbgram.findings import note
from limbgram.reconstruction.photos.photo import Photo, SetAside
from limbgram.reconstruction.photos.quality import PICTURE_SUFFIXES

_NUMBER = re.compile(r"\d*$")


def one_of_each_shot(photos: Sequence[Photo]) -> tuple[list[Photo], list[SetAside]]:
    """The photos, one of each shot, and the files of the same shots that are not used."""
    by_number: dict[str, list[list[Photo]]] = defaultdict(list)
    for photo in photos:
        alike = by_number[_number(photo) or _stem(photo)]
        shot = next((one for one in alike if all(_of_one_shot(photo, two) for two in one)), None)
        if shot is None:
            alike.append([photo])
        else:
            shot.append(photo)
    kinds = Counter(map(_kind, photos))

    def preference(photo: Photo) -> tuple[int, int, int]:
        kind = _kind(photo)
        nearness = PICTURE_SUFFIXES.index(kind) if kind in PICTURE_SUFFIXES else -1
        return kinds[kind], photo.width_px * photo.height_px, nearness

    used: dict[str, str] = {}
    for shot in (one for alike in by_number.values() for one in alike):
        best = max(shot, key=preference)
        used |= {photo.name: best.name for photo in shot if photo is not best}
    kept = [photo for photo in photos if photo.name not in used]
    return kept, [SetAside(name, note("photo.same_shot", used=by)) for name, by in used.items()]


def _of_one_shot(one: Photo, other: Photo) -> bool:
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


def _kind(photo: Photo) -> str:
    return photo.path.suffix.lower()


def _stem(photo: Photo) -> str:
    return photo.path.stem.casefold()


def _number(photo: Photo) -> str:
    """The number that the camera gave; empty where the name ends with none."""
    found = _NUMBER.search(photo.path.stem)
    return "" if found is None else found[0]
