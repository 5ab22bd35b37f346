"""Our files as other programs take them, and theirs: units, colours, scalar fields, landmarks."""

import base64
import io
import json
import struct
from dataclasses import replace
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import trimesh

from limbgram.core.errors import ExportError, OptionsError, ShapeFileError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.spreadsheet import Table, csv_of, xlsx_of
from limbgram.formats import dxf
from limbgram.formats.curves import curves_of
from limbgram.formats.dxf import write_drawing
from limbgram.formats.format import Format
from limbgram.formats.glb import write_glb, write_marked_glb
from limbgram.formats.limb_file import write_limb
from limbgram.formats.obj import read_obj, write_marked_obj
from limbgram.formats.ply import write_ply
from limbgram.formats.reading import ShapeFile, read_limb
from limbgram.formats.table import FORMATS
from limbgram.formats.vtp import write_vtp
from limbgram.services.export import LandmarkBook, Landmarks, export
from limbgram.workbench.limb import Landmark, Limb

MARKS = (
    Landmark(name="fibula head", position_mm=np.array([50.0, 0.0, 10.0])),
    Landmark(name="Schienbeinhöcker", position_mm=np.array([0.0, 50.0, -10.5])),
)


@pytest.fixture
def mesh() -> Mesh:
    """A ball of radius 50 mm; every colour of a channel, every seventh vertex filled."""
    ball = trimesh.creation.icosphere(subdivisions=3, radius=50)
    count = len(ball.vertices)
    filled = np.arange(count) % 7 == 0
    rng = np.random.default_rng(4)
    colours = np.stack([np.arange(count) % 256, *rng.integers(0, 256, (2, count))], axis=1)
    return Mesh(
        vertices_mm=np.asarray(ball.vertices, np.float64),
        faces=ball.faces.astype(np.int32),
        colours=colours.astype(np.uint8),
        filled=filled,
        sigma_mm=np.where(filled, np.nan, rng.random(count)).astype(np.float32),
    )


def test_a_drawing_has_units_layers_and_landmarks(mesh: Mesh, tmp_path: Path) -> None:
    raised = mesh.with_vertices(mesh.vertices_mm + np.array([3.0, -4.0, 0.0]))
    path = write_drawing(raised, tmp_path / "cad.dxf", "mm", curves_of(raised, 25.0), MARKS)
    drawing = ezdxf.readfile(path)
    assert drawing.dxfversion == "AC1024"  # release 2010
    assert drawing.header["$INSUNITS"] == 4  # millimetres
    assert not drawing.audit().errors
    space = drawing.modelspace()
    (surface,) = space.query('MESH[layer=="SURFACE_MM"]')
    np.testing.assert_array_equal(np.array(list(surface.vertices)), raised.vertices_mm)
    np.testing.assert_array_equal(np.array(list(map(tuple, surface.faces))), mesh.faces)
    assert space[-1].dxftype() == "MESH"  # FreeCAD 0.20 loses what follows
    sections = space.query('LWPOLYLINE[layer=="SECTIONS_MM"]')
    assert sorted({one.dxf.elevation for one in sections}) == [-25, 0, 25]
    for one in sections:
        radii = [np.hypot(x - 3, y + 4) for x, y, *_ in one.get_points()]
        np.testing.assert_allclose(radii, np.sqrt(50**2 - one.dxf.elevation**2), atol=0.5)
        assert one.closed
    (middle,) = space.query('POLYLINE[layer=="CENTRELINE_MM"]')
    found = np.array([tuple(one) for one in middle.points()])
    np.testing.assert_allclose(found, [(3, -4, -25), (3, -4, 0), (3, -4, 25)], atol=0.05)
    texts = space.query('TEXT[layer=="LANDMARKS_MM"]')
    assert [one.dxf.text for one in texts] == [mark.name for mark in MARKS]
    points = [tuple(one.dxf.location) for one in space.query("POINT")]
    np.testing.assert_allclose(points, [mark.position_mm for mark in MARKS])
    again = path.read_bytes()
    write_drawing(raised, path, "mm", curves_of(raised, 25.0), MARKS)
    assert path.read_bytes() == again


