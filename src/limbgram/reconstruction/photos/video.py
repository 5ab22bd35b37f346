"""Video: selects frames of a walk-round video as photos.

In      a video file; how many frames are wanted.
Out     a FrameChoice: for every frame how far the picture had moved, its sharpness where that was
        measured, and why it was taken or not. The pixels of the frames taken are handed on one by
        one.
Method  The video is decoded twice, so that no more than two frames are in memory. The first pass
        measures the way, the path length of the picture's motion: corners are tracked (Lucas and
        Kanade) in reduced frames from a keyframe on, and their median shift is added up in picture
        widths; a new keyframe begins once they have moved or were lost, so that a trembling hand
        adds nothing, nor does standing still. The second pass divides the way, not time, into even
        segments, and takes the sharpest of the frames near the middle of each segment, by the
        measure of `quality`. A segment in which all are blurred gives none.
        OpenCV's own FFmpeg decodes. Only files that begin as MP4, MOV, AVI, Matroska or WebM are
        opened: lists of other files and addresses, which FFmpeg could follow, never are. Frames
        stay as the sensor stored them; the orientation that the file states is kept.
Fails   PhotoError: no such video, no frames in it, or the camera hardly moved.
"""

import math
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float32, Float64

from limbgram.core.errors import OptionsError, PhotoError
from limbgram.core.geometry.arrays import ColourImage, GreyImage
from limbgram.core.run import track
from limbgram.findings import Finding, note
from limbgram.reconstruction.photos.quality import VIDEO_SUFFIXES, edge_width_px, name_for_people

