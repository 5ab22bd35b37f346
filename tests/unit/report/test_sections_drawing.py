"""The levels' drawing: one scale of heights; sections from above, front up, as the trade draws."""

import numpy as np
import pytest
import trimesh
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.smoothed_length import taut_length
from limbgram.core.mesh.mesh import Mesh
from limbgram.report.drawings.drawing import png
from limbgram.report.drawings.sections import sections_drawing
from limbgram.workbench.limb import AlignedLimb, Landmark, LimbFrame
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb

ABOVE_MM = 120.0


def lines_of(axes: Axes) -> list[np.ndarray]:
    (drawn,) = [one for one in axes.collections if isinstance(one, LineCollection)]
    return [np.asarray(line) for line in drawn.get_segments()]


@pytest.fixture(scope="module")
def views() -> list[Axes]:
    """A box from 20 mm right to 60 mm left, 30 mm back to 10 mm front; heights from 120 mm up."""
    box = trimesh.creation.box(bounds=[[-60.0, -30, 0], [20, 10, 200]])
    limb = AlignedLimb(
        mesh=Mesh(vertices_mm=np.asarray(box.vertices), faces=box.faces.astype(np.int32)),
        landmarks=(Landmark(name="knee", position_mm=np.array([20.0, 0, ABOVE_MM])),),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="right"),
    )
    options = LimbMeasureOptions(heights_mm=(-100.0, 50.0), reference="knee")
    return list(sections_drawing(measure_limb(limb, options)).figure.axes)


@pytest.mark.parametrize("view", [0, 1])
def test_levels_and_limb_stand_at_their_heights_from_the_landmark(
    views: list[Axes], view: int
) -> None:
    assert [line[0, 1] for line in lines_of(views[view])] == pytest.approx([-100, 50])
    _, _, low, high = views[view].images[0].get_extent()
    assert (low + high) / 2 == pytest.approx(100 - ABOVE_MM)
    assert 200 <= high - low < 220
    assert views[0].get_ylabel() == "height from the knee, mm"


def test_girths_stand_beside_their_levels(views: list[Axes]) -> None:
    told = {
        text.get_text(): text.get_position()[1]
        for text in views[1].texts
        if len(text.get_text()) > 1
    }
    corners = np.array([[-60.0, -30.0], [20.0, -30.0], [20.0, 10.0], [-60.0, 10.0]])
    girth = f"{taut_length(corners).value_mm:.1f}"
    assert told == {f"-100: {girth}": pytest.approx(-100), f"50: {girth}": pytest.approx(50)}


def test_sections_are_seen_from_above_with_the_right_to_the_right(views: list[Axes]) -> None:
    """The box reaches 60 mm to the left, 20 to the right, 30 back and 10 to the front."""
    front, beside, above = views[:3]
    for line in lines_of(front):
        assert (line[:, 0].min(), line[:, 0].max()) == pytest.approx((-20, 60))
    assert front.get_xlabel() == "to the patient's left, mm"
    for line in lines_of(above):
        assert (line[:, 0].min(), line[:, 0].max()) == pytest.approx((-60, 20))
        assert (line[:, 1].min(), line[:, 1].max()) == pytest.approx((-30, 10))
    assert above.get_xlabel() == "to the patient's right, mm"
    assert above.get_ylabel() == "forwards, mm"
    assert corners_of(front) == {"R": 0.02, "L": 0.98}
    assert corners_of(beside) == {"B": 0.02, "F": 0.98}
    assert corners_of(above) == {"L": 0.02, "R": 0.98}


def corners_of(axes: Axes) -> dict[str, float]:
    """The letters in the corners of a picture, and how far along they stand."""
    return {one.get_text(): one.get_position()[0] for one in axes.texts if len(one.get_text()) == 1}


def test_a_landmark_with_dollar_signs_is_no_formula() -> None:
    box = trimesh.creation.box(bounds=[[-60.0, -30, 0], [20, 10, 200]])
    limb = AlignedLimb(
        mesh=Mesh(vertices_mm=np.asarray(box.vertices), faces=box.faces.astype(np.int32)),
        landmarks=(Landmark(name="$__$", position_mm=np.array([20.0, 0, ABOVE_MM])),),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="right"),
    )
    options = LimbMeasureOptions(heights_mm=(-100.0, 50.0), reference="$__$")
    drawn = png(sections_drawing(measure_limb(limb, options)).figure)
    assert drawn.tobytes().startswith(b"\x89PNG")
