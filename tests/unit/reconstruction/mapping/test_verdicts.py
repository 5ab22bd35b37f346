"""Agreement of keypoints, contradictions and the words that photos get."""

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from tests.unit.reconstruction.mapping.conftest import described

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.frames import Rigid, angle_between_deg
from limbgram.core.geometry.lens import LENS_SIZE, Camera
from limbgram.findings import note, told
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.mapping.verdicts import (
    contradicted,
    contradicting_share,
    disputed,
    judge,
    photo_points,
    refined_keypoints,
    refuse_contradicted,
    reverified,
    solved_lenses,
)
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair
from limbgram.reconstruction.twoview.verification import verify_pair

MakeScene = Callable[..., Scene]
MakePair = Callable[..., VerifiedPair]


def agreed(features: Features, pairs: list[VerifiedPair]) -> list[np.ndarray]:
    """Shifts s of all keypoints: least sum of w |s_second - turn s_first - move|^2 + 0.1 |s|^2.

    A turn is a complex factor, second's scale and angle over first's; weights are Cauchy's at
    0.3 px, of the moves first and then once of what is left.
    """
    places = [keypoints.xy_px.astype(float) for keypoints in features.keypoints]
    names = [(k, i) for k, xy in enumerate(places) for i in range(len(xy))]
    rows: list[np.ndarray] = []
    moves: list[complex] = []

    def spin(photo: int, idx: int) -> complex:
        keypoints = features.keypoints[photo]
        angle = math.radians(float(keypoints.angle_deg[idx]))
        return cmath.rect(float(keypoints.scale_px[idx]), angle)

    for pair in pairs:
        first, second = pair.matches.first, pair.matches.second
        for (i, j), found in zip(pair.matches.keypoint_idx.tolist(), pair.matches.xy_second_px):
            row = np.zeros(len(names), complex)
            row[names.index((second, j))] += 1
            row[names.index((first, i))] -= spin(second, j) / spin(first, i)
            rows.append(row)
            moves.append(complex(*(found - places[second][j])))
    design, wanted = np.array(rows), np.array(moves)
    left, shifts = wanted, np.zeros(len(names), complex)
    for _ in range(2):
        root = np.sqrt(1 / (1 + np.abs(left) ** 2 / 0.3**2))
        whole = np.vstack([root[:, None] * design, math.sqrt(0.1) * np.eye(len(names))])
        shifts = np.linalg.lstsq(whole, np.concatenate([root * wanted, 0 * shifts]), rcond=None)[0]
        left = wanted - design @ shifts
    steps = iter(shifts)
    return [row + np.array([[s.real, s.imag] for _, s in zip(row, steps)]) for row in places]


@pytest.mark.parametrize("seed", range(3))
def test_places_agree_with_all_window_matches(make_pair: MakePair, seed: int) -> None:
    random = np.random.default_rng(seed)
    features = Features(
        tuple(
            described(
                random.uniform(0, 90, (9, 2)), random.uniform(1, 3, 9), random.uniform(-180, 180, 9)
            )
            for _ in range(3)
        )
    )
    pairs = []
    for first, second in [(0, 1), (1, 2), (0, 2)]:
        rows = np.column_stack([random.permutation(9)[:6], random.permutation(9)[:6]])
        places = features.keypoints[second].xy_px.astype(float)[rows[:, 1]]
        moved = places + random.normal(0, 0.3, (6, 2))
        moved[0] += 5.0  # a wrong one, which the robust weights play down
        pairs.append(make_pair(first, second, rows, xy_px=(np.zeros((6, 2)), moved)))
    found = refined_keypoints(features, Pairs(tuple(pairs), ()))
    for ours, expected in zip(found, agreed(features, pairs), strict=True):
        np.testing.assert_allclose(ours, expected, atol=1e-9)
    still = refined_keypoints(features, Pairs((), ()))
    for ours, keypoints in zip(still, features.keypoints, strict=True):
        np.testing.assert_array_equal(ours, keypoints.xy_px)


def relative(scene: Scene, first: int, second: int, turn_deg: float = 0.0) -> Rigid:
    turn = Rigid.from_rotation_vector(np.array([0.0, np.radians(turn_deg), 0.0]), np.zeros(3))
    poses = scene.view(first).camera_from_world, scene.view(second).camera_from_world
    return turn @ poses[1] @ poses[0].inverse


