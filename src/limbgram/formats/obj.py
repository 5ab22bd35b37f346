"""OBJ: vertices as text, with colours if they follow the coordinates, and polygons as fans.

A line with an unknown keyword is refused as damage: ignored, it might have been a face. The writer
gives vertices, to a millionth of a unit, and triangles; after them each landmark as an object of
one point. Points in files of other programs are no landmarks.

Own code: of 300 damaged files trimesh 5.2 reads 90 as another shape without a word, this reader
34 (benchmarks/results/formats.json).
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np
from jaxtyping import UInt8

from limbgram.core.errors import ShapeFileError, reason_of
from limbgram.core.files import ContentError, other, require, without_mark, write_file
from limbgram.core.geometry.arrays import Faces
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import Finding, note
from limbgram.formats.format import Format
from limbgram.formats.triangle_soup import Soup, fans_of, of_polygons, require_corners
from limbgram.formats.units import stated_unit
from limbgram.formats.writing import Unit, require_same_triangles, target
from limbgram.workbench.limb import Landmark

_CORNER = rb"-?\d{1,10}(?:/-?\d*){0,2}"
_FACE = re.compile(_CORNER + rb"(?:\s+" + _CORNER + rb"){2,}")
_AFTER_SLASH = re.compile(rb"/\S*")
_IGNORED_KEYWORDS = frozenset(
    b"vt vn vp cstype deg bmat step p l curv curv2 surf parm trim hole scrv sp end con g s mg o "
    b"bevel c_interp d_interp lod usemtl mtllib shadow_obj trace_obj ctech stech usemap maplib "
    b"call csh".split()
)
"""Keywords of the format (Wavefront, appendix B1) that do not change a surface of triangles."""
_MOST_VERTEX_NUMBERS = 7
"""Of a vertex: coordinates, a colour and its opacity."""
_TOLERANCE = 1e-6
_ROWS_PER_BLOCK = 10_000
_Y = 1
_LANDMARK_PREFIX = "landmark "
_LONGEST_NAME_BYTES = 300
_LANDMARK_LINES = (
    rb"o " + _LANDMARK_PREFIX.encode() + rb"([^\r\n]{1,300})\r?\n"
    rb"v ([-.\d ]{5,80})\r?\np \d{1,10}\r?\n"
)
"""A landmark as this program writes it: name and position."""


def read_obj(content: bytes, name: str) -> Soup:
    """The surface of all objects and groups of the file as one."""
    content = without_mark(content)
    try:
        surface, marks = _split_landmarks(content)
        lines = _lines(surface)
        places = _vertex_rows(lines)
        faces = _faces(lines)
    except ValueError as error:
        raise ShapeFileError("file.obj.damaged", name=name, why=reason_of(error)) from error
    if not len(places) or not len(faces):
        raise ShapeFileError("file.obj.empty", name=name)
    colours = None
    if places.shape[1] in (6, 7):
        colours = _colours(places[:, 3:6])
    mesh = Mesh(vertices_mm=places[:, :3].copy(), faces=faces, colours=colours)
    ours = stated_unit(content[:200])
    return Soup(
        mesh=mesh,
        stated_unit=ours,
        landmarks=marks,
        notes=(
            *of_polygons(faces, sum(word == b"f" for word, _ in lines)),
            *(() if ours else _y_up_note(mesh)),
        ),
    )


def write_obj(mesh: Mesh, path: Path | str, unit: Unit, *, unscaled: bool = False) -> Path:
    """Write vertices (to a millionth of a unit) and faces, and read them back."""
    return _write(mesh, target(path, unit, unscaled=unscaled), unit, ())


def write_marked_obj(mesh: Mesh, path: Path | str, landmarks: Sequence[Landmark]) -> Path:
    """Write the same, and each landmark as an object of one point."""
    return _write(mesh, Path(path), "mm", landmarks)


def _write(mesh: Mesh, path: Path, unit: Unit, landmarks: Sequence[Landmark]) -> Path:
    def encode(stream: BinaryIO) -> None:
        stream.write(f"# limbgram, unit: {unit}\n".encode("ascii"))
        for rows in _blocks(mesh.vertices_mm):
            stream.write(("v %.6f %.6f %.6f\n" * len(rows) % tuple(rows.ravel())).encode("ascii"))
        for rows in _blocks(mesh.faces + 1):
            stream.write(("f %d %d %d\n" * len(rows) % tuple(rows.ravel())).encode("ascii"))
        for number, mark in enumerate(landmarks, len(mesh) + 1):
            x, y, z = mark.position_mm.tolist()
            head = f"o {_LANDMARK_PREFIX}{_one_line(mark.name)}"
            stream.write(f"{head}\nv {x:.6f} {y:.6f} {z:.6f}\np {number}\n".encode())

    def check(written: Path) -> None:
        vertices, faces = _read_back(written)
        require_same_triangles(path.name, vertices[faces], mesh, _TOLERANCE)
        _, read = _split_landmarks(written.read_bytes())
        positions = np.array([mark.position_mm for mark in landmarks]).reshape(-1, 3)
        read_positions = np.array([mark.position_mm for mark in read]).reshape(-1, 3)
        same = [mark.name for mark in read] == [_one_line(mark.name) for mark in landmarks]
        near = same and np.allclose(read_positions, positions, rtol=0, atol=_TOLERANCE)
        require(near, other(path.name, "landmarks"))

    return write_file(path, encode, check)


def _one_line(name: str) -> str:
    """A landmark's name that a line of the file can hold."""
    plain = " ".join(name.split()).encode()[:_LONGEST_NAME_BYTES].decode(errors="ignore")
    return plain.strip() or "unnamed"


