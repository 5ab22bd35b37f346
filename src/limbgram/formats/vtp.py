"""VTP: the surface for ParaView and pyvista, with sigma, filled marks, colours and normals.

VTK's XML file of polygons, its numbers as base64 between the tags, little-endian. What is known of
each vertex stands as point data, by which these programs colour; the unit stands in the field data.
Only written: a limb is kept as PLY, which has all of it.
"""

import base64
import struct
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from limbgram.core.files import other, require, write_bytes
from limbgram.core.mesh.mesh import Mesh, unsigned
from limbgram.formats.format import Format
from limbgram.formats.writing import Unit, require_same_triangles, target

_TYPES = {"f4": "Float32", "f8": "Float64", "i4": "Int32", "i8": "Int64", "u1": "UInt8"}
_DTYPES = {name: f"<{code}" for code, name in _TYPES.items()}
_HEADER = struct.Struct("<Q")
"""Number of bytes, before the numbers themselves."""


def write_vtp(mesh: Mesh, path: Path | str, unit: Unit, *, unscaled: bool = False) -> Path:
    """Write the surface with all point data, and read it back."""
    path = target(path, unit, unscaled=unscaled)
    points = dict(_point_data(mesh))

    def check(written: Path) -> None:
        read = {one.attrib["Name"]: one for one in ElementTree.parse(written).iter("DataArray")}
        places = _array(read["Points"]).reshape(-1, 3)
        faces = _array(read["connectivity"]).reshape(-1, 3)
        require_same_triangles(path.name, places[faces], mesh, 0.0)
        for name, values in points.items():
            same = np.array_equal(
                _array(read[name]), values.ravel(), equal_nan=values.dtype.kind == "f"
            )
            require(same, other(path.name, name))

    return write_bytes(path, b"".join(_lines(mesh, unit, points)), check)


def _point_data(mesh: Mesh) -> Iterator[tuple[str, np.ndarray]]:
    yield "Normals", mesh.vertex_normals().astype("<f4")
    for name, values in mesh.shown().items():
        yield name, unsigned(values)


def _lines(mesh: Mesh, unit: Unit, points: dict[str, np.ndarray]) -> Iterator[bytes]:
    sizes = f'NumberOfPoints="{len(mesh)}" NumberOfPolys="{len(mesh.faces)}"'
    scalars = ' Scalars="sigma_mm"' if "sigma_mm" in points else ""
    spelt = " ".join(str(ord(letter)) for letter in f"{unit}\0")
    yield (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
        "<PolyData>\n<FieldData>\n"
        '<DataArray type="String" Name="unit" NumberOfTuples="1" format="ascii">'
        f"{spelt}</DataArray>\n"
        f"</FieldData>\n<Piece {sizes}>\n"
        f'<PointData{scalars} Normals="Normals">\n'
    ).encode("ascii")
    for name, values in points.items():
        yield _data_array(name, values)
    yield b"</PointData>\n<Points>\n"
    yield _data_array("Points", mesh.vertices_mm.astype("<f8"))
    yield b"</Points>\n<Polys>\n"
    yield _data_array("connectivity", mesh.faces.astype("<i4").ravel())
    yield _data_array("offsets", 3 * np.arange(1, len(mesh.faces) + 1, dtype="<i4"))
    yield b"</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n"


def _data_array(name: str, values: np.ndarray) -> bytes:
    width = 1 if values.ndim == 1 else values.shape[1]
    kind = _TYPES[values.dtype.str[1:]]
    head = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}" format="binary">'
    body = base64.b64encode(_HEADER.pack(values.nbytes) + values.tobytes())
    return head.encode("ascii") + body + b"</DataArray>\n"


def _array(element: ElementTree.Element) -> np.ndarray:
    content = base64.b64decode(element.text or "")
    (size,) = _HEADER.unpack_from(content)
    return np.frombuffer(content[_HEADER.size :][:size], _DTYPES[element.attrib["type"]])


FORMAT = Format(
    suffix=".vtp",
    place=60,
    used_for={"en": "ParaView, pyvista", "de": "ParaView, pyvista"},
    write=write_vtp,
    keeps=frozenset({"colours", "filled", "sigma"}),
)
