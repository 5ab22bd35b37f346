"""Surface lines: axes fitted to a part of the measured surface that landmarks choose.

In      a surface, and a part of it: a frame, its extent, and the distance over which it fades.
Out     the slope of a line in that frame, its middle, and its derivatives by each vertex.
Method  A bisecting line goes by least squares through the centroids of the part's sections. The
        moments of the volume give it; by the theorem of Gauss, with primitives in the direction in
        which the line leans, they are integrals over the skin, for the ends of the part lie along
        that direction and add nothing. A line under a part is that of the plane that fits the skin
        that faces down. Parts fade over a quarter of their length, so that a landmark that lies
        elsewhere by a millimetre chooses nearly the same part, and no triangle jumps in or out.
        Triangles are integrated by six places each, exactly to the fourth degree (D. Dunavant,
        International Journal for Numerical Methods in Engineering 21, 1985), and large ones in
        pieces, for over them the part fades.
Fails   MeasureError: there is no surface in the part, or it is open there.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from jaxtyping import Bool, Float64, Int32

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_half_edges

_FADE_SHARE = 0.25
"""Share of a part's length over which it fades at both ends."""
_LEAST_CONTENT = 1e-4
"""Least volume or skin that determines a line, as a share of the length's cube or square."""
_SECANT_ROUNDS, _CONVERGED = 30, 1e-9
_FIRST_RAD, _STEP_RAD, _MOST_RAD = 1e-3, 1e-6, 0.8
_LEAST_CHANGE = 0.15
"""Of the slope, for a radian by which a part is turned: of a ball, which every line through its
middle halves, it does not change at all."""
_A, _B = 0.445948490915965, 0.091576213509771
_NODES = np.array(
    [
        [1 - 2 * _A, _A, _A],
        [_A, 1 - 2 * _A, _A],
        [_A, _A, 1 - 2 * _A],
        [1 - 2 * _B, _B, _B],
        [_B, 1 - 2 * _B, _B],
        [_B, _B, 1 - 2 * _B],
    ]
)
"""Barycentric coordinates of the quadrature nodes."""
_NODE_WEIGHTS = np.repeat([0.223381589678011, 0.109951743655322], 3)
_MOST_QUARTERINGS = 3
"""Times that a triangle is quartered: a part is hardly told by one whose edges are longer."""


@dataclass(frozen=True, kw_only=True)
class LineSurface:
    """A surface to which lines are fitted, with a memory of fitted lines."""

    mesh: Mesh

    @cached_property
    def open_edges_mm(self) -> Points3:
        """Midpoints of its open edges."""
        return self.mesh.vertices_mm[boundary_half_edges(self.mesh.faces)].mean(1)

    @cached_property
    def first_lines(self) -> dict[str, tuple[bytes, "SurfaceLine"]]:
        """The first line found under each name, with its part's key.

        Later queries are for the same part while landmarks are moved that do not choose it.
        """
        return {}

    def line_of(
        self, line: Callable[["LineSurface", "SurfacePart"], "SurfaceLine"], part: "SurfacePart"
    ) -> "SurfaceLine":
        """The line of a part, fitted or remembered.

        Raises:
            MeasureError: there is none.
        """
        known = self.first_lines.get(part.name)
        if known is not None and known[0] == part.key:
            return known[1]
        found = line(self, part)
        self.first_lines.setdefault(part.name, (part.key, found))
        return found


@dataclass(frozen=True, kw_only=True)
class SurfacePart:
    """A part of a surface to which a line is fitted, about its middle."""

    name: str
    """Name of the line that is fitted to it."""
    middle_mm: Vector3
    along: Vector3
    towards: Vector3
    """Direction in which the line may lean; square to along."""
    half_mm: float
    """Length from the middle to each end."""
    fade_direction: Vector3
    full_at_mm: float
    zero_at_mm: float
    """Along the fade direction from the middle: where weights are still 1, and where they are 0."""
    skew: float = 0.0
    """Sideways slope of its centre line, per millimetre along."""
    reach_mm: float | None = None
    """Extent to both sides of the centre line; None for all."""

    @property
    def key(self) -> bytes:
        """A key that is equal for equal parts."""
        numbers = (self.half_mm, self.full_at_mm, self.zero_at_mm, self.skew, self.reach_mm or -1.0)
        vectors = (self.middle_mm, self.along, self.towards, self.fade_direction)
        return np.concatenate([*vectors, numbers]).tobytes()

    @property
    def aside(self) -> Vector3:
        return np.cross(self.along, self.towards)

    def turned(self, rad: float) -> "SurfacePart":
        """The part turned about its middle, so that `along` comes nearer to `towards`."""
        cosine, sine = np.cos(rad), np.sin(rad)
        return replace(
            self,
            along=cosine * self.along + sine * self.towards,
            towards=cosine * self.towards - sine * self.along,
        )

    def faces_within(self, mesh: Mesh) -> Bool[np.ndarray, " f"]:
        """Triangles that may lie partly within the part."""
        off = mesh.vertices_mm - self.middle_mm
        along = off @ self.along
        sign = np.sign(self.zero_at_mm - self.full_at_mm)
        gone = sign * (off @ self.fade_direction - self.zero_at_mm) >= 0
        # Triangles none of whose corners lies on the part's side of one of its ends.
        out = [along >= self.half_mm, along <= -self.half_mm, gone]
        if self.reach_mm is not None:
            aside = off @ self.aside - self.skew * along
            out += [aside >= self.reach_mm, aside <= -self.reach_mm]
        a, b, c = mesh.faces.T
        found = np.ones(len(mesh.faces), np.bool_)
        for one in out:
            found &= ~(one[a] & one[b] & one[c])
        return found

    def weights(self, points_mm: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, " k"]:
        """Weight of each place in the part, 0 to 1."""
        off = points_mm - self.middle_mm
        along = off @ self.along
        found = _window(along, self.half_mm)
        gone = (self.zero_at_mm - off @ self.fade_direction) / (self.zero_at_mm - self.full_at_mm)
        found *= smoothstep(gone)
        if self.reach_mm is not None:
            found *= _window(off @ self.aside - self.skew * along, self.reach_mm, soft=1.0)
        return found


