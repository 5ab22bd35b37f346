"""Every format gives the same surface in millimetres, or says what is wrong with the file."""

import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree

from limbgram.cli.export import KINDS
from limbgram.core.errors import OptionsError, ShapeFileError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import cut
from limbgram.core.mesh.topology import (
    boundary_loops,
    is_edge_manifold,
    is_vertex_manifold,
    split_nonmanifold_vertices,
    volume_mm3,
)
from limbgram.findings import told
from limbgram.formats.format import Format, Kept
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import SUFFIXES, read_limb
from limbgram.formats.table import FORMATS, format_of
from limbgram.formats.units import mm_per_unit_of
from limbgram.workbench.limb import AlignedLimb, Limb

BOX = trimesh.creation.box((100.0, 80.0, 200.0))
VOLUME = 100.0 * 80.0 * 200.0
VERTICES = np.asarray(BOX.vertices)
FACES = np.asarray(BOX.faces)


def ascii_stl(faces: np.ndarray = FACES) -> bytes:
    lines = ["solid box"]
    for corners in VERTICES[faces]:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x:e} {y:e} {z:e}" for x, y, z in corners]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid box"]).encode()


def binary_stl(header: bytes = b"solid but binary") -> bytes:
    records = b"".join(
        struct.pack("<12fH", 0, 0, 0, *corners.ravel(), 0) for corners in VERTICES[FACES]
    )
    return header.ljust(80) + struct.pack("<I", len(FACES)) + records


def ascii_ply() -> bytes:
    """Quads and triangles mixed, an extra column, CRLF."""
    head = ["ply", "format ascii 1.0", "element vertex 8"]
    head += [
        "property double x",
        "property double y",
        "property double z",
        "property float quality",
    ]
    head += ["element face 12", "property list uchar int vertex_indices", "end_header"]
    rows = [f"{x} {y} {z} 0.5" for x, y, z in VERTICES]
    return "\r\n".join([*head, *rows, *(f"3 {a} {b} {c}" for a, b, c in FACES)]).encode()


def big_endian_ply() -> bytes:
    """Two quads and eight triangles: faces of different lengths."""
    x, y = 50.0, 40.0
    ring = [(-x, -y), (x, -y), (x, y), (-x, y)]
    places = [(*p, -100.0) for p in ring] + [(*p, 100.0) for p in ring]
    faces = [(3, 2, 1, 0), (4, 5, 6, 7)]
    for k in range(4):
        n = (k + 1) % 4
        faces += [(k, n, 4 + n), (k, 4 + n, 4 + k)]
    head = (
        "ply\nformat binary_big_endian 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
    )
    head += "property float z\nelement face 10\nproperty list uchar uint vertex_index\nend_header\n"
    body = b"".join(struct.pack(">3f", *place) for place in places)
    body += b"".join(struct.pack(f">B{len(f)}I", len(f), *f) for f in faces)
    return head.encode() + body


def obj() -> bytes:
    """Slashes, a comment, and corners counted backwards."""
    lines = ["# from elsewhere", "o box"] + [f"v {x} {y} {z}" for x, y, z in VERTICES]
    lines += [f"f {a + 1}/1/2 {b + 1}//3 {c - 8}" for a, b, c in FACES]
    return "\n".join(lines).encode()


def flat_shaded(kind: str) -> bytes:
    """Every triangle has three vertices of its own, as programs write a surface without shading."""
    corners = VERTICES[FACES].reshape(-1, 3) / (1000.0 if kind == "glb" else 1.0)
    loose = trimesh.Trimesh(corners, np.arange(3 * len(FACES)).reshape(-1, 3), process=False)
    return bytes(loose.export(file_type=kind))


CONTENTS = {
    "a.stl": ascii_stl(),
    "b.STL": binary_stl(),
    "c.ply": ascii_ply(),
    "d.ply": big_endian_ply(),
    "e.obj": obj(),
    "f.glb": flat_shaded("glb"),
    "g.ply": flat_shaded("ply"),
}


