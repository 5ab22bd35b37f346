"""The bodies of `shapes`, each made once, when it is first asked for."""

from collections.abc import Callable
from functools import cache

import pytest
from tests.unit.workbench.devices.shapes import make_foot, make_stump, make_thigh, make_trunk

from limbgram.workbench.devices.body import Body
from limbgram.workbench.limb import Limb

BodyOf = Callable[[str], Body]
"""By kind of limb."""

_MADE_BY = {
    "foot": make_foot,
    "transtibial": make_stump,
    "transfemoral": make_thigh,
    "torso": make_trunk,
}


class _Bodies(dict[str, Limb]):
    def __missing__(self, kind: str) -> Limb:
        return _MADE_BY[kind]()


@pytest.fixture(scope="session")
def bodies() -> dict[str, Limb]:
    """By kind of limb."""
    return _Bodies()


@pytest.fixture(scope="session")
def body_of(bodies: dict[str, Limb]) -> BodyOf:
    """The bodies in their limb frames, for tests that only look at them."""
    return cache(lambda kind: Body.of(bodies[kind]))
