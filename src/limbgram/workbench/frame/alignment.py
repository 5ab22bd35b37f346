"""Alignment: a limb gets its axes, so that its measures mean what a clinician means by them.

In      a Limb with landmarks, and what the clinician states: side, and what landmarks do not say.
Out     the Limb with its frame, and notes.
Method  Axis, origin and front come from the shape's own file where it has them; else the long axis
        is fitted or stated. Which end is proximal: a statement says it, then the shape's file, then
        landmarks by level, then the open brim; all that say it must agree, and only --axis, which
        is stated exactly, goes over the brim. The limb is turned by the sides on which landmarks
        lie; flexion by two landmarks that lie one above the other in the side view. A wrong side
        is worn, so whatever is known of the limb is compared with what is said of it.
Fails   MeasureError: something is not stated, landmarks or file contradict what is, or the fit is
        no limb's axis.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Int64

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.core.geometry.frames import Rigid, axis_across
from limbgram.core.known_words import require_known_words
from limbgram.core.mesh.axis import Axis, axis_along, fit_axis
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_loops
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.anatomy.kind import Place
from limbgram.workbench.bodies import outer_bodies
from limbgram.workbench.frame.landmarks import (
    known_anywhere,
    known_name,
    landmark,
    likely_meant,
)
from limbgram.workbench.limb import KIND_NAMED, AlignedLimb, KindName, Limb, LimbFrame, Side

_OUTWARD: dict[str, complex] = {"anterior": 1j, "posterior": -1j, "right": 1, "left": -1}
"""In the limb frame, x + i y; medial and lateral follow from the side."""
_SAME_FRONT_DEG = 10.0
_SAME_TILT_DEG, _SAME_PLACE_MM = 0.01, 0.01
_MOST_LEAN_DEG = 45.0
"""Largest lean of the line between the plumb landmarks before the limb is turned by it."""
_SMALL_OPENING_SHARE = 0.25
"""Of the largest opening: pieces of a ragged brim are larger, and holes left by a scanner smaller.
"""
_BRIM_WIDTH_SHARE = 0.5
"""Share of the limb's width; a narrower opening is a hole."""


_MOST_CONTRADICTION_DEG = 60.0
"""Landmarks further than this from the side on which their names lie are contradicted, and so
is a file by another front."""
_MOST_CONTRADICTION_BENT_DEG = 100.0
"""The same where the limb bends: a navicular lies as far in front of the shank as beside it."""
_MOST_OFF_AXIS_DEG = 45.0
"""A fitted axis further than this from what is stated to be proximal is not the limb's."""
_MOST_FLEXION_DEG = 120.0
_NEAR_AXIS_MM = 15.0
"""Landmarks nearer to the axis than this lie on no side of it."""
_ROUNDING = 1e-9
"""A stated front so near to the file's own is that one, to the last bit."""


@dataclass(frozen=True, kw_only=True)
class AlignOptions:
    """What the clinician states. Directions are in the mesh's frame."""

    side: Side
    kind: KindName | None = None
    """Which names tell what; None for the kind that the limb is known to be, if it is."""
    axis: Vector3 | None = None
    """Long axis, pointing proximally, in place of the fit; the brim does not overrule it."""
    fit_anew: bool = False
    """Fit the long axis, and turn by landmarks, although the shape's own file has its axes."""
    proximal: Vector3 | None = None
    """Roughly towards the body, where landmarks and brim do not tell."""
    anterior: Vector3 | None = None
    """Roughly forwards, in place of landmarks."""
    plumb: tuple[str, str] | None = None
    """Upper and lower landmark that shall lie one above the other in the side view."""
    flexion_deg: float = 0.0
    """Turned further about the side-to-side axis; positive takes the proximal end backwards."""
    declared: LimbFrame | None = None
    """What the shape's own file says, as an AOP does: never overruled in side or proximal end, and

    its axis and origin are kept unless an axis is stated or to be fitted."""

    def __post_init__(self) -> None:
        require_known_words(self)

    @property
    def kept(self) -> LimbFrame | None:
        """The frame of the shape's own file, where nothing takes its axis away."""
        return self.declared if self.axis is None and not self.fit_anew else None


