"""Dask task of one capture: starts the attempt's process (`attempt_process`) and ends it.

In      an order (`attempt_process`), given out by `cluster`.
Out     the Result as JSON. Events go to the cluster's topic of this batch on the way.
Method  Dask cannot end a task that runs. So the task only waits for a process, and ends it once the
        task is cancelled or the worker closes. A worker that is killed closes the process's
        standard input by that, which the attempt takes as its end.

Nothing of the reconstruction is loaded here: the worker answers the scheduler at all times.
"""

import json
import sys
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any

from distributed import Worker, get_worker

from limbgram.batch.processors import processors_for
from limbgram.cases.child_process import NO_MORE, ChildProcess

_POLL_S = 0.2
_GRACE_S = 10.0
_LAST_LINES = 4
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}
"""As the command line sets it: sums of matrix products have one order, on every machine."""
_slots: set[int] = set()
_slots_lock = threading.Lock()


def run_attempt(order: str, module: str, topic: str, every_s: float, workers_here: int) -> str:
    """Do an attempt to its end.

    Args:
        module: What the process runs.
        topic: Dask topic that events are logged to.
        every_s: Least time between two reports of progress within a stage.
        workers_here: Workers on this machine, named 0, 1, ...; 0: not known.
    """
    worker = get_worker()
    key = worker.get_current_task()
    scratch = Path(worker.local_directory) / "limbgram"
    with _slot() as slot, TemporaryFile() as errors:
        processors = _processors(worker, slot, workers_here)
        command = [sys.executable, "-P", "-m", module, str(scratch), processors]
        child = ChildProcess(command, order, errors, _ONE_THREAD)
        try:
            result = _followed(child, worker, key, topic, every_s)
            code = child.process.wait()
        finally:
            child.end(_GRACE_S)
        answer = {"result": result} if result else {"ended": code, "lines": _last_lines(errors)}
        return json.dumps({**answer, "worker": worker.address})


class TaskCancelled(Exception):
    """Nobody waits for the task any more, nor reads this."""


def _followed(
    child: ChildProcess, worker: Worker, key: Any, topic: str, every_s: float
) -> dict[str, Any]:
    """Pass events on until the process ends; returns its result, or nothing."""
    stage, told_at = "", 0.0
    while True:
        if _is_cancelled(worker, key):
            raise TaskCancelled
        event = child.event(_POLL_S)
        if event is None:
            continue
        if event is NO_MORE:
            return {}
        if event["event"] == "result":
            return event["result"]
        now = time.monotonic()
        if event.get("stage", "") == stage and now - told_at < every_s:
            continue
        stage, told_at = event.get("stage", ""), now
        worker.log_event(topic, {**event, "key": str(key), "worker": worker.address})


def _is_cancelled(worker: Worker, key: Any) -> bool:
    """Whether nobody waits for the task any more."""
    task = worker.state.tasks.get(key)
    return task is None or task.state == "cancelled" or worker.status.name != "running"


@contextmanager
def _slot() -> Generator[int]:
    """A number that no other task of this worker has meanwhile."""
    with _slots_lock:
        slot = next(number for number in range(len(_slots) + 1) if number not in _slots)
        _slots.add(slot)
    try:
        yield slot
    finally:
        with _slots_lock:
            _slots.remove(slot)


def _processors(worker: Worker, slot: int, workers_here: int) -> str:
    """The processors of one task, as its process takes them: 0,1; empty for all."""
    if workers_here:
        chosen = processors_for(int(worker.name), workers_here)
    else:
        chosen = processors_for(slot, worker.state.nthreads)
    return ",".join(map(str, sorted(chosen)))


def _last_lines(errors: IO[bytes]) -> str:
    errors.seek(0)
    lines = errors.read().decode("utf-8", "replace").strip().splitlines()
    return "\n".join(lines[-_LAST_LINES:])
