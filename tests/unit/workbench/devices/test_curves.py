"""Fair curves hang on the surface alone, not on how it was cut into triangles."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.devices import curves
from limbgram.workbench.devices.curves import fair_curve
from limbgram.workbench.measures.geodesic import shortest_path

RADIUS_MM, HIGH_MM = 50.0, 400.0


def prism(*, flipped: bool) -> Mesh:
    """A tube of flat strips, each square of which is halved by one diagonal or by the other: both
    are the same surface."""
    sides, rings = 26, 34
    turned = np.radians(np.arange(sides) * 360 / sides)
    heights = np.linspace(0, HIGH_MM, rings)
    round_it = np.column_stack([RADIUS_MM * np.cos(turned), RADIUS_MM * np.sin(turned)])
    vertices = np.concatenate([np.column_stack([round_it, np.full(sides, z)]) for z in heights])
    low = (np.arange(rings - 1)[:, None] * sides + np.arange(sides)).ravel()
    ahead = (np.arange(rings - 1)[:, None] * sides + (np.arange(sides) + 1) % sides).ravel()
    a, b, c, d = low, ahead, ahead + sides, low + sides
    halves = [(a, b, d), (b, c, d)] if flipped else [(a, b, c), (a, c, d)]
    faces = np.concatenate([np.column_stack(one) for one in halves]).astype(np.int32)
    return Mesh(vertices_mm=vertices, faces=faces)


def picked(*degrees_and_heights: tuple[float, float]) -> Points3:
    return np.array(
        [
            [RADIUS_MM * np.cos(np.radians(deg)), RADIUS_MM * np.sin(np.radians(deg)), z]
            for deg, z in degrees_and_heights
        ]
    )


def farthest_mm(one: Points3, other: Points3) -> float:
    """From the points of one closed line to another one, whose points lie half a millimetre
    apart."""
    ahead = np.roll(other, -1, axis=0)
    dense = np.concatenate([other + share * (ahead - other) for share in np.arange(8) / 8])
    return float(KDTree(dense).query(one)[0].max())


ROUND = picked((10, 60), (95, 330), (170, 310), (255, 80), (300, 120))
"""Long legs that run aslant, as the front edges of a calf do."""


def test_it_is_the_same_on_other_triangles_of_the_same_surface() -> None:
    one, other = (fair_curve(prism(flipped=flipped), ROUND).points_mm for flipped in (False, True))
    assert farthest_mm(one, other) < 0.1


def test_it_is_mirrored_with_the_surface() -> None:
    whole = prism(flipped=False)
    flip = np.array([-1.0, 1.0, 1.0])
    mirrored = Mesh(vertices_mm=whole.vertices_mm * flip, faces=whole.faces[:, ::-1].copy())
    one = fair_curve(whole, ROUND).points_mm
    other = fair_curve(mirrored, ROUND * flip).points_mm
    assert farthest_mm(one, other * flip) < 0.1


def test_where_one_point_moves_only_its_two_legs_are_looked_for_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mesh, asked = prism(flipped=False), []

    def counted(on: Mesh, start_mm: Points3, end_mm: Points3) -> Points3:
        asked.append((start_mm, end_mm))
        return shortest_path(on, start_mm, end_mm)

    monkeypatch.setattr(curves, "shortest_path", counted)
    first = fair_curve(mesh, ROUND)
    assert len(asked) == len(ROUND)
    assert fair_curve(mesh, ROUND) is first
    assert len(asked) == len(ROUND)
    moved = ROUND.copy()
    moved[2] = picked((180, 300))[0]
    found = fair_curve(mesh, moved).points_mm
    assert len(asked) == len(ROUND) + 2
    np.testing.assert_array_equal(found, fair_curve(prism(flipped=False), moved).points_mm)
    assert len(asked) == 2 * len(ROUND) + 2
