"""Adapter: the plate of a modular prosthesis under a socket, and the block that joins both.

Method  The line of reference leads from the middle of the socket, half way up, straight down. The
        socket leans against it as the joint above flexes: below a knee its upper end forwards, as
        the end of a shank goes backwards; below a hip backwards, as that of a thigh goes forwards.
        Adduction takes the upper end outwards. The plate lies square to the line; the foot's
        direction is the limb's front as seen along the line, turned outwards about it by toe-out;
        inset moves the plate medially. The order of turns does not matter: the line has both slopes
        at once.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import unit
from limbgram.workbench.devices.blocks import RoundCone
from limbgram.workbench.devices.body import Body
from limbgram.workbench.devices.device import FlexedJoint
from limbgram.workbench.devices.fittings import Part, hole, plate, pyramid
from limbgram.workbench.devices.shell import Layout

_TAPER_SHARE = 0.35
"""Share of the socket's height over which its end tapers towards the plate."""
_OVERLAP_MM = 2.0
"""The block reaches this far into the plate, so that both are one solid."""
_BLOCK_SHARE = 0.95
"""Radius of the block at the plate, as a share of the plate's half width."""


@dataclass(frozen=True, kw_only=True)
class Alignment:
    """The alignment of a socket over its plate."""

    flexion_deg: float
    adduction_deg: float
    toe_out_deg: float
    inset_mm: float
    limb_from_plate: Rigid
    """Of the plate: origin in the middle of its lower face, Z up the reference line, Y as the
    foot goes."""


@dataclass(frozen=True, kw_only=True)
class Adapter:
    """An adapter: its alignment, the block towards the socket, and the plate's parts."""

    alignment: Alignment
    block: RoundCone
    parts: tuple[Part, ...]


def adapter_under(
    body: Body, layout: Layout, values: Mapping[str, float], joint: FlexedJoint
) -> Adapter:
    """The adapter under a socket.

    Args:
        joint: The one above the socket, which flexes.

    Raises:
        EditError: nobody said which side the limb is of.
    """
    out = body.lateral()
    up, ahead = _reference_line(values, joint, out)
    turn = np.radians(values["toe_out_deg"])
    sideways = unit((out - (out @ up) * up)[None])[0]
    square = unit((sideways - (sideways @ ahead) * ahead)[None])[0]
    foot = np.cos(turn) * ahead + np.sin(turn) * square
    covered = layout.positive.vertices_mm[layout.beyond_mm < 0]
    thickest_mm = float(layout.thickness_mm[layout.beyond_mm < 0].max())
    low, high = float(covered[:, 2].min()), float(covered[:, 2].max())
    middle = body.section_centre_mm(low + 0.5 * (high - low))
    top = float((covered @ up).min()) - thickest_mm - values["build_mm"]
    place = middle + (top - middle @ up) * up
    place = place - values["inset_mm"] * sideways + values["forward_mm"] * ahead
    origin = place - values["plate_height_mm"] * up
    motion = Rigid(np.column_stack([np.cross(foot, up), foot, up]), origin)
    inner = body.section_centre_mm(low + _TAPER_SHARE * (high - low))
    near = np.abs(covered[:, 2] - inner[2]) < 0.05 * (high - low)
    inner_radius = float(np.linalg.norm((covered[near] - inner)[:, :2], axis=1).min())
    block = RoundCone(
        start_mm=place - _OVERLAP_MM * up,
        end_mm=inner,
        start_radius_mm=0.5 * _BLOCK_SHARE * values["plate_mm"],
        end_radius_mm=inner_radius,
        floor=up,
    )
    alignment = Alignment(
        flexion_deg=values["flexion_deg"],
        adduction_deg=values["adduction_deg"],
        toe_out_deg=values["toe_out_deg"],
        inset_mm=values["inset_mm"],
        limb_from_plate=motion,
    )
    return Adapter(alignment=alignment, block=block, parts=_parts(motion, values, thickest_mm))


def _parts(
    limb_from_plate: Rigid, values: Mapping[str, float], thickest_mm: float
) -> tuple[Part, ...]:
    """The plate, the pyramid and the pilot hole, as far as they are asked for.

    Args:
        thickest_mm: Largest thickness of the wall that the pilot hole goes through.
    """
    up, origin = limb_from_plate.rotation[:, 2], limb_from_plate.translation
    parts = plate(
        limb_from_plate,
        width_mm=values["plate_mm"],
        height_mm=values["plate_height_mm"],
        hole_mm=values["hole_mm"],
    )
    if values["pyramid_mm"] > 0:
        parts = (*parts, pyramid(limb_from_plate, values["pyramid_mm"]))
    if values["pilot_mm"] > 0:
        deep_mm = values["plate_height_mm"] + values["build_mm"] + thickest_mm + 12.0
        drilled = hole(
            "pilot hole",
            origin + 0.5 * (deep_mm - values["pyramid_mm"]) * up,
            up,
            diameter_mm=values["pilot_mm"],
            depth_mm=0.5 * (deep_mm + values["pyramid_mm"]) + 1.0,
        )
        parts = (*parts, drilled)
    return parts


def _reference_line(
    values: Mapping[str, float], joint: FlexedJoint, out: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors up the alignment reference line, and forwards square to it."""
    flexed = np.radians(values["flexion_deg"])
    back = np.tan(flexed if joint == "knee" else -flexed)
    inwards = np.tan(np.radians(values["adduction_deg"]))
    up = unit((np.array([0.0, -back, 1.0]) - inwards * out)[None])[0]
    forward = np.array([0.0, 1.0, 0.0])
    return up, unit((forward - (forward @ up) * up)[None])[0]
