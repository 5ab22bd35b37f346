"""Propagation: the sigma of a figure from the surface and from where landmarks were placed.

A landmark errs along the surface by its placing error in each direction, and with the surface along
its normal. Both parts are propagated to first order: the surface's through the gradient over its
vertices, with the covariances that the mesh carries; the placing's by differences.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Matrix3, Vector3
from limbgram.core.geometry.frames import Rigid, plane_basis
from limbgram.core.mesh.mesh import unit
from limbgram.core.mesh.uncertainty import propagate
from limbgram.workbench.anatomy.directions import Anatomy
from limbgram.workbench.anatomy.landmark import Placing
from limbgram.workbench.anatomy.names import landmarks_by_identity
from limbgram.workbench.anatomy.surface_lines import LineSurface
from limbgram.workbench.bodies import outer_bodies
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.lengths import barycentric_on_mesh, vertex_gradient
from limbgram.workbench.measures.levels import Figure, Level, Measured, Sigmas, level_at

LEAN_STEP = 1e-4
"""Step by which slopes of axes fitted to the surface are changed."""
PLACE_STEP_MM = 0.5
"""Step of landmarks for finite differences: above facet roughness, below a limb's curvature."""
TILT_STEP_RAD = 0.01
_PLACING_REACH = math.sqrt(3.0)
PLACING_SHARE = 1 / 6
"""Of the squared changes at both ends of that many standard deviations."""
Slopes = Mapping[str, Float64[np.ndarray, "3 k"]]
Measure = Callable[[Level], Measured]


@dataclass(frozen=True, kw_only=True)
class Propagated:
    """A figure's value, and its derivatives by the surface and by the landmarks."""

    value: float
    by_vertex: Float64[np.ndarray, " n"] | None = None
    """Change for a millimetre of each vertex along its normal, with fixed landmarks."""
    by_place: Mapping[str, Vector3] = field(default_factory=dict[str, Vector3])
    """Change for a millimetre of each landmark in each direction."""
    placing_variances: Mapping[str, float] = field(default_factory=dict[str, float])
    """By landmark, what its placing adds, where the figure was followed as far as that reaches
    (`Subject.placing_steps`); of the others it follows from `by_place`."""
    lost: tuple[float, float] = (0.0, 0.0)
    """Length to be added for fine relief that the surface lost, and its sigma."""
    extra_variance: float = 0.0
    """Variance beyond first order; negative where first order overstates it."""


class _TrackedPlaces(dict[str, Vector3]):
    """Places that record which of them were read: only these have a slope."""

    def __init__(self, places: Mapping[str, Vector3]) -> None:
        super().__init__(places)
        self.names: dict[str, None] = {}

    def __getitem__(self, name: str) -> Vector3:
        self.names[name] = None
        return super().__getitem__(name)