_FIRST_MP4_BOXES = (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip")
"""Kinds of the first box of an MP4 or MOV."""
_EBML = b"\x1a\x45\xdf\xa3"
_QUARTER_TURNS = {0: 0, 90: 1, 180: 2, 270: 3}

_MOST_CORNERS = 400
_CORNER_QUALITY = 0.01
_CORNER_DISTANCE = 0.015
"""Least distance of two corners, in picture widths."""
_FLOW_WINDOW_PX = (21, 21)
_PYRAMID_LEVELS = 3
_LEAST_TRACKED_SHARE = 0.5
"""Share of the corners below which a new keyframe begins."""
_KEYFRAME_SHIFT = 0.03
"""Shift, in picture widths, after which a new keyframe begins."""
_FEWEST_CORNERS = 12


_MIDDLE_SHARE = 0.6
"""Middle share of each segment from which a frame is taken."""
_LEAST_WAY = 0.15
"""Shortest way, in picture widths, of a walk-round."""
_TRACKED_WIDTH_PX = 480
"""Width of the reduced frames in which corners are tracked."""


_MOST_MEASURED = 12
"""Most frames of a segment whose sharpness is measured."""
_MAX_BLUR_RATIO = 2.0
"""Edges this many times wider than those of the frames taken so far count as blurred."""
_MIN_BLUR_PX = 1.5
"""Narrower edges never count as blurred."""


@dataclass(frozen=True, kw_only=True)
class FrameOptions:
    """How many frames, and which of them are good enough."""

    count: int = 36
    """Frames taken from the whole film: one in ten degrees of one walk round."""

    def __post_init__(self) -> None:
        if not 4 <= self.count <= 500:
            raise OptionsError("video.count", count=self.count)


DEFAULTS = FrameOptions()


@dataclass(frozen=True, kw_only=True)
class Video:
    """A video file by its header."""

    path: Path
    width_px: int
    height_px: int
    frames_per_s: float
    """NaN where the file does not state it."""
    quarter_turns: int
    """Clockwise quarter turns that show its frames upright."""
    frames_told: int
    """Frames that the file states; the true number shows when it is decoded."""


@dataclass(frozen=True, kw_only=True)
class FrameVerdict:
    """Whether one frame was taken, and why."""

    number: int
    """Counted from 0."""
    way: float
    """How far the picture had moved since the beginning, in its own widths."""
    edge_px: float
    """Width of its sharpest edges; NaN where it was not measured."""
    taken: bool
    reason: Finding


@dataclass(frozen=True, kw_only=True)
class FrameChoice:
    """Every frame of a video with its verdict."""

    video: Video
    frames: tuple[FrameVerdict, ...]

    @property
    def taken(self) -> tuple[FrameVerdict, ...]:
        return tuple(frame for frame in self.frames if frame.taken)


@dataclass(frozen=True)
class Survey:
    """The way of the picture at every frame of a video, in picture widths."""

    video: Video
    way: Float64[np.ndarray, " frames"]


def is_video(path: Path) -> bool:
    """Whether a file is named as a video."""
    return path.suffix.lower() in VIDEO_SUFFIXES


def open_video(path: Path) -> Video:
    """A video by its header, before anything is decoded.

    Raises:
        PhotoError: there is no such file, or it is no video that can be decoded.
    """
    _require_video_file(path)
    with _opened(path) as stream:
        turned = round(stream.get(cv2.CAP_PROP_ORIENTATION_META)) % 360
        rate = stream.get(cv2.CAP_PROP_FPS)
        return Video(
            path=path.absolute(),
            width_px=round(stream.get(cv2.CAP_PROP_FRAME_WIDTH)),
            height_px=round(stream.get(cv2.CAP_PROP_FRAME_HEIGHT)),
            frames_per_s=rate if math.isfinite(rate) and rate > 0 else math.nan,
            quarter_turns=_QUARTER_TURNS.get(turned, 0),
            frames_told=max(0, round(stream.get(cv2.CAP_PROP_FRAME_COUNT))),
        )


def survey(video: Video) -> Survey:
    """Measure the way of the picture through the whole video.

    Raises:
        PhotoError: the video has no frame, or its camera hardly moved.
    """
    tracker = _MotionTracker()
    ways = [
        tracker.way_to(_reduced(frame, _TRACKED_WIDTH_PX))
        for frame in track(_frames(video), video.frames_told)
    ]
    if not ways:
        raise PhotoError("video.no_frame", video=name_for_people(video.path))
    if ways[-1] < _LEAST_WAY:
        raise PhotoError(
            "video.hardly_moved", video=name_for_people(video.path), way=float(ways[-1])
        )
    return Survey(video, np.array(ways))


def choose_frames(
    found: Survey,
    keep: Callable[[FrameVerdict, ColourImage], None],
    options: FrameOptions = DEFAULTS,
) -> FrameChoice:
    """Take the sharpest frame of each segment of the way.

    Args:
        keep: Called with each frame that is taken, in order, and its red, green and blue.
    """
    way, count = found.way, min(options.count, len(found.way))
    segment_of, measured_frames = _segments(way, count)
    measured = set(measured_frames)
    verdicts: list[FrameVerdict] = []
    taken_widths_px: list[float] = []
    segment = _Segment()

    def decide_segment() -> None:
        """Take the best frame of the segment that has ended."""
        usual_px = float(np.median(taken_widths_px)) if taken_widths_px else math.inf
        limit_px = max(_MIN_BLUR_PX, _MAX_BLUR_RATIO * usual_px)
        for frame in segment.decided(limit_px):
            verdicts[frame.number] = frame
            if frame.taken and segment.pixels is not None:
                taken_widths_px.append(frame.edge_px)
                keep(frame, cv2.cvtColor(segment.pixels, cv2.COLOR_BGR2RGB))

    segment_idx = -1
    for number, frame in enumerate(track(_frames(found.video), len(way))):
        if number >= len(way):
            break
        if segment_of[number] != segment_idx:
            decide_segment()
            segment, segment_idx = _Segment(), int(segment_of[number])
        edge_px = math.nan
        if number in measured:
            edge_px = edge_width_px(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY))
            edge_px = math.inf if math.isnan(edge_px) else edge_px
        verdict = FrameVerdict(
            number=number,
            way=float(way[number]),
            edge_px=edge_px,
            taken=False,
            reason=note("video.frame.not_looked_at"),
        )
        verdicts.append(verdict)
        if number in measured:
            segment.add(verdict, frame)
    decide_segment()
    return FrameChoice(video=found.video, frames=tuple(verdicts))


@dataclass
class _Segment:
    """The measured frames of a segment of the way, and the sharpest of them."""

    frames: list[FrameVerdict] = field(default_factory=list[FrameVerdict])
    best: FrameVerdict | None = None
    pixels: ColourImage | None = None

    def add(self, frame: FrameVerdict, pixels: ColourImage) -> None:
        self.frames.append(frame)
        if self.best is None or frame.edge_px < self.best.edge_px:
            self.best, self.pixels = frame, pixels

    def decided(self, limit_px: float) -> Iterator[FrameVerdict]:
        """The frames with their reasons; the sharpest is taken unless its edges are too wide."""
        best = self.best
        for frame in self.frames:
            if best is None or frame is best:
                continue
            less_sharp = note(
                "video.frame.less_sharp",
                best=best.number,
                edge_px=frame.edge_px,
                best_edge_px=best.edge_px,
            )
            yield replace(frame, reason=less_sharp)
        if best is None:
            return
        others = len(self.frames) - 1
        if math.isinf(best.edge_px):
            reason = note("video.frame.edgeless", beside=others)
        elif best.edge_px > limit_px:
            reason = note("video.frame.blurred", beside=others)
        elif others:
            reason = note("video.frame.sharpest", frames=others + 1)
        else:
            reason = note("video.frame.only")
        taken = best.edge_px <= limit_px and not math.isinf(best.edge_px)
        yield replace(best, reason=reason, taken=taken)


