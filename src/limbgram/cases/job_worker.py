"""Job worker: runs one job in a process of its own, which may be killed or may crash.

In      the job as one JSON line on standard input; when standard input ends, or at SIGTERM, the
        job stops at its next step; if it takes too long after the end of standard input, the
        process exits.
Out     one JSON line an event: stage, progress, and one of finished, refused, bug.
`job_process` loads it and calls `main`.
"""

import json
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import FrameType
from typing import IO, Any

from limbgram.cases.case_record import State, add_finding, write_record
from limbgram.cases.folder import CaseFolder, locked, sweep, with_disk_advice
from limbgram.cases.job import do
from limbgram.cases.job_messages import Job, plain_tree, read_job
from limbgram.cases.job_supervision import GRACE_S
from limbgram.cases.stage_cache import CachingRun
from limbgram.cases.superseded import drop_superseded, is_finished, is_up_to_date, key_of, supersede
from limbgram.cases.video_frames import with_frames
from limbgram.core.errors import Cancelled, LimbgramError
from limbgram.core.run import usual_budget_mb
from limbgram.core.typed import tree_of
from limbgram.findings import doubt

_EVENT_STEP_S = 0.1


@dataclass
class Events:
    """Writes events as JSON lines, at most one of progress every 0.1 s."""

    file: IO[str]
    on_lost: Callable[[], None] = lambda: None
    """Called when nobody reads any more."""
    _last: tuple[str, float] = ("", 0.0)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def send(self, event: str, **content: Any) -> None:
        with self._lock:
            try:
                self.file.write(json.dumps({"event": event, **content}) + "\n")
                self.file.flush()
            except BrokenPipeError:
                # The file's buffer still holds the line, and would raise again when it is flushed.
                null = os.open(os.devnull, os.O_WRONLY)
                os.dup2(null, self.file.fileno())
                os.close(null)
                self.on_lost()

    def progress(self, stage: str, done: int, total: int) -> None:
        now = time.monotonic()
        repeated = stage == self._last[0] and done != total
        if repeated and now - self._last[1] < _EVENT_STEP_S:
            return
        self._last = stage, now
        self.send("progress", stage=stage, done=done, total=total)


def work(job: Job, events: Events, stop: int) -> int:
    """Run the job, or stop it at the end of the descriptor `stop`; returns the exit code."""
    case = CaseFolder(job.case)
    memory_mb = usual_budget_mb() if job.memory_mb is None else job.memory_mb
    run = CachingRun(case=case, listener=events.progress, memory_mb=memory_mb)
    events.on_lost = run.cancel
    threading.Thread(target=_wait_for_stop, args=(stop, run), daemon=True).start()
    if threading.current_thread() is threading.main_thread():

        def cancel(_number: int, _frame: FrameType | None) -> None:
            run.cancel()

        signal.signal(signal.SIGTERM, cancel)
    try:
        with locked(case), with_disk_advice(case):
            sweep(case)
            return _do_and_record(job, run, events)
    except LimbgramError as error:
        events.send("refused", kind=type(error).__name__, finding=tree_of(error.finding))
        return error.exit_code
    except BaseException:
        events.send("bug", traceback=traceback.format_exc())
        return 1


def _do_and_record(job: Job, run: CachingRun, events: Events) -> int:
    case = run.case
    try:
        job = replace(job, sources=with_frames(case, job.sources, run))
        key = key_of(job)
    except LimbgramError as error:
        # The case is unchanged, and so are the results in it.
        if is_finished(case):
            add_finding(case, doubt("job.later_not_begun", reason=error.finding))
        else:
            write_record(case, "refused", run, finding=error.finding)
        raise
    up_to_date = is_up_to_date(case, key)
    if not up_to_date:
        supersede(case)
        write_record(case, "unfinished", run, job=key)
    try:
        with with_disk_advice(run.case):
            done = do(job, run)
    except LimbgramError as error:
        state: State = "cancelled" if isinstance(error, Cancelled) else "refused"
        if up_to_date:
            add_finding(case, doubt("job.later_ended", state=state, reason=error.finding))
        else:
            write_record(case, state, run, finding=error.finding, job=key)
        raise
    drop_superseded(case)
    write_record(case, "finished", run, done.reconstruction, job=key, verdict=done.verdict)
    events.send("finished", answer=plain_tree(done.answer))
    return 0


def _wait_for_stop(stop: int, run: CachingRun) -> None:
    # Not by a file object: a thread that reads one holds its lock, and the interpreter aborts at
    # its end if it cannot take that lock.
    while os.read(stop, 1):
        pass
    run.cancel()
    time.sleep(GRACE_S)
    os._exit(Cancelled.exit_code)


def main() -> int:
    # Standard output is for events alone: what libraries write there goes to standard error.
    private = os.dup(1)
    os.dup2(2, 1)
    with os.fdopen(private, "w", encoding="utf-8") as file:
        line = sys.stdin.buffer.readline().decode()
        if not line:
            return Cancelled.exit_code
        return work(read_job(json.loads(line), Path.cwd()), Events(file), sys.stdin.fileno())
