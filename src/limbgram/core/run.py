"""A run: calls stages, reports their progress, times them and lets the user stop.

A stage stays a plain function. Its loops are `for photo in track(photos)` or
`in_parallel(work, photos)`; inside a run these report progress and raise Cancelled, outside they do
nothing. Of nested loops only the outermost reports.

A run also has a memory budget. It limits how many items are worked on at a time
(`in_parallel(work, photos, each_mb=...)`), which never changes a result. Decisions that change one,
such as the resolution, are made from the budget by the caller of the stages (`pipeline`), and told.
"""

import gc
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import ParamSpec, TypeVar

from limbgram.core.errors import Cancelled

P = ParamSpec("P")
T = TypeVar("T")
S = TypeVar("S")

_STATM = Path("/proc/self/statm")
_WATCH_STEP_S = 0.05
_CGROUP_LIMITS = (
    Path("/sys/fs/cgroup/memory.max"),
    Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
)
_UNKNOWN_MACHINE_MB = 8192.0
"""Assumed where the system does not tell (Windows)."""
PROGRAM_MB = 330.0
"""Resident memory with all libraries loaded and no work done: 290 to 320 measured."""

NEUTRAL_FOLDER = Path(os.__file__).parent
"""Current folder while libraries are imported: several read settings from it (`matplotlibrc`,
`.numba_config.yaml`), and the user's may hold files from anywhere."""


@contextmanager
def garbage_collection_paused() -> Generator[None]:
    """No garbage collection during imports, which it would make a third slower.

    What was imported is exempt from later collections too.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        if enabled:
            gc.enable()


@contextmanager
def signal_handlers_kept() -> Generator[None]:
    """Restore our signal handlers after importing a library that installs its own.

    glog, which comes with pycolmap, would answer SIGTERM with a stack trace and an abort.
    """
    in_main = threading.current_thread() is threading.main_thread()
    kept = (signal.SIGINT, signal.SIGTERM) if in_main else ()
    before = {one: signal.getsignal(one) for one in kept}
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler or signal.SIG_DFL)


Listener = Callable[[str, int, int], None]
"""Called with the stage's name, steps done and steps in all."""


@dataclass(frozen=True)
class Timing:
    """Time and memory of one stage."""

    stage: str
    wall_s: float
    cpu_s: float
    peak_mb: float
    """Peak resident memory while it ran; see PeakWatch."""


