"""Whole batch: a folder of captures, planned from its settings and run to a table of outcomes.

In      the folder of the captures, the folder of the cases, a request.
Out     Prepared: a plan for each capture, nothing computed yet; Worked: outcomes and the table.
Fails   OptionsError: wrong settings, folders and options that exclude each other.
"""

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from limbgram.batch.attempt import Outcome, Plan
from limbgram.batch.captures import Capture, find_captures, loose_photos
from limbgram.batch.local_run import BatchOptions, BatchRun
from limbgram.batch.settings import (
    BATCH_FILE,
    CAPTURE_FILE,
    Batch,
    Settings,
    read_batch,
    read_settings,
    require_complete,
)
from limbgram.batch.steps import steps_of
from limbgram.batch.storage import (
    CaptureUrl,
    CasesAtUrl,
    captures_at,
    cases_at,
    is_url,
    read_from,
    write_to,
)
from limbgram.batch.table import (
    NAMES,
    BatchTable,
    earlier_outcomes,
    table_of,
    write_table,
)
from limbgram.cases.child_process import Event
from limbgram.cases.folder import CaseFolder, locked
from limbgram.cases.job_messages import Job, order
from limbgram.core.errors import LimbgramError, OptionsError
from limbgram.core.files import require_folder

if TYPE_CHECKING:
    from limbgram.batch.cluster import ClusterRun

_NAMED_AT_MOST = 20


@dataclass(frozen=True, kw_only=True)
class BatchRequest(BatchOptions):
    """Which captures are done, and by what."""

    settings: Path | None = None
    """What to do with each capture, as TOML; --example shows one. Without it batch.toml in the
    folder of the captures."""
    only: tuple[str, ...] = ()
    """Only the capture of this name."""
    part: str | None = None
    """K/N: job K of N that share the work, such as those of a cluster's queue. It does every
    Nth capture and writes no table; run the batch once more for that."""
    cluster: str | None = None
    """Give the captures to the workers of a Dask cluster: the address of its scheduler, such as
    tcp://host:8786, or local:4 to try it with four workers here."""
    dry_run: bool = False
    """Only say what would be done with each capture."""


@dataclass(frozen=True, kw_only=True)
class Worked:
    """The outcomes of a batch that has run."""

    outcomes: tuple[Outcome, ...]
    table: BatchTable
    stopped: bool
    """By Ctrl-C."""


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """The plans of a batch."""

    ask: BatchRequest
    found: tuple[Capture, ...]
    """All captures; only the chosen ones have plans."""
    plans: tuple[Plan, ...]
    notes: tuple[str, ...]
    places: "_Places"

    def work(self, listener: Callable[[Event], None]) -> Worked:
        """Run all plans, and write the table unless this is one part of several."""
        places, part = self.places, self.ask.part is not None
        alone = not part and not is_url(places.cases_at)
        with locked(CaseFolder(places.cases)) if alone else nullcontext():
            run = self._run(listener)
            outcomes, stopped = run.wait(), run.stopping.asked
            if part:
                table = table_of(outcomes, places.cases, self.notes, stopped=stopped)
                return Worked(outcomes=outcomes, table=table, stopped=stopped)
            known = {**earlier_outcomes(places.cases), **{one.name: one for one in outcomes}}
            shown = tuple(known[one.name] for one in self.found if one.name in known)
            places.fetch_pictures(shown)
            table = write_table(shown, places.cases, self.notes, stopped=stopped)
            return Worked(outcomes=shown, table=places.bring(table), stopped=stopped)

    def _run(self, listener: Callable[[Event], None]) -> "BatchRun | ClusterRun":
        if self.ask.cluster is None:
            return BatchRun(self.plans, self.places.cases, self.ask, listener)
        try:
            from limbgram.batch.cluster import ClusterOptions, ClusterRun
        except ModuleNotFoundError as error:
            if error.name not in ("dask", "distributed"):
                raise
            raise OptionsError("dask.not_installed") from error
        options = ClusterOptions(
            address=self.ask.cluster,
            captures=self.places.captures,
            folder=self.places.folder,
            cases=self.places.cases_at,
            at_once=self.ask.at_once,
            attempts=self.ask.attempts,
        )
        return ClusterRun(self.plans, options, listener)


