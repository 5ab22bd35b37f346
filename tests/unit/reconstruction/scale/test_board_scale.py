"""Scale from a board, against a room whose measures are known."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.unit.reconstruction.scale.conftest import (
    BOARD,
    WORLD_FROM_BOARD,
    Capture,
    capsule,
    ring,
    scene_of,
)

from limbgram.core.errors import ScaleError
from limbgram.core.geometry.frames import Rigid, fit_similarity
from limbgram.core.geometry.lens import POSE_SIZE, Camera, View
from limbgram.findings import Finding, told
from limbgram.reconstruction.mapping.scene import Movement, OwnLenses, Scene
from limbgram.reconstruction.scale.board import find_scene_board
from limbgram.reconstruction.scale.metric import LengthCheck, Scale, StretchDoubt
from limbgram.reconstruction.scale.ruler import stretch_by_cameras
from limbgram.reconstruction.scale.scaling import (
    _moved,
    check_lengths,
    check_scene_board,
    to_millimetres,
)
from limbgram.reconstruction.targets.board import BoardDetections, PhotoCorners


def scale_error(metric_scene: Scene, capture) -> float:
    """Size of the scaled scene over the room's, less one, by the points (poses may be shaken)."""
    truth = (capture.scene.points_in_world - capture.scene.points_in_world.mean(0)) / 0.0371
    found = metric_scene.points_in_world - metric_scene.points_in_world.mean(0)
    return fit_similarity(truth, found).scale - 1


def with_photo(detections: BoardDetections, k: int, xy_px: np.ndarray) -> BoardDetections:
    photos = list(detections.photos)
    photos[k] = replace(photos[k], xy_px=xy_px)
    return replace(detections, photos=tuple(photos))


def test_exact_corners_give_the_exact_scale_and_frame(capture) -> None:
    metric = to_millimetres(capture.scene, capture.detections())
    assert abs(scale_error(metric.scene, capture)) < 1e-9
    assert metric.floor_z_mm == 0.0
    centres = np.array([view.centre_in_world for view in metric.scene.views])
    truth = np.array([view.centre_in_world for view in capture.room_views])
    world_from_room = fit_similarity(truth, centres)
    np.testing.assert_allclose(world_from_room.rotation[:, 2], [0, 0, 1], atol=1e-9)
    table_z = world_from_room.apply(np.zeros((1, 3)))[0, 2]
    assert table_z == pytest.approx(-2.5, abs=1e-6)
    corners = np.array(metric.board_corners_mm)
    np.testing.assert_allclose(np.abs(corners), np.tile([105.0, 75.0, 0.0], (4, 1)), atol=1e-6)
    np.testing.assert_allclose(corners[0], [-105, 75, 0], atol=1e-6)


def test_noise_costs_what_sigma_says(capture, shaken) -> None:
    ratios = []
    for seed in range(6):
        scene = shaken(capture, shift_mm=0.1, turn_deg=0.004, seed=seed).scene
        metric = to_millimetres(scene, capture.detections(noise_px=0.1, seed=seed))
        ratios.append(scale_error(metric.scene, capture) / metric.scale.relative_sigma)
        assert 2e-5 < metric.scale.relative_sigma < 5e-4
    assert 0.5 < np.sqrt(np.mean(np.square(ratios))) < 1.7


def test_check_lengths_share_no_corner_with_control_lengths(capture) -> None:
    scale = to_millimetres(capture.scene, capture.detections(noise_px=0.1)).scale
    roles = [one.role for one in scale.lengths]
    assert roles.count("control") == roles.count("check") == 4
    assert scale.checked
    for one in scale.lengths:
        assert 1e-5 < abs(one.error) < 4 * one.sigma_mm / one.known_mm + 1e-4


