"""PLY: the surface or the cloud, with colours, filled marks, sigmas and shared errors.

The header lists elements, each with its properties; only vertices and faces are used. The data must
match its counts to the last byte: a reader that took what it found would silently lose faces of a
damaged file. Text and binary are read, with polygons of any size; the writer gives little-endian
binary.

Own code: trimesh 5.2 refuses a whole binary file of triangles and quads; of 300 damaged text
files it reads 82 as another shape without a word, this reader 19; of binary ones 18 and 9
(benchmarks/results/formats.json).
"""

import math
import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from jaxtyping import Shaped

from limbgram.core.errors import ExportError, ShapeFileError, reason_of
from limbgram.core.files import ContentError, other, other_count, require, without_mark, write_file
from limbgram.core.geometry.arrays import Faces
from limbgram.core.mesh.mesh import VERTEX_FIELDS, Cloud, Mesh
from limbgram.core.mesh.vertex_fields import VertexField
from limbgram.findings import fault
from limbgram.formats.format import Format
from limbgram.formats.triangle_soup import Soup, fans_of, of_polygons, require_corners
from limbgram.formats.units import stated_unit
from limbgram.formats.writing import Unit, require_same_triangles, single_precision, target

_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_WRITTEN = {
    np.dtype(_TYPES[name]).newbyteorder("<").str: name for name in ("float", "uchar", "ushort")
}
"""PLY names of the types that are written."""
_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
"""A written face: a list of uchar and int."""
_COLOUR = ("red", "green", "blue")
_QUALITY = "quality"
"""CloudCompare shows properties that begin with scalar_, MeshLab shows quality: sigma has both
names. MeshLab's colour scale takes no NaN, so there -1 stands for a vertex without sigma."""
_KINDS = {"colour": "u1", "mark": "u1", "number": "<f4"}
"""Types in which vertex fields are written."""


class _Property(NamedTuple):
    name: str
    kind: str
    """Type of its value, or of each value of a list."""
    counted: str | None = None
    """Type of the number of values that a list begins with; None for a single value."""


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list[_Property])

    @property
    def has_lists(self) -> bool:
        return any(one.counted for one in self.properties)

    @property
    def corners_at(self) -> int:
        """Number of the property that lists the corners of a face: the first list."""
        return next(k for k, one in enumerate(self.properties) if one.counted)


@dataclass
class _Header:
    order: str
    elements: list[_Element]


def read_ply(content: bytes, name: str) -> Soup:
    """The surface with colours, filled marks and sigmas where the file has them."""
    head, mark, body = without_mark(content).partition(b"end_header")
    try:
        if not mark:
            raise ContentError("file.ply.header_without_end")
        header = _header(head)
        _require_surface(header)
        end = re.match(rb"[ \t]*(\r\n|\r|\n)", body)
        if end is None:
            raise ContentError("file.ply.header_without_end")
        body = body[end.end() :]
        vertices, polygons = _text(header, body) if not header.order else _binary(header, body)
        mesh = replace(_mesh(vertices, polygons), correlation_mm=_correlation(head))
    except (ValueError, KeyError, IndexError) as error:
        strange = isinstance(error, KeyError)
        why = fault("file.ply.word", word=str(error.args[0])) if strange else reason_of(error)
        raise ShapeFileError("file.ply.unread", name=name, why=why) from error
    notes = of_polygons(mesh.faces, len(polygons))
    return Soup(mesh=mesh, stated_unit=stated_unit(head), notes=notes)


def write_ply(mesh: Mesh, path: Path | str, unit: Unit, *, unscaled: bool = False) -> Path:
    """Write the mesh with all its vertex fields, and read it back."""
    columns = dict(zip("xyz", mesh.vertices_mm.T.astype("<f4")))
    for name, one in VERTEX_FIELDS.items():
        values = getattr(mesh, name)
        if values is not None:
            columns |= _columns(one, values)
        if name == "sigma_mm" and values is not None:
            columns[_QUALITY] = np.where(np.isnan(values), -1.0, values).astype("<f4")
    path = target(path, unit, unscaled=unscaled)
    rows, faces = _rows(columns), face_rows(mesh.faces)

    def encode(stream: BinaryIO) -> None:
        stream.write(_encoded_header(rows, len(faces), unit, mesh.correlation_mm))
        stream.write(rows.tobytes() + faces.tobytes())

    def check(written: Path) -> None:
        read_rows, corners = _read_back(written)
        require(read_rows.tobytes() == rows.tobytes(), other(path.name, "vertices"))
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
        stream.write(_encoded_header(rows, 0, unit))
        stream.write(rows.tobytes())

    def check(written: Path) -> None:
        read_rows, _ = _read_back(written)
        require(read_rows.dtype == rows.dtype, other(path.name, "columns"))
        count = len(read_rows)
        require(count == len(cloud), other_count(path.name, "points", count, len(cloud)))
        require(read_rows.tobytes() == rows.tobytes(), other(path.name, "points"))

    return write_file(path, encode, check)


