"""3MF: triangles with their unit, in a zip archive (3MF core specification 1.4).

The writer gives one object with its pose on the printer's bed, and as metadata title, description
and application alone: no dates and no names, and the same bytes for the same mesh. The reader joins
the meshes of all build items that are to be printed, through components and other parts of the
archive, as they lie on the bed, to one surface in millimetres. A file that requires an unknown
extension is refused, since that may add to the surface.

Own code: lib3mf would be a library of 10 MB for 200 lines.
"""

import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, Final
from xml.parsers import expat
from xml.sax.saxutils import escape

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import ShapeFileError, reason_of
from limbgram.core.files import ContentError, damaged_zip_refused, write_file
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.units import MM_PER_INCH
from limbgram.formats.format import Format
from limbgram.formats.triangle_soup import Soup
from limbgram.formats.writing import Unit, require_same_triangles, target

_CORE: Final = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PRODUCTION: Final = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
_READABLE: Final = frozenset(
    {
        _PRODUCTION,
        "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
        "http://schemas.microsoft.com/3dmanufacturing/slice/2015/07",
    }
)
"""Extensions that leave the triangles of a mesh as they stand."""
_MODEL: Final = "3D/3dmodel.model"
_TYPES = b"""<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
_START: Final = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_RELATIONS = f"""<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/{_MODEL}" Id="rel0" Type="{_START}"/>
</Relationships>
""".encode()
_MM_PER = {
    "micron": 0.001,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "inch": MM_PER_INCH,
    "foot": 304.8,
    "meter": 1000.0,
}
_NOT_PRINTED: Final = ("0", "false")
"""Of the attribute `printable` of a build item, in which slicers keep what stays on the bed and is
left out."""
_PRECISION = 1e-6
_LARGEST_PART, _DEEPEST = 1 << 30, 32
_MOST_ITEMS = 10_000
_LONG_AGO = (1980, 1, 1, 0, 0, 0)
"""The earliest date of a zip archive: it has to have one."""
_BLOCK = 20_000


@dataclass(frozen=True, kw_only=True)
class Told:
    """Metadata of a 3MF file, and the pose of its object."""

    title: str = ""
    description: str = ""
    bed_from_mesh: Rigid = field(default_factory=Rigid.identity)
    """Pose of the object on the printer's bed."""


PLAIN = Told()


def write_3mf(
    mesh: Mesh, path: Path | str, unit: Unit, *, unscaled: bool = False, told: Told = PLAIN
) -> Path:
    """Write the triangles (to a millionth of a millimetre) and read them back."""
    path = target(path, unit, unscaled=unscaled)

    def encode(stream: BinaryIO) -> None:
        parts = {
            "[Content_Types].xml": _TYPES,
            "_rels/.rels": _RELATIONS,
            _MODEL: _model(mesh, told),
        }
        with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
            for name, content in parts.items():
                entry = zipfile.ZipInfo(name, _LONG_AGO)
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.create_system = 0  # else the system that it was written on
                archive.writestr(entry, content)

    def check(written: Path) -> None:
        read = read_3mf(written.read_bytes(), path.name).mesh
        lying = mesh.moved(told.bed_from_mesh)
        require_same_triangles(path.name, read.vertices_mm[read.faces], lying, 4 * _PRECISION)

    return write_file(path, encode, check)


def read_3mf(content: bytes, name: str) -> Soup:
    """The surface of all that is to be printed, in millimetres.

    Raises:
        ShapeFileError: damaged, or of an extension that is not known.
    """

    def damaged(error: Exception) -> ShapeFileError:
        return ShapeFileError("file.3mf.damaged", name=name, why=reason_of(error))

    try:
        with damaged_zip_refused(damaged):
            archive = _Archive(content)
            mesh = archive.built()
    except (ContentError, expat.ExpatError, ValueError, KeyError, RuntimeError) as error:
        raise damaged(error) from error  # a RuntimeError where a password is asked for
    return Soup(mesh=mesh, stated_unit="mm", converted_by=archive.mm_per_unit)


