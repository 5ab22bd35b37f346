"""Writing: a file appears under its name whole and proved, or not at all.

Each writer puts its bytes beside the target, syncs them, reads that file back and compares it
with what it should hold; only then does the file take its name.
"""

import os
import shutil
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import ExportError, is_full
from limbgram.core.files import short_name
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh, crosses

_LONGEST_SUFFIX = 16
Unit = Literal["mm", "unitless"]


def write_file(
    path: Path, encode: Callable[[BinaryIO], None], check: Callable[[Path], None]
) -> Path:
    """Write a file by `encode`, prove it by `check` (which raises ExportError), and name it."""
    suffix = path.suffix if len(path.suffix) <= _LONGEST_SUFFIX else ""
    beside = path.with_name(f".{short_name(path)}.{os.getpid()}.part{suffix}")
    with _disk(path):
        _sweep(path)
        try:
            with beside.open("wb") as stream:
                encode(stream)
                stream.flush()
                os.fsync(stream.fileno())
            check(beside)
            beside.replace(path)
        finally:
            beside.unlink(missing_ok=True)
        _sync_folder(path.parent)
    return path


def write_bytes(path: Path, content: bytes) -> Path:
    """Write a file whose bytes are at hand; proved by reading the same ones."""

    def encode(stream: BinaryIO) -> None:
        stream.write(content)

    def check(written: Path) -> None:
        require(written.read_bytes() == content, f"{path.name}: other bytes")

    return write_file(path, encode, check)


def write_folder(
    path: Path, files: dict[str, Callable[[BinaryIO], None]], check: Callable[[Path], None]
) -> Path:
    """Write a folder of files; an older folder of the name gives way once the new one is proved."""
    beside = path.with_name(f".{short_name(path)}.{os.getpid()}.part")
    older = path.with_name(f".{short_name(path)}.{os.getpid()}.old")
    with _disk(path):
        _sweep(path)
        try:
            beside.mkdir()
            for name, encode in files.items():
                with (beside / name).open("wb") as stream:
                    encode(stream)
                    stream.flush()
                    os.fsync(stream.fileno())
            _sync_folder(beside)
            check(beside)
            if path.exists():
                path.replace(older)
            beside.replace(path)
        finally:
            shutil.rmtree(beside, ignore_errors=True)
            shutil.rmtree(older, ignore_errors=True)
        _sync_folder(path.parent)
    return path


def _sweep(path: Path) -> None:
    """Remove what processes that were killed while they wrote the same file left beside it."""
    for left in path.parent.glob(f".{short_name(path)}.*"):
        process = left.name.split(".")[2]
        if not process.isdecimal() or _is_alive(int(process)):
            continue
        if left.is_dir():
            shutil.rmtree(left, ignore_errors=True)
        else:
            left.unlink(missing_ok=True)


def _is_alive(process: int) -> bool:
    """Whether a process may still be running."""
    if sys.platform == "win32":
        return True  # to ask by a signal would end it there
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True


def target(path: Path, unit: Unit, *, unscaled: bool) -> Path:
    """The path to write to: as given for millimetres, marked in its name where there is no unit.

    Raises:
        ExportError: the scene has no scale, and nobody asked for a file without one.
    """
    if unit == "mm":
        return path
    if not unscaled:
        raise ExportError(
            f"{path.name} was not written: the scene has no scale, and other programs would take "
            "its numbers for millimetres. Put a scale board beside the limb or give known "
            "distances; or ask for a file without unit by --unscaled."
        )
    return path.with_name(f"{path.stem}-unitless{path.suffix}")


def require_same_triangles(
    name: str, read: Float64[np.ndarray, "f 3 3"], mesh: Mesh, tolerance: float
) -> None:
    """The triangles read back are the mesh's, in order, within the format's precision."""
    wanted = (len(mesh.faces), 3, 3)
    require(read.shape == wanted, f"{name}: {len(read)} triangles of {len(mesh.faces)}")
    expected = [mesh.vertices_mm[mesh.faces[:, k]] for k in range(3)]
    apart = [np.abs(read[:, k] - expected[k]).max(initial=0.0) for k in range(3)]
    worst = float(np.max(apart))
    require(worst <= tolerance, f"{name}: a corner lies {worst:.3g} from its place")
    normals = mesh.face_normals()
    areas = np.linalg.norm(normals, axis=1).sum() / 2
    change = abs(_volume(read[:, 0], _normals(read)) - _volume(expected[0], normals))
    rounding = 1e-12 * float(np.abs(mesh.vertices_mm).max(initial=0.0)) ** 3
    require(
        change <= 2 * areas * tolerance + rounding, f"{name}: its volume differs by {change:.3g}"
    )


def require(holds: bool, finding: str) -> None:
    """Refuse a file that did not read back as it was written."""
    if not holds:
        raise ExportError(
            f"Reading back found {finding}. The file was not kept. The disk or its connection is "
            "probably failing: write to another disk."
        )


def single_precision(mesh: Mesh) -> float:
    """Largest rounding of the mesh's coordinates in 32 bits."""
    return float(np.spacing(np.float32(np.abs(mesh.vertices_mm).max(initial=1.0))))


def _normals(triangles: Float64[np.ndarray, "f 3 3"]) -> Float64[np.ndarray, "f 3"]:
    return crosses(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def _volume(places: Points3, normals: Float64[np.ndarray, "f 3"]) -> float:
    """From a place on each triangle and its normal, twice its area long."""
    around = places - places.mean(0) if len(places) else places
    return float(np.einsum("ij,ij->", around, normals)) / 6


@contextmanager
def _disk(path: Path) -> Generator[None]:
    """Turn what the system says about a disk into advice."""
    try:
        yield
    except OSError as error:
        if is_full(error):
            raise ExportError(
                f"{path.name} was not written: the disk of {path.parent} is full. Free some "
                "space, or choose another folder, and run again; what is finished is kept."
            ) from error
        raise ExportError(
            f"{path.name} was not written to {path.parent}: {error.strerror or error}. Check "
            "that the folder exists and may be written to, and that the name is not too long."
        ) from error


def _sync_folder(folder: Path) -> None:
    """Make a renaming last; systems that cannot sync a folder keep it by themselves."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
