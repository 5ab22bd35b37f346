"""Truths: a true surface from the truth folder of a capture, or from any mesh file."""

import math
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float64

from limbgram.cases.scoring import LEAST_PHOTOS, centres_mm, read_truth_mesh
from limbgram.errors import CaseError, OptionsError
from limbgram.files import json_of, read_content
from limbgram.geometry.arrays import Points3
from limbgram.report.accuracy import Evidence, KnownTruth
from limbgram.report.accuracy.figures.truth import Alignment
from limbgram.report.alignment import Truth
from limbgram.shape.reading import read_limb

_FEWEST_CAMERAS = 3
_LARGEST_BYTES = 4_000_000


def read_truth(path: Path, evidence: Evidence, alignment: Alignment) -> KnownTruth:
    """The truth at `path`: a capture's folder, its truth folder, or a mesh file in mm.

    Raises:
        CaseError: there is no truth at this path.
        OptionsError: cameras are to be aligned, and the truth has none of ours.
    """
    folder = next((one for one in (path / "truth", path) if (one / "mesh.ply").is_file()), None)
    if folder is not None:
        known = _of_capture(folder, evidence, alignment)
    elif path.is_file():
        known = _of_mesh(path, alignment)
    else:
        raise CaseError(
            f"{path} holds no truth. Name a mesh file in millimetres, or the folder of a capture "
            "with truth/mesh.ply and truth/cameras.json."
        )
    if alignment == "cameras" and len(known.centres_mm) < _FEWEST_CAMERAS:
        raise OptionsError(
            f"{path} does not tell where three of the photos were taken. Align by the surface."
        )
    return known


def _of_capture(folder: Path, evidence: Evidence, alignment: Alignment) -> KnownTruth:
    vertices, faces = read_truth_mesh(folder / "mesh.ply")
    ours = {view.name: view.centre_in_world for view in evidence.metric.scene.views}
    true = centres_mm(folder / "cameras.json")
    shared = sorted(ours.keys() & true.keys())
    truth = Truth(
        vertices_mm=vertices["xyz"].astype(float),
        faces=faces,
        seen=(vertices["ncam"] >= LEAST_PHOTOS)
        & (vertices["cap"] == 0)
        & (vertices["xyz"][:, 2] >= _lowest_mm(folder / "notes.json")),
        centres_mm=_stack([true[name] for name in shared]),
    )
    return KnownTruth(
        kind="the truth of a capture",
        truth=truth,
        centres_mm=_stack([ours[name] for name in shared]),
        alignment=alignment,
    )


def _lowest_mm(notes: Path) -> float:
    """Height below which the truth itself says that nothing is compared: the rim of the cut."""
    if not notes.is_file():
        return -math.inf
    try:
        region: Any = json_of(read_content(notes, _LARGEST_BYTES, CaseError)).get("roi", {})
        return float(region.get("z_min", -math.inf))
    except (ValueError, TypeError, AttributeError) as error:
        raise CaseError(
            f"{notes} does not say what of the truth counts ({error}). Make the capture again."
        ) from error


def _of_mesh(path: Path, alignment: Alignment) -> KnownTruth:
    mesh = read_limb(path).mesh
    truth = Truth(
        vertices_mm=mesh.vertices_mm,
        faces=mesh.faces,
        seen=np.ones(len(mesh), bool),
        centres_mm=_stack([]),
    )
    return KnownTruth(kind="a mesh file", truth=truth, centres_mm=_stack([]), alignment=alignment)


def _stack(points: list[Float64[np.ndarray, "3"]]) -> Points3:
    return np.array(points, float).reshape(-1, 3)
