"""Figures of a case whose errors are known."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import erf
from tests.unit.report.accuracy.conftest import tube

from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.scale.stated_lengths import LengthEnds
from limbgram.report.accuracy.capture import image_figures, length_figures, noise_grey
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.network import (
    camera_figures,
    network_figures,
    pose_figures,
    residual_figures,
)
from limbgram.report.accuracy.surface import expected_p95, surface_figures

NOISE_PX, RADIUS_MM, HEIGHT_MM, PHOTOS = 0.1, 50.0, 240.0, 12

MakeScene = Callable[..., Scene]


def shifted(scene: Scene, by_px: np.ndarray) -> Scene:
    seen = scene.observations
    moved = Observations(seen.photo_idx, seen.point_idx, seen.xy_px + by_px)
    return replace(scene, observations=moved)


def test_residuals_are_the_noise_that_was_put_in(make_scene: MakeScene) -> None:
    found = residual_figures(make_scene())
    assert found.rms_px == pytest.approx(NOISE_PX, rel=0.02)
    assert 0.002 < found.beyond_3_sigma_share < 0.0035  # Gaussian: 0.0027
    assert sum(found.histogram.x) == len(make_scene().observations.xy_px)
    assert 0 <= found.by_camera[0].systematic_px < 0.1 * NOISE_PX


def test_a_pattern_over_the_picture_is_told_from_noise(make_scene: MakeScene) -> None:
    scene = make_scene()
    right = scene.observations.xy_px[:, 0] > 600
    pattern = np.where(right, 0.15, -0.15)[:, None] * [1.0, 0.0]
    camera = residual_figures(shifted(scene, pattern)).by_camera[0]
    # RMS of one of two coordinates, of which only x is off.
    assert camera.systematic_px == pytest.approx(0.15 / np.sqrt(2), rel=0.03)
    grid = camera.grid
    mean_x = np.array(grid.mean_x_px).reshape(grid.rows, grid.columns)
    assert np.nanmean(mean_x[:, 6]) == pytest.approx(0.15, abs=0.01)
    assert np.nanmean(mean_x[:, 5]) == pytest.approx(-0.15, abs=0.01)
    assert sum(grid.observations) == len(scene.observations.xy_px)


def test_the_photo_that_fits_worse_is_named(make_scene: MakeScene) -> None:
    scene = make_scene()
    own = scene.observations.photo_idx == 4
    rng = np.random.default_rng(0)
    noise = rng.normal(size=(len(own), 2)) * np.where(own, 0.3, 0.0)[:, None]
    rows = residual_figures(shifted(scene, noise)).by_photo
    assert rows[4].name == "IMG_5.jpg"
    assert rows[4].rms_px == pytest.approx(np.hypot(0.1, 0.3), rel=0.05)
    assert max(row.rms_px for k, row in enumerate(rows) if k != 4) < 0.11


def test_rays_redundancy_and_overlap_are_counted(make_scene: MakeScene) -> None:
    scene = make_scene()
    found = network_figures(scene)
    rays = np.bincount(scene.observations.point_idx, minlength=len(scene.points_in_world))
    coordinates = 2 * len(scene.observations.xy_px)
    assert found.redundancy == coordinates - 6 * PHOTOS - 3 * len(rays) + 7
    assert found.rays.mean == pytest.approx(rays.mean())
    assert found.rays.points[:3] == tuple(int((rays == n).sum()) for n in (2, 3, 4))
    shared = np.array(found.overlap.shared_points)
    assert (shared == shared.T).all()
    assert shared.diagonal().sum() == len(scene.observations.xy_px)
    # Points lie where they truly are, not where they were adjusted to: no freedom was spent.
    spent = coordinates / found.redundancy
    assert found.sigma0_px == pytest.approx(NOISE_PX * np.sqrt(spent), rel=0.02)


def test_angles_are_those_between_the_outer_photos(make_scene: MakeScene) -> None:
    # Photos stand 30 degrees apart and look from 900 mm: three or four of them see each point.
    angles = network_figures(make_scene()).angles
    assert 58 < angles.median_deg < 100
    assert angles.narrow_share == 0
    assert sum(angles.points) == 4000


def test_point_sigma_follows_the_noise(make_scene: MakeScene) -> None:
    one = network_figures(make_scene(0.1)).point_sigma.median
    two = network_figures(make_scene(0.2)).point_sigma.median
    assert two == pytest.approx(2 * one, rel=0.02)
    pixel_mm = (900.0 - RADIUS_MM) / 1500.0
    assert 0.4 * 0.1 * pixel_mm < one < 2 * 0.1 * pixel_mm


def test_what_was_filled_counts_by_its_area(evidence: Evidence) -> None:
    mesh = tube(rings=61, spokes=80)
    filled = mesh.vertices_mm[:, 2] > 0.75 * HEIGHT_MM + 1e-6
    found = surface_figures(replace(evidence, mesh=replace(mesh, filled=filled)))
    assert found.filled_share == pytest.approx(0.25, abs=0.01)
    assert found.filled_share + found.measured_share == pytest.approx(1)
    assert found.area == pytest.approx(2 * np.pi * RADIUS_MM * HEIGHT_MM, rel=0.002)


def test_openings_are_found_where_they_are(evidence: Evidence) -> None:
    found = surface_figures(evidence).openings
    assert len(found) == 2
    for one in found:
        assert one.rim == pytest.approx(2 * np.pi * RADIUS_MM, rel=0.002)
    assert sorted(round(one.middle[2]) for one in found) == [0, 240]


def test_every_place_of_the_tube_is_seen_by_the_photos_of_its_side(evidence: Evidence) -> None:
    # 65 degrees of incidence either way, photos 30 degrees apart: four or five of them.
    found = surface_figures(evidence).photos_per_place
    assert 3.5 <= found.median <= 5
    assert found.below_3_share == 0


def test_expected_error_of_equal_and_of_mixed_sigmas() -> None:
    equal = expected_p95(np.full(50, 0.2), np.full(50, 0.02))
    assert equal == pytest.approx(1.96 * 0.2, rel=1e-3)
    mixed = expected_p95(np.array([0.1, 0.3]), np.array([0.5, 0.5]))
    inside = 0.5 * erf(mixed / 0.1 / np.sqrt(2)) + 0.5 * erf(mixed / 0.3 / np.sqrt(2))
    assert inside == pytest.approx(0.95, abs=1e-6)


def test_sigma_is_parted_into_shared_and_own(with_sigmas: Evidence) -> None:
    sigma = surface_figures(with_sigmas).sigma
    assert sigma is not None
    assert sigma.rms_mm == pytest.approx(0.1, rel=1e-5)
    assert sigma.shared_rms_mm == pytest.approx(0.06, rel=1e-5)
    assert sigma.own_rms_mm == pytest.approx(0.08, rel=1e-4)


def test_control_and_check_lengths_are_kept_apart(evidence: Evidence) -> None:
    found = length_figures(evidence)
    assert [one.label for one in found.control] == ["C-D"]
    assert found.check_worst == pytest.approx(0.0005)
    assert found.check[0].error_mm == pytest.approx(0.06)
    assert found.checked_by_another_piece is True


@pytest.mark.parametrize(
    ("control", "check", "checked"),
    [
        ("board", "board", False),
        ("board", "plate", False),
        ("plate", "plate", False),
        ("board", "points", True),
        ("plate", "points", True),
        ("points", "plate", True),
        ("points", "points", True),
        ("marks", "plate", True),  # of a rule, between stickers
        ("plate", "marks", True),
    ],
)
def test_prints_do_not_check_each_other_and_lengths_by_hand_do(
    evidence: Evidence, control: LengthEnds, check: LengthEnds, checked: bool
) -> None:
    scale, one = evidence.metric.scale, evidence.metric.scale.lengths[0]
    lengths = (
        replace(one, label="board, but by hand", between=control, role="control"),
        replace(one, label="board, but by hand", between=check, role="check"),
    )
    metric = replace(evidence.metric, scale=replace(scale, lengths=lengths))
    assert length_figures(replace(evidence, metric=metric)).checked_by_another_piece is checked


def test_lens_sigmas_and_correlation(evidence: Evidence) -> None:
    (lens,) = camera_figures(evidence)
    fx = lens.parameters[0]
    assert (fx.sigma, fx.calibrated_sigma) == (pytest.approx(0.2), pytest.approx(0.3))
    assert lens.correlations is not None
    assert lens.correlations.order == ("fx", "fy")
    assert lens.correlations.matrix[0][1] == pytest.approx(0.5)
    assert lens.parameters[5].held is True


def test_sigmas_of_poses_follow_from_their_covariance(make_scene: MakeScene) -> None:
    scene, count = make_scene(), 6 * PHOTOS + 10
    assert pose_figures(scene) is None
    shifts, turns = np.zeros(count), np.zeros(count)
    shifts[3 : 6 * PHOTOS : 6] = 0.2**2  # along the camera's own x
    turns[0 : 6 * PHOTOS : 6] = 0.001**2  # about the camera's own x
    shifted_only = pose_figures(replace(scene, camera_covariance=np.diag(shifts)))
    turned_only = pose_figures(replace(scene, camera_covariance=np.diag(turns)))
    assert shifted_only is not None
    assert turned_only is not None
    assert shifted_only.centre_median == pytest.approx(0.2)
    assert shifted_only.rotation_median_deg == 0
    # The cameras look at the world's middle from 900 mm: so far is its origin along z or beside.
    arm_mm = np.hypot(*scene.view(0).camera_from_world.translation[1:])
    assert turned_only.centre_median == pytest.approx(0.001 * arm_mm, rel=1e-6)
    assert turned_only.rotation_median_deg == pytest.approx(np.degrees(0.001))


def test_photos_that_are_gone_leave_the_noise_unknown(evidence: Evidence) -> None:
    found = image_figures(evidence)
    assert np.isnan(found.noise_grey)
    assert found.pixel == pytest.approx((900 - 0.85 * RADIUS_MM) / 1500, rel=0.02)


@pytest.mark.parametrize("sigma", [1.0, 3.0])
def test_noise_of_a_picture_is_found_beside_its_texture(sigma: float) -> None:
    rng = np.random.default_rng(5)
    y, x = np.mgrid[:700, :900]
    clean = 120 + 40 * np.sin(x / 40) * np.cos(y / 55) + 30 * ((x // 60 + y // 60) % 2)
    luma = np.clip(np.rint(clean + sigma * rng.normal(size=clean.shape)), 0, 255).astype(np.uint8)
    assert noise_grey(luma) == pytest.approx(sigma, rel=0.1)
