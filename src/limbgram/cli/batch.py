"""`limbgram batch`: a folder of captures to a folder of cases, with one table at the end."""

import json
import sys
from collections.abc import Generator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Literal

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

from limbgram.cases.batch.attempt import Outcome, Plan, StepOutcome
from limbgram.cases.batch.finding import Capture, find_captures, loose_photos
from limbgram.cases.batch.running import BatchOptions, BatchRun
from limbgram.cases.batch.settings import (
    BATCH_FILE,
    CAPTURE_FILE,
    EXAMPLE,
    Batch,
    Settings,
    read_batch,
    read_settings,
    require_complete,
)
from limbgram.cases.batch.steps import steps_of
from limbgram.cases.batch.storage import (
    CaptureUrl,
    CasesAtUrl,
    captures_at,
    cases_at,
    is_url,
    read_from,
    write_to,
)
from limbgram.cases.batch.table import (
    NAMES,
    BatchTable,
    earlier_outcomes,
    table_of,
    write_table,
)
from limbgram.cases.folder import CaseFolder, locked
from limbgram.cases.order import Job, order
from limbgram.cases.supervision import Event
from limbgram.cli.replies import Reply, answered, spoken
from limbgram.core.errors import Cancelled, LimbgramError, OptionsError, printable
from limbgram.findings import told
from limbgram.report.stages import stage_title

if TYPE_CHECKING:
    from limbgram.cases.batch.cluster import ClusterRun

_SHOWN_AT_MOST = 20


@answered
def batch_command(
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
    settings: Annotated[
        Path | None,
        typer.Option(
            help="What to do with each capture, as TOML; --example shows one.",
            show_default=f"FOLDER/{BATCH_FILE}",
        ),
    ] = None,
    only: Annotated[
        list[str] | None, typer.Option(help="Only the capture of this name. Repeat it.")
    ] = None,
    part: Annotated[
        str | None,
        typer.Option(
            help="Of N jobs that share the work, such as those of a cluster's queue, job K: K/N. "
            "It does every Nth capture and writes no table; run the batch once more for that.",
            show_default=False,
        ),
    ] = None,
    at_once: Annotated[
        int | None,
        typer.Option(
            min=1, help="Captures at a time, at most.", show_default="one for each processor"
        ),
    ] = None,
    memory: Annotated[
        float | None,
        typer.Option(
            min=0.5,
            help="Memory for all together, GB: fewer begin at a time where it is little.",
            show_default="three quarters of the machine's",
        ),
    ] = None,
    cluster: Annotated[
        str | None,
        typer.Option(
            help="Give the captures to the workers of a Dask cluster: the address of its "
            "scheduler, such as tcp://host:8786, or local:4 to try it with four workers here.",
            show_default=False,
        ),
    ] = None,
    attempts: Annotated[
        int, typer.Option(min=1, max=10, help="Attempts for a capture whose process dies.")
    ] = 3,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only say what would be done with each capture.")
    ] = False,
    example: Annotated[
        bool, typer.Option("--example", help="Only show a settings file with every setting.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Events as JSON lines on stderr, the table on stdout.")
    ] = False,
) -> Reply:
    """Do a whole folder of captures: a case, measures and files of each, and one table.

    A capture that fails stops no other. Ctrl-C stops all; the same command continues, and a later
    run computes only what has changed. batch.html, batch.csv and batch.json in the folder of the
    cases say what became of each; the exit code is that of the worst.
    """
    if example:
        return Reply(tuple(EXAMPLE.splitlines()), {"example": EXAMPLE})
    if folder is None or cases is None:
        raise OptionsError("batch.folders_missing")
    _require_fitting(folder, cases, cluster, part=part, memory=memory)
    with _places(folder, cases) as places:
        batch, base = _batch(places.folder, settings)
        found = find_captures(places.folder, batch, places.cases)
        captures = _part(_chosen(found, only, batch), part)
        plans = tuple(_plan(capture, batch, base, places.cases) for capture in captures)
        notes = _notes(places.folder, folder)
        if dry_run:
            return _would_do(plans, notes)
        alone = part is None and not is_url(cases)
        shared = locked(CaseFolder(places.cases)) if alone else nullcontext()
        with shared, _display(as_json) as screen:
            if cluster is None:
                options = BatchOptions(
                    at_once=at_once,
                    memory_mb=None if memory is None else 1024 * memory,
                    attempts=attempts,
                )
                run = BatchRun(plans, places.cases, options, screen.show)
            else:
                run = _on_cluster(cluster, plans, places, at_once, attempts, screen)
            outcomes = run.wait()
            stopped = run.stopping.asked
            if part is not None:
                table = table_of(outcomes, places.cases, notes, stopped=stopped)
                return _reply(outcomes, table, stopped)
            told = {**earlier_outcomes(places.cases), **{one.name: one for one in outcomes}}
            shown = [told[one.name] for one in found if one.name in told]
            places.fetch_pictures(shown)
            table = write_table(shown, places.cases, notes, stopped=stopped)
            return _reply(shown, places.bring(table), stopped)


