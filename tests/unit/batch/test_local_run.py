"""Nothing that becomes of one capture stops another, and each outcome is told as it was."""

import csv
import json
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from PIL import Image

from limbgram.batch import attempt as attempting
from limbgram.batch import local_run
from limbgram.batch.attempt import Outcome, Plan, StepOutcome, WrittenFile, worst_of
from limbgram.batch.attempt_process import _elsewhere_if_full
from limbgram.batch.captures import Capture
from limbgram.batch.local_run import BatchOptions, BatchRun
from limbgram.batch.memory import MemoryGate, need_mb
from limbgram.batch.processors import processors_for
from limbgram.batch.steps import Step, StepRefused, StepReply
from limbgram.batch.stopping import Stopping
from limbgram.batch.table import earlier_outcomes, write_table
from limbgram.cases.child_process import Event
from limbgram.cases.folder import CaseFolder, locked
from limbgram.cases.job_messages import Job
from limbgram.cases.job_supervision import Supervision
from limbgram.core.errors import Cancelled, OptionsError, in_words
from limbgram.findings import note
from limbgram.reconstruction.photos.photo import SetAside

CHILD = """
import json, os, sys, time, pathlib
job = json.loads(sys.stdin.readline())
case = pathlib.Path(job["case"]["path"])
what = (pathlib.Path(job["sources"][0]["path"]) / "what.txt").read_text()
tries = case / "tries"
count = len(tries.read_text()) if tries.exists() else 0
tries.write_text("x" * (count + 1))
def send(**event):
    print(json.dumps(event), flush=True)
def refuse(kind, message):
    found = {"code": "said.as_is", "gravity": "fault", "values": {"message": message}}
    send(event="refused", kind=kind, finding=found)
send(event="progress", stage="place", done=1, total=3)
if what.startswith("die") and count < int(what[3:]):
    os.kill(os.getpid(), 9)
if what == "refuse":
    refuse("ScaleError", "No board.")
    sys.exit(4)
if what == "bug":
    send(event="bug", traceback="Traceback: here")
    sys.exit(1)
if what == "wait":
    sys.stdin.read()
    refuse("Cancelled", "Stopped.")
    sys.exit(130)
light = what if what in ("red", "amber") else "green"
(case / "summary.json").write_text(json.dumps(
    {"verdict": {"light": light, "headline": light.upper() + ": 0.1 mm", "reasons": []},
     "set_aside": [{"name": "IMG_7.jpg", "reason": "the file is cut off"}]}))
send(event="finished", answer={
    "is": "Answer", "summary": {"path": str(case / "summary.json")}, "light": light})
"""


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """Do a batch of captures whose process does what their file says."""
    script = tmp_path / "child.py"
    script.write_text(CHILD, "utf-8")
    supervised = partial(Supervision, command=(sys.executable, str(script)), grace_s=2.0)
    monkeypatch.setattr(attempting, "Supervision", supervised)

    def plan(name: str, what: str) -> Plan:
        folder = tmp_path / "in" / name
        folder.mkdir(parents=True)
        (folder / "what.txt").write_text(what)
        (folder / "a.jpg").write_bytes(b"\xff\xd8\xff")
        capture = Capture(name=name, path=folder, kind="folder")
        return Plan(capture=capture, job=Job(case=tmp_path / "out" / name, sources=()))

    def do(whats: dict[str, str], listener: Callable[[Event], None], **more: Any) -> BatchRun:
        plans = [plan(name, what) for name, what in whats.items()]
        (tmp_path / "out").mkdir()
        options = BatchOptions(**{"at_once": 2, **more})
        return BatchRun(plans, tmp_path / "out", options, listener)

    return do


def states(outcomes: tuple[Outcome, ...]) -> dict[str, tuple[str, int, int]]:
    return {one.name: (one.state, one.exit_code, one.attempts) for one in outcomes}


