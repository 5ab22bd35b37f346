"""Sections against closed forms of the bodies as they are faceted."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.compare.levels import changes_by_level
from limbgram.workbench.edits.refinement import refine_where
from limbgram.workbench.measures.levels import (
    MEASURES,
    Level,
    Refused,
    Sigmas,
    ap_mm,
    ap_through_mm,
    area_mm2,
    contour_mm,
    level_at,
    levels_at,
    ml_mm,
    ml_through_mm,
    radius_mm,
    tape_mm,
)

N = 96
EXACT = 1e-9


def joined(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(mesh) for mesh in meshes[:-1])])
    return Mesh(
        vertices_mm=np.concatenate([mesh.vertices_mm for mesh in meshes]),
        faces=np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts)]).astype(
            np.int32
        ),
    )


def inside_out(mesh: Mesh) -> Mesh:
    return replace(mesh, faces=mesh.faces[:, ::-1].copy())


def moved(mesh: Mesh, *by_mm: float) -> Mesh:
    return mesh.with_vertices(mesh.vertices_mm + np.array(by_mm))


def round_mm(radius_mm: float) -> float:
    return 2 * N * radius_mm * math.sin(math.pi / N)


def smooth_mm(radius_mm: float) -> float:
    """Of the circle at the mean distance of a polygon's sides, which are shorter than 5 mm."""
    return 2 * math.pi * radius_mm * (1 - (math.pi / N) ** 2 / 3)


SMOOTH = 3e-5
"""What is left of the sides, and of even steps along the line."""


@pytest.mark.parametrize("height_mm", [0.001, 37.0, 100.0, 199.999, 200.0])
def test_a_cylinder_is_a_polygon_at_every_height(cylinder: Mesh, height_mm: float) -> None:
    level = level_at(cylinder, height_mm)
    area = 0.5 * N * 50**2 * math.sin(2 * math.pi / N)
    assert contour_mm(level).value == pytest.approx(smooth_mm(50), rel=SMOOTH)
    assert tape_mm(level).value == pytest.approx(smooth_mm(50), rel=SMOOTH)
    assert area_mm2(level).value == pytest.approx(area, rel=EXACT)
    assert radius_mm(level).value == pytest.approx(math.sqrt(area / math.pi), rel=EXACT)
    for width in (ml_mm, ap_mm, ml_through_mm, ap_through_mm):
        found = width(level)
        assert found is not None
        assert found.value == pytest.approx(100, rel=EXACT)


def test_a_cone_narrows_evenly(make_turned: Callable[..., Mesh]) -> None:
    cone = make_turned(np.array([60.0, 20.0]), np.array([0.0, 160.0]), N)
    for height_mm in (1.0, 33.3, 80.0, 159.0):
        radius = 60 - 40 * height_mm / 160
        level = level_at(cone, height_mm)
        assert tape_mm(level).value == pytest.approx(smooth_mm(radius), rel=SMOOTH)
        assert contour_mm(level).value == pytest.approx(smooth_mm(radius), rel=SMOOTH)
        assert area_mm2(level).value == pytest.approx(
            0.5 * N * radius**2 * math.sin(2 * math.pi / N), rel=EXACT
        )


def test_an_ellipsoid_has_its_own_width_in_each_direction(
    make_turned: Callable[..., Mesh],
) -> None:
    heights = np.linspace(-99, 99, 67)
    radii = 70 * np.sqrt(1 - (heights / 100) ** 2)
    body = make_turned(radii, heights, N, squeeze=0.6)
    for height_mm in (-60.5, 0.7, 31.0):
        radius = float(np.interp(height_mm, heights, radii))
        level = level_at(body, height_mm)
        angles = 2 * np.pi * np.arange(N) / N
        ring = radius * np.column_stack([np.cos(angles), 0.6 * np.sin(angles)])
        taut_mm = np.linalg.norm(np.roll(ring, -1, 0) - ring, axis=1).sum()
        for girth in (tape_mm(level).value, contour_mm(level).value):
            assert girth == pytest.approx(taut_mm * smooth_mm(1) / round_mm(1), rel=1e-4)
        assert area_mm2(level).value == pytest.approx(
            0.6 * 0.5 * N * radius**2 * math.sin(2 * math.pi / N), rel=EXACT
        )
        assert ml_mm(level).value == pytest.approx(2 * radius, rel=EXACT)
        assert ap_mm(level).value == pytest.approx(1.2 * radius, rel=EXACT)


