"""Guesses of places, on a limb whose distal end is known."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.frame.suggested_landmarks import guess_places
from limbgram.workbench.limb import Limb

Lay = Callable[[Limb, int], Limb]


@pytest.mark.parametrize("seed", range(3))
def test_the_distal_end_is_guessed_wherever_the_limb_lies(stump: Limb, lay: Lay, seed: int) -> None:
    lying = replace(lay(stump, seed), landmarks=(), kind="transtibial")
    (found,) = guess_places(lying)
    at = int(np.linalg.norm(lying.mesh.vertices_mm - found.position_mm, axis=1).argmin())
    assert found.name == "distal end"
    # The dome is flat at its tip: the axis of the fit leans a little, and the tip with it.
    assert stump.mesh.vertices_mm[at, 2] - stump.mesh.vertices_mm[:, 2].min() < 0.5


def test_what_is_known_and_what_no_shape_tells_is_not_guessed(stump: Limb, lay: Lay) -> None:
    plain = replace(lay(stump, 0), landmarks=(), kind="transtibial")
    (found,) = guess_places(plain)
    mark = replace(stump.landmarks[0], name="distal end", position_mm=found.position_mm)
    assert guess_places(replace(plain, landmarks=(mark,))) == ()
    german = replace(mark, name="Stumpfende")
    assert guess_places(replace(plain, landmarks=(german,))) == ()
    assert guess_places(replace(plain, kind="torso")) == ()
    assert guess_places(replace(plain, kind=None)) == ()


def test_a_place_that_is_marked_under_another_name_is_not_guessed(stump: Limb, lay: Lay) -> None:
    plain = replace(lay(stump, 0), landmarks=(), kind="transtibial")
    (found,) = guess_places(plain)
    for name in ("Stumpfspitze", "End of the stump"):
        mark = replace(stump.landmarks[0], name=name, position_mm=found.position_mm)
        assert guess_places(replace(plain, landmarks=(mark,))) == ()


def test_a_crumb_below_the_limb_is_not_its_distal_end(stump: Limb) -> None:
    corners = np.array([[0.0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3]]) - [1, 1, 40]
    first = len(stump.mesh)
    sides = first + np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    mesh = Mesh(
        vertices_mm=np.concatenate([stump.mesh.vertices_mm, corners]),
        faces=np.concatenate([stump.mesh.faces, sides]).astype(np.int32),
    )
    (found,) = guess_places(Limb(mesh=mesh, kind="transtibial"))
    assert abs(found.position_mm[2]) < 0.5


def test_a_shape_without_a_long_axis_tells_nothing(stump: Limb) -> None:
    whole = stump.mesh
    about = whole.vertices_mm - np.array([0.0, 0.0, 100.0])
    ball = about / np.linalg.norm(about, axis=1, keepdims=True)
    assert guess_places(Limb(mesh=whole.with_vertices(40 * ball), kind="transtibial")) == ()
