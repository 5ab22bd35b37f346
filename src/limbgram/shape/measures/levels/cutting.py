"""Cutting: whole cross-sections of a limb, their loops told apart by how they lie in each other.

Heights are z in the limb frame; a mesh "in the limb frame" has its vertices there already.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64

from limbgram.errors import MeasureError
from limbgram.geometry.arrays import Points2
from limbgram.surface.mesh import Mesh
from limbgram.surface.sections import Section, cut

_LEAST_AREA_MM2 = 1e-6
"""Smaller loops are where a plane touches a peak or a pit."""
_CRUMB_SHARE = 0.002
"""An outline with less of the largest one's area is no limb: on a leg it is 5 mm across, and no
tape, of which the narrowest have 6 mm, can rest on it. The hull of a section would reach out to it:
five points of under 0.01 mm2 beside a real stump, where a plane just meets a bulge, added 1.4 mm to
a girth of 350 mm."""


@dataclass(frozen=True, kw_only=True)
class Level:
    """A cut across a limb: one or more closed loops."""

    height_mm: float
    points_mm: Points2
    """x and y of all loops, one loop behind the other; material lies to the left."""
    after: Int64[np.ndarray, " k"]
    """Index of the next point round each point's loop."""
    loop: Int64[np.ndarray, " k"]
    """Loop of each point."""
    depth: Int64[np.ndarray, " l"]
    """Number of loops round each loop: outlines have 0, the rims of hollows 1."""
    left_out: int
    """Crumbs: outlines too small to be the limb, which no figure counts."""
    crossed: Int32[np.ndarray, "k 2"]
    shares: Float64[np.ndarray, " k"]
    """The mesh's edge on which each point lies, and how far along it."""

    @property
    def outer(self) -> Bool[np.ndarray, " k"]:
        """Points of the outlines."""
        return self.depth[self.loop] == 0


@dataclass(frozen=True)
class Refused:
    """A height at which there is no answer, and why."""

    height_mm: float
    reason: str


def level_at(mesh_in_limb: Mesh, height_mm: float) -> Level:
    """The cut at one height.

    Raises:
        MeasureError: the plane misses the limb, runs into its open brim, or the loops contradict
            each other.
    """
    (level,) = levels_at(mesh_in_limb, [height_mm])
    if isinstance(level, Refused):
        raise MeasureError(level.reason)
    return level


def levels_at(mesh_in_limb: Mesh, heights_mm: Sequence[float]) -> tuple[Level | Refused, ...]:
    """The cut at each height, in the order asked: as many answers as heights."""
    by_height: dict[float, list[Section]] = {float(height): [] for height in heights_mm}
    for section in cut(mesh_in_limb, [h for h in by_height if np.isfinite(h)]):
        by_height[section.offset_mm].append(section)
    levels = {h: _level(mesh_in_limb, h, sections) for h, sections in by_height.items()}
    return tuple(levels[float(height)] for height in heights_mm)


def _level(mesh: Mesh, height_mm: float, sections: list[Section]) -> Level | Refused:
    if not sections:
        low, high = (
            float(end) for end in (mesh.vertices_mm[:, 2].min(), mesh.vertices_mm[:, 2].max())
        )
        return Refused(
            height_mm,
            f"The plane at {height_mm:.2f} mm misses the limb, which reaches from {low:.2f} to "
            f"{high:.2f} mm. Choose a height between them.",
        )
    if not all(section.closed for section in sections):
        return Refused(
            height_mm,
            f"The plane at {height_mm:.2f} mm runs into an open edge of the surface, the brim or a "
            "hole: there is no whole girth. Choose a height that is clear of it, or fill the hole.",
        )
    up = np.array([0.0, 0.0, 1.0])
    sections = [section for section in sections if abs(section.area_mm2(up)) > _LEAST_AREA_MM2]
    if not sections:
        return Refused(
            height_mm,
            f"The plane at {height_mm:.2f} mm only touches the limb. Choose a height inside it.",
        )
    rings = [section.points_mm[:, :2] for section in sections]
    depth = np.array([sum(_holds(o, ring[0]) for o in rings if o is not ring) for ring in rings])
    outward = np.array([section.area_mm2(up) > 0 for section in sections])
    if (outward != (depth % 2 == 0)).any():
        return Refused(
            height_mm,
            f"At {height_mm:.2f} mm the surface cuts through itself or is partly inside out: its "
            f"{len(rings)} loops do not lie in each other as outlines and hollows. Repair the "
            "shape, or choose another height.",
        )
    crumbs = _crumbs(sections, rings, depth)
    keep = np.flatnonzero(~crumbs).tolist()
    sections, rings, depth = [sections[k] for k in keep], [rings[k] for k in keep], depth[keep]
    sizes = [len(ring) for ring in rings]
    starts = np.cumsum([0, *sizes[:-1]])
    after = np.concatenate([start + np.roll(np.arange(n), -1) for start, n in zip(starts, sizes)])
    return Level(
        height_mm=height_mm,
        left_out=int(crumbs.sum()),
        points_mm=np.concatenate(rings),
        after=after,
        loop=np.repeat(np.arange(len(rings)), sizes),
        depth=depth,
        crossed=np.concatenate([section.crossed for section in sections]),
        shares=np.concatenate([section.shares for section in sections]),
    )


def _crumbs(
    sections: list[Section], rings: list[Points2], depth: Int64[np.ndarray, " l"]
) -> Bool[np.ndarray, " l"]:
    """Outlines too small to be the limb, and what lies in them."""
    up = np.array([0.0, 0.0, 1.0])
    areas = np.array([abs(section.area_mm2(up)) for section in sections])
    crumbs = (depth == 0) & (areas < _CRUMB_SHARE * areas.max())
    for k in np.flatnonzero(crumbs):
        crumbs |= np.array([_holds(rings[k], ring[0]) for ring in rings]) & (depth > 0)
    return crumbs


def _holds(ring: Points2, point: Float64[np.ndarray, "2"]) -> bool:
    """Whether a point lies inside a ring: a ray to +x crosses it an odd number of times."""
    (x, y), (x_next, y_next) = (ring - point).T, (np.roll(ring, -1, axis=0) - point).T
    astride = (y > 0) != (y_next > 0)
    rise = np.where(astride, y_next - y, 1.0)
    return bool(((x - y * (x_next - x) / rise > 0) & astride).sum() % 2)
