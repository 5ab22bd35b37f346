"""Reading: files and folders to a PhotoSet.

In      files and folders; hidden files and sub-folders of a folder are left alone.
Out     a PhotoSet: photos sorted by name, their cameras, and what was set aside and why. Photos of
        one camera, lens, focal length, zoom and size share one calibration: each of a phone's
        lenses is a camera, and however it is held it stays the same one.
Method  Every picture is decoded once: only so a cut-off file shows itself.
Fails   PhotoError: a source does not exist, or fewer than two photos are left.
"""

import hashlib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from limbgram.core.errors import OptionsError, PhotoError
from limbgram.core.run import PROGRAM_MB, budget_mb, in_parallel
from limbgram.reconstruction.photos.decoding import (
    DECODING_FAULTS,
    MEGAPIXELS_DECODER,
    decoding_mb,
    depth_of,
    fault_for_people,
    is_deep,
    load_colour,
    load_luma,
    luma_of,
    open_picture,
    read_exif,
)
from limbgram.reconstruction.photos.masks import (
    find_mask,
    load_mask,
    mask_fault,
    mask_in,
    masks_among,
    require_masks_folder,
)
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet, SetAside
from limbgram.reconstruction.photos.quality import (
    brightest_luma,
    burnt_share,
    edge_width_px,
    name_for_people,
    sifted,
)
from limbgram.reconstruction.photos.raw import HAS_RAW, NO_RAW, RAW_SUFFIXES


def grouped(photos: Sequence[Photo], set_aside: tuple[SetAside, ...]) -> PhotoSet:
    """The photos with their cameras, numbered in the order in which the photos show them."""
    groups: dict[tuple[str | float | None, ...], CameraGroup] = {}
    keys: list[tuple[str | float | None, ...]] = []
    for photo in photos:
        exif, width_px, height_px = photo.exif, photo.width_px, photo.height_px
        lens = (exif.lens, exif.focal_mm, exif.focal_35mm, exif.digital_zoom)
        key = (exif.make, exif.model, exif.body, *lens, width_px, height_px)
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
    zoom = f"enlarged {exif.digital_zoom:g} times" if exif.digital_zoom else None
    return ", ".join(part for part in (model, exif.lens, focal, zoom) if part)


__all__ = [
    "DEFAULTS",
    "PhotoOptions",
    "load_colour",
    "load_luma",
    "load_mask",
    "masked_by",
    "read_photos",
]

_SMALLEST_SIDE_PX = 64
_MOST_PX_PER_BYTE = 1000
"""An empty picture packs about 1,000 pixels into a byte as PNG (deflate's limit) and 350 as JPEG;
photos pack 2 to 20. A damaged TIFF of 14 kB that claimed 57 megapixels was decoded, most of it
black."""
_NAMED_AT_MOST = 5
_LOOKING_MB = 80.0
"""For looking at the sharpness of a photo's middle part."""


@dataclass(frozen=True, kw_only=True)
class PhotoOptions:
    """Which files count as photos."""

    max_megapixels: float = 150.0
    """Larger pictures are set aside."""
    min_photos: int = 2
    """Fewer readable photos are refused."""


DEFAULTS = PhotoOptions()


def read_photos(sources: Sequence[Path], options: PhotoOptions = DEFAULTS) -> PhotoSet:
    """Read the photos in files and folders, and set aside what is none, by name.

    Raises:
        PhotoError: a source does not exist, or fewer than `min_photos` photos are left.
    """
    if not 0 < options.max_megapixels <= MEGAPIXELS_DECODER:
        raise OptionsError(f"max_megapixels must lie between 0 and {MEGAPIXELS_DECODER}.")
    files, set_aside = _files_in(sources)
    masks = masks_among(files)
    files = [file for file in files if file not in masks]
    each_mb = max((_reading_mb(file, options) for file in files), default=0.0)
    results = in_parallel(lambda file: _read(file, options), files, each_mb=each_mb)
    photos, repeated = _without_repeats([result for result in results if isinstance(result, Photo)])
    set_aside += [result for result in results if isinstance(result, SetAside)] + repeated
    photos = _of_one_depth(photos)
    photos, bad_masks = _without_bad_masks(photos)
    set_aside += bad_masks
    if len(photos) < max(1, options.min_photos):
        raise _too_few(sources, photos, set_aside, options)
    return grouped(photos, tuple(set_aside))


