"""Video: selects frames of a walk-round video as photos.

In      a video file; how many frames are wanted.
Out     a FrameChoice: of every frame how far the picture had moved, how sharp it is where it was
        looked at, and why it was taken or passed over. The pixels of the frames taken are handed on
        one by one.
Method  Twice through the film, so that no more than two frames are held. First the way of the
        picture: corners are followed (Lucas and Kanade) in reduced frames from a held frame on, and
        their median shift is counted in picture widths; a new frame is held once they have moved
        or were lost, so that a trembling hand adds nothing, nor does standing still. Then that way,
        not time, is parted evenly, and of the frames near the middle of each part the sharpest is
        taken, by the measure of `quality`. A part in which all are blurred is passed over.
        OpenCV's own FFmpeg decodes. Only files that begin as MP4, MOV, AVI, Matroska or WebM are
        opened: lists of other files and addresses, which FFmpeg could follow, never are. Frames
        stay as the sensor stored them; the turn that the file tells is kept for people.
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

_BOXES = (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip")
"""With one of these, after its length, an MP4 or MOV begins."""
_EBML = b"\x1a\x45\xdf\xa3"
_QUARTERS = {0: 0, 90: 1, 180: 2, 270: 3}

_CORNERS = 400
_CORNER_QUALITY = 0.01
_APART = 0.015
"""Least distance of two corners, in picture widths."""
_FOLLOW_PX = (21, 21)
_LEVELS = 3
_LOST_SHARE = 0.5
"""Once fewer of the corners are left, another frame is held."""
_HELD_SHIFT = 0.03
"""Shift, in picture widths, after which another frame is held."""
_FEWEST_CORNERS = 12


_WINDOW = 0.6
"""Share of each part's middle in which a frame is looked for."""
_LEAST_WAY = 0.15
"""Shortest way of the picture, in its widths, that is a walk."""
_FOLLOWED_PX = 480
"""Width of the reduced frames in which corners are followed."""


_LOOKED_AT = 12
"""Frames of a part that are decoded whole and measured, the middle ones."""
_MAX_BLUR_RATIO = 2.0
"""Edges this many times wider than those of the frames taken so far count as blurred."""
_MIN_BLUR_PX = 1.5
"""Narrower edges never do."""


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
    """What a video file says of itself."""

    path: Path
    width_px: int
    height_px: int
    frames_per_s: float
    """NaN where the file does not tell."""
    quarter_turns: int
    """Clockwise quarter turns that show its frames upright."""
    frames_told: int
    """Frames by the file's own word; the true number shows when it is decoded."""


@dataclass(frozen=True, kw_only=True)
class FrameVerdict:
    """What became of one frame."""

    number: int
    """Counted from 0."""
    way: float
    """How far the picture had moved since the beginning, in its own widths."""
    edge_px: float
    """Width of its sharpest edges; NaN where it was not looked at."""
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
    """What a video says of itself, before anything is decoded.

    Raises:
        PhotoError: there is no such file, or it is no video that can be decoded.
    """
    _require_video(path)
    with _opened(path) as film:
        turned = round(film.get(cv2.CAP_PROP_ORIENTATION_META)) % 360
        rate = film.get(cv2.CAP_PROP_FPS)
        return Video(
            path=path.absolute(),
            width_px=round(film.get(cv2.CAP_PROP_FRAME_WIDTH)),
            height_px=round(film.get(cv2.CAP_PROP_FRAME_HEIGHT)),
            frames_per_s=rate if math.isfinite(rate) and rate > 0 else math.nan,
            quarter_turns=_QUARTERS.get(turned, 0),
            frames_told=max(0, round(film.get(cv2.CAP_PROP_FRAME_COUNT))),
        )


