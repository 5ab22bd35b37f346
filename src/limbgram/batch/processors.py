"""Processors: which of this machine's processors a capture may use, of so many at a time.

Each capture has processors of its own, so that captures do not slow each other down.
"""

import os


def processors_for(slot: int, at_once: int) -> frozenset[int]:
    """The processors of one slot of `at_once`; none where the system cannot assign processors."""
    if not hasattr(os, "sched_getaffinity"):
        return frozenset()
    available = sorted(os.sched_getaffinity(0))
    if at_once >= len(available):
        return frozenset({available[slot % len(available)]})
    first, end = (edge * len(available) // at_once for edge in (slot, slot + 1))
    return frozenset(available[first:end])
