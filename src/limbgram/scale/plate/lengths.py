"""Lengths: a handful of long distances between a board's corners, for people to judge by."""

from collections.abc import Iterator
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.geometry.arrays import Points3
from limbgram.scale.ruler import RulerLength, jackknife_sigma

_DIRECTIONS = ("along x", "along y", "diagonal", "other diagonal")


def long_lengths(
    board_mm: Points3,
    points_in_world: Points3,
    without_photo: Float64[np.ndarray, "p n 3"],
    chosen: Bool[np.ndarray, " n"],
    role: Literal["control", "check"],
) -> tuple[RulerLength, ...]:
    """The longest length in each direction between chosen corners; none where none lies so."""
    rows = np.flatnonzero(chosen)
    return tuple(
        RulerLength(
            label=f"board, {direction}",
            known_mm=float(np.linalg.norm(board_mm[first] - board_mm[second])),
            measured=float(np.linalg.norm(points_in_world[first] - points_in_world[second])),
            sigma=jackknife_sigma(
                np.linalg.norm(without_photo[:, first] - without_photo[:, second], axis=1)
            ),
            role=role,
        )
        for direction, first, second in _longest(board_mm, rows)
    )


def _longest(board_mm: Points3, rows: np.ndarray) -> Iterator[tuple[str, int, int]]:
    """The farthest pair in each direction: direction, first row, second row."""
    first, second = (rows[side] for side in np.triu_indices(len(rows), 1))
    across, down = (board_mm[second] - board_mm[first])[:, :2].T
    length = np.hypot(across, down)
    slant = np.minimum(np.abs(across), np.abs(down)) > 0.3 * length
    cases = (down == 0, across == 0, slant & (across * down > 0), slant & (across * down < 0))
    for direction, among in zip(_DIRECTIONS, cases, strict=True):
        if among.any():
            best = int(np.argmax(np.where(among, length, 0.0)))
            yield direction, int(first[best]), int(second[best])
