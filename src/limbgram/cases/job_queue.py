"""Job queue: a queue of jobs in child processes, each with a status file in its case.

In      a Job; requests to hold it, let it go on, or end it.
Out     CASE/job.json: the request, its progress, the time it took in all. A program that is started
        again finds there which jobs were interrupted, and `resume_all` goes on with them.
Method  One thread a job waits for its process (`job_supervision`). Up to `at_once` jobs run at a
        time; others wait in a queue. `_reconcile` starts those whose turn has come, whenever a job
        begins, rests or ends; a job that cannot start ends, and the next one starts. The time left
        is estimated from the seconds a megapixel that stages took in earlier runs on this machine,
        and from the part of the stage that is done; before the first run, from figures of another
        machine, and the reply says so.
Fails   CaseError: a job is running in the case already.
"""

import json
import os
import signal
import statistics
import threading
import time
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from limbgram.cases.case_record import read_kept, utc_now, write_json
from limbgram.cases.child_process import Event
from limbgram.cases.folder import CaseFolder
from limbgram.cases.job_messages import Job, plain_tree, read_job
from limbgram.cases.job_supervision import COMMAND, JobBug, Supervision
from limbgram.core.errors import Cancelled, CaseError, LimbgramError, disk_finding, in_words
from limbgram.core.files import json_of, read_content
from limbgram.core.typed import tree_of
from limbgram.findings import Finding, fault
from limbgram.report.stages import stage_title

JobState = Literal[
    "queued", "running", "held", "cancelled", "interrupted", "refused", "failed", "finished"
]
GRACE_S = 1.5
"""From a request to cancel until the process is killed."""
_SCHEMA = "limbgram-job/1"
_LARGEST_BYTES = 4_000_000
_STOPPED = fault("job.stopped")
_INTERRUPTED = fault("job.interrupted")
_KILLED_TWICE = fault("job.killed_twice")
_ACTIVE = ("queued", "running", "held")
_KILL_TIMEOUT_S = 10.0
"""Longest wait for a killed process to be gone."""
_SAVE_EVERY_S = 2.0
_TIME_LEFT_RANGE = (0.7, 1.6)
"""Shares of the estimated time left, from which to which it is given."""
_RUNS_REMEMBERED = 8
_WRITING = threading.Lock()
"""Held while a job file is written, so that an older state never overwrites a newer one."""

_REFERENCE_S_PER_MP: dict[str, float] = {
    "read_photos": 0.018,
    "cameras_for": 0.0,
    "find_board": 0.013,
    "detect": 0.042,
    "find_still": 0.001,
    "match": 0.033,
    "verify": 0.022,
    "place_roughly": 0.029,
    "follow_points": 0.056,
    "limb_groups": 0.004,
    "to_millimetres": 0.010,
    "find_region": 0.003,
    "estimate_depth": 0.115,
    "fuse": 0.032,
    "pivot": 0.011,
    "tell_parts": 0.008,
    "repair": 0.008,
    "refine": 0.013,
    "measure": 0.109,
    "hold_tapes": 0.0,
    "draw": 0.050,
    "assess": 0.050,
    "deliver": 0.080,
}
"""Seconds a megapixel of photos, in the order of the run: limb_ring15, 15 photos of 2.5 MP, two
processors."""


@dataclass(frozen=True, kw_only=True)
class StageProgress:
    """One stage of a run."""

    name: str
    title: str
    """For people."""
    state: Literal["waiting", "running", "done"]
    done: int = 0
    total: int = 0
    """Steps; 0 where it has none."""
    seconds: float = 0.0


@dataclass(frozen=True, kw_only=True)
class TimeLeft:
    """How long it may still take, s."""

    least_s: float
    most_s: float
    known: bool
    """Estimated from runs on this machine; else from one on another."""


