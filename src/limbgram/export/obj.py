"""OBJ: the surface as text."""

from pathlib import Path
from typing import BinaryIO

import numpy as np

from limbgram.export.writing import Unit, require_same_triangles, target, write_file
from limbgram.surface.mesh import Mesh

_PRECISION = 1e-6
_BLOCK = 10_000


def write_obj(mesh: Mesh, path: Path, unit: Unit, *, unscaled: bool = False) -> Path:
    """Write vertices (to a millionth of a unit) and faces, and read them back."""
    path = target(path, unit, unscaled=unscaled)

    def encode(stream: BinaryIO) -> None:
        stream.write(f"# limbgram, unit: {unit}\n".encode("ascii"))
        for rows in _blocks(mesh.vertices_mm):
            stream.write(("v %.6f %.6f %.6f\n" * len(rows) % tuple(rows.ravel())).encode("ascii"))
        for rows in _blocks(mesh.faces + 1):
            stream.write(("f %d %d %d\n" * len(rows) % tuple(rows.ravel())).encode("ascii"))

    def check(written: Path) -> None:
        vertices, faces = _read(written)
        require_same_triangles(path.name, vertices[faces], mesh, _PRECISION)

    return write_file(path, encode, check)


def _blocks(rows: np.ndarray) -> list[np.ndarray]:
    return [rows[start : start + _BLOCK] for start in range(0, len(rows), _BLOCK)]


def _read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    lines = path.read_bytes().splitlines()
    vertices = b" ".join(line[2:] for line in lines if line.startswith(b"v "))
    faces = b" ".join(line[2:] for line in lines if line.startswith(b"f "))
    places = np.array(vertices.split(), np.float64).reshape(-1, 3)
    return places, np.array(faces.split(), np.int64).reshape(-1, 3) - 1
