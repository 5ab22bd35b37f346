"""Mutants: every reader is given thousands of damaged files, and may only read or refuse them.

    python benchmarks/mutants.py all --record

writes results/mutants.json, for 10,000 mutants of each. A mutant is a small whole file with one to
three changes: bytes flipped, cut, put in, repeated or moved; numbers turned into what is none or
beyond all measure; lines and keys left out, repeated or exchanged; trees nested 6,000 deep; and for
files of parts (PLY, GLB, TIFF) the head alone, the parts' lengths set right again. Each must end
within its time and memory in one of two ways: it is read, or refused by a LimbgramError that says
why. Anything else is a fault of ours. Of a shape that is read it is told, too, whether triangles
are missing without a word. A change that leaves a whole file of its format, such as a face taken
out of an OBJ together with its line, can be told by no reader.

    python benchmarks/mutants.py ply-text --count 2000 --seed 7 --keep /tmp/found

keeps the files that were crashed on, so that they can be looked at.
"""

import json
import multiprocessing
import os
import random
import re
import resource
import signal
import struct
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass, field
from io import BytesIO
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from harness import described, machine, made_on
from limbgram.cases.case_assessment import cited
from limbgram.cases.encoding import sealed
from limbgram.cases.folder import CaseFolder
from limbgram.cases.scoring import centres_mm, read_truth_mesh
from limbgram.core.errors import LimbgramError, PhotoError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import PARAMETERS, Camera
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.camera import read_camera, write_camera
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import read_limb
from limbgram.formats.table import FORMATS
from limbgram.formats.units import mm_per_unit_of
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.photos.masks import load_mask
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.services.parse_capture import parse_board, parse_box, read_distances
from limbgram.services.parse_text import (
    colour_of,
    direction,
    landmarks_of,
    pair_of,
    reading_of,
    span_of,
)
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame
from limbgram.workbench.recipe.file import encode_recipe, make_edit, read_recipe
from limbgram.workbench.recipe.recipe import Entry, Recipe
from limbgram.workbench.templates.chart_field import ANGLES, node_heights
from limbgram.workbench.templates.files import encode_template, read_template
from limbgram.workbench.templates.template import Template, TemplateMark

LIMIT_S = 5.0
"""Of processor time for one mutant; a whole file of this size is read in milliseconds."""
_PATIENCE_S = 60.0
"""Of any time: a reader that waits for something takes no processor."""
_GB = 6
LIMIT_BYTES = _GB << 30
"""Address space of a process, of which libraries have a third before they read anything."""
_OVERTIME = 99
_CHUNK = 250
_PROCESSES = 2
_RESULTS = Path(__file__).parent / "results"

_ODD_NUMBERS = (
    b"inf", b"-inf", b"nan", b"-1", b"0", b"1e400", b"-1e400", b"1" + b"0" * 400, b"0.5", b"1e308",
    b"4294967295", b"2147483648", b"-2147483648", b"9" * 20, b"7" * 5000, b"1e-400", b"0x10",
    b"1_0", b"NaN", b"Infinity", b"-0", b"1,5", b"", b"x", b"65536", b"255", b"256", b"3.0",
)  # fmt: skip
_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")

Change = Callable[[random.Random, bytes], bytes]
"""Damages a file."""
Read = Callable[[Path], int | None]
"""Reads a file; the number of triangles of a shape about which nothing odd was said, or None."""


@dataclass(frozen=True)
class Reader:
    """A reader and a whole file for it."""

    name: str
    ending: str
    whole: bytes
    read: Read
    changes: tuple[Change, ...]
    setting: dict[str, bytes] = field(default_factory=dict)
    """Files beside it, by name."""


@dataclass
class Outcome:
    """What became of the mutants of a reader."""

    read: int = 0
    refused: int = 0
    crashed: int = 0
    hung: int = 0
    missing: int = 0
    """Read, with triangles missing and nothing said."""
    slowest_s: float = 0.0
    faults: Counter[str] = field(default_factory=Counter)

    def add(self, other: "Outcome") -> None:
        self.read += other.read
        self.refused += other.refused
        self.crashed += other.crashed
        self.hung += other.hung
        self.missing += other.missing
        self.slowest_s = max(self.slowest_s, other.slowest_s)
        self.faults.update(other.faults)


