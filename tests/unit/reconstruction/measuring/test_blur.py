"""Where blurred photos show a round surface: closed forms for a ball and a saddle."""

import numpy as np

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.measuring.imagery import apparent_lift_mm
from limbgram.reconstruction.measuring.measurement_pass import _FACE_POINTS
from limbgram.reconstruction.measuring.thin_plate import tangent_axes

CAMERA = Camera(width_px=400, height_px=300, fx=1000.0, fy=1000.0, cx=199.5, cy=149.5)
DISTANCE_MM, RADIUS_MM = 800.0, 50.0
UP = np.array([0.0, 0.0, 1.0])


def lift_mm(incidence_deg: float, quadric: list[float], azimuth_deg: float = 0.0) -> float:
    """Of one vertex at the origin, its normal up."""
    slant, turn = np.radians([incidence_deg, azimuth_deg])
    away = np.array([np.sin(slant) * np.cos(turn), np.sin(slant) * np.sin(turn), np.cos(slant)])
    side = np.array([0.0, 1.0, 0.0]) if abs(away[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    view = View("a", CAMERA, Rigid.looking_at(DISTANCE_MM * away, np.zeros(3), side))
    axes = tangent_axes(UP[None])
    found = apparent_lift_mm(
        np.zeros((1, 3)),
        axes,
        np.array([quadric]),
        view.packed[None],
        np.array([[0, -1]], np.int32),
    )
    assert found[0, 1] == 0.0
    return float(found[0, 0])


def test_a_ball_sinks_by_its_curvature_and_more_at_a_slant() -> None:
    squarely = lift_mm(0.0, [-1 / RADIUS_MM, 0.0, -1 / RADIUS_MM])
    pixel_mm = DISTANCE_MM / CAMERA.fx
    assert -0.36 * pixel_mm**2 / RADIUS_MM < squarely < -0.05 * pixel_mm**2 / RADIUS_MM
    steeply = lift_mm(60.0, [-1 / RADIUS_MM, 0.0, -1 / RADIUS_MM])
    np.testing.assert_allclose(steeply / squarely, (2 + np.tan(np.radians(60)) ** 2) / 2, rtol=1e-6)


def test_a_saddle_seen_squarely_stays_and_a_hollow_rises() -> None:
    assert abs(lift_mm(0.0, [-0.02, 0.0, 0.02])) < 1e-9
    assert lift_mm(0.0, [0.02, 0.0, 0.02]) > 1e-4


def test_only_the_bend_along_the_ray_counts_at_a_slant() -> None:
    """A cylinder along y: a ray that leans along y sees it as a square one does."""
    axes = tangent_axes(UP[None])[0]
    along_x = np.outer(axes[:2] @ [1.0, 0.0, 0.0], axes[:2] @ [1.0, 0.0, 0.0]) / -RADIUS_MM
    quadric = [along_x[0, 0], along_x[0, 1], along_x[1, 1]]
    squarely = lift_mm(0.0, quadric)
    np.testing.assert_allclose(lift_mm(60.0, quadric, 90.0), squarely, rtol=1e-6)
    np.testing.assert_allclose(lift_mm(60.0, quadric, 0.0), 4 * squarely, rtol=1e-6)


def test_samples_of_a_face_see_a_round_surface_as_the_whole_face_does() -> None:
    a, b, c = _FACE_POINTS.T
    np.testing.assert_allclose(a + b + c, 1.0)
    np.testing.assert_allclose((a * b + b * c + c * a).mean(), 0.25, atol=1e-12)