@pytest.mark.parametrize("name", CONTENTS)
def test_a_foreign_box_is_a_box(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(CONTENTS[name])
    limb = read_limb(path)
    assert len(limb.mesh) == 8  # corners at one place are one vertex
    assert is_edge_manifold(limb.mesh.faces)
    assert volume_mm3(limb.mesh) == pytest.approx(VOLUME, rel=1e-6)
    assert limb.name == name
    assert not isinstance(limb, AlignedLimb)


def test_a_seam_of_the_texture_opens_no_section(tmp_path: Path) -> None:
    turn = np.append(np.linspace(0, 2 * np.pi, 72, endpoint=False), 0.0)  # the seam stands twice
    x, y = 0.05 * np.cos(turn), 0.05 * np.sin(turn)
    rings = [np.column_stack([x, np.full(73, height), -y]) for height in (0.0, 0.1, 0.2)]
    here = (73 * np.arange(2)[:, None] + np.arange(72)).ravel()
    faces = np.concatenate(
        [
            np.column_stack([here, here + 1, here + 74]),
            np.column_stack([here, here + 74, here + 73]),
        ]
    )
    tube = trimesh.Trimesh(np.concatenate(rings), faces, process=False)
    (tmp_path / "tube.glb").write_bytes(bytes(tube.export(file_type="glb")))
    mesh = read_limb(tmp_path / "tube.glb").mesh
    assert len(mesh) == 3 * 72
    (section,) = cut(mesh, [50.0])
    assert section.closed
    assert section.length_mm == pytest.approx(72 * 100 * np.sin(np.pi / 72), rel=1e-6)


def test_sheets_that_meet_at_an_edge_stay_apart(tmp_path: Path) -> None:
    """Four open sides at one place: no two of them belong together."""
    places = np.array([
        (0, 0, 0), (0, 0, 100), (80, 0, 50), (-80, 0, 50), (0, 80, 50), (0, -80, 50)
    ], float)  # fmt: skip
    mesh = Mesh(
        vertices_mm=places,
        faces=np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4], [1, 0, 5]], np.int32),
    )
    whole = split_nonmanifold_vertices(mesh)
    assert len(whole) == 12
    read = read_limb(write_limb(Limb(mesh=whole), tmp_path / "sheets.ply")).mesh
    np.testing.assert_array_equal(read.faces, whole.faces)


