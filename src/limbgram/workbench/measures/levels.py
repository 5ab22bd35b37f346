"""Levels: closed cross-sections of a limb, their measures, and volumes between two heights.

In      a mesh with its vertices in the limb frame; heights are z there.
Out     Levels, their loops told apart by how they lie in each other; Figures with their sigmas.
Method  A level is of one limb: where a plane cuts several, as a trunk and its arms, two thighs, a
        heel and the forefoot, it is the outline that the long axis goes through; where it misses
        all, the limb is followed from height to height, and refused where nothing tells which it
        is. No tape goes round two. The others are named beside it.
        Each figure has a slope: how it changes as the level's points move. Through the slopes the
        sigmas of the vertices become the figure's own. A volume is the clipped solid, exactly,
        without building it, by the divergence of (x, y, 0) / 2: its flux through level caps is
        nothing, so the volume is the flux through the clipped triangles alone. What of a triangle
        lies below a height follows from the integrals of its three barycentric coordinates.
Fails   MeasureError: the surface is open between the heights.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.smoothed_length import SmoothedLength, smoothed_length, taut_length
from limbgram.core.interval import Interval, plus_minus
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.sections import Section, contains_point, cut, outlines_of_limb
from limbgram.core.mesh.topology import boundary_half_edges
from limbgram.core.mesh.uncertainty import extra_extremum_variance_mm2, propagate
from limbgram.findings import Finding, fault

_LEAST_AREA_MM2 = 1e-6
"""Smaller loops arise where a plane just touches a peak or a pit."""
_CRUMB_SHARE = 0.002
"""An outline with less of the largest one's area is no limb: on a leg it is 5 mm across, and no
tape, of which the narrowest have 6 mm, can rest on it. The hull of a section would reach out to it:
five points of under 0.01 mm2 beside a real stump, where a plane just meets a bulge, added 1.4 mm to
a girth of 350 mm."""
_SAME_POINT_MM = 1e-9
"""Points of a section nearer than this are one point, apart by rounding alone."""

AXIS_MM = (0.0, 0.0)
"""Where the long axis passes every level of the limb frame."""


@dataclass(frozen=True, kw_only=True)
class OtherOutline:
    """An outline at a level that belongs to another limb than the measured one."""

    contour_mm: float
    area_mm2: float
    """Area of its material."""
    middle_mm: Float64[np.ndarray, "2"]
    """Mean of x and y round it."""


@dataclass(frozen=True, kw_only=True)
class Level:
    """A cut across a limb: its outline and the rims of hollows in it."""

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
    """Number of crumbs, outlines too small to be a limb; they are not listed as others."""
    others: tuple[OtherOutline, ...] = ()
    """Outlines of other limbs at this height, the largest first; no figure counts them."""
    crossed: Int32[np.ndarray, "k 2"]
    shares: Float64[np.ndarray, " k"]
    """The mesh's edge on which each point lies, and how far along it."""

    @property
    def outer(self) -> Bool[np.ndarray, " k"]:
        """Which points lie on outlines, not on the rims of hollows."""
        return self.depth[self.loop] == 0


class Extremity(NamedTuple):
    """A direction in which a measure depends on an outline's extreme point."""

    x: float
    y: float
    times: float
    """Factor with which the extreme point counts in the measure."""


@dataclass(frozen=True)
class Measured:
    """A measure of a level, and its change for a millimetre of each point in x and y."""

    value: float
    slopes: Float64[np.ndarray, "k 2"]
    along_mm: Float64[np.ndarray, " k"] | None = None
    """Length along the surface that belongs to each point, for a measure that is such a length."""
    reaches: tuple[Extremity, ...] = ()
    """The directions in which extreme points determine it."""


Measure = Callable[[Level], Measured | None]


def contour_mm(level: Level) -> Measured:
    """Girth along the outline at the smoothing length, into every hollow that is wider."""
    return _outline_length(level, partial(smoothed_length, closed=True))


def tape_mm(level: Level) -> Measured:
    """Girth as a taut tape reads it, round the outline at the smoothing length.

    Relief that the surface has lost lengthens it where it lies on the outline; bridges stay.
    """
    return _outline_length(level, taut_length)


def tape_value_mm(level: Level) -> float:
    """The value of `tape_mm`, without its slopes."""
    return float(sum(taut_length(level.points_mm[one]).value_mm for one in _outlines(level)))


