"""DXF, release 12, which carvers and old programs ask for: surface, sections and trimline.

Each has a layer, and the curves are 3D polylines. The surface is 3DFACEs, or polyface meshes, whose
faces share vertices. A polyface mesh has 16-bit counts, so a larger surface is split into several
meshes that touch. Release 12 has no field for the unit: a comment and the layer names state it.

Own code: ezdxf's r12writer writes no header and no layer table, which state the unit, and takes
6.5 s for 250,000 triangles; this writer takes 0.6 s with reading back
(benchmarks/results/formats.json).
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import BinaryIO

import numpy as np
from jaxtyping import Float64, Int16, Int64

from limbgram.core.files import other_count, require, write_file
from limbgram.core.geometry.arrays import Points3
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import with_faces
from limbgram.findings import fault
from limbgram.formats.curves import Curves, curves_of
from limbgram.formats.writing import Unit, require_same_triangles, target

_POLYFACE, _MESH_VERTEX, _MESH_FACE = 64, 192, 128
"""Flags (group code 70) of a polyface mesh, of its vertices, and of its faces."""
_CLOSED, _THREE_D, _THREE_D_VERTEX = 1, 8, 32
_CORNER_CODES = tuple(10 * axis + corner for corner in range(4) for axis in (1, 2, 3))
_NEWLINE, _MINUS, _POINT, _ZERO, _NINE = b"\n-.09"
_WORD_LETTERS = 8
_TOLERANCE = 1e-6
_FACES_PER_BLOCK = 5_000
_MOST_PER_MESH = 32_767
"""Largest number of vertices, or of faces, in one polyface mesh."""


@dataclass(frozen=True, kw_only=True)
class PolyfaceReport:
    """A written polyface file."""

    path: Path
    meshes: int
    """More than 1 where the surface had to be split."""
    curves: Curves


def write_r12_dxf(
    mesh: Mesh, path: Path | str, unit: Unit, *, spacing_mm: float = 10.0, unscaled: bool = False
) -> Path:
    """Write triangles, sections across z at multiples of `spacing_mm`, trimline; read all back."""
    path = target(path, unit, unscaled=unscaled)
    return write_triangles(mesh, path, unit, curves_of(mesh, spacing_mm))


def write_polyface_dxf(mesh: Mesh, path: Path, *, spacing_mm: float = 10.0) -> PolyfaceReport:
    """Write surface, sections across z at multiples of `spacing_mm`, trimline; read all back."""
    curves = curves_of(mesh, spacing_mm)
    parts, layer = _split(mesh), _surface_layer("mm")
    surface = chain.from_iterable(_polyface(with_faces(mesh, faces), layer) for faces in parts)
    ordered = Mesh(vertices_mm=mesh.vertices_mm, faces=np.concatenate(parts))
    write_drawing(path, "mm", surface, ordered, curves)
    return PolyfaceReport(path=path, meshes=len(parts), curves=curves)


def write_triangles(mesh: Mesh, path: Path, unit: str, curves: Curves) -> Path:
    """Write the surface as 3DFACEs, with the curves; read all back."""
    return write_drawing(path, unit, _faces(mesh, _surface_layer(unit)), mesh, curves)


def write_drawing(
    path: Path, unit: str, surface: Iterable[bytes], mesh: Mesh, curves: Curves
) -> Path:
    """Write the entities of a surface and its curves, and read them back.

    Args:
        mesh: The triangles of the surface in the order of its entities.
    """
    layers = (_surface_layer(unit), f"SECTIONS_{unit.upper()}", f"TRIMLINE_{unit.upper()}")
    trimline = curves.trimline or ()
    wanted = [*(section.points_mm for section in curves.sections), *trimline]

    def encode(stream: BinaryIO) -> None:
        stream.write(_header(unit, layers if trimline else layers[:2]))
        stream.writelines(surface)
        stream.writelines(
            _polyline(section.points_mm, layers[1], closed=section.closed)
            for section in curves.sections
        )
        stream.writelines(_polyline(loop, layers[2], closed=True) for loop in trimline)
        stream.write(_encoded_tags((0, "ENDSEC"), (0, "EOF")))

    def check(written: Path) -> None:
        read = _read_back(written, path.name)
        require_same_triangles(path.name, read.triangles, mesh, _TOLERANCE)
        _require_same_lines(path.name, read.polylines, wanted)

    return write_file(path, encode, check)


def _surface_layer(unit: str) -> str:
    return f"SURFACE_{unit.upper()}"


def _encoded_tags(*tags: tuple[int, str]) -> bytes:
    return "".join(f"{code}\n{value}\n" for code, value in tags).encode("ascii")


def _header(unit: str, layers: tuple[str, ...]) -> bytes:
    """Comment, header, layer table, and the beginning of the entities."""
    tags: list[tuple[int, str]] = [
        (999, f"limbgram, unit: {unit}"),
        (0, "SECTION"),
        (2, "HEADER"),
        (9, "$ACADVER"),
        (1, "AC1009"),
        (0, "ENDSEC"),
        (0, "SECTION"),
        (2, "TABLES"),
        (0, "TABLE"),
        (2, "LAYER"),
        (70, str(len(layers))),
    ]
    for colour, layer in enumerate(layers, 1):
        tags += [(0, "LAYER"), (2, layer), (70, "0"), (62, str(colour)), (6, "CONTINUOUS")]
    return _encoded_tags(*tags, (0, "ENDTAB"), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"))


def _faces(mesh: Mesh, layer: str) -> Iterator[bytes]:
    """3DFACEs of the triangles; the fourth corner repeats the third."""
    face = f"0\n3DFACE\n8\n{layer}\n" + "".join(f"{code}\n%s\n" for code in _CORNER_CODES)
    numbers = "%.6f " * mesh.vertices_mm.size % tuple(mesh.vertices_mm.ravel().tolist())
    places_mm = np.array(numbers.split(), object).reshape(-1, 3)
    for start in range(0, len(mesh.faces), _FACES_PER_BLOCK):
        corners = places_mm[mesh.faces[start : start + _FACES_PER_BLOCK][:, [0, 1, 2, 2]]]
        yield (face * len(corners) % tuple(corners.ravel().tolist())).encode("ascii")


def _split(mesh: Mesh) -> list[np.ndarray]:
    """The faces, sorted along z, in parts that one polyface mesh can number."""
    heights = mesh.vertices_mm[mesh.faces][:, :, 2].mean(1)
    rest = [mesh.faces[np.argsort(heights, kind="stable")]]
    parts: list[np.ndarray] = []
    while rest:
        faces = rest.pop(0)
        over = max(len(faces), len(np.unique(faces))) / _MOST_PER_MESH
        if over <= 1:
            parts.append(faces)
        else:
            rest = [*np.array_split(faces, int(np.ceil(over))), *rest]
    return parts


def _polyface(part: Mesh, layer: str) -> Iterator[bytes]:
    yield _encoded_tags(
        (0, "POLYLINE"),
        (8, layer),
        (66, "1"),
        (10, "0.0"),
        (20, "0.0"),
        (30, "0.0"),
        (70, str(_POLYFACE)),
        (71, str(len(part.vertices_mm))),
        (72, str(len(part.faces))),
    )
    place = f"0\nVERTEX\n8\n{layer}\n10\n%.6f\n20\n%.6f\n30\n%.6f\n70\n{_MESH_VERTEX}\n"
    yield (place * len(part.vertices_mm) % tuple(part.vertices_mm.ravel().tolist())).encode("ascii")
    face = (
        f"0\nVERTEX\n8\n{layer}\n10\n0.0\n20\n0.0\n30\n0.0\n70\n{_MESH_FACE}\n"
        "71\n%d\n72\n%d\n73\n%d\n"
    )
    yield (face * len(part.faces) % tuple((part.faces + 1).ravel().tolist())).encode("ascii")
    yield _encoded_tags((0, "SEQEND"), (8, layer))


def _polyline(points_mm: Points3, layer: str, *, closed: bool) -> bytes:
    """A 3D polyline; a closed one does not repeat its first point."""
    flags = _THREE_D + (_CLOSED if closed else 0)
    head = f"0\nPOLYLINE\n8\n{layer}\n66\n1\n10\n0.0\n20\n0.0\n30\n0.0\n70\n{flags}\n"
    vertex = f"0\nVERTEX\n8\n{layer}\n10\n%.6f\n20\n%.6f\n30\n%.6f\n70\n{_THREE_D_VERTEX}\n"
    points = vertex * len(points_mm) % tuple(points_mm.ravel())
    return f"{head}{points}0\nSEQEND\n8\n{layer}\n".encode("ascii")


def _require_same_lines(name: str, found: Sequence[Points3], wanted: Sequence[Points3]) -> None:
    """Refuse a file whose polylines are not those that were written."""
    require(len(found) == len(wanted), other_count(name, "curves", len(found), len(wanted)))
    for number, (polyline, points) in enumerate(zip(found, wanted, strict=True), 1):
        whole = polyline.shape == points.shape
        near = whole and np.allclose(polyline, points, rtol=0, atol=_TOLERANCE)
        require(near, fault("export.curve_elsewhere", name=name, curve=number))


@dataclass(frozen=True)
class _Drawing:
    triangles: Float64[np.ndarray, "f 3 3"]
    """Of 3DFACEs, then of polyface meshes."""
    polylines: list[Points3]


def _read_back(path: Path, name: str) -> _Drawing:
    tags = _Tags(name, *_tags(np.fromfile(path, np.uint8)))
    corners = tags.rows("3DFACE", *_CORNER_CODES).reshape(-1, 4, 3)
    three = bool((corners[:, 2] == corners[:, 3]).all())
    require(three, fault("export.four_corners", name=name))
    points, flags = tags.rows("VERTEX", 10, 20, 30), tags.rows("VERTEX", 70)[:, 0]
    joined = tags.rows("POLYLINE", 70)[:, 0] == _POLYFACE
    begun = tags.entities[tags.codes == 0]
    line_of = np.cumsum(begun == _word("POLYLINE"))[begun == _word("VERTEX")] - 1
    of_curve = ~joined[line_of]
    ends = np.searchsorted(line_of[of_curve], np.flatnonzero(~joined), "right")
    polylines = np.split(points[of_curve], ends)[:-1]
    # Faces of a polyface mesh count its vertices from 1.
    place = flags == _MESH_VERTEX
    first = np.searchsorted(line_of[place], line_of[flags == _MESH_FACE])
    idx = tags.rows("VERTEX", 71, 72, 73) - 1 + first[:, None]
    known = bool(((idx >= 0) & (idx < place.sum())).all())
    require(known, fault("export.no_vertices", name=name))
    triangles = np.concatenate([corners[:, :3], points[place][idx.astype(np.int64)]])
    return _Drawing(triangles, polylines)


@dataclass(frozen=True)
class _Tags:
    """Pairs of lines, a code and a value; code 0 begins an entity."""

    name: str
    codes: Int16[np.ndarray, " t"]
    numbers: Float64[np.ndarray, " t"]
    """NaN where the value is none."""
    entities: Int64[np.ndarray, " t"]
    """Name of the entity that each belongs to, as `_word` has it."""

    def rows(self, entity: str, *codes: int) -> Float64[np.ndarray, "n k"]:
        """Values under these codes, which must follow each other in this order."""
        asked = (self.entities == _word(entity)) & np.isin(self.codes, codes)
        found = self.codes[asked]
        times = len(found) // len(codes)
        in_order = np.array_equal(found, np.tile(np.array(codes, np.int16), times))
        require(in_order, fault("export.other_parts", name=self.name, entity=entity))
        return self.numbers[asked].reshape(-1, len(codes))


def _word(name: str) -> int:
    """Up to eight letters as one integer."""
    return int.from_bytes(name.encode("ascii"), "big")


@njit(cache=True, nogil=True)
def _tags(text: np.ndarray):
    """Of each pair of lines: code, numeric value or NaN, name of the entity that it belongs to."""
    lines = 0
    for letter in text:
        lines += letter == _NEWLINE
    codes = np.empty(lines // 2, np.int16)
    numbers, entities = np.empty(len(codes)), np.empty(len(codes), np.int64)
    at = entity = 0
    for tag in range(len(codes)):
        code, _, at = _value(text, at)
        number, word, at = _value(text, at)
        if code == 0:
            entity = word
        codes[tag] = -1 if np.isnan(code) else code
        numbers[tag], entities[tag] = number, entity
    return codes, numbers, entities


@njit(cache=True, nogil=True)
def _value(text: np.ndarray, start: int):
    """A line as a number (NaN if it is none) and as a word (0 if it has more than eight letters);
    and where the next line begins."""
    at, sign, number, share, word = start, 1.0, 0.0, 1.0, 0
    digits, after_point, plain = 0, False, True
    while text[at] != _NEWLINE:
        letter = text[at]
        word = word * 256 + letter if at < start + _WORD_LETTERS else 0
        if _ZERO <= letter <= _NINE:
            number = 10 * number + (letter - _ZERO)
            digits += 1
            if after_point:
                share *= 10
        elif letter == _POINT and not after_point:
            after_point = True
        elif letter == _MINUS and at == start:
            sign = -1.0
        else:
            plain = False
        at += 1
    return sign * number / share if plain and digits else np.nan, word, at + 1
