"""Jobs over HTTP: rest, cancelling, what survives, and what is told meanwhile."""

import errno
import io
import json
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import cv2
import numpy as np
import pytest
from fastapi.testclient import TestClient
from PIL import Image

from limbgram.app.state import AppState
from limbgram.cases import job_queue
from limbgram.cases.case_record import write_json
from limbgram.cases.folder import CaseFolder, locked
from limbgram.cases.job_queue import (
    JobFile,
    Runner,
    RunningJob,
    StageProgress,
    mark_interrupted,
    read_job_file,
)
from limbgram.cases.job_supervision import Supervision
from limbgram.cases.shelf import Shelf
from limbgram.core.errors import in_words
from limbgram.core.typed import tree_of
from limbgram.findings import fault

API = "/api/v1"
SLOW = """
import json, os, sys, threading, time
def say(**event): print(json.dumps(event), flush=True)
threading.Thread(target=lambda: (sys.stdin.read(), os._exit(130)), daemon=True).start()
say(event="progress", stage="read photos", done=1, total=1)
for k in range(1000):
    say(event="progress", stage="detect", done=k, total=1000)
    time.sleep(0.02)
"""
FULL = {
    "event": "refused",
    "kind": "CaseError",
    "finding": in_words("The disk is full.").tree(),
}
DEAF = """
import json, time
print(json.dumps({"event": "progress", "stage": "detect", "done": 0, "total": 9}), flush=True)
time.sleep(60)
"""


@pytest.fixture
def case(client: TestClient) -> str:
    return new_case(client)


def new_case(client: TestClient) -> str:
    """A case with a photo."""
    case = f"{API}/cases/" + client.post(f"{API}/cases", json={}).json()["id"]
    made = io.BytesIO()
    Image.new("RGB", (120, 90)).save(made, "PNG")
    client.put(f"{case}/photos/a.png", content=made.getvalue())
    return case


def started(client: TestClient, app_state: AppState, case: str, body: str) -> dict[str, Any]:
    app_state.runner.command = (sys.executable, "-c", body)
    reply = client.post(f"{case}/job", json={"board": None, "unscaled": True})
    assert reply.status_code == 202
    return wait(client, case, lambda job: stage(job, "detect")["state"] == "running")


def stage(job: dict[str, Any], name: str) -> dict[str, Any]:
    return next(one for one in job["stages"] if one["name"] == name)


def wait(client: TestClient, case: str, until: Any) -> dict[str, Any]:
    """The job once something holds of it; a busy machine may take its time."""
    given_up = time.monotonic() + 60
    while True:
        job: dict[str, Any] = client.get(f"{case}/job").json()
        if until(job):
            return job
        assert time.monotonic() < given_up, job
        time.sleep(0.02)


def at_rest(client: TestClient, case: str) -> int:
    """Steps that a run had done when it was let rest, once all of them were heard of."""
    heard = -1
    while heard != (now := stage(client.get(f"{case}/job").json(), "detect")["done"]):
        heard = now
        time.sleep(0.3)
    return heard


def test_a_run_tells_its_stages_and_how_long_it_may_take(
    client: TestClient, app_state: AppState, case: str
) -> None:
    job = started(client, app_state, case, SLOW)
    named = [one["name"] for one in job["stages"]]
    at = named.index("detect")
    assert job["stages"][0]["state"] == "done"
    assert job["stages"][at + 1]["state"] == "waiting"
    assert job["stage"] == at + 1
    assert job["left"]["least_s"] <= job["left"]["most_s"]
    assert client.get(case).json()["state"] == "computing"
    assert client.post(f"{case}/job", json={}).status_code == 409
    client.post(f"{case}/job/cancel")