def ml_mm(level: Level) -> Measured:
    """Caliper width from side to side, along x."""
    return _caliper_width(level, 0)


def ap_mm(level: Level) -> Measured:
    """Caliper width from front to back, along y."""
    return _caliper_width(level, 1)


def ml_through_mm(level: Level) -> Measured | None:
    """Width from side to side on the line through the long axis; None where it meets nothing."""
    return _width_through_axis(level, 0)


def ap_through_mm(level: Level) -> Measured | None:
    """Width from front to back on the line through the long axis."""
    return _width_through_axis(level, 1)


def area_mm2(level: Level) -> Measured:
    """Area of the material, without hollows."""
    points, after = level.points_mm, level.after
    before = np.empty_like(after)
    before[after] = np.arange(len(after))
    middle = points[level.outer].mean(0)
    x, y = (points - middle).T
    value = 0.5 * float(np.sum(x * y[after] - x[after] * y))
    slopes = 0.5 * np.column_stack([y[after] - y[before], x[before] - x[after]])
    return Measured(value, slopes)


def radius_mm(level: Level) -> Measured:
    """Radius of the circle of the same area."""
    area = area_mm2(level)
    radius = float(np.sqrt(max(area.value, 0.0) / np.pi))
    return Measured(radius, area.slopes / (2 * np.pi * max(radius, 1e-300)))


MEASURES: dict[str, Measure] = {
    "contour_mm": contour_mm,
    "tape_mm": tape_mm,
    "ml_mm": ml_mm,
    "ap_mm": ap_mm,
    "ml_through_mm": ml_through_mm,
    "ap_through_mm": ap_through_mm,
    "area_mm2": area_mm2,
    "radius_mm": radius_mm,
}
"""Everything that is measured at a level, by its name in tables."""
DISTAL_END, PROXIMAL_END = -np.inf, np.inf
"""Heights that stand for the ends of a closed surface."""


@dataclass(frozen=True)
class Refused:
    """A height at which nothing can be measured, and the reason."""

    height_mm: float
    reason: Finding


@dataclass(frozen=True)
class Figure:
    """A measure of the limb and its standard deviation, None where the mesh carries no sigmas."""

    value: float
    sigma: float | None

    @property
    def interval(self) -> Interval | None:
        """The interval that holds the true value in 95 of 100 cases, told as ±."""
        return None if self.sigma is None else Interval.of_sigma(self.sigma)

    @property
    def with_interval(self) -> str:
        """The value to a tenth, with its ±, for tables that people read."""
        return f"{self.value:.1f} {plus_minus(self.interval, 1)}".rstrip()


