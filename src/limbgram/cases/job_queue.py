"""Job queue: a queue of jobs in child processes, each with a status file in its case.

In      a Job; requests to hold it, let it go on, or end it.
Out     CASE/job.json: what was asked for, how far it is, how long it took in all. A program that
        was ended meanwhile finds there what is still wanted, and `take_up` goes on with it.
Method  One thread a job waits for its process (`job_supervision`). So many work at once as the
        runner was told; others wait in a line. `_reconcile` holds what is wanted against what works
        whenever one of them changes; what fails in it ends that one job, and the next begins. Time
        left is told by what the stages of earlier runs took a megapixel on this machine, and by the
        part of the stage that is done; before the first run, by figures of another machine, which
        is said.
Fails   CaseError: a run is working in the case already.
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
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal, cast

from limbgram.cases.case_record import read_kept, write_json
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
"""Between the wish to cancel and the end of the process."""
_SCHEMA = "limbgram-job/1"
_LARGEST = 4_000_000
_STOPPED = fault("job.stopped")
_INTERRUPTED = fault("job.interrupted")
_KILLED_TWICE = fault("job.killed_twice")
_ACTIVE = ("queued", "running", "held")
_DIES_S = 10.0
"""As long as a process that was ended by the system may take to be gone."""
_SAVE_EVERY_S = 2.0
_SPREAD = (0.7, 1.6)
"""Time left is told from so much of the likely time to so much of it."""
_REMEMBERED = 8
_WRITING = threading.Lock()
"""Threads that write the same file beside its place would take it from each other."""

_USUAL_S: dict[str, float] = {
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
    """Told by runs on this machine; else by one on another."""


@dataclass(frozen=True, kw_only=True)
class JobFile:
    """What is kept of a job."""

    state: JobState
    order: str
    """The job as its process reads it, JSON."""
    megapixels: float
    """Of all photos together."""
    began: str
    """Date and time, UTC, of the first start."""
    elapsed_s: float = 0.0
    """In all starts together, without the time that it was held."""
    stages: tuple[StageProgress, ...] = ()
    finding: Finding | None = None
    """Why it did not finish."""
    message: str = ""
    """The same in a file of an earlier version, in its own words."""
    kind: str = ""
    """Of the refusal."""
    light: str = ""
    process: int = 0
    wanted: bool = False
    """Whether it goes on by itself when the program is opened again."""
    killed: bool = False
    """The program was killed while it ran, and no stage has ended since."""
    schema: str = _SCHEMA

    @property
    def why(self) -> Finding | None:
        """Why it did not finish, whichever version wrote it down."""
        return self.finding or (in_words(self.message) if self.message else None)


@dataclass
class RunningJob:
    """A job in its process, and how far it is."""

    case: CaseFolder
    file: JobFile
    on_change: Callable[[], None]
    on_finished: Callable[[], None]
    on_rest: Callable[[], None]
    """Called when it works no more, or not for now: another one may begin."""
    usual_s: dict[str, float]
    usual_known: bool
    _supervision: Supervision | None = None
    _thread: threading.Thread | None = None
    _asked: bool = False
    """Somebody asked to end it; its process may be ended by the system too."""
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _since: float = 0.0
    _stage_since: float = 0.0
    _saved: float = 0.0

    def queue(self) -> None:
        """Wait for its turn.

        Raises:
            OSError: that cannot be written down.
        """
        with self._lock:
            self.file = replace(self.file, state="queued", wanted=True)
        self._save()

    def begin(self, command: tuple[str, ...]) -> None:
        """Its turn has come; where it cannot begin it is refused."""
        try:
            self._begin(command)
        except OSError as error:
            self._end("refused", disk_finding(error), kind="OSError")
        except LimbgramError as error:
            self._end("refused", error.finding, kind=type(error).__name__)
        except (ValueError, RuntimeError) as error:  # its order is damaged; no thread is to be had
            self._end("failed", _fault(str(error)), kind=type(error).__name__)

    def _begin(self, command: tuple[str, ...]) -> None:
        """Start its process, or let the one that rests go on."""
        if not self.case.root.is_dir():
            raise CaseError("job.case_gone")
        with self._lock:
            self.file = replace(self.file, state="running")
            self._since = time.monotonic()
        if self._supervision is not None:
            self._supervision.go_on()
            self._try_save()
            return
        self._stage_since = self._since
        job = read_job(json.loads(self.file.order), self.case.root)
        self._supervision = Supervision(
            job, self._hear, command=command, grace_s=GRACE_S, slack_s=0.0
        )
        self._try_save()
        self._thread = threading.Thread(target=self._wait, name="job", daemon=True)
        self._thread.start()

    @property
    def active(self) -> bool:
        return self.file.state in _ACTIVE

    @property
    def has_process(self) -> bool:
        """Whether a process of it works or rests."""
        return self.active and self._supervision is not None

    @property
    def elapsed_s(self) -> float:
        """Of all starts together."""
        now = time.monotonic() - self._since if self.file.state == "running" else 0.0
        return self.file.elapsed_s + now

    def hold(self) -> None:
        """Let it rest."""
        with self._lock:
            if self.file.state != "running" or self._supervision is None:
                raise CaseError("job.nothing_to_hold")
            if not self._supervision.hold():
                raise CaseError("job.cannot_hold")
            self.file = replace(self.file, elapsed_s=self.elapsed_s, state="held", wanted=False)
        self._try_save()
        self.on_rest()
        self.on_change()

    def cancel(self) -> None:
        """End it; what is finished is kept."""
        self._asked = True
        if self._supervision is not None:
            self._supervision.stop()
        elif self.file.state == "queued":
            self._end("cancelled", _STOPPED, kind=Cancelled.__name__)

    def drop(self) -> None:
        """Its case goes: wait no more, and write nothing down."""
        with self._lock:
            self.file = replace(self.file, state="cancelled", wanted=False)

    def join(self, timeout_s: float) -> None:
        """Wait for its end."""
        if self._thread is not None:
            self._thread.join(timeout_s)

    def left(self) -> TimeLeft | None:
        """How long it may still take; None where nobody knows."""
        if self.file.state not in ("running", "held"):
            return None
        return time_left(self.file, self.usual_s, known=self.usual_known, stage_s=self._stage_s())

    def _stage_s(self) -> float:
        return time.monotonic() - self._stage_since

    def _wait(self) -> None:
        supervision = self._supervision
        assert supervision is not None
        try:
            answer = supervision.wait()
            self._end("finished", light=answer.light)
        except Cancelled as error:
            if self._asked:
                self._end("cancelled", _STOPPED, kind=type(error).__name__)
            else:  # as the machine shuts down: every process is asked to end
                self._end("interrupted", _INTERRUPTED, wanted=self.file.wanted)
        except JobBug as bug:
            self._end("failed", _fault(str(bug)), kind="JobBug")
        except LimbgramError as error:
            self._end("refused", error.finding, kind=type(error).__name__)
        except OSError as error:
            self._end("failed", disk_finding(error), kind="OSError")
        finally:
            if self.active:  # a fault of ours passes on, and nobody waits for this one
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
            self.file = replace(
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
        try:
            self._try_save()
            if state == "finished":
                self.on_finished()
        finally:
            self.on_rest()
            self.on_change()

    def _hear(self, event: Event) -> None:
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
                seconds, self._stage_since = self._stage_s(), time.monotonic()
                stages = [
                    replace(one, state="done", seconds=seconds) if one.state == "running" else one
                    for one in stages
                ]
                if at is None:
                    at = sum(one.state == "done" for one in stages)
                    stages.insert(at, _waiting(name))
                # What lies before a stage that runs was passed over in this run.
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
        if changed or time.monotonic() - self._saved > _SAVE_EVERY_S:
            self._try_save()
        self.on_change()

    def _try_save(self) -> None:
        """Where the disk takes no more, what is in memory goes on; the next one may be written."""
        with suppress(OSError):
            self._save()

    def _save(self) -> None:
        """One at a time, so that what an older state was does not end up as the last word."""
        with _WRITING:
            self._saved = time.monotonic()
            write_json(job_file(self.case), tree_of(replace(self.file, elapsed_s=self.elapsed_s)))


@dataclass
class Runner:
    """The jobs of a shelf, one a case."""

    pace_file: Path
    """What stages took in earlier runs on this machine."""
    on_change: Callable[[str], None]
    """Called with the name of the case's folder."""
    command: tuple[str, ...] = COMMAND
    """That starts a job's process."""
    at_once: int = 1
    """So many work at a time: each uses all processors, and memory as photos need it."""
    _jobs: dict[Path, RunningJob] = field(default_factory=dict[Path, RunningJob])
    _line: list[RunningJob] = field(default_factory=list[RunningJob])
    """Those that wait for their turn, the first first."""
    _closing: bool = False
    _lock: threading.RLock = field(default_factory=threading.RLock)

    def running(self, case: CaseFolder) -> RunningJob | None:
        """The job of a case that this program started."""
        return self._jobs.get(case.root)

    def start(self, job: Job, megapixels: float) -> RunningJob:
        """Start a job that was not asked for before.

        Raises:
            CaseError: one is working in the case, or what is known of an earlier one is unreadable.
            OSError: it cannot be written down.
        """
        read_job_file(CaseFolder(job.case))
        return self._start(job, JobFile(
            state="running",
            order=json.dumps(plain_tree(job)),
            megapixels=megapixels,
            began=datetime.now(UTC).isoformat(timespec="seconds"),
        ))  # fmt: skip

    def again(self, case: CaseFolder) -> RunningJob:
        """Take up what was cancelled, interrupted or refused: finished stages are kept.

        Raises:
            CaseError: nothing was ever asked for.
        """
        kept = read_job_file(case)
        if kept is None:
            raise CaseError("job.never_begun")
        return self._again(case, replace(kept, killed=False))

    def take_up(self, cases: Iterable[CaseFolder]) -> None:
        """Go on with what was wanted when the program ended: what ran first, then what waited."""
        found: dict[CaseFolder, tuple[bool, int]] = {}
        for case in cases:
            with suppress(CaseError, OSError):  # one that cannot be read is told in the list
                before = read_job_file(case)
                if before is not None:  # what waits is written when it is asked for
                    since = job_file(case).stat().st_mtime_ns
                    found[case] = before.state == "queued", since
        for case in sorted(found, key=lambda case: found[case]):
            with suppress(CaseError, OSError, ValueError):  # it stays interrupted
                kept = mark_interrupted(case)
                if kept is not None and kept.wanted:
                    self._again(case, kept)

    def _again(self, case: CaseFolder, kept: JobFile) -> RunningJob:
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
            usual, own = self._usual()
            stages = tuple(_waiting(name) for name in usual)
            started = RunningJob(
                case=case,
                file=replace(file, stages=stages),
                on_change=lambda: self.on_change(case.root.name),
                on_finished=lambda: self._learn(case),
                on_rest=self._reconcile,
                usual_s=usual,
                usual_known=own,
            )
            started.queue()  # one that cannot be written down leaves nothing behind
            self._jobs[case.root] = started
            self._line.append(started)
        self._reconcile()
        started.on_change()
        return started

    def go_on(self, case: CaseFolder) -> None:
        """Let a job that rests go on, now or when its turn has come.

        Raises:
            CaseError: nothing rests in the case.
        """
        with self._lock:
            job = self._jobs.get(case.root)
            if job is None or job.file.state != "held":
                raise CaseError("job.nothing_rests")
            with suppress(OSError):
                job.queue()
            self._line.append(job)
        self._reconcile()
        job.on_change()

    @contextmanager
    def forgetting(self, case: CaseFolder) -> Generator[None]:
        """Held while a case is deleted: no job begins meanwhile, and its own is gone with it.

        Where the case cannot be deleted its job waits on.

        Raises:
            CaseError: it works or rests.
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

    def before(self, case: CaseFolder) -> int:
        """How many runs work or wait before this one may begin; 0 where it does not wait."""
        with self._lock:
            job = self._jobs.get(case.root)
            if job is None or job not in self._line:
                return 0
            return self._line.index(job) + self._working()

    def _reconcile(self) -> None:
        """Let those begin whose turn has come, and those go that wait no more.

        A job that cannot begin ends, and asks here again before the next one is looked at.
        """
        with self._lock:
            was = len(self._line)
            self._line = [one for one in self._line if one.file.state == "queued"]
            while self._line and not self._closing and self._working() < self.at_once:
                self._line.pop(0).begin(self.command)
            waiting = list(self._line) if len(self._line) != was else []
        for one in waiting:
            one.on_change()

    def _working(self) -> int:
        return sum(one.file.state == "running" for one in self._jobs.values())

    def close(self) -> None:
        """End what still runs: what is finished is kept, and goes on when the program is opened."""
        self._closing = True
        for job in list(self._jobs.values()):
            if job.active:
                wanted = job.file.wanted
                job.cancel()
                job.join(2 * GRACE_S + 3)
                with suppress(CaseError, OSError):
                    _close(job.case, wanted=wanted)

    def _learn(self, case: CaseFolder) -> None:
        """Remember what the stages of a finished run took."""
        try:
            job = read_job_file(case)
            record = json_of(read_content(case.record, _LARGEST, CaseError))
        except (CaseError, ValueError):
            return
        if job is None or job.megapixels <= 0:
            return
        took = {
            str(stage["stage"]): float(stage["wall_s"]) / job.megapixels
            for stage in record.get("stages", [])
            if not stage["reused"] and "wall_s" in stage
        }
        runs = [*self._pace(), took][-_REMEMBERED:]
        with suppress(OSError):
            write_json(self.pace_file, {"format": "limbgram pace", "s_per_megapixel": runs})

    def _usual(self) -> tuple[dict[str, float], bool]:
        """Seconds a megapixel of each stage, in order; and whether this machine's."""
        runs = [run for run in self._pace() if run]
        if not runs:
            return dict(_USUAL_S), False
        usual = dict(_USUAL_S)
        for name in usual:
            own = [run[name] for run in runs if name in run]
            usual[name] = statistics.median(own) if own else usual[name]
        return usual, True

    def _pace(self) -> list[dict[str, float]]:
        try:
            tree = json_of(read_content(self.pace_file, _LARGEST, CaseError))
            return cast(list[dict[str, float]], tree["s_per_megapixel"])
        except (CaseError, ValueError, KeyError, TypeError):
            return []


