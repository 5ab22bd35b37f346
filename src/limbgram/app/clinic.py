"""Clinic: what all routes work on: the shelf, the jobs, the shapes in memory, and the news.

A route gets it, and the case that its path names, by the annotations at the end.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Annotated

from fastapi import Depends, Path, Request

from limbgram.app.access import Access, session_in
from limbgram.app.coaching import Coaches
from limbgram.app.desk import Desk
from limbgram.app.doors import Doors
from limbgram.cases.bench import Bench
from limbgram.cases.cameras import Cameras
from limbgram.cases.intake import Intake, secret_of
from limbgram.cases.overview import Overviews
from limbgram.cases.running import Runner
from limbgram.cases.shelf import ID_PATTERN, Shelf, ShelvedCase


@dataclass
class News:
    """Counts what changed in each case, by subject, so that whoever listens asks for the rest."""

    _counts: dict[tuple[str, str], int] = field(default_factory=dict[tuple[str, str], int])
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def tell(self, case_id: str, subject: str) -> None:
        """Something of a subject changed: photos, check, job, work, case."""
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
class Clinic:
    """Everything behind the routes."""

    shelf: Shelf
    access: Access
    news: News = field(default_factory=News)
    desk: Desk = field(default_factory=Desk)
    overviews: Overviews = field(default_factory=Overviews)
    runner: Runner = field(init=False)
    coaches: Coaches = field(init=False)
    doors: Doors = field(default_factory=Doors)
    origin: Callable[[], str] = lambda: ""
    """Address of this server, for links."""
    jobs_at_once: int = 1
    sampling: threading.Lock = field(default_factory=threading.Lock)
    """Held while a sample case is made: one at a time."""
    calibrating: threading.Lock = field(default_factory=threading.Lock)
    """Held while a camera is calibrated: one at a time, others wait."""
    calibrations: set[str] = field(default_factory=set[str])
    """Cameras that are calibrated, or wait for it: their labels alone do not tell."""
    closing: bool = False
    """The server ends: answers that stay open, such as streams of events, end by themselves."""

    def __post_init__(self) -> None:
        self.runner = Runner(
            self.shelf.root / "pace.json",
            lambda case: self.news.tell(case, "job"),
            at_once=self.jobs_at_once,
        )
        self.coaches = Coaches(lambda case: self.news.tell(case, "check"))

    def open(self) -> None:
        """Take the shelf up: what was wanted when the program last ended goes on."""
        self.shelf.open()
        self.runner.take_up(case.folder for case in self.shelf.cases())
        Cameras(self.shelf.cameras).settle()

    def close(self) -> None:
        """End what runs; what is finished is kept."""
        self.closing = True
        self.doors.close_all()
        self.coaches.close()
        self.runner.close()

    def access_of(self, request: Request) -> Access:
        """Of the door through which a request came."""
        return self.doors.access_at(request.headers.get("host", "").lower()) or self.access

    def intake(self, case: ShelvedCase) -> Intake:
        return self.intake_of(case.received)

    def intake_of(self, folder: FilePath) -> Intake:
        """Where photos of a case, or of a camera's board, come in."""
        return Intake(folder, secret_of(self.shelf.root))


async def clinic_of(request: Request) -> Clinic:  # so that no thread is asked for it
    clinic: Clinic = request.app.state.clinic
    return clinic


ClinicHere = Annotated[Clinic, Depends(clinic_of)]


async def session_of(clinic: ClinicHere, request: Request) -> str:
    access = clinic.access_of(request)
    return session_in(request.headers.get("cookie", ""), access.cookie)


SessionHere = Annotated[str, Depends(session_of)]
"""The session in the cookie of the door through which a request came; empty without one."""


def case_of(
    clinic: ClinicHere,
    case_id: Annotated[
        str, Path(pattern=ID_PATTERN, description="Id of the case, such as K7Q-4F2.")
    ],
) -> ShelvedCase:
    return clinic.shelf.case(case_id)


CaseHere = Annotated[ShelvedCase, Depends(case_of)]


def bench_of(case: CaseHere) -> Bench:
    return Bench(case)


BenchHere = Annotated[Bench, Depends(bench_of)]
