"""The limb file: what is known of a shape beyond its triangles, as JSON beside the mesh's file.

`scan.ply` has `scan.limb.json`. It holds the hash of the mesh's file, so it is never taken for
that of another shape. Places are in the mesh's frame, in millimetres.
"""

import hashlib
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from limbgram.errors import ShapeFileError
from limbgram.geometry.rigid import Rigid
from limbgram.shape.limb import KINDS, Kind, Landmark, Limb, LimbFrame, Side

_FORMAT, _VERSION = "limbgram limb", 1
_LARGEST_BYTES = 4_000_000
_MOST_LANDMARKS = 1000
_LONGEST_NAME = 80
_SIDES: tuple[Side, ...] = ("left", "right", "none")
_ROUNDING = 1e-6


@dataclass(frozen=True)
class OfAnother:
    """The limb file beside a shape is that of another file of the same name."""

    mesh_name: str


@dataclass(frozen=True, kw_only=True)
class LimbRecord:
    """What a limb file says."""

    mm_per_unit: float
    """Of the mesh's file."""
    landmarks: tuple[Landmark, ...]
    frame: LimbFrame | None
    sock_mm: float
    kind: Kind | None
    """None also in files older than this entry."""


def limb_file_beside(mesh_path: Path) -> Path:
    return mesh_path.with_name(f"{mesh_path.stem}.limb.json")


def hash_of(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def encode_record(limb: Limb, mesh_name: str, mesh_hash: str, mm_per_unit: float) -> bytes:
    """The limb file of a limb whose mesh lies in the named file."""
    frame = limb.frame
    tree = {
        "format": _FORMAT,
        "version": _VERSION,
        "mesh": {"file": mesh_name, "sha256": mesh_hash, "mm_per_unit": mm_per_unit},
        "kind": limb.kind,
        "side": None if frame is None else frame.side,
        "limb_from_mesh": None
        if frame is None
        else {
            "rotation": frame.limb_from_mesh.rotation.tolist(),
            "translation_mm": frame.limb_from_mesh.translation.tolist(),
        },
        "sock_mm": limb.sock_mm,
        "landmarks": [
            {"name": mark.name, "position_mm": mark.position_mm.tolist()} for mark in limb.landmarks
        ],
    }
    return (json.dumps(tree, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()


def read_record(path: Path, mesh_path: Path, mesh_hash: str) -> LimbRecord | OfAnother | None:
    """What the limb file says; None if there is none.

    Raises:
        ShapeFileError: it belongs to another mesh, or cannot be understood.
    """
    if not path.is_file():
        return None
    try:
        if path.stat().st_size > _LARGEST_BYTES:
            raise ValueError("it is too large")
        tree = json.loads(path.read_bytes())
        if tree["format"] != _FORMAT or tree["version"] != _VERSION:
            raise ValueError("it is of another program or a later version")
        owner = cast(dict[str, Any], tree["mesh"])
        if owner["sha256"] == mesh_hash:
            return _record(tree)
        other = str(owner.get("file"))
        if other != mesh_path.name and (mesh_path.parent / Path(other).name).is_file():
            return OfAnother(Path(other).name)
    except OSError as error:
        raise ShapeFileError(f"{path.name} cannot be read: {error.strerror or error}.") from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ShapeFileError(
            f"{path.name} is no limb file that can be read ({type(error).__name__}: {error}). "
            "Mend it, or move it away and align the shape again."
        ) from error
    raise ShapeFileError(
        f"{path.name} belongs to another shape ({str(owner.get('file'))[:80]}), not to "
        f"{mesh_path.name} as it is now: its landmarks and axes may be wrong on this one. If the "
        "shape was changed or replaced, move the limb file away and align again; if two shapes "
        "share a name, rename one."
    )


def _record(tree: dict[str, Any]) -> LimbRecord:
    marks = tree["landmarks"]
    if len(marks) > _MOST_LANDMARKS:
        raise ValueError(f"{len(marks)} landmarks")
    mm_per_unit, sock_mm = float(tree["mesh"]["mm_per_unit"]), float(tree["sock_mm"])
    if not (math.isfinite(mm_per_unit) and mm_per_unit > 0 and 0 <= sock_mm < 100):
        raise ValueError("a length that cannot be")
    return LimbRecord(
        mm_per_unit=mm_per_unit,
        landmarks=tuple(_landmark(mark) for mark in marks),
        frame=None if tree["limb_from_mesh"] is None else _frame(tree),
        sock_mm=sock_mm,
        kind=_kind(tree.get("kind")),
    )


def _kind(listed: Any) -> Kind | None:
    if listed is not None and listed not in KINDS:
        raise ValueError(f"kind {listed!r}")
    return listed


def _landmark(tree: dict[str, Any]) -> Landmark:
    name = str(tree["name"])
    if not 0 < len(name) <= _LONGEST_NAME or not name.isprintable():
        raise ValueError("a landmark without a usable name")
    return Landmark(name=name, position_mm=_numbers(tree["position_mm"], (3,)))


def _frame(tree: dict[str, Any]) -> LimbFrame:
    motion = tree["limb_from_mesh"]
    rotation = _numbers(motion["rotation"], (3, 3))
    turned = np.abs(rotation @ rotation.T - np.eye(3)).max() > _ROUNDING
    if turned or np.linalg.det(rotation) < 0:
        raise ValueError("limb_from_mesh is no rotation")
    if tree["side"] not in _SIDES:
        raise ValueError(f"side {tree['side']!r}")
    motion = Rigid(rotation, _numbers(motion["translation_mm"], (3,)))
    return LimbFrame(limb_from_mesh=motion, side=tree["side"])


def _numbers(listed: Any, shape: tuple[int, ...]) -> np.ndarray:
    numbers = np.array(listed, np.float64)
    if numbers.shape != shape or not np.isfinite(numbers).all():
        raise ValueError(f"{listed} in place of numbers")
    return numbers