@contextmanager
def prepared(folder: str, cases: str, ask: BatchRequest) -> Generator[Prepared]:
    """The plans of a batch; inside, captures and cases behind a URL have a temporary folder here.

    Args:
        folder: Of the captures; with a cluster also a URL.
        cases: Folder of the cases, new or to continue; with a cluster also a URL.

    Raises:
        OptionsError: the settings are none, or what was asked for cannot go together.
        ExportError: the folder of the cases cannot be made.
    """
    _require_fitting(folder, cases, ask)
    with _places(folder, cases) as places:
        require_folder(places.cases)
        batch, base = _batch(places.folder, ask.settings)
        found = find_captures(places.folder, batch, places.cases)
        captures = _part(_chosen(found, ask.only, batch), ask.part)
        yield Prepared(
            ask=ask,
            found=tuple(found),
            plans=tuple(_plan(capture, batch, base, places.cases) for capture in captures),
            notes=_notes(places.folder, folder),
            places=places,
        )


@dataclass(frozen=True)
class _Places:
    """Where captures and cases lie (folder or URL), and their folders on this machine.

    For what lies behind a URL that is a temporary folder, for the plan and the table.
    """

    captures: str
    folder: Path
    cases_at: str
    cases: Path

    def fetch_pictures(self, outcomes: Sequence[Outcome]) -> None:
        """Download the pictures that the page shows."""
        at = cases_at(self.cases_at)
        if not isinstance(at, CasesAtUrl):
            return
        for outcome in outcomes:
            case = CaseFolder(self.cases / outcome.name)
            inside = case.surface_picture.relative_to(case.root).as_posix()
            content = at.read(outcome.name, inside) if outcome.done else None
            if content is not None:
                case.report.mkdir(parents=True, exist_ok=True)
                case.surface_picture.write_bytes(content)

    def bring(self, table: BatchTable) -> BatchTable:
        """The table, uploaded to where the cases are."""
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


def _require_fitting(folder: str, cases: str, ask: BatchRequest) -> None:
    """Refuse options that exclude each other.

    Raises:
        OptionsError: says what, and what to do instead.
    """
    if ask.cluster is None:
        if is_url(folder) or is_url(cases):
            raise OptionsError("batch.url_without_cluster")
        return
    if ask.part is not None:
        raise OptionsError("batch.part_on_cluster")
    if ask.memory_gb is not None:
        raise OptionsError("batch.memory_on_cluster")


def _batch(folder: Path, given: Path | None) -> tuple[Batch, Path]:
    """The settings, and the folder in which the files that they name are looked for."""
    file = given or folder / BATCH_FILE
    if given is None and not file.exists():
        return Batch(), folder
    return read_batch(file), file.parent


def _chosen(captures: Sequence[Capture], only: Sequence[str], batch: Batch) -> tuple[Capture, ...]:
    """The captures that the request names; a name that no capture has is refused.

    Raises:
        OptionsError: a capture that is named is not there, or has the name of our own file.
    """
    names = {capture.name for capture in captures}
    for what, asked in (("--only", only), (f"{BATCH_FILE}: capture.", batch.of_one)):
        strange = [name for name in asked if name not in names]
        if strange:
            raise OptionsError(
                "batch.no_such_capture",
                where=what,
                names=tuple(strange[:5]),
                known=tuple(sorted(names)[:_NAMED_AT_MOST]),
            )
    taken = names & set(NAMES)
    if taken:
        raise OptionsError("batch.name_of_table", names=tuple(taken))
    return tuple(one for one in captures if not only or one.name in only)


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
    """The plan of a capture; wrong settings of its own are a refusal of that capture alone."""
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
