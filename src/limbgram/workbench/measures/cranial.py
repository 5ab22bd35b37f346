"""Cranial: the figures of a head above its base plane, without grades of severity.

In      a head with sellion and both tragia.
Out     figures by name: width, length, girth and radii at the measuring level, diagonals,
        asymmetry and its indices, volumes of the four quadrants, ratios.
Method  Frame: x to the right, y forwards along the midline, z up from the base plane, from the
        middle of the tragia. Ten equal levels reach from the base plane to the highest place;
        figures are taken at the third. Radii start half way between front and back of the midline
        there. The diagonals lie at 30 degrees to the midline. Volumes are exact: the surface is
        clipped by the three planes of the frame, and cone by cone from their corner it fills the
        quadrant.
Fails   MeasureError: a landmark is missing, or the section at the measuring level is not whole.
        Volumes alone need a surface that is whole above the base plane.
"""

import math
from collections.abc import Mapping

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Matrix3, Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_half_edges
from limbgram.core.units import MM3_PER_ML
from limbgram.workbench.anatomy.directions import Anatomy
from limbgram.workbench.anatomy.kind import Midpoint
from limbgram.workbench.measures.levels import (
    Level,
    Measured,
    Sigmas,
    ap_mm,
    ap_through_mm,
    level_at,
    ml_mm,
    tape_mm,
)
from limbgram.workbench.measures.propagation import (
    PLACE_STEP_MM,
    PLACING_SHARE,
    Propagated,
    Subject,
    kinked_slopes,
    with_limb_heights,
)

LEVELS, MEASURING_LEVEL = 10, 3
DIAGONAL_DEG = 30.0
_SPOKES_DEG = range(15, 180, 15)
_QUADRANTS = {
    "right front": (1, 1),
    "left front": (-1, 1),
    "right back": (1, -1),
    "left back": (-1, -1),
}
_CLEARANCE_MM = 2 * PLACE_STEP_MM
"""An opening has to lie this far below the base plane, because slopes move the plane."""
Triangles = Float64[np.ndarray, "_ 3 3"]


def cranial_figures(subject: Subject) -> Mapping[str, Propagated]:
    """The figures of a head, by the names that the kind's items give them.

    Volumes are left out where the surface is open above the base plane; see `require_closed_above`.

    Raises:
        MeasureError: a landmark is missing, or the section at the measuring level is not whole.
    """
    _, middle_mm = _frame(subject.anatomy)
    try:
        return _figures(subject)
    except MeasureError as error:  # its heights count from the base plane
        raise with_limb_heights(error, subject.anatomy, middle_mm, 0.0) from error


def _figures(subject: Subject) -> Mapping[str, Propagated]:
    whole = _open_height_mm(subject) is None
    here = _values(subject.sigmas, *_frame(subject.anatomy), whole=whole, with_gradients=True)
    names = tuple(here)
    values = np.array([value for value, _ in here.values()])
    found: dict[str, dict[str, Vector3]] = {name: {} for name in names}
    placed: dict[str, dict[str, float]] = {name: {} for name in names}
    for place in ("sellion", "right tragion", "left tragion"):
        rows = [
            kinked_slopes(
                _values_with_moved_landmark(subject, place, step, whole),
                values,
                _values_with_moved_landmark(subject, place, -step, whole),
                PLACE_STEP_MM,
            )
            for step in np.eye(3) * PLACE_STEP_MM
        ]
        for name, slope in zip(names, np.stack(rows).T, strict=True):
            found[name][place] = slope
        for name, variance in zip(
            names, _placing_variances(subject, place, values, whole), strict=False
        ):
            placed[name][place] = variance
    turned, level = _measuring_level(subject.sigmas, *_frame(subject.anatomy))
    measures = _level_measures(level)
    beyond = {name: turned.extremity_variance(level, one.reaches) for name, one in measures.items()}
    lost = {name: turned.lost_along_mm(level, one) for name, one in measures.items()}
    by_top = _slopes_by_top(turned, level)
    return {
        name: Propagated(
            value=value,
            by_vertex=gradient + by_top.get(name, 0.0),
            by_place=found[name],
            placing_variances=placed[name],
            lost=lost.get(name, (0.0, 0.0)),
            extra_variance=beyond.get(name, 0.0),
        )
        for name, (value, gradient) in here.items()
    }