@pytest.mark.parametrize("name", [name for name in CONTENTS if name != "e.obj"])
def test_a_file_cut_off_anywhere_is_refused(tmp_path: Path, name: str) -> None:
    content = CONTENTS[name]
    path = tmp_path / name
    for length in range(0, len(content) - 40, max(1, len(content) // 60)):
        path.write_bytes(content[:length])
        with pytest.raises(ShapeFileError, match=name):
            read_limb(path)


def test_ours_keep_all_that_is_known(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    mesh = Mesh(
        vertices_mm=VERTICES.astype(np.float32).astype(float),
        faces=FACES.astype(np.int32),
        colours=rng.integers(0, 256, (8, 3), np.uint8),
        filled=np.arange(8) % 2 == 0,
        sigma_mm=rng.random(8).astype(np.float32),
    )
    read = read_limb(write_limb(Limb(mesh=mesh), tmp_path / "ours.ply")).mesh
    np.testing.assert_array_equal(read.vertices_mm, mesh.vertices_mm)
    np.testing.assert_array_equal(read.faces, mesh.faces)
    assert read.colours is not None
    assert read.filled is not None
    assert read.sigma_mm is not None
    np.testing.assert_array_equal(read.colours, mesh.colours)
    np.testing.assert_array_equal(read.filled, mesh.filled)
    np.testing.assert_array_equal(read.sigma_mm, mesh.sigma_mm)


@pytest.mark.parametrize("kind", [one for one in FORMATS if one.holds_limbs], ids=lambda k: k.name)
def test_a_limb_is_read_as_it_was_written_with_what_its_format_keeps(
    tmp_path: Path, kind: Format
) -> None:
    rng = np.random.default_rng(6)
    filled = np.arange(8) % 3 == 0
    known: dict[Kept, np.ndarray] = {
        "colours": rng.integers(0, 256, (8, 3), np.uint8),
        "filled": filled,
        "sigma": np.where(filled, np.nan, rng.random(8)).astype(np.float32),
        "shared errors": rng.random((8, 2)).astype(np.float32),
        "lost length": rng.random((8, 2)).astype(np.float32),
    }
    mesh = Mesh(
        vertices_mm=VERTICES + rng.random((8, 3)),
        faces=FACES.astype(np.int32),
        **{_FIELDS[name]: values for name, values in known.items()},
    )
    path = write_limb(Limb(mesh=mesh), tmp_path / f"box{kind.suffix}")
    read = read_limb(path).mesh
    # STL keeps no order of vertices: each is compared with the nearest.
    nearest = KDTree(read.vertices_mm).query(mesh.vertices_mm)
    assert sorted(nearest[1]) == list(range(8))
    assert nearest[0].max() <= kind.within_mm
    assert volume_mm3(read) == pytest.approx(volume_mm3(mesh), rel=1e-6)
    for name, values in known.items():
        held = getattr(read, _FIELDS[name])
        if name in kind.keeps:
            np.testing.assert_allclose(held, values, rtol=1e-6)
        else:
            assert held is None


@pytest.mark.parametrize("kept", ["colours", "filled", "sigma"])
@pytest.mark.parametrize("kind", [one for one in FORMATS if one.write], ids=lambda k: k.name)
def test_a_format_says_of_each_vertex_what_it_writes(
    tmp_path: Path, kind: Format, kept: Kept
) -> None:
    assert kind.write is not None
    bare = Mesh(vertices_mm=VERTICES, faces=FACES.astype(np.int32))
    values = {
        "colours": np.full((8, 3), 90, np.uint8),
        "filled": np.arange(8) % 3 == 0,
        "sigma": np.full(8, 0.1, np.float32),
    }[kept]
    without = kind.write(bare, tmp_path / f"bare{kind.suffix}", "mm")
    known = kind.write(replace(bare, **{_FIELDS[kept]: values}), tmp_path / f"a{kind.suffix}", "mm")
    assert (known.read_bytes() != without.read_bytes()) == (kept in kind.keeps)


_FIELDS: dict[Kept, str] = {
    "colours": "colours",
    "filled": "filled",
    "sigma": "sigma_mm",
    "shared errors": "shared_mm",
    "lost length": "lost_length",
}


def test_every_kind_of_the_table_is_offered_and_read() -> None:
    assert len({one.suffix for one in FORMATS}) == len(FORMATS)
    for one in FORMATS:
        assert one.read is not None or one.write is not None
        assert (one.suffix in SUFFIXES) == (one.read is not None)
        assert (one.name in KINDS) == (one.write is not None or one.name == "aop")
        assert format_of(Path(f"limb{one.suffix.upper()}")) is one


def test_faces_wound_at_random_come_out_outward(tmp_path: Path) -> None:
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=50)
    faces = np.asarray(sphere.faces).copy()
    flipped = np.random.default_rng(0).random(len(faces)) < 0.4
    faces[flipped] = faces[flipped][:, ::-1]
    path = tmp_path / "mixed.stl"
    trimesh.Trimesh(sphere.vertices, faces, process=False).export(path)
    limb = read_limb(path)
    assert volume_mm3(limb.mesh) == pytest.approx(sphere.volume, rel=1e-6)
    assert "turned" in told(limb.notes[0])


def test_a_mesh_inside_out_is_turned(tmp_path: Path) -> None:
    path = tmp_path / "inverted.stl"
    path.write_bytes(ascii_stl(FACES[:, ::-1]))
    assert volume_mm3(read_limb(path).mesh) == pytest.approx(VOLUME)


def test_two_boxes_that_share_an_edge_stay_whole(tmp_path: Path) -> None:
    other = BOX.copy()
    other.apply_translation((100.0, 80.0, 0.0))
    path = tmp_path / "touching.stl"
    trimesh.util.concatenate([BOX, other]).export(path)
    mesh = read_limb(path).mesh
    assert len(mesh.faces) == 24
    assert is_edge_manifold(mesh.faces)


def test_sheets_that_touch_in_a_point_are_parted_there(tmp_path: Path) -> None:
    """Two open boxes, corner to corner: their rims are two loops, not one that meets itself."""
    other = BOX.copy()
    other.apply_translation((100.0, 80.0, 0.0))
    upper = np.asarray(BOX.vertices)[:, 2] > 0
    open_faces = FACES[~upper[FACES].all(1)]
    two = np.concatenate([np.asarray(BOX.vertices), np.asarray(other.vertices)])
    low = (two[:, 2] < 0)[:, None] & (np.arange(len(two)) >= len(VERTICES))[:, None]
    two = two + low * np.array([5.0, 5.0, 0.0])  # only the upper corners meet
    faces = np.concatenate([open_faces, open_faces + len(VERTICES)])
    path = tmp_path / "touching.stl"
    trimesh.Trimesh(two, faces, process=False).export(path)
    mesh = read_limb(path).mesh
    assert len(mesh.faces) == len(faces)
    assert is_edge_manifold(mesh.faces)
    assert is_vertex_manifold(mesh.faces)
    assert [len(loop) for loop in boundary_loops(mesh.faces)] == [4, 4]
    assert len(mesh.vertices_mm) == 16


@pytest.mark.parametrize(
    ("factor", "guess"), [(1e-3, " m"), (1 / 25.4, "inch"), (0.1, "cm"), (1e3, "no limb")]
)
def test_a_limb_of_no_limbs_size_is_asked_about(tmp_path: Path, factor: float, guess: str) -> None:
    path = tmp_path / "odd.stl"
    trimesh.Trimesh(VERTICES * factor, FACES).export(path)
    with pytest.raises(ShapeFileError, match="--unit") as refused:
        read_limb(path)
    assert guess in str(refused.value)
    mesh = read_limb(path, 1 / factor).mesh
    assert volume_mm3(mesh) == pytest.approx(VOLUME, rel=1e-5)


def test_units_are_words_or_numbers() -> None:
    assert [mm_per_unit_of(text) for text in ("mm", "cm", "m", "inch", "383")] == [
        1,
        10,
        1000,
        25.4,
        383,
    ]
    for text in ("yard", "-1", "0", "nan", "inf", ""):
        with pytest.raises(OptionsError, match="no unit"):
            mm_per_unit_of(text)


def test_a_file_without_scale_says_so(tmp_path: Path) -> None:
    path = tmp_path / "scan-unitless.stl"
    path.write_bytes(binary_stl(b"limbgram binary STL, unit: unitless"))
    with pytest.raises(ShapeFileError, match="no scale"):
        read_limb(path)
    assert volume_mm3(read_limb(path, 1.0).mesh) == pytest.approx(VOLUME)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("none.stl", b""),
        (
            "cloud.ply",
            b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
        ),
        ("nan.obj", b"v nan 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n"),
        ("far.obj", b"v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 9\n"),
        ("line.obj", b"v 0 0 0\nv 100 0 0\nv 50 0 0\nf 1 2 3\n"),
        ("shape.step", b"ISO-10303-21;"),
        ("broken.glb", b"glTF\x02\x00\x00\x00nothing"),
    ],
)
def test_what_is_no_surface_is_refused(tmp_path: Path, name: str, content: bytes) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ShapeFileError, match=name):
        read_limb(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ShapeFileError, match="cannot be read"):
        read_limb(tmp_path / "nowhere.stl")


