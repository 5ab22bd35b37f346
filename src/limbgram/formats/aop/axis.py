"""Axis: fits a line whose rays meet a limb once, where the limb's own axis gives no such map.

Method  Nelder-Mead over two tilts and two shifts, started from a line through the centroids of
        level bands and from the limb's own axis. The cost counts rays that miss the surface or
        cross it several times, and the surface lost below the point where the axis leaves the tip.
        It is evaluated on a decimated surface; the caller casts the full one.
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
"""Share of the height, at the proximal end, that is not counted: a brim may be oblique."""
_MOST_EVALUATIONS = 160
_STEP_TOLERANCE, _COST_TOLERANCE = 0.01, 1e-3
"""A search ends below these: its step as a share of the first step, and its change of cost."""
_MOST_FACES = 20_000
"""A surface of more faces is decimated to about this number."""
_FIRST_STEP_RAD, _FIRST_STEP_MM = 0.1, 10.0
_LOST_WEIGHT, _OFF_CENTRE_WEIGHT = 0.02, 0.05
_STEEPEST_RAD = np.radians(40.0)

AxisParameters = Float64[np.ndarray, "4"]
"""Tilts about x and y, rad; shifts along x and y, mm."""


def fitted_axis(mesh: Mesh, options: MapOptions) -> Rigid:
    """The motion from the limb frame to a frame round whose z axis most rays meet the limb once.

    Raises:
        CarveError: no line near the limb's own axis runs through it.
    """
    from scipy.optimize import minimize  # imported here: 0.1 s that most commands do without

    mesh = _decimated(mesh)
    pivot_mm = np.array([0.0, 0.0, float(mesh.vertices_mm[:, 2].mean())])
    units = np.array([_FIRST_STEP_RAD, _FIRST_STEP_RAD, _FIRST_STEP_MM, _FIRST_STEP_MM])

    def cost(scaled: AxisParameters) -> float:
        return _cost(mesh, _motion(scaled * units, pivot_mm), options)

    limits = {"maxfev": _MOST_EVALUATIONS, "xatol": _STEP_TOLERANCE, "fatol": _COST_TOLERANCE}
    best, least = np.zeros(4), np.inf
    for start in (_line_through_bands(mesh, pivot_mm), np.zeros(4)):
        found = minimize(cost, start / units, method="Nelder-Mead", options=limits)
        if float(found.fun) < least:
            best, least = np.asarray(found.x, np.float64), float(found.fun)
        if least < MOST_MENDED:
            break
    parameters: AxisParameters = best * units
    if np.hypot(parameters[0], parameters[1]) > _STEEPEST_RAD:
        raise CarveError("aop.no_axis")
    return _motion(parameters, pivot_mm)


def _decimated(mesh: Mesh) -> Mesh:
    """The mesh after vertex clustering on a grid; a closed surface stays closed."""
    if len(mesh.faces) <= _MOST_FACES:
        return mesh
    area_mm2 = 0.5 * float(np.linalg.norm(mesh.face_normals(), axis=1).sum())
    cell_mm = np.sqrt(2 * area_mm2 / _MOST_FACES)
    cells = np.floor((mesh.vertices_mm - mesh.vertices_mm.min(0)) / cell_mm).astype(np.int64)
    rows, columns, _ = cells.max(0) + 1
    cell = cells[:, 0] + rows * (cells[:, 1] + columns * cells[:, 2])
    cluster_of_vertex, count = np.unique(cell, return_inverse=True, return_counts=True)[1:]
    sums = [np.bincount(cluster_of_vertex, coordinates) for coordinates in mesh.vertices_mm.T]
    faces = cluster_of_vertex[mesh.faces].astype(np.int32)
    distinct = (faces != np.roll(faces, 1, axis=1)).all(1)
    return Mesh(vertices_mm=np.stack(sums, 1) / count[:, None], faces=faces[distinct])


def _motion(parameters: AxisParameters, pivot_mm: Float64[np.ndarray, "3"]) -> Rigid:
    """Tilt about the pivot, then shift; no turn about z, so that the front stays in front."""
    turn = Rotation.from_rotvec([parameters[0], parameters[1], 0.0]).as_matrix()
    shift_mm = np.array([parameters[2], parameters[3], 0.0])
    return Rigid(turn, pivot_mm - turn @ (pivot_mm + shift_mm))


def _line_through_bands(mesh: Mesh, pivot_mm: Float64[np.ndarray, "3"]) -> AxisParameters:
    """The least-squares line through the centroids of level bands."""
    centres = mesh.vertices_mm[mesh.faces].mean(1)
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    low, high = float(centres[:, 2].min()), float(centres[:, 2].max())
    band = ((centres[:, 2] - low) / max(high - low, 1e-9) * _BANDS).astype(np.int64)
    band = np.minimum(band, _BANDS - 1)
    weights = np.maximum(np.bincount(band, areas, _BANDS), 1e-12)
    x, y, z = (np.bincount(band, areas * axis, _BANDS) / weights for axis in centres.T)
    filled = weights > 1e-9
    slope_x, at_x = np.polyfit(z[filled] - pivot_mm[2], x[filled], 1)
    slope_y, at_y = np.polyfit(z[filled] - pivot_mm[2], y[filled], 1)
    return np.array([np.arctan(slope_y), -np.arctan(slope_x), at_x, at_y])


def _cost(mesh: Mesh, motion: Rigid, options: MapOptions) -> float:
    """Share of rays without exactly one crossing; with small weights the height lost at the tip and
    how far sections lie off centre.
    """
    moved = mesh.moved(motion)
    heights = moved.vertices_mm[:, 2]
    low, high = float(heights.min()), float(heights.max())
    top = high - _BRIM_SHARE * (high - low) if options.to_mm is None else options.to_mm
    bottom = low if options.from_mm is None else options.from_mm
    pierced_mm = axis_heights_mm(moved)
    first = float(pierced_mm[0]) if len(pierced_mm) else high
    levels = np.linspace(max(bottom, min(first, top - 1.0)) + 0.5, max(top, bottom + 1.0), _SLICES)
    cast = cast_radii(moved, 360.0 / _SPOKES * np.arange(_SPOKES), levels)
    bad = float((cast.crossings != 1).mean())
    radii_mm = cast.outermost_mm
    opposite_mm = np.roll(radii_mm, _SPOKES // 2, axis=1)
    off_centre = np.abs(radii_mm - opposite_mm).mean() / max(radii_mm.mean(), 1e-9)
    lost = max(0.0, first - bottom) / MOST_LOST_MM if options.from_mm is None else 0.0
    return bad + _LOST_WEIGHT * lost + _OFF_CENTRE_WEIGHT * float(off_centre)
