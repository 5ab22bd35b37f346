"""Quality: which files can be photos, and how sharp and how well exposed a photo is.

In      files, or what lies in a folder (sub-folders are no candidates); a photo's brightness.
Out     the candidates and what was set aside and why; remarks on each photo; where the photos of a
        capture cannot be used together, whether they are to blame (`common_fault`), so that nobody
        looks for the cause in the board or in the paint.
Method  Candidates are recognised by their suffix or their first bytes; nothing is decoded. Of many
        files of other kinds a few are named and the rest counted.
        Sharpness is the width of the sharpest edges, which depends little on what the photo shows:
        an edge blurred by a Gaussian of width s has a steepest slope of contrast / (s sqrt(2 pi)).
        Motion blurs one direction only, so edges across it are taken: the worse of four directions
        counts. Exposure is the share of pixels at either end of the scale, of what a mask keeps;
        without one, of what stands before a burnt-out backdrop: burnt pixels that reach the
        picture's border, farther from everything else than paint on a burnt limb leaves bare.
"""

import stat
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar, cast

import cv2
import numpy as np

from limbgram.core.errors import printable
from limbgram.core.geometry.arrays import GreyImage, Mask
from limbgram.findings import Finding, Value, doubt, fault, note
from limbgram.reconstruction.photos.heif import HEIF_BRANDS, HEIF_SUFFIXES
from limbgram.reconstruction.photos.lenses import same_lens, stated_lens
from limbgram.reconstruction.photos.photo import CameraGroup, Photo, PhotoSet, SetAside
from limbgram.reconstruction.photos.raw import RAW_SUFFIXES, TIFF_MAGIC

Picture = TypeVar("Picture", bound=np.ndarray)
_FINE_PX, _COARSE_PX = 1.0, 2.5
_CENTRE_PX = 1800
"""Side of the central part in which edges are measured."""
_EDGE_SHARE = 0.05
"""Share of the pixels with a gradient in one direction, the steepest, that count as edges."""
_LEAST_SLOPE = 3.0
"""Gradient, in luma over two pixels, above noise."""
_SHARPEST_PERCENTILE = 80.0
"""So that parts out of focus before and behind the limb do not count."""
_DIRECTIONS = 4
_FEWEST_EDGES = 50
_BURNT_LUMA = 252
_BACKDROP_CELLS = 240
"""Cells along the longer side, in which backdrop and foreground are separated."""
_PAINT_GAP_CELLS = 6
"""Cells: burnt gaps between unburnt places up to twice this wide are bare ground between paint."""
_LEAST_FOREGROUND = 0.01
"""Share of a picture before a backdrop: with less, the whole picture counts as burnt."""


_MAX_BURNT = 0.3
"""Share of burnt-out pixels, of the limb where that is known: a photo with more is remarked on."""
_MIN_BRIGHTEST = 60.0
"""Photos whose brightest hundredth is darker than this luma count as underexposed."""
_FAULT_BLUR_PX = 1.8
"""Edges in most photos from which blur explains why they fail. Edges of 1.4 to 1.95 px (skull,
1.6 in the middle one), 0.8 to 1.5 (flowerpot) and below 1 (rendered) worked; a rendered
capture of 800 px blurred to 1.9 px could not be placed any more."""
_FAULT_BURNT = 0.05
"""Share of the whole picture, in most photos, from which overexposure explains why they fail: a
rendered capture had 0.08 to 0.1 when it failed, all of it on the limb. Nearly all that worked had
none, one had 0.03: where the ground between its paint was burnt, the surface was as near the truth
as elsewhere (RMS 0.049 and 0.048 mm)."""
_MAX_OTHER_CAMERA_SHARE = 0.2
"""Largest share of the capture that photos of another camera may have to be remarked on."""
_MAX_REFOCUS = 0.003
"""Change of the principal distance, by the focus distance in EXIF, that is remarked on."""
_DETECTION_MEGAPIXELS = 6.0
"""Blur is assessed at this size, at which keypoints are detected."""