def star(make_turned: Callable[..., Mesh]) -> Mesh:
    """A prism whose every other corner is drawn in: 8 points at 60 mm, 8 at 40 mm."""
    prism = make_turned(np.full(5, 60.0), np.linspace(0, 100, 5), 16)
    vertices = prism.vertices_mm.copy()
    vertices[:80].reshape(5, 16, 3)[:, 1::2, :2] *= 40 / 60
    return prism.with_vertices(vertices)


AT_CORNER_MM = np.linspace(-20, 20, 40001)
"""Along two long straight sides, from their corner."""


def turned_at_corner() -> np.ndarray:
    """How far a smoothed line has turned, 0 to 1, by the filter's own kernel.

    Its plate's kernel is exp(-x) sin(x + pi / 4) / 2l of x = |s| / (l root 2); where a part g of
    it lies beyond the corner, the line is (1 - g) one side's direction and g the other's.
    """
    length = 5 / (2 * math.pi)
    x = np.abs(AT_CORNER_MM) / (length * math.sqrt(2))
    kernel = np.exp(-x) * np.sin(x + math.pi / 4) / (2 * length)
    return np.cumsum(kernel) * (AT_CORNER_MM[1] - AT_CORNER_MM[0])


def lost_at_corner_mm(turn_rad: float) -> float:
    """What smoothing takes from the two sides."""
    beyond = turned_at_corner()
    speed = np.sqrt(1 - 4 * math.sin(turn_rad / 2) ** 2 * beyond * (1 - beyond))
    return float(np.sum(1 - speed) * (AT_CORNER_MM[1] - AT_CORNER_MM[0]))


def round_corners_mm(radius_mm: float, turn_rad: float, count: int) -> float:
    """Of a tape round so many corners at a radius, each of two sides that turn so far.

    By Cauchy's formula: the tape's length is how far it reaches to all directions, summed up.
    """
    step = AT_CORNER_MM[1] - AT_CORNER_MM[0]
    out = -np.cumsum(2 * turned_at_corner() - 1) * step * math.sin(turn_rad / 2)
    out += radius_mm - 20 * math.sin(turn_rad / 2)
    along = AT_CORNER_MM * math.cos(turn_rad / 2)
    ways = np.linspace(-math.pi / count, math.pi / count, 1001)
    reach = [(out * math.cos(way) + along * math.sin(way)).max() for way in ways]
    return count * float(np.trapezoid(reach, ways))


def test_a_taut_tape_spans_hollows_and_the_contour_follows_them(
    make_turned: Callable[..., Mesh],
) -> None:
    level = level_at(star(make_turned), 30.0)
    side = math.sqrt(60**2 + 40**2 - 2 * 60 * 40 * math.cos(math.pi / 8))
    wide = 2 * math.asin(60 * math.sin(math.pi / 8) / side)  # between two sides at a deep corner
    turns = math.pi - wide, math.pi - (wide - math.pi / 4)
    rounded = sum(8 * lost_at_corner_mm(turn) for turn in turns)
    assert contour_mm(level).value == pytest.approx(16 * side - rounded, abs=0.02)
    taut = tape_mm(level)
    assert taut.value == pytest.approx(round_corners_mm(60.0, turns[1], 8), abs=5e-3)
    assert taut.along_mm is not None
    assert taut.along_mm.sum() < 0.05 * taut.value  # all else spans hollows
    assert area_mm2(level).value == pytest.approx(8 * 60 * 40 * math.sin(math.pi / 8), rel=EXACT)