@dataclass
class Run:
    """One job: `product = run(stage, inputs, options)`."""

    listener: Listener = field(default=lambda _stage, _done, _total: None)
    timings: list[Timing] = field(default_factory=list)
    memory_mb: float = field(default_factory=lambda: usual_budget_mb())
    """Resident memory that the work should keep to."""
    _stop: threading.Event = field(default_factory=threading.Event)
    _stage: str = ""
    _looping: bool = False

    def __call__(self, stage: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        self._stage = getattr(stage, "__name__", "stage").replace("_", " ")
        self.report(0, 0)
        wall, cpu, memory = time.perf_counter(), cpu_seconds(), PeakWatch()
        token = _current.set(self)
        try:
            return stage(*args, **kwargs)
        finally:
            _current.reset(token)
            wall_s, cpu_s = time.perf_counter() - wall, cpu_seconds() - cpu
            self.timings.append(Timing(self._stage, wall_s, cpu_s, memory.stop()))

    def cancel(self) -> None:
        """Ask the work to stop at its next step; safe from another thread or a signal handler."""
        self._stop.set()

    def report(self, done: int, total: int) -> None:
        """Tell the listener how far the stage is, or raise Cancelled."""
        self.check()
        self.listener(self._stage, done, total)

    def check(self) -> None:
        """Raise Cancelled where the user asked to stop."""
        if self._stop.is_set():
            raise Cancelled("job.run_stopped")

    @contextmanager
    def loop(self, total: int) -> Generator[Callable[[int], None]]:
        """A function to call with the steps done; in a nested loop it only checks for a stop."""
        outermost, self._looping = not self._looping, True
        try:
            yield (lambda done: self.report(done, total)) if outermost else lambda _: self.check()
        finally:
            if outermost:
                self._looping = False


_current: ContextVar[Run | None] = ContextVar("limbgram_run", default=None)


def track(items: Iterable[T], total: int | None = None) -> Iterator[T]:
    """Iterate, reporting every step to the current run."""
    run = _current.get() or Run()
    count = total if total is not None else len(items) if isinstance(items, Sequence) else 0
    with run.loop(count) as report:
        for done, item in enumerate(items):
            report(done)
            yield item
        report(count)


def in_parallel(
    work: Callable[[S], T],
    items: Sequence[S],
    workers: int | None = None,
    *,
    each_mb: float = 0.0,
) -> list[T]:
    """`[work(item) for item in items]` on threads, in order, at most `workers` in flight.

    For work that releases the interpreter lock (OpenCV, numba with nogil, large numpy calls).
    `each_mb` is the memory that one item takes: no more are in flight than the run's budget
    allows, but at least one.
    """
    limit = workers or worker_count()
    if each_mb > 0:
        limit = max(1, min(limit, int(spare_mb() / each_mb)))
    if min(limit, len(items)) <= 1:
        return [work(item) for item in track(items)]
    run = _current.get() or Run()
    with run.loop(len(items)) as report, ThreadPoolExecutor(limit) as pool:
        futures: list[Future[T]] = []
        try:
            futures = [pool.submit(copy_context().run, work, item) for item in items]
            results: list[T] = []
            for done, future in enumerate(futures):
                report(done)
                results.append(future.result())
            report(len(items))
            return results
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def budget_mb() -> float:
    """Memory that the current run may use; outside a run the usual share of the machine's."""
    run = _current.get()
    return usual_budget_mb() if run is None else run.memory_mb


def spare_mb() -> float:
    """Memory that the budget leaves beside what is in use now."""
    held_mb = resident_megabytes()
    return budget_mb() - (PROGRAM_MB if math.isnan(held_mb) else held_mb)


def usual_budget_mb() -> float:
    """Half of the memory that this machine has, or that its container allows."""
    return 0.5 * machine_mb()


@cache
def machine_mb() -> float:
    """Physical memory, or less where a container is allowed less."""
    names = getattr(os, "sysconf_names", {})
    if "SC_PHYS_PAGES" not in names:
        return _UNKNOWN_MACHINE_MB
    limits = [os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")]
    for file in _CGROUP_LIMITS:
        told = file.read_text("ascii").strip() if file.exists() else ""
        if told.isdecimal():  # else "max": no limit
            limits.append(int(told))
    return min(limits) / 2**20


def worker_count() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return max(1, os.cpu_count() or 1)


def cpu_seconds() -> float:
    """Processor time of this process and its ended children."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


@dataclass
class PeakWatch:
    """Peak resident memory of this process from now on, MB.

    Exact if it exceeds the process's earlier peak, which the system keeps. Otherwise, on Linux, the
    largest of twenty samples a second; elsewhere the process's peak, and NaN on Windows.
    """

    _before_mb: float = field(default_factory=lambda: peak_megabytes())
    _seen_mb: float = field(default_factory=lambda: resident_megabytes())
    _ended: threading.Event = field(default_factory=threading.Event)
    _thread: threading.Thread | None = None

    def __post_init__(self) -> None:
        if _STATM.exists():
            self._thread = threading.Thread(target=self._watch, daemon=True)
            self._thread.start()

    def stop(self) -> float:
        """End watching; the peak."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
        most_mb = peak_megabytes()
        exact = self._thread is None or most_mb > self._before_mb
        return most_mb if exact else max(self._seen_mb, resident_megabytes())

    def _watch(self) -> None:
        while not self._ended.wait(_WATCH_STEP_S):
            self._seen_mb = max(self._seen_mb, resident_megabytes())


def resident_megabytes() -> float:
    """Resident memory of this process now; NaN where the system does not tell."""
    if not _STATM.exists():
        return float("nan")
    pages = int(_STATM.read_text("ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def peak_megabytes() -> float:
    """Largest resident memory of this process so far; NaN where the system does not tell."""
    if sys.platform == "win32":
        return float("nan")
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 2**20 if sys.platform == "darwin" else peak / 1024