def masked_by(photos: PhotoSet, folder: Path) -> PhotoSet:
    """The photos with the masks in a folder instead of those that lie beside them.

    Raises:
        PhotoError: it is no folder.
    """
    require_masks_folder(folder)
    named = [replace(one, mask_path=mask_in(folder.absolute(), one.path)) for one in photos.photos]
    kept, bad_masks = _without_bad_masks(named)
    return replace(photos, photos=tuple(kept), set_aside=(*photos.set_aside, *bad_masks))


def _files_in(sources: Sequence[Path]) -> tuple[list[Path], list[SetAside]]:
    """Files named or lying in named folders, each once, in natural order of names."""
    files: dict[Path, None] = {}
    set_aside: list[SetAside] = []
    for source in sources:
        if source.is_dir():
            try:
                found = [entry for entry in source.iterdir() if not entry.name.startswith(".")]
            except OSError:
                set_aside.append(
                    SetAside(name_for_people(source), "no permission to read the folder")
                )
                continue
            files.update((entry, None) for entry in found)
        elif source.exists() or source.is_symlink():
            files[source] = None
        else:
            raise PhotoError(f"{source} does not exist. Check the path of the photos.")
    candidates = sifted(sorted(files, key=natural_order))
    return list(candidates.pictures), [*set_aside, *candidates.set_aside]


def natural_order(path: Path) -> tuple[list[tuple[int, int, str]], str]:
    """IMG_9 before IMG_10."""
    parts = re.split(r"(\d+)", path.name)
    return [
        (0, int(part), "") if part.isdecimal() else (1, 0, part.lower()) for part in parts if part
    ], str(path)


def _read(path: Path, options: PhotoOptions) -> Photo | SetAside:
    if path.suffix.lower() in RAW_SUFFIXES and not HAS_RAW:
        return SetAside(path.name, NO_RAW)
    try:
        return _decoded(path, options)
    except DECODING_FAULTS as fault:
        return SetAside(path.name, fault_for_people(path, fault))


def _reading_mb(path: Path, options: PhotoOptions) -> float:
    """Memory for one file while it is read; 0 where nothing of it is decoded."""
    try:
        with open_picture(path) as picture:
            pixels, deep = picture.width * picture.height, is_deep(picture)
    except DECODING_FAULTS:
        return 0.0
    used = pixels <= options.max_megapixels * 1e6
    return decoding_mb(path, pixels, deep=deep) + _LOOKING_MB if used else 0.0