def test_a_width_through_the_axis_is_less_than_the_caliper_off_centre(
    cylinder: Mesh,
) -> None:
    level = level_at(moved(cylinder, 0, 30, 0), 40.0)
    through, caliper = ml_through_mm(level), ml_mm(level)
    assert through is not None
    # The chord of the polygon at y = -30 from its middle.
    angles = 2 * np.pi * np.arange(N + 1) / N
    chord = 2 * np.interp(-30.0, 50 * np.sin(angles[72:]), 50 * np.cos(angles[72:]))
    assert through.value == pytest.approx(chord, rel=EXACT)
    assert caliper.value == pytest.approx(100, rel=EXACT)


def test_no_width_through_an_axis_that_lies_outside(cylinder: Mesh) -> None:
    level = level_at(moved(cylinder, 80, 0, 0), 40.0)
    assert ml_through_mm(level) is None
    assert ap_through_mm(level) is None
    assert ml_mm(level).value == pytest.approx(100, rel=EXACT)


def test_hollows_take_off_area_and_leave_the_girth(make_turned: Callable[..., Mesh]) -> None:
    outer = make_turned(np.full(2, 50.0), np.array([0.0, 100.0]), N)
    inner = inside_out(make_turned(np.full(2, 45.0), np.array([10.0, 90.0]), N))
    level = level_at(joined(outer, inner), 50.0)
    assert sorted(level.depth) == [0, 1]
    unit = 0.5 * N * math.sin(2 * math.pi / N)
    assert area_mm2(level).value == pytest.approx(unit * (50**2 - 45**2), rel=EXACT)
    assert contour_mm(level).value == pytest.approx(smooth_mm(50), rel=SMOOTH)
    core = make_turned(np.full(2, 20.0), np.array([20.0, 80.0]), N)
    level = level_at(joined(inner, core, outer), 50.0)
    assert sorted(level.depth) == [0, 1, 2]
    assert area_mm2(level).value == pytest.approx(unit * (50**2 - 45**2 + 20**2), rel=EXACT)


@pytest.mark.parametrize("measured", [0, 1])
def test_a_tape_goes_round_one_of_two_thighs(
    make_forked: Callable[..., Mesh], measured: int
) -> None:
    """Arms of 50 and 45 mm, 300 mm apart: a tape round both would read over 900 mm."""
    body = make_forked(300.0, (50.0, 45.0))
    at, radius, other = ((0.0, 50.0, 45.0), (300.0, 45.0, 50.0))[measured]
    level = level_at(body, 90.0, through_mm=(at, 0.0))
    assert level_at(body, 90.0).points_mm[:, 0].max() < 51  # the long axis goes through the first
    unit = 0.5 * N * math.sin(2 * math.pi / N)
    assert contour_mm(level).value == pytest.approx(smooth_mm(radius), rel=SMOOTH)
    assert tape_mm(level).value == pytest.approx(smooth_mm(radius), rel=SMOOTH)
    assert ml_mm(level).value == pytest.approx(2 * radius, rel=EXACT)
    assert ap_mm(level).value == pytest.approx(2 * radius, rel=EXACT)
    assert area_mm2(level).value == pytest.approx(unit * radius**2, rel=EXACT)
    (beside,) = level.others
    assert beside.contour_mm == pytest.approx(smooth_mm(other), rel=SMOOTH)
    assert beside.area_mm2 == pytest.approx(unit * other**2, rel=EXACT)
    np.testing.assert_allclose(beside.middle_mm, [300.0 - at, 0], atol=1e-6)
    assert level_at(body, -160.0).others == ()


