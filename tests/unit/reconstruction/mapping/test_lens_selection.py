"""Lenses of single photos: asked for where photos differ, found as they were, left alone else."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.lens import LENS_SIZE, PARAMETERS, POSE_SIZE, Camera
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.hypotheses.lens_explanations import lens_explanations
from limbgram.reconstruction.mapping.bundle_adjustment import (
    Adjusted,
    adjust,
    split_statistics,
)
from limbgram.reconstruction.mapping.lens_deviations import (
    PRIOR_SPREAD,
    PhotoLenses,
    basis_of,
    implausible_deviations,
    with_deviation,
    with_photo_lenses,
)
from limbgram.reconstruction.mapping.lens_selection import (
    lens_scores,
    supported_kind,
    with_supported_lenses,
)
from limbgram.reconstruction.mapping.scene import Deviation, Explanation, Observations, Scene
from limbgram.reconstruction.mapping.two_bodies import AIC_PER_PARAMETER, explained_by_two_bodies

MakeScene = Callable[..., Scene]
LENS = Camera(width_px=900, height_px=900, fx=700.0, fy=700.0, cx=450.0, cy=450.0, k1=-0.05)
"""As wide as a phone's."""
CALIBRATED = Calibration(
    camera=LENS,
    covariance=np.diag([0.2, 0.2, 0.5, 0.5, 0.0, 1e-3, 1e-3, 1e-4, 1e-4, 0.0]) ** 2,
    source="board",
)
NOISE_PX = 0.05
PHOTOS = 12


def near(make_scene: MakeScene, seed: int = 1) -> Scene:
    """Photos that the points fill, measured without an error."""
    scene = make_scene(photos=PHOTOS, points=400, seed=seed, lenses=(LENS,))
    points = scene.points_in_world * 3.0
    views = [scene.view(k) for k in scene.placed]
    seen = scene.observations
    xy_px = np.empty((len(seen.photo_idx), 2))
    for k, view in enumerate(views):
        rows = seen.photo_idx == k
        xy_px[rows] = view.project(points[seen.point_idx[rows]])
    inside = LENS.contains(xy_px)
    kept = Observations(seen.photo_idx[inside], seen.point_idx[inside], xy_px[inside])
    return replace(scene, points_in_world=points, observations=kept)


def taken(scene: Scene, seed: int, photo_of: Callable[[int, np.ndarray], np.ndarray]) -> Scene:
    """The scene as photos show it of which each projects points in its own way, with noise."""
    seen, xy_px = scene.observations, scene.observations.xy_px.copy()
    for photo in scene.placed:
        rows = seen.photo_idx == photo
        xy_px[rows] = photo_of(photo, scene.points_in_world[seen.point_idx[rows]])
    xy_px += np.random.default_rng(seed).normal(0.0, NOISE_PX, xy_px.shape)
    return replace(scene, observations=replace(seen, xy_px=xy_px))


def stabilised(scene: Scene, seed: int, sigma_px: float) -> tuple[Scene, np.ndarray]:
    shifts = np.random.default_rng(seed).normal(0.0, sigma_px, (PHOTOS, 2))
    return taken(scene, seed, lambda k, points: scene.view(k).project(points) + shifts[k]), shifts


def fixed(scene: Scene) -> Adjusted:
    return adjust(scene, [CALIBRATED])


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 6))]
)
def test_photos_of_one_lens_ask_for_nothing(make_scene: MakeScene, seed: int) -> None:
    scene = near(make_scene, seed)
    plain = taken(scene, seed, lambda k, points: scene.view(k).project(points))
    first = fixed(plain)
    scores = lens_scores(first, [CALIBRATED])
    assert [one.deviation for one in scores] == [
        "principal point", "focal length", "rolling shutter",
    ]  # fmt: skip
    assert all(0.0 < one.statistic < one.dof for one in scores), "counted in inflated sigmas"
    assert with_supported_lenses(first, plain, [CALIBRATED]) is first


