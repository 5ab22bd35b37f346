"""What is stated, against what landmarks, brim and file say of a limb that is known beforehand."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import doubt
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.frame.landmarks import NAMES, known_anywhere, likely_meant
from limbgram.workbench.limb import KINDS, Landmark, Limb, LimbFrame

FRONT, UP = np.array([0.0, 1, 0]), np.array([0.0, 0, 1])
Lay = Callable[[Limb, int], Limb]


def file_says(side: str, turn_deg: float = 0.0) -> LimbFrame:
    """The stump's own frame, turned about its axis."""
    turn = Rigid.from_rotation_vector(np.array([0, 0, np.radians(turn_deg)]), np.zeros(3))
    return LimbFrame(limb_from_mesh=turn, side=side)  # type: ignore[arg-type]


def rotation(limb: Limb) -> np.ndarray:
    return limb.frame.limb_from_mesh.rotation


@pytest.mark.parametrize("name", ["fibula head", "Fibula Head", "fibula head "])
@pytest.mark.parametrize("kind", [None, "transfemoral"])
def test_landmarks_speak_against_a_side_also_without_their_kind(
    stump: Limb, name: str, kind: str | None
) -> None:
    (head,) = [mark for mark in stump.landmarks if mark.name == "fibula head"]
    limb = replace(stump, landmarks=(replace(head, name=name),))
    right = AlignOptions(side="right", kind=kind, anterior=FRONT)  # type: ignore[arg-type]
    assert align(limb, right).frame is not None
    with pytest.raises(MeasureError, match="180 degrees from where it belongs"):
        align(limb, replace(right, side="left"))
    with pytest.raises(MeasureError, match="side or the front is wrong"):
        align(limb, replace(right, anterior=-FRONT))


def trunk(spine_mm: float, forward_mm: float) -> Limb:
    """An elliptic trunk of 340 x 220 mm with iliac spines, so far beside and before its axis."""
    tube = trimesh.creation.cylinder(1.0, 500.0, sections=64)
    vertices = np.asarray(tube.vertices, float) * (170.0, 110.0, 1.0)
    places = {
        "right iliac spine": (spine_mm, forward_mm, -100.0),
        "left iliac spine": (-spine_mm, forward_mm, -100.0),
    }
    marks = tuple(
        Landmark(name=name, position_mm=np.array(at, float)) for name, at in places.items()
    )
    mesh = Mesh(vertices_mm=vertices, faces=np.asarray(tube.faces, np.int32))
    return Limb(mesh=mesh, landmarks=marks)


def test_iliac_spines_lie_in_front_and_each_in_its_half() -> None:
    """A flat trunk has them further beside than before its axis; swapped ones are told."""
    options = AlignOptions(side="none", kind="torso", axis=UP)
    for front in (None, FRONT):
        turned = replace(options, anterior=front)
        for forward_mm in (40.0, 105.0):
            found = rotation(align(trunk(120.0, forward_mm), turned))
            np.testing.assert_allclose(found, np.eye(3), atol=1e-6)
    with pytest.raises(MeasureError, match="right and left were taken for each other"):
        align(trunk(-120.0, 60.0), replace(options, anterior=FRONT))


def test_a_name_lies_on_one_side_in_every_template() -> None:
    for kind in KINDS:
        for row in NAMES[kind]:
            for other in KINDS:
                found = known_anywhere(row.identity, other)
                assert found is not None
                assert found.facing == row.facing


def test_the_kind_is_kept_and_turns_the_limb_again(stump: Limb, lay: Lay) -> None:
    first = align(lay(stump, 3), AlignOptions(side="right", kind="transtibial"))
    assert first.kind == "transtibial"
    again = align(first, AlignOptions(side="right"))
    np.testing.assert_allclose(rotation(again), rotation(first), atol=1e-9)
    assert again.kind == "transtibial"


def test_a_side_that_the_file_does_not_name_is_refused(stump: Limb) -> None:
    bare = replace(stump, landmarks=())
    options = AlignOptions(side="left", anterior=FRONT, declared=file_says("right"))
    with pytest.raises(MeasureError, match=r"says that it is a right limb.*'left'"):
        align(bare, options)
    with pytest.raises(MeasureError, match="'none'"):
        align(bare, replace(options, side="none"))
    assert align(bare, replace(options, side="right")).frame is not None
    assert align(bare, replace(options, declared=file_says("none"))).frame is not None


def test_another_side_than_before_is_noted(stump: Limb) -> None:
    left = align(replace(stump, landmarks=()), AlignOptions(side="left", anterior=FRONT))
    assert left.notes == align(left, AlignOptions(side="left", anterior=FRONT)).notes == ()
    unsaid = replace(left, frame=file_says("none"))
    assert align(unsaid, AlignOptions(side="left", anterior=FRONT)).notes == ()
    (note,) = align(left, AlignOptions(side="right", anterior=FRONT)).notes
    assert note == doubt("align.side.changed", before="left", side="right")


