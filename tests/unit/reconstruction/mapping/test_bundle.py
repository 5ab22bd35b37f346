"""The bundle: what it makes of a scene, its steps, and what it drops."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from limbgram.core.geometry.lens import LENS_SIZE
from limbgram.reconstruction.mapping.bundle import Bundle
from limbgram.reconstruction.mapping.scene import Observations, Scene

MakeScene = Callable[..., Scene]


def test_a_bundle_gives_its_scene_back(make_scene: MakeScene) -> None:
    """Sorted by point; photos without a pose and their observations stay out."""
    scene = make_scene(noise_px=1.0)
    poses = list(scene.camera_from_world)
    poses[1] = None
    scene = replace(scene, camera_from_world=tuple(poses))
    bundle = Bundle.of(scene)
    given = scene.observations
    expected = sorted(
        (int(point), int(photo), *xy)
        for photo, point, xy in zip(given.photo_idx, given.point_idx, given.xy_px.tolist())
        if photo != 1
    )
    again = bundle.scene(scene).observations
    found = zip(again.point_idx.tolist(), again.photo_idx.tolist(), *again.xy_px.T.tolist())
    assert list(found) == expected
    for before, after in zip(scene.views, bundle.scene(scene).views):
        np.testing.assert_array_equal(before.packed, after.packed)
    for k, first in enumerate(bundle.bounds[:-1]):
        np.testing.assert_array_equal(bundle.point_idx[first : bundle.bounds[k + 1]], k)


def test_a_step_turns_shifts_and_refines(make_scene: MakeScene) -> None:
    """Turn in the camera's frame by the matrix exponential; each lens by its own ten numbers."""
    scene = make_scene()
    bundle, random = Bundle.of(scene), np.random.default_rng(1)
    step = random.normal(0, 0.1, bundle.unknowns)
    points = random.normal(size=bundle.points.shape)
    after = bundle.moved(step, points)
    np.testing.assert_array_equal(after.points, bundle.points + points)
    for k, view in enumerate(scene.views):
        x, y, z = step[6 * k : 6 * k + 3]
        turn = expm(np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]))
        rotation = turn @ view.camera_from_world.rotation
        np.testing.assert_allclose(after.views[k, :9].reshape(3, 3), rotation, atol=1e-12)
        shift = view.camera_from_world.translation + step[6 * k + 3 : 6 * k + 6]
        np.testing.assert_allclose(after.views[k, 9:12], shift)
        first = 6 * len(scene.views) + LENS_SIZE * scene.camera_idx[k]
        lens = view.camera.packed + step[first : first + LENS_SIZE]
        np.testing.assert_allclose(after.views[k, 12:], lens)


def widest_angle_deg(scene: Scene, point: int) -> float:
    """Between its first ray, in the order of the photos, and the ray farthest from that."""
    seen = scene.observations
    photos = sorted(seen.photo_idx[seen.point_idx == point].tolist())
    rays = [scene.view(photo).centre_in_world - scene.points_in_world[point] for photo in photos]
    rays = [ray / np.linalg.norm(ray) for ray in rays]
    return max((float(np.degrees(np.arccos(min(ray @ rays[0], 1)))) for ray in rays), default=0.0)


def test_angles_are_those_between_rays(make_scene: MakeScene) -> None:
    scene = make_scene(photos=9, points=15, share=0.4)
    expected = [widest_angle_deg(scene, k) for k in range(15)]
    np.testing.assert_allclose(Bundle.of(scene).widest_angle_deg(), expected, atol=1e-5)


def test_outliers_go_and_points_that_are_left_weak_with_them(make_scene: MakeScene) -> None:
    scene = make_scene(photos=9, points=40, share=0.35)
    random, seen = np.random.default_rng(3), scene.observations
    wrong = random.random(len(seen.xy_px)) < 0.25
    xy = seen.xy_px + np.where(wrong[:, None], 8.0, 0.0)
    scene = replace(scene, observations=Observations(seen.photo_idx, seen.point_idx, xy))
    kept = Bundle.of(scene).without_outliers(scene, 1.25, 4.0)
    good = [
        (int(point), int(photo))
        for photo, point, bad in zip(seen.photo_idx, seen.point_idx, wrong)
        if not bad
    ]
    rays = {k: sum(point == k for point, _ in good) for k in range(40)}
    left = [k for k in range(40) if rays[k] >= 2]
    assert 0 < len(left) < 40
    expected = sorted((left.index(point), photo) for point, photo in good if point in left)
    assert list(zip(kept.point_idx.tolist(), kept.photo_idx.tolist())) == expected
    np.testing.assert_array_equal(kept.points, scene.points_in_world[left])


@pytest.mark.parametrize("noise_px", [0.1, 0.5])
def test_sigma_is_that_of_the_measurements(make_scene: MakeScene, noise_px: float) -> None:
    """About points of the least squares residuals lie below errors; the median makes up for it."""
    scene = make_scene(photos=8, points=300, noise_px=noise_px, share=1.0)
    # Cameras are exact and points too: residuals are the errors, which sigma takes for residuals.
    expected = noise_px / np.sqrt((2 * 8 - 3) / (2 * 8))
    assert Bundle.of(scene).sigma_px(scene) == pytest.approx(expected, rel=0.05)
