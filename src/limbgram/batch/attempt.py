"""Attempt: one try at a capture: from its files to a finished case, then the batch's steps.

In      a Plan: the capture, the job of its case, the steps after the surface.
Out     an Outcome, whatever happens: nothing that is wrong with one capture stops another.
        CASE/batch/STEP/ holds what a step wrote, CASE/batch/done.json what was done and from what.
Method  The case is made by its killable process (`job_supervision`), as `limbgram reconstruct`
        has it made. A finished capture is not begun again while its files, the request, the program
        and every byte of the result are unchanged. Else the case computes what is missing, and each
        step is run again if what it reads has changed. An alignment that was corrected by hand
        since is kept, and the steps after it start from it. What a step wrote goes with the surface
        that it was made from, and where the step is not tried or not asked for any more.
"""

import hashlib
import json
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from limbgram.batch.captures import Capture, sources_in
from limbgram.batch.memory import MemoryGate, need_mb
from limbgram.batch.steps import Places, Step, StepRefused, run_step
from limbgram.batch.stopping import Stopping
from limbgram.batch.storage import batch_folder
from limbgram.cases.case_record import read_record, write_json
from limbgram.cases.child_process import Event
from limbgram.cases.deliverables import surface_of
from limbgram.cases.fingerprint import code_version, file_sha256, sha256_if_readable
from limbgram.cases.folder import CaseFolder, incoming, locked
from limbgram.cases.job_messages import Job, plain_tree
from limbgram.cases.job_supervision import GRACE_S, JobBug, JobDied, Supervision
from limbgram.cases.zips import unpack
from limbgram.core.errors import (
    RED_EXIT_CODE,
    Cancelled,
    CaseError,
    LimbgramError,
    PhotoError,
    disk_finding,
)
from limbgram.core.files import json_of, read_content
from limbgram.core.typed import TOLERANT, tree_of, value_of
from limbgram.findings import Finding, fault, note, told
from limbgram.formats.sidecar import limb_file_beside
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.photos.video import is_video
from limbgram.report.verdict_light import Light
from limbgram.workbench.limb import marked_red

State = Literal["finished", "unchanged", "refused", "died", "failed", "cancelled"]
"""How an attempt ended; died: the system or a library ended its process."""

_SCHEMA = "limbgram-batch-case/1"
_LARGEST_BYTES = 16_000_000
_UNPACKED = ".unpacked"
_PATIENCE_S = GRACE_S + 10.0
_STEP_S = 0.2


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What is to be done with a capture."""

    capture: Capture
    job: Job
    """Without sources: where the photos lie is known once a zip is unpacked."""
    photos: str | None = None
    """Folder inside the capture in which they lie."""
    steps: tuple[Step, ...] = ()
    refusal: LimbgramError | None = None
    """Why nothing can be done: the capture's own settings are wrong."""


@dataclass(frozen=True, kw_only=True)
class WrittenFile:
    """A file that a step wrote, in the case."""

    path: str
    sha256: str


@dataclass(frozen=True, kw_only=True)
class StepOutcome:
    """What became of a step."""

    name: str
    state: Literal["done", "kept", "refused", "died"]
    """kept: of an earlier run, because nothing that it reads has changed."""
    finding: Finding | None = None
    """Why it was not done, or is not done anew."""
    message: str = ""
    """The same in a file of an earlier version, in its own words."""
    exit_code: int = 0
    key: str = ""
    files: tuple[WrittenFile, ...] = ()

    @property
    def reason(self) -> str:
        """Why it was not done, in words."""
        return self.message if self.finding is None else told(self.finding)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of a capture."""

    name: str
    source: str
    state: State
    light: Light | None = None
    headline: str = ""
    size_checked: bool | None = None
    """Whether something independent confirms the size; None without a result."""
    finding: Finding | None = None
    """Why it has no result."""
    message: str = ""
    """The same in a file of an earlier version, in its own words."""
    kind: str = ""
    """Of the refusal."""
    exit_code: int = 0
    attempts: int = 0
    seconds: float = 0.0
    steps: tuple[StepOutcome, ...] = ()
    set_aside: tuple[SetAside, ...] = ()
    """What was left out of a result, and why; without a result the finding says it."""

    @property
    def reason(self) -> str:
        """Why it has no result, in words."""
        return self.message if self.finding is None else told(self.finding)

    @property
    def done(self) -> bool:
        """Whether there is a result."""
        return self.state in ("finished", "unchanged")

    @property
    def died(self) -> bool:
        """Whether a process of it died, so that another attempt may go better."""
        return self.state == "died" or any(step.state == "died" for step in self.steps)


@dataclass(frozen=True, kw_only=True)
class _Verdict:
    light: Light
    headline: Finding
    size_checked: bool = False


@dataclass(frozen=True, kw_only=True)
class _Summary:
    """What is read of a case's summary."""

    verdict: _Verdict
    set_aside: tuple[SetAside, ...] = ()


