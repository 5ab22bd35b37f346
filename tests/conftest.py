"""Fixtures that many tests share."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The folder of captures with truth, named by LIMBGRAM_DATA."""
    name = os.environ.get("LIMBGRAM_DATA")
    if not name:
        pytest.skip("LIMBGRAM_DATA is not set: no captures with truth to compare with")
    return Path(name)
