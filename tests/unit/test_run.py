"""Stages are timed, each with its own peak of memory."""

import sys
import time

import numpy as np
import pytest

from limbgram.run import Run, resident_megabytes


def large() -> int:
    return _fill(40_000_000)


def small() -> int:
    return _fill(5_000_000)


def _fill(count: int) -> int:
    array = np.ones(count)
    time.sleep(0.15)
    return len(array)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux tells memory in use")
def test_the_peak_of_a_stage_is_not_that_of_an_earlier_one() -> None:
    run, rest_mb = Run(), resident_megabytes()
    run(large)
    run(small)
    first, second = (timing.peak_mb - rest_mb for timing in run.timings)
    assert 300 < first < 400  # 320 MB of numbers
    assert 30 < second < 120  # 40 MB of numbers
    assert [timing.stage for timing in run.timings] == ["large", "small"]
    assert all(0.15 < timing.wall_s < 5 for timing in run.timings)