def _header(head: bytes) -> _Header:
    order: str | None = None
    elements: list[_Element] = []
    lines = _header_lines(head)
    if lines[0].strip() != "ply":
        raise ContentError("file.ply.beginning")
    for line in lines[1:]:
        match line.split():
            case ["format", kind, "1.0"] if order is None:
                order = _ORDERS[kind]
            case ["element", name, number]:
                elements.append(_Element(name, _counted(number)))
            case ["property", "list", count, kind, name]:
                if _TYPES[count][0] == "f":
                    raise ContentError("file.ply.list_of_fractions")
                elements[-1].properties.append(_Property(name, _TYPES[kind], _TYPES[count]))
            case ["property", kind, name]:
                elements[-1].properties.append(_Property(name, _TYPES[kind]))
            case [] | ["comment", *_] | ["obj_info", *_]:
                pass
            case _:
                raise ContentError("file.ply.header", line=line[:40])
    if order is None:
        raise ContentError("file.ply.order")
    return _Header(order, elements)


def _header_lines(head: bytes) -> list[str]:
    """The header's lines; comments may have letters of any encoding."""
    return re.split(r"\r\n|\r|\n", head.decode("latin-1"))


def _counted(word: str) -> int:
    if not re.fullmatch(r"\d{1,10}", word):
        raise ContentError("file.ply.element_count", found=word[:20])
    return int(word)


def _require_surface(header: _Header) -> None:
    """Refuse a header without vertices, or without faces that list them."""
    if [element.name for element in header.elements[:2]] != ["vertex", "face"]:
        raise ContentError("file.ply.elements")
    vertex, face = header.elements[:2]
    if vertex.has_lists or not face.has_lists or min(vertex.count, face.count) < 1:
        raise ContentError("file.ply.form")
    if face.properties[face.corners_at].kind[0] == "f":
        raise ContentError("file.ply.vertex_in_fractions")


_Read = tuple[np.ndarray, list[list[int]] | np.ndarray]


def _binary(header: _Header, body: bytes) -> _Read:
    vertex, face, *others = header.elements
    rows = _vertex_rows(header, body)
    if len(rows) != vertex.count:
        raise ContentError("file.ply.ends_in_vertices")
    rest = body[rows.nbytes :]
    rows_of_faces = _FaceRows(rest, face, header.order)
    if face.count * rows_of_faces.least_bytes > len(rest):
        raise ContentError("file.ply.ends_in_faces")
    found = rows_of_faces.triangles() or rows_of_faces.polygons(vertex.count)
    _require_end(rest[found.end :], others)
    return rows, found.corners


def _vertex_rows(header: _Header, body: bytes) -> Shaped[np.ndarray, " n"]:
    """One record a vertex, as many as there are."""
    vertex = header.elements[0]
    layout = np.dtype([(one.name, header.order + one.kind) for one in vertex.properties])
    return np.frombuffer(body[: vertex.count * layout.itemsize], layout)


def _require_end(left: bytes, others: list[_Element]) -> None:
    """Refuse a file whose data after the faces do not match its header."""
    if any(element.has_lists for element in others):
        return  # the lists would have to be read to know their length
    wanted = sum(
        other.count * sum(np.dtype(one.kind).itemsize for one in other.properties)
        for other in others
    )
    if len(left) < wanted or left[wanted:].strip():
        raise ContentError("file.ply.behind_faces", bytes=len(left), wanted=wanted)


class _Polygons(NamedTuple):
    corners: list[list[int]] | np.ndarray
    end: int
    """Offset of the first byte after the last face."""