def _model(mesh: Mesh, told: Told) -> bytes:
    texts = {"Title": told.title, "Description": told.description, "Application": "limbgram"}
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<model unit="millimeter" xml:lang="en-US" xmlns="{_CORE}">',
        *(
            f'<metadata name="{key}">{escape(text)}</metadata>'
            for key, text in texts.items()
            if text
        ),
        '<resources><object id="1" type="model"><mesh><vertices>',
    ]
    for rows in _blocks(mesh.vertices_mm + 0.0):
        row = '<vertex x="%.6f" y="%.6f" z="%.6f"/>\n'
        lines.append(row * len(rows) % tuple(rows.ravel()))
    lines.append("</vertices><triangles>")
    for rows in _blocks(mesh.faces):
        row = '<triangle v1="%d" v2="%d" v3="%d"/>\n'
        lines.append(row * len(rows) % tuple(rows.ravel()))
    motion = told.bed_from_mesh
    numbers = [*motion.rotation.T.ravel(), *motion.translation]
    shown = " ".join(f"{number:.12g}" for number in numbers)
    lines.append("</triangles></mesh></object></resources>")
    lines.append(f'<build><item objectid="1" transform="{shown}"/></build></model>')
    return "\n".join(lines).encode()


def _blocks(rows: np.ndarray) -> list[np.ndarray]:
    return [rows[start : start + _BLOCK] for start in range(0, len(rows), _BLOCK)]


Transform = Float64[np.ndarray, "4 3"]
_UNMOVED: Final = np.vstack([np.eye(3), np.zeros(3)])


@dataclass(frozen=True)
class _Use:
    """An object's use in another object, or in the build."""

    part: str
    """Part of the archive that holds the object; empty for the same part."""
    number: str
    transform: Transform


@dataclass
class _Object:
    printed: bool
    places: list[float] = field(default_factory=list[float])
    corners: list[int] = field(default_factory=list[int])
    uses: list[_Use] = field(default_factory=list[_Use])


@dataclass
class _Part:
    """One model part of the archive."""

    mm_per_unit: float = 1.0
    objects: dict[str, _Object] = field(default_factory=dict[str, _Object])
    items: list[_Use] = field(default_factory=list[_Use])


class _Archive:
    """The parts of a file, each read once."""

    def __init__(self, content: bytes) -> None:
        self._zip = zipfile.ZipFile(BytesIO(content))
        self._parts: dict[str, _Part] = {}
        self._start = self._first()

    @property
    def mm_per_unit(self) -> float:
        return self._part(self._start).mm_per_unit

    def built(self) -> Mesh:
        """The surface of all build items."""
        start = self._part(self._start)
        if len(start.items) > _MOST_ITEMS:
            raise ContentError("file.3mf.items", items=len(start.items))
        places: list[np.ndarray] = []
        faces: list[np.ndarray] = []
        waiting = [(use, self._start, use.transform, 0) for use in reversed(start.items)]
        count = taken = 0
        while waiting:
            use, part, transform, depth = waiting.pop()
            taken += 1
            if depth > _DEEPEST or taken > _MOST_ITEMS:
                raise ContentError("file.3mf.deep")
            part = use.part or part
            found = self._part(part).objects.get(use.number)
            if found is None:
                raise ContentError("file.3mf.no_object", number=use.number[:40])
            if not found.printed:
                continue
            waiting += [
                (below, part, _after(below.transform, transform), depth + 1)
                for below in reversed(found.uses)
            ]
            own = np.array(found.places, np.float64).reshape(-1, 3)
            try:
                corners = np.array(found.corners, np.int64).reshape(-1, 3)
            except OverflowError as error:
                raise ContentError("file.face.vertex") from error
            if len(corners) and not 0 <= corners.min() <= corners.max() < len(own):
                raise ContentError("file.face.vertex")
            if np.linalg.det(transform[:3]) < 0:
                corners = corners[:, ::-1]
            places.append(own @ transform[:3] + transform[3])
            faces.append(corners + count)
            count += len(own)
        if not sum(map(len, faces)):
            raise ContentError("file.3mf.empty")
        vertices = np.concatenate(places) * self.mm_per_unit
        return Mesh(vertices_mm=vertices, faces=np.concatenate(faces).astype(np.int32))

    def _first(self) -> str:
        """The name of the archive's start part."""
        found: list[str] = []

        def start(tag: str, given: dict[str, str]) -> None:
            if tag.endswith(" Relationship") and given.get("Type") == _START:
                found.append(given["Target"].lstrip("/"))

        _parsed(self._bytes("_rels/.rels"), start)
        if len(found) != 1:
            raise ContentError("file.3mf.no_model", models=len(found))
        return found[0]

    def _bytes(self, part: str) -> bytes:
        try:
            entry = self._zip.getinfo(part)
        except KeyError:
            raise ContentError("file.3mf.no_part", part=part[:60]) from None
        if entry.file_size > _LARGEST_PART:
            raise ContentError("file.3mf.large", mb=entry.file_size >> 20)
        with self._zip.open(entry) as stream:
            content = stream.read(entry.file_size + 1)
            if len(content) != entry.file_size:
                raise ContentError("file.3mf.large", mb=len(content) >> 20)
        return content

    def _part(self, name: str) -> _Part:
        if name not in self._parts:
            self._parts[name] = _read_part(self._bytes(name))
        return self._parts[name]


