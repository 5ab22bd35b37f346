"""The toolpath: roughing in layers, then one finishing pass that follows the surface.

In      a mesh in the limb frame; tool, blank, wanted ridges.
Out     a Toolpath: strips of places of the ball's centre, joined by straight moves of X, A and Z.
Method  the ball stops where it touches the surface (contact.py). Neighbouring ways lie as far
        apart on the offset surface as the ridges allow, along the steepest profile; places on a
        way so close that straight moves keep within the tolerance.
Fails   CarveError: blank or tool too small, or no height at which the surface goes all round.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import OptionsError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import level_segments
from limbgram.workbench.carving.contact import ContactField, sample_surface
from limbgram.workbench.carving.mapping import highest_whole_mm
from limbgram.workbench.carving.setup import (
    DEFAULTS,
    Blank,
    CarveOptions,
    check_mandrel,
    check_options,
    check_reach,
    fit_blank,
)

_PROFILES = 120
"""Profiles along the axis that tell how far apart the ways may lie."""
_PROFILES_DEG = 360.0 / _PROFILES * np.arange(_PROFILES)
_STEEPEST = 98
"""Percentile of the profiles that counts: a fold of the scan must not set the pace."""
_LINKS = 9
"""Places on the way from ring to ring."""


@dataclass(frozen=True, kw_only=True)
class Strip:
    """A continuous cut: a straight move of all axes from each place to the next."""

    x_mm: Float64[np.ndarray, " k"]
    """Along the axis, from the limb frame's origin towards proximal."""
    a_deg: Float64[np.ndarray, " k"]
    """Of the tool round the work, counter-clockwise seen from proximal, 0 at the front."""
    centre_mm: Float64[np.ndarray, " k"]
    """Radius of the ball's centre."""
    name: str
    """Of the pass it belongs to."""


@dataclass(frozen=True, kw_only=True)
class Toolpath:
    """The cuts of a carver, with blank and options."""

    strips: tuple[Strip, ...]
    blank: Blank
    options: CarveOptions
    rings: int
    """Ways of the finishing pass along the axis."""
    low_mm: float
    """Distal end of the shape."""


def plan_toolpath(mesh_in_limb: Mesh, options: CarveOptions = DEFAULTS) -> Toolpath:
    """Plan how to carve a shape from a cylinder."""
    check_options(options)
    ball = options.ball_mm
    low_mm = float(mesh_in_limb.vertices_mm[:, 2].min())
    high_mm = _end_height_mm(mesh_in_limb, options)
    below = mesh_in_limb.vertices_mm[mesh_in_limb.vertices_mm[:, 2] <= high_mm]
    radii = np.hypot(below[:, 0], below[:, 1])
    blank = fit_blank(options, float(radii.max()), low_mm, high_mm)
    end_radius_mm = _radius_at_mm(mesh_in_limb, high_mm)
    if end_radius_mm > blank.radius_mm:  # the end cuts triangles far from their corners
        blank = fit_blank(options, end_radius_mm, low_mm, high_mm)
    check_mandrel(options, radii, below[:, 2] - low_mm)
    # Between samples a ball sinks by c^2 / (2 R), c being the way to the nearest of them.
    sinking = options.tolerance_mm
    spacing_mm = np.sqrt(3 * 2 * ball * sinking)
    field = ContactField.of(sample_surface(mesh_in_limb, spacing_mm))
    finishing = _BallContact(field, options, ball + sinking)
    # The deepest cut is the first one, beyond the distal end: asked before the long work.
    check_reach(options, blank, finishing.deepest_mm(low_mm - ball) - ball)
    rings_mm = finishing.rings(low_mm - ball, high_mm)
    roughing = _BallContact(field, options, ball + options.rough_allowance_mm)
    strips: list[Strip] = []
    for one_pass in [
        *_roughing_passes(roughing, blank, low_mm),
        _finishing_pass(finishing, rings_mm, blank),
    ]:
        at_turn = round(float(strips[-1].a_deg[-1]) / 360) if strips else 0
        strips.append(_strip_of_pass(one_pass, at_turn))
    lowest_mm = min(float(strip.centre_mm.min()) for strip in strips) - ball
    check_reach(options, blank, lowest_mm)
    return Toolpath(
        strips=tuple(strips), blank=blank, options=options, rings=len(rings_mm), low_mm=low_mm
    )


