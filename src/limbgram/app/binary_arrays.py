"""Binary arrays: blocks as one binary answer, little-endian, that a browser lays views over.

    bytes 0 to 3    LGM1
    bytes 4 to 7    length of the header, unsigned, a multiple of 4
    then            the header, JSON in UTF-8, filled up with spaces
    then            the blocks, each beginning at a multiple of 4 behind the header

The header has `blocks`, a list of {"name", "type", "shape", "offset", "bytes"}, where offset counts
from the end of the header and type is one of float32, uint32, uint8; and what else belongs to it.

A surface has positions (float32, n x 3, mm), indices (uint32, f x 3, counter-clockwise seen from
outside), normals (float32, n x 3), flags (uint8, n: 1 filled in, not measured), and where they are
known sigma (float32, n, one standard deviation in mm, NaN where filled in) and colours (uint8,
n x 3, sRGB).

A change of a surface has the numbers of vertices and faces that there are then, and changed
(uint32, k) with positions (k x 3), flags and colours, and faces_changed (uint32, m) with indices
(m x 3): numbers beyond those that were there before are new ones. The client keeps all others, and
makes the normals round what changed anew.
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from limbgram.core.mesh.mesh import Mesh, changed_rows
from limbgram.workbench.edits.pressing import changed_vertices

_MAGIC = b"LGM1"


def encode_blocks(header: Mapping[str, Any], blocks: Mapping[str, np.ndarray]) -> bytes:
    """Arrays and what belongs to them as one answer."""
    listed: list[dict[str, Any]] = []
    parts: list[bytes] = []
    offset = 0
    for name, array in blocks.items():
        plain = _plain(array)
        content = plain.tobytes()
        kind = {"f4": "float32", "u4": "uint32", "u1": "uint8"}[plain.dtype.str[1:]]
        listed.append(
            {
                "name": name,
                "type": kind,
                "shape": list(plain.shape),
                "offset": offset,
                "bytes": len(content),
            }
        )
        room = -len(content) % 4
        parts += [content, bytes(room)]
        offset += len(content) + room
    text = json.dumps({**header, "blocks": listed}, allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    return b"".join([_MAGIC, len(text).to_bytes(4, "little"), text, *parts])


def decode_blocks(content: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """What `encode_blocks` wrote; also what a program in Python reads an answer by."""
    if content[:4] != _MAGIC:
        raise ValueError("it does not begin as blocks do")
    start = 8 + int.from_bytes(content[4:8], "little")
    header: dict[str, Any] = json.loads(content[8:start])
    blocks: dict[str, np.ndarray] = {}
    for one in header["blocks"]:
        kind = np.dtype(one["type"]).newbyteorder("<")
        count = one["bytes"] // kind.itemsize
        flat = np.frombuffer(content, kind, count, start + one["offset"])
        blocks[one["name"]] = flat.reshape(one["shape"])
    return header, blocks


def surface_blocks(mesh: Mesh, header: Mapping[str, Any]) -> bytes:
    """A whole surface."""
    return encode_blocks(
        {"what": "surface", "vertices": len(mesh), "faces": len(mesh.faces), **header},
        {
            "positions": mesh.vertices_mm,
            "indices": mesh.faces,
            "normals": mesh.vertex_normals(),
            **_of_vertices(mesh, np.arange(len(mesh))),
        },
    )


def change_blocks(before: Mesh, after: Mesh, header: Mapping[str, Any]) -> bytes | None:
    """What makes one surface of another; None where the whole one is shorter."""
    changed = np.flatnonzero(changed_vertices(before, after))
    faces = np.flatnonzero(changed_rows(before.faces, after.faces))
    if 2 * len(changed) > len(after) or 2 * len(faces) > len(after.faces):
        return None
    return encode_blocks(
        {"what": "change", "vertices": len(after), "faces": len(after.faces), **header},
        {
            "changed": changed,
            "positions": after.vertices_mm[changed],
            "faces_changed": faces,
            "indices": after.faces[faces],
            **_of_vertices(after, changed),
        },
    )


def _of_vertices(mesh: Mesh, chosen: np.ndarray) -> dict[str, np.ndarray]:
    filled = ~mesh.measured
    blocks: dict[str, np.ndarray] = {"flags": filled[chosen].astype(np.uint8)}
    if mesh.sigma_mm is not None:
        blocks["sigma"] = mesh.sigma_mm[chosen]
    if mesh.colours is not None:
        blocks["colours"] = mesh.colours[chosen]
    return blocks


def _plain(array: np.ndarray) -> np.ndarray:
    """In one of the three types, little-endian, in rows."""
    if array.dtype == np.uint8:
        return np.ascontiguousarray(array)
    kind = "<f4" if array.dtype.kind == "f" else "<u4"
    return np.ascontiguousarray(array, kind)