@dataclass(frozen=True)
class Sigmas:
    """Propagates the sigmas of a mesh to figures, through the slopes of points."""

    mesh: Mesh
    normals: Points3

    @classmethod
    def of(cls, mesh_in_limb: Mesh) -> "Sigmas":
        """Of a mesh; one of which no vertex was measured carries no sigmas."""
        mesh, sigma_mm = mesh_in_limb, mesh_in_limb.sigma_mm
        if sigma_mm is not None and not np.isfinite(sigma_mm).any():
            mesh = replace(mesh, sigma_mm=None)
        return cls(mesh, mesh.vertex_normals())

    def moved(self, motion: Rigid) -> "Sigmas":
        return Sigmas(self.mesh.moved(motion), self.normals @ motion.rotation.T)

    def figure(self, level: Level, sloped: Measured) -> Figure:
        """The limb's figure: the surface's own measure, with lost length added, and its sigma."""
        if self.mesh.sigma_mm is None:
            return Figure(sloped.value, None)
        sigma = propagate(self.mesh, self.gradient(level, sloped)) or 0.0
        sigma = math.sqrt(max(sigma**2 + self.extremity_variance(level, sloped.reaches), 0.0))
        lost_length_mm, lost_sigma_mm = self.lost_along_mm(level, sloped)
        return Figure(sloped.value + lost_length_mm, math.hypot(sigma, lost_sigma_mm))

    def lost_along_mm(self, level: Level, sloped: Measured) -> tuple[float, float]:
        """How much longer a measure along the surface is on the limb, and its sigma."""
        if sloped.along_mm is None or self.mesh.lost_length is None or self.mesh.sigma_mm is None:
            return 0.0, 0.0
        parts = np.column_stack([1 - level.shares, level.shares])
        x, y, _ = np.einsum("ke,kei->ik", parts, self.normals[level.crossed])
        ways = unit(np.column_stack([-y, x, np.zeros(len(x))]))
        return self.lost_length_mm(level.crossed, parts, ways, sloped.along_mm)

    def lost_length_mm(
        self,
        vertices: Int32[np.ndarray, "k c"],
        shares: Float64[np.ndarray, "k c"],
        ways: Points3,
        along_mm: Float64[np.ndarray, " k"],
    ) -> tuple[float, float]:
        """How much longer a line over the limb is than over this surface, and its sigma.

        Args:
            vertices: The vertices between which each segment of the line lies, with their shares.
            ways: Directions of the segments, unit vectors along the surface.
            along_mm: Lengths of the segments.
        """
        lost, across = self.mesh.lost_length, self.mesh.lost_across
        if lost is None:
            return 0.0, 0.0
        ends = lost.astype(np.float64)[vertices]
        if across is not None:
            folds = across.astype(np.float64)[vertices]
            size = np.maximum(np.linalg.norm(folds, axis=-1), np.finfo(float).tiny)
            ends[..., 0] += 2 * np.einsum("kcd,kd->kc", folds, ways) ** 2 / size - size
        more, sigma = along_mm @ np.einsum("kc,kcf->kf", shares, ends)
        return float(more), float(sigma)

    def gradient(self, level: Level, sloped: Measured) -> Float64[np.ndarray, " n"]:
        """Change of the figure for a millimetre of each vertex along its normal.

        The surface moves along its own normal, so its cut moves along the normal in the plane,
        further the more the surface leans. The direction of edges has no part in it: along one that
        nearly lies in the plane a point would slide without end.
        """
        total = self._edge_end_changes(level, sloped.slopes).ravel()
        return np.bincount(level.crossed.ravel(), total, len(self.mesh))

    def extremity_variance(self, level: Level, reaches: tuple[Extremity, ...]) -> float:
        """Variance of extreme points beyond their own: another point may be extreme where they err,
        or where a fill beside them bulges."""
        outer = level.outer
        each = [
            one.times**2
            * extra_extremum_variance_mm2(
                self.mesh,
                (level.points_mm @ (one.x, one.y))[outer],
                level.crossed[outer],
                self._edge_end_changes(level, np.tile((one.x, one.y), (len(outer), 1)))[outer],
            )
            for one in reaches
        ]
        return sum(each)

    def _edge_end_changes(
        self, level: Level, slopes: Float64[np.ndarray, "k 2"]
    ) -> Float64[np.ndarray, "k 2"]:
        """Change for a millimetre of the vertices at both ends of each point's edge."""
        ends = self.normals[level.crossed]
        parts = np.column_stack([1 - level.shares, level.shares])
        normal = unit(np.einsum("ke,ked->kd", parts, ends))
        steep = np.maximum((normal[:, :2] ** 2).sum(1), np.finfo(float).tiny)
        change = (slopes * normal[:, :2]).sum(1) / steep
        along = np.einsum("ked,kd->ke", ends, normal)
        return parts * along * change[:, None]


