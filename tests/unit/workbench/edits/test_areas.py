"""Areas and ovals: the depth is met exactly, fades as asked, and nothing else moves."""

import numpy as np
import pytest

from limbgram.core.errors import EditError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.edits.areas import falloff
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.load import Load
from limbgram.workbench.edits.pad import Pad
from limbgram.workbench.edits.relieve import Relieve
from limbgram.workbench.edits.room import Room
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame

RADIUS_MM = 40.0
HEIGHT_MM = 100.0
SPOKES = 72


def radial_mm(limb: Limb) -> np.ndarray:
    """How far vertices of the tube stand out from its radius; 0 on the round end."""
    points = limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)
    out = np.hypot(points[:, 0], points[:, 1]) - RADIUS_MM
    return np.where(points[:, 2] > RADIUS_MM, out, 0.0)


def unrolled_mm(limb: Limb, right: float) -> np.ndarray:
    """Distance over the tube from the place at the front (0) or the right (1)."""
    points = limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)
    angle = np.arctan2(points[:, 0], points[:, 1]) - right * np.pi / 2
    return np.hypot(RADIUS_MM * angle, points[:, 2] - HEIGHT_MM)


def test_a_load_round_a_landmark_has_its_depth_and_fades_over_the_surface(limb: Limb) -> None:
    edited = do_edit(limb, Load(at="right", depth_mm=4, flat_mm=5, falloff_mm=20))
    moved = radial_mm(edited)
    assert moved.min() == pytest.approx(-4, abs=0.05)  # coarse triangles lie inside the tube
    distance = unrolled_mm(edited, 1)
    expected = -4 * falloff((distance - 5) / 20)
    assert np.abs(moved - expected)[distance < 30].max() < 0.12
    old = len(limb.mesh)
    far = distance[:old] > 26
    np.testing.assert_array_equal(edited.mesh.vertices_mm[:old][far], limb.mesh.vertices_mm[far])


@pytest.mark.parametrize(("edit", "sign"), [(Pad, -1), (Room, 1)])
def test_an_oval_in_the_middle_of_long_triangles_has_its_depth(
    edit: type[Pad | Room], sign: int
) -> None:
    angle = 2 * np.pi * np.arange(SPOKES) / SPOKES
    ring = RADIUS_MM * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    here, ahead = np.arange(SPOKES), np.roll(np.arange(SPOKES), -1)
    faces = [[here, ahead, ahead + SPOKES], [here, ahead + SPOKES, here + SPOKES]]
    tube = Mesh(
        vertices_mm=np.concatenate([ring, ring + np.array([0, 0, 250.0])]),
        faces=np.concatenate([np.column_stack(one) for one in faces]).astype(np.int32),
    )
    limb = AlignedLimb(mesh=tube, frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="left"))
    edited = do_edit(limb, edit(at=(0, RADIUS_MM, 125), depth_mm=4, width_mm=30, height_mm=50))
    x, y, z = edited.mesh.vertices_mm.T
    front = y > 0
    assert y[front][np.hypot(x, z - 125)[front].argmin()] == pytest.approx(40 + sign * 4, abs=0.1)
    moved = sign * (np.hypot(x, y) - RADIUS_MM) > 0.2
    assert moved.any()
    assert np.abs(z[moved] - 125).max() < 25


def test_the_landmark_moves_with_the_surface(limb: Limb) -> None:
    edited = do_edit(limb, Relieve(at="front", depth_mm=3, flat_mm=6, falloff_mm=15))
    front = edited.landmarks[0].position_mm - limb.landmarks[0].position_mm
    assert np.linalg.norm(front) == pytest.approx(3, abs=0.05)
    np.testing.assert_array_equal(edited.landmarks[1].position_mm, limb.landmarks[1].position_mm)


def ring(radius_mm: float, count: int = 12) -> tuple[tuple[float, float, float], ...]:
    """Points of a circle on the unrolled tube, round the front."""
    turn = 2 * np.pi * np.arange(count) / count
    angle, z = radius_mm * np.cos(turn) / RADIUS_MM, HEIGHT_MM + radius_mm * np.sin(turn)
    return tuple(
        (float(RADIUS_MM * np.sin(a)), float(RADIUS_MM * np.cos(a)), float(h))
        for a, h in zip(angle, z, strict=True)
    )


@pytest.mark.parametrize("backwards", [False, True])
def test_a_drawn_region_is_full_inside_and_untouched_outside(limb: Limb, backwards: bool) -> None:
    points = ring(20.0)[::-1] if backwards else ring(20.0)
    edited = do_edit(limb, Relieve(within=points, depth_mm=5, falloff_mm=8))
    moved, distance = radial_mm(edited), unrolled_mm(edited, 0)
    assert moved.max() == pytest.approx(5, abs=0.05)
    assert np.abs(moved[distance < 11] - 5).max() < 0.1
    assert np.abs(moved[distance > 20.3]).max() < 0.05  # the triangles' own sag
    expected = 5 * (1 - falloff((20 - distance) / 8))
    assert np.abs(moved - expected)[distance < 25].max() < 0.25


