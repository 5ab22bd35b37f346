"""Poses: a cast that was turned over is told by its board, and nothing else is."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from tests.unit.reconstruction.mapping.conftest import described

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.frames import Rigid, Similarity
from limbgram.core.run import Run
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.dense.depth import DepthMap
from limbgram.reconstruction.dense.region import closed_region
from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.lens_groups import ByLens
from limbgram.reconstruction.limb_groups import LimbGroups
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.matching.matching import Matches, PairMatches
from limbgram.reconstruction.matching.static_background import StaticBackground
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, PhotoSet
from limbgram.reconstruction.poses import (
    Part,
    Poses,
    Side,
    Unplaced,
    above_floors,
    find_poses,
    may_be_turned_over,
    place_object,
    refuse_apart,
)
from limbgram.reconstruction.scale.metric import MetricScene, Scale
from limbgram.reconstruction.targets.board import BoardDetections, PhotoCorners
from limbgram.reconstruction.twoview.pairs import Pairs
from limbgram.synthetic import (
    SMALL,
    Movement,
    MovementKind,
    Truth,
    TurnedOver,
    Turning,
    stage_truth,
)

PHOTOS = 16
OTHER_UNIT = Similarity(0.01, np.eye(3), np.array([3.0, -1.0, 2.0]))


def staged(**told: Any) -> Truth:
    return stage_truth(replace(SMALL, photos=PHOTOS, calibration_photos=0, **told))


def scene_of(truth: Truth, *, in_room: bool = False) -> Scene:
    """The photos placed by the limb, or by the room; every point is seen by all who could."""
    views = [truth.in_room(k) if in_room else view for k, view in enumerate(truth.views)]
    limb = truth.limb.mesh.vertices_mm[::200]
    bodies = [(limb, range(PHOTOS))]
    if in_room:
        bodies = [
            (truth.room_from_limb[half[0]].apply(limb), half)
            for half in (range(PHOTOS // 2), range(PHOTOS // 2, PHOTOS))
        ]
    points = np.concatenate([points for points, _ in bodies])
    every = np.arange(len(limb), dtype=np.int32)
    seen = [
        (np.full(len(limb), photo, np.int32), every + np.int32(len(limb) * body),
         views[photo].project(body_points))
        for body, (body_points, photos) in enumerate(bodies)
        for photo in photos
    ]  # fmt: skip
    photo_idx, point_idx, xy_px = (np.concatenate(column) for column in zip(*seen, strict=True))
    scene = Scene(
        names=tuple(view.name for view in views),
        cameras=(views[0].camera,),
        camera_idx=(0,) * PHOTOS,
        camera_from_world=tuple(view.camera_from_world for view in views),
        points_in_world=points,
        observations=Observations(photo_idx, point_idx, xy_px),
        verdicts=(),
    )
    return scene.moved(OTHER_UNIT)


def board_in(truth: Truth) -> BoardDetections:
    assert truth.board is not None
    board = truth.board.printed.board
    shown: list[PhotoCorners] = []
    for k, push in enumerate(truth.room_from_board):
        xy_px = truth.in_room(k).project(push.apply(truth.board.corners_in_world()))
        noise = np.random.default_rng(k).normal(scale=0.1, size=xy_px.shape)
        shown.append(
            PhotoCorners(
                name=truth.views[k].name,
                photo_idx=k,
                ids=np.arange(len(xy_px), dtype=np.int32),
                xy_px=xy_px + noise,
                sigmas_px=np.full(len(xy_px), 0.1),
                blur_px=0.7,
                step_px=40.0,
                doubtful_ids=np.zeros(0, np.int32),
                doubtful_xy_px=np.zeros((0, 2)),
                doubts=(),
            )
        )
    return BoardDetections(
        board=board, corners_mm=board.corners_mm, photos=tuple(shown), set_aside=()
    )


@pytest.fixture(scope="module")
def turned_over() -> Truth:
    return staged(turning=TurnedOver())


def test_a_cast_that_joins_two_poses_shows_its_board_twice(turned_over: Truth) -> None:
    assert may_be_turned_over(scene_of(turned_over), board_in(turned_over))


def test_a_room_that_joins_them_shows_the_cast_twice(turned_over: Truth) -> None:
    assert may_be_turned_over(scene_of(turned_over, in_room=True), board_in(turned_over))


@pytest.mark.parametrize("with_board", [(), (15,)])
def test_a_few_photos_that_the_cast_joined_hide_nothing(
    turned_over: Truth, with_board: tuple[int, ...]
) -> None:
    """They are placed by the first pose's cast, and share its points with the photos before.

    They show no board, or one that lies elsewhere by less than tells in the mean of all photos.
    """
    scene = scene_of(turned_over, in_room=True).moved(OTHER_UNIT.inverse)
    astray = (8, 9, 15)
    first_limb = turned_over.room_from_limb[0].inverse
    poses = list(scene.camera_from_world)
    for k in astray:
        poses[k] = turned_over.views[k].camera_from_world @ first_limb
    seen = scene.observations
    body = np.int32(len(scene.points_in_world) // 2) * np.isin(seen.photo_idx, astray)
    mixed = replace(
        scene,
        camera_from_world=tuple(poses),
        observations=replace(seen, point_idx=seen.point_idx - body),
    ).moved(OTHER_UNIT)
    shown = board_in(turned_over)
    hidden = {*astray} - {*with_board}
    shown = replace(shown, photos=tuple(o for o in shown.photos if o.photo_idx not in hidden))
    assert may_be_turned_over(mixed, shown)


@pytest.mark.parametrize(
    "told",
    [
        {},
        {"rings": 2},
        {"turning": Turning(sway_mm=6.0)},
        {"movement": Movement(kind=MovementKind.STEP, shift_mm=10.0)},
        {"movement": Movement(kind=MovementKind.PUSHED_BOARD, shift_mm=30.0)},
    ],
)
def test_nothing_else_is_turned_over(told: dict[str, Any]) -> None:
    """Nor a turntable, nor a patient who shifts, nor a board that is pushed."""
    truth = staged(**told)
    assert not may_be_turned_over(scene_of(truth), board_in(truth))


@pytest.mark.parametrize("told", [{}, {"elevations_deg": (60.0,)}])
def test_halves_of_one_ring_that_share_no_paint_are_one_body(told: dict[str, Any]) -> None:
    """Half of the paint is missing: what lies between them is bare, and the board joins them.

    From high above all photos look nearly the same way.
    """
    truth = staged(**told)
    scene = scene_of(truth)
    limb = len(scene.points_in_world)
    seen = scene.observations
    second = seen.photo_idx >= PHOTOS // 2
    apart = replace(
        scene,
        points_in_world=np.concatenate([scene.points_in_world] * 2),
        observations=replace(seen, point_idx=seen.point_idx + np.int32(limb) * second),
    )
    assert not may_be_turned_over(apart, board_in(truth))
    rounds = staged(rings=2)
    two = replace(
        apart,
        camera_from_world=scene_of(rounds).camera_from_world,
    )
    assert may_be_turned_over(two, board_in(rounds))  # two rounds that see different bodies


def test_a_board_of_which_only_a_row_is_seen_tells_nothing(turned_over: Truth) -> None:
    """What stands before it hides the rest: such a row leaves its pose open."""
    still = staged()
    row = [
        replace(one, ids=one.ids[:6], xy_px=one.xy_px[:6], sigmas_px=one.sigmas_px[:6])
        for one in board_in(still).photos
    ]
    hidden = replace(board_in(still), photos=tuple(row))
    assert not may_be_turned_over(scene_of(still), hidden)
    some = replace(hidden, photos=(*row[:4], *board_in(turned_over).photos[4:]))
    assert may_be_turned_over(scene_of(turned_over), some)


@pytest.mark.parametrize("off_px", [15.0, -15.0])
def test_one_wrong_corner_of_seven_turns_nothing_over(off_px: float) -> None:
    """The limb's silhouette cuts the board, and a corner of what is left lies beside its place."""
    still = staged()
    photos = list(board_in(still).photos)
    ids = np.array([0, 1, 2, 6, 7, 12, 18], np.int32)
    xy_px = photos[9].xy_px[ids].copy()
    xy_px[2, 0] += off_px
    photos[9] = replace(photos[9], ids=ids, xy_px=xy_px, sigmas_px=photos[9].sigmas_px[ids])
    shown = replace(board_in(still), photos=(*photos[:4], *photos[9:13]))
    assert not may_be_turned_over(scene_of(still), shown)


