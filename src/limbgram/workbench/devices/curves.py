"""Curves: a fair closed curve on a surface through points that lie far apart.

A spline in space, brought to the surface, jumps where the surface turns away under it
(`edits/regions.draw_curve`, for points that were drawn close together). Here the shortest ways
over the surface join the points, and are made fair on it.

Method  Points along the curve move to where it bends least, each the mean of four neighbours (the
        discrete biharmonic equation), and back to the surface; the given points stay. Coarse steps
        first: every step is short, and none jumps. Corners are rounded far; a long leg stays near
        the shortest way, for so many rounds do not settle all of it. So that way has to be the
        surface's own: one along the edges of triangles would differ from scan to scan of a limb.
"""

from functools import partial

import numpy as np
from jaxtyping import Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.polyline import resampled
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.tree_cache import AnswersByMesh, tree_on
from limbgram.workbench.edits.regions import Curve
from limbgram.workbench.measures.geodesic import length_mm, shortest_path

_STEPS_MM = (16.0, 8.0, 4.0, 2.0, 1.0, 0.5)
_ROUNDS = 60
_STEP_SHARE = 0.5
"""Share of the way towards least bending that a point moves in one round; more than 0.75
diverges."""
_SMOOTHING_WEIGHTS = 1 - _STEP_SHARE, _STEP_SHARE * 4 / 6, -_STEP_SHARE / 6
"""Weights of a point itself, of its neighbours and of theirs in one smoothing round."""
_FEWEST_SEGMENTS = 2
_NORMAL_STEPS = 4
"""Points to either side over which the normals along the curve are averaged."""


Line = Float64[np.ndarray, "_ 3"]
"""Each of its own number of points."""
_leg_cache = AnswersByMesh[Line](most=256)
_curve_cache = AnswersByMesh[Curve](most=16)
"""Moving one point of an edge changes only its two legs; changing the wall's thickness changes no
edge."""


def fair_curve(mesh: Mesh, picked_mm: Points3) -> Curve:
    """The fair closed curve through places on the surface.

    Raises:
        MeasureError: no surface joins two places.
    """
    return _curve_cache(mesh, picked_mm.tobytes(), lambda: _make_curve(mesh, picked_mm))


def _make_curve(mesh: Mesh, picked_mm: Points3) -> Curve:
    count = len(picked_mm)
    tree = tree_on(mesh)
    ring = picked_mm
    legs = [
        _leg_cache(
            mesh, (here.tobytes(), ahead.tobytes()), partial(shortest_path, mesh, here, ahead)
        )
        for here, ahead in zip(picked_mm, np.roll(picked_mm, -1, axis=0), strict=True)
    ]
    for step_mm in _STEPS_MM:
        parts = [
            resampled(leg, max(_FEWEST_SEGMENTS, round(length_mm(leg) / step_mm)) + 1)[:-1]
            for leg in legs
        ]
        sizes = np.array([len(part) for part in parts])
        ring = np.concatenate(parts)
        starts = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64)
        held = np.isin(np.arange(len(ring)), starts)
        ring = tree.relaxed(ring, held, _SMOOTHING_WEIGHTS, _ROUNDS)
        closed = np.concatenate([ring, ring[:1]])
        ends = np.append(starts, len(ring))
        legs = [closed[ends[k] : ends[k + 1] + 1] for k in range(count)]
    return Curve.on(mesh, tree.closest(ring), _NORMAL_STEPS)
