"""Attempt process: the process in which a Dask worker makes one attempt at a capture.

In      one JSON line on standard input: what `order_of` makes of a plan. When standard input ends,
        nobody waits any more: the attempt is ended at once and nothing is uploaded.
Out     JSON lines: events, and last the Result. A complete attempt lies in the storage of the
        cases, where it waits to be accepted (`storage`); nothing is left on the machine itself.
Method  What an earlier attempt made is fetched into a folder of this attempt alone, continued there
        as a batch continues it (`attempt`), and uploaded as a whole. The folder of an attempt whose
        machine lost power is removed by the next attempt there: its lock is free.

Runs as `python -P -m limbgram.batch.attempt_process SCRATCH PROCESSORS`.
"""

import base64
import json
import os
import secrets
import shutil
import socket
import sys
import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any

from limbgram.batch.attempt import (
    Outcome,
    Plan,
    State,
    attempt,
    failed_outcome,
    unchanged_outcome,
    undecided_outcome,
)
from limbgram.batch.memory import MemoryGate
from limbgram.batch.stopping import Stopping
from limbgram.batch.storage import (
    CaptureFolder,
    CasesInFolder,
    captures_at,
    cases_at,
)
from limbgram.batch.versions import program_version
from limbgram.cases.encoding import from_tree, to_tree
from limbgram.cases.folder import CaseFolder, locked
from limbgram.core.errors import (
    Cancelled,
    CaseError,
    LimbgramError,
    OptionsError,
    disk_finding,
)
from limbgram.core.files import read_content
from limbgram.core.typed import tree_of, value_of
from limbgram.findings import Finding, fault

MODULE = "limbgram.batch.attempt_process"
_LARGEST_BYTES = 16_000_000
_DISK_MB_PER_PHOTO = 50.0
"""Disk space that a case takes while it is computed."""
_STOP_GRACE_S = 30.0
"""From the end of standard input until the process kills itself."""
_PREFIX = "limbgram-attempt-"
_CAPTURE, _CASE = "capture", "case"


@dataclass(frozen=True, kw_only=True)
class Result:
    """What an attempt answers."""

    outcome: Outcome
    token: str = ""
    """Of the attempt that waits in the storage; empty: there is nothing to accept."""
    seen: str = ""
    """State of the stored case from which the attempt began."""
    host: str = ""
    fetch_s: float = 0.0
    work_s: float = 0.0
    bring_s: float = 0.0
    bytes_brought: int = 0


def order_of(plan: Plan, captures: str, folder: Path, cases: str, number: int) -> str:
    """A plan as one line of JSON that means the same on every machine.

    Args:
        captures: The folder or URL of the captures.
        folder: Where the plan found them; another one if they lie behind a URL.
        cases: The folder or URL of the cases.
        number: How many attempts this makes.

    Raises:
        OptionsError: a file that the settings name cannot be read.
    """
    files = [*plan.job.camera_files, *(file for step in plan.steps for file in step.files)]
    names = {file: f"{idx}-{file.name}" for idx, file in enumerate(dict.fromkeys(files))}
    known = {**names, plan.capture.path: _CAPTURE, plan.job.case: _CASE}
    contents = {
        name: base64.b64encode(read_content(file, _LARGEST_BYTES, OptionsError)).decode()
        for file, name in names.items()
    }
    return json.dumps({
        "program": program_version(_modules(plan)),
        "captures": captures,
        "cases": cases,
        "place": plan.capture.path.relative_to(folder).as_posix(),
        "number": number,
        "files": contents,
        "plan": to_tree(plan, [], known.__getitem__),
    })  # fmt: skip


def main() -> int:
    """Make the attempt; its Result alone tells how it ended, not the exit code."""
    private = os.dup(1)
    os.dup2(2, 1)
    scratch, stopping = Path(sys.argv[1]), Stopping()
    _run_on(sys.argv[2])
    with os.fdopen(private, "w", encoding="utf-8") as file:
        order: dict[str, Any] = json.loads(_first_line(sys.stdin.fileno()))
        with _attempt_folder(scratch) as own:
            watched = (sys.stdin.fileno(), stopping, own)
            threading.Thread(target=_stop_at_end_of_input, args=watched, daemon=True).start()
            events = _Events(file)
            events.send({"event": "begun", "token": own.name.removeprefix(_PREFIX)})
            result = _result(order, own, events.send, stopping)
        events.send({"event": "result", "result": tree_of(result)})
    return 0


@dataclass
class _Events:
    """Writes events as JSON lines; nobody may be there to read them."""

    file: IO[str]

    def send(self, event: dict[str, Any]) -> None:
        with suppress(BrokenPipeError):
            self.file.write(json.dumps(event) + "\n")
            self.file.flush()


def _first_line(stream: int) -> bytes:
    """The first line, read without a buffer: `_stop_at_end_of_input` reads what follows."""
    line = bytearray()
    while not line.endswith(b"\n"):
        piece = os.read(stream, 1 << 16)
        if not piece:
            break
        line += piece
    return bytes(line)


def _stop_at_end_of_input(stream: int, stopping: Stopping, own: Path) -> None:
    """Stop once nobody waits any more."""
    while os.read(stream, 1):
        pass
    stopping.ask()
    time.sleep(_STOP_GRACE_S)
    shutil.rmtree(own, ignore_errors=True)
    os._exit(Cancelled.exit_code)