def test_a_trunk_is_measured_without_its_arms(make_turned: Callable[..., Mesh]) -> None:
    """An arm with a bone in it, and one nearer to the origin than the trunk's own wall."""
    trunk = make_turned(np.full(2, 150.0), np.array([0.0, 400.0]), N, squeeze=0.7)
    arm = make_turned(np.full(2, 40.0), np.array([50.0, 390.0]), N)
    bone = inside_out(make_turned(np.full(2, 10.0), np.array([60.0, 380.0]), N))
    body = joined(moved(joined(arm, bone), -195, 0, 0), trunk, moved(arm, 192, 20, 0))
    alone = level_at(trunk, 200.0)
    level = level_at(body, 200.0)
    for measure in (contour_mm, tape_mm, ml_mm, ap_mm, area_mm2, radius_mm):
        assert measure(level).value == pytest.approx(measure(alone).value, rel=EXACT)
    assert [other.contour_mm for other in level.others] == pytest.approx(
        [smooth_mm(40)] * 2, rel=SMOOTH
    )
    unit = 0.5 * N * math.sin(2 * math.pi / N)
    sizes = [other.area_mm2 / unit for other in level.others]
    assert sizes == pytest.approx([1600, 1500])
    held = level_at(body, 200.0, through_mm=(-195.0, 0.0))
    assert held.depth.tolist() == [0, 1]
    assert area_mm2(held).value == pytest.approx(unit * 1500, rel=EXACT)


def test_a_heel_is_measured_without_the_forefoot(make_forked: Callable[..., Mesh]) -> None:
    """Upside down the fork stands on heel and ball; the leg's axis goes through the heel."""
    foot = make_forked(120.0, (32.0, 20.0))
    foot = moved(inside_out(foot.with_vertices(foot.vertices_mm * [1, 1, -1])), 0, 0, 200)
    level = level_at(foot, 30.0)
    assert tape_mm(level).value == pytest.approx(smooth_mm(32), rel=SMOOTH)
    assert [other.contour_mm for other in level.others] == pytest.approx([smooth_mm(20)], rel=1e-4)


def test_where_the_axis_misses_all_outlines_the_nearest_is_measured(cylinder: Mesh) -> None:
    small = moved(cylinder.with_vertices(cylinder.vertices_mm * [0.2, 0.2, 1]), 14, 0, 0)
    level = level_at(joined(moved(cylinder, -65, 0, 0), small), 90.0)
    assert tape_mm(level).value == pytest.approx(smooth_mm(10), rel=1e-4)
    assert [other.contour_mm for other in level.others] == pytest.approx(
        [smooth_mm(50)], rel=SMOOTH
    )


def straddled(make_forked: Callable[..., Mesh], axis_at_mm: float) -> Mesh:
    """Two wavy thighs of 55 and 60 mm on a trunk; the axis passes between them, so far along x.

    The waves go 0.8 mm to and fro and bring now the one, now the other nearer to the middle.
    """
    body = make_forked(160.0, (55.0, 60.0))
    vertices = body.vertices_mm.copy()
    vertices[:, 0] += 0.8 * np.cos(2 * np.pi * vertices[:, 2] / 40.0) - axis_at_mm
    return body.with_vertices(vertices)


HEIGHTS_MM, ALONE_MM = [10.0, 30, 50, 70, 90], (10.0, 70.0)


@pytest.mark.parametrize("axis_at_mm", [77.5, 77.0, 78.0])
def test_between_two_thighs_nothing_is_measured_from_level_to_level(
    make_forked: Callable[..., Mesh], axis_at_mm: float
) -> None:
    body = straddled(make_forked, axis_at_mm)
    for height, level in zip(HEIGHTS_MM, levels_at(body, HEIGHTS_MM), strict=True):
        assert isinstance(level, Refused)
        assert level.reason.code == "measure.level.no_limb"
        if height not in ALONE_MM:
            continue
        with pytest.raises(MeasureError) as refused:
            level_at(body, height)
        assert refused.value.finding == level.reason


@pytest.mark.parametrize(("axis_at_mm", "radius"), [(57.0, 55.0), (98.0, 60.0)])
def test_one_thigh_is_followed_from_level_to_level(
    make_forked: Callable[..., Mesh], axis_at_mm: float, radius: float
) -> None:
    """Clearly nearer to one; asked for together or alone, the same."""
    body = straddled(make_forked, axis_at_mm)
    for height, level in zip(HEIGHTS_MM, levels_at(body, HEIGHTS_MM), strict=True):
        assert isinstance(level, Level)
        assert tape_mm(level).value == pytest.approx(round_mm(radius), rel=1e-3)
        if height in ALONE_MM:
            assert tape_mm(level_at(body, height)).value == tape_mm(level).value


