"""Coaching: checks of captures that run while photos arrive, one at a time for each case.

A check that runs while another photo arrives goes on to its end, so that there is an answer; then
it begins again with all photos that are there.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from limbgram.capture.coach import CaptureCheck
from limbgram.cases.checking import check_sources
from limbgram.cases.shelf import ShelvedCase
from limbgram.core.errors import Cancelled, LimbgramError
from limbgram.core.run import Run
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.targets.board import Board

CheckState = Literal["none", "running", "done", "refused"]


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a check works with."""

    sources: tuple[Path, ...]
    calibrations: tuple[Calibration, ...]
    board: Board | None


@dataclass
class Coach:
    """The check of one case."""

    on_change: Callable[[], None]
    state: CheckState = "none"
    found: CaptureCheck | None = None
    message: str = ""
    stage: str = ""
    photos: int = 0
    """Files that the answer, or the check that runs, looked at."""
    took_s: float = 0.0
    _next: Asked | None = None
    _run: Run | None = None
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def ask(self, asked: Asked) -> None:
        """Check these photos, now or after the check that runs."""
        with self._lock:
            self._next = asked
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

    def _work(self) -> None:
        while True:
            with self._lock:
                asked, self._next = self._next, None
                if asked is None:
                    ended = "none" if self.found is None and not self.message else self.state
                    self.state = "done" if ended == "running" else ended
                    break
                self._run = Run(listener=self._hear)
                self.photos = len(asked.sources)
                self.state = "running"
            self._check(asked, self._run)
            self.on_change()
        self.on_change()

    def _check(self, asked: Asked, run: Run) -> None:
        began = time.monotonic()
        try:
            self.found = check_sources(asked.sources, asked.calibrations, asked.board, run)
            self.message = ""
        except Cancelled:
            return
        except LimbgramError as error:
            self.found, self.message = None, str(error)
        self.took_s = time.monotonic() - began

    def _hear(self, stage: str, _done: int, _total: int) -> None:
        if stage != self.stage:
            self.stage = stage
            self.on_change()


@dataclass
class Coaches:
    """The checks of all cases."""

    on_change: Callable[[str], None]
    _coaches: dict[str, Coach] = field(default_factory=dict[str, Coach])

    def of(self, case: ShelvedCase) -> Coach:
        case_id = case.case_id
        return self._coaches.setdefault(case_id, Coach(lambda: self.on_change(case_id)))

    def drop(self, case: ShelvedCase) -> None:
        """Forget what is known of a case."""
        coach = self._coaches.pop(case.case_id, None)
        if coach is not None:
            coach.cancel()

    def close(self) -> None:
        for coach in self._coaches.values():
            coach.cancel()