def test_corners_cut_by_the_silhouette_do_no_harm(capture) -> None:
    detections = capture.detections(noise_px=0.05, seed=4)
    clean = scale_error(to_millimetres(capture.scene, detections).scene, capture)
    draw = np.random.default_rng(5)
    for k in range(12):
        xy = detections.photos[k].xy_px.copy()
        xy[draw.integers(len(xy))] += draw.uniform(2, 20, 2)
        detections = with_photo(detections, k, xy)
    cut = scale_error(to_millimetres(capture.scene, detections).scene, capture)
    assert abs(cut) < 1e-4
    assert abs(cut - clean) < 5e-5


CORNER = 19


def with_corner_in(
    photos: Mapping[int, float], nearer_mm: float = 0.0
) -> tuple[Scene, BoardDetections]:
    """Photos of a flat board, in few pixels, of which these alone show one corner.

    Args:
        photos: By photo, by how many pixels it measures the corner too far right.
        nearer_mm: How much nearer to the second of them the corner lies than the board's plane.
    """
    lens = Camera(width_px=720, height_px=540, fx=600.0, fy=600.0, cx=360.0, cy=265.0)
    views = tuple(replace(view, camera=lens) for view in ring(12, 550.0))
    shown = Capture(views, replace(scene_of(views, capsule(500, 1)), cameras=(lens,)))
    detections = shown.detections(0.05, seed=1)
    place = WORLD_FROM_BOARD.apply(BOARD.corners_mm)[CORNER]
    sight = views[[*photos][1]].centre_in_world - place
    moved = place + nearer_mm * sight / np.linalg.norm(sight)
    seen: list[PhotoCorners] = []
    for k, one in enumerate(detections.photos):
        kept = (one.ids != CORNER) | (k in photos)
        xy_px = one.xy_px.copy()
        xy_px[CORNER] = views[k].project(moved[None])[0] + (photos.get(k, 0.0), 0.0)
        sigmas_px = one.sigmas_px[kept]
        seen.append(replace(one, ids=one.ids[kept], xy_px=xy_px[kept], sigmas_px=sigmas_px))
    return shown.scene, replace(detections, photos=tuple(seen))


def corners_off_plane(scene: Scene, detections: BoardDetections) -> list[int]:
    found = find_scene_board(scene, detections)
    assert len(found.control_ids) == 11  # either way it sets no scale
    off = [one.reason for one in found.ruler.set_aside if one.reason.code == "board.off_plane"]
    return [one.values["corners"] for one in off]


@pytest.mark.parametrize(("nearer_mm", "told_of"), [(0.4, []), (2.0, [1])])
def test_a_corner_of_a_flat_board_is_off_it_only_where_its_photos_say_so(
    nearer_mm: float, told_of: list[int]
) -> None:
    """Three neighbouring photos of few pixels show it: what their poses err by moves it along the
    line of sight, and they miss the flat board by no more than noise."""
    shown = with_corner_in(dict.fromkeys((3, 4, 5), 0.0), nearer_mm)
    assert corners_off_plane(*shown) == told_of


def test_one_photo_that_mismeasures_a_corner_does_not_lift_it_off_the_board() -> None:
    """It moves the corner, and lies too near to it to be an outlier."""
    assert corners_off_plane(*with_corner_in({3: 0.0, 4: 0.0, 5: 0.0, 6: 0.6})) == []


def test_a_photo_in_which_the_board_lay_elsewhere_is_named(capture) -> None:
    detections = capture.detections(noise_px=0.05, seed=6)
    moved = with_photo(detections, 3, detections.photos[3].xy_px + np.array([40.0, -25.0]))
    metric = to_millimetres(capture.scene, moved)
    assert [one.name for one in metric.scale.set_aside] == ["photo03.jpg"]
    assert abs(scale_error(metric.scene, capture)) < 1e-4


