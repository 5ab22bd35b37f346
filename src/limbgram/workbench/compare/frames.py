"""Frames: the axes in which two shapes are compared, the first one's."""

from dataclasses import dataclass

import numpy as np

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.frames import Rigid, axis_across
from limbgram.core.mesh.axis import fit_axis
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_half_edges
from limbgram.findings import Finding, doubt
from limbgram.workbench import bodies
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.limb import AlignedLimb, Limb


@dataclass(frozen=True, kw_only=True)
class Axes:
    """The frame of a comparison, and what it is based on."""

    limb_from_mesh: Rigid
    anatomical: bool
    """True if the clinician aligned the limb, so that front and right mean something."""
    doubt: Finding | None


def axes_of(limb: Limb) -> Axes:
    """The limb's own frame, or a fitted long axis, or at least the file's z axis."""
    if isinstance(limb, AlignedLimb):
        return Axes(limb_from_mesh=limb.limb_from_mesh, anatomical=True, doubt=None)
    try:
        return Axes(
            limb_from_mesh=_fitted_frame(limb),
            anatomical=False,
            doubt=doubt("compare.axes.fitted", name=limb.name),
        )
    except MeasureError as error:
        low, high = limb.mesh.vertices_mm.min(0), limb.mesh.vertices_mm.max(0)
        foot = np.array([*(low + high)[:2] / 2, low[2]])
        return Axes(
            limb_from_mesh=Rigid(np.eye(3), -foot),
            anatomical=False,
            doubt=doubt("compare.axes.of_file", name=limb.name, reason=error.finding),
        )


def outside_by_name(limb: Limb) -> Limb:
    """The limb without bodies inside it or loose beside it, and notes of them."""
    name = limb.name or "a shape"
    return bodies.outside_of(limb, name)


def mesh_in_frame(mesh: Mesh, limb_from_mesh: Rigid) -> Mesh:
    return mesh.moved(limb_from_mesh)


def brim_height_mm(mesh_in_limb: Mesh) -> float:
    """Height of the lowest place of the open brim; of the top where the surface is closed there."""
    heights = mesh_in_limb.vertices_mm[:, 2]
    border = heights[boundary_half_edges(mesh_in_limb.faces)[:, 0]]
    upper = border[border > (heights.min() + heights.max()) / 2]
    return float(upper.min(initial=heights.max()))


def _fitted_frame(limb: Limb) -> Rigid:
    direction = fit_axis(limb.mesh).direction
    return align(limb, AlignOptions(side="none", anterior=axis_across(direction))).limb_from_mesh