_MAX_BLUR_RATIO = 2.0
"""Edges this many times wider than those of the set's middle photo count as blurred."""
_MIN_BLUR_PX = 1.5
"""Narrower edges never count as blurred."""


@dataclass(frozen=True)
class Remark:
    """What is wrong with a photo that is used all the same."""

    name: str
    finding: Finding


def remarks(photos: PhotoSet) -> tuple[Remark, ...]:
    """Photos that are blurred, too bright or too dark, compared with the rest of the set."""
    widths = np.array([photo.sharpness for photo in photos.photos])
    usual_px = float(np.nanmedian(widths)) if np.isfinite(widths).any() else float("nan")
    limit_px = max(_MIN_BLUR_PX, _MAX_BLUR_RATIO * usual_px)
    found: list[Remark] = []
    for photo in photos.photos:
        if photo.sharpness > limit_px:
            blurred = doubt("photo.blurred", edge_px=photo.sharpness, usual_px=usual_px)
            found.append(Remark(photo.name, blurred))
        if photo.burnt > _MAX_BURNT:
            found.append(Remark(photo.name, doubt("photo.overexposed", share=photo.burnt)))
        if photo.brightest < _MIN_BRIGHTEST:
            found.append(Remark(photo.name, doubt("photo.underexposed")))
        if photo.exif.mirrored:
            found.append(Remark(photo.name, doubt("photo.mirrored")))
    return (*found, *_lens_remarks(photos))


def remarks_by_photo(photos: PhotoSet) -> dict[str, list[Finding]]:
    """`remarks` by the photo's name; photos without any are left out."""
    found: dict[str, list[Finding]] = {}
    for remark in remarks(photos):
        found.setdefault(remark.name, []).append(remark.finding)
    return found


UNUSABLE_REMARKS = ("photo.blurred", "photo.overexposed", "photo.underexposed")
"""Remarks on photos that cannot be measured in."""


def _other_camera_finding(photos: PhotoSet, idx: int, most: int, others: int) -> Finding:
    """The remark on a photo of a camera that took few of the photos."""
    own, usual = photos.cameras[idx], photos.cameras[most]
    sizes: dict[str, Value] = {
        "width_px": own.width_px,
        "height_px": own.height_px,
        "usual_width_px": usual.width_px,
        "usual_height_px": usual.height_px,
        "others": others,
    }
    if own.label == usual.label and (own.height_px, own.width_px) == (
        usual.width_px,
        usual.height_px,
    ):
        return doubt("photo.turned", **sizes)
    return doubt("photo.other_lens", label=own.label, usual=usual.label, **sizes)


def _lens_remarks(photos: PhotoSet) -> Iterator[Remark]:
    """Remarks on photos whose files state another lens or zoom than nearly all, or another focus.

    Focus is compared among photos of one lens: another one is calibrated by itself.
    """
    counts = np.bincount([photo.camera_idx for photo in photos.photos])
    most = int(np.argmax(counts))
    usual = _usual_focus_m(photos)
    for photo in photos.photos:
        idx, exif = photo.camera_idx, photo.exif
        few = idx != most and counts[idx] <= _MAX_OTHER_CAMERA_SHARE * len(photos.photos)
        if few and not _only_resized(photos.cameras[idx], photos.cameras[most]):
            yield Remark(photo.name, _other_camera_finding(photos, idx, most, int(counts[most])))
        elif exif.focal_mm is not None and exif.subject_m is not None:
            # By the thin lens equation the principal distance is f D / (D - f).
            focal_m, usual_m = exif.focal_mm / 1000, usual[stated_lens(exif)]
            longer = _relative_extension(focal_m, exif.subject_m) - _relative_extension(
                focal_m, usual_m
            )
            if abs(longer) > _MAX_REFOCUS:
                refocused = doubt(
                    "photo.refocused",
                    focus_m=exif.subject_m,
                    usual_m=usual_m,
                    share=abs(longer),
                    longer=longer > 0,
                )
                yield Remark(photo.name, refocused)