# Changes that know nothing of the format.


def flip(rng: random.Random, content: bytes) -> bytes:
    changed = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 8))):
        if changed:
            changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def overwrite(rng: random.Random, content: bytes) -> bytes:
    at = rng.randrange(len(content) + 1)
    new = rng.choice((b"\0", b"\xff", b"\x80", rng.randbytes(1))) * rng.choice((1, 2, 4, 8))
    return content[:at] + new + content[at + len(new) :]


def cut(rng: random.Random, content: bytes) -> bytes:
    return content[: rng.randrange(len(content) + 1)]


def insert(rng: random.Random, content: bytes) -> bytes:
    at = rng.randrange(len(content) + 1)
    return content[:at] + rng.randbytes(rng.choice((1, 4, 50))) + content[at:]


def _stretch(rng: random.Random, content: bytes) -> tuple[int, int]:
    start = rng.randrange(len(content) + 1)
    return start, min(len(content), start + rng.choice((1, 4, 12, 50, 400)))


def repeat(rng: random.Random, content: bytes) -> bytes:
    start, end = _stretch(rng, content)
    return content[:end] + content[start:end] * rng.choice((1, 1, 2, 30)) + content[end:]


def leave_out(rng: random.Random, content: bytes) -> bytes:
    start, end = _stretch(rng, content)
    return content[:start] + content[end:]


def move(rng: random.Random, content: bytes) -> bytes:
    start, end = _stretch(rng, content)
    rest = content[:start] + content[end:]
    at = rng.randrange(len(rest) + 1)
    return rest[:at] + content[start:end] + rest[at:]


def number(rng: random.Random, content: bytes) -> bytes:
    """Another number, or none, in place of one that is written in digits."""
    places = list(_NUMBER.finditer(content))
    if not places:
        return content
    place = rng.choice(places)
    return content[: place.start()] + rng.choice(_ODD_NUMBERS) + content[place.end() :]


def word(rng: random.Random, content: bytes) -> bytes:
    """A word in place of another of the same file."""
    words = list(re.finditer(rb"\S+", content))
    if not words:
        return content
    place, other = rng.choice(words), rng.choice(words)
    return content[: place.start()] + other[0] + content[place.end() :]


def line(rng: random.Random, content: bytes) -> bytes:
    """A line left out, repeated, emptied or exchanged with another."""
    lines = content.split(b"\n")
    one, two = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(4):
        case 0:
            del lines[one]
        case 1:
            lines.insert(two, lines[one])
        case 2:
            lines[one] = b""
        case _:
            lines[one], lines[two] = lines[two], lines[one]
    return b"\n".join(lines)


_BLIND = (flip, overwrite, cut, insert, repeat, leave_out, move)
_TEXT = (*_BLIND, number, number, number, word, word, line, line)


# Changes that know the format.


def _somewhere(rng: random.Random, tree: Any) -> tuple[Any, Any] | None:
    """A list or table of a tree and one of its keys."""
    places = list(_places(tree))
    return rng.choice(places) if places else None


def _places(tree: Any) -> Iterator[tuple[Any, Any]]:
    keys = tree.keys() if isinstance(tree, dict) else range(len(tree))
    for key in keys:
        yield tree, key
        if isinstance(tree[key], dict | list):
            yield from _places(tree[key])


_ODD_VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 0.5, 10**400, 1e308, 2**31, 2**63, "", "x", [], {}, [[]], [1, "2", None],
    {"a": 1}, float("nan"), float("inf"), "\ud800", "\x1b[2J", "x" * 5000, -0.0, 1e-320,
)  # fmt: skip


def tree(rng: random.Random, content: bytes) -> bytes:
    """A JSON text with a key gone, a value of another kind, or lists without end."""
    try:
        known = json.loads(content)
    except (ValueError, RecursionError):
        return flip(rng, content)
    found = _somewhere(rng, known) if isinstance(known, dict | list) else None
    if found is None:
        return content
    holder, key = found
    deep: str | None = None
    match rng.randrange(5):
        case 0:
            del holder[key]
        case 1:
            other = _somewhere(rng, known)
            holder[key] = json.loads(json.dumps(other[0][other[1]])) if other else None
        case 2 if isinstance(holder, list):
            holder.extend(holder[:] * rng.choice((1, 3)))
        case 3:
            depth = rng.choice((50, 500, 6000))
            deep = rng.choice(("[" * depth + "]" * depth, '{"a":' * depth + "1" + "}" * depth))
            holder[key] = "DEEP"
        case _:
            holder[key] = rng.choice(_ODD_VALUES)
    text = json.dumps(known)
    return (text if deep is None else text.replace('"DEEP"', deep, 1)).encode()


