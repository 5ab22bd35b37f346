"""Stages are timed, each with its own peak of memory, and their outermost loop reports."""

import mmap
import sys
import time

import numpy as np
import pytest

from limbgram.core.errors import Cancelled
from limbgram.core.run import Run, in_parallel, resident_megabytes, track


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


def nested() -> int:
    """A loop of two steps, each with loops of its own, and a second loop of three."""
    inner = sum(sum(in_parallel(_looped, range(4), workers=2)) for _ in track(range(2)))
    return inner + sum(track(range(3)))


def _looped(number: int) -> int:
    return sum(number for _ in track(range(5)))


def test_the_outermost_loop_reports() -> None:
    steps: list[tuple[int, int]] = []
    run = Run(listener=lambda _stage, done, total: steps.append((done, total)))
    assert run(nested) == 2 * 5 * 6 + 3
    assert steps == [(0, 0), (0, 2), (1, 2), (2, 2), (0, 3), (1, 3), (2, 3), (3, 3)]


def test_a_stop_is_told_by_its_code() -> None:
    run = Run()
    run.cancel()
    with pytest.raises(Cancelled) as stopped:
        run.check()
    assert stopped.value.finding.code == "job.run_stopped"


def test_an_inner_loop_stops_too() -> None:
    run = Run()

    def stage() -> None:
        for _ in track(range(2)):
            for step in track(range(1000)):
                if step == 1:
                    run.cancel()
                assert step < 2

    with pytest.raises(Cancelled):
        run(stage)
    assert [timing.stage for timing in run.timings] == ["stage"]
