"""Axis: the line through the middles of a limb's sections."""

import numpy as np
from jaxtyping import Float64

from limbgram.geometry.arrays import Points3
from limbgram.shape.edits.marking.places import in_limb_frame
from limbgram.shape.limb import Limb
from limbgram.surface.sections import cut

_LEVELS = 48
_LEAST_SHARE = 0.5
"""A section needs this share of the largest one's area to have a say."""


def middles_mm(limb: Limb, points: Points3, what: str) -> Points3:
    """For points in the limb frame: the middle of the section at the height of each.

    The line follows the centroids of whole sections, and is made smooth; where sections are
    open (at a slanting brim) or shrink (at the distal end) it goes on along the axis.
    """
    vertices = in_limb_frame(limb, what)
    mesh = limb.mesh.with_vertices(vertices)
    low, high = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    heights = low + (high - low) * (np.arange(_LEVELS) + 0.5) / _LEVELS
    rows: list[tuple[float, float, float, float]] = []
    for section in cut(mesh, heights.tolist()):
        if section.closed:
            area, x, y = _area_and_centroid(section.points_mm)
            rows.append((section.offset_mm, area, x, y))
    table = np.array(rows).reshape(-1, 4)
    largest = table[:, 1].max(initial=0.0)
    table = table[table[:, 1] > _LEAST_SHARE * largest]
    if not len(table):
        return np.array([0.0, 0.0, 1.0]) * points
    table = _largest_of_each(table)
    line = np.stack([_calm(table[:, 2]), _calm(table[:, 3])], axis=1)
    x = np.interp(points[:, 2], table[:, 0], line[:, 0])
    y = np.interp(points[:, 2], table[:, 0], line[:, 1])
    return np.stack([x, y, points[:, 2]], axis=1)


def _area_and_centroid(points: Points3) -> tuple[float, float, float]:
    base = points[0, :2]
    here = points[:, :2] - base
    ahead = np.roll(here, -1, axis=0)
    double = here[:, 0] * ahead[:, 1] - here[:, 1] * ahead[:, 0]
    area = float(double.sum()) / 2
    if abs(area) < 1e-9:
        return 0.0, float(base[0]), float(base[1])
    middle = ((here + ahead) * double[:, None]).sum(0) / (6 * area) + base
    return area, float(middle[0]), float(middle[1])


def _largest_of_each(table: Float64[np.ndarray, "k 4"]) -> Float64[np.ndarray, "m 4"]:
    """One row for each height: that of the largest area."""
    order = np.lexsort((-table[:, 1], table[:, 0]))
    first = np.unique(table[order, 0], return_index=True)[1]
    return table[order][first]


def _calm(values: Float64[np.ndarray, " m"]) -> Float64[np.ndarray, " m"]:
    """Averaged over five neighbours, the ends held."""
    padded = np.concatenate([values[:1], values[:1], values, values[-1:], values[-1:]])
    return np.asarray(sum(padded[k : k + len(values)] for k in range(5))) / 5