@pytest.mark.parametrize(
    ("turning", "asked"), [(Turning(board_turns=False), False), (TurnedOver(), True)]
)
def test_a_board_of_the_room_turns_nothing_over(
    monkeypatch: pytest.MonkeyPatch, turning: Turning | TurnedOver, asked: bool
) -> None:
    """Before a still camera each photo shows it elsewhere beside a limb that turns on a table."""
    truth, of = staged(turning=turning), "limbgram.reconstruction.poses"
    scene, looks = scene_of(truth), list[bool]()

    def look(*_: Any) -> Poses:
        looks.append(True)
        return Poses()

    monkeypatch.setattr(f"{of}.place", lambda *_: scene)  # pyright: ignore[reportUnknownLambdaType]
    monkeypatch.setattr(f"{of}.limb_groups", lambda *_: LimbGroups())  # pyright: ignore[reportUnknownLambdaType]
    monkeypatch.setattr(f"{of}.find_poses", look)
    unplaced = Unplaced(
        photos=cast(PhotoSet, SimpleNamespace(cameras=())),
        features=Features(()),
        still=StaticBackground(groups=(tuple(range(PHOTOS)),)),
        matches=Matches(pairs=(), pairs_tried=0, descriptor_matches=0),
        pairs=Pairs((), 0),
        cameras=cast(Cameras, None),
        detections=board_in(truth),
    )
    assert may_be_turned_over(scene, board_in(truth))
    assert place_object(unplaced, Run()).poses == Poses()
    assert bool(looks) == asked


