"""The limb file beside a mesh: kept whole, and never taken for that of another shape."""

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import ExportError, ShapeFileError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import doubt, note, told
from limbgram.formats.export_checks import in_limb_frame
from limbgram.formats.limb_file import write_limb, write_limb_file
from limbgram.formats.ply import write_ply
from limbgram.formats.reading import read_limb, read_shape
from limbgram.formats.sidecar import limb_file_beside
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame


def motion(rotation: np.ndarray) -> dict[str, object]:
    return {"rotation": rotation.tolist(), "translation_mm": [0, 0, 0]}


def made_from(**changed: object) -> dict[str, object]:
    """An entry of the limb file that is understood, but for what is changed."""
    return {"sha256": "0", "mm_per_unit": 1.0, "mesh_from_it": motion(np.eye(3))} | changed


@pytest.fixture
def limb() -> Limb:
    box = trimesh.creation.box((100.0, 80.0, 200.0))
    motion = Rigid.from_rotation_vector(np.array([0.1, -0.2, 0.3]), np.array([1.0, 2.0, 3.0]))
    return AlignedLimb(
        mesh=Mesh(vertices_mm=np.asarray(box.vertices), faces=box.faces.astype(np.int32)),
        landmarks=(Landmark(name="Fibula Head", position_mm=np.array([50.0, 1 / 3, -7.0])),),
        frame=LimbFrame(limb_from_mesh=motion, side="left"),
        sock_mm=0.3,
        kind="transtibial",
    )


def test_it_keeps_everything(tmp_path: Path, limb: Limb) -> None:
    read = read_limb(write_limb(limb, tmp_path / "scan.ply"))
    assert read.frame.side == "left"
    assert read.sock_mm == 0.3
    assert read.kind == "transtibial"
    assert read.landmarks[0].name == "Fibula Head"
    np.testing.assert_array_equal(read.landmarks[0].position_mm, limb.landmarks[0].position_mm)
    ours, theirs = limb.frame.limb_from_mesh, read.frame.limb_from_mesh
    np.testing.assert_array_equal(theirs.matrix_3x4, ours.matrix_3x4)


def test_a_red_surface_is_told_by_its_name_and_by_what_is_made_of_it(
    tmp_path: Path, limb: Limb
) -> None:
    assert read_limb(write_limb(limb, tmp_path / "surface.ply")).doubt is None
    red = doubt("verdict.red_shape")
    for name in ("surface-RED.ply", "surface-RED-unitless.ply"):
        write_ply(limb.mesh, tmp_path / name, "mm")
        read = read_limb(tmp_path / name)
        assert (read.doubt, read.notes[0]) == (red, red)
    again = read_limb(write_limb(read, tmp_path / "rectified.stl"))
    assert (again.doubt, again.notes[0]) == (red, red)


def test_a_doubt_that_earlier_versions_kept_as_a_sentence_is_kept(
    tmp_path: Path, limb: Limb
) -> None:
    path = write_limb(limb, tmp_path / "rectified.ply")
    beside = path.with_name("rectified.limb.json")
    record = json.loads(beside.read_text("utf-8"))
    assert record["doubt"] == ""
    beside.write_text(json.dumps({**record, "doubt": "its verdict is RED"}), "utf-8")
    assert read_limb(path).doubt == note("said.as_is", message="its verdict is RED")


def test_it_names_what_a_shape_was_made_from(tmp_path: Path, limb: Limb) -> None:
    """Scan, edited, exported in other axes: by hash, nearest first, with the motion to each."""
    scan = write_limb(limb, tmp_path / "scan.ply")
    edited = write_limb(replace(read_limb(scan), sock_mm=1.0), tmp_path / "edited.stl")
    read = read_limb(edited)
    write_limb_file(read, edited, sha256=read.origins[0].sha256)  # as `align` does
    moved = write_limb(in_limb_frame(read_limb(edited)), tmp_path / "moved.glb")
    hashes = [hashlib.sha256(path.read_bytes()).hexdigest() for path in (moved, edited, scan)]
    found = read_limb(moved)
    assert [origin.sha256 for origin in found.origins] == hashes
    assert [origin.mm_per_unit for origin in found.origins] == [1000.0, 1.0, 1.0]
    for origin in found.origins[1:]:
        np.testing.assert_allclose(
            origin.mesh_from_origin.matrix_3x4, limb.frame.limb_from_mesh.matrix_3x4, atol=1e-12
        )
    np.testing.assert_allclose(
        found.origins[2].mesh_from_origin.apply(read_limb(scan).mesh.vertices_mm).mean(0),
        found.mesh.vertices_mm.mean(0),
        atol=1e-3,
    )


