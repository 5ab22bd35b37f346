"""GLB: the surface for viewers, with colour and sigma.

glTF knows one unit, the metre, and calls +Y up (Khronos, glTF 2.0, 2021): read, it becomes
millimetres with +Z up; written, one node turns +Z to +Y, so that viewers show the limb standing.
Colours of vertices are shares of light there, not the steps of a display; some programs write the
latter, and files of theirs, as ours from before, are known by the name that they give. The
attribute _SIGMA has each vertex's standard deviation in metres, -1 where it was filled, for glTF
has no NaN. Landmarks are nodes with the mark in their extras. Triangles, strips and fans are read,
through all nodes of the scene. Compressed files are refused by name.

Our reader stays: of 300 damaged files trimesh 5.2 reads 15 as another shape without a word, ours 9;
the rest trimesh ends in eleven kinds of error, RecursionError among them
(benchmarks/results/formats.json).
"""

import base64
import binascii
import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np
from jaxtyping import Float32, Float64, Int64

from limbgram.core.errors import ShapeFileError, reason_of
from limbgram.core.files import ContentError, json_of, other, require, write_file
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import Finding, fault, note
from limbgram.formats.format import Format
from limbgram.formats.triangle_soup import Soup
from limbgram.formats.writing import Unit, require_same_triangles, single_precision, target
from limbgram.reconstruction.photos.decoding import LINEAR_OF_SRGB
from limbgram.workbench.limb import Landmark

_Z_UP_FROM_Y_UP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
_METRE = 0.001
_SIGMA = "_SIGMA"
_MAGIC, _JSON, _BIN = b"glTF", 0x4E4F534A, 0x004E4942
_KINDS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_CODES = {kind: code for code, kind in _KINDS.items()}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_VALUES_OF, _CORNERS_OF = 34962, 34963
"""What a part of the numbers is for: values of vertices, or corners of triangles."""
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_OURS = "limbgram"
_MARKED = "landmark"
_OF_DISPLAYS = ("trimesh", "open3d")
"""Programs that write a display's colours (seen: trimesh 5.2, Open3D 0.20); trimesh wrote ours."""
_DATA = "data:application/"
_OF_LOOKS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_")
"""Extensions so named change no triangle."""
_OF_DRAWING = {"attributes", "indices", "material", "mode", "targets", "extensions", "extras"}
"""All that the format knows there: with indices misspelt, other triangles would be drawn."""
_MOST_CORNERS = 60_000_000
_TURNED = 1e-3
_LONGEST_NAME = 300
"""A quaternion's length is 1 within this."""


