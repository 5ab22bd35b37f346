"""The limb file: what is known of a shape beyond its triangles, as JSON beside the mesh's file.

`scan.ply` has `scan.limb.json`; where that is there and belongs to `scan.ply`, `scan.stl` has
`scan.stl.limb.json`. It holds the hash of the mesh's file, so it is never taken for
that of another shape. Places are in the mesh's frame, in millimetres. It names what the mesh was
made from by hash and motion; files older than that entry do not, and older versions pass over it.
"""

import hashlib
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from limbgram.core.errors import ShapeFileError
from limbgram.core.files import json_of, read_content
from limbgram.core.geometry.frames import Rigid
from limbgram.workbench.limb import KINDS, Kind, Landmark, Limb, LimbFrame, Origin, Side

LIMB_FILE_ENDING = ".limb.json"
_FORMAT, _VERSION = "limbgram limb", 1
_LARGEST_BYTES = 4_000_000
_MOST_LANDMARKS = 1000
_LONGEST_NAME = 80
_LONGEST_DOUBT = 400
_MOST_ORIGINS = 100
_SIDES: tuple[Side, ...] = ("left", "right", "none")
_ROUNDING = 1e-6
_FARTHEST_MM = 1e9
"""No shape that is read reaches farther."""


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
    made_from: tuple[Origin, ...]
    """The nearest first; none in files older than this entry."""
    doubt: str = ""


def limb_file_beside(mesh_path: Path) -> Path:
    """`scan.limb.json` of `scan.ply`; and `scan.stl.limb.json` of `scan.stl`, where it has one."""
    own = _own_limb_file(mesh_path)
    return own if own.is_file() else mesh_path.with_name(f"{mesh_path.stem}{LIMB_FILE_ENDING}")


def limb_file_for(mesh_path: Path) -> Path:
    """Where the limb file of a mesh is written: never over that of a namesake that is still there.

    `scan.ply` and `scan.stl` may be one limb in two formats, or two limbs: each keeps its own.
    """
    path = limb_file_beside(mesh_path)
    owner = mesh_path.name
    if path.is_file():
        try:
            owner = str(json_of(read_content(path, _LARGEST_BYTES, ShapeFileError))["mesh"]["file"])
        except (ShapeFileError, ValueError, KeyError, TypeError):
            owner = mesh_path.name
    of_another = owner != mesh_path.name and (mesh_path.parent / Path(owner).name).is_file()
    return _own_limb_file(mesh_path) if of_another else path


def _own_limb_file(mesh_path: Path) -> Path:
    return mesh_path.with_name(f"{mesh_path.name}{LIMB_FILE_ENDING}")


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
        "limb_from_mesh": None if frame is None else _tree(frame.limb_from_mesh),
        "sock_mm": limb.sock_mm,
        "doubt": limb.doubt,
        "landmarks": [
            {"name": mark.name, "position_mm": mark.position_mm.tolist()} for mark in limb.landmarks
        ],
        "made_from": [
            {
                "sha256": origin.sha256,
                "mm_per_unit": origin.mm_per_unit,
                "mesh_from_it": _tree(origin.mesh_from_origin),
            }
            for origin in limb.origins[:_MOST_ORIGINS]
            if origin.sha256 != mesh_hash
        ],
    }
    return (json.dumps(tree, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _tree(motion: Rigid) -> dict[str, Any]:
    return {
        "rotation": motion.rotation.tolist(),
        "translation_mm": motion.translation.tolist(),
    }


def read_record(path: Path, mesh_path: Path, mesh_hash: str) -> LimbRecord | OfAnother | None:
    """What the limb file says; None if there is none.

    Raises:
        ShapeFileError: it belongs to another mesh, or cannot be understood.
    """
    if not path.is_file():
        return None
    try:
        tree = json_of(read_content(path, _LARGEST_BYTES, ShapeFileError))
        if tree["format"] != _FORMAT or tree["version"] != _VERSION:
            raise ValueError("it is of another program or a later version")
        owner = cast(dict[str, Any], tree["mesh"])
        if owner["sha256"] == mesh_hash:
            return _record(tree)
        other = str(owner.get("file"))
        if other != mesh_path.name and (mesh_path.parent / Path(other).name).is_file():
            return OfAnother(Path(other).name)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
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
    marks, made_from = tree["landmarks"], tree.get("made_from", [])
    if len(marks) > _MOST_LANDMARKS:
        raise ValueError(f"{len(marks)} landmarks")
    if len(made_from) > _MOST_ORIGINS:
        raise ValueError(f"made from {len(made_from)} files")
    sock_mm = float(tree["sock_mm"])
    if not 0 <= sock_mm < 100:
        raise ValueError("a length that cannot be")
    landmarks = tuple(_landmark(mark) for mark in marks)
    if len({mark.name for mark in landmarks}) < len(landmarks):
        raise ValueError("two landmarks of one name")
    return LimbRecord(
        mm_per_unit=_unit(tree["mesh"]["mm_per_unit"]),
        landmarks=landmarks,
        frame=None if tree["limb_from_mesh"] is None else _frame(tree),
        sock_mm=sock_mm,
        kind=_kind(tree.get("kind")),
        made_from=tuple(_origin(origin) for origin in made_from),
        doubt=str(tree.get("doubt", ""))[:_LONGEST_DOUBT],
    )


def _unit(listed: Any) -> float:
    mm_per_unit = float(listed)
    if not (math.isfinite(mm_per_unit) and mm_per_unit > 0):
        raise ValueError("a length that cannot be")
    return mm_per_unit


def _origin(tree: dict[str, Any]) -> Origin:
    return Origin(
        sha256=str(tree["sha256"]),
        mm_per_unit=_unit(tree["mm_per_unit"]),
        mesh_from_origin=_motion(tree["mesh_from_it"], "mesh_from_it"),
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
    motion = _motion(tree["limb_from_mesh"], "limb_from_mesh")
    if tree["side"] not in _SIDES:
        raise ValueError(f"side {tree['side']!r}")
    return LimbFrame(limb_from_mesh=motion, side=tree["side"])


def _motion(tree: dict[str, Any], name: str) -> Rigid:
    rotation = _numbers(tree["rotation"], (3, 3))
    turned = np.abs(rotation @ rotation.T - np.eye(3)).max() > _ROUNDING
    if turned or np.linalg.det(rotation) < 0:
        raise ValueError(f"{name} is no rotation")
    return Rigid(rotation, _numbers(tree["translation_mm"], (3,)))


def _numbers(listed: Any, shape: tuple[int, ...]) -> np.ndarray:
    numbers = np.array(listed, np.float64)
    if numbers.shape != shape or not (np.abs(numbers) <= _FARTHEST_MM).all():
        raise ValueError(f"{listed} in place of numbers")
    return numbers
