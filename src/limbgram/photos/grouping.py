"""Grouping: photos of one camera, lens, focal length and size share one calibration."""

from collections.abc import Sequence
from dataclasses import replace

from limbgram.photos.photo import CameraGroup, Exif, Photo, PhotoSet, SetAside


def grouped(photos: Sequence[Photo], set_aside: tuple[SetAside, ...]) -> PhotoSet:
    """The photos with their cameras, numbered in the order in which the photos show them."""
    groups: dict[tuple[str | float | None, ...], CameraGroup] = {}
    keys: list[tuple[str | float | None, ...]] = []
    for photo in photos:
        exif, width_px, height_px = photo.exif, photo.width_px, photo.height_px
        key = (exif.make, exif.model, exif.lens, exif.focal_mm, width_px, height_px)
        keys.append(key)
        if key not in groups:
            groups[key] = CameraGroup(
                label=_label(exif),
                width_px=width_px,
                height_px=height_px,
                exif=replace(exif, quarter_turns=0, mirrored=False),
            )
    order = {key: index for index, key in enumerate(groups)}
    return PhotoSet(
        photos=tuple(replace(p, camera_idx=order[key]) for p, key in zip(photos, keys)),
        cameras=tuple(groups.values()),
        set_aside=set_aside,
    )


def _label(exif: Exif) -> str:
    model = exif.model or "unknown camera"
    if exif.make and not model.lower().startswith(exif.make.lower().split()[0]):
        model = f"{exif.make} {model}"
    focal = f"{exif.focal_mm:g} mm" if exif.focal_mm else None
    return ", ".join(part for part in (model, exif.lens, focal) if part)