@dataclass(frozen=True, kw_only=True)
class Volumes:
    """Volumes of one mesh in the limb frame, prepared once for many heights."""

    sigmas: Sigmas
    heights: Float64[np.ndarray, "f 3"]
    lowest: Float64[np.ndarray, " f"]
    highest: Float64[np.ndarray, " f"]
    corner_gains: Float64[np.ndarray, "f 3"]
    """Volume that a face gains while a corner's vertex goes a millimetre along its normal."""
    flux: Float64[np.ndarray, "f 3"]
    """Flux through a face, if a corner's barycentric coordinate were 1 all over it."""
    sorted_tops: Float64[np.ndarray, " f"]
    """Highest corners of the faces, sorted upwards."""
    flux_sums: Float64[np.ndarray, " f+1"]
    """Cumulative flux through the faces in that order."""
    open_edges: Float64[np.ndarray, "b 2"]
    """Lowest and highest end of each open edge."""

    @classmethod
    def of(cls, sigmas: Sigmas) -> "Volumes":
        mesh = sigmas.mesh
        heights = mesh.vertices_mm[:, 2][mesh.faces]
        lowest = np.minimum(np.minimum(heights[:, 0], heights[:, 1]), heights[:, 2])
        highest = np.maximum(np.maximum(heights[:, 0], heights[:, 1]), heights[:, 2])
        flat = (mesh.vertices_mm[:, :2] - mesh.vertices_mm[:, :2].mean(0))[mesh.faces]
        half_normals = mesh.face_normals() / 2
        flux = 0.5 * np.einsum("fkd,fd->fk", flat, half_normals[:, :2])
        order = np.argsort(highest, kind="stable")
        open_edges = mesh.vertices_mm[:, 2][boundary_half_edges(mesh.faces)]
        return cls(
            sigmas=sigmas,
            heights=heights,
            lowest=lowest,
            highest=highest,
            corner_gains=np.einsum("fkd,fd->fk", sigmas.normals[mesh.faces], half_normals),
            flux=flux,
            sorted_tops=highest[order],
            flux_sums=np.concatenate([[0.0], np.cumsum(flux.sum(1)[order] / 3)]),
            open_edges=np.sort(open_edges, axis=1),
        )

    def between(self, low_mm: float, high_mm: float) -> Figure:
        """Volume between two heights, mm3; negative where they are swapped or faces are inside out.

        Raises:
            MeasureError: the surface is open between the heights, or one misses the limb.
        """
        self._require_closed(min(low_mm, high_mm), max(low_mm, high_mm))
        value = self._below(high_mm) - self._below(low_mm)
        if self.sigmas.mesh.sigma_mm is None:
            return Figure(value, None)
        return Figure(value, propagate(self.sigmas.mesh, self.gradient(low_mm, high_mm)))

    def gradient(self, low_mm: float, high_mm: float) -> Float64[np.ndarray, " n"]:
        """Change of the volume for a millimetre of each vertex along its normal."""
        faces = self.sigmas.mesh.faces
        low, high = min(low_mm, high_mm), max(low_mm, high_mm)
        within = np.flatnonzero((self.highest > low) & (self.lowest < high))
        heights = self.heights[within]
        parts = barycentric_means_below(heights, high_mm) - barycentric_means_below(heights, low_mm)
        changes = (parts * self.corner_gains[within]).ravel()
        return np.bincount(faces[within].ravel(), changes, len(self.sigmas.mesh.vertices_mm))

    def _below(self, height_mm: float) -> float:
        crossed = np.flatnonzero((self.lowest < height_mm) & (self.highest > height_mm))
        parts = barycentric_means_below(self.heights[crossed], height_mm)
        whole = self.flux_sums[np.searchsorted(self.sorted_tops, height_mm, side="right")]
        return float(whole) + float((parts * self.flux[crossed]).sum())

    def _require_closed(self, low_mm: float, high_mm: float) -> None:
        ends = float(self.lowest.min()), float(self.sorted_tops[-1])
        for height in (low_mm, high_mm):
            if np.isnan(height) or (np.isfinite(height) and not ends[0] <= height <= ends[1]):
                raise MeasureError(
                    "measure.volume.beyond", height_mm=height, low_mm=ends[0], high_mm=ends[1]
                )
        open_here = (self.open_edges[:, 0] < high_mm) & (self.open_edges[:, 1] > low_mm)
        if open_here.any():
            raise MeasureError(
                "measure.volume.open",
                low_mm=_finite_or_none(low_mm),
                high_mm=_finite_or_none(high_mm),
                open_from_mm=float(self.open_edges[open_here].min()),
                open_to_mm=float(self.open_edges[open_here].max()),
            )


def level_at(
    mesh_in_limb: Mesh, height_mm: float, through_mm: tuple[float, float] = AXIS_MM
) -> Level:
    """The level at one height.

    Raises:
        MeasureError: the plane misses the limb, runs into its open brim, or the loops contradict
            each other.
    """
    (level,) = levels_at(mesh_in_limb, [height_mm], through_mm)
    if isinstance(level, Refused):
        raise MeasureError.of(level.reason)
    return level


def levels_at(
    mesh_in_limb: Mesh,
    heights_mm: Sequence[float],
    through_mm: tuple[float, float] = AXIS_MM,
) -> tuple[Level | Refused, ...]:
    """The level at each height, in the order asked, or the reason why there is none.

    Args:
        through_mm: Where a line along z goes through the limb that is measured.
    """
    levels = all_levels_at(mesh_in_limb, heights_mm)
    z = mesh_in_limb.vertices_mm[:, 2]
    chosen = outlines_of_limb(
        lambda heights: [_outlines_of(one) for one in all_levels_at(mesh_in_limb, heights)],
        (float(z.min()), float(z.max())),
        heights_mm,
        [_outlines_of(one) for one in levels],
        np.array(through_mm),
    )
    return tuple(
        level if isinstance(level, Refused) else _of_chosen_limb(level, limb)
        for level, limb in zip(levels, chosen, strict=True)
    )


