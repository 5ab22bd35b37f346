"""Checking a capture where its photos lie: small copies are made, used and removed."""

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from limbgram.capture.coach import DEFAULTS, CaptureCheck, CheckOptions, check_capture
from limbgram.cases.frames import take_frames
from limbgram.core.run import Run, in_parallel
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.photo import Photo, PhotoSet
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.photos.video import is_video
from limbgram.reconstruction.targets.board import Board

_SMALL_MEGAPIXELS = 1.5


def check_sources(
    sources: Sequence[Path],
    calibrations: Sequence[Calibration],
    board: Board | None,
    run: Run,
    options: CheckOptions = DEFAULTS,
) -> CaptureCheck:
    """Check photos, folders of them, or the frames of a video.

    Raises:
        PhotoError: a source does not exist, or no photos are readable.
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
        small = run(reduce_photos, photos, folder)
        return check_capture(photos, small, calibrations, board, options, run)


def reduce_photos(photos: PhotoSet, folder: Path) -> PhotoSet:
    """Small copies, in shades of grey, with the pixel centres kept."""
    factors = [
        min(1.0, (_SMALL_MEGAPIXELS * 1e6 / (one.width_px * one.height_px)) ** 0.5)
        for one in photos.cameras
    ]

    def side(pixels: int, factor: float) -> int:
        return max(1, round(pixels * factor))

    def reduce_one(number: int) -> Photo:
        photo = photos.photos[number]
        factor = factors[photo.camera_idx]
        width, height = side(photo.width_px, factor), side(photo.height_px, factor)
        place = folder / f"{number:05d}.png"
        luma = cv2.resize(load_luma(photo), (width, height), interpolation=cv2.INTER_AREA)
        written = cv2.imencode(".png", np.asarray(luma), (cv2.IMWRITE_PNG_COMPRESSION, 1))[1]
        place.write_bytes(written.tobytes())
        return replace(
            photo, path=place, width_px=width, height_px=height, mask_path=None, bits=None
        )

    each_mb = in_flight_mb(photos.photos, 2.0)
    reduced = in_parallel(reduce_one, range(len(photos.photos)), each_mb=each_mb)
    cameras = tuple(
        replace(one, width_px=side(one.width_px, f), height_px=side(one.height_px, f))
        for one, f in zip(photos.cameras, factors)
    )
    return replace(photos, photos=tuple(reduced), cameras=cameras)
