"""Residuals: how far the measured image points lie from where the scene puts them, and where.

A residual is measured minus projected, px, one coordinate at a time; x to the right, y down. What
the lens model misses shows as a pattern over the picture: the mean residual of a cell of the grid,
over all photos of one camera, is then larger than chance makes it.
"""

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.geometry.arrays import Points2
from limbgram.geometry.camera import Camera
from limbgram.mapping.scene import Scene
from limbgram.report.accuracy.evidence import Json

_BINS = 61
_REACH_SIGMAS = 5.0
_CELLS_ACROSS = 12
_ZONES = 5
_FEWEST_IN_CELL = 5


def residual_figures(scene: Scene) -> Json:
    """Histogram, by photo, by distance from the picture's middle, and the systematic part."""
    residuals = scene.residuals_px()
    known = np.isfinite(residuals).all(1)
    off, seen = residuals[known], scene.observations
    photo_idx, xy_px = seen.photo_idx[known], seen.xy_px[known]
    cameras = np.array(scene.camera_idx, np.int64)[photo_idx]
    return {
        "rms_px": _rms(off),
        "median_distance_px": float(np.median(np.hypot(*off.T))) if len(off) else float("nan"),
        "largest_px": float(np.hypot(*off.T).max(initial=0.0)),
        "beyond_3_sigma_share": _beyond(off, scene.sigma_px),
        "histogram": _histogram(off, scene.sigma_px),
        "by_photo": _by_photo(scene, photo_idx, off),
        "by_camera": [
            _of_camera(idx, camera, xy_px[cameras == idx], off[cameras == idx])
            for idx, camera in enumerate(scene.cameras)
        ],
    }


def _rms(off: Points2) -> float:
    """Of one coordinate."""
    return float(np.sqrt(np.mean(off**2))) if len(off) else float("nan")


def _beyond(off: Points2, sigma_px: float) -> float:
    """Share of coordinates beyond three robust sigmas; 0.27 % where the errors are Gaussian."""
    return float(np.mean(np.abs(off) > 3 * sigma_px)) if len(off) else float("nan")


def _histogram(off: Points2, sigma_px: float) -> Json:
    reach = _REACH_SIGMAS * sigma_px if sigma_px > 0 else max(float(np.abs(off).max(initial=0)), 1)
    edges = np.linspace(-reach, reach, _BINS + 1)
    inside = np.clip(off, -reach, reach)
    return {
        "edges_px": edges.tolist(),
        "x": np.histogram(inside[:, 0], edges)[0].tolist(),
        "y": np.histogram(inside[:, 1], edges)[0].tolist(),
    }


def _by_photo(scene: Scene, photo_idx: np.ndarray, off: Points2) -> list[Json]:
    rows: list[Json] = []
    for photo in scene.placed:
        own = off[photo_idx == photo]
        mean = own.mean(0) if len(own) else np.full(2, np.nan)
        rows.append(
            {
                "name": scene.names[photo],
                "observations": len(own),
                "rms_px": _rms(own),
                "mean_x_px": float(mean[0]),
                "mean_y_px": float(mean[1]),
                "largest_px": float(np.hypot(*own.T).max(initial=0.0)),
            }
        )
    return rows


def _of_camera(idx: int, camera: Camera, xy_px: Points2, off: Points2) -> Json:
    return {
        "camera": idx,
        "observations": len(off),
        "grid": _grid(camera, xy_px, off),
        "zones": _zones(camera, xy_px, off),
        "systematic_px": systematic_px(_cells(camera, xy_px), off),
    }


def _shape(camera: Camera) -> tuple[int, int]:
    """Rows and columns of the grid: cells about square."""
    rows = max(2, round(_CELLS_ACROSS * camera.height_px / camera.width_px))
    return rows, _CELLS_ACROSS


def _cells(camera: Camera, xy_px: Points2) -> Int64[np.ndarray, " m"]:
    rows, columns = _shape(camera)
    size = np.array([camera.width_px, camera.height_px])
    column, row = ((xy_px + 0.5) / size * (columns, rows)).astype(np.int64).T
    return np.clip(row, 0, rows - 1) * columns + np.clip(column, 0, columns - 1)


def _grid(camera: Camera, xy_px: Points2, off: Points2) -> Json:
    """Cells row after row, from the top left: observations, mean residual, RMS."""
    rows, columns = _shape(camera)
    cell, count = _cells(camera, xy_px), rows * columns
    number = np.bincount(cell, minlength=count)
    divisor = np.where(number >= _FEWEST_IN_CELL, number, np.nan)
    sums = [np.bincount(cell, off[:, axis], count) / divisor for axis in (0, 1)]
    squares = np.bincount(cell, (off**2).sum(1) / 2, count) / divisor
    return {
        "rows": rows,
        "columns": columns,
        "width_px": camera.width_px,
        "height_px": camera.height_px,
        "observations": number.tolist(),
        "mean_x_px": sums[0].tolist(),
        "mean_y_px": sums[1].tolist(),
        "rms_px": np.sqrt(squares).tolist(),
    }


def systematic_px(cell: Int64[np.ndarray, " m"], off: Points2) -> float:
    """RMS of one coordinate's mean over a cell, less what chance alone makes of it.

    Unbiased: the sum of squares between cells estimates systematic^2 + variance within / number.
    """
    count = int(cell.max(initial=-1)) + 1
    number = np.bincount(cell, minlength=count)
    used = number >= _FEWEST_IN_CELL
    if not used.any():
        return float("nan")
    excess, weight = 0.0, float(number[used].sum())
    for axis in (0, 1):
        mean = np.bincount(cell, off[:, axis], count)[used] / number[used]
        square = np.bincount(cell, off[:, axis] ** 2, count)[used] / number[used]
        by_chance = np.maximum(square - mean**2, 0.0) / (number[used] - 1)
        excess += float(np.sum(number[used] * (mean**2 - by_chance))) / weight / 2
    return float(np.sqrt(max(excess, 0.0)))


def _zones(camera: Camera, xy_px: Points2, off: Points2) -> list[Json]:
    """Rings round the picture's middle: RMS, and the mean residual away from the middle."""
    middle = np.array([camera.width_px - 1, camera.height_px - 1]) / 2
    arm = xy_px - middle
    radius = np.hypot(*arm.T)
    share: Float64[np.ndarray, " m"] = radius / float(np.hypot(*(middle + 0.5)))
    outward = (off * arm).sum(1) / np.maximum(radius, 1e-9)
    zone = np.clip((share * _ZONES).astype(np.int64), 0, _ZONES - 1)
    return [
        {
            "from_share": k / _ZONES,
            "to_share": (k + 1) / _ZONES,
            "observations": int((zone == k).sum()),
            "rms_px": _rms(off[zone == k]),
            "outward_px": float(outward[zone == k].mean()) if (zone == k).any() else float("nan"),
        }
        for k in range(_ZONES)
    ]
