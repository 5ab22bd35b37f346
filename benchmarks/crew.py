"""Crew: a Dask scheduler and workers for benchmarks, each a process of its own, as on a cluster.

A worker may have a small disk of its own, or stand in a network of its own whose cable can be cut;
both need the rights of an administrator on Linux. In place of a reconstruction a stub may work,
which takes a few seconds and makes files that are known beforehand.
"""

import hashlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import limbgram

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
import hashlib, json, pathlib, sys, time
job = json.loads(sys.stdin.readline())
case = pathlib.Path(job["case"]["path"])
seconds = float((pathlib.Path(job["sources"][0]["path"]) / "what.txt").read_text())
def send(**event):
    print(json.dumps(event), flush=True)
(case / "case.json").write_text("{}")
send(event="progress", stage="place", done=0, total=0)
(case / "deliverables").mkdir(exist_ok=True)
with (case / "deliverables" / "surface.ply").open("wb") as file:
    for piece in range(FILES_MB * 16):
        file.write(hashlib.sha256(f"{case.name} {piece}".encode()).digest() * 2048)
        time.sleep(seconds / FILES_MB / 16)
(case / "summary.json").write_text(json.dumps(
    {"verdict": {"light": "green", "headline": "GREEN", "reasons": []}}))
send(event="finished", answer={
    "is": "Answer", "summary": {"path": str(case / "summary.json")}, "light": "green"})
"""
FILES_MB = 2
NET = ("10.77.0.1", "10.77.0.2")


def stub_sha256(name: str) -> str:
    """Of the surface that the stub makes of a capture."""
    digest = hashlib.sha256()
    for piece in range(FILES_MB * 16):
        digest.update(hashlib.sha256(f"{name} {piece}".encode()).digest() * 2048)
    return digest.hexdigest()


def lay_stubs(folder: Path, count: int, seconds: float) -> None:
    """Captures of which the stub makes something."""
    for number in range(1, count + 1):
        place = folder / f"P{number:03d}"
        place.mkdir(parents=True)
        (place / "what.txt").write_text(str(seconds))
        (place / "a.jpg").write_bytes(b"\xff\xd8\xff")


@dataclass
class Crew:
    """The processes of a cluster."""

    folder: Path
    ttl_s: float = 5.0
    workers: list["subprocess.Popen[bytes]"] = field(default_factory=list)
    """That may be killed."""
    head: "subprocess.Popen[bytes] | None" = None
    address: str = ""
    _count: int = 0
    _all: list["subprocess.Popen[bytes]"] = field(default_factory=list)

    def __post_init__(self) -> None:
        (self.folder / "stub_attempt.py").write_text(ATTEMPT)
        (self.folder / "stub_job.py").write_text(JOB.replace("FILES_MB", str(FILES_MB)))

    def scheduler(self) -> None:
        """Start it, or start it again at the same address."""
        told = self.folder / "scheduler.json"
        told.unlink(missing_ok=True)
        port = self.address.rpartition(":")[2] or "0"
        words = ("--scheduler-file", str(told), "--port", port)
        self.head = self._start("dask_scheduler", words)
        until(told.exists)
        self.address = json.loads(told.read_text())["address"]

    def worker(self, scratch: Path | None = None, *before: str, address: str = "") -> Any:
        """Start one more; `before` are words of a command that starts it."""
        self._count += 1
        place = scratch or self.folder / "scratch"
        words = (
            address or self.address,
            *("--nthreads", "1", "--no-nanny", "--local-directory", str(place)),
            *("--name", f"w{self._count}"),
        )
        process = self._start("dask_worker", words, before)
        self.workers.append(process)
        self._all.append(process)
        return process

    def _start(
        self, name: str, words: tuple[str, ...], before: tuple[str, ...] = ()
    ) -> "subprocess.Popen[bytes]":
        source = str(Path(limbgram.__file__).parents[1])
        settings = {
            "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0",
            "DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": f"{self.ttl_s}s",
            "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
            "PYTHONPATH": f"{self.folder}{os.pathsep}{source}",
        }
        log = (self.folder / f"{name}-{self._count}.log").open("wb")
        return subprocess.Popen(
            [*before, sys.executable, "-P", "-m", f"distributed.cli.{name}", "--no-dashboard",
             *words],
            env={**os.environ, **settings}, stdout=log, stderr=log, start_new_session=True,
        )  # fmt: skip

    def end(self) -> None:
        for process in (*self._all, *([self.head] if self.head else [])):
            process.kill()
            process.wait()


@contextmanager
def crew_of(folder: Path, workers: int, ttl_s: float = 5.0) -> Generator[Crew]:
    crew = Crew(folder, ttl_s)
    try:
        crew.scheduler()
        for _ in range(workers):
            crew.worker()
        until(lambda: present(crew) == workers)
        yield crew
    finally:
        crew.end()


def present(crew: Crew) -> int:
    """Workers that the scheduler knows."""
    from distributed import Client

    with Client(crew.address, set_as_default=False) as client:
        return len(client.scheduler_info(n_workers=-1)["workers"])


def until(holds: Callable[[], bool], seconds: float = 120.0) -> None:
    deadline = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > deadline:
            raise SystemExit("A part of the cluster did not come.")
        time.sleep(0.1)


@contextmanager
def small_disk(place: Path, size_mb: int) -> Generator[Path | None]:
    """A disk in memory of so few MB; None where this user may not have one."""
    place.mkdir(parents=True)
    words = ["mount", "-t", "tmpfs", "-o", f"size={size_mb}m", "none", str(place)]
    if subprocess.run(words, check=False, capture_output=True).returncode:
        yield None
        return
    try:
        yield place
    finally:
        subprocess.run(["umount", "-l", str(place)], check=False)


@contextmanager
def far_network(name: str = "limbgram-far") -> Generator[tuple[str, ...] | None]:
    """A network of its own behind one cable; the words that start a command there.

    None where this user may not have one.
    """
    here, there = NET
    lines = (
        f"ip netns add {name}",
        f"ip link add lgnear type veth peer name lgfar netns {name}",
        f"ip addr add {here}/24 dev lgnear",
        "ip link set lgnear up",
        f"ip netns exec {name} ip addr add {there}/24 dev lgfar",
        f"ip netns exec {name} ip link set lgfar up",
        f"ip netns exec {name} ip link set lo up",
    )
    made = all(
        not subprocess.run(line.split(), check=False, capture_output=True).returncode
        for line in lines
    )
    try:
        yield ("ip", "netns", "exec", name) if made else None
    finally:
        subprocess.run(["ip", "netns", "del", name], check=False, capture_output=True)


def cable(*, up: bool) -> None:
    subprocess.run(["ip", "link", "set", "lgnear", "up" if up else "down"], check=True)