def _slopes_by_top(turned: Sigmas, level: Level) -> dict[str, Float64[np.ndarray, " n"]]:
    """Changes for a millimetre of each vertex through the highest place, which sets the level."""
    top = int(turned.mesh.vertices_mm[:, 2].argmax())
    lift = np.zeros(len(turned.mesh))
    lift[top] = turned.normals[top, 2] * MEASURING_LEVEL / LEVELS
    here = _level_measures(level)
    above, below = (
        _level_measures(level_at(turned.mesh, level.height_mm + step))
        for step in (PLACE_STEP_MM, -PLACE_STEP_MM)
    )
    ahead, values, behind = (
        np.array([at[name].value for name in here]) for at in (above, here, below)
    )
    slopes = kinked_slopes(ahead, values, behind, PLACE_STEP_MM)
    return {name: slope * lift for name, slope in zip(here, slopes.tolist(), strict=True)}


def require_closed_above(subject: Subject) -> None:
    """Refuse volumes of a surface that is open above the base plane.

    Raises:
        MeasureError: it is; says how high.
    """
    height_mm = _open_height_mm(subject)
    if height_mm is not None:
        raise MeasureError("measure.sheet.open_above", height_mm=height_mm)


def _placing_variances(
    subject: Subject, place: str, values: Float64[np.ndarray, " k"], whole: bool
) -> list[float]:
    """What placing a landmark adds to the variance of each figure; none where the measuring level
    leaves the surface on the way.

    Slopes do not tell: a level a few millimetres higher or lower may cut an ear, or a head's
    widest part, at which they are nothing.
    """
    try:
        changes = [
            _values_with_moved_landmark(subject, place, step, whole) - values
            for step in subject.placing_steps(place)
        ]
    except MeasureError:
        return []
    return (PLACING_SHARE * np.square(changes).sum(0)).tolist()


def _values_with_moved_landmark(
    subject: Subject, place: str, step: Vector3, whole: bool
) -> Float64[np.ndarray, " k"]:
    """All values with one landmark moved by a step."""
    frame = _frame(subject.moved(place, step))
    values = _values(subject.sigmas, *frame, whole=whole, with_gradients=False)
    return np.array([value for value, _ in values.values()])


def _frame(anatomy: Anatomy) -> tuple[Matrix3, Vector3]:
    """The head's axes (rows right, forward, up), and the midpoint of the tragia."""
    up = anatomy.axis("base").direction
    forward = anatomy.axis("midline").direction
    origin = anatomy.at(Midpoint(("right tragion", "left tragion")), "base")
    return np.stack([np.cross(forward, up), forward, up]), origin


_ValueAndGradient = tuple[float, Float64[np.ndarray, " n"]]
"""A value, and its change for a millimetre of each vertex along its normal, if wanted."""
_NO_GRADIENT = np.zeros(0)


def _values(
    sigmas: Sigmas, rotation: Matrix3, origin: Vector3, *, whole: bool, with_gradients: bool
) -> dict[str, _ValueAndGradient]:
    """The figures, with their gradients if wanted."""
    turned, level = _measuring_level(sigmas, rotation, origin)
    values = {
        name: (one.value, turned.gradient(level, one) if with_gradients else _NO_GRADIENT)
        for name, one in _level_measures(level).items()
    }
    if not whole:
        return values
    volumes = _quadrants(turned, with_gradients)
    values |= {f"volume {name}": one for name, one in volumes.items()}
    for half in ("front", "back"):
        values[f"symmetry {half}"] = _smaller_per_larger(
            volumes[f"right {half}"], volumes[f"left {half}"]
        )
    values["symmetry"] = _smaller_per_larger(
        _sum(volumes["right front"], volumes["right back"]),
        _sum(volumes["left front"], volumes["left back"]),
    )
    return values


