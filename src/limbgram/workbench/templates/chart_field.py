"""Chart field: a smooth function on a chart, fitted to scattered values, evaluated anywhere."""

import numpy as np
from jaxtyping import Float64
from scipy.sparse import csr_array, eye_array, kron
from scipy.sparse.linalg import spsolve

from limbgram.workbench.templates.charts import DOME, Chart

ANGLES = 60
"""Nodes round the limb."""
_SPACING = 0.04
"""Of nodes in chart height."""
_SMOOTH = 0.02
"""Weight of the second differences, in places per node."""
_FEWEST = 0.75
"""Places near a node without which nothing is known there."""
_WRAP = 8

Field = Float64[np.ndarray, "h a"]
"""At the nodes; NaN where nothing is known."""


def node_heights(top: float) -> Float64[np.ndarray, " h"]:
    """Chart heights of the nodes: from the tip to the last one under `top`."""
    return -DOME + _SPACING * np.arange(int((top + DOME) / _SPACING + 1e-9) + 1)


def fit_field(
    places: Chart, values: Float64[np.ndarray, " n"], heights: Float64[np.ndarray, " h"]
) -> Field:
    """Smoothing bicubic B-spline, periodic round the limb, by least squares, at its nodes."""
    rows = len(heights)
    inside = (places[:, 0] >= heights[0]) & (places[:, 0] <= heights[-1])
    up = (places[inside, 0] - heights[0]) / _SPACING
    round_ = (places[inside, 1] % (2 * np.pi)) / (2 * np.pi) * ANGLES
    low = np.minimum(up.astype(np.int64), rows - 2)
    left = round_.astype(np.int64) % ANGLES
    along, across = _basis(up - low), _basis(round_ - np.floor(round_))
    columns = (low[:, None, None] + np.arange(4)[None, :, None]) * ANGLES + (
        left[:, None, None] - 1 + np.arange(4)[None, None, :]
    ) % ANGLES
    weights = along[:, :, None] * across[:, None, :]
    count = len(up)
    design = csr_array(
        (
            weights.ravel(),
            (np.repeat(np.arange(count), 16), columns.ravel()),
        ),
        shape=(count, (rows + 2) * ANGLES),
    )
    smooth = _SMOOTH * max(count / (rows * ANGLES), 1.0)
    normal = design.T @ design + smooth * _roughness_matrix(rows + 2)
    found = np.asarray(
        spsolve(normal.tocsc(), design.T @ values[inside], permc_spec="MMD_AT_PLUS_A")
    )
    field = _at_nodes(found.reshape(rows + 2, ANGLES))
    field[0] = field[0].mean()
    near = np.bincount(
        np.minimum(np.rint(up).astype(np.int64), rows - 1) * ANGLES
        + np.rint(round_).astype(np.int64) % ANGLES,
        minlength=rows * ANGLES,
    ).reshape(rows, ANGLES)
    field[1:][near[1:] < _FEWEST] = np.nan
    if np.isnan(field[1]).all():
        field[0] = np.nan
    return field


def evaluate_field(
    field: Field, heights: Float64[np.ndarray, " h"], places: Chart
) -> Float64[np.ndarray, " n"]:
    """Evaluate the field at places; unknown counts as 0, and above the last node as at it."""
    from scipy.interpolate import RectBivariateSpline  # a tenth of a second, for templates alone

    known = np.nan_to_num(field)
    wrapped = np.concatenate([known[:, -_WRAP:], known, known[:, :_WRAP]], axis=1)
    angles = 2 * np.pi * np.arange(-_WRAP, ANGLES + _WRAP) / ANGLES
    spline = RectBivariateSpline(heights, angles, wrapped, kx=3, ky=3, s=0)
    up = np.clip(places[:, 0], heights[0], heights[-1])
    return np.asarray(spline.ev(up, places[:, 1] % (2 * np.pi)))


def _basis(t: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, "n 4"]:
    """Uniform cubic B-splines over one interval."""
    return (
        np.column_stack(
            [(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3]
        )
        / 6
    )


def _roughness_matrix(rows: int) -> csr_array:
    """Sum of squared second differences, up and round."""
    ring = np.arange(ANGLES)
    values = np.concatenate([np.ones(ANGLES), -2 * np.ones(ANGLES), np.ones(ANGLES)])
    turns = csr_array(
        (
            values,
            (np.tile(ring, 3), np.concatenate([(ring - 1) % ANGLES, ring, (ring + 1) % ANGLES])),
        ),
        shape=(ANGLES, ANGLES),
    )
    line = np.arange(rows - 2)
    rises = csr_array(
        (
            np.concatenate([np.ones(rows - 2), -2 * np.ones(rows - 2), np.ones(rows - 2)]),
            (np.tile(line, 3), np.concatenate([line, line + 1, line + 2])),
        ),
        shape=(rows - 2, rows),
    )
    up = kron(rises.T @ rises, eye_array(ANGLES))
    return csr_array(up + kron(eye_array(rows), turns.T @ turns))


def _at_nodes(coefficients: Float64[np.ndarray, "k a"]) -> Field:
    along = (coefficients[:-2] + 4 * coefficients[1:-1] + coefficients[2:]) / 6
    return (np.roll(along, 1, axis=1) + 4 * along + np.roll(along, -1, axis=1)) / 6
