"""Damaged files are refused: a surface with faces missing never looks whole."""

import codecs
import json
import struct
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import LimbgramError, ShapeFileError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.formats.format import Format
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import read_limb
from limbgram.formats.table import FORMATS
from limbgram.formats.triangle_soup import fans_of
from limbgram.workbench.limb import Limb

BOX = trimesh.creation.box((100.0, 80.0, 200.0))
PLACES = [" ".join(f"{value:g}" for value in row) for row in np.asarray(BOX.vertices)]
FACES = np.asarray(BOX.faces)

PLY = "\n".join(
    [
        "ply",
        "format ascii 1.0",
        "element vertex 8",
        "property float x",
        "property float y",
        "property float z",
        "property float sigma",
        "element face 12",
        "property list uchar int vertex_indices",
        "end_header",
        *(f"{place} 0.1" for place in PLACES),
        *(f"3 {a} {b} {c}" for a, b, c in FACES),
        "",
    ]
)
OBJ = "\n".join(
    [*(f"v {place}" for place in PLACES), *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES), ""]
)
STL = "\n".join(
    [
        "solid box",
        *(
            "facet normal 0 0 0\nouter loop\n"
            + "\n".join(f"vertex {PLACES[k]}" for k in face)
            + "\nendloop\nendfacet"
            for face in FACES
        ),
        "endsolid box",
        "",
    ]
)
FIRST = f"3 {' '.join(map(str, FACES[0]))}"
FACE = f"f {' '.join(str(k + 1) for k in FACES[0])}"


def read(tmp_path: Path, name: str, content: str | bytes) -> Limb:
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_limb(path)


@pytest.mark.parametrize(("name", "content"), [("a.ply", PLY), ("a.obj", OBJ), ("a.stl", STL)])
def test_whole_they_are_read(tmp_path: Path, name: str, content: str) -> None:
    limb = read(tmp_path, name, content)
    assert len(limb.mesh.faces) == 12
    assert limb.notes == ()
    # Ends of lines and blanks are nobody's damage.
    again = read(tmp_path, name, content.replace("\n", "\r\n").replace(" ", "  "))
    np.testing.assert_array_equal(again.mesh.faces, limb.mesh.faces)
    # Nor is the byte order mark of an editor.
    marked = read(tmp_path, name, codecs.BOM_UTF8 + content.encode())
    np.testing.assert_array_equal(marked.mesh.vertices_mm, limb.mesh.vertices_mm)


DAMAGE = {
    "ply: counts one face less": ("a.ply", PLY, "face 12", "face 11"),
    "ply: counts one face more": ("a.ply", PLY, "face 12", "face 13"),
    "ply: a face lost a corner": ("a.ply", PLY, FIRST, FIRST[:-2]),
    "ply: a face has one more": ("a.ply", PLY, FIRST, FIRST + " 1"),
    "ply: a face counts two": ("a.ply", PLY, FIRST, "2" + FIRST[1:-2]),
    "ply: a corner in fractions": ("a.ply", PLY, FIRST, FIRST + ".5"),
    "ply: a vertex lost its sigma": ("a.ply", PLY, f"{PLACES[0]} 0.1", PLACES[0]),
    "ply: a negative sigma": ("a.ply", PLY, " 0.1\n", " -1\n"),
    "ply: an infinite sigma": ("a.ply", PLY, " 0.1\n", " inf\n"),
    "ply: a word of the header": ("a.ply", PLY, "property float z", "propertx float z"),
    "ply: faces in fractions": ("a.ply", PLY, "uchar int", "uchar float"),
    "ply: count in fractions": ("a.ply", PLY, "uchar int", "float int"),
    "obj: a word": ("a.obj", OBJ, FACE, FACE.replace("f", "g2")),
    "obj: a face lost a corner": ("a.obj", OBJ, FACE, FACE[:-2]),
    "obj: a corner in fractions": ("a.obj", OBJ, FACE, FACE + ".5"),
    "obj: a corner 0": ("a.obj", OBJ, FACE, FACE[:-1] + "0"),
    "obj: a vertex lost a number": ("a.obj", OBJ, PLACES[0], PLACES[0].rsplit(" ", 1)[0]),
    "stl: a corner lost a number": ("a.stl", STL, PLACES[0], PLACES[0].rsplit(" ", 1)[0]),
    "stl: a corner lost its word": ("a.stl", STL, "vertex", "vertx"),
    "stl: a triangle lost its end": ("a.stl", STL, "endfacet\n", ""),
    "stl: a corner no number": ("a.stl", STL, PLACES[0], PLACES[0] + "-"),
    "stl: a corner without end": ("a.stl", STL, PLACES[0], PLACES[0][:-1] + "e999"),
}


