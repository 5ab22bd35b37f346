"""State: the objects that all routes share: shelf, jobs, cached shapes, change counters.

A route gets them, and the case in its path, by the annotations at the end.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Annotated

from fastapi import Depends, Path, Request

from limbgram.app.access import Access, session_in
from limbgram.app.live_checks import LiveChecks
from limbgram.app.phone_port import PhonePorts
from limbgram.app.shape_cache import ShapeCache
from limbgram.cases.cameras import Cameras
from limbgram.cases.job_queue import Runner
from limbgram.cases.overview import Overviews
from limbgram.cases.shelf import ID_PATTERN, Shelf, ShelvedCase
from limbgram.cases.uploads import Intake, secret_of
from limbgram.cases.workspace import Workspace


@dataclass
class News:
    """Counts changes of each case, by subject, for clients that listen to events."""

    _counts: dict[tuple[str, str], int] = field(default_factory=dict[tuple[str, str], int])
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def tell(self, case_id: str, subject: str) -> None:
        """Count a change of a subject: photos, check, job, work, case."""
        with self._lock:
            at = case_id, subject
            self._counts[at] = self._counts.get(at, 0) + 1

    def of(self, case_id: str) -> dict[str, int]:
        """Counts by subject."""
        with self._lock:
            return {subject: n for (case, subject), n in self._counts.items() if case == case_id}

    def of_all(self) -> dict[str, int]:
        """Counts by case."""
        with self._lock:
            found: dict[str, int] = {}
            for (case, _), count in self._counts.items():
                found[case] = found.get(case, 0) + count
            return found


@dataclass
class AppState:
    """The shared state of all routes."""

    shelf: Shelf
    access: Access
    news: News = field(default_factory=News)
    shape_cache: ShapeCache = field(default_factory=ShapeCache)
    overviews: Overviews = field(default_factory=Overviews)
    runner: Runner = field(init=False)
    live_checks: LiveChecks = field(init=False)
    phone_ports: PhonePorts = field(default_factory=PhonePorts)
    origin: Callable[[], str] = lambda: ""
    """Address of this server, for links."""
    jobs_at_once: int = 1
    sampling: threading.Lock = field(default_factory=threading.Lock)
    """Held while a sample case is made."""
    calibrating: threading.Lock = field(default_factory=threading.Lock)
    """Held while a camera is calibrated: one at a time, others wait."""
    calibrations: set[str] = field(default_factory=set[str])
    """Ids of cameras that are being calibrated, or wait for it."""
    closing: bool = False
    """Whether the server ends: open answers, such as event streams, then end by themselves."""

    def __post_init__(self) -> None:
        self.runner = Runner(
            self.shelf.root / "pace.json",
            lambda case: self.news.tell(case, "job"),
            at_once=self.jobs_at_once,
        )
        self.live_checks = LiveChecks(lambda case: self.news.tell(case, "check"))

    def open(self) -> None:
        """Open the shelf, and resume what the last end of the program interrupted."""
        self.shelf.open()
        self.runner.resume_all(case.folder for case in self.shelf.cases())
        Cameras(self.shelf.cameras).settle()

    def close(self) -> None:
        """End ports, checks and jobs; finished stages are kept."""
        self.closing = True
        self.phone_ports.close_all()
        self.live_checks.close()
        self.runner.close()

    def access_of(self, request: Request) -> Access:
        """The sessions of the port through which a request came."""
        return self.phone_ports.access_at(request.headers.get("host", "").lower()) or self.access

    def intake(self, case: ShelvedCase) -> Intake:
        return self.intake_of(case.received)

    def intake_of(self, folder: FilePath) -> Intake:
        """Where photos of a case, or of a camera's board, come in."""
        return Intake(folder, secret_of(self.shelf.root))


async def app_state_of(request: Request) -> AppState:  # async: without a thread of the pool
    app_state: AppState = request.app.state.app_state
    return app_state


AppStateHere = Annotated[AppState, Depends(app_state_of)]


async def session_of(app_state: AppStateHere, request: Request) -> str:
    access = app_state.access_of(request)
    return session_in(request.headers.get("cookie", ""), access.cookie)


SessionHere = Annotated[str, Depends(session_of)]
"""The session in the cookie of the port through which a request came; empty without one."""


def case_of(
    app_state: AppStateHere,
    case_id: Annotated[
        str, Path(pattern=ID_PATTERN, description="Id of the case, such as K7Q-4F2.")
    ],
) -> ShelvedCase:
    return app_state.shelf.case(case_id)


def other_case(app_state: AppState, request: Request, case_id: str) -> ShelvedCase:
    """A case beside that in the path, which the log then has too (`access`)."""
    case = app_state.shelf.case(case_id)
    known: tuple[str, ...] = getattr(request.state, "other_cases", ())
    request.state.other_cases = (*known, case.case_id)
    return case


CaseHere = Annotated[ShelvedCase, Depends(case_of)]


def workspace_of(case: CaseHere) -> Workspace:
    return Workspace(case)


WorkspaceHere = Annotated[Workspace, Depends(workspace_of)]
