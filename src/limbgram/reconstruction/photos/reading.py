"""Reading: files and folders to a PhotoSet.

In      files and folders; hidden files and sub-folders of a folder are left alone.
Out     a PhotoSet: photos sorted by name, their cameras, and what was set aside and why. Photos of
        one camera, lens, focal length, zoom and size share one calibration: each of a phone's
        lenses is a camera, and however it is held it stays the same one.
Method  Every picture is decoded once: only so a cut-off file shows itself. The steps serve every
        door by themselves: `candidates_in` says what can be a photo and what it is called,
        `look_at` judges one file, `photo_set` what is known of all together.
        Photos are told by name ever after. Where two folders hold photos of one name, as cameras
        that count alike write them, those of both folders are called by it too:
        100APPLE_IMG_0001.JPG.
Fails   PhotoError: a source does not exist, or fewer than two photos are left.
"""

import hashlib
import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from PIL.ImageFile import ImageFile

from limbgram.core.errors import OptionsError, PhotoError, printable
from limbgram.core.run import PROGRAM_MB, budget_mb, in_parallel
from limbgram.findings import Finding, fault, note
from limbgram.reconstruction.photos.decoding import (
    DECODING_FAULTS,
    MEGAPIXELS_DECODER,
    decoding_fault,
    decoding_mb,
    depth_of,
    in_flight_mb,
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
    opacity_of,
    require_masks_folder,
)
from limbgram.reconstruction.photos.photo import (
    CameraGroup,
    Exif,
    Photo,
    PhotoSet,
    SetAside,
    left_out,
)
from limbgram.reconstruction.photos.quality import judged, name_for_people, sifted
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
    "Candidate",
    "Candidates",
    "PhotoOptions",
    "candidates_in",
    "load_colour",
    "load_luma",
    "load_mask",
    "look_at",
    "masked_by",
    "names_apart",
    "photo_set",
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
    found = candidates_in(sources)
    looked = look_at_all([one.path for one in found.photos], options)
    photos = photo_set(found, looked)
    if len(photos.photos) < max(1, options.min_photos):
        raise _too_few(sources, photos, options)
    return photos


@dataclass(frozen=True)
class Candidate:
    """A file that can be a photo, and what it is called ever after."""

    path: Path
    name: str


@dataclass(frozen=True)
class Candidates:
    """What can be photos, in the order of their names, and what cannot."""

    photos: tuple[Candidate, ...]
    set_aside: tuple[SetAside, ...]


def candidates_in(sources: Sequence[Path]) -> Candidates:
    """The files that can be photos, named or lying in named folders, each once; masks are none.

    Raises:
        PhotoError: a source does not exist.
    """
    files, set_aside = _files_in(sources)
    parted = sifted(sorted(files, key=natural_order))
    masks = masks_among(parted.pictures)
    photos = [file for file in parted.pictures if file not in masks]
    names = names_apart([*photos, *(file for file, _ in parted.faulty)])
    faulty = (SetAside(printable(names[file], keep=""), why) for file, why in parted.faulty)
    photos.sort(key=lambda file: natural_order(file.with_name(names[file])))
    return Candidates(
        tuple(Candidate(file, names[file]) for file in photos),
        (*set_aside, *faulty, *parted.others),
    )


def look_at_all(files: Sequence[Path], options: PhotoOptions) -> list[Photo | SetAside]:
    """`look_at` for many files, as memory allows."""
    if not 0 < options.max_megapixels <= MEGAPIXELS_DECODER:
        raise OptionsError("photo.max_megapixels", most=MEGAPIXELS_DECODER)
    each_mb = max((_reading_mb(file, options) for file in files), default=0.0)
    return in_parallel(lambda file: look_at(file, options), files, each_mb=each_mb)


def photo_set(candidates: Candidates, looked: Sequence[Photo | SetAside]) -> PhotoSet:
    """The photos of a capture of which each candidate was looked at."""
    named = [
        replace(one, name=candidate.name)
        for candidate, one in zip(candidates.photos, looked, strict=True)
    ]
    photos, repeated = _without_repeats(one for one in named if isinstance(one, Photo))
    photos, bad_masks = _without_bad_masks(photos)
    faulty = [one for one in named if isinstance(one, SetAside)]
    set_aside = (*candidates.set_aside, *faulty, *repeated, *bad_masks)
    return grouped(_of_one_depth(photos), set_aside)


