"""Memory: how many captures run at a time within the allowed memory.

In      the photos of a capture; the memory that all captures may use together.
Out     an upper estimate of its memory; a gate that lets it begin once there is room.
Method  Peaks of whole runs were measured on captures of 14 to 66 photos of 0.2 to 15 megapixels;
        the sum below lies above each of them (`docs/library/batch.md`). A capture that alone needs
        more than the limit is let in when no other runs: its own budget limits it.
"""

import threading
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from limbgram.batch.stopping import Stopping
from limbgram.cases.folder import incoming
from limbgram.core.errors import LimbgramError
from limbgram.core.run import PROGRAM_MB
from limbgram.reconstruction.photos.decoding import DECODING_FAULTS, open_picture

_PHOTO_MB = 12.0
"""Products of one photo."""
_DEPTH_PX, _DEPTH_BYTES = 8_000_000, 76.0
"""Pixels of all depth maps together, at most, and bytes of each."""
_MEGAPIXEL_MB = 25.0
"""For each megapixel of the largest photo, while it is compared with another."""
_UNKNOWN_MB = 1500.0
"""For a video, whose frames are not chosen yet."""
_STEP_S = 0.2


@dataclass
class MemoryGate:
    """Lets captures begin while the memory of all together stays within a limit."""

    limit_mb: float
    _used_mb: float = 0.0
    _changed: threading.Condition = field(default_factory=threading.Condition)

    @contextmanager
    def hold(self, needed_mb: float, stopping: Stopping) -> Generator[None]:
        """Wait until there is room, and hold it.

        Raises:
            Cancelled: stopping was asked for meanwhile.
        """
        with self._changed:
            while self._used_mb and self._used_mb + needed_mb > self.limit_mb:
                stopping.check()
                self._changed.wait(_STEP_S)
            self._used_mb += needed_mb
        try:
            yield
        finally:
            with self._changed:
                self._used_mb -= needed_mb
                self._changed.notify_all()


def need_mb(sources: Sequence[Path]) -> float:
    """Upper estimate of a capture's resident memory, MB, whatever its surface."""
    if any(source.is_file() for source in sources):
        return _UNKNOWN_MB
    try:
        pictures, _ = incoming(sources)
    except LimbgramError:
        return PROGRAM_MB  # reading the photos will say what is wrong
    sizes_px = [_pixels(path) for path, _ in pictures]
    depth_mb = min(sum(sizes_px), _DEPTH_PX) * _DEPTH_BYTES / 2**20
    return (
        PROGRAM_MB
        + _PHOTO_MB * len(sizes_px)
        + depth_mb
        + _MEGAPIXEL_MB * max(sizes_px, default=0) / 1e6
    )


def _pixels(path: Path) -> int:
    """Pixels by the picture's header; 0 for one that cannot be read, which is set aside later."""
    try:
        with open_picture(path) as picture:
            return picture.size[0] * picture.size[1]
    except (LimbgramError, *DECODING_FAULTS):
        return 0