def test_one_of_before_that_entry_is_read(tmp_path: Path, limb: Limb) -> None:
    path = write_limb(limb, tmp_path / "scan.ply")
    kept = tmp_path / "scan.limb.json"
    tree = json.loads(kept.read_text())
    assert tree["version"] == 1
    del tree["made_from"]
    kept.write_text(json.dumps(tree))
    read = read_limb(path)
    assert [origin.sha256 for origin in read.origins] == [tree["mesh"]["sha256"]]


def test_that_of_another_mesh_is_refused(tmp_path: Path, limb: Limb) -> None:
    path = write_limb(limb, tmp_path / "scan.stl")
    content = bytearray(path.read_bytes())
    content[-3] ^= 1  # the attribute of the last triangle: the shape itself is the same
    path.write_bytes(content)
    with pytest.raises(ShapeFileError, match="belongs to another shape"):
        read_limb(path)
    (tmp_path / "scan.limb.json").unlink()
    assert not isinstance(read_limb(path), AlignedLimb)


def test_that_of_a_file_beside_is_left_to_it(tmp_path: Path, limb: Limb) -> None:
    write_limb(limb, tmp_path / "scan.ply")
    other = tmp_path / "scan.stl"
    trimesh.creation.box((90.0, 90.0, 210.0)).export(other)
    left = read_limb(other)
    assert not isinstance(left, AlignedLimb)
    assert (left.sock_mm, left.landmarks) == (0.0, ())
    (said,) = left.notes
    assert "scan.limb.json belongs to scan.ply and was not used" in told(said)
    assert read_limb(tmp_path / "scan.ply").notes == ()
    (tmp_path / "scan.ply").unlink()
    with pytest.raises(ShapeFileError, match="belongs to another shape"):
        read_limb(other)


def test_it_is_not_written_for_a_surface_that_the_file_does_not_hold(
    tmp_path: Path, limb: Limb
) -> None:
    path = write_limb(limb, tmp_path / "scan.ply")
    swollen = replace(limb, mesh=limb.mesh.with_vertices(limb.mesh.vertices_mm * 1.001))
    with pytest.raises(ExportError, match="another surface"):
        write_limb_file(swollen, path)


def test_a_namesake_in_another_format_has_a_limb_file_of_its_own(
    tmp_path: Path, limb: Limb
) -> None:
    """sock.ply exported as sock.stl, the natural name: both keep what is known of them."""
    write_limb(limb, tmp_path / "sock.ply")
    before = (tmp_path / "sock.limb.json").read_bytes()
    moved = in_limb_frame(limb)
    for _ in range(2):  # written again, it takes the place of its own alone
        write_limb(moved, tmp_path / "sock.stl")
        assert (tmp_path / "sock.limb.json").read_bytes() == before
        assert limb_file_beside(tmp_path / "sock.stl").name == "sock.stl.limb.json"
    for name, wanted in (("sock.ply", limb), ("sock.stl", moved)):
        found = read_limb(tmp_path / name)
        assert found.notes == ()
        np.testing.assert_array_equal(
            found.frame.limb_from_mesh.matrix_3x4, wanted.frame.limb_from_mesh.matrix_3x4
        )
        np.testing.assert_array_equal(
            found.landmarks[0].position_mm, wanted.landmarks[0].position_mm
        )
    (tmp_path / "sock.stl.limb.json").unlink()
    assert "belongs to sock.ply" in told(read_limb(tmp_path / "sock.stl").notes[0])


def test_it_knows_the_unit_of_the_mesh(tmp_path: Path, limb: Limb) -> None:
    path = tmp_path / "scan.stl"
    trimesh.Trimesh(limb.mesh.vertices_mm / 25.4, limb.mesh.faces).export(path)
    write_limb_file(replace(limb, mesh=read_limb(path, 25.4).mesh), path, mm_per_unit=25.4)
    assert np.ptp(read_limb(path).mesh.vertices_mm[:, 2]) == pytest.approx(200.0, abs=1e-4)
    with pytest.raises(ShapeFileError, match=r"25\.4"):
        read_limb(path, 10.0)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("format", "other"),
        ("version", 2),
        ("side", "upper"),
        ("kind", "tail"),
        ("sock_mm", -1),
        ("sock_mm", "thin"),
        ("landmarks", [{"name": "", "position_mm": [0, 0, 0]}]),
        ("landmarks", [{"name": "A", "position_mm": [0, 0]}]),
        ("landmarks", [{"name": "A", "position_mm": [0, 0, 0]}] * 2),
        ("landmarks", None),
        ("limb_from_mesh", {"rotation": (-np.eye(3)).tolist(), "translation_mm": [0, 0, 0]}),
        ("limb_from_mesh", {"rotation": (2 * np.eye(3)).tolist(), "translation_mm": [0, 0, 0]}),
        ("limb_from_mesh", {"rotation": [[1]], "translation_mm": [0, 0, 0]}),
        ("made_from", None),
        ("made_from", [{"sha256": "0", "mm_per_unit": 1.0}]),
        ("made_from", [made_from(mm_per_unit=0.0)]),
        ("made_from", [made_from(mesh_from_it=motion(2 * np.eye(3)))]),
        ("made_from", [made_from()] * 101),
    ],
)
def test_nonsense_is_refused(tmp_path: Path, limb: Limb, key: str, value: object) -> None:
    path = write_limb(limb, tmp_path / "scan.ply")
    kept = tmp_path / "scan.limb.json"
    kept.write_text(json.dumps(json.loads(kept.read_text()) | {key: value}))
    with pytest.raises(ShapeFileError, match=r"scan\.limb\.json"):
        read_limb(path)


