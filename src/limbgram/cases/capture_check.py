"""Capture check: checks photos where they lie, on temporary reduced copies.

A CaptureWatch keeps the copies, and what was found in each photo, while photos arrive: another
photo costs the work on that photo, and the placing of all.
"""

import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Self

import cv2
import numpy as np

from limbgram.capture.answer import CaptureCheck
from limbgram.capture.coach import Coach, check_capture
from limbgram.cases.video_frames import take_frames
from limbgram.core.errors import PhotoError
from limbgram.core.run import Run, in_parallel
from limbgram.formats.camera import read_camera
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.masks import (
    find_mask,
    load_mask,
    mask_as_png,
    no_mask_fits,
    require_masks_folder,
)
from limbgram.reconstruction.photos.photo import (
    CameraGroup,
    Photo,
    PhotoSet,
    SetAside,
    left_out,
)
from limbgram.reconstruction.photos.reading import (
    PhotoOptions,
    candidates_in,
    natural_order,
    photo_set,
    read_each,
    read_photos,
    with_masks_in,
)
from limbgram.reconstruction.photos.video import is_video
from limbgram.reconstruction.targets.board import Board
from limbgram.services.parse_capture import DEFAULT_BOARD, parse_board
from limbgram.services.reconstruct import NO_BOARD

_SMALL_MEGAPIXELS = 1.5
_FEWEST = 2
"""Photos that a check needs."""


@dataclass(frozen=True, kw_only=True)
class CheckRequest:
    """With what photos are checked."""

    camera: tuple[Path, ...] = ()
    """Camera file of `limbgram calibrate`."""
    board: str | None = None
    """Scale board in the scene, or the board file of `limbgram print`; without it
    charuco:7x5:30:22:4X4_50."""
    masks: Path | None = None
    """Folder of masks, NAME.png for each photo NAME: white is used, black is not. Without it
    NAME.png beside the photos, or in a folder `masks` there."""

    def calibrations(self) -> tuple[Calibration, ...]:
        """What the camera files hold."""
        return tuple(read_camera(file) for file in self.camera)

    def scale_board(self) -> Board | None:
        """The board that is looked for.

        Raises:
            OptionsError: the words are none.
        """
        return None if self.board == NO_BOARD else parse_board(self.board or DEFAULT_BOARD)


def check_sources(
    sources: Sequence[Path],
    calibrations: Sequence[Calibration],
    board: Board | None,
    run: Run,
    masks: Path | None = None,
) -> CaptureCheck:
    """Check photos, folders of them, or the frames of a video.

    Args:
        masks: Folder of masks that take the place of those beside the photos.

    Raises:
        PhotoError: a source does not exist, no photos are readable, or no mask is any photo's.
    """
    with tempfile.TemporaryDirectory(prefix="limbgram-check-") as scratch:
        folder = Path(scratch)
        named = [
            take_frames(source, folder / f"video-{number}", run).photos
            if is_video(source)
            else source
            for number, source in enumerate(sources)
        ]
        photos = run(read_photos, named)
        if masks is not None:
            photos = _with_masks(photos, masks)
        small = run(reduce_photos, photos, folder)
        return check_capture(photos, small, calibrations, board, run)


def _with_masks(photos: PhotoSet, masks: Path) -> PhotoSet:
    """The photos with the masks of a folder.

    Raises:
        PhotoError: no picture in it is named as the mask of a photo.
    """
    masked = with_masks_in(photos, masks)
    fits = any(one.mask_path for one in masked.photos)
    if not fits and masked.set_aside == photos.set_aside:
        raise no_mask_fits(masks, photos.photos[0].path)
    return masked


_Stamp = tuple[int, int]
"""Size and time of a file, which change when it is written again."""
_PhotoStamp = tuple[_Stamp, _Stamp | None]
"""Of a photo and of the mask that lies beside it."""
_CopyKey = tuple[str, int | None, Path | None, _Stamp | None]


def _copy_key(photo: Photo) -> _CopyKey:
    """Key of all that the reduced copy of a photo depends on."""
    mask = photo.mask_path
    return photo.sha256, photo.bits, mask, mask and stamp_of(mask)


def _photo_stamp(photo: Path) -> _PhotoStamp:
    mask = find_mask(photo)
    return stamp_of(photo), mask and stamp_of(mask)


