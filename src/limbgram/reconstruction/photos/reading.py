"""Reading: files and folders to a PhotoSet.

In      files and folders; hidden files and sub-folders of a folder are left alone.
Out     a PhotoSet: photos sorted by name, their cameras, and what was set aside and why. Photos of
        one camera, lens, focal length, zoom and size share one calibration: each of a phone's
        lenses is a camera, and however it is held it stays the same one.
Method  Every picture is decoded once, because only that shows a cut-off file. Callers can use the
        steps separately: `candidates_in` lists what can be a photo and its name, `read_photo` reads
        one file, `photo_set` puts all together.
        Photos are identified by name afterwards. Where two folders hold photos of one name, as
        cameras with the same numbering write them, names begin with the folder's:
        100APPLE_IMG_0001.JPG. Of several files of one shot one is used (`shots`).
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
    bit_depth,
    decoding_fault,
    decoding_mb,
    has_16_bits,
    in_flight_mb,
    load_colour,
    load_luma,
    luma_of,
    open_picture,
    read_exif,
)
from limbgram.reconstruction.photos.masks import (
    checked_mask,
    find_mask,
    load_mask,
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
from limbgram.reconstruction.photos.quality import assessed, files_by_kind, name_for_people
from limbgram.reconstruction.photos.raw import HAS_RAW, NO_RAW, RAW_SUFFIXES
from limbgram.reconstruction.photos.shots import one_of_each_shot


def grouped_by_camera(photos: Sequence[Photo], set_aside: tuple[SetAside, ...]) -> PhotoSet:
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
                label=_camera_label(exif),
                width_px=width_px,
                height_px=height_px,
                exif=replace(exif, quarter_turns=0, mirrored=False, taken=None),
            )
    order = {key: index for index, key in enumerate(groups)}
    return PhotoSet(
        photos=tuple(replace(p, camera_idx=order[key]) for p, key in zip(photos, keys)),
        cameras=tuple(groups.values()),
        set_aside=set_aside,
    )


def _camera_label(exif: Exif) -> str:
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
    "names_apart",
    "photo_set",
    "read_photo",
    "read_photos",
    "with_masks_in",
]

_SMALLEST_SIDE_PX = 64
_MOST_PX_PER_BYTE = 1000
"""An empty picture packs about 1,000 pixels into a byte as PNG (deflate's limit) and 350 as JPEG;
photos pack 2 to 20. A damaged TIFF of 14 kB that claimed 57 megapixels was decoded, most of it
black."""
_NAMED_AT_MOST = 5
_SHARPNESS_MB = 80.0
"""Memory for measuring the sharpness of a photo."""


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
    read = read_each([one.path for one in found.photos], options)
    photos = photo_set(found, read)
    if len(photos.photos) < max(1, options.min_photos):
        raise _too_few(sources, photos, options)
    return photos


@dataclass(frozen=True)
class Candidate:
    """A file that can be a photo, and the photo's name."""

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
    parted = files_by_kind(sorted(files, key=natural_order))
    masks = masks_among(parted.pictures)
    photos = [file for file in parted.pictures if file not in masks]
    names = names_apart([*photos, *(file for file, _ in parted.faulty)])
    faulty = (SetAside(printable(names[file], keep=""), why) for file, why in parted.faulty)
    photos.sort(key=lambda file: natural_order(file.with_name(names[file])))
    return Candidates(
        tuple(Candidate(file, names[file]) for file in photos),
        (*set_aside, *faulty, *parted.others),
    )


def read_each(files: Sequence[Path], options: PhotoOptions) -> list[Photo | SetAside]:
    """`read_photo` for many files, in parallel as memory allows."""
    if not 0 < options.max_megapixels <= MEGAPIXELS_DECODER:
        raise OptionsError("photo.max_megapixels", most=MEGAPIXELS_DECODER)
    each_mb = max((_memory_mb(file, options) for file in files), default=0.0)
    return in_parallel(lambda file: read_photo(file, options), files, each_mb=each_mb)


def photo_set(candidates: Candidates, read: Sequence[Photo | SetAside]) -> PhotoSet:
    """The PhotoSet of a capture, from its candidates and what each was read as."""
    named = [
        replace(result, name=candidate.name)
        for candidate, result in zip(candidates.photos, read, strict=True)
    ]
    photos, repeated = _without_repeats(result for result in named if isinstance(result, Photo))
    photos, unused = one_of_each_shot(photos)
    photos, bad_masks = _without_bad_masks(photos)
    faulty = [result for result in named if isinstance(result, SetAside)]
    set_aside = (*candidates.set_aside, *faulty, *repeated, *unused, *bad_masks)
    return grouped_by_camera(_at_common_bit_depth(photos), set_aside)


def with_masks_in(photos: PhotoSet, folder: Path) -> PhotoSet:
    """The photos with the masks in a folder instead of those beside them.

    Raises:
        PhotoError: it is no folder.
    """
    require_masks_folder(folder)
    named = [
        replace(one, mask_path=mask_in(folder.absolute(), one.path, one.name), mask_told=True)
        for one in photos.photos
    ]
    kept, bad_masks = _without_bad_masks(named)
    again = in_parallel(_reassessed, kept, each_mb=in_flight_mb(kept) + _SHARPNESS_MB)
    return replace(photos, photos=tuple(again), set_aside=(*photos.set_aside, *bad_masks))


def _files_in(sources: Sequence[Path]) -> tuple[Collection[Path], list[SetAside]]:
    """The given files and the files in given folders, each once."""
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
    labels = _distinct_labels(shared)
    return {
        file: f"{labels[folder]}_{file.name}" if folder in shared else file.name
        for file, folder in folders.items()
    }


def _distinct_labels(folders: Collection[Path]) -> dict[Path, str]:
    """The shortest ends of the paths that differ from each other."""
    labels: dict[Path, str] = {}
    parts = {folder: folder.relative_to(folder.anchor).parts for folder in folders}
    for count in range(1, 1 + max(map(len, parts.values()), default=0)):
        labels = {folder: "_".join(own[-count:]) for folder, own in parts.items()}
        if len({label.casefold() for label in labels.values()}) == len(labels):
            break
    return labels


def natural_order(path: Path) -> tuple[list[tuple[int, int, str]], str]:
    """Sort key that puts IMG_9 before IMG_10."""
    parts = re.split(r"(\d+)", path.name)
    return [
        (0, int(part), "") if part.isdecimal() else (1, 0, part.lower()) for part in parts if part
    ], str(path)


def read_photo(path: Path, options: PhotoOptions = DEFAULTS) -> Photo | SetAside:
    """A photo, decoded once and assessed; or why the file cannot be used."""
    if path.suffix.lower() in RAW_SUFFIXES and not HAS_RAW:
        return SetAside(path.name, NO_RAW)
    try:
        return _decode_and_assess(path, options)
    except DECODING_FAULTS as error:
        return SetAside(path.name, decoding_fault(path, error))


def _memory_mb(path: Path, options: PhotoOptions) -> float:
    """Memory for one file while it is read; 0 where it is not decoded."""
    try:
        with open_picture(path) as picture:
            pixels, deep = picture.width * picture.height, has_16_bits(picture)
    except DECODING_FAULTS:
        return 0.0
    used = pixels <= options.max_megapixels * 1e6
    return decoding_mb(path, pixels, deep=deep) + _SHARPNESS_MB if used else 0.0


def _decode_and_assess(path: Path, options: PhotoOptions) -> Photo | SetAside:
    """Decode a file and assess its quality. Raises one of DECODING_FAULTS."""
    if path.stat().st_size == 0:
        return SetAside(path.name, fault("photo.file.empty"))
    with open_picture(path) as picture:
        if unfit := _why_unfit(path, picture, options):
            return SetAside(path.name, unfit)
        width_px, height_px = picture.size
        # Pixels come before EXIF, so that a fault in them shows here.
        bits = bit_depth(picture)
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
    return assessed(photo, luma, mask)


def _why_unfit(path: Path, picture: ImageFile, options: PhotoOptions) -> Finding | None:
    """Why a picture is not decoded, by its header; None where it is."""
    width_px, height_px = picture.size
    size_px, size_bytes = width_px * height_px, path.stat().st_size
    sides = {"width_px": width_px, "height_px": height_px}
    if size_px > options.max_megapixels * 1e6:
        most = options.max_megapixels
        return fault("photo.file.too_large", **sides, most_megapixels=most)
    if size_bytes * _MOST_PX_PER_BYTE < size_px:
        return fault("photo.file.lacking", **sides, size_bytes=size_bytes)
    needed_mb = decoding_mb(path, size_px, deep=has_16_bits(picture)) + _SHARPNESS_MB
    if needed_mb > budget_mb() - PROGRAM_MB:
        return fault(
            "photo.file.needs_memory",
            **sides,
            needs_gb=needed_mb / 1024,
            allowed_gb=budget_mb() / 1024,
            program_gb=PROGRAM_MB / 1024,
        )
    if min(width_px, height_px) < _SMALLEST_SIDE_PX:
        return fault("photo.file.too_small", **sides)
    return fault("photo.file.floating") if picture.mode == "F" else None


def _at_common_bit_depth(photos: Sequence[Photo]) -> list[Photo]:
    """Photos of sixteen bits a sample at one bit depth: a dark one seems to have fewer bits."""
    bits = max((photo.bits for photo in photos if photo.bits is not None), default=None)
    return [
        photo if photo.bits in (None, bits) else _reassessed(replace(photo, bits=bits))
        for photo in photos
    ]


def _reassessed(photo: Photo) -> Photo:
    return assessed(photo, load_luma(photo), load_mask(photo))


def _without_repeats(photos: Iterable[Photo]) -> tuple[list[Photo], list[SetAside]]:
    """Each picture once and each name once, because names identify photos."""
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
        if path is not None:
            found = checked_mask(path, photo.width_px, photo.height_px, photo.exif)
            if isinstance(found, Finding):
                unusable = fault("photo.mask.unusable", photo=photo.name, reason=found)
                set_aside.append(SetAside(path.name, unusable))
                photo = replace(photo, mask_path=None)
            else:
                photo = replace(photo, mask_told=found.told)
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
