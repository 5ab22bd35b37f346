"""Sizes of files: a reader looks into one that is as large as it may be, and not into a larger."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from limbgram.core.errors import LimbgramError


def require_takes_up_to(read: Callable[[Path], object], path: Path, most_bytes: int) -> None:
    """Gives the reader zeros, with which no format of ours begins, and then one byte more."""
    assert not _is_too_large(read, path, most_bytes)
    assert _is_too_large(read, path, most_bytes + 1)


def _is_too_large(read: Callable[[Path], object], path: Path, size: int) -> bool:
    path.touch()
    os.truncate(path, size)
    with pytest.raises(LimbgramError) as refused:
        read(path)
    causes = (refused.value, refused.value.__cause__)
    codes = [one.finding.code for one in causes if isinstance(one, LimbgramError)]
    return "file.too_large" in codes
