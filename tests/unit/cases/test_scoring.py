"""The truth's own mesh: what was written is read, and nothing else is taken for it."""

from pathlib import Path

import numpy as np
import pytest

from limbgram.cases.scoring import read_truth_mesh
from limbgram.core.errors import CaseError
from limbgram.formats.ply import face_rows

_HEADER = """ply
format binary_little_endian 1.0
element vertex 4
property float x
property float y
property float z
property uchar ncam
property uchar cap
element face 2
property list uchar int vertex_indices
end_header
"""
_FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def _vertices() -> np.ndarray:
    rows = np.zeros(4, [("xyz", "<f4", 3), ("ncam", "u1"), ("cap", "u1")])
    rows["xyz"] = [(0, 0, 0), (10, 0, 0), (10, 20, 0), (0, 20, 5)]
    rows["ncam"], rows["cap"] = (5, 3, 2, 0), (0, 0, 1, 1)
    return rows


def _file(
    folder: Path, header: str = _HEADER, faces: np.ndarray = _FACES, behind: bytes = b""
) -> Path:
    path = folder / "mesh.ply"
    content = header.encode() + _vertices().tobytes() + face_rows(faces).tobytes() + behind
    path.write_bytes(content)
    return path


def test_a_truth_is_read_as_it_was_written(tmp_path: Path) -> None:
    vertices, faces = read_truth_mesh(_file(tmp_path))
    for name in ("xyz", "ncam", "cap"):
        np.testing.assert_array_equal(vertices[name], _vertices()[name])
    np.testing.assert_array_equal(faces, _FACES)


@pytest.mark.parametrize(
    ("changed", "to"),
    [
        ("ncam", "views"),
        ("property uchar cap\n", ""),
        ("face 2", "face 3"),
        ("vertex 4", "vertex x"),
    ],
)
def test_another_mesh_is_no_truth(tmp_path: Path, changed: str, to: str) -> None:
    with pytest.raises(CaseError) as refused:
        read_truth_mesh(_file(tmp_path, _HEADER.replace(changed, to)))
    assert refused.value.finding.code == "case.no_capture_truth"


def test_a_truth_with_more_behind_it_or_a_corner_that_is_none_is_refused(tmp_path: Path) -> None:
    for path in (_file(tmp_path, behind=b"\0"), _file(tmp_path, faces=_FACES + 2)):
        with pytest.raises(CaseError):
            read_truth_mesh(path)
