"""Job messages: a job request and its answer, as exchanged with the job's process.

In      a Job, sent as JSON to the process that does it.
Out     an Answer: where the summary lies, and what people read at the end.
A program that only passes jobs on imports this and none of the stages: it starts in 0.4 s, not 2.4.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from limbgram.cases.encoding import from_tree, to_tree
from limbgram.reconstruction.scale.stated_lengths import KnownDistance, TapedGirth
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.plates import MarkPlate
from limbgram.reconstruction.user_settings import Choices
from limbgram.services.reconstruct import Known, Shaping


@dataclass(frozen=True, kw_only=True)
class Job:
    """The request of one reconstruction."""

    case: Path
    sources: tuple[Path, ...]
    """Photo files, or folders of them."""
    masks: Path | None = None
    """Folder of masks that take the place of those beside the photos."""
    camera_files: tuple[Path, ...] = ()
    board: Board | None = None
    distances: tuple[KnownDistance, ...] = ()
    tapes: tuple[TapedGirth, ...] = ()
    """Girths taped on the limb, to test the size by."""
    plates: tuple[MarkPlate, ...] = ()
    """Scale bars, mats and rings in the scene."""
    unscaled: bool = False
    """Write files even if their unit is not known."""
    choices: Choices = field(default_factory=Choices)
    memory_mb: float | None = None
    """Memory that the work may use; None: half of the machine's."""


def order(
    case: Path,
    sources: Sequence[Path],
    shaping: Shaping,
    known: Known,
    *,
    camera_files: Sequence[Path] = (),
    masks: Path | None = None,
) -> Job:
    """The job of a request; command line, app and batch all build it here."""
    return Job(
        case=case,
        sources=tuple(sources),
        masks=masks,
        camera_files=tuple(camera_files),
        board=known.board,
        distances=known.distances,
        tapes=known.tapes,
        plates=known.plates,
        unscaled=shaping.unscaled,
        choices=shaping.choices,
        memory_mb=shaping.memory_mb,
    )


@dataclass(frozen=True, kw_only=True)
class Answer:
    """The answer of a finished job."""

    summary: Path
    light: str = ""
    """Green, amber or red."""
    lines: tuple[str, ...] = ()
    """Its summary, for people."""
    costs: tuple[str, ...] = ()
    """Time and memory of each stage, for people who ask."""


def plain_tree(value: Job | Answer) -> Any:
    """A job or an answer as JSON, paths absolute."""
    return to_tree(value, [], lambda path: str(path.absolute()))


def read_job(tree: Any, root: Path) -> Job:
    return from_tree(tree, Job, [], root)


def read_answer(tree: Any) -> Answer:
    return from_tree(tree, Answer, [], Path())
