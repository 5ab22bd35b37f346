"""Live checks: checks of captures while photos arrive, one at a time for each case.

A check goes on to its end when another photo arrives, so that there is an answer; then it runs
again with all photos. What was found in each photo is kept for the case that was checked last, so
that another photo costs little.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from limbgram.capture.answer import CaptureCheck
from limbgram.cases.capture_check import CaptureWatch, check_sources
from limbgram.cases.shelf import ShelvedCase
from limbgram.core.errors import Cancelled, LimbgramError, disk_finding
from limbgram.core.run import Run
from limbgram.findings import Finding, fault
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.photos.video import is_video
from limbgram.reconstruction.targets.board import Board

CheckState = Literal["none", "running", "done", "refused"]


@dataclass(frozen=True, kw_only=True)
class Asked:
    """The inputs of a check."""

    sources: tuple[Path, ...]
    calibrations: tuple[Calibration, ...]
    camera_sha256: tuple[str, ...]
    """Of the calibrations' files: what was found in the photos is valid for these alone."""
    board: Board | None
    seen: frozenset[tuple[str, str]] = frozenset()
    """Name and hash of each photo that was sent."""
    photos: int = 0
    """That there are, of several files of one shot one."""

    @property
    def kit(self) -> "Kit":
        return self.camera_sha256, self.board


Kit = tuple[tuple[str, ...], Board | None]


@dataclass
class LiveCheck:
    """The check of one case."""

    on_change: Callable[[], None]
    state: CheckState = "none"
    found: CaptureCheck | None = None
    refusal: Finding | None = None
    """Why there is no answer."""
    stage: str = ""
    took_s: float = 0.0
    _next: Asked | None = None
    _asked: Asked | None = None
    """What the running check covers."""
    _answered: Asked | None = None
    """What the answer covers."""
    _run: Run | None = None
    _watch: CaptureWatch | None = None
    _watched: Kit | None = None
    """Cameras and board of the watch."""
    _release_after_check: bool = False
    _lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def photos(self) -> int:
        """That the running check, or else the answer, covers."""
        asked = self._asked if self.state == "running" else self._answered
        return 0 if asked is None else asked.photos

    def covers(self, seen: frozenset[tuple[str, str]]) -> bool:
        """Whether these photos, and no others, are what the answer is about."""
        return self._answered is not None and self._answered.seen == seen

    def ask(self, asked: Asked) -> None:
        """Check these photos, now or after the check that runs."""
        with self._lock:
            self._next, self._release_after_check = asked, False
            if self.state == "running":
                return
            self.state, self._asked = "running", asked
        threading.Thread(target=self._work, name="check", daemon=True).start()

    def cancel(self) -> None:
        """End it; the last answer stays."""
        with self._lock:
            self._next = None
            if self._run is not None:
                self._run.cancel()

    def release(self) -> None:
        """Release what is kept of each photo, now or after the running check."""
        with self._lock:
            self._release_after_check = True
            if self.state != "running":
                self._close_watch()

    def _work(self) -> None:
        try:
            self._check_all()
        except BaseException:  # a bug: it passes on, after the state tells clients
            with self._lock:
                self.state, self.found, self.refusal = "done", None, fault("coach.own_fault")
                self._answered = self._asked
                self._close_watch()
            raise
        finally:
            self.on_change()

    def _check_all(self) -> None:
        while True:
            with self._lock:
                asked, self._next = self._next, None
                if asked is None:
                    ended = "none" if self.found is None and not self.refusal else self.state
                    self.state = "done" if ended == "running" else ended
                    if self._release_after_check:
                        self._close_watch()
                    return
                self._run = Run(listener=self._on_progress)
                self._asked = asked
                self.state = "running"
            self._check(asked, self._run)
            self.on_change()

    def _check(self, asked: Asked, run: Run) -> None:
        began = time.monotonic()
        try:
            self.found = self._answer(asked, run)
            self.refusal = None
        except Cancelled:
            return
        except LimbgramError as error:
            self.found, self.refusal = None, error.finding
        except OSError as error:
            self.found, self.refusal = None, disk_finding(error)
        self.took_s = time.monotonic() - began
        self._answered = asked

    def _answer(self, asked: Asked, run: Run) -> CaptureCheck:
        if any(is_video(source) for source in asked.sources):
            return check_sources(asked.sources, asked.calibrations, asked.board, run)
        if self._watch is None or self._watched != asked.kit:
            self._close_watch()
            self._watch = CaptureWatch(asked.calibrations, asked.board)
            self._watched = asked.kit
        return self._watch.check(asked.sources, run)

    def _close_watch(self) -> None:
        if self._watch is not None:
            self._watch.close()
        self._watch = self._watched = None

    def _on_progress(self, stage: str, _done: int, _total: int) -> None:
        if stage != self.stage:
            self.stage = stage
            self.on_change()


@dataclass
class LiveChecks:
    """The checks of all cases."""

    on_change: Callable[[str], None]
    _checks: dict[str, LiveCheck] = field(default_factory=dict[str, LiveCheck])

    def of(self, case: ShelvedCase) -> LiveCheck:
        case_id = case.case_id
        return self._checks.setdefault(case_id, LiveCheck(lambda: self.on_change(case_id)))

    def ask(self, case: ShelvedCase, asked: Asked) -> None:
        """Check a case's photos; what is kept of other cases' photos is released."""
        own = self.of(case)
        for other in list(self._checks.values()):
            if other is not own:
                other.release()
        own.ask(asked)

    def drop(self, case: ShelvedCase) -> None:
        """Remove the check of a case."""
        coach = self._checks.pop(case.case_id, None)
        if coach is not None:
            coach.cancel()
            coach.release()

    def close(self) -> None:
        for coach in self._checks.values():
            coach.cancel()
            coach.release()
