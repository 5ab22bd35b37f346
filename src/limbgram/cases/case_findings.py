"""Case findings: the findings on tapes, movement and photos that a finished case keeps."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeVar

from limbgram.cases.folder import CaseFolder
from limbgram.core.files import json_of
from limbgram.core.typed import TOLERANT, value_of
from limbgram.findings import Finding, fault, note


@dataclass(frozen=True, kw_only=True)
class Judged:
    """The verdict on one criterion of the accuracy."""

    key: str
    light: Literal["green", "amber", "red"]
    finding: Finding


@dataclass(frozen=True, kw_only=True)
class _Criterion:
    """A criterion in accuracy.json; earlier versions wrote its sentence alone."""

    key: str
    light: Literal["green", "amber", "red"]
    finding: Finding | None = None
    sentence: str = ""

    @property
    def judged(self) -> Judged:
        said = self.finding or note("said.as_is", message=self.sentence)
        return Judged(key=self.key, light=self.light, finding=said)


@dataclass(frozen=True, kw_only=True)
class _Accuracy:
    criteria: tuple[_Criterion, ...]


@dataclass(frozen=True, kw_only=True)
class _Noted:
    notes: tuple[Finding, ...] = ()


@dataclass(frozen=True, kw_only=True)
class _Done:
    scene: _Noted
    resolution: _Noted


_Kept = TypeVar("_Kept")
_TAPE, _MOVEMENT = "tape", "movement"
"""Criteria of accuracy.json."""


def tapes_judged(case: CaseFolder) -> tuple[Judged, ...]:
    """Verdicts of accuracy.json on taped girths; none where the file cannot be read."""
    return _judged(case, _TAPE)


def capture_notes(case: CaseFolder) -> tuple[Finding, ...]:
    """Findings on the limb's movement and on how the photos were processed, as the report has them.

    Masks, a turntable, two poses, coded marks that helped, lenses of single photos, photos that
    were reduced; and a finding for each file that cannot be read.
    """
    files = {case.accuracy("json"): _Accuracy, case.summary: _Done}
    unread = [one for one, kind in files.items() if one.exists() and _read(one, kind) is None]
    moved = tuple(one.finding for one in _judged(case, _MOVEMENT))
    done = _read(case.summary, _Done)
    noted = () if done is None else (*done.scene.notes, *done.resolution.notes)
    return (*(fault("case.findings_unreadable", file=one.name) for one in unread), *moved, *noted)


def _judged(case: CaseFolder, key: str) -> tuple[Judged, ...]:
    said = _read(case.accuracy("json"), _Accuracy)
    return () if said is None else tuple(one.judged for one in said.criteria if one.key == key)


def _read(file: Path, kind: type[_Kept]) -> _Kept | None:
    try:
        tree = json_of(file.read_bytes())
        return value_of(tree, kind, strictness=TOLERANT)
    except (OSError, ValueError):
        return None
