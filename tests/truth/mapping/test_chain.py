"""The classical chain: it gets round the limb, and what it lacks beside the adjusted ring shows."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.frames import Rigid, angle_between_deg, fit_similarity
from limbgram.findings import told
from limbgram.reconstruction.mapping.chain import chain, resect
from limbgram.reconstruction.mapping.ring import place
from limbgram.reconstruction.twoview.pairs import Pairs
from limbgram.reconstruction.twoview.verification import verify


@pytest.fixture(scope="module")
def pairs(good_capture: Any) -> Pairs:
    return verify(good_capture.photos, good_capture.matches, good_capture.cameras)


def centre_rms_mm(centres: np.ndarray, truth: np.ndarray) -> float:
    error = fit_similarity(centres, truth).apply(centres) - truth
    return float(np.sqrt(np.mean(np.sum(error**2, axis=1))))


def test_chain_goes_round_but_the_ring_is_better(good_capture: Any, pairs: Pairs) -> None:
    found = chain(good_capture.photos, pairs, good_capture.cameras)
    truth = np.array([view.centre_in_world for view in good_capture.views])
    chained = centre_rms_mm(np.array([view.centre_in_world for view in found.views]), truth)
    scene = place(good_capture.photos, good_capture.features, pairs, good_capture.cameras)
    ringed = centre_rms_mm(np.array([view.centre_in_world for view in scene.views]), truth)
    assert len(found.views) == len(truth)
    assert len(found.points_in_world) == len(truth) - 1
    assert 1.3 * ringed < chained < 10.0


def test_resection_finds_the_pose_among_wrong_points(good_capture: Any) -> None:
    view, points = good_capture.views[0], good_capture.points_mm[:300]
    xy_px = view.project(points)
    xy_px[::5] += 60.0
    pose = resect(view.camera, points, xy_px)
    assert pose is not None
    assert angle_between_deg(pose.rotation, view.camera_from_world.rotation) < 1e-3
    np.testing.assert_allclose(pose.centre, view.centre_in_world, atol=0.01)
    assert resect(view.camera, points[:5], xy_px[:5]) is None


def test_a_missing_link_is_named(good_capture: Any, pairs: Pairs) -> None:
    broken = tuple(
        pair for pair in pairs.verified if (pair.matches.first, pair.matches.second) != (3, 4)
    )
    with pytest.raises(PlacementError, match=r"IMG_0003.*IMG_0004"):
        chain(good_capture.photos, Pairs(broken, 1), good_capture.cameras)


def test_a_photo_that_contradicts_its_pairs_is_not_placed(
    make_capture: Callable[..., Any],
) -> None:
    """Pairs that claim another turn than the scene has: the guard against a folded scene."""
    capture = make_capture(photos=9, points=700)
    pairs = verify(capture.photos, capture.matches, capture.cameras)
    quarter = Rigid.from_rotation_vector(np.array([0.0, 1.5, 0.0]), np.zeros(3))
    lying = tuple(
        replace(pair, second_from_first=quarter @ pair.second_from_first)
        if 2 in (pair.matches.first, pair.matches.second) and pair.second_from_first
        else pair
        for pair in pairs.verified
    )
    scene = place(capture.photos, capture.features, Pairs(lying, 0), capture.cameras)
    assert [verdict.name for verdict in scene.verdicts if not verdict.placed] == ["IMG_0002.jpg"]
    assert "contradicts" in told(scene.verdicts[2].reason)