@pytest.mark.parametrize("kind", [one for one in FORMATS if one.holds_limbs], ids=lambda k: k.name)
def test_overwritten_bytes_are_refused_or_read_but_never_crash(
    tmp_path: Path, kind: Format
) -> None:
    whole = write_limb(
        Limb(mesh=Mesh(vertices_mm=np.asarray(BOX.vertices), faces=FACES.astype(np.int32))),
        tmp_path / f"a{kind.suffix}",
    ).read_bytes()
    rng = np.random.default_rng(20)
    refused = 0
    for trial in range(150):
        content = bytearray(whole)
        for at in rng.integers(0, len(whole), 3):
            content[at] = rng.integers(0, 256)
        path = tmp_path / f"{trial}{kind.suffix}"
        path.write_bytes(content)
        try:
            read_limb(path)
        except LimbgramError:
            refused += 1
    assert refused > 0


@pytest.mark.parametrize("damage", DAMAGE)
def test_damage_is_refused_and_not_passed_over(tmp_path: Path, damage: str) -> None:
    name, content, old, new = DAMAGE[damage]
    assert old in content
    with pytest.raises(ShapeFileError, match=name):
        read(tmp_path, name, content.replace(old, new, 1))


def bomb(kind: str, corners: int) -> bytes:
    """A box of whose faces the last has so many corners."""
    ring = " ".join(["1", "2", "3", "4", "5", "6"] * (corners // 6))
    if kind == "obj":
        return OBJ.encode() + f"f {ring}\n".encode()
    text = PLY.replace("element face 12", "element face 13").replace("uchar int", "uint uint")
    if kind == "ply":
        return text.encode() + f"{corners} {ring}\n".encode()
    head, _, _ = text.replace("ascii", "binary_little_endian").partition("end_header\n")
    rows = np.zeros(8, np.dtype([("xyz", "<f4", 3), ("sigma", "<f4")]))
    rows["xyz"] = BOX.vertices
    faces = np.column_stack([np.full(12, 3), FACES]).astype("<u4").tobytes()
    last = np.append(corners, np.tile(np.arange(6), corners // 6)).astype("<u4").tobytes()
    return f"{head}end_header\n".encode() + rows.tobytes() + faces + last


@pytest.mark.parametrize("kind", ["obj", "ply", "binary.ply"])
def test_a_face_of_six_hundred_thousand_corners_is_refused_at_once(
    tmp_path: Path, kind: str
) -> None:
    """Made into triangles it took two hundred times the memory of its file."""
    content = bomb(kind, 600_000)
    (tmp_path / f"box.{kind}").write_bytes(content)
    tracemalloc.start()
    with pytest.raises(ShapeFileError, match=r"a face has [\d,]+ corners or more, and there are 8"):
        read_limb(tmp_path / f"box.{kind}", 1.0)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 8 * len(content)


@pytest.mark.parametrize("kind", ["obj", "ply", "binary.ply"])
def test_a_face_with_as_many_corners_as_there_are_vertices_is_read(
    tmp_path: Path, kind: str
) -> None:
    (tmp_path / f"box.{kind}").write_bytes(bomb(kind, 6))
    assert len(read_limb(tmp_path / f"box.{kind}", 1.0).mesh.faces) >= 12


def test_polygons_become_fans_round_their_first_corner() -> None:
    found = fans_of([[4, 5, 6], [0, 1, 2, 3], [7, 3, 2, 1, 0]])
    wanted = [[4, 5, 6], [0, 1, 2], [0, 2, 3], [7, 3, 2], [7, 2, 1], [7, 1, 0]]
    np.testing.assert_array_equal(found, wanted)
    assert fans_of([]).shape == (0, 3)
    for bad in (-1, 2**31, 10**30):
        with pytest.raises(ValueError, match="cannot be"):
            fans_of([[0, 1, bad]])


def test_tabs_and_lines_that_go_on_are_read(tmp_path: Path) -> None:
    content = OBJ.replace("f ", "f\t").replace(PLACES[0], PLACES[0].replace(" ", " \\\n", 1))
    assert len(read(tmp_path, "a.obj", content).mesh.faces) == 12


def test_an_stl_of_34_bytes_counts_no_triangles_backwards(tmp_path: Path) -> None:
    with pytest.raises(ShapeFileError, match="no STL file"):
        read(tmp_path, "a.stl", b"\0" * 34)


def _binary_ply(count_kind: str, faces: bytes, number: int = 12) -> bytes:
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty float x\n"
    head += f"property float y\nproperty float z\nelement face {number}\n"
    head += f"property list {count_kind} int vertex_indices\nend_header\n"
    return head.encode() + np.asarray(BOX.vertices, "<f4").tobytes() + faces


@pytest.mark.parametrize(
    ("kind", "faces"),
    [
        ("float", struct.pack("<f", float("inf")) * 60),
        ("float", struct.pack("<f", -1.0) * 60),
        ("char", struct.pack("<b", -1) * 160),
        ("int", struct.pack("<i", -1) * 60),
        ("int", struct.pack("<i", 2**31 - 1) * 60),
        ("uchar", b"\0" * 160),
    ],
)
def test_a_binary_ply_counts_forwards_and_comes_to_its_end(
    tmp_path: Path, kind: str, faces: bytes
) -> None:
    with pytest.raises(ShapeFileError, match="no PLY file"):
        read(tmp_path, "a.ply", _binary_ply(kind, faces))
    with pytest.raises(ShapeFileError, match="no PLY file"):
        read(tmp_path, "a.ply", _binary_ply(kind, faces, 4_000_000_000))


def test_a_binary_ply_with_bytes_left_over_is_refused(tmp_path: Path) -> None:
    rows = b"".join(struct.pack("<B3i", 3, *face) for face in FACES)
    assert len(read(tmp_path, "a.ply", _binary_ply("uchar", rows)).mesh.faces) == 12
    with pytest.raises(ShapeFileError, match="bytes behind its faces"):
        read(tmp_path, "a.ply", _binary_ply("uchar", rows, 11))


def test_values_behind_the_corners_of_faces_are_passed_over(tmp_path: Path) -> None:
    """As MeshLab writes the colours of faces."""
    listed = "property list uchar int vertex_indices\n"
    coloured = PLY.replace(listed, f"{listed}property uchar red\nproperty float quality\n")
    rows = [f"3 {a} {b} {c}" for a, b, c in FACES]
    whole = coloured
    for row in rows:
        whole = whole.replace(f"\n{row}\n", f"\n{row} 255 0.5\n")
    np.testing.assert_array_equal(
        read(tmp_path, "a.ply", whole).mesh.faces, read(tmp_path, "b.ply", PLY).mesh.faces
    )
    for damage in (coloured, whole.replace(" 255 0.5\n", " 255\n", 1)):
        with pytest.raises(ShapeFileError, match="no PLY file"):
            read(tmp_path, "a.ply", damage)
    with pytest.raises(ShapeFileError, match="no PLY file"):
        read(tmp_path, "a.ply", whole.replace(f"\n{rows[0]} 255 0.5\n", "\n1\n"))


@pytest.mark.parametrize("quads", [False, True])
def test_binary_values_behind_the_corners_are_passed_over(tmp_path: Path, quads: bool) -> None:
    faces = [[*face] for face in FACES.tolist()]
    if quads:
        faces[0].append(faces[0][0])
    rows = b"".join(struct.pack(f"<B{len(f)}iBf", len(f), *f, 255, 0.5) for f in faces)
    listed = b"int vertex_indices\n"
    content = _binary_ply("uchar", rows).replace(
        listed, listed + b"property uchar red\nproperty float quality\n"
    )
    assert len(read(tmp_path, "a.ply", content).mesh.faces) == 12
    for cut in (1, 5, 18):
        with pytest.raises(ShapeFileError, match="no PLY file"):
            read(tmp_path, "b.ply", content[:-cut])


@pytest.mark.parametrize("all_textured", [True, False])
def test_texture_places_of_a_face_s_corners_are_passed_over(
    tmp_path: Path, all_textured: bool
) -> None:
    """As MeshLab writes them: a second list, which is empty where a face has no texture."""
    listed = "property list uchar int vertex_indices\n"
    textured = f"{listed}property list uchar float texcoord\nproperty int texnumber\n"
    places = [[0.5] * (6 if all_textured or k % 3 else 0) for k in range(len(FACES))]
    rows, text = b"", PLY.replace(listed, textured)
    for corners, uv in zip(FACES.tolist(), places, strict=True):
        rows += struct.pack(f"<B3iB{len(uv)}fi", 3, *corners, len(uv), *uv, 0)
        row = "3 " + " ".join(map(str, corners))
        words = " ".join(map(str, [len(uv), *uv, 0]))
        text = text.replace(f"\n{row}\n", f"\n{row} {words}\n")
    binary = _binary_ply("uchar", rows).replace(listed.encode(), textured.encode())
    plain = read(tmp_path, "a.ply", PLY).mesh
    for content in (text, binary):
        np.testing.assert_array_equal(read(tmp_path, "b.ply", content).mesh.faces, plain.faces)
    for damage in (binary[:-1], text.replace(" 0\n", "\n", 1)):
        with pytest.raises(ShapeFileError, match="no PLY file"):
            read(tmp_path, "c.ply", damage)


def sphere() -> Mesh:
    made = trimesh.creation.icosphere(subdivisions=2, radius=50)
    rng = np.random.default_rng(4)
    count = len(made.vertices)
    sigma = rng.random(count).astype(np.float32)
    sigma[:5] = np.nan
    return Mesh(
        vertices_mm=np.asarray(made.vertices).astype(np.float32).astype(float),
        faces=np.asarray(made.faces, np.int32),
        colours=rng.integers(0, 256, (count, 3), np.uint8),
        sigma_mm=sigma,
    )


def glb_of(tree: dict[str, Any], numbers: bytes) -> bytes:
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    numbers += b"\0" * (-len(numbers) % 4)
    whole = 12 + 8 + len(text) + 8 + len(numbers)
    return (
        struct.pack("<4sII", b"glTF", 2, whole)
        + struct.pack("<I4s", len(text), b"JSON")
        + text
        + struct.pack("<I4s", len(numbers), b"BIN\0")
        + numbers
    )


def parts_of(content: bytes) -> tuple[dict[str, Any], bytes]:
    size = struct.unpack_from("<I", content, 12)[0]
    return json.loads(content[20 : 20 + size]), content[28 + size :]


def test_our_glb_keeps_all_that_is_known(tmp_path: Path) -> None:
    mesh = sphere()
    read_back = read_limb(write_limb(Limb(mesh=mesh), tmp_path / "a.glb")).mesh
    np.testing.assert_array_equal(read_back.faces, mesh.faces)
    np.testing.assert_allclose(read_back.vertices_mm, mesh.vertices_mm, atol=1e-5)
    np.testing.assert_array_equal(read_back.colours, mesh.colours)
    np.testing.assert_allclose(read_back.sigma_mm, mesh.sigma_mm, rtol=1e-6)


def test_a_foreign_glb_is_read_as_another_library_reads_it(tmp_path: Path) -> None:
    """Two meshes, one of them twice, mirrored, turned and scaled, below other nodes."""
    scene = trimesh.Scene()
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [0.1, 0, 0])
    mirror, small = np.diag([-1.0, 1, 1, 1]), np.diag([0.9, 0.9, 0.9, 1])
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.1)
    scene.add_geometry(ball, node_name="a", geom_name="ball", transform=turn)
    scene.add_geometry(
        trimesh.creation.cylinder(0.05, 0.4), node_name="b", parent_node_name="a",
        transform=turn @ mirror,
    )  # fmt: skip
    scene.graph.update(frame_from="b", frame_to="c", matrix=turn @ small, geometry="ball")
    path = tmp_path / "foreign.glb"
    path.write_bytes(scene.export(file_type="glb"))
    other = trimesh.load_scene(path, process=False).to_mesh()
    ours = read_limb(path).mesh
    assert len(ours.faces) == len(other.faces)
    upright = np.asarray(other.vertices) @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]) * 1000
    np.testing.assert_allclose(ours.vertices_mm.min(0), upright.min(0), atol=1e-3)
    np.testing.assert_allclose(ours.vertices_mm.max(0), upright.max(0), atol=1e-3)
    assert volume_mm3(ours) == pytest.approx(abs(other.volume) * 1e9, rel=1e-4)


