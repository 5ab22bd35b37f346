"""Kept products: those of a finished case from which its accuracy is read; nothing is computed."""

import json
import zipfile
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from limbgram.calibration.cameras import Cameras
from limbgram.cases.folder import CaseFolder
from limbgram.cases.keeping.encoding import from_tree
from limbgram.errors import CaseError
from limbgram.photos.photo import PhotoSet
from limbgram.report.accuracy import Evidence
from limbgram.scale.metric import MetricScene
from limbgram.surface.mesh import Mesh
from limbgram.targets.detections import BoardDetections

T = TypeVar("T")


def kept_evidence(case: CaseFolder) -> Evidence:
    """The evidence that a finished case keeps.

    Raises:
        CaseError: the folder is no finished case, or its products cannot be read.
    """
    _require_finished(case)
    board = case.stages / "find_board"
    return Evidence(
        name=_name(case),
        photos=_read(case, "read_photos", PhotoSet),
        cameras=_read(case, "cameras_for", Cameras),
        detections=_read(case, "find_board", BoardDetections) if board.is_dir() else None,
        metric=_read(case, "to_millimetres", MetricScene),
        mesh=_read(case, "measure", Mesh),
    )


def _name(case: CaseFolder) -> str:
    """Of the case, told apart from the many that are called `case`."""
    root = case.root.resolve()
    return f"{root.parent.name}/{root.name}" if root.name == "case" else root.name


def _require_finished(case: CaseFolder) -> None:
    try:
        state = json.loads(case.record.read_text("utf-8"))["state"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise CaseError(
            f"{case.root} is no case: it has no readable case.json. Name the folder that "
            "`limbgram reconstruct` was given with -o."
        ) from error
    if state != "finished":
        raise CaseError(
            f"The case {case.root} is {state}. Run `limbgram reconstruct` again: it continues "
            "where it stopped."
        )


def _read(case: CaseFolder, stage: str, hint: type[T]) -> T:
    """A product by the name of its stage, whatever options it was made with."""
    folder = case.stages / stage
    try:
        with np.load(folder / "arrays.npz", allow_pickle=False) as kept:
            arrays = [kept[f"arr_{k}"] for k in range(len(kept.files))]
        tree: Any = json.loads((folder / "product.json").read_text("utf-8"))
        return from_tree(tree, hint, arrays, Path(case.root))
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        raise CaseError(
            f"{folder} cannot be read ({type(error).__name__}): it was made by another version, "
            "or is damaged. Run `limbgram reconstruct` on the case again."
        ) from error