def turned(by: float) -> dict[str, object]:
    """A motion whose rotation lacks so much of a right angle."""
    return motion(np.array([[1.0, by, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))


def marks(**of_one: object) -> list[dict[str, object]]:
    return [{"name": "A", "position_mm": [0, 0, 0], "placed": "click"} | of_one]


def numbered(count: int) -> list[dict[str, object]]:
    return [one for k in range(count) for one in marks(name=f"{k}")]


@pytest.mark.parametrize(
    ("key", "last", "beyond"),
    [
        ("sock_mm", 99.9, 100.0),
        ("landmarks", marks(name="A" * 80), marks(name="A" * 81)),
        ("landmarks", marks(sigma_mm=99.9), marks(sigma_mm=100.0)),
        ("landmarks", numbered(1000), numbered(1001)),
        ("made_from", [made_from()] * 100, [made_from()] * 101),
        ("limb_from_mesh", turned(0.9e-6), turned(1.1e-6)),
    ],
    ids=["sock", "name", "sigma", "landmarks", "origins", "rotation"],
)
def test_what_no_limb_has_is_refused(
    tmp_path: Path, limb: Limb, key: str, last: object, beyond: object
) -> None:
    path = write_limb(limb, tmp_path / "scan.ply")
    kept = tmp_path / "scan.limb.json"
    tree = json.loads(kept.read_text())
    kept.write_text(json.dumps(tree | {key: last}))
    read_limb(path)
    kept.write_text(json.dumps(tree | {key: beyond}))
    with pytest.raises(ShapeFileError):
        read_limb(path)


def test_of_a_doubt_400_letters_are_kept(tmp_path: Path, limb: Limb) -> None:
    path = write_limb(limb, tmp_path / "scan.ply")
    kept = tmp_path / "scan.limb.json"
    kept.write_text(json.dumps(json.loads(kept.read_text()) | {"doubt": "x" * 500}))
    assert read_limb(path).doubt == note("said.as_is", message="x" * 400)


def test_it_is_not_written_for_a_file_that_changed_since_it_was_read(
    tmp_path: Path, limb: Limb
) -> None:
    path = write_limb(limb, tmp_path / "scan.stl")
    read = read_shape(path)
    before = (tmp_path / "scan.limb.json").read_bytes()
    assert write_limb_file(read.limb, path, sha256=read.sha256).read_bytes() == before
    path.write_bytes(path.read_bytes()[:-1] + b"\1")
    with pytest.raises(ExportError, match="has changed"):
        write_limb_file(read.limb, path, sha256=read.sha256)
    assert (tmp_path / "scan.limb.json").read_bytes() == before


def test_stopped_between_mesh_and_limb_file_the_older_limb_file_is_refused(
    tmp_path: Path, limb: Limb, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_limb(limb, tmp_path / "out.ply")

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("limbgram.formats.limb_file._write_record", stop)
    swollen = replace(limb, mesh=limb.mesh.with_vertices(limb.mesh.vertices_mm * 1.01))
    with pytest.raises(KeyboardInterrupt):
        write_limb(swollen, path)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["out.limb.json", "out.ply"]
    with pytest.raises(ShapeFileError, match="move the limb file away and align again"):
        read_limb(path)


@pytest.mark.parametrize("name", ["x" * 81, "tibia\tend", ""])
def test_a_name_that_no_limb_file_can_hold_is_refused_before_anything_is_written(
    tmp_path: Path, limb: Limb, name: str
) -> None:
    mark = Landmark(name=name, position_mm=np.zeros(3))
    with pytest.raises(ExportError, match="A landmark cannot be called"):
        write_limb(replace(limb, landmarks=(mark,)), tmp_path / "a.ply")
    assert not list(tmp_path.iterdir())
