"""Alignment: a limb gets its axes, so that its measures mean what a clinician means by them.

In      a Limb with landmarks, and what the clinician states: side, and what landmarks do not tell.
Out     the Limb with its frame.
Method  long axis by fit or as stated; which end is proximal by landmarks, a statement, or the open
        brim; flexion by two landmarks that lie one above the other in the side view; rotation by
        the sides on which landmarks lie.
Fails   MeasureError: something is not told, or the landmarks contradict the side.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from limbgram.errors import MeasureError, OptionsError
from limbgram.geometry.arrays import Matrix3, Vector3
from limbgram.geometry.rigid import Rigid
from limbgram.shape.bodies import outer_bodies
from limbgram.shape.frame.axis import Axis, AxisOptions, axis_along, fit_axis
from limbgram.shape.frame.landmarks import Facing, Kind, known_names, landmark
from limbgram.shape.limb import Landmark, Limb, LimbFrame, Side
from limbgram.surface.topology import boundary_half_edges

_OUTWARD: dict[Facing, complex] = {"anterior": 1j, "posterior": -1j, "right": 1, "left": -1}
"""In the limb frame, x + i y; medial and lateral follow from the side."""


@dataclass(frozen=True, kw_only=True)
class AlignOptions:
    """What the clinician states. Directions are in the mesh's frame."""

    side: Side
    kind: Kind | None = None
    """Which names tell what; None for a limb whose landmarks tell nothing."""
    axis: Vector3 | None = None
    """Long axis, pointing proximally, in place of the fit."""
    proximal: Vector3 | None = None
    """Roughly towards the body, where landmarks and brim do not tell."""
    anterior: Vector3 | None = None
    """Roughly forwards, in place of landmarks."""
    plumb: tuple[str, str] | None = None
    """Upper and lower landmark that shall lie one above the other in the side view."""
    flexion_deg: float = 0.0
    """Turned further about the side-to-side axis; positive takes the proximal end backwards."""
    most_contradiction_deg: float = 60.0
    """Landmarks further than this from the side on which their names lie are contradicted."""
    near_axis_mm: float = 15.0
    """Landmarks nearer to the axis than this lie on no side of it."""
    fit: AxisOptions = field(default_factory=AxisOptions)


def align(limb: Limb, options: AlignOptions) -> Limb:
    """The limb with its frame: the same limb frame wherever the mesh was lying.

    Raises:
        MeasureError: proximal or anterior is not told, or told in contradiction.
    """
    found = outer_bodies(limb.mesh)
    found.require_one_limb()
    whole, limb = limb, limb.with_mesh(found.mesh)
    axis = (
        fit_axis(limb.mesh, options.fit)
        if options.axis is None
        else axis_along(limb.mesh, options.axis, options.fit)
    )
    up = _proximal(limb, axis, options)
    frame = _frame(limb, axis.point_mm, _turned_about(up, limb, axis, options))
    angle = _flexion_rad(limb, frame, options)
    if angle:
        tilt = Rigid.from_rotation_vector(np.array([angle, 0.0, 0.0]), np.zeros(3))
        frame = _frame(limb, axis.point_mm, tilt.rotation @ frame.rotation)
    _require_agreement(limb, frame, options)
    return replace(whole, frame=LimbFrame(limb_from_mesh=frame, side=options.side))


def _proximal(limb: Limb, axis: Axis, options: AlignOptions) -> Vector3:
    """The axis's direction, pointing to the body."""
    stated = options.proximal if options.axis is None else axis.direction
    sense = 0.0 if stated is None else float(stated @ axis.direction)
    rise = _rise_of_landmarks(limb, axis, options)
    if sense * rise < 0:
        raise MeasureError(
            "The landmarks lie the other way up than --axis or --proximal says. Check which is "
            "wrong; the template of names orders them from distal to proximal."
        )
    sense = sense or rise
    if not sense:
        sense = _brim_side(limb, axis)
    if not sense:
        raise MeasureError(
            "Nothing tells which end of the limb is proximal: it has no landmarks at different "
            "levels and no open brim at one end. Say it by --proximal, such as --proximal +z."
        )
    return np.sign(sense) * axis.direction


def _rise_of_landmarks(limb: Limb, axis: Axis, options: AlignOptions) -> float:
    """Positive if landmarks of higher level lie further along the axis."""
    known = known_names(options.kind) if options.kind else {}
    marks = [mark for mark in limb.landmarks if mark.name in known]
    levels = np.array([known[mark.name].level for mark in marks], np.float64)
    heights = np.array([mark.position_mm @ axis.direction for mark in marks])
    rise = np.subtract.outer(levels, levels) * np.subtract.outer(heights, heights)
    return float(rise.sum())


