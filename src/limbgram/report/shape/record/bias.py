"""Bias: what each step on the way adds to a radius, in millimetres.

A bias shifts all radii one way (positive: outwards), a spread goes both ways. 0.25 mm of radius
is what a socket's fit can show. None stands for what nobody knows, and the line says why.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from limbgram.carving import MapOptions, map_radii
from limbgram.carving.slab import clipped, distance_to, volume_between_mm3
from limbgram.errors import CarveError
from limbgram.report.shape.record.sources import CaseSource
from limbgram.shape.limb import Limb
from limbgram.shape.measures import Measures
from limbgram.shape.recipe import Ledger
from limbgram.surface.mesh import Mesh

_KEEPS_SHAPE = "smoothing"
"""The edit that is meant to change nothing but wrinkles."""


@dataclass(frozen=True, kw_only=True)
class Bias:
    """One step's line."""

    step: str
    bias_mm: float | None
    """Mean shift of the surface."""
    spread_mm: float | None
    """How far single places go, one way or the other; `basis` says in which sense."""
    volume_share: float | None
    """Change of volume that goes with it, as a fraction."""
    basis: str
    """Where the figures come from, or why there are none."""


def biases(
    measures: Measures, mesh_in_limb: Mesh, case: CaseSource | None, ledger: Ledger | None
) -> tuple[Bias, ...]:
    """Scale, surface, sock, smoothing, and the formats in which the shape may leave."""
    radius_mm = mean_radius_mm(measures)
    return (
        _scale(case, radius_mm),
        _surface(measures.limb.mesh, case),
        _sock(measures.limb, radius_mm),
        *_smoothing(ledger),
        _stl(mesh_in_limb),
        _aop(mesh_in_limb),
        Bias(
            step="carving",
            bias_mm=None,
            spread_mm=None,
            volume_share=None,
            basis="depends on tool and feed: `limbgram export --to gcode` carves the file by "
            "simulation and tells gouge and ridges",
        ),
    )


def mean_radius_mm(measures: Measures) -> float:
    """Of the circles that have the areas of the sections; NaN without a section."""
    radii = [row.figures["radius_mm"] for row in measures.rows]
    found = [figure.value for figure in radii if figure is not None]
    return float(np.mean(found)) if found else math.nan


def _scale(case: CaseSource | None, radius_mm: float) -> Bias:
    if case is None:
        return _unknown("scale", "no case is named: --case tells how it was checked")
    lengths = case.accuracy["lengths"]
    if not lengths["check"]:
        return _unknown("scale", "no length checked it that had not set it")
    worst, rms = abs(lengths["check_worst"]), lengths["check_rms"]
    return Bias(
        step="scale",
        bias_mm=None,
        spread_mm=worst * radius_mm,
        volume_share=None,
        basis=f"worst of {len(lengths['check'])} check lengths is off by {worst:.3%} (RMS "
        f"{rms:.3%}), taken at the mean radius of {radius_mm:.0f} mm; volume up to {3 * worst:.2%}",
    )


def _surface(mesh: Mesh, case: CaseSource | None) -> Bias:
    truth: dict[str, Any] | None = None if case is None else case.accuracy["truth"]
    if truth is not None:
        return Bias(
            step="surface from the photos",
            bias_mm=truth["mean_mm"],
            spread_mm=truth["rms_mm"],
            volume_share=truth["volume_error"],
            basis="compared with a truth (mean, and RMS)",
        )
    if case is not None:
        expected = case.accuracy["expected"]
        return Bias(
            step="surface from the photos",
            bias_mm=None,
            spread_mm=expected["rms_mm"],
            volume_share=None,
            basis=f"expected RMS, from the {expected['basis']}; the bias is not known without a "
            "truth",
        )
    known = None if mesh.sigma_mm is None else mesh.sigma_mm[np.isfinite(mesh.sigma_mm)]
    if known is None or not len(known):
        return _unknown(
            "surface as scanned", "the shape carries no uncertainty and no case is named"
        )
    return Bias(
        step="surface as scanned",
        bias_mm=None,
        spread_mm=float(np.sqrt(np.mean(known.astype(np.float64) ** 2))),
        volume_share=None,
        basis="RMS of the vertices' own standard deviations",
    )


def _sock(limb: Limb, radius_mm: float) -> Bias:
    tenth = 2 * 0.1 / radius_mm
    if limb.sock_mm:
        return Bias(
            step="sock taken off",
            bias_mm=-limb.sock_mm,
            spread_mm=None,
            volume_share=None,
            basis="done to the surface; a thickness that is 0.1 mm wrong leaves 0.1 mm on every "
            f"radius and {tenth:.1%} of volume",
        )
    return Bias(
        step="sock taken off",
        bias_mm=0.0,
        spread_mm=None,
        volume_share=None,
        basis="none was taken off: what was worn is in every radius, each 0.1 mm of it "
        f"{tenth:.1%} of volume",
    )


def _smoothing(ledger: Ledger | None) -> Iterator[Bias]:
    for line in () if ledger is None else ledger.lines:
        if not line.edit.startswith(_KEEPS_SHAPE) or line.displacement is None:
            continue
        before = line.before.volume_ml
        yield Bias(
            step=f"smoothing (edit {line.number})",
            bias_mm=line.displacement.mean_mm,
            spread_mm=abs(line.displacement.largest_mm),
            volume_share=line.after.volume_ml / before - 1 if before else None,
            basis=f"mean and largest move of the surface; mean size "
            f"{line.displacement.mean_size_mm:.3f} mm",
        )


def _stl(mesh: Mesh) -> Bias:
    rounding = float(np.spacing(np.float32(np.abs(mesh.vertices_mm).max(initial=1.0)))) / 2
    return Bias(
        step="leaving as STL",
        bias_mm=0.0,
        spread_mm=rounding,
        volume_share=None,
        basis="rounding of its 32-bit numbers, at most",
    )


def _aop(mesh: Mesh) -> Bias:
    options = MapOptions()
    step = "leaving as AOP"
    try:
        mapped = map_radii(mesh, options)
    except CarveError as error:
        return _unknown(step, f"it cannot: {error}")
    found = mapped.radius_map
    part = clipped(mesh, mapped.first_mm, mapped.first_mm + float(found.z_mm[-1]))
    surface = found.surface()
    held = surface.with_vertices(surface.vertices_mm + np.array([0.0, 0.0, mapped.first_mm]))
    away = distance_to(part, held)
    of_limb, of_file = volume_between_mm3(part), volume_between_mm3(held)
    area_mm2 = float(np.linalg.norm(part.face_normals(), axis=1).sum()) / 2
    return Bias(
        step=step,
        bias_mm=(of_file - of_limb) / area_mm2,
        spread_mm=away.max_mm,
        volume_share=of_file / of_limb - 1,
        basis=f"{options.spokes} spokes every {options.spacing_mm:g} mm: mean, and the farthest "
        f"place (RMS {away.rms_mm:.3f} mm)",
    )


def _unknown(step: str, why: str) -> Bias:
    return Bias(step=step, bias_mm=None, spread_mm=None, volume_share=None, basis=why)
