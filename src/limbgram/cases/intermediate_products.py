"""Intermediate products of a run, read from its case during the run or afterwards."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Self, TypeVar, cast

from limbgram.cases.folder import CaseFolder
from limbgram.cases.stage_cache import read_product
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Cloud, Mesh
from limbgram.reconstruction.scale.metric import MetricScene

T = TypeVar("T")

_SURFACES = ("measure", "refine")
"""Stages whose product is a surface to show, the best one first."""


@dataclass(frozen=True, kw_only=True)
class IntermediateProducts:
    """Which products can be looked at."""

    cameras: bool
    cloud: bool
    surface: bool

    @classmethod
    def of(cls, case: CaseFolder) -> Self:
        return cls(
            cameras=_is_there(case, "to_millimetres"),
            cloud=_is_there(case, "fuse"),
            surface=any(_is_there(case, stage) for stage in _SURFACES),
        )


def cameras_so_far(case: CaseFolder) -> tuple[View, ...]:
    """The placed photos' cameras; none before they are placed."""
    metric = _product(case, "to_millimetres", MetricScene)
    return () if metric is None else tuple(metric.scene.views)


def cloud_so_far(case: CaseFolder) -> Cloud | None:
    """The fused points."""
    return _product(case, "fuse", Cloud)


def surface_so_far(case: CaseFolder) -> Mesh | None:
    """The measured surface, or the refined one before that."""
    found = (_product(case, stage, Mesh) for stage in _SURFACES)
    return next((mesh for mesh in found if mesh is not None), None)


def _is_there(case: CaseFolder, stage: str) -> bool:
    return _record(case, stage).is_file()


def _product(case: CaseFolder, stage: str, hint: type[T]) -> T | None:
    """The kept product of a stage; None where there is none, or it is being replaced."""
    try:
        key = str(json.loads(_record(case, stage).read_text("utf-8"))["key"])
        return cast(T, read_product(case.stages / stage, key, hint, case.root)[0])
    except (OSError, ValueError, KeyError, TypeError, LookupError):
        return None


def _record(case: CaseFolder, stage: str) -> Path:
    return case.stages / stage / "stage.json"
