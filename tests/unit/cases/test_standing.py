"""A result stays while it answers what is asked; one that no longer does is set aside visibly."""

import io
import json
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from limbgram.cases import job_worker
from limbgram.cases import superseded as standing
from limbgram.cases.folder import CaseFolder
from limbgram.cases.job import Done
from limbgram.cases.job_messages import Answer, Job
from limbgram.cases.stage_cache import CachingRun
from limbgram.cases.superseded import key_of
from limbgram.core.errors import Cancelled, LimbgramError, ScaleError

VERDICT = {"light": "green", "headline": "GREEN: 0.05 mm.", "reasons": [], "facts": []}
Run = Callable[..., dict[str, Any]]


@pytest.fixture
def job(tmp_path: Path) -> Job:
    photos = tmp_path / "photos"
    photos.mkdir()
    for name in ("a.jpg", "b.jpg"):
        (photos / name).write_bytes(name.encode())
    return Job(case=tmp_path / "case", sources=(photos,))


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Run:
    """Do a job whose stages are replaced by writing results, or by a refusal."""

    def do_so(job: Job, outcome: BaseException | str) -> dict[str, Any]:
        case = CaseFolder(job.case)
        case.root.mkdir(exist_ok=True)

        def do(_job: Job, _run: CachingRun) -> Done:
            if not isinstance(outcome, str):
                raise outcome
            for path in written(case):
                path.parent.mkdir(exist_ok=True)
                path.write_text(outcome)
            return Done(None, VERDICT, Answer(summary=_job.case / "summary.json"))  # type: ignore[arg-type]

        monkeypatch.setattr(job_worker, "do", do)
        monkeypatch.setattr(job_worker, "write_record", recorded)
        with suppress(LimbgramError):
            job_worker._do_and_record(job, CachingRun(case=case), job_worker.Events(io.StringIO()))
        return record_of(case)

    plain = job_worker.write_record

    def recorded(case: CaseFolder, state: Any, run: CachingRun, *args: Any, **more: Any) -> None:
        plain(case, state, run, None, *(args[1:]), **more)

    return do_so


def record_of(case: CaseFolder) -> dict[str, Any]:
    return json.loads(case.record.read_text("utf-8"))


def written(case: CaseFolder) -> list[Path]:
    return [
        case.page,
        case.summary,
        case.accuracy("json"),
        case.accuracy("html"),
        case.accuracy("pdf"),
        case.deliverables / "surface.stl",
        case.report / "a.png",
    ]


def test_a_refused_run_leaves_no_result_of_another_in_its_place(job: Job, run: Run) -> None:
    case = CaseFolder(job.case)
    record = run(job, "first")
    assert record["state"] == "finished"
    assert record["verdict"] == VERDICT
    assert record["superseded"] is None
    record = run(replace(job, unscaled=True), ScaleError("no board"))
    assert (record["state"], record["message"]) == ("refused", "no board")
    assert record["superseded"] == "superseded"
    assert record["verdict"] is None
    assert not any(path.exists() for path in written(case))
    aside = [case.superseded / path.relative_to(case.root) for path in written(case)]
    assert all(path.read_text() == "first" for path in aside)
    assert "earlier run" in (case.superseded / "READ-ME.txt").read_text("utf-8")
    kept = json.loads((case.superseded / "case.json").read_text("utf-8"))
    assert kept["verdict"] == VERDICT


def test_what_was_set_aside_goes_when_a_run_finishes(job: Job, run: Run) -> None:
    case = CaseFolder(job.case)
    run(job, "first")
    other = replace(job, unscaled=True)
    run(other, ScaleError("no board"))
    record = run(other, "second")
    assert not case.superseded.exists()
    assert record["superseded"] is None
    assert all(path.read_text() == "second" for path in written(case))


@pytest.mark.parametrize("ending", [Cancelled("stopped"), ScaleError("the disk"), RuntimeError()])
def test_the_same_run_again_keeps_its_result_however_it_ends(
    job: Job, run: Run, ending: BaseException
) -> None:
    case = CaseFolder(job.case)
    before = run(job, "first")
    if isinstance(ending, LimbgramError):
        record = run(job, ending)
        assert str(ending) in record["message"]
        assert {**record, "message": "", "finding": None} == before
    else:
        with pytest.raises(RuntimeError):
            run(job, ending)
        assert record_of(case) == before
    assert all(path.read_text() == "first" for path in written(case))
    assert not case.superseded.exists()


def test_a_run_that_cannot_begin_touches_nothing(job: Job, run: Run) -> None:
    case = CaseFolder(job.case)
    before = run(job, "first")
    record = run(replace(job, sources=(job.case / "nowhere",)), "never")
    assert "nowhere does not exist" in record["message"]
    assert {**record, "message": "", "finding": None} == before
    assert all(path.read_text() == "first" for path in written(case))


def test_a_cancelled_run_with_other_photos_leaves_no_old_page(job: Job, run: Run) -> None:
    case = CaseFolder(job.case)
    run(job, "first")
    (job.sources[0] / "c.jpg").write_bytes(b"c")
    record = run(job, Cancelled("stopped"))
    assert record["state"] == "cancelled"
    assert not case.page.exists()
    assert (case.superseded / "report.html").read_text() == "first"


def test_results_of_unknown_origin_do_not_stand(job: Job, run: Run) -> None:
    """Cases of versions that kept no key, and cases of which a file is gone."""
    case = CaseFolder(job.case)
    before = run(job, "first")
    del before["job"]
    case.record.write_text(json.dumps(before))
    assert run(job, ScaleError("x"))["state"] == "refused"
    run(job, "second")
    case.page.unlink()
    assert run(job, ScaleError("x"))["state"] == "refused"
    assert not case.deliverables.exists()


@pytest.mark.parametrize("moves", range(9))
def test_a_kill_at_any_move_leaves_no_page_that_no_record_speaks_for(
    job: Job, run: Run, monkeypatch: pytest.MonkeyPatch, moves: int
) -> None:
    """Every rename on the way counted down to the one that never happens."""
    case = CaseFolder(job.case)
    run(job, "first")
    other = replace(job, unscaled=True)
    left = [moves]
    plain = os.replace

    class Killed(BaseException):
        pass

    def move(source: Path, target: Path) -> Path:
        if not left[0]:
            raise Killed
        left[0] -= 1
        plain(source, target)
        return target

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", move)
        with pytest.raises(Killed):
            run(other, Killed())
    record = record_of(case)
    if case.page.exists():
        assert record["state"] == "finished"
        assert record["job"] == key_of(job)
        assert all(path.exists() for path in written(case))
    elif record["state"] == "finished":
        assert not standing.is_up_to_date(case, key_of(job))
    assert run(other, ScaleError("later"))["state"] == "refused"
    assert not any(path.exists() for path in written(case))
    assert (case.superseded / "report.html").read_text() == "first"


def test_the_key_tells_photos_camera_options_and_program_apart(
    job: Job, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = key_of(job)
    assert key_of(replace(job, case=job.case.with_name("moved"))) == first
    assert key_of(replace(job, unscaled=True)) != first
    copied = job.case.parent / "another place"
    job.sources[0].rename(copied)
    assert key_of(replace(job, sources=(copied,))) == first
    (copied / "a.jpg").write_bytes(b"altered")
    assert key_of(replace(job, sources=(copied,))) != first
    (copied / "a.jpg").write_bytes(b"a.jpg")
    monkeypatch.setattr(standing, "code_version", lambda _module: "another version")
    assert key_of(replace(job, sources=(copied,))) != first
