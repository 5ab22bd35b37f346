"""The limb file: landmarks, axes, side and origins of a shape, as JSON beside the mesh's file.

The limb file of `scan.ply` is `scan.limb.json`; where that is another file's, the one of `scan.stl`
is `scan.stl.limb.json`. It holds the hash of the mesh's file, so that it is never used for another
shape. Positions are in the mesh's frame, in millimetres. Its origins, by hash and motion, are the
files that the mesh was made from; files of earlier versions have none.
"""

import hashlib
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from limbgram.core.errors import ExportError, ShapeFileError, reason_of
from limbgram.core.files import ContentError, json_of, read_content
from limbgram.core.geometry.frames import Rigid
from limbgram.core.typed import Strictness, value_of
from limbgram.findings import Finding, as_json
from limbgram.workbench.limb import KindName, Landmark, Limb, LimbFrame, Origin, Placed, Side

LIMB_FILE_ENDING = ".limb.json"
_FORMAT, _VERSION = "limbgram limb", 1
_LARGEST_BYTES = 4_000_000
_MOST_LANDMARKS = 1000
_LONGEST_NAME = 80
_LONGEST_DOUBT = 400
_MOST_ORIGINS = 100
_THICKEST_SOCK_MM = 100
_LARGEST_PLACING_MM = 100
_ROUNDING = 1e-6
_AS_WRITTEN = Strictness(pass_over_unknown=True, below=1e9)
"""Unknown names are ignored: later versions may write more. `below` bounds coordinates, mm."""

_Triple = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class _Motion:
    rotation: tuple[_Triple, _Triple, _Triple]
    translation_mm: _Triple


@dataclass(frozen=True, kw_only=True)
class _Mark:
    name: str
    position_mm: _Triple
    placed: Placed = "click"
    sigma_mm: float | None = None
    confirmed: bool = True


@dataclass(frozen=True, kw_only=True)
class _Origin:
    sha256: str
    mm_per_unit: float
    mesh_from_it: _Motion


@dataclass(frozen=True, kw_only=True)
class _Owner:
    """The mesh that a limb file belongs to."""

    sha256: str
    file: str = ""
    mm_per_unit: float = math.nan


@dataclass(frozen=True, kw_only=True)
class _Head:
    """The part of a limb file that tells which mesh it belongs to."""

    format: Literal["limbgram limb"]
    version: Literal[1]
    mesh: _Owner


@dataclass(frozen=True, kw_only=True)
class _LimbFile(_Head):
    """What a limb file holds."""

    side: Side | None
    limb_from_mesh: _Motion | None
    sock_mm: float
    landmarks: tuple[_Mark, ...]
    kind: KindName | None = None
    doubt: Finding | None = None
    """Earlier versions wrote a sentence."""
    made_from: tuple[_Origin, ...] = ()


@dataclass(frozen=True)
class OfAnother:
    """The limb file beside a shape belongs to another file with the same stem."""

    mesh_name: str


@dataclass(frozen=True, kw_only=True)
class LimbRecord:
    """The content of a limb file."""

    mm_per_unit: float
    """Of the mesh's file."""
    landmarks: tuple[Landmark, ...]
    frame: LimbFrame | None
    sock_mm: float
    kind: KindName | None
    """None also in files of earlier versions."""
    made_from: tuple[Origin, ...]
    """The latest origin first; none in files of earlier versions."""
    doubt: Finding | None = None


def limb_file_beside(mesh_path: Path) -> Path:
    """`scan.limb.json` of `scan.ply`; and `scan.stl.limb.json` of `scan.stl`, where it has one."""
    own = _own_limb_file(mesh_path)
    return own if own.is_file() else mesh_path.with_name(f"{mesh_path.stem}{LIMB_FILE_ENDING}")


@dataclass(frozen=True, kw_only=True)
class LimbProgress:
    """How far the work on a limb is, read without its mesh."""

    aligned: bool = False
    landmarks: int = 0


def progress_of(limb_file: Path) -> LimbProgress:
    """How far the work on a limb is, by its limb file.

    Raises:
        ShapeFileError: it cannot be understood.
    """
    try:
        tree = json_of(read_content(limb_file, _LARGEST_BYTES, ShapeFileError))
        kept = value_of(tree, _LimbFile, strictness=_AS_WRITTEN)
    except ValueError as error:
        raise _unreadable(limb_file, error) from error
    return LimbProgress(aligned=kept.limb_from_mesh is not None, landmarks=len(kept.landmarks))