@pytest.mark.parametrize(
    ("written", "kept"),
    [
        ("\n 93\n5120\n", "\n 93\n5116\n"),
        ("\n 90\n3\n 90\n0\n", "\n 90\n3\n 90\n642\n"),
        ("\n 10\n0.0\n", "\n 20\n0.0\n"),
        ("\n 10\n0.0\n", "\n 10\n"),
    ],
)
def test_a_drawing_whose_surface_reads_back_otherwise_is_not_kept(
    mesh: Mesh, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, written: str, kept: str
) -> None:
    encode = dxf._encoded
    path = tmp_path / "cad.dxf"
    monkeypatch.setattr(dxf, "_encoded", lambda *all_of_it: damaged(encode(*all_of_it)))

    def damaged(content: bytes) -> bytes:
        head, begun, surface = content.decode().rpartition("AcDbEntity\n")
        assert written in surface
        return f"{head}{begun}{surface.replace(written, kept, 1)}".encode()

    with pytest.raises(ExportError):
        write_drawing(mesh, path, "mm", curves_of(mesh, 25.0), MARKS)
    assert not path.exists()


def test_a_scalar_field_by_the_names_that_cloudcompare_and_meshlab_show(
    mesh: Mesh, tmp_path: Path
) -> None:
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    known = meshio.read(write_ply(mesh, tmp_path / "a.ply", "mm")).point_data
    np.testing.assert_array_equal(known["scalar_sigma"], mesh.sigma_mm)
    np.testing.assert_array_equal(known["quality"], np.nan_to_num(mesh.sigma_mm, nan=-1.0))


def test_sigma_by_its_earlier_name_is_read(mesh: Mesh, tmp_path: Path) -> None:
    content = write_ply(mesh, tmp_path / "a.ply", "mm").read_bytes()
    (tmp_path / "old.ply").write_bytes(content.replace(b"float scalar_sigma", b"float sigma"))
    np.testing.assert_array_equal(read_limb(tmp_path / "old.ply").mesh.sigma_mm, mesh.sigma_mm)


def test_colours_of_a_glb_are_linear_light_and_come_back(mesh: Mesh, tmp_path: Path) -> None:
    path = write_glb(mesh, tmp_path / "a.glb", "mm")
    (seen,) = trimesh.load_scene(path, process=False).geometry.values()
    shown = np.asarray(mesh.colours) / 255
    light = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    np.testing.assert_array_equal(seen.visual.vertex_colors[:, :3], np.rint(light * 255))
    np.testing.assert_allclose(np.linalg.norm(seen.vertex_normals, axis=1), 1, atol=1e-6)
    outwards = (seen.vertex_normals * seen.vertices).sum(1)
    assert (outwards > 0).all()
    np.testing.assert_array_equal(read_limb(path).mesh.colours, mesh.colours)


def test_colours_of_programs_that_write_a_displays_are_read_as_they_stand(
    mesh: Mesh, tmp_path: Path
) -> None:
    """trimesh, which wrote our own files before."""
    # In metres; without sigma, whose NaN trimesh writes into the description.
    other = replace(mesh, vertices_mm=mesh.vertices_mm / 1000, sigma_mm=None).to_trimesh()
    (tmp_path / "a.glb").write_bytes(other.export(file_type="glb"))
    np.testing.assert_array_equal(read_limb(tmp_path / "a.glb").mesh.colours, mesh.colours)


