"""Levenberg-Marquardt, and normal equations with a Schur complement.

In      a start with its cost, and `linearised`: builds the equations at a state and returns a
        function from a damping to the state after the damped step, with its cost.
Out     the state of least cost that was reached.
Method  a step is accepted if the cost does not grow; then the damping falls to a tenth, else it
        grows tenfold and the same equations are solved again (More 1978, "The Levenberg-Marquardt
        algorithm: implementation and theory"). The caller updates rotations by composition.
        Blocks that are coupled only through shared unknowns, as poses or points are, are
        eliminated by the Schur complement (Triggs et al. 2000, section 6).
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
    """Damping and stopping rules of Levenberg-Marquardt."""

    iterations: int
    """Largest number of accepted steps."""
    smallest_gain: float
    """Converged when a step lowers the cost by no more than this share of it."""
    least_gain: float = 0.0
    """Converged when a step lowers the cost by no more than this, for costs that can reach zero."""
    damping: float = 1e-3
    """Of the first step."""
    least_damping: float = 1e-9
    largest_damping: float = 1e8
    """Converged when no step with less damping lowers the cost."""


def minimise(
    start: State,
    cost: float,
    linearised: Callable[[State], Callable[[float], Trial[State] | None]],
    descent: Descent,
) -> State:
    """The local minimum from a start.

    A trial of None, or with a cost of NaN, counts as a rejected step.
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
    """Normal equations with an arrowhead matrix: shared unknowns, and blocks coupled to them."""

    shared: Float64[np.ndarray, "s s"]
    shared_right: Float64[np.ndarray, " s"]
    blocks: Float64[np.ndarray, "k b b"]
    cross: Float64[np.ndarray, "k b s"]
    block_right: Float64[np.ndarray, "k b"]
    """Right-hand sides of the blocks."""

    def damped(
        self,
        damping: float,
        *,
        least_shared: float = 0.0,
        least_block: float | Float64[np.ndarray, " b"] = 0.0,
    ) -> "ArrowheadEquations":
        """The equations with `damping` times (diagonal + `least`) added to each diagonal."""
        shared, blocks = self.shared.copy(), self.blocks.copy()
        diagonal = np.einsum("ii->i", shared)  # a view
        diagonal += damping * (diagonal + least_shared)
        diagonal = np.einsum("kii->ki", blocks)
        diagonal += damping * (diagonal + least_block)
        return replace(self, shared=shared, blocks=blocks)

    def reduced(self) -> tuple[Float64[np.ndarray, "s s"], Float64[np.ndarray, " s"]]:
        """Schur complement and right-hand side of the shared unknowns, the blocks eliminated.

        Raises:
            LinAlgError: a block is singular.
        """
        count = len(self.shared)
        solved = np.linalg.solve(self.blocks, self.cross).reshape(-1, count)
        return (
            self.shared - self.cross.reshape(-1, count).T @ solved,
            self.shared_right - solved.T @ self.block_right.ravel(),
        )

    def back_substituted(self, shared: Float64[np.ndarray, " s"]) -> Float64[np.ndarray, "k b"]:
        """Steps of the blocks for a step of the shared unknowns."""
        left = self.block_right - self.cross @ shared
        return np.linalg.solve(self.blocks, left[:, :, None])[:, :, 0]
