"""However the job's process ends, the caller learns what happened and what to do."""

import json
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import limbgram
from limbgram.cases.child_process import Event
from limbgram.cases.folder import CaseFolder, locked
from limbgram.cases.job_messages import Answer, Job, plain_tree
from limbgram.cases.job_supervision import JobBug, JobDied, Supervision
from limbgram.core.errors import Cancelled, CaseError, PhotoError, ScaleError

HEAD = """
import json, os, sys, time
def send(**event):
    print(json.dumps(event), flush=True)
job = json.loads(sys.stdin.readline())
send(event="progress", stage="place", done=1, total=3)
"""


def supervised(tmp_path: Path, body: str, grace_s: float = 5.0) -> tuple[Supervision, list[Event]]:
    script = tmp_path / "child.py"
    script.write_text(HEAD + textwrap.dedent(body), "utf-8")
    events: list[Event] = []
    job = Job(case=tmp_path / "Fall ä 1", sources=(tmp_path,))
    command = (sys.executable, str(script))
    return Supervision(job, events.append, command, grace_s), events


def test_an_answer_comes_back(tmp_path: Path) -> None:
    supervision, events = supervised(
        tmp_path,
        """
        place = {"path": job["case"]["path"] + "/s.json"}
        send(event="finished", answer={"is": "Answer", "summary": place, "lines": ["GREEN"]})
        """,
    )
    summary = tmp_path / "Fall ä 1" / "s.json"
    assert supervision.wait() == Answer(summary=summary, lines=("GREEN",))
    assert [event["event"] for event in events] == ["progress", "finished"]


def test_a_refusal_is_raised_as_it_was(tmp_path: Path) -> None:
    found = {"code": "said.as_is", "gravity": "fault", "values": {"message": "No board."}}
    body = f'send(event="refused", kind="ScaleError", finding={found}); sys.exit(4)'
    with pytest.raises(ScaleError, match=r"^No board\.$"):
        supervised(tmp_path, body)[0].wait()


def test_a_bug_brings_its_traceback(tmp_path: Path) -> None:
    body = 'send(event="bug", traceback="Traceback: here"); sys.exit(1)'
    with pytest.raises(JobBug, match="Traceback: here"):
        supervised(tmp_path, body)[0].wait()


@pytest.mark.skipif(sys.platform == "win32", reason="signals end processes on POSIX only")
def test_an_abort_names_the_stage_the_signal_and_the_log(tmp_path: Path) -> None:
    body = 'sys.stderr.write("Check failed: x > 0\\n"); sys.stderr.flush(); os.abort()'
    with pytest.raises(JobDied, match=r"SIGABRT during 'place'") as caught:
        supervised(tmp_path, body)[0].wait()
    assert "Check failed: x > 0" in str(caught.value)
    assert "run the same command again" in str(caught.value)
    assert caught.value.exit_code == 6


@pytest.mark.skipif(sys.platform == "win32", reason="signals end processes on POSIX only")
def test_a_kill_is_explained_by_memory(tmp_path: Path) -> None:
    with pytest.raises(JobDied, match="memory ran out"):
        supervised(tmp_path, "os.kill(os.getpid(), 9)")[0].wait()


def test_ending_without_an_answer_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(JobDied, match="with code 7"):
        supervised(tmp_path, "sys.exit(7)")[0].wait()


@pytest.mark.skipif(sys.platform == "win32", reason="signals end processes on POSIX only")
@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ('event="finished", answer={}', "finished"),
        (
            'event="refused", kind="ScaleError", finding={"code": "said.as_is", '
            '"gravity": "fault", "values": {"message": "No board."}}',
            r"No board\.",
        ),
    ],
)
def test_a_process_that_dies_after_its_answer_is_not_believed(
    answer: str, said: str, tmp_path: Path
) -> None:
    body = f"send({answer}); os.abort()"
    with pytest.raises(JobDied, match=rf"SIGABRT after 'place', though it had .* {said}"):
        supervised(tmp_path, body)[0].wait()


