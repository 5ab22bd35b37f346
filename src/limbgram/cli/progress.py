"""Progress: a bar for each stage on a terminal, plain lines or JSON elsewhere."""

import json
import sys
import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Literal

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from limbgram.report.stages import stage_title

Event = dict[str, Any]


def write_event(event: Event) -> None:
    """Write an event to standard error, as a line of JSON."""
    sys.stderr.write(json.dumps(event) + "\n")
    sys.stderr.flush()


@dataclass
class Display:
    """Shows the events of a job as they come."""

    kind: Literal["terminal", "lines", "json"]
    bars: Progress
    _task: TaskID | None = None
    _stage: str = ""
    _since: float = field(default_factory=time.monotonic)

    def show(self, event: Event) -> None:
        """Show one event; unknown events only as JSON."""
        if self.kind == "json":
            write_event(event)
            return
        match event:
            case {"event": "progress", "stage": str(stage), "done": int(done), "total": int(total)}:
                self._progress(stage, done, total)
            case {"event": "stopping", "stage": str(stage)}:
                self.say(f"Stopping after this step of '{stage_title(stage)}' ...")
            case {"event": "finished" | "refused" | "bug"}:
                self.close()
            case _:
                pass

    def listen(self, stage: str, done: int, total: int) -> None:
        """The listener of a Run in this process."""
        self.show({"event": "progress", "stage": stage, "done": done, "total": total})

    def close(self) -> None:
        """End the last stage."""
        self._end_stage()
        self._stage = ""

    def _progress(self, stage: str, done: int, total: int) -> None:
        if stage != self._stage:
            self._end_stage()
            self._stage, self._since = stage, time.monotonic()
            if self.kind == "terminal":
                self._task = self.bars.add_task(stage_title(stage), total=None)
        if self._task is not None:
            self.bars.update(self._task, completed=done, total=total or None)

    def _end_stage(self) -> None:
        if not self._stage:
            return
        if self._task is not None:
            whole = self.bars.tasks[self.bars.task_ids.index(self._task)].total or 1
            self.bars.update(self._task, completed=whole, total=whole)
            self.bars.stop_task(self._task)
            self._task = None
        else:
            self.say(f"{stage_title(self._stage):<28}{time.monotonic() - self._since:7.1f} s")

    def say(self, line: str) -> None:
        """Show a line above the bar, or as a JSON event."""
        if self.kind == "json":
            self.show({"event": "said", "line": line})
            return
        self.bars.console.print(line, markup=False)


@contextmanager
def display(as_json: bool) -> Generator[Display]:
    """Show progress on standard error: bars on a terminal, else lines, or JSON."""
    console = Console(stderr=True, highlight=False)
    bars = Progress(
        TextColumn("{task.description:<28}"),
        BarColumn(bar_width=26),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=console,
    )
    if as_json or not console.is_terminal:
        screen = Display("json" if as_json else "lines", bars)
        yield screen
        screen.close()
        return
    with bars:
        screen = Display("terminal", bars)
        yield screen
        screen.close()
