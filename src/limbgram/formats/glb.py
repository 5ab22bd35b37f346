"""GLB: the surface for viewers, with colour and sigma.

glTF's unit is the metre, and +Y is up (Khronos, glTF 2.0, 2021). The reader turns +Y to +Z; the
writer adds a node that turns +Z to +Y, so that viewers show the limb standing. Vertex colours are
linear in glTF; some programs write sRGB instead, as earlier versions of this one did, and their
files are recognised by the generator's name. The attribute _SIGMA has each vertex's standard
deviation in metres, -1 where it was filled, for glTF has no NaN. Landmarks are nodes, marked in
their extras. Triangles, strips and fans are read, through all nodes of the scene. Compressed files
are refused by name.

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
from typing import Any, cast

import numpy as np
from jaxtyping import Float32, Float64, Int64

from limbgram.core.errors import ShapeFileError, reason_of
from limbgram.core.files import ContentError, json_of, other, require, write_bytes
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import Finding, fault, note
from limbgram.formats.format import Format
from limbgram.formats.triangle_soup import Soup
from limbgram.formats.writing import Unit, require_same_triangles, single_precision, target
from limbgram.reconstruction.photos.decoding import LINEAR_OF_SRGB
from limbgram.workbench.limb import Landmark

_Z_UP_FROM_Y_UP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
_M_PER_MM = 0.001
_SIGMA = "_SIGMA"
_MAGIC, _JSON, _BIN = b"glTF", 0x4E4F534A, 0x004E4942
_DTYPE_OF_CODE = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_CODE_OF_DTYPE = {kind: code for code, kind in _DTYPE_OF_CODE.items()}
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963
"""Targets of a buffer view: vertex attributes, or vertex indices."""
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_GENERATOR = "limbgram"
_LANDMARK_EXTRA = "landmark"
_SRGB_WRITERS = ("trimesh", "open3d")
"""Generators that write sRGB (seen: trimesh 5.2, Open3D 0.20); earlier versions used trimesh."""
_DATA_URI = "data:application/"
_APPEARANCE_EXTENSIONS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_")
"""Prefixes of extensions that change no triangle."""
_PRIMITIVE_KEYS = {"attributes", "indices", "material", "mode", "targets", "extensions", "extras"}
"""All keys of a primitive: with `indices` misspelt, other triangles would be read."""
_MOST_INDICES = 60_000_000
_QUATERNION_TOLERANCE = 1e-3
"""A quaternion's length is 1 within this."""
_LONGEST_NAME = 300


