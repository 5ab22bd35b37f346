"""Scale from known distances, marks and from nothing; the world's frame."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from tests.unit.reconstruction.scale.conftest import SCENE_FROM_ROOM

from limbgram.core.errors import OptionsError, ScaleError
from limbgram.core.geometry.frames import fit_similarity
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE
from limbgram.findings import told
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.scale.distances import measure_distances, ruler_of
from limbgram.reconstruction.scale.marks import distance_between_marks, mark_distances
from limbgram.reconstruction.scale.ruler import RulerLength, jackknife_sigma
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.scale.stated_lengths import KnownDistance, Pick
from limbgram.reconstruction.targets.marks import MarkDetections, PhotoMarks, find_marks
from limbgram.reconstruction.targets.plates import MarkPlate, PrintedMark

ENDS = {
    "A-C": (np.array([-60.0, -90.0, 0.0]), np.array([60.0, -90.0, 0.0])),
    "B-D": (np.array([-70.0, -60.0, 0.0]), np.array([70.0, -100.0, 0.0])),
}


def world_from_room(metric, capture):
    truth = np.array([view.centre_in_world for view in capture.room_views])
    return fit_similarity(truth, np.array([view.centre_in_world for view in metric.scene.views]))


def both(capture, photos=(0, 2, 10)):
    return [capture.distance(label, *ends, photos=photos) for label, ends in ENDS.items()]


def test_one_distance_sets_the_scale_and_the_other_checks_it(capture) -> None:
    metric = to_millimetres(capture.scene, None, both(capture))
    assert world_from_room(metric, capture).scale == pytest.approx(1, abs=1e-9)
    assert [one.role for one in metric.scale.lengths] == ["control", "check"]
    assert metric.scale.checked
    assert metric.scale.lengths[1].measured_mm == pytest.approx(145.602198, abs=1e-6)


def test_one_distance_alone_is_visibly_unchecked(capture) -> None:
    metric = to_millimetres(capture.scene, None, both(capture)[:1])
    assert metric.scale.unit == "mm"
    assert not metric.scale.checked


@pytest.mark.parametrize(("factor", "refused"), [(1.005, True), (1.002, False), (0.996, True)])
def test_distances_that_disagree_are_refused(capture, factor: float, refused: bool) -> None:
    """Ends that were found to 0.1 px: 0.4 % of 146 mm are 13 sigmas."""
    first, second = (replace(one, sigma_px=0.1) for one in both(capture))
    second = replace(second, length_mm=second.length_mm * factor)
    if refused:
        with pytest.raises(ScaleError, match=r"B-D is .* where the scale is set by A-C"):
            to_millimetres(capture.scene, None, [first, second])
    else:
        metric = to_millimetres(capture.scene, None, [first, second])
        assert metric.scale.lengths[1].error == pytest.approx(1 / factor - 1, abs=1e-9)


@pytest.mark.parametrize(
    ("photos", "factor", "refused"),
    [
        ((0, 2), 1.008, False),  # 1.16 mm of 146 are 3.4 sigmas
        ((0, 2, 4, 6, 8, 10), 1.008, True),  # 7.5
        ((0, 2, 4, 6, 8, 10), 1.003, False),
        ((0, 2), 1.012, True),  # 5.1
    ],
)
def test_distances_picked_by_hand_are_held_to_their_picks(
    capture, photos: tuple[int, ...], factor: float, refused: bool
) -> None:
    """What picks of half a pixel explain is no contradiction; in more photos they explain less."""
    first, second = both(capture, photos)
    known = [first, replace(second, length_mm=second.length_mm * factor)]
    if refused:
        with pytest.raises(ScaleError, match=r"B-D is .* where the scale is set by A-C"):
            to_millimetres(capture.scene, None, known)
        return
    check = to_millimetres(capture.scene, None, known).scale.lengths[1]
    assert check.error == pytest.approx(1 / factor - 1, abs=1e-9)
    assert abs(check.error) * check.known_mm < 4 * check.sigma_mm


def test_pairs_that_are_picked_as_a_hand_picks_are_hardly_ever_refused(capture) -> None:
    """40 true pairs, each pick off by half a pixel: 0.3 % alone refused a part of them."""
    draw = np.random.default_rng(1)
    off: list[float] = []
    for _ in range(40):
        known = [
            replace(
                one,
                **{
                    end: tuple(
                        replace(pick, x_px=pick.x_px + dx, y_px=pick.y_px + dy)
                        for pick, (dx, dy) in zip(
                            getattr(one, end), draw.normal(0, 0.5, (2, 2)), strict=True
                        )
                    )
                    for end in ("first", "second")
                },
            )
            for one in both(capture, (0, 2))
        ]
        off.append(abs(to_millimetres(capture.scene, None, known).scale.lengths[1].error))
    assert np.mean(np.array(off) > 0.003) > 0.1


def test_a_length_that_a_tape_read_is_held_to_its_own_sigma(capture) -> None:
    """0.73 mm off: less than two sigmas of a tape, and seven of a steel rule."""
    first, second = (replace(one, sigma_px=0.1) for one in both(capture))
    off = replace(second, length_mm=second.length_mm * 1.005)
    taped = replace(off, length_sigma_mm=0.5)
    metric = to_millimetres(capture.scene, None, [first, taped])
    assert metric.scale.lengths[1].error == pytest.approx(1 / 1.005 - 1, abs=1e-9)
    with pytest.raises(ScaleError, match=r"B-D is .* where the scale is set by A-C"):
        to_millimetres(capture.scene, None, [first, replace(off, length_sigma_mm=0.1)])


@pytest.mark.parametrize("number", [0, 2, 5])
def test_how_a_lens_lengthens_a_typed_length(capture, number: int) -> None:
    """Against the same picks with another focal length, middle or distortion."""
    (lens,) = capture.scene.cameras
    given = [both(capture)[1]]
    unknowns = POSE_SIZE * len(capture.scene.placed) + LENS_SIZE
    known = replace(capture.scene, camera_covariance=np.zeros((unknowns, unknowns)))
    ruler = measure_distances(known, given, 0.1, all_check=True)
    step = (0.5, 0.0, 0.5, 0.0, 0.0, 1e-4)[number]
    packed = lens.packed.copy()
    packed[number] += step
    other = replace(known, cameras=(lens.with_parameters(packed),))
    found = measure_distances(other, given, 0.1, all_check=True)
    assert ruler.by_cameras is not None
    expected = ruler.by_cameras[POSE_SIZE * len(known.placed) + number] * step
    assert abs(expected) > 1e-9
    assert found.units_per_mm / ruler.units_per_mm - 1 == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("number", [0, 2, 5])
def test_a_scale_by_distances_depends_on_the_cameras_that_measured_them(
    capture, number: int
) -> None:
    """A lens that lengthens the distance makes all else that much smaller."""
    unknowns = POSE_SIZE * len(capture.scene.placed) + LENS_SIZE
    known = replace(capture.scene, camera_covariance=np.zeros((unknowns, unknowns)))
    given = both(capture)[:1]
    metric = to_millimetres(known, None, given)
    (lens,) = known.cameras
    step = (0.5, 0.0, 0.5, 0.0, 0.0, 1e-4)[number]
    packed = lens.packed.copy()
    packed[number] += step
    other = to_millimetres(replace(known, cameras=(lens.with_parameters(packed),)), None, given)
    grown = world_from_room(other, capture).scale / world_from_room(metric, capture).scale - 1
    assert metric.scale.by_cameras is not None
    expected = metric.scale.by_cameras[POSE_SIZE * len(known.placed) + number] * step
    assert abs(expected) > 1e-9
    assert grown == pytest.approx(expected, rel=0.02)


def test_sigma_follows_the_picks(capture) -> None:
    """Rays 1.5 m long, 0.27 mm per pixel: half a pixel on 120 mm is about a thousandth."""
    coarse, fine = (
        to_millimetres(
            capture.scene, None, [replace(one, sigma_px=sigma) for one in both(capture)[:1]]
        ).scale.relative_sigma
        for sigma in (None, 0.1)
    )
    assert coarse == pytest.approx(5 * fine, rel=1e-6)
    assert 5e-4 < coarse < 2e-3


@pytest.mark.parametrize(
    "photos",
    [
        (0, 2),
        *(pytest.param(one, marks=pytest.mark.slow) for one in ((0, 2, 10), (0, 2, 5, 8, 10))),
    ],
)
def test_picks_that_scatter_more_than_stated_are_believed(capture, photos) -> None:
    """Picks three times as far off as stated: few of them tell it badly, and it is widened."""
    exact = both(capture, photos)[0]
    draw = np.random.default_rng(len(photos))

    def off(picks: tuple[Pick, ...]) -> tuple[Pick, ...]:
        return tuple(
            replace(one, x_px=one.x_px + x, y_px=one.y_px + y)
            for one, (x, y) in zip(picks, 0.3 * draw.normal(size=(len(picks), 2)), strict=True)
        )

    held = []
    for _ in range(500):
        picked = replace(exact, first=off(exact.first), second=off(exact.second))
        (one,) = measure_distances(capture.scene, [picked], 0.1, all_check=True).lengths
        error = one.measured / one.known_mm - SCENE_FROM_ROOM.scale
        held.append(abs(error) * one.known_mm < 1.96 * one.sigma)
    assert 0.93 < np.mean(held) < 0.97


def test_a_check_length_is_as_unsure_as_the_scale_besides(capture) -> None:
    """A length 3.3 times that of the scale: its own picks explain a third of what it is off."""
    ends = {"short": (-45.0, 45.0), "long": (-150.0, 150.0)}
    exact = [
        capture.distance(label, *(np.array([x, -90.0, 0.0]) for x in span), photos=(0, 2, 5, 8, 10))
        for label, span in ends.items()
    ]
    draw = np.random.default_rng(5)

    def off(picks: tuple[Pick, ...]) -> tuple[Pick, ...]:
        return tuple(
            replace(one, x_px=one.x_px + x, y_px=one.y_px + y)
            for one, (x, y) in zip(picks, 0.5 * draw.normal(size=(len(picks), 2)), strict=True)
        )

    ratios = []
    for _ in range(400):
        picked = [replace(one, first=off(one.first), second=off(one.second)) for one in exact]
        ruler = measure_distances(capture.scene, picked, 0.5, all_check=False)
        control, check = ruler.lengths
        error = check.measured - ruler.units_per_mm * check.known_mm
        assert ruler.sigma_of(control, capture.scene) == control.sigma
        ratios.append(error / ruler.sigma_of(check, capture.scene))
    assert 0.85 < np.sqrt(np.mean(np.square(ratios))) < 1.1


@pytest.mark.parametrize("count", [1, 2, 3, 5, 9])
def test_lengths_whose_sigmas_are_right_make_the_scale_as_sure_as_they_are(count: int) -> None:
    """More lengths make it surer: by the root of their number, in the usual draw."""
    draw = np.random.default_rng(count)
    held, sigmas = [], []
    for _ in range(3000):
        lengths = [
            RulerLength(
                label="", known_mm=100.0, measured=100 + 0.1 * off, sigma=0.1, role="control"
            )
            for off in draw.normal(size=count)
        ]
        found = ruler_of(lengths)
        held.append(abs(found.units_per_mm - 1) < 1.96 * found.relative_sigma)
        sigmas.append(found.relative_sigma)
    assert 0.935 < np.mean(held) < 0.97
    assert np.median(sigmas) == pytest.approx(0.001 / math.sqrt(count), rel=0.01)


@pytest.mark.parametrize(("count", "times"), [(2, 100.0), (3, 30.0), (5, 5.0), (9, 3.0)])
def test_lengths_that_differ_more_than_stated_widen_the_scale(count: int, times: float) -> None:
    """Few lengths have to differ by much before their own sigmas are not believed."""
    draw = np.random.default_rng(count)
    held = []
    for _ in range(3000):
        lengths = [
            RulerLength(
                label="",
                known_mm=100.0,
                measured=100 + 0.1 * times * off,
                sigma=0.1,
                role="control",
            )
            for off in draw.normal(size=count)
        ]
        found = ruler_of(lengths)
        held.append(abs(found.units_per_mm - 1) < 1.96 * found.relative_sigma)
    assert 0.93 < np.mean(held) < 0.97


@pytest.mark.parametrize("photos", [3, 4, 8, 15])
def test_a_sigma_from_photos_left_out_in_turn_holds_95_of_100(photos: int) -> None:
    by_photo = np.random.default_rng(photos).normal(size=(5000, photos))
    without = (by_photo.sum(1, keepdims=True) - by_photo) / (photos - 1)
    sigmas = np.array([jackknife_sigma(one) for one in without])
    assert 0.93 < np.mean(np.abs(by_photo.mean(1)) < 1.96 * sigmas) < 0.97


def test_a_tape_adds_its_own_doubt(capture) -> None:
    exact = both(capture)[0]
    taped = replace(exact, length_mm=120.0, length_sigma_mm=0.6)
    sigmas = [
        to_millimetres(capture.scene, None, [one]).scale.relative_sigma for one in (exact, taped)
    ]
    assert sigmas[1] == pytest.approx(np.hypot(sigmas[0], 0.6 / 120.0), rel=1e-3)
    with pytest.raises(OptionsError, match="cannot be uncertain"):
        replace(exact, length_sigma_mm=500.0)


def test_the_length_that_is_known_best_sets_the_scale(capture) -> None:
    """0.48 mm off, less than one sigma of its tape: the exact one given after it was refused."""
    first, second = both(capture)
    taped = replace(first, length_mm=first.length_mm * 1.004, length_sigma_mm=0.6)
    metric = to_millimetres(capture.scene, None, [taped, second])
    assert [one.role for one in metric.scale.lengths] == ["check", "control"]
    assert world_from_room(metric, capture).scale == pytest.approx(1, abs=1e-9)


def test_a_wrong_pick_is_named(capture) -> None:
    first, second = both(capture, photos=(0, 2, 4, 10))
    off = replace(first.first[2], x_px=first.first[2].x_px + 30)
    wrong = replace(first, first=(*first.first[:2], off, first.first[3]))
    with pytest.raises(ScaleError, match=r"A-C: .*photo04\.jpg misses"):
        to_millimetres(capture.scene, None, [wrong, second])


def test_unusable_distances_are_set_aside_or_refused(capture) -> None:
    first, second = both(capture)
    once = replace(first, first=first.first[:1])
    metric = to_millimetres(capture.scene, None, [once, second])
    assert [one.name for one in metric.scale.set_aside] == ["A-C"]
    assert not metric.scale.checked
    with pytest.raises(ScaleError, match="None of the known distances"):
        to_millimetres(capture.scene, None, [once])
    stranger = replace(first, first=(Pick("nobody.jpg", 1.0, 2.0), *first.first))
    with pytest.raises(ScaleError, match=r"nobody\.jpg"):
        to_millimetres(capture.scene, None, [stranger])
    with pytest.raises(OptionsError, match="no length"):
        replace(first, length_mm=-3.0)


def test_without_scale_the_scene_says_so(capture) -> None:
    metric = to_millimetres(capture.scene)
    assert metric.scale.unit == "unitless"
    assert metric.scale.source == "none"
    assert np.isnan(metric.scale.relative_sigma)
    assert world_from_room(metric, capture).scale == pytest.approx(1000 / 1500, rel=0.05)


def test_the_floor_is_found_without_a_board(capture) -> None:
    metric = to_millimetres(capture.scene, None, both(capture))
    moved = world_from_room(metric, capture)
    assert metric.floor_z_mm == pytest.approx(moved.apply(np.zeros((1, 3)))[0, 2], abs=0.1)
    np.testing.assert_allclose(moved.rotation[:, 2], [0, 0, 1], atol=1e-3)
    middle = moved.apply(np.array([[0.0, 0.0, 160.0]]))[0]
    assert np.linalg.norm(middle) < 25


def test_without_a_table_up_is_told_by_the_ring(turned_capture) -> None:
    metric = to_millimetres(turned_capture.scene)
    assert metric.floor_z_mm is None
    up = world_from_room(metric, turned_capture).rotation[:, 2]
    assert up[2] > np.cos(np.radians(5))


def test_marks_are_found_where_perspective_puts_their_centres(tmp_path) -> None:
    """A marker of 200 px drawn under a known homography, in two photos."""
    marker = cv2.aruco.generateImageMarker(
        cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), 7, 200
    )
    sheet = np.full((300, 300), 255, np.uint8)
    sheet[50:250, 50:250] = marker
    centres = []
    for k in range(2):
        onto = np.array([[1.5, 0.4, 60 + 50 * k], [-0.2, 1.2, 150], [4e-4, 3e-4, 1.0]])
        picture = cv2.warpPerspective(sheet, onto, (800, 600), borderValue=255)
        cv2.imwrite(str(tmp_path / f"m{k}.png"), cv2.GaussianBlur(picture, (0, 0), 1.0))
        centre = onto @ (149.5, 149.5, 1.0)
        centres.append(centre[:2] / centre[2])
    found = find_marks(read_photos([tmp_path]), "4X4_50")
    assert found.ids == (7,)
    for photo, centre in zip(found.photos, centres, strict=True):
        assert np.hypot(*(photo.centres_px[0] - centre)) < 0.05
    with pytest.raises(ScaleError, match="Mark 9 was found in 0 photos"):
        distance_between_marks(found, 7, 9, 100.0)


BAR = MarkPlate(
    name="scale bar 1",
    side_mm=20.0,
    marks=(PrintedMark(mark_id=100, x_mm=0, y_mm=0), PrintedMark(mark_id=101, x_mm=120.0, y_mm=0)),
)


def seen_marks(capture, ends: dict[int, np.ndarray], photos=(0, 2, 5, 10)) -> MarkDetections:
    """Marks with their middles at places of the room, exactly where the photos see them."""
    return MarkDetections(
        dictionary=BAR.dictionary,
        photos=tuple(
            PhotoMarks(
                name=capture.room_views[k].name,
                photo_idx=k,
                ids=np.array(list(ends), np.int32),
                corners_px=np.zeros((len(ends), 4, 2)),
                centres_px=np.array(
                    [capture.room_views[k].project(place[None])[0] for place in ends.values()]
                ),
                sigmas_px=np.full(len(ends), 0.02),
                bent=np.zeros(len(ends), bool),
                doubtful_ids=np.zeros(0, np.int32),
                doubts=(),
            )
            for k in photos
        ),
    )


def test_a_scale_bar_sets_the_scale_and_a_smaller_print_makes_a_smaller_scene(capture) -> None:
    marks = seen_marks(capture, dict(zip((100, 101), ENDS["A-C"], strict=True)))
    metric = to_millimetres(capture.scene, None, mark_distances(marks, [BAR]))
    assert metric.scale.source == "distances"
    assert world_from_room(metric, capture).scale == pytest.approx(1, abs=1e-9)
    assert metric.scale.lengths[0].label == "scale bar 1, marks 100 to 101"
    assert (metric.scale.lengths[0].between, metric.scale.lengths[0].marks) == ("plate", (100, 101))
    assert metric.scale.relative_sigma < 2e-4
    smaller = to_millimetres(capture.scene, None, mark_distances(marks, [BAR.grown(0.99)]))
    assert world_from_room(smaller, capture).scale == pytest.approx(0.99, abs=1e-9)


def test_a_length_measured_by_hand_checks_a_scale_bar(capture) -> None:
    """It is given before the bar, and a quarter of a millimetre too long."""
    marks = seen_marks(capture, dict(zip((100, 101), ENDS["A-C"], strict=True)))
    by_hand = both(capture)[1]
    long = replace(by_hand, length_mm=by_hand.length_mm + 0.25)
    metric = to_millimetres(capture.scene, None, [long, *mark_distances(marks, [BAR])])
    assert [one.role for one in metric.scale.lengths] == ["check", "control"]
    assert world_from_room(metric, capture).scale == pytest.approx(1, abs=1e-9)
    assert metric.scale.lengths[0].error == pytest.approx(-0.25 / long.length_mm, abs=1e-9)


def test_a_mark_that_is_not_seen_is_named(capture) -> None:
    marks = seen_marks(capture, {100: ENDS["A-C"][0]})
    distances: list[KnownDistance] = [*mark_distances(marks, [BAR]), *both(capture)]
    metric = to_millimetres(capture.scene, None, distances)
    assert [(one.name, told(one.reason)) for one in metric.scale.set_aside] == [
        ("scale bar 1, marks 100 to 101", "mark 101 is seen in 0 placed photos; 2 are needed")
    ]
    with pytest.raises(ScaleError, match="mark 101 is seen in 0 placed photos"):
        to_millimetres(capture.scene, None, mark_distances(marks, [BAR]))


def test_a_photo_that_misreads_a_mark_is_named_and_one_that_moved_is_refused(capture) -> None:
    marks = seen_marks(capture, dict(zip((100, 101), ENDS["A-C"], strict=True)), (0, 2, 5, 8, 10))
    marks.photos[1].centres_px[0] += 40.0
    metric = to_millimetres(capture.scene, None, mark_distances(marks, [BAR]))
    assert [one.name for one in metric.scale.set_aside] == [marks.photos[1].name]
    assert world_from_room(metric, capture).scale == pytest.approx(1, abs=1e-9)
    marks.photos[3].centres_px[0] -= 30.0
    with pytest.raises(ScaleError, match="do not meet"):
        to_millimetres(capture.scene, None, mark_distances(marks, [BAR]))


def test_one_mark_on_two_plates_is_refused(capture) -> None:
    marks = seen_marks(capture, dict(zip((100, 101), ENDS["A-C"], strict=True)))
    with pytest.raises(OptionsError, match="Mark 100 is on scale bar 1 and on scale bar 1"):
        mark_distances(marks, [BAR, BAR])


def test_no_two_lengths_of_a_plate_share_a_mark() -> None:
    places = [(0, 0), (100, 0), (0, 80), (100, 80), (50, 200)]
    plate = MarkPlate(
        name="mat",
        side_mm=20.0,
        marks=tuple(PrintedMark(mark_id=k, x_mm=x, y_mm=y) for k, (x, y) in enumerate(places)),
    )
    lengths = plate.lengths()
    assert [(one.first_id, one.second_id) for one in lengths] == [(0, 4), (1, 2)]
    assert lengths[0].length_mm == pytest.approx(np.hypot(50, 200))
    assert lengths[1].length_mm == pytest.approx(np.hypot(100, 80))