def align(limb: Limb, options: AlignOptions) -> AlignedLimb:
    """Align a limb: the same limb frame wherever the mesh was lying.

    Raises:
        MeasureError: proximal or anterior is not told, or told in contradiction; the file holds
            several limbs.
        OptionsError: a direction or an angle that cannot be meant.
    """
    require_side_of_file(options)
    _require_directions(options)
    found = outer_bodies(limb.mesh)
    found.require_one_limb()
    whole = replace(limb, kind=options.kind or limb.kind)
    limb = whole.with_mesh(found.mesh)
    options = _with_landmark_axes(limb, options)
    axis = _long_axis(limb, options)
    up, notes = proximal_direction(limb, axis, options)
    frame = _limb_frame(limb, axis, _rotation_to_limb(up, limb, axis, options), options)
    notes += side_change_findings(limb, options) + front_change_findings(frame, options)
    angle = _flexion_rad(limb, frame, options)
    if angle:
        tilt = Rigid.from_rotation_vector(np.array([angle, 0.0, 0.0]), np.zeros(3))
        frame = _limb_frame(limb, axis, tilt.rotation @ frame.rotation, options)
    notes += axis_change_findings(frame, options)
    require_landmarks_agree(limb, frame, options)
    noted = replace(whole, notes=(*limb.notes, *notes, *odd_name_findings(limb)))
    return noted.with_frame(LimbFrame(limb_from_mesh=frame, side=options.side))


def _with_landmark_axes(limb: Limb, options: AlignOptions) -> AlignOptions:
    """The options with axes by landmarks, for kinds without a long axis such as a foot or head.

    What the clinician or the shape's own file states goes before it.
    """
    kind = None if limb.kind is None else KIND_NAMED[limb.kind]
    stated = options.axis is not None or options.declared is not None or options.fit_anew
    if kind is None or kind.upright is None or stated:
        return options
    try:
        up, forward = limb.axis(kind.upright.up), limb.axis(kind.upright.forward)
    except MeasureError:  # a landmark lacks: the axis has to be stated, which says so
        return options
    if options.proximal is not None and options.proximal @ up.direction < 0:
        raise MeasureError("align.proximal.against_landmarks")
    anterior = forward.direction if options.anterior is None else options.anterior
    return replace(options, axis=up.direction, anterior=anterior)


def proximal_direction(
    limb: Limb, axis: Axis, options: AlignOptions
) -> tuple[Vector3, tuple[Finding, ...]]:
    """The axis's direction towards the body, and findings about it."""
    stated = axis.direction if options.axis is not None else options.proximal
    of_file = None if options.declared is None else options.declared.limb_from_mesh.rotation[2]
    if options.axis is None:
        _require_along_limb(limb, axis, stated if stated is not None else of_file)
    said, rise, brim = (
        _cosine_to_axis(stated, axis),
        _rise_of_landmarks(limb, axis),
        _brim_side(limb, axis) if limb.kind is None or KIND_NAMED[limb.kind].long else 0.0,
    )
    told = said or _cosine_to_axis(of_file, axis)
    if said * _cosine_to_axis(of_file, axis) < 0:
        raise MeasureError("align.proximal.against_file")
    if told * rise < 0:
        raise MeasureError("align.proximal.against_landmarks")
    sense = told or rise
    if sense * brim < 0:
        return _direction_against_brim(axis, options, "landmarks" if not told else "statement")
    sense = sense or brim
    if not sense:
        raise MeasureError("align.proximal.untold")
    return np.sign(sense) * axis.direction, ()


def front_change_findings(frame: Rigid, options: AlignOptions) -> tuple[Finding, ...]:
    """A doubt if the front differs from that of the shape's own file.

    Raises:
        MeasureError: it differs too far.
    """
    if options.declared is None or not options.declared.front_told:
        return ()
    x, y, _ = frame.rotation @ options.declared.limb_from_mesh.rotation[1]
    off_deg = _angle_between_deg(complex(x, y), 1j)
    if off_deg > _MOST_CONTRADICTION_DEG:
        raise MeasureError("align.front.against_file", off_deg=off_deg)
    if off_deg < _SAME_FRONT_DEG:
        return ()
    return (doubt("align.front.off_file", off_deg=off_deg),)


