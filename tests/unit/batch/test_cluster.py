"""On a cluster every case is made once and whole, whatever becomes of workers on the way."""

import json
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from typer.testing import CliRunner

from limbgram.batch.attempt import Outcome, Plan
from limbgram.batch.captures import find_captures
from limbgram.batch.settings import Batch
from limbgram.cases.child_process import Event
from limbgram.cases.job_messages import Job
from limbgram.cli.main import app
from limbgram.core.errors import OptionsError
from limbgram.findings import fault

distributed = pytest.importorskip("distributed", reason="the extra cluster is not installed")
psutil = pytest.importorskip("psutil")

import limbgram  # noqa: E402
from limbgram.batch import cluster as clusters  # noqa: E402
from limbgram.batch import versions  # noqa: E402
from limbgram.batch.cluster import ClusterOptions, ClusterRun  # noqa: E402

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="kills as Linux has them"),
]

ATTEMPT = """
import sys
from pathlib import Path
from limbgram.batch import attempt, attempt_process
from limbgram.cases.job_supervision import Supervision
JOB = (sys.executable, str(Path(__file__).with_name("stub_job.py")))
attempt.Supervision = lambda job, listener, grace_s: Supervision(job, listener, JOB, grace_s)
sys.exit(attempt_process.main())
"""
JOB = """
import json, os, pathlib, sys, time
job = json.loads(sys.stdin.readline())
case = pathlib.Path(job["case"]["path"])
photos = pathlib.Path(job["sources"][0]["path"])
what, _, seconds = (photos / "what.txt").read_text().partition(" ")
tries = case / "tries"
count = len(tries.read_text()) if tries.exists() else 0
tries.write_text("x" * (count + 1))
(case / "case.json").write_text("{}")
def send(**event):
    print(json.dumps(event), flush=True)
def refuse(kind, message):
    found = {"code": "said.as_is", "gravity": "fault", "values": {"message": message}}
    send(event="refused", kind=kind, finding=found)
send(event="progress", stage="place", done=1, total=3)
time.sleep(float(seconds or 0))
if what.startswith("die") and count < int(what[3:]):
    os.kill(os.getpid(), 9)
if what == "refuse":
    refuse("ScaleError", f"No board in {case}.")
    sys.exit(4)
if what == "bug":
    send(event="bug", traceback="Traceback: here")
    sys.exit(1)
(case / "deliverables").mkdir(exist_ok=True)
(case / "deliverables" / "surface.ply").write_text(what * 100)
(case / "threads").write_text(os.environ["OPENBLAS_NUM_THREADS"])
(case / "summary.json").write_text(json.dumps(
    {"verdict": {"light": "green", "headline": "GREEN: 0.1 mm", "reasons": []}}))
if (photos / "a.png").exists():
    (case / "report").mkdir(exist_ok=True)
    (case / "report" / "surface.png").write_bytes((photos / "a.png").read_bytes())
send(event="finished", answer={
    "is": "Answer", "summary": {"path": str(case / "summary.json")}, "light": "green"})
"""
SETTINGS = {
    "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0",
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
}


