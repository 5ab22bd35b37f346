"""Surface lines: directions that the measured surface tells, where landmarks only choose the part.

In      a surface, and a part of it: a frame, how far the part reaches, and over which way it fades.
Out     how far a line leans in that frame, where it runs, and what each vertex has in it.
Method  A line that halves a part goes by least squares through the middles of its sections. The
        moments of the volume tell it; by the theorem of Gauss, with primitives in the direction in
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

_SOFT = 0.25
"""Of a part's length: over which it fades in and out at both ends."""
_LEAST_SHARE = 1e-4
"""Of the cube of a part's length, or of the square: less volume, or less skin, tells no line."""
_ROUNDS, _CONVERGED = 30, 1e-9
_FIRST_RAD, _STEP_RAD, _MOST_RAD = 1e-3, 1e-6, 0.8
_LEAST_CHANGE = 0.15
"""Of the slope, for a radian by which a part is turned: of a ball, which every line through its
middle halves, it does not change at all."""
_A, _B = 0.445948490915965, 0.091576213509771
_PLACES = np.array(
    [
        [1 - 2 * _A, _A, _A],
        [_A, 1 - 2 * _A, _A],
        [_A, _A, 1 - 2 * _A],
        [1 - 2 * _B, _B, _B],
        [_B, 1 - 2 * _B, _B],
        [_B, _B, 1 - 2 * _B],
    ]
)
"""Barycentric coordinates."""
_SHARES = np.repeat([0.223381589678011, 0.109951743655322], 3)
_MOST_SPLIT = 3
"""Times that a triangle is quartered: a part is hardly told by one whose edges are longer."""


@dataclass(frozen=True, kw_only=True)
class Skin:
    """A surface that is asked for lines again and again."""

    mesh: Mesh

    @cached_property
    def border_mm(self) -> Points3:
        """Middles of its open edges."""
        return self.mesh.vertices_mm[boundary_half_edges(self.mesh.faces)].mean(1)

    @cached_property
    def first(self) -> dict[str, tuple[bytes, "Leaning"]]:
        """What was told of each line when it was first asked for, and of which part: the next ask
        for the same part while landmarks are moved that do not choose it."""
        return {}

    def tell(self, line: Callable[["Skin", "Part"], "Leaning"], part: "Part") -> "Leaning":
        """A line of a part.

        Raises:
            MeasureError: there is none.
        """
        known = self.first.get(part.name)
        if known is not None and known[0] == part.key:
            return known[1]
        found = line(self, part)
        self.first.setdefault(part.name, (part.key, found))
        return found


@dataclass(frozen=True, kw_only=True)
class Part:
    """A part of a surface, about its middle."""

    name: str
    """Of the line that it tells."""
    middle_mm: Vector3
    along: Vector3
    towards: Vector3
    """In which the line may lean; square to along."""
    half_mm: float
    """From the middle to each end, along."""
    fades_along: Vector3
    whole_mm: float
    none_mm: float
    """Along that direction from the middle: the part is whole up to there, and gone there."""
    skew: float = 0.0
    """How far its middle line goes aside for a millimetre along."""
    reach_mm: float | None = None
    """To both sides of the middle line; None for all."""

    @property
    def key(self) -> bytes:
        """Equal for equal parts."""
        numbers = (self.half_mm, self.whole_mm, self.none_mm, self.skew, self.reach_mm or -1.0)
        vectors = (self.middle_mm, self.along, self.towards, self.fades_along)
        return np.concatenate([*vectors, numbers]).tobytes()

    @property
    def aside(self) -> Vector3:
        return np.cross(self.along, self.towards)

    def turned(self, rad: float) -> "Part":
        """The part turned about its middle, so that `along` comes nearer to `towards`."""
        cosine, sine = np.cos(rad), np.sin(rad)
        return replace(
            self,
            along=cosine * self.along + sine * self.towards,
            towards=cosine * self.towards - sine * self.along,
        )

    def reached_by(self, mesh: Mesh) -> Bool[np.ndarray, " f"]:
        """Triangles of which some of it may lie in the part."""
        off = mesh.vertices_mm - self.middle_mm
        along = off @ self.along
        sign = np.sign(self.none_mm - self.whole_mm)
        gone = sign * (off @ self.fades_along - self.none_mm) >= 0
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
        """How much each place counts, 0 to 1."""
        off = points_mm - self.middle_mm
        along = off @ self.along
        found = _window(along, self.half_mm)
        gone = (self.none_mm - off @ self.fades_along) / (self.none_mm - self.whole_mm)
        found *= smoothstep(gone)
        if self.reach_mm is not None:
            found *= _window(off @ self.aside - self.skew * along, self.reach_mm, soft=1.0)
        return found


