"""Suggested landmarks: places that the shape itself tells, before anybody has felt for them.

In      a Limb, aligned or not, of a known kind.
Out     guessed places with their names; none where the shape tells nothing.
Method  The round end of a residual limb is its place farthest along the long axis, away from the
        body. Bones under the skin are not told by the surface to a clinician's standard, so none of
        them is guessed: a wrong guess that is confirmed in a hurry is worse than an empty row.
Fails   never: a shape without an axis, or whose proximal end nothing tells, has no guesses.
"""

from dataclasses import dataclass

import numpy as np

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.mesh.axis import fit_axis
from limbgram.workbench.anatomy.names import identity_of
from limbgram.workbench.bodies import outer_bodies
from limbgram.workbench.frame.alignment import AlignOptions, proximal_direction
from limbgram.workbench.limb import KIND_NAMED, AlignedLimb, Limb


@dataclass(frozen=True, kw_only=True)
class GuessedPlace:
    """A place that may be the landmark of that name."""

    name: str
    position_mm: Vector3
    """On the surface, in the mesh's frame."""


def guess_places(limb: Limb) -> tuple[GuessedPlace, ...]:
    """Landmarks guessed from the shape, without those that it has."""
    known = {identity_of(mark.name) for mark in limb.landmarks}
    if limb.kind is None or not KIND_NAMED[limb.kind].round_ended or "distal end" in known:
        return ()
    limb = limb.with_mesh(outer_bodies(limb.mesh).mesh)
    up = _proximal_direction(limb)
    if up is None:
        return ()
    at = int(np.argmin(limb.mesh.vertices_mm @ up))
    return (GuessedPlace(name="distal end", position_mm=limb.mesh.vertices_mm[at]),)


def _proximal_direction(limb: Limb) -> Vector3 | None:
    """The proximal direction, by the limb's frame or else by brim and landmarks."""
    if isinstance(limb, AlignedLimb):
        return limb.limb_from_mesh.rotation[2]
    try:
        return proximal_direction(limb, fit_axis(limb.mesh), AlignOptions(side="none"))[0]
    except MeasureError:
        return None
