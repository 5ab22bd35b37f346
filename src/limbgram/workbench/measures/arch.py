"""Arch: height and place of the apex of a foot's arch, between two places under it.

In      a subject; an item with the two places and the base over which heights count.
Out     the apex's height, or its distance from the first place.
Method  The profile is the lowest surface in the plane through both places that stands upright on
        the base, between them, sampled every millimetre. A parabola by least squares through the
        part of it that lies within a tenth of the highest tells the apex: of a flat top, the
        highest sample alone would tell little of the place. Heights count from the first place.
Fails   MeasureError: a landmark is missing, the surface is open there, or no place between the two
        is higher than both.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.mesh.mesh import unit
from limbgram.workbench.anatomy.directions import Anatomy
from limbgram.workbench.anatomy.kind import Arch
from limbgram.workbench.measures.levels import Sigmas
from limbgram.workbench.measures.propagation import Propagated, Subject

_STEP_MM = 1.0
_APEX_SHARE = 0.1
_LEAST_RISE_MM = 0.5
_LEAST_SAMPLES = 5


def arch_apex(subject: Subject, item: Arch) -> Propagated:
    """The apex of an arch, by surface and landmarks.

    Raises:
        MeasureError: see the head of this file.
    """
    which = 0 if item.what == "height" else 1

    def apex(anatomy: Anatomy) -> Float64[np.ndarray, " 2"]:
        return _apex(_profile(subject.sigmas, anatomy, item)).values

    profile = _profile(subject.sigmas, subject.anatomy, item)
    found = _apex(profile)
    slopes = subject.slopes(apex)
    return Propagated(
        value=float(found.values[which]),
        by_vertex=profile.by_vertex(subject.sigmas, found.by_sample[which]),
        by_place={name: rows[:, which] for name, rows in slopes.items()},
    )


@dataclass(frozen=True, kw_only=True)
class _Profile:
    """The profile of the sole between two places: the lowest surface in an upright plane."""

    names: tuple[str, ...]
    along_mm: Float64[np.ndarray, " k"]
    heights_mm: Float64[np.ndarray, " k"]
    up: Vector3
    corners: Int64[np.ndarray, "k 3"]
    """Vertices of the triangle at each sample."""
    shares: Float64[np.ndarray, "k 3"]

    def by_vertex(
        self, sigmas: Sigmas, by_sample: Float64[np.ndarray, " k"]
    ) -> Float64[np.ndarray, " n"]:
        """Change of a function of the heights for a millimetre of each vertex along its normal."""
        corners = sigmas.mesh.vertices_mm[self.corners]
        looks = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        rises = np.einsum("kcd,kd->kc", sigmas.normals[self.corners], looks)
        rises /= (looks @ self.up)[:, None]
        weights = by_sample[:, None] * self.shares * rises
        return np.bincount(self.corners.ravel(), weights.ravel(), len(sigmas.mesh))


def _profile(sigmas: Sigmas, anatomy: Anatomy, item: Arch) -> _Profile:
    """Sample the profile of the sole between an item's two places."""
    start, end = (anatomy.at(one, item.en) for one in (item.start, item.end))
    up = anatomy.axis(item.base).direction
    way = end - start
    way -= up * (way @ up)
    length = float(np.linalg.norm(way))
    frame = np.stack([way / length, np.cross(up, way / length), up])
    names = (*item.start.of, *item.end.of)
    mesh = sigmas.mesh
    places = (mesh.vertices_mm - start) @ frame.T
    at = np.arange(_STEP_MM, length - _STEP_MM / 2, _STEP_MM)
    left = places[:, 1] > 0
    one, two, three = (left[mesh.faces[:, k]] for k in range(3))
    ids = np.flatnonzero((one | two | three) & ~(one & two & three))
    near = places[mesh.faces[ids]]
    shares, hit = _barycentric_under(near, at)
    heights = np.where(hit, np.einsum("kfc,fc->kf", shares, near[:, :, 2]), np.inf)
    lowest = heights.argmin(1) if len(ids) else np.zeros(len(at), np.int64)
    rows = np.arange(len(at))
    if not len(ids) or not np.isfinite(heights[rows, lowest]).all():
        raise MeasureError("measure.sheet.no_arch", names=names)
    return _Profile(
        names=names,
        along_mm=at,
        heights_mm=heights[rows, lowest],
        up=up,
        corners=mesh.faces[ids[lowest]].astype(np.int64),
        shares=shares[rows, lowest],
    )


def _barycentric_under(
    triangles: Float64[np.ndarray, "f 3 3"], at: Float64[np.ndarray, " k"]
) -> tuple[Float64[np.ndarray, "k f 3"], Bool[np.ndarray, "k f"]]:
    """Barycentric weights of vertical lines in triangles, and whether they hit them."""
    a, b, c = (triangles[:, k, :2] for k in range(3))
    first, second = b - a, c - a
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    safe = np.where(area == 0, 1.0, area)
    x, y = at[:, None] - a[:, 0], -a[:, 1]
    by_b = (x * second[:, 1] - y * second[:, 0]) / safe
    by_c = (first[:, 0] * y - first[:, 1] * x) / safe
    shares = np.stack([1 - by_b - by_c, by_b, by_c], axis=-1)
    return shares, (shares >= -1e-9).all(-1) & (area != 0)


@dataclass(frozen=True)
class _Apex:
    values: Float64[np.ndarray, " 2"]
    """Height of the apex, and its place along the profile."""
    by_sample: Float64[np.ndarray, "2 k"]


def _apex(profile: _Profile) -> _Apex:
    heights, along = profile.heights_mm, profile.along_mm
    inside = len(heights) >= _LEAST_SAMPLES
    at = int(heights.argmax()) if inside else 0
    base = max(0.0, float(max(heights[0], heights[-1]))) if inside else 0.0
    rise = float(heights[at]) - base if inside else 0.0
    if rise < _LEAST_RISE_MM:
        raise MeasureError("measure.sheet.no_arch", names=profile.names)
    low = np.flatnonzero(heights < heights[at] - _APEX_SHARE * rise)
    first = min(int(low[low < at].max(initial=-1)) + 1, max(at - 2, 0))
    last = max(int(low[low > at].min(initial=len(heights))), min(at + 3, len(heights)))
    off = along[first:last] - along[at]
    rows = np.linalg.pinv(np.vander(off, 3, increasing=True))
    flat, slope, bend = rows @ heights[first:last]
    if bend >= 0 or not off[0] <= -slope / (2 * bend) <= off[-1]:
        raise MeasureError("measure.sheet.no_arch", names=profile.names)
    top = -slope / (2 * bend)
    by_sample = np.zeros((2, len(heights)))
    by_sample[0, first:last] = rows[0] + top * rows[1] + top**2 * rows[2]
    by_sample[1, first:last] = slope * rows[2] / (2 * bend**2) - rows[1] / (2 * bend)
    return _Apex(np.array([flat + slope * top + bend * top**2, along[at] + top]), by_sample)
