"""Attempt process: the process in which a Dask worker makes one attempt at a capture.

In      one JSON line on standard input: what `order_of` makes of a plan. When standard input ends,
        nobody waits any more: what is under way is ended at once and nothing is brought.
Out     JSON lines: events, and last the Result. A whole attempt lies in the storage of the cases,
        where it waits to be accepted (`storage`); on the machine itself nothing is left.
Method  What an earlier attempt made is fetched into a folder of this attempt alone, continued there
        as a batch continues it (`attempt`), and brought as a whole. Folders of attempts whose
        machine lost its power are removed by the next attempt there: their lock is free.

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

from limbgram.batch.attempt import Outcome, Plan, State, attempt, begun, ended, standing
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
_ROOM_MB_A_PHOTO = 50.0
"""What a case takes on the disk while it is made."""
_LATEST_S = 30.0
"""After nobody waits any more: an attempt that has not ended by then ends itself."""
_PREFIX = "limbgram-attempt-"
_CAPTURE, _CASE = "capture", "case"


@dataclass(frozen=True, kw_only=True)
class Result:
    """What an attempt answers."""

    outcome: Outcome
    token: str = ""
    """Of the attempt that waits in the storage; empty: there is nothing to accept."""
    seen: str = ""
    """State of the case from which the attempt began."""
    host: str = ""
    fetch_s: float = 0.0
    work_s: float = 0.0
    bring_s: float = 0.0
    bytes_brought: int = 0


def order_of(plan: Plan, captures: str, folder: Path, cases: str, number: int) -> str:
    """A plan as one line of JSON that says the same on every machine.

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
    held = {
        name: base64.b64encode(read_content(file, _LARGEST_BYTES, OptionsError)).decode()
        for file, name in names.items()
    }
    return json.dumps({
        "program": program_version(_modules(plan)),
        "captures": captures,
        "cases": cases,
        "place": plan.capture.path.relative_to(folder).as_posix(),
        "number": number,
        "files": held,
        "plan": to_tree(plan, [], known.__getitem__),
    })  # fmt: skip


def main() -> int:
    """Do the attempt; what is answered is all that tells how it went."""
    private = os.dup(1)
    os.dup2(2, 1)
    scratch, stopping = Path(sys.argv[1]), Stopping()
    _keep_to(sys.argv[2])
    with os.fdopen(private, "w", encoding="utf-8") as file:
        order: dict[str, Any] = json.loads(_line(sys.stdin.fileno()))
        with _own_folder(scratch) as own:
            words = (sys.stdin.fileno(), stopping, own)
            threading.Thread(target=_watch, args=words, daemon=True).start()
            told = _Told(file)
            told.tell({"event": "begun", "token": own.name.removeprefix(_PREFIX)})
            result = _result(order, own, told.tell, stopping)
        told.tell({"event": "result", "result": tree_of(result)})
    return 0


@dataclass
class _Told:
    """Events as JSON lines; nobody may be there to read them."""

    file: IO[str]

    def tell(self, event: dict[str, Any]) -> None:
        with suppress(BrokenPipeError):
            self.file.write(json.dumps(event) + "\n")
            self.file.flush()


def _line(stream: int) -> bytes:
    """The first line, and no byte more: the rest is watched without a buffer."""
    line = bytearray()
    while not line.endswith(b"\n"):
        piece = os.read(stream, 1 << 16)
        if not piece:
            break
        line += piece
    return bytes(line)


def _watch(stream: int, stopping: Stopping, own: Path) -> None:
    """Stop once nobody waits any more."""
    while os.read(stream, 1):
        pass
    stopping.ask()
    time.sleep(_LATEST_S)
    shutil.rmtree(own, ignore_errors=True)
    os._exit(Cancelled.exit_code)


@contextmanager
def _own_folder(scratch: Path) -> Generator[Path]:
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
    order: dict[str, Any], own: Path, tell: Callable[[dict[str, Any]], None], stopping: Stopping
) -> Result:
    """The attempt, and how long each part of it took."""
    plan = _plan(order, own)
    base = begun(plan, int(order["number"]))
    try:
        if order["program"] != program_version(_modules(plan)):
            raise OptionsError("dask.machine_differs", machine=socket.gethostname())
        return _attempted(order, plan, own, tell, stopping)
    except LimbgramError as error:
        return Result(outcome=ended(base, _state_of(error), error), host=socket.gethostname())
    except OSError as error:
        if error.errno is None:
            raise
        refusal = CaseError.of(disk_finding(error))
        return Result(outcome=ended(base, "died", refusal), host=socket.gethostname())