def _usual_focus_m(photos: PhotoSet) -> dict[tuple[str | float | None, ...], float]:
    """By lens, the middle one of the distances at which its photos say that it was focused."""
    stated: dict[tuple[str | float | None, ...], list[float]] = {}
    for photo in photos.photos:
        if photo.exif.subject_m is not None:
            stated.setdefault(stated_lens(photo.exif), []).append(photo.exif.subject_m)
    return {lens: float(np.median(distances)) for lens, distances in stated.items()}


def _only_resized(one: CameraGroup, other: CameraGroup) -> bool:
    """Whether groups differ only by resizing or cropping, which `photos.lenses` reports."""
    sizes = [{group.width_px, group.height_px} for group in (one, other)]
    return same_lens(one, other) and sizes[0] != sizes[1]


def _relative_extension(focal_m: float, distance_m: float) -> float:
    return focal_m / max(distance_m - focal_m, focal_m)


def common_fault(photos: Sequence[Photo], *, placed: bool = False) -> Finding | None:
    """The fault of most of these photos; None where their pixels show none.

    For photos that already failed together: a fault here is no reason to refuse them.

    Args:
        placed: Their feature points gave them a place, and their figures are those of the limb:
            where no edge was measured, that says nothing, and what is burnt between paint that
            held them is bare ground, until each of most photos is remarked on by itself.
    """
    most = _MAX_BURNT if placed else _FAULT_BURNT
    burnt = [photo for photo in photos if photo.burnt > most]
    if 2 * len(burnt) > len(photos):
        share = float(np.median([photo.burnt for photo in burnt]))
        return fault("photo.most_overexposed", spoilt=len(burnt), photos=len(photos), share=share)
    dark = [photo for photo in photos if photo.brightest < _MIN_BRIGHTEST]
    if 2 * len(dark) > len(photos):
        return fault("photo.most_underexposed", spoilt=len(dark), photos=len(photos))
    widths_px = np.array([_detection_width_px(photo) for photo in photos])
    if placed:
        widths_px[np.isinf(widths_px)] = np.nan
    bare = np.isinf(widths_px)
    if 2 * bare.sum() > len(photos):
        return fault("photo.most_edgeless", spoilt=int(bare.sum()), photos=len(photos))
    blurred = widths_px > _FAULT_BLUR_PX
    if 2 * blurred.sum() > len(photos):
        return fault(
            "photo.most_blurred",
            spoilt=int(blurred.sum()),
            photos=len(photos),
            edge_px=float(np.median(widths_px[blurred])),
        )
    return None


def _detection_width_px(photo: Photo) -> float:
    """Edge width at the size at which keypoints are detected.

    Infinite where a photo was assessed and no edge was found: even a plain object has an outline.
    """
    if np.isnan(photo.sharpness) and not np.isnan(photo.brightest):
        return float("inf")
    megapixels = photo.width_px * photo.height_px / 1e6
    return photo.sharpness * min(1.0, (_DETECTION_MEGAPIXELS / megapixels) ** 0.5)


def assessed(photo: Photo, luma: GreyImage, mask: Mask | None = None) -> Photo:
    """The photo with its sharpness and exposure."""
    where = exposure_mask(luma, mask)
    return replace(
        photo,
        sharpness=edge_width_px(luma, mask),
        burnt=burnt_share(luma, where),
        brightest=brightest_luma(luma, where),
    )


