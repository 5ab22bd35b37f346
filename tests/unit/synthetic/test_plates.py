"""Plates on the table: their marks are photographed where they truly lie."""

import cv2
import numpy as np

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.targets.marks import marks_in
from limbgram.reconstruction.targets.plates import MarkPlate, PrintedMark
from limbgram.synthetic.props.plates import lay_plates
from limbgram.synthetic.rendering.developing import developed
from limbgram.synthetic.rendering.renderer import Stage, render
from limbgram.synthetic.rendering.shading import Lighting, light_of

CAMERA = Camera(width_px=900, height_px=600, fx=2100.0, fy=2100.0, cx=451.0, cy=298.0, k1=-0.08)
BAR = MarkPlate(
    name="bar",
    side_mm=20.0,
    marks=(
        PrintedMark(mark_id=100, x_mm=26.0, y_mm=35.0),
        PrintedMark(mark_id=101, x_mm=246.0, y_mm=35.0),
    ),
)


def test_marks_of_a_laid_plate_are_seen_where_they_lie() -> None:
    (laid,) = lay_plates([BAR], np.array([-100.0, 40.0, 0.0]))
    first, second = laid.middles_mm[100], laid.middles_mm[101]
    np.testing.assert_allclose(np.linalg.norm(second - first), 220.0, atol=1e-9)
    centre = np.array([500.0, -250.0, 560.0])
    up = np.array([0.0, 0.0, 1.0])
    view = View("a", CAMERA, Rigid.looking_at(centre, (first + second) / 2, up))
    light = light_of(Lighting(), view.camera_from_world, 800.0, np.zeros(3))
    picture = developed(render(view, Stage((laid.panel,)), light), 0.5, np.random.default_rng(1))
    found = marks_in(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), camera=CAMERA)
    assert [one.mark_id for one in found] == [100, 101]
    for one, place in zip(found, (first, second), strict=True):
        assert one.fit is not None
        off_px = one.fit.centre_px - view.project(place[None])[0]
        assert 1e-5 < np.linalg.norm(off_px) < 0.06