def _colours(values: np.ndarray) -> UInt8[np.ndarray, "n 3"]:
    """Colours of values from 0 to 1; some programs write whole numbers up to 255."""
    counted = values.max() > 1 and (values == np.floor(values)).all()
    share = values / 255 if counted else values
    return np.rint(np.clip(share, 0, 1) * 255).astype(np.uint8)


def _y_up_note(mesh: Mesh) -> tuple[Finding, ...]:
    """A note where the shape is longest along Y, which may be up: the format does not say.

    The shape is not turned: alignment will do that without a guess.
    """
    if int(np.ptp(mesh.vertices_mm, axis=0).argmax()) != _Y:
        return ()
    return (note("file.obj.y_up"),)


_Lines = list[tuple[bytes, bytes]]
"""The keywords v and f, each with its arguments, in the order of the file."""


def _lines(content: bytes) -> _Lines:
    """The v and f lines; a backslash continues a line."""
    kept: _Lines = []
    whole = content.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    for number, line in enumerate(whole.splitlines(), 1):
        word, _, rest = line.split(b"#", 1)[0].strip().replace(b"\t", b" ").partition(b" ")
        if word in (b"v", b"f"):
            kept.append((word, rest.strip()))
        elif word and word not in _IGNORED_KEYWORDS:
            shown = word[:40].decode("ascii", "replace")
            raise ContentError("file.obj.word", line=number, word=shown)
    return kept


def _vertex_rows(lines: _Lines) -> np.ndarray:
    rows = [rest.split(None, _MOST_VERTEX_NUMBERS) for word, rest in lines if word == b"v"]
    if not rows:
        return np.empty((0, 3))
    widths = {len(row) for row in rows}
    if len(widths) > 1 or not 3 <= min(widths) <= _MOST_VERTEX_NUMBERS:
        raise ContentError("file.obj.coordinates")
    numbers = np.array(rows, np.float64)
    if not np.isfinite(numbers[:, 3:]).all():
        raise ContentError("file.colour.no_number")
    return numbers


def _faces(lines: _Lines) -> Faces:
    """Triangles of all faces; indices count from 1, or backwards from the last vertex so far."""
    listed: list[list[int]] = []
    vertices, most = 0, sum(word == b"v" for word, _ in lines)
    for word, rest in lines:
        if word == b"v":
            vertices += 1
        else:
            if len(rest) > most:  # only then can it have more corners
                require_corners(len(rest.split(None, most)), most)
            if not _FACE.fullmatch(rest):
                shown = rest[:40].decode("ascii", "replace")
                raise ContentError("file.obj.face", found=shown)
            corners = [int(corner) for corner in _AFTER_SLASH.sub(b"", rest).split()]
            if 0 in corners:
                raise ContentError("file.obj.vertex_0")
            listed.append([k - 1 if k > 0 else vertices + k for k in corners])
    return fans_of(listed)


def _split_landmarks(content: bytes) -> tuple[bytes, tuple[Landmark, ...]]:
    """The surface, and the landmarks that follow it in files of this program."""
    begin = content.find(b"\no " + _LANDMARK_PREFIX.encode())
    if begin < 0 or stated_unit(content[:200]) is None:
        return content, ()
    marks = content[begin + 1 :]
    if not re.fullmatch(rb"(?:" + _LANDMARK_LINES + rb")+", marks):
        raise ContentError("file.obj.landmark")
    return content[: begin + 1], tuple(
        Landmark(name=name.decode("utf-8"), position_mm=np.array(place.split(), np.float64))
        for name, place in re.findall(_LANDMARK_LINES, marks)
    )


def _blocks(rows: np.ndarray) -> list[np.ndarray]:
    return [rows[start : start + _ROWS_PER_BLOCK] for start in range(0, len(rows), _ROWS_PER_BLOCK)]


def _read_back(path: Path) -> tuple[np.ndarray, np.ndarray]:
    lines = path.read_bytes().splitlines()
    vertices = b" ".join(line[2:] for line in lines if line.startswith(b"v "))
    faces = b" ".join(line[2:] for line in lines if line.startswith(b"f "))
    places = np.array(vertices.split(), np.float64).reshape(-1, 3)
    return places, np.array(faces.split(), np.int64).reshape(-1, 3) - 1


FORMAT = Format(
    suffix=".obj",
    place=40,
    used_for={"en": "other programs", "de": "andere Programme"},
    read=read_obj,
    write=write_obj,
    write_marked=write_marked_obj,
)