REAL = """
import sys
from limbgram.cases import job_worker
from limbgram.cases.job import Done
from pathlib import Path
from limbgram.cases.job_messages import Answer
answer = Answer(summary=job_worker.CaseFolder(Path(sys.argv[1])).summary)
job_worker.do = lambda job, run: run.case.summary.write_text("{}") and Done(None, {}, answer)
job_worker.write_record = lambda case, *args, **more: case.record.write_text("{}")
sys.exit(job_worker.main())
"""


@pytest.mark.slow
def test_the_real_worker_ends_in_silence_every_time(tmp_path: Path) -> None:
    script = tmp_path / "child.py"
    script.write_text(REAL, "utf-8")
    job = Job(case=tmp_path / "case", sources=(tmp_path,))
    for _ in range(4):
        supervision = Supervision(job, lambda _event: None, (sys.executable, str(script)))
        assert supervision.wait().summary == tmp_path / "case" / "summary.json"
    assert (tmp_path / "case" / "log.txt").read_bytes() == b""


ENDLESS = """
import sys, time
from limbgram.cases import job_worker
job_worker.do = lambda job, run: [run.report(k, 1000) or time.sleep(0.05) for k in range(1000)]
job_worker.write_record = lambda *args, **more: None
sys.exit(job_worker.main())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="pipes break otherwise there")
def test_the_real_worker_ends_in_silence_when_its_command_is_gone(tmp_path: Path) -> None:
    script = tmp_path / "child.py"
    script.write_text(ENDLESS, "utf-8")
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "a.jpg").write_bytes(b"photo")
    job = Job(case=tmp_path / "case", sources=(tmp_path / "photos",))
    with subprocess.Popen(
        [sys.executable, str(script)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdin.write(json.dumps(plain_tree(job)).encode() + b"\n")
        process.stdin.flush()
        assert json.loads(process.stdout.readline())["event"] == "progress"
        process.stdout.close()
        process.stdin.close()
        assert process.stderr.read() == b""
        assert process.wait() == 130


PLANTED = ("queue", "json", "numpy", "limbgram", "platform", "typer")


def test_code_and_settings_in_the_current_folder_are_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    photos = tmp_path / "photos"
    photos.mkdir()
    ran = tmp_path / "ran"
    for name in PLANTED:
        (photos / f"{name}.py").write_text(f"open({str(ran)!r}, 'a').write('{name} ')\n", "utf-8")
    (photos / "matplotlibrc").write_text("no setting: at all\n", "utf-8")
    (photos / ".numba_config.yaml").write_text("disable_jit: 1\n", "utf-8")
    monkeypatch.chdir(photos)
    sources = str(Path(limbgram.__file__).parents[1])
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(("", sources)))  # "" is the current folder
    with pytest.raises(PhotoError, match="no photos in"):
        Supervision(Job(case=tmp_path / "case", sources=(Path(),)), lambda _event: None).wait()
    assert not ran.exists(), ran.read_text("utf-8")
    assert (tmp_path / "case" / "log.txt").read_bytes() == b""
    record = json.loads((tmp_path / "case" / "case.json").read_text("utf-8"))
    assert record["state"] == "refused"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signal between programs")
def test_a_job_that_the_system_ends_stops_at_its_next_step(tmp_path: Path) -> None:
    """And says so: what is finished is kept."""
    script = tmp_path / "child.py"
    script.write_text(
        textwrap.dedent("""
        import sys, time
        from limbgram.cases import job_worker
        from limbgram.core.run import track
        def steps():
            for _ in track(range(600)):
                time.sleep(0.1)
        job_worker.do = lambda job, run: run.unkept(steps)
        sys.exit(job_worker.main())
        """),
        "utf-8",
    )
    photos = tmp_path / "photos"
    photos.mkdir()
    (photos / "1.jpg").write_bytes(b"a photo")
    events: list[Event] = []

    def hear(event: Event) -> None:
        if not events and supervision.process_id is not None:
            os.kill(supervision.process_id, signal.SIGTERM)
        events.append(event)

    job = Job(case=tmp_path / "case", sources=(photos,))
    supervision = Supervision(job, hear, (sys.executable, str(script)))
    with pytest.raises(Cancelled, match="Finished stages are kept"):
        supervision.wait()
    assert events[-1]["kind"] == "Cancelled"
    assert json.loads((tmp_path / "case" / "case.json").read_text("utf-8"))["state"] == "cancelled"


@pytest.fixture
def interrupt_soon() -> Iterator[None]:
    """Ctrl-C in a moment, heard even where the tests run in the background of a shell."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.6, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    yield
    timer.cancel()
    signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C cannot be sent to oneself alone")
