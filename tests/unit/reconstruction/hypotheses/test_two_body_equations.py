"""TwoBodyEquations: what two bodies show, against motions and lenses that are known."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid, Similarity
from limbgram.reconstruction.hypotheses.lens_spread import second_body_equations
from limbgram.reconstruction.hypotheses.two_body_equations import two_body_equations
from limbgram.reconstruction.mapping.lens_equations import USUAL_SPREAD
from limbgram.reconstruction.mapping.score_tests import pseudo_inverse

Take = Callable[..., Any]
N = 14


def motions(sizes: np.ndarray, turn: float = 0.0) -> np.ndarray:
    found = np.zeros((len(sizes), 6))
    found[:, 3:] = sizes[:, None] * np.array([0.6, 0.64, 0.48])
    found[:, :3] = turn * sizes[:, None] * np.array([0.0, 0.6, 0.8])
    return found


def test_a_motion_comes_out_as_it_was(take: Take) -> None:
    """Turn and shift of one step, with lenses that may differ as a tripod's do."""
    true = motions(np.repeat([0.0, 1.5], [6, 8]), turn=0.002)
    left = second_body_equations(take(motions=true, noise_px=0.03).equations, 0.01 * USUAL_SPREAD)
    course = np.kron((np.arange(N) >= 6)[:, None], np.eye(6))
    seen = left.of_motion.restricted_to(course)
    found = pseudo_inverse(seen.normal) @ seen.right
    np.testing.assert_allclose(found[:3], true[-1, :3], atol=2e-4)
    np.testing.assert_allclose(found[3:], true[-1, 3:], atol=0.02)


def test_the_frame_and_size_of_the_second_scene_do_not_matter(take: Take) -> None:
    taken = take(motions=motions(np.repeat([0.0, 1.0], 7)))
    frame = Similarity(
        0.02,
        Rigid.from_rotation_vector(np.array([0.3, -0.2, 0.5]), np.zeros(3)).rotation,
        np.array([3.0, -2.0, 1.0]),
    )
    moved = two_body_equations(
        taken.limb, taken.room.moved(frame), tuple(range(N)), [taken.calibration]
    )
    here, there = taken.equations, moved
    course = np.kron((np.arange(N) >= 7)[:, None], np.eye(6))
    values: list[np.ndarray] = []
    for one in (here, there):
        left = second_body_equations(one, USUAL_SPREAD)
        seen = left.of_motion.restricted_to(course)
        values.append(pseudo_inverse(seen.normal) @ seen.right)
    np.testing.assert_allclose(values[0], values[1], rtol=2e-3, atol=1e-6)


def test_a_motion_that_all_photos_share_is_none(take: Take) -> None:
    left = second_body_equations(take().equations, USUAL_SPREAD)
    everywhere = np.kron(np.ones((N, 1)), np.eye(6))
    own = np.kron(np.eye(N)[:, :1], np.eye(6))
    shared, alone = (left.of_motion.restricted_to(one).normal for one in (everywhere, own))
    assert (np.diag(shared) < 1e-4 * np.diag(alone)).all()


@pytest.mark.parametrize(("shared", "low", "high"), [(0.0, 1.0, 1.4), (0.8, 1.8, 40.0)])
def test_errors_that_neighbours_share_count_less(
    take: Take, shared: float, low: float, high: float
) -> None:
    for seed in range(4):
        limb = take(points=400, shared=shared, seed=seed).equations.inflation[0]
        assert low <= limb <= high