@dataclass(frozen=True, kw_only=True)
class Subject:
    """A limb that is being measured, with the data for propagating errors."""

    anatomy: Anatomy
    sigmas: Sigmas
    """Sigmas of its outer surface, in the mesh's frame."""
    normals: Mapping[str, Vector3]
    """Normal of the surface at each landmark."""
    placing_mm: Mapping[str, float]
    _moved: dict[tuple[str, bytes], Anatomy] = field(
        default_factory=dict[tuple[str, bytes], Anatomy], init=False, repr=False, compare=False
    )
    """Anatomies with one landmark moved, by landmark and step, shared between figures."""

    @classmethod
    def of(cls, limb: Limb, placing: Placing) -> "Subject":
        found = outer_bodies(limb.mesh)
        found.require_one_limb()
        anatomy = replace(limb.anatomy, skin=LineSurface(mesh=found.mesh))
        names = tuple(anatomy.places)
        normals: dict[str, Vector3] = {}
        sigmas = Sigmas.of(found.mesh)
        if names:
            places = np.stack([anatomy.places[name] for name in names])
            ids, shares = barycentric_on_mesh(found.mesh, places)
            at_places = unit(np.einsum("pk,pkd->pd", shares, sigmas.normals[ids]))
            normals = dict(zip(names, at_places, strict=True))
        return cls(
            anatomy=anatomy,
            sigmas=sigmas,
            normals=normals,
            placing_mm={
                name: placing.of(one) for name, one in landmarks_by_identity(limb.landmarks).items()
            },
        )

    def figure(self, propagated: Propagated) -> tuple[Figure, float | None]:
        """The figure with its sigma, and the placing's part of that."""
        followed = propagated.placing_variances
        placing = math.sqrt(
            sum(
                followed[name] if name in followed else self._placing_variance(name, g)
                for name, g in propagated.by_place.items()
            )
        )
        value = propagated.value + propagated.lost[0]
        if self.sigmas.mesh.sigma_mm is None:
            return Figure(value, None), placing
        gradient = np.zeros(len(self.sigmas.mesh))
        if propagated.by_vertex is not None:
            gradient += propagated.by_vertex
        if propagated.by_place:
            places = np.stack([self.anatomy.places[name] for name in propagated.by_place])
            gradient += vertex_gradient(
                self.sigmas, places, np.stack([*propagated.by_place.values()])
            )
        surface = propagate(self.sigmas.mesh, gradient) or 0.0
        surface = math.sqrt(max(surface**2 + propagated.extra_variance, 0.0))
        return Figure(value, math.hypot(surface, placing, propagated.lost[1])), placing

    def _placing_variance(self, name: str, gradient: Vector3) -> float:
        """Variance that one landmark's placing adds: it slides along the surface."""
        normal = self.normals[name]
        along = gradient - normal * (gradient @ normal)
        return float(along @ along) * self.placing_mm[name] ** 2

    def placing_steps(self, name: str) -> Float64[np.ndarray, "4 3"]:
        """Steps of a landmark along the surface, to both sides in two directions, after which a
        figure changes by d: the sum of d squared over six is the variance that placing adds.

        Gauss and Hermite's three places: exact up to fifth powers, where slopes are so for lines.
        """
        ways = _PLACING_REACH * self.placing_mm[name] * plane_basis(self.normals[name])
        return np.concatenate([ways, -ways])

    def moved(self, name: str, step: Vector3) -> Anatomy:
        """The anatomy with one landmark moved by a step."""
        key = name, step.tobytes()
        if key not in self._moved:
            places = dict(self.anatomy.places)
            places[name] = places[name] + step
            self._moved[key] = replace(self.anatomy, places=places)
        return self._moved[key]

    def vertex_slopes_by_axes(
        self, what: Callable[[Anatomy], float], names: Iterable[str]
    ) -> Float64[np.ndarray, " n"]:
        """Change of a figure for a millimetre of each vertex along its normal, by the axes alone.

        Only named axes that are fitted to the surface count; landmarks stay fixed.
        """
        gradient = np.zeros(len(self.sigmas.mesh))
        for name in dict.fromkeys(names):
            found = self.anatomy.surface_line(name)
            if found is not None:
                ahead, behind = (
                    what(self.anatomy.with_added_slope(name, step))
                    for step in (LEAN_STEP, -LEAN_STEP)
                )
                by_lean = (ahead - behind) / (2 * LEAN_STEP)
                gradient += by_lean * found.by_vertex(self.sigmas.normals)
        return gradient

    def slopes(self, what: Callable[[Anatomy], Float64[np.ndarray, " k"]]) -> Slopes:
        """Change of values that depend on landmarks alone, by landmark: rows by direction."""
        used = _TrackedPlaces(self.anatomy.places)
        first = what(replace(self.anatomy, places=used))
        found: dict[str, Float64[np.ndarray, "3 k"]] = {}
        for name in used.names:
            rows = [
                (what(self.moved(name, step)) - what(self.moved(name, -step))) / (2 * PLACE_STEP_MM)
                for step in np.eye(3) * PLACE_STEP_MM
            ]
            if np.any(rows):
                found[name] = np.stack(rows).reshape(3, len(first))
        return found


@dataclass(frozen=True, kw_only=True)
class CutPlane:
    """A cutting plane as a frame: rows x (the direction of widths), y and normal."""

    rotation: Matrix3
    through_mm: Vector3
    """In that frame: x and y inside the outline that counts, and the plane's height. Halves are
    parted by the line along y through it."""

    def level(self, sigmas: Sigmas) -> Level:
        x, y, height = self.through_mm.tolist()
        return level_at(self.surface_in_frame(sigmas).mesh, height, (x, y))

    def surface_in_frame(self, sigmas: Sigmas) -> Sigmas:
        """The surface in the plane's frame."""
        return sigmas.moved(Rigid(self.rotation, np.zeros(3)))

    def moved_slightly(
        self, offset_mm: float, tilt_rad: float, roll_rad: float, turn_rad: float
    ) -> "CutPlane":
        """A plane near this one: moved along its normal, tilted about its x and y, and turned
        about the normal, all about the place inside the outline."""
        turn = Rigid.from_rotation_vector(np.array([tilt_rad, roll_rad, turn_rad]), np.zeros(3))
        rotation = turn.rotation @ self.rotation
        place = self.rotation.T @ self.through_mm
        moved = rotation @ place
        return CutPlane(rotation=rotation, through_mm=moved + np.array([0.0, 0.0, offset_mm]))

    def level_in_frame(self, level: Level, aside_mm: float = 0.0) -> Level:
        """A level with the plane's place as origin, or a place a distance from it along x."""
        x, y, _ = self.through_mm.tolist()
        return replace(level, points_mm=level.points_mm - np.array([x + aside_mm, y]))

    def offsets_to(self, other: "CutPlane") -> Float64[np.ndarray, "5"]:
        """The steps of `moved_slightly` that lead from this plane to another one.

        The last value is the distance of its place from this one's along x.
        """
        place = self.rotation.T @ self.through_mm
        away = other.rotation.T @ other.through_mm - place
        offset = away @ other.rotation[2]
        turn = other.rotation @ self.rotation.T
        return np.array(
            [
                offset,
                (turn[2, 1] - turn[1, 2]) / 2,
                (turn[0, 2] - turn[2, 0]) / 2,
                (turn[1, 0] - turn[0, 1]) / 2,
                away @ other.rotation[0],
            ]
        )