@dataclass(frozen=True)
class _FaceRows:
    """The faces of a binary file, which may have other lists and values beside their corners."""

    content: bytes
    face: _Element
    order: str

    @property
    def least_bytes(self) -> int:
        """Bytes of a face all of whose lists are empty."""
        return sum(np.dtype(one.counted or one.kind).itemsize for one in self.face.properties)

    def triangles(self) -> _Polygons | None:
        """All faces at once; None unless they are triangles, the other lists alike in length."""
        lengths = [len(values) for values in self._row(0)[0]]
        at, fields = self.face.corners_at, list[tuple[Any, ...]]()
        for number, one in enumerate(self.face.properties):
            if one.counted:
                fields.append((f"count {number}", self.order + one.counted))
            shape = (lengths[number],) if one.counted else ()
            fields.append((f"value {number}", self.order + one.kind, shape))
        layout = np.dtype(fields)
        end = self.face.count * layout.itemsize
        if lengths[at] != 3 or end > len(self.content):
            return None
        rows = np.frombuffer(self.content, layout, self.face.count)
        for number, one in enumerate(self.face.properties):
            if one.counted and (rows[f"count {number}"] != lengths[number]).any():
                return None
        return _Polygons(rows[f"value {at}"].astype(np.int64), end)

    def polygons(self, vertices: int) -> _Polygons:
        """Faces one by one, each with as many corners as it says.

        vertices: Number of vertices in the file.
        """
        corners: list[list[int]] = []
        place, at = 0, self.face.corners_at
        for _ in range(self.face.count):
            values, place = self._row(place)
            require_corners(len(values[at]), vertices)
            corners.append(values[at].tolist())
        return _Polygons(corners, place)

    def _row(self, place: int) -> tuple[list[np.ndarray], int]:
        """The values of one face, and where the next one begins."""
        found: list[np.ndarray] = []
        for number, one in enumerate(self.face.properties):
            length = 1
            if one.counted:
                length = int(self._values(one.counted, 1, place)[0])
                place += np.dtype(one.counted).itemsize
            if length < (3 if number == self.face.corners_at else 0):
                raise ContentError("file.ply.face", corners=length)
            found.append(self._values(one.kind, length, place))
            place += found[-1].nbytes
        return found, place

    def _values(self, kind: str, length: int, place: int) -> np.ndarray:
        if place + length * np.dtype(kind).itemsize > len(self.content):
            raise ContentError("file.ply.ends_in_faces")
        return np.frombuffer(self.content, self.order + kind, length, place)


def _text(header: _Header, body: bytes) -> _Read:
    vertex, face = header.elements[:2]
    lines = [line for line in body.splitlines() if line.strip()]
    wanted = sum(element.count for element in header.elements)
    if len(lines) != wanted:
        raise ContentError("file.ply.lines", lines=len(lines), wanted=wanted)
    columns = [(one.name, one.kind) for one in vertex.properties]
    words = [line.split(None, len(columns)) for line in lines[: vertex.count]]
    if any(len(row) != len(columns) for row in words):
        raise ContentError("file.ply.vertex_numbers")
    table = np.array(words, np.float64)
    wide = np.dtype([(name, "f8" if kind[0] == "f" else kind) for name, kind in columns])
    rows = np.zeros(vertex.count, wide)
    for idx, (name, kind) in enumerate(columns):
        column = table[:, idx]
        if kind[0] != "f":
            _require_whole(column, kind, name)
        rows[name] = column
    faces = lines[vertex.count : vertex.count + face.count]
    return rows, [_corners_in(line, face, vertex.count) for line in faces]


def _corners_in(line: bytes, face: _Element, vertices: int) -> list[int]:
    """The corners in the line of a face, whose other values and lists are passed over."""
    values: list[list[bytes]] = []
    for number, one in enumerate(face.properties):
        length = 1
        if one.counted:
            (counted,), line = _words_taken(line, 1)
            length = int(counted)
        if length < (3 if number == face.corners_at else 0):
            raise ContentError("file.ply.face_count")
        if number == face.corners_at:
            require_corners(length, vertices)
        taken, line = _words_taken(line, length)
        values.append(taken)
    if line:
        raise ContentError("file.ply.face_count")
    return [int(word) for word in values[face.corners_at]]


def _words_taken(line: bytes, number: int) -> tuple[list[bytes], bytes]:
    """So many words of a line, and what follows them."""
    words = line.split(None, number)
    if len(words) < number:
        raise ContentError("file.ply.face_numbers")
    return words[:number], words[number] if len(words) > number else b""


def _require_whole(column: np.ndarray, kind: str, name: str) -> None:
    limits = np.iinfo(kind)
    within = (column >= limits.min) & (column <= limits.max) & (column == np.floor(column))
    if not within.all():
        raise ContentError("file.ply.value", column=name)


def _mesh(rows: np.ndarray, polygons: list[list[int]] | np.ndarray) -> Mesh:
    names: tuple[str, ...] = rows.dtype.names or ()
    if isinstance(polygons, list):
        faces = fans_of(polygons)
    else:
        if len(polygons) and not 0 <= polygons.min() <= polygons.max() < 2**31:
            raise ContentError("file.face.vertex")
        faces = polygons.astype(np.int32)
    known: dict[str, Any] = {name: _field(one, rows, names) for name, one in VERTEX_FIELDS.items()}
    places = np.column_stack([rows[axis] for axis in "xyz"]).astype(np.float64)
    return Mesh(vertices_mm=places, faces=faces, **known)


def _columns(one: VertexField, values: np.ndarray) -> dict[str, np.ndarray]:
    """A vertex field as columns of the file."""
    parts = values.reshape(len(values), -1).astype(_KINDS[one.kind]).T
    names = [f"{one.columns[0]}{k}" for k in range(len(parts))] if one.counted else one.columns
    return dict(zip(names, parts, strict=True))