def toml_deep(rng: random.Random, content: bytes) -> bytes:
    """Lists, tables or keys without end in a TOML text."""
    depth = rng.choice((50, 500, 6000))
    new = rng.choice(
        (
            b"a = " + b"[" * depth + b"]" * depth,
            b"a = " + b"{b = " * depth + b"1" + b"}" * depth,
            b"a." * depth + b"b = 1",
            b"[" + b"a." * depth + b"b]",
            b"[[" + b"a." * depth + b"b]]",
            b"passes = 0x" + b"f" * depth,
            b"passes = " + b"7" * depth,
            b"at = 1979-05-27T07:32:00Z",
        )
    )
    lines = content.split(b"\n")
    lines.insert(rng.randrange(len(lines) + 1), new)
    return b"\n".join(lines)


def ply_head(rng: random.Random, content: bytes) -> bytes:
    """Changes of the header alone; what follows stays."""
    head, mark, body = content.partition(b"end_header\n")
    if rng.random() < 0.4:
        kinds = (b"char", b"uchar", b"short", b"int", b"uint", b"float", b"double", b"int8")
        words = list(re.finditer(rb"\b(?:u?char|int|float|double)\b", head))
        if words:
            place = rng.choice(words)
            head = head[: place.start()] + rng.choice(kinds) + head[place.end() :]
    else:
        head = rng.choice((number, word, line, flip))(rng, head)
    return head + mark + body


