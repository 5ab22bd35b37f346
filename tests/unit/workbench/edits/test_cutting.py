"""Cuts: triangles really split along the plane or the curve, openings really capped."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import EditError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_loops, is_edge_manifold, volume_mm3
from limbgram.reconstruction.surface.holes import loop_area
from limbgram.workbench.edits.cutting import cap
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.plane_cut import PlaneCut
from limbgram.workbench.edits.regions import draw_curve
from limbgram.workbench.edits.trimline import Trimline
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import Limb

RADIUS_MM, SPOKES = 40.0, 72

POLYGON_AREA = SPOKES / 2 * np.sin(2 * np.pi / SPOKES) * RADIUS_MM**2


def heights_mm(limb: Limb) -> np.ndarray:
    return limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)[:, 2]


@pytest.mark.parametrize("level_mm", [100.0, 101.3])  # on a row of vertices, and between rows
def test_a_capped_cut_is_closed_and_of_the_right_volume(limb: Limb, level_mm: float) -> None:
    whole = do_edit(limb, PlaneCut(height_mm=159.0, capped=True))
    cut = do_edit(limb, PlaneCut(height_mm=level_mm, capped=True))
    assert not boundary_loops(cut.mesh.faces)
    assert is_edge_manifold(cut.mesh.faces)
    assert heights_mm(cut).max() == pytest.approx(level_mm, abs=1.1e-3)
    lost = volume_mm3(whole.mesh) - volume_mm3(cut.mesh)
    assert lost == pytest.approx(POLYGON_AREA * (159.0 - level_mm), rel=1e-4)


def jagged_ring(seed: int) -> Mesh:
    """Two skins that end in one plane, their edges uneven and off a smooth line by 0.05 mm."""
    random = np.random.default_rng(seed)
    vertices, faces, first = [], [], 0
    for radius_mm, count, inner in ((40.0, 500, False), (32.0, 300, True)):
        angle = np.sort(random.uniform(0, 2 * np.pi, count))
        away_mm = radius_mm + 1.8 * np.cos(5 * angle) + 0.05 * random.normal(size=count)
        edge = np.column_stack([away_mm * np.cos(angle), away_mm * np.sin(angle), 0 * angle])
        here, ahead = np.arange(count), (np.arange(count) + 1) % count
        skin = np.concatenate(
            [
                np.column_stack([here + count, ahead + count, ahead]),
                np.column_stack([here + count, ahead, here]),
            ]
        )
        vertices += [edge, edge - [0.0, 0.0, 1.0]]
        faces.append(first + (skin[:, ::-1] if inner else skin))
        first += 2 * count
    return Mesh(vertices_mm=np.concatenate(vertices), faces=np.concatenate(faces).astype(np.int32))


@pytest.mark.parametrize("seed", [1, 2, 3, 6])
def test_no_triangle_of_a_cap_is_turned_over(seed: int) -> None:
    ring = jagged_ring(seed)
    upper = ring.vertices_mm[:, 2] == 0
    capped = cap(ring, upper)
    added = replace(capped, faces=capped.faces[len(ring.faces) :])
    assert (added.face_normals()[:, 2] > 0).all()
    edge = ring.vertices_mm[upper]
    circles = edge[:500], edge[500:]
    outer_mm2, inner_mm2 = (float(np.linalg.norm(loop_area(circle))) for circle in circles)
    assert added.area_mm2() == pytest.approx(outer_mm2 - inner_mm2, rel=1e-9)


def test_a_tilted_cut_rises_towards_the_back_as_said(limb: Limb) -> None:
    cut = do_edit(limb, PlaneCut(height_mm=100.0, forward_deg=20.0))
    (rim,) = boundary_loops(cut.mesh.faces)
    points = limb.frame.limb_from_mesh.apply(cut.mesh.vertices_mm[rim])
    expected = 100 - np.tan(np.radians(20)) * points[:, 1]
    np.testing.assert_allclose(points[:, 2], expected, atol=2e-3)
    other = do_edit(limb, PlaneCut(height_mm=100.0, forward_deg=20.0, keep="proximal"))
    assert len(boundary_loops(other.mesh.faces)) == 2
    area = sum(np.linalg.norm(c.mesh.face_normals(), axis=1).sum() for c in (cut, other))
    assert area == pytest.approx(np.linalg.norm(limb.mesh.face_normals(), axis=1).sum(), rel=1e-9)


def test_the_cap_of_a_wall_has_a_hole(limb: Limb) -> None:
    cup = do_edit(limb, Wall(thickness_mm=5.0))
    whole = do_edit(cup, PlaneCut(height_mm=150.0, capped=True))
    cut = do_edit(cup, PlaneCut(height_mm=110.0, capped=True))
    assert not boundary_loops(cut.mesh.faces)
    outer = RADIUS_MM * np.cos(np.pi / SPOKES) + 5
    ring = SPOKES * np.tan(np.pi / SPOKES) * outer**2 - POLYGON_AREA
    lost = volume_mm3(whole.mesh) - volume_mm3(cut.mesh)
    assert lost == pytest.approx(40 * ring, rel=1e-3)


def test_a_plane_that_misses_or_leaves_no_flat_opening_is_refused(limb: Limb) -> None:
    with pytest.raises(EditError, match="misses"):
        do_edit(limb, PlaneCut(height_mm=400.0))
    for height_mm, keep in ((1e-4, "distal"), (160 - 1e-4, "distal"), (1e-4, "proximal")):
        with pytest.raises(EditError, match=r"misses the shape, which reaches from -?0\.0 to 160"):
            do_edit(limb, PlaneCut(height_mm=height_mm, keep=keep))  # pyright: ignore
    assert len(do_edit(limb, PlaneCut(height_mm=0.1)).mesh.faces) == SPOKES
    with pytest.raises(EditError, match="brim"):
        do_edit(limb, PlaneCut(height_mm=150.0, forward_deg=40.0, capped=True))


def wave(count: int = 16) -> tuple[tuple[float, float, float], ...]:
    angle = 2 * np.pi * np.arange(count) / count
    return tuple(
        (
            float(RADIUS_MM * np.sin(a)),
            float(RADIUS_MM * np.cos(a)),
            float(110 + 20 * np.cos(2 * a)),
        )
        for a in angle
    )


@pytest.mark.parametrize("keep", ["distal", "proximal"])
@pytest.mark.parametrize("order", [1, -1])
def test_the_new_brim_follows_the_trimline(limb: Limb, keep: str, order: int) -> None:
    edit = Trimline(through=wave()[::order], keep=keep)  # pyright: ignore
    cut = do_edit(limb, edit)
    loops = boundary_loops(cut.mesh.faces)
    assert len(loops) == (1 if keep == "distal" else 2)
    rims = [limb.frame.limb_from_mesh.apply(cut.mesh.vertices_mm[loop]) for loop in loops]
    rim = next(r for r in rims if r[:, 2].min() < 100)
    angle = np.arctan2(rim[:, 0], rim[:, 1])
    # Through 16 points a spline meets the wave to a few hundredths; the rest is the cut's own.
    np.testing.assert_allclose(rim[:, 2], 110 + 20 * np.cos(2 * angle), atol=0.12)
    picked = limb.frame.limb_from_mesh.inverse.apply(np.array(wave()))
    line = draw_curve(limb.mesh, picked).points_mm
    away = np.linalg.norm(cut.mesh.vertices_mm[loops[-1]][:, None] - line[None], axis=2).min(1)
    if keep == "distal":
        assert away.max() < 0.3  # the line's own points are half a millimetre apart


def test_a_curve_that_does_not_part_the_surface_is_refused(limb: Limb) -> None:
    eight = wave()[:8] + wave()[12:] + wave()[8:12]
    with pytest.raises(EditError, match=r"leaves the surface|part the surface"):
        do_edit(limb, Trimline(through=eight))
