"""Aligning and measuring foreign scans, checked against other ways to the same figures."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.smoothed_length import smoothed_length
from limbgram.formats.reading import read_limb
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame
from limbgram.workbench.measures.geodesic import length_mm, shortest_path
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb

SHAPES = [
    ("ampscan/stl_file.stl", 1.0),
    ("ampscan/stl_file_2.stl", 1.0),
    ("ampscan/Example.AOP", 1.0),
    ("openlimb_TT/Full Size Mean_Limb_Shape.stl", 1.0),
    ("openlimb_TT/Full Size Mean_Skin_Shape.stl", 1.0),
    ("openlimb_TT/102m.stl", 383.0),
    ("find_template_foot/template.obj", 1000.0),
    ("homebrew_socket/socket.STL", 1.0),
]


@pytest.mark.parametrize(("name", "mm_per_unit"), SHAPES)
def test_every_shape_is_aligned_alike_wherever_it_lies(
    data_folder: Path, name: str, mm_per_unit: float
) -> None:
    # the front is stated here; landmarks of a file have a front of their own
    limb = replace(read_limb(data_folder / "shapes" / name, mm_per_unit), landmarks=())
    up, front = np.array([0.0, 0.1, 1]), np.array([0.2, -1, 0.1])
    pose = Rigid.from_rotation_vector(np.array([0.8, 0.3, -1.1]), np.array([400.0, -90, 33]))
    moved = Limb(mesh=limb.mesh.with_vertices(pose.apply(limb.mesh.vertices_mm)))
    # A foot is longest from heel to toe: its axis is stated.
    given = "axis" if "foot" in name else "proximal"
    options = AlignOptions(side="right", anterior=front)
    here = align(limb, replace(options, **{given: up}))
    turned = replace(options, anterior=pose.rotation @ front)
    there = align(moved, replace(turned, **{given: pose.rotation @ up}))
    np.testing.assert_allclose(
        there.aligned().mesh_in_limb.vertices_mm, here.aligned().mesh_in_limb.vertices_mm, atol=1e-4
    )
    table = measure_limb(here, LimbMeasureOptions(heights_mm=tuple(np.linspace(2, 240, 240))))
    assert len(table.rows) == 240
    assert all((row.level is not None) or row.reasons for row in table.rows)
    for row in table.rows:
        tape, contour = row.figures["tape_mm"], row.figures["contour_mm"]
        if tape is None or contour is None or row.level is None or row.loops > 1:
            continue
        points = row.level.points_mm
        outline = np.linalg.norm(points[row.level.after] - points, axis=1).sum()
        assert tape.value <= outline * (1 + 1e-12)
        assert contour.value <= outline * (1 + 1e-12)


def test_a_real_limb_measured_by_another_program(data_folder: Path) -> None:
    """Section lengths by trimesh, and the volume by many areas."""
    path = data_folder / "shapes" / "ampscan" / "stl_file.stl"
    limb = read_limb(path)
    limb = AlignedLimb(
        mesh=limb.mesh, frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="none")
    )
    heights = (-180.0, -91.3, 0.4, 20.0)
    table = measure_limb(limb, LimbMeasureOptions(heights_mm=heights, volumes_mm=((-150, 20),)))
    other = trimesh.load_mesh(path)
    for row in table.rows:
        contour = row.figures["contour_mm"]
        assert contour is not None
        cut = other.section([0, 0, 1], [0, 0, row.height_mm])
        (line,) = cut.discrete
        smooth = smoothed_length(np.asarray(line)[:-1, :2], closed=True)
        assert contour.value == pytest.approx(smooth.value_mm, rel=1e-6)
    cuts = np.linspace(-150, 20, 681)
    areas = [
        row.figures["area_mm2"]
        for row in measure_limb(limb, LimbMeasureOptions(heights_mm=tuple(cuts))).rows
    ]
    by_slices = np.trapezoid([figure.value for figure in areas if figure is not None], cuts)
    assert len(areas) == 681
    assert table.volumes[0].volume_mm3.value == pytest.approx(by_slices, rel=1e-5)


def test_a_way_over_a_real_limb_is_as_long_there_as_back(data_folder: Path) -> None:
    limb = read_limb(data_folder / "shapes" / "ampscan" / "stl_file_2.stl")
    rng = np.random.default_rng(6)
    vertices = limb.mesh.vertices_mm
    for start, end in rng.integers(0, len(vertices), (8, 2)):
        way = length_mm(shortest_path(limb.mesh, vertices[start], vertices[end]))
        back = length_mm(shortest_path(limb.mesh, vertices[end], vertices[start]))
        assert way == pytest.approx(back, rel=1e-6)
        assert way >= np.linalg.norm(vertices[start] - vertices[end])


def test_a_way_over_a_thin_socket_does_not_stay_on_the_wrong_skin(data_folder: Path) -> None:
    """The length by exact continuous Dijkstra (pygeodesic); the way round is 8 % longer."""
    limb = read_limb(data_folder / "shapes" / "homebrew_socket" / "socket.STL")
    ends = np.array([[130.617, 119.914, 194.416], [66.644, 142.286, 78.418]])
    path = shortest_path(limb.mesh, ends[0], ends[1])
    assert length_mm(path) == pytest.approx(179.4241356, rel=1e-8)


def test_a_bulge_that_a_plane_just_meets_does_not_lift_the_tape(data_folder: Path) -> None:
    """At 216 mm five points of a bulge stand beside the stump's section: they are no limb."""
    limb = read_limb(data_folder / "shapes" / "ampscan" / "stl_file.stl")
    options = AlignOptions(
        side="left", proximal=np.array([0, 0, 1.0]), anterior=np.array([0, 1.0, 0])
    )
    limb = align(limb, options)
    rows = measure_limb(limb, LimbMeasureOptions(heights_mm=(215.9, 216.0, 216.1))).rows
    before, at, after = (row.figures["tape_mm"] for row in rows)
    assert before is not None
    assert at is not None
    assert after is not None
    assert rows[1].level is not None
    assert rows[1].level.left_out == 1
    assert rows[1].loops == 1
    assert at.value == pytest.approx((before.value + after.value) / 2, abs=0.4)
