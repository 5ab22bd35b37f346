"""Resection: the pose of a photo from known points, also among wrong ones."""

from collections.abc import Callable

import numpy as np
import pytest

from limbgram.reconstruction.mapping.resection import resect
from limbgram.reconstruction.mapping.scene import Scene

MakeScene = Callable[..., Scene]


@pytest.mark.parametrize("wrong", [0, 12])
def test_resection_finds_the_pose_also_among_wrong_points(
    make_scene: MakeScene, wrong: int
) -> None:
    scene = make_scene(photos=3, points=40, share=1.0)
    view = scene.views[1]
    xy = view.project(scene.points_in_world)
    xy[:wrong] += np.random.default_rng(1).uniform(20, 60, (wrong, 2))
    pose = resect(view.camera, scene.points_in_world, xy)
    assert pose is not None
    np.testing.assert_allclose(pose.rotation, view.camera_from_world.rotation, atol=1e-6)
    np.testing.assert_allclose(pose.translation, view.camera_from_world.translation, atol=1e-3)


def test_five_points_are_too_few(make_scene: MakeScene) -> None:
    scene = make_scene(photos=3, points=40, share=1.0)
    points = scene.points_in_world[:5]
    assert resect(scene.views[0].camera, points, scene.views[0].project(points)) is None