def _field(one: VertexField, rows: np.ndarray, names: tuple[str, ...]) -> np.ndarray | None:
    """A vertex field from its columns; None where the file has none."""
    columns = _columns_of(one, names)
    if not columns or (one.kind == "colour" and any(rows.dtype[k] != np.uint8 for k in columns)):
        return None
    parts = [rows[column] for column in columns]
    if one.kind == "mark":
        if not np.isin(parts, (0, 1)).all():
            raise ContentError("file.ply.mark", column=columns[0])
        parts = [part.astype(np.bool_) for part in parts]
    elif one.kind == "number":
        parts = [part.astype(np.float32) for part in parts]
        least = one.least or [-np.inf] * len(parts)
        for column, part, low in zip(columns, parts, least, strict=True):
            told = np.isfinite(part) | (np.isnan(part) & (not one.known_everywhere))
            if not told.all() or (part < low).any():
                bound = float(low) if math.isfinite(low) else None
                raise ContentError("file.ply.number", column=column, least=bound)
    return parts[0] if one.flat else np.column_stack(parts)


def _columns_of(one: VertexField, names: tuple[str, ...]) -> list[str]:
    """The columns of a field that a file has; none where it lacks one of them."""
    if one.counted:
        counted = (f"{one.columns[0]}{k}" for k in range(len(names)))
        return [name for name in counted if name in names]
    found = (all_of for all_of in (one.columns, one.older) if all_of and set(all_of) <= set(names))
    return list(next(found, ()))


def _correlation(head: bytes) -> float | None:
    """The correlation length in a comment written by this program."""
    for line in _header_lines(head):
        match line.split():
            case ["comment", "sigma", "is", "alike", "over:", length]:
                value = float(length)
                if not (math.isfinite(value) and value > 0):
                    raise ContentError("file.ply.correlation", length=length[:20])
                return value
            case _:
                pass
    return None


def _rows(columns: dict[str, np.ndarray]) -> Shaped[np.ndarray, " n"]:
    """One record a vertex."""
    layout = np.dtype([(name, values.dtype.str) for name, values in columns.items()])
    rows = np.zeros(len(columns["x"]), layout)
    for name, values in columns.items():
        rows[name] = values
    return rows


def face_rows(faces: Faces) -> Shaped[np.ndarray, " f"]:
    """Triangles as the records of a file."""
    rows = np.zeros(len(faces), _FACE)
    rows["count"] = 3
    rows["corners"] = faces
    return rows


def _encoded_header(
    rows: Shaped[np.ndarray, " n"], faces: int, unit: str, correlation: float | None = None
) -> bytes:
    names: tuple[str, ...] = rows.dtype.names or ()
    lines = ["ply", "format binary_little_endian 1.0", f"comment limbgram, unit: {unit}"]
    if correlation is not None:
        lines.append(f"comment sigma is alike over: {correlation!r}")
    lines.append(f"element vertex {len(rows)}")
    lines += [f"property {_WRITTEN[rows.dtype[name].str]} {name}" for name in names]
    if faces:
        lines += [f"element face {faces}", "property list uchar int vertex_indices"]
    return "\n".join([*lines, "end_header\n"]).encode("ascii")


def _read_back(path: Path) -> tuple[Shaped[np.ndarray, " n"], np.ndarray]:
    """Vertex records and face corners of a file that this program wrote."""
    try:
        return read_records(path.read_bytes())
    except ContentError as error:
        raise ExportError("export.read_back", found=other(path.name, "bytes")) from error


def read_records(content: bytes) -> tuple[Shaped[np.ndarray, " n"], Shaped[np.ndarray, "f 3"]]:
    """Vertex records and face corners of a little-endian binary file with triangles only.

    Raises:
        ContentError: the data do not match the header's counts, or there are other faces.
    """
    head, _, body = content.partition(b"end_header\n")
    header = _header(head)
    rows = _vertex_rows(header, body)
    count = sum(element.count for element in header.elements[1:])
    left = len(body) - rows.nbytes
    if len(rows) != header.elements[0].count:
        raise ContentError("file.ply.ends_in_vertices")
    if left != count * _FACE.itemsize:
        raise ContentError("file.ply.behind_faces", bytes=left, wanted=count * _FACE.itemsize)
    faces = np.frombuffer(body[rows.nbytes :], _FACE)
    if (faces["count"] != 3).any():
        raise ContentError("file.ply.form")
    return rows, faces["corners"]


FORMAT = Format(
    suffix=".ply",
    place=30,
    used_for={"en": "with colours and sureness", "de": "mit Farben und Sicherheit"},
    read=read_ply,
    write=write_ply,
    keeps=frozenset({"colours", "filled", "sigma", "shared errors", "lost length"}),
    within_mm=1e-4,
)