def test_a_wide_region_is_made_fine_only_where_it_fades(limb: Limb) -> None:
    """The band under a falloff of 2 mm wants edges of 0.4 mm; all the region, five times that."""
    edited = do_edit(limb, Relieve(within=ring(34.0), depth_mm=2, falloff_mm=2))
    moved, distance = radial_mm(edited), unrolled_mm(edited, 0)
    assert np.abs(moved[distance < 31] - 2).max() < 0.1
    assert np.abs(moved[distance > 34.3]).max() < 0.05
    ends = edited.mesh.vertices_mm[edited.mesh.faces]
    longest = np.linalg.norm(ends - np.roll(ends, -1, axis=1), axis=2).max(1)
    place = distance[edited.mesh.faces].mean(1)
    assert longest[(place > 32.2) & (place < 33.8)].max() < 1.0
    assert np.median(longest[place < 25]) > 2.0


def test_a_narrow_region_still_reaches_its_depth(limb: Limb) -> None:
    edited = do_edit(limb, Relieve(within=ring(10.0), depth_mm=2, falloff_mm=50))
    assert radial_mm(edited).max() == pytest.approx(2, abs=0.05)


def test_a_load_through_the_other_side_is_refused(limb: Limb) -> None:
    with pytest.raises(EditError, match=r"pass through each other|fold over"):
        do_edit(limb, Load(at="right", depth_mm=90, falloff_mm=25))


@pytest.mark.parametrize(
    ("edit", "reason"),
    [
        (Relieve(depth_mm=3, falloff_mm=5), "either a place"),
        (Relieve(at="front", within=ring(9.0), depth_mm=3, falloff_mm=5), "either a place"),
        (
            Relieve(at="front", depth_mm=-3, falloff_mm=5),
            "other way there is load",
        ),
        (Relieve(at="heel", depth_mm=3, falloff_mm=5), "front, right"),
        (Relieve(at=(0.0, 90.0, 100.0), depth_mm=3, falloff_mm=5), "from the surface"),
        (Relieve(within=ring(9.0)[:2], depth_mm=3, falloff_mm=5), "at least 3 points"),
    ],
)
def test_what_makes_no_sense_is_refused(limb: Limb, edit: Relieve, reason: str) -> None:
    with pytest.raises(EditError, match=reason):
        do_edit(limb, edit)


def test_places_may_be_given_in_the_frame_of_the_mesh(limb: Limb) -> None:
    x, y, z = limb.landmarks[0].position_mm.tolist()
    named = do_edit(limb, Relieve(at="front", depth_mm=3, falloff_mm=15))
    placed = do_edit(limb, Relieve(at=(x, y, z), positions_in="mesh", depth_mm=3, falloff_mm=15))
    np.testing.assert_array_equal(named.mesh.vertices_mm, placed.mesh.vertices_mm)


@pytest.mark.parametrize(("kind", "sign"), [(Pad, -1), (Room, 1)])
def test_what_turns_away_from_an_oval_stays(
    limb: AlignedLimb, kind: type[Pad] | type[Room], sign: int
) -> None:
    """On a limb as flat as a forefoot: 80 mm wide and 20 mm thick."""
    motion = limb.limb_from_mesh
    flat = motion.apply(limb.mesh.vertices_mm) * [1.0, 0.25, 1.0]
    limb = limb.with_mesh(limb.mesh.with_vertices(motion.inverse.apply(flat)))
    edited = do_edit(limb, kind(at=(0.0, 10.0, 100.0), depth_mm=4.0, width_mm=60.0, height_mm=60.0))
    step = motion.apply(edited.mesh.vertices_mm)[: len(flat)] - flat
    assert (sign * step[:, 1]).max() == pytest.approx(4.0, abs=0.02)
    assert (sign * step[:, 1]).min() > -1e-6
    assert np.abs(step[:, [0, 2]]).max() < 1e-6
    np.testing.assert_allclose(step[flat[:, 1] <= 0], 0.0, atol=1e-9)


def test_an_oval_at_the_limbs_end_goes_from_back_to_front(limb: AlignedLimb) -> None:
    motion = limb.limb_from_mesh
    given = motion.apply(limb.mesh.vertices_mm)
    edited = do_edit(limb, Room(at=(0.0, 0.0, 0.0), depth_mm=4.0, width_mm=20.0, height_mm=60.0))
    step = np.linalg.norm(motion.apply(edited.mesh.vertices_mm)[: len(given)] - given, axis=1)
    moved = given[step > 1e-3]
    assert np.abs(moved[:, 0]).max() < 10.0
    assert 20.0 < np.abs(moved[:, 1]).max() < 30.0