def read_job_file(case: CaseFolder) -> JobFile | None:
    """What is kept of a case's job; None where none was begun.

    Raises:
        CaseError: it is there and cannot be read.
    """
    return read_kept(job_file(case), JobFile, "job")


def mark_interrupted(case: CaseFolder) -> JobFile | None:
    """Say of a job that nobody waits for any more that it was interrupted; end what rests of it.

    It is wanted still, unless it rested, or the program was killed twice in the same stage: what
    takes the machine down is not begun again for ever.

    Raises:
        CaseError: what is kept of the job cannot be read.
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
        write_json(job_file(case), tree_of(kept))
    return kept


def _close(case: CaseFolder, *, wanted: bool) -> None:
    """The program ends as it was asked to, and with it a job, which may be wanted still."""
    kept = read_job_file(case)
    if kept is None or kept.state != "cancelled":
        return
    kept = replace(
        kept, state="interrupted", finding=_INTERRUPTED, message="", kind="", wanted=wanted
    )
    with _WRITING:
        write_json(job_file(case), tree_of(kept))


def time_left(job: JobFile, usual_s: dict[str, float], *, known: bool, stage_s: float) -> TimeLeft:
    """By the usual cost of the stages that wait, and of the part of the running one that is left.

    A stage that takes longer than usual is told by its own pace once a tenth of it is done.
    """
    left = 0.0
    for one in job.stages:
        usual = usual_s.get(one.name, 0.0) * job.megapixels
        if one.state == "waiting":
            left += usual
        elif one.state == "running":
            part = one.done / one.total if one.total else 0.0
            own = stage_s * (1 - part) / part if part >= 0.1 else max(0.0, usual - stage_s)
            left += own
    return TimeLeft(least_s=_SPREAD[0] * left, most_s=_SPREAD[1] * left, known=known)


def _fault(trace: str | None = None) -> Finding:
    return fault("job.fault", trace=trace)


def _waiting(name: str) -> StageProgress:
    return StageProgress(name=name, title=stage_title(name), state="waiting")


def job_file(case: CaseFolder) -> Path:
    """Where it is kept."""
    return case.root / "job.json"


def _end_process(process: int, case: CaseFolder) -> None:
    """End what rests of a job, and wait until it is gone: it holds the case as long as it is."""
    if not _is_ours(process, case):
        return
    with suppress(OSError):
        os.kill(process, signal.SIGKILL if hasattr(signal, "SIGKILL") else signal.SIGTERM)
    until = time.monotonic() + _DIES_S
    while _is_ours(process, case) and time.monotonic() < until:
        time.sleep(0.02)


def _is_ours(process: int, case: CaseFolder) -> bool:
    """Whether a process is this case's job: its id may belong to another process by now."""
    try:
        words = Path(f"/proc/{process}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return False
    return b"limbgram.cases.job_process" in words and str(case.root).encode() in words