def test_a_glb_whose_numbers_are_text_is_read(mesh: Mesh, tmp_path: Path) -> None:
    """As Open3D writes it: no second part, the numbers as base64 in the description."""
    content = write_glb(mesh, tmp_path / "a.glb", "mm").read_bytes()
    (length,) = struct.unpack_from("<I", content, 12)
    tree, numbers = json.loads(content[20 : 20 + length]), content[28 + length :]

    def kept(uri: str) -> Path:
        tree["buffers"][0]["uri"] = uri
        described = json.dumps(tree).encode()
        described += b" " * (-len(described) % 4)
        head = b"glTF" + struct.pack("<IIII", 2, 20 + len(described), len(described), 0x4E4F534A)
        (tmp_path / "b.glb").write_bytes(head + described)
        return tmp_path / "b.glb"

    as_text = base64.b64encode(numbers).decode()
    read = read_limb(kept(f"data:application/octet-stream;base64,{as_text}")).mesh
    np.testing.assert_allclose(read.vertices_mm, mesh.vertices_mm, atol=1e-4)
    np.testing.assert_array_equal(read.faces, mesh.faces)
    for uri, code in (
        ("surface.bin", "file.glb.elsewhere"),
        (f"data:application/octet-stream;base64,{as_text[:-9]}!", "file.glb.no_base64"),
        (f"data:application/octet-stream;base64,{as_text[:400]}", "file.glb.beyond_numbers"),
    ):
        with pytest.raises(ShapeFileError) as refused:
            read_limb(kept(uri))
        assert refused.value.finding.values["why"].code == code


def test_landmarks_stand_in_the_file_itself(mesh: Mesh, tmp_path: Path) -> None:
    for kind in ("glb", "obj"):
        path = write_limb(Limb(mesh=mesh, landmarks=MARKS), tmp_path / f"a.{kind}")
        (path.with_suffix(".limb.json")).unlink()
        read = read_limb(path)
        assert len(read.mesh) == len(mesh)
        assert [mark.name for mark in read.landmarks] == [mark.name for mark in MARKS]
        for mark, known in zip(read.landmarks, MARKS):
            np.testing.assert_allclose(mark.position_mm, known.position_mm, atol=1e-5)
    scene = trimesh.load_scene(write_marked_glb(mesh, tmp_path / "b.glb", MARKS))
    place = scene.graph.get(MARKS[0].name)[0][:3, 3]
    np.testing.assert_allclose(place, (0.05, 0.01, 0.0), atol=1e-9)  # +Y up, metres
    seen = trimesh.load_mesh(write_marked_obj(mesh, tmp_path / "b.obj", MARKS))
    assert seen.is_watertight


def test_a_damaged_landmark_of_an_obj_is_refused(mesh: Mesh, tmp_path: Path) -> None:
    content = write_marked_obj(mesh, tmp_path / "a.obj", MARKS).read_bytes()
    for damaged in (content[:-3], content.replace(b"p 644", b"p x"), content + b"v 0 0 0\n"):
        (tmp_path / "b.obj").write_bytes(damaged)
        with pytest.raises(ShapeFileError) as refused:
            read_limb(tmp_path / "b.obj")
        assert refused.value.finding.values["why"].code == "file.obj.landmark"


@pytest.mark.parametrize("name", [" ", "\u00e9" * 200, "two\u2003words"], ids=ascii)
def test_an_obj_is_read_again_whatever_its_landmark_is_called(
    mesh: Mesh, tmp_path: Path, name: str
) -> None:
    mark = Landmark(name=name, position_mm=np.array([1.0, 2.0, 3.0]))
    content = write_marked_obj(mesh, tmp_path / "a.obj", [mark]).read_bytes()
    (read,) = read_obj(content, "a.obj").landmarks
    assert read.name
    assert name.startswith(read.name[:3]) or not name.strip()
    np.testing.assert_allclose(read.position_mm, mark.position_mm)