def test_a_stabiliser_is_found_and_solved_for(make_scene: MakeScene) -> None:
    scene = near(make_scene)
    faulty, shifts = stabilised(scene, 3, 2.0)
    before = fixed(faulty)
    asked = supported_kind(before, [CALIBRATED])
    assert asked is not None
    assert asked.deviation == "principal point"
    assert asked.p_value < 1e-12
    after = with_supported_lenses(before, faulty, [CALIBRATED])
    assert before.sigma_px > 1.1 * after.sigma_px
    assert 0.9 * NOISE_PX < after.sigma_px < 1.1 * NOISE_PX
    own = after.scene.own
    assert own is not None
    assert own.deviations == ("principal point",)
    found = own.shifts[:, 2:4]
    assert np.abs(own.shifts[:, [0, 1, 4, 5, 6, 7, 8, 9]]).max() == 0.0
    off = (found - found.mean(0)) - (shifts - shifts.mean(0))
    assert 0.01 < np.sqrt((off**2).mean()) < 0.5, "the shifts come out as they were"
    np.testing.assert_allclose(own.spread * LENS.width_px, shifts.std(0), rtol=0.3)


@pytest.mark.parametrize(
    ("seed", "share", "asks"),
    [
        (8, 0.0007, True),
        (6, 0.002, False),
        pytest.param(4, 0.001, True, marks=pytest.mark.slow),
        pytest.param(4, 0.002, True, marks=pytest.mark.slow),
        pytest.param(3, 0.002, False, marks=pytest.mark.slow),
    ],
)
def test_what_moved_half_of_the_points_is_no_lens(
    make_scene: MakeScene, seed: int, share: float, asks: bool
) -> None:
    """Where the residuals ask for own lenses, two bodies explain more."""
    scene = near(make_scene, seed)
    middle = float(np.median(scene.points_in_world[:, 0]))
    size = float(np.ptp(scene.points_in_world))
    moves = np.random.default_rng(seed).normal(0.0, share * size, (PHOTOS, 3))

    def swaying(k: int, points: np.ndarray) -> np.ndarray:
        return scene.view(k).project(points + np.where(points[:, :1] > middle, moves[k], 0.0))

    faulty = taken(scene, seed, swaying)
    before = fixed(faulty)
    assert (min(one.p_value for one in lens_scores(before, [CALIBRATED])) < 1e-6) is asks
    assert with_supported_lenses(before, faulty, [CALIBRATED]) is before


def stepped(scene: Scene, share: float, at: int, seed: int = 3) -> tuple[Scene, np.ndarray]:
    """A part of the points stands elsewhere from one photo on; and which points these are."""
    edge = float(np.quantile(scene.points_in_world[:, 0], 0.3))
    part = scene.points_in_world[:, 0] < edge
    move = share * float(np.ptp(scene.points_in_world)) * np.array([0.6, -0.64, 0.48])

    def seen(k: int, points: np.ndarray) -> np.ndarray:
        return scene.view(k).project(points + np.where((points[:, :1] < edge) & (k >= at), move, 0))

    return taken(scene, seed, seen), part


@pytest.mark.parametrize(
    "seed", [3, *(pytest.param(one, marks=pytest.mark.slow) for one in (5, 6))]
)
def test_a_body_that_steps_once_counts_with_one_motion(make_scene: MakeScene, seed: int) -> None:
    """A motion for each photo would be too many numbers to say that anything moved."""
    scene = near(make_scene, seed)
    faulty, part = stepped(scene, 0.0005, 5, seed)
    before = fixed(faulty)
    base = with_photo_lenses(before.scene)
    each = split_statistics(base, [CALIBRATED], before.sigma_px, 10**9, [part])[0, 0]
    assert each < AIC_PER_PARAMETER * POSE_SIZE * PHOTOS
    explained = explained_by_two_bodies(before, [CALIBRATED], 10**9)
    assert explained > 15
    assert all(
        one.statistic - AIC_PER_PARAMETER * one.dof < 0 for one in lens_scores(before, [CALIBRATED])
    )
    still = taken(scene, seed, lambda k, points: scene.view(k).project(points))
    assert explained_by_two_bodies(fixed(still), [CALIBRATED], 10**9) < 0


