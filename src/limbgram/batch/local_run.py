"""Local run: runs the captures of a batch in parallel, as processors and memory allow.

In      Plans, the folder of the cases, what may be used.
Out     Outcomes in the order of the plans; events on the way.
Method  A thread for each capture that is at work waits for its process. Each process is given
        processors of its own, so that many cases do not get in each other's way; results do not
        depend on how many. Captures whose process died are tried again afterwards, one at a time,
        because memory is what processes die of; after so many attempts they are reported.
"""

import os
import queue
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

from limbgram.batch.attempt import Outcome, Plan, attempt
from limbgram.batch.memory import MemoryGate
from limbgram.batch.stopping import Stopping
from limbgram.cases.child_process import Event
from limbgram.core.request_fields import Flag, Within
from limbgram.core.run import machine_mb, worker_count

_POLL_S = 0.2


@dataclass(frozen=True, kw_only=True)
class BatchOptions:
    """What a batch may use of the machine."""

    at_once: Annotated[int | None, Within(1, 4096)] = None
    """Captures at a time, at most; without it one for each processor."""
    memory_gb: Annotated[float | None, Within(0.5, 65536), Flag("memory")] = None
    """Memory for all captures together, GB: the less, the fewer at a time; without it three
    quarters of the machine's."""
    attempts: Annotated[int, Within(1, 10)] = 3
    """Attempts for a capture whose process dies."""

    @property
    def memory_mb(self) -> float:
        """Of all together."""
        return _SHARE * machine_mb() if self.memory_gb is None else 1024 * self.memory_gb


_SHARE = 0.75


@dataclass
class BatchRun:
    """Captures at work."""

    plans: Sequence[Plan]
    cases: Path
    options: BatchOptions
    listener: Callable[[Event], None]
    stopping: Stopping = field(default_factory=Stopping)
    _outcomes: dict[str, Outcome] = field(default_factory=dict[str, Outcome])
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _fault: BaseException | None = None

    def wait(self) -> tuple[Outcome, ...]:
        """Do all to the end; Ctrl-C stops all, and what is finished is kept."""
        limit_mb = self.options.memory_mb
        at_once = max(1, min(self.options.at_once or worker_count(), len(self.plans)))
        self._tell({"event": "planned", "captures": len(self.plans), "at_once": at_once})
        waiting = list(self.plans)
        for number in range(1, self.options.attempts + 1):
            self._work(waiting, number, at_once if number == 1 else 1, MemoryGate(limit_mb))
            waiting = [plan for plan in waiting if self._outcome(plan).died]
        return tuple(self._outcome(plan) for plan in self.plans)

    def _work(self, plans: Sequence[Plan], number: int, at_once: int, gate: MemoryGate) -> None:
        left: queue.SimpleQueue[Plan] = queue.SimpleQueue()
        for plan in plans:
            left.put(plan)
        ends = [threading.Event() for _ in range(min(at_once, len(plans)))]
        for slot, ended in enumerate(ends):
            words = (left, number, _share(slot, at_once), gate, ended)
            threading.Thread(target=self._take, args=words, daemon=True).start()
        # Not by joining the threads: a join that Ctrl-C interrupts takes its thread for ended.
        try:
            while not all(ended.wait(_POLL_S) for ended in ends):
                pass
        except KeyboardInterrupt:
            self._tell({"event": "stopping"})
            self.stopping.ask()
            for ended in ends:
                ended.wait()
        if self._fault is not None:
            raise self._fault

    def _take(
        self,
        left: "queue.SimpleQueue[Plan]",
        number: int,
        processors: frozenset[int],
        gate: MemoryGate,
        ended: threading.Event,
    ) -> None:
        """Do one capture after the other; its processes inherit the processors of this thread."""
        try:
            self._take_all(left, number, processors, gate)
        except BaseException as fault:  # raised again by `_work`: of a thread nobody would hear
            self._fault = fault
            self.stopping.ask()
        finally:
            ended.set()

    def _take_all(
        self,
        left: "queue.SimpleQueue[Plan]",
        number: int,
        processors: frozenset[int],
        gate: MemoryGate,
    ) -> None:
        if processors and hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, processors)
        while self._fault is None:
            try:
                plan = left.get_nowait()
            except queue.Empty:
                return
            self._one(plan, number, gate)

    def _one(self, plan: Plan, number: int, gate: MemoryGate) -> None:
        name = plan.capture.name
        if not self.stopping.asked:
            self._tell({"event": "begun", "capture": name, "attempt": number})

        def heard(event: Event) -> None:
            if event["event"] == "progress":
                self._tell({**event, "capture": name})

        outcome = attempt(plan, self.cases, number, heard, self.stopping, gate)
        with self._lock:
            before = self._outcomes.get(name)
            if outcome.state == "cancelled" and before is not None:
                outcome = before  # it died before; that is what is known of it
            elif before is not None:
                outcome = replace(outcome, seconds=before.seconds + outcome.seconds)
            self._outcomes[name] = outcome
        again = outcome.died and number < self.options.attempts
        self._tell(ended_event(outcome, number, again=again))

    def _outcome(self, plan: Plan) -> Outcome:
        return self._outcomes[plan.capture.name]

    def _tell(self, event: Event) -> None:
        with self._lock:
            self.listener(event)


def ended_event(outcome: Outcome, number: int, *, again: bool) -> Event:
    """What is told of an attempt that has ended; again: another one follows."""
    return {
        "event": "ended",
        "capture": outcome.name,
        "attempt": number,
        "state": outcome.state,
        "light": outcome.light,
        "message": outcome.told or outcome.headline,
        "exit_code": outcome.exit_code,
        "again": again,
    }


def _share(slot: int, at_once: int) -> frozenset[int]:
    """The processors of one of so many that work at a time."""
    if not hasattr(os, "sched_getaffinity"):
        return frozenset()
    mine = sorted(os.sched_getaffinity(0))
    if at_once >= len(mine):
        return frozenset({mine[slot % len(mine)]})
    return frozenset(mine[slot * len(mine) // at_once : (slot + 1) * len(mine) // at_once])
