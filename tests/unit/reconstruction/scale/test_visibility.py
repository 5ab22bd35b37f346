"""What photos show, by a lens whose distortion turns back within its picture."""

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View, fold_radius
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.visibility import incidence_cosines
from limbgram.reconstruction.scale.visibility import aim_of, in_frame

FOLDED = Camera(width_px=1600, height_px=1200, fx=1250.0, fy=1250.0, cx=799.5, cy=599.5, k2=-0.58)
"""Its distortion turns back 0.766 from the axis, and shows at most 0.613; corners are at 0.8."""


@pytest.mark.parametrize(
    ("radial", "fold"),
    [
        ((0.0, 0.0, 0.0), np.inf),
        ((0.3, 0.1, 0.0), np.inf),
        ((-1 / 3, 0.0, 0.0), 1.0),
        ((0.0, -0.2, 0.0), 1.0),
        ((0.0, 0.0, -1 / 7), 1.0),
        ((-1 / 12, 0.0, 0.0), 2.0),
        ((-5 / 12, 1 / 20, 0.0), 1.0),  # (1 - s) (1 - s / 4), by the square s: again at 2
        ((-0.3, 0.2, 0.0), np.inf),  # flattest at 0.45, where its slope is still 0.8
    ],
)
def test_a_lens_turns_back_where_its_slope_ends(
    radial: tuple[float, float, float], fold: float
) -> None:
    assert fold_radius(*radial) == pytest.approx(fold)


def test_corners_without_a_ray_hide_no_point_in_the_middle() -> None:
    """Before, no point at all was seen: the corners' rays are no numbers."""
    corners = FOLDED.normalize(np.array([[0.0, 0.0], [1599.0, 1199.0]]))
    assert not np.isfinite(FOLDED.project(np.column_stack([corners, [1.0, 1.0]]))).any()
    aside = np.linspace(0.0, 3.0, 301)
    points = np.column_stack([0.8 * aside, 0.6 * aside, np.ones(301)]) * 500.0
    drawn = FOLDED.distort(points[:, :2] / 500.0) * 1250.0 + (799.5, 599.5)
    would_be_in_frame = FOLDED.contains(drawn)
    shown = in_frame([View("", FOLDED, Rigid.identity())], points)[0]
    before_it_turns = aside <= 0.58**-0.25 * 0.2**0.25
    assert would_be_in_frame[before_it_turns].all()
    assert would_be_in_frame[~before_it_turns].sum() > 30  # folded back over the others
    np.testing.assert_array_equal(shown, before_it_turns)
    np.testing.assert_array_equal(shown, np.isfinite(FOLDED.project(points)).all(axis=1))


def test_the_surface_is_seen_by_the_same_rule() -> None:
    """A wall of squares facing the camera, far wider than the lens shows."""
    side = np.linspace(-700.0, 700.0, 57)
    x, y = (part.ravel() for part in np.meshgrid(side, side))
    at = np.arange(57 * 57).reshape(57, 57)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]))
    wall = Mesh(
        vertices_mm=np.column_stack([x, y, np.full(len(x), 500.0)]),
        faces=np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)]).astype(np.int32),
    )
    view = View("", FOLDED, Rigid.identity())
    seen = incidence_cosines(wall, [view], 80.0)[:, 0] > 0
    aside = np.hypot(x, y) / 500.0
    np.testing.assert_array_equal(seen, view.shows(wall.vertices_mm, margin_px=4.0))
    assert seen[(aside < 0.76) & (np.abs(y) < 220.0)].all()
    assert not seen[aside > 0.77].any()


@pytest.mark.parametrize(("aside", "weight"), [(1 / 3, 0.41), (1 / 2, 0.135), (2.0, 0.0)])
def test_photos_look_at_what_their_frames_hold_in_the_middle(aside: float, weight: float) -> None:
    """A point in the middle, and one so many half frames beside it, which counts as much less."""
    camera = Camera(width_px=1600, height_px=1200, fx=1200.0, fy=1200.0, cx=799.5, cy=599.5)
    half = 500.0 * 600 / 1200
    points = np.array([[0.0, 0.0, 500.0], [aside * half, 0.0, 500.0]])
    aim = aim_of([View("", camera, Rigid.identity())], points)
    assert aim.point[0] / (aside * half - aim.point[0]) == pytest.approx(weight, abs=0.005)
    assert aim.reach == pytest.approx(half, rel=0.02)