def test_a_board_that_moved_between_all_photos_is_refused(capture) -> None:
    detections = capture.detections()
    draw = np.random.default_rng(7)
    for k in range(12):
        shifted = detections.photos[k].xy_px + draw.uniform(-150, 150, 2)
        detections = with_photo(detections, k, shifted)
    with pytest.raises(ScaleError, match="moved against the limb"):
        to_millimetres(capture.scene, detections)


def test_a_print_stretched_one_way_is_refused_with_its_number(capture) -> None:
    with pytest.raises(ScaleError, match=r"0\.60% longer along its x than along its y"):
        to_millimetres(capture.scene, capture.detections(stretch_x=1.006))
    metric = to_millimetres(capture.scene, capture.detections(stretch_x=1.002))
    assert 5e-4 < abs(scale_error(metric.scene, capture)) < 2e-3


@pytest.mark.parametrize(
    ("by", "said"),
    [
        ("none", "board.stretched"),
        ("uncalibrated", "board.stretched_or_lens"),
        ("rolling shutter", "board.stretched_or_lens"),
    ],
)
def test_a_stretch_is_not_blamed_on_the_print_alone_where_the_lens_is_not_known(
    capture, by: StretchDoubt, said: str
) -> None:
    board = find_scene_board(capture.scene, capture.detections(stretch_x=1.007))
    with pytest.raises(ScaleError) as refusal:
        check_scene_board(board, 0.003, capture.scene, by)
    assert refusal.value.finding.code == said


def test_a_stretch_that_a_lens_may_have_done_is_refused_where_the_scale_is_not_sure(
    capture,
) -> None:
    """0.4 % is no fact of the board, and the scale between both sides is sure to 0.2 %."""
    board = find_scene_board(capture.scene, capture.detections(stretch_x=1.004))
    check_scene_board(board, 0.003, capture.scene, by="uncalibrated")
    assert board.relative_sigma == pytest.approx(0.002, rel=0.1)
    with pytest.raises(ScaleError, match=r"0\.40% longer along its x"):
        check_scene_board(board, 0.003, capture.scene)


def with_length(measured_mm: float, sigma_mm: float, by: StretchDoubt) -> Scale:
    """A board's scale with one checking length of 60 mm."""
    one = LengthCheck(
        label="board, along y",
        known_mm=60.0,
        measured_mm=measured_mm,
        sigma_mm=sigma_mm,
        role="check",
        between="board",
        marks=(),
    )
    return Scale(unit="mm", source="board", relative_sigma=3e-4, lengths=(one,), stretch_doubt=by)


@pytest.mark.parametrize("by", ["none", "uncalibrated"])
def test_a_length_of_the_board_that_noise_explains_accuses_no_print(by: StretchDoubt) -> None:
    """0.19 mm is 2.7 sigma: one length in 150 errs so, and eight are compared."""
    scale = with_length(60.19, 0.07, by)
    check_lengths(scale, 0.003, of_board=8)


@pytest.mark.parametrize(("sigma_mm", "refused"), [(0.04, True), (0.046, True), (0.048, False)])
def test_a_typed_length_contradicts_beyond_four_of_its_sigmas(
    sigma_mm: float, refused: bool
) -> None:
    """0.19 mm of 60 is more than 0.3 %, and less than four sigmas from 0.0475 mm on."""
    scale = with_length(60.19, sigma_mm, "none")
    with pytest.raises(ScaleError) if refused else nullcontext():
        check_lengths(scale, 0.003)


@pytest.mark.parametrize("of_board", [8, 0])
@pytest.mark.parametrize(
    ("by", "said"),
    [
        ("none", "scale.cause.board"),
        ("uncalibrated", "scale.cause.board_or_lens"),
        ("rolling shutter", "scale.cause.board_or_lens"),
    ],
)
def test_a_length_that_noise_does_not_explain_is_told(
    by: StretchDoubt, said: str, of_board: int
) -> None:
    """0.4 % of 60 mm is 0.24 mm, 8 sigma; on the board, or a typed one beside it."""
    with pytest.raises(ScaleError) as refusal:
        check_lengths(with_length(60.24, 0.03, by), 0.003, of_board)
    cause = refusal.value.finding.values["cause"]
    assert isinstance(cause, Finding)
    assert cause.code == said
    words = told(cause)
    assert ("rolling shutter" in words) == (by == "rolling shutter")
    assert ("no board calibrated it" in words) == (by == "uncalibrated")
    assert ("typed length" in words) == (by == "none" or not of_board)