@dataclass(frozen=True, kw_only=True)
class Leaning:
    """A line along a part, as the surface tells it."""

    slope: float
    """In the direction in which it may lean, for a millimetre along."""
    middle_mm: Vector3
    faces: Int32[np.ndarray, "f 3"]
    places: Float64[np.ndarray, "p 3"]
    """On each triangle, in barycentric coordinates."""
    pulls: Float64[np.ndarray, "f p 3"]
    """Change of the slope for a millimetre of each place in each direction."""

    def by_vertex(self, normals: Points3) -> Float64[np.ndarray, " n"]:
        """Change of the slope for a millimetre of each vertex along its normal."""
        corners = np.einsum("kc,fkd->fcd", self.places, self.pulls)
        along = np.einsum("fcd,fcd->fc", corners, normals[self.faces])
        return np.bincount(self.faces.ravel(), along.ravel(), len(normals))


def halved(skin: Skin, part: Part) -> Leaning:
    """The line that halves a part of what the surface encloses.

    Raises:
        MeasureError: there is none, or the surface is open in it.
    """
    skins = _Nodes.of(skin, part)
    x, t = skins.leaning_mm, skins.along_mm
    flux = skins.weights * (skins.areas_mm2 @ part.towards)
    volume = float(flux @ x)
    if not volume > _LEAST_SHARE * part.half_mm**3:
        raise MeasureError("anatomy.no_part", name=part.name)
    middle_x, middle_t = float(flux @ (x * x / 2)) / volume, float(flux @ (x * t)) / volume
    spread = float(flux @ (x * t * t)) / volume - middle_t**2
    slope = (float(flux @ (x * x * t / 2)) / volume - middle_x * middle_t) / spread
    apart = (t - middle_t) * (x - middle_x - slope * (t - middle_t)) / (spread * volume)
    return skins.leaning(part, slope, (middle_t, middle_x), apart)


def halved_across(skin: Skin, part: Part) -> Leaning:
    """The line that halves a part whose sections lie square to that line itself.

    So it goes with the part, however the frame lies that it was chosen in.

    Raises:
        MeasureError: there is none, the part is too round to have one, or the surface is open.
    """
    found = halved(skin, part)
    before_rad, before, by_rad = 0.0, found.slope, -1.0
    rad = found.slope if abs(found.slope) > _FIRST_RAD else _FIRST_RAD
    for _ in range(_ROUNDS):  # the secant method
        found = halved(skin, part.turned(rad))
        if abs(rad - before_rad) > _STEP_RAD:
            by_rad = (found.slope - before) / (rad - before_rad)
        if not by_rad < -_LEAST_CHANGE or abs(rad) > _MOST_RAD:
            raise MeasureError("anatomy.round_part", name=part.name)
        if abs(found.slope) < _CONVERGED:
            break
        before_rad, before = rad, found.slope
        rad -= found.slope / by_rad
    slope = float(np.tan(rad))
    return replace(found, slope=slope, pulls=found.pulls * (-(1 + slope**2) / by_rad))


def under(skin: Skin, part: Part) -> Leaning:
    """The line of the plane that fits the skin of a part that faces away from `towards`.

    Raises:
        MeasureError: there is none, or the surface is open in it.
    """
    skins = _Nodes.of(skin, part)
    faces_down = np.maximum(-(skins.areas_mm2 @ part.towards), 0.0) * skins.weights
    if not faces_down.sum() > _LEAST_SHARE * part.half_mm**2:
        raise MeasureError("anatomy.no_part", name=part.name)
    columns = np.column_stack([np.ones_like(skins.along_mm), skins.along_mm, skins.aside_mm])
    inverse = np.linalg.inv(columns.T @ (columns * faces_down[:, None]))
    height, slope, _ = inverse @ (columns.T @ (faces_down * skins.leaning_mm))
    # Skin that goes outwards goes down by more the more it leans, and there is less of it.
    lowered = np.where(faces_down > 0, -skins.weights, 0.0) * (columns @ inverse[1])
    return skins.leaning(part, float(slope), (0.0, float(height)), lowered, weighted=True)


