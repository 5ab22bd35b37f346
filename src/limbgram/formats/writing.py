"""Writing a mesh or poses: where they go by their unit, and that what was read back is the same."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO, Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import ExportError
from limbgram.core.files import other, other_count, require, write_file
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh, crosses
from limbgram.findings import fault

Unit = Literal["mm", "unitless"]


def target(path: Path | str, unit: Unit, *, unscaled: bool) -> Path:
    """The path to write to: as given for millimetres, marked in its name where there is no unit.

    Raises:
        ExportError: the scene has no scale, and nobody asked for a file without one.
    """
    path = Path(path)
    if unit == "mm":
        return path
    if not unscaled:
        raise ExportError("export.unscaled", name=path.name)
    return path.with_name(f"{path.stem}-unitless{path.suffix}")


def write_poses_tree(tree: Mapping[str, Any], path: Path) -> Path:
    """Write cameras and poses as JSON, and read them back: each number is the very same."""

    def encode(stream: BinaryIO) -> None:
        stream.write(json.dumps(tree, indent=1).encode())

    def check(written: Path) -> None:
        require(json.loads(written.read_bytes()) == tree, other(path.name, "poses"))

    return write_file(path, encode, check)


def require_same_triangles(
    name: str, read: Float64[np.ndarray, "f 3 3"], mesh: Mesh, tolerance: float
) -> None:
    """The triangles read back are the mesh's, in order, within the format's precision."""
    wanted = (len(mesh.faces), 3, 3)
    require(read.shape == wanted, other_count(name, "triangles", len(read), len(mesh.faces)))
    expected = [mesh.vertices_mm[mesh.faces[:, k]] for k in range(3)]
    apart = [np.abs(read[:, k] - expected[k]).max(initial=0.0) for k in range(3)]
    worst = float(np.max(apart))
    require(worst <= tolerance, fault("export.corner_elsewhere", name=name, off_mm=worst))
    normals = mesh.face_normals()
    areas = np.linalg.norm(normals, axis=1).sum() / 2
    change = abs(_volume(read[:, 0], _normals(read)) - _volume(expected[0], normals))
    rounding = 1e-12 * float(np.abs(mesh.vertices_mm).max(initial=0.0)) ** 3
    require(
        change <= 2 * areas * tolerance + rounding,
        fault("export.other_volume", name=name, change_mm3=change),
    )


def single_precision(mesh: Mesh) -> float:
    """Largest rounding of the mesh's coordinates in 32 bits."""
    return float(np.spacing(np.float32(np.abs(mesh.vertices_mm).max(initial=1.0))))


def _normals(triangles: Float64[np.ndarray, "f 3 3"]) -> Float64[np.ndarray, "f 3"]:
    return crosses(
        triangles.reshape(-1, 3), np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3)
    )


def _volume(places: Points3, normals: Float64[np.ndarray, "f 3"]) -> float:
    """From a place on each triangle and its normal, twice its area long."""
    around = places - places.mean(0) if len(places) else places
    return float(np.einsum("ij,ij->", around, normals)) / 6
