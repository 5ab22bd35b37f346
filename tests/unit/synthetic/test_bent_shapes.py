"""Bent shapes: rings that follow a surface round a bend lie on it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.unit.workbench.devices.shapes import cone, settled, surface, together

from limbgram.core.errors import ShapeFileError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_loops, is_watertight, volume_mm3, with_faces
from limbgram.formats.stl import write_stl
from limbgram.synthetic.props.bent import BentShape, limb_of_bent
from limbgram.synthetic.props.limb import Relief
from limbgram.synthetic.props.scan import read_scan

SMOOTH = Relief(rms_mm=0.0)
HOOK = together([cone((0, 0, -40), 26, (0, 0, 90), 24), cone((0, 0, 90), 24, (0, 95, 75), 16)], 2.0)
"""A tube that stands upright and bends by more than a right angle, as a foot upside down."""


def hook() -> Mesh:
    whole = surface(HOOK, (-45, -45, -70), (45, 125, 125), 3.0, None)
    upside = whole.with_vertices(whole.vertices_mm * [1, -1, -1])
    high = surface(lambda p: HOOK(p * [1, -1, -1]), (-45, -125, -125), (45, 45, 70), 3.0, 0.0)
    assert len(high) < len(upside)
    return high.with_vertices(high.vertices_mm * [1, -1, -1])


def shape_of(mesh: Mesh) -> BentShape:
    tip = np.array([0, 111, 73.0])
    pole = int(np.linalg.norm(mesh.vertices_mm - tip, axis=1).argmin())
    return BentShape(sha256="hook", side="right", mesh=mesh, pole=pole)


def test_the_rings_lie_on_the_surface_and_close_it() -> None:
    limb = limb_of_bent(shape_of(hook()), 1, 1.5, 60.0, SMOOTH)
    skin = limb.mesh.vertices_mm[~limb.cut] - [0, 0, 60.0]
    off = np.linalg.norm(settled(HOOK, skin) - skin, axis=1)
    assert np.quantile(off, 0.99) < 0.15  # the file's triangles of 3 mm are flat
    assert is_watertight(limb.mesh.faces)
    assert volume_mm3(limb.mesh) > 0
    assert not len(find_crossings(limb.mesh.vertices_mm, limb.mesh.faces))
    assert limb.mesh.vertices_mm[:, 2].min() == pytest.approx(60.0, abs=1e-4)


def test_the_whole_surface_is_there() -> None:
    mesh = hook()
    limb = limb_of_bent(shape_of(mesh), 1, 1.5, 60.0, SMOOTH)
    own = Mesh(vertices_mm=mesh.vertices_mm + np.array([0, 0, 60.0]), faces=mesh.faces)
    assert limb.mesh.area_mm2() == pytest.approx(own.area_mm2() + np.pi * 25.5**2, rel=0.02)
    rows = np.linalg.norm(np.diff(limb.grid_mm, axis=0), axis=2)
    columns = np.linalg.norm(np.diff(limb.grid_mm, axis=1), axis=2)
    assert np.quantile(rows, 0.95) < 3.0
    assert np.quantile(columns, 0.95) < 3.0


def test_two_openings_are_refused() -> None:
    mesh = hook()
    gone = np.linalg.norm(mesh.vertices_mm - [25, 0, 50.0], axis=1) < 8
    holed = with_faces(mesh, mesh.faces[~gone[mesh.faces].any(1)])
    with pytest.raises(ShapeFileError) as refused:
        limb_of_bent(shape_of(holed), 1, 1.5, 60.0, SMOOTH)
    assert refused.value.finding.code == "made.bent.no_disc"
    assert refused.value.finding.values["openings"] == 2


def test_a_file_of_a_bent_shape_stands_on_its_open_edge_however_it_lies(tmp_path: Path) -> None:
    lying = Rigid.from_rotation_vector(np.array([1.1, 0.4, -0.7]), np.array([300.0, -80.0, 45.0]))
    mesh = hook()
    path = write_stl(mesh.with_vertices(lying.apply(mesh.vertices_mm)), tmp_path / "foot.stl", "mm")
    shape = read_scan(path)
    assert isinstance(shape, BentShape)
    assert shape.side == "none"
    assert len(boundary_loops(shape.mesh.faces)) == 1
    heights = shape.mesh.vertices_mm[:, 2]
    assert heights.min() == pytest.approx(0.0, abs=1e-3)
    own = mesh.vertices_mm[:, 2]
    assert np.ptp(heights) == pytest.approx(np.ptp(own), abs=5.0)  # the ragged edge is cut off
    assert shape.mesh.area_mm2() == pytest.approx(mesh.area_mm2(), rel=0.03)
    assert volume_mm3(limb_of_bent(shape, 1, 1.5, 60.0, SMOOTH).mesh) > 0
    # The rings close at the end of the hook, 100 mm aside of the tube that it stands on.
    aside = np.linalg.norm(shape.mesh.vertices_mm[shape.pole, :2])
    assert 90.0 < aside < 125.0


@pytest.mark.slow
def test_a_bent_shape_that_is_closed_has_no_end_to_stand_on(tmp_path: Path) -> None:
    whole = surface(HOOK, (-45, -45, -70), (45, 125, 125), 3.0, None)
    with pytest.raises(ShapeFileError) as refused:
        read_scan(write_stl(whole, tmp_path / "foot.stl", "mm"))
    assert refused.value.finding.code in {"made.scan.folded", "made.scan.steep"}


def test_a_refusal_names_the_file_and_no_hash(tmp_path: Path) -> None:
    mesh = hook()
    shape = read_scan(write_stl(mesh, tmp_path / "trunk.stl", "mm"))
    assert isinstance(shape, BentShape)
    gone = np.linalg.norm(shape.mesh.vertices_mm - shape.mesh.vertices_mm.mean(0), axis=1)
    hole = gone.argmin()
    holed = with_faces(shape.mesh, shape.mesh.faces[~(shape.mesh.faces == hole).any(1)])
    with pytest.raises(ShapeFileError) as refused:
        limb_of_bent(replace(shape, mesh=holed), 1, 1.5, 60.0, SMOOTH)
    assert refused.value.finding.values["name"] == "trunk.stl"
