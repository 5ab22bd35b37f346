"""`limbgram batch`: a folder of captures to a folder of cases, with one table at the end."""

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Annotated, Literal

import typer
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
)

from limbgram.batch.attempt import Outcome, Plan, StepOutcome
from limbgram.batch.settings import EXAMPLE
from limbgram.batch.whole_batch import BatchRequest, Worked, prepared
from limbgram.cases.child_process import Event
from limbgram.cli.progress import write_event
from limbgram.cli.replies import Reply, answered, spoken
from limbgram.cli.request_options import asking
from limbgram.core.errors import Cancelled, OptionsError, printable
from limbgram.report.batch import captures
from limbgram.report.stages import stage_title

_SHOWN_AT_MOST = 20


@answered
@asking
def batch_command(
    ask: BatchRequest,
    folder: Annotated[
        str | None,
        typer.Argument(
            help="Folder of captures: each a folder of photos, a zip of them, or a video. With "
            "--cluster also a URL, such as s3://bucket/captures.",
            show_default=False,
        ),
    ] = None,
    cases: Annotated[
        str | None,
        typer.Option(
            "-o",
            "--out",
            help="Folder of the cases: new, or to continue. With --cluster also a URL.",
        ),
    ] = None,
    example: Annotated[
        bool, typer.Option("--example", help="Only show a settings file with every setting.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Events as JSON lines on stderr, the table on stdout.")
    ] = False,
) -> Reply:
    """Reconstruct a folder of captures: a case, measures and files of each, and one table.

    A capture that fails stops no other. Ctrl-C stops all; the same command continues, and a later
    run computes only what has changed. batch.html, batch.xlsx, batch.csv and batch.json in the
    folder of the cases say what became of each; the exit code is that of the worst.
    """
    if example:
        return Reply(tuple(EXAMPLE.splitlines()), {"example": EXAMPLE})
    if folder is None or cases is None:
        raise OptionsError("batch.folders_missing")
    with prepared(folder, cases, ask) as batch:
        if ask.dry_run:
            return _would_do(batch.plans, batch.notes)
        with _display(as_json) as screen:
            return _reply(batch.work(screen.show))


def _reply(worked: Worked) -> Reply:
    """How many went well, and what is wrong with the others."""
    outcomes, table = worked.outcomes, worked.table
    faults = [f"  {one.name}: {one.state}: {_told(one)}" for one in outcomes if not one.done] + [
        f"  {one.name}: {step.name}: {_told(step)}"
        for one in outcomes
        for step in one.steps
        if step.exit_code
    ]
    more = len(faults) - _SHOWN_AT_MOST
    lines = (
        table.line,
        *faults[:_SHOWN_AT_MOST],
        *([f"  and {more} more in the table"] if more > 0 else []),
        *table.content["notes"],
        *(f"Written: {path}" for path in table.written),
    )
    code = Cancelled.exit_code if worked.stopped else table.exit_code
    return Reply(lines, table.content, exit_code=code)


def _told(one: Outcome | StepOutcome) -> str:
    return one.reason if one.finding is None else spoken(one.finding)


def _would_do(plans: Sequence[Plan], notes: Sequence[str]) -> Reply:
    """What would be done; exit code 2 where a capture's settings are wrong."""
    wrong = sum(plan.refusal is not None for plan in plans)
    told = {
        plan.capture.name: f"refused: {spoken(plan.refusal.finding)}"
        if plan.refusal is not None
        else ", ".join(("reconstruct", *(step.name for step in plan.steps)))
        for plan in plans
    }
    lines = (
        f"{captures(len(plans))}; the settings of {wrong} are wrong. Nothing was computed."
        if wrong
        else f"{captures(len(plans))}. Nothing was computed.",
        *(f"  {name}: {text}" for name, text in told.items()),
        *notes,
    )
    content = {
        "captures": [
            {
                "name": plan.capture.name,
                "source": str(plan.capture.path),
                "kind": plan.capture.kind,
                "steps": [step.name for step in plan.steps],
                "refusal": None if plan.refusal is None else str(plan.refusal),
            }
            for plan in plans
        ],
        "notes": list(notes),
    }
    return Reply(lines, content, exit_code=OptionsError.exit_code if wrong else 0)


@dataclass
class _Display:
    """Shows the events of a batch: a line for each capture at work, and how many are done."""

    kind: Literal["terminal", "lines", "json"]
    bars: Progress
    _all: TaskID | None = None
    _of: dict[str, TaskID] = field(default_factory=dict[str, TaskID])
    _ended: int = 0

    def show(self, event: Event) -> None:
        if self.kind == "json":
            write_event(event)
            return
        match event:
            case {"event": "planned", "captures": int(count), "at_once": int(at_once)}:
                self._planned(count, at_once)
            case {"event": "begun", "capture": str(name)} if self._all is not None:
                if name in self._of:  # begun once more, on another worker
                    self.bars.remove_task(self._of.pop(name))
                shown = printable(name, keep="")
                self._of[name] = self.bars.add_task(f"{shown:.20}", total=None, stage="")
            case {"event": "progress", "capture": str(name), "stage": str(stage)} if (
                name in self._of
            ):
                self.bars.update(
                    self._of[name],
                    completed=event["done"],
                    total=event["total"] or None,
                    stage=stage_title(stage),
                )
            case {"event": "ended", "capture": str(name)}:
                self._end(name, event)
            case {"event": "lost"}:
                self._say("The scheduler is lost. It is called until it answers again ...")
            case {"event": "stopping"}:
                self._say("Stopping: each capture ends after its present step ...")
            case _:
                pass

    def _planned(self, count: int, at_once: int) -> None:
        pace = f"{at_once} at a time" if at_once else "which wait for a first worker"
        self._say(f"{captures(count)}, {pace}")
        if self.kind == "terminal":
            self._all = self.bars.add_task("All captures", total=count, stage="")

    def _end(self, name: str, event: Event) -> None:
        if name in self._of:
            self.bars.remove_task(self._of.pop(name))
        self._ended += not event["again"]
        if self._all is not None:
            self.bars.update(self._all, completed=self._ended)
        word = (event["light"] or event["state"]).upper()
        again = " It is tried again after the others." if event["again"] else ""
        first = printable(event["message"].splitlines()[0] if event["message"] else "", keep="")
        self._say(f"{printable(name, keep=''):<20} {word:<9} {first:.140}{again}")

    def _say(self, line: str) -> None:
        self.bars.console.print(line, markup=False, soft_wrap=True)


@contextmanager
def _display(as_json: bool) -> Generator[_Display]:
    console = Console(stderr=True, highlight=False)
    bars = Progress(
        TextColumn("{task.description:<20}"),
        TextColumn("{task.fields[stage]:<26}"),
        BarColumn(bar_width=20),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=console,
    )
    if as_json or not console.is_terminal:
        yield _Display("json" if as_json else "lines", bars)
        return
    with bars:
        yield _Display("terminal", bars)