@pytest.mark.parametrize(("turn_deg", "wrong"), [(14.0, False), (16.0, True)])
def test_a_photo_contradicts_where_most_of_its_matches_say_so(
    make_scene: MakeScene, make_pair: MakePair, turn_deg: float, wrong: bool
) -> None:
    """Photo 2 has 29 matches that agree, photo 3 has 31, both 30 others; planes say nothing."""
    scene = make_scene(photos=4)
    fewer, turned, more = (np.zeros((count, 2)) for count in (29, 30, 31))
    plane = np.zeros((90, 2))
    verified = (
        make_pair(1, 2, fewer, relative(scene, 1, 2)),
        make_pair(2, 3, turned, relative(scene, 2, 3, turn_deg)),
        make_pair(0, 3, more, relative(scene, 0, 3)),
        make_pair(0, 2, plane, relative(scene, 0, 2, 90.0), kind="planar"),
        make_pair(0, 1, plane, None, kind="rotation"),
    )
    found = contradicted(scene, Pairs(verified, ()))
    assert found.tolist() == [False, False, wrong, False]
    seen = make_pair(1, 2, plane, relative(scene, 1, 2), kind="planar")
    assert not contradicted(scene, Pairs((*verified, seen), ())).any()


@pytest.mark.parametrize(("apart_deg", "wrong"), [(10.0, True), (60.0, False)])
def test_pairs_that_contradict_each_other_contradict_no_photo(
    make_scene: MakeScene, make_pair: MakePair, apart_deg: float, wrong: bool
) -> None:
    """Photo 3 has 30 matches that agree, and twice 25 that turn it by 90 degrees, or otherwise."""
    scene = make_scene(photos=4)
    against = np.zeros((25, 2))
    verified = (
        make_pair(2, 3, np.zeros((30, 2)), relative(scene, 2, 3)),
        make_pair(0, 3, against, relative(scene, 0, 3, 90.0)),
        make_pair(1, 3, against, relative(scene, 1, 3, 90.0 + apart_deg)),
        make_pair(0, 2, np.zeros((40, 2)), relative(scene, 0, 2)),
        make_pair(1, 2, np.zeros((40, 2)), relative(scene, 1, 2)),
        make_pair(0, 1, np.zeros((40, 2)), relative(scene, 0, 1)),
    )
    assert contradicted(scene, Pairs(verified, ())).tolist() == [False, False, False, wrong]


@pytest.mark.parametrize(("apart_deg", "two"), [(10.0, True), (60.0, False)])
def test_two_pairs_that_turn_a_photo_alike_dispute_it_whatever_agrees(
    make_scene: MakeScene, make_pair: MakePair, apart_deg: float, two: bool
) -> None:
    """Photo 3 has 90 matches that agree, and twice 25 that turn it by 90 degrees, or otherwise.

    So a cast that was turned over shows: 90 of them lie on the room. It is no contradiction.
    """
    scene = make_scene(photos=4)
    against = np.zeros((25, 2))
    verified = (
        make_pair(2, 3, np.zeros((90, 2)), relative(scene, 2, 3)),
        make_pair(0, 3, against, relative(scene, 0, 3, 90.0)),
        make_pair(1, 3, against, relative(scene, 1, 3, 90.0 + apart_deg)),
    )
    assert disputed(scene, Pairs(verified, ())).tolist() == [False, False, False, two]
    assert not contradicted(scene, Pairs(verified, ()))[3]


@pytest.mark.parametrize(("wrong", "torn"), [(24, False), (26, True)])
def test_a_scene_without_some_photos_is_torn_where_a_quarter_of_the_matches_contradict(
    make_scene: MakeScene, make_pair: MakePair, wrong: int, torn: bool
) -> None:
    """Of 100 matches between three placed photos so many turn photo 2 as if it stood at photo 0."""
    scene = make_scene(photos=4)
    given = Calibration(camera=LENS, covariance=np.eye(LENS_SIZE), source="board")
    same = Rigid.from_rotation_vector(np.zeros(3), np.array([1.0, 0.0, 0.0]))
    verified = (
        make_pair(0, 1, np.zeros((50, 2)), relative(scene, 0, 1)),
        make_pair(1, 2, np.zeros((50 - wrong, 2)), relative(scene, 1, 2)),
        make_pair(0, 2, np.zeros((wrong, 2)), same),
        make_pair(0, 2, np.zeros((900, 2)), same, kind="planar"),
        make_pair(2, 3, np.zeros((900, 2)), same),
    )
    pairs, cameras = Pairs(verified, ()), Cameras((given,) * len(scene.cameras))
    refuse_contradicted(scene, pairs, cameras)  # all photos are placed
    without = replace(scene, camera_from_world=(*scene.camera_from_world[:3], None))
    assert contradicting_share(without, pairs) == pytest.approx(wrong / 100)
    if not torn:
        refuse_contradicted(without, pairs, cameras)
        return
    with pytest.raises(PlacementError) as refusal:
        refuse_contradicted(without, pairs, cameras)
    assert refusal.value.finding.code == "placing.torn"
    assert refusal.value.finding.values["count"] == 3