def read_glb(content: bytes, name: str) -> Soup:
    """All surfaces of the scene as one, in metres."""
    try:
        file = _File.of(content)
        parts, passed_over = _parts(file)
        marks = _landmarks(file)
    except (ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise ShapeFileError("file.glb.unread", name=name, why=_why(error)) from error
    if not parts:
        raise ShapeFileError("file.glb.empty", name=name)
    starts = np.cumsum([0, *(len(part.places) for part in parts[:-1])])
    places = np.concatenate([part.places for part in parts]) @ _Z_UP_FROM_Y_UP.T
    faces = np.concatenate([part.faces + start for part, start in zip(parts, starts)])
    colours = [part.colours for part in parts if part.colours is not None]
    sigma = parts[0].sigma if len(parts) == 1 else None
    mesh = Mesh(
        vertices_mm=places,
        faces=faces.astype(np.int32),
        colours=np.concatenate(colours) if len(colours) == len(parts) else None,
        sigma_mm=sigma,
    )
    notes = (note("file.glb.passed_over", drawings=passed_over),) if passed_over else ()
    return Soup(mesh=mesh, stated_unit="m", landmarks=marks, notes=notes)


def write_glb(mesh: Mesh, path: Path | str, unit: Unit, *, unscaled: bool = False) -> Path:
    """Write a binary glTF in metres with normals, and read it back in units of the mesh."""
    return _write(mesh, target(path, unit, unscaled=unscaled), unit, ())


def write_marked_glb(mesh: Mesh, path: Path | str, landmarks: Sequence[Landmark]) -> Path:
    """Write the same with each landmark as a named node, which viewers show as an empty place."""
    return _write(mesh, Path(path), "mm", landmarks)


def _write(mesh: Mesh, path: Path, unit: Unit, landmarks: Sequence[Landmark]) -> Path:
    content = _encoded(mesh, unit, landmarks)

    def encode(stream: BinaryIO) -> None:
        stream.write(content)

    def check(written: Path) -> None:
        read = read_glb(written.read_bytes(), path.name)
        places = read.mesh.vertices_mm / _METRE
        require_same_triangles(path.name, places[read.mesh.faces], mesh, 2 * single_precision(mesh))
        kept, sigma = read.mesh.sigma_mm, mesh.sigma_mm
        require(_same(read.mesh.colours, mesh.colours), other(path.name, "colours"))
        metres = None if sigma is None else (sigma * _METRE).astype(np.float32)
        require(_same(kept, metres), other(path.name, "sigmas"))
        require(_same_marks(read.landmarks, landmarks), other(path.name, "landmarks"))

    return write_file(path, encode, check)


def _same(one: np.ndarray | None, two: np.ndarray | None) -> bool:
    if one is None or two is None:
        return one is two
    return np.array_equal(one, two, equal_nan=one.dtype.kind == "f")


def _same_marks(found: Sequence[Landmark], written: Sequence[Landmark]) -> bool:
    """Names and places, within a nanometre; what is read is in metres."""
    return [mark.name for mark in found] == [_shown(mark.name) for mark in written] and all(
        np.allclose(one.position_mm / _METRE, two.position_mm, rtol=0, atol=1e-6)
        for one, two in zip(found, written, strict=True)
    )


def _encoded(mesh: Mesh, unit: Unit, landmarks: Sequence[Landmark]) -> bytes:
    """The whole file: a description in JSON, and the numbers that it points into."""
    places = (mesh.vertices_mm * _METRE).astype("<f4")
    rows: dict[str, np.ndarray] = {
        "POSITION": places,
        "NORMAL": _whole_normals(mesh).astype("<f4"),
    }
    if mesh.colours is not None:
        # As fractions: trimesh 5.2 takes whole numbers of 16 bits for others.
        rows["COLOR_0"] = LINEAR_OF_SRGB[mesh.colours].astype("<f4")
    if mesh.sigma_mm is not None:
        rows[_SIGMA] = _finite_metres(mesh.sigma_mm)
    arrays = [*rows.values(), mesh.faces.astype("<u4").ravel()]
    ends = np.cumsum([array.nbytes for array in arrays])  # all of whole words of 4 bytes
    views = [
        {
            "buffer": 0,
            "byteOffset": int(end - array.nbytes),
            "byteLength": array.nbytes,
            "target": _CORNERS_OF if array is arrays[-1] else _VALUES_OF,
        }
        for array, end in zip(arrays, ends)
    ]
    accessors: list[dict[str, Any]] = [_accessor(idx, array) for idx, array in enumerate(arrays)]
    accessors[0] |= {"min": places.min(0).tolist(), "max": places.max(0).tolist()}
    matrix = np.eye(4)
    matrix[:3, :3] = _Z_UP_FROM_Y_UP.T
    surface: dict[str, Any] = {"name": "surface", "mesh": 0, "matrix": matrix.T.ravel().tolist()}
    if landmarks:
        surface["children"] = list(range(1, len(landmarks) + 1))
    tree = {
        "asset": {"version": "2.0", "generator": _OURS},
        "scene": 0,
        "scenes": [{"nodes": [0], "extras": {"source_unit": unit}}],
        "nodes": [surface, *map(_node, landmarks)],
        "meshes": [
            {
                "primitives": [
                    {
                        "attributes": {name: idx for idx, name in enumerate(rows)},
                        "indices": len(rows),
                    }
                ]
            }
        ],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": int(ends[-1])}],
    }
    described = json.dumps(tree, separators=(",", ":")).encode()
    described += b" " * (-len(described) % 4)
    numbers = b"".join(array.tobytes() for array in arrays)
    parts = (
        struct.pack("<II", len(described), _JSON) + described,
        struct.pack("<II", len(numbers), _BIN) + numbers,
    )
    return _MAGIC + struct.pack("<II", 2, 12 + sum(map(len, parts))) + b"".join(parts)


def _accessor(idx: int, array: np.ndarray) -> dict[str, Any]:
    width = 1 if array.ndim == 1 else array.shape[1]
    return {
        "bufferView": idx,
        "componentType": _CODES[array.dtype.str],
        "count": len(array),
        "type": "SCALAR" if width == 1 else f"VEC{width}",
    }


def _node(mark: Landmark) -> dict[str, Any]:
    """In the axes of the surface, whose node is above."""
    place = (mark.position_mm * _METRE).tolist()
    return {"name": _shown(mark.name), "translation": place, "extras": {_MARKED: True}}


def _shown(name: str) -> str:
    """A landmark's name without what no program shows."""
    return "".join(letter for letter in name if letter.isprintable())[:_LONGEST_NAME]


def _whole_normals(mesh: Mesh) -> Points3:
    """Of length 1 everywhere, as the format demands, also where no face of area meets."""
    normals = mesh.vertex_normals()
    normals[~normals.any(1)] = (0.0, 0.0, 1.0)
    return normals


def _displayed(light: np.ndarray) -> np.ndarray:
    """Steps of a display's colour, 0 to 255, of shares of light (IEC 61966-2-1)."""
    light = np.clip(light, 0, 1)
    shown = np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.rint(shown * 255).astype(np.uint8)


@dataclass(frozen=True)
class _File:
    """The tree of a file and the numbers that it points into."""

    tree: dict[str, Any]
    numbers: tuple[bytes, ...]
    """Of each buffer; only the first stands in the file itself, behind its description."""

    @classmethod
    def of(cls, content: bytes) -> "_File":
        if content[:4] != _MAGIC or len(content) < 20:
            raise ContentError("file.glb.beginning")
        version, length = struct.unpack_from("<II", content, 4)
        if version != 2:
            raise ContentError("file.glb.version", version=version)
        if length != len(content):
            raise ContentError("file.glb.length", bytes=len(content), wanted=length)
        chunks: dict[int, bytes] = {}
        place = 12
        while place < length:
            if place + 8 > length:
                raise ContentError("file.glb.ends_in_part")
            size, kind = struct.unpack_from("<II", content, place)
            if place + 8 + size > length:
                raise ContentError("file.glb.part_beyond_end")
            if not chunks and kind != _JSON:
                raise ContentError("file.glb.no_description")
            chunks.setdefault(kind, content[place + 8 : place + 8 + size])
            place += 8 + size
        tree = json_of(chunks[_JSON].rstrip(b"\0 "))
        if not str(tree["asset"]["version"]).startswith("2"):
            raise ContentError("file.glb.gltf_version")
        for needed in tree.get("extensionsRequired", []):
            if not str(needed).startswith(_OF_LOOKS):
                raise ContentError("file.glb.needs", extension=str(needed)[:60])
        buffers: list[dict[str, Any]] = tree.get("buffers", [])
        inside = [chunks.get(_BIN), *(None for _ in buffers[1:])]
        return cls(tree, tuple(_numbers(*one) for one in zip(buffers, inside)))

    def item(self, kind: str, number: Any) -> dict[str, Any]:
        """One of a list of the tree."""
        listed = self.tree[kind]
        if not isinstance(listed, list):
            raise ContentError("file.glb.no_list", kind=kind)
        found = cast(list[object], listed)[_whole(number, kind)]
        if not isinstance(found, dict):
            raise ContentError("file.glb.no_object", kind=kind)
        return cast(dict[str, Any], found)

    def array(self, number: Any, widths: tuple[str, ...]) -> tuple[np.ndarray, bool]:
        """An accessor's rows, and whether whole numbers stand for shares of one."""
        accessor = self.item("accessors", number)
        kind, count = accessor["type"], _whole(accessor["count"], "count")
        if kind not in widths or "sparse" in accessor:
            raise ContentError("file.glb.numbers", kind=str(kind)[:20])
        view = self.item("bufferViews", accessor["bufferView"])
        numbers = self.numbers[_whole(view["buffer"], "buffer")]
        cell = np.dtype(_KINDS[accessor["componentType"]])
        width = _WIDTHS[kind]
        start = _whole(view.get("byteOffset", 0), "byteOffset")
        end = start + _whole(view["byteLength"], "byteLength")
        first = start + _whole(accessor.get("byteOffset", 0), "byteOffset")
        step = _whole(view.get("byteStride", 0), "byteStride") or width * cell.itemsize
        last = first + (count - 1) * step + width * cell.itemsize
        if not count or step < width * cell.itemsize or last > end or end > len(numbers):
            raise ContentError("file.glb.beyond_numbers")
        rows = np.ndarray((count, width), cell, numbers, first, strides=(step, cell.itemsize))
        return rows, bool(accessor.get("normalized", False))


def _numbers(buffer: dict[str, Any], inside: bytes | None) -> bytes:
    """Of one buffer: behind the description, or as text in it, which Open3D writes.

    inside: What stands behind the description, which only the first buffer may mean.
    """
    if "uri" not in buffer and inside is not None:
        return inside
    uri = str(buffer.get("uri", ""))
    head, mark, text = uri.partition(";base64,")
    if not (mark and head.startswith(_DATA)):
        raise ContentError("file.glb.elsewhere")
    try:
        return base64.b64decode(text, validate=True)
    except binascii.Error as error:
        raise ContentError("file.glb.no_base64") from error


@dataclass(frozen=True)
class _Part:
    """A drawing of triangles in the scene's axes."""

    places: Points3
    faces: Int64[np.ndarray, "f 3"]
    colours: np.ndarray | None
    sigma: np.ndarray | None


def _parts(file: _File) -> tuple[list[_Part], int]:
    """Every surface at every node; and how many drawings of other things there are."""
    parts: list[_Part] = []
    passed_over = corners = 0
    for node, motion in _placed(file):
        if "mesh" not in node:
            continue
        for drawing in file.item("meshes", node["mesh"])["primitives"]:
            if drawing.get("mode", _TRIANGLES) in (0, 1, 2, 3):
                passed_over += 1
                continue
            part = _part(file, drawing, motion)
            corners += 3 * len(part.faces) + len(part.places)
            if corners > _MOST_CORNERS:
                raise ContentError("file.glb.too_many")
            parts.append(part)
    return parts, passed_over


def _placed(file: _File) -> list[tuple[dict[str, Any], Float64[np.ndarray, "4 4"]]]:
    """The nodes of the scene, with the motion to the scene."""
    if "scenes" in file.tree:
        roots = file.item("scenes", file.tree.get("scene", 0)).get("nodes", [])
    else:
        nodes: list[dict[str, Any]] = file.tree["nodes"]
        children = {child for node in nodes for child in node.get("children", [])}
        roots = [number for number in range(len(nodes)) if number not in children]
    waiting = [(number, np.eye(4)) for number in reversed(roots)]
    found: list[tuple[dict[str, Any], Float64[np.ndarray, "4 4"]]] = []
    seen: set[int] = set()
    while waiting:
        number, above = waiting.pop()
        if _whole(number, "node") in seen:
            raise ContentError("file.glb.node_twice")
        seen.add(number)
        node = file.item("nodes", number)
        motion = above @ _motion(node)
        found.append((node, motion))
        waiting += [(child, motion) for child in reversed(node.get("children", []))]
    return found


def _landmarks(file: _File) -> tuple[Landmark, ...]:
    """The nodes that say that they are landmarks, in metres and the axes of the limb's file."""
    found: list[Landmark] = []
    for node, motion in _placed(file):
        extras = node.get("extras")
        if isinstance(extras, dict) and cast(dict[str, Any], extras).get(_MARKED) is True:
            place = _Z_UP_FROM_Y_UP @ motion[:3, 3]
            if not np.isfinite(place).all():
                raise ContentError("file.glb.landmark")
            found.append(Landmark(name=_shown(str(node["name"])), position_mm=place))
    return tuple(found)


def _motion(node: dict[str, Any]) -> Float64[np.ndarray, "4 4"]:
    """From a node's axes to those of the one above."""
    if "matrix" in node:
        motion = _floats(node["matrix"], 16).reshape(4, 4).T
        if not np.array_equal(motion[3], [0, 0, 0, 1]):
            raise ContentError("file.glb.matrix")
    else:
        x, y, z, w = _floats(node.get("rotation", [0, 0, 0, 1]), 4)
        if abs(x * x + y * y + z * z + w * w - 1) > 2 * _TURNED:
            raise ContentError("file.glb.rotation")
        motion = np.eye(4)
        motion[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        motion[:3, :3] *= _floats(node.get("scale", [1, 1, 1]), 3)
        motion[:3, 3] = _floats(node.get("translation", [0, 0, 0]), 3)
    return motion


def _part(file: _File, drawing: dict[str, Any], motion: Float64[np.ndarray, "4 4"]) -> _Part:
    strange = sorted(set(drawing) - _OF_DRAWING)
    if strange:
        raise ContentError("file.glb.strange", name=strange[0][:40])
    attributes: dict[str, Any] = drawing["attributes"]
    rows, _ = file.array(attributes["POSITION"], ("VEC3",))
    if rows.dtype.kind != "f":
        raise ContentError("file.glb.places")
    count = len(rows)
    if "indices" in drawing:
        listed, _ = file.array(drawing["indices"], ("SCALAR",))
        if listed.dtype.kind != "u":
            raise ContentError("file.glb.corners")
        corners = listed[:, 0].astype(np.int64)
    else:
        corners = np.arange(count)
    if corners.max(initial=-1) >= count:
        raise ContentError("file.glb.corner", vertex=int(corners.max()), vertices=count)
    faces = _triangles(corners, drawing.get("mode", _TRIANGLES))
    if np.linalg.det(motion[:3, :3]) < 0:
        faces = faces[:, ::-1]
    return _Part(
        places=rows.astype(np.float64) @ motion[:3, :3].T + motion[:3, 3],
        faces=faces,
        colours=_colours(file, attributes, count),
        sigma=_sigma(file, attributes, count),
    )


def _triangles(corners: Int64[np.ndarray, " k"], mode: Any) -> Int64[np.ndarray, "f 3"]:
    if mode == _TRIANGLES:
        if len(corners) % 3:
            raise ContentError("file.glb.corner_count", corners=len(corners))
        return corners.reshape(-1, 3)
    first, second, third = corners[:-2], corners[1:-1], corners[2:]
    if mode == _STRIP:
        faces = np.column_stack([first, second, third])
        faces[1::2] = faces[1::2, [1, 0, 2]]
        return faces
    if mode == _FAN:
        return np.column_stack([np.full(len(third), corners[0]), second, third])
    raise ContentError("file.glb.mode")


def _colours(file: _File, attributes: dict[str, Any], count: int) -> np.ndarray | None:
    if "COLOR_0" not in attributes:
        return None
    rows, shares = file.array(attributes["COLOR_0"], ("VEC3", "VEC4"))
    if len(rows) != count:
        raise ContentError("file.glb.colour_count", colours=len(rows), vertices=count)
    colours = rows[:, :3]
    writer = str(file.tree["asset"].get("generator", "")).lower()
    shown = any(one in writer for one in _OF_DISPLAYS)
    if colours.dtype.kind == "f":
        if not np.isfinite(colours).all():
            raise ContentError("file.colour.no_number")
        return (
            np.rint(np.clip(colours, 0, 1) * 255).astype(np.uint8) if shown else _displayed(colours)
        )
    if colours.dtype.kind != "u" or colours.dtype.itemsize > 2 or not shares:
        raise ContentError("file.glb.colours")
    if not shown:
        return _displayed(colours / np.iinfo(colours.dtype).max)
    return (colours >> 8 if colours.dtype.itemsize == 2 else colours).astype(np.uint8)


def _sigma(file: _File, attributes: dict[str, Any], count: int) -> np.ndarray | None:
    """Sigmas of our own files, in metres; -1 there says that there is none."""
    if _SIGMA not in attributes:
        return None
    rows, _ = file.array(attributes[_SIGMA], ("SCALAR",))
    sigma = rows[:, 0].astype(np.float32)
    if len(sigma) != count:
        raise ContentError("file.glb.sigma_count", sigmas=len(sigma), vertices=count)
    none = sigma == -1
    if not (none | ((sigma >= 0) & np.isfinite(sigma))).all():
        raise ContentError("file.glb.sigma")
    return np.where(none, np.nan, sigma).astype(np.float32)


def _floats(listed: Any, count: int) -> Float64[np.ndarray, " k"]:
    numbers = np.array(listed, np.float64)
    if numbers.shape != (count,):
        raise ContentError("file.glb.number_count", found=numbers.size, wanted=count)
    return numbers


def _whole(number: Any, what: str) -> int:
    """A whole number from 0: lists are counted, and none has an end that counts backwards."""
    if isinstance(number, bool) or not isinstance(number, int) or number < 0:
        raise ContentError("file.glb.no_whole", what=what, found=str(number)[:20])
    return number


def _why(error: Exception) -> Finding:
    """What went wrong; of what Python says no more than a line."""
    if isinstance(error, KeyError):
        return fault("file.glb.missing", name=str(error.args[0]))
    return reason_of(error).with_texts(lambda text: text[:200])


def _finite_metres(sigma_mm: Float32[np.ndarray, " n"]) -> Float32[np.ndarray, " n"]:
    """Sigmas in metres; what has none is negative."""
    return np.where(np.isfinite(sigma_mm), sigma_mm * _METRE, -1.0).astype(np.float32)


FORMAT = Format(
    suffix=".glb",
    place=50,
    used_for={"en": "viewers", "de": "Betrachter"},
    read=read_glb,
    write=write_glb,
    write_marked=write_marked_glb,
    keeps=frozenset({"colours", "sigma"}),
    within_mm=1e-4,
    unit="m",
)