def all_levels_at(mesh_in_limb: Mesh, heights_mm: Sequence[float]) -> tuple[Level | Refused, ...]:
    """Levels with the loops of all limbs at each height, before one limb is chosen."""
    by_height: dict[float, list[Section]] = {float(height): [] for height in heights_mm}
    for section in cut(mesh_in_limb, [h for h in by_height if np.isfinite(h)]):
        by_height[section.offset_mm].append(section)
    levels = {h: _level_of_sections(mesh_in_limb, h, sections) for h, sections in by_height.items()}
    return tuple(levels[float(height)] for height in heights_mm)


def _outlines_of(level: Level | Refused) -> list[Points2]:
    if isinstance(level, Refused):
        return []
    return [level.points_mm[level.loop == k] for k in np.flatnonzero(level.depth == 0)]


def _of_chosen_limb(level: Level, chosen: int | None) -> Level | Refused:
    """The level reduced to the loops of the chosen outline; other outlines are listed."""
    outlines = np.flatnonzero(level.depth == 0)
    if chosen is None:
        return Refused(
            level.height_mm,
            fault("measure.level.no_limb", height_mm=level.height_mm, outlines=len(outlines)),
        )
    if len(outlines) == 1:
        return level
    rings = [level.points_mm[level.loop == k] for k in range(len(level.depth))]
    limbs = [
        np.array(
            [
                k == outline or contains_point(rings[outline], ring[0])
                for k, ring in enumerate(rings)
            ]
        )
        for outline in outlines.tolist()
    ]
    others = [
        _other_outline(_with_loops(level, kept)) for k, kept in enumerate(limbs) if k != chosen
    ]
    others.sort(key=lambda other: -other.area_mm2)
    return replace(_with_loops(level, limbs[chosen]), others=tuple(others))


def _other_outline(level: Level) -> OtherOutline:
    return OtherOutline(
        contour_mm=contour_mm(level).value,
        area_mm2=area_mm2(level).value,
        middle_mm=level.points_mm[level.outer].mean(0),
    )


def _with_loops(level: Level, kept: Bool[np.ndarray, " l"]) -> Level:
    points = kept[level.loop]
    number = np.cumsum(points) - 1
    return replace(
        level,
        points_mm=level.points_mm[points],
        after=number[level.after[points]],
        loop=(np.cumsum(kept) - 1)[level.loop[points]],
        depth=level.depth[kept],
        crossed=level.crossed[points],
        shares=level.shares[points],
    )


def barycentric_means_below(
    heights: Float64[np.ndarray, "f 3"], height_mm: float
) -> Float64[np.ndarray, "f 3"]:
    """Mean of each barycentric coordinate over each face, over the part below a height only.

    A third each for a face that lies below it, zero for one above.
    """
    if not np.isfinite(height_mm):
        return np.full(heights.shape, 1 / 3 if height_mm > 0 else 0.0)
    below = heights <= height_mm
    count = below[:, 0].astype(np.int8) + below[:, 1] + below[:, 2]
    parts = np.where((count == 3)[:, None], 1 / 3, np.zeros(heights.shape))
    for lone_below in (True, False):
        rows = np.flatnonzero(count == (1 if lone_below else 2))
        lone = (below[rows] == lone_below).argmax(1)
        order = (lone[:, None] + np.arange(3)) % 3
        apex, one, two = np.take_along_axis(heights[rows], order, axis=1).T
        # Shares of the lone corner's two sides that its small triangle takes.
        s, t = (height_mm - apex) / (one - apex), (height_mm - apex) / (two - apex)
        small = np.column_stack([3 - s - t, s, t]) * (s * t / 3)[:, None]
        values = small if lone_below else 1 / 3 - small
        parts[rows[:, None], order] = values
    return parts


def _finite_or_none(height_mm: float) -> float | None:
    """A finite height; None for an end of the limb."""
    return height_mm if np.isfinite(height_mm) else None