def exposure_mask(luma: GreyImage, mask: Mask | None = None) -> Mask:
    """Pixels by which exposure is assessed: those of the mask, or all before a burnt backdrop."""
    if mask is not None:
        return mask
    rows, columns = luma.shape
    factor = min(1.0, _BACKDROP_CELLS / max(rows, columns))
    size = max(1, round(columns * factor)), max(1, round(rows * factor))
    not_burnt = (luma < _BURNT_LUMA).astype(np.uint8) * 255
    cells = (cv2.resize(not_burnt, size, interpolation=cv2.INTER_AREA) > 127).astype(np.uint8)
    kernel = cv2.getStructuringElement(
        cv2.MORPH_ELLIPSE, (2 * _PAINT_GAP_CELLS + 1, 2 * _PAINT_GAP_CELLS + 1)
    )
    foreground = cv2.morphologyEx(cells, cv2.MORPH_CLOSE, kernel)
    # Enclosed burnt pixels are no backdrop: a backdrop reaches the border.
    background = cv2.copyMakeBorder(1 - foreground, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=1)
    _, parts = cv2.connectedComponents(background, connectivity=4)
    backdrop = parts[1:-1, 1:-1] == parts[0, 0]
    if 1.0 - backdrop.mean() < _LEAST_FOREGROUND:
        return np.ones(luma.shape, np.bool_)
    foreground_mask = (~backdrop).astype(np.uint8)
    return cv2.resize(foreground_mask, (columns, rows), interpolation=cv2.INTER_NEAREST) > 0


def edge_width_px(luma: GreyImage, mask: Mask | None = None, where: Mask | None = None) -> float:
    """Gaussian sigma, px, of the sharpest edges in the worst of four directions.

    Slopes at two scales t and T over a blurred step compare as sqrt((s^2 + T^2) / (s^2 + t^2)).
    The outline of a mask is no edge. NaN where the photo shows no edges.

    Args:
        where: Edges elsewhere do not count: the background is out of focus, and where its edges
            are the steepest of one direction the limb would seem blurred.
    """
    centre = _central_part(luma)
    fine_x, fine_y = _gradients(centre, _FINE_PX)
    coarse_x, coarse_y = _gradients(centre, _COARSE_PX)
    coarse = np.hypot(coarse_x, coarse_y)
    seen = coarse > _LEAST_SLOPE
    if where is not None:
        seen &= _central_part(where)[::2, ::2]
    if mask is not None:
        reach_px = 2 * round(3 * _COARSE_PX) + 1
        inner = cv2.erode(
            _central_part(mask).astype(np.uint8), np.ones((reach_px, reach_px), np.uint8)
        )
        seen &= np.asarray(inner[::2, ::2]) > 0
    coarse, direction = coarse[seen], np.arctan2(coarse_y[seen], coarse_x[seen])
    ratio = np.hypot(fine_x[seen], fine_y[seen]) / coarse
    bins = np.round(direction * (_DIRECTIONS / np.pi)).astype(np.int64) % _DIRECTIONS
    widths = [
        _width_px(ratio[bins == index], coarse[bins == index]) for index in range(_DIRECTIONS)
    ]
    known = [width for width in widths if not np.isnan(width)]
    return max(known, default=float("nan"))


def burnt_share(luma: GreyImage, where: Mask) -> float:
    """Share of overexposed pixels among these; NaN without any."""
    seen = luma[::2, ::2][where[::2, ::2]]
    return float(np.mean(seen >= _BURNT_LUMA)) if seen.size else float("nan")


def brightest_luma(luma: GreyImage, where: Mask) -> float:
    """99th percentile of these pixels' luma; NaN without any."""
    seen = luma[::4, ::4][where[::4, ::4]]
    return float(np.percentile(seen, 99)) if seen.size else float("nan")


def _central_part(picture: Picture) -> Picture:
    top, left = (max(0, (side - _CENTRE_PX) // 2) for side in picture.shape)
    return cast(Picture, picture[top : top + _CENTRE_PX, left : left + _CENTRE_PX])


def _gradients(luma: GreyImage, scale_px: float) -> tuple[np.ndarray, np.ndarray]:
    """Gradients of the smoothed picture, in x and y, at every second pixel of every second row."""
    smooth = cv2.GaussianBlur(luma.astype(np.float32), (0, 0), scale_px)
    across = cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=1)[::2, ::2]
    return across, cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=1)[::2, ::2]