def ply_count(rng: random.Random, content: bytes) -> bytes:
    """A byte of what follows the header, at the beginning of a face more often than not."""
    head, mark, body = content.partition(b"end_header\n")
    changed = bytearray(body)
    if changed:
        changed[rng.randrange(len(changed) // 2, len(changed))] = rng.choice((0, 1, 2, 4, 127, 255))
    return head + mark + bytes(changed)


def glb_tree(rng: random.Random, content: bytes) -> bytes:
    """Changes of the JSON part, with all lengths right again."""
    if len(content) < 28 or content[:4] != b"glTF":
        return flip(rng, content)
    size = struct.unpack_from("<I", content, 12)[0]
    text, rest = content[20 : 20 + size], content[20 + size :]
    text = rng.choice((tree, tree, tree, number, flip, overwrite))(rng, text)
    text += b" " * (-len(text) % 4)
    whole = 20 + len(text) + len(rest)
    return struct.pack("<4sIIII", b"glTF", 2, whole, len(text), 0x4E4F534A) + text + rest


def glb_head(rng: random.Random, content: bytes) -> bytes:
    """Another number in one of the lengths or kinds of the parts."""
    places = [4, 8, 12, 16]
    if len(content) >= 20:
        places += [20 + struct.unpack_from("<I", content, 12)[0] + k for k in (0, 4)]
    at = rng.choice([place for place in places if place + 4 <= len(content)] or [0])
    odd = rng.choice((0, 1, 3, 2**31, 2**32 - 1, rng.randrange(2**32)))
    return content[:at] + struct.pack("<I", odd) + content[at + 4 :]


def word32(rng: random.Random, content: bytes) -> bytes:
    """Another number where four bytes may be one."""
    at = rng.randrange(max(1, len(content) // 4)) * 4 + rng.choice((0, 0, 2))
    odd = rng.choice((0, 1, 2**31, 2**32 - 1, 0x7F800000, 0xFF800000, 0x7FC00000, 0x3F000000))
    order = rng.choice("<>")
    return content[:at] + struct.pack(order + "I", odd) + content[at + 4 :]


def beginning(rng: random.Random, content: bytes) -> bytes:
    """Changes among the first bytes, where pictures have their tables."""
    size = min(len(content), 700)
    return rng.choice((*_BLIND, word32))(rng, content[:size]) + content[size:]


# Whole files, and how they are read.


def _mesh() -> Mesh:
    ball = trimesh.creation.icosphere(subdivisions=1, radius=60.0)
    count = len(ball.vertices)
    rng = np.random.default_rng(5)
    filled = np.arange(count) % 5 == 0
    sigma = rng.uniform(0.01, 0.2, count)
    return Mesh(
        vertices_mm=np.asarray(ball.vertices).round(3),
        faces=np.asarray(ball.faces, np.int32),
        colours=rng.integers(0, 256, (count, 3), np.uint8),
        filled=filled,
        sigma_mm=np.where(filled, np.nan, sigma).astype(np.float32),
        shared_mm=rng.normal(0, 0.05, (count, 2)).astype(np.float32),
        correlation_mm=4.0,
    )


def _shape(path: Path) -> int | None:
    limb = read_limb(path)
    return None if limb.notes else len(limb.mesh.faces)


def _beside(path: Path) -> int | None:
    """The limb file, by the mesh that it describes."""
    read_limb(path.with_name("scan.ply"))
    return None


def _void(read: Callable[[Path], object]) -> Read:
    def reading(path: Path) -> int | None:
        read(path)
        return None

    return reading


def _photo(path: Path) -> int | None:
    """A photo beside a whole one; set aside by name is refused."""
    found = read_photos([path, path.with_name("whole.png")])
    if found.set_aside:
        raise PhotoError.of(found.set_aside[0].reason)
    return None


def _mask(path: Path) -> int | None:
    found = read_photos([path.with_name("whole.png"), path.with_name("other.png"), path])
    if found.set_aside:
        raise PhotoError.of(found.set_aside[0].reason)
    for photo in found.photos:
        load_mask(photo)
    return None


def _typed(path: Path) -> int | None:
    """What people type, each line by the one that reads it."""
    readers: dict[str, Callable[[str], object]] = {
        "board": parse_board,
        "box": parse_box,
        "unit": mm_per_unit_of,
        "axis": lambda text: direction(text, "--axis"),
        "colour": colour_of,
        "landmark": lambda text: landmarks_of([text], [np.zeros(3)]),
        "length": lambda text: pair_of(text, "--length"),
        "volume": span_of,
        "tape": reading_of,
    }
    for line_typed in path.read_bytes().decode("utf-8", "surrogateescape").split("\n"):
        kind, _, text = line_typed.partition(" ")
        readers.get(kind, parse_box)(text)
    return None


def _ascii_ply(mesh: Mesh) -> bytes:
    head = "ply\nformat ascii 1.0\ncomment by hand\n"
    head += f"element vertex {len(mesh)}\nproperty float x\nproperty float y\nproperty float z\n"
    head += "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float sigma\n"
    head += f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    assert mesh.colours is not None
    rows = [
        " ".join([*(f"{x:g}" for x in place), *map(str, colour), "0.1"])
        for place, colour in zip(mesh.vertices_mm.tolist(), mesh.colours.tolist())
    ]
    rows += [" ".join(map(str, (3, *face))) for face in mesh.faces.tolist()]
    return ("\n".join([head + rows[0], *rows[1:]]) + "\n").encode()


def _polygon_ply(mesh: Mesh) -> bytes:
    """Binary, big-endian, with a face of four corners among those of three."""
    head = f"ply\nformat binary_big_endian 1.0\nelement vertex {len(mesh)}\nproperty float x\n"
    head += f"property float y\nproperty float z\nelement face {len(mesh.faces)}\n"
    head += "property list char int vertex_indices\nend_header\n"
    faces = [[*face] for face in mesh.faces.tolist()]
    faces[0].append(faces[0][0])
    body = mesh.vertices_mm.astype(">f4").tobytes()
    return head.encode() + body + b"".join(struct.pack(f">b{len(f)}i", len(f), *f) for f in faces)


def _text_stl(mesh: Mesh) -> bytes:
    rows = ["solid ball"]
    for corners in mesh.vertices_mm[mesh.faces].tolist():
        rows += ["facet normal 0 0 1", "outer loop"]
        rows += [f"vertex {x:g} {y:g} {z:g}" for x, y, z in corners]
        rows += ["endloop", "endfacet"]
    return ("\n".join([*rows, "endsolid ball"]) + "\n").encode()


def _aop() -> bytes:
    rows = ["AAOP1", "AAOP1", "by hand", "END COMMENTS", "CYLINDRICAL", "RIGHT", "2"]
    rows += ["FIB", "1", "52.1", "90", "30", "TIB", "2", "50", "0", "10", "50", "180", "60"]
    rows += ["12", "30", "6", "0", "0", "15", "30", "50", "75", "90"]
    rows += [f"{50 + k % 5}.25" for k in range(12 * 6)]
    return ("\r\n".join(rows) + "\r\n").encode()


def _recipe() -> bytes:
    edits = (
        ("smoothing", {"passes": 8, "leave": ["fibula head", [1, 2.5, 3]]}),
        ("reduction", {"heights_mm": [30.0, 200.0], "per_cent": [0.0, 4.0], "of": "girth"}),
        ("trimline", {"through": [[1, 2, 3], [4.5, 5, 6], "mid patella"], "keep": "distal"}),
        ("sock", {"thickness_mm": 0.3}),
    )
    entries = tuple(
        Entry(edit=make_edit(kind, values, kind), on=kind != "smoothing") for kind, values in edits
    )
    return encode_recipe(Recipe(name="first fitting", scan_sha256="00ff", entries=entries))


_TYPED = b"""board charuco:7x5:30:22:4X4_50
board checkerboard:14x10:9.98
box -80,-80,5,80,80,400
unit 25.4
axis 0.2,-1,0
colour 230,20,200
landmark fibula head=41.5,-12,250
landmark fibula head=#1
length tibial tubercle:tibia end
volume 20:150
tape 60=312.5"""


def _camera(folder: Path) -> bytes:
    values = (3000.0, 3001.0, 1999.5, 1499.5, 0.0, -0.1, 0.02, 1e-4, -1e-4, 0.0)
    camera = Camera(width_px=4000, height_px=3000, **dict(zip(PARAMETERS, values, strict=True)))
    sigmas = np.array([1, 1, 0.5, 0.5, 0, 1e-3, 1e-3, 1e-5, 1e-5, 0])
    calibration = Calibration(
        camera=camera,
        covariance=np.diag(sigmas**2),
        source="board",
        label="A camera, 28 mm",
        focal_mm=28.0,
        rms_px=0.21,
    )
    write_camera(folder / "camera.json", calibration, {"board": "14x10"})
    return (folder / "camera.json").read_bytes()


def _template() -> bytes:
    heights = node_heights(1.2 + 1e-6)
    shape = (len(heights), ANGLES)
    rng = np.random.default_rng(3)
    spread = rng.uniform(0, 1, shape)
    spread[0] = np.nan
    return encode_template(
        Template(
            name="ptb",
            pairs=3,
            sided=True,
            reference="mid patella",
            marks=(TemplateMark(name="mid patella", height=1.0, angle_deg=0.0),),
            heights=heights,
            displacement_mm=rng.normal(0, 1, shape),
            spread_mm=spread,
            known_pairs=rng.integers(0, 4, shape),
        )
    )


_DISTANCES = json.dumps(
    {
        "distances": [
            {
                "label": "A-C",
                "length_mm": 120,
                "first": [{"photo": "1.jpg", "x_px": 812.5, "y_px": 400.0}] * 2,
                "second": [{"photo": "1.jpg", "x_px": 12.5, "y_px": 40.0}] * 2,
            }
        ]
    }
).encode()


def _truth(mesh: Mesh) -> bytes:
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(mesh)}\nproperty float x\n"
    head += "property float y\nproperty float z\nproperty uchar ncam\nproperty uchar cap\n"
    head += f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    body = b"".join(struct.pack("<3f2B", *place, 3, 0) for place in mesh.vertices_mm.tolist())
    return (
        head.encode()
        + body
        + b"".join(struct.pack("<B3i", 3, *face) for face in mesh.faces.tolist())
    )


_CAMERAS = json.dumps(
    {"images": [{"name": f"{k}.jpg", "R": np.eye(3).tolist(), "t": [k, 0, 1]} for k in range(3)]}
).encode()

_ACCURACY = json.dumps(
    sealed(
        {
            "schema": "limbgram-accuracy/1",
            "unit": "mm",
            "truth": None,
            "light": "green",
            "headline": "GREEN.",
            "lengths": {"check": [{"label": "A-B"}], "check_rms": 0.0004, "check_worst": 0.001},
            "expected": {"rms_mm": 0.05, "p95_mm": 0.1, "basis": "vertex sigmas"},
        }
    )
).encode()
_CASE = json.dumps({"state": "finished", "files": [{"path": "a", "sha256": "00"}]}).encode()


def _picture(kind: str, *, mode: str = "RGB", seed: int = 8, **options: Any) -> bytes:
    rng = np.random.default_rng(seed)
    small = rng.integers(0, 256, (12, 16, 3)).astype(np.uint8)
    picture = Image.fromarray(small).resize((96, 72), Image.Resampling.BILINEAR)
    if mode == "I;16":
        deep = np.asarray(picture.convert("L")).astype(np.uint16) * 257
        picture = Image.fromarray(deep)
    elif mode != "RGB":
        picture = picture.convert(mode)
    stream = BytesIO()
    exif = Image.Exif()
    exif[0x0110] = "A camera"
    exif[0x0112] = 6
    exif.get_ifd(0x8769)[0x920A] = 28.0
    picture.save(stream, kind, exif=exif, **options)
    return stream.getvalue()


_KNOWING: dict[str, tuple[Change, ...]] = {
    ".stl": (word32, word32),
    ".ply": (word32, *3 * (ply_head,), ply_count),
    ".glb": (*5 * (glb_tree,), glb_head, word32),
}
"""Changes that know a format, beside those of all bytes, and of all text where the file is text."""


def readers() -> dict[str, Reader]:
    """All readers with their whole files. Long, as it is one list: an entry for each reader."""
    mesh = _mesh()
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="left")
    marks = (Landmark(name="fibula head", position_mm=mesh.vertices_mm[3]),)
    limb = AlignedLimb(mesh=mesh, landmarks=marks, frame=frame, kind="transtibial", sock_mm=0.3)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        ours: dict[str, bytes] = {}
        for one in FORMATS:
            if one.holds_limbs:
                own = folder / one.name
                own.mkdir()
                written = write_limb(Limb(mesh=mesh), own / f"a{one.suffix}")
                ours[one.suffix] = written.read_bytes()
        (folder / "limb").mkdir()
        scan = write_limb(limb, folder / "limb" / "scan.ply").read_bytes()
        record = (folder / "limb" / "scan.limb.json").read_bytes()
        camera = _camera(folder)
    whole = {"whole.png": _picture("PNG", seed=1), "other.png": _picture("PNG", seed=2)}
    json_like = (*_BLIND, number, number, *5 * (tree,))
    picture = (*_BLIND, *4 * (beginning,), word32)
    case = {"case.json": _CASE}
    listed = [
        *(
            Reader(
                suffix[1:], suffix, whole_file, _shape,
                (*(_TEXT if whole_file.isascii() else _BLIND), *_KNOWING.get(suffix, ())),
            )
            for suffix, whole_file in ours.items()
        ),
        Reader("stl-text", ".stl", _text_stl(mesh), _shape, _TEXT),
        Reader(
            "ply-polygons", ".ply", _polygon_ply(mesh), _shape,
            (*_BLIND, word32, *2 * (ply_head,), *3 * (ply_count,)),
        ),
        Reader("ply-text", ".ply", _ascii_ply(mesh), _shape, (*_TEXT, ply_head, ply_head)),
        Reader("aop", ".aop", _aop(), _shape, _TEXT),
        Reader("limb-file", ".limb.json", record, _beside, json_like, {"scan.ply": scan}),
        Reader("recipe", ".toml", _recipe(), _void(read_recipe), (*_TEXT, *3 * (toml_deep,))),
        Reader("template", ".json", _template(), _void(read_template), json_like),
        Reader("camera", ".json", camera, _void(read_camera), json_like),
        Reader("distances", ".json", _DISTANCES, _void(read_distances), json_like),
        Reader(
            "accuracy-of-case", "accuracy.json", _ACCURACY,
            _void(lambda path: cited(CaseFolder(path.parent))), json_like, case,
        ),
        Reader(
            "truth-mesh", ".ply", _truth(mesh), _void(read_truth_mesh),
            (*_BLIND, word32, ply_head, ply_count),
        ),
        Reader("truth-cameras", ".json", _CAMERAS, _void(centres_mm), json_like),
        Reader("typed", ".txt", _TYPED, _typed, _TEXT),
        Reader("photo-jpeg", ".jpg", _picture("JPEG"), _photo, picture, whole),
        Reader("photo-png", ".png", _picture("PNG", mode="RGB"), _photo, picture, whole),
        Reader(
            "photo-tiff", ".tif", _picture("TIFF", compression="tiff_lzw"), _photo, picture, whole
        ),
        Reader("photo-tiff-16", ".tif", _picture("TIFF", mode="I;16"), _photo, picture, whole),
        Reader(
            "mask", "whole.png.png", _picture("PNG", mode="L"), _mask, picture, whole,
        ),
    ]  # fmt: skip
    return {reader.name: reader for reader in listed}


# Doing it.

_KNOWN: dict[str, Reader] = {}


def _start() -> None:
    warnings.simplefilter("ignore")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # libraries in C say there what is damaged
    resource.setrlimit(resource.RLIMIT_AS, (LIMIT_BYTES, LIMIT_BYTES))
    signal.signal(signal.SIGALRM, _too_long)
    signal.signal(signal.SIGPROF, _too_long)
    _KNOWN.update(readers())


def _too_long(_signal: int, _frame: FrameType | None) -> None:
    """End the process: a thread that waits for another cannot be called back soundly."""
    os._exit(_OVERTIME)


def mutant(reader: Reader, seed: int, idx: int) -> bytes:
    """One mutant; the same for a reader, a seed and a number."""
    rng = random.Random(f"{reader.name} {seed} {idx}")
    content = reader.whole
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        content = rng.choice(reader.changes)(rng, content)
    return content


@dataclass(frozen=True)
class Chunk:
    """Some mutants of a reader."""

    name: str
    first: int
    count: int

    def halves(self) -> list["Chunk"]:
        half = self.count // 2
        return [
            Chunk(self.name, self.first, half),
            Chunk(self.name, self.first + half, self.count - half),
        ]


def try_some(chunk: Chunk, seed: int, keep: Path | None) -> Outcome:
    """What becomes of some mutants."""
    reader = _KNOWN[chunk.name]
    outcome = Outcome()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for beside, content in reader.setting.items():
            (folder / beside).write_bytes(content)
        own = reader.ending if not reader.ending.startswith(".") else f"scan{reader.ending}"
        path = folder / own
        path.write_bytes(reader.whole)
        triangles = reader.read(path)  # whole, it must be read; and kernels are compiled
        for idx in range(chunk.first, chunk.first + chunk.count):
            content = mutant(reader, seed, idx)
            path.write_bytes(content)
            fault = _try_one(reader, path, triangles, outcome)
            if fault is not None:
                outcome.faults[fault] += 1
                if keep is not None:
                    keep.mkdir(parents=True, exist_ok=True)
                    (keep / f"{chunk.name}-{seed}-{idx}{Path(own).suffix}").write_bytes(content)
    return outcome


def _try_one(reader: Reader, path: Path, triangles: int | None, outcome: Outcome) -> str | None:
    """Count what becomes of a mutant; the fault, where it is one of ours."""
    began = time.perf_counter()
    signal.setitimer(signal.ITIMER_PROF, LIMIT_S)
    signal.setitimer(signal.ITIMER_REAL, _PATIENCE_S)
    try:
        found = reader.read(path)
        outcome.read += 1
        if found is not None and triangles is not None and found < triangles:
            outcome.missing += 1
        return None
    except LimbgramError as refusal:
        str(refusal).encode()  # a refusal that cannot be written is none
        outcome.refused += 1
        return None
    except BaseException as fault:
        outcome.crashed += 1
        at = fault.__traceback__
        while at is not None and at.tb_next is not None:
            at = at.tb_next
        where = "" if at is None else f" in {at.tb_frame.f_code.co_filename.rsplit('/', 1)[-1]}"
        return f"{type(fault).__name__}{where}: {str(fault)[:80]}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)
        outcome.slowest_s = max(outcome.slowest_s, time.perf_counter() - began)


@dataclass
class _Pool:
    """Processes that read; new ones where one of them has died."""

    executor: ProcessPoolExecutor | None = None

    def try_all(self, chunks: list[Chunk], seed: int, keep: Path | None) -> Iterator[Outcome]:
        """Outcomes of chunks; one that ended its process is looked at mutant by mutant."""
        while chunks:
            if self.executor is None:
                spawn = multiprocessing.get_context("spawn")
                self.executor = ProcessPoolExecutor(_PROCESSES, spawn, initializer=_start)
            waiting = [
                (chunk, self.executor.submit(try_some, chunk, seed, keep)) for chunk in chunks
            ]
            chunks = []
            for chunk, result in waiting:
                try:
                    yield result.result()
                except BrokenProcessPool:
                    chunks.append(chunk)
            if chunks:
                self.executor.shutdown()
                self.executor = None
                first = chunks.pop(0)
                if first.count > 1:
                    halves = first.halves()
                    chunks = [*halves, *chunks]
                else:
                    yield Outcome(
                        hung=1, faults=Counter({"the process died, or its time was over": 1})
                    )


def run(names: list[str], count: int, seed: int, keep: Path | None) -> dict[str, Outcome]:
    """The outcomes of every reader."""
    outcomes: dict[str, Outcome] = {}
    pool = _Pool()
    for name in names:
        firsts = range(0, count, _CHUNK)
        chunks = [Chunk(name, first, min(_CHUNK, count - first)) for first in firsts]
        total = Outcome()
        for outcome in pool.try_all(chunks, seed, keep):
            total.add(outcome)
        outcomes[name] = total
        told = {key: value for key, value in asdict(total).items() if key != "faults"}
        sys.stdout.write(f"{name}: {told}\n")
        for fault, times in total.faults.most_common(12):
            sys.stdout.write(f"    {times} x {fault}\n")
        sys.stdout.flush()
    return outcomes


def page(results: dict[str, Any]) -> str:
    """The outcomes as a table."""
    table = [
        f"| {name} | {one['count']:,} | {one['read']:,} | {one['refused']:,} | {one['crashed']} | "
        f"{one['hung']} | {one['missing']:,} | {one['slowest_s']:.2f} |"
        for name, one in results["readers"].items()
    ]
    return "\n".join(
        [
            "# Damaged files",
            "",
            made_on(results["machine"]),
            "",
            "Mutants of each reader, made by `python benchmarks/mutants.py all --record`. "
            f"Each has {LIMIT_S:g} s of processor time and {_GB} GB of address space. Read "
            "and refused are right; crashed and hung would be faults of ours. *Faces "
            "missing, unsaid*: read, with fewer triangles than the whole file has and no "
            "note; a reader cannot tell where the change leaves another whole file, such as "
            "an OBJ without one line, or a corner number that names another vertex. *s*: "
            "the longest that one took.",
            "",
            "| reader | mutants | read | refused | crashed | hung | faces missing, unsaid | s |",
            "| --- | --- | --- | --- | --- | --- | --- | --- |",
            *table,
            "",
        ]
    )


def main() -> int:
    parser = described(__doc__)
    parser.add_argument("reader", help="name of a reader, or all")
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder for the files that were crashed on")
    parser.add_argument("--record", action="store_true", help="put the outcomes into results/")
    asked = parser.parse_args()
    known = list(readers())
    if asked.reader not in ("all", *known):
        parser.error(f"there is no reader {asked.reader}; there are all, {', '.join(known)}")
    names = known if asked.reader == "all" else [asked.reader]
    outcomes = run(names, asked.count, asked.seed, asked.keep)
    if asked.record:
        record(outcomes, known, asked.count, asked.seed)
    return int(any(one.crashed or one.hung for one in outcomes.values()))


def record(outcomes: dict[str, Outcome], known: list[str], count: int, seed: int) -> None:
    """Put outcomes beside those of other readers; of each, count and seed are told."""
    path = _RESULTS / "mutants.json"
    held: dict[str, Any] = json.loads(path.read_text("utf-8")) if path.is_file() else {}
    rows = held.get("readers", {})
    rows |= {
        name: {"count": count, "seed": seed, **asdict(outcome), "faults": dict(outcome.faults)}
        for name, outcome in outcomes.items()
    }
    rows = {name: rows[name] for name in known if name in rows}
    tree = {"limit_s": LIMIT_S, "limit_gb": _GB, "readers": rows, "machine": machine()}
    path.write_text(json.dumps(tree, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    sys.exit(main())
