"""The surface: what of it was measured, where it is open, how sure each vertex is.

Areas are shared out to vertices, a third of each triangle to each corner, so that a share is a
share of the surface and not of a number of vertices.
"""

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float64
from scipy.special import erf

from limbgram.geometry.camera import View
from limbgram.measuring.visibility import incidence_cosines
from limbgram.report.accuracy.evidence import Evidence, Json
from limbgram.report.accuracy.figures.around import around_figures
from limbgram.surface.mesh import Mesh, Part
from limbgram.surface.topology import boundary_half_edges

_STEEPEST_DEG = 65.0
"""A photo that looks more closely along the surface than this hardly measures it."""
_RAY_VERTICES = 20_000
_BINS = 50
_SHOWN_QUANTILE = 0.995
_TELL_OPENINGS = 5
_BISECTIONS = 50
UNNAMED = "shared by all vertices"
"""What a shared source is called where the mesh does not tell."""


def surface_figures(evidence: Evidence) -> Json:
    """Completeness, openings, photos per place, and sigma."""
    mesh = evidence.mesh
    areas = mesh.vertex_areas_mm2()
    measured = measured_vertices(mesh)
    repairs = mesh.repairs
    return {
        "vertices": len(mesh),
        "faces": len(mesh.faces),
        "size": np.ptp(mesh.vertices_mm, axis=0).tolist(),
        "height_from": float(mesh.vertices_mm[:, 2].min()),
        "area": float(areas.sum()),
        "measured_share": _share(measured, areas),
        "filled_share": _share(~measured, areas),
        "left_out_share": 0.0 if repairs is None else repairs.island_share,
        "other_parts": [] if repairs is None else [_part(one) for one in repairs.others],
        "part_given": repairs is not None and repairs.part_given,
        "holes_filled": 0 if repairs is None else repairs.holes_filled,
        "openings": openings(mesh),
        "around": around_figures(mesh, evidence.metric.floor_z_mm),
        "photos_per_place": _photos_per_place(mesh, evidence.metric.scene.views),
        "sigma": _sigma(mesh, areas),
    }


def _part(part: Part) -> Json:
    """A sizeable body beside this surface."""
    return {"number": part.number, "relation": part.relation, "area": part.area_mm2}


def measured_vertices(mesh: Mesh) -> np.ndarray:
    """True where photos measured the surface."""
    return np.ones(len(mesh), bool) if mesh.filled is None else ~mesh.filled


def openings(mesh: Mesh) -> list[Json]:
    """The largest openings: length of the rim, and where its middle is."""
    border = boundary_half_edges(mesh.faces)
    if not np.array_equal(np.sort(border[:, 0]), np.unique(border[:, 1])):
        return []  # rims that touch or branch: no loops to tell
    following = np.zeros(len(mesh), np.int64)
    following[border[:, 0]] = border[:, 1]
    found: list[Json] = []
    left = set(border[:, 0].tolist())
    while left:
        loop = [left.pop()]
        while (vertex := int(following[loop[-1]])) in left:
            left.remove(vertex)
            loop.append(vertex)
        rim = mesh.vertices_mm[loop]
        sides = np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1)
        found.append({"rim": float(sides.sum()), "middle": rim.mean(0).tolist()})
    return sorted(found, key=lambda one: -one["rim"])[:_TELL_OPENINGS]


def _share(chosen: np.ndarray, areas: Float64[np.ndarray, " n"]) -> float:
    total = float(areas.sum())
    return float(areas[chosen].sum()) / total if total > 0 else float("nan")


def _photos_per_place(mesh: Mesh, views: Sequence[View]) -> Json:
    """Photos that see a place under `_STEEPEST_DEG` or squarer; some vertices stand for all."""
    step = max(1, len(mesh) // _RAY_VERTICES)
    number = (incidence_cosines(mesh, views, _STEEPEST_DEG, step) > 0).sum(1)
    return {
        "median": float(np.median(number)),
        "below_3_share": float(np.mean(number < 3)),
        "places": np.bincount(number).tolist(),
    }


def _sigma(mesh: Mesh, areas: Float64[np.ndarray, " n"]) -> Json | None:
    """Along the normal, over the measured surface; None where the mesh carries no sigmas."""
    if mesh.sigma_mm is None:
        return None
    known = np.isfinite(mesh.sigma_mm) & measured_vertices(mesh) & (areas > 0)
    if not known.any():
        return None
    sigmas, weights = mesh.sigma_mm[known].astype(np.float64), areas[known]
    weights = weights / weights.sum()
    shares = _shares(mesh, known, weights)
    shared = math.hypot(*shares.values())
    total = float(np.sqrt(weights @ sigmas**2))
    reach = float(np.quantile(sigmas, _SHOWN_QUANTILE))
    edges = np.linspace(0.0, reach, _BINS + 1)
    return {
        "rms_mm": total,
        "median_mm": _weighted_quantile(sigmas, weights, 0.5),
        "p95_mm": _weighted_quantile(sigmas, weights, 0.95),
        "shared_rms_mm": shared,
        "shares_mm": shares,
        "own_rms_mm": float(np.sqrt(max(total**2 - shared**2, 0.0))),
        "correlation_mm": float("nan") if mesh.correlation_mm is None else mesh.correlation_mm,
        "expected_error_p95_mm": expected_p95(sigmas, weights),
        "edges_mm": edges.tolist(),
        "area_share": np.histogram(np.minimum(sigmas, reach), edges, weights=weights)[0].tolist(),
    }


def _shares(mesh: Mesh, known: Bool[np.ndarray, " n"], weights: Float64[np.ndarray, " k"]) -> Json:
    """RMS over the area of what each shared source does to the surface, by the source's name."""
    if mesh.shared_mm is None:
        return {}
    energies = weights @ mesh.shared_mm[known].astype(np.float64) ** 2
    names = mesh.shared_sources or len(energies) * (UNNAMED,)
    return {
        name: float(np.sqrt(sum(e for e, of in zip(energies, names, strict=True) if of == name)))
        for name in dict.fromkeys(names)
    }


def expected_p95(sigmas: Float64[np.ndarray, " n"], weights: Float64[np.ndarray, " n"]) -> float:
    """Error within which 95 % of the surface is expected, its errors being Gaussian."""
    low, high = 0.0, 4.0 * float(sigmas.max())
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        inside = erf(middle / np.maximum(sigmas, 1e-12) / np.sqrt(2))
        low, high = (middle, high) if float(weights @ inside) < 0.95 else (low, middle)
    return (low + high) / 2


def _weighted_quantile(
    values: Float64[np.ndarray, " n"], weights: Float64[np.ndarray, " n"], share: float
) -> float:
    order = np.argsort(values)
    return float(values[order][np.searchsorted(np.cumsum(weights[order]), share)])
