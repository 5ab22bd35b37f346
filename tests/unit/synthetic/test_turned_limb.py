"""Limbs that move in the room: what stands still in the picture, and what lies on the table."""

from dataclasses import replace

import numpy as np

from limbgram.synthetic.options import SMALL
from limbgram.synthetic.truth import stage_truth
from limbgram.synthetic.turned_limb import TurnedOver, Turning

TURNING = replace(SMALL, turning=Turning(sway_mm=4.0), photos=12, rings=2, calibration_photos=0)
ON_THE_WALL = np.array([[200.0, 300.0, 400.0], [-150.0, 200.0, 10.0]])


def test_before_a_turning_limb_the_room_stands_still_in_the_picture() -> None:
    """Within each ring a point of the room has one pixel, and a point of the limb has many."""
    truth = stage_truth(TURNING)
    room = np.array(
        [
            view.project(moved.inverse.apply(ON_THE_WALL))
            for view, moved in zip(truth.views, truth.room_from_limb, strict=True)
        ]
    )
    np.testing.assert_allclose(room[:6], np.broadcast_to(room[0], room[:6].shape), atol=1e-8)
    assert np.linalg.norm(room[6] - room[0], axis=1).min() > 20
    skin = truth.limb.mesh.vertices_mm[[500, 5000]]
    moved_px = np.array([view.project(skin) for view in truth.views[:6]])
    assert np.ptp(moved_px, axis=0).max() > 30


def test_the_limb_goes_all_round_and_sways_by_what_was_asked() -> None:
    truth = stage_truth(replace(TURNING, rings=1))
    turns = [np.arctan2(*one.rotation[[1, 0], 0]) for one in truth.room_from_limb]
    steps = np.diff(np.unwrap(turns))
    assert 0.6 * np.pi / 6 < steps.min() <= steps.max() < 1.4 * np.pi / 6
    shifts = np.array([one.translation for one in truth.room_from_limb])[:, :2]
    assert 1.0 < shifts.std() < 10.0


def test_a_cast_that_is_turned_over_lies_on_the_table() -> None:
    truth = stage_truth(replace(TURNING, turning=TurnedOver(), rings=SMALL.rings))
    skin = truth.limb.mesh.vertices_mm
    assert all((one.rotation == np.eye(3)).all() for one in truth.room_from_limb[:6])
    lying = truth.room_from_limb[-1].apply(skin)
    assert abs(lying[:, 2].min()) < 1e-9
    assert lying[:, 2].max() < 150 < skin[:, 2].max()  # 270 mm long
    np.testing.assert_allclose(lying[:, :2].max(0), -lying[:, :2].min(0), atol=1e-9)