def _modules(plan: Plan) -> list[str]:
    return [step.module for step in plan.steps]


def _state_of(error: LimbgramError) -> State:
    return "cancelled" if isinstance(error, Cancelled) else "refused"


def _plan(order: dict[str, Any], own: Path) -> Plan:
    """The plan, with the files that came with it, and places of this machine."""
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
    tell: Callable[[dict[str, Any]], None],
    stopping: Stopping,
) -> Result:
    name, host = plan.capture.name, socket.gethostname()
    captures, cases = captures_at(order["captures"]), cases_at(order["cases"])
    token = own.name.removeprefix(_PREFIX)
    (own / "cases").mkdir()
    (own / "captures").mkdir()
    began = time.monotonic()
    tell({"event": "progress", "stage": "fetch", "done": 0, "total": 0})
    fetched = captures.fetch(order["place"], own / "captures", stopping.check)
    plan = replace(plan, capture=replace(plan.capture, path=fetched))
    if isinstance(captures, CaptureFolder) and isinstance(cases, CasesInFolder):
        there = replace(plan, job=replace(plan.job, case=cases.root / name))
        stands = standing(there, int(order["number"]))
        if stands is not None:
            return Result(outcome=stands, host=host)
    seen = cases.fetch(name, plan.job.case, stopping.check)
    fetched_at = time.monotonic()
    outcome = attempt(
        plan,
        own / "cases",
        int(order["number"]),
        tell,
        stopping,
        MemoryGate(float("inf")),
        grace_s=0.0,
    )
    outcome = _elsewhere_if_full(outcome, plan, own)
    worked_at = time.monotonic()
    here, there = str(plan.job.case), cases.place(name)
    outcome = replace(
        outcome,
        finding=_at(outcome.finding, here, there),
        steps=tuple(replace(one, finding=_at(one.finding, here, there)) for one in outcome.steps),
    )
    timed = Result(
        outcome=outcome,
        seen=seen,
        host=host,
        fetch_s=round(fetched_at - began, 3),
        work_s=round(worked_at - fetched_at, 3),
    )
    begun_at_all = CaseFolder(plan.job.case).record.is_file()
    if outcome.state in ("unchanged", "cancelled") or not begun_at_all:
        return timed
    tell({"event": "progress", "stage": "bring", "done": 0, "total": 0})
    count = cases.bring(plan.job.case, name, token, stopping.check)
    spent = round(time.monotonic() - worked_at, 3)
    return replace(timed, token=token, bring_s=spent, bytes_brought=count)


def _elsewhere_if_full(outcome: Outcome, plan: Plan, own: Path) -> Outcome:
    """A refusal that the full disk of this machine explains: another machine may do it."""
    if outcome.state != "refused" or outcome.kind not in ("CaseError", "ExportError"):
        return outcome
    count = sum(1 for _ in plan.capture.path.rglob("*")) if plan.capture.path.is_dir() else 1
    free_mb = shutil.disk_usage(own).free / 2**20
    if free_mb > _ROOM_MB_A_PHOTO * max(1, count):
        return outcome
    found = fault(
        "dask.disk_full", machine=socket.gethostname(), free_mb=free_mb, reason=outcome.finding
    )
    return replace(outcome, state="died", finding=found)


def _at(finding: Finding | None, here: str, there: str) -> Finding | None:
    """A finding with the place where the case will lie in the stead of this machine's."""
    if finding is None:
        return None
    return finding.with_texts(lambda text: text.replace(here, there))


def _keep_to(processors: str) -> None:
    """Keep this process, and those that it starts, to some processors: 0,1; all where empty."""
    if processors and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, [int(one) for one in processors.split(",")])


def result_of(tree: Any) -> Result:
    """The result as another process told it."""
    return value_of(tree, Result)


if __name__ == "__main__":
    sys.exit(main())
