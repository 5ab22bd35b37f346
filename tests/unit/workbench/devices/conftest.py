"""The bodies of `shapes`, made once."""

import sys
from pathlib import Path

import pytest

from limbgram.workbench.limb import Limb

sys.path.insert(0, str(Path(__file__).parent))
from shapes import make_foot, make_stump, make_thigh, make_trunk


@pytest.fixture(scope="session")
def bodies() -> dict[str, Limb]:
    """By kind of limb."""
    return {
        "foot": make_foot(),
        "transtibial": make_stump(),
        "transfemoral": make_thigh(),
        "torso": make_trunk(),
    }
