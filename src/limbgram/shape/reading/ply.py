"""PLY, text and binary, ours (filled, sigma) and that of other programs.

The header lists elements, each with its properties; only vertices and faces are used.
"""

from dataclasses import dataclass, field, replace
from itertools import accumulate

import numpy as np

from limbgram.errors import ShapeFileError
from limbgram.shape.reading.obj import fans_of
from limbgram.shape.reading.soup import Soup
from limbgram.shape.reading.stl import stated_unit
from limbgram.surface.mesh import Mesh

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


@dataclass
class _Element:
    name: str
    count: int
    columns: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])
    """Names and types of single values."""
    lists: list[tuple[str, str, str]] = field(default_factory=list[tuple[str, str, str]])
    """Names, count types and value types; only faces have them, and only one is understood."""


@dataclass
class _Header:
    order: str
    elements: list[_Element]


def read_ply(content: bytes, name: str) -> Soup:
    """The surface with colours, filled marks and sigmas where the file has them."""
    head, mark, body = content.partition(b"end_header")
    body = body[2:] if body[:2] == b"\r\n" else body[1:]
    try:
        header = _header(head)
        if not mark or (not header.order and b"ascii" not in head):
            raise ValueError("its header has no end")
        vertices, polygons = _text(header, body) if not header.order else _binary(header, body)
        mesh = replace(_mesh(vertices, polygons), correlation_mm=_correlation(head))
    except (ValueError, KeyError, IndexError) as error:
        raise ShapeFileError(
            f"{name} is no PLY file that can be read ({error}). It may have been cut off on its "
            "way: copy it again, or export it as STL."
        ) from error
    return Soup(mesh=mesh, stated_unit=stated_unit(head))


def _header(head: bytes) -> _Header:
    header = _Header("", [])
    for line in head.decode("latin-1").splitlines():
        match line.split():
            case ["format", kind, _]:
                header.order = _ORDERS[kind]
            case ["element", name, number]:
                header.elements.append(_Element(name, int(number)))
            case ["property", "list", count, kind, name]:
                header.elements[-1].lists.append((name, _TYPES[count], _TYPES[kind]))
            case ["property", kind, name]:
                if header.elements[-1].lists:
                    raise ValueError("values behind a list")
                header.elements[-1].columns.append((name, _TYPES[kind]))
            case _:
                pass
    if [element.name for element in header.elements[:2]] != ["vertex", "face"]:
        raise ValueError("its elements do not begin with vertices and faces")
    vertex, face = header.elements[:2]
    if vertex.lists or len(face.lists) != 1 or min(vertex.count, face.count) < 1:
        raise ValueError("its vertices or faces are not of the usual form")
    return header


_Read = tuple[np.ndarray, list[list[int]] | np.ndarray]


def _binary(header: _Header, body: bytes) -> _Read:
    vertex, face = header.elements[:2]
    layout = np.dtype([(name, header.order + kind) for name, kind in vertex.columns])
    size = vertex.count * layout.itemsize
    rows = np.frombuffer(body[:size], layout)
    if len(rows) != vertex.count:
        raise ValueError("the file ends among the vertices")
    leading = [(name, header.order + kind) for name, kind in face.columns]
    (_, count_kind, kind) = face.lists[0]
    head = np.dtype([*leading, ("count", header.order + count_kind)])
    of_three = np.dtype([*head.descr, ("corners", header.order + kind, 3)])
    rest = body[size:]
    if len(rest) >= face.count * of_three.itemsize:
        triangles = np.frombuffer(rest, of_three, face.count)
        if (triangles["count"] == 3).all():
            return rows, triangles["corners"].astype(np.int64)
    return rows, _polygons(rest, face.count, head, np.dtype(header.order + kind))


def _polygons(rest: bytes, count: int, head: np.dtype, kind: np.dtype) -> list[list[int]]:
    """Faces of different numbers of corners: each tells where the next begins."""

    def corners_at(place: int) -> int:
        return int(np.frombuffer(rest, head, 1, place)["count"][0])

    def after(place: int, _face: int) -> int:
        return place + head.itemsize + corners_at(place) * kind.itemsize

    places = list(accumulate(range(count), after, initial=0))
    if places[-1] > len(rest):
        raise ValueError("the file ends among the faces")
    return [
        np.frombuffer(rest, kind, corners_at(place), place + head.itemsize).tolist()
        for place in places[:-1]
    ]


def _text(header: _Header, body: bytes) -> _Read:
    vertex, face = header.elements[:2]
    lines = body.split(b"\n")
    lines = [line for line in lines if line.strip()]
    if len(lines) < vertex.count + face.count:
        raise ValueError(f"{len(lines)} lines of {vertex.count + face.count}")
    layout = np.dtype([(name, kind) for name, kind in vertex.columns])
    numbers = np.array(b" ".join(lines[: vertex.count]).split(), np.float64)
    table = numbers.reshape(vertex.count, len(vertex.columns))
    wide = np.dtype([(name, "f8" if kind[0] == "f" else kind) for name, kind in vertex.columns])
    rows = np.zeros(vertex.count, wide)
    for idx, name in enumerate(layout.names or ()):
        rows[name] = table[:, idx]
    skipped = len(face.columns)
    words = [line.split()[skipped:] for line in lines[vertex.count : vertex.count + face.count]]
    return rows, [[int(word) for word in corners[1 : 1 + int(corners[0])]] for corners in words]


def _mesh(rows: np.ndarray, polygons: list[list[int]] | np.ndarray) -> Mesh:
    names: tuple[str, ...] = rows.dtype.names or ()
    if isinstance(polygons, list):
        faces = fans_of(polygons)
    else:
        if len(polygons) and not 0 <= polygons.min() <= polygons.max() < 2**31:
            raise ValueError("a face names a vertex that cannot be")
        faces = polygons.astype(np.int32)
    colours = None
    if {"red", "green", "blue"} <= set(names) and rows.dtype["red"].itemsize == 1:
        colours = np.column_stack([rows[name] for name in ("red", "green", "blue")])
    return Mesh(
        vertices_mm=np.column_stack([rows[axis] for axis in "xyz"]).astype(np.float64),
        faces=faces,
        colours=colours,
        filled=rows["filled"].astype(np.bool_) if "filled" in names else None,
        sigma_mm=rows["sigma"].astype(np.float32) if "sigma" in names else None,
        shared_mm=_shared(rows, names),
    )


def _shared(rows: np.ndarray, names: tuple[str, ...]) -> np.ndarray | None:
    """Columns shared_0, shared_1, ... as our own files have them."""
    parts = [rows[name] for k in range(len(names)) if (name := f"shared_{k}") in names]
    return np.column_stack(parts).astype(np.float32) if parts else None


def _correlation(head: bytes) -> float | None:
    """What the comment of our own files says."""
    for line in head.decode("latin-1").splitlines():
        match line.split():
            case ["comment", "sigma", "is", "alike", "over:", length]:
                return float(length)
            case _:
                pass
    return None
