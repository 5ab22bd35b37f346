"""Cases: the list, and making, naming, archiving, clearing and deleting one."""

import shutil
import threading
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Annotated, Any, Literal, cast

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, Field

from limbgram.app.forms import RequestBody
from limbgram.app.idempotency import forget_acts
from limbgram.app.replies import ADDRESS_ALONE, PICTURE, FindingReply, missing
from limbgram.app.state import AppState, AppStateHere, CaseHere, WorkspaceHere
from limbgram.app.thumbnails import thumbnail_of
from limbgram.cases.case_record import read_verdict, set_aside
from limbgram.cases.job_queue import JobFile, read_job_file
from limbgram.cases.overview import Overview
from limbgram.cases.sample import begin_sample, fill_sample
from limbgram.cases.shelf import Holding, Label, ShelvedCase, last_change
from limbgram.cases.workspace import MAKING, Progress, Workspace
from limbgram.core.errors import CaseError, LimbgramError
from limbgram.core.run import Run
from limbgram.findings import Finding
from limbgram.formats.sidecar import progress_of
from limbgram.report.summary import Verdict as Summary
from limbgram.workbench.limb import KindName, Side

router = APIRouter(tags=["cases"])

State = Literal[
    "empty",
    "photos",
    "computing",
    "held",
    "interrupted",
    "cancelled",
    "refused",
    "failed",
    "finished",
]
StepName = Literal["capture", "result", "align", "measure", "rectify", "send", "record"]
StepState = Literal["locked", "open", "done", "check"]


class Verdict(BaseModel):
    """Green, amber or red, as the case's report says it."""

    light: Literal["green", "amber", "red"]
    headline: FindingReply = Field(description="Its value `verdict` says it without the light.")
    size_checked: bool = Field(description="A length that set no scale, and no print, confirms it.")
    reasons: list[FindingReply] = []
    facts: list[FindingReply] = []


class Step(BaseModel):
    """One step of the work on a case."""

    name: StepName
    state: StepState = Field(
        description="locked: something before it is missing; check: what it rests on changed."
    )
    count: int = Field(
        default=0,
        description="Of what the step has brought: photos, places, girths by tape, edits, files.",
    )
    front: bool = Field(default=False, description="Of align: whether the front is set.")


class Case(BaseModel):
    """A case in the list."""

    id: str
    kind: KindName | None = None
    side: Side | None = None
    note: str = ""
    made: str = Field(description="Date and time, UTC.")
    changed: str = Field(description="Date and time of the last change, UTC.")
    archived: bool = False
    sample: bool = False
    state: State
    message: str = Field(default="", description="Why it was refused, interrupted or failed.")
    finding: FindingReply | None = Field(default=None, description="The message as data.")
    unreadable: list[FindingReply] = Field(
        default=[],
        description="Of files in which people's work is kept and that cannot be read: what, why, "
        "what to do. `set-aside` begins them anew.",
    )
    verdict: Verdict | None = None
    photos: int = Field(
        description="That are here whole and can be used; of several files of one shot one."
    )
    steps: list[Step]
    next: StepName = Field(description="The step to go on with.")
    bytes: int = Field(description="On disk.")
    thumbnail: str | None = Field(default=None, description="Where its picture is.")


class Cases(BaseModel):
    """The list, and the disk."""

    cases: list[Case]
    bytes: int = Field(description="That all cases together use.")
    clearable_bytes: int = Field(description="Intermediate products, which can be made again.")
    free_bytes: int


class NewCase(RequestBody):
    """What is known of a new case; all of it may be said later."""

    kind: KindName | None = None
    side: Side | None = None
    note: str = Field(
        default="", max_length=200, description="A few words; never a patient's name."
    )


class CaseChange(RequestBody):
    """What is to be said otherwise of a case; what is left out stays."""

    kind: KindName | None = None
    side: Side | None = None
    note: str | None = Field(default=None, max_length=200)
    archived: bool | None = None


class Held(BaseModel):
    """What a case's folder holds for one purpose."""

    what: Holding
    files: int
    bytes: int


class Freed(BaseModel):
    """Room on the disk."""

    bytes: int


@router.get("/cases")
def list_cases(
    app_state: AppStateHere,
    find: Annotated[str, Query(max_length=100, description="In id, kind or note.")] = "",
    archived: Annotated[bool | None, Query(description="Only archived ones, or only others.")] = (
        None
    ),
) -> Cases:
    """List the cases, the last changed first."""
    listed = [_listed(app_state, one) for one in app_state.shelf.cases()]
    shown = [one[0] for one in listed if one is not None]
    held = [one[1] for one in listed if one is not None]
    wanted = find.casefold()
    found = [
        one
        for one in shown
        if (archived is None or one.archived == archived)
        and wanted in f"{one.id} {one.kind or ''} {one.note}".casefold()
    ]
    return Cases(
        cases=sorted(found, key=lambda one: one.changed, reverse=True),
        bytes=sum(one.bytes for one in held),
        clearable_bytes=sum(one.clearable_bytes for one in held),
        free_bytes=shutil.disk_usage(app_state.shelf.root).free,
    )