class CaptureWatch:
    """Checks a capture while photos arrive; leaving its `with` removes its temporary files."""

    def __init__(
        self,
        calibrations: Sequence[Calibration],
        board: Board | None,
        masks: Path | None = None,
    ) -> None:
        if masks is not None:
            require_masks_folder(masks)
        self._masks = masks
        self._coach = Coach(calibrations, board)
        self._scratch = tempfile.TemporaryDirectory(prefix="limbgram-watch-")
        self._read_files: dict[Path, tuple[_PhotoStamp, Photo | SetAside]] = {}
        self._copies: dict[_CopyKey, Photo] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        self._scratch.cleanup()

    def check(self, sources: Sequence[Path], run: Run | None = None) -> CaptureCheck:
        """Check the photos that these files and folders hold now.

        Raises:
            PhotoError: a source does not exist, or fewer than two photos are readable.
        """
        run = run or Run()
        photos = self._read_again(sources, run)
        if self._masks is not None:
            photos = with_masks_in(photos, self._masks)
        if len(photos.photos) < _FEWEST:
            raise PhotoError(
                "photo.too_few_yet",
                photos=len(photos.photos),
                least=_FEWEST,
                aside=len(photos.set_aside),
                left_out=left_out(photos.set_aside),
            )
        # Before the copies are made: a mask that is painted anew meanwhile gets another copy.
        keys = [_copy_key(one) for one in photos.photos]
        fresh = {key: one for key, one in zip(keys, photos.photos) if key not in self._copies}
        if fresh:
            folder = Path(tempfile.mkdtemp(dir=self._scratch.name))
            copies = run(reduce_photos, replace(photos, photos=tuple(fresh.values())), folder)
            self._copies |= dict(zip(fresh, copies.photos))
        small = tuple(
            replace(self._copies[key], name=one.name, camera_idx=one.camera_idx)
            for key, one in zip(keys, photos.photos)
        )
        reduced = replace(photos, photos=small, cameras=_small_cameras(photos))
        return self._coach.check(photos, reduced, run)

    def _read_again(self, sources: Sequence[Path], run: Run) -> PhotoSet:
        """As `read_photos`, but only files that are new or were written again are decoded."""
        found = candidates_in(sources)
        stamps = {one.path: _photo_stamp(one.path) for one in found.photos}
        known = {file: own for file, own in self._read_files.items() if stamps.get(file) == own[0]}
        new = [file for file in stamps if file not in known]

        def read() -> list[Photo | SetAside]:
            return read_each(new, PhotoOptions())

        read.__name__ = read_photos.__name__
        looked = zip(new, run(read) if new else [])
        self._read_files = known | {file: (stamps[file], one) for file, one in looked}
        return photo_set(found, [self._read_files[one.path][1] for one in found.photos])


def require_sources(sources: Sequence[Path]) -> None:
    """Refuse a source that does not exist.

    Raises:
        PhotoError: there is one.
    """
    for source in sources:
        if not source.exists():
            raise PhotoError("photo.missing_path", source=str(source))


def stamps_of(sources: Sequence[Path]) -> dict[Path, _Stamp]:
    """The files that are in the sources now, each with its stamp."""
    found: dict[Path, _Stamp] = {}
    for source in sources:
        inside = source.is_dir()
        with suppress(FileNotFoundError):  # a file or the folder vanished during this look
            for file in sorted(source.iterdir(), key=natural_order) if inside else (source,):
                if file.is_file() and not (inside and file.name.startswith(".")):
                    found[file] = stamp_of(file)
    return found


def stamp_of(file: Path) -> _Stamp:
    about = file.stat()
    return about.st_size, about.st_mtime_ns


def reduce_photos(photos: PhotoSet, folder: Path) -> PhotoSet:
    """Reduced grey copies of photos and of their masks, pixel centres aligned."""
    cameras = _small_cameras(photos)

    def reduce_one(number: int) -> Photo:
        photo = photos.photos[number]
        width, height = cameras[photo.camera_idx].width_px, cameras[photo.camera_idx].height_px
        place = folder / f"{number:05d}.png"
        luma = cv2.resize(load_luma(photo), (width, height), interpolation=cv2.INTER_AREA)
        written = cv2.imencode(".png", np.asarray(luma), (cv2.IMWRITE_PNG_COMPRESSION, 1))[1]
        place.write_bytes(written.tobytes())
        mask_path = _reduced_mask(photo, place, (width, height))
        return replace(
            photo,
            path=place,
            width_px=width,
            height_px=height,
            mask_path=mask_path,
            cut_out=False,
            bits=None,
        )

    each_mb = in_flight_mb(photos.photos, 2.0)
    reduced = in_parallel(reduce_one, range(len(photos.photos)), each_mb=each_mb)
    return replace(photos, photos=tuple(reduced), cameras=cameras)


def _small_cameras(photos: PhotoSet) -> tuple[CameraGroup, ...]:
    """The camera groups of reduced copies; groups that become equal stay separate."""

    def small(group: CameraGroup) -> CameraGroup:
        size_px = group.width_px, group.height_px
        factor = min(1.0, (_SMALL_MEGAPIXELS * 1e6 / (size_px[0] * size_px[1])) ** 0.5)
        width_px, height_px = (max(1, round(side * factor)) for side in size_px)
        return replace(group, width_px=width_px, height_px=height_px, file_px=size_px)

    return tuple(map(small, photos.cameras))


def _reduced_mask(photo: Photo, place: Path, size: tuple[int, int]) -> Path | None:
    """Write the reduced copy of a photo's mask beside that of the photo; upright, as masks are."""
    mask = load_mask(photo)
    if mask is None:
        return None
    white = cv2.resize(mask.astype(np.uint8) * 255, size, interpolation=cv2.INTER_AREA)
    path = place.with_suffix(".mask.png")
    path.write_bytes(mask_as_png(np.asarray(white) > 0, photo.exif))
    return path