@dataclass(frozen=True, kw_only=True)
class JobFile:
    """What CASE/job.json holds."""

    state: JobState
    order: str
    """The job as its process reads it, JSON."""
    megapixels: float
    """Of all photos together."""
    began: str
    """Date and time, UTC, of the first start."""
    elapsed_s: float = 0.0
    """Of all starts together, without the time that it was held."""
    stages: tuple[StageProgress, ...] = ()
    finding: Finding | None = None
    """Why it did not finish."""
    message: str = ""
    """The same in a file of an earlier version, as a sentence."""
    kind: str = ""
    """Name of the refusal's class."""
    light: str = ""
    process: int = 0
    wanted: bool = False
    """Whether it is resumed when the program is started again."""
    killed: bool = False
    """The program was killed while it ran, and no stage has ended since."""
    schema: str = _SCHEMA

    @property
    def why(self) -> Finding | None:
        """Why it did not finish, whichever version wrote it down."""
        return self.finding or (in_words(self.message) if self.message else None)


@dataclass
class RunningJob:
    """A job with its process and its progress."""

    case: CaseFolder
    file: JobFile
    on_change: Callable[[], None]
    on_finished: Callable[[], None]
    """Called when it ends whole and was never held: its pace is that of the machine."""
    on_idle: Callable[[], None]
    """Called when it ends or is held: another job may start."""
    usual_s_per_mp: dict[str, float]
    usual_known: bool
    _supervision: Supervision | None = None
    _thread: threading.Thread | None = None
    _stop_requested: bool = False
    """Somebody cancelled it; else the system ended its process."""
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _running_since: float = 0.0
    _stage_since: float = 0.0
    _held_since: float | None = None
    _was_held: bool = False
    """What its process says of its stages' times includes its rest."""
    _saved_at: float = 0.0

    def queue(self) -> None:
        """Let it wait for its turn.

        Raises:
            OSError: its file cannot be written.
        """
        with self._lock:
            self.file = replace(self.file, state="queued", wanted=True)
        self._save()

    def begin(self, command: tuple[str, ...]) -> None:
        """Start or resume it; if that fails, it ends as refused or failed."""
        try:
            self._begin(command)
        except OSError as error:
            self._end("refused", disk_finding(error), kind="OSError")
        except LimbgramError as error:
            self._end("refused", error.finding, kind=type(error).__name__)
        except (ValueError, RuntimeError) as error:  # damaged order; no thread can be started
            self._end("failed", _fault(str(error)), kind=type(error).__name__)

    def _begin(self, command: tuple[str, ...]) -> None:
        """Start its process, or resume the one that is held."""
        if not self.case.root.is_dir():
            raise CaseError("job.case_gone")
        with self._lock:
            self.file = replace(self.file, state="running")
            self._running_since = time.monotonic()
            if self._held_since is not None:
                self._stage_since += self._running_since - self._held_since
                self._held_since = None
        if self._supervision is not None:
            self._supervision.resume()
            self._try_save()
            return
        self._stage_since = self._running_since
        job = read_job(json.loads(self.file.order), self.case.root)
        self._supervision = Supervision(
            job, self._on_event, command=command, grace_s=GRACE_S, slack_s=0.0
        )
        self._try_save()
        self._thread = threading.Thread(target=self._wait, name="job", daemon=True)
        self._thread.start()

    @property
    def active(self) -> bool:
        return self.file.state in _ACTIVE

    @property
    def has_process(self) -> bool:
        """Whether it has a process, running or held."""
        return self.active and self._supervision is not None

    @property
    def elapsed_s(self) -> float:
        """Of all starts together, without the time that it was held."""
        now = time.monotonic() - self._running_since if self.file.state == "running" else 0.0
        return self.file.elapsed_s + now

    def hold(self) -> None:
        """Pause it; its process keeps its memory."""
        with self._lock:
            if self.file.state != "running" or self._supervision is None:
                raise CaseError("job.nothing_to_hold")
            if not self._supervision.hold():
                raise CaseError("job.cannot_hold")
            self._held_since, self._was_held = time.monotonic(), True
            self.file = replace(self.file, elapsed_s=self.elapsed_s, state="held", wanted=False)
        self._try_save()
        self.on_idle()
        self.on_change()

    def cancel(self) -> None:
        """End it; finished stages are kept."""
        self._stop_requested = True
        if self._supervision is not None:
            self._supervision.stop()
        elif self.file.state == "queued":
            self._end("cancelled", _STOPPED, kind=Cancelled.__name__)

    def drop(self) -> None:
        """Forget it, since its case is deleted; nothing is written."""
        with self._lock:
            self.file = replace(self.file, state="cancelled", wanted=False)

    def join(self, timeout_s: float) -> None:
        """Wait for its end."""
        if self._thread is not None:
            self._thread.join(timeout_s)

    def time_left(self) -> TimeLeft | None:
        """Estimated time that it still takes; None unless it is running or held, or where nobody
        knows how large its photos are."""
        if self.file.state not in ("running", "held") or self.file.megapixels <= 0:
            return None
        return estimate_time_left(
            self.file, self.usual_s_per_mp, known=self.usual_known, stage_s=self._stage_elapsed_s()
        )

    def _stage_elapsed_s(self) -> float:
        """Of the running stage, without the time that it was held."""
        now = time.monotonic() if self._held_since is None else self._held_since
        return max(0.0, now - self._stage_since)

    def _wait(self) -> None:
        supervision = self._supervision
        assert supervision is not None
        try:
            answer = supervision.wait()
            self._end("finished", light=answer.light)
        except Cancelled as error:
            if self._stop_requested:
                self._end("cancelled", _STOPPED, kind=type(error).__name__)
            else:  # the machine shuts down, and asked every process to end
                self._end("interrupted", _INTERRUPTED, wanted=self.file.wanted)
        except JobBug as bug:
            self._end("failed", _fault(str(bug)), kind="JobBug")
        except LimbgramError as error:
            self._end("refused", error.finding, kind=type(error).__name__)
        except OSError as error:
            self._end("failed", disk_finding(error), kind="OSError")
        finally:
            if self.active:  # a bug passes on; the job must not stay active
                self._end("failed", _fault(), kind="JobBug")

    def _end(
        self,
        state: JobState,
        finding: Finding | None = None,
        *,
        kind: str = "",
        light: str = "",
        wanted: bool = False,
    ) -> None:
        with self._lock:
            stages = tuple(
                replace(one, state="done") if one.state == "running" and state == "finished"
                else replace(one, state="waiting") if one.state == "running" else one
                for one in self.file.stages
            )  # fmt: skip
            ended = replace(
                self.file,
                elapsed_s=self.elapsed_s,
                state=state,
                finding=finding,
                message="",
                kind=kind,
                light=light,
                process=0,
                wanted=wanted,
                stages=stages,
            )
            # Written before it is seen to have ended: what is resumed then begins from this file,
            # and its own is not written over.
            with suppress(OSError):
                self._write(ended)
            self.file = ended
        try:
            if state == "finished" and not self._was_held:
                self.on_finished()
        finally:
            self.on_idle()
            self.on_change()

    def _on_event(self, event: Event) -> None:
        match event:
            case {"event": "progress", "stage": str(stage), "done": int(done), "total": int(total)}:
                self._progress(stage.replace(" ", "_"), done, total)
            case _:
                pass

    def _progress(self, name: str, done: int, total: int) -> None:
        with self._lock:
            stages = list(self.file.stages)
            at = next((k for k, one in enumerate(stages) if one.name == name), None)
            running = next((one.name for one in stages if one.state == "running"), None)
            if running != name:
                seconds, self._stage_since = self._stage_elapsed_s(), time.monotonic()
                stages = [
                    replace(one, state="done", seconds=seconds) if one.state == "running" else one
                    for one in stages
                ]
                if at is None:
                    at = sum(one.state == "done" for one in stages)
                    stages.insert(at, _waiting_stage(name))
                # Stages before the running one that are still waiting were skipped in this run.
                stages = [
                    replace(one, state="done") if k < at and one.state == "waiting" else one
                    for k, one in enumerate(stages)
                ]
            assert at is not None
            stages[at] = replace(stages[at], state="running", done=done, total=total)
            changed = running != name
            process = 0 if self._supervision is None else self._supervision.process_id or 0
            killed = self.file.killed and (running is None or not changed)
            self.file = replace(self.file, stages=tuple(stages), process=process, killed=killed)
        if changed or time.monotonic() - self._saved_at > _SAVE_EVERY_S:
            self._try_save()
        self.on_change()

    def _try_save(self) -> None:
        """Write its file; a full disk does not end the job, and the next write may succeed."""
        with suppress(OSError):
            self._save()

    def _save(self) -> None:
        self._write(replace(self.file, elapsed_s=self.elapsed_s))

    def _write(self, file: JobFile) -> None:
        with _WRITING:
            self._saved_at = time.monotonic()
            write_json(self.case.job_file, tree_of(file))


