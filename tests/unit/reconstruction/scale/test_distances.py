"""Scale from known distances, marks and from nothing; the world's frame."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from limbgram.core.errors import OptionsError, ScaleError
from limbgram.core.geometry.frames import fit_similarity
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.scale.distances import Pick, distance_between_marks, find_markers
from limbgram.reconstruction.scale.scaling import ScaleOptions, to_millimetres

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
    first, second = both(capture)
    second = replace(second, length_mm=second.length_mm * factor)
    if refused:
        with pytest.raises(ScaleError, match=r"B-D is .* where the scale is set by A-C"):
            to_millimetres(capture.scene, None, [first, second])
    else:
        metric = to_millimetres(capture.scene, None, [first, second])
        assert metric.scale.lengths[1].error == pytest.approx(1 / factor - 1, abs=1e-9)


def test_sigma_follows_the_picks(capture) -> None:
    """Rays 1.5 m long, 0.27 mm per pixel: half a pixel on 120 mm is about a thousandth."""
    coarse, fine = (
        to_millimetres(
            capture.scene, None, both(capture)[:1], ScaleOptions(pick_sigma_px=sigma)
        ).scale.relative_sigma
        for sigma in (0.5, 0.1)
    )
    assert coarse == pytest.approx(5 * fine, rel=1e-6)
    assert 5e-4 < coarse < 2e-3


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
    observations = find_markers(read_photos([tmp_path]), "4X4_50")
    assert [one.mark_id for one in observations] == [7, 7]
    for one, centre in zip(observations, centres, strict=True):
        assert np.hypot(one.pick.x_px - centre[0], one.pick.y_px - centre[1]) < 0.5
    with pytest.raises(ScaleError, match="Marker 9 was found in 0 photos"):
        distance_between_marks(observations, 7, 9, 100.0)