def test_a_vtp_has_point_data_and_a_unit(mesh: Mesh, tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista", reason="pyvista is not installed")
    seen = pyvista.read(write_vtp(mesh, tmp_path / "a.vtp", "mm"))
    np.testing.assert_array_equal(seen.points, mesh.vertices_mm)
    np.testing.assert_array_equal(seen.regular_faces, mesh.faces)
    np.testing.assert_array_equal(seen["sigma_mm"], mesh.sigma_mm)
    np.testing.assert_array_equal(seen["RGB"], mesh.colours)
    assert seen.active_scalars_name == "sigma_mm"
    assert list(seen.field_data["unit"]) == ["mm"]


def test_a_vtp_without_a_scale_needs_asking(mesh: Mesh, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="no scale"):
        write_vtp(mesh, tmp_path / "a.vtp", "unitless")
    written = write_vtp(replace(mesh, sigma_mm=None), tmp_path / "a.vtp", "unitless", unscaled=True)
    assert written.name == "a-unitless.vtp"


def test_landmarks_as_a_table(mesh: Mesh, tmp_path: Path) -> None:
    shape = ShapeFile(limb=Limb(mesh=mesh, landmarks=MARKS), sha256="", mm_per_unit=1.0)
    told = export(shape, Landmarks(decimal="comma"), tmp_path / "a.csv")
    lines = told.path.read_text("utf-8-sig").splitlines()
    assert lines[0] == "name;x_mm;y_mm;z_mm"
    assert lines[2] == "Schienbeinhöcker;0,0;50,0;-10,5"
    book = export(shape, LandmarkBook(), tmp_path / "a.xlsx").path
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl is not installed")
    heads, *rows = openpyxl.load_workbook(book)["landmarks"].iter_rows(values_only=True)
    assert heads == ("name", "x [mm]", "y [mm]", "z [mm]")
    assert rows == [(mark.name, *mark.position_mm.tolist()) for mark in MARKS]
    bare = replace(shape, limb=Limb(mesh=mesh))
    for ask, name in ((Landmarks(), "b.csv"), (LandmarkBook(), "b.xlsx")):
        with pytest.raises(OptionsError) as refused:
            export(bare, ask, tmp_path / name)
        assert refused.value.finding.code == "exported.no_landmarks"


def test_tables_as_pandas_reads_them() -> None:
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    pytest.importorskip("openpyxl", reason="openpyxl is not installed")
    table = Table(title="t", columns=("tape_mm", "name"), rows=((65.213, "a"), (1234.5, "b")))
    seen = pandas.read_csv(io.StringIO(csv_of(table, "comma")[1:]), sep=";", decimal=",")
    assert seen["tape_mm"].tolist() == [65.213, 1234.5]
    book = pandas.read_excel(io.BytesIO(xlsx_of([table])))
    assert book["tape [mm]"].tolist() == [65.213, 1234.5]


def test_quads_are_noted(tmp_path: Path) -> None:
    lines = [f"v {x} {y} {z}" for z in (0, 200) for x, y in ((0, 0), (90, 0), (90, 80), (0, 80))]
    faces = ("4 3 2 1", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8")
    (tmp_path / "box.obj").write_text("\n".join([*lines, *(f"f {face}" for face in faces)]))
    (told,) = read_limb(tmp_path / "box.obj").notes
    assert (told.code, told.values["polygons"]) == ("file.polygons_split", 6)


def test_an_obj_that_may_have_y_upwards_is_noted_and_left_as_it_lies(
    mesh: Mesh, tmp_path: Path
) -> None:
    tall = mesh.with_vertices(mesh.vertices_mm * (1.0, 2.0, 1.0))
    path = write_limb(Limb(mesh=tall), tmp_path / "tall.obj")
    assert not read_limb(path).notes  # ours says of itself that +Z is up
    blenders = path.read_bytes().replace(b"# limbgram, unit: mm", b"# Blender 3.4.1")
    (tmp_path / "other.obj").write_bytes(blenders)
    read = read_limb(tmp_path / "other.obj")
    assert [one.code for one in read.notes] == ["file.obj.y_up"]
    np.testing.assert_allclose(np.ptp(read.mesh.vertices_mm, axis=0), (100, 200, 100), atol=1)
    lying = tall.with_vertices(tall.vertices_mm[:, [0, 2, 1]] * (1, -1, 1))
    other = write_limb(Limb(mesh=lying), tmp_path / "z.obj").read_bytes()
    (tmp_path / "upright.obj").write_bytes(other.replace(b"# limbgram, unit: mm", b"# Blender"))
    assert not read_limb(tmp_path / "upright.obj").notes


def test_the_table_finds_every_file_that_says_that_it_is_a_format() -> None:
    assert {one.name for one in FORMATS} >= {"stl", "3mf", "dxf", "ply", "obj", "glb", "vtp", "aop"}
    assert all(isinstance(one, Format) for one in FORMATS)
    assert len({one.place for one in FORMATS}) == len(FORMATS)