@dataclass
class Runner:
    """The job queue of a shelf, at most one job a case."""

    pace_file: Path
    """Seconds a megapixel of each stage in earlier runs on this machine."""
    on_change: Callable[[str], None]
    """Called with the name of the case's folder."""
    command: tuple[str, ...] = COMMAND
    """Starts a job's process."""
    at_once: int = 1
    """Jobs that run at a time: each uses all processors, and memory as photos need it."""
    _jobs: dict[Path, RunningJob] = field(default_factory=dict[Path, RunningJob])
    _waiting_jobs: list[RunningJob] = field(default_factory=list[RunningJob])
    """Those that wait for their turn, in that order."""
    _closing: bool = False
    _lock: threading.RLock = field(default_factory=threading.RLock)

    def running(self, case: CaseFolder) -> RunningJob | None:
        """The job of a case that this program started."""
        return self._jobs.get(case.root)

    def start(self, job: Job, megapixels: float) -> RunningJob:
        """Queue a new job.

        Raises:
            CaseError: a job is active in the case, or the file of an earlier one is unreadable.
            OSError: its file cannot be written.
        """
        read_job_file(CaseFolder(job.case))
        return self._start(job, JobFile(
            state="running",
            order=json.dumps(plain_tree(job)),
            megapixels=megapixels,
            began=utc_now(),
        ))  # fmt: skip

    def restart(self, case: CaseFolder) -> RunningJob:
        """Queue a job again that was cancelled, interrupted or refused: finished stages are kept.

        Raises:
            CaseError: the case never had a job.
        """
        kept = read_job_file(case)
        if kept is None:
            raise CaseError("job.never_begun")
        return self._restart(case, replace(kept, killed=False))

    def resume_all(self, cases: Iterable[CaseFolder]) -> None:
        """Queue the jobs that the end of the program interrupted: first those that were running."""
        order: dict[CaseFolder, tuple[bool, int]] = {}
        for case in cases:
            with suppress(
                CaseError, OSError
            ):  # the list of cases reports files that are unreadable
                kept = read_job_file(case)
                if kept is not None:  # the file of a waiting job is written when it is queued
                    order[case] = kept.state == "queued", case.job_file.stat().st_mtime_ns
        for case in sorted(order, key=lambda case: order[case]):
            with suppress(CaseError, OSError, ValueError):  # it stays interrupted
                kept = mark_interrupted(case)
                if kept is not None and kept.wanted:
                    self._restart(case, kept)

    def _restart(self, case: CaseFolder, kept: JobFile) -> RunningJob:
        job = read_job(json.loads(kept.order), case.root)
        return self._start(
            job, replace(kept, state="running", finding=None, message="", kind="", light="")
        )

    def _start(self, job: Job, file: JobFile) -> RunningJob:
        case = CaseFolder(job.case)
        with self._lock:
            known = self._jobs.get(case.root)
            if known is not None and known.active:
                raise CaseError("job.works_already")
            usual_s_per_mp, known = self._usual_pace()
            stages = tuple(_waiting_stage(name) for name in usual_s_per_mp)
            started = RunningJob(
                case=case,
                file=replace(file, stages=stages),
                on_change=lambda: self.on_change(case.root.name),
                on_finished=lambda: self._record_pace(case),
                on_idle=self._reconcile,
                usual_s_per_mp=usual_s_per_mp,
                usual_known=known,
            )
            started.queue()  # before it is listed: if its file cannot be written, nothing is left
            self._jobs[case.root] = started
            self._waiting_jobs.append(started)
        self._reconcile()
        started.on_change()
        return started

    def resume(self, case: CaseFolder) -> None:
        """Resume a job that is held, now or when its turn has come.

        Raises:
            CaseError: no job of the case is held.
        """
        with self._lock:
            job = self._jobs.get(case.root)
            if job is None or job.file.state != "held":
                raise CaseError("job.nothing_rests")
            with suppress(OSError):
                job.queue()
            self._waiting_jobs.append(job)
        self._reconcile()
        job.on_change()

    @contextmanager
    def forgetting(self, case: CaseFolder) -> Generator[None]:
        """Lock the queue while a case is deleted; its waiting job is dropped afterwards.

        If the case cannot be deleted, its job keeps waiting.

        Raises:
            CaseError: the job is running or held.
        """
        with self._lock:
            job = self._jobs.get(case.root)
            if job is not None and job.has_process:
                raise CaseError("job.works")
            yield
            if job is not None:
                job.drop()
                del self._jobs[case.root]
        self._reconcile()

    def jobs_ahead(self, case: CaseFolder) -> int:
        """Number of jobs that run or wait ahead of this case's job; 0 if it does not wait."""
        with self._lock:
            job = self._jobs.get(case.root)
            if job is None or job not in self._waiting_jobs:
                return 0
            return self._waiting_jobs.index(job) + self._running_count()

    def _reconcile(self) -> None:
        """Start the jobs whose turn has come, and drop those that wait no more.

        A job that cannot start ends, which calls this again before the next one is started.
        """
        with self._lock:
            before = len(self._waiting_jobs)
            self._waiting_jobs = [one for one in self._waiting_jobs if one.file.state == "queued"]
            while self._waiting_jobs and not self._closing and self._running_count() < self.at_once:
                self._waiting_jobs.pop(0).begin(self.command)
            moved_up = list(self._waiting_jobs) if len(self._waiting_jobs) != before else []
        for one in moved_up:
            one.on_change()

    def _running_count(self) -> int:
        return sum(one.file.state == "running" for one in self._jobs.values())

    def close(self) -> None:
        """End running jobs; finished stages are kept, and the next start resumes them."""
        self._closing = True
        for job in list(self._jobs.values()):
            if job.active:
                wanted = job.file.wanted
                job.cancel()
                job.join(2 * GRACE_S + 3)
                with suppress(CaseError, OSError):
                    _mark_closed(job.case, wanted=wanted)

    def _record_pace(self, case: CaseFolder) -> None:
        """Keep the seconds a megapixel that the stages of a finished run took."""
        try:
            job = read_job_file(case)
            record = json_of(read_content(case.record, _LARGEST_BYTES, CaseError))
        except (CaseError, ValueError):
            return
        if job is None or job.megapixels <= 0:
            return
        took = {
            str(stage["stage"]): float(stage["wall_s"]) / job.megapixels
            for stage in record.get("stages", [])
            if not stage["reused"] and "wall_s" in stage
        }
        runs = [*self._pace(), took][-_RUNS_REMEMBERED:]
        with suppress(OSError):
            write_json(self.pace_file, {"format": "limbgram pace", "s_per_megapixel": runs})

    def _usual_pace(self) -> tuple[dict[str, float], bool]:
        """Seconds a megapixel of each stage, in order; and whether measured on this machine."""
        runs = [run for run in self._pace() if run]
        if not runs:
            return dict(_REFERENCE_S_PER_MP), False
        usual = dict(_REFERENCE_S_PER_MP)
        for name in usual:
            measured = [run[name] for run in runs if name in run]
            usual[name] = statistics.median(measured) if measured else usual[name]
        return usual, True

    def _pace(self) -> list[dict[str, float]]:
        """Seconds a megapixel of each stage, by earlier run; none if they cannot be read."""
        try:
            tree = json_of(read_content(self.pace_file, _LARGEST_BYTES, CaseError))
            runs = tree["s_per_megapixel"]
            return [{str(name): float(pace) for name, pace in run.items()} for run in runs]
        except (CaseError, ValueError, KeyError, TypeError, AttributeError):
            return []


