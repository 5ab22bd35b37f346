"""STL: loose triangles, binary or text.

A binary file may begin with "solid": its length tells it from a text. A text is read completely or
refused: anything between its triangles but names of solids is damage, and a reader that ignored it
would silently lose triangles. The writer gives the binary form, with the unit in the header.

Own code: of 300 damaged binary files trimesh 5.2 reads 79 as another shape without a word, and
187 as no triangles at all; this reader 44, and none as empty. Of text files 63 and 16
(benchmarks/results/formats.json).
"""

import re
from pathlib import Path
from typing import BinaryIO

import numpy as np

from limbgram.core.errors import ShapeFileError, reason_of
from limbgram.core.files import without_mark, write_file
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.format import Format
from limbgram.formats.triangle_soup import Soup, triangles_merged
from limbgram.formats.units import stated_unit
from limbgram.formats.writing import Unit, require_same_triangles, single_precision, target

_HEADER_BYTES = 84
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_NUMBER = rb"\s+([-+.\deE]{1,40})"
_VERTEX = rb"\s+vertex" + 3 * _NUMBER
_FACET = re.compile(
    rb"facet\s+normal"
    + 3 * rb"\s+\S{1,40}"
    + rb"\s+outer\s+loop"
    + 3 * _VERTEX
    + rb"\s+endloop\s+endfacet(?=\s)",
    re.IGNORECASE,
)
_SOLID = re.compile(rb"(end)?solid\b.*", re.IGNORECASE)


def read_stl(content: bytes, name: str) -> Soup:
    """The triangles, equal corners merged; normals are ignored, the winding counts."""
    count = (
        int.from_bytes(content[80:_HEADER_BYTES], "little") if len(content) >= _HEADER_BYTES else -1
    )
    beyond = len(content) - _HEADER_BYTES - count * _RECORD.itemsize
    if count >= 0 and not beyond:
        records = np.frombuffer(content, _RECORD, offset=_HEADER_BYTES)
        corners = records["corners"].astype(np.float64)
        return Soup(mesh=triangles_merged(corners), stated_unit=stated_unit(content[:80]))
    text = without_mark(content)
    if text[:512].lstrip()[:5].lower() == b"solid":
        return Soup(mesh=triangles_merged(_text(text, name)))
    if len(content) < _HEADER_BYTES or b"\0" not in content:
        raise ShapeFileError("file.stl.other", name=name, bytes=len(content))
    if count > 0 and beyond > 0:
        raise ShapeFileError("file.stl.longer", name=name, triangles=count, bytes=beyond)
    fitting = (len(content) - _HEADER_BYTES) // _RECORD.itemsize
    raise ShapeFileError("file.stl.cut", name=name, promised=max(count, 0), room=max(fitting, 0))


def write_stl(mesh: Mesh, path: Path | str, unit: Unit, *, unscaled: bool = False) -> Path:
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


def _text(content: bytes, name: str) -> np.ndarray:
    """Corners of the triangles; between them stand only the names of solids."""
    found = _FACET.findall(content)
    rest = [line.strip() for line in _FACET.sub(b"\n", content).splitlines()]
    ended = rest and any(line.lower().startswith(b"endsolid") for line in rest[-5:])
    unknown = next((line for line in rest if line and not _SOLID.fullmatch(line)), None)
    if not found or (unknown is None and not ended):
        raise ShapeFileError("file.stl.endless", name=name, triangles=len(found))
    if unknown is not None:
        shown = unknown[:40].decode("ascii", "replace")
        raise ShapeFileError("file.stl.strange", name=name, found=shown)
    try:
        return np.array(found).astype(np.float64).reshape(-1, 3, 3)
    except ValueError as error:
        raise ShapeFileError("file.stl.corner", name=name, why=reason_of(error)) from error


FORMAT = Format(
    suffix=".stl",
    place=10,
    used_for={"en": "printer, other programs", "de": "Drucker, andere Programme"},
    read=read_stl,
    write=write_stl,
    within_mm=1e-4,
)
