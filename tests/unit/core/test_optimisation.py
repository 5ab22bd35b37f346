"""The one loop of Levenberg and Marquardt on functions whose minimum is known."""

from collections.abc import Callable

import numpy as np

from limbgram.core.optimisation import ArrowheadEquations, Descent, Trial, minimise

DESCENT = Descent(iterations=100, smallest_gain=0.0, least_gain=1e-30)
START = np.array([-1.2, 1.0])


def residuals(at: np.ndarray) -> np.ndarray:
    """Rosenbrock's valley: nought at (1, 1)."""
    return np.array([10 * (at[1] - at[0] ** 2), 1 - at[0]])


def valley(seen: list[float]) -> Callable[[np.ndarray], Callable[[float], Trial[np.ndarray]]]:
    def linearised(state: np.ndarray) -> Callable[[float], Trial[np.ndarray]]:
        slopes = np.array([[-20 * state[0], 10.0], [-1.0, 0.0]])
        normal, right = slopes.T @ slopes, -slopes.T @ residuals(state)

        def step(damping: float) -> Trial[np.ndarray]:
            seen.append(damping)
            after = state + np.linalg.solve(normal + damping * np.diag(np.diag(normal)), right)
            return Trial(after, float(residuals(after) @ residuals(after)))

        return step

    return linearised


def test_a_curved_valley_is_followed_to_its_end() -> None:
    found = minimise(START, float(residuals(START) @ residuals(START)), valley([]), DESCENT)
    np.testing.assert_allclose(found, [1.0, 1.0], atol=1e-9)


def test_few_iterations_end_on_the_way_and_never_higher() -> None:
    start = float(residuals(START) @ residuals(START))
    reached = [start]
    for iterations in (1, 3, 6):
        descent = Descent(iterations=iterations, smallest_gain=0.0)
        found = minimise(START, start, valley([]), descent)
        reached.append(float(residuals(found) @ residuals(found)))
    assert reached == sorted(reached, reverse=True)
    assert len(set(reached)) == 4
    assert reached[-1] > 1e-12


def test_damping_falls_after_success_and_grows_after_failure() -> None:
    seen: list[float] = []
    minimise(START, float(residuals(START) @ residuals(START)), valley(seen), DESCENT)
    ratios = np.array(seen[1:]) / np.array(seen[:-1])
    grown, fallen = np.isclose(ratios, 10.0), np.isclose(ratios, 0.1) | np.isclose(ratios, 1.0)
    assert (grown | fallen).all()
    assert grown.any()
    assert fallen.any()


def test_where_no_step_lowers_the_cost_the_start_is_the_answer() -> None:
    for worse in (None, Trial(7.0, 2.0), Trial(7.0, float("nan"))):
        tried: list[float] = []

        def linearised(
            _: float, trial: Trial[float] | None = worse, tried: list[float] = tried
        ) -> Callable[[float], Trial[float] | None]:
            def step(damping: float) -> Trial[float] | None:
                tried.append(damping)
                return trial

            return step

        assert minimise(3.0, 1.0, linearised, DESCENT) == 3.0
        assert len(tried) == 11
        assert max(tried) < 1e8


def test_a_small_gain_is_the_last() -> None:
    counted: list[float] = []

    def linearised(state: float) -> Callable[[float], Trial[float]]:
        counted.append(state)
        return lambda _: Trial(state + 1, 10.0 - 0.05 * (state + 1))

    assert minimise(0.0, 10.0, linearised, Descent(iterations=9, smallest_gain=0.01)) == 1.0
    assert minimise(0.0, 10.0, linearised, Descent(iterations=9, smallest_gain=0.001)) == 9.0
    assert len(counted) == 10


def test_blocks_are_eliminated_and_follow_as_in_the_dense_equations() -> None:
    """Four shared unknowns and five blocks of three, from equations drawn at random."""
    random = np.random.default_rng(4)
    count, size, shared = 5, 3, 4
    slopes = random.normal(size=(60, shared + count * size))
    for row, own in enumerate(np.repeat(np.arange(count), 12)):  # each row measures one block
        slopes[row, shared:].reshape(count, size)[np.arange(count) != own] = 0.0
    normal, right = slopes.T @ slopes, slopes.T @ random.normal(size=60)
    parts = [slice(shared + size * k, shared + size * (k + 1)) for k in range(count)]
    equations = ArrowheadEquations(
        shared=normal[:shared, :shared],
        shared_right=right[:shared],
        blocks=np.stack([normal[part, part] for part in parts]),
        cross=np.stack([normal[part, :shared] for part in parts]),
        block_right=np.stack([right[part] for part in parts]),
    )
    held = np.concatenate([np.full(shared, 0.5), np.tile([0.0, 0.0, 2.0], count)])
    for damping in (0.0, 0.3):
        damped = equations.damped(damping, least_shared=0.5, least_block=np.array([0.0, 0.0, 2.0]))
        step = np.linalg.solve(*damped.reduced())
        dense = normal + damping * np.diag(np.diag(normal) + held)
        expected = np.linalg.solve(dense, right)
        np.testing.assert_allclose(step, expected[:shared], atol=1e-12)
        np.testing.assert_allclose(
            damped.back_substituted(step).ravel(), expected[shared:], atol=1e-12
        )
    np.testing.assert_array_equal(equations.shared, normal[:shared, :shared])