def read_job_file(case: CaseFolder) -> JobFile | None:
    """The file of a case's job; None where the case never had one.

    Raises:
        CaseError: it is there and cannot be read.
    """
    return read_kept(case.job_file, JobFile, "job")


def mark_interrupted(case: CaseFolder) -> JobFile | None:
    """Mark a job that the end of the program interrupted, and kill its process if it still runs.

    It is to be resumed, unless it was held, or the program was killed twice in the same stage: a
    job that takes the machine down must not be started for ever.

    Raises:
        CaseError: the job's file cannot be read.
    """
    kept = read_job_file(case)
    if kept is None or kept.state not in _ACTIVE:
        return kept
    if kept.process:
        _end_process(kept.process, case)
    ran = kept.state == "running"
    wanted = kept.state == "queued" or (ran and not kept.killed)
    finding = _KILLED_TWICE if ran and kept.killed else _INTERRUPTED
    stages = tuple(
        replace(one, state="waiting") if one.state == "running" else one for one in kept.stages
    )
    kept = replace(
        kept,
        state="interrupted",
        finding=finding,
        message="",
        process=0,
        wanted=wanted,
        killed=kept.killed or ran,
        stages=stages,
    )
    with _WRITING:
        write_json(case.job_file, tree_of(kept))
    return kept


