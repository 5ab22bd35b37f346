"""Case record: CASE/case.json, the state of a case with its versions, photos, stages and files."""

import itertools
import json
import platform
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal, TypeVar

from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.folder import UNREADABLE, CaseFolder
from limbgram.cases.stage_cache import CachingRun
from limbgram.core.errors import CaseError
from limbgram.core.files import json_of, read_content, written_whole
from limbgram.core.typed import TOLERANT, tree_of, value_of
from limbgram.findings import Finding, as_json, told
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.pipeline import Reconstruction
from limbgram.report.summary import Verdict

SCHEMA = "limbgram-case/1"
_LIBRARIES = (
    "numpy",
    "scipy",
    "numba",
    "opencv-python-headless",
    "pycolmap",
    "pillow",
    "trimesh",
    "embreex",
    "matplotlib",
)

_LARGEST_BYTES = 40_000_000

State = Literal["unfinished", "cancelled", "refused", "finished"]
T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class StageEntry:
    """A stage of the run, and the key of its product."""

    stage: str
    key: str


@dataclass(frozen=True, kw_only=True)
class FileEntry:
    """A file that was delivered."""

    path: str
    sha256: str


@dataclass(frozen=True, kw_only=True)
class PhotoHash:
    """The hash in a photo's entry."""

    sha256: str


@dataclass(frozen=True, kw_only=True)
class CaseRecord:
    """The fields of case.json that the program reads."""

    state: State
    job: str = ""
    written: str = ""
    """Date and time, UTC."""
    stages: tuple[StageEntry, ...] = ()
    photos: tuple[PhotoHash, ...] = ()
    set_aside: tuple[SetAside, ...] = ()
    files: tuple[FileEntry, ...] = ()


@dataclass(frozen=True, kw_only=True)
class _Result:
    """State and verdict in case.json."""

    state: State
    verdict: Verdict | None = None


@dataclass(frozen=True, kw_only=True)
class _PhotoEntry:
    """A photo that was read, and whether it was placed."""

    name: str
    sha256: str
    placed: bool
    reason: str


@dataclass(frozen=True, kw_only=True)
class _StageRun(StageEntry):
    """A stage that was stopped or refused before it was timed."""

    reused: bool


@dataclass(frozen=True, kw_only=True)
class _TimedStage(_StageRun):
    """A stage that ended."""

    wall_s: float
    cpu_s: float
    peak_mb: float


@dataclass(frozen=True, kw_only=True)
class _RecordFile:
    """What is written to case.json, in this order."""

    schema: str = SCHEMA
    state: State
    message: str
    """The finding in English, for other programs."""
    finding: Finding | None
    """Why there is no result, or how a later run ended."""
    verdict: Verdict | None
    superseded: str | None
    """Folder of the earlier run's results that no longer stand."""
    job: str
    written: str
    """Date and time, UTC."""
    versions: dict[str, str]
    python: str
    system: str
    photos: tuple[_PhotoEntry, ...]
    set_aside: tuple[SetAside, ...]
    stages: tuple[_StageRun, ...]
    files: tuple[FileEntry, ...]


def read_record(case: CaseFolder) -> CaseRecord:
    """The record of a case.

    Raises:
        LookupError: there is none that can be read.
    """
    try:
        tree = json_of(case.record.read_bytes())
        return value_of(tree, CaseRecord, strictness=TOLERANT)
    except (OSError, ValueError) as error:
        raise LookupError(f"{case.record} cannot be read: {error}") from error


def read_verdict(case: CaseFolder) -> Verdict | None:
    """The verdict of a finished case; None of any other.

    Raises:
        CaseError: the record is there and cannot be read.
    """
    kept = read_kept(case.record, _Result, "record")
    return kept.verdict if kept is not None and kept.state == "finished" else None


