"""Live checks: of captures that run while photos arrive, one at a time for each case.

A check that runs while another photo arrives goes on to its end, so that there is an answer; then
it begins again with all photos that are there. What was found in each photo is kept meanwhile, of
the case that was asked for last, so that a further photo costs little.
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
    """What a check works with."""

    sources: tuple[Path, ...]
    calibrations: tuple[Calibration, ...]
    camera_sha256: tuple[str, ...]
    """Of the files of the calibrations: what is known of the photos holds for these alone."""
    board: Board | None

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
    photos: int = 0
    """Files that the answer, or the check that runs, looked at."""
    took_s: float = 0.0
    _next: Asked | None = None
    _run: Run | None = None
    _watch: CaptureWatch | None = None
    _watched: Kit | None = None
    """What the watch was begun with."""
    _to_rest: bool = False
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def ask(self, asked: Asked) -> None:
        """Check these photos, now or after the check that runs."""
        with self._lock:
            self._next, self._to_rest = asked, False
            if self.state == "running":
                return
            self.state = "running"
        threading.Thread(target=self._work, name="check", daemon=True).start()

    def cancel(self) -> None:
        """End it; the last answer stays."""
        with self._lock:
            self._next = None
            if self._run is not None:
                self._run.cancel()

    def rest(self) -> None:
        """Let go what is kept of each photo, now or after the check that runs."""
        with self._lock:
            self._to_rest = True
            if self.state != "running":
                self._let_go()

    def _work(self) -> None:
        try:
            self._check_all()
        except BaseException:  # a fault of ours passes on, and nobody waits for it
            with self._lock:
                self.state, self.found, self.refusal = "done", None, fault("coach.own_fault")
                self._let_go()
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
                    if self._to_rest:
                        self._let_go()
                    return
                self._run = Run(listener=self._hear)
                self.photos = len(asked.sources)
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

    def _answer(self, asked: Asked, run: Run) -> CaptureCheck:
        if any(is_video(source) for source in asked.sources):
            return check_sources(asked.sources, asked.calibrations, asked.board, run)
        if self._watch is None or self._watched != asked.kit:
            self._let_go()
            self._watch = CaptureWatch(asked.calibrations, asked.board)
            self._watched = asked.kit
        return self._watch.check(asked.sources, run)

    def _let_go(self) -> None:
        if self._watch is not None:
            self._watch.close()
        self._watch = self._watched = None

    def _hear(self, stage: str, _done: int, _total: int) -> None:
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
        """Check a case's photos; what is kept of the photos of other cases is let go."""
        own = self.of(case)
        for other in list(self._checks.values()):
            if other is not own:
                other.rest()
        own.ask(asked)

    def drop(self, case: ShelvedCase) -> None:
        """Forget what is known of a case."""
        coach = self._checks.pop(case.case_id, None)
        if coach is not None:
            coach.cancel()
            coach.rest()

    def close(self) -> None:
        for coach in self._checks.values():
            coach.cancel()
            coach.rest()