@pytest.mark.parametrize("mode", [5, 6])
def test_strips_and_fans_are_triangles(tmp_path: Path, mode: int) -> None:
    places = np.array(
        [[0, 0, 0], [0.1, 0, 0], [-0.02, 0.1, 0], [0.12, 0.1, 0], [0, 0.2, 0], [0.1, 0.2, 0]], "<f4"
    )
    ring = np.array([0, 1, 3, 5, 4, 2], np.uint8) if mode == 6 else np.arange(6, dtype=np.uint8)
    tree = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0, "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": mode}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 72},
            {"buffer": 0, "byteOffset": 72, "byteLength": 6},
        ],
        "buffers": [{"byteLength": 78}],
    }
    mesh = read(tmp_path, "a.glb", glb_of(tree, places.tobytes() + ring.tobytes())).mesh
    assert len(mesh.faces) == 4
    normals = mesh.face_normals()
    assert np.linalg.norm(normals, axis=1).sum() / 2 == pytest.approx(120 * 200)
    assert (normals @ normals[0] > 0).all()


def _set(*way: Any) -> Callable[[dict[str, Any]], None]:
    *keys, last, value = way

    def change(tree: dict[str, Any]) -> None:
        for key in keys:
            tree = tree[key]
        tree[last] = value

    return change


