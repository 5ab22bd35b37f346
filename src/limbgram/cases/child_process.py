"""Child process: a program of ours beside this one, told one line, telling events line by line.

It imports from where this one does, never from the folder that this one was started in, and gets no
Ctrl-C of its own. Its standard input stays open while somebody wants it: once that is closed, also
because this process is gone, it ends by itself.
"""

import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, Final

from limbgram.core.run import NEUTRAL_FOLDER

Event = dict[str, Any]
NO_MORE: Final[Event] = {"event": "ended"}
"""After the last event: the process has closed its output."""
_MEMORY = {"GLIBC_TUNABLES": "glibc.malloc.arena_max=1:glibc.malloc.hugetlb=1"}
"""Threads share one heap, in pages of 2 MB: a quarter less memory, a tenth less time in the
system. Only glibc reads it."""


class ChildProcess:
    """One such process; `process` is the system's."""

    def __init__(
        self,
        command: Sequence[str],
        order: str,
        errors: IO[bytes],
        more: Mapping[str, str] | None = None,
    ) -> None:
        """Start it.

        Args:
            order: The line that it is told.
            errors: Takes what libraries write.
            more: Variables of its environment.
        """
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            cwd=NEUTRAL_FOLDER,
            env=environment() | dict(more or {}),
            start_new_session=sys.platform != "win32",
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        assert self.process.stdin is not None
        self._input = self.process.stdin
        self._lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        threading.Thread(target=self._read, args=(self.process.stdout,), daemon=True).start()
        with suppress(BrokenPipeError):  # it died at once: the end of its events tells
            self._input.write(order.encode() + b"\n")
            self._input.flush()

    def _read(self, output: IO[bytes]) -> None:
        for line in output:
            self._lines.put(line)
        self._lines.put(b"")

    def event(self, within_s: float) -> Event | None:
        """The next event, NO_MORE after the last; None where none comes in that time."""
        try:
            line = self._lines.get(timeout=within_s)
        except queue.Empty:
            return None
        return json.loads(line) if line else NO_MORE

    def end(self, grace_s: float) -> None:
        """Let its current step end; after the grace, or at a second Ctrl-C, end it."""
        try:
            with suppress(BrokenPipeError):
                self._input.close()
            self.process.wait(grace_s)
        except (subprocess.TimeoutExpired, KeyboardInterrupt):
            self.process.kill()
            self.process.wait()


def environment() -> dict[str, str]:
    """What a process of ours inherits, with modules looked for where we looked.

    Never in the folder that we were started in.
    """
    given = os.environ.get("PYTHONPATH", "")
    places = [str(Path(place).absolute()) for place in given.split(os.pathsep) if place]
    return _MEMORY | dict(os.environ) | {"PYTHONPATH": os.pathsep.join(places)}
