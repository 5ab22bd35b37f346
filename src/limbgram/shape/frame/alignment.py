"""Alignment: a limb gets its axes, so that its measures mean what a clinician means by them.

In      a Limb with landmarks, and what the clinician states: side, and what landmarks do not tell.
Out     the Limb with its frame.
Method  axis, origin and front of the shape's own file where it has them; else the long axis by fit
        or as stated; which end is proximal; rotation by the sides on which landmarks lie. Flexion
        by two landmarks that lie one above the other in the side view.
Fails   MeasureError: something is not told, or landmarks or file contradict what is.
"""

from dataclasses import replace

import numpy as np

from limbgram.errors import MeasureError, OptionsError
from limbgram.geometry.arrays import Matrix3, Vector3
from limbgram.geometry.rigid import Rigid
from limbgram.shape.bodies import outer_bodies
from limbgram.shape.frame.agreement import (
    front_of_file,
    moved_from_file,
    odd_names,
    other_side_before,
    require_landmarks_agree,
    require_side_of_file,
)
from limbgram.shape.frame.axis import Axis, axis_along, fit_axis
from limbgram.shape.frame.landmarks import known_name, landmark
from limbgram.shape.frame.proximal import proximal_of
from limbgram.shape.frame.stated import AlignOptions, outward
from limbgram.shape.limb import Limb, LimbFrame


def align(limb: Limb, options: AlignOptions) -> Limb:
    """The limb with its frame: the same limb frame wherever the mesh was lying.

    Raises:
        MeasureError: proximal or anterior is not told, or told in contradiction; the file holds
            several limbs.
        OptionsError: a direction or an angle that cannot be meant.
    """
    require_side_of_file(options)
    found = outer_bodies(limb.mesh)
    found.require_one_limb()
    whole = replace(limb, kind=options.kind or limb.kind)
    limb = whole.with_mesh(found.mesh)
    axis = _axis(limb, options)
    up, notes = proximal_of(limb, axis, options)
    frame = _frame(limb, axis, _turned_about(up, limb, axis, options), options)
    notes += other_side_before(limb, options) + front_of_file(frame, options)
    angle = _flexion_rad(limb, frame, options)
    if angle:
        tilt = Rigid.from_rotation_vector(np.array([angle, 0.0, 0.0]), np.zeros(3))
        frame = _frame(limb, axis, tilt.rotation @ frame.rotation, options)
    notes += moved_from_file(frame, options)
    require_landmarks_agree(limb, frame, options)
    return replace(
        whole,
        frame=LimbFrame(limb_from_mesh=frame, side=options.side),
        notes=(*limb.notes, *notes, *odd_names(limb)),
    )


def _axis(limb: Limb, options: AlignOptions) -> Axis:
    """The file's own, as stated, or by fit."""
    if options.kept is not None:
        motion = options.kept.limb_from_mesh
        origin_mm = motion.inverse.translation
        return Axis(point_mm=origin_mm, direction=motion.rotation[2], spread_mm=0.0)
    if options.axis is not None:
        return axis_along(limb.mesh, options.axis, options.fit)
    return fit_axis(limb.mesh, options.fit)


def _turned_about(up: Vector3, limb: Limb, axis: Axis, options: AlignOptions) -> Matrix3:
    """Rotation to the limb frame: as stated, as the file has it, or with the landmarks on the

    sides where they belong."""
    if options.kept is not None and options.anterior is None:
        return options.kept.limb_from_mesh.rotation
    start = _across(up)
    if options.anterior is not None:
        forward = start @ options.anterior
        if np.hypot(forward[0], forward[1]) < 0.1 * np.linalg.norm(options.anterior):
            raise OptionsError(
                "The anterior direction runs along the limb's axis. State one that points "
                "forwards, such as --anterior +y."
            )
        return _about_z(np.pi / 2 - np.arctan2(forward[1], forward[0])) @ start
    turn = _turn_by_landmarks(start, limb, axis, options)
    if abs(turn) < 1e-6 and options.declared is not None:
        x, y, _ = start @ options.declared.limb_from_mesh.rotation[1]
        turn = 1j * np.conj(complex(x, y))
    if abs(turn) < 1e-6:
        raise MeasureError(
            "Nothing tells where the front of the limb is: it has no landmark of known side. "
            "Pick one, such as the tibial crest or the fibula head, and say --kind; or state the "
            "direction by --anterior, such as --anterior +y."
        )
    return _about_z(float(np.angle(turn))) @ start


def _turn_by_landmarks(start: Matrix3, limb: Limb, axis: Axis, options: AlignOptions) -> complex:
    """The turn about z that brings the landmarks to where names of the limb's kind lie."""
    turn = 0j
    if limb.kind is None:
        return turn
    for mark in limb.landmarks:
        expected = outward(known_name(mark.name, limb.kind), options.side)
        x, y, _ = start @ (mark.position_mm - axis.point_mm)
        turn += expected * np.conj(complex(x, y))
    return turn


def _flexion_rad(limb: Limb, frame: Rigid, options: AlignOptions) -> float:
    """Turn about x that brings the plumb landmarks over each other, and what is asked on top."""
    if not abs(options.flexion_deg) <= options.most_flexion_deg:
        raise OptionsError(
            f"A flexion of {options.flexion_deg:g} degrees cannot be meant. Give degrees from "
            f"{-options.most_flexion_deg:g} to {options.most_flexion_deg:g}, or leave it out."
        )
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


def _frame(limb: Limb, axis: Axis, rotation: Matrix3, options: AlignOptions) -> Rigid:
    """Limb frame of a rotation, its origin on the axis: that of the file, or at the distal end."""
    if options.kept is not None:
        motion = options.kept.limb_from_mesh
        if np.array_equal(rotation, motion.rotation):
            return motion
        return Rigid(rotation, -rotation @ axis.point_mm)
    distal = float((limb.mesh.vertices_mm @ rotation[2]).min())
    x, y, _ = rotation @ axis.point_mm
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
