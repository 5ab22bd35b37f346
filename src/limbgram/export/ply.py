"""PLY, binary: the surface with colour, filled mark and sigma; and the cloud.

A reader of its own checks the files: positions, colours and the marks that few programs read.
"""

from pathlib import Path
from typing import BinaryIO

import numpy as np
from jaxtyping import Shaped

from limbgram.export.writing import (
    Unit,
    require,
    require_same_triangles,
    single_precision,
    target,
    write_file,
)
from limbgram.geometry.cloud import Cloud
from limbgram.surface.mesh import Mesh

_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
_NAMES = {"<f4": "float", "|u1": "uchar"}
_TYPES = {name: code for code, name in _NAMES.items()}
_COLOUR = ("red", "green", "blue")


def write_ply(mesh: Mesh, path: Path, unit: Unit, *, unscaled: bool = False) -> Path:
    """Write the mesh with all that is known of its vertices, and read it back."""
    columns = dict(zip("xyz", mesh.vertices_mm.T.astype("<f4")))
    if mesh.colours is not None:
        columns |= dict(zip(_COLOUR, mesh.colours.T))
    if mesh.filled is not None:
        columns["filled"] = mesh.filled.astype(np.uint8)
    if mesh.sigma_mm is not None:
        columns["sigma"] = mesh.sigma_mm.astype("<f4")
    if mesh.shared_mm is not None:
        columns |= {f"shared_{k}": part.astype("<f4") for k, part in enumerate(mesh.shared_mm.T)}
    if mesh.lost_length is not None:
        columns |= dict(zip(("lost", "lost_sigma"), mesh.lost_length.T.astype("<f4")))
    path = target(path, unit, unscaled=unscaled)
    rows, faces = _rows(columns), _face_rows(mesh)

    def encode(stream: BinaryIO) -> None:
        stream.write(_header(rows, len(faces), unit, mesh.correlation_mm))
        stream.write(rows.tobytes() + faces.tobytes())

    def check(written: Path) -> None:
        read_rows, corners = _read(written)
        require(read_rows.tobytes() == rows.tobytes(), f"{path.name}: other vertices")
        places = np.column_stack([read_rows[axis] for axis in "xyz"]).astype(np.float64)
        require_same_triangles(path.name, places[corners], mesh, single_precision(mesh))

    return write_file(path, encode, check)


def write_cloud_ply(cloud: Cloud, path: Path, unit: Unit, *, unscaled: bool = False) -> Path:
    """Write the points with normal, colour and number of photos, and read them back."""
    columns = dict(zip("xyz", cloud.points_mm.T.astype("<f4")))
    columns |= dict(zip(("nx", "ny", "nz"), cloud.normals.T.astype("<f4")))
    columns |= dict(zip(_COLOUR, cloud.colours.T)) | {"views": cloud.views}
    path = target(path, unit, unscaled=unscaled)
    rows = _rows(columns)

    def encode(stream: BinaryIO) -> None:
        stream.write(_header(rows, 0, unit))
        stream.write(rows.tobytes())

    def check(written: Path) -> None:
        read_rows, _ = _read(written)
        require(read_rows.dtype == rows.dtype, f"{path.name}: other columns")
        require(len(read_rows) == len(cloud), f"{path.name}: {len(read_rows)} of {len(cloud)}")
        require(read_rows.tobytes() == rows.tobytes(), f"{path.name}: other points")

    return write_file(path, encode, check)


def _rows(columns: dict[str, np.ndarray]) -> Shaped[np.ndarray, " n"]:
    """One record a vertex."""
    layout = np.dtype([(name, values.dtype.str) for name, values in columns.items()])
    rows = np.zeros(len(columns["x"]), layout)
    for name, values in columns.items():
        rows[name] = values
    return rows


def _face_rows(mesh: Mesh) -> Shaped[np.ndarray, " f"]:
    rows = np.zeros(len(mesh.faces), _FACE)
    rows["count"] = 3
    rows["corners"] = mesh.faces
    return rows


def _header(
    rows: Shaped[np.ndarray, " n"], faces: int, unit: str, correlation: float | None = None
) -> bytes:
    names: tuple[str, ...] = rows.dtype.names or ()
    lines = ["ply", "format binary_little_endian 1.0", f"comment limbgram, unit: {unit}"]
    if correlation is not None:
        lines.append(f"comment sigma is alike over: {correlation!r}")
    lines.append(f"element vertex {len(rows)}")
    lines += [f"property {_NAMES[rows.dtype[name].str]} {name}" for name in names]
    if faces:
        lines += [f"element face {faces}", "property list uchar int vertex_indices"]
    return "\n".join([*lines, "end_header\n"]).encode("ascii")


def _read(path: Path) -> tuple[Shaped[np.ndarray, " n"], np.ndarray]:
    """Vertex records and face corners of a file of this form, by what its header says."""
    head, _, body = path.read_bytes().partition(b"end_header\n")
    count, faces = 0, 0
    layout: list[tuple[str, str]] = []
    for words in (line.split() for line in head.decode("ascii").splitlines()):
        match words:
            case ["element", "vertex", number]:
                count = int(number)
            case ["element", "face", number]:
                faces = int(number)
            case ["property", kind, name]:
                layout.append((name, _TYPES[kind]))
            case _:
                pass
    size = count * np.dtype(layout).itemsize
    complete = len(body) == size + faces * _FACE.itemsize
    require(complete, f"{path.name}: {len(body)} bytes after the header")
    rows = np.frombuffer(body[:size], layout)
    return rows, np.frombuffer(body[size:], _FACE)["corners"]