@dataclass(frozen=True, kw_only=True)
class _Nodes:
    """Places on the triangles that reach into a part."""

    faces: Int32[np.ndarray, "f 3"]
    places: Float64[np.ndarray, "p 3"]
    along_mm: Float64[np.ndarray, " k"]
    leaning_mm: Float64[np.ndarray, " k"]
    aside_mm: Float64[np.ndarray, " k"]
    areas_mm2: Float64[np.ndarray, "k 3"]
    """Area vectors, outwards."""
    weights: Float64[np.ndarray, " k"]

    @classmethod
    def of(cls, skin: Skin, part: Part) -> "_Nodes":
        open_here = part.weights(skin.border_mm)
        if open_here.max(initial=0.0) > 0:
            at = tuple(skin.border_mm[int(open_here.argmax())].tolist())
            raise MeasureError("anatomy.open_part", name=part.name, point_mm=at)
        mesh = skin.mesh
        faces = mesh.faces[part.reached_by(mesh)]
        corners = mesh.vertices_mm[faces]
        places, shares = _places(_splits(corners, part.half_mm))
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

    def leaning(
        self,
        part: Part,
        slope: float,
        at_mm: tuple[float, float],
        by_area: Float64[np.ndarray, " k"],
        *,
        weighted: bool = False,
    ) -> Leaning:
        """With what each corner has in it.

        Args:
            at_mm: The line's middle: along, and in the direction in which it leans.
            by_area: Change of the slope for a cubic millimetre that is added at each place.
            weighted: It holds the weights already.
        """
        change = by_area if weighted else by_area * self.weights
        along, leaning = at_mm
        return Leaning(
            slope=slope,
            middle_mm=part.middle_mm + along * part.along + leaning * part.towards,
            faces=self.faces,
            places=self.places,
            pulls=(change[:, None] * self.areas_mm2).reshape(-1, len(self.places), 3),
        )


def _splits(corners_mm: Float64[np.ndarray, "f 3 3"], half_mm: float) -> int:
    """How often triangles are quartered, so that their edges are no longer than a part fades."""
    if not len(corners_mm):
        return 0
    edges_mm = np.linalg.norm(corners_mm - np.roll(corners_mm, 1, axis=1), axis=2)
    times = np.log2(float(np.median(edges_mm.max(1))) / (2 * _SOFT * half_mm))
    return int(np.clip(np.ceil(times), 0, _MOST_SPLIT))


@lru_cache
def _places(
    splits: int,
) -> tuple[Float64[np.ndarray, "p 3"], Float64[np.ndarray, " p"]]:
    """Places on a triangle and the share of its area that each stands for."""
    pieces = np.eye(3)[None]
    for _ in range(splits):
        middles = (pieces + np.roll(pieces, -1, axis=1)) / 2
        at_corners = [
            np.stack([pieces[:, k], middles[:, k], middles[:, k - 1]], 1) for k in range(3)
        ]
        pieces = np.concatenate([*at_corners, middles])
    places = np.einsum("kc,pcd->pkd", _PLACES, pieces).reshape(-1, 3)
    return places, np.tile(_SHARES, len(pieces)) / len(pieces)


def _window(
    off_mm: Float64[np.ndarray, " k"], half_mm: float, soft: float = 2 * _SOFT
) -> Float64[np.ndarray, " k"]:
    """1 in the middle, 0 at both ends; soft is the share of each half over which it falls."""
    return smoothstep((half_mm - np.abs(off_mm)) / (soft * half_mm))


def smoothstep(share: Float64[np.ndarray, " k"]) -> Float64[np.ndarray, " k"]:
    """From 0 at 0 to 1 at 1, level at both ends."""
    x = np.clip(share, 0, 1)
    return x * x * (3 - 2 * x)