def masked_by(photos: PhotoSet, folder: Path) -> PhotoSet:
    """The photos with the masks in a folder instead of those that lie beside them.

    Raises:
        PhotoError: it is no folder.
    """
    require_masks_folder(folder)
    named = [
        replace(one, mask_path=mask_in(folder.absolute(), one.path, one.name))
        for one in photos.photos
    ]
    kept, bad_masks = _without_bad_masks(named)
    again = in_parallel(_judged_again, kept, each_mb=in_flight_mb(kept) + _LOOKING_MB)
    return replace(photos, photos=tuple(again), set_aside=(*photos.set_aside, *bad_masks))


def _files_in(sources: Sequence[Path]) -> tuple[Collection[Path], list[SetAside]]:
    """Files named or lying in named folders, each once."""
    files: dict[Path, Path] = {}
    set_aside: list[SetAside] = []
    for source in sources:
        if source.is_dir():
            try:
                found = [entry for entry in source.iterdir() if not entry.name.startswith(".")]
            except OSError:
                forbidden = fault("photo.folder_forbidden")
                set_aside.append(SetAside(name_for_people(source), forbidden))
                continue
        elif source.exists() or source.is_symlink():
            found = [source]
        else:
            raise PhotoError("photo.missing_source", source=str(source))
        for file in found:
            files.setdefault(file.parent.resolve() / file.name, file)
    return files.values(), set_aside


def names_apart(files: Collection[Path]) -> dict[Path, str]:
    """A name for each file: its own, after that of its folder where another folder has it too.

    Endings do not tell photos apart: what lies in one case as x.jpg and x.png is photo and mask.
    """
    holding: dict[str, set[Path]] = defaultdict(set)
    folders = {file: file.parent.resolve() for file in files}
    for file, folder in folders.items():
        holding[file.stem.casefold()].add(folder)
    shared = {folder for alike in holding.values() if len(alike) > 1 for folder in alike}
    labels = _labels(shared)
    return {
        file: f"{labels[folder]}_{file.name}" if folder in shared else file.name
        for file, folder in folders.items()
    }


def _labels(folders: Collection[Path]) -> dict[Path, str]:
    """As much of the end of each path as tells it from the others."""
    labels: dict[Path, str] = {}
    parts = {folder: folder.relative_to(folder.anchor).parts for folder in folders}
    for count in range(1, 1 + max(map(len, parts.values()), default=0)):
        labels = {folder: "_".join(own[-count:]) for folder, own in parts.items()}
        if len({label.casefold() for label in labels.values()}) == len(labels):
            break
    return labels


def natural_order(path: Path) -> tuple[list[tuple[int, int, str]], str]:
    """IMG_9 before IMG_10."""
    parts = re.split(r"(\d+)", path.name)
    return [
        (0, int(part), "") if part.isdecimal() else (1, 0, part.lower()) for part in parts if part
    ], str(path)


def look_at(path: Path, options: PhotoOptions = DEFAULTS) -> Photo | SetAside:
    """A photo, decoded once as a whole and judged; or why the file is none that can be used."""
    if path.suffix.lower() in RAW_SUFFIXES and not HAS_RAW:
        return SetAside(path.name, NO_RAW)
    try:
        return _decoded(path, options)
    except DECODING_FAULTS as error:
        return SetAside(path.name, decoding_fault(path, error))


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
        return SetAside(path.name, fault("photo.file.empty"))
    with open_picture(path) as picture:
        if unfit := _unfit(path, picture, options):
            return SetAside(path.name, unfit)
        width_px, height_px = picture.size
        # Before EXIF: a fault in the pixels must show here.
        bits = depth_of(picture)
        luma = luma_of(picture, bits)
        opacity = opacity_of(picture)
        if opacity is not None and not opacity.any():
            return SetAside(path.name, fault("photo.file.transparent"))
        exif = read_exif(picture)
    with path.open("rb") as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
    photo = Photo(
        name=path.name,
        path=path.absolute(),
        width_px=width_px,
        height_px=height_px,
        exif=exif,
        sha256=digest,
        camera_idx=0,
        mask_path=find_mask(path.absolute()),
        cut_out=opacity is not None,
        bits=bits,
    )
    try:
        mask = load_mask(photo)
    except PhotoError:  # a bad mask is set aside with its reason once all files are known
        mask = None
    return judged(photo, luma, mask)