def rolled(views: Sequence[View], detections: BoardDetections, mm: float) -> BoardDetections:
    """Corners by a camera that falls so far while it reads a picture, undistorted as if all lay
    as far away as the middle of the limb."""
    in_room = WORLD_FROM_BOARD.apply(BOARD.corners_mm)
    middle = np.array([[0.0, 0.0, 150.0]])
    for k, view in enumerate(views):
        lens, xy_px = view.camera, view.project(in_room)
        far_mm = view.camera_from_world.apply(middle)[0, 2]
        for _ in range(5):  # a row tells when it was read, and this where it shows the corner
            late_mm = mm * (xy_px[:, 1] - lens.cy) / lens.height_px
            seen = view.camera_from_world.apply(in_room)
            seen[:, 1] += late_mm * (seen[:, 2] / far_mm - 1.0)
            xy_px = View(view.name, lens, Rigid.identity()).project(seen)
        detections = with_photo(detections, k, xy_px)
    return detections


def test_a_rolling_shutter_accuses_no_print() -> None:
    """Of a board printed as given, what is left of a shutter's bending makes a length 0.3 % off."""
    lens = Camera(width_px=2400, height_px=1800, fx=1900.0, fy=1900.0, cx=1210.0, cy=890.0, k1=-0.1)
    views = tuple(replace(view, camera=lens) for view in ring(12, 550.0))
    scene = replace(scene_of(views, capsule(500, 1)), cameras=(lens,))
    own = OwnLenses(
        deviations=("rolling shutter",),
        values=np.zeros((12, 4)),
        spread=np.zeros(4),
        shifts=np.zeros((12, 10)),
        chances=(1e-9,),
    )
    true = Capture(views, scene).detections()
    to_millimetres(replace(scene, own=own), rolled(views, true, 3.0))
    with pytest.raises(ScaleError) as refusal:
        to_millimetres(replace(scene, own=own), rolled(views, true, 25.0))
    cause = refusal.value.finding.values["cause"]
    assert isinstance(cause, Finding)
    assert cause.code == "scale.cause.board_or_lens"
    assert cause.values["by"] == "rolling shutter"


@pytest.mark.parametrize("number", [0, 2, 5])
def test_how_a_lens_stretches_the_board(capture, number: int) -> None:
    """Against the same corners located with another focal length, middle or distortion."""
    scene, detections = capture.scene, capture.detections()
    board = find_scene_board(scene, detections)
    corners = board.scene_from_board.apply(detections.corners_mm)
    every = np.arange(len(corners), dtype=np.int32)
    by_cameras = stretch_by_cameras(scene, detections, corners, every)
    (lens,) = scene.cameras
    step = (0.5, 0.0, 0.5, 0.0, 0.0, 1e-4)[number]
    packed = lens.packed.copy()
    packed[number] += step
    other = replace(scene, cameras=(lens.with_parameters(packed),))
    found = find_scene_board(other, detections).stretch - board.stretch
    expected = by_cameras[POSE_SIZE * len(scene.placed) + number] * step
    assert abs(expected) > 1e-9
    assert found == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("stretch_x", [1.002, 0.998])
def test_a_print_stretched_within_what_is_allowed_makes_the_scale_less_sure(
    capture, stretch_x: float
) -> None:
    metric = to_millimetres(capture.scene, capture.detections(stretch_x=stretch_x, noise_px=0.05))
    assert metric.scale.board_stretch == pytest.approx(stretch_x - 1, abs=3e-4)
    assert metric.scale.relative_sigma == pytest.approx(0.001, rel=0.2)
    assert 0.5 < abs(scale_error(metric.scene, capture)) / metric.scale.relative_sigma < 1.96


