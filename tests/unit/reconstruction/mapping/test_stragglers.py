"""Photos that share many points with one photo and few with two: placed by turn and few points."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.unit.reconstruction.mapping.conftest import described

from limbgram.core.geometry.frames import Rigid, angle_between_deg, fit_similarity
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.mapping import stragglers
from limbgram.reconstruction.mapping.bundle_adjustment import rotation_sigma_deg
from limbgram.reconstruction.mapping.placement import place, without_photos
from limbgram.reconstruction.mapping.scene import OwnLenses, Scene
from limbgram.reconstruction.mapping.stragglers import with_stragglers
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

MakeScene = Callable[..., Scene]
MakePair = Callable[..., VerifiedPair]
NOISE_PX = 0.1
SHARED = np.arange(100)
"""Points that photos 0 to 5 show."""
DEVIATION_SIZE = np.arange(100, 180)
"""Points that photos 5 and 6 show; photo 4 shows the first of them."""
BEYOND = np.arange(180, 240)
"""Points that photos 6 and 0 show, and no other."""


@pytest.fixture
def ring(make_scene: MakeScene) -> Scene:
    """Seven photos in steps of 51 degrees, by one lens."""
    scene = make_scene(photos=7, points=240, share=1.0)
    lens = scene.cameras[0].pinhole
    return replace(scene, cameras=(lens,), camera_idx=(0,) * 7)


@pytest.fixture
def photographed(make_pair: MakePair) -> Callable[..., Scene]:
    """The ring placed by its matches, of which photo 6 has so many with points of the scene.

    Args of the function: the ring; these points; whether its matches with photo 5 are right.
    """

    def placed(ring: Scene, third: int, *, right: bool = True) -> Scene:
        rng = np.random.default_rng(3)
        places = [one.project(ring.points_in_world) for one in ring.views]
        places = [one + rng.normal(0.0, NOISE_PX, one.shape) for one in places]
        if not right:
            places[6][DEVIATION_SIZE] = _astray(ring, rng)
        rows = [(k, m, SHARED) for k in range(5) for m in (k + 1, k + 2) if m < 6]
        rows[rows.index((4, 5, SHARED))] = (4, 5, np.r_[SHARED, DEVIATION_SIZE[:third]])
        pairs = [_pair(ring, places, make_pair, *one) for one in (*rows, (5, 6, DEVIATION_SIZE))]
        features = Features(tuple(map(described, places)))
        return place(_photos(ring), features, Pairs(tuple(pairs), 0), _cameras(ring))

    return placed


def _astray(ring: Scene, rng: np.random.Generator) -> np.ndarray:
    """Places in photo 6 on the epipolar lines of other points: right for the pair, and nothing."""
    elsewhere = ring.points_in_world[DEVIATION_SIZE]
    toward = elsewhere - ring.view(5).centre_in_world
    far = 1.0 + rng.uniform(-0.15, 0.15, (len(DEVIATION_SIZE), 1))
    return ring.view(6).project(ring.view(5).centre_in_world + far * toward)


def _pair(
    ring: Scene,
    places: list[np.ndarray],
    make_pair: MakePair,
    first: int,
    second: int,
    rows: np.ndarray,
) -> VerifiedPair:
    poses = [ring.view(k).camera_from_world for k in (first, second)]
    turn = poses[1] @ poses[0].inverse
    unit = Rigid(turn.rotation, turn.translation / np.linalg.norm(turn.translation))
    ends = places[first][rows], places[second][rows]
    return make_pair(first, second, np.column_stack([rows, rows]), unit, xy_px=ends)


def _photos(ring: Scene) -> PhotoSet:
    wide, high = 900, 700
    photos = tuple(
        Photo(
            name=one,
            path=Path(one),
            sha256="",
            camera_idx=0,
            width_px=wide,
            height_px=high,
            exif=Exif(),
        )
        for one in ring.names
    )
    return PhotoSet(photos, (CameraGroup(label="", width_px=wide, height_px=high, exif=Exif()),))


def _cameras(ring: Scene) -> Cameras:
    lens = ring.cameras[0]
    held = np.zeros((LENS_SIZE, LENS_SIZE))
    return Cameras((Calibration(camera=lens, covariance=held, source="board"),))


def turned_deg(found: Scene, ring: Scene) -> float:
    """How far photo 6 is turned against photo 5 otherwise than in truth."""
    one, other = (
        scene.view(6).camera_from_world.rotation @ scene.view(5).camera_from_world.rotation.T
        for scene in (found, ring)
    )
    return angle_between_deg(one, other)


def test_ten_points_and_a_pair_place_a_photo(
    ring: Scene, photographed: Callable[..., Scene]
) -> None:
    found = photographed(ring, 10)
    assert found.placed == tuple(range(7))
    assert 1e-4 < turned_deg(found, ring) < 0.1
    assert all(one.reason is None for one in found.verdicts)
    step = [
        np.linalg.norm(scene.view(6).centre_in_world - scene.view(5).centre_in_world)
        / np.linalg.norm(scene.view(5).centre_in_world - scene.view(4).centre_in_world)
        for scene in (found, ring)
    ]
    assert step[0] == pytest.approx(step[1], rel=0.005)


@pytest.fixture
def met(make_pair: MakePair) -> Callable[..., Scene]:
    """The ring placed by its matches, of which photo 6 has some with 5 and 0 and no third photo.

    Args of the function: the ring; by how much photos 5 and 0 show photo 6 turned about the limb.
    """

    def placed(ring: Scene, turned_deg: tuple[float, float]) -> Scene:
        rng = np.random.default_rng(3)
        places = [one.project(ring.points_in_world) for one in ring.views]
        turned = [_turned_about_the_limb(ring, 6, deg) for deg in turned_deg]
        for shown, points in zip(turned, (DEVIATION_SIZE, BEYOND), strict=True):
            places[6][points] = shown.view(6).project(ring.points_in_world[points])
        places = [one + rng.normal(0.0, NOISE_PX, one.shape) for one in places]
        rows = [(k, m, SHARED) for k in range(5) for m in (k + 1, k + 2) if m < 6]
        pairs = [_pair(ring, places, make_pair, *one) for one in rows]
        pairs.append(_pair(turned[0], places, make_pair, 5, 6, DEVIATION_SIZE))
        pairs.append(_pair(turned[1], places, make_pair, 0, 6, BEYOND))
        features = Features(tuple(map(described, places)))
        return place(_photos(ring), features, Pairs(tuple(pairs), 0), _cameras(ring))

    return placed


def _turned_about_the_limb(ring: Scene, photo: int, deg: float) -> Scene:
    """As if the limb had turned before one photo, about a slanting axis."""
    turn = Rotation.from_rotvec(np.radians(deg) * np.array([0.6, 0.0, 0.8])).as_matrix()
    poses = list(ring.camera_from_world)
    poses[photo] = ring.view(photo).camera_from_world @ Rigid(turn, np.zeros(3))
    return replace(ring, camera_from_world=tuple(poses))


def test_two_pairs_whose_steps_meet_place_a_photo(ring: Scene, met: Callable[..., Scene]) -> None:
    found = met(ring, (0.0, 0.0))
    assert found.placed == tuple(range(7))
    assert 1e-4 < turned_deg(found, ring) < 0.1
    steps = np.array([_steps_of_photo_6(scene) for scene in (found, ring)])
    assert steps[0] == pytest.approx(steps[1], rel=0.005)


@pytest.mark.parametrize(
    "deg",
    [
        (0.0, 3.0),
        (-5.0, 9.0),
        *(pytest.param(one, marks=pytest.mark.slow) for one in ((0.0, 10.0), (0.0, 60.0))),
    ],
)
def test_a_photo_that_two_pairs_turn_otherwise_stays_out(
    ring: Scene, met: Callable[..., Scene], deg: tuple[float, float]
) -> None:
    found = met(ring, deg)
    assert found.placed == tuple(range(6))
    assert [k for k, one in enumerate(found.verdicts) if one.reason is not None] == [6]


GROUP = (6, 7, 8)
"""Photos that share points among each other,"""
THEIRS = np.arange(240, 320)
"""these,"""
BRIDGES = np.arange(100, 150), np.arange(150, 200)
"""and these with photo 5, and with photo 0."""


@pytest.fixture
def bridged(make_scene: MakeScene, make_pair: MakePair) -> Callable[..., tuple[Scene, Scene]]:
    """Nine photos in truth, and placed by their matches: six, and a group bridged at both ends.

    Args of the function: by how much photos 5 and 0 show the group turned about the limb.
    """

    def placed(turned_deg: tuple[float, float]) -> tuple[Scene, Scene]:
        scene = make_scene(photos=9, points=320, share=1.0)
        ring = replace(scene, cameras=(scene.cameras[0].pinhole,), camera_idx=(0,) * 9)
        rng = np.random.default_rng(3)
        places = [one.project(ring.points_in_world) for one in ring.views]
        ends = ((5, 6), (0, 8))
        turned = [
            _turned_about_the_limb(ring, inner, deg)
            for (_, inner), deg in zip(ends, turned_deg, strict=True)
        ]
        for shown, points, (_, inner) in zip(turned, BRIDGES, ends, strict=True):
            places[inner][points] = shown.view(inner).project(ring.points_in_world[points])
        places = [one + rng.normal(0.0, NOISE_PX, one.shape) for one in places]
        rows = [(k, m, SHARED) for k in range(5) for m in (k + 1, k + 2) if m < 6]
        rows += [(k, m, THEIRS) for k, m in ((6, 7), (7, 8), (6, 8))]
        pairs = [_pair(ring, places, make_pair, *one) for one in rows]
        pairs += [
            _pair(shown, places, make_pair, *end, points)
            for shown, end, points in zip(turned, ends, BRIDGES, strict=True)
        ]
        features = Features(tuple(map(described, places)))
        return ring, place(_photos(ring), features, Pairs(tuple(pairs), 0), _cameras(ring))

    return placed


def test_photos_of_a_smaller_scene_join_by_two_pairs(
    bridged: Callable[..., tuple[Scene, Scene]],
) -> None:
    ring, found = bridged((0.0, 0.0))
    assert found.placed == tuple(range(9))
    centres, true = (
        np.array([view.centre_in_world for view in one.views]) for one in (found, ring)
    )
    to_truth = fit_similarity(centres, true)
    off = np.linalg.norm(to_truth.apply(centres) - true, axis=1)
    assert off.max() < 0.003 * np.linalg.norm(true - true.mean(0), axis=1).mean()
    for photo in GROUP:
        seen, truly = (one.view(photo).camera_from_world.rotation for one in (found, ring))
        assert angle_between_deg(seen @ to_truth.rotation.T, truly) < 0.1


@pytest.mark.parametrize(
    "deg",
    [
        (0.0, 4.0),
        (-5.0, 9.0),
        *(pytest.param(one, marks=pytest.mark.slow) for one in ((0.0, 10.0), (0.0, 60.0))),
    ],
)
def test_photos_of_a_smaller_scene_that_pairs_turn_otherwise_stay_out(
    bridged: Callable[..., tuple[Scene, Scene]], deg: tuple[float, float]
) -> None:
    _, found = bridged(deg)
    assert found.placed == tuple(range(6))
    assert [k for k, one in enumerate(found.verdicts) if one.reason is not None] == [*GROUP]


def _steps_of_photo_6(scene: Scene) -> list[float]:
    """From its two neighbours, over the step between two others."""
    centres = [one.centre_in_world for one in scene.views]
    other = np.linalg.norm(centres[3] - centres[2])
    return [float(np.linalg.norm(centres[6] - centres[k]) / other) for k in (5, 0)]


@pytest.mark.parametrize(
    ("third", "right"), [(3, True), (10, False), pytest.param(40, False, marks=pytest.mark.slow)]
)
def test_what_chance_may_do_places_no_photo(
    ring: Scene, photographed: Callable[..., Scene], third: int, right: bool
) -> None:
    """Three points that agree, or forty matches that lie on their epipolar lines and are wrong."""
    found = photographed(ring, third, right=right)
    assert found.placed == tuple(range(6))
    assert [k for k, one in enumerate(found.verdicts) if one.reason is not None] == [6]


def test_a_photo_is_looked_at_once_while_the_scene_stays(
    ring: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of three that look right the second stays; in the scene with it the other two do not."""
    poses = (*ring.camera_from_world[:4], None, None, None)
    looked, tried = list[int](), list[int]()

    def likeliest(photo: int, *_: Any) -> stragglers.ResectedPose:
        looked.append(photo)
        pose = ring.camera_from_world[photo]
        assert pose is not None
        return stragglers.ResectedPose(photo, pose, np.arange(60), 40 + photo, 500.0)

    def joined(place: stragglers.ResectedPose, scene: Scene, *_: Any) -> Scene | None:
        tried.append(place.photo)
        found = [*scene.camera_from_world]
        found[place.photo] = place.camera_from_world
        return replace(scene, camera_from_world=tuple(found)) if place.photo == 5 else None

    monkeypatch.setattr(stragglers, "_best_resection", likeliest)
    monkeypatch.setattr(stragglers, "_with_candidate", joined)
    left_out = replace(ring, camera_from_world=poses, sigma_px=0.1)
    found = with_stragglers(left_out, (), Pairs((), 0), (), lambda scene: scene)
    assert found.placed == (0, 1, 2, 3, 5)
    assert tried == [6, 5, 6, 4]
    assert looked == [4, 5, 6, 4, 6]