def test_every_outcome_is_told_and_none_stops_another(
    run: Callable[..., BatchRun], tmp_path: Path
) -> None:
    events: list[Event] = []
    whats = {"a": "refuse", "b": "bug", "c": "green", "d": "die9", "e": "red", "f": "die1"}
    batch = run(whats, events.append)
    outcomes = batch.wait()
    assert states(outcomes) == {
        "a": ("refused", 4, 1),
        "b": ("failed", 1, 1),
        "c": ("finished", 0, 1),
        "d": ("died", 6, 3),
        "e": ("finished", 7, 1),
        "f": ("finished", 0, 2),
    }
    assert (tmp_path / "out" / "d" / "tries").read_text() == "xxx"
    assert "Traceback: here" in outcomes[1].reason
    ends = [event["capture"] for event in events if event["event"] == "ended"]
    assert sorted(ends) == ["a", "b", "c", "d", "d", "d", "e", "f", "f"]
    again = [event["capture"] for event in events if event.get("again")]
    assert sorted(again) == ["d", "d", "f"]

    table = write_table(outcomes, tmp_path / "out", ("A note.",), stopped=False)
    assert table.exit_code == 1
    assert table.line == (
        "6 captures: 2 green, 1 red, 3 without a result; scale not checked independently: 3 of 3."
    )
    rows = list(csv.DictReader((tmp_path / "out" / "batch.csv").open()))
    assert [row["verdict"] for row in rows] == ["", "", "green", "", "red", "green"]
    kept = json.loads((tmp_path / "out" / "batch.json").read_text())
    assert [one["exit_code"] for one in kept["captures"]] == [4, 1, 0, 6, 7, 0]
    page = (tmp_path / "out" / "batch.html").read_text("utf-8")
    assert "No board." in page
    assert page.count("GREEN; scale not checked independently") == 2
    assert [row["size_checked"] for row in rows] == ["", "", "false", "", "false", "false"]
    assert kept["captures"][2]["size_checked"] is False
    assert "A note." in page


def test_stopping_ends_all_and_begins_no_other(run: Callable[..., BatchRun]) -> None:
    begun = threading.Event()
    whats = {"a": "green", "b": "wait", "c": "green", "d": "green"}
    batch = run(whats, lambda event: begun.set() if event.get("capture") == "b" else None,
                at_once=1)  # fmt: skip

    def stop() -> None:
        begun.wait(20)
        time.sleep(0.3)
        batch.stopping.ask()

    threading.Thread(target=stop).start()
    assert states(batch.wait()) == {
        "a": ("finished", 0, 1),
        "b": ("cancelled", 130, 1),
        "c": ("cancelled", 130, 1),
        "d": ("cancelled", 130, 1),
    }


def test_ctrl_c_stops_all_and_tells_of_each(run: Callable[..., BatchRun]) -> None:
    begun = threading.Barrier(3)
    whats = {"a": "wait", "b": "wait", "c": "green"}

    def heard(event: Event) -> None:
        if event["event"] == "progress":
            threading.Thread(target=begun.wait, args=(20,)).start()

    def interrupt() -> None:
        begun.wait(20)
        time.sleep(0.3)
        signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Thread(target=interrupt).start()
        found = states(run(whats, heard).wait())
    finally:
        signal.signal(signal.SIGINT, before)
    assert set(found.values()) == {("cancelled", 130, 1)}


def test_settings_that_are_wrong_are_the_fault_of_one_capture(tmp_path: Path) -> None:
    capture = Capture(name="a", path=tmp_path, kind="folder")
    job = Job(case=tmp_path / "out" / "a", sources=())
    plan = Plan(capture=capture, job=job, refusal=OptionsError("No such camera."))
    outcomes = BatchRun([plan], tmp_path / "out", BatchOptions(), lambda _: None).wait()
    assert states(outcomes) == {"a": ("refused", 2, 1)}
    assert outcomes[0].reason == "No such camera."


def test_a_fault_in_a_thread_of_ours_is_not_lost(
    run: Callable[..., BatchRun], monkeypatch: pytest.MonkeyPatch
) -> None:
    batch = run({"a": "green"}, lambda _: None)

    def broken(*_: object) -> float:
        raise ZeroDivisionError

    monkeypatch.setattr(attempting, "need_mb", broken)
    with pytest.raises(ZeroDivisionError):
        batch.wait()


def test_a_batch_keeps_to_three_quarters_of_the_machine_unless_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(local_run, "machine_mb", lambda: 16_000.0)
    assert BatchOptions().memory_mb == 12_000.0
    assert BatchOptions(memory_gb=2.0).memory_mb == 2048.0


@pytest.mark.parametrize(("free_mb", "state"), [(110, "refused"), (90, "died")])
def test_a_refusal_on_a_full_disk_is_the_machines_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, free_mb: int, state: str
) -> None:
    """Two photos take up to 100 MB while their case is made; with less, another machine may do."""
    folder = tmp_path / "in"
    folder.mkdir()
    for name in ("a.jpg", "b.jpg"):
        (folder / name).write_bytes(b"\xff\xd8\xff")
    plan = Plan(
        capture=Capture(name="a", path=folder, kind="folder"),
        job=Job(case=tmp_path / "out", sources=()),
    )
    refused = Outcome(name="a", source="a", state="refused", kind="CaseError", finding=note("x.y"))
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=free_mb * 2**20))
    assert _elsewhere_if_full(refused, plan, tmp_path).state == state


