"""Thickness: a draped sheet keeps its volume; zones and ribs are as thick as they say."""

import numpy as np
import pytest
import trimesh

from limbgram.core.mesh.mesh import Mesh, crosses
from limbgram.workbench.devices.layout import CoveredArea, Rib
from limbgram.workbench.devices.thickness import Zone, draped_thickness, printed_thickness

RADIUS = 50.0


@pytest.fixture(scope="module")
def half() -> CoveredArea:
    """A sphere, of which a device covers the lower half; the sheet leaves it 15 mm above."""
    ball = trimesh.creation.icosphere(5, RADIUS)
    mesh = Mesh(vertices_mm=np.asarray(ball.vertices, float), faces=ball.faces.astype(np.int32))
    polar = np.arccos(-mesh.vertices_mm[:, 2] / RADIUS)
    return CoveredArea(positive=mesh, beyond_mm=RADIUS * polar - (RADIUS * np.pi / 2 - 15.0))


def test_a_held_sheet_over_a_hemisphere_is_a_quarter_at_its_top(half: CoveredArea) -> None:
    """Stereographic projection: the stretch of area is (2 / (1 + cos polar))^2 at the rim's 1."""
    mesh = half.positive
    thick = draped_thickness(half, 6.0)
    polar = np.arccos(np.clip(-mesh.vertices_mm[:, 2] / RADIUS, -1, 1))
    exact = 6.0 / np.maximum(1 + np.cos(polar), 1e-9) ** 2
    inside = polar < np.radians(85)
    np.testing.assert_allclose(thick[inside], exact[inside], rtol=0.03)
    assert thick[np.argmin(mesh.vertices_mm[:, 2])] == pytest.approx(1.5, rel=0.03)


def test_a_held_sheet_keeps_its_volume(half: CoveredArea) -> None:
    mesh = half.positive
    thick = draped_thickness(half, 6.0)
    areas = np.linalg.norm(crosses(mesh.vertices_mm, mesh.faces), axis=1) / 2
    below = mesh.vertices_mm[mesh.faces].mean(1)[:, 2] < 0
    volume = (areas * thick[mesh.faces].mean(1))[below].sum()
    assert volume == pytest.approx(6.0 * np.pi * RADIUS**2, rel=0.03)


def test_a_soft_sheet_draws_in_and_thins_less(half: CoveredArea) -> None:
    held, soft = draped_thickness(half, 6.0), draped_thickness(half, 6.0, 16.0)
    top = np.argmin(half.positive.vertices_mm[:, 2])
    # far from any edge: u = K draw^2
    assert soft[top] == pytest.approx(6.0 * np.exp(-2 * (16 / RADIUS) ** 2), rel=0.03)
    assert soft[top] > held[top]
    assert soft.max() <= 6.0 + 1e-9


def test_what_can_be_unrolled_does_not_stretch() -> None:
    tube = trimesh.creation.cylinder(40.0, 200.0, sections=96).subdivide().subdivide()
    mesh = Mesh(vertices_mm=np.asarray(tube.vertices, float), faces=tube.faces.astype(np.int32))
    covered = CoveredArea(positive=mesh, beyond_mm=np.abs(mesh.vertices_mm[:, 2]) - 40.0)
    inside = covered.beyond_mm < 0
    np.testing.assert_allclose(draped_thickness(covered, 4.8)[inside], 4.8, rtol=1e-3)


def test_zones_and_ribs_add_what_they_say(half: CoveredArea) -> None:
    mesh = half.positive
    polar = RADIUS * np.arccos(np.clip(-mesh.vertices_mm[:, 2] / RADIUS, -1, 1))
    zone = Zone(middle_mm=np.array([0, 0, -RADIUS]), reach_mm=15.0, falloff_mm=10.0, add_mm=3.0)
    thick = printed_thickness(half, 4.0, [zone])
    np.testing.assert_allclose(thick[polar < 14.5], 7.0)
    np.testing.assert_allclose(thick[polar > 25.5], 4.0)
    np.testing.assert_allclose(thick[np.abs(polar - 20) < 0.3], 5.5, atol=0.15)
    angle = np.linspace(-0.6, 0.6, 40)
    line = RADIUS * np.column_stack([np.sin(angle), 0 * angle, -np.cos(angle)])
    rib = Rib(line_mm=line, width_mm=12.0, falloff_mm=5.0, add_mm=2.0)
    raised = printed_thickness(half, 4.0, (), [rib])
    off = RADIUS * np.abs(np.arcsin(np.clip(mesh.vertices_mm[:, 1] / RADIUS, -1, 1)))
    along = np.abs(np.arctan2(mesh.vertices_mm[:, 0], -mesh.vertices_mm[:, 2])) < 0.5
    np.testing.assert_allclose(raised[along & (off < 5.3)], 6.0, atol=0.02)
    np.testing.assert_allclose(raised[along & (off > 12)], 4.0, atol=0.02)