@dataclass(frozen=True)
class _Places:
    """Where captures and cases lie, and where they stand for planning and for the table.

    Both are the same folders, but for what lies behind a URL: that has a folder of its own here
    meanwhile.
    """

    captures: str
    folder: Path
    cases_at: str
    cases: Path

    def fetch_pictures(self, outcomes: Sequence[Outcome]) -> None:
        """The pictures that the page shows."""
        at = cases_at(self.cases_at)
        if not isinstance(at, CasesAtUrl):
            return
        for outcome in outcomes:
            place = self.cases / outcome.name / "report" / "surface.png"
            content = at.read(outcome.name, "report/surface.png") if outcome.done else None
            if content is not None:
                place.parent.mkdir(parents=True, exist_ok=True)
                place.write_bytes(content)

    def bring(self, table: BatchTable) -> BatchTable:
        """The table where the cases are."""
        if not is_url(self.cases_at):
            return table
        files = [self.cases / name for name in NAMES]
        return replace(table, written=write_to(self.cases_at, files))


@contextmanager
def _places(folder: str, cases: str) -> Generator[_Places]:
    with TemporaryDirectory(prefix="limbgram-batch-") as held:
        here = Path(folder) if not is_url(folder) else Path(held) / "captures"
        there = Path(cases).absolute() if not is_url(cases) else Path(held) / "cases"
        captures = captures_at(folder)
        if isinstance(captures, CaptureUrl):
            here.mkdir()
            captures.outline(here)
        if is_url(cases):
            there.mkdir()
            content = read_from(cases, NAMES[0])
            if content is not None:
                (there / NAMES[0]).write_bytes(content)
        asked = folder if is_url(folder) else str(here.absolute())
        yield _Places(asked, here.absolute(), cases if is_url(cases) else str(there), there)


def _require_fitting(
    folder: str, cases: str, cluster: str | None, *, part: str | None, memory: float | None
) -> None:
    """Refuse what cannot go together.

    Raises:
        OptionsError: says what, and what to do instead.
    """
    if cluster is None and (is_url(folder) or is_url(cases)):
        raise OptionsError("batch.url_without_cluster")
    if cluster is not None and part is not None:
        raise OptionsError("batch.part_on_cluster")
    if cluster is not None and memory is not None:
        raise OptionsError("batch.memory_on_cluster")


def _on_cluster(
    address: str,
    plans: tuple[Plan, ...],
    places: _Places,
    at_once: int | None,
    attempts: int,
    screen: "_Display",
) -> "ClusterRun":
    try:
        from limbgram.cases.batch.cluster import ClusterOptions, ClusterRun
    except ModuleNotFoundError as error:
        if error.name not in ("dask", "distributed"):
            raise
        raise OptionsError("dask.not_installed") from error
    options = ClusterOptions(
        address=address,
        captures=places.captures,
        folder=places.folder,
        cases=places.cases_at,
        at_once=at_once,
        attempts=attempts,
    )
    return ClusterRun(plans, options, screen.show)


def _reply(outcomes: Sequence[Outcome], table: BatchTable, stopped: bool) -> Reply:
    """How many went well, and what is wrong with the others."""
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
    code = Cancelled.exit_code if stopped else table.exit_code
    return Reply(lines, table.content, exit_code=code)


def _told(one: Outcome | StepOutcome) -> str:
    return one.told if one.finding is None else told(one.finding, spoken())


