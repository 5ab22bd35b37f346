"""Local run: runs the captures of a batch in parallel, as processors and memory allow.

In      Plans, the folder of the cases, what may be used.
Out     Outcomes in the order of the plans; events on the way.
Method  One thread for each running capture waits for its process. Each process has processors of
        its own, so that cases do not slow each other down; results do not depend on how many.
        Captures whose process died are tried again afterwards, one at a time, because memory is
        what processes die of; after `attempts` attempts they are reported.
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
from limbgram.batch.processors import processors_for
from limbgram.batch.stopping import Stopping
from limbgram.cases.child_process import Event
from limbgram.core.request_fields import Flag, Within
from limbgram.core.run import machine_mb, worker_count

_POLL_S = 0.2
_MEMORY_SHARE = 0.75
"""Of the machine's memory, that a batch uses unless told otherwise."""


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
        """Memory for all captures together."""
        usual_mb = _MEMORY_SHARE * machine_mb()
        return usual_mb if self.memory_gb is None else 1024 * self.memory_gb


@dataclass
class BatchRun:
    """A batch that runs on this machine."""

    plans: Sequence[Plan]
    cases: Path
    options: BatchOptions
    listener: Callable[[Event], None]
    stopping: Stopping = field(default_factory=Stopping)
    _outcomes: dict[str, Outcome] = field(default_factory=dict[str, Outcome])
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _fault: BaseException | None = None

    def wait(self) -> tuple[Outcome, ...]:
        """Run all captures to their end; Ctrl-C stops all, and finished cases are kept."""
        limit_mb = self.options.memory_mb
        at_once = max(1, min(self.options.at_once or worker_count(), len(self.plans)))
        self._tell({"event": "planned", "captures": len(self.plans), "at_once": at_once})
        plans = list(self.plans)
        for number in range(1, self.options.attempts + 1):
            self._attempt_all(plans, number, at_once if number == 1 else 1, MemoryGate(limit_mb))
            plans = [plan for plan in plans if self._outcome(plan).died]
        return tuple(self._outcome(plan) for plan in self.plans)

    def _attempt_all(
        self, plans: Sequence[Plan], number: int, at_once: int, gate: MemoryGate
    ) -> None:
        waiting: queue.SimpleQueue[Plan] = queue.SimpleQueue()
        for plan in plans:
            waiting.put(plan)
        ends = [threading.Event() for _ in range(min(at_once, len(plans)))]
        for slot, ended in enumerate(ends):
            arguments = (waiting, number, processors_for(slot, at_once), gate, ended)
            threading.Thread(target=self._run_thread, args=arguments, daemon=True).start()
        # Not by joining the threads: a join that Ctrl-C interrupts counts its thread as ended.
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

    def _run_thread(
        self,
        waiting: "queue.SimpleQueue[Plan]",
        number: int,
        processors: frozenset[int],
        gate: MemoryGate,
        ended: threading.Event,
    ) -> None:
        """Attempt one capture after the other; its processes inherit this thread's processors."""
        try:
            self._attempt_next_ones(waiting, number, processors, gate)
        except BaseException as fault:  # `_attempt_all` raises it again in the main thread
            self._fault = fault
            self.stopping.ask()
        finally:
            ended.set()

    def _attempt_next_ones(
        self,
        waiting: "queue.SimpleQueue[Plan]",
        number: int,
        processors: frozenset[int],
        gate: MemoryGate,
    ) -> None:
        if processors and hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, processors)
        while self._fault is None:
            try:
                plan = waiting.get_nowait()
            except queue.Empty:
                return
            self._attempt_one(plan, number, gate)

    def _attempt_one(self, plan: Plan, number: int, gate: MemoryGate) -> None:
        name = plan.capture.name
        if not self.stopping.asked:
            self._tell({"event": "begun", "capture": name, "attempt": number})

        def forward(event: Event) -> None:
            if event["event"] == "progress":
                self._tell({**event, "capture": name})

        outcome = attempt(plan, self.cases, number, forward, self.stopping, gate)
        with self._lock:
            before = self._outcomes.get(name)
            if outcome.state == "cancelled" and before is not None:
                outcome = before  # it died in the attempt before; that stays its outcome
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
    """The event of an attempt that has ended.

    again: Another attempt follows.
    """
    return {
        "event": "ended",
        "capture": outcome.name,
        "attempt": number,
        "state": outcome.state,
        "light": outcome.light,
        "message": outcome.reason or outcome.headline,
        "exit_code": outcome.exit_code,
        "again": again,
    }
