"""The classical chain: resection, links, and refusals; its accuracy stands in tests/truth."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.mapping.chain import chain, resect
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

MakeScene = Callable[..., Scene]
MakePair = Callable[..., VerifiedPair]


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


def photos_of(scene: Scene) -> tuple[PhotoSet, Cameras]:
    sizes = {"width_px": 900, "height_px": 700, "exif": Exif()}
    photos = tuple(
        Photo(name=name, path=Path(name), sha256="", camera_idx=idx, **sizes)
        for name, idx in zip(scene.names, scene.camera_idx)
    )
    calibrations = tuple(
        Calibration(
            label="",
            source="board",
            camera=lens,
            covariance=np.zeros((LENS_SIZE, LENS_SIZE)),
            rms_px=0.1,
        )
        for lens in scene.cameras
    )
    return PhotoSet(photos, (CameraGroup(label="", **sizes),) * 2), Cameras(calibrations)


def links(scene: Scene, make_pair: MakePair, count: int) -> list[VerifiedPair]:
    """Exact matches of all points between neighbours; keypoint k of a photo is point k."""
    found = []
    rows = np.tile(np.arange(len(scene.points_in_world))[:, None], 2)
    for k in range(count):
        views = scene.view(k), scene.view(k + 1)
        pose = views[1].camera_from_world @ views[0].camera_from_world.inverse
        unit = Rigid(pose.rotation, pose.translation / np.linalg.norm(pose.translation))
        xy_px = tuple(view.project(scene.points_in_world) for view in views)
        found.append(make_pair(k, k + 1, rows, unit, xy_px=xy_px))
    return found


def test_exact_matches_give_the_exact_chain(make_scene: MakeScene, make_pair: MakePair) -> None:
    scene = make_scene(photos=9, points=40, share=1.0)
    photos, cameras = photos_of(scene)
    found = chain(photos, Pairs(tuple(links(scene, make_pair, 8)), ()), cameras)
    first = scene.views[0].camera_from_world
    step = np.linalg.norm(scene.views[1].centre_in_world - scene.views[0].centre_in_world)
    for ours, true in zip(found.views, scene.views, strict=True):
        relative = true.camera_from_world @ first.inverse
        np.testing.assert_allclose(ours.camera_from_world.rotation, relative.rotation, atol=1e-5)
        np.testing.assert_allclose(
            ours.camera_from_world.translation, relative.translation / step, atol=1e-4
        )
    for points in found.points_in_world:
        expected = first.apply(scene.points_in_world) / step
        np.testing.assert_allclose(points, expected, atol=1e-4)


def test_a_missing_link_and_a_start_without_a_step_are_refused(
    make_scene: MakeScene, make_pair: MakePair
) -> None:
    scene = make_scene(photos=4, points=40, share=1.0)
    photos, cameras = photos_of(scene)
    whole = links(scene, make_pair, 3)
    with pytest.raises(PlacementError, match=r"1\.jpg and 2\.jpg do not match"):
        chain(photos, Pairs((whole[0], whole[2]), ()), cameras)
    still = make_pair(0, 1, np.zeros((9, 2)), None, kind="rotation")
    with pytest.raises(PlacementError, match=r"0\.jpg and 1\.jpg were taken from one spot"):
        chain(photos, Pairs((still, *whole[1:]), ()), cameras)
    few = make_pair(2, 3, np.zeros((3, 2)), None, xy_px=(np.zeros((3, 2)), np.zeros((3, 2))))
    with pytest.raises(PlacementError, match=r"join 3\.jpg to the photos before it"):
        chain(photos, Pairs((*whole[:2], few), ()), cameras)
