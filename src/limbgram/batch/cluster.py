"""Cluster: distributes the captures of a batch to the workers of a Dask cluster.

In      Plans, the address of the scheduler (or local:4, which starts four workers here), where
        captures and cases lie.
Out     Outcomes in the order of the plans; events on the way, as a batch on one machine tells them.
Method  Each capture is a task that starts a process (`dask_task`, `attempt_process`). This process
        alone accepts what the workers upload (`storage`), one attempt a capture. A capture whose
        process or worker died is submitted again, to another worker if there is one, up to
        `attempts` times. When the scheduler is lost, this process reconnects until it is back, and
        submits unfinished captures once more.
Fails   OptionsError: nobody answers at the address, or versions differ.
"""

import json
import logging
import queue
import secrets
import socket
import time
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast

from dask import config as dask_config
from distributed import Client, Future, KilledWorker, LocalCluster

from limbgram.batch.attempt import Outcome, Plan, failed_outcome, undecided_outcome
from limbgram.batch.attempt_process import MODULE, Result, order_of, result_of
from limbgram.batch.dask_task import run_attempt
from limbgram.batch.local_run import ended_event
from limbgram.batch.stopping import Stopping
from limbgram.batch.storage import Cases, cases_at
from limbgram.batch.versions import program_version
from limbgram.cases.child_process import Event
from limbgram.cases.job_supervision import JobDied
from limbgram.core.errors import Cancelled, LimbgramError, OptionsError
from limbgram.findings import Finding, fault, note

LOCAL = "local:"
_COMPARED_PACKAGES = ("python", "dask", "distributed", "msgpack", "cloudpickle")
_POLL_S = 0.2
_RECONNECT_STEP_S = 1.0
_CONNECT_S = 10.0
_EVENTS_PER_S = 200.0
"""Of all workers together: a load that a scheduler does not notice."""
_LEAST_EVENT_STEP_S = 0.5
_LISTED_AT_MOST = 5
_PATIENCE_S = 600.0
"""How long to try to reach a scheduler that was lost."""


@dataclass(frozen=True, kw_only=True)
class ClusterOptions:
    """Which cluster, and how much it is trusted."""

    address: str
    captures: str
    """Folder or URL."""
    folder: Path
    """Where the plans found the captures; the same folder, unless they lie behind a URL."""
    cases: str
    """Folder or URL."""
    at_once: int | None = None
    """Captures submitted at a time, at most; None: all, and the scheduler queues them."""
    attempts: int = 3
    """For a capture whose process or worker dies."""
    module: str = MODULE
    """What the process of an attempt runs."""


@dataclass(frozen=True)
class _Submitted:
    """A capture that is submitted as a task."""

    plan: Plan
    number: int
    future: "Future[str]"