@dataclass(frozen=True, kw_only=True)
class SurfaceLine:
    """A line along a part, fitted to the surface."""

    slope: float
    """Slope in the direction in which it may lean, per millimetre along."""
    middle_mm: Vector3
    faces: Int32[np.ndarray, "f 3"]
    places: Float64[np.ndarray, "p 3"]
    """Quadrature nodes on each triangle, in barycentric coordinates."""
    slope_gradients: Float64[np.ndarray, "f p 3"]
    """Change of the slope for a millimetre of each place in each direction."""

    def by_vertex(self, normals: Points3) -> Float64[np.ndarray, " n"]:
        """Change of the slope for a millimetre of each vertex along its normal."""
        corners = np.einsum("kc,fkd->fcd", self.places, self.slope_gradients)
        along = np.einsum("fcd,fcd->fc", corners, normals[self.faces])
        return np.bincount(self.faces.ravel(), along.ravel(), len(normals))


def bisecting_line(skin: LineSurface, part: SurfacePart) -> SurfaceLine:
    """The line through the centroids of a part's sections.

    Raises:
        MeasureError: there is none, or the surface is open in it.
    """
    nodes = _QuadraturePoints.of(skin, part)
    x, t = nodes.leaning_mm, nodes.along_mm
    flux = nodes.weights * (nodes.areas_mm2 @ part.towards)
    volume = float(flux @ x)
    if not volume > _LEAST_CONTENT * part.half_mm**3:
        raise MeasureError("anatomy.no_part", name=part.name)
    middle_x, middle_t = float(flux @ (x * x / 2)) / volume, float(flux @ (x * t)) / volume
    spread = float(flux @ (x * t * t)) / volume - middle_t**2
    slope = (float(flux @ (x * x * t / 2)) / volume - middle_x * middle_t) / spread
    apart = (t - middle_t) * (x - middle_x - slope * (t - middle_t)) / (spread * volume)
    return nodes.line(part, slope, (middle_t, middle_x), apart)


def bisecting_line_across(skin: LineSurface, part: SurfacePart) -> SurfaceLine:
    """The line through the centroids of a part's sections square to that line itself.

    So it depends on the part alone, not on the frame in which the part was chosen.

    Raises:
        MeasureError: there is none, the part is too round to have one, or the surface is open.
    """
    found = bisecting_line(skin, part)
    before_rad, before, by_rad = 0.0, found.slope, -1.0
    rad = found.slope if abs(found.slope) > _FIRST_RAD else _FIRST_RAD
    for _ in range(_SECANT_ROUNDS):  # the secant method
        found = bisecting_line(skin, part.turned(rad))
        if abs(rad - before_rad) > _STEP_RAD:
            by_rad = (found.slope - before) / (rad - before_rad)
        if not by_rad < -_LEAST_CHANGE or abs(rad) > _MOST_RAD:
            raise MeasureError("anatomy.round_part", name=part.name)
        if abs(found.slope) < _CONVERGED:
            break
        before_rad, before = rad, found.slope
        rad -= found.slope / by_rad
    slope = float(np.tan(rad))
    return replace(
        found, slope=slope, slope_gradients=found.slope_gradients * (-(1 + slope**2) / by_rad)
    )