def axis_change_findings(frame: Rigid, options: AlignOptions) -> tuple[Finding, ...]:
    """A note if the axis or the origin of the shape's own file was not kept."""
    if options.declared is None:
        return ()
    own = options.declared.limb_from_mesh
    tilted_deg = float(np.degrees(np.arccos(min(float(frame.rotation[2] @ own.rotation[2]), 1.0))))
    x, y, z = frame.apply(own.inverse.translation[None])[0]
    if tilted_deg < _SAME_TILT_DEG and max(abs(x), abs(y), abs(z)) < _SAME_PLACE_MM:
        return ()
    return (
        note(
            "align.axis.not_kept",
            tilted_deg=tilted_deg,
            beside_mm=float(np.hypot(x, y)),
            along_mm=float(z),
        ),
    )


def require_side_of_file(options: AlignOptions) -> None:
    """Refuse another side than the shape's own file names.

    Raises:
        MeasureError: with both sides.
    """
    declared = options.declared
    if declared is None or declared.side in ("none", options.side):
        return
    raise MeasureError("align.side.of_file", of_file=declared.side, side=options.side)


def require_landmarks_agree(limb: Limb, frame: Rigid, options: AlignOptions) -> None:
    """Refuse a side, or an anterior direction, that the landmarks contradict.

    Raises:
        MeasureError: a landmark lies far from the side on which places of its name lie, whether
            or not anybody says what kind of limb it is.
    """
    long = limb.kind is None or KIND_NAMED[limb.kind].long
    most_deg = _MOST_CONTRADICTION_DEG if long else _MOST_CONTRADICTION_BENT_DEG
    for mark in limb.landmarks:
        expected = expected_direction(known_anywhere(mark.name, limb.kind), options.side)
        x, y, _ = frame.apply(mark.position_mm[None])[0]
        if not expected or abs(complex(x, y)) < _NEAR_AXIS_MM:
            continue
        off_deg = _angle_between_deg(complex(x, y), expected)
        if off_deg > most_deg:
            raise MeasureError(
                "align.landmark.elsewhere",
                name=mark.name,
                off_deg=off_deg,
                side=options.side,
                right_mm=float(x),
                anterior_mm=float(y),
            )


def _require_directions(options: AlignOptions) -> None:
    """Refuse a stated direction that has no length, or is none in numbers.

    Raises:
        OptionsError: says which.
    """
    stated = {
        "axis": options.axis,
        "proximal": options.proximal,
        "anterior": options.anterior,
    }
    for option, given in stated.items():
        if given is not None and not 0 < float(np.linalg.norm(given)) < np.inf:
            text = ",".join(f"{value:g}" for value in given)
            raise OptionsError("options.no_direction", text=text, option=option)


def side_change_findings(limb: Limb, options: AlignOptions) -> tuple[Finding, ...]:
    """A doubt if the limb was aligned for another side before."""
    if limb.side in ("none", options.side):
        return ()
    return (doubt("align.side.changed", before=limb.side, side=options.side),)


def odd_name_findings(limb: Limb) -> tuple[Finding, ...]:
    """Doubts about landmarks whose names nearly match a known place."""
    meant = ((mark.name, likely_meant(mark.name, limb.kind)) for mark in limb.landmarks)
    return tuple(
        doubt("landmark.odd_name", name=name, meant=other)
        for name, other in meant
        if other is not None
    )


def expected_direction(known: Place | None, side: Side) -> complex:
    """Direction from the axis in which a landmark should lie, x + i y; 0 if unknown."""
    if known is None:
        return 0
    if known.facing in ("medial", "lateral"):
        lateral = {"right": 1, "left": -1, "none": 0}[side]
        return lateral if known.facing == "lateral" else -lateral
    direction = _OUTWARD.get(known.facing, 0) + _OUTWARD.get(known.half, 0)
    return direction / abs(direction) if direction else 0