def test_a_course_explains_no_more_than_motions_of_every_photo(make_scene: MakeScene) -> None:
    """And as much where the body moved so."""
    faulty, part = stepped(near(make_scene, 3), 0.0007, 5)
    before = fixed(faulty)
    base = with_photo_lenses(before.scene)
    at = np.arange(PHOTOS)[:, None] >= np.arange(1, PHOTOS)
    even = np.linspace(0.0, 1.0, PHOTOS)[:, None]
    courses = np.hstack([at, even])
    falls = split_statistics(base, [CALIBRATED], before.sigma_px, 10**9, [part, ~part], courses)
    each, along = falls[:, 0], falls[:, 1:]
    assert (along < each[:, None]).all()
    np.testing.assert_array_equal(along.argmax(axis=1), [4, 4])
    np.testing.assert_allclose(along[0], along[1], rtol=1e-3)  # whichever part moves
    assert along[0, 4] > 0.8 * each[0]
    assert along[0, 4] > 1.1 * along[0, [3, 5, PHOTOS - 1]].max()


def test_two_bodies_explain_what_moved_one_of_them(make_scene: MakeScene) -> None:
    """Cut where they touch they explain all of it; cut at random, next to nothing."""
    scene = near(make_scene, 3)
    size = float(np.ptp(scene.points_in_world))
    moves = np.random.default_rng(3).normal(0.0, 0.0002 * size, (PHOTOS, 3))

    def swaying(k: int, points: np.ndarray) -> np.ndarray:
        middle = np.median(scene.points_in_world[:, 0])
        return scene.view(k).project(points + np.where(points[:, :1] < middle, moves[k], 0.0))

    for faulty, moved in ((taken(scene, 3, swaying), True), (stabilised(scene, 3, 2.0)[0], False)):
        before = fixed(faulty)
        base = with_photo_lenses(before.scene)
        low = base.points_in_world[:, 0] < np.median(base.points_in_world[:, 0])
        mixed = np.random.default_rng(0).random(len(low)) < 0.5
        true, other = split_statistics(base, [CALIBRATED], before.sigma_px, 10**9, [low, mixed])[
            :, 0
        ]
        lens = max(one.statistic for one in lens_scores(before, [CALIBRATED]))
        assert other < 0.5 * max(true, lens)
        assert bool(true > lens) is moved
        each = AIC_PER_PARAMETER * POSE_SIZE * PHOTOS
        assert explained_by_two_bodies(before, [CALIBRATED], 10**9) > 0.2 * true - each


def test_too_few_photos_ask_for_nothing(make_scene: MakeScene) -> None:
    few = make_scene(photos=5, points=200, lenses=(LENS,))
    adjusted = fixed(few)
    assert lens_scores(adjusted, [CALIBRATED]) == ()
    assert supported_kind(adjusted, [CALIBRATED]) is None


def test_the_covariance_has_a_lens_for_every_photo(make_scene: MakeScene) -> None:
    scene = near(make_scene)
    faulty, shifts = stabilised(scene, 4, 2.0)
    after = with_supported_lenses(fixed(faulty), faulty, [CALIBRATED])
    rows = (POSE_SIZE + len(PARAMETERS)) * PHOTOS
    assert after.covariance.shape == (rows, rows)
    assert after.lens_covariance.shape == (1, LENS_SIZE, LENS_SIZE)
    assert after.scene.lens_idx == tuple(range(PHOTOS))
    assert after.scene.lenses == PHOTOS
    variance = np.diag(after.covariance)[POSE_SIZE * PHOTOS :].reshape(PHOTOS, LENS_SIZE)
    assert (variance[:, 4] == 0).all(), "skew is held"
    found = np.array([after.scene.camera(k).packed[2:4] for k in range(PHOTOS)])
    off = (found - 450.0 - shifts) / np.sqrt(variance[:, 2:4])
    assert 0.1 < np.sqrt((off**2).mean()) < 1.0, "a third: pixels count with thrice their sigma"
    assert len(fixed(faulty).covariance) == POSE_SIZE * PHOTOS + LENS_SIZE


