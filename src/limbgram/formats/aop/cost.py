"""Cost: how far the shape in an AOP file differs from the limb between the same heights.

At the rounded tip slices meet the surface obliquely: a girth there changes by many millimetres with
a little height, and says nothing of the fit. The cap, up to where radii grow no faster than the
height, has figures of its own.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.notebook import brief
from limbgram.formats.aop.reading import AopReading
from limbgram.workbench.bodies import OuterShape, SeparateBody
from limbgram.workbench.carving.mapping import MappedSurface
from limbgram.workbench.carving.slab import (
    SurfaceDistance,
    clip_between_heights,
    distance_to,
    volume_between_mm3,
)


@dataclass(frozen=True, kw_only=True)
class GirthLevel:
    """One slice above the cap at which every ray crosses the surface once."""

    height_mm: float
    """In the frame of the file's axis."""
    limb_mm: float
    file_mm: float

    @property
    def change_mm(self) -> float:
        return self.file_mm - self.limb_mm


@dataclass(frozen=True, kw_only=True)
class DistalCap:
    """The rounded end, where girths mean little."""

    to_mm: float
    """Height above the first slice."""
    max_mm: float
    """Largest distance from the limb's surface to the file's."""
    volume_change_ml: float


@dataclass(frozen=True, kw_only=True)
class AopReport:
    """An AOP file compared with the limb between the same heights."""

    path: Path
    spokes: int
    slices: int
    height_mm: float
    max_mm: float
    """Largest distance from the limb's surface to the file's, the cap included."""
    rms_mm: float
    volume_ml: float
    """In the file."""
    volume_change: float
    """Fraction of the limb's."""
    above_cap_max_mm: float
    girths: tuple[GirthLevel, ...]
    cap: DistalCap | None
    """None where the wall is steep from the first slice on."""
    mapped: MappedSurface
    axis_from_limb: Rigid
    """The motion to the file's axis; the identity unless another axis was fitted."""
    bodies_left_out: int
    """Bodies inside the limb, such as bones, and loose ones beside it."""
    loose: tuple[SeparateBody, ...]
    """Those beside it, in the limb frame."""
    held: AopReading
    """The file as it was read back."""

    __repr__ = brief

    @property
    def worst_girth(self) -> GirthLevel | None:
        return max(self.girths, key=lambda level: abs(level.change_mm), default=None)

    @property
    def girth_change(self) -> float:
        """Mean, as a fraction."""
        changes = [level.change_mm / level.limb_mm for level in self.girths]
        return float(np.mean(changes)) if changes else 0.0


def cost_of(
    path: Path,
    mesh: Mesh,
    mapped: MappedSurface,
    held: AopReading,
    axis_from_limb: Rigid,
    outside: OuterShape,
) -> AopReport:
    """Compare the file as it was read back with the mesh, which is in the frame of its axis."""
    radius_map = held.radius_map
    top_mm = mapped.first_mm + float(radius_map.z_mm[-1])
    file = radius_map.surface()
    file = file.with_vertices(file.vertices_mm + np.array([0.0, 0.0, mapped.first_mm]))
    cap_end = _end_of_cap(radius_map.radii_mm, radius_map.z_mm)
    cap_mm = float(radius_map.z_mm[cap_end])
    above, limb_mm3 = _compared(mesh, file, mapped.first_mm + cap_mm, top_mm)
    whole, file_mm3, cap = above, volume_between_mm3(file), None
    if cap_end:
        heights_mm = mapped.first_mm, mapped.first_mm + cap_mm
        in_cap, limb_cap_mm3 = _compared(mesh, file, *heights_mm)
        whole, limb_mm3 = above | in_cap, limb_mm3 + limb_cap_mm3
        file_cap_mm3 = volume_between_mm3(clip_between_heights(file, *heights_mm))
        cap = DistalCap(
            to_mm=cap_mm,
            max_mm=in_cap.max_mm,
            volume_change_ml=(file_cap_mm3 - limb_cap_mm3) / 1000,
        )
    return AopReport(
        path=path,
        spokes=len(radius_map.thetas_deg),
        slices=len(radius_map.z_mm),
        height_mm=float(radius_map.z_mm[-1]),
        max_mm=whole.max_mm,
        rms_mm=whole.rms_mm,
        volume_ml=file_mm3 / 1000,
        volume_change=file_mm3 / limb_mm3 - 1,
        above_cap_max_mm=above.max_mm,
        girths=_girths(mapped, held, cap_end),
        cap=cap,
        mapped=mapped,
        axis_from_limb=axis_from_limb,
        bodies_left_out=outside.bodies_left_out,
        loose=outside.loose,
        held=held,
    )


def _compared(
    mesh: Mesh, file: Mesh, low_mm: float, high_mm: float
) -> tuple[SurfaceDistance, float]:
    """Distance of the limb between two heights from the file's surface, and its volume in mm3."""
    part = clip_between_heights(mesh, low_mm, high_mm)
    return distance_to(part, file), volume_between_mm3(part)


def _end_of_cap(radii_mm: Float64[np.ndarray, "m n"], z_mm: Float64[np.ndarray, " m"]) -> int:
    """Index of the first slice from which the mean radius grows no faster than the height.

    Only the lower half can be a cap; a slope of 45 degrees further up is the limb's own.
    """
    grows = np.diff(radii_mm, axis=0).mean(1) > np.diff(z_mm)
    lower = np.flatnonzero(grows & (z_mm[1:] < z_mm[-1] / 2))
    return int(lower[-1]) + 1 if len(lower) else 0


def _girths(mapped: MappedSurface, held: AopReading, first: int) -> tuple[GirthLevel, ...]:
    """Girths of complete slices; without the last, which touches the brim and may be open."""
    complete: Bool[np.ndarray, " m"] = mapped.whole & (mapped.girths_mm > 0)
    rows = [row for row in np.flatnonzero(complete[:-1]).tolist() if row >= first]
    heights_mm = mapped.first_mm + held.radius_map.z_mm
    file_girths_mm = held.radius_map.girths_mm()
    return tuple(
        GirthLevel(
            height_mm=float(heights_mm[row]),
            limb_mm=float(mapped.girths_mm[row]),
            file_mm=float(file_girths_mm[row]),
        )
        for row in rows
    )