def measure_section(
    subject: Subject, cut_of: Callable[[Anatomy], CutPlane], measures: Mapping[str, Measure]
) -> dict[str, Propagated]:
    """Measures of one section, each with its derivatives by surface and landmarks.

    Args:
        cut_of: Gives the plane by the landmarks.
        measures: Measures of a level whose origin is the plane's place.

    Raises:
        MeasureError: the plane misses the limb, or its outline is open.
    """
    first = cut_of(subject.anatomy)
    slopes = subject.slopes(lambda one: first.offsets_to(cut_of(one)))
    turned = first.surface_in_frame(subject.sigmas)
    x, y, height = first.through_mm.tolist()
    steps = np.diag(PLANE_STEPS) if slopes else np.empty((0, len(PLANE_STEPS)))
    try:
        level = level_at(turned.mesh, height, (x, y))
        moved_slightly = [
            tuple(first.moved_slightly(*way) for way in (step, -step)) for step in steps
        ]
        neighbours = [
            tuple(one.level_in_frame(one.level(subject.sigmas)) for one in pair)
            for pair in moved_slightly
        ]
    except MeasureError as error:
        place_mm = first.rotation.T @ first.through_mm
        raise with_limb_heights(error, subject.anatomy, place_mm, height) from error
    if slopes:
        neighbours.append(
            tuple(first.level_in_frame(level, aside) for aside in (PLACE_STEP_MM, -PLACE_STEP_MM))
        )
    sizes = [*PLANE_STEPS, PLACE_STEP_MM]
    found: dict[str, Propagated] = {}
    for name, measure in measures.items():
        sloped = measure(first.level_in_frame(level))
        around = [[measure(one).value for one in pair] for pair in neighbours]
        ahead, behind = np.array(around).reshape(-1, 2).T
        by_step = kinked_slopes(ahead, sloped.value, behind, np.array(sizes[: len(around)]))
        figure, gradient = turned.figure(level, sloped), turned.gradient(level, sloped)
        surface = propagate(turned.mesh, gradient) or 0.0
        extra_variance = turned.extremity_variance(level, sloped.reaches)
        relief = math.sqrt(max((figure.sigma or 0.0) ** 2 - surface**2 - extra_variance, 0.0))
        found[name] = Propagated(
            value=sloped.value,
            by_vertex=gradient,
            by_place={place: rows @ by_step for place, rows in slopes.items()},
            lost=(figure.value - sloped.value, relief),
            extra_variance=extra_variance,
        )
    return found


def kinked_slopes(
    ahead: Float64[np.ndarray, " k"],
    here: float | Float64[np.ndarray, " k"],
    behind: Float64[np.ndarray, " k"],
    step: float | Float64[np.ndarray, " k"],
) -> Float64[np.ndarray, " k"]:
    """Slopes of values that may have a kink here, as an extent between places that stand out alike
    or the size of a difference that is zero: where both sides rise or both fall, the steeper one.
    """
    up, down = (ahead - here) / step, (here - behind) / step
    steeper = np.where(np.abs(up) > np.abs(down), up, down)
    return np.where(up * down < 0, steeper, (up + down) / 2)


def with_limb_heights(
    error: MeasureError, anatomy: Anatomy, place_mm: Vector3, height_mm: float
) -> MeasureError:
    """The refusal with its heights converted to heights over the limb frame's origin.

    Args:
        place_mm: A place on the cutting plane, in the mesh's frame.
        height_mm: Its height as the refusal counts heights.
    """
    if anatomy.frame is None:
        return error
    in_limb_mm = float((place_mm - anatomy.origin_mm) @ anatomy.frame[_HEIGHT_AXIS])
    lift_mm = in_limb_mm - height_mm
    values = {
        name: value + lift_mm if name in _HEIGHT_VALUES and isinstance(value, float) else value
        for name, value in error.finding.values.items()
    }
    return MeasureError.of(replace(error.finding, values=values))


_HEIGHT_AXIS = 2
_HEIGHT_VALUES = ("height_mm", "low_mm", "high_mm")
PLANE_STEPS = (PLACE_STEP_MM, TILT_STEP_RAD, TILT_STEP_RAD, TILT_STEP_RAD)
"""Finite-difference steps of `CutPlane.moved_slightly`."""