@pytest.mark.parametrize(
    ("body", "least_s", "most_s"),
    [("sys.stdin.read(); sys.exit(130)", 0.5, 4.0), ("time.sleep(60)", 3.0, 9.0)],
    ids=["stops when told", "is killed after the grace"],
)
@pytest.mark.usefixtures("interrupt_soon")
def test_ctrl_c_stops_the_job(tmp_path: Path, body: str, least_s: float, most_s: float) -> None:
    supervision, events = supervised(tmp_path, body, grace_s=1.0)
    began = time.monotonic()
    with pytest.raises(Cancelled, match="run the same command again"):
        supervision.wait()
    assert least_s < time.monotonic() - began < most_s
    assert events[-1] == {"event": "stopping", "stage": "place"}


def test_a_case_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    job = Job(case=tmp_path / "file" / "case", sources=(tmp_path,))
    with pytest.raises(CaseError, match="cannot be made"):
        Supervision(job, lambda _event: None).wait()


@pytest.mark.slow
def test_the_real_worker_refuses_a_missing_folder(tmp_path: Path) -> None:
    job = Job(case=tmp_path / "case", sources=(tmp_path / "nowhere",))
    with pytest.raises(Exception, match="nowhere does not exist"):
        Supervision(job, lambda _event: None).wait()
    record = json.loads((tmp_path / "case" / "case.json").read_text("utf-8"))
    assert record["state"] == "refused"
    assert "nowhere does not exist" in record["message"]


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    """Two files that are photos by name."""
    folder = tmp_path / "photos"
    folder.mkdir()
    for name in ("a.jpg", "b.jpg"):
        (folder / name).write_bytes(name.encode())
    return folder


def block_record(case: Path) -> None:
    (case / "case.json").mkdir(parents=True)


def block_photos(case: Path) -> None:
    case.mkdir()
    (case / "case.json").write_text("{}")
    (case / "photos").write_text("no folder")


def block_log(case: Path) -> None:
    (case / "log.txt").mkdir(parents=True)


def block_lock(case: Path) -> None:
    (case / ".lock").mkdir(parents=True)


@pytest.mark.parametrize(
    "block",
    [
        block_photos,
        *(
            pytest.param(one, marks=pytest.mark.slow)
            for one in (block_log, block_record, block_lock)
        ),
    ],
)
def test_what_is_in_the_way_is_refused_by_the_real_worker(
    block: Callable[[Path], None], photos: Path, tmp_path: Path
) -> None:
    block(tmp_path / "case")
    with pytest.raises(CaseError, match=r"is in the way: .* Move it elsewhere"):
        Supervision(Job(case=tmp_path / "case", sources=(photos,)), lambda _event: None).wait()


@pytest.mark.slow
def test_a_folder_without_photos_is_refused_by_the_real_worker(tmp_path: Path) -> None:
    photos = tmp_path / "photos"
    photos.mkdir()
    (photos / "letter.docx").write_bytes(b"")
    with pytest.raises(PhotoError, match="no photos in"):
        Supervision(Job(case=tmp_path / "case", sources=(photos,)), lambda _event: None).wait()
    record = json.loads((tmp_path / "case" / "case.json").read_text("utf-8"))
    assert record["state"] == "refused"


def test_the_photos_own_folder_is_no_case_and_stays_as_it_is(photos: Path) -> None:
    with pytest.raises(CaseError, match="folder of the photos itself"):
        Supervision(Job(case=photos, sources=(photos,)), lambda _event: None).wait()
    assert sorted(file.name for file in photos.iterdir()) == ["a.jpg", "b.jpg"]


@pytest.mark.skipif(sys.platform == "win32", reason="uses POSIX locks")
def test_two_runs_do_not_share_a_case(tmp_path: Path) -> None:
    case = tmp_path / "case"
    with locked(CaseFolder(case)), pytest.raises(CaseError, match="Another run"):
        Supervision(Job(case=case, sources=(tmp_path,)), lambda _event: None).wait()