def _unfit(path: Path, picture: ImageFile, options: PhotoOptions) -> Finding | None:
    """Why a picture is not decoded, by what its file says before its pixels are read."""
    width_px, height_px = picture.size
    size_px, size_bytes = width_px * height_px, path.stat().st_size
    sides = {"width_px": width_px, "height_px": height_px}
    if size_px > options.max_megapixels * 1e6:
        most = options.max_megapixels
        return fault("photo.file.too_large", **sides, most_megapixels=most)
    if size_bytes * _MOST_PX_PER_BYTE < size_px:
        return fault("photo.file.lacking", **sides, size_bytes=size_bytes)
    needed_mb = decoding_mb(path, size_px, deep=is_deep(picture)) + _LOOKING_MB
    if needed_mb > budget_mb() - PROGRAM_MB:
        return fault(
            "photo.file.needs_memory",
            **sides,
            needs_gb=needed_mb / 1000,
            allowed_gb=budget_mb() / 1000,
            program_gb=PROGRAM_MB / 1000,
        )
    if min(width_px, height_px) < _SMALLEST_SIDE_PX:
        return fault("photo.file.too_small", **sides)
    return fault("photo.file.floating") if picture.mode == "F" else None


def _of_one_depth(photos: Sequence[Photo]) -> list[Photo]:
    """Deep photos alike: by itself, a dark one would be taken for one of fewer bits."""
    bits = max((photo.bits for photo in photos if photo.bits is not None), default=None)
    return [
        photo if photo.bits in (None, bits) else _judged_again(replace(photo, bits=bits))
        for photo in photos
    ]


def _judged_again(photo: Photo) -> Photo:
    return judged(photo, load_luma(photo), load_mask(photo))


def _without_repeats(photos: Iterable[Photo]) -> tuple[list[Photo], list[SetAside]]:
    """Each picture once, and each name once, since names identify photos ever after."""
    by_digest: dict[str, Photo] = {}
    by_name: dict[str, Photo] = {}
    set_aside: list[SetAside] = []
    for photo in photos:
        if photo.sha256 in by_digest:
            original = by_digest[photo.sha256].name
            set_aside.append(SetAside(photo.name, note("photo.repeated", original=original)))
        elif photo.name in by_name:
            other = str(by_name[photo.name].path)
            set_aside.append(SetAside(photo.name, fault("photo.same_name", other=other)))
        else:
            by_digest[photo.sha256] = by_name[photo.name] = photo
    return list(by_name.values()), set_aside


def _without_bad_masks(photos: Iterable[Photo]) -> tuple[list[Photo], list[SetAside]]:
    kept: list[Photo] = []
    set_aside: list[SetAside] = []
    for photo in photos:
        path = photo.mask_path
        reason = path and mask_fault(path, photo.width_px, photo.height_px, photo.exif)
        if path and reason:
            unusable = fault("photo.mask.unusable", photo=photo.name, reason=reason)
            set_aside.append(SetAside(path.name, unusable))
            photo = replace(photo, mask_path=None)
        kept.append(photo)
    return kept, set_aside


def _too_few(sources: Sequence[Path], photos: PhotoSet, options: PhotoOptions) -> PhotoError:
    """The refusal of sources with fewer photos than are needed."""
    return PhotoError(
        "photo.too_few",
        given=len(sources),
        sources=tuple(map(str, sources[:_NAMED_AT_MOST])),
        photos=len(photos.photos),
        least=options.min_photos,
        aside=len(photos.set_aside),
        left_out=left_out(photos.set_aside),
    )
