"""Taped: what a finished case's accuracy says of the girths that were taped on the limb."""

from dataclasses import dataclass
from typing import Literal

from limbgram.cases.folder import CaseFolder
from limbgram.core.files import json_of
from limbgram.core.typed import Strictness, value_of


@dataclass(frozen=True, kw_only=True)
class TapeJudged:
    """The verdict on one taped girth."""

    key: str
    light: Literal["green", "amber", "red"]
    sentence: str


@dataclass(frozen=True, kw_only=True)
class _Judged:
    criteria: tuple[TapeJudged, ...]


_KEY = "tape"
"""Of the criterion in accuracy.json."""


def tapes_judged(case: CaseFolder) -> tuple[TapeJudged, ...]:
    """What accuracy.json says of each taped girth; nothing where no such file can be read."""
    try:
        tree = json_of(case.accuracy("json").read_bytes())
        kept = value_of(tree, _Judged, strictness=Strictness(pass_over_unknown=True))
    except (OSError, ValueError):
        return ()
    return tuple(one for one in kept.criteria if one.key == _KEY)