def _measuring_level(sigmas: Sigmas, rotation: Matrix3, origin: Vector3) -> tuple[Sigmas, Level]:
    """The surface in the head's frame, and its section at the measuring level."""
    turned = sigmas.moved(Rigid(rotation, -rotation @ origin))
    top_mm = float(turned.mesh.vertices_mm[:, 2].max())
    return turned, level_at(turned.mesh, top_mm * MEASURING_LEVEL / LEVELS)


def _level_measures(level: Level) -> dict[str, Measured]:
    middle = _midline_centre(level)
    width, length = ml_mm(level), ap_mm(level)
    left = _diagonal(level, middle, 90 + DIAGONAL_DEG)
    right = _diagonal(level, middle, 90 - DIAGONAL_DEG)
    longer, shorter = (left, right) if left.value > right.value else (right, left)
    asymmetry = _linear_combination((longer, 1.0), (shorter, -1.0))
    return {
        "width": width,
        "length": length,
        "girth": tape_mm(level),
        "ratio": _per_cent(width, length),
        "diagonal left": left,
        "diagonal right": right,
        "asymmetry": asymmetry,
        "asymmetry signed": _linear_combination((left, 1.0), (right, -1.0)),
        "index shorter": _per_cent(asymmetry, shorter),
        "index longer": _per_cent(asymmetry, longer),
        "radial": _radial_asymmetry(level, middle),
    }


def _midline_centre(level: Level) -> Float64[np.ndarray, "2"]:
    """The point half way between front and back on the midline."""
    if ap_through_mm(level) is None:
        raise MeasureError("measure.sheet.off_midline")
    ahead, behind = (_spoke(level, np.zeros(2), angle).value for angle in (90.0, 270.0))
    return np.array([0.0, (ahead - behind) / 2])


def _diagonal(level: Level, middle: Float64[np.ndarray, "2"], angle_deg: float) -> Measured:
    return _linear_combination(
        (_spoke(level, middle, angle_deg), 1.0), (_spoke(level, middle, angle_deg + 180), 1.0)
    )


def _radial_asymmetry(level: Level, middle: Float64[np.ndarray, "2"]) -> Measured:
    parts: list[tuple[Measured, float]] = []
    for turn_deg in _SPOKES_DEG:
        left, right = (_spoke(level, middle, 90 + sign * turn_deg) for sign in (1, -1))
        sign = 1.0 if left.value > right.value else -1.0
        parts += [(left, sign), (right, -sign)]
    return _linear_combination(*parts)


def _spoke(level: Level, middle: Float64[np.ndarray, "2"], angle_deg: float) -> Measured:
    """Distance from the middle to the outline at an angle from the right, counter-clockwise."""
    angle = math.radians(angle_deg)
    way, side = (
        np.array([math.cos(angle), math.sin(angle)]),
        np.array([-math.sin(angle), math.cos(angle)]),
    )
    points, after = level.points_mm - middle, level.after
    across = points @ side
    astride = np.flatnonzero(level.outer & ((across > 0) != (across[after] > 0)))
    share = across[astride] / (across[astride] - across[after[astride]])
    reach = (1 - share) * (points[astride] @ way) + share * (points[after[astride]] @ way)
    if not len(reach) or reach.max() <= 0:
        raise MeasureError("measure.sheet.off_midline")
    k = int(reach.argmax())
    first, second = astride[k], after[astride[k]]
    edge = points[second] - points[first]
    normal = np.array([edge[1], -edge[0]])
    slopes = np.zeros_like(points)
    slopes[first] = (1 - share[k]) * normal / (normal @ way)
    slopes[second] += share[k] * normal / (normal @ way)
    return Measured(float(reach[k]), slopes)


