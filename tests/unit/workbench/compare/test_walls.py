"""A wall is compared by the skin that its limb would touch, and is told to be a wall."""

import math
from collections.abc import Callable
from datetime import date
from functools import cache

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import Finding
from limbgram.workbench.compare.comparison import CompareOptions, Comparison, compare
from limbgram.workbench.compare.over_time import Visit, follow, repeats
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.reduction import Reduction
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame

RADIUS_MM, HIGH_MM, SPOKES, STEP_MM = 50.0, 120.0, 60, 5.0
AREA_MM2 = SPOKES / 2 * math.sin(2 * math.pi / SPOKES) * RADIUS_MM**2
HELD_MM3 = AREA_MM2 * (HIGH_MM - 20)
"""Up to the highest level."""


@cache
def _cup() -> Limb:
    """A tube with a flat bottom at 0, open above."""
    rows = round(HIGH_MM / STEP_MM) + 1
    angle = np.arange(SPOKES) * 2 * np.pi / SPOKES
    ring = RADIUS_MM * np.column_stack([np.cos(angle), np.sin(angle)])
    z = np.repeat(np.linspace(0.0, HIGH_MM, rows), SPOKES)
    points = np.vstack([np.column_stack([np.tile(ring, (rows, 1)), z]), np.zeros((1, 3))])
    a = np.arange((rows - 1) * SPOKES).reshape(rows - 1, SPOKES)
    b = np.roll(a, -1, axis=1)
    side = np.stack([a, b, b + SPOKES, a, b + SPOKES, a + SPOKES], -1).reshape(-1, 3)
    bottom = np.column_stack([b[0], a[0], np.full(SPOKES, len(points) - 1)])
    mesh = Mesh(vertices_mm=points, faces=np.vstack([side, bottom]).astype(np.int32))
    return AlignedLimb(
        name="cup", mesh=mesh, frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="left")
    )


def _walls(found: Comparison) -> list[Finding]:
    return [one for one in found.notes if one.code == "compare.wall"]


@pytest.mark.parametrize(("side", "skin"), [("outward", "inside"), ("inward", "outside")])
@pytest.mark.parametrize("limb_first", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_wall_is_the_limb_that_it_was_made_of(side: str, skin: str, *, limb_first: bool) -> None:
    """4 mm thick: between both its skins and the limb lay up to 1,270 mL and 25 mm of girth."""
    limb = _cup()
    wall = do_edit(limb, Wall(thickness_mm=4.0, side=side))  # type: ignore[arg-type]
    found = compare(limb, wall) if limb_first else compare(wall, limb)
    (told,) = _walls(found)
    assert told.values["skin"] == skin
    assert told.values["median_mm"] == pytest.approx(4.0, abs=0.01)
    assert found.radial is not None
    assert found.radial.mre_mm == pytest.approx(0.0, abs=0.01)
    assert found.levels.volume is not None
    assert found.levels.volume.first.value == pytest.approx(HELD_MM3, rel=1e-3)
    assert found.levels.volume.difference == pytest.approx(0.0, abs=0.001 * HELD_MM3)


@pytest.mark.parametrize("per_cent", [3.0, 6.0])
def test_a_socket_over_a_reduced_limb_is_smaller_by_the_reduction(per_cent: float) -> None:
    """6 % of the girth are 3 mm of the radius: the outside of a 4 mm wall lies nearer, at +1 mm."""
    found = compare(_cup(), _socket(per_cent))
    assert [one.values["skin"] for one in _walls(found)] == ["inside"]
    assert found.radial is not None
    assert found.radial.mre_mm == pytest.approx(-RADIUS_MM * per_cent / 100, abs=0.05)


@cache
def _socket(per_cent: float, thickness_mm: float = 4.0) -> Limb:
    reduced = Reduction(heights_mm=(0.0, HIGH_MM), per_cent=(per_cent, per_cent), of="girth")
    limb = do_edit(_cup(), reduced) if per_cent else _cup()
    return do_edit(limb, Wall(thickness_mm=thickness_mm))


@pytest.mark.parametrize("first", [_cup, lambda: _socket(0.0)], ids=["limb", "socket"])
def test_sockets_over_time_are_followed_by_what_they_hold(first: Callable[[], Limb]) -> None:
    """Both skins of a wall of 4 mm would hold a fifth of it, and a tape lie 25 mm farther out."""
    shapes = (first(), _socket(3.0), _socket(6.0))
    days = [date(2026, 3, day) for day in (2, 9, 16)]
    series = follow([Visit(limb=limb, day=day) for limb, day in zip(shapes, days, strict=True)])
    left = np.array([1.0, 0.97, 0.94])
    np.testing.assert_allclose(series.stack.volumes_mm3, left**2 * HELD_MM3, rtol=2e-3)
    girth_mm = 2 * SPOKES * RADIUS_MM * math.sin(math.pi / SPOKES)
    middle = series.stack.tapes_mm[:, len(series.stack.heights_mm) // 2]
    np.testing.assert_allclose(middle, left * girth_mm, atol=0.3)
    told = [one for one in series.stack.notes if one.code == "compare.wall"]
    assert {one.values["skin"] for one in told} == {"inside"}


def test_walls_of_one_limb_repeat_it_however_thick_they_are() -> None:
    found = repeats([_socket(0.0, thick_mm) for thick_mm in (3.0, 4.0, 5.0)], CompareOptions())
    volumes = found.stack.volumes_mm3
    np.testing.assert_allclose(volumes, HELD_MM3, rtol=1e-3)
    assert np.ptp(found.stack.tapes_mm, axis=0).max() < 0.05


def test_a_half_shell_is_told_to_be_compared_by_both_skins() -> None:
    limb = _cup()
    points = limb.mesh.vertices_mm[limb.mesh.faces].mean(1)
    half = limb.with_mesh(Mesh(vertices_mm=limb.mesh.vertices_mm,
                               faces=limb.mesh.faces[points[:, 1] > 0]))  # fmt: skip
    shell = do_edit(half, Wall(thickness_mm=4.0))
    assert [one.values["skin"] for one in _walls(compare(limb, shell))] == ["both"]


def test_two_limbs_are_no_walls() -> None:
    assert not _walls(compare(_cup(), _cup()))
