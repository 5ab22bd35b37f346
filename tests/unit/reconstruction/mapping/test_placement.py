"""The ring's gaps and bridges, photos that must not stay, and scenes that are too small."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE
from limbgram.findings import told
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.mapping.placement import (
    MappingOptions,
    _misplaced,
    _refuse_too_few,
    readjusted,
    ring_of,
    without_photos,
)
from limbgram.reconstruction.mapping.scene import Observations, OwnLenses, PhotoVerdict, Scene
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

MakeScene = Callable[..., Scene]


@pytest.fixture
def agreeing_pair(make_pair: Callable[..., VerifiedPair]) -> Callable[..., VerifiedPair]:
    """What the scene's poses say of a pair, turned by so much about the second's z axis."""

    def pair(scene: Scene, first: int, second: int, turn_deg: float = 0.0) -> VerifiedPair:
        views = scene.view(first), scene.view(second)
        pose = views[1].camera_from_world @ views[0].camera_from_world.inverse
        wrong = Rigid.from_rotation_vector(np.array([0.0, 0.0, np.radians(turn_deg)]), np.zeros(3))
        return make_pair(first, second, np.zeros((30, 2)), wrong @ pose)

    return pair


def test_a_ring_of_even_steps_is_closed(make_scene: MakeScene) -> None:
    ring = ring_of(make_scene(photos=12, points=60, share=1.0))
    assert ring.largest_gap_deg == pytest.approx(30.0, abs=4.0)  # seen from the points' median
    assert ring.weakest_bridge == 60
    assert ring.closed


def test_a_gap_is_as_wide_as_the_photos_that_lack(make_scene: MakeScene) -> None:
    scene = without_photos(make_scene(photos=12, points=60, share=1.0), {4, 5})
    assert scene.placed == (0, 1, 2, 3, 6, 7, 8, 9, 10, 11)
    assert not np.isin(scene.observations.photo_idx, [4, 5]).any()
    ring = ring_of(scene)
    assert ring.largest_gap_deg == pytest.approx(90.0, abs=8.0)
    assert not ring.closed


@pytest.mark.parametrize("own", [False, True])
def test_the_covariance_of_photos_without_a_place_leaves_with_them(
    make_scene: MakeScene, own: bool
) -> None:
    """Six numbers a photo, then ten of the one lens or of each photo's."""
    scene = make_scene(photos=4, points=60, share=1.0)
    lenses = OwnLenses(
        deviations=("focal length",),
        values=np.zeros((4, 1)),
        spread=np.zeros(1),
        shifts=np.zeros((4, LENS_SIZE)),
        chances=(1e-9,),
    )
    variances = np.arange(4.0 * POSE_SIZE + (4 if own else 1) * LENS_SIZE)
    scene = replace(scene, own=lenses if own else None, camera_covariance=np.diag(variances))
    left = without_photos(scene, {1}).camera_covariance
    assert left is not None
    rest = variances[4 * POSE_SIZE :]
    if own:
        rest = np.delete(rest, range(LENS_SIZE, 2 * LENS_SIZE))
    poses = np.delete(variances[: 4 * POSE_SIZE], range(POSE_SIZE, 2 * POSE_SIZE))
    np.testing.assert_array_equal(left, np.diag(np.concatenate([poses, rest])))


def test_a_ring_is_open_where_no_points_join_both_sides(make_scene: MakeScene) -> None:
    """Half of the photos see the first 50 points, the others the rest but for five."""
    scene = make_scene(photos=12, points=100, share=1.0)
    seen = scene.observations
    first_half = seen.photo_idx < 6
    keep = np.where(first_half, seen.point_idx < 50, seen.point_idx >= 45)
    part = Observations(seen.photo_idx[keep], seen.point_idx[keep], seen.xy_px[keep])
    ring = ring_of(replace(scene, observations=part))
    assert ring.largest_gap_deg < 60
    assert ring.weakest_bridge == 5
    assert not ring.closed


def test_photos_that_must_not_stay_are_named_with_the_reason(
    make_scene: MakeScene, agreeing_pair: Callable[..., VerifiedPair]
) -> None:
    scene = make_scene(photos=6, points=60, share=1.0)
    pairs = Pairs(tuple(agreeing_pair(scene, k, k + 1) for k in range(5)), ())
    assert _misplaced(scene, pairs) == {}

    seen = scene.observations
    few = (seen.photo_idx != 1) | (seen.point_idx < 19)
    xy = seen.xy_px + np.where((seen.photo_idx == 3)[:, None], [3.0, 2.0], 0.0)
    spoiled = Observations(seen.photo_idx[few], seen.point_idx[few], xy[few])
    turned = Pairs((*pairs.verified[:4], agreeing_pair(scene, 4, 5, 40.0)), ())
    found = _misplaced(replace(scene, observations=spoiled), turned)
    assert sorted(found) == [1, 3, 5]
    assert told(found[1]).startswith("Only 19 scene points")
    assert told(found[3]).startswith("Its points miss by 3.6 px")
    assert "contradicts" in told(found[5])


@pytest.mark.parametrize(("without", "refused"), [((0, 1), False), ((0, 1, 2, 3), True)])
def test_a_scene_of_half_the_photos_is_the_least(
    make_scene: MakeScene, without: tuple[int, ...], refused: bool
) -> None:
    scene = without_photos(make_scene(photos=6), set(without))
    if not refused:
        _refuse_too_few(scene, MappingOptions())
        return
    with pytest.raises(PlacementError, match=r"Only 2 of 6 photos .*0\.jpg, 1\.jpg"):
        _refuse_too_few(scene, MappingOptions())


def with_verdicts(scene: Scene) -> Scene:
    fine = [PhotoVerdict(name=one, placed=True, points=1, rms_px=0.1) for one in scene.names]
    return replace(scene, verdicts=tuple(fine))


def test_a_photo_without_points_does_not_refuse_the_others(make_scene: MakeScene) -> None:
    scene = make_scene(photos=12, points=300, noise_px=0.1)
    lone = replace(scene, observations=scene.observations.some(scene.observations.photo_idx != 4))
    known = 1e-4 * np.eye(LENS_SIZE)
    given = [Calibration(camera=one, covariance=known, source="exif") for one in scene.cameras]
    found = readjusted(with_verdicts(lone), Cameras(tuple(given)), MappingOptions())
    assert found.placed == (0, 1, 2, 3, *range(5, 12))
    assert [k for k, one in enumerate(found.verdicts) if one.reason] == [4]
