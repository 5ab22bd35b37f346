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
"""Time that a stage gets to end before the process is killed."""
COMMAND = (sys.executable, "-P", "-m", "limbgram.cases.job_process")
"""With -P no modules are imported from the current folder, which may hold anything."""
_POLL_S = 0.2


class JobDied(LimbgramError):
    """The job's process ended without an answer."""

    exit_code = 6


class _StopRequested(Exception):
    """Another thread asked to end the job."""


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
    """Beyond the grace: time for a process to end by itself before it is killed."""
    _stage: str = "start"
    _process: "subprocess.Popen[bytes] | None" = None
    _stop_requested: threading.Event = field(default_factory=threading.Event)
    _held: bool = False

    def stop(self) -> None:
        """Ask for the end of the job from another thread; `wait` raises Cancelled."""
        self._stop_requested.set()

    @property
    def process_id(self) -> int | None:
        """Of the job's process, once there is one."""
        return None if self._process is None else self._process.pid

    def hold(self) -> bool:
        """Pause the job; its process keeps its memory. False where the system cannot do that."""
        return self._signal("SIGSTOP", held=True)

    def resume(self) -> None:
        """Resume a job that is held."""
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
        """Run the job to its end.

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
            except (KeyboardInterrupt, _StopRequested):
                self._stop(child)
                raise Cancelled("job.run_stopped") from None
            finally:
                child.process.kill()
        if code != _expected_exit_code(last):
            raise _death(self._stage, code, case.log, last)
        return _answer(last)

    def _listen(self, child: ChildProcess) -> Event:
        """Pass events on until the process ends; returns the last one, which is its answer."""
        last = NO_MORE
        while True:
            if self._stop_requested.is_set():
                raise _StopRequested
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
            self.resume()
        child.end(self.grace_s + self.slack_s)


def _expected_exit_code(last: Event) -> int | None:
    """The exit code of a process with this answer; None if the event is no answer."""
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
    """The error of a process that ended by itself."""
    answered = _expected_exit_code(last) is not None
    if code == -getattr(signal, "SIGKILL", 9) and not answered:
        return JobDied("job.memory_ran_out", stage=stage)
    tail = log.read_text("utf-8", errors="replace").strip().splitlines()[-5:]
    return JobDied(
        "job.died",
        stage=stage,
        signal=signal.Signals(-code).name if code < 0 else None,
        code=code,
        answer=_answer_finding(last) if answered else None,
        log=str(log),
        last_lines="\n".join(tail) or None,
    )


def _answer_finding(last: Event) -> Finding:
    """The answer of a process that died afterwards, as a finding."""
    match last:
        case {"finding": dict(finding)}:
            return Finding.from_tree(cast(dict[str, Any], finding))
        case _:
            return in_words(str(last["event"]))