@dataclass(frozen=True, kw_only=True)
class _BatchRecord:
    """What CASE/batch/done.json holds."""

    schema: str = _SCHEMA
    key: str = ""
    """Of all that was asked for; empty until everything is done."""
    steps: tuple[StepOutcome, ...] = ()


def attempt(
    plan: Plan,
    cases: Path,
    number: int,
    listener: Callable[[Event], None],
    stopping: Stopping,
    gate: MemoryGate,
    grace_s: float = GRACE_S,
) -> Outcome:
    """Make one attempt at a capture.

    Args:
        number: Of the attempt, from 1.
        grace_s: Time that a running stage of the reconstruction gets to end when it is stopped.
    """
    began = time.monotonic()
    base = undecided_outcome(plan, number)
    try:
        stopping.check()
        if plan.refusal is not None:
            raise plan.refusal
        with locked(batch_folder(CaseFolder(plan.job.case))):
            try:
                outcome = _made(plan, cases, base, listener, stopping, gate, grace_s)
            finally:
                shutil.rmtree(_unpack_folder(plan, cases), ignore_errors=True)
    except Cancelled as error:
        outcome = failed_outcome(base, "cancelled", error)
    except JobDied as error:
        outcome = failed_outcome(base, "died", error)
    except LimbgramError as error:
        outcome = failed_outcome(base, "refused", error)
    except JobBug as bug:
        outcome = replace(
            base,
            state="failed",
            kind="JobBug",
            exit_code=1,
            finding=fault(
                "batch.fault", log=str(plan.job.case / "log.txt"), trace=str(bug), library=None
            ),
        )
    except OSError as error:
        if error.errno is None:
            raise
        outcome = failed_outcome(base, "refused", CaseError.of(disk_finding(error)))
    return replace(outcome, seconds=round(time.monotonic() - began, 2))


def undecided_outcome(plan: Plan, number: int) -> Outcome:
    """The outcome of a capture before anything is known of it."""
    source = plan.capture.path.name
    return Outcome(name=plan.capture.name, source=source, state="refused", attempts=number)


def unchanged_outcome(plan: Plan, number: int) -> Outcome | None:
    """The result of an earlier batch, if nothing has changed since; nothing is written.

    None also where files or case cannot be read: the attempt says why.
    """
    case = CaseFolder(plan.job.case)
    try:
        return _unchanged(
            undecided_outcome(plan, number), case, _key(plan), _read_batch_record(case)
        )
    except (LimbgramError, OSError):
        return None


def failed_outcome(base: Outcome, state: State, error: LimbgramError) -> Outcome:
    """An outcome without a result, with the reason."""
    return replace(
        base,
        state=state,
        kind=type(error).__name__,
        finding=error.finding,
        exit_code=error.exit_code,
    )


def _made(
    plan: Plan,
    cases: Path,
    base: Outcome,
    listener: Callable[[Event], None],
    stopping: Stopping,
    gate: MemoryGate,
    grace_s: float,
) -> Outcome:
    case = CaseFolder(plan.job.case)
    key, earlier = _key(plan), _read_batch_record(case)
    unchanged = _unchanged(base, case, key, earlier)
    if unchanged is not None:
        return unchanged
    job = replace(plan.job, sources=_sources(plan, cases))
    with gate.hold(need_mb(job.sources), stopping):
        _wait_until_free(case, stopping)
        supervision = Supervision(job, listener, grace_s=grace_s)
        try:
            with stopping.calling(supervision.stop):
                supervision.wait()
        finally:
            if not surface_of(case.deliverables).is_file():
                _remove_outputs(case, [step.name for step in earlier.steps])
    planned = {step.name for step in plan.steps}
    _remove_outputs(case, [step.name for step in earlier.steps if step.name not in planned])
    steps = tuple(_run_steps(plan, case, earlier, listener, stopping))
    complete = all(step.state in ("done", "kept") for step in steps)
    _write_batch_record(case, _BatchRecord(key=key if complete else "", steps=steps))
    return _with_verdict(base, case, steps, "finished")


def _unchanged(base: Outcome, case: CaseFolder, key: str, earlier: _BatchRecord) -> Outcome | None:
    if earlier.key != key or not _is_intact(case, earlier):
        return None
    steps = tuple(replace(step, state="kept") for step in earlier.steps)
    return _with_verdict(base, case, steps, "unchanged")


def _wait_until_free(case: CaseFolder, stopping: Stopping) -> None:
    """Until a process of an earlier batch that was killed itself has ended, at its next step.

    Raises:
        CaseError: somebody else goes on working in the case.
    """
    deadline = time.monotonic() + _PATIENCE_S
    while True:
        try:
            with locked(case):
                return
        except CaseError:
            if time.monotonic() > deadline:
                raise
            stopping.check()
            time.sleep(_STEP_S)


