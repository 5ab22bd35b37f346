"""Lenses: which photos are cut out of larger ones, and what is said of photos of several lenses.

Photos of one camera whose sides keep their ratio are taken to be smaller copies, the same lens with
other pixels, unless what they show tells that they were cut (`lens_groups`). Those of another ratio
were cut: where the lens's middle lies in them nobody knows, nor whether they were reduced as well.
Photos whose files tell no camera are taken to be of one.
"""

from collections.abc import Iterator

from limbgram.findings import Finding, note
from limbgram.reconstruction.photos.photo import CameraGroup, PhotoSet, first_of

_ROUNDED_PX = 1.0
"""A reduced picture has whole pixels."""


def cut_from(photos: PhotoSet) -> dict[int, int]:
    """Camera groups that are cut out of others, and of which."""
    larger = _larger(photos)
    copies = _copies(photos, larger)
    cut = {k: of for k, of in larger.items() if k not in copies or photos.cameras[k].cut_out}
    return {k: _largest(photos, of) for k, of in cut.items()}


def copies_of(photos: PhotoSet) -> dict[int, int]:
    """Camera groups that are smaller copies of others by their size, and of which."""
    return _copies(photos, _larger(photos))


def _larger(photos: PhotoSet) -> dict[int, list[int]]:
    """By camera group, those of the same lens whose pictures have room for its own."""
    found = {
        number: [
            other
            for other, one in enumerate(photos.cameras)
            if same_lens(group, one) and _holds(one, group)
        ]
        for number, group in enumerate(photos.cameras)
    }
    return {number: larger for number, larger in found.items() if larger}


def _copies(photos: PhotoSet, larger: dict[int, list[int]]) -> dict[int, int]:
    alike = {
        number: [other for other in of if _is_copy(photos.cameras[number], photos.cameras[other])]
        for number, of in larger.items()
    }
    return {number: _largest(photos, of) for number, of in alike.items() if of}


def _largest(photos: PhotoSet, groups: list[int]) -> int:
    return max(groups, key=lambda one: _pixels(photos.cameras[one]))


def same_lens(one: CameraGroup, other: CameraGroup) -> bool:
    """Whether files tell nothing that differs, but for sizes."""

    def told(group: CameraGroup) -> tuple[object, ...]:
        exif = group.exif
        lens = (exif.lens, exif.focal_mm, exif.focal_35mm, exif.digital_zoom)
        return (exif.make, exif.model, exif.body, *lens)

    return told(one) == told(other)


def _holds(whole: CameraGroup, part: CameraGroup) -> bool:
    """Whether a picture of one size has room for one of another, however it is turned."""
    (long, short), (own_long, own_short) = _sides(whole), _sides(part)
    return (own_long, own_short) != (long, short) and own_long <= long and own_short <= short


def _is_copy(part: CameraGroup, whole: CameraGroup) -> bool:
    (long, short), (own_long, own_short) = _sides(whole), _sides(part)
    return abs(short * own_long / long - own_short) <= _ROUNDED_PX


def _sides(group: CameraGroup) -> tuple[int, int]:
    width, height = _file_px(group)
    return max(width, height), min(width, height)


def _pixels(group: CameraGroup) -> int:
    width, height = _file_px(group)
    return width * height


def _file_px(group: CameraGroup) -> tuple[int, int]:
    return group.file_px or (group.width_px, group.height_px)


def lens_notes(photos: PhotoSet) -> tuple[Finding, ...]:
    """That photos have a lens of their own because they were cut, or by what they show."""
    return (*_cut_notes(photos), *_told_notes(photos))


def _cut_notes(photos: PhotoSet) -> Iterator[Finding]:
    for number, whole in cut_from(photos).items():
        group, of = photos.cameras[number], photos.cameras[whole]
        names = _names(photos, number)
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


def _told_notes(photos: PhotoSet) -> Iterator[Finding]:
    for number, group in enumerate(photos.cameras):
        if group.longer is not None:
            names = _names(photos, number)
            yield note(
                "lens.told_by_photos",
                count=len(names),
                photos=len(photos.photos),
                longer=group.longer,
                **first_of(names),
            )


def _names(photos: PhotoSet, number: int) -> tuple[str, ...]:
    return tuple(one.name for one in photos.photos if one.camera_idx == number)