def test_memory_is_shared_by_those_at_work() -> None:
    gate, stopping, order = MemoryGate(1000.0), Stopping(), list[str]()

    def work(name: str, needed_mb: float) -> None:
        with gate.hold(needed_mb, stopping):
            order.append(name)

    with gate.hold(600.0, stopping):
        small = threading.Thread(target=work, args=("small", 300.0))
        large = threading.Thread(target=work, args=("large", 5000.0))
        small.start()
        small.join()
        large.start()
        time.sleep(0.05)
        assert order == ["small"]
    large.join(5)
    assert order == ["small", "large"]
    stopping.ask()
    with gate.hold(600.0, stopping), pytest.raises(Cancelled), gate.hold(600.0, stopping):
        pass


@pytest.mark.skipif(not hasattr(__import__("os"), "sched_getaffinity"), reason="Linux alone")
def test_processors_are_shared_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0, 2, 4, 6, 8})
    assert [sorted(processors_for(slot, 2)) for slot in range(2)] == [[0, 2], [4, 6, 8]]
    assert [sorted(processors_for(slot, 6)) for slot in range(6)] == [[0], [2], [4], [6], [8], [0]]


def test_the_exit_code_is_that_of_the_worst() -> None:
    assert worst_of([]) == 0
    assert worst_of([0, 7, 0]) == 7
    assert worst_of([7, 4, 0]) == 4
    assert worst_of([7, 4, 3, 6]) == 6
    assert worst_of([1, 6, 130]) == 130


def test_all_green_is_said_only_where_every_size_is_checked(tmp_path: Path) -> None:
    def page(*checked: bool) -> str:
        outcomes = [
            Outcome(name=f"c{k}", source="x", state="finished", light="green", size_checked=one)
            for k, one in enumerate(checked)
        ]
        table = write_table(outcomes, tmp_path, (), stopped=False)
        assert table.exit_code == 0
        assert table.line in (tmp_path / "batch.html").read_text("utf-8")
        return f"{table.line} {(tmp_path / 'batch.html').read_text('utf-8')}"

    assert page(True).startswith("1 capture: 1 green. ")
    assert page(True, True).startswith("2 captures: 2 green. ")
    assert "ALL GREEN" in page(True, True)
    doubtful = page(True, False)
    assert doubtful.startswith("2 captures: 2 green; scale not checked independently: 1 of 2. ")
    assert "ALL GREEN" not in doubtful
    assert "GREEN, SCALE UNCHECKED" in doubtful
    rows = list(csv.DictReader((tmp_path / "batch.csv").open()))
    assert [row["size_checked"] for row in rows] == ["true", "false"]


def test_a_table_cell_is_no_formula(tmp_path: Path) -> None:
    step = StepOutcome(name="align", state="refused", finding=in_words("No place."), exit_code=4)
    outcome = Outcome(
        name="=cmd()", source="x", state="finished", light="amber", headline="AMBER",
        exit_code=4, steps=(step,),
    )  # fmt: skip
    table = write_table([outcome], tmp_path, (), stopped=True)
    row = next(csv.DictReader((tmp_path / "batch.csv").open()))
    assert row["capture"] == "'=cmd()"
    assert row["steps_failed"] == "align"
    assert "align: No place." in row["message"]
    assert "a step after the surface failed" in table.line


def test_what_a_surface_was_made_without_is_told(
    run: Callable[..., BatchRun], tmp_path: Path
) -> None:
    (outcome,) = run({"a": "green"}, lambda _: None).wait()
    assert outcome.set_aside == (
        SetAside("IMG_7.jpg", note("said.as_is", message="the file is cut off")),
    )
    table = write_table([outcome], tmp_path, (), stopped=False)
    (row,) = table.content["captures"]
    (aside,) = row["set_aside"]
    assert (aside["name"], aside["reason"]["sentence"]) == ("IMG_7.jpg", "the file is cut off")
    row = next(csv.DictReader((tmp_path / "batch.csv").open()))
    assert row["left_out"] == "IMG_7.jpg: the file is cut off"
    page = (tmp_path / "batch.html").read_text("utf-8")
    assert "Left out" in page
    assert "the file is cut off" in page


def earlier_batch(case: Path, *steps: str) -> list[Path]:
    """Files that steps of an earlier batch wrote, with its record of them."""
    files = [case / "batch" / step / f"{step}.stl" for step in steps]
    written: list[dict[str, Any]] = []
    for step, file in zip(steps, files, strict=True):
        file.parent.mkdir(parents=True)
        file.write_text("of the earlier surface")
        place = file.relative_to(case).as_posix()
        written.append({"name": step, "state": "done", "files": [{"path": place, "sha256": "0"}]})
    record = {"schema": "limbgram-batch-case/1", "key": "earlier", "steps": written}
    (case / "batch" / "done.json").write_text(json.dumps(record), "utf-8")
    CaseFolder(case).record.write_text("{}", "utf-8")
    return files