def test_a_photo_that_loses_all_its_points_stays_out(
    ring: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The adjustment takes it out. What was known is of six photos with lenses of their own."""

    def likeliest(photo: int, *_: Any) -> stragglers.ResectedPose:
        pose = ring.view(photo).camera_from_world
        return stragglers.ResectedPose(photo, pose, np.arange(60), 40, 500.0)

    monkeypatch.setattr(stragglers, "_best_resection", likeliest)
    poses = (*ring.camera_from_world[:6], None)
    known = np.eye(6 * (POSE_SIZE + LENS_SIZE))
    scene = replace(
        ring,
        camera_from_world=poses,
        camera_covariance=known,
        own=_own(np.zeros((7, LENS_SIZE))),
        sigma_px=0.1,
    )
    lost = partial(without_photos, photos={6})
    assert with_stragglers(scene, (), Pairs((), 0), (), lost).placed == tuple(range(6))


def test_a_turn_is_known_as_well_as_its_pixels_tell_it(make_scene: MakeScene) -> None:
    """By differences of the pixels, the points known, each coordinate counted as three times as
    unsure as its noise: neighbours share errors. Unknown points and robust weights add a half."""
    scene = make_scene(photos=6, points=60, noise_px=NOISE_PX, share=1.0)
    view, step = scene.view(3), 1e-6
    in_camera = view.camera_from_world.apply(scene.points_in_world)
    turned = [np.cross(one, in_camera) for one in np.eye(3)]
    moved = [np.broadcast_to(one, in_camera.shape) for one in np.eye(3)]
    slopes = [
        (view.camera.project(in_camera + step * one) - view.camera.project(in_camera)) / step
        for one in (*turned, *moved)
    ]
    by_pose = np.reshape(slopes, (6, -1))
    known = np.linalg.inv(by_pose @ by_pose.T)[:3, :3] * (3 * NOISE_PX) ** 2
    least_deg = np.degrees(np.sqrt(np.linalg.eigvalsh(known)[-1]))
    assert least_deg < rotation_sigma_deg(scene, 3) < 2.0 * least_deg


def test_a_turn_is_as_well_known_where_photos_have_lenses_of_their_own(
    make_scene: MakeScene,
) -> None:
    """A stabiliser shifts the picture of each photo by some pixels: the noise stays what it is."""
    alike = make_scene(photos=6, points=60, noise_px=NOISE_PX, share=1.0)
    shifts = np.zeros((6, LENS_SIZE))
    shifts[:, 2:4] = np.random.default_rng(5).normal(0.0, 5.0, (6, 2))
    seen = alike.observations
    moved = replace(seen, xy_px=seen.xy_px + shifts[seen.photo_idx, 2:4])
    own = _own(shifts)
    stabilised = replace(alike, observations=moved, own=own)
    assert rotation_sigma_deg(stabilised, 3) == pytest.approx(
        rotation_sigma_deg(alike, 3), rel=0.05
    )


def _own(shifts: np.ndarray) -> OwnLenses:
    none = np.zeros((len(shifts), 0))
    return OwnLenses(deviations=(), values=none, spread=none[0], shifts=shifts, chances=())


def test_a_turn_is_known_as_well_as_its_points_are_spread(make_scene: MakeScene) -> None:
    """Eight points tell it by the root of 60 / 8 less sharply than sixty do."""
    scene = make_scene(photos=6, points=60, noise_px=NOISE_PX, share=1.0)
    seen = scene.observations
    narrow = (seen.photo_idx != 3) | (seen.point_idx < 8)
    wide_deg, narrow_deg = (
        rotation_sigma_deg(one, 3)
        for one in (scene, replace(scene, observations=seen.some(narrow)))
    )
    assert narrow_deg == pytest.approx(wide_deg * np.sqrt(60 / 8), rel=0.6)