def _decoded(path: Path, options: PhotoOptions) -> Photo | SetAside:
    """Raises one of DECODING_FAULTS."""
    if path.stat().st_size == 0:
        return SetAside(path.name, "the file is empty: copy it again from the camera")
    with open_picture(path) as picture:
        width_px, height_px = picture.size
        if width_px * height_px > options.max_megapixels * 1e6:
            return SetAside(
                path.name,
                f"{width_px} x {height_px} is more than {options.max_megapixels:g} megapixels",
            )
        if path.stat().st_size * _MOST_PX_PER_BYTE < width_px * height_px:
            return SetAside(
                path.name,
                f"the file is broken: {width_px} x {height_px} pixels are not in its "
                f"{path.stat().st_size:,} bytes; copy it again from the camera",
            )
        needed_mb = decoding_mb(path, width_px * height_px, deep=is_deep(picture)) + _LOOKING_MB
        if needed_mb > budget_mb() - PROGRAM_MB:
            return SetAside(
                path.name,
                f"{width_px} x {height_px} pixels take {needed_mb / 1000:.1f} GB to decode, and of "
                f"the {budget_mb() / 1000:.1f} GB of memory that may be used the program itself "
                f"takes {PROGRAM_MB / 1000:.1f}: allow more (--memory), or export smaller photos",
            )
        if min(width_px, height_px) < _SMALLEST_SIDE_PX:
            return SetAside(path.name, f"{width_px} x {height_px} is too small for a photo")
        if picture.mode == "F":
            return SetAside(path.name, "floating-point pixels: export it as JPEG")
        # Before EXIF: a fault in the pixels must show here.
        bits = depth_of(picture)
        luma = luma_of(picture, bits)
        exif = read_exif(picture)
    with path.open("rb") as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
    return Photo(
        name=path.name,
        path=path.absolute(),
        width_px=width_px,
        height_px=height_px,
        exif=exif,
        sha256=digest,
        camera_idx=0,
        mask_path=find_mask(path.absolute()),
        bits=bits,
        sharpness=edge_width_px(luma),
        burnt=burnt_share(luma),
        brightest=brightest_luma(luma),
    )


def _of_one_depth(photos: Sequence[Photo]) -> list[Photo]:
    """Deep photos alike: by itself, a dark one would be taken for one of fewer bits."""
    bits = max((photo.bits for photo in photos if photo.bits is not None), default=None)
    return [photo if photo.bits in (None, bits) else _seen_at(photo, bits) for photo in photos]


def _seen_at(photo: Photo, bits: int | None) -> Photo:
    photo = replace(photo, bits=bits)
    luma = load_luma(photo)
    return replace(
        photo,
        sharpness=edge_width_px(luma),
        burnt=burnt_share(luma),
        brightest=brightest_luma(luma),
    )


def _without_repeats(photos: Iterable[Photo]) -> tuple[list[Photo], list[SetAside]]:
    """Each picture once, and each name once, since names identify photos ever after."""
    by_digest: dict[str, Photo] = {}
    by_name: dict[str, Photo] = {}
    set_aside: list[SetAside] = []
    for photo in photos:
        if photo.sha256 in by_digest:
            original = by_digest[photo.sha256].name
            set_aside.append(SetAside(photo.name, f"the same file as {original}"))
        elif photo.name in by_name:
            other = by_name[photo.name].path
            set_aside.append(
                SetAside(photo.name, f"another photo has this name, {other}: rename one")
            )
        else:
            by_digest[photo.sha256] = by_name[photo.name] = photo
    return list(by_name.values()), set_aside


def _without_bad_masks(photos: Iterable[Photo]) -> tuple[list[Photo], list[SetAside]]:
    kept: list[Photo] = []
    set_aside: list[SetAside] = []
    for photo in photos:
        path = photo.mask_path
        fault = path and mask_fault(path, photo.width_px, photo.height_px, photo.exif)
        if path and fault:
            set_aside.append(SetAside(path.name, f"as mask of {photo.name}: {fault}"))
            photo = replace(photo, mask_path=None)
        kept.append(photo)
    return kept, set_aside


def _too_few(
    sources: Sequence[Path],
    photos: Sequence[Photo],
    set_aside: Sequence[SetAside],
    options: PhotoOptions,
) -> PhotoError:
    where = ", ".join(str(source) for source in sources[:_NAMED_AT_MOST]) or "nothing given"
    reasons = "".join(f"\n  {part.name}: {part.reason}" for part in set_aside[:_NAMED_AT_MOST])
    more = len(set_aside) - _NAMED_AT_MOST
    return PhotoError(
        f"Photos that can be read in {where}: {len(photos)}; {options.min_photos} are needed at "
        "least. Name a folder with photos as JPEG, PNG or TIFF; its sub-folders are not searched."
        + (f" Set aside:{reasons}" if reasons else "")
        + (f"\n  and {more} more" if more > 0 else "")
    )