def survey(video: Video) -> Survey:
    """Follow the picture through the whole film.

    Raises:
        PhotoError: the film ends before it begins, or its camera hardly moved.
    """
    follower = _Follower()
    ways = [
        follower.way_to(_reduced(frame, _FOLLOWED_PX))
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
    """Take the sharpest frame of each part of the way.

    Args:
        keep: Called with each frame that is taken, in order, and its red, green and blue.
    """
    way, count = found.way, min(options.count, len(found.way))
    part_of, middle = _parts(way, count)
    looked_at = set(middle)
    verdicts: list[FrameVerdict] = []
    widths_px: list[float] = []
    part = _FilmPart()

    def close() -> None:
        """Decide the part that has ended."""
        usual_px = float(np.median(widths_px)) if widths_px else math.inf
        limit_px = max(_MIN_BLUR_PX, _MAX_BLUR_RATIO * usual_px)
        for frame in part.decided(limit_px):
            verdicts[frame.number] = frame
            if frame.taken and part.pixels is not None:
                widths_px.append(frame.edge_px)
                keep(frame, cv2.cvtColor(part.pixels, cv2.COLOR_BGR2RGB))

    ended = -1
    for number, frame in enumerate(track(_frames(found.video), len(way))):
        if number >= len(way):
            break
        if part_of[number] != ended:
            close()
            part, ended = _FilmPart(), int(part_of[number])
        edge_px = math.nan
        if number in looked_at:
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
        if number in looked_at:
            part.look_at(verdict, frame)
    close()
    return FrameChoice(video=found.video, frames=tuple(verdicts))


@dataclass
class _FilmPart:
    """The frames of a part of the way that were looked at, and the sharpest of them."""

    looked_at: list[FrameVerdict] = field(default_factory=list[FrameVerdict])
    best: FrameVerdict | None = None
    pixels: ColourImage | None = None

    def look_at(self, frame: FrameVerdict, pixels: ColourImage) -> None:
        self.looked_at.append(frame)
        if self.best is None or frame.edge_px < self.best.edge_px:
            self.best, self.pixels = frame, pixels

    def decided(self, limit_px: float) -> Iterator[FrameVerdict]:
        """The frames with their reasons; the sharpest is taken unless its edges are too wide."""
        best = self.best
        for frame in self.looked_at:
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
        beside = len(self.looked_at) - 1
        if math.isinf(best.edge_px):
            reason = note("video.frame.edgeless", beside=beside)
        elif best.edge_px > limit_px:
            reason = note("video.frame.blurred", beside=beside)
        elif beside:
            reason = note("video.frame.sharpest", frames=beside + 1)
        else:
            reason = note("video.frame.only")
        taken = best.edge_px <= limit_px and not math.isinf(best.edge_px)
        yield replace(best, reason=reason, taken=taken)


def _parts(way: Float64[np.ndarray, " frames"], count: int) -> tuple[np.ndarray, list[int]]:
    """The part of the walk in which each frame lies, and the frames that are looked at."""
    step = way[-1] / count
    part_of = np.minimum((way / step).astype(int), count - 1)
    looked_at: list[int] = []
    for part in range(count):
        off = np.abs(way / step - part - 0.5)
        own = np.flatnonzero(part_of == part)
        inside = own[off[own] <= 0.5 * _WINDOW]
        if not len(inside) and len(own):  # the camera hurried through
            inside = own[[np.argmin(off[own])]]
        if len(inside) > _LOOKED_AT:
            # Where the walk stood still many frames show the same: some all along them will do.
            chosen = np.linspace(0, len(inside) - 1, _LOOKED_AT).round().astype(int)
            inside = inside[chosen]
        looked_at += inside.tolist()
    return part_of, looked_at


class _Follower:
    """How far the picture has moved, over a film of any length."""

    def __init__(self) -> None:
        self._before: GreyImage | None = None
        self._start: Float32[np.ndarray, "n 2"] = np.zeros((0, 2), np.float32)
        self._now: Float32[np.ndarray, "n 2"] = np.zeros((0, 2), np.float32)
        self._held_with = 0
        self._way = 0.0
        self._shift = 0.0

    def way_to(self, frame: GreyImage) -> float:
        """The way of the picture up to this frame, the next one, in picture widths."""
        if self._before is not None and len(self._now) >= _FEWEST_CORNERS:
            moved, status, _ = cv2.calcOpticalFlowPyrLK(
                self._before, frame, self._now, self._now.copy(), winSize=_FOLLOW_PX,
                maxLevel=_LEVELS,
            )  # fmt: skip
            inside = ((moved >= 0) & (moved < frame.shape[::-1])).all(axis=1)
            kept = (status.ravel() == 1) & inside
            self._start, self._now = self._start[kept], moved[kept]
            if len(self._now) >= _FEWEST_CORNERS:
                shifts = np.linalg.norm(self._now - self._start, axis=1)
                self._shift = float(np.median(shifts)) / frame.shape[1]
        self._before = frame
        few = len(self._now) < max(_FEWEST_CORNERS, _LOST_SHARE * self._held_with)
        if few or self._shift > _HELD_SHIFT:
            self._hold(frame)
        return self._way + self._shift

    def _hold(self, frame: GreyImage) -> None:
        self._way += self._shift
        self._shift = 0.0
        found: Any = cv2.goodFeaturesToTrack(
            frame, _CORNERS, _CORNER_QUALITY, _APART * frame.shape[1]
        )
        corners = np.zeros((0, 2), np.float32) if found is None else found.reshape(-1, 2)
        self._start = self._now = corners
        self._held_with = len(corners)


def _reduced(frame: np.ndarray, width_px: int) -> GreyImage:
    height_px = max(16, round(frame.shape[0] * width_px / frame.shape[1]))
    small = cv2.resize(frame, (width_px, height_px), interpolation=cv2.INTER_AREA)
    return cv2.cvtColor(small, cv2.COLOR_BGR2GRAY)


def _require_video(path: Path) -> None:
    if not path.is_file():
        raise PhotoError("video.missing", video=name_for_people(path))
    with path.open("rb") as stream:
        first = stream.read(12)
    is_avi = first[:4] == b"RIFF" and first[8:] == b"AVI "
    if not (first[4:8] in _BOXES or is_avi or first[:4] == _EBML):
        raise PhotoError("video.no_video", video=name_for_people(path))


@contextmanager
def _opened(path: Path) -> Generator[cv2.VideoCapture]:
    film = cv2.VideoCapture(str(path.absolute()), cv2.CAP_FFMPEG)
    try:
        if not film.isOpened():
            raise PhotoError("video.broken", video=name_for_people(path))
        film.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        yield film
    finally:
        film.release()


def _frames(video: Video) -> Iterator[ColourImage]:
    """Frames as blue, green and red, in the sensor's orientation, one at a time."""
    with _opened(video.path) as film:
        while True:
            there, frame = film.read()
            if not there:
                return
            yield frame
