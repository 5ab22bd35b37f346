"""DXF, release 12: the surface as polyface meshes, sections and trimline as 3D polylines.

A polyface mesh keeps vertices apart from faces, so neighbours stay joined, which 3DFACEs do not.
Its counts are 16-bit numbers, so a larger surface is split into several meshes that touch.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from limbgram.export.dxf import (
    CORNERS,
    PLACE,
    POLYFACE,
    Curves,
    curves_of,
    encoded_tags,
    surface_layer,
    write_drawing,
)
from limbgram.surface.mesh import Mesh
from limbgram.surface.topology import with_faces

_MOST = 32_767
"""Vertices or faces of one polyface mesh."""
_LAYER = surface_layer("mm")


@dataclass(frozen=True, kw_only=True)
class PolyfaceReport:
    """What the file holds."""

    path: Path
    meshes: int
    """More than 1 where the surface had to be split."""
    curves: Curves


def write_polyface_dxf(mesh: Mesh, path: Path, *, spacing_mm: float = 10.0) -> PolyfaceReport:
    """Write surface, sections across z at multiples of `spacing_mm`, trimline; read all back."""
    curves = curves_of(mesh, spacing_mm)
    parts = _split(mesh)
    surface = chain.from_iterable(_polyface(with_faces(mesh, faces)) for faces in parts)
    ordered = Mesh(vertices_mm=mesh.vertices_mm, faces=np.concatenate(parts))
    write_drawing(path, "mm", surface, ordered, curves)
    return PolyfaceReport(path=path, meshes=len(parts), curves=curves)


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
    yield encoded_tags(
        (0, "POLYLINE"),
        (8, _LAYER),
        (66, "1"),
        (10, "0.0"),
        (20, "0.0"),
        (30, "0.0"),
        (70, str(POLYFACE)),
        (71, str(len(part.vertices_mm))),
        (72, str(len(part.faces))),
    )
    place = f"0\nVERTEX\n8\n{_LAYER}\n10\n%.6f\n20\n%.6f\n30\n%.6f\n70\n{PLACE}\n"
    yield (place * len(part.vertices_mm) % tuple(part.vertices_mm.ravel().tolist())).encode("ascii")
    face = (
        f"0\nVERTEX\n8\n{_LAYER}\n10\n0.0\n20\n0.0\n30\n0.0\n70\n{CORNERS}\n"
        "71\n%d\n72\n%d\n73\n%d\n"
    )
    yield (face * len(part.faces) % tuple((part.faces + 1).ravel().tolist())).encode("ascii")
    yield encoded_tags((0, "SEQEND"), (8, _LAYER))
