"""Choosing neighbours on a ring of photos 24 degrees apart."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import View
from limbgram.reconstruction.dense.region import Region
from limbgram.reconstruction.dense.source_views import SourceViewOptions, select_source_views
from limbgram.reconstruction.scale.metric import MetricScene

BOX = Region(
    origin_mm=np.array([-60.0, -60.0, 30.0]), cell_mm=10.0, occupied=np.ones((12, 12, 27), bool)
)


def add_view(metric: MetricScene, pose: Rigid | None) -> MetricScene:
    scene = replace(
        metric.scene,
        names=(*metric.scene.names, "extra.jpg"),
        camera_idx=(*metric.scene.camera_idx, 0),
        camera_from_world=(*metric.scene.camera_from_world, pose),
    )
    return replace(metric, scene=scene)


def test_both_sides_come_first(metric: MetricScene) -> None:
    neighbours = select_source_views(metric, BOX)
    for k, chosen in enumerate(neighbours):
        assert set(chosen[:2]) == {(k - 1) % 15, (k + 1) % 15}
        assert 2 <= len(chosen) <= 4
        steps = [(other - k + 7) % 15 - 7 for other in chosen]
        assert np.abs(steps).max() <= 2


def test_the_same_place_twice_tells_no_depth(metric: MetricScene, views: tuple[View, ...]) -> None:
    pose = views[0].camera_from_world
    twin = Rigid(pose.rotation, pose.translation + np.array([5.0, 0.0, 0.0]))
    neighbours = select_source_views(add_view(metric, twin), BOX)
    assert 15 not in neighbours[0]
    assert 15 in neighbours[1]


def test_a_photo_that_is_not_placed_has_and_is_no_neighbour(metric: MetricScene) -> None:
    neighbours = select_source_views(add_view(metric, None), BOX)
    assert neighbours[15] == ()
    assert all(15 not in chosen for chosen in neighbours)


@pytest.mark.parametrize("most", [1, 3])
def test_no_more_than_asked_for(metric: MetricScene, most: int) -> None:
    neighbours = select_source_views(metric, BOX, SourceViewOptions(most=most))
    assert max(len(chosen) for chosen in neighbours) == min(most, 2)


def test_a_far_photo_comes_after_a_near_one(metric: MetricScene, views: tuple[View, ...]) -> None:
    """From the same side as photo 1, three times as far away."""
    centre = 3 * views[1].centre_in_world - 2 * np.array([0.0, 0.0, 160.0])
    far = Rigid.looking_at(centre, np.array([0.0, 0.0, 160.0]), np.array([0.0, 0.0, 1.0]))
    chosen = select_source_views(add_view(metric, far), BOX)[0]
    assert set(chosen[:2]) == {1, 14}
