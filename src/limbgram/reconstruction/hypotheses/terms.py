"""Terms: what may have happened between two bodies, each as columns over the photos.

A term is a course (how much of one motion each photo shows) of a kind. Its rival is the lens that
changes along the same course: another lens for the second body alone, or for all of the photo.
Kinds nest: rest < one step < several steps < each photo by itself.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.reconstruction.hypotheses.evidence import MOVE

Kind = Literal["step", "drift", "photo", "sway"]


@dataclass(frozen=True)
class Term:
    """One course of one motion."""

    kind: Kind
    course: Float64[np.ndarray, " n"]
    """How much of the motion each of the common photos shows."""
    turns: bool = True
    at: int = 0
    """First photo after a step; the photo of a kind that concerns one alone."""

    def same_as(self, other: "Term") -> bool:
        """Whether it is the same kind of motion in the same photos."""
        return (self.kind, self.turns, self.at) == (other.kind, other.turns, other.at)

    @property
    def columns(self) -> Float64[np.ndarray, "m k"]:
        """Of the motion, 6 numbers a photo."""
        kept = np.eye(MOVE) if self.turns else np.eye(MOVE)[:, MOVE // 2 :]
        return np.kron(self.course[:, None], kept)

    @property
    def rivals(self) -> tuple[Float64[np.ndarray, " n"], ...]:
        """Courses that a lens may take. A step of all later photos is one of all earlier ones back:
        bodies have no place but against each other, and lenses have."""
        return (self.course, 1.0 - self.course) if self.kind == "step" else (self.course,)


def steps(photos: int, borders: tuple[int, ...] = ()) -> Iterator[Term]:
    """A step between any two photos that follow each other, but where one is already."""
    for at in range(1, photos):
        if at not in borders:
            yield Term("step", (np.arange(photos) >= at).astype(float), at=at)


def drifts(photos: Int64[np.ndarray, " n"]) -> Iterator[Term]:
    """Even from the first to the last, with a turn or without."""
    even = (photos - photos.mean()) / max(float(np.ptp(photos)), 1.0)
    yield Term("drift", even)
    yield Term("drift", even, turns=False)


def single_photos(photos: int) -> Iterator[Term]:
    for at, own in enumerate(np.eye(photos)):
        yield Term("photo", own, at=at)