def _sources(plan: Plan, cases: Path) -> tuple[Path, ...]:
    """Where the photos lie; a zip is unpacked beside the cases for as long as it is worked on."""
    place = plan.capture.path
    if plan.capture.kind == "zip":
        place = unpack(place, _unpack_folder(plan, cases))
    return _sources_in(place, plan.photos)


def _sources_in(place: Path, photos: str | None) -> tuple[Path, ...]:
    inside = place if photos is None or place.is_file() else place / photos
    if not inside.exists():
        raise PhotoError("batch.no_photos_folder", capture=str(place), folder=photos)
    return sources_in(inside)


def _unpack_folder(plan: Plan, cases: Path) -> Path:
    return cases / _UNPACKED / plan.capture.name


def _key(plan: Plan) -> str:
    """Key of what the results depend on: the bytes of all files, the request, the program."""
    tree: dict[str, Any] = plain_tree(replace(plan.job, sources=()))
    del tree["case"]
    tree["camera_files"] = [sha256_if_readable(file) for file in plan.job.camera_files]
    tree["sources"] = _content(plan)
    tree["steps"] = [
        [
            step.name,
            *step.words,
            *(sha256_if_readable(file) for file in step.files),
            code_version(step.module),
        ]
        for step in plan.steps
    ]
    tree["program"] = code_version("limbgram.cases.job")
    return _hash(tree)


def _content(plan: Plan) -> list[list[str]]:
    """Names and hashes of the capture's files."""
    place = plan.capture.path
    if place.is_file():
        return [[place.suffix, file_sha256(place), plan.photos or ""]]
    sources = _sources_in(place, plan.photos)
    if any(is_video(source) for source in sources):
        return [[source.name, file_sha256(source)] for source in sources]
    pictures, _ = incoming(sources)
    return sorted([name.as_posix(), sha256_if_readable(source)] for source, name in pictures)


def _hash(tree: object) -> str:
    return hashlib.sha256(json.dumps(tree, sort_keys=True).encode()).hexdigest()


def _is_intact(case: CaseFolder, batch_record: _BatchRecord) -> bool:
    """Whether every file of the case and of the steps is still as it was written."""
    try:
        record = read_record(case)
    except LookupError:
        return False
    pages = (case.page, case.summary, case.accuracy("json"), case.accuracy("html"))
    written = [(file.path, file.sha256) for file in record.files]
    written += [(file.path, file.sha256) for step in batch_record.steps for file in step.files]
    return (
        record.state == "finished"
        and all(page.is_file() for page in pages)
        and all(sha256_if_readable(case.root / path) == sha256 for path, sha256 in written)
    )


def _with_verdict(
    base: Outcome, case: CaseFolder, steps: tuple[StepOutcome, ...], state: State
) -> Outcome:
    """The outcome with the verdict of the case's summary, which its report shows too."""
    try:
        tree = json_of(read_content(case.summary, _LARGEST_BYTES, CaseError))
        summary = value_of(tree, _Summary, "", TOLERANT)
    except ValueError as error:
        raise CaseError(
            "batch.summary_unreadable", path=str(case.summary), why=str(error)
        ) from error
    verdict = summary.verdict
    codes = [step.exit_code for step in steps if step.exit_code]
    codes += [RED_EXIT_CODE] if verdict.light == "red" else []
    return replace(
        base,
        state=state,
        light=verdict.light,
        headline=told(verdict.headline),
        size_checked=verdict.size_checked,
        exit_code=worst_of(codes),
        steps=steps,
        set_aside=summary.set_aside,
    )


_BY_WEIGHT = (0, RED_EXIT_CODE, 4, 2, 3, 5, 6, 1, 130)
"""Exit codes, the worst last: red result, photos that give no result, wrong options, files that
cannot be read or written, process that died, bug of the program, stopped."""


def worst_of(codes: Sequence[int]) -> int:
    """The worst of several exit codes."""
    return max((0, *codes), key=lambda code: _BY_WEIGHT.index(code) if code in _BY_WEIGHT else 7)


