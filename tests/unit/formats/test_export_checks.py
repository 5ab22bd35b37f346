"""What must hold before a carver gets a shape, and DXF beside it."""

from dataclasses import replace
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import trimesh
from ezdxf.render import MeshBuilder

from limbgram.core.errors import CarveError, ExportError, MeasureError, OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.folds import ANY_SHAPE, find_folds
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import told
from limbgram.formats.curves import curves_of
from limbgram.formats.dxf_r12 import write_drawing, write_polyface_dxf, write_r12_dxf
from limbgram.formats.export_checks import (
    admit,
    in_limb_frame,
    require_unfolded,
    sure_in_limb_frame,
)
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame, Side


@pytest.fixture
def limb() -> Limb:
    box = trimesh.creation.box((100.0, 80.0, 200.0))
    turn = Rigid.from_rotation_vector(np.array([0.0, 0, np.pi / 2]), np.array([0.0, 0, 100]))
    return AlignedLimb(
        mesh=Mesh(vertices_mm=np.asarray(box.vertices), faces=box.faces.astype(np.int32)),
        landmarks=(Landmark(name="A", position_mm=np.array([50.0, 0, 0])),),
        frame=LimbFrame(limb_from_mesh=turn, side="left"),
    )


def test_an_aligned_limb_of_the_confirmed_side_passes_in_its_frame(limb: Limb) -> None:
    passed = admit(limb, "left")
    np.testing.assert_allclose(np.ptp(passed.mesh.vertices_mm, axis=0), (80, 100, 200))
    assert passed.mesh.vertices_mm[:, 2].min() == pytest.approx(0)
    np.testing.assert_allclose(passed.landmarks[0].position_mm, (0, 50, 100), atol=1e-12)
    again = in_limb_frame(passed)
    np.testing.assert_array_equal(again.mesh.vertices_mm, passed.mesh.vertices_mm)


def test_what_is_not_sure_does_not_pass(limb: Limb) -> None:
    with pytest.raises(OptionsError, match="confirmed"):
        admit(limb, None)
    with pytest.raises(CarveError, match="'right' and the shape was aligned as 'left'"):
        admit(limb, "right")
    with pytest.raises(MeasureError, match="not aligned"):
        admit(limb.unaligned(), "left")
    inverted = replace(limb.mesh, faces=limb.mesh.faces[:, ::-1].copy())
    with pytest.raises(CarveError, match="inside out"):
        admit(limb.with_mesh(inverted), "left")
    inches = limb.mesh.with_vertices(limb.mesh.vertices_mm / 25.4)
    with pytest.raises(CarveError, match="unit"):
        admit(limb.with_mesh(inches), "left")


def _in_its_frame(shape: trimesh.Trimesh) -> Limb:
    mesh = Mesh(vertices_mm=np.asarray(shape.vertices), faces=shape.faces.astype(np.int32))
    return AlignedLimb(mesh=mesh, frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="left"))


def test_what_is_folded_goes_back_and_is_told() -> None:
    ball = _in_its_frame(trimesh.creation.icosphere(subdivisions=4, radius=50))
    vertices = ball.mesh.vertices_mm.copy()
    vertices[700] *= 1.5
    folded = ball.with_mesh(ball.mesh.with_vertices(vertices))
    with pytest.raises(ExportError, match="folds over or through itself at"):
        require_unfolded(folded.mesh)
    passed = admit(folded, "left")
    require_unfolded(passed.mesh)
    assert not len(find_folds(passed.mesh, ANY_SHAPE))
    (note,) = passed.notes
    assert "1 of its points went back among their neighbours, by up to 25." in told(note)
    np.testing.assert_array_equal(np.flatnonzero(passed.mesh.filled), [700])
    assert np.linalg.norm(passed.mesh.vertices_mm[700]) == pytest.approx(50, abs=0.2)
    np.testing.assert_array_equal(
        np.delete(passed.mesh.vertices_mm, 700, 0), np.delete(ball.mesh.vertices_mm, 700, 0)
    )
    assert sure_in_limb_frame(ball).mesh is ball.mesh or not sure_in_limb_frame(ball).notes


def test_what_cannot_go_back_is_refused_with_its_place() -> None:
    upright = trimesh.creation.box((60, 60, 300))
    across = trimesh.creation.box((200, 50, 50))
    crossed = _in_its_frame(trimesh.util.concatenate([upright, across]))
    with pytest.raises(ExportError, match=r"folds over or through itself .* the first near \("):
        admit(crossed, "left")
    beside = trimesh.creation.box((60, 60, 300))
    beside.apply_translation((60, 60, 0))
    joined = trimesh.util.concatenate([upright, beside])
    joined.merge_vertices()  # one edge, four faces
    for asked in (admit, lambda limb, _: sure_in_limb_frame(limb)):
        with pytest.raises(ExportError, match=r"at 4 triangles the surface branches.* near \("):
            asked(_in_its_frame(joined), "left")