def read_glb(content: bytes, name: str) -> Soup:
    """All surfaces of the scene as one, in metres."""
    try:
        file = _File.of(content)
        parts, skipped = _primitives(file)
        landmarks = _landmarks(file)
    except (ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise ShapeFileError("file.glb.unread", name=name, why=_why(error)) from error
    if not parts:
        raise ShapeFileError("file.glb.empty", name=name)
    starts = np.cumsum([0, *(len(part.positions) for part in parts[:-1])])
    positions = np.concatenate([part.positions for part in parts]) @ _Z_UP_FROM_Y_UP.T
    faces = np.concatenate([part.faces + start for part, start in zip(parts, starts)])
    colours = [part.colours for part in parts if part.colours is not None]
    sigma = parts[0].sigma if len(parts) == 1 else None
    mesh = Mesh(
        vertices_mm=positions,
        faces=faces.astype(np.int32),
        colours=np.concatenate(colours) if len(colours) == len(parts) else None,
        sigma_mm=sigma,
    )
    notes = (note("file.glb.passed_over", drawings=skipped),) if skipped else ()
    return Soup(mesh=mesh, stated_unit="m", landmarks=landmarks, notes=notes)


def write_glb(mesh: Mesh, path: Path | str, unit: Unit, *, unscaled: bool = False) -> Path:
    """Write a binary glTF in metres with normals, and read it back in units of the mesh."""
    return _write(mesh, target(path, unit, unscaled=unscaled), unit, ())


def write_marked_glb(mesh: Mesh, path: Path | str, landmarks: Sequence[Landmark]) -> Path:
    """Write the same with each landmark as a named node, which viewers show as an empty object."""
    return _write(mesh, Path(path), "mm", landmarks)


def _write(mesh: Mesh, path: Path, unit: Unit, landmarks: Sequence[Landmark]) -> Path:
    content = _encoded(mesh, unit, landmarks)

    def check(written: Path) -> None:
        read = read_glb(written.read_bytes(), path.name)
        corners_mm = (read.mesh.vertices_mm / _M_PER_MM)[read.mesh.faces]
        require_same_triangles(path.name, corners_mm, mesh, 2 * single_precision(mesh))
        require(_same(read.mesh.colours, mesh.colours), other(path.name, "colours"))
        sigma_mm = mesh.sigma_mm
        sigma_m = None if sigma_mm is None else (sigma_mm * _M_PER_MM).astype(np.float32)
        require(_same(read.mesh.sigma_mm, sigma_m), other(path.name, "sigmas"))
        require(_same_landmarks(read.landmarks, landmarks), other(path.name, "landmarks"))

    return write_bytes(path, content, check)


def _same(one: np.ndarray | None, two: np.ndarray | None) -> bool:
    if one is None or two is None:
        return one is two
    return np.array_equal(one, two, equal_nan=one.dtype.kind == "f")


def _same_landmarks(found: Sequence[Landmark], written: Sequence[Landmark]) -> bool:
    """Names and places, within a nanometre; what is read is in metres."""
    return [mark.name for mark in found] == [
        _printable_name(mark.name) for mark in written
    ] and all(
        np.allclose(one.position_mm / _M_PER_MM, two.position_mm, rtol=0, atol=1e-6)
        for one, two in zip(found, written, strict=True)
    )


def _encoded(mesh: Mesh, unit: Unit, landmarks: Sequence[Landmark]) -> bytes:
    """The whole file: the JSON chunk, and the binary chunk with its arrays."""
    attributes = _attributes(mesh)
    arrays = [*attributes.values(), mesh.faces.astype("<u4").ravel()]
    binary = b"".join(array.tobytes() for array in arrays)
    described = json.dumps(
        _tree(attributes, arrays, unit, landmarks), separators=(",", ":")
    ).encode()
    described += b" " * (-len(described) % 4)
    chunks = (
        struct.pack("<II", len(described), _JSON) + described,
        struct.pack("<II", len(binary), _BIN) + binary,
    )
    return _MAGIC + struct.pack("<II", 2, 12 + sum(map(len, chunks))) + b"".join(chunks)


def _attributes(mesh: Mesh) -> dict[str, np.ndarray]:
    """The vertex attributes, each an array of 4-byte values."""
    attributes: dict[str, np.ndarray] = {
        "POSITION": (mesh.vertices_mm * _M_PER_MM).astype("<f4"),
        "NORMAL": _unit_normals(mesh).astype("<f4"),
    }
    if mesh.colours is not None:
        # As floats: trimesh 5.2 misreads 16-bit integers.
        attributes["COLOR_0"] = LINEAR_OF_SRGB[mesh.colours].astype("<f4")
    if mesh.sigma_mm is not None:
        attributes[_SIGMA] = _sigma_m(mesh.sigma_mm)
    return attributes


def _tree(
    attributes: dict[str, np.ndarray],
    arrays: list[np.ndarray],
    unit: Unit,
    landmarks: Sequence[Landmark],
) -> dict[str, Any]:
    """The JSON of a file whose arrays are the attributes and the vertex indices, in this order."""
    ends = np.cumsum([array.nbytes for array in arrays])
    views = [
        {
            "buffer": 0,
            "byteOffset": int(end - array.nbytes),
            "byteLength": array.nbytes,
            "target": _ELEMENT_ARRAY_BUFFER if array is arrays[-1] else _ARRAY_BUFFER,
        }
        for array, end in zip(arrays, ends)
    ]
    accessors: list[dict[str, Any]] = [_accessor(idx, array) for idx, array in enumerate(arrays)]
    positions = attributes["POSITION"]
    accessors[0] |= {"min": positions.min(0).tolist(), "max": positions.max(0).tolist()}
    matrix = np.eye(4)
    matrix[:3, :3] = _Z_UP_FROM_Y_UP.T
    surface: dict[str, Any] = {"name": "surface", "mesh": 0, "matrix": matrix.T.ravel().tolist()}
    if landmarks:
        surface["children"] = list(range(1, len(landmarks) + 1))
    primitive = {
        "attributes": {name: idx for idx, name in enumerate(attributes)},
        "indices": len(attributes),
    }
    return {
        "asset": {"version": "2.0", "generator": _GENERATOR},
        "scene": 0,
        "scenes": [{"nodes": [0], "extras": {"source_unit": unit}}],
        "nodes": [surface, *map(_node, landmarks)],
        "meshes": [{"primitives": [primitive]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": int(ends[-1])}],
    }


def _accessor(idx: int, array: np.ndarray) -> dict[str, Any]:
    width = 1 if array.ndim == 1 else array.shape[1]
    return {
        "bufferView": idx,
        "componentType": _CODE_OF_DTYPE[array.dtype.str],
        "count": len(array),
        "type": "SCALAR" if width == 1 else f"VEC{width}",
    }


def _node(mark: Landmark) -> dict[str, Any]:
    """A landmark's node, a child of the surface's node and in its axes."""
    place = (mark.position_mm * _M_PER_MM).tolist()
    return {
        "name": _printable_name(mark.name),
        "translation": place,
        "extras": {_LANDMARK_EXTRA: True},
    }


def _printable_name(name: str) -> str:
    """A landmark's name without unprintable characters."""
    return "".join(letter for letter in name if letter.isprintable())[:_LONGEST_NAME]


def _unit_normals(mesh: Mesh) -> Points3:
    """Vertex normals of length 1, as glTF demands; +Z where all faces of a vertex have no area."""
    normals = mesh.vertex_normals()
    normals[~normals.any(1)] = (0.0, 0.0, 1.0)
    return normals


def _srgb_from_linear(linear: np.ndarray) -> np.ndarray:
    """sRGB, 0 to 255, of linear colours, 0 to 1 (IEC 61966-2-1)."""
    linear = np.clip(linear, 0, 1)
    srgb = np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.rint(srgb * 255).astype(np.uint8)


@dataclass(frozen=True)
class _File:
    """The JSON of a file, and its buffers."""

    tree: dict[str, Any]
    buffers: tuple[bytes, ...]
    """Only the first may be the file's binary chunk."""

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
            if not str(needed).startswith(_APPEARANCE_EXTENSIONS):
                raise ContentError("file.glb.needs", extension=str(needed)[:60])
        buffers: list[dict[str, Any]] = tree.get("buffers", [])
        inside = [chunks.get(_BIN), *(None for _ in buffers[1:])]
        return cls(tree, tuple(_buffer_bytes(*one) for one in zip(buffers, inside)))

    def item(self, kind: str, number: Any) -> dict[str, Any]:
        """An object of one of the tree's lists."""
        listed = self.tree[kind]
        if not isinstance(listed, list):
            raise ContentError("file.glb.no_list", kind=kind)
        found = cast(list[object], listed)[_index(number, kind)]
        if not isinstance(found, dict):
            raise ContentError("file.glb.no_object", kind=kind)
        return cast(dict[str, Any], found)

    def array(self, number: Any, widths: tuple[str, ...]) -> tuple[np.ndarray, bool]:
        """An accessor's rows, and whether its integers are normalised."""
        accessor = self.item("accessors", number)
        kind, count = accessor["type"], _index(accessor["count"], "count")
        if kind not in widths or "sparse" in accessor:
            raise ContentError("file.glb.numbers", kind=str(kind)[:20])
        view = self.item("bufferViews", accessor["bufferView"])
        buffer = self.buffers[_index(view["buffer"], "buffer")]
        cell = np.dtype(_DTYPE_OF_CODE[accessor["componentType"]])
        width = _COMPONENTS[kind]
        start = _index(view.get("byteOffset", 0), "byteOffset")
        end = start + _index(view["byteLength"], "byteLength")
        first = start + _index(accessor.get("byteOffset", 0), "byteOffset")
        step = _index(view.get("byteStride", 0), "byteStride") or width * cell.itemsize
        last = first + (count - 1) * step + width * cell.itemsize
        if not count or step < width * cell.itemsize or last > end or end > len(buffer):
            raise ContentError("file.glb.beyond_numbers")
        rows = np.ndarray((count, width), cell, buffer, first, strides=(step, cell.itemsize))
        return rows, bool(accessor.get("normalized", False))


def _buffer_bytes(buffer: dict[str, Any], chunk: bytes | None) -> bytes:
    """The bytes of a buffer: the binary chunk, or a data URI, which Open3D writes.

    chunk: The file's binary chunk, for the first buffer only.
    """
    if "uri" not in buffer and chunk is not None:
        return chunk
    uri = str(buffer.get("uri", ""))
    head, mark, text = uri.partition(";base64,")
    if not (mark and head.startswith(_DATA_URI)):
        raise ContentError("file.glb.elsewhere")
    try:
        return base64.b64decode(text, validate=True)
    except binascii.Error as error:
        raise ContentError("file.glb.no_base64") from error


@dataclass(frozen=True)
class _Primitive:
    """A primitive's triangles in the scene's axes."""

    positions: Points3
    faces: Int64[np.ndarray, "f 3"]
    colours: np.ndarray | None
    sigma: np.ndarray | None


def _primitives(file: _File) -> tuple[list[_Primitive], int]:
    """The triangles of every node of the scene; and the number of primitives of points or lines."""
    found: list[_Primitive] = []
    skipped = size = 0
    for node, scene_from_node in _nodes_in_scene(file):
        if "mesh" not in node:
            continue
        for listed in file.item("meshes", node["mesh"])["primitives"]:
            if listed.get("mode", _TRIANGLES) in (0, 1, 2, 3):
                skipped += 1
                continue
            primitive = _primitive(file, listed, scene_from_node)
            size += 3 * len(primitive.faces) + len(primitive.positions)
            if size > _MOST_INDICES:
                raise ContentError("file.glb.too_many")
            found.append(primitive)
    return found, skipped


def _nodes_in_scene(file: _File) -> list[tuple[dict[str, Any], Float64[np.ndarray, "4 4"]]]:
    """The nodes of the scene, each with its matrix scene_from_node."""
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
        number, scene_from_parent = waiting.pop()
        if _index(number, "node") in seen:
            raise ContentError("file.glb.node_twice")
        seen.add(number)
        node = file.item("nodes", number)
        scene_from_node = scene_from_parent @ _parent_from_node(node)
        found.append((node, scene_from_node))
        waiting += [(child, scene_from_node) for child in reversed(node.get("children", []))]
    return found


def _landmarks(file: _File) -> tuple[Landmark, ...]:
    """The nodes that are marked as landmarks, in metres, with +Z up."""
    found: list[Landmark] = []
    for node, scene_from_node in _nodes_in_scene(file):
        extras = node.get("extras")
        if isinstance(extras, dict) and cast(dict[str, Any], extras).get(_LANDMARK_EXTRA) is True:
            position = _Z_UP_FROM_Y_UP @ scene_from_node[:3, 3]
            if not np.isfinite(position).all():
                raise ContentError("file.glb.landmark")
            found.append(Landmark(name=_printable_name(str(node["name"])), position_mm=position))
    return tuple(found)


def _parent_from_node(node: dict[str, Any]) -> Float64[np.ndarray, "4 4"]:
    """A node's matrix, or the one of its rotation, scale and translation."""
    if "matrix" in node:
        motion = _floats(node["matrix"], 16).reshape(4, 4).T
        if not np.array_equal(motion[3], [0, 0, 0, 1]):
            raise ContentError("file.glb.matrix")
    else:
        x, y, z, w = _floats(node.get("rotation", [0, 0, 0, 1]), 4)
        if abs(x * x + y * y + z * z + w * w - 1) > 2 * _QUATERNION_TOLERANCE:
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


def _primitive(
    file: _File, listed: dict[str, Any], scene_from_node: Float64[np.ndarray, "4 4"]
) -> _Primitive:
    unknown = sorted(set(listed) - _PRIMITIVE_KEYS)
    if unknown:
        raise ContentError("file.glb.strange", name=unknown[0][:40])
    attributes: dict[str, Any] = listed["attributes"]
    rows, _ = file.array(attributes["POSITION"], ("VEC3",))
    if rows.dtype.kind != "f":
        raise ContentError("file.glb.places")
    count = len(rows)
    if "indices" in listed:
        column, _ = file.array(listed["indices"], ("SCALAR",))
        if column.dtype.kind != "u":
            raise ContentError("file.glb.corners")
        indices = column[:, 0].astype(np.int64)
    else:
        indices = np.arange(count)
    if indices.max(initial=-1) >= count:
        raise ContentError("file.glb.corner", vertex=int(indices.max()), vertices=count)
    faces = _triangles(indices, listed.get("mode", _TRIANGLES))
    linear, translation = scene_from_node[:3, :3], scene_from_node[:3, 3]
    if np.linalg.det(linear) < 0:  # a mirror image: turn the faces back
        faces = faces[:, ::-1]
    return _Primitive(
        positions=rows.astype(np.float64) @ linear.T + translation,
        faces=faces,
        colours=_colours(file, attributes, count),
        sigma=_sigma(file, attributes, count),
    )


def _triangles(indices: Int64[np.ndarray, " k"], mode: Any) -> Int64[np.ndarray, "f 3"]:
    """Triangles of a list, a strip or a fan of vertex indices."""
    if mode == _TRIANGLES:
        if len(indices) % 3:
            raise ContentError("file.glb.corner_count", corners=len(indices))
        return indices.reshape(-1, 3)
    first, second, third = indices[:-2], indices[1:-1], indices[2:]
    if mode == _STRIP:
        faces = np.column_stack([first, second, third])
        faces[1::2] = faces[1::2, [1, 0, 2]]
        return faces
    if mode == _FAN:
        return np.column_stack([np.full(len(third), indices[0]), second, third])
    raise ContentError("file.glb.mode")


def _colours(file: _File, attributes: dict[str, Any], count: int) -> np.ndarray | None:
    if "COLOR_0" not in attributes:
        return None
    rows, normalised = file.array(attributes["COLOR_0"], ("VEC3", "VEC4"))
    if len(rows) != count:
        raise ContentError("file.glb.colour_count", colours=len(rows), vertices=count)
    colours = rows[:, :3]
    generator = str(file.tree["asset"].get("generator", "")).lower()
    is_srgb = any(one in generator for one in _SRGB_WRITERS)
    if colours.dtype.kind == "f":
        if not np.isfinite(colours).all():
            raise ContentError("file.colour.no_number")
        if not is_srgb:
            return _srgb_from_linear(colours)
        return np.rint(np.clip(colours, 0, 1) * 255).astype(np.uint8)
    if colours.dtype.kind != "u" or colours.dtype.itemsize > 2 or not normalised:
        raise ContentError("file.glb.colours")
    if not is_srgb:
        return _srgb_from_linear(colours / np.iinfo(colours.dtype).max)
    return (colours >> 8 if colours.dtype.itemsize == 2 else colours).astype(np.uint8)


def _sigma(file: _File, attributes: dict[str, Any], count: int) -> np.ndarray | None:
    """The _SIGMA attribute in metres, NaN where the file has -1."""
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


def _index(number: Any, what: str) -> int:
    """A list index or count: an integer from 0, as JSON has it."""
    if isinstance(number, bool) or not isinstance(number, int) or number < 0:
        raise ContentError("file.glb.no_whole", what=what, found=str(number)[:20])
    return number


def _why(error: Exception) -> Finding:
    """The reason of a failed read; of Python's messages one line."""
    if isinstance(error, KeyError):
        return fault("file.glb.missing", name=str(error.args[0]))
    return reason_of(error).with_texts(lambda text: text[:200])


def _sigma_m(sigma_mm: Float32[np.ndarray, " n"]) -> Float32[np.ndarray, " n"]:
    """Sigmas in metres, -1 for NaN."""
    return np.where(np.isfinite(sigma_mm), sigma_mm * _M_PER_MM, -1.0).astype(np.float32)


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