def _brim_side(limb: Limb, axis: Axis) -> float:
    """Positive if the open brim, or the part that no photo saw, lies at the far end of the axis."""
    mesh = limb.mesh
    along = mesh.vertices_mm @ axis.direction
    border = along[boundary_half_edges(mesh.faces)[:, 0]]
    if not len(border) and mesh.filled is not None:
        border = along[mesh.filled]
    middle = (along.min() + along.max()) / 2
    share = float((border > middle).mean()) if len(border) else 0.5
    return 1.0 if share > 0.9 else -1.0 if share < 0.1 else 0.0


def _turned_about(up: Vector3, limb: Limb, axis: Axis, options: AlignOptions) -> Matrix3:
    """Rotation to the limb frame, with the landmarks on the sides where they belong."""
    start = _across(up)
    if options.anterior is not None:
        forward = start @ options.anterior
        if np.hypot(forward[0], forward[1]) < 0.1 * np.linalg.norm(options.anterior):
            raise OptionsError(
                "The anterior direction runs along the limb's axis. State one that points "
                "forwards, such as --anterior +y."
            )
        return _about_z(np.pi / 2 - np.arctan2(forward[1], forward[0])) @ start
    turn = 0j
    for mark in limb.landmarks:
        outward = _outward(mark, options)
        x, y, _ = start @ (mark.position_mm - axis.point_mm)
        turn += outward * np.conj(complex(x, y))
    if abs(turn) < 1e-6:
        raise MeasureError(
            "Nothing tells where the front of the limb is: it has no landmark of known side. "
            "Pick one, such as the tibial crest or the fibula head, and say --kind; or state the "
            "direction by --anterior, such as --anterior +y."
        )
    return _about_z(float(np.angle(turn))) @ start


def _outward(mark: Landmark, options: AlignOptions) -> complex:
    """Direction in the limb frame in which a landmark should lie from the axis; 0 if untold."""
    known = known_names(options.kind) if options.kind else {}
    if mark.name not in known:
        return 0
    facing = known[mark.name].facing
    if facing in ("medial", "lateral"):
        lateral = {"right": 1, "left": -1, "none": 0}[options.side]
        return lateral if facing == "lateral" else -lateral
    return _OUTWARD.get(facing, 0)


def _flexion_rad(limb: Limb, frame: Rigid, options: AlignOptions) -> float:
    """Turn about x that brings the plumb landmarks over each other, and what is asked on top."""
    if not np.isfinite(options.flexion_deg):
        raise OptionsError("The flexion is no number of degrees. Give one, or leave it out.")
    angle = np.radians(options.flexion_deg)
    if options.plumb is not None:
        upper, lower = (landmark(limb, name).position_mm for name in options.plumb)
        _, y, z = frame.rotation @ (upper - lower)
        if not z > abs(y):
            raise MeasureError(
                f"Landmark {options.plumb[0]!r} does not lie above {options.plumb[1]!r}: the line "
                "between them leans by more than 45 degrees. Swap them, or choose others."
            )
        angle += float(np.arctan2(y, z))
    return float(angle)


def _require_agreement(limb: Limb, frame: Rigid, options: AlignOptions) -> None:
    """Refuse a side, or an anterior direction, that the landmarks contradict."""
    for mark in limb.landmarks:
        outward = _outward(mark, options)
        x, y, _ = frame.apply(mark.position_mm[None])[0]
        if not outward or abs(complex(x, y)) < options.near_axis_mm:
            continue
        off_deg = abs(np.degrees(np.angle(complex(x, y) * np.conj(outward))))
        if off_deg > options.most_contradiction_deg:
            raise MeasureError(
                f"Landmark {mark.name!r} lies {off_deg:.0f} degrees from where it belongs on a "
                f"limb of side {options.side!r}. The side is wrong, the landmark lies in another "
                "place, or the shape is mirrored. Check them before anything is made from it."
            )


def _frame(limb: Limb, on_axis_mm: Vector3, rotation: Matrix3) -> Rigid:
    """Limb frame of a rotation, its origin on the axis at the distal end."""
    distal = float((limb.mesh.vertices_mm @ rotation[2]).min())
    x, y, _ = rotation @ on_axis_mm
    return Rigid(rotation, -np.array([x, y, distal]))


def _across(up: Vector3) -> Matrix3:
    """Some rotation whose third row is `up`."""
    unit = up / np.linalg.norm(up)
    other = np.eye(3)[int(np.abs(unit).argmin())]
    x = np.cross(other, unit)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(unit, x), unit])


def _about_z(angle_rad: float) -> Matrix3:
    return Rigid.from_rotation_vector(np.array([0.0, 0.0, angle_rad]), np.zeros(3)).rotation
