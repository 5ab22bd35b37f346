"""OBJ: vertices, with colours where they stand behind the places, and polygons as fans."""

import re

import numpy as np

from limbgram.errors import ShapeFileError
from limbgram.geometry.arrays import Faces
from limbgram.shape.reading.soup import Soup
from limbgram.shape.reading.stl import stated_unit
from limbgram.surface.mesh import Mesh

_BEHIND_SLASH = re.compile(rb"/\S*")


def read_obj(content: bytes, name: str) -> Soup:
    """The surface of all objects and groups of the file as one."""
    lines = [line.split(b"#")[0].strip() for line in content.splitlines()]
    try:
        places = _rows([line[2:] for line in lines if line[:2] == b"v "])
        faces = _faces(lines)
    except ValueError as error:
        raise ShapeFileError(
            f"{name} is damaged: {error}. Export it again as OBJ, or as STL."
        ) from error
    if not len(places) or not len(faces):
        raise ShapeFileError(f"{name} holds no surface: no lines that begin with v and f.")
    colours = None
    if places.shape[1] in (6, 7):
        colours = np.rint(np.clip(places[:, 3:6], 0, 1) * 255).astype(np.uint8)
    mesh = Mesh(vertices_mm=places[:, :3].copy(), faces=faces, colours=colours)
    return Soup(mesh=mesh, stated_unit=stated_unit(content[:200]))


def _rows(lines: list[bytes]) -> np.ndarray:
    if not lines:
        return np.empty((0, 3))
    numbers = np.array(b" ".join(lines).split(), np.float64)
    width = len(lines[0].split())
    if len(numbers) != width * len(lines) or width < 3:
        raise ValueError("its vertices do not all have the same number of coordinates")
    return numbers.reshape(-1, width)


def _faces(lines: list[bytes]) -> Faces:
    """Corner numbers count from 1, or backwards from the last vertex so far."""
    listed: list[list[int]] = []
    vertices = 0
    for line in lines:
        if line[:2] == b"v ":
            vertices += 1
        elif line[:2] == b"f ":
            corners = [int(word) for word in _BEHIND_SLASH.sub(b"", line[2:]).split()]
            listed.append([k - 1 if k > 0 else vertices + k for k in corners])
    return fans_of(listed)


def fans_of(polygons: list[list[int]]) -> Faces:
    """Triangles of polygons, each a fan round its first corner."""
    triangles = [
        (corners[0], corners[k], corners[k + 1])
        for corners in polygons
        for k in range(1, len(corners) - 1)
    ]
    within = all(0 <= corner < 2**31 for triangle in triangles for corner in triangle)
    if not within:
        raise ValueError("a face names a vertex that cannot be")
    return np.array(triangles, np.int32).reshape(-1, 3)