def test_refocusing_is_told_from_a_stabiliser(make_scene: MakeScene) -> None:
    scene = near(make_scene)
    longer = np.random.default_rng(5).normal(1.0, 0.003, PHOTOS)

    def breathing(k: int, points: np.ndarray) -> np.ndarray:
        lens = replace(LENS, fx=LENS.fx * longer[k], fy=LENS.fy * longer[k])
        return replace(scene.view(k), camera=lens).project(points)

    faulty = taken(scene, 5, breathing)
    after = with_supported_lenses(fixed(faulty), faulty, [CALIBRATED])
    own = after.scene.own
    assert own is not None
    assert own.deviations == ("focal length",)
    found = np.array([after.scene.camera(k).fx for k in range(PHOTOS)]) / LENS.fx
    np.testing.assert_allclose(found / found.mean(), longer / longer.mean(), atol=4e-4)
    assert after.sigma_px < 1.1 * NOISE_PX


def rolled(scene: Scene, turns: np.ndarray, longer: np.ndarray) -> Scene:
    """Photos whose camera turns (rad) from the first row to the last, with focal lengths of their
    own."""

    def rolling(k: int, points: np.ndarray) -> np.ndarray:
        lens = replace(LENS, fx=longer[k] * LENS.fx, fy=longer[k] * LENS.fy)
        in_camera = scene.view(k).camera_from_world.apply(points)
        xy_px = lens.project(in_camera)
        for _ in range(5):  # the row that a point falls on tells when it was taken
            when = xy_px[:, 1] / LENS.height_px - 0.5
            xy_px = lens.project(Rotation.from_rotvec(when[:, None] * turns[k]).apply(in_camera))
        return xy_px

    return taken(scene, 6, rolling)


def test_a_rolling_shutter_is_found(make_scene: MakeScene) -> None:
    """The camera turns and rolls while it reads its rows, to the second order in nothing."""
    turns = np.random.default_rng(6).normal(0.0, 0.004, (PHOTOS, 3))
    faulty = rolled(near(make_scene), turns, np.ones(PHOTOS))
    before = fixed(faulty)
    after = with_supported_lenses(before, faulty, [CALIBRATED])
    own = after.scene.own
    assert own is not None
    assert own.deviations[0] == "rolling shutter"
    assert before.sigma_px > 2.0 * NOISE_PX
    assert after.sigma_px < 1.3 * NOISE_PX


def test_beside_a_strong_rolling_shutter_no_other_kind_is_a_fact(make_scene: MakeScene) -> None:
    """What its numbers, which hold for one distance, leave looks like one."""
    draw = np.random.default_rng(6)
    turns, longer = draw.normal(0.0, 0.006, (PHOTOS, 3)), draw.normal(1.0, 0.01, PHOTOS)
    faulty = rolled(near(make_scene), turns, longer)
    found = told(with_supported_lenses(fixed(faulty), faulty, [CALIBRATED]).scene)
    rules = {one.kind: one.failed for one in found}
    assert rules["rolling shutter"] == ()
    assert "lens" in rules["focal length"]


def test_lenses_of_single_photos_are_held_unless_they_are_solved_for(
    make_scene: MakeScene,
) -> None:
    scene = near(make_scene)
    faulty, _ = stabilised(scene, 7, 2.0)
    found = with_supported_lenses(fixed(faulty), faulty, [CALIBRATED]).scene
    held = adjust(found, [CALIBRATED]).scene
    assert held.own is not None
    assert found.own is not None
    np.testing.assert_allclose(held.own.shifts, found.own.shifts, atol=1e-9)
    anew = adjust(shaken_values(found), [CALIBRATED], solve_own=True).scene
    assert anew.own is not None
    assert np.abs(found.own.shifts[:, 2]).max() > 2.0
    off = (anew.own.shifts - found.own.shifts)[:, 2:4]
    assert np.sqrt((off**2).mean()) < 0.4, "from 1 px beside"