@router.post("/cases", status_code=201)
def new_case(app_state: AppStateHere, given: NewCase, request: Request) -> Case:
    """Begin a case under a random id."""
    made = app_state.shelf.new_case(given.kind, given.side, given.note)
    request.state.case = made.case_id
    app_state.news.tell(made.case_id, "case")
    return case_reply(app_state, made)


@router.post("/cases/sample", status_code=202)
def new_sample(app_state: AppStateHere, request: Request) -> Case:
    """Begin a sample case: the program photographs a limb that never was, in half a minute.

    Its photos arrive one after the other, and a calibrated camera with them; then ask for its shape
    as for any other.
    """
    if not app_state.sampling.acquire(blocking=False):
        raise CaseError("app.sample_underway")
    with ExitStack() as undoing:
        undoing.callback(app_state.sampling.release)
        made = begin_sample(app_state.shelf)
        undoing.pop_all()
    request.state.case = made.case_id

    def work() -> None:
        try:
            fill_sample(app_state.shelf, made, Run())
        except LookupError:
            if made.folder.root.is_dir():  # else it was deleted while it was made
                raise
        finally:
            app_state.sampling.release()
            app_state.news.tell(made.case_id, "photos")
            app_state.news.tell("cameras", made.case_id)

    threading.Thread(target=work, name="sample", daemon=True).start()
    app_state.news.tell(made.case_id, "case")
    return case_reply(app_state, made)


@router.get("/cases/{case_id}")
def read_case(app_state: AppStateHere, case: CaseHere) -> Case:
    """One case."""
    return case_reply(app_state, case)


@router.patch("/cases/{case_id}")
def change_case(app_state: AppStateHere, case: CaseHere, given: CaseChange) -> Case:
    """Say something else of a case: kind, side, note, archived."""
    said: dict[str, Any] = given.model_dump(exclude_unset=True)
    keep = {name: value for name, value in said.items() if value is not None or name in _MAY_BE_NO}
    with app_state.shape_cache.changing(Workspace(case)):
        case.relabel(replace(case.label, **keep))
    app_state.news.tell(case.case_id, "case")
    return case_reply(app_state, case)


@router.delete("/cases/{case_id}", status_code=204)
def delete_case(app_state: AppStateHere, case: CaseHere) -> None:
    """Delete a case for good; `contents` lists what goes."""
    workspace = Workspace(case)
    with (
        app_state.shape_cache.changing(workspace),
        MAKING.of(workspace.root),
        app_state.runner.forgetting(case.folder),
    ):
        going = app_state.shelf.take_out(case)
        forget_acts(app_state.shelf, case.case_id)
    app_state.live_checks.drop(case)
    app_state.phone_ports.close(case)
    app_state.shape_cache.forget(workspace)
    app_state.overviews.forget(case)
    app_state.news.tell(case.case_id, "case")
    shutil.rmtree(going, ignore_errors=True)


@router.post("/cases/{case_id}/set-aside")
def set_aside_unreadable(
    app_state: AppStateHere, case: CaseHere, workspace: WorkspaceHere
) -> list[str]:
    """Begin files anew that cannot be read; each stays beside, under the name that is told."""
    with app_state.shape_cache.changing(workspace):
        aside = [set_aside(one).name for one in _read_all(workspace).faults]
    for subject in ("case", "job", "work"):
        app_state.news.tell(case.case_id, subject)
    return aside


@router.get("/cases/{case_id}/contents")
def list_contents(case: CaseHere) -> list[Held]:
    """What a case's folder holds, and would lose."""
    return [Held(what=one.what, files=one.files, bytes=one.bytes) for one in case.holdings()]


@router.post("/cases/{case_id}/clear")
def clear_case(app_state: AppStateHere, case: CaseHere) -> Freed:
    """Remove intermediate products; photos, results and work stay."""
    with app_state.shape_cache.changing(Workspace(case)):
        freed = case.clear_intermediate()
    app_state.news.tell(case.case_id, "case")
    return Freed(bytes=freed)


@router.get("/cases/{case_id}/thumbnail", response_class=Response, responses=PICTURE)
def read_thumbnail(
    case: CaseHere,
    _drawn: Annotated[str, Query(alias="drawn", max_length=64, description=ADDRESS_ALONE)] = "",
) -> Response:
    """A small picture of the case's surface, without a ground."""
    if case.thumbnail is None:
        raise missing("app.no_picture")
    changed = case.thumbnail.stat().st_mtime_ns
    return Response(
        thumbnail_of(case.thumbnail, changed),
        media_type="image/png",
        headers={"cache-control": "private, max-age=60"},
    )


_MAY_BE_NO = ("kind", "side")


@dataclass(frozen=True)
class _Kept:
    """Files of a case in which people's work is kept: what they say, or why it cannot be read."""

    values: dict[FilePath, object]
    faults: dict[FilePath, Finding]