@pytest.mark.parametrize("by_mm", [-3.0, pytest.param(0.0, marks=pytest.mark.slow), 3.0])
def test_all_who_measure_choose_the_same_thigh_after_an_edit_too(
    make_forked: Callable[..., Mesh], by_mm: float
) -> None:
    """An edit moves the thighs; where either may be nearer then, none is measured."""
    for axis_at_mm, radius in ((60.0, 55.0), (95.0, 60.0), (77.5, None)):
        before = straddled(make_forked, axis_at_mm)
        found = changes_by_level(before, moved(before, by_mm, 0, 0), tuple(HEIGHTS_MM))
        for level in found.levels:
            told = level.measures.get("tape_mm")
            assert (told is None) == (radius is None)
            if told is not None and radius is not None:
                assert told.first.value == pytest.approx(round_mm(radius), rel=1e-3)
                assert told.second.value == pytest.approx(round_mm(radius), rel=1e-3)


def test_a_bent_limb_is_followed_past_another(make_turned: Callable[..., Mesh]) -> None:
    """It leaves the axis, and the other comes nearer; none passes for the other."""
    heights = np.linspace(0, 200, 41)
    bent = make_turned(np.full(41, 30.0), heights, N)
    vertices = bent.vertices_mm.copy()
    vertices[:, 0] += 100.0 * (vertices[:, 2] / 200) ** 2
    other = moved(make_turned(np.full(41, 40.0), heights, N), -75, 0, 0)
    body = joined(bent.with_vertices(vertices), other)
    for level in levels_at(body, [20.0, 100, 130, 160, 190]):
        assert isinstance(level, Level)
        assert tape_mm(level).value == pytest.approx(round_mm(30), rel=1e-2)


@pytest.mark.parametrize("at_mm", [0.0, 5.0])
def test_where_a_limb_has_ended_no_other_is_measured(
    make_turned: Callable[..., Mesh], at_mm: float
) -> None:
    """Thigh A ends at 100 mm, B beside it goes on."""
    ended = make_turned(np.full(21, 55.0), np.linspace(0, 100, 21), N)
    other = moved(make_turned(np.full(41, 60.0), np.linspace(0, 200, 41), N), 160, 0, 0)
    body = joined(ended, other)
    low, high = levels_at(body, [50.0, 150.0], through_mm=(at_mm, 0.0))
    assert isinstance(low, Level)
    assert tape_mm(low).value == pytest.approx(smooth_mm(55), rel=SMOOTH)
    assert isinstance(high, Refused)
    with pytest.raises(MeasureError, match="none alone continues the limb"):
        level_at(body, 150.0, through_mm=(at_mm, 0.0))
    held = level_at(body, 150.0, through_mm=(160.0, 0.0))
    assert tape_mm(held).value == pytest.approx(smooth_mm(60), rel=SMOOTH)


def test_240_planes_give_240_answers_in_the_order_asked(cylinder: Mesh) -> None:
    heights = np.linspace(250, -20, 240)
    answers = levels_at(cylinder, heights.tolist())
    np.testing.assert_array_equal([answer.height_mm for answer in answers], heights)
    hit = (heights > 0) & (heights <= 200)
    assert [isinstance(answer, Level) for answer in answers] == hit.tolist()
    missed = [answer for answer in answers if isinstance(answer, Refused)]
    assert {answer.reason.code for answer in missed} == {"measure.level.missed"}
    assert len(missed) == (~hit).sum() > 0


def test_a_plane_that_misses_is_an_error_with_the_limbs_extent(cylinder: Mesh) -> None:
    with pytest.raises(MeasureError, match=r"-1\.00 mm misses .* from 0\.00 to 200\.00"):
        level_at(cylinder, -1.0)
    with pytest.raises(MeasureError, match="misses"):
        level_at(cylinder, math.nan)


