"""Cameras: every lens parameter before and after the adjustment with its sigma; sigmas of poses."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from limbgram.calibration.cameras import Calibration
from limbgram.geometry.camera import PARAMETERS, Camera
from limbgram.geometry.projection import POSE_SIZE
from limbgram.mapping.scene import Scene
from limbgram.report.accuracy.evidence import Evidence, Json

_LEAST_LEARNED = 1e-4
"""Of the variance before: less than this is rounding."""
IN_PIXELS = ("fx", "fy", "cx", "cy", "skew")
"""Lens parameters with a unit; the others have none."""


def camera_figures(evidence: Evidence) -> list[Json]:
    """Each camera of the capture."""
    scene = evidence.metric.scene
    covariances = scene.lens_covariance
    return [
        _camera(idx, given, camera, None if covariances is None else covariances[idx])
        for idx, (given, camera) in enumerate(
            zip(evidence.cameras.calibrations, scene.cameras, strict=True)
        )
    ]


def _camera(
    idx: int, given: Calibration, camera: Camera, covariance: Float64[np.ndarray, "10 10"] | None
) -> Json:
    before, after = given.camera.packed, camera.packed
    sigmas = np.full(len(PARAMETERS), np.nan) if covariance is None else _sigmas(covariance)
    return {
        "camera": idx,
        "label": given.label,
        "source": given.source,
        "width_px": camera.width_px,
        "height_px": camera.height_px,
        "calibration_rms_px": given.rms_px,
        "parameters": [
            {
                "name": name,
                "unit": "px" if name in IN_PIXELS else "",
                "value": float(after[k]),
                "sigma": float(sigmas[k]),
                "calibrated": float(before[k]),
                "calibrated_sigma": float(given.sigmas[k]),
                "moved_sigmas": _ratio(after[k] - before[k], given.sigmas[k]),
                "contradicted_sigmas": _contradiction(
                    after[k] - before[k], given.sigmas[k], sigmas[k]
                ),
                "held": bool(given.sigmas[k] == 0),
            }
            for k, name in enumerate(PARAMETERS)
        ],
        "correlations": _correlations(covariance),
    }


def _sigmas(covariance: Float64[np.ndarray, "10 10"]) -> Float64[np.ndarray, "10"]:
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def _ratio(shift: float, sigma: float) -> float:
    return float(shift / sigma) if sigma > 0 else float("nan")


def _contradiction(shift: float, before: float, after: float) -> float:
    """The shift over the sigma that it has where calibration and photos agree.

    What is known before and learned from independent photos moves by chance with the variance that
    was lost on the way, before^2 - after^2. A tight calibration hardly moves however wrong it is;
    by this measure it is seen.
    """
    if not (before > 0 and np.isfinite(after)):
        return _ratio(shift, before)
    learned = max(before**2 - after**2, _LEAST_LEARNED * before**2)
    return float(shift / np.sqrt(learned))


def _correlations(covariance: Float64[np.ndarray, "10 10"] | None) -> Any:
    """Of the parameters that are free; None where the scene keeps no covariance."""
    if covariance is None:
        return None
    free = np.flatnonzero(np.diag(covariance) > 0)
    if not len(free):
        return None
    sigmas = _sigmas(covariance)[free]
    matrix = covariance[np.ix_(free, free)] / np.outer(sigmas, sigmas)
    return {"order": [PARAMETERS[k] for k in free], "matrix": matrix.tolist()}


def pose_figures(scene: Scene) -> Json | None:
    """Sigma of every photo's place and turn; None where the scene keeps no covariance of them.

    Of all three coordinates together (root of the trace), in the frame of the points' own
    average: what moves or turns the whole scene carries nothing.
    """
    covariance = scene.camera_covariance
    if covariance is None:
        return None
    rows: list[Json] = []
    for k, view in enumerate(scene.views):
        part = slice(POSE_SIZE * k, POSE_SIZE * (k + 1))
        pose = covariance[part, part]
        x, y, z = view.camera_from_world.translation
        crossed = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        # C = -R' t; a turn w and a shift d of t move it by -R' (t x w + d).
        moved = -view.camera_from_world.rotation.T @ np.hstack([crossed, np.eye(3)])
        rows.append(
            {
                "name": view.name,
                "centre": _root_trace(moved @ pose @ moved.T),
                "rotation_deg": float(np.degrees(_root_trace(pose[:3, :3]))),
            }
        )
    return {
        "centre_median": float(np.median([row["centre"] for row in rows])),
        "centre_largest": max(row["centre"] for row in rows),
        "rotation_median_deg": float(np.median([row["rotation_deg"] for row in rows])),
        "by_photo": rows,
    }


def _root_trace(covariance: Float64[np.ndarray, "3 3"]) -> float:
    return float(np.sqrt(max(np.trace(covariance), 0.0)))