def _long_axis(limb: Limb, options: AlignOptions) -> Axis:
    """The long axis: the file's own, as stated, or fitted."""
    if options.kept is not None:
        motion = options.kept.limb_from_mesh
        origin_mm = motion.inverse.translation
        return Axis(point_mm=origin_mm, direction=motion.rotation[2], spread_mm=0.0)
    if options.axis is not None:
        return axis_along(limb.mesh, options.axis)
    return fit_axis(limb.mesh)


def _limb_frame(limb: Limb, axis: Axis, rotation: Matrix3, options: AlignOptions) -> Rigid:
    """The limb frame of a rotation, with its origin on the axis: the file's, or the distal end."""
    if options.kept is not None:
        motion = options.kept.limb_from_mesh
        if np.array_equal(rotation, motion.rotation):
            return motion
        return Rigid(rotation, -rotation @ axis.point_mm)
    distal = float((limb.mesh.vertices_mm @ rotation[2]).min())
    x, y, _ = rotation @ axis.point_mm
    return Rigid(rotation, -np.array([x, y, distal]))


def _rotation_to_limb(up: Vector3, limb: Limb, axis: Axis, options: AlignOptions) -> Matrix3:
    """Rotation to the limb frame: as stated, as in the file, or with landmarks on their sides."""
    if options.kept is not None and options.kept.front_told and options.anterior is None:
        return options.kept.limb_from_mesh.rotation
    start = _any_rotation_with_up(up)
    if options.anterior is not None:
        forward = start @ options.anterior
        if np.hypot(forward[0], forward[1]) < 0.1 * np.linalg.norm(options.anterior):
            raise OptionsError("align.front.along_axis")
        turned = _about_z(np.pi / 2 - np.arctan2(forward[1], forward[0])) @ start
        if options.kept is not None:
            own = options.kept.limb_from_mesh.rotation
            return own if np.abs(turned - own).max() < _ROUNDING else turned
        return turned
    turn = _turn_by_landmarks(start, limb, axis, options)
    if abs(turn) < 1e-6 and options.declared is not None:
        if not options.declared.front_told:
            raise MeasureError("align.front.left_open")
        x, y, _ = start @ options.declared.limb_from_mesh.rotation[1]
        turn = 1j * np.conj(complex(x, y))
    if abs(turn) < 1e-6:
        raise MeasureError("align.front.untold")
    return _about_z(float(np.angle(turn))) @ start


def _any_rotation_with_up(up: Vector3) -> Matrix3:
    """Any rotation whose third row is `up`."""
    unit = up / np.linalg.norm(up)
    x = np.cross(axis_across(unit), unit)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(unit, x), unit])


def _about_z(angle_rad: float) -> Matrix3:
    return Rigid.from_rotation_vector(np.array([0.0, 0.0, angle_rad]), np.zeros(3)).rotation


def _turn_by_landmarks(start: Matrix3, limb: Limb, axis: Axis, options: AlignOptions) -> complex:
    """The turn about z that brings landmarks to the sides expected by their names."""
    turn = 0j
    if limb.kind is None:
        return turn
    for mark in limb.landmarks:
        expected = expected_direction(known_name(mark.name, limb.kind), options.side)
        x, y, _ = start @ (mark.position_mm - axis.point_mm)
        turn += expected * np.conj(complex(x, y))
    return turn


def _flexion_rad(limb: Limb, frame: Rigid, options: AlignOptions) -> float:
    """Turn about x that brings the plumb landmarks over each other, plus the flexion asked for."""
    if not abs(options.flexion_deg) <= _MOST_FLEXION_DEG:
        raise OptionsError(
            "align.flexion", flexion_deg=options.flexion_deg, most_deg=_MOST_FLEXION_DEG
        )
    angle = np.radians(options.flexion_deg)
    if options.plumb is not None:
        upper, lower = (landmark(limb, name).position_mm for name in options.plumb)
        _, y, z = frame.rotation @ (upper - lower)
        if not np.degrees(np.arctan2(abs(y), z)) < _MOST_LEAN_DEG:
            raise MeasureError(
                "align.plumb",
                upper=options.plumb[0],
                lower=options.plumb[1],
                most_deg=_MOST_LEAN_DEG,
            )
        angle += float(np.arctan2(y, z))
    return float(angle)