def _segments(way: Float64[np.ndarray, " frames"], count: int) -> tuple[np.ndarray, list[int]]:
    """The segment of the way in which each frame lies, and the frames to be measured."""
    step = way[-1] / count
    # A frame for which the camera went back a little belongs to the segment that it had reached.
    segment_of = np.maximum.accumulate(np.minimum((way / step).astype(int), count - 1))
    measured: list[int] = []
    for segment in range(count):
        off_middle = np.abs(way / step - segment - 0.5)
        own = np.flatnonzero(segment_of == segment)
        inside = own[off_middle[own] <= 0.5 * _MIDDLE_SHARE]
        if not len(inside) and len(own):  # the camera moved fast
            inside = own[[np.argmin(off_middle[own])]]
        if len(inside) > _MOST_MEASURED:
            # Where the camera stood still many frames show the same; some of them are enough.
            chosen = np.linspace(0, len(inside) - 1, _MOST_MEASURED).round().astype(int)
            inside = inside[chosen]
        measured += inside.tolist()
    return segment_of, measured


class _MotionTracker:
    """Path length of the picture's motion, over a video of any length."""

    def __init__(self) -> None:
        self._previous: GreyImage | None = None
        self._corners_at_keyframe: Float32[np.ndarray, "n 2"] = np.zeros((0, 2), np.float32)
        self._corners: Float32[np.ndarray, "n 2"] = np.zeros((0, 2), np.float32)
        self._count_at_keyframe = 0
        self._way = 0.0
        self._shift = 0.0

    def way_to(self, frame: GreyImage) -> float:
        """The way of the picture up to this frame, the next one, in picture widths."""
        if self._previous is not None and len(self._corners) >= _FEWEST_CORNERS:
            moved, status, _ = cv2.calcOpticalFlowPyrLK(
                self._previous, frame, self._corners, self._corners.copy(), winSize=_FLOW_WINDOW_PX,
                maxLevel=_PYRAMID_LEVELS,
            )  # fmt: skip
            inside = ((moved >= 0) & (moved < frame.shape[::-1])).all(axis=1)
            kept = (status.ravel() == 1) & inside
            self._corners_at_keyframe, self._corners = self._corners_at_keyframe[kept], moved[kept]
            if len(self._corners) >= _FEWEST_CORNERS:
                shifts = np.linalg.norm(self._corners - self._corners_at_keyframe, axis=1)
                self._shift = float(np.median(shifts)) / frame.shape[1]
        self._previous = frame
        few = len(self._corners) < max(
            _FEWEST_CORNERS, _LEAST_TRACKED_SHARE * self._count_at_keyframe
        )
        if few or self._shift > _KEYFRAME_SHIFT:
            self._start_keyframe(frame)
        return self._way + self._shift

    def _start_keyframe(self, frame: GreyImage) -> None:
        self._way += self._shift
        self._shift = 0.0
        found: Any = cv2.goodFeaturesToTrack(
            frame, _MOST_CORNERS, _CORNER_QUALITY, _CORNER_DISTANCE * frame.shape[1]
        )
        corners = np.zeros((0, 2), np.float32) if found is None else found.reshape(-1, 2)
        self._corners_at_keyframe = self._corners = corners
        self._count_at_keyframe = len(corners)


def _reduced(frame: np.ndarray, width_px: int) -> GreyImage:
    height_px = max(16, round(frame.shape[0] * width_px / frame.shape[1]))
    small = cv2.resize(frame, (width_px, height_px), interpolation=cv2.INTER_AREA)
    return cv2.cvtColor(small, cv2.COLOR_BGR2GRAY)


def _require_video_file(path: Path) -> None:
    if not path.is_file():
        raise PhotoError("video.missing", video=name_for_people(path))
    with path.open("rb") as stream:
        first = stream.read(12)
    is_avi = first[:4] == b"RIFF" and first[8:] == b"AVI "
    if not (first[4:8] in _FIRST_MP4_BOXES or is_avi or first[:4] == _EBML):
        raise PhotoError("video.no_video", video=name_for_people(path))


@contextmanager
def _opened(path: Path) -> Generator[cv2.VideoCapture]:
    stream = cv2.VideoCapture(str(path.absolute()), cv2.CAP_FFMPEG)
    try:
        if not stream.isOpened():
            raise PhotoError("video.broken", video=name_for_people(path))
        stream.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        yield stream
    finally:
        stream.release()


def _frames(video: Video) -> Iterator[ColourImage]:
    """Frames as blue, green and red, in the sensor's orientation, one at a time."""
    with _opened(video.path) as stream:
        while True:
            decoded, frame = stream.read()
            if not decoded:
                return
            yield frame
