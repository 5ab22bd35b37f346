"""Stickers on the skin: seen where they truly are, and read by their number."""

import cv2
import numpy as np
import pytest

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.targets.marks import marks_in
from limbgram.synthetic import CaptureOptions, Paint, SockSticker, sticker_places_mm
from limbgram.synthetic.props.limb import LimbKind, make_limb
from limbgram.synthetic.props.paint import Painting, bake
from limbgram.synthetic.props.room import make_room
from limbgram.synthetic.props.stickers import stick
from limbgram.synthetic.rendering.developing import developed, softened
from limbgram.synthetic.rendering.renderer import RenderScene, render
from limbgram.synthetic.rendering.shading import Lighting, light_of

STICKERS = (
    SockSticker(mark_id=3, around=0.0, height=0.4, side_mm=16.0, twist_deg=30.0),
    SockSticker(mark_id=17, around=0.6, height=0.6, side_mm=16.0),
)
CAMERA = Camera(width_px=640, height_px=640, fx=1500.0, fy=1500.0, cx=319.5, cy=319.5)
FAR_MM = 500.0


def looking_at(place: np.ndarray, outward: np.ndarray) -> View:
    """A camera straight before a place on the skin."""
    forward = -outward / np.linalg.norm(outward)
    right = np.cross(forward, np.array([0.0, 0.0, 1.0]))
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    return View("a.jpg", CAMERA, Rigid(rotation, -rotation @ (place - FAR_MM * forward)))


@pytest.mark.parametrize("which", [0, 1])
def test_a_sticker_is_read_where_it_truly_is(which: int) -> None:
    limb = make_limb(LimbKind.TRANSTIBIAL, 7, 1.5, 60.0)
    skin = bake(limb, Painting(Paint.NONE), 7, 0.15)
    stick(skin, limb, STICKERS)
    place = sticker_places_mm(limb, STICKERS)[which]
    vertex = int(np.argmin(np.linalg.norm(limb.mesh.vertices_mm - place, axis=1)))
    view = looking_at(place, limb.normals[vertex] * [1.0, 1.0, 0.0])
    light = light_of(Lighting(), view.camera_from_world, FAR_MM, np.zeros(3))
    picture = softened(
        render(view, RenderScene(make_room(7, under_stand=True), limb, None, skin), light, 3), 0.5
    )
    pixels = developed(picture, 0.0, np.random.default_rng(0))
    luma = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY), np.uint8)
    found = {one.mark_id: one.fit for one in marks_in(luma, camera=CAMERA)}
    fit = found[STICKERS[which].mark_id]  # a mirrored print would not be read at all
    assert fit is not None
    off_px = fit.centre_px - view.project(place[None])[0]
    assert np.abs(off_px).max() < 1.0  # 0.33 mm: the skin is round and leans
    across_px = np.linalg.norm(fit.corners_px[1] - fit.corners_px[0])
    assert across_px * FAR_MM / CAMERA.fx == pytest.approx(16.0, rel=0.03)


def test_a_large_sticker_at_the_distal_end_stays_within_its_border() -> None:
    limb = make_limb(LimbKind.TRANSTIBIAL, 11, 2.0, 60.0)
    large = SockSticker(mark_id=3, around=0.3, height=0.95, side_mm=40.0)
    texture = np.zeros((*limb.grid_mm.shape[:2], 4), np.uint8)
    stick(texture, limb, (large,))
    (centre,) = sticker_places_mm(limb, (large,))
    printed = texture[..., 0] > 0
    corner_mm = np.sqrt(2) * (0.5 + 1 / 4) * large.side_mm  # a mark has four cells or more
    off_mm = np.linalg.norm(limb.grid_mm - centre, axis=2)
    assert printed[off_mm < 10.0].all()
    assert off_mm[printed].max() < corner_mm


def test_stickers_that_cannot_be_stuck_are_refused() -> None:
    with pytest.raises(OptionsError, match="stickers lie"):
        CaptureOptions(stickers=(SockSticker(mark_id=600, around=0.1, height=0.5),))
