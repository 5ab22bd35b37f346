"""Plates on the table: their marks are photographed where they truly lie."""

from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.geometry.triangulation import triangulate
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.scale.marks import mark_distances
from limbgram.reconstruction.targets.marks import find_marks, marks_in
from limbgram.reconstruction.targets.plates import MarkPlate, PrintedMark
from limbgram.synthetic.props.plates import lay_plates
from limbgram.synthetic.rendering.developing import developed
from limbgram.synthetic.rendering.renderer import RenderScene, render
from limbgram.synthetic.rendering.shading import Lighting, light_of

CAMERA = Camera(width_px=900, height_px=600, fx=2100.0, fy=2100.0, cx=451.0, cy=298.0, k1=-0.08)
RNG = np.random.default_rng(3)
BAR = MarkPlate(
    name="bar",
    side_mm=20.0,
    marks=(
        PrintedMark(mark_id=100, x_mm=26.0, y_mm=35.0),
        PrintedMark(mark_id=101, x_mm=246.0, y_mm=35.0),
    ),
)


def test_a_bar_seen_from_four_sides_has_its_length(tmp_path: Path) -> None:
    """Photos on disk, marks found in them, their middles met: 220 mm to some hundredths."""
    (laid,) = lay_plates([BAR], np.array([-100.0, 40.0, 0.0]))
    ends = np.array([laid.middles_mm[100], laid.middles_mm[101]])
    up, views = np.array([0.0, 0.0, 1.0]), []
    centres = [(480, -250, 560), (-60, -420, 600), (250, 380, 700), (60, 60, 800)]
    for k, centre in enumerate(centres):
        pose = Rigid.looking_at(np.array(centre, float), ends.mean(0), up)
        views.append(View(f"{k}.png", CAMERA, pose))
        light = light_of(Lighting(), pose, 800.0, np.zeros(3))
        picture = developed(render(views[k], RenderScene((laid.panel,)), light), 1.0, RNG)
        Image.fromarray(picture).save(tmp_path / f"{k}.png")
    found = find_marks(read_photos([tmp_path]), lenses=(CAMERA,) * 4)
    (distance,) = mark_distances(found, [BAR])
    assert distance.length_mm == 220.0
    met = []
    for picks in (distance.first, distance.second):
        seen = [view for view in views if view.name in {pick.photo for pick in picks}]
        assert len(seen) == len(picks) >= 3
        order = np.arange(len(seen), dtype=np.int32)
        xy_px = np.array([(pick.x_px, pick.y_px) for pick in picks])
        point = triangulate(seen, order, np.zeros(len(seen), np.int32), xy_px, 1)
        met.append(point.points_in_world[0])
    assert 1e-6 < abs(np.linalg.norm(met[1] - met[0]) - 220.0) < 0.03


def test_marks_of_a_laid_plate_are_seen_where_they_lie() -> None:
    (laid,) = lay_plates([BAR], np.array([-100.0, 40.0, 0.0]))
    first, second = laid.middles_mm[100], laid.middles_mm[101]
    np.testing.assert_allclose(np.linalg.norm(second - first), 220.0, atol=1e-9)
    centre = np.array([500.0, -250.0, 560.0])
    up = np.array([0.0, 0.0, 1.0])
    view = View("a", CAMERA, Rigid.looking_at(centre, (first + second) / 2, up))
    light = light_of(Lighting(), view.camera_from_world, 800.0, np.zeros(3))
    picture = developed(
        render(view, RenderScene((laid.panel,)), light), 0.5, np.random.default_rng(1)
    )
    found = marks_in(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), camera=CAMERA)
    assert [one.mark_id for one in found] == [100, 101]
    for one, place in zip(found, (first, second), strict=True):
        assert one.fit is not None
        off_px = one.fit.centre_px - view.project(place[None])[0]
        assert 1e-5 < np.linalg.norm(off_px) < 0.06