@pytest.mark.parametrize("cut_out", [False, True])
def test_smaller_copies_leave_a_camera_file_open_to_doubt(
    monkeypatch: pytest.MonkeyPatch, cut_out: bool
) -> None:
    """Only photos that tell of other lenses than their files stand for lenses of their own."""
    of, scene = "limbgram.reconstruction.poses", scene_of(staged())
    sizes = (1600, 1200), (800, 600)
    groups = tuple(CameraGroup(label="", width_px=w, height_px=h, exif=Exif()) for w, h in sizes)
    photos = PhotoSet((), groups)
    shown = replace(photos, cameras=(groups[0], replace(groups[1], cut_out=cut_out)))

    def asked(*_: Any) -> ByLens:
        return ByLens(shown, Cameras(()))

    monkeypatch.setattr(f"{of}.by_cut", asked)
    monkeypatch.setattr(f"{of}.place", lambda *_: scene)  # pyright: ignore[reportUnknownLambdaType]
    monkeypatch.setattr(f"{of}.limb_groups", lambda *_: LimbGroups())  # pyright: ignore[reportUnknownLambdaType]
    unplaced = Unplaced(
        photos=photos,
        features=Features(()),
        still=StaticBackground(),
        matches=Matches(pairs=(), pairs_tried=0, descriptor_matches=0),
        pairs=Pairs((), 0),
        cameras=Cameras(()),
        detections=None,
    )
    assert (place_object(unplaced, Run()).lenses is not None) == cut_out


def test_without_a_board_nothing_is_said(turned_over: Truth) -> None:
    assert not may_be_turned_over(scene_of(turned_over), None)


def part_of(truth: Truth, photos: range, floor_z_mm: float | None = 0.0) -> Part:
    """Photos of one side as their own scene has them: placed by the room, in millimetres."""
    scene = scene_of(truth, in_room=True).moved(OTHER_UNIT.inverse)
    poses = tuple(pose if k in photos else None for k, pose in enumerate(scene.camera_from_world))
    skin = truth.room_from_limb[photos[0]].apply(truth.limb.mesh.vertices_mm[::20])
    scale = Scale(unit="mm", source="board", relative_sigma=1e-4)
    metric = MetricScene(
        scene=replace(scene, camera_from_world=poses), scale=scale, floor_z_mm=floor_z_mm
    )
    return Part(metric=metric, region=closed_region(skin, 10.0, 5.0, 4.0))


def side_of(truth: Truth, photos: range) -> Side:
    """All its photos hang together."""
    return Side(photos=tuple(photos), parts=(part_of(truth, photos),))