def _require_along_limb(limb: Limb, axis: Axis, told: Vector3 | None) -> None:
    """Refuse a fitted axis across the proximal direction, as one from heel to toe."""
    if told is None:
        if limb.kind is not None and not KIND_NAMED[limb.kind].long:
            raise MeasureError("align.axis.foot")
        return
    off_deg = np.degrees(np.arccos(min(abs(_cosine_to_axis(told, axis)), 1.0)))
    if off_deg > _MOST_OFF_AXIS_DEG:
        raise MeasureError(
            "align.axis.across",
            off_deg=float(off_deg),
            along=_as_typed_option(axis.direction),
            axis=_as_typed_option(told),
        )


def _cosine_to_axis(direction: Vector3 | None, axis: Axis) -> float:
    """Cosine between a direction and the axis; 0 if there is none."""
    if direction is None:
        return 0.0
    return float(direction @ axis.direction / np.linalg.norm(direction))


def _as_typed_option(direction: Vector3) -> str:
    """A direction as it is typed for an option."""
    unit = direction / np.linalg.norm(direction)
    return ",".join(f"{value + 0.0:.4g}" for value in np.round(unit, 4))


def _rise_of_landmarks(limb: Limb, axis: Axis) -> float:
    """Positive if landmarks of a higher level lie further along the axis."""
    if limb.kind is None:
        return 0.0
    found = ((mark, known_name(mark.name, limb.kind)) for mark in limb.landmarks)
    marks = [(mark, known.level) for mark, known in found if known is not None]
    levels = np.array([level for _, level in marks], np.float64)
    heights = np.array([mark.position_mm @ axis.direction for mark, _ in marks])
    rise = np.subtract.outer(levels, levels) * np.subtract.outer(heights, heights)
    return float(rise.sum())


def _brim_side(limb: Limb, axis: Axis) -> float:
    """Positive if the open brim, or the part that no photo saw, lies at the far end of the axis.

    A hole is no brim: a brim is about as wide as the limb, and small openings do not count beside
    a large one.
    """
    mesh = limb.mesh
    edge = mesh.vertices_mm[_large_openings(mesh)]
    if not len(edge) and mesh.filled is not None:
        edge = mesh.vertices_mm[mesh.filled]
    if not len(edge) or _width_mm(edge, axis) < _BRIM_WIDTH_SHARE * _width_mm(
        mesh.vertices_mm, axis
    ):
        return 0.0
    along = mesh.vertices_mm @ axis.direction
    share = float((edge @ axis.direction > (along.min() + along.max()) / 2).mean())
    return 1.0 if share > 0.9 else -1.0 if share < 0.1 else 0.0


def _large_openings(mesh: Mesh) -> Int64[np.ndarray, " k"]:
    """Vertices on the open edges, without those round openings much smaller than the largest."""
    loops = boundary_loops(mesh.faces)
    if not loops:
        return np.zeros(0, np.int64)
    across_mm = [float(np.linalg.norm(np.ptp(mesh.vertices_mm[loop], axis=0))) for loop in loops]
    least_mm = _SMALL_OPENING_SHARE * max(across_mm)
    large = [loop for loop, size_mm in zip(loops, across_mm, strict=True) if size_mm >= least_mm]
    return np.concatenate(large).astype(np.int64)


def _width_mm(points: Points3, axis: Axis) -> float:
    """RMS distance of points from their centroid, across the axis."""
    off = points - points.mean(0)
    return float(np.linalg.norm(off - np.outer(off @ axis.direction, axis.direction))) / np.sqrt(
        len(points)
    )


def _direction_against_brim(
    axis: Axis, options: AlignOptions, by: Literal["landmarks", "statement"]
) -> tuple[Vector3, tuple[Finding, ...]]:
    """The stated axis, although the shape is open at its distal end; else a refusal."""
    if options.axis is not None:
        return axis.direction, (doubt("align.axis.opening"),)
    raise MeasureError(
        "align.open_distal",
        by=by,
        axis=_as_typed_option(axis.direction),
        other=_as_typed_option(-axis.direction),
    )


def _angle_between_deg(one: complex, other: complex) -> float:
    return float(abs(np.degrees(np.angle(one * np.conj(other)))))
