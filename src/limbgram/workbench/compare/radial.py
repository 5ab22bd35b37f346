"""Radial error: along spokes from the long axis, second shape less first.

The figures of Sanders et al.: MRE, the mean radial error; IQR, the range of the middle half of the
radial errors. Angles run from the front (+Y) towards the patient's right (+X), as in AOP files.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.core.errors import MeasureError
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.compare.frames import brim_height_mm

_GRAZING = 0.3
"""Least cosine between spoke and normal: a spoke along the surface tells nothing of its radius."""
_EDGE = 1e-9
_FEWEST = 100
_SPACING_MM, _SPOKES = 2.0, 120
"""Between rings of spokes, and how many a ring has."""


@dataclass(frozen=True, kw_only=True)
class RadialErrors:
    """Radii of the second less those of the first."""

    heights_mm: Float64[np.ndarray, " h"]
    angles_deg: Float64[np.ndarray, " a"]
    errors_mm: Float64[np.ndarray, "h a"]
    """NaN where a spoke misses a shape, lies beyond a brim, or grazes the surface."""
    mre_mm: float
    """Mean."""
    iqr_mm: float
    """Third less first quartile."""
    known_share: float
    """Of the spokes from the lower of both distal ends to the lower of both brims."""


def radial_errors(first_in_limb: Mesh, second_in_limb: Mesh, brim_mm: float) -> RadialErrors:
    """Compare two shapes along the spokes of one frame.

    Raises:
        MeasureError: hardly a spoke meets both shapes.
    """
    meshes = (first_in_limb, second_in_limb)
    low = min(float(mesh.vertices_mm[:, 2].min()) for mesh in meshes)
    high = min(brim_height_mm(mesh) for mesh in meshes) - brim_mm
    rings = max(math.floor((high - low) / _SPACING_MM), 0)
    heights = low + (np.arange(rings) + 0.5) * _SPACING_MM
    one, two = (spoke_radii(mesh, heights, _SPOKES) for mesh in meshes)
    clear = (one.facing > _GRAZING) & (two.facing > _GRAZING)
    errors = np.where(clear, two.radii_mm - one.radii_mm, np.nan)
    known = errors[np.isfinite(errors)]
    if len(known) < _FEWEST:
        raise MeasureError("compare.radial.few_spokes", spokes=len(known))
    low_quartile, high_quartile = np.quantile(known, [0.25, 0.75])
    return RadialErrors(
        heights_mm=heights,
        angles_deg=360.0 * np.arange(_SPOKES) / _SPOKES,
        errors_mm=errors,
        mre_mm=float(known.mean()),
        iqr_mm=float(high_quartile - low_quartile),
        known_share=len(known) / errors.size,
    )


@dataclass(frozen=True, kw_only=True)
class Spokes:
    """Radii at which spokes leave a shape, and how squarely."""

    radii_mm: Float64[np.ndarray, "h a"]
    """Distance of the outermost crossing from the axis; NaN without any."""
    facing: Float64[np.ndarray, "h a"]
    """Cosine between spoke and normal there, positive outwards; 0 without any."""


def spoke_radii(mesh_in_limb: Mesh, heights_mm: Float64[np.ndarray, " h"], spokes: int) -> Spokes:
    """Cross rings of spokes at rising heights with a shape, exactly; the first points forwards."""
    corners = mesh_in_limb.vertices_mm[mesh_in_limb.faces]
    near = _candidates(corners, heights_mm, spokes)
    face, ring, spoke = near.face, near.ring, near.spoke
    turns = 2 * np.pi * np.arange(spokes) / spokes
    ways = np.column_stack([np.sin(turns), np.cos(turns)])
    a, way = corners[face, 0], np.column_stack([ways[spoke], np.zeros(len(spoke))])
    one, two = corners[face, 1] - a, corners[face, 2] - a
    across = np.cross(way, two)
    size = np.einsum("nc,nc->n", one, across)
    safe = np.where(size == 0, 1.0, size)
    start = -a
    start[:, 2] += heights_mm[ring]
    u = np.einsum("nc,nc->n", start, across) / safe
    lifted = np.cross(start, one)
    v = np.einsum("nc,nc->n", way, lifted) / safe
    radius = np.einsum("nc,nc->n", two, lifted) / safe
    hit = (size != 0) & (u >= -_EDGE) & (v >= -_EDGE) & (u + v <= 1 + _EDGE) & (radius > 0)
    # Outermost crossing of each spoke: the last one in order of its radius.
    hits = np.flatnonzero(hit)
    hits = hits[np.argsort(radius[hits], kind="stable")]
    radii = np.full((len(heights_mm), spokes), np.nan)
    facing = np.zeros(radii.shape)
    radii[ring[hits], spoke[hits]] = radius[hits]
    normal = np.cross(one[hits], two[hits])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    facing[ring[hits], spoke[hits]] = np.einsum("nc,nc->n", normal, way[hits])
    return Spokes(radii_mm=radii, facing=facing)


@dataclass(frozen=True)
class _Span:
    """A range of indices for each face."""

    first: Int64[np.ndarray, " f"]
    count: Int64[np.ndarray, " f"]


@dataclass(frozen=True)
class _Candidates:
    """Triples of face, ring and spoke that may meet."""

    face: Int64[np.ndarray, " n"]
    ring: Int64[np.ndarray, " n"]
    spoke: Int64[np.ndarray, " n"]


def _candidates(
    corners: Float64[np.ndarray, "f 3 3"], heights_mm: Float64[np.ndarray, " h"], spokes: int
) -> _Candidates:
    low = np.searchsorted(heights_mm, corners[:, :, 2].min(1) - _EDGE)
    rings = _Span(low, np.searchsorted(heights_mm, corners[:, :, 2].max(1) + _EDGE) - low)
    turns = np.arctan2(corners[:, :, 0], corners[:, :, 1]) / (2 * np.pi) * spokes
    apart = turns - turns[:, :1]
    apart -= spokes * np.round(apart / spokes)
    start = np.ceil(turns[:, 0] + apart.min(1) - _EDGE * spokes).astype(np.int64)
    count = np.floor(turns[:, 0] + apart.max(1) + _EDGE * spokes).astype(np.int64) - start + 1
    round_axis = np.ptp(apart, axis=1) >= spokes / 3
    turned = _Span(np.where(round_axis, 0, start), np.where(round_axis, spokes, count))
    pairs = rings.count * np.maximum(turned.count, 0)
    face = np.repeat(np.arange(len(corners)), pairs)
    within = np.arange(len(face)) - np.repeat(np.cumsum(pairs) - pairs, pairs)
    return _Candidates(
        face,
        rings.first[face] + within // np.maximum(turned.count[face], 1),
        (turned.first[face] + within % np.maximum(turned.count[face], 1)) % spokes,
    )
