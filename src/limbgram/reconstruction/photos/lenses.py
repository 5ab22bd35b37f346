"""Lenses: which photos are crops of larger ones, and findings on photos of several lenses.

Photos of one camera whose sides keep their ratio are taken to be smaller copies, the same lens with
other pixels, unless what they show tells that they were cut (`lens_groups`). Those of another ratio
are crops: the place of the principal point in them is unknown, and whether they were reduced.
Photos whose files tell no camera are taken to be of one.
"""

from collections.abc import Iterator

from limbgram.findings import Finding, note
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, PhotoSet, first_of

_ROUNDED_PX = 1.0
"""A reduced picture has whole pixels."""


def cut_from(photos: PhotoSet) -> dict[int, int]:
    """Camera groups whose photos are crops, and the groups that they were cropped from."""
    larger = _larger_of_same_lens(photos)
    copies = _smaller_copies(photos, larger)
    cut = {
        k: larger_idxs
        for k, larger_idxs in larger.items()
        if k not in copies or photos.cameras[k].cut_out
    }
    return {k: _largest(photos, larger_idxs) for k, larger_idxs in cut.items()}


def copies_of(photos: PhotoSet) -> dict[int, int]:
    """Camera groups that are smaller copies of others by their size, and these others."""
    return _smaller_copies(photos, _larger_of_same_lens(photos))


def _larger_of_same_lens(photos: PhotoSet) -> dict[int, list[int]]:
    """By camera group, the groups of the same lens with larger pictures."""
    found = {
        idx: [
            other
            for other, one in enumerate(photos.cameras)
            if same_lens(group, one) and _has_room_for(one, group)
        ]
        for idx, group in enumerate(photos.cameras)
    }
    return {idx: larger for idx, larger in found.items() if larger}


def _smaller_copies(photos: PhotoSet, larger: dict[int, list[int]]) -> dict[int, int]:
    alike = {
        idx: [other for other in of if _is_copy(photos.cameras[idx], photos.cameras[other])]
        for idx, of in larger.items()
    }
    return {idx: _largest(photos, of) for idx, of in alike.items() if of}


def _largest(photos: PhotoSet, groups: list[int]) -> int:
    return max(groups, key=lambda one: _pixel_count(photos.cameras[one]))


def same_lens(one: CameraGroup, other: CameraGroup) -> bool:
    """Whether the files of two groups state the same camera and lens."""
    return stated_lens(one.exif) == stated_lens(other.exif)


def stated_lens(exif: Exif) -> tuple[str | float | None, ...]:
    """What a file states of camera, lens and zoom."""
    lens = (exif.lens, exif.focal_mm, exif.focal_35mm, exif.digital_zoom)
    return (exif.make, exif.model, exif.body, *lens)


def _has_room_for(whole: CameraGroup, part: CameraGroup) -> bool:
    """Whether a picture of one size contains one of another, in either orientation."""
    (long, short), (part_long, part_short) = _long_and_short_side(whole), _long_and_short_side(part)
    return (part_long, part_short) != (long, short) and part_long <= long and part_short <= short


def _is_copy(part: CameraGroup, whole: CameraGroup) -> bool:
    (long, short), (part_long, part_short) = _long_and_short_side(whole), _long_and_short_side(part)
    return abs(short * part_long / long - part_short) <= _ROUNDED_PX


def _long_and_short_side(group: CameraGroup) -> tuple[int, int]:
    width, height = _file_px(group)
    return max(width, height), min(width, height)


def _pixel_count(group: CameraGroup) -> int:
    width, height = _file_px(group)
    return width * height


def _file_px(group: CameraGroup) -> tuple[int, int]:
    return group.file_px or (group.width_px, group.height_px)


def lens_notes(photos: PhotoSet) -> tuple[Finding, ...]:
    """Findings on photos that got their own lens: crops, and lenses told apart by content."""
    return (*_cut_notes(photos), *_lens_notes_by_content(photos))


def _cut_notes(photos: PhotoSet) -> Iterator[Finding]:
    for idx, whole in cut_from(photos).items():
        group, of = photos.cameras[idx], photos.cameras[whole]
        names = _names(photos, idx)
        (width_px, height_px), (of_width_px, of_height_px) = _file_px(group), _file_px(of)
        yield note(
            "lens.cut_out",
            count=len(names),
            width_px=width_px,
            height_px=height_px,
            of_width_px=of_width_px,
            of_height_px=of_height_px,
            **first_of(names),
        )


def _lens_notes_by_content(photos: PhotoSet) -> Iterator[Finding]:
    for idx, group in enumerate(photos.cameras):
        if group.longer is not None:
            names = _names(photos, idx)
            yield note(
                "lens.told_by_photos",
                count=len(names),
                photos=len(photos.photos),
                longer=group.longer,
                **first_of(names),
            )


def _names(photos: PhotoSet, camera_idx: int) -> tuple[str, ...]:
    return tuple(one.name for one in photos.photos if one.camera_idx == camera_idx)
