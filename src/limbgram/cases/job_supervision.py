"""Job supervision: starts a job's process, reads its events, stops it, and reports how it ended.

The process may abort by itself (a library, or the system when memory runs out): the caller gets
an error that names the stage, and the case stays usable.
"""

import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, cast

from limbgram.cases.folder import CaseFolder, cannot_be_made, require_apart, require_new_or_ours
from limbgram.cases.job_messages import Answer, Job, plain_tree, read_answer
from limbgram.core import errors
from limbgram.core.errors import Cancelled, LimbgramError, in_words
from limbgram.core.run import NEUTRAL_FOLDER
from limbgram.findings import Finding

Event = dict[str, Any]
GRACE_S = 20.0
"""Time that a step gets to end before the process is ended."""
COMMAND = (sys.executable, "-P", "-m", "limbgram.cases.job_process")
"""With -P the current folder, which may hold anything, is not searched for modules."""
_POLL_S = 0.2
_ENDED: Event = {"event": "ended"}
_MEMORY = {"GLIBC_TUNABLES": "glibc.malloc.arena_max=1:glibc.malloc.hugetlb=1"}
"""Threads share one heap, in pages of 2 MB: a quarter less memory, a tenth less time in the
system. Only glibc reads it."""


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
    _events: "queue.Queue[Event]" = field(default_factory=lambda: queue.Queue())
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
            self._process = process = self._start(log)
            try:
                last = self._listen()
                code = process.wait()
            except (KeyboardInterrupt, _StopAsked):
                self._stop(process)
                raise Cancelled("job.run_stopped") from None
            finally:
                process.kill()
        if code != _announced(last):
            raise _death(self._stage, code, case.log, last)
        return _answer(last)

    def _start(self, log: IO[bytes]) -> "subprocess.Popen[bytes]":
        """The process gets no Ctrl-C of its own: we tell it to stop."""
        new_group = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)
        process = subprocess.Popen(
            [*self.command, str(self.job.case)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=log,
            cwd=NEUTRAL_FOLDER,
            env=environment(),
            start_new_session=sys.platform != "win32",
            creationflags=new_group,
        )
        assert process.stdin is not None
        assert process.stdout is not None
        threading.Thread(target=self._read, args=(process.stdout,), daemon=True).start()
        try:
            process.stdin.write(json.dumps(plain_tree(self.job)).encode() + b"\n")
            process.stdin.flush()
        except BrokenPipeError:
            pass  # it died at once: the end of its events tells
        return process

    def _read(self, lines: IO[bytes]) -> None:
        for line in lines:
            self._events.put(json.loads(line))
        self._events.put(_ENDED)

    def _listen(self) -> Event:
        """Pass events on until the process ends; returns its answer."""
        last: Event = _ENDED
        while True:
            if self._asked.is_set():
                raise _StopAsked
            try:
                event = self._events.get(timeout=_POLL_S)
            except queue.Empty:
                continue
            if event is _ENDED:
                return last
            last = event
            self._stage = event.get("stage", self._stage)
            self.listener(event)

    def _stop(self, process: "subprocess.Popen[bytes]") -> None:
        """Let the current step end; after the grace, or at a second Ctrl-C, end it."""
        self.listener({"event": "stopping", "stage": self._stage})
        if self._held:
            self.go_on()
        assert process.stdin is not None
        try:
            process.stdin.close()
            process.wait(self.grace_s + self.slack_s)
        except (subprocess.TimeoutExpired, KeyboardInterrupt, BrokenPipeError):
            process.kill()


def environment() -> dict[str, str]:
    """What a process of ours inherits, with modules looked for where we looked.

    Never in the folder that we were started in.
    """
    given = os.environ.get("PYTHONPATH", "")
    places = [str(Path(place).absolute()) for place in given.split(os.pathsep) if place]
    return _MEMORY | dict(os.environ) | {"PYTHONPATH": os.pathsep.join(places)}


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
