"""DXF, release 2010: the surface as one MESH, with its curves and landmarks, in stated units.

Each kind of entity has a layer: sections as flat polylines at their heights, trimline and
centreline as 3D polylines, landmarks as points with their names beside them. $INSUNITS states the
unit. MESH shares vertices between faces and has no limit of their number. Programs without MESH,
such as FreeCAD 0.20 and LibreCAD 2.2, still read the curves: the surface comes last, because
FreeCAD 0.20 loses what follows an entity that it does not know. Its default importer (C++) knows
neither MESH nor 3DFACE, and takes a polyface's vertices for those of a curve; its legacy importer
(Python) makes a closed mesh of a polyface if layers are turned off. That importer, carvers and
programs that need separate faces get release 12 (dxf_r12.py).

ezdxf writes and reads all but the surface's tags, for each of which it makes an object: 26 s for
327,680 triangles, against 3.5 s for their text in one piece, read back. It gets one triangle as a
placeholder for them.
"""

from collections.abc import Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from jaxtyping import Int64

from limbgram.core.files import other, other_count, require, write_bytes
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
_LAYERS = ("SURFACE", "SECTIONS", "TRIMLINE", "CENTRELINE", "LANDMARKS")
_POINT_MODE_CROSS, _POINT_SIZE_MM = 3, 3.0
_TEXT_HEIGHT_MM, _TEXT_OFFSET_MM = 3.0, 2.0
_TOLERANCE = 1e-9
_PLACEHOLDER = Mesh(vertices_mm=np.eye(3), faces=np.array([[0, 1, 2]], np.int32))


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

    def check(written: Path) -> None:
        _check(written, path.name, mesh, unit, curves, landmarks)

    return write_bytes(path, _encoded(mesh, unit, curves, landmarks), check)


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
    drawing.header["$PDMODE"], drawing.header["$PDSIZE"] = _POINT_MODE_CROSS, _POINT_SIZE_MM
    for colour, kind in enumerate(_LAYERS, 1):
        drawing.layers.add(_layer(kind, unit), color=colour)
    space = drawing.modelspace()
    _draw_curves(space, unit, curves)
    _draw_landmarks(space, unit, landmarks)
    surface = space.add_mesh(dxfattribs={"layer": _layer("SURFACE", unit)})
    with surface.edit_data() as data:
        data.vertices = _PLACEHOLDER.vertices_mm.tolist()
        data.faces = _PLACEHOLDER.faces.tolist()
    for kind in sorted(drawing.entitydb.dxf_types_in_use()):  # ezdxf takes them from a set
        drawing.classes.add_class(kind)
    before, after = _text(drawing).split(_mesh_tags(_PLACEHOLDER))
    text = f"{before}{_mesh_tags(mesh)}{after}"
    return text.encode(drawing.output_encoding, "dxfreplace")


def _mesh_tags(mesh: Mesh) -> str:
    """Vertices and faces as tags of a MESH, each a code and a value, after their counts."""
    vertices, faces = mesh.vertices_mm, mesh.faces
    vertex, face = " 10\n%r\n 20\n%r\n 30\n%r\n", " 90\n3\n 90\n%d\n 90\n%d\n 90\n%d\n"
    return (
        f" 92\n{len(vertices)}\n{vertex * len(vertices) % tuple(vertices.ravel().tolist())}"
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
        x, y, z = mark.position_mm.tolist()
        space.add_point((x, y, z), dxfattribs=at)
        beside = (x + _TEXT_OFFSET_MM, y, z)
        space.add_text(mark.name, height=_TEXT_HEIGHT_MM, dxfattribs={**at, "insert": beside})


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

    vertices, faces, rest = _without_mesh(written.read_text("utf-8"), name)
    drawing = read(StringIO(rest))
    require(drawing.units == _INSUNITS[unit], other(name, "unit"))
    space: Any = drawing.modelspace()  # what a query finds is of the kind that it names
    surfaces = space.query("MESH")
    require(len(surfaces) == 1, other_count(name, "surfaces", len(surfaces), 1))
    require_same_triangles(name, vertices[faces], mesh, _TOLERANCE)
    centreline = curves.centreline_mm
    wanted: list[Points3] = [section.points_mm for section in curves.sections]
    wanted += [*(curves.trimline or ()), *([centreline] if len(centreline) > 1 else [])]
    found = [
        np.array([tuple(one) for one in line.vertices_in_wcs()])
        for line in space.query("LWPOLYLINE")
    ]
    found += [np.array([tuple(one) for one in line.points()]) for line in space.query("POLYLINE")]
    require(len(found) == len(wanted), other_count(name, "curves", len(found), len(wanted)))
    for number, (one, two) in enumerate(zip(found, wanted, strict=True), 1):
        near = one.shape == two.shape and np.allclose(one, two, rtol=0, atol=_TOLERANCE)
        require(near, fault("export.curve_elsewhere", name=name, curve=number))
    points = [tuple(point.dxf.location) for point in space.query("POINT")]
    positions = np.array([mark.position_mm for mark in landmarks]).reshape(-1, 3)
    require(
        len(points) == len(positions), other_count(name, "landmarks", len(points), len(positions))
    )
    near = np.allclose(np.array(points).reshape(-1, 3), positions, rtol=0, atol=_TOLERANCE)
    require(near, other(name, "landmarks"))


def _without_mesh(text: str, name: str) -> tuple[Points3, Int64[np.ndarray, "f 3"], str]:
    """Vertices and faces of the MESH, and the drawing with the placeholder instead of them."""
    head, mesh_begin, rest = text.rpartition("AcDbSubDMesh\n")
    settings, tags_begin, rest = rest.partition(" 92\n")
    tags, tags_end, rest = rest.partition(" 94\n")
    numbers = np.fromstring(f"{tags_begin}{tags}", sep="\n")
    codes, values = numbers[::2], numbers[1::2]
    vertices, faces = int(np.sum(codes == 10)), int(np.sum(codes == 90)) // 4
    wanted = [92, *[10, 20, 30] * vertices, 93, *[90] * (4 * faces)]
    damaged = fault("export.other_parts", name=name, entity="MESH")
    require(np.array_equal(codes, wanted) and len(values) == len(codes), damaged)
    counts, corners = values[[0, 1 + 3 * vertices]], values[2 + 3 * vertices :].reshape(-1, 4)
    require(counts.tolist() == [vertices, 4 * faces], damaged)
    require(bool((corners[:, 0] == 3).all() and (corners[:, 1:] < vertices).all()), damaged)
    reduced = f"{head}{mesh_begin}{settings}{_mesh_tags(_PLACEHOLDER)}{tags_end}{rest}"
    return values[1 : 1 + 3 * vertices].reshape(-1, 3), corners[:, 1:].astype(np.int64), reduced


FORMAT = Format(
    suffix=".dxf",
    place=20,
    used_for={"en": "surface, sections, landmarks", "de": "Oberfläche, Schnitte, Landmarken"},
    write=write_dxf,
)