def _radius_at_mm(mesh: Mesh, height_mm: float) -> float:
    """Largest distance of a section from the axis."""
    cut = level_segments(mesh, np.array([height_mm]))
    return float(np.linalg.norm(cut.start_mm, axis=1).max(initial=0.0))


def _end_height_mm(mesh: Mesh, options: CarveOptions) -> float:
    whole_mm = highest_whole_mm(mesh)
    if options.to_mm is None:
        return whole_mm
    low_mm = float(mesh.vertices_mm[:, 2].min())
    least_mm = low_mm + options.ball_mm
    if not least_mm < options.to_mm <= whole_mm:
        raise OptionsError(
            "carve.end.beyond", to_mm=options.to_mm, whole_mm=whole_mm, least_mm=least_mm
        )
    return options.to_mm


@dataclass(frozen=True)
class _BallContact:
    """The contact of a ball of a given radius with the surface."""

    field: ContactField
    options: CarveOptions
    ball_mm: float

    def stops(
        self, x_mm: Float64[np.ndarray, " k"], a_deg: Float64[np.ndarray, " k"]
    ) -> Float64[np.ndarray, " k"]:
        return self.field.stops_mm(x_mm, np.radians(a_deg), self.ball_mm, self.options.floor_mm)

    def deepest_mm(self, x_mm: float) -> float:
        """Least distance of the ball's centre from the axis, at one place along it."""
        return float(self.stops(np.full(_PROFILES, x_mm), _PROFILES_DEG).min())

    def rings(self, from_mm: float, to_mm: float) -> Float64[np.ndarray, " r"]:
        """Places along the axis between which the ball's centre moves by the step-over."""
        count = int((to_mm - from_mm) / (self.options.ball_mm / 16)) + 2
        x_mm = np.linspace(from_mm, to_mm, count)
        grid_x, grid_a = np.meshgrid(x_mm, _PROFILES_DEG, indexing="ij")
        stops = self.stops(grid_x.ravel(), grid_a.ravel()).reshape(grid_x.shape)
        rise = np.percentile(np.abs(np.diff(stops, axis=0)), _STEEPEST, axis=1)
        contact = np.append(0, np.cumsum(np.hypot(np.diff(x_mm), rise)))
        steps = int(np.ceil(contact[-1] / self.options.stepover_mm))
        return np.interp(np.linspace(0, contact[-1], steps + 1), contact, x_mm)


@dataclass(frozen=True)
class _Pass:
    """A pass: what one strip is to cover."""

    contact: _BallContact
    rings_mm: Float64[np.ndarray, " r"]
    """Along the axis, rising."""
    count: int
    """Places on a turn."""
    level_mm: float
    """The ball's centre comes no nearer to the axis."""
    name: str


def _finishing_pass(
    contact: _BallContact, rings_mm: Float64[np.ndarray, " r"], blank: Blank
) -> _Pass:
    count = _places_per_turn(
        contact.options, blank.radius_mm + contact.ball_mm, contact.options.tolerance_mm
    )
    return _Pass(contact, rings_mm, count, 0.0, "finishing")


def _roughing_passes(contact: _BallContact, blank: Blank, low_mm: float) -> list[_Pass]:
    """Roughing layers from the blank's outside to the axis, without rings where nothing is left
    to cut."""
    options = contact.options
    ball = options.ball_mm
    apart_mm = options.rough_stepover * options.tool_diameter_mm
    steps = int(np.ceil((blank.to_mm - (low_mm - ball)) / apart_mm)) + 1
    rings_mm = np.linspace(low_mm - ball, blank.to_mm, steps)
    count = _places_per_turn(options, blank.radius_mm + ball, options.rough_allowance_mm / 4)
    angles = 360.0 / count * np.arange(count)
    grid_x, grid_a = np.meshgrid(rings_mm, angles, indexing="ij")
    lowest = contact.stops(grid_x.ravel(), grid_a.ravel()).reshape(grid_x.shape).min(1)
    layers = int(np.ceil(blank.radius_mm / options.rough_depth_mm))
    passes: list[_Pass] = []
    for layer in range(1, layers + 1):
        level_mm = blank.radius_mm - layer * options.rough_depth_mm + ball
        needed = np.flatnonzero(lowest < level_mm + options.rough_depth_mm)
        for run in np.split(needed, np.flatnonzero(np.diff(needed) > 1) + 1):
            if len(run):
                name = f"roughing {layer} of {layers}"
                passes.append(_Pass(contact, rings_mm[run], count, max(level_mm, 0.0), name))
    return passes


