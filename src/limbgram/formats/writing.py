"""Writing meshes and poses: the path by their unit, and the comparison of what is read back."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import ExportError
from limbgram.core.files import other, other_count, require, write_bytes
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh, crosses
from limbgram.findings import fault

Unit = Literal["mm", "unitless"]


def target(path: Path | str, unit: Unit, *, unscaled: bool) -> Path:
    """The path to write to: as given for millimetres, with a mark in its name without a unit.

    Raises:
        ExportError: there is no unit, and `unscaled` is not set.
    """
    path = Path(path)
    if unit == "mm":
        return path
    if not unscaled:
        raise ExportError("export.unscaled", name=path.name)
    return path.with_name(f"{path.stem}-unitless{path.suffix}")


def write_poses_tree(tree: Mapping[str, Any], path: Path) -> Path:
    """Write cameras and poses as JSON, and read them back without any difference."""

    def check(written: Path) -> None:
        require(json.loads(written.read_bytes()) == tree, other(path.name, "poses"))

    return write_bytes(path, json.dumps(tree, indent=1).encode(), check)


def require_same_triangles(
    name: str, read: Float64[np.ndarray, "f 3 3"], mesh: Mesh, tolerance: float
) -> None:
    """Refuse triangles that differ from the mesh's, in order, by more than the tolerance."""
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
    """Largest rounding error of the mesh's coordinates in 32-bit floats."""
    return float(np.spacing(np.float32(np.abs(mesh.vertices_mm).max(initial=1.0))))


def _normals(triangles: Float64[np.ndarray, "f 3 3"]) -> Float64[np.ndarray, "f 3"]:
    return crosses(
        triangles.reshape(-1, 3), np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3)
    )


def _volume(places: Points3, normals: Float64[np.ndarray, "f 3"]) -> float:
    """Volume, from a point on each triangle and its normal of twice its area."""
    around = places - places.mean(0) if len(places) else places
    return float(np.einsum("ij,ij->", around, normals)) / 6
