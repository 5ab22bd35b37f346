"""Terms: what may have happened between two bodies, each as design columns over the photos.

A term is a course (how much of one motion each photo shows) of a kind. Its rival is a lens that
changes along the same course: another lens as the second body alone sees it, or for all of the
photo. The models are nested: no motion < one step < several steps < a motion in each photo.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.reconstruction.mapping.body_motion import MOTION_SIZE

Kind = Literal["step", "drift", "photo", "sway"]


@dataclass(frozen=True)
class Term:
    """One motion that the photos show along one course."""

    kind: Kind
    course: Float64[np.ndarray, " n"]
    """How much of the motion each of the common photos shows."""
    rotates: bool = True
    """Whether the motion has a rotation beside its shift."""
    at: int = 0
    """First photo after a step; the photo of a term that concerns one alone."""

    def same_as(self, other: "Term") -> bool:
        """Whether it is the same kind of motion in the same photos."""
        return (self.kind, self.rotates, self.at) == (other.kind, other.rotates, other.at)

    @property
    def columns(self) -> Float64[np.ndarray, "m k"]:
        """Design columns over the motions of all photos, 6 rows a photo."""
        numbers = np.eye(MOTION_SIZE)
        kept = numbers if self.rotates else numbers[:, MOTION_SIZE // 2 :]
        return np.kron(self.course[:, None], kept)

    @property
    def lens_courses(self) -> tuple[Float64[np.ndarray, " n"], ...]:
        """Courses of the rival lenses.

        A step of all later photos is one of all earlier ones back: a motion is relative, so one
        course describes both, but a lens has an absolute value, and either course is a rival.
        """
        return (self.course, 1.0 - self.course) if self.kind == "step" else (self.course,)


def steps(photos: int, taken: tuple[int, ...] = ()) -> Iterator[Term]:
    """A step before each photo but the first and those where a step is `taken` already."""
    for at in range(1, photos):
        if at not in taken:
            yield Term("step", (np.arange(photos) >= at).astype(float), at=at)


def drifts(photos: Int64[np.ndarray, " n"]) -> Iterator[Term]:
    """A uniform drift from the first photo to the last, with and without a rotation."""
    even = (photos - photos.mean()) / max(float(np.ptp(photos)), 1.0)
    yield Term("drift", even)
    yield Term("drift", even, rotates=False)


def single_photos(photos: int) -> Iterator[Term]:
    """For each photo, a motion in that photo alone."""
    for at, own in enumerate(np.eye(photos)):
        yield Term("photo", own, at=at)