GLB_DAMAGE: dict[str, Callable[[dict[str, Any]], None]] = {
    "a node below itself": _set("nodes", 0, "children", [0]),
    "a node that is not there": _set("scenes", 0, "nodes", [99]),
    "counted backwards": _set("scenes", 0, "nodes", [-1]),
    "more numbers than there are": _set("accessors", 0, "count", 10**9),
    "an offset without end": _set("bufferViews", 0, "byteOffset", 10**15),
    "an offset before the beginning": _set("bufferViews", 0, "byteOffset", -4),
    "in fractions": _set("accessors", 0, "count", 1.5),
    "a text": _set("accessors", 0, "count", "12"),
    "another kind": _set("accessors", -1, "componentType", 5126),
    "no list": _set("meshes", {}),
    "a misspelt key": _set("meshes", 0, "primitives", 0, "indyces", 0),
    "null": _set("meshes", 0, "primitives", None),
    "compressed": _set("extensionsRequired", ["KHR_draco_mesh_compression"]),
    "elsewhere": _set("buffers", 0, "uri", "https://example.org/a.bin"),
    "not by this program": _set("asset", {"version": "1.0"}),
    "text that is not UTF-8": _set("asset", {"version": "2.0", "x": "\ud800"}),
}


@pytest.mark.parametrize("damage", GLB_DAMAGE)
def test_a_damaged_glb_is_refused(tmp_path: Path, damage: str) -> None:
    tree, numbers = parts_of(write_limb(Limb(mesh=sphere()), tmp_path / "a.glb").read_bytes())
    GLB_DAMAGE[damage](tree)
    with pytest.raises(ShapeFileError, match=r"b\.glb is no GLB file"):
        read(tmp_path, "b.glb", glb_of(tree, numbers))