@pytest.fixture(scope="module")
def poses(turned_over: Truth) -> Poses:
    first, second = range(PHOTOS // 2), range(PHOTOS // 2, PHOTOS)
    return Poses(sides=(side_of(turned_over, first), side_of(turned_over, second)))


@pytest.mark.parametrize(
    "first_guess", [5, *(pytest.param(one, marks=pytest.mark.slow) for one in (8, 11))]
)
def test_a_side_that_falls_apart_itself_is_parted_there(
    monkeypatch: pytest.MonkeyPatch, turned_over: Truth, first_guess: int
) -> None:
    """Whatever place is tried first, the sides begin where the cast was turned over."""

    def guess(*_: Any) -> list[int]:
        return [first_guess]

    def side(half: range, *_: Any, **__: Any) -> Side:
        return side_of(turned_over, half)

    monkeypatch.setattr("limbgram.reconstruction.poses._seam_by_pairs", guess)
    monkeypatch.setattr("limbgram.reconstruction.poses._side", side)
    photo = SimpleNamespace(camera_idx=0)
    photos = cast(PhotoSet, SimpleNamespace(photos=[photo] * PHOTOS))
    calibration = SimpleNamespace(camera=turned_over.views[0].camera)
    cameras = cast(Cameras, SimpleNamespace(calibrations=[calibration]))
    found = find_poses(photos, Features(()), Pairs((), 0), cameras, board_in(turned_over), None)
    assert [side.photos for side in found.sides] == [tuple(range(8)), tuple(range(8, PHOTOS))]


LYING = range(PHOTOS // 2, PHOTOS)
FACES = range(LYING.start, LYING.start + 4), range(LYING.start + 4, LYING.stop)
"""Of the lying cast: what photos of one show, those of the other do not."""


@pytest.mark.parametrize(("board_moves", "expected"), [(True, FACES), (False, ())])
def test_faces_of_a_side_that_share_nothing_are_its_parts(
    monkeypatch: pytest.MonkeyPatch,
    turned_over: Truth,
    board_moves: bool,
    expected: tuple[range, ...],
) -> None:
    """Where the board lies in two places of the scene; elsewhere such photos are no side."""

    def placed(_: Any, __: Any, pairs: Any, *___: Any) -> Scene:
        joined = {k for one in pairs.verified for k in one.matches.photos}
        first = min(joined)
        end = next(one.stop for one in (range(LYING.start), *FACES) if first in one)
        return part_of(turned_over, range(first, end)).metric.scene

    def metric(scene: Scene, *_: Any) -> MetricScene:
        return part_of(turned_over, range(scene.placed[0], scene.placed[-1] + 1)).metric

    def region(_: Any, metric: MetricScene, *__: Any) -> object:
        return part_of(turned_over, range(metric.scene.placed[0], PHOTOS)).region

    def moves(*_: Any) -> bool:
        return board_moves

    def guess(*_: Any) -> list[int]:
        return [LYING.start]

    of = "limbgram.reconstruction.poses"
    monkeypatch.setattr(f"{of}._seam_by_pairs", guess)
    monkeypatch.setattr(f"{of}._suspected_seams", lambda *_: [])  # pyright: ignore[reportUnknownLambdaType]
    monkeypatch.setattr(f"{of}._board_moves", moves)
    monkeypatch.setattr(f"{of}.place_roughly", placed)
    monkeypatch.setattr(f"{of}._metric", metric)
    monkeypatch.setattr(f"{of}.find_region", region)
    runs = (range(LYING.start), *FACES)
    pairs = [
        SimpleNamespace(matches=SimpleNamespace(photos=(k, k + 1)))
        for one in runs
        for k in one[:-1]
    ]
    photo = SimpleNamespace(camera_idx=0)
    photos = cast(PhotoSet, SimpleNamespace(photos=[photo] * PHOTOS))
    calibration = SimpleNamespace(camera=turned_over.views[0].camera)
    cameras = cast(Cameras, SimpleNamespace(calibrations=[calibration]))
    given = cast(Pairs, SimpleNamespace(verified=pairs))
    monkeypatch.setattr(f"{of}.reverified", lambda *_: given)  # pyright: ignore[reportUnknownLambdaType]
    monkeypatch.setattr(f"{of}.solved_lenses", lambda *_: cameras)  # pyright: ignore[reportUnknownLambdaType]
    scene = scene_of(turned_over)
    found = find_poses(photos, Features(()), given, cameras, board_in(turned_over), scene)
    parts = [part.metric.scene.placed for side in found.sides[1:] for part in side.parts]
    assert parts == [tuple(one) for one in expected]


def test_the_parts_of_a_side_may_have_units_of_their_own(turned_over: Truth, poses: Poses) -> None:
    """The joined scene must agree with each of them, and with most photos of both."""
    first, second = (part_of(turned_over, face) for face in FACES)
    twice = Similarity(2.0, np.eye(3), np.zeros(3))
    second = replace(second, metric=replace(second.metric, scene=second.metric.scene.moved(twice)))
    lying = Side(photos=tuple(LYING), parts=(first, second))
    assert lying.placed == len(LYING)
    parted = replace(poses, sides=(poses.sides[0], lying))
    joined = scene_of(turned_over)
    refuse_apart(parted, joined)
    astray = list(joined.camera_from_world)
    last = astray[FACES[1].stop - 1]
    assert last is not None
    astray[FACES[1].stop - 1] = Rigid(last.rotation, last.translation + 2.0)
    lost = (*joined.camera_from_world[: FACES[1].start], *(None,) * len(FACES[1]))
    for camera_from_world in (tuple(astray), lost):
        with pytest.raises(PlacementError, match="The object was turned over"):
            refuse_apart(parted, replace(joined, camera_from_world=camera_from_world))


def test_only_what_lies_on_the_object_joins_the_poses(turned_over: Truth, poses: Poses) -> None:
    """The limb's middle is on it in both poses; the board's corners and the corner are not."""
    assert turned_over.board is not None
    middle = turned_over.limb.mesh.vertices_mm.mean(0)[None]
    shown: list[Keypoints] = []
    for k, view in enumerate(turned_over.views):
        board = turned_over.in_room(k).project(turned_over.board.outline_in_world()[2:3])
        shown.append(described(np.concatenate([view.project(middle), board, [[2.0, 2.0]]])))
    features = Features(tuple(shown))
    every = np.column_stack([np.arange(3), np.arange(3)]).astype(np.int32)
    pair = PairMatches(
        first=2,
        second=12,
        keypoint_idx=every,
        xy_first_px=np.zeros((3, 2)),
        xy_second_px=np.zeros((3, 2)),
        correlation=np.ones(3, np.float32),
    )
    found = poses.matches_on_object(
        features, Matches(pairs=(pair,), pairs_tried=1, descriptor_matches=3)
    )
    np.testing.assert_array_equal(found.pairs[0].keypoint_idx, [[0, 0]])


def test_the_board_of_the_pose_that_shows_it_more_sets_the_scale(
    turned_over: Truth, poses: Poses
) -> None:
    found = board_in(turned_over)
    less = replace(found, photos=found.photos[3:])
    kept = poses.one_board(less)
    assert [one.photo_idx for one in kept.photos] == list(range(PHOTOS // 2, PHOTOS))
    assert Poses().one_board(less) is less


def test_scenes_that_agree_with_their_sides_pass_and_others_are_refused(
    turned_over: Truth, poses: Poses
) -> None:
    joined = scene_of(turned_over)
    refuse_apart(poses, joined)
    astray = list(joined.camera_from_world)
    assert astray[9] is not None
    astray[9] = Rigid(astray[9].rotation, astray[9].translation + 0.5)
    with pytest.raises(PlacementError, match="The object was turned over, and IMG_1009"):
        refuse_apart(poses, replace(joined, camera_from_world=tuple(astray)))
    lost = (*joined.camera_from_world[: PHOTOS // 2], *(None,) * (PHOTOS // 2))
    with pytest.raises(PlacementError, match="Too few marks on the object itself"):
        refuse_apart(poses, replace(joined, camera_from_world=lost))


def test_the_table_of_a_lying_cast_leaves_its_depth_map(turned_over: Truth, poses: Poses) -> None:
    """In the limb's frame that table stands upright: only what lies above it stays."""
    scene = scene_of(turned_over).moved(OTHER_UNIT.inverse)
    scale = Scale(unit="mm", source="board", relative_sigma=1e-4)
    metric = MetricScene(scene=scene, scale=scale, floor_z_mm=0.0)
    view, in_room = turned_over.views[10], turned_over.in_room(10)
    pinhole = replace(view.camera, k1=0.0, k2=0.0, p1=0.0, p2=0.0)
    pixels = np.stack(np.meshgrid(np.arange(40), np.arange(30)), -1).reshape(-1, 2)
    rays = np.column_stack([pinhole.normalize(pixels + np.array([400.0, 250.0])), np.ones(1200)])
    rays_in_room = rays @ in_room.camera_from_world.rotation
    on_table = -in_room.centre_in_world[2] / rays_in_room[:, 2]
    high = 20.0 / -rays_in_room[:, 2]  # from the table back to 20 mm above it
    depth = np.where(pixels[:, 0] < 20, on_table, on_table - high).reshape(30, 40)
    one = DepthMap(
        photo_idx=10,
        camera=pinhole,
        camera_from_world=view.camera_from_world,
        x0=400,
        y0=250,
        depth_mm=depth.astype(np.float32),
        normal_in_camera=np.zeros((30, 40, 3), np.float32),
        confidence=np.ones((30, 40), np.float32),
    )
    (cleared,) = above_floors([one], metric, poses)
    assert np.isnan(cleared.depth_mm[:, :20]).all()
    assert np.isfinite(cleared.depth_mm[:, 20:]).all()
    assert above_floors([one], metric, Poses()) == (one,)
