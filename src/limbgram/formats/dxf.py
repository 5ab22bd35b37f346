"""DXF, release 2010: the surface as one MESH, with its curves and landmarks, in stated units.

A layer holds each kind of thing: sections as flat polylines at their heights, trimline and
centreline as 3D polylines, landmarks as points with their names beside them. $INSUNITS says the
unit. MESH keeps neighbours joined and counts to any number; programs that know no MESH, such as
FreeCAD 0.20 and LibreCAD 2.2, still take the curves: the surface comes last, because FreeCAD 0.20
loses what follows an entity that it does not know. Its usual importer, written in C++, knows
neither MESH nor 3DFACE, and takes a polyface's vertices for those of a curve; its legacy one, in
Python, makes a closed mesh of a polyface where its layers are turned off. Carvers and programs that
ask for loose faces, and that importer, get release 12 (dxf_r12.py).

ezdxf draws and reads all but the surface's numbers, of which it makes an object each: 26 s for
327,680 triangles, where their text in one piece takes 3.5 s with reading back. One triangle stands
in for them.
"""

from collections.abc import Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Final

import numpy as np
from jaxtyping import Int64

from limbgram.core.files import other, other_count, require, write_file
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import fault
from limbgram.formats.curves import Curves, curves_of
from limbgram.formats.format import Format
from limbgram.formats.writing import Unit, require_same_triangles, target
from limbgram.workbench.limb import Landmark

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.layouts.layout import Modelspace

_INSUNITS: Final[dict[Unit, int]] = {"mm": 4, "unitless": 0}
_METRIC = 1
_KINDS = ("SURFACE", "SECTIONS", "TRIMLINE", "CENTRELINE", "LANDMARKS")
_POINT_AS_CROSS, _POINT_MM = 3, 3.0
_TEXT_MM, _BESIDE_MM = 3.0, 2.0
_PRECISION = 1e-9
_STAND_IN = Mesh(vertices_mm=np.eye(3), faces=np.array([[0, 1, 2]], np.int32))


def write_dxf(
    mesh: Mesh, path: Path | str, unit: Unit, *, spacing_mm: float = 10.0, unscaled: bool = False
) -> Path:
    """Write surface, sections across z at multiples of `spacing_mm`, trimline; read all back."""
    path = target(path, unit, unscaled=unscaled)
    return write_drawing(mesh, path, unit, curves_of(mesh, spacing_mm), ())


def write_drawing(
    mesh: Mesh, path: Path, unit: Unit, curves: Curves, landmarks: Sequence[Landmark]
) -> Path:
    """Write a surface, its curves and landmarks, in one frame, and read them back."""

    def encode(stream: BinaryIO) -> None:
        stream.write(_encoded(mesh, unit, curves, landmarks))

    def check(written: Path) -> None:
        _check(written, path.name, mesh, unit, curves, landmarks)

    return write_file(path, encode, check)


def _layer(kind: str, unit: Unit) -> str:
    return f"{kind}_{unit.upper()}"


def _encoded(mesh: Mesh, unit: Unit, curves: Curves, landmarks: Sequence[Landmark]) -> bytes:
    from ezdxf import options  # pyright: ignore[reportPrivateImportUsage] as its manual has it
    from ezdxf.filemanagement import new  # half a second, for drawings alone

    # The same input gives the same bytes: no date, and no number drawn at random.
    options.write_fixed_meta_data_for_testing = True
    drawing = new("R2010")
    drawing.units = _INSUNITS[unit]
    drawing.header["$MEASUREMENT"] = _METRIC
    drawing.header["$PDMODE"], drawing.header["$PDSIZE"] = _POINT_AS_CROSS, _POINT_MM
    for colour, kind in enumerate(_KINDS, 1):
        drawing.layers.add(_layer(kind, unit), color=colour)
    space = drawing.modelspace()
    _draw_curves(space, unit, curves)
    _draw_landmarks(space, unit, landmarks)
    surface = space.add_mesh(dxfattribs={"layer": _layer("SURFACE", unit)})
    with surface.edit_data() as data:
        data.vertices = _STAND_IN.vertices_mm.tolist()
        data.faces = _STAND_IN.faces.tolist()
    for kind in sorted(drawing.entitydb.dxf_types_in_use()):  # ezdxf takes them from a set
        drawing.classes.add_class(kind)
    before, after = _text(drawing).split(_numbers(_STAND_IN))
    text = f"{before}{_numbers(mesh)}{after}"
    return text.encode(drawing.output_encoding, "dxfreplace")


def _numbers(mesh: Mesh) -> str:
    """Places and faces as a MESH has them: each a code and a value, after their counts."""
    places, faces = mesh.vertices_mm, mesh.faces
    place, face = " 10\n%r\n 20\n%r\n 30\n%r\n", " 90\n3\n 90\n%d\n 90\n%d\n 90\n%d\n"
    return (
        f" 92\n{len(places)}\n{place * len(places) % tuple(places.ravel().tolist())}"
        f" 93\n{4 * len(faces)}\n{face * len(faces) % tuple(faces.ravel().tolist())}"
    )