def limb_file_for(mesh_path: Path) -> Path:
    """The path to write a mesh's limb file to: never over that of another mesh that exists.

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


def require_usable_names(limb: Limb) -> None:
    """Refuse landmarks by whose names no limb file could be read.

    Raises:
        ExportError: a name is empty, too long, or has letters that cannot be printed.
    """
    for mark in limb.landmarks:
        if not _is_usable(mark.name):
            raise ExportError(
                "export.limb.landmark_name", landmark=mark.name[:_LONGEST_NAME], most=_LONGEST_NAME
            )


def _is_usable(name: str) -> bool:
    return 0 < len(name) <= _LONGEST_NAME and name.isprintable()


def encode_record(limb: Limb, mesh_name: str, mesh_hash: str, mm_per_unit: float) -> bytes:
    """The limb file of a limb whose mesh lies in the named file."""
    motion = limb.known_limb_from_mesh
    tree = {
        "format": _FORMAT,
        "version": _VERSION,
        "mesh": {"file": mesh_name, "sha256": mesh_hash, "mm_per_unit": mm_per_unit},
        "kind": limb.kind,
        "side": None if motion is None else limb.side,
        "limb_from_mesh": None if motion is None else _tree(motion),
        "sock_mm": limb.sock_mm,
        "doubt": "" if limb.doubt is None else as_json(limb.doubt),
        "landmarks": [
            {
                "name": mark.name,
                "position_mm": mark.position_mm.tolist(),
                "placed": mark.placed,
                "sigma_mm": mark.sigma_mm,
                **({} if mark.confirmed else {"confirmed": False}),
            }
            for mark in limb.landmarks
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
    """Read a limb file; None if there is none.

    Raises:
        ShapeFileError: it belongs to another mesh, or cannot be understood.
    """
    if not path.is_file():
        return None
    try:
        tree = json_of(read_content(path, _LARGEST_BYTES, ShapeFileError))
        owner = value_of(tree, _Head, strictness=_AS_WRITTEN).mesh
        if owner.sha256 == mesh_hash:
            return _record(value_of(tree, _LimbFile, strictness=_AS_WRITTEN))
    except ValueError as error:
        raise _unreadable(path, error) from error
    if owner.file != mesh_path.name and (mesh_path.parent / Path(owner.file).name).is_file():
        return OfAnother(Path(owner.file).name)
    raise ShapeFileError(
        "file.limb.of_another", name=path.name, owner=owner.file[:80], shape=mesh_path.name
    )


def _unreadable(path: Path, error: ValueError) -> ShapeFileError:
    return ShapeFileError("file.limb.unread", name=path.name, why=reason_of(error))


def _record(file: _LimbFile) -> LimbRecord:
    if len(file.landmarks) > _MOST_LANDMARKS:
        raise ContentError("file.limb.landmark_count", landmarks=len(file.landmarks))
    if len(file.made_from) > _MOST_ORIGINS:
        raise ContentError("file.limb.origin_count", files=len(file.made_from))
    if not 0 <= file.sock_mm < _THICKEST_SOCK_MM:
        raise ContentError("file.limb.length", field="sock_mm")
    landmarks = tuple(_landmark(mark) for mark in file.landmarks)
    if len({mark.name for mark in landmarks}) < len(landmarks):
        raise ContentError("file.limb.landmark_twice")
    return LimbRecord(
        mm_per_unit=_unit(file.mesh.mm_per_unit),
        landmarks=landmarks,
        frame=_frame(file),
        sock_mm=file.sock_mm,
        kind=file.kind,
        made_from=tuple(
            Origin(
                sha256=one.sha256,
                mm_per_unit=_unit(one.mm_per_unit),
                mesh_from_origin=_motion(one.mesh_from_it, "mesh_from_it"),
            )
            for one in file.made_from
        ),
        doubt=file.doubt and file.doubt.with_texts(lambda text: text[:_LONGEST_DOUBT]),
    )


def _unit(mm_per_unit: float) -> float:
    if not mm_per_unit > 0:
        raise ContentError("file.limb.length", field="mm_per_unit")
    return mm_per_unit


def _landmark(mark: _Mark) -> Landmark:
    if not _is_usable(mark.name):
        raise ContentError("file.limb.landmark_name")
    if mark.sigma_mm is not None and not 0 <= mark.sigma_mm < _LARGEST_PLACING_MM:
        raise ContentError("file.limb.length", field="sigma_mm")
    return Landmark(
        name=mark.name,
        position_mm=np.array(mark.position_mm),
        placed=mark.placed,
        sigma_mm=mark.sigma_mm,
        confirmed=mark.confirmed,
    )


def _frame(file: _LimbFile) -> LimbFrame | None:
    if file.limb_from_mesh is None:
        return None
    if file.side is None:
        raise ContentError("file.limb.no_side")
    motion = _motion(file.limb_from_mesh, "limb_from_mesh")
    return LimbFrame(limb_from_mesh=motion, side=file.side)


def _motion(motion: _Motion, name: str) -> Rigid:
    rotation = np.array(motion.rotation)
    turned = np.abs(rotation @ rotation.T - np.eye(3)).max() > _ROUNDING
    if turned or np.linalg.det(rotation) < 0:
        raise ContentError("file.limb.rotation", field=name)
    return Rigid(rotation, np.array(motion.translation_mm))
