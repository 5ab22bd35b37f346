"""Job supervision: starts a job's process, reads its events, stops it, and reports how it ended.

The process may abort by itself (a library, or the system when memory runs out): the caller gets
an error that names the stage, and the case stays usable.
"""

import json
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, cast

from limbgram.cases.child_process import NO_MORE, ChildProcess, Event
from limbgram.cases.folder import CaseFolder, cannot_be_made, require_apart, require_new_or_ours
from limbgram.cases.job_messages import Answer, Job, plain_tree, read_answer
from limbgram.core import errors
from limbgram.core.errors import Cancelled, LimbgramError, in_words
from limbgram.findings import Finding

GRACE_S = 20.0
"""Time that a step gets to end before the process is ended."""
COMMAND = (sys.executable, "-P", "-m", "limbgram.cases.job_process")
"""With -P the current folder, which may hold anything, is not searched for modules."""
_POLL_S = 0.2


class JobDied(LimbgramError):
    """The job's process ended without an answer."""

    exit_code = 6


class _StopAsked(Exception):
    """Another thread asked for the end."""


class JobBug(Exception):
    """A bug of ours in the job's process; holds its traceback."""


@dataclass
class Supervision:
    """One job in its own process."""

    job: Job
    listener: Callable[[Event], None]
    command: tuple[str, ...] = COMMAND
    grace_s: float = GRACE_S
    slack_s: float = 2.0
    """Beyond the grace: a process that ends itself then gets so long."""
    _stage: str = "start"
    _process: "subprocess.Popen[bytes] | None" = None
    _asked: threading.Event = field(default_factory=threading.Event)
    _held: bool = False

    def stop(self) -> None:
        """Ask for the end of the job from another thread; `wait` raises Cancelled."""
        self._asked.set()

    @property
    def process_id(self) -> int | None:
        """Of the job's process, once there is one."""
        return None if self._process is None else self._process.pid

    def hold(self) -> bool:
        """Let the job rest where it is, in memory; False where the system cannot do that."""
        return self._signal("SIGSTOP", held=True)

    def go_on(self) -> None:
        """Let a job that rests go on."""
        self._signal("SIGCONT", held=False)

    def _signal(self, name: str, *, held: bool) -> bool:
        number = getattr(signal, name, None)
        process = self._process
        if number is None or process is None or process.poll() is not None:
            return False
        process.send_signal(number)
        self._held = held
        return True

    def wait(self) -> Answer:
        """Do the job to its end.

        Raises:
            LimbgramError: as the job raised it.
            JobDied: the process ended by itself.
            JobBug: the job met a bug of ours.
        """
        case = CaseFolder(self.job.case)
        require_apart(case, self.job.sources)
        require_new_or_ours(case)
        with _log(case) as log:
            order = json.dumps(plain_tree(self.job))
            child = ChildProcess([*self.command, str(self.job.case)], order, log)
            self._process = child.process
            try:
                last = self._listen(child)
                code = child.process.wait()
            except (KeyboardInterrupt, _StopAsked):
                self._stop(child)
                raise Cancelled("job.run_stopped") from None
            finally:
                child.process.kill()
        if code != _announced(last):
            raise _death(self._stage, code, case.log, last)
        return _answer(last)

    def _listen(self, child: ChildProcess) -> Event:
        """Pass events on until the process ends; returns its answer."""
        last = NO_MORE
        while True:
            if self._asked.is_set():
                raise _StopAsked
            event = child.event(_POLL_S)
            if event is None:
                continue
            if event is NO_MORE:
                return last
            last = event
            self._stage = event.get("stage", self._stage)
            self.listener(event)

    def _stop(self, child: ChildProcess) -> None:
        self.listener({"event": "stopping", "stage": self._stage})
        if self._held:
            self.go_on()
        child.end(self.grace_s + self.slack_s)


def _announced(last: Event) -> int | None:
    """The exit code with which the process ends after its answer; None: it gave no answer."""
    match last:
        case {"event": "finished"}:
            return 0
        case {"event": "refused", "kind": str(kind)}:
            return getattr(errors, kind, LimbgramError).exit_code
        case {"event": "bug"}:
            return 1
        case _:
            return None


def _answer(last: Event) -> Answer:
    match last:
        case {"event": "finished", "answer": answer}:
            return read_answer(answer)
        case {"event": "refused", "kind": str(kind), "finding": dict(finding)}:
            raise getattr(errors, kind, LimbgramError).of(Finding.from_tree(finding))
        case _:
            raise JobBug(str(last.get("traceback")))


def _log(case: CaseFolder) -> IO[bytes]:
    try:
        case.root.mkdir(parents=True, exist_ok=True)
        return case.log.open("ab")
    except OSError as error:
        raise cannot_be_made(case, error) from error


def _death(stage: str, code: int, log: Path, last: Event) -> JobDied:
    """How the process ended by itself."""
    answered = _announced(last) is not None
    if code == -getattr(signal, "SIGKILL", 9) and not answered:
        return JobDied("job.memory_ran_out", stage=stage)
    tail = log.read_text("utf-8", errors="replace").strip().splitlines()[-5:]
    return JobDied(
        "job.died",
        stage=stage,
        signal=signal.Signals(-code).name if code < 0 else None,
        code=code,
        answer=_said(last) if answered else None,
        log=str(log),
        last_lines="\n".join(tail) or None,
    )


def _said(last: Event) -> Finding:
    """What the process answered before it died."""
    match last:
        case {"finding": dict(finding)}:
            return Finding.from_tree(cast(dict[str, Any], finding))
        case _:
            return in_words(str(last["event"]))
