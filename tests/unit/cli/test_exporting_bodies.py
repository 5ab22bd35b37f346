"""`limbgram export` of a scan with a crumb beside the limb and a bone inside it."""

import json
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import read_limb
from limbgram.workbench.limb import AlignedLimb, LimbFrame

SHIFT_MM = np.array([3.0, 4.0, 5.0])
"""From the file's axes to the limb's."""


def ball(radius_mm: float, *middle_mm: float) -> trimesh.Trimesh:
    made = trimesh.creation.icosphere(subdivisions=2, radius=radius_mm)
    made.apply_translation(middle_mm)
    return made


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """The crumb comes first, so that what is kept of the vertices is not just the first of them."""
    parts = [ball(2, 120, 0, 60), ball(60, 0, 0, 60), ball(6, 0, 0, 60)]
    whole: Any = trimesh.util.concatenate(parts)
    count = len(whole.vertices)
    numbers = np.arange(count)
    mesh = Mesh(
        vertices_mm=np.asarray(whole.vertices),
        faces=whole.faces.astype(np.int32),
        colours=np.stack([numbers % 251, numbers % 7, numbers % 13], axis=1).astype(np.uint8),
        filled=numbers % 5 == 0,
        sigma_mm=np.where(numbers % 5 == 0, np.nan, 0.01 + numbers / 1e4).astype(np.float32),
    )
    frame = LimbFrame(limb_from_mesh=Rigid(np.eye(3), SHIFT_MM), side="left")
    return write_limb(AlignedLimb(mesh=mesh, frame=frame), tmp_path / "scan.ply")


def exported(scan: Path, kind: str) -> tuple[dict[str, Any], str]:
    out = scan.with_name(f"out-{kind}.{kind}")
    words = ["export", str(scan), "--to", kind, "-o", str(out)]
    answer = CliRunner().invoke(app, [*words, "--json"])
    assert answer.exit_code == 0, answer.output
    return json.loads(answer.stdout), CliRunner().invoke(app, words).stdout


@pytest.mark.parametrize("kind", ["stl", "ply", "obj", "glb"])
def test_no_file_for_a_printer_holds_a_crumb(scan: Path, kind: str) -> None:
    content, told = exported(scan, kind)
    assert "1 loose body apart from the limb (4.0 mm across at x 123, y 4, z 65 mm" in told
    assert "1 body inside the limb, such as a bone, was written too." in told
    assert (content["bodies_left_out"], content["bodies_inside"]) == (1, 1)
    (body,) = content["loose_bodies"]
    np.testing.assert_allclose(body["in_limb_mm"], [123, 4, 65], atol=1e-3)
    written = read_limb(Path(content["written"])).mesh
    middle_mm = SHIFT_MM + np.array([0.0, 0.0, 60.0])
    away_mm = np.linalg.norm(written.vertices_mm - middle_mm, axis=1)
    assert sorted({round(float(mm)) for mm in away_mm}) == [6, 60]


def test_a_ply_keeps_what_is_known_of_every_vertex(scan: Path) -> None:
    source = read_limb(scan).mesh
    own = np.linalg.norm(source.vertices_mm - (120.0, 0, 60), axis=1) > 10
    written = read_limb(Path(exported(scan, "ply")[0]["written"])).mesh
    np.testing.assert_allclose(written.vertices_mm, source.vertices_mm[own] + SHIFT_MM, atol=1e-4)
    for name in ("colours", "filled", "sigma_mm"):
        before, after = getattr(source, name), getattr(written, name)
        assert before is not None
        np.testing.assert_array_equal(after, before[own])


def test_a_drawing_holds_no_crumb(scan: Path) -> None:
    content, told = exported(scan, "dxf")
    assert content["bodies_left_out"] == 1
    assert "1 loose body" in told
    (surface,) = ezdxf.readfile(content["written"]).modelspace().query("MESH")
    assert len(surface.faces) == 2 * len(ball(1, 0, 0, 0).faces)
    assert max(vertex[0] for vertex in surface.vertices) < 64
