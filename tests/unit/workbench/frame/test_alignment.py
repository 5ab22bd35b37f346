"""The limb frame against a limb that was built in it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.mesh.axis import fit_axis
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.limb import Landmark, Limb

RIGHT = AlignOptions(side="right", kind="transtibial")
Lay = Callable[[Limb, int], Limb]


def in_limb(limb: Limb) -> np.ndarray:
    return limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)


@pytest.mark.parametrize("seed", range(4))
def test_a_limb_lying_anywhere_comes_back_to_its_own_frame(
    stump: Limb, lay: Lay, seed: int
) -> None:
    aligned = align(lay(stump, seed), RIGHT)
    assert aligned.frame.side == "right"
    np.testing.assert_allclose(in_limb(aligned), stump.mesh.vertices_mm, atol=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_a_crooked_limb_gets_the_same_frame_wherever_it_lies(
    stump: Limb, lay: Lay, seed: int
) -> None:
    rng = np.random.default_rng(11)
    bent = stump.mesh.vertices_mm + rng.normal(0, 0.3, stump.mesh.vertices_mm.shape)
    bent[:, 1] += 12 * (bent[:, 2] / 230) ** 2
    crooked = stump.with_mesh(stump.mesh.with_vertices(bent))
    options = replace(RIGHT, plumb=("patellar tendon", "tibial crest"), flexion_deg=3.0)
    first, again = align(crooked, options), align(lay(crooked, seed), options)
    np.testing.assert_allclose(in_limb(again), in_limb(first), atol=1e-6)


def test_the_origin_is_on_the_axis_at_the_distal_end(stump: Limb, lay: Lay) -> None:
    vertices = in_limb(align(lay(stump, 5), RIGHT))
    assert vertices[:, 2].min() == pytest.approx(0, abs=1e-9)
    assert vertices[:, 2].max() == pytest.approx(230, abs=1e-6)


def test_a_dent_does_not_pull_the_axis_over(stump: Limb) -> None:
    """A ninth of the length pushed in by 15 mm on one side: sections there are off by 4 mm."""
    rough = stump.mesh.vertices_mm + np.random.default_rng(1).normal(0, 0.3, (len(stump.mesh), 3))
    hit = (np.abs(rough[:, 2] - 185) < 13) & (rough[:, 1] > 20)
    dented = rough - 15 * hit[:, None] * np.array([0.0, 1, 0])
    plain, axis = (fit_axis(stump.mesh.with_vertices(shape)) for shape in (rough, dented))
    turned_deg = np.degrees(np.arccos(abs(axis.direction @ plain.direction)))
    assert 1e-4 < turned_deg < 0.1  # a line through the middles as they are turns by 1.5
    assert 0.5 < axis.spread_mm < 3


def test_the_brim_tells_which_end_is_proximal(stump: Limb, lay: Lay) -> None:
    plain = replace(stump, landmarks=stump.landmarks[:1])
    aligned = align(lay(plain, 2), RIGHT)
    np.testing.assert_allclose(in_limb(aligned), stump.mesh.vertices_mm, atol=1e-6)


def test_stated_directions_take_the_place_of_landmarks(stump: Limb) -> None:
    turned = stump.mesh.vertices_mm[:, [1, 2, 0]]  # the limb's +z lies along +y, its +y along +x
    limb = Limb(mesh=stump.mesh.with_vertices(turned))
    options = AlignOptions(side="left", anterior=np.array([1.0, 0.1, 0]))
    np.testing.assert_allclose(in_limb(align(limb, options)), stump.mesh.vertices_mm, atol=1e-6)


def test_a_stated_axis_is_kept(stump: Limb) -> None:
    tilted = np.array([0.0, 0.2, 1.0])
    limb = align(stump, replace(RIGHT, axis=tilted))
    np.testing.assert_allclose(
        limb.frame.limb_from_mesh.rotation[2], tilted / np.linalg.norm(tilted), atol=1e-12
    )


def test_plumb_landmarks_come_over_each_other_in_the_side_view(stump: Limb) -> None:
    limb = align(stump, replace(RIGHT, plumb=("patellar tendon", "tibial crest")))
    upper, lower = (
        limb.frame.limb_from_mesh.apply(mark.position_mm[None])[0] for mark in limb.landmarks[:2]
    )
    assert upper[1] == pytest.approx(lower[1], abs=1e-9)
    assert upper[2] > lower[2]


def test_flexion_takes_the_proximal_end_backwards(stump: Limb) -> None:
    limb = align(stump, replace(RIGHT, flexion_deg=10.0))
    vertices = in_limb(limb)
    brim = vertices[stump.mesh.vertices_mm[:, 2] > 229].mean(0)
    distal = vertices[0]
    lean = np.degrees(np.arctan2(distal[1] - brim[1], brim[2] - distal[2]))
    assert lean == pytest.approx(10, abs=1e-6)
    assert brim[0] == pytest.approx(distal[0], abs=1e-6)


def test_the_wrong_side_is_refused(stump: Limb, lay: Lay) -> None:
    with pytest.raises(MeasureError, match=r"'fibula head' lies 1\d\d degrees"):
        align(lay(stump, 1), replace(RIGHT, side="left"))


def test_a_mirrored_limb_is_refused(stump: Limb) -> None:
    mirror = np.array([-1.0, 1, 1])
    marks = tuple(replace(mark, position_mm=mark.position_mm * mirror) for mark in stump.landmarks)
    mesh = replace(
        stump.mesh,
        vertices_mm=stump.mesh.vertices_mm * mirror,
        faces=stump.mesh.faces[:, ::-1].copy(),
    )
    with pytest.raises(MeasureError, match="mirrored"):
        align(Limb(mesh=mesh, landmarks=marks), RIGHT)
    assert align(Limb(mesh=mesh, landmarks=marks), replace(RIGHT, side="left")).frame is not None


def test_what_is_not_told_is_asked_for(stump: Limb) -> None:
    bare = replace(stump, landmarks=())
    with pytest.raises(MeasureError, match="--anterior"):
        align(bare, RIGHT)
    closed = trimesh.creation.capsule(150, 40)
    capsule = Mesh(
        vertices_mm=np.asarray(closed.vertices, np.float64),
        faces=np.asarray(closed.faces, np.int32),
    )
    forwards = AlignOptions(side="none", anterior=np.array([0.0, 1, 0]))
    with pytest.raises(MeasureError, match="--proximal"):
        align(Limb(mesh=capsule), forwards)
    up = align(Limb(mesh=capsule), replace(forwards, proximal=np.array([0.1, 0.0, -1])))
    np.testing.assert_allclose(up.frame.limb_from_mesh.rotation[2], [0, 0, -1], atol=1e-3)
    with pytest.raises(OptionsError, match="along the limb's axis"):
        align(stump, replace(RIGHT, anterior=np.array([0.0, 0, 1])))


def test_landmarks_the_other_way_up_are_refused(stump: Limb) -> None:
    with pytest.raises(MeasureError, match="other way up"):
        align(stump, replace(RIGHT, proximal=np.array([0.0, 0, -1])))


def test_a_ball_has_no_long_axis() -> None:
    ball = trimesh.creation.icosphere(3, 50)
    mesh = Mesh(
        vertices_mm=np.asarray(ball.vertices, np.float64), faces=np.asarray(ball.faces, np.int32)
    )
    with pytest.raises(MeasureError, match="no long axis"):
        fit_axis(mesh)


def test_a_band_that_no_photo_saw_does_not_spoil_the_axis(stump: Limb, lay: Lay) -> None:
    """Under a strap in the middle: the limb is in two pieces, and a section may meet neither."""
    middles = stump.mesh.vertices_mm[stump.mesh.faces][:, :, 2].mean(1)
    seen = (middles < 115) | (middles > 120)
    parted = stump.with_mesh(replace(stump.mesh, faces=stump.mesh.faces[seen]))
    aligned = align(lay(parted, 3), RIGHT)
    np.testing.assert_allclose(in_limb(aligned), stump.mesh.vertices_mm, atol=1e-6)


def test_a_name_of_no_template_turns_nothing(stump: Limb) -> None:
    odd = Landmark(name="scar", position_mm=np.array([0.0, -51.0, 150]))
    aligned = align(replace(stump, landmarks=(*stump.landmarks, odd)), RIGHT)
    np.testing.assert_allclose(in_limb(aligned), stump.mesh.vertices_mm, atol=1e-6)


def test_landmarks_contradict_a_stated_axis_too(stump: Limb) -> None:
    with pytest.raises(MeasureError, match="other way up"):
        align(stump, replace(RIGHT, axis=np.array([0.0, 0, -1])))
