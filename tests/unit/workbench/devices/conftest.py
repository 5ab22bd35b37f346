"""The bodies of `shapes`, made once."""

import pytest
from tests.unit.workbench.devices.shapes import make_foot, make_stump, make_thigh, make_trunk

from limbgram.workbench.limb import Limb


@pytest.fixture(scope="session")
def bodies() -> dict[str, Limb]:
    """By kind of limb."""
    return {
        "foot": make_foot(),
        "transtibial": make_stump(),
        "transfemoral": make_thigh(),
        "torso": make_trunk(),
    }
