"""What people write for a batch is read up to a size that nobody writes."""

from collections.abc import Callable
from pathlib import Path

import pytest
from tests.unit.file_sizes import require_takes_up_to

from limbgram.batch.settings import read_batch, read_settings
from limbgram.batch.steps import landmark_words


@pytest.mark.parametrize("read", [read_batch, read_settings, landmark_words])
def test_a_file_is_read_up_to_a_megabyte(tmp_path: Path, read: Callable[[Path], object]) -> None:
    require_takes_up_to(read, tmp_path / "file", 1_000_000)
