"""DXF, release 12: the surface as polyface meshes, sections and trimline as 3D polylines.

A polyface mesh keeps vertices apart from faces, so neighbours stay joined, which 3DFACEs do not.
Its counts are 16-bit numbers, so a larger surface is split into several meshes that touch.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from jaxtyping import Float64

from limbgram.export.dxf import (
    encoded_tags,
    opening_tags,
    polyline_tags,
    require_same_lines,
    trimline_of,
)
from limbgram.export.workshop.limb_file import MILLIMETRES
from limbgram.export.writing import require_same_triangles, write_file
from limbgram.surface.mesh import Mesh
from limbgram.surface.sections import cut, heights_between
from limbgram.surface.topology import with_faces

_MOST = 32_767
"""Vertices or faces of one polyface mesh."""
_POLYFACE, _PLACE, _FACE = 64, 192, 128
_PRECISION = 1e-6
_LAYERS = ("SURFACE_MM", "SECTIONS_MM", "TRIMLINE_MM")


@dataclass(frozen=True, kw_only=True)
class PolyfaceReport:
    """What the file holds."""

    path: Path
    meshes: int
    """More than 1 where the surface had to be split."""
    sections: int


def write_polyface_dxf(mesh: Mesh, path: Path, *, spacing_mm: float = 10.0) -> PolyfaceReport:
    """Write surface, sections across z at multiples of `spacing_mm`, trimline; read all back."""
    parts = [with_faces(mesh, faces) for faces in _split(mesh)]
    sections = cut(mesh, heights_between(mesh, spacing_mm).tolist())
    trimline = trimline_of(mesh)
    wanted = [*(section.points_mm for section in sections), *trimline]

    def encode(stream: BinaryIO) -> None:
        layers = _LAYERS if trimline else _LAYERS[:2]
        stream.write(opening_tags(MILLIMETRES.unit, layers))
        for part in parts:
            stream.writelines(_polyface(part))
        stream.writelines(
            polyline_tags(section.points_mm, _LAYERS[1], closed=section.closed)
            for section in sections
        )
        stream.writelines(polyline_tags(loop, _LAYERS[2], closed=True) for loop in trimline)
        stream.write(encoded_tags((0, "ENDSEC"), (0, "EOF")))

    def check(written: Path) -> None:
        drawing = _read(written)
        ordered = Mesh(
            vertices_mm=mesh.vertices_mm, faces=np.concatenate(_split(mesh)).astype(np.int32)
        )
        require_same_triangles(path.name, drawing.triangles, ordered, _PRECISION)
        require_same_lines(path.name, drawing.polylines, wanted)

    write_file(path, encode, check)
    return PolyfaceReport(path=path, meshes=len(parts), sections=len(sections))


def _split(mesh: Mesh) -> list[np.ndarray]:
    """Faces in layers along z, each within what one polyface mesh can number."""
    heights = mesh.vertices_mm[mesh.faces][:, :, 2].mean(1)
    rest = [mesh.faces[np.argsort(heights, kind="stable")]]
    parts: list[np.ndarray] = []
    while rest:
        faces = rest.pop(0)
        over = max(len(faces), len(np.unique(faces))) / _MOST
        if over <= 1:
            parts.append(faces)
        else:
            rest = [*np.array_split(faces, int(np.ceil(over))), *rest]
    return parts


def _polyface(part: Mesh) -> Iterator[bytes]:
    layer = _LAYERS[0]
    yield encoded_tags(
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
    place = f"0\nVERTEX\n8\n{layer}\n10\n%.6f\n20\n%.6f\n30\n%.6f\n70\n{_PLACE}\n"
    yield (place * len(part.vertices_mm) % tuple(part.vertices_mm.ravel())).encode("ascii")
    face = (
        f"0\nVERTEX\n8\n{layer}\n10\n0.0\n20\n0.0\n30\n0.0\n70\n{_FACE}\n71\n%d\n72\n%d\n73\n%d\n"
    )
    yield (face * len(part.faces) % tuple((part.faces + 1).ravel())).encode("ascii")
    yield encoded_tags((0, "SEQEND"), (8, layer))


@dataclass(frozen=True)
class _Drawing:
    triangles: Float64[np.ndarray, "f 3 3"]
    polylines: list[np.ndarray]


def _read(path: Path) -> _Drawing:
    """Polylines by their flag: vertices and faces of meshes, points of sections."""
    from ezdxf.lldxf.tagger import ascii_tags_loader  # takes longer than all else here to import

    triangles: list[np.ndarray] = []
    polylines: list[np.ndarray] = []
    is_mesh = False
    entity = ""
    places: list[str] = []
    corners: list[str] = []
    with path.open(encoding="ascii") as stream:
        for tag in ascii_tags_loader(stream):
            if tag.code == 0:
                entity = tag.value
                if entity == "POLYLINE":
                    is_mesh, places, corners = False, [], []
                elif entity == "SEQEND":
                    points = np.array(places, np.float64).reshape(-1, 3)
                    if is_mesh:
                        idx = np.array(corners, np.int64).reshape(-1, 3) - 1
                        triangles.append(points[: len(points) - len(idx)][idx])
                    else:
                        polylines.append(points)
            elif entity == "POLYLINE" and tag.code == 70:
                is_mesh = int(tag.value) == _POLYFACE
            elif entity == "VERTEX" and tag.code in (10, 20, 30):
                places.append(tag.value)
            elif entity == "VERTEX" and tag.code in (71, 72, 73):
                corners.append(tag.value)
    return _Drawing(np.concatenate(triangles or [np.empty((0, 3, 3))]), polylines)
