"""The network: how many rays meet in a point, at what angles, and how much is left over to check.

Redundancy is the number of measured coordinates (and calibrated lens parameters) beyond the
unknowns; sigma0 is the standard deviation of one measured coordinate that the residuals show.
"""

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.geometry.projection import POSE_SIZE
from limbgram.geometry.triangulation import triangulate
from limbgram.mapping.scene import Scene
from limbgram.report.accuracy.evidence import Json

_GAUGE_FREEDOM = 7
_ANGLE_STEP_DEG = 5.0
_LARGEST_ANGLE_DEG = 120.0
_MOST_RAYS = 12
_BELOW_DEG = 5.0


def network_figures(scene: Scene) -> Json:
    """Rays, angles, redundancy, overlap and the ring."""
    seen = _seen(scene)
    rays = seen.sum(1)
    angles = widest_angles_deg(scene, seen)
    return {
        "points": len(scene.points_in_world),
        "observations": int(len(scene.observations.xy_px)),
        **_freedom(scene),
        "rays": {
            "mean": float(rays.mean()),
            "median": float(np.median(rays)),
            "two_share": float(np.mean(rays == 2)),
            "numbers": list(range(2, _MOST_RAYS + 1)),
            "points": np.bincount(np.clip(rays, 2, _MOST_RAYS), minlength=_MOST_RAYS + 1)[
                2:
            ].tolist(),
        },
        "angles": {
            "median_deg": float(np.median(angles)),
            "low_deg": float(np.quantile(angles, 0.05)),
            "narrow_share": float(np.mean(angles < _BELOW_DEG)),
            **_angle_histogram(angles),
        },
        "point_sigma": _point_sigma(scene),
        "overlap": _overlap(scene, seen),
        "ring": None
        if scene.ring is None
        else {
            "largest_gap_deg": scene.ring.largest_gap_deg,
            "weakest_bridge_points": scene.ring.weakest_bridge,
            "closed": scene.ring.closed,
        },
    }


def widest_angles_deg(scene: Scene, seen: Bool[np.ndarray, "n p"]) -> Float64[np.ndarray, " n"]:
    """Largest angle between any two of a point's rays."""
    # Single precision: 0.03 degrees at worst, and half the memory of the largest array here.
    centres = np.array([view.centre_in_world for view in scene.views])
    middle = centres.mean(0)
    rays = (centres - middle).astype(np.float32)[None] - (
        (scene.points_in_world - middle).astype(np.float32)[:, None]
    )
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    smallest = np.ones(len(rays))
    for first in range(len(centres)):
        for second in range(first):
            both = seen[:, first] & seen[:, second]
            cosine = np.einsum("ij,ij->i", rays[both, first], rays[both, second])
            smallest[both] = np.minimum(smallest[both], cosine)
    return np.degrees(np.arccos(np.clip(smallest, -1.0, 1.0)))


def _seen(scene: Scene) -> Bool[np.ndarray, "n p"]:
    """Which placed photo sees which point."""
    place = np.full(len(scene.names), -1)
    place[list(scene.placed)] = np.arange(len(scene.placed))
    observed = scene.observations
    used = place[observed.photo_idx] >= 0
    seen = np.zeros((len(scene.points_in_world), len(scene.placed)), bool)
    seen[observed.point_idx[used], place[observed.photo_idx[used]]] = True
    return seen


def _freedom(scene: Scene) -> Json:
    """Redundancy, and sigma0 two ways: from all residuals, and robustly.

    A lens parameter that moves is observed too, by its calibration, so it takes nothing away.
    """
    residuals = scene.residuals_px()
    known = np.isfinite(residuals).all(1)
    coordinates = 2 * int(known.sum())
    unknowns = POSE_SIZE * len(scene.placed) + 3 * len(scene.points_in_world) - _GAUGE_FREEDOM
    redundancy = coordinates - unknowns
    squares = float((residuals[known] ** 2).sum())
    return {
        "unknowns": unknowns,
        "redundancy": redundancy,
        "redundancy_share": redundancy / coordinates if coordinates else float("nan"),
        "sigma0_px": float(np.sqrt(squares / redundancy)) if redundancy > 0 else float("nan"),
        "sigma0_robust_px": scene.sigma_px,
    }


def _angle_histogram(angles: Float64[np.ndarray, " n"]) -> Json:
    edges = np.arange(0, _LARGEST_ANGLE_DEG + _ANGLE_STEP_DEG, _ANGLE_STEP_DEG)
    inside = np.clip(angles, 0, _LARGEST_ANGLE_DEG - 1e-9)
    return {"edges_deg": edges.tolist(), "points": np.histogram(inside, edges)[0].tolist()}


def _point_sigma(scene: Scene) -> Json:
    """Formal sigma of a point along the direction that its rays fix worst, cameras exact."""
    seen = scene.observations
    place = np.full(len(scene.names), -1, np.int32)
    place[list(scene.placed)] = np.arange(len(scene.placed), dtype=np.int32)
    used = place[seen.photo_idx] >= 0
    found = triangulate(
        scene.views,
        place[seen.photo_idx[used]],
        seen.point_idx[used],
        seen.xy_px[used],
        len(scene.points_in_world),
    )
    covariance = found.covariance[np.isfinite(found.covariance).all((1, 2))]
    if not len(covariance):
        return {"median": float("nan"), "p95": float("nan")}
    worst = scene.sigma_px * np.sqrt(np.linalg.eigvalsh(covariance)[:, 2])
    return {"median": float(np.median(worst)), "p95": float(np.quantile(worst, 0.95))}


def _overlap(scene: Scene, seen: Bool[np.ndarray, "n p"]) -> Json:
    """Points that each pair of placed photos shares; a photo's own points on the diagonal."""
    numbers = seen.astype(np.float32)
    shared = np.rint(numbers.T @ numbers).astype(int)
    apart = shared - np.diag(np.diag(shared))
    return {
        "names": [scene.names[k] for k in scene.placed],
        "shared_points": shared.tolist(),
        "best_partner": apart.max(1).tolist() if len(apart) else [],
        "partners": (apart > 0).sum(1).tolist() if len(apart) else [],
    }