@dataclass
class Crew:
    """A scheduler and workers, each a process of its own, as on a real cluster."""

    folder: Path
    waits: str = "60s"
    """So long a worker may be silent."""
    processes: list["subprocess.Popen[bytes]"] = field(default_factory=list)
    address: str = ""

    port: int = field(default_factory=lambda: _free_port())

    def scheduler(self) -> "subprocess.Popen[bytes]":
        told = self.folder / "scheduler.json"
        told.unlink(missing_ok=True)
        words = ("--host", "127.0.0.1", "--port", str(self.port))
        process = self._start("dask_scheduler", "--scheduler-file", str(told), *words)
        _until(lambda: told.exists() and told.read_text().rstrip().endswith("}"))
        self.address = json.loads(told.read_text())["address"]
        return process

    def worker(self) -> "subprocess.Popen[bytes]":
        place = self.folder / "scratch"
        words = ("--nthreads", "1", "--no-nanny", "--local-directory", str(place))
        return self._start("dask_worker", self.address, *words)

    def _start(self, name: str, *words: str) -> "subprocess.Popen[bytes]":
        source = str(Path(limbgram.__file__).parents[1])
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", f"distributed.cli.{name}", "--no-dashboard", *words],
            env={
                **{name: os.environ[name] for name in os.environ if "BLAS" not in name},
                **SETTINGS,
                "DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": self.waits,
                "PYTHONPATH": f"{self.folder}{os.pathsep}{source}",
            },
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        self.processes.append(process)
        return process

    def end(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()


def _free_port() -> int:
    """Below the ports that the system gives to connections, so that none takes it meanwhile."""
    while True:
        port = random.randrange(10_000, 32_000)
        with socket.socket() as tried:
            try:
                tried.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port


def _until(holds: Callable[[], bool], seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline, "it did not come"
        time.sleep(0.05)


@pytest.fixture
def crew(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Crew]:
    (tmp_path / "stub_attempt.py").write_text(ATTEMPT)
    (tmp_path / "stub_job.py").write_text(JOB)
    crew = Crew(tmp_path, getattr(request, "param", "60s"))
    try:
        crew.scheduler()
        yield crew
    finally:
        crew.end()


def batch(crew: Crew, whats: dict[str, str], heard: Callable[[Event], None]) -> ClusterRun:
    """A batch of captures whose process does what their file says."""
    folder, out = crew.folder / "in", crew.folder / "out"
    for name, what in whats.items():
        (folder / name).mkdir(parents=True)
        (folder / name / "what.txt").write_text(what)
        (folder / name / "a.jpg").write_bytes(b"\xff\xd8\xff")
    plans = [
        Plan(capture=one, job=Job(case=out / one.name, sources=()))
        for one in find_captures(folder, Batch(), out)
    ]
    options = ClusterOptions(
        address=crew.address,
        captures=str(folder),
        folder=folder,
        cases=str(out),
        module="stub_attempt",
    )
    return ClusterRun(plans, options, heard)


def states(outcomes: tuple[Outcome, ...]) -> dict[str, tuple[str, int, int]]:
    return {one.name: (one.state, one.exit_code, one.attempts) for one in outcomes}


def left_behind(folder: Path) -> list[str]:
    """What attempts left on the machines, and beside the cases."""
    scratch = [path.name for path in folder.glob("scratch/**/limbgram-attempt-*")]
    return scratch + [path.name for path in (folder / "out").iterdir() if path.name[0] == "."]


def stubs(folder: Path) -> list[Any]:
    """Processes that work on captures of this test."""
    found = []
    for one in psutil.process_iter(["cmdline", "cwd"]):
        words = " ".join(one.info["cmdline"] or ())
        if str(folder) in words and "stub" in words:
            found.append(one)
    return found


def test_each_becomes_what_it_becomes_and_nothing_is_left(crew: Crew) -> None:
    crew.worker()
    crew.worker()
    events: list[Event] = []
    whats = {"a": "refuse", "b": "bug", "c": "green", "d": "die9", "e": "die1", "f ü": "green"}
    run = batch(crew, whats, events.append)
    outcomes = run.wait()
    assert states(outcomes) == {
        "a": ("refused", 4, 1),
        "b": ("failed", 1, 1),
        "c": ("finished", 0, 1),
        "d": ("died", 6, 3),
        "e": ("finished", 0, 2),
        "f ü": ("finished", 0, 1),
    }
    out = crew.folder / "out"
    assert outcomes[0].reason == f"No board in {out / 'a'}."
    assert "Traceback: here" in outcomes[1].reason
    assert (out / "d" / "tries").read_text() == "xxx"  # continued, not begun anew
    assert (out / "c" / "deliverables" / "surface.ply").read_text() == "green" * 100
    assert (out / "c" / "threads").read_text() == "1"  # the sums of the command line
    assert left_behind(crew.folder) == []
    ends = [event["capture"] for event in events if event["event"] == "ended"]
    assert sorted(ends) == ["a", "b", "c", "d", "d", "d", "e", "e", "f ü"]
    assert events[0]["captures"] == 6


def test_what_a_killed_worker_did_is_done_by_another_and_its_processes_end(crew: Crew) -> None:
    first = crew.worker()
    working = threading.Event()

    def heard(event: Event) -> None:
        if event.get("stage") == "place" and not working.is_set():
            working.set()
            first.kill()
            crew.worker()

    outcomes = batch(crew, {"a": "green 3"}, heard).wait()
    assert states(outcomes) == {"a": ("finished", 0, 2)}
    _until(lambda: not stubs(crew.folder))
    assert (crew.folder / "out" / "a" / "tries").read_text() == "x"
    assert left_behind(crew.folder) == []


@pytest.mark.parametrize("crew", ["5s"], indirect=True)
def test_a_worker_that_slept_too_long_writes_nothing_when_it_wakes(crew: Crew) -> None:
    slow = crew.worker()
    asleep: list[Any] = []

    def heard(event: Event) -> None:
        if event.get("stage") == "place" and not asleep:
            asleep.extend([psutil.Process(slow.pid), *psutil.Process(slow.pid).children(True)])
            for one in asleep:
                one.send_signal(signal.SIGSTOP)
            crew.worker()

    outcomes = batch(crew, {"a": "green 2"}, heard).wait()
    assert outcomes[0].state == "finished"
    assert outcomes[0].attempts >= 2
    assert len(asleep) == 3
    case = crew.folder / "out" / "a"
    before = {path: path.stat().st_mtime_ns for path in case.rglob("*")}
    for one in reversed(asleep):
        one.send_signal(signal.SIGCONT)
    _until(lambda: not stubs(crew.folder))
    assert {path: path.stat().st_mtime_ns for path in case.rglob("*")} == before
    assert left_behind(crew.folder) == []


def test_a_scheduler_that_is_started_again_gets_what_was_not_finished(crew: Crew) -> None:
    crew.worker()
    lost: list[Event] = []

    def again() -> None:
        scheduler = crew.processes[0]
        scheduler.kill()
        scheduler.wait()
        crew.scheduler()
        crew.worker()

    def heard(event: Event) -> None:
        if event.get("stage") == "place" and event["capture"] == "b" and not lost:
            lost.append(event)
            threading.Thread(target=again).start()
        if event["event"] == "lost":
            lost.append(event)

    outcomes = batch(crew, {"a": "green", "b": "green 2"}, heard).wait()
    assert {one.name: one.state for one in outcomes} == {"a": "finished", "b": "finished"}
    assert outcomes[0].attempts == 1
    assert outcomes[1].attempts == 2
    assert {"event": "lost", "what": "scheduler"} in lost


def test_ctrl_c_ends_all_processes_and_keeps_what_is_finished(crew: Crew) -> None:
    crew.worker()
    begun = threading.Event()

    def heard(event: Event) -> None:
        if event.get("stage") == "place" and event["capture"] == "b" and not begun.is_set():
            begun.set()
            threading.Timer(0.3, signal.raise_signal, (signal.SIGINT,)).start()

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        outcomes = batch(crew, {"a": "green", "b": "green 60", "c": "green"}, heard).wait()
    finally:
        signal.signal(signal.SIGINT, before)
    assert begun.is_set()
    assert states(outcomes)["a"] == ("finished", 0, 1)
    assert {outcome.state for outcome in outcomes[1:]} == {"cancelled"}
    _until(lambda: not stubs(crew.folder), 20.0)
    assert left_behind(crew.folder) == []
    assert [path.name for path in (crew.folder / "out").iterdir()] == ["a"]


def test_other_versions_are_refused_before_and_at_work(
    crew: Crew, monkeypatch: pytest.MonkeyPatch
) -> None:
    crew.worker()
    client = distributed.Client(crew.address)
    client.wait_for_workers(1)
    client.close()
    whats = {"a": "green"}
    with monkeypatch.context() as other:
        other.setattr(versions, "_ALWAYS", ("limbgram.cases.job",))
        with pytest.raises(OptionsError, match="another version of limbgram"):
            batch(crew, whats, lambda _: None).wait()
    order = clusters.order_of

    def altered(*words: Any) -> str:
        return json.dumps({**json.loads(order(*words)), "program": "another"})

    monkeypatch.setattr(clusters, "order_of", altered)
    (crew.folder / "in").rename(crew.folder / "before")
    outcomes = batch(crew, whats, lambda _: None).wait()
    assert states(outcomes) == {"a": ("refused", 2, 1)}
    assert outcomes[0].finding == fault("dask.machine_differs", machine=socket.gethostname())


@pytest.mark.parametrize(
    "address", ["local:", "local:0", "local:x", "tcp://127.0.0.1:9", "nothing"]
)
def test_an_address_at_which_nobody_answers_is_refused(
    tmp_path: Path, address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clusters, "_CONNECT_S", 0.5)
    crew = Crew(tmp_path, address=address)
    with pytest.raises(OptionsError, match="local:4"):
        batch(crew, {"a": "green"}, lambda _: None).wait()


def test_from_url_to_url_by_one_command(
    s3: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import s3fs

    folder = tmp_path / "in"
    for name in ("P 1", "P2"):
        (folder / name).mkdir(parents=True)
    (folder / "P 1" / "what.txt").write_text("green")
    (folder / "P2" / "what.txt").write_text("refuse")
    Image.new("RGB", (8, 8), "red").save(folder / "P 1" / "a.png")
    s3fs.S3FileSystem().put(str(folder), "limbs/many", recursive=True)
    (tmp_path / "stub_attempt.py").write_text(ATTEMPT)
    (tmp_path / "stub_job.py").write_text(JOB)
    source = str(Path(limbgram.__file__).parents[1])
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{source}")
    options = partial(ClusterOptions, module="stub_attempt")
    monkeypatch.setattr(clusters, "ClusterOptions", options)
    words = ("batch", f"{s3}/many", "-o", f"{s3}/made", "--json")
    done = CliRunner().invoke(app, [*words, "--cluster", "local:1"])
    assert done.exit_code == 4, done.output
    told = {one["name"]: one for one in json.loads(done.stdout)["captures"]}
    assert (told["P 1"]["state"], told["P2"]["state"]) == ("finished", "refused")
    assert told["P2"]["message"] == f"No board in {s3}/made/P2."
    system = s3fs.S3FileSystem(use_listings_cache=False)
    keys = {key.removeprefix("limbs/made/") for key in system.find("limbs/made")}
    assert {"batch.json", "batch.csv", "batch.html", "P 1/00000001.json"} <= keys
    token = json.loads(system.cat_file("limbs/made/P 1/00000001.json"))["attempt"]
    assert system.cat_file(f"limbs/made/P 1/{token}/deliverables/surface.ply") == b"green" * 100
    assert b"data:image/png" in system.cat_file("limbs/made/batch.html")
    assert json.loads(system.cat_file("limbs/made/batch.json"))["exit_code"] == 4


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("s3://a/b", "-o", "out"), "need --cluster"),
        (("in", "-o", "s3://a/b"), "need --cluster"),
        (("in", "-o", "out", "--cluster", "local:2", "--part", "1/2"), "--part is for jobs"),
        (("in", "-o", "out", "--cluster", "local:2", "--memory", "4"), "--memory is for this"),
    ],
)
def test_what_cannot_go_together_is_refused(words: tuple[str, ...], told: str) -> None:
    done = CliRunner().invoke(app, ["batch", *words])
    assert done.exit_code == 2
    assert told in " ".join(done.output.split())