@pytest.mark.parametrize(("frames", "taken"), [(10, 10), (50, 36)])
def test_a_film_counts_as_the_frames_that_are_taken_of_it(
    client: TestClient, app_state: AppState, tmp_path: Path, frames: int, taken: int
) -> None:
    case = f"{API}/cases/" + client.post(f"{API}/cases", json={}).json()["id"]
    film = tmp_path / "walk.avi"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter_fourcc(*"MJPG"), 30, (320, 240))
    for k in range(frames):
        writer.write(np.full((240, 320, 3), k, np.uint8))
    writer.release()
    client.put(f"{case}/photos/walk.avi", content=film.read_bytes())
    job = started(client, app_state, case, SLOW)
    file = read_job_file(app_state.shelf.case(case.rpartition("/")[2]).folder)
    assert file is not None
    assert file.megapixels == pytest.approx(taken * 320 * 240 / 1e6)
    assert job["left"]["least_s"] > 0.0
    client.post(f"{case}/job/cancel")


def test_of_photos_of_an_unknown_size_no_time_is_foretold(
    client: TestClient, app_state: AppState, case: str
) -> None:
    """It was 0 s."""
    client.delete(f"{case}/photos/a.png")
    client.put(f"{case}/photos/a.png", content=b"no picture")
    assert started(client, app_state, case, SLOW)["left"] is None
    client.post(f"{case}/job/cancel")


@pytest.mark.skipif(sys.platform == "win32", reason="that system cannot hold a process")
def test_a_run_rests_without_counting_time_and_goes_on(
    client: TestClient, app_state: AppState, case: str
) -> None:
    started(client, app_state, case, SLOW)
    held = client.post(f"{case}/job/pause").json()
    assert held["state"] == "held"
    steps = at_rest(client, case)
    assert steps < 1000, "it goes on working"
    resting = client.get(f"{case}/job").json()
    assert resting["elapsed_s"] == pytest.approx(held["elapsed_s"], abs=1e-6)
    assert client.post(f"{case}/job/resume").json()["state"] == "running"
    wait(client, case, lambda job: stage(job, "detect")["done"] > steps + 10)
    client.post(f"{case}/job/cancel")