def shaken_values(scene: Scene) -> Scene:
    """With other principal points to start from."""
    assert scene.own is not None
    off = np.random.default_rng(0).normal(0.0, 1.0, scene.own.values.shape)
    shifts = scene.own.shifts.copy()
    shifts[:, 2:4] += off
    values = scene.own.values + off / LENS.width_px
    return replace(scene, own=replace(scene.own, values=values, shifts=shifts))


@pytest.mark.parametrize(
    "kinds", [("principal point",), ("rolling shutter", "focal length", "principal point")]
)
def test_lenses_follow_their_numbers_as_the_map_says(
    make_scene: MakeScene, kinds: tuple[Deviation, ...]
) -> None:
    scene = with_photo_lenses(near(make_scene))
    for kind in kinds:
        scene = with_deviation(scene, kind)
    photo_lenses = PhotoLenses.of(scene, [LENS], solve=True)
    size = POSE_SIZE * PHOTOS
    step = np.random.default_rng(0).normal(0.0, 1e-3, size + LENS_SIZE + photo_lenses.values.size)
    moved = photo_lenses.moved(step[size:]).lenses - photo_lenses.lenses
    np.testing.assert_allclose((photo_lenses.jacobian @ step)[size:], moved.ravel(), atol=1e-10)
    np.testing.assert_allclose((photo_lenses.jacobian @ step)[:size], step[:size])
    assert basis_of(kinds, LENS).shape == (LENS_SIZE, photo_lenses.values.shape[1])


def test_a_roll_of_the_rows_is_a_shift_and_a_tangential_distortion() -> None:
    """To first order, once the camera is turned: the formula in the head of the module."""
    lens = replace(LENS, k1=0.0)
    x, y = np.random.default_rng(1).uniform(-0.5, 0.5, (2, 50))
    rate = 1e-5
    rolled = np.stack([x - rate * y * y, y + rate * x * y], axis=1)
    column = basis_of(("rolling shutter",), lens)[:, 2]
    bent = lens.with_parameters(lens.packed - rate * column)
    turned = np.stack([x + 3 * rate * (1 + x * x), y + 3 * rate * x * y, np.ones(50)], axis=1)
    ideal = np.column_stack([rolled, np.ones(50)])
    np.testing.assert_allclose(bent.project(turned), lens.project(ideal), atol=1e-6)


def test_a_camera_carried_along_its_axis_shifts_the_principal_point() -> None:
    """To first order, once the camera is turned: the formula in the head of the module."""
    lens = replace(LENS, k1=0.0)
    x, y = np.random.default_rng(2).uniform(-0.5, 0.5, (2, 50))
    rate = 1e-5
    nearer = np.column_stack([x + rate * x * y, y + rate * y * y, np.ones(50)])
    column = basis_of(("rolling shutter",), lens)[:, 3]
    shifted = lens.with_parameters(lens.packed - rate * column)
    turned = np.column_stack([x + rate * x * y, y + rate * (1 + y * y), np.ones(50)])
    np.testing.assert_allclose(shifted.project(turned), lens.project(nearer), atol=1e-6)


def told(scene: Scene, calibration: Calibration = CALIBRATED) -> tuple[Explanation, ...]:
    size = float(np.ptp(scene.points_in_world))
    return lens_explanations(scene, [calibration], scene.points_in_world, size / 600.0)