LENS = Camera(width_px=900, height_px=700, fx=700.0, fy=700.0, cx=449.5, cy=349.5, k1=0.05)


def by_guess(scene: Scene, make_pair: MakePair, ratio: float) -> tuple[Pairs, Cameras]:
    """All pairs, verified under a lens without distortion and with so much more focal length."""
    lens = replace(LENS, fx=ratio * LENS.fx, fy=ratio * LENS.fy, k1=0.0)
    given = Calibration(camera=lens, covariance=np.eye(LENS_SIZE), source="guess")
    seen, verified = scene.observations, list[VerifiedPair]()
    places = [seen.xy_px[seen.photo_idx == photo] for photo in range(len(scene.names))]
    rows = np.repeat(np.arange(len(places[0]))[:, None], 2, axis=1)
    for first, second in combinations(range(len(places)), 2):
        shown = make_pair(first, second, rows, xy_px=(places[first], places[second]))
        found = verify_pair(shown.matches, given, given)
        assert found is not None
        verified.append(found)
    return Pairs(tuple(verified), 0), Cameras((given,))


def test_turns_solved_under_a_guessed_lens_are_solved_again_under_the_lens_of_the_scene(
    make_scene: MakeScene, make_pair: MakePair
) -> None:
    """The scene is exact. Its lens is found, where 1.65 times its focal length was guessed."""
    scene = make_scene(photos=6, points=60, share=1.0, lenses=(LENS,))
    pairs, cameras = by_guess(scene, make_pair, 1.65)
    assert contradicted(scene, pairs).all()
    again = reverified(scene, pairs, cameras)
    assert len(again.verified) == len(pairs.verified)
    for pair in again.verified:
        first, second = pair.matches.first, pair.matches.second
        assert pair.second_from_first is not None
        true = relative(scene, first, second).rotation
        assert angle_between_deg(true, pair.second_from_first.rotation) < 0.01
    assert not contradicted(scene, again).any()
    poses = list(scene.camera_from_world)
    wrong = Rigid.from_rotation_vector(np.array([0.0, 0.0, np.radians(20.0)]), np.zeros(3))
    poses[4] = wrong @ scene.view(4).camera_from_world
    turned = replace(scene, camera_from_world=tuple(poses))
    found = contradicted(turned, reverified(turned, pairs, cameras))
    assert np.flatnonzero(found).tolist() == [4]


def test_a_lens_that_a_board_calibrated_is_not_solved_again(
    make_scene: MakeScene, make_pair: MakePair
) -> None:
    scene = make_scene(photos=6, points=60, share=1.0, lenses=(LENS,))
    pairs, cameras = by_guess(scene, make_pair, 1.02)
    board = Cameras((replace(cameras.calibrations[0], source="board"),))
    assert solved_lenses(scene, board) == board
    assert reverified(scene, pairs, board).verified == pairs.verified


def test_points_and_residuals_are_counted_by_photo(make_scene: MakeScene) -> None:
    scene = make_scene(noise_px=0.5, points=20)
    figures, residuals = photo_points(scene), scene.residuals_px()
    for photo in range(5):
        own = residuals[scene.observations.photo_idx == photo]
        mean = sum(float(row @ row) for row in own) / len(own)
        np.testing.assert_allclose(figures[photo], [len(own), math.sqrt(mean)])