def test_noise_is_not_taken_for_a_stretched_print(capture) -> None:
    told = [
        to_millimetres(capture.scene, capture.detections(noise_px=0.1, seed=seed)).scale
        for seed in range(12)
    ]
    assert [one.board_stretch for one in told] == [0.0] * 12
    assert max(one.relative_sigma for one in told) < 3e-4


def test_a_stretched_board_that_moved_is_not_blamed_on_the_print_alone(capture) -> None:
    stretched = capture.detections(stretch_x=1.006)
    with pytest.raises(ScaleError) as still:
        to_millimetres(capture.scene, stretched)
    assert "moved" not in str(still.value)

    pushed = stretched
    for k in (0, 4, 8):
        pushed = with_photo(pushed, k, pushed.photos[k].xy_px + np.array([2.0, 0.0]))
    with pytest.raises(ScaleError, match=r"probably moved .* miss each other by \d\.\d px"):
        to_millimetres(capture.scene, pushed)

    photos = len(capture.scene.names)
    restless = replace(Movement.unknown(photos), kind="restless", shift=np.ones(photos))
    with pytest.raises(ScaleError, match=r"the limb and what lies round .* rolling shutter bent"):
        to_millimetres(replace(capture.scene, movement=restless), stretched)


def test_a_board_that_contradicts_a_typed_length_is_refused(capture) -> None:
    ends = np.array([10.0, -60.0, 0.0]), np.array([-40.0, 80.0, 0.0])
    true = capture.distance("edge", *ends, photos=(0, 2, 4))
    metric = to_millimetres(capture.scene, capture.detections(), [true])
    assert metric.scale.source == "board"
    assert [one.role for one in metric.scale.lengths if one.label == "edge"] == ["check"]
    wrong = replace(true, length_mm=true.length_mm * 1.01)
    with pytest.raises(ScaleError, match=r"edge is .* \(-0\.99%.*squares are not as large"):
        to_millimetres(capture.scene, capture.detections(), [wrong])


def test_a_mirrored_board_is_refused(capture) -> None:
    detections = capture.detections()
    across = detections.board.inner[0]
    ids = detections.photos[0].ids
    mirrored = ids // across * across + across - 1 - ids % across
    for k, photo in enumerate(detections.photos):
        detections = with_photo(detections, k, photo.xy_px[mirrored])
    with pytest.raises(ScaleError, match="back to the cameras"):
        to_millimetres(capture.scene, detections)


def test_too_few_corners_are_refused(capture) -> None:
    detections = capture.detections()
    few = tuple(
        replace(photo, ids=photo.ids[:5], xy_px=photo.xy_px[:5], sigmas_px=photo.sigmas_px[:5])
        for photo in detections.photos
    )
    with pytest.raises(ScaleError, match="Only 5 corners"):
        to_millimetres(capture.scene, replace(detections, photos=few))
    with pytest.raises(ScaleError, match="Only 0 corners"):
        to_millimetres(capture.scene, replace(detections, photos=()))


@pytest.mark.parametrize(("sigma_px", "told"), [(0.05, False), (0.25, False), (0.4, True)])
def test_corners_that_miss_each_other_tell_of_a_board_that_moved(
    sigma_px: float, told: bool
) -> None:
    """Those of boards that kept still miss each other by 0.05 to 0.15 px."""
    board: Any = SimpleNamespace(corners=SimpleNamespace(set_aside=(), sigma_px=sigma_px))
    scene: Any = SimpleNamespace(movement=None)
    found = _moved(board, scene)
    assert (found is not None) == told
    if found is not None:
        assert found.code == "board.probably_moved"