def test_time_that_a_run_rests_is_none_of_its_stages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor of the pace that later runs are foretold by."""
    now, finished = [0.0], list[str]()
    monkeypatch.setattr("limbgram.cases.job_queue.time", SimpleNamespace(monotonic=lambda: now[0]))
    half = StageProgress(name="detect", title="", state="running", done=50, total=100)
    job = RunningJob(
        case=CaseFolder(tmp_path),
        file=JobFile(state="running", order="{}", megapixels=1.0, began="", stages=(half,)),
        on_change=lambda: None,
        on_finished=lambda: finished.append("pace"),
        on_idle=lambda: None,
        usual_s_per_mp={},
        usual_known=True,
    )
    process = SimpleNamespace(hold=lambda: True, resume=lambda: None, process_id=1)
    job._supervision = cast(Any, process)
    now[0] = 10.0
    before = job.time_left()
    job.hold()
    now[0] = 3610.0
    assert job.time_left() == before
    job.begin(())
    assert job.time_left() == before
    now[0] = 3620.0
    job._progress("match", 0, 10)
    assert {one.name: one.seconds for one in job.file.stages}["detect"] == 20.0
    job._end("finished")
    assert finished == []


@pytest.mark.parametrize("body", [SLOW, DEAF], ids=["listens", "does not listen"])
def test_cancelling_takes_two_seconds_at_most(
    client: TestClient, app_state: AppState, case: str, body: str
) -> None:
    started(client, app_state, case, body)
    began = time.monotonic()
    client.post(f"{case}/job/cancel")
    job = wait(client, case, lambda job: job["state"] != "running")
    assert time.monotonic() - began < 2.5
    assert job["state"] == "cancelled"
    assert "kept" in job["message"]
    assert client.get(case).json()["state"] == "cancelled"


def test_elapsed_time_goes_on_where_a_run_is_taken_up_again(
    client: TestClient, app_state: AppState, case: str
) -> None:
    started(client, app_state, case, SLOW)
    time.sleep(0.3)
    client.post(f"{case}/job/cancel")
    before = wait(client, case, lambda job: job["state"] == "cancelled")["elapsed_s"]
    assert before > 0.3
    client.post(f"{case}/job/resume")
    assert client.get(f"{case}/job").json()["elapsed_s"] >= before
    client.post(f"{case}/job/cancel")


def test_what_is_resumed_at_once_is_not_written_over_by_the_run_that_ended(
    client: TestClient, app_state: AppState, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a slow disk: the file of the ended run is on its way when the next one begins."""

    def slowly(path: Path, tree: dict[str, Any]) -> None:
        if tree["state"] == "cancelled":
            time.sleep(0.5)
        write_json(path, tree)

    started(client, app_state, case, SLOW)
    time.sleep(0.3)
    monkeypatch.setattr(job_queue, "write_json", slowly)
    client.post(f"{case}/job/cancel")
    before = wait(client, case, lambda job: job["state"] == "cancelled")["elapsed_s"]
    assert client.post(f"{case}/job/resume").json()["elapsed_s"] >= before
    time.sleep(0.7)
    kept = read_job_file(app_state.shelf.case(case[-7:]).folder)
    assert kept is not None
    assert kept.state == "running"
    client.post(f"{case}/job/cancel")


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are told by /proc")
def test_what_ran_when_the_program_was_killed_is_interrupted_and_ends(
    client: TestClient, app_state: AppState, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    started(client, app_state, case, DEAF + "# limbgram.cases.job_process")
    monkeypatch.setattr(RunningJob, "_save", lambda _: None)  # a killed program writes no more
    shelved = app_state.shelf.case(case.rpartition("/")[2])
    kept = read_job_file(shelved.folder)
    assert kept is not None
    assert kept.state == "running"
    mark_interrupted(Shelf(app_state.shelf.root).case(shelved.case_id).folder)
    again = read_job_file(shelved.folder)
    assert again is not None
    assert again.state == "interrupted"
    assert again.why == fault("job.interrupted")
    client.post(f"{case}/job/cancel")


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are told by /proc")
@pytest.mark.parametrize("ours", [True, False])
def test_what_rests_of_an_interrupted_run_is_ended_and_nothing_else(
    client: TestClient, app_state: AppState, case: str, ours: bool
) -> None:
    started(client, app_state, case, SLOW)
    client.post(f"{case}/job/cancel")
    wait(client, case, lambda job: job["state"] == "cancelled")
    folder = app_state.shelf.case(case.rpartition("/")[2]).folder
    job = app_state.runner.running(folder)
    assert job is not None
    job.join(10)  # its last word is written
    kept = read_job_file(folder)
    assert kept is not None
    root = folder.root if ours else folder.root.with_name("another")
    words = ["-c", "import time; time.sleep(60)", "limbgram.cases.job_process", str(root)]
    with subprocess.Popen([sys.executable, *words]) as process:
        left = replace(kept, state="running", process=process.pid)
        write_json(folder.root / "job.json", tree_of(left))
        mark_interrupted(folder)
        if ours:
            assert process.wait(10) == -signal.SIGKILL
        else:
            assert process.poll() is None
            process.kill()
    now = read_job_file(folder)
    assert now is not None
    assert (now.state, now.process) == ("interrupted", 0)
    assert all(one.state != "running" for one in now.stages)


def test_runs_wait_for_their_turn_in_order(
    client: TestClient, app_state: AppState, case: str
) -> None:
    started(client, app_state, case, SLOW)
    others = [new_case(client) for _ in range(3)]
    asked = {"board": None, "unscaled": True}
    for number, other in enumerate(others, 1):
        waits = client.post(f"{other}/job", json=asked).json()
        assert (waits["state"], waits["before"], waits["left"]) == ("queued", number, None)
    assert client.get(others[0]).json()["state"] == "computing"
    assert client.post(f"{others[0]}/job", json=asked).status_code == 409, "it waits already"
    assert client.post(f"{others[0]}/job/pause").status_code == 409
    assert client.post(f"{others[1]}/job/cancel").json()["state"] == "cancelled"
    assert client.get(f"{others[2]}/job").json()["before"] == 2
    client.post(f"{case}/job/cancel")
    wait(client, others[0], lambda job: job["state"] == "running")
    assert client.get(f"{others[2]}/job").json()["state"] == "queued"
    kept = read_job_file(app_state.shelf.case(others[2].rpartition("/")[2]).folder)
    assert kept is not None
    assert kept.state == "queued"
    mark_interrupted(app_state.shelf.case(others[2].rpartition("/")[2]).folder)
    kept = read_job_file(app_state.shelf.case(others[2].rpartition("/")[2]).folder)
    assert kept is not None
    assert kept.state == "interrupted"
    for one in (others[2], others[0]):
        client.post(f"{one}/job/cancel")


@pytest.mark.skipif(sys.platform == "win32", reason="that system cannot hold a process")
def test_a_run_that_rests_lets_another_begin_and_waits_for_its_turn(
    client: TestClient, app_state: AppState, case: str
) -> None:
    started(client, app_state, case, SLOW)
    other = new_case(client)
    asked = {"board": None, "unscaled": True}
    assert client.post(f"{other}/job", json=asked).json()["state"] == "queued"
    assert client.post(f"{case}/job/pause").json()["state"] == "held"
    wait(client, other, lambda job: job["state"] == "running")
    again = client.post(f"{case}/job/resume").json()
    assert (again["state"], again["before"]) == ("queued", 1)
    resting = at_rest(client, case)
    assert resting < 1000, "it goes on working"
    client.post(f"{other}/job/cancel")
    wait(client, case, lambda job: stage(job, "detect")["done"] > resting + 10)
    client.post(f"{case}/job/cancel")


def test_a_case_that_is_deleted_while_it_waits_holds_up_no_other(
    client: TestClient, app_state: AppState, case: str
) -> None:
    started(client, app_state, case, SLOW)
    waits, last = new_case(client), new_case(client)
    asked = {"board": None, "unscaled": True}
    for one in (waits, last):
        assert client.post(f"{one}/job", json=asked).json()["state"] == "queued"
    assert client.delete(case).status_code == 409, "it works"
    assert client.delete(waits).status_code == 204
    assert client.get(f"{last}/job").json()["before"] == 1
    client.post(f"{case}/job/cancel")
    wait(client, last, lambda job: job["state"] == "running")
    assert not (app_state.shelf.root / waits.rpartition("/")[2]).exists()
    client.post(f"{last}/job/cancel")


def test_a_case_that_cannot_be_deleted_waits_on(
    client: TestClient, app_state: AppState, case: str
) -> None:
    started(client, app_state, case, SLOW)
    waits = new_case(client)
    client.post(f"{waits}/job", json={"board": None, "unscaled": True})
    with locked(app_state.shelf.case(waits.rpartition("/")[2]).folder):
        assert client.delete(waits).status_code == 409, "the command line works in it"
    assert client.get(f"{waits}/job").json()["state"] == "queued"
    client.post(f"{case}/job/cancel")
    wait(client, waits, lambda job: job["state"] == "running")
    client.post(f"{waits}/job/cancel")


@pytest.mark.parametrize("full", ["asked", "begins", "ends"])
def test_a_run_that_finds_the_disk_full_leaves_the_line(
    client: TestClient, app_state: AppState, case: str, monkeypatch: pytest.MonkeyPatch, full: str
) -> None:
    """Whether it is asked for, begins or ends just then: the next one begins."""
    own = case.rpartition("/")[2]
    may_end = app_state.shelf.root / "may-end"
    of_the_disk = f"""
import os, time
while not os.path.exists({str(may_end)!r}): time.sleep(0.02)
print({json.dumps(json.dumps(FULL))})
raise SystemExit(3)"""
    app_state.runner.command = (sys.executable, "-c", of_the_disk)
    states = {"asked": "queued", "begins": "running", "ends": "refused"}

    def write_if_there_is_room(path: Path, content: Any) -> None:
        if path.parent.name == own and content["state"] == states[full]:
            raise OSError(errno.ENOSPC, "No space left on device")
        write_json(path, content)

    monkeypatch.setattr("limbgram.cases.job_queue.write_json", write_if_there_is_room)
    asked = {"board": None, "unscaled": True}
    first = client.post(f"{case}/job", json=asked)
    other = new_case(client)
    assert client.post(f"{other}/job", json=asked).status_code == 202
    may_end.write_bytes(b"")
    if full == "asked":
        assert first.status_code == 507
        assert client.get(f"{case}/job").json()["state"] == "none"
    else:
        refused = wait(client, case, lambda job: job["state"] not in ("queued", "running"))
        assert refused["state"] == "refused"
        assert "full" in refused["message"]
    assert wait(client, other, lambda job: job["state"] == "refused")["before"] == 0
    monkeypatch.undo()
    assert client.post(f"{case}/job", json=asked).status_code == 202, "and so does the same again"


def test_a_fault_of_ours_in_a_run_holds_up_no_other(
    client: TestClient, app_state: AppState, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fault(_: Supervision) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(threading, "excepthook", lambda _: None)
    with monkeypatch.context() as broken:
        broken.setattr(Supervision, "wait", fault)
        client.post(f"{case}/job", json={"board": None, "unscaled": True})
        job = wait(client, case, lambda job: job["state"] != "running")
        assert (job["state"], client.get(case).json()["state"]) == ("failed", "failed")
    other = new_case(client)
    started(client, app_state, other, SLOW)
    client.post(f"{other}/job/cancel")


def test_what_was_wanted_when_the_program_ended_goes_on_by_itself(
    client: TestClient, app_state: AppState, case: str
) -> None:
    """What ran comes before what waited; what was cancelled or let rest stays so."""
    started(client, app_state, case, SLOW)
    cases = [case, *(new_case(client) for _ in range(3))]
    for one in cases[1:]:
        client.post(f"{one}/job", json={"board": None, "unscaled": True})
    client.post(f"{cases[3]}/job/cancel")
    folders = [app_state.shelf.case(one.rpartition("/")[2]).folder for one in cases]
    app_state.runner.close()
    kept = [read_job_file(one) for one in folders]
    assert [one and (one.state, one.wanted) for one in kept] == [
        ("interrupted", True),
        ("interrupted", True),
        ("interrupted", True),
        ("cancelled", False),
    ]
    told: list[str] = []
    opened = Runner(app_state.runner.pace_file, told.append, command=app_state.runner.command)
    opened.resume_all(reversed(folders))
    working = [opened.running(one) for one in folders]
    assert [one and one.file.state for one in working] == ["running", "queued", "queued", None]
    assert [opened.jobs_ahead(one) for one in folders] == [0, 1, 2, 0]
    opened.close()


def test_what_was_killed_twice_in_one_stage_is_not_begun_for_ever(
    client: TestClient, app_state: AppState, case: str
) -> None:
    folder = app_state.shelf.case(case.rpartition("/")[2]).folder
    started(client, app_state, case, SLOW)
    app_state.runner.close()

    def killed(*, before: bool) -> JobFile:
        kept = read_job_file(folder)
        assert kept is not None
        write_json(folder.job_file, tree_of(replace(kept, state="running", killed=before)))
        found = mark_interrupted(folder)
        assert found is not None
        return found

    once = killed(before=False)
    assert (once.wanted, once.killed) == (True, True)
    twice = killed(before=True)
    assert (twice.state, twice.wanted) == ("interrupted", False)
    assert twice.why == fault("job.killed_twice")
    opened = Runner(app_state.runner.pace_file, lambda _: None, command=app_state.runner.command)
    opened.resume_all([folder])
    assert opened.running(folder) is None
    job = opened.restart(folder)  # somebody wants it all the same
    given_up = time.monotonic() + 60
    while not any(one.name == "detect" and one.state == "running" for one in job.file.stages):
        assert time.monotonic() < given_up
        time.sleep(0.02)
    assert not job.file.killed
    opened.close()


def test_more_than_one_run_at_a_time_where_it_is_wanted(
    client: TestClient, app_state: AppState, case: str
) -> None:
    app_state.runner.at_once = 2
    started(client, app_state, case, SLOW)
    other = new_case(client)
    asked = {"board": None, "unscaled": True}
    assert client.post(f"{other}/job", json=asked).json()["state"] == "running"
    for one in (case, other):
        client.post(f"{one}/job/cancel")


def test_a_refusal_is_told_word_by_word(client: TestClient, app_state: AppState, case: str) -> None:
    finding = in_words("The board is in no photo.").tree()
    refusal = {"event": "refused", "kind": "ScaleError", "finding": finding}
    app_state.runner.command = (
        sys.executable, "-c", f"print({json.dumps(json.dumps(refusal))}); raise SystemExit(4)",
    )  # fmt: skip
    client.post(f"{case}/job", json={"board": None, "unscaled": True})
    job = wait(client, case, lambda job: job["state"] != "running")
    assert (job["state"], job["kind"]) == ("refused", "ScaleError")
    assert job["message"] == "The board is in no photo."
    assert client.get(case).json()["state"] == "refused"


def test_a_run_that_would_end_without_a_size_is_refused_before_it_begins(
    client: TestClient, case: str
) -> None:
    """As the command line refuses it; else all is computed, and then no file is written."""
    refused = client.post(f"{case}/job", json={"board": None})
    assert refused.status_code == 422
    assert refused.json()["finding"]["code"] == "options.no_size"
    assert "--" not in refused.json()["message"]
    assert client.get(f"{case}/job").json()["state"] == "none"


def test_nothing_to_do_is_refused(client: TestClient) -> None:
    case = f"{API}/cases/" + client.post(f"{API}/cases", json={}).json()["id"]
    assert client.get(f"{case}/job").json()["state"] == "none"
    for act in ("pause", "resume", "cancel"):
        assert client.post(f"{case}/job/{act}").status_code == 409
    assert client.post(f"{case}/job", json={}).status_code == 409


@pytest.mark.parametrize("content", ["[1", '{"s_per_megapixel": [1]}', '{"s_per_megapixel": 3}'])
def test_a_spoiled_record_of_earlier_runs_does_not_keep_a_job_from_starting(
    client: TestClient, app_state: AppState, case: str, content: str
) -> None:
    app_state.runner.pace_file.write_text(content, "utf-8")
    job = started(client, app_state, case, SLOW)
    assert not job["left"]["known"]
    client.post(f"{case}/job/cancel")


@pytest.mark.parametrize("made_by", ["the app", "the command line"])
def test_a_case_whose_record_was_set_aside_is_computed_again(
    client: TestClient, app_state: AppState, case: str, made_by: str
) -> None:
    """The app itself advised to set it aside; its results and photos lie there still."""
    folder = app_state.shelf.case(case[-7:]).folder
    folder.deliverables.mkdir()
    if made_by == "the app":
        folder.photos.mkdir()
    else:
        (folder.root / "received").rename(folder.photos)
        folder.label_file.unlink()
    folder.record.write_bytes(b"{")
    assert client.post(f"{case}/set-aside").json() == ["case.unreadable-1.json"]
    assert client.get(f"{case}/photos").json()["here"] >= 1
    started(client, app_state, case, SLOW)
    client.post(f"{case}/job/cancel")


def test_photos_that_were_put_into_a_case_by_hand_are_computed(
    client: TestClient, app_state: AppState
) -> None:
    """The list shows the folder as a case, and its photos as here."""
    case = f"{API}/cases/222-CKA"
    photos = app_state.shelf.root / "222-CKA" / "photos"
    photos.mkdir(parents=True)
    Image.new("RGB", (120, 90)).save(photos / "a.png")
    assert client.get(case).json()["photos"] == 1
    started(client, app_state, case, SLOW)
    client.post(f"{case}/job/cancel")