def test_a_plane_through_the_brim_is_an_error(make_turned: Callable[..., Mesh]) -> None:
    tube = make_turned(np.full(5, 50.0), np.linspace(0, 100, 5), N, capped=False)
    slant = tube.vertices_mm.copy()
    slant[-N:, 2] += slant[-N:, 0] / 5
    tube = tube.with_vertices(slant)
    assert tape_mm(level_at(tube, 70.0)).value == pytest.approx(smooth_mm(50), rel=SMOOTH)
    with pytest.raises(MeasureError, match="open edge"):
        level_at(tube, 95.0)


def test_surfaces_that_overlap_are_refused(cylinder: Mesh) -> None:
    inner = moved(cylinder, 0, 0, 0)
    inner = inner.with_vertices(inner.vertices_mm * [0.5, 0.5, 1])
    with pytest.raises(MeasureError, match="through itself"):
        level_at(joined(cylinder, inner), 50.0)


@pytest.mark.parametrize("name", list(MEASURES))
def test_slopes_are_what_moving_the_surface_does(
    make_turned: Callable[..., Mesh], name: str
) -> None:
    """Finite differences: the whole chain from vertices along their normals to the figure.

    What is moved is a surface: neighbours go along with each other, as its errors do. A vertex
    alone, 1e-6 mm away, would tell of the triangles and not of the limb.
    """
    heights = np.linspace(0, 100, 81)
    body = make_turned(50 + 6 * np.sin(heights / 9), heights, 256, squeeze=0.8)
    x, y, z = body.vertices_mm.T
    body = body.with_vertices(
        body.vertices_mm + np.column_stack([3 * np.sin(y / 11), 0 * y, x / 9])
    )
    push = 1 + 0.6 * np.sin(x / 17 + 1) + 0.5 * np.cos(y / 13) + 0.4 * np.sin(z / 8)
    normals = body.vertex_normals()
    level = level_at(body, 41.7)
    sloped = MEASURES[name](level)
    assert sloped is not None
    told = float(Sigmas.of(body).gradient(level, sloped) @ push)
    step = 1e-6
    values = []
    for sign in (-1, 1):
        pushed = body.with_vertices(body.vertices_mm + sign * step * push[:, None] * normals)
        after = MEASURES[name](level_at(pushed, 41.7))
        assert after is not None
        values.append(after.value)
    assert abs(told) > 1e-3
    assert told == pytest.approx((values[1] - values[0]) / (2 * step), rel=0.01)


@pytest.mark.parametrize("height_mm", [10.0, 57.5, 99.999, 100.0, 100.37, 188.0])
def test_levels_through_rows_of_vertices_are_as_sure_as_those_between(
    make_turned: Callable[..., Mesh], height_mm: float
) -> None:
    """A tube with a row of vertices at every whole mm, turned away and back: rows lie within
    1e-14 mm of the plane, and so do the edges along them. Each of a row's vertices changes the
    girth by 2 sin(pi / n) a millimetre; between two rows they share that by their heights."""
    pose = Rigid.from_rotation_vector(np.array([0.4, -1.0, 0.7]), np.array([200.0, -30, 55]))
    tube = make_turned(np.full(201, 50.0), np.arange(201.0), N)
    tube = tube.with_vertices(pose.inverse.apply(pose.apply(tube.vertices_mm)))
    sigmas = Sigmas.of(replace(tube, sigma_mm=np.full(len(tube), 0.15, np.float32)))
    level = level_at(tube, height_mm)
    share = height_mm % 1
    expected = 0.15 * 2 * math.sin(math.pi / N) * math.sqrt(N * (share**2 + (1 - share) ** 2))
    for measure in (tape_mm, contour_mm):
        sigma = sigmas.figure(level, measure(level)).sigma
        assert sigma == pytest.approx(expected, rel=0.02)
    for name, measure in MEASURES.items():
        sloped = measure(level)
        assert sloped is not None
        sigma = sigmas.figure(level, sloped).sigma
        assert sigma is not None
        assert 0 < sigma < (0.5 * 50 if name == "area_mm2" else 0.5)


