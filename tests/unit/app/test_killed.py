"""The app as a process that is killed, or asked to end: nothing is lost, nothing left over."""

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from PIL import Image

API = "/api/v1"
PROGRAM = "import sys; sys.argv[0] = 'limbgram'; from limbgram.cli.main import app; app()"
WITH_PYCOLMAP = """
import sys, threading
from pathlib import Path
from limbgram.app.local_server import ServeOptions, serve
def ready(link):
    import pycolmap
    print(link, flush=True)
serve(ServeOptions(cases=Path(sys.argv[1]), no_browser=True), ready)
print("ended by itself", flush=True)
"""

pytestmark = pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are told by /proc")


@contextmanager
def app_on(cases: Path) -> Iterator[tuple["subprocess.Popen[str]", httpx.Client]]:
    """The app in a process of its own, and somebody who is signed in."""
    words = ["app", "--no-browser", "--json", "--cases", str(cases)]
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", PROGRAM, *words], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        link: str = json.loads(process.stdout.readline())["link"]
        with httpx.Client(base_url=link.partition("/start")[0], timeout=60) as client:
            client.get(link).raise_for_status()
            yield process, client
    finally:
        process.kill()
        process.wait(20)


def test_a_kill_in_mid_upload_and_in_mid_run_loses_nothing(tmp_path: Path) -> None:
    """Nor does the app that is asked to end."""
    cases, photos = tmp_path / "cases", noise(tmp_path, 8)
    content = photos[0].read_bytes()
    half = len(content) // 2
    with app_on(cases) as (process, client):
        case = f"{API}/cases/" + client.post(f"{API}/cases", json={}).json()["id"]
        for photo in photos[1:]:
            client.put(f"{case}/photos/{photo.name}", content=photo.read_bytes()).raise_for_status()
        started = client.post(f"{case}/job", json={"board": None, "unscaled": True})
        assert started.status_code == 202
        worker = worker_of(client, case)
        first = {"content-range": f"bytes 0-{half - 1}/{len(content)}"}
        sent = client.put(f"{case}/photos/{photos[0].name}", content=content[:half], headers=first)
        assert sent.json()["bytes"] == half
        process.send_signal(signal.SIGKILL)
        process.wait(20)
    before_s = kept_of(cases, case)["elapsed_s"]
    wait_until(lambda: not Path(f"/proc/{worker}").exists(), "the run goes on without the app")
    with app_on(cases) as (process, client):
        told = {one["name"]: one for one in client.get(f"{case}/photos").json()["photos"]}
        assert len(told) == len(photos)
        arriving = told[photos[0].name]
        assert (arriving["state"], arriving["bytes"]) == ("arriving", half)
        rest = {"content-range": f"bytes {half}-{len(content) - 1}/{len(content)}"}
        sent = client.put(f"{case}/photos/{photos[0].name}", content=content[half:], headers=rest)
        assert sent.json()["whole"]
        assert sent.json()["photos"][0]["sha256"] == hashlib.sha256(content).hexdigest()
        assert worker_of(client, case) != worker, "it goes on by itself"
        assert client.get(f"{case}/job").json()["elapsed_s"] >= before_s > 0
        worker = worker_of(client, case)
        client.close()
        process.send_signal(signal.SIGTERM)
        require_ended(process, worker, cases, case)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("asked", "first"),
    [(signal.SIGTERM, "app"), (signal.SIGINT, "app"), (signal.SIGTERM, "worker")],
)
def test_asked_to_end_it_ends_what_runs_and_says_so(
    tmp_path: Path, asked: signal.Signals, first: str
) -> None:
    """The app alone is asked, or its run before it, as where the machine shuts down."""
    with app_on(tmp_path / "cases") as (process, client):
        case = f"{API}/cases/" + client.post(f"{API}/cases", json={}).json()["id"]
        for photo in noise(tmp_path, 4):
            client.put(f"{case}/photos/{photo.name}", content=photo.read_bytes())
        client.post(f"{case}/job", json={"board": None, "unscaled": True})
        worker = worker_of(client, case)
        if first == "worker":
            os.kill(worker, signal.SIGTERM)
            wait_until(lambda: not Path(f"/proc/{worker}").exists(), "the run does not end")
        client.close()
        process.send_signal(asked)
        require_ended(process, worker, tmp_path / "cases", case)


def require_ended(process: "subprocess.Popen[str]", worker: int, cases: Path, case: str) -> None:
    """What runs has ended with the app, which says so; it is to go on when the app is back."""
    assert process.stdout is not None
    assert json.loads(process.stdout.read()) == {"closed": True}
    assert process.wait(20) == 0
    wait_until(lambda: not Path(f"/proc/{worker}").exists(), "the run goes on without the app")
    kept = kept_of(cases, case)
    assert (kept["state"], kept["wanted"]) == ("interrupted", True)


def test_libraries_that_take_signals_do_not_keep_it_from_ending(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", WITH_PYCOLMAP, str(tmp_path / "cases")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    process.stdout.readline()
    time.sleep(2.5)  # the handlers are put back once a second
    os.kill(process.pid, signal.SIGTERM)
    said, trace = process.communicate(timeout=20)
    assert (process.returncode, said, trace) == (0, "ended by itself\n", "")


def kept_of(cases: Path, case: str) -> dict[str, Any]:
    """What a case's job file says."""
    return json.loads((cases / case.rpartition("/")[2] / "job.json").read_text("utf-8"))


def noise(folder: Path, count: int) -> list[Path]:
    random = np.random.default_rng(3)
    found = [folder / f"IMG_{k:02d}.png" for k in range(count)]
    for file in found:
        Image.fromarray(random.integers(0, 256, (500, 700, 3), np.uint8)).save(file)
    return found


def worker_of(client: httpx.Client, case: str) -> int:
    """The process of a run, once it told of its first stage."""
    found: list[Any] = []

    def runs() -> bool:
        job = client.get(f"{case}/job").json()
        assert job["state"] == "running", job
        found[:] = [one for one in job["stages"] if one["state"] == "running"]
        return bool(found)

    wait_until(runs, "the run does not begin")
    children = [
        int(entry.name)
        for entry in Path("/proc").iterdir()
        if entry.name.isdecimal() and case.rpartition("/")[2] in _words(entry)
    ]
    assert len(children) == 1
    return children[0]


def _words(process: Path) -> str:
    try:
        words = (process / "cmdline").read_bytes().decode("utf-8", "replace")
    except OSError:
        return ""
    return words if "limbgram.cases.job_process" in words else ""


def wait_until(holds: Any, otherwise: str) -> None:
    for _ in range(1200):
        if holds():
            return
        time.sleep(0.05)
    raise AssertionError(otherwise)
