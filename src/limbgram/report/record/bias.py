"""Bias: what each step on the way adds to a radius, in millimetres.

A bias shifts all radii one way (positive: outwards); what is typical and what is largest goes both
ways. 0.25 mm of radius is what a socket's fit can show. None stands for what nobody knows, and the
line says why.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from limbgram.core.errors import CarveError
from limbgram.core.interval import rms
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import with_faces
from limbgram.findings import Finding, note
from limbgram.report.record.sources import CaseSource
from limbgram.workbench.carving.mapping import MapOptions, map_radii
from limbgram.workbench.carving.slab import clip_between_heights, distance_to, volume_between_mm3
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.measuring import Measures
from limbgram.workbench.recipe.ledger import Ledger

_KEEPS_SHAPE = "smoothing"
"""The edit that is meant to change nothing but wrinkles."""
_FLAT_MM = 1e-6


@dataclass(frozen=True, kw_only=True)
class Bias:
    """The bias of one step."""

    step: str
    bias_mm: float | None
    """Mean shift of the surface."""
    typical_mm: float | None
    """Root mean square of what single places go, one way or the other."""
    largest_mm: float | None
    """The farthest that a place goes."""
    volume_share: float | None
    """Change of volume that goes with it, as a fraction."""
    basis: Finding
    """Where the figures come from, or why there are none."""


def biases(
    measures: Measures,
    mesh_in_limb: Mesh,
    case: CaseSource | None,
    ledger: Ledger | None,
    inside: Measures | None = None,
) -> tuple[Bias, ...]:
    """Biases of scale, surface, sock, smoothing, and the export formats.

    Radii of a wall are those of its inside: the areas of its outside are of its material.
    """
    radius_mm = mean_radius_mm(measures if inside is None else inside)
    return (
        _scale_bias(case, radius_mm),
        _surface_bias(measures.limb.mesh, case),
        _sock_bias(measures.limb, radius_mm),
        *_smoothing_bias(ledger),
        _stl_bias(mesh_in_limb),
        _aop_bias(mesh_in_limb),
        _unknown_bias("carving", note("record.bias.carving")),
    )


def mean_radius_mm(measures: Measures) -> float:
    """Mean radius of circles with the areas of the sections; NaN without a section."""
    radii = [row.figures["radius_mm"] for row in measures.rows]
    found = [figure.value for figure in radii if figure is not None]
    return float(np.mean(found)) if found else math.nan


def _scale_bias(case: CaseSource | None, radius_mm: float) -> Bias:
    if case is None:
        return _unknown_bias("scale", note("record.bias.scale.no_case"))
    lengths = case.accuracy.lengths
    if not lengths.check or lengths.check_rms is None or lengths.check_worst is None:
        return _unknown_bias("scale", note("record.bias.scale.unchecked"))
    worst = abs(lengths.check_worst)
    return Bias(
        step="scale",
        bias_mm=None,
        typical_mm=lengths.check_rms * radius_mm,
        largest_mm=worst * radius_mm,
        volume_share=None,
        basis=note(
            "record.bias.scale.checked",
            lengths=len(lengths.check),
            worst_per_cent=100 * worst,
            radius_mm=radius_mm,
        ),
    )


def _surface_bias(mesh: Mesh, case: CaseSource | None) -> Bias:
    if case is not None:
        expected = case.accuracy.expected
        return Bias(
            step="surface",
            bias_mm=None,
            typical_mm=expected.rms_mm,
            largest_mm=None,
            volume_share=None,
            basis=note("record.bias.surface.expected", of=expected.basis),
        )
    known = None if mesh.sigma_mm is None else mesh.sigma_mm[np.isfinite(mesh.sigma_mm)]
    if known is None or not len(known):
        return _unknown_bias("surface", note("record.bias.surface.unknown"))
    return Bias(
        step="surface",
        bias_mm=None,
        typical_mm=rms(known.astype(np.float64)),
        largest_mm=None,
        volume_share=None,
        basis=note("record.bias.surface.own"),
    )


def _sock_bias(limb: Limb, radius_mm: float) -> Bias:
    tenth = 100 * 2 * 0.1 / radius_mm
    if limb.sock_mm:
        return Bias(
            step="sock taken off",
            bias_mm=-limb.sock_mm,
            typical_mm=None,
            largest_mm=None,
            volume_share=None,
            basis=note("record.bias.sock.off", volume_per_cent=tenth),
        )
    return Bias(
        step="sock taken off",
        bias_mm=0.0,
        typical_mm=None,
        largest_mm=None,
        volume_share=None,
        basis=note("record.bias.sock.none", volume_per_cent=tenth),
    )


def _smoothing_bias(ledger: Ledger | None) -> Iterator[Bias]:
    for line in () if ledger is None else ledger.lines:
        if not line.edit.startswith(_KEEPS_SHAPE) or line.displacement is None:
            continue
        volume = line.volume
        yield Bias(
            step=f"smoothing (edit {line.number})",
            bias_mm=line.displacement.mean_mm,
            typical_mm=None,
            largest_mm=abs(line.displacement.largest_mm),
            volume_share=volume.after_ml / volume.before_ml - 1
            if volume is not None and volume.before_ml
            else None,
            basis=note("record.bias.smoothing", mean_mm=line.displacement.mean_size_mm),
        )


def _stl_bias(mesh: Mesh) -> Bias:
    rounding = float(np.spacing(np.float32(np.abs(mesh.vertices_mm).max(initial=1.0)))) / 2
    return Bias(
        step="leaving as STL",
        bias_mm=0.0,
        typical_mm=None,
        largest_mm=rounding,
        volume_share=None,
        basis=note("record.bias.stl"),
    )


def _aop_bias(mesh: Mesh) -> Bias:
    options = MapOptions()
    step = "leaving as AOP"
    try:
        mapped = map_radii(mesh, options)
    except CarveError as error:
        return _unknown_bias(step, note("record.bias.aop.cannot", reason=error.finding))
    found = mapped.radius_map
    ends_mm = mapped.first_mm, mapped.first_mm + float(found.z_mm[-1])
    part = _without_lids(clip_between_heights(mesh, *ends_mm), ends_mm)
    surface = found.surface()
    held = surface.with_vertices(surface.vertices_mm + np.array([0.0, 0.0, mapped.first_mm]))
    away = distance_to(part, held)
    of_limb, of_file = volume_between_mm3(part), volume_between_mm3(held)
    normals = part.face_normals()
    upright_mm2 = float(np.hypot(normals[:, 0], normals[:, 1]).sum()) / 2
    return Bias(
        step=step,
        bias_mm=(of_file - of_limb) / upright_mm2,
        typical_mm=away.rms_mm,
        largest_mm=away.max_mm,
        volume_share=of_file / of_limb - 1,
        basis=note("record.bias.aop", spokes=options.spokes, spacing_mm=options.spacing_mm),
    )


def _without_lids(part: Mesh, ends_mm: tuple[float, float]) -> Mesh:
    """The part without what lies flat in its end planes: a radius map ends there."""
    heights = part.vertices_mm[part.faces][:, :, 2]
    lids = [(np.abs(heights - end) < _FLAT_MM).all(1) for end in ends_mm]
    return with_faces(part, part.faces[~(lids[0] | lids[1])])


def _unknown_bias(step: str, why: Finding) -> Bias:
    return Bias(
        step=step, bias_mm=None, typical_mm=None, largest_mm=None, volume_share=None, basis=why
    )
