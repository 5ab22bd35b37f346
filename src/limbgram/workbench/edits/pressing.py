"""Pressing: where an edit of a positive presses on places that bear no pressure, and how deep."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh, changed_rows, dots
from limbgram.core.mesh.tree_cache import signed_on
from limbgram.workbench.anatomy.kind import SensitivePlace
from limbgram.workbench.frame.sensitive import sensitive_place
from limbgram.workbench.limb import Landmark, Limb
from limbgram.workbench.measures.lengths import barycentric_on_mesh

LEAST_PRESSURE_MM = 0.25
"""Least inward move that counts: from 0.25 mm of radius on, the fit of a socket shows it
(J. Sanders et al., J Rehabil Res Dev 49(4), 2012)."""
USUAL_DEPTH_MM = 10.0
"""Usual depth of a load or relief, or of all edits together where it works: more needs a word.

No limit has been published; this one is a convention. What is cut away are "small amounts"
(J. Zettl, J. Traub, Artificial Limbs 15(1), 1971); two experienced prosthetists differed by 2 mm,
and repeated themselves within 1 mm, where they cut most (P. Convery et al., Prosthet Orthot Int
27(3), 2003). Half an inch over the patellar tendon, as some schools teach for a cast that was not
pressed by hand, is above it and can be asked for."""
_FARTHEST_MM = 50.0
"""No edit moves a surface farther; a landmark that seems to was on a part that was cut off."""
_LEAST_COSINE = 0.7
"""Cosine to the normal below which the nearest place is the rim, and surface was added beyond."""


@dataclass(frozen=True, kw_only=True)
class Pressure:
    """A sensitive place that a change presses on."""

    place: str
    """Its name in the list of sensitive places, never the landmark's own."""
    why: str
    depth_mm: float
    """How far the surface went inward there, at most."""


@dataclass(frozen=True)
class SignedOffsets:
    """Signed distances of points from a surface, with the nearest places."""

    signed_mm: Float64[np.ndarray, " n"]
    """Distance, positive outward."""
    nearest_mm: Points3
    along: Float64[np.ndarray, " n"]
    """Absolute cosine between the direction to each point and the surface's normal."""


def signed_offsets(surface: Mesh, points_mm: Points3) -> SignedOffsets:
    """Signed distances of points from a surface."""
    found = signed_on(surface).query(points_mm)
    upward = dots(points_mm - found.points_mm, found.normals)
    return SignedOffsets(
        signed_mm=found.signed_mm,
        nearest_mm=found.points_mm,
        along=np.abs(upward) / np.maximum(np.abs(found.signed_mm), 1e-30),
    )


@dataclass(frozen=True, kw_only=True)
class SkinHistory:
    """The skin's first position and its movement since, at each vertex near a sensitive place.

    Both go along with the vertices through all edits, so that loads beside each other do not add
    up, and room at a landmark does not hide that the skin was pressed a little beside it.
    """

    start_mm: Points3
    """In the frame of the first shape; NaN far from every sensitive place."""
    moved_mm: Float64[np.ndarray, " n"]
    """Positive outward; turning or shifting the shape, or taking off its sock, does not count."""

    @classmethod
    def unmoved(cls, limb: Limb) -> "SkinHistory":
        """The state before the first edit."""
        return cls(start_mm=limb.mesh.vertices_mm, moved_mm=np.zeros(len(limb.mesh)))

    def after(self, before: Limb, after: Limb, *, moves_skin: bool) -> "SkinHistory":
        """The history after one more edit.

        Args:
            moves_skin: Whether the edit's movement counts; else it only carries the skin along.
        """
        if not moves_skin and same_triangles(before.mesh, after.mesh):
            return self
        count = len(after.mesh)
        shared = min(count, len(before.mesh))
        start_mm, moved_mm = np.full((count, 3), np.nan), np.zeros(count)
        start_mm[:shared], moved_mm[:shared] = self.start_mm[:shared], self.moved_mm[:shared]
        changed = changed_vertices(before.mesh, after.mesh)
        start_mm[changed] = np.nan
        marks = sensitive_marks(after)
        starts = np.array([mark.position_mm for mark, _ in marks]).reshape(-1, 3)
        changed &= _near_places(
            after.mesh, starts, np.array([place.reach_mm for _, place in marks])
        )
        if changed.any():
            away = signed_offsets(before.mesh, after.mesh.vertices_mm[changed])
            ids, shares = barycentric_on_mesh(before.mesh, away.nearest_mm)
            start_mm[changed] = np.einsum("pk,pki->pi", shares, self.start_mm[ids])
            moved_mm[changed] = (shares * self.moved_mm[ids]).sum(1)
            if moves_skin:
                moved_mm[changed] += np.where(away.along > _LEAST_COSINE, away.signed_mm, 0.0)
        return SkinHistory(start_mm=start_mm, moved_mm=moved_mm)

    def pressed_mm(self, limb: Limb) -> dict[str, float]:
        """The greatest depth of the skin within reach of each sensitive place."""
        deepest: dict[str, float] = {}
        for mark, place in sensitive_marks(limb):
            within = np.linalg.norm(self.start_mm - mark.position_mm, axis=1) <= place.reach_mm
            inward_mm = float((-self.moved_mm[within]).max(initial=0.0))
            deepest[place.name] = max(inward_mm, deepest.get(place.name, 0.0))
        return deepest