def _draw_curves(space: "Modelspace", unit: Unit, curves: Curves) -> None:
    for section in curves.sections:
        space.add_lwpolyline(
            section.points_mm[:, :2].tolist(),
            close=section.closed,
            dxfattribs={"layer": _layer("SECTIONS", unit), "elevation": section.offset_mm},
        )
    for loop in curves.trimline or ():
        at = {"layer": _layer("TRIMLINE", unit)}
        space.add_polyline3d(loop.tolist(), close=True, dxfattribs=at)
    middle = curves.centreline_mm
    if len(middle) > 1:
        space.add_polyline3d(middle.tolist(), dxfattribs={"layer": _layer("CENTRELINE", unit)})


def _draw_landmarks(space: "Modelspace", unit: Unit, landmarks: Sequence[Landmark]) -> None:
    at = {"layer": _layer("LANDMARKS", unit)}
    for mark in landmarks:
        place = mark.position_mm.tolist()
        space.add_point(place, dxfattribs=at)
        beside = [place[0] + _BESIDE_MM, place[1], place[2]]
        space.add_text(mark.name, height=_TEXT_MM, dxfattribs={**at, "insert": beside})


def _text(drawing: "Drawing") -> str:
    text = StringIO()
    drawing.write(text)
    return text.getvalue()


def _check(
    written: Path,
    name: str,
    mesh: Mesh,
    unit: Unit,
    curves: Curves,
    landmarks: Sequence[Landmark],
) -> None:
    from ezdxf.filemanagement import read

    places, faces, rest = _parted(written.read_text("utf-8"), name)
    drawing = read(StringIO(rest))
    require(drawing.units == _INSUNITS[unit], other(name, "unit"))
    space: Any = drawing.modelspace()  # what a query finds is of the kind that it names
    surfaces = space.query("MESH")
    require(len(surfaces) == 1, other_count(name, "surfaces", len(surfaces), 1))
    require_same_triangles(name, places[faces], mesh, _PRECISION)
    middle = curves.centreline_mm
    wanted: list[Points3] = [section.points_mm for section in curves.sections]
    wanted += [*(curves.trimline or ()), *([middle] if len(middle) > 1 else [])]
    found = [
        np.array([tuple(one) for one in line.vertices_in_wcs()])
        for line in space.query("LWPOLYLINE")
    ]
    found += [np.array([tuple(one) for one in line.points()]) for line in space.query("POLYLINE")]
    require(len(found) == len(wanted), other_count(name, "curves", len(found), len(wanted)))
    for number, (one, two) in enumerate(zip(found, wanted, strict=True), 1):
        near = one.shape == two.shape and np.allclose(one, two, rtol=0, atol=_PRECISION)
        require(near, fault("export.curve_elsewhere", name=name, curve=number))
    marks = [tuple(point.dxf.location) for point in space.query("POINT")]
    there = np.array([mark.position_mm for mark in landmarks]).reshape(-1, 3)
    require(len(marks) == len(there), other_count(name, "landmarks", len(marks), len(there)))
    near = np.allclose(np.array(marks).reshape(-1, 3), there, rtol=0, atol=_PRECISION)
    require(near, other(name, "landmarks"))


def _parted(text: str, name: str) -> tuple[Points3, Int64[np.ndarray, "f 3"], str]:
    """The surface's places and faces, and the drawing with what stands in for them."""
    head, begun, rest = text.rpartition("AcDbSubDMesh\n")
    settings, first, rest = rest.partition(" 92\n")
    told, last, rest = rest.partition(" 94\n")
    numbers = np.fromstring(f"{first}{told}", sep="\n")
    codes, values = numbers[::2], numbers[1::2]
    places, faces = int(np.sum(codes == 10)), int(np.sum(codes == 90)) // 4
    wanted = [92, *[10, 20, 30] * places, 93, *[90] * (4 * faces)]
    damaged = fault("export.other_parts", name=name, entity="MESH")
    require(np.array_equal(codes, wanted) and len(values) == len(codes), damaged)
    counts, corners = values[[0, 1 + 3 * places]], values[2 + 3 * places :].reshape(-1, 4)
    require(counts.tolist() == [places, 4 * faces], damaged)
    require(bool((corners[:, 0] == 3).all() and (corners[:, 1:] < places).all()), damaged)
    stood_in = f"{head}{begun}{settings}{_numbers(_STAND_IN)}{last}{rest}"
    return values[1 : 1 + 3 * places].reshape(-1, 3), corners[:, 1:].astype(np.int64), stood_in


FORMAT = Format(
    suffix=".dxf",
    place=20,
    used_for={"en": "surface, sections, landmarks", "de": "Oberfläche, Schnitte, Landmarken"},
    write=write_dxf,
)
