"""Batch: the page of many captures: how many went well, what to do about the others, each surface.

In      a row for each capture, made of what its case says.
Out     a Report; it has no sheets of paper.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from urllib.parse import quote

from limbgram.findings import doubt, fault
from limbgram.report.blocks import (
    AdviceList,
    Banner,
    Block,
    Card,
    Colour,
    Columns,
    Illustration,
    Report,
    Section,
    Table,
    Text,
)
from limbgram.report.drawings.drawing import Picture
from limbgram.report.intended_use import OF_SCANS
from limbgram.report.verdict_light import Light

_ORDER = ("", "red", "amber", "green")


@dataclass(frozen=True, kw_only=True)
class BatchRow:
    """The outcome of one capture of a batch."""

    name: str
    source: str
    state: str
    """In a word or two."""
    light: Light | None
    size_checked: bool
    """Whether something independent confirms the size; false without a result."""
    told: str
    """The verdict, or why there is none."""
    steps: tuple[str, ...]
    """What became of each step after the surface."""
    faults: tuple[str, ...]
    """Steps that failed, and why."""
    left_out: tuple[tuple[str, str], ...]
    """Photos and other files that the surface was made without, and why."""
    attempts: int
    seconds: float
    thumbnail: Picture | None = None


def batch_report(rows: Sequence[BatchRow], notes: Sequence[str], *, stopped: bool) -> Report:
    """The worst first: what has no result, then red, amber and green."""
    ordered = sorted(rows, key=lambda row: (_ORDER.index(row.light or ""), row.name))
    return Report(
        title=captures(len(rows)),
        banner=_banner(rows, stopped=stopped),
        cards=_cards(rows),
        intended_use=OF_SCANS,
        sections=(
            *_advice_section(ordered),
            Section(
                title="Captures",
                blocks=(*(Text(words=note, note=True) for note in notes), _table(ordered)),
            ),
            *_left_out(ordered),
            *_surfaces(ordered),
        ),
    )


def captures(count: int) -> str:
    """How many captures, in words."""
    return f"{count} capture{'s' * (count != 1)}"


def count_by_verdict(rows: Sequence[BatchRow]) -> str:
    """How many of each verdict there are, in a sentence."""
    if not rows:
        return "No captures."
    lights = Counter(row.light or "" for row in rows)
    unchecked, done = _unchecked(rows), sum(row.light is not None for row in rows)
    words = (("green", "green"), ("amber", "amber"), ("red", "red"), ("", "without a result"))
    told = [f"{lights[light]} {word}" for light, word in words if lights[light]]
    faults = sum(bool(row.faults) for row in rows)
    more = f"; in {faults} a step after the surface failed" if faults else ""
    size = f"; scale not checked independently: {len(unchecked)} of {done}" if unchecked else ""
    return f"{captures(len(rows))}: {', '.join(told)}{size}{more}."


def _unchecked(rows: Sequence[BatchRow]) -> list[BatchRow]:
    """Captures with a surface whose size has no independent check."""
    return [row for row in rows if row.light is not None and not row.size_checked]


def colour_of(rows: Sequence[BatchRow]) -> Colour:
    """The colour of the worst capture."""
    if any(row.light in (None, "red") for row in rows):
        return "red"
    return "amber" if any(row.light == "amber" or row.faults for row in rows) else "green"


def _banner(rows: Sequence[BatchRow], *, stopped: bool) -> Banner:
    colour = colour_of(rows)
    reasons = ("It was stopped before it ended: the same command continues.",) if stopped else ()
    green = "GREEN, SCALE UNCHECKED" if _unchecked(rows) else "ALL GREEN"
    badge = {"green": green, "amber": "LOOK AT SOME", "red": "NOT ALL GOOD"}[colour]
    return Banner(badge=badge, words=count_by_verdict(rows), colour=colour, reasons=reasons)


def _cards(rows: Sequence[BatchRow]) -> tuple[Card, ...]:
    done = sum(row.light is not None for row in rows)
    seconds = sum(row.seconds for row in rows)
    again = sum(row.attempts > 1 for row in rows)
    return (
        Card("How many have a surface?", f"{done} of {len(rows)}", "each with a page of its own"),
        Card("How long did they take?", f"{seconds / 60:.1f} min", "all together, in this run"),
        Card("Which were tried again?", str(again), "because a process of theirs died"),
    )


def _advice_section(rows: Sequence[BatchRow]) -> Iterator[Section]:
    """What has to be done about captures without a result, and steps that failed."""
    items = [
        fault("record.batch.no_result", capture=row.name, state=row.state, told=row.told)
        for row in rows
        if row.light is None
    ]
    items += [
        doubt("record.batch.step_failed", capture=row.name, told=one)
        for row in rows
        for one in row.faults
    ]
    if items:
        yield Section(title="What to do", blocks=(AdviceList(items=tuple(items)),))


def _table(rows: Sequence[BatchRow]) -> Table:
    cells = tuple(
        (
            row.name,
            row.source,
            ", ".join(row.steps),
            str(row.attempts),
            f"{row.seconds:.0f}",
            row.state,
            _verdict(row),
        )
        for row in rows
    )
    heads = ("capture", "from", "then", "#attempts", "#seconds", "what became of it", "verdict")
    colours: tuple[Colour | None, ...] = tuple(row.light or "red" for row in rows)
    return Table(heads=heads, rows=cells, colours=colours)


def _left_out(rows: Sequence[BatchRow]) -> Iterator[Section]:
    """What surfaces were made without."""
    cells = tuple((row.name, name, reason) for row in rows for name, reason in row.left_out)
    if cells:
        table = Table(heads=("capture", "what", "why"), rows=cells)
        yield Section(title="Left out", blocks=(table,))


def _verdict(row: BatchRow) -> str:
    if row.light is None:
        return "NONE"
    return row.light.upper() + ("" if row.size_checked else "; scale not checked independently")


def _surfaces(rows: Sequence[BatchRow]) -> Iterator[Section]:
    """Each surface with its verdict; a click opens its page."""
    for light in _ORDER[1:]:
        figures = tuple(
            Illustration(
                image=row.thumbnail,
                caption=f"{row.name}: {row.told}",
                address=f"{quote(row.name)}/report.html",
            )
            for row in rows
            if row.light == light and row.thumbnail is not None
        )
        if figures:
            blocks: tuple[Block, ...] = (
                Text(words="Click a picture for the page of its case.", note=True),
                Columns(figures=figures),
            )
            yield Section(title=light.capitalize(), blocks=blocks)