@dataclass(frozen=True, kw_only=True)
class PlaceEffects:
    """What a change did at a limb's sensitive places: pressures and shifts."""

    pressures: tuple[Pressure, ...]
    """Places within whose reach the surface moved inward."""
    shifts_mm: Mapping[str, float]
    """How far each place's own landmark moved, positive outward: room."""


def sensitive_marks(limb: Limb) -> tuple[tuple[Landmark, SensitivePlace], ...]:
    """The limb's landmarks on sensitive places, each with its place."""
    return tuple(
        (mark, place)
        for mark in limb.landmarks
        if (place := sensitive_place(mark.name, limb.kind)) is not None
    )


def effects_at_places(before: Limb, after: Limb) -> PlaceEffects:
    """What a change did at the sensitive places that the limb's landmarks mark."""
    ends = {mark.name: mark.position_mm for mark in after.landmarks}
    known = [(mark, place) for mark, place in sensitive_marks(before) if mark.name in ends]
    if not known:
        return PlaceEffects(pressures=(), shifts_mm={})
    starts = np.stack([mark.position_mm for mark, _ in known])
    reaches = np.array([place.reach_mm for _, place in known])
    changed = _near_places(after.mesh, starts, reaches) & changed_vertices(before.mesh, after.mesh)
    stops = np.stack([ends[mark.name] for mark, _ in known])
    count = len(known)
    points = np.concatenate([starts, stops, after.mesh.vertices_mm[changed]])
    away = signed_offsets(before.mesh, points)
    shift_mm = away.signed_mm[count : 2 * count] - away.signed_mm[:count]
    inward_mm = np.where(away.along > _LEAST_COSINE, -away.signed_mm, 0.0)[2 * count :]
    start_mm = away.nearest_mm[2 * count :]
    deepest: dict[str, Pressure] = {}
    shifts: dict[str, float] = {}
    for k, (_, place) in enumerate(known):
        if abs(shift_mm[k]) > _FARTHEST_MM:
            continue
        shifts[place.name] = min(float(shift_mm[k]), shifts.get(place.name, np.inf))
        within = np.linalg.norm(start_mm - starts[k], axis=1) <= reaches[k]
        depth = max(-float(shift_mm[k]), float(inward_mm[within].max(initial=0.0)))
        if depth > max(
            LEAST_PRESSURE_MM, deepest[place.name].depth_mm if place.name in deepest else 0.0
        ):
            deepest[place.name] = Pressure(place=place.name, why=place.why, depth_mm=depth)
    return PlaceEffects(pressures=tuple(deepest.values()), shifts_mm=shifts)


def depths_from_start(start: Mesh, before: Mesh, after: Mesh) -> tuple[float, float]:
    """The greatest depth and height of the moved vertices against the start, both from 0 up."""
    moved = changed_vertices(before, after)
    if not moved.any():
        return 0.0, 0.0
    away = signed_offsets(start, after.vertices_mm[moved])
    signed = away.signed_mm[away.along > _LEAST_COSINE]
    return float(max(0.0, (-signed).max(initial=0.0))), float(signed.max(initial=0.0))


def changed_vertices(old: Mesh, new: Mesh) -> Bool[np.ndarray, " n"]:
    """Vertices that differ from the old mesh's vertex of the same index, or are new."""
    return changed_rows(old.vertices_mm, new.vertices_mm)


def same_triangles(old: Mesh, new: Mesh) -> bool:
    """Whether both have the same triangles, turned over or not, as by a mirror."""
    return np.array_equal(np.sort(old.faces, axis=1), np.sort(new.faces, axis=1))


def _near_places(
    mesh: Mesh, places: Float64[np.ndarray, "k 3"], reaches: Float64[np.ndarray, " k"]
) -> Bool[np.ndarray, " n"]:
    """Vertices that may have been within reach of a place."""
    near = np.zeros(len(mesh), np.bool_)
    for place, reach in zip(places, reaches, strict=True):
        near |= np.linalg.norm(mesh.vertices_mm - place, axis=1) < reach + _FARTHEST_MM
    return near