def _width_px(ratios: np.ndarray, slopes: np.ndarray) -> float:
    """Edge width from the slopes at two scales, at the steepest places of one direction."""
    if _EDGE_SHARE * len(ratios) < _FEWEST_EDGES:
        return float("nan")
    steepest = ratios[slopes >= np.quantile(slopes, 1 - _EDGE_SHARE)]
    squared = float(np.percentile(steepest, _SHARPEST_PERCENTILE)) ** 2
    if squared <= 1:
        return float("inf")
    return float(np.sqrt(max(0.0, (_COARSE_PX**2 - squared * _FINE_PX**2) / (squared - 1))))


VIDEO_SUFFIXES = (".mp4", ".mov", ".m4v", ".avi", ".mkv", ".webm", ".3gp")
PICTURE_SUFFIXES = (".jpg", ".jpeg", ".png", ".tif", ".tiff", *HEIF_SUFFIXES, *RAW_SUFFIXES)
"""Suffixes of files that are taken for pictures."""
_MAGIC = (
    b"\xff\xd8\xff",  # JPEG
    b"\x89PNG\r\n\x1a\n",
    *TIFF_MAGIC,  # and most raw files
    b"II+\0",  # TIFF for files beyond 4 GB
    b"MM\0+",
)
_NAMED_AT_MOST = 5


@dataclass(frozen=True)
class FilesByKind:
    """Files that can be pictures, in the order in which they were given, and the others."""

    pictures: tuple[Path, ...]
    faulty: tuple[tuple[Path, Finding], ...]
    """Files named as pictures, and why they cannot be opened."""
    others: tuple[SetAside, ...]


def files_by_kind(files: Iterable[Path]) -> FilesByKind:
    """Files sorted into those that can be pictures and those that cannot."""
    pictures: list[Path] = []
    others: list[Path] = []
    faulty: list[tuple[Path, Finding]] = []
    for file in files:
        unreadable = _file_fault(file)
        if unreadable is not None:
            faulty.append((file, unreadable))
        elif file.suffix.lower() in PICTURE_SUFFIXES or _begins_as_picture(file):
            pictures.append(file)
        elif not file.is_dir():
            others.append(file)
    return FilesByKind(tuple(pictures), tuple(faulty), tuple(_summary(others)))


def name_for_people(path: Path) -> str:
    """A file's name without control characters."""
    return printable(path.name or str(path), keep="")


def name_fault(path: Path) -> Finding | None:
    """Why a file's name cannot be used in results; None where it can."""
    if name_for_people(path) == path.name:
        return None
    return fault("photo.file.name")


def _file_fault(path: Path) -> Finding | None:
    """Why a file that is named as a picture cannot be opened; None where it may."""
    try:
        mode = path.stat().st_mode
    except PermissionError:
        return fault("photo.file.forbidden")
    except OSError:
        return fault("photo.file.nowhere")
    if stat.S_ISREG(mode):
        return name_fault(path)
    if path.suffix.lower() not in PICTURE_SUFFIXES:
        return None
    return fault("photo.file.folder") if stat.S_ISDIR(mode) else fault("photo.file.none")


def _begins_as_picture(path: Path) -> bool:
    """Whether a file begins as a picture: its suffix may be missing or wrong."""
    if not path.is_file():
        return False
    try:
        with path.open("rb") as stream:
            first = stream.read(12)
    except OSError:
        return False
    return first.startswith(_MAGIC) or (first[4:8] == b"ftyp" and first[8:] in HEIF_BRANDS)


def _no_picture(file: Path) -> Finding:
    if file.suffix.lower() in VIDEO_SUFFIXES:
        return note("photo.file.video")
    return note("photo.file.no_picture")


def _summary(others: list[Path]) -> list[SetAside]:
    if len(others) <= _NAMED_AT_MOST:
        return [SetAside(name_for_people(file), _no_picture(file)) for file in others]
    some = tuple(name_for_people(file) for file in others[:_NAMED_AT_MOST])
    said = note("photo.file.no_pictures", names=some, count=len(others))
    return [SetAside(f"{some[0]} ...", said)]
