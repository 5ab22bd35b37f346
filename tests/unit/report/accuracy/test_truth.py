"""Against a truth: the errors that were put in come out, and sigmas are tested honestly."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.report.accuracy.truth import (
    Alignment,
    Compared,
    KnownTruth,
    sigma_test,
    truth_figures,
)
from limbgram.report.alignment import Truth

RNG = np.random.default_rng(4)
CENTRES_MM = RNG.normal(size=(9, 3)) * [900, 900, 200]
AWAY = Rigid.from_rotation_vector(np.array([0.1, 1.4, 2.0]), np.array([300.0, -40.0, 11.0]))
UP_MM = np.array([0.0, 0.0, 0.5])
NONE = np.zeros((0, 3))


def limb(swell_mm: float = 0.0, rings: int = 121, spokes: int = 120) -> Mesh:
    """A lumpy tube that fits itself in one way only, its wall moved outwards."""
    azimuth, height = np.meshgrid(np.arange(spokes) * 2 * np.pi / spokes, np.linspace(0, 1, rings))
    radius = 55 + 8 * np.cos(2 * azimuth + 3 * height) + 6 * np.sin(4 * height + azimuth) + swell_mm
    wall = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), 280 * height], axis=-1)
    grid = np.arange(rings * spokes, dtype=np.int32).reshape(rings, spokes)
    a, b = grid[:-1], np.roll(grid, -1, axis=1)[:-1]
    c, d = np.roll(grid, -1, axis=1)[1:], grid[1:]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return Mesh(vertices_mm=wall.reshape(-1, 3), faces=np.ascontiguousarray(faces))


def truth(*, with_cameras: bool = True) -> Truth:
    mesh = limb()
    return Truth(
        vertices_mm=mesh.vertices_mm,
        faces=mesh.faces,
        seen=(mesh.vertices_mm[:, 2] > 10) & (mesh.vertices_mm[:, 2] < 270),
        centres_mm=CENTRES_MM if with_cameras else NONE,
    )


def compared(mesh: Mesh, centres_mm: np.ndarray, known: Truth, alignment: Alignment) -> Compared:
    named = KnownTruth(kind="a limb", truth=known, centres_mm=centres_mm, alignment=alignment)
    return truth_figures(mesh, named, 0.5)


def test_a_surface_outside_the_truth_is_outside() -> None:
    found = compared(limb(0.2), CENTRES_MM, truth(), "cameras").figures
    # Along the normal, which leans where the wall does: a little less than along the radius.
    assert 0.190 < found.mean_mm < 0.200
    assert 0.190 < found.rms_mm < 0.200
    assert found.rms_px == pytest.approx(found.rms_mm / 0.5)
    assert found.within["0.1 mm"] == 0
    assert found.within["0.25 mm"] == 1
    assert found.covered["0.25 mm"] == 1
    for girth in found.girths:
        # Swollen along the radius, not along the outline's normal: a little less than 2 pi.
        assert 0.95 < girth.error_mm / (2 * np.pi * 0.2) < 1.0
    assert found.camera_rms_mm < 1e-9


def test_a_surface_in_one_frame_with_the_truth_needs_no_alignment() -> None:
    moved = limb().with_vertices(limb().vertices_mm + UP_MM)
    found = compared(moved, NONE, truth(with_cameras=False), "frame").figures
    aligned = compared(moved, CENTRES_MM + UP_MM, truth(), "surface").figures
    assert found.rms_mm > 0.02
    assert aligned.rms_mm < 1e-4


def test_a_truth_in_a_frame_of_its_own_is_found() -> None:
    known = truth(with_cameras=False).moved(AWAY)
    found = compared(limb(), NONE, known, "surface")
    assert found.figures.rms_mm < 1e-3
    assert found.figures.volume_error == pytest.approx(0, abs=1e-4)
    assert found.figures.camera_rms_mm != found.figures.camera_rms_mm


def test_what_was_filled_is_not_compared() -> None:
    mesh = limb()
    wrong = mesh.vertices_mm[:, 2] > 140
    spoiled = mesh.with_vertices(
        np.where(wrong[:, None], mesh.vertices_mm * 1.02, mesh.vertices_mm)
    )
    found = compared(replace(spoiled, filled=wrong), CENTRES_MM, truth(), "cameras")
    assert found.figures.rms_mm < 1e-9
    assert np.isnan(found.off_mm[wrong]).all()


def test_honest_sigmas_spread_by_one_and_halved_ones_by_two() -> None:
    rng = np.random.default_rng(1)
    sigma = rng.uniform(0.02, 0.2, 40_000)
    error = rng.normal(size=len(sigma)) * sigma
    honest = sigma_test(error, sigma)
    assert honest.robust_spread == pytest.approx(1.0, abs=0.02)
    assert honest.within_95_share == pytest.approx(0.95, abs=0.005)
    assert honest.rank_correlation > 0.3
    assert sigma_test(error, sigma / 2).robust_spread == pytest.approx(2.0, abs=0.04)
    blind = sigma_test(rng.normal(size=len(sigma)) * 0.1, sigma)
    assert abs(blind.rank_correlation) < 0.02
    for part in honest.by_sigma:
        assert part.rms_error_mm == pytest.approx(part.sigma_mm, rel=0.12)
