"""The very bytes of small files: a change here is a change for every program that reads them."""

from pathlib import Path

import numpy as np

from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.dxf_r12 import write_r12_dxf
from limbgram.formats.stl import write_stl

GOLDEN = Path(__file__).parent
TETRAHEDRON = Mesh(
    vertices_mm=np.array([[0.0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 12]]),
    faces=np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32),
)


def test_stl(tmp_path: Path) -> None:
    written = write_stl(TETRAHEDRON, tmp_path / "tetrahedron.stl", "mm").read_bytes()
    assert written == (GOLDEN / "tetrahedron.stl").read_bytes()


def test_dxf_of_release_12(tmp_path: Path) -> None:
    written = write_r12_dxf(TETRAHEDRON, tmp_path / "tetrahedron.dxf", "mm").read_bytes()
    assert written == (GOLDEN / "tetrahedron.dxf").read_bytes()
