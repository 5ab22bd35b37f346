"""Least squares by Levenberg and Marquardt: one loop, whatever the structure of the equations.

In      a start with its cost, and `linearised`: the equations at a state, as a function that takes
        a damping and gives the state after the damped step with its cost.
Out     the state of least cost that was reached.
Method  a step is accepted where the cost does not grow; then the damping falls to a tenth, else it
        grows tenfold and the same equations are solved again. Whoever calls keeps the structure:
        poses or points eliminated (Schur complement), rotations composed.
        More 1978, "The Levenberg-Marquardt algorithm: implementation and theory".
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

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
