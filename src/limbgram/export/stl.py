"""STL, binary: the triangles alone, in millimetres by what the header says."""

from pathlib import Path
from typing import BinaryIO

import numpy as np

from limbgram.export.writing import (
    Unit,
    require_same_triangles,
    single_precision,
    target,
    write_file,
)
from limbgram.surface.mesh import Mesh

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write_stl(mesh: Mesh, path: Path, unit: Unit, *, unscaled: bool = False) -> Path:
    """Write a binary STL and read it back."""
    path = target(path, unit, unscaled=unscaled)
    # A header that began with "solid" would be taken for the text form.
    header = f"limbgram binary STL, unit: {unit}".encode().ljust(80)

    def encode(stream: BinaryIO) -> None:
        normals = mesh.face_normals()
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        records = np.zeros(len(mesh.faces), _RECORD)
        records["normal"] = normals / np.maximum(lengths, 1e-30)
        records["corners"] = mesh.vertices_mm[mesh.faces]
        stream.write(header + np.uint32(len(mesh.faces)).astype("<u4").tobytes())
        stream.write(records.tobytes())

    def check(written: Path) -> None:
        import trimesh  # a fifth of a second, which most commands do without

        read = trimesh.load_mesh(written, file_type="stl", process=False)
        require_same_triangles(path.name, np.asarray(read.triangles), mesh, single_precision(mesh))

    return write_file(path, encode, check)