def _linear_combination(*parts: tuple[Measured, float]) -> Measured:
    value = sum(one.value * times for one, times in parts)
    return Measured(float(value), np.sum([one.slopes * times for one, times in parts], axis=0))


def _per_cent(part: Measured, whole: Measured) -> Measured:
    value = 100 * part.value / whole.value
    slopes = (100 * part.slopes - value * whole.slopes) / whole.value
    shares = ((part, 100 / whole.value), (whole, value / whole.value))
    reaches = tuple(
        one._replace(times=one.times * share) for of, share in shares for one in of.reaches
    )
    return Measured(value, slopes, reaches=reaches)


def _sum(one: _ValueAndGradient, other: _ValueAndGradient) -> _ValueAndGradient:
    return one[0] + other[0], one[1] + other[1]


def _smaller_per_larger(one: _ValueAndGradient, other: _ValueAndGradient) -> _ValueAndGradient:
    small, large = (one, other) if one[0] < other[0] else (other, one)
    value = 100 * small[0] / large[0]
    return value, (100 * small[1] - value * large[1]) / large[0]


def _quadrants(turned: Sigmas, with_gradients: bool) -> dict[str, _ValueAndGradient]:
    """Volumes of the quadrants above the base plane, mL."""
    mesh = turned.mesh
    above = clipped_triangles(mesh.vertices_mm[mesh.faces], 2, 1)
    halves = {right: clipped_triangles(above, 0, right) for right in (1, -1)}
    areas = mesh.vertex_areas_mm2() if with_gradients else _NO_GRADIENT
    found: dict[str, _ValueAndGradient] = {}
    for name, (right, front) in _QUADRANTS.items():
        pieces = clipped_triangles(halves[right], 1, front)
        volume = np.einsum("fi,fi->f", pieces[:, 0], np.cross(pieces[:, 1], pieces[:, 2])).sum() / 6
        gradient = (
            areas * _vertices_in_quadrant(mesh, right, front) / MM3_PER_ML
            if with_gradients
            else _NO_GRADIENT
        )
        found[name] = float(volume) / MM3_PER_ML, gradient
    return found


def _vertices_in_quadrant(mesh: Mesh, right: int, front: int) -> Bool[np.ndarray, " n"]:
    """The vertices of a quadrant."""
    x, y, z = mesh.vertices_mm.T
    return (z > 0) & (right * x > 0) & (front * y > 0)


def clipped_triangles(pieces: Triangles, axis: int, sign: int) -> Triangles:
    """The parts of triangles on one side of a plane through the origin across an axis."""
    heights = sign * pieces[:, :, axis]
    above = heights > 0
    count = above.sum(1)
    kept = [pieces[count == 3]]
    for lone_above in (True, False):
        rows = np.flatnonzero(count == (1 if lone_above else 2))
        lone = (above[rows] == lone_above).argmax(1)
        order = (lone[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(pieces[rows], order[:, :, None], axis=1).transpose(1, 0, 2)
        p, q, r = np.take_along_axis(heights[rows], order, axis=1).T
        at_b = a + (p / (p - q))[:, None] * (b - a)
        at_c = a + (p / (p - r))[:, None] * (c - a)
        if lone_above:
            kept.append(np.stack([a, at_b, at_c], axis=1))
        else:
            kept += [np.stack([at_b, b, c], axis=1), np.stack([at_b, c, at_c], axis=1)]
    return np.concatenate(kept)


def _open_height_mm(subject: Subject) -> float | None:
    """Height over the base plane up to which the surface is open; None where it is closed."""
    rotation, origin = _frame(subject.anatomy)
    mesh = subject.sigmas.mesh
    edges = (mesh.vertices_mm[boundary_half_edges(mesh.faces)].reshape(-1, 3) - origin) @ rotation.T
    height_mm = float(edges[:, 2].max(initial=-np.inf))
    return max(height_mm, 0.0) if height_mm > -_CLEARANCE_MM else None
