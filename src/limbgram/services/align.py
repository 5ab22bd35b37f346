"""Align: a shape gets its axes from landmarks, its side and what is stated of its directions.

In      a limb in its mesh's frame; what the clinician states; the frame of the shape's own file; a
        marked limb whose landmarks are proposed on it.
Out     the limb with its frame: +Z proximal, +Y anterior, +X the patient's right, origin distal.
Fails   MeasureError: something is not stated, or landmarks or file contradict it; the marked limb
        is another one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Annotated, Literal

import numpy as np

from limbgram.core.geometry.arrays import Vector3
from limbgram.core.request_fields import Flag, Within
from limbgram.services.parse_text import AXIS, DIRECTION, PAIR, Direction, Pair
from limbgram.workbench.compare.carried_landmarks import Carried, carry_landmarks
from limbgram.workbench.frame.alignment import AlignOptions
from limbgram.workbench.frame.alignment import align as with_frame
from limbgram.workbench.frame.landmarks import with_confirmed, with_landmarks
from limbgram.workbench.limb import AlignedLimb, AnyLimb, KindName, Limb, LimbFrame, Side

ALL = "all"
"""In place of names, every landmark."""


@dataclass(frozen=True, kw_only=True)
class Axes:
    """What is stated of the axes; directions are in the frame of the shape."""

    axis: Annotated[Direction | Literal["fit"] | None, AXIS] = None
    """Long axis, pointing proximally: +z; or fit. Without it an AOP's own axis and origin, else
    fit."""
    proximal: Annotated[Direction | None, DIRECTION] = None
    """Rough direction towards the body, such as +z: for a foot, and where nothing else tells it."""
    anterior: Annotated[Direction | None, DIRECTION] = None
    """Rough direction forwards, in place of landmarks or an AOP's own: +y or 0.2,-1,0."""
    plumb: Annotated[Pair | None, PAIR] = None
    """UPPER:LOWER landmarks to lie one above the other in the side view."""
    flexion_deg: Annotated[float, Within(-120, 120), Flag("flexion")] = 0.0
    """Turn further in the side view, degrees; positive takes the top backwards."""


@dataclass(frozen=True, kw_only=True)
class AlignRequest(Axes):
    """How a shape is aligned; directions are in the frame of the shape."""

    side: Side
    """Side of the patient: never guessed. none for a torso."""
    kind: KindName | None = None
    """Kind of limb, which tells what the names of landmarks mean; kept with the shape."""

    @classmethod
    def of(cls, axes: Axes, side: Side, kind: KindName | None) -> "AlignRequest":
        stated = {one.name: getattr(axes, one.name) for one in fields(Axes)}
        return cls(side=side, kind=kind, **stated)

    def options(self, declared: LimbFrame | None) -> AlignOptions:
        """The options of the workbench."""
        return AlignOptions(
            side=self.side,
            kind=self.kind,
            axis=None if self.axis == "fit" else _vector_or_none(self.axis),
            fit_anew=self.axis == "fit",
            proximal=_vector_or_none(self.proximal),
            anterior=_vector_or_none(self.anterior),
            plumb=self.plumb,
            flexion_deg=self.flexion_deg,
            declared=declared,
        )


def align(limb: Limb, ask: AlignRequest, declared: LimbFrame | None = None) -> AlignedLimb:
    """Give a shape its axes.

    Args:
        limb: With its landmarks.
        declared: What the shape's own file says of its axes.

    Raises:
        MeasureError: proximal or anterior is not told, or told in contradiction.
        OptionsError: a direction that cannot be meant.
    """
    return with_frame(limb, ask.options(declared))


@dataclass(frozen=True, kw_only=True)
class Proposed:
    """A limb with proposals that nobody has confirmed, and what was not carried over to it."""

    limb: Limb
    carried: Carried


def propose(limb: Limb, marked: Limb, side: Side, kind: KindName | None) -> Proposed:
    """Carry the landmarks of a marked limb, such as an earlier visit's, over to this one.

    Landmarks that this limb has, and that somebody placed or confirmed, stay.

    Raises:
        MeasureError: the marked limb is of another kind or side, or hardly the same limb.
    """
    known = replace(limb, kind=kind or limb.kind)
    carried = carry_landmarks(known, marked, side)
    return Proposed(limb=with_landmarks(limb, carried.landmarks), carried=carried)


def confirm(limb: AnyLimb, names: Sequence[str]) -> AnyLimb:
    """Somebody looked at proposals and says that they stand where they should.

    Args:
        names: Of landmarks; "all" for every one.

    Raises:
        MeasureError: the limb has no landmark of such a name.
    """
    every = [mark.name for mark in limb.landmarks]
    return with_confirmed(limb, every if tuple(names) == (ALL,) else names)


def _vector_or_none(given: Direction | None) -> Vector3 | None:
    return None if given is None else np.array(given, np.float64)