def test_every_photo_that_is_left_out_gets_its_own_reason(
    make_scene: MakeScene, make_pair: MakePair
) -> None:
    scene = make_scene(photos=7, points=30)
    poses = scene.camera_from_world
    placed = replace(scene, camera_from_world=(*poses[:2], *5 * (None,)))
    other = replace(scene, camera_from_world=(None, None, None, *poses[3:5], None, None))
    plenty, rows = np.zeros((300, 2)), np.zeros((9, 2))
    places = (plenty, plenty, np.zeros((150, 2)), *4 * (plenty,))
    pairs = (
        make_pair(0, 2, rows),
        make_pair(0, 5, rows, kind="rotation"),
        make_pair(0, 6, rows),
        make_pair(1, 6, rows),
    )
    photos = taken(7)
    dropped = {1: "unused", 4: "It moved."}
    verdicts = judge(
        placed,
        photos,
        places,
        Pairs(pairs, 0),
        [other],
        {k: note("said.as_is", message=one) for k, one in dropped.items()},
    )
    assert [verdict.placed for verdict in verdicts] == [True, True, *5 * (False,)]
    starts = [
        "",
        "",
        "Only 150 feature points",
        "It joins only with 4.jpg,",
        "It moved.",
        "It was taken from the same spot",
        "Only 2 points of the scene are found in it",
    ]
    for verdict, start in zip(verdicts, starts, strict=True):
        assert (told(verdict.reason) if verdict.reason else "").startswith(start)
        assert (verdict.reason is not None) != verdict.placed
        assert np.isnan(verdict.rms_px) != verdict.placed
    alone = judge(placed, photos, places, Pairs((), 0), [], {})
    assert told(alone[6].reason).startswith("No other photo shows the same points")


def taken(count: int, blurred: Sequence[int] = ()) -> PhotoSet:
    """Photos of `make_scene`; edges are 1 px wide, 4 px in blurred ones."""
    return PhotoSet(
        tuple(
            Photo(
                name=f"{k}.jpg",
                path=Path(f"{k}.jpg"),
                width_px=900,
                height_px=700,
                exif=Exif(),
                sha256="",
                camera_idx=0,
                sharpness=4.0 if k in blurred else 1.0,
                burnt=0.0,
                brightest=200.0,
            )
            for k in range(count)
        ),
        (CameraGroup(label="", width_px=900, height_px=700, exif=Exif()),),
    )


def with_one_not_placed(
    make_scene: MakeScene, make_pair: MakePair, matched: int, agreeing: int
) -> tuple[Scene, list[np.ndarray], Pairs]:
    """Photo 3 of six has no place; its first matches lie where the scene has their points."""
    scene = make_scene(photos=6, points=240, share=1.0)
    seen = scene.observations
    places = [seen.xy_px[seen.photo_idx == photo] for photo in range(6)]
    others = (240 - agreeing, 2)
    places[3][agreeing:] = np.random.default_rng(3).uniform(0, 700, others)
    poses = scene.camera_from_world
    without = replace(
        scene,
        camera_from_world=(*poses[:3], None, *poses[4:]),
        observations=seen.some(seen.photo_idx != 3),
    )
    rows = np.repeat(np.arange(matched)[:, None], 2, axis=1)
    split = matched // 4
    pairs = (make_pair(2, 3, rows[:-split]), make_pair(3, 4, rows[split:]))
    return without, places, Pairs(pairs, 0)


@pytest.mark.parametrize(
    ("matched", "agreeing", "says"),
    [
        (20, 15, "Only 15 points"),
        (20, 8, "Not placed: 8 of its 20 matches"),
        (20, 0, "Not placed: 5 of its 20 matches"),
        (4, 0, "Only 4 points"),
        (7, 5, "Only 5 points"),
    ],
)
def test_a_few_wrong_matches_of_a_few_do_not_disagree(
    make_scene: MakeScene, make_pair: MakePair, matched: int, agreeing: int, says: str
) -> None:
    """Five of twenty are wrong in many a sound photo; twelve are by no chance. Without a pose,
    which takes six matches, nothing tells that fewer than five agree."""
    without, places, pairs = with_one_not_placed(make_scene, make_pair, matched, agreeing)
    verdict = judge(without, taken(6), places, pairs, [], {})[3]
    assert told(verdict.reason).startswith(says)


@pytest.mark.parametrize("blurred", [(), (3,)])
def test_a_cause_is_named_only_where_it_was_measured(
    make_scene: MakeScene, make_pair: MakePair, blurred: tuple[int, ...]
) -> None:
    """Of 40 points that the photo without a place matches 25 lie where it has them."""
    without, places, pairs = with_one_not_placed(make_scene, make_pair, 40, 25)
    verdict = judge(without, taken(6, blurred), places, pairs, [], {})[3]
    assert told(verdict.reason).startswith(
        "Not placed: 25 of its 40 matches with points of the scene"
    )
    assert ("It is blurred: edges 4.0 px wide" in told(verdict.reason)) == bool(blurred)
    assert "moved" not in told(verdict.reason)
    few = [*places[:3], places[3][:150], *places[4:]]
    verdict = judge(without, taken(6, blurred), few, Pairs((), 0), [], {})[3]
    assert told(verdict.reason).startswith("Only 150 feature points were found. ")
    assert ("blurred" in told(verdict.reason)) == bool(blurred)