@contextmanager
def _attempt_folder(scratch: Path) -> Generator[Path]:
    """A folder of this attempt alone, locked while it lives; those of dead attempts are removed."""
    scratch.mkdir(parents=True, exist_ok=True)
    for left in sorted(scratch.glob(f"{_PREFIX}*")):
        with suppress(CaseError, OSError), locked(CaseFolder(left)):
            shutil.rmtree(left, ignore_errors=True)
    own = scratch / f"{_PREFIX}{secrets.token_hex(8)}"
    with locked(CaseFolder(own)):
        try:
            yield own
        finally:
            shutil.rmtree(own, ignore_errors=True)


def _result(
    order: dict[str, Any], own: Path, send: Callable[[dict[str, Any]], None], stopping: Stopping
) -> Result:
    """The attempt, and how long each part of it took."""
    plan = _plan(order, own)
    base = undecided_outcome(plan, int(order["number"]))
    try:
        if order["program"] != program_version(_modules(plan)):
            raise OptionsError("dask.machine_differs", machine=socket.gethostname())
        return _attempted(order, plan, own, send, stopping)
    except LimbgramError as error:
        return Result(
            outcome=failed_outcome(base, _state_of(error), error), host=socket.gethostname()
        )
    except OSError as error:
        if error.errno is None:
            raise
        refusal = CaseError.of(disk_finding(error))
        return Result(outcome=failed_outcome(base, "died", refusal), host=socket.gethostname())


def _modules(plan: Plan) -> list[str]:
    return [step.module for step in plan.steps]


def _state_of(error: LimbgramError) -> State:
    return "cancelled" if isinstance(error, Cancelled) else "refused"


def _plan(order: dict[str, Any], own: Path) -> Plan:
    """The plan, with the files that came with it, its paths those of this machine."""
    given = own / "given"
    given.mkdir()
    for name, content in order["files"].items():
        (given / Path(name).name).write_bytes(base64.b64decode(content))
    plan: Plan = from_tree(order["plan"], Plan, [], given)
    capture = replace(plan.capture, path=given / Path(order["place"]).name)
    job = replace(plan.job, case=own / "cases" / plan.capture.name)
    return replace(plan, capture=capture, job=job)


def _attempted(
    order: dict[str, Any],
    plan: Plan,
    own: Path,
    send: Callable[[dict[str, Any]], None],
    stopping: Stopping,
) -> Result:
    """Fetch the capture and its case, make the attempt, upload it."""
    name, number, host = plan.capture.name, int(order["number"]), socket.gethostname()
    captures, cases = captures_at(order["captures"]), cases_at(order["cases"])
    token = own.name.removeprefix(_PREFIX)
    (own / "cases").mkdir()
    (own / "captures").mkdir()
    began = time.monotonic()
    send({"event": "progress", "stage": "fetch", "done": 0, "total": 0})
    fetched = captures.fetch(order["place"], own / "captures", stopping.check)
    plan = replace(plan, capture=replace(plan.capture, path=fetched))
    if isinstance(captures, CaptureFolder) and isinstance(cases, CasesInFolder):
        in_place = replace(plan, job=replace(plan.job, case=cases.root / name))
        unchanged = unchanged_outcome(in_place, number)
        if unchanged is not None:
            return Result(outcome=unchanged, host=host)
    seen = cases.fetch(name, plan.job.case, stopping.check)
    fetched_at = time.monotonic()
    gate = MemoryGate(float("inf"))
    outcome = attempt(plan, own / "cases", number, send, stopping, gate, grace_s=0.0)
    outcome = _elsewhere_if_full(outcome, plan, own)
    worked_at = time.monotonic()
    timed = Result(
        outcome=_with_final_paths(outcome, str(plan.job.case), cases.place(name)),
        seen=seen,
        host=host,
        fetch_s=round(fetched_at - began, 3),
        work_s=round(worked_at - fetched_at, 3),
    )
    has_case = CaseFolder(plan.job.case).record.is_file()
    if outcome.state in ("unchanged", "cancelled") or not has_case:
        return timed
    send({"event": "progress", "stage": "bring", "done": 0, "total": 0})
    bytes_brought = cases.bring(plan.job.case, name, token, stopping.check)
    bring_s = round(time.monotonic() - worked_at, 3)
    return replace(timed, token=token, bring_s=bring_s, bytes_brought=bytes_brought)


def _elsewhere_if_full(outcome: Outcome, plan: Plan, own: Path) -> Outcome:
    """A refusal that the full disk of this machine explains: another machine may do it."""
    if outcome.state != "refused" or outcome.kind not in ("CaseError", "ExportError"):
        return outcome
    count = sum(1 for _ in plan.capture.path.rglob("*")) if plan.capture.path.is_dir() else 1
    free_mb = shutil.disk_usage(own).free / 2**20
    if free_mb > _DISK_MB_PER_PHOTO * max(1, count):
        return outcome
    disk_full = fault(
        "dask.disk_full", machine=socket.gethostname(), free_mb=free_mb, reason=outcome.finding
    )
    return replace(outcome, state="died", finding=disk_full)


def _with_final_paths(outcome: Outcome, here: str, there: str) -> Outcome:
    """The outcome with paths of the case as it will lie in the storage, not as it lies here."""

    def moved(finding: Finding | None) -> Finding | None:
        return finding and finding.with_texts(lambda text: text.replace(here, there))

    steps = tuple(replace(step, finding=moved(step.finding)) for step in outcome.steps)
    return replace(outcome, finding=moved(outcome.finding), steps=steps)


def _run_on(processors: str) -> None:
    """Bind this process, and those that it starts, to processors: 0,1; to none where empty."""
    if processors and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, [int(one) for one in processors.split(",")])


def result_of(tree: Any) -> Result:
    """The result as another process told it."""
    return value_of(tree, Result)


if __name__ == "__main__":
    sys.exit(main())
