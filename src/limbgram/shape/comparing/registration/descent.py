"""Descent: how two shapes lie to each other because one was made from the other.

The limb files name what a shape was made from, and the motion between both meshes' axes. Where
they do not (older ones, and files of other programs) the shapes themselves tell. An edited shape
keeps its scan's limb frame to the last digit, and often some of its vertices. Two
scans never do: each is aligned by its own landmarks. Laid on each other by shape, what was
taken off would turn into a slide along the axis.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from limbgram.geometry.rigid import Rigid
from limbgram.shape.limb import Limb, LimbFrame

_SAME_FRAME = 1e-9
_SAME_PLACE_MM = 1e-3
"""A file's rounding."""
_PROBES = 500
_SHARED = 0.05
"""Of the second's vertices that lie on the first's: more than ends and axes have by chance."""


@dataclass(frozen=True)
class Descent:
    """How a shape and what was made from it lie to each other."""

    first_from_second: Rigid
    """Between the frames of the meshes."""
    reason: str
    """Words after "because"."""


def descent(first: Limb, second: Limb) -> Descent | None:
    """How both lie, if one was made from the other; None where nothing tells."""
    told = _by_origins(first, second)
    if told is not None:
        return Descent(told, "their limb files name one file that both come from")
    reason = _why_alike(first, second)
    return None if reason is None else Descent(Rigid.identity(), reason)


def _by_origins(first: Limb, second: Limb) -> Rigid | None:
    """By the nearest file that both come from, read in the same unit."""
    theirs = {(one.sha256, one.mm_per_unit): one for one in reversed(second.origins)}
    for own in first.origins:
        other = theirs.get((own.sha256, own.mm_per_unit))
        if other is not None:
            return own.mesh_from_origin @ other.mesh_from_origin.inverse
    return None


def _why_alike(first: Limb, second: Limb) -> str | None:
    """Why both lie in the same coordinates; None where nothing tells."""
    if _shared_share(first, second) >= _SHARED:
        return "they share vertices, so one was made from the other"
    one, two = first.frame, second.frame
    if one is None or two is None or not _same_frame(one, two):
        return None
    if _free(one) or _same_faces(first, second) or _same_landmarks(first, second):
        return "both carry the same limb frame, so one was made from the other"
    return None


def _shared_share(first: Limb, second: Limb) -> float:
    own = second.mesh.vertices_mm
    probes = own[np.linspace(0, len(own) - 1, min(_PROBES, len(own))).astype(int)]
    off_mm = np.asarray(KDTree(first.mesh.vertices_mm).query(probes)[0])
    return float(np.mean(off_mm < _SAME_PLACE_MM))


def _same_frame(one: LimbFrame, two: LimbFrame) -> bool:
    motions = one.limb_from_mesh, two.limb_from_mesh
    turned = np.abs(motions[0].rotation - motions[1].rotation).max()
    shifted = np.abs(motions[0].translation - motions[1].translation).max()
    return bool(turned < _SAME_FRAME and shifted < _SAME_PLACE_MM)


def _free(frame: LimbFrame) -> bool:
    """Whether the axes lie as no file format puts them by itself: not along the file's own."""
    return bool(np.abs(frame.limb_from_mesh.rotation).max(1).min() < 1 - _SAME_FRAME)


def _same_faces(first: Limb, second: Limb) -> bool:
    return np.array_equal(first.mesh.faces, second.mesh.faces)


def _same_landmarks(first: Limb, second: Limb) -> bool:
    """One landmark that no edit moved is enough: nobody marks a place twice to the micrometre."""
    places = {mark.name: mark.position_mm for mark in first.landmarks}
    return any(
        mark.name in places
        and float(np.abs(places[mark.name] - mark.position_mm).max()) < _SAME_PLACE_MM
        for mark in second.landmarks
    )
