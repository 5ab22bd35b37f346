"""A limb on disk: its mesh, and the limb file beside it with landmarks, frame, side and sock."""

from pathlib import Path

import numpy as np

from limbgram.core.errors import ExportError
from limbgram.core.files import other, require, write_bytes
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.formats.reading import read_mesh
from limbgram.formats.sidecar import (
    LimbRecord,
    encode_record,
    hash_of,
    limb_file_for,
    read_record,
    require_usable_names,
)
from limbgram.formats.table import FORMATS, format_of
from limbgram.workbench.limb import Limb

_SAME_PLACE_MM = 1e-3
_SAME_VOLUME = 1e-4


def write_limb(limb: Limb, path: Path | str) -> Path:
    """Write the mesh by the path's ending, in the mesh's frame, and the limb file beside it.

    The limb's origins are recorded as those of the new file.
    """
    path = Path(path)
    kind = format_of(path)
    if kind is None or kind.write is None or not kind.holds_limbs:
        known = tuple(one.name.upper() for one in FORMATS if one.holds_limbs)
        raise ExportError("export.limb.kind", name=path.name, known=known)
    require_usable_names(limb)
    if kind.write_marked is not None and limb.landmarks:
        written = kind.write_marked(limb.mesh, path, limb.landmarks)
    else:
        written = kind.write(limb.mesh, path, "mm")
    # The mesh first: if the program is ended in between, the older limb file does not fit its hash.
    _write_record(limb, written, hash_of(written.read_bytes()), kind.mm_per_unit)
    return written


def write_limb_file(
    limb: Limb, mesh_path: Path | str, *, mm_per_unit: float = 1.0, sha256: str | None = None
) -> Path:
    """Write the limb file beside a mesh's file that is there already.

    Args:
        mm_per_unit: Millimetres in one unit of the mesh's file.
        sha256: Of that file when the limb's mesh was read from it; saves reading the mesh again.

    Raises:
        ExportError: that file does not hold this limb's mesh.
    """
    require_usable_names(limb)
    mesh_path = Path(mesh_path)
    mesh_hash = hash_of(mesh_path.read_bytes())
    if sha256 is not None and sha256 != mesh_hash:
        raise ExportError("export.limb.changed", name=mesh_path.name)
    if sha256 is None and not _same_surface(read_mesh(mesh_path, mm_per_unit), limb.mesh):
        raise ExportError("export.limb.other_surface", name=mesh_path.name)
    return _write_record(limb, mesh_path, mesh_hash, mm_per_unit)


def _write_record(limb: Limb, mesh_path: Path, mesh_hash: str, mm_per_unit: float) -> Path:
    path = limb_file_for(mesh_path)
    content = encode_record(limb, mesh_path.name, mesh_hash, mm_per_unit)

    def check(written: Path) -> None:
        record = read_record(written, mesh_path, mesh_hash)
        again = None
        if isinstance(record, LimbRecord):
            read = Limb(
                mesh=limb.mesh,
                landmarks=record.landmarks,
                sock_mm=record.sock_mm,
                kind=record.kind,
                doubt=record.doubt,
                origins=record.made_from,
            )
            if record.frame is not None:
                read = read.with_frame(record.frame)
            again = encode_record(read, mesh_path.name, mesh_hash, record.mm_per_unit)
        require(again == content, other(path.name, "record"))

    return write_bytes(path, content, check)


def _same_surface(one: Mesh, other: Mesh) -> bool:
    """Whether two meshes have the same bounding box and volume; their vertices may be reordered."""
    boxes = [np.array([m.vertices_mm.min(0), m.vertices_mm.max(0)]) for m in (one, other)]
    volumes_mm3 = [volume_mm3(m) for m in (one, other)]
    same_box = np.abs(boxes[0] - boxes[1]).max() <= _SAME_PLACE_MM
    change_mm3 = abs(volumes_mm3[0] - volumes_mm3[1])
    return bool(same_box and change_mm3 <= _SAME_VOLUME * abs(volumes_mm3[1]) + 1.0)
