"""DXF, release 12: surface as 3DFACEs, sections and trimline as 3D polylines, a layer for each.

Release 12 has no field for the unit: comments and layer names say it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import compress, islice
from pathlib import Path
from typing import BinaryIO

import numpy as np

from limbgram.export.writing import require, require_same_triangles, target, write_file
from limbgram.geometry.arrays import Points3
from limbgram.scale.metric import Scale
from limbgram.surface.mesh import Mesh
from limbgram.surface.sections import cut, heights_between
from limbgram.surface.topology import boundary_loops, is_edge_manifold, is_vertex_manifold

_PRECISION = 1e-6
_TAGS = 200_000
"""Read at once."""
_BLOCK = 5_000
_CLOSED, _THREE_D, _THREE_D_VERTEX = 1, 8, 32


def write_dxf(
    mesh: Mesh, path: Path, scale: Scale, *, spacing_mm: float = 10.0, unscaled: bool = False
) -> Path:
    """Write triangles, sections across z at multiples of `spacing_mm`, trimline; read all back."""
    path = target(path, scale, unscaled=unscaled)
    unit = scale.unit.upper()
    sections = cut(mesh, heights_between(mesh, spacing_mm).tolist())
    trimline = trimline_of(mesh)
    wanted = [*(section.points_mm for section in sections), *trimline]

    def encode(stream: BinaryIO) -> None:
        layers = (f"SURFACE_{unit}", f"SECTIONS_{unit}", f"TRIMLINE_{unit}")
        stream.write(opening_tags(scale.unit, layers if trimline else layers[:2]))
        stream.writelines(_faces(mesh, layers[0]))
        stream.writelines(
            polyline_tags(section.points_mm, layers[1], closed=section.closed)
            for section in sections
        )
        stream.writelines(polyline_tags(loop, layers[2], closed=True) for loop in trimline)
        stream.write(encoded_tags((0, "ENDSEC"), (0, "EOF")))

    def check(written: Path) -> None:
        read = _read(written)
        require_same_triangles(path.name, read.triangles, mesh, _PRECISION)
        require_same_lines(path.name, read.polylines, wanted)

    return write_file(path, encode, check)


def trimline_of(mesh: Mesh) -> list[Points3]:
    """The surface's open edges, the longest first: the brim, and holes if there are any.

    None on a surface that is no manifold: its open edges are no lines.
    """
    if not (is_edge_manifold(mesh.faces) and is_vertex_manifold(mesh.faces)):
        return []
    return [mesh.vertices_mm[loop] for loop in boundary_loops(mesh.faces)]


def require_same_lines(name: str, found: Sequence[Points3], wanted: Sequence[Points3]) -> None:
    """Refuse a file whose polylines are not those that were written."""
    require(len(found) == len(wanted), f"{name}: {len(found)} curves of {len(wanted)}")
    for number, (polyline, points) in enumerate(zip(found, wanted, strict=True), 1):
        whole = polyline.shape == points.shape
        near = whole and np.allclose(polyline, points, rtol=0, atol=_PRECISION)
        require(near, f"{name}: curve {number} lies elsewhere")


def opening_tags(unit: str, layers: tuple[str, ...]) -> bytes:
    """Header, layers, and the beginning of the entities."""
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
    return encoded_tags(*tags, (0, "ENDTAB"), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"))


def encoded_tags(*tags: tuple[int, str]) -> bytes:
    return "".join(f"{code}\n{value}\n" for code, value in tags).encode("ascii")


def _faces(mesh: Mesh, layer: str) -> Iterator[bytes]:
    """A triangle is a 3DFACE whose fourth corner repeats its third."""
    places = (f"{10 * axis + corner}\n%.6f\n" for corner in range(4) for axis in (1, 2, 3))
    face = f"0\n3DFACE\n8\n{layer}\n" + "".join(places)
    for start in range(0, len(mesh.faces), _BLOCK):
        corners = mesh.vertices_mm[mesh.faces[start : start + _BLOCK][:, [0, 1, 2, 2]]]
        yield (face * len(corners) % tuple(corners.ravel())).encode("ascii")


def polyline_tags(points_mm: Points3, layer: str, *, closed: bool) -> bytes:
    """A 3D polyline; a closed one does not repeat its first point."""
    flags = _THREE_D + (_CLOSED if closed else 0)
    head = f"0\nPOLYLINE\n8\n{layer}\n66\n1\n10\n0.0\n20\n0.0\n30\n0.0\n70\n{flags}\n"
    vertex = f"0\nVERTEX\n8\n{layer}\n10\n%.6f\n20\n%.6f\n30\n%.6f\n70\n{_THREE_D_VERTEX}\n"
    points = vertex * len(points_mm) % tuple(points_mm.ravel())
    return f"{head}{points}0\nSEQEND\n8\n{layer}\n".encode("ascii")


@dataclass(frozen=True)
class _Drawing:
    triangles: np.ndarray
    polylines: list[np.ndarray]


def _read(path: Path) -> _Drawing:
    """Tags are lines in pairs, a code and a value; code 0 begins an entity."""
    begun: list[str] = []
    parts = [(np.zeros(0), np.zeros(0, np.int64))]
    with path.open(encoding="ascii") as file:
        while text := "".join(islice(file, 2 * _TAGS)):
            parts.append(_read_tags(text.removesuffix("\n").split("\n"), begun))
    every = np.concatenate([part[0] for part in parts])
    entity = np.concatenate([part[1] for part in parts])
    names = np.array(begun)

    def numbers(name: str) -> np.ndarray:
        return every[(names == name)[entity]].reshape(-1, 3)

    corners = numbers("3DFACE").reshape(-1, 4, 3)
    require(bool((corners[:, 2] == corners[:, 3]).all()), f"{path.name}: faces of four corners")
    line_of = np.cumsum(names == "POLYLINE")[names == "VERTEX"]
    ends = np.searchsorted(line_of, np.arange(1, int((names == "POLYLINE").sum()) + 1), "right")
    polylines = np.split(numbers("VERTEX"), ends)[:-1]
    return _Drawing(corners[:, :3], polylines)


def _read_tags(lines: list[str], begun: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates, and which entity each belongs to; the entities are added to `begun`."""
    values = lines[1::2]
    letters = np.array(lines[: 2 * len(values) : 2], "U3").view(np.uint32).reshape(-1, 3)
    begins = (letters[:, 0] == ord("0")) & (letters[:, 1] == 0)
    entity = len(begun) - 1 + np.cumsum(begins)
    begun += compress(values, begins.tolist())
    place = (letters[:, 1] != 0) & (letters[:, 2] == 0)  # codes 10 to 39
    place &= (letters[:, 0] >= ord("1")) & (letters[:, 0] <= ord("3")) & (entity >= 0)
    found = map(float, compress(values, place.tolist()))
    return np.fromiter(found, np.float64, int(place.sum())), entity[place]