def line_under(skin: LineSurface, part: SurfacePart) -> SurfaceLine:
    """The line of the plane fitted to the skin of a part that faces away from `towards`.

    Raises:
        MeasureError: there is none, or the surface is open in it.
    """
    nodes = _QuadraturePoints.of(skin, part)
    faces_down = np.maximum(-(nodes.areas_mm2 @ part.towards), 0.0) * nodes.weights
    if not faces_down.sum() > _LEAST_CONTENT * part.half_mm**2:
        raise MeasureError("anatomy.no_part", name=part.name)
    columns = np.column_stack([np.ones_like(nodes.along_mm), nodes.along_mm, nodes.aside_mm])
    inverse = np.linalg.inv(columns.T @ (columns * faces_down[:, None]))
    height, slope, _ = inverse @ (columns.T @ (faces_down * nodes.leaning_mm))
    # Skin that goes outwards goes down by more the more it leans, and there is less of it.
    lowered = np.where(faces_down > 0, -nodes.weights, 0.0) * (columns @ inverse[1])
    return nodes.line(part, float(slope), (0.0, float(height)), lowered, already_weighted=True)


@dataclass(frozen=True, kw_only=True)
class _QuadraturePoints:
    """Quadrature points on the triangles within a part."""

    faces: Int32[np.ndarray, "f 3"]
    places: Float64[np.ndarray, "p 3"]
    along_mm: Float64[np.ndarray, " k"]
    leaning_mm: Float64[np.ndarray, " k"]
    aside_mm: Float64[np.ndarray, " k"]
    areas_mm2: Float64[np.ndarray, "k 3"]
    """Area vectors, outwards."""
    weights: Float64[np.ndarray, " k"]

    @classmethod
    def of(cls, skin: LineSurface, part: SurfacePart) -> "_QuadraturePoints":
        open_here = part.weights(skin.open_edges_mm)
        if open_here.max(initial=0.0) > 0:
            at = tuple(skin.open_edges_mm[int(open_here.argmax())].tolist())
            raise MeasureError("anatomy.open_part", name=part.name, point_mm=at)
        mesh = skin.mesh
        faces = mesh.faces[part.faces_within(mesh)]
        corners = mesh.vertices_mm[faces]
        places, shares = _quadrature(_quartering_count(corners, part.half_mm))
        off = (places @ (corners - part.middle_mm)).reshape(-1, 3)
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        return cls(
            faces=faces,
            places=places,
            along_mm=off @ part.along,
            leaning_mm=off @ part.towards,
            aside_mm=off @ part.aside,
            areas_mm2=(areas[:, None] * shares[:, None]).reshape(-1, 3),
            weights=part.weights(off + part.middle_mm),
        )

    def line(
        self,
        part: SurfacePart,
        slope: float,
        at_mm: tuple[float, float],
        by_area: Float64[np.ndarray, " k"],
        *,
        already_weighted: bool = False,
    ) -> SurfaceLine:
        """The line with its derivatives at the quadrature points.

        Args:
            at_mm: The line's middle: along, and in the direction in which it leans.
            by_area: Change of the slope for a cubic millimetre added at each point.
            already_weighted: It holds the weights already.
        """
        change = by_area if already_weighted else by_area * self.weights
        along, leaning = at_mm
        return SurfaceLine(
            slope=slope,
            middle_mm=part.middle_mm + along * part.along + leaning * part.towards,
            faces=self.faces,
            places=self.places,
            slope_gradients=(change[:, None] * self.areas_mm2).reshape(-1, len(self.places), 3),
        )


def _quartering_count(corners_mm: Float64[np.ndarray, "f 3 3"], half_mm: float) -> int:
    """How often triangles are quartered, so that edges are no longer than the part's fading."""
    if not len(corners_mm):
        return 0
    edges_mm = np.linalg.norm(corners_mm - np.roll(corners_mm, 1, axis=1), axis=2)
    times = np.log2(float(np.median(edges_mm.max(1))) / (2 * _FADE_SHARE * half_mm))
    return int(np.clip(np.ceil(times), 0, _MOST_QUARTERINGS))


@lru_cache
def _quadrature(
    splits: int,
) -> tuple[Float64[np.ndarray, "p 3"], Float64[np.ndarray, " p"]]:
    """Quadrature nodes on a triangle, and their weights."""
    pieces = np.eye(3)[None]
    for _ in range(splits):
        middles = (pieces + np.roll(pieces, -1, axis=1)) / 2
        at_corners = [
            np.stack([pieces[:, k], middles[:, k], middles[:, k - 1]], 1) for k in range(3)
        ]
        pieces = np.concatenate([*at_corners, middles])
    places = np.einsum("kc,pcd->pkd", _NODES, pieces).reshape(-1, 3)
    return places, np.tile(_NODE_WEIGHTS, len(pieces)) / len(pieces)


def _window(
    off_mm: Float64[np.ndarray, " k"], half_mm: float, soft: float = 2 * _FADE_SHARE
) -> Float64[np.ndarray, " k"]:
    """A window: 1 in the middle, 0 at both ends; it falls over a share `soft` of each half."""
    return smoothstep((half_mm - np.abs(off_mm)) / (soft * half_mm))


def smoothstep(share: Float64[np.ndarray, " k"]) -> Float64[np.ndarray, " k"]:
    """The smoothstep from 0 at 0 to 1 at 1, with zero slope at both ends."""
    x = np.clip(share, 0, 1)
    return x * x * (3 - 2 * x)
