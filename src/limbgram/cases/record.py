"""The record: CASE/case.json, what was done, with which versions, from which photos."""

import json
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

from limbgram.cases.encoding import to_tree
from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.folder import CaseFolder
from limbgram.cases.store import CachingRun
from limbgram.core.files import json_of, written_whole
from limbgram.core.typed import Strictness, tree_of, value_of
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

State = Literal["unfinished", "cancelled", "refused", "finished"]


@dataclass(frozen=True, kw_only=True)
class StageEntry:
    """A stage of the run that finished, and the key of its product."""

    stage: str
    key: str


@dataclass(frozen=True, kw_only=True)
class FileEntry:
    """A file that was delivered."""

    path: str
    sha256: str


@dataclass(frozen=True, kw_only=True)
class CaseRecord:
    """What is read of case.json."""

    state: State
    job: str = ""
    stages: tuple[StageEntry, ...] = ()
    files: tuple[FileEntry, ...] = ()


def read_record(case: CaseFolder) -> CaseRecord:
    """The record of a case.

    Raises:
        LookupError: there is none that can be read.
    """
    try:
        tree = json_of(case.record.read_bytes())
        return value_of(tree, CaseRecord, strictness=Strictness(pass_over_unknown=True))
    except (OSError, ValueError) as error:
        raise LookupError(f"{case.record} cannot be read: {error}") from error


def write_record(
    case: CaseFolder,
    state: State,
    run: CachingRun,
    done: Reconstruction | None = None,
    message: str = "",
    *,
    job: str = "",
    verdict: Verdict | None = None,
) -> None:
    """Replace case.json.

    Args:
        job: Key of what was asked for (`superseding.key_of`).
        verdict: Of a finished run.
    """
    record = {
        "schema": SCHEMA,
        "state": state,
        "message": message,
        "verdict": tree_of(verdict),
        "superseded": case.superseded.name if case.superseded.is_dir() else None,
        "job": job,
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
        "versions": {name: version(name) for name in ("limbgram", *_LIBRARIES)},
        "python": platform.python_version(),
        "system": platform.platform(),
        "photos": [] if done is None else _photos(done),
        "set_aside": [] if done is None else _set_aside(done.photos.set_aside),
        "stages": [
            {"stage": name, "key": key, "reused": name in run.reused, **_timing(run, idx)}
            for idx, (name, key) in enumerate(run.keys.items())
        ],
        "files": _files(case) if state == "finished" else [],
    }
    write_json(case.record, record)


def add_message(case: CaseFolder, message: str) -> None:
    """Tell in case.json of a later run that changed nothing."""
    record: Any = json.loads(case.record.read_text("utf-8"))
    write_json(case.record, {**record, "message": message})


def write_json(path: Path, content: Any) -> None:
    """Write JSON whole or not at all."""
    with written_whole(path) as beside:
        beside.write_text(json.dumps(content, indent=1, allow_nan=False), encoding="utf-8")


def _photos(done: Reconstruction) -> list[dict[str, Any]]:
    verdicts = {verdict.name: verdict for verdict in done.metric.scene.verdicts}
    return [
        {
            "name": photo.name,
            "sha256": photo.sha256,
            "placed": verdicts[photo.name].placed,
            "reason": verdicts[photo.name].reason,
        }
        for photo in done.photos.photos
    ]


def _set_aside(parts: Sequence[SetAside]) -> list[dict[str, str]]:
    return [{"name": part.name, "reason": part.reason} for part in parts]


def _timing(run: CachingRun, idx: int) -> dict[str, Any]:
    """Of a stage; none for the one that was stopped or refused before it was timed."""
    if idx >= len(run.timings):
        return {}
    tree: Any = to_tree(run.timings[idx], [], str)
    return {name: tree[name] for name in ("wall_s", "cpu_s", "peak_mb")}


def _files(case: CaseFolder) -> list[dict[str, Any]]:
    """What was delivered; hidden files are half written ones, or of the system."""
    files = sorted(
        file
        for file in case.deliverables.rglob("*")
        if file.is_file()
        and not any(part.startswith(".") for part in file.relative_to(case.deliverables).parts)
    )
    return [
        {"path": file.relative_to(case.root).as_posix(), "sha256": file_sha256(file)}
        for file in files
    ]