def _run_steps(
    plan: Plan,
    case: CaseFolder,
    earlier: _BatchRecord,
    listener: Callable[[Event], None],
    stopping: Stopping,
) -> Iterator[StepOutcome]:
    """Run the steps in their order; a step whose input was refused is not tried."""
    surface = surface_of(case.deliverables)
    shape = surface
    earlier_steps = {step.name: step for step in earlier.steps}
    broken: StepOutcome | None = None
    outcomes: list[StepOutcome] = []
    for step in plan.steps:
        stopping.check()
        if broken is not None:
            _remove_outputs(case, [step.name])
            why = fault("batch.not_tried", step=broken.name)
            yield replace(broken, name=step.name, finding=why, files=(), key="")
            continue
        listener({"event": "progress", "stage": f"then {step.name}", "done": 0, "total": 0})
        out = batch_folder(case).root / step.name
        edited = out / surface.name.replace("surface", "rectified")
        places = Places(surface=surface, shape=shape, edited=edited, case=case.root, out=out)
        outcome = _run_or_keep(step, places, case, earlier_steps.get(step.name), stopping)
        outcomes.append(outcome)
        _write_batch_record(case, _BatchRecord(steps=tuple(outcomes)))
        yield outcome
        if outcome.state in ("refused", "died"):
            broken = outcome if step.kind in ("align", "recipe") else None
        elif step.kind == "recipe":
            shape = edited


def _remove_outputs(case: CaseFolder, names: Sequence[str]) -> None:
    """Remove what steps wrote for a surface that is no more, or that nobody asks for any more."""
    root = batch_folder(case).root
    for folder in root.iterdir() if root.is_dir() else ():
        if folder.name in names and folder.is_dir():
            shutil.rmtree(folder, ignore_errors=True)


def _run_or_keep(
    step: Step, places: Places, case: CaseFolder, earlier: StepOutcome | None, stopping: Stopping
) -> StepOutcome:
    key = _step_key(step, places)
    if earlier is not None and earlier.key == key and _has_its_files(step, earlier, case):
        return _as_kept(step, earlier, places, case)
    shutil.rmtree(places.out, ignore_errors=True)
    places.out.mkdir(parents=True)
    try:
        reply = run_step(_named_as_red(step, places), places, stopping)
    except Cancelled:
        raise
    except LimbgramError as error:
        shutil.rmtree(places.out, ignore_errors=True)
        refused = isinstance(error, StepRefused)
        return StepOutcome(
            name=step.name,
            state="refused" if refused else "died",
            finding=error.finding,
            exit_code=error.exit_code,
        )
    content = {
        name: value.removeprefix(f"{case.root}/") if isinstance(value, str) else value
        for name, value in reply.content.items()
        if name != "written"
    }
    write_json(places.out / f"{step.kind}.json", content)
    return StepOutcome(name=step.name, state="done", key=key, files=_files(step, places, case))


def _named_as_red(step: Step, places: Places) -> Step:
    """The step, its exported file named as red where the surface is."""
    if step.kind != "export" or places.surface.name == "surface.ply":
        return step
    at = step.words.index("-o") + 1
    red = str(marked_red(Path(step.words[at])))
    return replace(step, words=(*step.words[:at], red, *step.words[at + 1 :]))


def _step_key(step: Step, places: Places) -> str:
    """Key of what a step reads: the shape, its limb file (but for align, which writes it), code."""
    reads = [places.surface, places.shape, *step.files]
    if step.kind != "align":
        reads += [limb_file_beside(places.surface), limb_file_beside(places.shape)]
    hashes = [sha256_if_readable(file) for file in reads]
    return _hash([step.words, hashes, code_version(step.module)])


def _has_its_files(step: Step, earlier: StepOutcome, case: CaseFolder) -> bool:
    """Whether a step's files are as they were written; those of align may be edited by hand."""
    if step.kind == "align":
        return all((case.root / file.path).is_file() for file in earlier.files)
    return all(sha256_if_readable(case.root / file.path) == file.sha256 for file in earlier.files)


def _as_kept(step: Step, earlier: StepOutcome, places: Places, case: CaseFolder) -> StepOutcome:
    """The outcome of an earlier run, with the files as they are now."""
    files = _files(step, places, case)
    finding = earlier.finding if files == earlier.files else note("batch.limb_kept_by_hand")
    return replace(earlier, state="kept", finding=finding, files=files)


def _files(step: Step, places: Places, case: CaseFolder) -> tuple[WrittenFile, ...]:
    found = sorted(path for path in places.out.rglob("*") if path.is_file())
    if step.kind == "align":
        found.append(limb_file_beside(places.surface))
    return tuple(
        WrittenFile(path=path.relative_to(case.root).as_posix(), sha256=file_sha256(path))
        for path in found
    )


def _batch_record_file(case: CaseFolder) -> Path:
    return batch_folder(case).root / "done.json"


def _read_batch_record(case: CaseFolder) -> _BatchRecord:
    """What an earlier batch did; an empty record where there is none that can be read."""
    file = _batch_record_file(case)
    if not file.is_file():
        return _BatchRecord()
    try:
        record = value_of(json_of(read_content(file, _LARGEST_BYTES, CaseError)), _BatchRecord)
    except (CaseError, ValueError):
        return _BatchRecord()
    return record if record.schema == _SCHEMA else _BatchRecord()


def _write_batch_record(case: CaseFolder, record: _BatchRecord) -> None:
    write_json(_batch_record_file(case), tree_of(record))