def _after(inner: Transform, outer: Transform) -> Transform:
    """The composition of two transforms, the inner one first."""
    return np.vstack([inner[:3] @ outer[:3], inner[3] @ outer[:3] + outer[3]])


def _read_part(content: bytes) -> _Part:
    part = _Part()
    now: list[_Object] = []
    seen: set[str] = set()

    def start(tag: str, given: dict[str, str]) -> None:
        match tag.removeprefix(f"{_CORE} "):
            case "model":
                part.mm_per_unit = _MM_PER[given.get("unit", "millimeter")]
                seen.add("model")
            case "object":
                kind = given.get("type", "model")
                made = _Object(kind in ("model", "solidsupport"))
                if given["id"] in part.objects:
                    raise ContentError("file.3mf.twice", number=given["id"][:40])
                part.objects[given["id"]] = made
                now[:] = [made]
            case "vertex" | "triangle" | "component" if not now:
                raise ContentError("file.3mf.outside")
            case "vertex":
                now[0].places += (float(given["x"]), float(given["y"]), float(given["z"]))
            case "triangle":
                now[0].corners += (int(given["v1"]), int(given["v2"]), int(given["v3"]))
            case "component":
                now[0].uses.append(_use(given))
            case "item" if given.get("printable") not in _NOT_PRINTED:
                part.items.append(_use(given))
            case _:
                pass

    _parsed(content, start)
    if not seen:
        raise ContentError("file.3mf.no_model", models=0)
    return part


def _use(given: dict[str, str]) -> _Use:
    numbers = given.get("transform", "").split()
    transform = np.array(numbers, np.float64).reshape(4, 3) if numbers else _UNMOVED
    path = given.get(f"{_PRODUCTION} path", "").lstrip("/")
    return _Use(path, given["objectid"], transform)


def _parsed(content: bytes, start: Callable[[str, dict[str, str]], None]) -> None:
    """Parse a document; required extensions must be known to leave triangles as they are."""
    parser = expat.ParserCreate(namespace_separator=" ")
    spaces: dict[str, str] = {}

    def declared(prefix: str | None, space: str) -> None:
        spaces[prefix or ""] = space

    def entered(tag: str, given: dict[str, str]) -> None:
        for prefix in given.get("requiredextensions", "").split():
            if spaces.get(prefix, prefix) not in _READABLE:
                raise ContentError("file.3mf.extension", name=spaces.get(prefix, prefix)[:80])
        start(tag, given)

    def refused(*_: object) -> None:
        raise ContentError("file.3mf.doctype")

    parser.StartNamespaceDeclHandler = declared
    parser.StartElementHandler = entered
    parser.StartDoctypeDeclHandler = refused
    parser.Parse(content, True)


FORMAT = Format(
    suffix=".3mf",
    place=15,
    used_for={"en": "printer, with its unit", "de": "Drucker, mit Einheit"},
    read=read_3mf,
    write=write_3mf,
    within_mm=4e-6,
)
