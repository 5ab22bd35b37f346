"""Movement: how far the limb goes, when, and that views follow it."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import OptionsError
from limbgram.synthetic import SMALL, CaptureOptions, Movement, MovementKind, stage_truth
from limbgram.synthetic.capture import _shadow_seed
from limbgram.synthetic.movement import bent, motions
from limbgram.synthetic.rendering.shading import Lighting, Shadow, shadow_edge

STAGE = replace(SMALL, calibration_photos=0)
MIDDLE = np.array([10.0, -20.0, 150.0])


def shifts_mm(kind: MovementKind, photos: int = 12) -> np.ndarray:
    found = motions(Movement(kind=kind, shift_mm=8.0), photos, 5, MIDDLE)
    return np.array([np.linalg.norm(one.apply(MIDDLE[None])[0] - MIDDLE) for one in found])


def test_a_step_moves_the_second_half_by_all() -> None:
    np.testing.assert_allclose(shifts_mm(MovementKind.STEP), [0.0] * 6 + [8.0] * 6, atol=1e-12)


def test_a_drift_grows_evenly() -> None:
    np.testing.assert_allclose(
        shifts_mm(MovementKind.DRIFT), np.linspace(0, 8, 12), rtol=1e-12, atol=1e-12
    )


def test_a_sway_stays_within_its_reach_and_uses_it() -> None:
    assert 5.0 < shifts_mm(MovementKind.SWAY).max() <= 8.0


def test_views_see_the_limb_as_the_room_does() -> None:
    truth = stage_truth(replace(STAGE, movement=Movement()))
    points = truth.limb.mesh.vertices_mm[::500]
    for k in (0, 7):
        in_room = truth.room_from_limb[k].apply(points)
        np.testing.assert_allclose(
            truth.in_room(k).project(in_room), truth.views[k].project(points), atol=1e-8
        )
    still = stage_truth(STAGE)
    np.testing.assert_allclose(
        truth.in_room(7).camera_from_world.matrix_3x4,
        still.views[7].camera_from_world.matrix_3x4,
        atol=1e-9,
    )


def test_a_pushed_board_leaves_the_limb_alone() -> None:
    truth = stage_truth(replace(STAGE, movement=Movement(kind=MovementKind.PUSHED_BOARD)))
    assert all((one.matrix_3x4 == np.eye(3, 4)).all() for one in truth.room_from_limb)
    corner = np.zeros((1, 3))
    assert np.linalg.norm(truth.room_from_board[7].apply(corner) - corner) > 1.0


def test_a_bent_limb_keeps_its_base_and_its_normals_stand_on_it() -> None:
    limb = stage_truth(STAGE).limb
    other = bent(limb, 8.0, 5)
    moved = np.linalg.norm(other.mesh.vertices_mm - limb.mesh.vertices_mm, axis=1)
    heights = limb.mesh.vertices_mm[:, 2]
    assert (moved[heights < limb.base_mm + 0.4 * limb.height_mm] == 0.0).all()
    assert moved.max() == pytest.approx(8.0)
    upper = ~limb.cut & (heights > limb.base_mm + 0.6 * limb.height_mm)
    by_mesh = other.mesh.vertex_normals()
    before = (limb.normals * limb.mesh.vertex_normals()).sum(1)[upper]
    after = (other.normals * by_mesh).sum(1)[upper]
    assert np.median(after) > np.median(before) - 1e-3


def test_movements_without_meaning_are_refused() -> None:
    with pytest.raises(OptionsError, match="move by 0 to 30 mm"):
        CaptureOptions(movement=Movement(shift_mm=50.0))
    with pytest.raises(OptionsError, match="needs a board"):
        CaptureOptions(movement=Movement(kind=MovementKind.PUSHED_BOARD), board=None)


def test_a_shadow_does_not_lean_by_where_the_limb_moves() -> None:
    """Of forty captures with both: the one is drawn without regard to the other."""
    lighting = Lighting(shadow=Shadow.STANDING)
    leans: list[float] = []
    azimuths: list[float] = []
    for seed in range(40):
        options = replace(STAGE, seed=seed, movement=Movement(), lighting=lighting)
        edge = shadow_edge(lighting, MIDDLE, _shadow_seed(options), 0)
        leans.append(float(edge[2]))
        moved = motions(Movement(), 4, seed, MIDDLE)[-1].apply(MIDDLE[None])[0] - MIDDLE
        azimuths.append(float(np.arctan2(moved[1], moved[0]) % (2 * np.pi)))
    ranks = [np.argsort(np.argsort(one)) for one in (leans, azimuths)]
    assert abs(np.corrcoef(*ranks)[0, 1]) < 0.5