def _level_of_sections(mesh: Mesh, height_mm: float, sections: list[Section]) -> Level | Refused:
    if not sections:
        low, high = (
            float(end) for end in (mesh.vertices_mm[:, 2].min(), mesh.vertices_mm[:, 2].max())
        )
        return Refused(
            height_mm,
            fault("measure.level.missed", height_mm=height_mm, low_mm=low, high_mm=high),
        )
    if not all(section.closed for section in sections):
        return Refused(height_mm, fault("measure.level.open", height_mm=height_mm))
    up = np.array([0.0, 0.0, 1.0])
    sections = [section for section in sections if abs(section.area_mm2(up)) > _LEAST_AREA_MM2]
    if not sections:
        return Refused(height_mm, fault("measure.level.touched", height_mm=height_mm))
    sections = [_without_repeats(section) for section in sections]
    rings = [section.points_mm[:, :2] for section in sections]
    depth = np.array(
        [sum(contains_point(o, ring[0]) for o in rings if o is not ring) for ring in rings]
    )
    areas = np.array([section.area_mm2(up) for section in sections])
    if ((areas > 0) != (depth % 2 == 0)).any():
        return Refused(
            height_mm, fault("measure.level.crossed", height_mm=height_mm, loops=len(rings))
        )
    crumbs = _is_crumb(np.abs(areas), rings, depth)
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


def _without_repeats(section: Section) -> Section:
    """The section with one point where a plane through a vertex crosses all its edges."""
    steps = section.points_mm - np.roll(section.points_mm, 1, axis=0)
    fresh = np.linalg.norm(steps, axis=1) > _SAME_POINT_MM
    return replace(
        section,
        points_mm=section.points_mm[fresh],
        crossed=section.crossed[fresh],
        shares=section.shares[fresh],
    )


def _is_crumb(
    areas: Float64[np.ndarray, " l"], rings: list[Points2], depth: Int64[np.ndarray, " l"]
) -> Bool[np.ndarray, " l"]:
    """Which loops are outlines too small to be the limb, or lie in such an outline."""
    crumbs = (depth == 0) & (areas < _CRUMB_SHARE * areas.max())
    for k in np.flatnonzero(crumbs):
        crumbs |= np.array([contains_point(rings[k], ring[0]) for ring in rings]) & (depth > 0)
    return crumbs


def _outlines(level: Level) -> Iterator[Bool[np.ndarray, " n"]]:
    """The points of each outline."""
    return (level.loop == outline for outline in np.flatnonzero(level.depth == 0))


def _outline_length(level: Level, length: Callable[[Points2], SmoothedLength]) -> Measured:
    """Total length round all outlines."""
    value = 0.0
    slopes, along_mm = np.zeros_like(level.points_mm), np.zeros(len(level.points_mm))
    for points in _outlines(level):
        found = length(level.points_mm[points])
        value += found.value_mm
        slopes[points], along_mm[points] = found.slopes, found.along_mm
    return Measured(value, slopes, along_mm)


def _caliper_width(level: Level, axis: int) -> Measured:
    along = np.where(level.outer, level.points_mm[:, axis], np.nan)
    low, high = int(np.nanargmin(along)), int(np.nanargmax(along))
    slopes = np.zeros_like(level.points_mm)
    slopes[low, axis], slopes[high, axis] = -1.0, 1.0
    x, y = np.eye(2)[axis].tolist()
    reaches = (Extremity(x, y, 1.0), Extremity(-x, -y, 1.0))
    return Measured(float(along[high] - along[low]), slopes, reaches=reaches)


def _width_through_axis(level: Level, axis: int) -> Measured | None:
    """Width between the outermost crossings of the outlines with the line through x = y = 0."""
    along, across = level.points_mm[:, axis], level.points_mm[:, 1 - axis]
    astride = np.flatnonzero(level.outer & ((across > 0) != (across[level.after] > 0)))
    if not len(astride):
        return None
    after = level.after[astride]
    rise = across[after] - across[astride]
    share = -across[astride] / rise
    places = along[astride] + share * (along[after] - along[astride])
    if not places.min() < 0 < places.max():
        return None
    slopes = np.zeros_like(level.points_mm)
    for k, sign in ((int(places.argmin()), -1.0), (int(places.argmax()), 1.0)):
        lean = (along[after[k]] - along[astride[k]]) / rise[k]
        for point, part in ((astride[k], 1 - share[k]), (after[k], share[k])):
            slopes[point, axis] += sign * part
            slopes[point, 1 - axis] -= sign * part * lean
    return Measured(float(places.max() - places.min()), slopes)
