"""What is missing of a limb is told from its surface, wherever it stands and however turned."""

import numpy as np
import pytest

from limbgram.core.mesh.mesh import Mesh
from limbgram.report.accuracy.surface import around_figures

RADIUS_MM, HEIGHT_MM = 50.0, 240.0
RINGS, SPOKES = 61, 120


def tube() -> Mesh:
    """Open at both ends, about z, from z = 0."""
    azimuth = np.arange(SPOKES) * 2 * np.pi / SPOKES
    places = np.empty((RINGS, SPOKES, 3))
    places[..., 0], places[..., 1] = RADIUS_MM * np.cos(azimuth), RADIUS_MM * np.sin(azimuth)
    places[..., 2] = np.linspace(0, HEIGHT_MM, RINGS)[:, None]
    grid = np.arange(RINGS * SPOKES, dtype=np.int32).reshape(RINGS, SPOKES)
    a, b = grid[:-1], np.roll(grid, -1, axis=1)[:-1]
    c, d = np.roll(grid, -1, axis=1)[1:], grid[1:]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return Mesh(vertices_mm=places.reshape(-1, 3), faces=np.ascontiguousarray(faces))


def azimuth_deg(mesh: Mesh) -> np.ndarray:
    x, y = mesh.vertices_mm[:, :2].T
    return np.degrees(np.arctan2(y, x)) % 360


def without(mesh: Mesh, gone: np.ndarray) -> Mesh:
    return Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces[~gone[mesh.faces].any(1)])


def moved(mesh: Mesh, off_mm: tuple[float, float, float], turn_deg: float) -> Mesh:
    turn = np.radians(turn_deg)
    rotation = np.array(
        [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    )
    return mesh.with_vertices(mesh.vertices_mm @ rotation.T + np.array(off_mm))


@pytest.mark.parametrize("gap_deg", [0, 36, 90, 180, 240])
def test_a_gap_counts_with_its_share_wherever_it_lies(gap_deg: float) -> None:
    whole = tube()
    turned = moved(without(whole, azimuth_deg(whole) < gap_deg), (300.0, -80.0, 60.0), 33.0)
    found = around_figures(turned, 60.0)
    assert found.missing_share == pytest.approx(gap_deg / 360, abs=0.02)
    assert found.widest_gap_deg == pytest.approx(gap_deg, abs=7)


def test_a_cone_that_leans_has_nothing_missing() -> None:
    mesh = tube()
    z = mesh.vertices_mm[:, 2:]
    cone = mesh.vertices_mm * np.array([1.0, 0.6, 1.0]) * np.where(z < 0, 1, 1 - 0.6 * z / 240)
    cone[:, 2] = z[:, 0]
    cone[:, 0] += 0.5 * z[:, 0]
    found = around_figures(mesh.with_vertices(cone), None)
    assert found.missing_share == 0


def test_what_was_filled_in_is_no_surface() -> None:
    whole = tube()
    filled = azimuth_deg(whole) < 180
    mesh = Mesh(vertices_mm=whole.vertices_mm, faces=whole.faces, filled=filled)
    assert around_figures(mesh, 0.0).missing_share == pytest.approx(0.5, abs=0.03)


def test_one_brim_and_what_stands_on_the_table_are_no_opening() -> None:
    ring = np.pi * RADIUS_MM**2
    wall = 2 * np.pi * RADIUS_MM * HEIGHT_MM
    assert around_figures(tube(), 0.0).open_share == pytest.approx(0, abs=1e-3)
    hanging = around_figures(tube(), -60.0).open_share
    assert hanging == pytest.approx(ring / (wall + 2 * ring), rel=0.02)


def test_half_a_shell_is_open_beyond_its_brim() -> None:
    whole = tube()
    half = without(whole, azimuth_deg(whole) < 180)
    assert around_figures(half, 0.0).open_share > 0.25
