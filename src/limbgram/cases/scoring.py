"""Scoring: a finished case against the truth folder of a capture."""

import json
from pathlib import Path

import numpy as np
import trimesh

from limbgram.cases.folder import CaseFolder
from limbgram.errors import CaseError
from limbgram.geometry.arrays import Faces
from limbgram.report.alignment import Truth
from limbgram.report.comparison import Comparison, compare
from limbgram.surface.mesh import Mesh

LEAST_PHOTOS = 3
"""Photos that must show a vertex for it to count as visible."""
_VERTEX = np.dtype([("xyz", "<f4", 3), ("ncam", "u1"), ("cap", "u1")])
_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def score_case(case: Path, truth: Path) -> Comparison:
    """Compare the surface that a case delivered with the truth of its capture."""
    deliverables = CaseFolder(case).deliverables
    surface = trimesh.load_mesh(deliverables / "surface.ply", process=False)
    found = centres_mm(deliverables / "poses.json")
    true = centres_mm(truth / "cameras.json")
    shared = sorted(found.keys() & true.keys())
    vertices, faces = read_truth_mesh(truth / "mesh.ply")
    return compare(
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
    content = path.read_bytes()
    header, _, body = content.partition(b"end_header\n")
    words = [line.split() for line in header.decode("ascii", "replace").splitlines()]
    counts = {line[1]: int(line[2]) for line in words if line[:1] == ["element"]}
    properties = [line[-1] for line in words if line[:1] == ["property"]]
    if properties != ["x", "y", "z", "ncam", "cap", "vertex_indices"]:
        raise CaseError(f"{path} is no truth of a capture. Make the capture again.")
    vertices = np.frombuffer(body, _VERTEX, counts["vertex"])
    faces = np.frombuffer(body, _FACE, counts["face"], vertices.nbytes)
    return vertices, np.ascontiguousarray(faces["corners"])


def centres_mm(path: Path) -> dict[str, np.ndarray]:
    """Camera centre by photo name."""
    images = json.loads(path.read_text("utf-8"))["images"]
    return {image["name"]: -np.array(image["R"]).T @ np.array(image["t"]) for image in images}