def test_the_front_is_that_of_the_file(stump: Limb) -> None:
    bare = replace(stump, landmarks=())
    options = AlignOptions(side="right", declared=file_says("right", 30.0))
    aligned = align(bare, options)
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    np.testing.assert_allclose(rotation(aligned), [[c, -s, 0], [s, c, 0], [0, 0, 1]], atol=1e-9)
    assert aligned.notes == ()
    noted = align(bare, replace(options, anterior=FRONT))
    np.testing.assert_allclose(rotation(noted), np.eye(3), atol=1e-9)
    assert noted.notes[0].code == "align.front.off_file"
    assert noted.notes[0].values["off_deg"] == pytest.approx(30)
    for wrong in (-FRONT, np.array([1.0, 0, 0])):
        with pytest.raises(MeasureError, match="from where the shape's own file has it"):
            align(bare, replace(options, anterior=wrong))


@pytest.mark.parametrize("given", ["proximal", "axis"])
def test_the_file_is_not_turned_upside_down(stump: Limb, given: str) -> None:
    bare = replace(stump, landmarks=())
    options = AlignOptions(side="right", declared=file_says("right"))
    with pytest.raises(MeasureError, match="the other way than the file says"):
        align(bare, replace(options, **{given: -UP}))


def test_a_direction_against_the_brim_is_refused(stump: Limb) -> None:
    bare = replace(stump, landmarks=())
    options = AlignOptions(side="right", anterior=FRONT)
    assert rotation(align(bare, replace(options, proximal=UP)))[2] == pytest.approx([0, 0, 1])
    with pytest.raises(MeasureError, match=r"open.*distal by what is stated.*--axis=0,0,-?1"):
        align(bare, replace(options, proximal=-UP))
    turned = align(bare, replace(options, axis=-UP))
    assert rotation(turned)[2] == pytest.approx([0, 0, -1])
    assert turned.notes == (doubt("align.axis.opening"),)
    assert align(bare, replace(options, axis=UP)).notes == ()


def test_landmarks_against_the_brim_are_refused(stump: Limb) -> None:
    """Two landmarks with their heights swapped."""
    tendon, crest, *_ = stump.landmarks
    swapped = (replace(tendon, name=crest.name), replace(crest, name=tendon.name))
    with pytest.raises(MeasureError, match="distal by what landmarks say"):
        align(
            replace(stump, landmarks=swapped),
            AlignOptions(side="right", kind="transtibial", anterior=FRONT),
        )


def test_a_hole_is_no_brim() -> None:
    """A capsule with one triangle missing near one end: nothing tells which end is proximal."""
    ball = trimesh.creation.capsule(150, 40)
    faces = np.asarray(ball.faces, np.int32)
    lowest = int(np.asarray(ball.triangles_center)[:, 2].argmin())
    mesh = Mesh(vertices_mm=np.asarray(ball.vertices, float), faces=np.delete(faces, lowest, 0))
    options = AlignOptions(side="none", anterior=FRONT)
    with pytest.raises(MeasureError, match="--proximal"):
        align(Limb(mesh=mesh), options)
    for up in (UP, -UP):
        aligned = align(Limb(mesh=mesh), replace(options, proximal=up))
        np.testing.assert_allclose(rotation(aligned)[2], up, atol=1e-2)


def test_an_axis_across_what_is_proximal_is_refused(stump: Limb) -> None:
    bare = replace(stump, landmarks=())
    options = AlignOptions(side="right", anterior=FRONT)
    lean = np.array([np.sin(np.radians(71)), 0, np.cos(np.radians(71))])
    with pytest.raises(MeasureError, match=r"longest 71 degrees away.*--axis=0\.9455,0,0\.3256"):
        align(bare, replace(options, proximal=lean))
    within = np.array([np.sin(np.radians(40)), 0, np.cos(np.radians(40))])
    np.testing.assert_allclose(
        rotation(align(bare, replace(options, proximal=within))), np.eye(3), atol=1e-6
    )


def test_the_axis_of_a_foot_is_not_taken_from_its_shape_alone(stump: Limb) -> None:
    foot = replace(stump, landmarks=())
    options = AlignOptions(side="right", kind="foot", anterior=FRONT)
    with pytest.raises(MeasureError, match="heel to toe"):
        align(foot, options)
    with pytest.raises(MeasureError, match="heel to toe"):
        align(replace(foot, kind="foot"), replace(options, kind=None))
    assert align(foot, replace(options, proximal=UP)).frame is not None
    assert align(foot, replace(options, axis=UP)).frame is not None


def test_slips_of_the_pen_are_noted(stump: Limb) -> None:
    assert likely_meant("mid patela", "transtibial") == "mid patella"
    assert likely_meant("Fibula heda", None) == "fibula head"
    assert likely_meant("scar", None) is None
    assert likely_meant("mid patella", None) is None
    slip = Landmark(name="mid patela", position_mm=np.array([0, 45.0, 200]))
    limb = replace(stump, landmarks=(*stump.landmarks, slip))
    (note,) = align(limb, AlignOptions(side="right", kind="transtibial")).notes
    assert note == doubt("landmark.odd_name", name="mid patela", meant="mid patella")


@pytest.mark.parametrize("flexion", [400.0, -121.0, float("nan"), float("inf")])
def test_a_flexion_that_no_joint_has_is_refused(stump: Limb, flexion: float) -> None:
    options = AlignOptions(side="right", kind="transtibial", flexion_deg=flexion)
    with pytest.raises(OptionsError, match="-120 to 120"):
        align(stump, options)
