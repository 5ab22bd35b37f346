"""Axis: a line from which rays meet a limb once, where the limb's own axis gives no such map.

Method  from a straight line through the middles of the limb's bands, and from its own axis, a
        search over two tilts and two shifts for the fewest rays that miss the surface or cross it
        several times, and the least surface lost below the point where the axis leaves the tip.
        The search goes by a thinned surface: the caller casts the whole one round what it finds.
"""

import numpy as np
from jaxtyping import Float64
from scipy.spatial.transform import Rotation

from limbgram.core.errors import CarveError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.carving.mapping import MOST_LOST_MM, MOST_MENDED, MapOptions
from limbgram.workbench.carving.radial_rays import axis_heights_mm, cast_radii

_SPOKES, _SLICES, _BANDS = 48, 40, 24
_BRIM_SHARE = 0.08
"""Of the height, at the proximal end: an oblique brim is no fault of the axis."""
_STEPS = 160
_SHARE_OF_STEP, _COST_STEP = 0.01, 1e-3
"""A search ends where it moves by less of its first steps, and gains less."""
_FACES = 20_000
"""A surface of more faces is thinned to about so many."""
_RADIAN, _MM = 0.1, 10.0
"""Sizes of the search's first steps."""
_LOST_WEIGHT, _OFF_WEIGHT = 0.02, 0.05
_STEEPEST_RAD = np.radians(40.0)

Line = Float64[np.ndarray, "4"]
"""Tilts about x and y, rad; shifts along x and y, mm."""


def fitted_axis(mesh: Mesh, options: MapOptions) -> Rigid:
    """The motion, from the limb frame, to a frame whose z axis gives a map of single radii.

    Raises:
        CarveError: the limb lies so that no line near its own axis runs through it.
    """
    from scipy.optimize import minimize  # a tenth of a second, which most commands do without

    mesh = _thinned(mesh)
    middle = np.array([0.0, 0.0, float(mesh.vertices_mm[:, 2].mean())])
    sizes = np.array([_RADIAN, _RADIAN, _MM, _MM])

    def cost(steps: Line) -> float:
        return _cost(mesh, _motion(steps * sizes, middle), options)

    ends = {"maxfev": _STEPS, "xatol": _SHARE_OF_STEP, "fatol": _COST_STEP}
    best, least = np.zeros(4), np.inf
    for start in (_through_bands(mesh, middle), np.zeros(4)):
        found = minimize(cost, start / sizes, method="Nelder-Mead", options=ends)
        if float(found.fun) < least:
            best, least = np.asarray(found.x, np.float64), float(found.fun)
        if least < MOST_MENDED:
            break
    line: Line = best * sizes
    if np.hypot(line[0], line[1]) > _STEEPEST_RAD:
        raise CarveError("aop.no_axis")
    return _motion(line, middle)


def _thinned(mesh: Mesh) -> Mesh:
    """Vertices that share a cell of a grid made one, at their mean; closed stays closed."""
    if len(mesh.faces) <= _FACES:
        return mesh
    area_mm2 = 0.5 * float(np.linalg.norm(mesh.face_normals(), axis=1).sum())
    cell_mm = np.sqrt(2 * area_mm2 / _FACES)
    cells = np.floor((mesh.vertices_mm - mesh.vertices_mm.min(0)) / cell_mm).astype(np.int64)
    rows, columns, _ = cells.max(0) + 1
    number = cells[:, 0] + rows * (cells[:, 1] + columns * cells[:, 2])
    of_vertex, count = np.unique(number, return_inverse=True, return_counts=True)[1:]
    sums = [np.bincount(of_vertex, axis) for axis in mesh.vertices_mm.T]
    faces = of_vertex[mesh.faces].astype(np.int32)
    whole = (faces != np.roll(faces, 1, axis=1)).all(1)
    return Mesh(vertices_mm=np.stack(sums, 1) / count[:, None], faces=faces[whole])


def _motion(line: Line, middle: Float64[np.ndarray, "3"]) -> Rigid:
    """Tilt about the limb's middle, and shift; the front stays as nearly in front as can be."""
    turn = Rotation.from_rotvec([line[0], line[1], 0.0]).as_matrix()
    shift = np.array([line[2], line[3], 0.0])
    return Rigid(turn, middle - turn @ (middle + shift))


def _through_bands(mesh: Mesh, middle: Float64[np.ndarray, "3"]) -> Line:
    """The straight line through the middles of level bands, by least squares."""
    centres = mesh.vertices_mm[mesh.faces].mean(1)
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    low, high = float(centres[:, 2].min()), float(centres[:, 2].max())
    band = ((centres[:, 2] - low) / max(high - low, 1e-9) * _BANDS).astype(np.int64)
    band = np.minimum(band, _BANDS - 1)
    weights = np.maximum(np.bincount(band, areas, _BANDS), 1e-12)
    x, y, z = (np.bincount(band, areas * axis, _BANDS) / weights for axis in centres.T)
    kept = weights > 1e-9
    slope_x, at_x = np.polyfit(z[kept] - middle[2], x[kept], 1)
    slope_y, at_y = np.polyfit(z[kept] - middle[2], y[kept], 1)
    return np.array([np.arctan(slope_y), -np.arctan(slope_x), at_x, at_y])


def _cost(mesh: Mesh, motion: Rigid, options: MapOptions) -> float:
    """Share of bad rays, and in small part what is lost at the tip and how far off sections lie."""
    moved = mesh.moved(motion)
    heights = moved.vertices_mm[:, 2]
    low, high = float(heights.min()), float(heights.max())
    top = high - _BRIM_SHARE * (high - low) if options.to_mm is None else options.to_mm
    bottom = low if options.from_mm is None else options.from_mm
    pierced = axis_heights_mm(moved)
    first = float(pierced[0]) if len(pierced) else high
    levels = np.linspace(max(bottom, min(first, top - 1.0)) + 0.5, max(top, bottom + 1.0), _SLICES)
    cast = cast_radii(moved, 360.0 / _SPOKES * np.arange(_SPOKES), levels)
    bad = float((cast.crossings != 1).mean())
    reach = cast.outermost_mm
    off = np.abs(reach - np.roll(reach, _SPOKES // 2, axis=1)).mean() / max(reach.mean(), 1e-9)
    lost = max(0.0, first - bottom) / MOST_LOST_MM if options.from_mm is None else 0.0
    return bad + _LOST_WEIGHT * lost + _OFF_WEIGHT * float(off)
