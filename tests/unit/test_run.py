"""Stages are timed, each with its own peak of memory."""

import mmap
import sys
import time

import numpy as np
import pytest

from limbgram.run import Run, resident_megabytes


def large() -> float:
    return _fill(40_000_000)


def small() -> float:
    return _fill(5_000_000)


def _fill(count: int) -> float:
    """Hold so many numbers for a while; memory in use before."""
    before_mb = resident_megabytes()
    # Straight from the system: an allocator may hand out again what an earlier test gave back.
    array = np.frombuffer(mmap.mmap(-1, 8 * count))
    array[:] = 1
    time.sleep(0.6)
    return before_mb + 0 * array[0]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux tells memory in use")
def test_the_peak_of_a_stage_is_not_that_of_an_earlier_one() -> None:
    run = Run()
    rest_mb = [run(large), run(small)]
    first, second = (one.peak_mb - mb for one, mb in zip(run.timings, rest_mb, strict=True))
    assert 300 < first < 400  # 320 MB of numbers
    assert 30 < second < 120  # 40 MB of numbers
    assert [timing.stage for timing in run.timings] == ["large", "small"]
    assert all(0.6 < timing.wall_s < 20 for timing in run.timings)