def _read_all(workspace: Workspace) -> _Kept:
    """Read each by itself: one that cannot be read hides nothing of the others."""
    case, kept = workspace.case, _Kept({}, {})
    readers: dict[FilePath, Callable[[], object]] = {
        case.label_file: lambda: case.label,
        case.folder.record: lambda: read_verdict(case.folder),
        case.folder.job_file: lambda: read_job_file(case.folder),
        workspace.tape_file: workspace.tape,
        workspace.recipe_file: workspace.require_recipe,
    }
    limb_file = workspace.limb_file
    if limb_file is not None:
        readers[limb_file] = lambda: progress_of(limb_file)
    for file, read in readers.items():
        if not file.is_file():
            continue
        try:
            kept.values[file] = read()
        except LimbgramError as error:
            kept.faults[file] = error.finding
    return kept


def case_reply(app_state: AppState, case: ShelvedCase) -> Case:
    """What the list says of a case; one file that cannot be read hides nothing of the others."""
    seen, workspace = app_state.overviews.of(case), Workspace(case)
    kept, photos = _read_all(workspace), seen.photos
    label = cast(Label | None, kept.values.get(case.label_file)) or case.unlabelled
    verdict = cast(Summary | None, kept.values.get(case.folder.record))
    hidden = {workspace.tape_file, workspace.limb_file} & kept.faults.keys()
    progress = workspace.progress() if workspace.has_scan() and not hidden else None
    running = app_state.runner.running(case.folder)
    job = running.file if running else cast(JobFile | None, kept.values.get(case.folder.job_file))
    state: State = "finished" if verdict is not None else "photos" if photos else "empty"
    why: Finding | None = None
    if running is not None and running.active:
        state = "held" if running.file.state == "held" else "computing"
    elif job is not None and job.state != "finished" and state != "finished":
        state = "interrupted" if job.state in ("running", "queued") else job.state
        why = job.why
    found = None if why is None else FindingReply.of(why, app_state.shelf.root)
    said = (
        None
        if verdict is None
        else Verdict(
            light=verdict.light,
            headline=FindingReply.of(verdict.headline),
            size_checked=verdict.size_checked,
            reasons=[FindingReply.of(one) for one in verdict.reasons],
            facts=[FindingReply.of(one) for one in verdict.facts],
        )
    )
    steps = _steps(workspace, seen, progress, state)
    return Case(
        id=case.case_id,
        kind=label.kind,
        side=label.side,
        note=label.note,
        made=label.made,
        changed=last_change(case),
        archived=label.archived,
        sample=label.sample,
        state=state,
        message="" if found is None else found.sentence,
        finding=found,
        unreadable=[FindingReply.of(one, app_state.shelf.root) for one in kept.faults.values()],
        verdict=said,
        photos=photos,
        steps=steps,
        next=_next(steps),
        bytes=seen.bytes,
        thumbnail=_thumbnail_address(case),
    )


def _thumbnail_address(case: ShelvedCase) -> str | None:
    """Where the picture is: another one once it was drawn anew, which no browser has yet."""
    try:
        drawn = case.folder.surface_picture.stat().st_mtime_ns
    except OSError:  # none, or moved aside just now
        return None
    return f"/api/v1/cases/{case.case_id}/thumbnail?drawn={drawn:x}"


def _listed(app_state: AppState, case: ShelvedCase) -> tuple[Case, Overview] | None:
    """A case and the room it takes; None where it is deleted just now."""
    try:
        return case_reply(app_state, case), app_state.overviews.of(case)
    except (OSError, ValueError, LimbgramError):
        if case.folder.root.is_dir():
            raise
        return None


def _next(steps: list[Step]) -> StepName:
    """The first step that waits for somebody."""
    for one in steps:
        if one.state in ("open", "check"):
            return one.name
    return "record"


def _steps(
    workspace: Workspace,
    seen: Overview,
    progress: Progress | None,
    state: State,
) -> list[Step]:
    scan, stale = workspace.has_scan(), seen.stale
    aligned = progress is not None and progress.aligned
    capture: StepState = "done" if scan else "open"
    result: StepState = "locked" if not scan and state in ("empty", "photos") else (
        "done" if scan and state != "computing" else "open"
    )  # fmt: skip
    of_scan: StepState = "locked" if not scan else "check" if stale else "open"

    def after(done: bool) -> StepState:
        return "locked" if not aligned else "check" if stale else "done" if done else "open"

    places = 0 if progress is None else progress.landmarks
    edits = 0 if progress is None else progress.edits
    files = 0 if progress is None else progress.files
    tapes = 0 if progress is None else progress.tapes
    return [
        Step(name="capture", state=capture, count=seen.photos),
        Step(name="result", state=result),
        Step(
            name="align",
            state="done" if aligned and not stale else of_scan,
            count=places,
            front=aligned,
        ),
        Step(name="measure", state=after(tapes > 0), count=tapes),
        Step(name="rectify", state=after(edits > 0), count=edits),
        Step(name="send", state=after(files > 0), count=files),
        Step(name="record", state="locked" if not aligned else "open"),
    ]