@pytest.mark.parametrize("woven_mm", [0.0, 1e-13, 1e-9, 1e-6])
def test_a_level_along_a_row_is_as_sure_where_its_vertices_lie_now_above_now_below(
    make_turned: Callable[..., Mesh], woven_mm: float
) -> None:
    """A cone; the plane crosses each of the row's edges midway, where that rises by hardly
    anything. Moved along its normal, a wall that leans by a fifth is cut farther out by more."""
    heights = np.arange(201.0)
    cone = make_turned(70 - 0.2 * heights, heights, N)
    vertices = cone.vertices_mm.copy()
    (row,) = np.nonzero(np.abs(vertices[:, 2] - 100) < 1e-6)
    assert len(row) == N
    vertices[row[::2], 2] += woven_mm
    vertices[row[1::2], 2] -= woven_mm
    sigma_mm = np.full(len(cone), 0.15, np.float32)
    cone = replace(cone.with_vertices(vertices), sigma_mm=sigma_mm)
    level = level_at(cone, 100.0)
    each = 2 * math.sin(math.pi / N) * math.hypot(1, 0.2)
    for measure in (tape_mm, contour_mm):
        sigma = Sigmas.of(cone).figure(level, measure(level)).sigma
        assert sigma == pytest.approx(0.15 * math.sqrt(N) * each, rel=0.02)
    for measure in (ml_mm, ap_mm):  # both ends, and what else may be foremost
        sigma = Sigmas.of(cone).figure(level, measure(level)).sigma
        assert sigma is not None
        assert 0.15 * math.hypot(1, 0.2) < sigma < 0.15 * 2 * math.hypot(1, 0.2)


@pytest.mark.parametrize("shape", ["cone", "barrel", "waist"])
@pytest.mark.parametrize("spacing_mm", [4.5, pytest.param(1.5, marks=pytest.mark.slow)])
def test_every_level_of_a_shell_has_a_sigma_of_its_vertices_size(
    make_turned: Callable[..., Mesh], shape: str, spacing_mm: float
) -> None:
    heights = np.arange(201.0)
    radii = {
        "cone": 70 - 0.2 * heights,
        "barrel": 40 + 25 * np.sin(np.pi * heights / 200),
        "waist": 60 - 20 * np.sin(np.pi * heights / 200),
    }[shape]
    pose = Rigid.from_rotation_vector(np.array([1.1, 0.3, -0.6]), np.array([-80.0, 10, 400]))
    shell = make_turned(radii, heights, N, squeeze=0.8)
    shell = shell.with_vertices(pose.inverse.apply(pose.apply(shell.vertices_mm)))
    sigmas = Sigmas.of(replace(shell, sigma_mm=np.full(len(shell), 0.15, np.float32)))
    levels = levels_at(shell, np.arange(3, 197.5, spacing_mm).tolist())  # on rows and between
    for level in levels:
        assert isinstance(level, Level)
        for measure in (tape_mm, contour_mm, ml_mm, ap_mm):
            sigma = sigmas.figure(level, measure(level)).sigma
            assert sigma is not None
            assert 0.05 < sigma < 0.5


def test_a_girths_sigma_is_that_of_its_radius(cylinder: Mesh) -> None:
    """One vertex of a ring on the plane: the girth's slope is 2 sin(pi/n) a millimetre each."""
    ring = np.abs(cylinder.vertices_mm[:, 2] - 100) < 1e-9
    sigma = np.where(ring, 0.1, 0.0).astype(np.float32)
    level = level_at(cylinder, 100.0)
    figure = Sigmas.of(replace(cylinder, sigma_mm=sigma)).figure(level, tape_mm(level))
    assert figure.sigma == pytest.approx(0.1 * math.sqrt(N) * 2 * math.sin(math.pi / N), rel=0.02)
    assert Sigmas.of(cylinder).figure(level, tape_mm(level)).sigma is None