def test_what_steps_made_of_a_surface_goes_with_it(
    run: Callable[..., BatchRun], tmp_path: Path
) -> None:
    """Other photos are refused: an export of the earlier ones is no answer to them."""
    batch = run({"a": "refuse"}, lambda _: None)
    case = tmp_path / "out" / "a"
    (file,) = earlier_batch(case, "export-1-stl")
    (case / "batch" / "mine").mkdir()
    assert states(batch.wait()) == {"a": ("refused", 4, 1)}
    assert not file.exists()
    assert (case / "batch" / "mine").is_dir()


def test_what_steps_made_stays_while_the_surface_stands(
    run: Callable[..., BatchRun], tmp_path: Path
) -> None:
    batch = run({"a": "refuse"}, lambda _: None)
    case = tmp_path / "out" / "a"
    (file,) = earlier_batch(case, "export-1-stl")
    (case / "deliverables").mkdir()
    (case / "deliverables" / "surface-RED.ply").write_text("it stands")
    assert states(batch.wait()) == {"a": ("refused", 4, 1)}
    assert file.is_file()


def test_steps_that_are_not_tried_or_not_asked_for_leave_nothing_of_before(
    run: Callable[..., BatchRun], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> StepReply:
        raise StepRefused("said.as_is", message="No landmark.")

    monkeypatch.setattr(attempting, "run_step", refuse)
    batch = run({"a": "green"}, lambda _: None)
    case = tmp_path / "out" / "a"
    earlier = earlier_batch(case, "export-1-stl", "export-2-dxf")
    (case / "deliverables").mkdir()
    (case / "deliverables" / "surface.ply").write_text("the new one")
    align = Step(name="align", kind="align", words=("align", "{surface}"))
    export = Step(name="export-1-stl", kind="export", words=("export", "{shape}", "-o", "{out}/a"))
    batch.plans = [replace(plan, steps=(align, export)) for plan in batch.plans]
    (outcome,) = batch.wait()
    assert [(one.name, one.state) for one in outcome.steps] == [
        ("align", "refused"),
        ("export-1-stl", "refused"),
    ]
    assert not any(file.exists() for file in earlier)


def test_a_capture_that_another_batch_works_on_is_left_to_it(
    run: Callable[..., BatchRun], tmp_path: Path
) -> None:
    batch = run({"a": "green"}, lambda _: None)
    with locked(CaseFolder(tmp_path / "out" / "a" / "batch")):
        outcomes = batch.wait()
    assert states(outcomes) == {"a": ("refused", 3, 1)}
    assert outcomes[0].finding is not None
    assert outcomes[0].finding.code == "case.locked"


def test_a_process_that_outlives_its_batch_is_waited_for(
    run: Callable[..., BatchRun], tmp_path: Path
) -> None:
    batch = run({"a": "green"}, lambda _: None)
    held, left = threading.Event(), threading.Event()

    def hold() -> None:
        with locked(CaseFolder(tmp_path / "out" / "a")):
            held.set()
            left.wait(1.0)

    threading.Thread(target=hold).start()
    held.wait(5)
    began = time.monotonic()
    assert states(batch.wait()) == {"a": ("finished", 0, 1)}
    assert time.monotonic() - began > 0.8


def test_the_table_of_a_part_is_completed_by_what_was_told_before(tmp_path: Path) -> None:
    assert earlier_outcomes(tmp_path) == {}
    step = StepOutcome(name="align", state="done", files=(WrittenFile(path="a", sha256="b"),))
    before = Outcome(name="a", source="a", state="finished", light="green", steps=(step,))
    write_table([before], tmp_path, (), stopped=False)
    assert earlier_outcomes(tmp_path) == {"a": before}
    (tmp_path / "batch.json").write_text("{")
    assert earlier_outcomes(tmp_path) == {}


def test_a_capture_needs_what_its_photos_and_their_depth_take(tmp_path: Path) -> None:
    """The program has 330 MB, each photo 12, eight million pixels of depth maps 76 bytes each, and
    a megapixel of the largest photo 25 MB while it is compared."""
    for k in range(2):
        Image.new("L", (3000, 2000)).save(tmp_path / f"{k}.png")
    expected = 330 + 2 * 12 + 8e6 * 76 / 2**20 + 6 * 25
    assert need_mb([tmp_path]) == pytest.approx(expected)
    film = tmp_path / "walk.mp4"
    film.touch()
    assert need_mb([film]) == 1500  # its photos are not chosen yet
