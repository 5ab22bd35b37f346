"""Landmarks on the surface, and marks seen in its colours."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import EditError, MeasureError, OptionsError
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.edits.regions import position_mm
from limbgram.workbench.frame.landmarks import NAMES, landmark, with_landmarks
from limbgram.workbench.frame.painted_marks import find_marks
from limbgram.workbench.limb import Landmark, Limb

BALL = trimesh.creation.icosphere(5, 60.0)
MESH = Mesh(
    vertices_mm=np.asarray(BALL.vertices, np.float64), faces=np.asarray(BALL.faces, np.int32)
)
RED, GREEN = (200, 30, 40), (30, 170, 60)
PLACES = 60 * np.array([[0.6, 0.8, 0], [0, 0.6, 0.8], [0.8, 0, -0.6], [-1.0, 0, 0]])


def painted(spots: list[tuple[np.ndarray, tuple[int, int, int], float]]) -> Mesh:
    """A sock of black and grey speckles with round spots: place, colour, diameter."""
    rng = np.random.default_rng(4)
    grey = rng.integers(20, 230, (len(MESH), 1)) + rng.integers(-12, 13, (len(MESH), 3))
    colours = np.clip(grey, 0, 255)
    for place, colour, diameter_mm in spots:
        inside = np.linalg.norm(MESH.vertices_mm - place, axis=1) < diameter_mm / 2
        colours[inside] = np.clip(
            np.array(colour) + rng.integers(-10, 11, (inside.sum(), 3)), 0, 255
        )
    return replace(MESH, colours=colours.astype(np.uint8))


def test_marks_are_found_where_they_were_painted() -> None:
    mesh = painted([(PLACES[0], RED, 12), (PLACES[1], GREEN, 10), (PLACES[2], RED, 14)])
    marks = find_marks(mesh)
    assert len(marks) == 3
    for place, colour, diameter in (
        (PLACES[0], RED, 12),
        (PLACES[1], GREEN, 10),
        (PLACES[2], RED, 14),
    ):
        (mark,) = [m for m in marks if np.linalg.norm(m.position_mm - place) < 5]
        assert np.linalg.norm(mark.position_mm - place) < 0.5
        assert np.abs(mark.colour.astype(int) - colour).max() < 6
        assert mark.diameter_mm == pytest.approx(diameter, rel=0.15)


def test_what_is_no_round_spot_is_no_mark() -> None:
    """A sock without marks, a large patch, a line."""
    assert find_marks(painted([])) == ()
    assert find_marks(painted([(PLACES[3], RED, 45)])) == ()
    along = np.linspace(0, np.pi / 3, 40)
    line = [(60 * np.array([np.cos(a), np.sin(a), 0]), GREEN, 5.0) for a in along]
    assert find_marks(painted(line)) == ()


def test_marks_of_two_colours_that_touch_stay_two() -> None:
    beside = 60 * np.array([np.cos(0.2), 0, np.sin(0.2)])
    marks = find_marks(painted([(np.array([60.0, 0, 0]), RED, 11), (beside, GREEN, 11)]))
    assert len(marks) == 2


def test_a_given_colour_leaves_the_others_out() -> None:
    mesh = painted([(PLACES[0], RED, 12), (PLACES[1], GREEN, 10), (PLACES[2], RED, 14)])
    (mark,) = find_marks(mesh, (0, 160, 40))
    assert np.linalg.norm(mark.position_mm - PLACES[1]) < 0.5


@pytest.mark.parametrize("grey", [(255, 255, 255), (0, 0, 0), (130, 120, 110)])
def test_a_grey_is_no_colour_for_marks(grey: tuple[int, int, int]) -> None:
    mesh = painted([(PLACES[0], RED, 12)])
    with pytest.raises(OptionsError, match="near to grey"):
        find_marks(mesh, grey)


def test_a_painted_sock_is_told_from_marks_on_it() -> None:
    """41 dabs of 8 mm on a spiral from pole to pole; the last one less, and they are marks."""
    z = np.linspace(-0.95, 0.95, 41)
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(41)
    across = np.sqrt(1 - z**2)
    places = 60 * np.column_stack([across * np.cos(turn), across * np.sin(turn), z])
    dabs = [(place, GREEN, 8.0) for place in places]
    with pytest.raises(MeasureError, match="41 spots on this shape pass as marks"):
        find_marks(painted(dabs))
    assert len(find_marks(painted(dabs[:-1]))) == 40


def test_a_shape_without_colours_shows_no_marks() -> None:
    with pytest.raises(MeasureError, match="no colours"):
        find_marks(MESH)


def test_landmarks_snap_to_the_surface_and_replace_their_namesakes() -> None:
    limb = with_landmarks(
        Limb(mesh=MESH), [Landmark(name=" a ", position_mm=np.array([0, 0, 66.0]))]
    )
    limb = with_landmarks(limb, [Landmark(name="b", position_mm=np.array([0, 57.0, 0]))])
    limb = with_landmarks(limb, [Landmark(name="a", position_mm=np.array([0, 0, -60.0]))])
    assert [mark.name for mark in limb.landmarks] == ["b", "a"]
    np.testing.assert_allclose(landmark(limb, "b").position_mm, [0, 60, 0], atol=0.1)
    np.testing.assert_allclose(landmark(limb, "a").position_mm, [0, 0, -60], atol=0.1)


def test_a_place_far_off_and_names_that_do_not_serve_are_refused() -> None:
    limb = Limb(mesh=MESH)
    with pytest.raises(MeasureError, match=r"20\.0 mm from the surface"):
        with_landmarks(limb, [Landmark(name="a", position_mm=np.array([0, 0, 80.0]))])
    with pytest.raises(MeasureError, match="from the surface"):
        with_landmarks(limb, [Landmark(name="a", position_mm=np.array([0, 0, np.nan]))])
    twice = [Landmark(name="a", position_mm=np.array([0, 0, 60.0]))] * 2
    with pytest.raises(OptionsError, match="name of its own"):
        with_landmarks(limb, twice)
    with pytest.raises(MeasureError, match="no landmark 'c'; it has none"):
        landmark(limb, "c")


@pytest.mark.parametrize("kind", [kind for kind in NAMES if kind != "cast"])
def test_every_template_can_tell_front_and_proximal(kind: str) -> None:
    names = NAMES[kind]
    assert len({known.identity for known in names}) == len(names)
    assert any(known.facing in ("anterior", "posterior") for known in names)
    assert len({known.level for known in names}) > 1


@pytest.mark.parametrize("name", ["fibula haed", "Fibulakof", "fibulas head"])
def test_a_misspelt_name_gets_a_question(name: str) -> None:
    marks = tuple(
        Landmark(name=one, position_mm=PLACES[k])
        for k, one in enumerate(("tibia end", "fibula head"))
    )
    limb = Limb(mesh=MESH, landmarks=marks)
    with pytest.raises(MeasureError, match='Was "fibula head" meant'):
        landmark(limb, name)
    with pytest.raises(EditError, match='Was "fibula head" meant'):
        position_mm(limb, name, "limb")
    for written in ("Fibula Head", "fibulahead", " fibula head", "Wadenbeinköpfchen"):
        assert landmark(limb, written) is marks[1]
        np.testing.assert_array_equal(position_mm(limb, written, "limb"), PLACES[1])
    with pytest.raises(MeasureError) as refused:
        landmark(limb, "umbilicus")
    assert "meant" not in str(refused.value)