@dataclass
class ClusterRun:
    """A batch at work on a cluster."""

    plans: Sequence[Plan]
    options: ClusterOptions
    listener: Callable[[Event], None]
    stopping: Stopping = field(default_factory=Stopping)
    results: list[Result] = field(default_factory=list[Result])
    """What attempts answered, with the times that they took."""
    _outcomes: dict[str, Outcome] = field(default_factory=dict[str, Outcome])
    _submitted: dict[str, _Submitted] = field(default_factory=dict[str, _Submitted])
    _waiting: list[tuple[Plan, int, str]] = field(default_factory=list[tuple[Plan, int, str]])
    _attempt_tokens: dict[str, set[str]] = field(default_factory=dict[str, set[str]])
    _inbox: "queue.SimpleQueue[Event | str]" = field(default_factory=lambda: queue.SimpleQueue())
    """Events, and names of captures whose task is done, in the order of arrival."""
    _worker_count: int = 0
    _topic: str = field(default_factory=lambda: f"limbgram-{secrets.token_hex(8)}")

    def wait(self) -> tuple[Outcome, ...]:
        """Do all to the end; Ctrl-C stops all, and cases that are finished are kept."""
        cases = cases_at(self.options.cases)
        for plan in self.plans:
            if plan.refusal is not None:
                self._end(
                    plan, 1, failed_outcome(undecided_outcome(plan, 1), "refused", plan.refusal)
                )
            else:
                self._waiting.append((plan, 1, ""))
        with ExitStack() as held:
            try:
                address, workers = held.enter_context(_started(self.options.address))
                self._work(address, workers, cases)
            except KeyboardInterrupt:
                self.listener({"event": "stopping"})
                self.stopping.ask()
        cases.end()
        for plan in self.plans:
            if plan.capture.name not in self._outcomes:
                stopped = Cancelled("job.command_stopped")
                self._end(plan, 1, failed_outcome(undecided_outcome(plan, 1), "cancelled", stopped))
        return tuple(self._outcomes[plan.capture.name] for plan in self.plans)

    def _work(self, address: str, workers: int, cases: Cases) -> None:
        """Submit captures, and again those that a scheduler lost, until every one has ended."""
        lost_at, first = 0.0, True
        while first or self._waiting:
            try:
                with _connected(address) as client:
                    self._worker_count = seen = require_same_versions(client)
                    if first:
                        cases.begin()
                        at_once = workers or seen
                        self.listener(
                            {"event": "planned", "captures": len(self.plans), "at_once": at_once}
                        )
                    first, lost_at = False, 0.0
                    client.subscribe_topic(self._topic, self._on_event)
                    try:
                        self._follow(client, workers, cases)
                    finally:
                        client.cancel([one.future for one in self._submitted.values()], force=True)
            except OptionsError:
                if first or (lost_at and time.monotonic() - lost_at > _PATIENCE_S):
                    raise
                lost_at = lost_at or time.monotonic()
                time.sleep(_RECONNECT_STEP_S)
            self._requeue()
            if self._waiting:
                self.listener({"event": "lost", "what": "scheduler"})

    def _follow(self, client: Client, workers: int, cases: Cases) -> None:
        """Handle events and results until every capture has ended, or the scheduler is lost."""
        while (self._waiting or self._submitted) and not self._is_lost(client):
            self._submit(client, workers)
            try:
                item = self._inbox.get(timeout=_POLL_S)
            except queue.Empty:
                continue
            if not isinstance(item, str):
                self._forward(item)
            elif item in self._submitted and self._submitted[item].future.done():
                try:
                    answer = _answer(self._submitted[item].future)
                except (CancelledError, OSError):
                    return
                self._end_task(self._submitted.pop(item), answer, cases)

    def _is_lost(self, client: Client) -> bool:
        """A client that finds its scheduler again by itself has lost all its tasks and topics."""
        oldest = next(iter(self._submitted.values()), None)
        return client.status != "running" or (oldest is not None and oldest.future.cancelled())

    def _requeue(self) -> None:
        """Let submitted captures without an answer wait again."""
        self._waiting += [(one.plan, one.number, "") for one in self._submitted.values()]
        self._submitted.clear()

    def _submit(self, client: Client, workers: int) -> None:
        most = self.options.at_once or len(self.plans)
        every_s = max(_LEAST_EVENT_STEP_S, self._worker_count / _EVENTS_PER_S)
        while self._waiting and len(self._submitted) < most:
            plan, number, elsewhere = self._waiting.pop(0)
            name = plan.capture.name
            try:
                order = order_of(
                    plan, self.options.captures, self.options.folder, self.options.cases, number
                )
            except LimbgramError as error:
                self._end(
                    plan, number, failed_outcome(undecided_outcome(plan, number), "refused", error)
                )
                continue
            others = [one for one in _addresses(client) if one != elsewhere] if elsewhere else []
            future = client.submit(
                run_attempt,
                order,
                self.options.module,
                self._topic,
                every_s,
                workers,
                key=f"{self._topic}-{name}-{secrets.token_hex(4)}",
                pure=False,
                priority=-number,
                workers=others or None,
                allow_other_workers=bool(others),
            )
            self._submitted[name] = _Submitted(plan, number, future)
            future.add_done_callback(partial(self._on_task_done, name))

    def _on_task_done(self, name: str, _: object) -> None:
        """Called by the client's own thread."""
        self._inbox.put(name)

    def _end_task(
        self, submitted: _Submitted, answer: "str | BaseException | None", cases: Cases
    ) -> None:
        """Take the answer of a task, a lost worker or an error as the outcome; or try again."""
        plan, number = submitted.plan, submitted.number
        name, where = plan.capture.name, ""
        if isinstance(answer, str):
            tree: dict[str, Any] = json.loads(answer)
            where = str(tree["worker"])
            outcome = self._accepted(plan, number, tree, cases)
        else:
            outcome = _without_answer(plan, number, answer)
        outcome = replace(outcome, attempts=max(number, len(self._attempt_tokens.get(name, ()))))
        again = outcome.died and number < self.options.attempts
        if again:
            self._waiting.append((plan, number + 1, where))
            self.listener(ended_event(outcome, number, again=True))
        else:
            self._end(plan, number, outcome)

    def _accepted(self, plan: Plan, number: int, tree: dict[str, Any], cases: Cases) -> Outcome:
        """The outcome that a process answered, once the attempt is accepted as the case."""
        base = undecided_outcome(plan, number)
        if "ended" in tree:
            return _process_ended(base, tree)
        result = result_of(tree["result"])
        self.results.append(result)
        if result.token:
            try:
                cases.accept(plan.capture.name, result.token, result.seen, result.bytes_brought)
            except LimbgramError as error:
                return failed_outcome(base, "refused", error)
        return result.outcome

    def _end(self, plan: Plan, number: int, outcome: Outcome) -> None:
        self._outcomes[plan.capture.name] = outcome
        self.listener(ended_event(outcome, number, again=False))

    def _on_event(self, logged: tuple[float, Event]) -> None:
        """Called by the client's own thread, with the time and the event."""
        self._inbox.put(logged[1])

    def _forward(self, event: Event) -> None:
        key = str(event["key"])
        name = key.removeprefix(f"{self._topic}-").rpartition("-")[0]
        if name not in self._submitted:
            return
        if event["event"] == "begun":
            tokens = self._attempt_tokens.setdefault(name, set())
            tokens.add(event["token"])
            self.listener({"event": "begun", "capture": name, "attempt": len(tokens)})
        elif event["event"] == "progress":
            shown = {word: event[word] for word in ("event", "stage", "done", "total")}
            self.listener({**shown, "capture": name})


