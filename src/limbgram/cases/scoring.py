"""Scoring: a finished case against the truth folder of a capture."""

from pathlib import Path

import numpy as np

from limbgram.cases.deliverables import surface_of
from limbgram.cases.folder import CaseFolder
from limbgram.core.errors import CaseError
from limbgram.core.files import json_of, read_content
from limbgram.core.geometry.arrays import Faces
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.ply import read_records
from limbgram.report.alignment import Truth
from limbgram.report.comparison import TruthComparison, compare_with_truth

_LARGEST_BYTES = 1 << 30
LEAST_PHOTOS = 3
"""Photos that must show a vertex for it to count as visible."""
_WRITTEN = np.dtype([*((axis, "<f4") for axis in "xyz"), ("ncam", "u1"), ("cap", "u1")])
_VERTEX = np.dtype([("xyz", "<f4", 3), ("ncam", "u1"), ("cap", "u1")])
"""The same with the place of a vertex as one field."""


def score_case(case: Path, truth: Path) -> TruthComparison:
    """Compare the surface that a case delivered with the truth of its capture."""
    import trimesh  # with networkx it takes 30 MB, which a server that never scores does without

    deliverables = CaseFolder(case).deliverables
    surface = trimesh.load_mesh(surface_of(deliverables), process=False)
    found = centres_mm(deliverables / "poses.json")
    true = centres_mm(truth / "cameras.json")
    shared = sorted(found.keys() & true.keys())
    vertices, faces = read_truth_mesh(truth / "mesh.ply")
    return compare_with_truth(
        Mesh(
            vertices_mm=np.asarray(surface.vertices, np.float64),
            faces=np.asarray(surface.faces, np.int32),
        ),
        np.array([found[name] for name in shared]),
        Truth(
            vertices_mm=vertices["xyz"].astype(float),
            faces=faces,
            seen=(vertices["ncam"] >= LEAST_PHOTOS) & (vertices["cap"] == 0),
            centres_mm=np.array([true[name] for name in shared]),
        ),
    )


def read_truth_mesh(path: Path) -> tuple[np.ndarray, Faces]:
    """Vertices (xyz, photos that show them, on the flat cut or not) and faces of a truth."""
    content = read_content(path, _LARGEST_BYTES, CaseError)
    try:
        rows, corners = read_records(content)
    except (ValueError, KeyError, IndexError) as error:
        raise _no_truth(path, error) from error
    if rows.dtype != _WRITTEN:
        raise _no_truth(path, "other properties")
    vertices, corners = rows.view(_VERTEX), np.ascontiguousarray(corners)
    if not 0 <= corners.min(initial=0) <= corners.max(initial=0) < len(vertices):
        raise _no_truth(path, "what it counts is not what it holds")
    if not np.isfinite(vertices["xyz"]).all():
        raise _no_truth(path, "a vertex has no place")
    return vertices, corners


def centres_mm(path: Path) -> dict[str, np.ndarray]:
    """Camera centre by photo name."""
    try:
        images = json_of(read_content(path, _LARGEST_BYTES, CaseError))["images"]
        places = {
            str(image["name"]): -_numbers(image["R"], (3, 3)).T @ _numbers(image["t"], (3,))
            for image in images
        }
    except (ValueError, KeyError, TypeError) as error:
        raise _no_truth(path, error) from error
    return places


def _numbers(listed: object, shape: tuple[int, ...]) -> np.ndarray:
    numbers = np.array(listed, np.float64)
    if numbers.shape != shape:
        raise ValueError("other numbers than a camera's")
    return numbers


def _no_truth(path: Path, why: object) -> CaseError:
    return CaseError("case.no_capture_truth", path=str(path), why=str(why))
