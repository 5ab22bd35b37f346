"""A trunk bent by level, against the arc of its axis summed by itself."""

from collections.abc import Callable

import numpy as np
import pytest

from limbgram.core.errors import EditError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import told
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.spine import Spine
from limbgram.workbench.limb import AlignedLimb, Landmark, LimbFrame
from limbgram.workbench.recipe.file import make_edit

LOW_MM, HIGH_MM, TOP_MM = 100.0, 300.0, 400.0
TILT_DEG = 12.0
RIGHT, FORWARD = 0, 1


def make_trunk() -> AlignedLimb:
    """An open tube, 240 x 160 mm across, with landmarks on its surface."""
    around, along = 96, 81
    angles = np.linspace(0, 2 * np.pi, around, endpoint=False)
    heights = np.linspace(0, TOP_MM, along)
    ring = np.column_stack([120 * np.cos(angles), 80 * np.sin(angles)])
    points = np.column_stack([np.tile(ring, (along, 1)), np.repeat(heights, around)])
    at = np.arange(around * (along - 1)).reshape(along - 1, around)
    beside = np.roll(at, -1, axis=1)
    faces = np.concatenate(
        [
            np.stack([at, beside, beside + around], axis=2).reshape(-1, 3),
            np.stack([at, beside + around, at + around], axis=2).reshape(-1, 3),
        ]
    ).astype(np.int32)
    marks = tuple(
        Landmark(name=name, position_mm=points[k].copy())
        for name, k in (("low", 12 * around + 5), ("within", 40 * around + 7), ("top", 79 * around))
    )
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="none")
    mesh = Mesh(vertices_mm=points, faces=faces)
    return AlignedLimb(mesh=mesh, landmarks=marks, frame=frame, kind="torso")


def summed(of: Callable[[np.ndarray], np.ndarray]) -> float:
    """Over the heights of the bend, by the rule of trapezia."""
    heights = np.linspace(LOW_MM, HIGH_MM, 40001)
    return float(np.trapezoid(of(heights), heights))


def smooth_deg(z_mm: np.ndarray) -> np.ndarray:
    """A cubic from nothing to the tilt, level at both ends."""
    u = np.clip((z_mm - LOW_MM) / (HIGH_MM - LOW_MM), 0, 1)
    return TILT_DEG * (3 * u**2 - 2 * u**3)


@pytest.mark.parametrize(("name", "way"), [("bend_right_deg", RIGHT), ("bend_back_deg", FORWARD)])
def test_what_lies_above_the_bend_goes_with_its_last_level(name: str, way: int) -> None:
    """It turns by the whole angle, about where the axis passes that level before and after."""
    limb = make_trunk()
    bend = {"heights_mm": [LOW_MM, HIGH_MM], name: [0.0, TILT_DEG]}
    after = do_edit(limb, make_edit("spine", bend, "the bend")).mesh.vertices_mm
    to = 1.0 if way == RIGHT else -1.0  # backwards is against forwards

    def half_way(z_mm: np.ndarray) -> np.ndarray:
        return np.radians(smooth_deg(z_mm)) / 2

    aside = summed(lambda z: np.sin(half_way(z)))
    up = LOW_MM + summed(lambda z: np.cos(half_way(z)))
    before_mm, after_mm = np.array([-to * aside, up]), np.array([to * aside, up])
    tilt = to * np.radians(TILT_DEG)
    turn = np.array([[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]])
    across = limb.mesh.vertices_mm[:, [way, 2]]
    upward = np.array([-to * np.sin(np.radians(TILT_DEG / 2)), np.cos(np.radians(TILT_DEG / 2))])
    above = (across - before_mm) @ upward > 0
    assert 0.15 < above.mean() < 0.35
    truth = (across - before_mm) @ turn.T + after_mm
    np.testing.assert_allclose(after[above][:, [way, 2]], truth[above], atol=1e-6)
    still = 1 - way
    np.testing.assert_allclose(after[:, still], limb.mesh.vertices_mm[:, still], atol=1e-9)
    below = limb.mesh.vertices_mm[:, 2] <= LOW_MM
    np.testing.assert_allclose(after[below], limb.mesh.vertices_mm[below], atol=1e-9)


def test_a_bend_and_its_opposite_above_it_shift_what_lies_over_them() -> None:
    limb = make_trunk()
    middle = (LOW_MM + HIGH_MM) / 2
    bend = Spine(heights_mm=(LOW_MM, middle, HIGH_MM), bend_right_deg=(0.0, 5.0, 0.0))
    moved = do_edit(limb, bend).mesh.vertices_mm - limb.mesh.vertices_mm

    def tilt(z_mm: np.ndarray) -> np.ndarray:
        u = (z_mm - LOW_MM) / (middle - LOW_MM)
        u = np.minimum(u, 2 - u)
        return np.radians(5.0 * (3 * u**2 - 2 * u**3)) / 2

    aside = 2 * summed(lambda z: np.sin(tilt(z)))
    above = limb.mesh.vertices_mm[:, 2] > HIGH_MM
    truth = np.tile([aside, 0.0, 0.0], (int(above.sum()), 1))
    np.testing.assert_allclose(moved[above], truth, atol=1e-5)


def test_all_moves_at_once_come_back_with_opposite_signs() -> None:
    limb = make_trunk()
    moves = {
        "right_mm": (0.0, 12.0, -4.0, 6.0),
        "forward_mm": (0.0, -8.0, 3.0, 0.0),
        "turn_deg": (0.0, 6.0, 9.0, 4.0),
        "bend_right_deg": (0.0, -5.0, 2.0, 4.0),
        "bend_back_deg": (0.0, 4.0, -2.0, 4.0),
    }
    levels = {"heights_mm": (60.0, 180.0, 260.0, 380.0), "beyond": True}
    there = do_edit(limb, make_edit("spine", {**levels, **moves}, "there"))
    assert np.linalg.norm(there.mesh.vertices_mm - limb.mesh.vertices_mm, axis=1).max() > 20
    opposite = {name: tuple(-one for one in values) for name, values in moves.items()}
    home = do_edit(there, make_edit("spine", {**levels, **opposite}, "back"))
    np.testing.assert_allclose(home.mesh.vertices_mm, limb.mesh.vertices_mm, atol=1e-8)
    for mark in limb.landmarks:
        back = home.landmark(mark.name).position_mm
        np.testing.assert_allclose(back, mark.position_mm, atol=1e-6)


def test_landmarks_go_with_the_surface_and_a_sharp_bend_is_refused() -> None:
    limb = make_trunk()
    bend = Spine(heights_mm=(LOW_MM, HIGH_MM), bend_right_deg=(0.0, TILT_DEG))
    after = do_edit(limb, bend)
    for name, idx in (("low", 12 * 96 + 5), ("within", 40 * 96 + 7), ("top", 79 * 96)):
        np.testing.assert_allclose(
            after.landmark(name).position_mm, after.mesh.vertices_mm[idx], atol=1e-9
        )
    for beyond in (False, True):
        sharp = Spine(heights_mm=(200.0, 240.0), bend_right_deg=(0.0, 25.0), beyond=beyond)
        with pytest.raises(EditError) as refused:
            do_edit(limb, sharp)
        assert refused.value.finding.code == "edit.spine.strain"
        assert ("say that it is meant" in told(refused.value.finding)) is not beyond
        assert refused.value.finding.values["most"] == (0.6 if beyond else 0.25)