def _answer(future: "Future[str]") -> "str | BaseException | None":
    """What a task that is done answered, or why it did not.

    Raises:
        CancelledError, OSError: the scheduler was lost before it had told.
    """
    if future.status == "error":
        return cast(BaseException | None, future.exception())
    return future.result()


def _addresses(client: Client) -> list[str]:
    return list(client.scheduler_info(n_workers=-1)["workers"])


def require_same_versions(client: Client) -> int:
    """Compare what is installed here and there; returns the number of workers.

    Workers that come later are compared by each attempt.

    Raises:
        OptionsError: a worker or the scheduler has other versions.
    """
    versions = cast(dict[str, Any], client.get_versions())
    here = _packages(versions["client"])
    others = {"the scheduler": versions["scheduler"], **versions["workers"]}
    differing: list[Finding] = [
        note("dask.other_version", where=name, what=one, there=there.get(one), here=here[one])
        for name, there in ((name, _packages(reported)) for name, reported in others.items())
        for one in _COMPARED_PACKAGES
        if there.get(one) != here[one]
    ]
    programs = cast(dict[str, Any], client.run(program_version, on_error="return"))
    for address, program in programs.items():
        if isinstance(program, ModuleNotFoundError):
            differing.append(note("dask.no_library", where=address, library=program.name))
        elif program != program_version():
            differing.append(note("dask.other_program", where=address))
    if differing:
        raise OptionsError(
            "dask.versions_differ",
            differing=tuple(differing[:_LISTED_AT_MOST]),
            more=max(0, len(differing) - _LISTED_AT_MOST),
        )
    return len(programs)


def _packages(reported: Any) -> dict[str, str]:
    """Versions by name, Python's with its patch level."""
    found = dict(reported["packages"]) if reported else {}
    host = dict(reported["host"]) if reported else {}
    return {
        name: str(found.get(name, host.get(name, "none"))).partition(".final")[0]
        for name in _COMPARED_PACKAGES
    }


def _without_answer(plan: Plan, number: int, error: BaseException | None) -> Outcome:
    """The outcome of a task that Dask gave up, or that met a bug of the program."""
    base = undecided_outcome(plan, number)
    if isinstance(error, KilledWorker):
        return failed_outcome(base, "died", JobDied("dask.workers_lost"))
    return replace(
        base,
        state="failed",
        kind=type(error).__name__,
        exit_code=1,
        finding=fault("batch.fault", log=None, trace=repr(error), library="Dask"),
    )


def _process_ended(base: Outcome, tree: dict[str, Any]) -> Outcome:
    """The outcome of an attempt whose process ended without an answer."""
    code, lines = int(tree["ended"]), str(tree["lines"])
    if code > 0:
        found = fault("batch.fault", log=None, trace=lines, library=None)
        return replace(base, state="failed", kind="JobBug", exit_code=1, finding=found)
    return failed_outcome(base, "died", JobDied("dask.memory_ran_out"))


@contextmanager
def _started(address: str) -> Generator[tuple[str, int]]:
    """The address of a cluster, and how many workers were started here for it."""
    if not address.startswith(LOCAL):
        yield address, 0
        return
    count = address.removeprefix(LOCAL)
    if not count.isdecimal() or not 1 <= int(count) <= 256:
        raise OptionsError("dask.no_count_of_workers", address=address)
    settings = {
        "distributed.scheduler.allowed-failures": 0,
        "distributed.worker.profile.enabled": False,
        "logging.distributed": "error",
    }
    with (
        TemporaryDirectory(prefix="limbgram-", ignore_cleanup_errors=True) as scratch,
        dask_config.set(settings),
        LocalCluster(
            n_workers=int(count),
            threads_per_worker=1,
            memory_limit=None,
            dashboard_address="127.0.0.1:0",
            local_directory=scratch,
        ) as cluster,
    ):
        yield str(cast(Any, cluster).scheduler_address), int(count)


@contextmanager
def _connected(address: str) -> Generator[Client]:
    _silence_dask()
    try:
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError, socket.gaierror) as error:
        raise OptionsError("dask.no_scheduler", address=address, why=str(error)) from error
    try:
        yield client
    finally:
        client.close(timeout=_CONNECT_S)


def _silence_dask() -> None:
    """Keep the library's tracebacks of lost connections back: this module reports those itself."""
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)