@pytest.mark.parametrize(("sigma_px", "fact"), [(2.0, False), (4.0, True)])
def test_a_stabiliser_is_a_fact_where_it_matters_on_the_limb(
    make_scene: MakeScene, sigma_px: float, fact: bool
) -> None:
    """A turn of the camera takes most of what it does."""
    scene = near(make_scene)
    faulty, shifts = stabilised(scene, 3, sigma_px)
    after = with_supported_lenses(fixed(faulty), faulty, [CALIBRATED])
    (one,) = told(after.scene)
    assert one.kind == "principal point"
    assert one.is_fact is fact
    assert fact or one.failed == ("size",)
    moved = np.linalg.norm(shifts - shifts.mean(0), axis=1)
    assert int(moved.argmax()) in one.photos
    assert one.low < one.effect < one.high


@pytest.mark.parametrize(("sigma_px", "fact"), [(2.0, False), (4.0, True)])
def test_a_stabiliser_is_a_fact_where_no_usual_one_moves_as_far(
    make_scene: MakeScene, sigma_px: float, fact: bool
) -> None:
    """However little that is on a limb; 0.0025 of the picture's width is usual."""
    faulty, _ = stabilised(near(make_scene), 3, sigma_px)
    scene = with_supported_lenses(fixed(faulty), faulty, [CALIBRATED]).scene
    mm = float(np.ptp(scene.points_in_world)) / 10.0
    (one,) = lens_explanations(scene, [CALIBRATED], scene.points_in_world, mm)
    assert one.high < one.floor
    assert one.is_fact is fact


@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_a_stabiliser_that_turns_the_view_by_two_degrees_is_told(
    make_scene: MakeScene, seed: int
) -> None:
    """2.5 % of the width, as sensors do that are shifted; all else comes out as without it."""
    faulty, shifts = stabilised(near(make_scene), seed, 0.025 * LENS.width_px)
    after = with_supported_lenses(fixed(faulty), faulty, [CALIBRATED])
    assert after.sigma_px == pytest.approx(NOISE_PX, rel=0.1)
    (one,) = told(after.scene)
    assert one.kind == "principal point"
    assert one.is_fact
    own = after.scene.own
    assert own is not None
    np.testing.assert_allclose(own.spread * LENS.width_px, shifts.std(0), rtol=0.3)


def test_a_spread_that_few_photos_show_by_chance_is_no_fault_beyond_cameras(
    make_scene: MakeScene,
) -> None:
    scene = with_deviation(with_photo_lenses(near(make_scene)), "principal point")
    assert scene.own is not None
    for wider, beyond in ((1.05, ()), (2.0, ("principal point",))):
        own = replace(scene.own, spread=wider * np.full(2, PRIOR_SPREAD["principal point"]))
        assert implausible_deviations(replace(scene, own=own)) == beyond


def test_what_an_uncalibrated_lens_was_freed_for_is_no_fact(make_scene: MakeScene) -> None:
    by_exif = replace(CALIBRATED, source="exif")
    faulty, _ = stabilised(near(make_scene), 3, 4.0)
    after = with_supported_lenses(adjust(faulty, [by_exif]), faulty, [by_exif])
    assert after.scene.own is not None
    (one,) = told(after.scene, by_exif)
    assert one.failed == ("model",)


def test_what_all_photos_have_alike_is_the_camera_file(make_scene: MakeScene) -> None:
    """Its focal length comes out with its sigma, whatever was freed to explain it."""
    scene = near(make_scene)
    longer = replace(LENS, fx=1.01 * LENS.fx, fy=1.01 * LENS.fy)

    def seen(k: int, points: np.ndarray) -> np.ndarray:
        return replace(scene.view(k), camera=longer).project(points)

    faulty = taken(scene, 5, seen)
    found = told(with_supported_lenses(fixed(faulty), faulty, [CALIBRATED]).scene)
    facts = {one.kind: one for one in found if one.is_fact}
    assert {*facts} == {"camera file"}
    assert facts["camera file"].low < 0.01 < facts["camera file"].high
    plain = taken(scene, 5, lambda k, points: scene.view(k).project(points))
    assert told(fixed(plain).scene) == ()