@pytest.mark.parametrize("content", [b"", b"a note\n", b"A letter about the fitting. " * 20])
def test_what_is_no_stl_is_not_called_a_cut_off_one(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.stl"
    path.write_bytes(content)
    with pytest.raises(ShapeFileError, match="no STL file") as refused:
        read_limb(path)
    assert "triangles" not in str(refused.value)


def test_a_cut_off_stl_still_says_how_much_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "a.stl"
    path.write_bytes(bytes(80) + struct.pack("<I", 12) + bytes(3 * 50))
    with pytest.raises(ShapeFileError, match="promises 12 triangles and there is room for 3"):
        read_limb(path)


@pytest.mark.parametrize("comment", ["TextureFile Åse.png".encode(), b"left leg \x85 cast"])
def test_a_ply_comment_may_be_in_any_encoding(tmp_path: Path, comment: bytes) -> None:
    content = ascii_ply().replace(b"element vertex", b"comment " + comment + b"\r\nelement vertex")
    (tmp_path / "a.ply").write_bytes(content)
    assert len(read_limb(tmp_path / "a.ply").mesh) == 8


@pytest.mark.parametrize("one", ["128 64 255", "0.501961 0.25098 1", "0.501961 0.25098 1 0.5"])
def test_colours_of_an_obj_may_be_shares_or_whole_numbers(tmp_path: Path, one: str) -> None:
    lines = [f"v {x} {y} {z} {one}" for x, y, z in VERTICES]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES]
    (tmp_path / "a.obj").write_text("\n".join(lines))
    colours = read_limb(tmp_path / "a.obj").mesh.colours
    assert colours is not None
    assert np.unique(colours, axis=0).tolist() == [[128, 64, 255]]