def _batch(folder: Path, given: Path | None) -> tuple[Batch, Path]:
    """The settings, and the folder in which the files that they name are looked for."""
    file = given or folder / BATCH_FILE
    if given is None and not file.exists():
        return Batch(), folder
    return read_batch(file), file.parent


def _chosen(
    captures: Sequence[Capture], only: Sequence[str] | None, batch: Batch
) -> tuple[Capture, ...]:
    """The captures that are wanted; a name that none has is a slip that nobody would notice.

    Raises:
        OptionsError: a capture that is named is not there, or has the name of our own file.
    """
    names = {capture.name for capture in captures}
    for what, asked in (("--only", only or ()), (f"{BATCH_FILE}: capture.", batch.of_one)):
        strange = [name for name in asked if name not in names]
        if strange:
            raise OptionsError(
                "batch.no_such_capture",
                where=what,
                names=tuple(strange[:5]),
                known=tuple(sorted(names)[:_SHOWN_AT_MOST]),
            )
    taken = names & set(NAMES)
    if taken:
        raise OptionsError("batch.name_of_table", names=tuple(taken))
    return tuple(one for one in captures if only is None or one.name in only)


def _part(captures: tuple[Capture, ...], part: str | None) -> tuple[Capture, ...]:
    """The captures of one of several jobs.

    Raises:
        OptionsError: the part is none.
    """
    if part is None:
        return captures
    number, slash, count = part.partition("/")
    numbers = (number.strip(), count.strip())
    if not slash or not all(one.isdecimal() and len(one) < 8 for one in numbers):
        raise OptionsError("batch.no_part", part=part)
    first, every = int(numbers[0]), int(numbers[1])
    if not 1 <= first <= every:
        raise OptionsError("batch.part_out_of_range", part=part, most=every)
    return captures[first - 1 :: every]


def _plan(capture: Capture, batch: Batch, base: Path, cases: Path) -> Plan:
    """What is to be done with a capture; what is wrong with its own settings is its own fault."""
    case = (cases / capture.name).absolute()
    try:
        settings = batch.of_all.overlaid(batch.of_one.get(capture.name, Settings()))
        own = capture.path / CAPTURE_FILE
        if capture.kind == "folder" and own.exists():
            settings = settings.overlaid(read_settings(own))
        require_complete(settings)

        def located(name: str) -> Path:
            return _located(name, capture, base)

        ask = settings.request(located)
        return Plan(
            capture=capture,
            job=order(case, (), ask, ask.known(), camera_files=ask.camera),
            photos=settings.photos,
            steps=steps_of(settings, capture.name, located),
        )
    except LimbgramError as error:
        return Plan(capture=capture, job=Job(case=case, sources=()), refusal=error)


def _located(name: str, capture: Capture, base: Path) -> Path:
    """A file that the settings name: in the capture's own folder, or beside the settings.

    Raises:
        OptionsError: it is in neither.
    """
    own = capture.path / name
    if capture.kind == "folder" and own.is_file():
        return own.absolute()
    shared = base / name
    if not shared.is_file():
        where = (str(capture.path), str(base)) if capture.kind == "folder" else (str(base),)
        raise OptionsError("batch.file_missing", name=name, places=where)
    return shared.absolute()


def _notes(folder: Path, named: str) -> tuple[str, ...]:
    loose = loose_photos(folder)
    if not loose:
        return ()
    return (
        f"{loose} photos lie in {named} itself and belong to no capture: put them into a folder "
        "of their own.",
    )


def _would_do(plans: Sequence[Plan], notes: Sequence[str]) -> Reply:
    """What would be done; exit code 2 where a capture's settings are wrong."""
    wrong = sum(plan.refusal is not None for plan in plans)
    told = {
        plan.capture.name: f"refused: {plan.refusal}"
        if plan.refusal is not None
        else ", ".join(("reconstruct", *(step.name for step in plan.steps)))
        for plan in plans
    }
    lines = (
        f"{len(plans)} captures; the settings of {wrong} are wrong. Nothing was computed."
        if wrong
        else f"{len(plans)} captures. Nothing was computed.",
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
            sys.stderr.write(json.dumps(event) + "\n")
            sys.stderr.flush()
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
        self._say(f"{count} captures, {pace}")
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