def _mark_closed(case: CaseFolder, *, wanted: bool) -> None:
    """Mark a job as interrupted that was cancelled because the program ends."""
    kept = read_job_file(case)
    if kept is None or kept.state != "cancelled":
        return
    kept = replace(
        kept, state="interrupted", finding=_INTERRUPTED, message="", kind="", wanted=wanted
    )
    with _WRITING:
        write_json(case.job_file, tree_of(kept))


def estimate_time_left(
    job: JobFile, usual_s_per_mp: dict[str, float], *, known: bool, stage_s: float
) -> TimeLeft:
    """Time left, by the usual time of the waiting stages and the rest of the running one.

    Once a tenth of the running stage is done, its own pace counts, not the usual one.

    Args:
        usual_s_per_mp: Seconds a megapixel of each stage.
        known: Whether these were measured on this machine.
        stage_s: Elapsed time of the running stage.
    """
    left_s = 0.0
    for one in job.stages:
        usual = usual_s_per_mp.get(one.name, 0.0) * job.megapixels
        if one.state == "waiting":
            left_s += usual
        elif one.state == "running":
            part = one.done / one.total if one.total else 0.0
            left_s += stage_s * (1 - part) / part if part >= 0.1 else max(0.0, usual - stage_s)
    least, most = _TIME_LEFT_RANGE
    return TimeLeft(least_s=least * left_s, most_s=most * left_s, known=known)


def _fault(trace: str | None = None) -> Finding:
    return fault("job.fault", trace=trace)


def _waiting_stage(name: str) -> StageProgress:
    return StageProgress(name=name, title=stage_title(name), state="waiting")


def _end_process(process: int, case: CaseFolder) -> None:
    """Kill the process of a job, and wait until it is gone: it locks the case until then."""
    if not _is_ours(process, case):
        return
    with suppress(OSError):
        os.kill(process, signal.SIGKILL if hasattr(signal, "SIGKILL") else signal.SIGTERM)
    until = time.monotonic() + _KILL_TIMEOUT_S
    while _is_ours(process, case) and time.monotonic() < until:
        time.sleep(0.02)


def _is_ours(process: int, case: CaseFolder) -> bool:
    """Whether a process is this case's job: the system may have given its id to another one."""
    try:
        words = Path(f"/proc/{process}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return False
    return b"limbgram.cases.job_process" in words and str(case.root).encode() in words