def test_a_glb_with_bad_text_or_another_length_is_refused(tmp_path: Path) -> None:
    content = write_limb(Limb(mesh=sphere()), tmp_path / "a.glb").read_bytes()
    bad = content.replace(b'"asset"', b'"as\xff\xfet"')
    for changed in (bad, content[:-4], content + b"\0\0\0\0", content[:21] + b"," + content[22:]):
        with pytest.raises(ShapeFileError, match=r"b\.glb is no GLB file"):
            read(tmp_path, "b.glb", changed)


@pytest.mark.parametrize(("told", "value"), [("sigma", -0.5), ("sigma", np.inf)])
def test_a_sigma_that_cannot_be_is_refused(tmp_path: Path, told: str, value: float) -> None:
    mesh = sphere()
    assert mesh.sigma_mm is not None
    content = write_limb(Limb(mesh=mesh), tmp_path / "a.glb").read_bytes()
    old = (mesh.sigma_mm * np.float32(0.001)).astype("<f4")[10].tobytes()
    assert content.count(old) == 1
    with pytest.raises(ShapeFileError, match=told):
        read(tmp_path, "b.glb", content.replace(old, struct.pack("<f", value)))


def _with_corners_apart(share: float) -> bytes:
    """A sphere of 1,280 triangles as STL, some of them each moved by 0.0002 mm."""
    triangles = np.array(trimesh.creation.icosphere(3, radius=60.0).triangles)
    moved = int(share * len(triangles))
    step = np.random.default_rng(4).normal(0.0, 2e-4, (moved, 3, 3))
    triangles[:moved] += step
    loose = trimesh.Trimesh(
        triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=False
    )
    return bytes(loose.export(file_type="stl"))


def test_triangles_that_share_no_corners_are_refused_and_not_called_a_brim(tmp_path: Path) -> None:
    with pytest.raises(ShapeFileError) as refused:
        read(tmp_path, "a.stl", _with_corners_apart(1.0))
    assert refused.value.finding.code == "file.triangles_apart"
    assert refused.value.finding.values["triangles"] == 1280
    assert refused.value.finding.values["sides_open_share"] == 1.0


def test_a_surface_with_some_triangles_apart_is_read(tmp_path: Path) -> None:
    assert len(read(tmp_path, "a.stl", _with_corners_apart(0.1)).mesh.faces) > 1100


def test_an_stl_with_bytes_behind_its_triangles_is_not_said_to_be_cut_off(tmp_path: Path) -> None:
    with pytest.raises(ShapeFileError, match="2 bytes stand behind the 12 triangles") as refused:
        read(tmp_path, "a.stl", bytes(BOX.export(file_type="stl")) + b"\0\0")
    assert refused.value.finding.code == "file.stl.longer"