def write_record(
    case: CaseFolder,
    state: State,
    run: CachingRun,
    done: Reconstruction | None = None,
    *,
    finding: Finding | None = None,
    job: str = "",
    verdict: Verdict | None = None,
) -> None:
    """Replace case.json.

    Args:
        job: Key of the request (`superseded.key_of`).
        verdict: Of a finished run.
    """
    content = _RecordFile(
        state=state,
        message="" if finding is None else told(finding),
        finding=finding,
        verdict=verdict,
        superseded=case.superseded.name if case.superseded.is_dir() else None,
        job=job,
        written=utc_now(),
        versions={name: version(name) for name in ("limbgram", *_LIBRARIES)},
        python=platform.python_version(),
        system=platform.platform(),
        photos=() if done is None else _photos(done),
        set_aside=() if done is None else done.photos.set_aside,
        stages=_stages(run),
        files=_files(case) if state == "finished" else (),
    )
    write_json(case.record, tree_of(content))


def add_finding(case: CaseFolder, finding: Finding) -> None:
    """Add a finding to case.json on a later run that changed nothing."""
    record: Any = json.loads(case.record.read_text("utf-8"))
    write_json(case.record, {**record, "message": told(finding), "finding": as_json(finding)})


def utc_now() -> str:
    """Date and time, UTC, to the second, as records and labels have it."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def write_json(path: Path, content: Any) -> None:
    """Write JSON under a temporary name, and rename it."""
    with written_whole(path) as beside:
        beside.write_text(json.dumps(content, indent=1, allow_nan=False), encoding="utf-8")


def read_kept(path: Path, kind: type[T], what: str) -> T | None:
    """The content of a file that keeps people's work; None where there is none.

    A file that cannot be read is an error and no empty file, so that it is not overwritten.

    Args:
        what: The kind of file, as `kept.unreadable` names it.

    Raises:
        CaseError: it is there and cannot be read.
    """
    if not path.exists():
        return None
    try:
        tree = json_of(read_content(path, _LARGEST_BYTES, CaseError))
        return value_of(tree, kind, strictness=TOLERANT)
    except (CaseError, ValueError) as error:
        raise unreadable(path, what) from error


def unreadable(path: Path, what: str) -> CaseError:
    """The refusal of a file that keeps people's work and cannot be read."""
    return CaseError("kept.unreadable", what=what, file=path.name)


def set_aside(path: Path) -> Path:
    """Rename a file that cannot be read; returns its new path in the same folder."""
    for number in itertools.count(1):
        beside = path.with_name(f"{path.stem}{UNREADABLE}{number}{path.suffix}")
        if not beside.exists():
            return path.rename(beside)
    raise AssertionError


def _photos(done: Reconstruction) -> tuple[_PhotoEntry, ...]:
    verdicts = {verdict.name: verdict for verdict in done.metric.scene.verdicts}
    return tuple(
        _PhotoEntry(
            name=photo.name,
            sha256=photo.sha256,
            placed=verdicts[photo.name].placed,
            reason=_sentence(verdicts[photo.name].reason),
        )
        for photo in done.photos.photos
    )


def _sentence(reason: Finding | None) -> str:
    return "" if reason is None else told(reason)


def _stages(run: CachingRun) -> tuple[_StageRun, ...]:
    """In the order of the run; the last one may have no timing."""
    found: list[_StageRun] = []
    for idx, (name, key) in enumerate(run.keys.items()):
        reused = name in run.reused
        if idx >= len(run.timings):
            found.append(_StageRun(stage=name, key=key, reused=reused))
            continue
        took = run.timings[idx]
        found.append(
            _TimedStage(
                stage=name,
                key=key,
                reused=reused,
                wall_s=took.wall_s,
                cpu_s=took.cpu_s,
                peak_mb=took.peak_mb,
            )
        )
    return tuple(found)


def _files(case: CaseFolder) -> tuple[FileEntry, ...]:
    """The delivered files; hidden ones are temporary, or the system's."""
    files = sorted(
        file
        for file in case.deliverables.rglob("*")
        if file.is_file()
        and not any(part.startswith(".") for part in file.relative_to(case.deliverables).parts)
    )
    return tuple(
        FileEntry(path=file.relative_to(case.root).as_posix(), sha256=file_sha256(file))
        for file in files
    )