@pytest.mark.parametrize("turn_deg", [0, 180])
def test_landmarks_speak_against_a_kept_side_or_front(limb: Limb, turn_deg: int) -> None:
    """As in a limb file of an older version, or one that was corrected by hand."""
    head = Landmark(name="fibula head", position_mm=np.array([0.0, 40, 50]))  # the patient's left
    crest = Landmark(name="tibial crest", position_mm=np.array([50.0, 0, 50]))
    turn = Rigid.from_rotation_vector(np.array([0.0, 0, np.radians(90 + turn_deg)]), np.zeros(3))
    cases: tuple[tuple[Side, tuple[Landmark, ...]], ...] = (
        ("left", (head, crest)),
        ("right", (head,)),
        ("none", (crest,)),
    )
    for side, marks in cases:
        framed = LimbFrame(limb_from_mesh=turn, side=side)
        told = replace(limb, landmarks=marks, frame=framed)
        # Turned to the back, what was on a left limb's outer side is on a right one's.
        if (side == "right") == (turn_deg == 180):
            assert admit(told, side).frame is not None
            assert isinstance(sure_in_limb_frame(told), AlignedLimb)
            continue
        with pytest.raises(MeasureError, match="degrees from where it belongs"):
            admit(told, side)
        told_side = "The front is wrong" if side == "none" else f"side '{side}'"
        with pytest.raises(MeasureError, match=told_side):
            sure_in_limb_frame(told)


@pytest.mark.parametrize("polyface", [False, True])
def test_a_drawing_holds_the_trimline_as_a_closed_curve(tmp_path: Path, polyface: bool) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3, radius=50)
    normal = np.array([0.6, 0.0, -0.8])
    vertices, faces, _ = trimesh.intersections.slice_faces_plane(
        np.asarray(ball.vertices), np.asarray(ball.faces), normal, np.array([0, 0, 10.0])
    )
    bowl = trimesh.Trimesh(vertices, faces, process=True)
    mesh = Mesh(vertices_mm=np.asarray(bowl.vertices), faces=bowl.faces.astype(np.int32))
    path = tmp_path / "bowl.dxf"
    if polyface:
        write_polyface_dxf(mesh, path)
    else:
        write_r12_dxf(mesh, path, "mm")
    drawing = ezdxf.readfile(path)
    assert not drawing.audit().errors
    (line,) = drawing.modelspace().query('POLYLINE[layer=="TRIMLINE_MM"]')
    assert line.is_closed
    points = np.array([tuple(vertex.dxf.location) for vertex in line.vertices])
    np.testing.assert_allclose(points @ normal, -8.0, atol=1e-5)
    length = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).sum()
    assert length == pytest.approx(2 * np.pi * np.sqrt(50**2 - 8**2), rel=0.01)


@pytest.mark.parametrize(("subdivisions", "meshes"), [(3, 1), (6, 3)])
def test_a_polyface_drawing_is_the_surface(tmp_path: Path, subdivisions: int, meshes: int) -> None:
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=50)
    mesh = Mesh(vertices_mm=np.asarray(ball.vertices), faces=ball.faces.astype(np.int32))
    report = write_polyface_dxf(mesh, tmp_path / "ball.dxf", spacing_mm=20)
    assert report.meshes == meshes  # 81,920 faces of 32,767 at most
    assert len(report.curves.sections) == 5
    if subdivisions > 3:
        return
    drawing = ezdxf.readfile(report.path)
    assert not drawing.audit().errors
    lines = drawing.modelspace().query("POLYLINE")
    (surface,) = [line for line in lines if line.is_poly_face_mesh]
    sections = [line for line in lines if line.is_3d_polyline]
    assert len(sections) == 5
    assert all(line.is_closed for line in sections)
    found = MeshBuilder.from_polyface(surface)
    corners = np.array([tuple(place) for place in found.vertices])[np.array(found.faces)]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(ball.volume, rel=1e-6)
    for line in sections:
        points = np.array([tuple(vertex.dxf.location) for vertex in line.vertices])
        assert np.ptp(points[:, 2]) == 0
        np.testing.assert_allclose(np.linalg.norm(points, axis=1), 50, atol=0.5)


@pytest.mark.parametrize(
    ("written", "read", "finding"),
    [
        (b"\n30\n2.000000\n", b"\n30\n2.000003\n", "a corner lies 3e-06 from its place"),
        (b"\n30\n2.000000\n", b"\n30\n2.0000x0\n", r"a corner lies \? from its place"),
        (b"\n30\n2.000000\n", b"\n31\n2.000000\n", "3DFACE with other parts"),
        (b"\n13\n", b"\n13\n9", "faces of four corners"),
        (b"0\n3DFACE\n", b"0\n3DFACES\n", "0 triangles of 1"),
    ],
)
def test_a_drawing_that_reads_back_otherwise_is_not_kept(
    tmp_path: Path, written: bytes, read: bytes, finding: str
) -> None:
    face = b"0\n3DFACE\n8\nSURFACE_MM\n" + b"".join(
        b"%d\n%d.000000\n" % (10 * axis + corner, place[axis - 1])
        for corner, place in enumerate(((1, 0, 2), (0, 3, 0), (-4, 0, 0), (-4, 0, 0)))
        for axis in (1, 2, 3)
    )
    mesh = Mesh(
        vertices_mm=np.array([[1.0, 0, 2], [0, 3, 0], [-4, 0, 0]]),
        faces=np.array([[0, 1, 2]], np.int32),
    )
    curves = curves_of(mesh, 5.0)
    path = tmp_path / "one.dxf"
    assert write_drawing(path, "mm", [face], mesh, curves).is_file()
    assert face.count(written) == 1
    other = tmp_path / "other.dxf"
    with pytest.raises(ExportError, match=finding):
        write_drawing(other, "mm", [face.replace(written, read)], mesh, curves)
    assert not other.exists()
