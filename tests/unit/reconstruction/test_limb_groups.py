"""Limb groups: photos of two limbs that a room joins are told from all others."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.limb_groups import limb_groups
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.matching.matching import Matches, PairMatches
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.synthetic import SMALL, Truth, stage_truth, surface_points
from limbgram.synthetic.truth import SurfacePoints

PHOTOS = 20
POINTS = 700
NONE = Matches(pairs=(), pairs_tried=0, descriptor_matches=0)


@pytest.fixture(scope="module")
def truth() -> Truth:
    return stage_truth(replace(SMALL, photos=PHOTOS, calibration_photos=0))


@pytest.fixture(scope="module")
def limb(truth: Truth) -> SurfacePoints:
    return surface_points(truth, POINTS)


def photo_set(truth: Truth) -> PhotoSet:
    width_px, height_px = truth.views[0].camera.width_px, truth.views[0].camera.height_px
    photos = tuple(
        Photo(
            name=view.name, path=Path(view.name), width_px=width_px, height_px=height_px,
            exif=Exif(), sha256=view.name, camera_idx=0,
        )
        for view in truth.views
    )  # fmt: skip
    group = CameraGroup(label="", width_px=width_px, height_px=height_px, exif=Exif())
    return PhotoSet(photos, (group,))


def cameras_of(truth: Truth) -> Cameras:
    known = Calibration(camera=truth.views[0].camera, covariance=np.eye(LENS_SIZE), source="board")
    return Cameras((known,))


def scene_of(truth: Truth, bodies: list[tuple[np.ndarray, np.ndarray]]) -> Scene:
    """Bodies: points, and which of the photos see which of them."""
    columns: list[tuple[np.ndarray, ...]] = []
    first = 0
    for points, shown in bodies:
        point_idx, photo_idx = np.nonzero(shown)
        xy_px = np.empty((len(point_idx), 2))
        for photo, view in enumerate(truth.views):
            rows = photo_idx == photo
            xy_px[rows] = view.project(points[point_idx[rows]])
        columns.append((photo_idx.astype(np.int32), (first + point_idx).astype(np.int32), xy_px))
        first += len(points)
    observations = Observations(*(np.concatenate(column) for column in zip(*columns, strict=True)))
    return Scene(
        names=tuple(view.name for view in truth.views),
        cameras=(truth.views[0].camera,),
        camera_idx=(0,) * PHOTOS,
        camera_from_world=tuple(view.camera_from_world for view in truth.views),
        points_in_world=np.concatenate([points for points, _ in bodies]),
        observations=observations,
        verdicts=(),
    )


def groups_of(
    truth: Truth, scene: Scene, features: Features | None = None, matches: Matches = NONE
) -> list[set[int]]:
    empty = Keypoints(
        xy_px=np.zeros((0, 2), np.float32),
        scale_px=np.zeros(0, np.float32),
        angle_deg=np.zeros(0, np.float32),
        descriptors=np.zeros((0, 128), np.uint8),
    )
    seen = features or Features((empty,) * PHOTOS)
    found = limb_groups(photo_set(truth), seen, matches, scene, cameras_of(truth))
    return [{*group} for group in found.photos]


def test_photos_of_one_limb_hang_together(truth: Truth, limb: SurfacePoints) -> None:
    assert groups_of(truth, scene_of(truth, [(limb.points_in_world, limb.seen)])) == []


def test_photos_of_two_limbs_are_parted_in_any_order(truth: Truth, limb: SurfacePoints) -> None:
    """Every other photo shows another limb of the same shape at the same place."""
    other = surface_points(truth, POINTS, seed=1)
    even = np.arange(PHOTOS) % 2 == 0
    scene = scene_of(
        truth,
        [(limb.points_in_world, limb.seen & even), (other.points_in_world, other.seen & ~even)],
    )
    found = groups_of(truth, scene)
    assert sorted(map(min, found)) == [0, 1]
    assert {0, 2, 4} <= found[0] | found[1]
    assert all(len({k % 2 for k in group}) == 1 for group in found)


def test_halves_of_a_ring_that_paint_does_not_join_are_one_limb(
    truth: Truth, limb: SurfacePoints
) -> None:
    """Their photos stand beside each other at the two ends alone."""
    other = surface_points(truth, POINTS, seed=1)
    half = np.arange(PHOTOS) < PHOTOS / 2
    scene = scene_of(
        truth,
        [(limb.points_in_world, limb.seen & half), (other.points_in_world, other.seen & ~half)],
    )
    assert groups_of(truth, scene) == []


def test_a_few_matches_that_err_hide_nothing(truth: Truth, limb: SurfacePoints) -> None:
    other = surface_points(truth, POINTS, seed=1)
    even = np.arange(PHOTOS) % 2 == 0
    shown = limb.seen & even
    shown[:3] = limb.seen[:3]
    scene = scene_of(
        truth, [(limb.points_in_world, shown), (other.points_in_world, other.seen & ~even)]
    )
    assert len(groups_of(truth, scene)) == 2


@pytest.mark.parametrize(("turn_deg", "groups"), [(2.0, 0), (100.0, 2)])
def test_a_limb_that_shifted_is_one_and_one_that_was_turned_two(
    truth: Truth, limb: SurfacePoints, turn_deg: float, groups: int
) -> None:
    """The second half of two rounds shows it elsewhere; its matches contradict the scene."""
    middle = limb.points_in_world.mean(0)
    turn = Rigid.from_rotation_vector(np.radians([0.0, 0.0, turn_deg]), np.zeros(3))
    shift = np.array([12.0, -9.0, 0.0])
    moved = turn.apply(limb.points_in_world - middle) + middle + shift
    normals = turn.apply(limb.normals_in_world)
    seen = np.stack(
        [
            np.einsum("ij,ij->i", normals, view.centre_in_world - moved) > 0.2 * 1400.0
            for view in truth.views
        ],
        axis=1,
    )
    even = np.arange(PHOTOS) % 2 == 0
    scene = scene_of(truth, [(limb.points_in_world, limb.seen & even), (moved, seen & ~even)])
    places = [
        view.project(limb.points_in_world if k % 2 == 0 else moved)
        for k, view in enumerate(truth.views)
    ]
    shown = np.where(even, limb.seen, seen)
    keypoints = tuple(
        Keypoints(
            xy_px=xy_px.astype(np.float32),
            scale_px=np.full(POINTS, 2.0, np.float32),
            angle_deg=np.zeros(POINTS, np.float32),
            descriptors=np.zeros((POINTS, 128), np.uint8),
        )
        for xy_px in places
    )
    pairs: list[PairMatches] = []
    for first in range(PHOTOS):
        for second in range(first + 1, PHOTOS):
            both = np.flatnonzero(shown[:, first] & shown[:, second])
            if len(both) >= 16:
                pairs.append(
                    PairMatches(
                        first=first,
                        second=second,
                        keypoint_idx=np.column_stack([both, both]).astype(np.int32),
                        xy_first_px=places[first][both],
                        xy_second_px=places[second][both],
                        correlation=np.ones(len(both), np.float32),
                    )
                )
    matches = replace(NONE, pairs=tuple(pairs))
    found = groups_of(truth, scene, features=Features(keypoints), matches=matches)
    assert len(found) == groups
