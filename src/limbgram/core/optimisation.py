"""Least squares by Levenberg and Marquardt, and the normal equations of an adjustment.

In      a start with its cost, and `linearised`: the equations at a state, as a function that takes
        a damping and gives the state after the damped step with its cost.
Out     the state of least cost that was reached.
Method  a step is accepted where the cost does not grow; then the damping falls to a tenth, else it
        grows tenfold and the same equations are solved again. Whoever calls composes rotations.
        More 1978, "The Levenberg-Marquardt algorithm: implementation and theory".
        Many blocks that meet only through shared unknowns, as poses or points do, are eliminated:
        their Schur complement has the size of what is shared (Triggs et al. 2000, section 6).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np
from jaxtyping import Float64

State = TypeVar("State")


@dataclass(frozen=True)
class Trial(Generic[State]):
    """The state after a step, and its cost."""

    state: State
    cost: float


@dataclass(frozen=True, kw_only=True)
class Descent:
    """Where damping begins and ends, and when to stop."""

    iterations: int
    """Accepted steps at most."""
    smallest_gain: float
    """Gain of a step, as a share of the cost, after which no further one is tried."""
    least_gain: float = 0.0
    """The same in the unit of the cost, for costs that can end at nothing."""
    damping: float = 1e-3
    least_damping: float = 1e-9
    largest_damping: float = 1e8
    """Where no step with less damping lowers the cost, the state is the answer."""


def minimise(
    start: State,
    cost: float,
    linearised: Callable[[State], Callable[[float], Trial[State] | None]],
    descent: Descent,
) -> State:
    """The state nearby with the least cost.

    A trial of None or of a cost that is no number counts as a step that failed.
    """
    state, damping = start, descent.damping
    for _ in range(descent.iterations):
        step = linearised(state)
        while damping < descent.largest_damping:
            trial = step(damping)
            if trial is not None and trial.cost <= cost:
                break
            damping *= 10.0
        else:
            return state
        gain = cost - trial.cost
        state, cost, damping = trial.state, trial.cost, max(damping / 10.0, descent.least_damping)
        if gain <= descent.smallest_gain * cost + descent.least_gain:
            break
    return state


@dataclass(frozen=True)
class ArrowheadEquations:
    """Normal equations of shared unknowns and of blocks that meet only through them.

    Their matrix is an arrowhead: dense in the shared part, else block diagonal.
    """

    shared: Float64[np.ndarray, "s s"]
    shared_right: Float64[np.ndarray, " s"]
    blocks: Float64[np.ndarray, "k b b"]
    cross: Float64[np.ndarray, "k b s"]
    block_right: Float64[np.ndarray, "k b"]

    def damped(
        self,
        damping: float,
        *,
        least_shared: float = 0.0,
        least_block: float | Float64[np.ndarray, " b"] = 0.0,
    ) -> "ArrowheadEquations":
        """The equations with `damping` times each diagonal, plus `least`, added to it."""
        shared, blocks = self.shared.copy(), self.blocks.copy()
        grown = np.einsum("ii->i", shared)
        grown += damping * (grown + least_shared)
        grown = np.einsum("kii->ki", blocks)
        grown += damping * (grown + least_block)
        return replace(self, shared=shared, blocks=blocks)

    def reduced(self) -> tuple[Float64[np.ndarray, "s s"], Float64[np.ndarray, " s"]]:
        """Matrix and right side of the shared unknowns, the blocks eliminated.

        Raises:
            LinAlgError: what a block's own observations say leaves it undetermined.
        """
        count = len(self.shared)
        solved = np.linalg.solve(self.blocks, self.cross).reshape(-1, count)
        return (
            self.shared - self.cross.reshape(-1, count).T @ solved,
            self.shared_right - solved.T @ self.block_right.ravel(),
        )

    def followed(self, shared: Float64[np.ndarray, " s"]) -> Float64[np.ndarray, "k b"]:
        """Steps of the blocks after one of the shared unknowns."""
        left = self.block_right - self.cross @ shared
        return np.linalg.solve(self.blocks, left[:, :, None])[:, :, 0]
