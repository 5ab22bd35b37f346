"""Commands run and timed: in a process of their own, and once more in this one."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from typer.testing import CliRunner

from limbgram.cli.main import app

_NO_BYTECODE = "PYTHONDONTWRITEBYTECODE"
"""Where it is set, every start would compile what an installed program keeps compiled."""
Rows = list[Sequence[str]]


@dataclass
class Tried:
    """Commands that were run, with their seconds; what refuses says so in the results."""

    rows: Rows = field(default_factory=list)
    refused: list[tuple[str, str]] = field(default_factory=list)

    def __call__(self, name: str, arguments: list[str]) -> Any:
        """Run it three times, the first to warm up; returns its reply."""
        body(*arguments)
        start, wall = time.process_time(), time.perf_counter()
        reply = body(*arguments)
        running = time.process_time() - start, time.perf_counter() - wall
        before, wall = os.times(), time.perf_counter()
        whole = run(*arguments)
        whole_s = time.perf_counter() - wall
        after = os.times()
        spent = after.children_user + after.children_system
        spent -= before.children_user + before.children_system
        seconds = (spent, whole_s, *running)
        self.rows.append((name, *(f"{one:.2f}" for one in seconds), str(whole.returncode)))
        if whole.returncode:
            self.refused.append((name, (whole.stderr + whole.stdout).strip()))
        return reply


def run(*arguments: str, threads: str | None = None) -> subprocess.CompletedProcess[str]:
    """A command in a process of its own."""
    told = {} if threads is None else {"NUMBA_NUM_THREADS": threads}
    kept = {name: value for name, value in os.environ.items() if name != _NO_BYTECODE}
    return subprocess.run(
        [sys.executable, "-P", "-c", "from limbgram.cli.main import app; app()", *arguments],
        env={**kept, **told},
        capture_output=True,
        text=True,
        check=False,
    )


def body(*arguments: str) -> Any:
    """The JSON reply of a command in this process."""
    answer = CliRunner().invoke(app, [*arguments, "--json"])
    if answer.exception is not None and not isinstance(answer.exception, SystemExit):
        raise answer.exception
    return json.loads(answer.stdout) if answer.stdout.startswith(("{", "[")) else {}


def done(*arguments: str) -> Any:
    """The reply of a command that everything after it needs."""
    reply = body(*arguments)
    if "error" in reply:
        raise SystemExit(f"limbgram {' '.join(arguments)}: {reply['error']['message']}")
    return reply