def _places_per_turn(options: CarveOptions, radius_mm: float, tolerance_mm: float) -> int:
    """Number of places on one turn: the chord error of a move of length d at the ball's radius R is
    d^2 / 8R, and over the turn itself no larger."""
    step_mm = np.sqrt(8 * options.ball_mm * tolerance_mm)
    return max(36, int(np.ceil(2 * np.pi * radius_mm / step_mm)))


def _strip_of_pass(one_pass: _Pass, at_turn: int) -> Strip:
    """One strip over all rings, from the turn at which the last one ended."""
    options = one_pass.contact.options
    if options.pattern == "rings":
        return _ring_strip(one_pass, at_turn)
    # A full turn at either end, a ring's distance a turn between.
    course = _helix_course(len(one_pass.rings_mm) + 1, one_pass.count, at_turn, options.most_turns)
    rings = np.arange(len(one_pass.rings_mm))
    x_mm = np.interp(course.done - 1, rings, one_pass.rings_mm)
    a_deg = 360.0 * course.angle
    stops = np.maximum(one_pass.contact.stops(x_mm, a_deg), one_pass.level_mm)
    return Strip(x_mm=x_mm, a_deg=a_deg, centre_mm=stops, name=one_pass.name)


@dataclass(frozen=True)
class _HelixCourse:
    """The course of a helix: progress along the axis and angle, both in turns."""

    done: Float64[np.ndarray, " k"]
    """On the way along the axis."""
    angle: Float64[np.ndarray, " k"]


def _helix_course(turns: int, count: int, start: int, most: int | None) -> _HelixCourse:
    """A helix in one direction, or reversed after a turn in place wherever the angle ends.

    Without that turn the passes before and after it would be two rings' distance apart.
    """
    if most is None:
        done = np.arange(turns * count + 1) / count
        return _HelixCourse(done, start + done)
    sign = 1 if 2 * start <= most else -1
    advances: list[int] = []
    signs: list[int] = []
    at = start
    while sum(advances) < turns:
        room = most - at if sign > 0 else at
        contact = min(room, turns - sum(advances))
        advances += [1] * contact
        signs += [sign] * contact
        at += sign * contact
        if sum(advances) < turns:
            sign = -sign
            advances.append(0)
            signs.append(sign)
            at += sign
    share = np.arange(1, count + 1) / count
    before = np.concatenate([[0], np.cumsum(advances)[:-1]])[:, None]
    angles = start + np.concatenate([[0], np.cumsum(signs)[:-1]])[:, None]
    done = before + np.array(advances)[:, None] * share
    angle = angles + np.array(signs)[:, None] * share
    return _HelixCourse(np.append(0.0, done), np.append(float(start), angle))


def _ring_strip(one_pass: _Pass, at_turn: int) -> Strip:
    """A strip of rings to and fro.

    Links pass over the highest place between two rings: a straight one would cut into a bulge.
    """
    rings_mm, count, contact = one_pass.rings_mm, one_pass.count, one_pass.contact
    turn = np.linspace(0, 360, count + 1)
    there = np.append(turn, np.full(_LINKS, 360.0))
    back = np.append(turn[::-1], np.zeros(_LINKS))
    a_deg = np.where((np.arange(len(rings_mm)) % 2 == at_turn)[:, None], there, back)
    share = np.append(np.zeros(count + 1), np.linspace(0, 1, _LINKS))
    x_mm = rings_mm[:, None] + np.append(np.diff(rings_mm), 0.0)[:, None] * share
    stops = contact.stops(x_mm.ravel(), a_deg.ravel()).reshape(x_mm.shape)
    stops[:, count + 1 :] = stops[:, count + 1 :].max(1, keepdims=True)
    return Strip(
        x_mm=x_mm.ravel(),
        a_deg=a_deg.ravel(),
        centre_mm=np.maximum(stops, one_pass.level_mm).ravel(),
        name=one_pass.name,
    )