def test_a_girth_is_the_limbs_own_and_not_the_smoothed_surfaces(cylinder: Mesh) -> None:
    """Twice as much is lost on one half of the cylinder as on the other."""
    count = len(cylinder)
    front = np.where(cylinder.vertices_mm[:, 1] > 0, 2.0, 1.0)[:, None]
    lost = (front * [4e-4, 1e-4]).astype(np.float32)
    known = replace(cylinder, sigma_mm=np.zeros(count, np.float32), lost_length=lost)
    level = level_at(cylinder, 101.0)
    bare, sigmas = contour_mm(level).value, Sigmas.of(known)
    contour, tape = (sigmas.figure(level, of(level)) for of in (contour_mm, tape_mm))
    taut = tape_mm(level).value
    assert contour.value / bare - 1 == pytest.approx(1.5 * 4e-4, rel=0.05)
    assert contour.sigma == pytest.approx(1.5 * 1e-4 * bare, rel=0.05)
    assert tape.value - taut == pytest.approx(contour.value - bare, rel=1e-6)
    assert tape.sigma == pytest.approx(contour.sigma, rel=1e-6)
    assert sigmas.figure(level, area_mm2(level)).value == area_mm2(level).value
    unknown = replace(known, sigma_mm=None)
    assert Sigmas.of(unknown).figure(level, contour_mm(level)).value == bare


@pytest.mark.parametrize(("turn_deg", "times"), [(0.0, 2.0), (90.0, 0.0), (45.0, 1.0)])
def test_a_girth_across_folds_lost_twice_as_much_and_one_along_them_nothing(
    cylinder: Mesh, turn_deg: float, times: float
) -> None:
    """Folds of the same slope, at an angle to the girth, in whichever frame they were measured."""
    count, lost = len(cylinder), np.array([4e-4, 1e-4], np.float32)
    x, y, _ = cylinder.vertex_normals().T
    turn = np.radians(turn_deg)
    across = np.column_stack([-y * np.cos(turn), x * np.cos(turn), np.full(count, np.sin(turn))])
    across[::2] *= -1  # a fold has no front: either sign says the same
    folded = replace(
        cylinder,
        sigma_mm=np.zeros(count, np.float32),
        lost_length=np.tile(lost, (count, 1)),
        lost_across=(lost[0] * across).astype(np.float32),
    )
    elsewhere = Rigid.from_rotation_vector(np.array([0.3, -1.2, 0.7]), np.array([5.0, 6.0, 7.0]))
    back = folded.moved(elsewhere).moved(elsewhere.inverse)
    level = level_at(back, 101.0)
    for measure in (contour_mm, tape_mm):
        bare = measure(level).value
        figure = Sigmas.of(back).figure(level, measure(level))
        assert figure.value / bare - 1 == pytest.approx(times * 4e-4, abs=1e-5)
        assert figure.sigma == pytest.approx(1e-4 * bare, rel=0.05)


@pytest.mark.parametrize(("across_mm", "named"), [(3.0, False), (8.0, True)])
def test_a_crumb_beside_the_limb_is_no_limb(cylinder: Mesh, across_mm: float, named: bool) -> None:
    """A pin beside a leg of 100 mm takes no part in its figures; one of 8 mm is named."""
    alone = level_at(cylinder, 100.0)
    thin = np.array([across_mm / 100, across_mm / 100, 1.0])
    pin = moved(cylinder.with_vertices(cylinder.vertices_mm * thin), 60, 0, 0)
    level = level_at(joined(cylinder, pin), 100.0)
    assert level.left_out == (0 if named else 1)
    assert len(level.others) == (1 if named else 0)
    for measure in (tape_mm, contour_mm, ml_mm, area_mm2):
        assert measure(level).value == pytest.approx(measure(alone).value, rel=EXACT)


def test_folds_of_either_sign_keep_their_way_where_faces_are_split(cylinder: Mesh) -> None:
    """Half of the vertices say the same way with the other sign: a mean of both would be none."""
    across = np.tile(np.array([0.0, 0.0, 3e-4], np.float32), (len(cylinder), 1))
    across[::2] *= -1
    known = replace(cylinder, lost_across=across)
    split = refine_where(known, np.ones(len(cylinder.faces), np.bool_), 3.0)
    assert len(split) > len(known)
    assert split.lost_across is not None
    np.testing.assert_allclose(np.abs(split.lost_across[:, 2]), 3e-4, rtol=1e-6)
