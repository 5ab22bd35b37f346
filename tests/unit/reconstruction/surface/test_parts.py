"""Parts against shapes known exactly: two sides of a wall, a torn tube, two things."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.mesh.mesh import Cloud, Mesh
from limbgram.core.mesh.topology import boundary_loops, face_components
from limbgram.reconstruction.surface.parts import PartOptions, Parts, tell_parts
from limbgram.reconstruction.surface.pivoting import pivot
from limbgram.reconstruction.surface.poisson import poisson
from limbgram.reconstruction.surface.repair import repair

MakeCloud = Callable[..., Cloud]
DEFAULTS = PartOptions()
HIGH_MM = 60.0
OUTER_MM, INNER_MM = 30.0, 26.0


def tube(
    make_cloud: MakeCloud, radius_mm: float, low_mm: float, high_mm: float, outward: float = 1.0
) -> Cloud:
    """A wall of points 0.9 mm apart, seen by four photos, its normals outward or inward."""
    rows = np.arange(low_mm, high_mm, 0.9)
    count = round(2 * np.pi * radius_mm / 0.9)
    angle = 2 * np.pi * (np.arange(count)[None] + 0.5 * (np.arange(len(rows)) % 2)[:, None]) / count
    flat = np.column_stack([np.cos(angle).ravel(), np.sin(angle).ravel()])
    normals = np.column_stack([flat, np.zeros(len(flat))])
    points = radius_mm * normals
    points[:, 2] = np.repeat(rows, count)
    return make_cloud(points, outward * normals, 0.03)


def joined(one: Cloud, two: Cloud) -> Cloud:
    rows = {
        name: np.concatenate([getattr(one, name), getattr(two, name)])
        for name in ("points_mm", "normals", "colours", "views")
    }
    return replace(one, **rows)


def from_axis_mm(mesh: Mesh) -> np.ndarray:
    """Of what was measured."""
    assert mesh.filled is not None
    return np.linalg.norm(mesh.vertices_mm[~mesh.filled, :2], axis=1)


def seen_by(cloud: Cloud, photos: int) -> Cloud:
    return replace(cloud, views=np.full(len(cloud), photos, np.uint16))


@pytest.fixture(scope="module")
def pot(make_cloud: MakeCloud) -> Cloud:
    """The outside and the inside of a wall whose rim no photo shows; more look at the outside."""
    outside = tube(make_cloud, OUTER_MM, 0.0, HIGH_MM)
    inside = tube(make_cloud, INNER_MM, 8.0, HIGH_MM, outward=-1.0)
    return joined(seen_by(outside, 6), seen_by(inside, 3))


def parts_of(cloud: Cloud, options: PartOptions = DEFAULTS) -> Parts:
    return tell_parts(pivot(cloud), cloud, options=options)


def test_both_sides_of_a_wall_are_kept_and_neither_lacks_the_other(pot: Cloud) -> None:
    parts = parts_of(pot)
    assert [part.relation for part in parts.parts] == ["chosen", "other side"]
    outside, inside = parts.parts
    assert outside.area_mm2 == pytest.approx(2 * np.pi * OUTER_MM * HIGH_MM, rel=0.05)
    assert inside.area_mm2 == pytest.approx(2 * np.pi * INNER_MM * (HIGH_MM - 8), rel=0.05)
    assert inside.middle_mm == pytest.approx([0, 0, 34], abs=1)
    assert inside.size_mm == pytest.approx(2 * INNER_MM, rel=0.05)
    assert parts.left_out_share == 0.0
    mesh = repair(parts, pot)
    assert mesh.repairs is not None
    assert mesh.repairs.island_share == 0.0
    assert [part.number for part in mesh.repairs.others] == [2]
    assert from_axis_mm(mesh).min() > OUTER_MM - 1


def rim(make_cloud: MakeCloud) -> Cloud:
    """The top of the wall, which joins its sides."""
    rings = [
        tube(make_cloud, radius, HIGH_MM - 0.5, HIGH_MM)
        for radius in np.arange(INNER_MM + 0.5, OUTER_MM, 0.8)
    ]
    points = np.concatenate([one.points_mm for one in rings])
    up = np.zeros_like(points)
    up[:, 2] = 1.0
    return make_cloud(points, up, 0.03)


def test_a_closed_surface_joins_the_sides_of_a_wall_whose_rim_is_seen(
    pot: Cloud, make_cloud: MakeCloud
) -> None:
    torn = parts_of(pot)
    assert torn.sides_of_a_wall
    assert not parts_of(pot, PartOptions(chosen=2)).sides_of_a_wall
    unseen = tell_parts(poisson(pot), pot)
    assert not unseen.joins(torn)
    seen = joined(pot, seen_by(rim(make_cloud), 6))
    whole = tell_parts(poisson(seen), seen)
    assert whole.joins(torn)
    assert not whole.sides_of_a_wall
    walls = sum(part.area_mm2 for part in torn.parts)
    top = np.pi * (OUTER_MM**2 - INNER_MM**2)
    assert whole.parts[0].area_mm2 == pytest.approx(walls + top, rel=0.05)


def test_each_part_is_made_whole_by_its_number(pot: Cloud) -> None:
    inside = repair(parts_of(pot), pot, number=2)
    assert not face_components(inside.faces).any()
    assert from_axis_mm(inside).max() < INNER_MM + 1
    assert len(boundary_loops(inside.faces)) <= 1
    assert inside.repairs is not None
    assert (inside.repairs.part, inside.repairs.others) == (2, ())


def test_the_user_chooses_and_the_numbers_stay(pot: Cloud) -> None:
    parts = parts_of(pot, PartOptions(chosen=2))
    assert [part.relation for part in parts.parts] == ["other side", "chosen"]
    assert parts.given
    mesh = repair(parts, pot)
    assert from_axis_mm(mesh).max() < INNER_MM + 1
    assert mesh.repairs is not None
    assert mesh.repairs.part_given
    assert [part.number for part in mesh.repairs.others] == [1]


@pytest.mark.parametrize(
    "wanted", [0, *(pytest.param(one, marks=pytest.mark.slow) for one in (3, -1))]
)
def test_a_part_that_is_not_there_is_refused(pot: Cloud, wanted: int) -> None:
    with pytest.raises(OptionsError, match="2 bodies were found"):
        parts_of(pot, PartOptions(chosen=wanted))


def test_the_smaller_is_meant_where_the_photos_look_at_it(make_cloud: MakeCloud) -> None:
    small, large = tube(make_cloud, 15, 0, 40), tube(make_cloud, 30, 0, 60)
    aside = replace(large, points_mm=large.points_mm + np.array([0, 90, 0], np.float32))
    both = joined(small, aside)
    assert [part.area_mm2 > 8000 for part in parts_of(both).parts] == [True, False]
    views = [_looking_at_the_origin(angle) for angle in np.linspace(-0.8, 0.8, 5)]
    parts = tell_parts(pivot(both), both, views)
    assert [part.area_mm2 > 8000 for part in parts.parts] == [False, True]
    assert [part.relation for part in parts.parts] == ["chosen", "apart"]
    assert parts.parts[0].looked_at > 0.5
    assert parts.left_out_share == 0.0


def test_a_photo_with_a_part_of_the_limb_behind_it_looks_at_the_rest(
    make_cloud: MakeCloud,
) -> None:
    """One camera comes so near to the lower end that the upper end faces it from behind."""
    limb, other = tube(make_cloud, 30, 0, 200), tube(make_cloud, 15, 0, 40)
    aside = replace(other, points_mm=other.points_mm + np.array([0, 90, 0], np.float32))
    both = joined(limb, aside)
    near = Rigid.looking_at(
        np.array([80.0, 0.0, 100.0]), np.array([0.0, 0.0, 20.0]), np.array([0.0, 0.0, 1.0])
    )
    round_it = [_looking_at_the_origin(angle) for angle in np.linspace(-0.8, 0.8, 5)]
    parts = tell_parts(pivot(both), both, [*round_it, replace(round_it[0], camera_from_world=near)])
    assert [part.area_mm2 > 30_000 for part in parts.parts] == [True, False]
    assert sum(part.looked_at for part in parts.parts) == pytest.approx(1.0)


@pytest.mark.parametrize("gap_mm", [9.0, 16.0])
def test_what_a_bare_strip_round_the_limb_tears_off_is_missing(
    make_cloud: MakeCloud, gap_mm: float
) -> None:
    cloud = joined(tube(make_cloud, 30, 0, 60), tube(make_cloud, 30, 60 + gap_mm, 100))
    parts = parts_of(cloud)
    assert [part.relation for part in parts.parts] == ["chosen", "torn off"]
    assert parts.left_out_share == pytest.approx((40 - gap_mm) / (100 - gap_mm), rel=0.05)


@pytest.mark.parametrize("bare_deg", [20.0, 40.0])
def test_two_halves_along_the_limb_are_missing_from_each_other(
    make_cloud: MakeCloud, bare_deg: float
) -> None:
    whole = tube(make_cloud, 30, 0, 90)
    angle = np.degrees(np.arctan2(whole.points_mm[:, 1], whole.points_mm[:, 0]))
    rows = (np.abs(angle) > bare_deg / 2) & (np.abs(angle) < 180 - bare_deg / 2)
    halves = replace(
        whole,
        points_mm=whole.points_mm[rows],
        normals=whole.normals[rows],
        colours=whole.colours[rows],
        views=whole.views[rows],
    )
    parts = parts_of(halves)
    assert sorted(part.relation for part in parts.parts) == ["chosen", "torn off"]
    assert parts.left_out_share == pytest.approx(0.5, abs=0.02)


def test_two_limbs_beside_each_other_lack_nothing(make_cloud: MakeCloud) -> None:
    one = tube(make_cloud, 30, 0, 60)
    two = replace(one, points_mm=one.points_mm + np.array([0, 75, 0], np.float32))
    parts = parts_of(joined(one, two))
    assert sorted(part.relation for part in parts.parts) == ["apart", "chosen"]
    assert parts.left_out_share == 0.0


def _looking_at_the_origin(angle: float) -> View:
    centre = 300 * np.array([np.cos(angle), np.sin(angle), 0.2])
    ahead = -centre / np.linalg.norm(centre)
    right = np.cross(ahead, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(ahead, right), ahead])
    camera = Camera(width_px=600, height_px=400, fx=700, fy=700, cx=299.5, cy=199.5)
    return View("photo", camera, Rigid(rotation, -rotation @ centre))
