"""The ledger: what each edit did to volume, girths and surface, in figures.

Girths are taken at levels that stay the same for the whole recipe, so lines can be compared.
Displacement is the distance of the new surface from the old one, positive outwards.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from limbgram.core.geometry.smoothing import SMOOTHED_OVER
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.workbench.edits.pressing import away_from, changed_vertices
from limbgram.workbench.edits.regions import moved_by, roughness_mm
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.levels import Refused, contour_mm, levels_at
from limbgram.workbench.recipe.accepting import Concern

_LEVELS = 6
SIGNS = "How far the surface moved: + outward, which gives room; - inward, which gives pressure."
"""Of what is made over the shape, which is a positive."""
_WHOLE_MM = 2 * _LEVELS
"""A shape that is as high has its levels at whole millimetres."""


@dataclass(frozen=True, kw_only=True)
class Figures:
    """A shape in figures."""

    volume_ml: float
    """Of the closed shape; an open brim, or hole, counts as closed by a cone from its middle."""
    girths_mm: tuple[float | None, ...]
    """Along the limb's contour at each level, as it is measured; None where no section is whole."""
    roughness_mm: float
    """How far vertices stand out from their surroundings (RMS)."""


@dataclass(frozen=True, kw_only=True)
class Displacement:
    """How far a surface lies from an earlier one, positive outwards."""

    largest_mm: float
    """The one furthest from 0, with its sign."""
    mean_mm: float
    """Over the new surface, each vertex by its area: the bias of the edit."""
    mean_size_mm: float
    """The same without signs."""
    moved_share: float
    """Part of the new surface's area that moved."""


@dataclass(frozen=True, kw_only=True)
class Line:
    """One edit's entry."""

    number: int
    edit: str
    """The edit in one line."""
    before: Figures
    after: Figures
    displacement: Displacement | None
    """None for a mirror, which moves everything; for a cleaning, which takes away what was no
    limb; and where an edit only added surface beyond an open edge, which lies neither outside the
    old one nor inside."""
    told: tuple[str, ...] = ()
    """What the edit itself has to say: what it took away, or could not do."""
    concerns: tuple[Concern, ...] = ()
    """Where it presses on what bears no pressure, and what of it is unusually deep."""


@dataclass(frozen=True, kw_only=True)
class Ledger:
    """What a recipe did."""

    levels_mm: tuple[float, ...]
    """Heights of the girths: along the limb's axis, or the mesh's z where it is not aligned."""
    lines: tuple[Line, ...]
    places_mm: Mapping[str, float] = field(default_factory=dict[str, float])
    """How far all edits together moved the surface at each sensitive place that is marked, without
    the sock: positive outward, room."""


def choose_levels(limb: Limb) -> tuple[float, ...]:
    """Even heights over the limb, in whole millimetres: measuring there gives the same girths."""
    heights = _upright(limb).vertices_mm[:, 2]
    low, high = float(heights.min()), float(heights.max())
    even = [low + (high - low) * (k + 0.5) / _LEVELS for k in range(_LEVELS)]
    return tuple(float(round(level)) if high - low >= _WHOLE_MM else level for level in even)


def figures_of(limb: Limb, levels_mm: tuple[float, ...]) -> Figures:
    """Volume, girths and roughness."""
    levels = levels_at(_upright(limb), levels_mm)
    return Figures(
        volume_ml=volume_mm3(limb.mesh) / 1000,
        girths_mm=tuple(
            None if isinstance(level, Refused) else contour_mm(level).value for level in levels
        ),
        roughness_mm=roughness_mm(limb.mesh),
    )


def displacement_between(old: Mesh, new: Mesh) -> Displacement:
    """How far the new surface lies from the old."""
    distance = np.zeros(len(new))
    moved = changed_vertices(old, new)
    if moved.any():
        distance[moved] = away_from(old, new.vertices_mm[moved]).signed_mm
    distance[np.abs(distance) < 1e-9] = 0.0
    area = new.vertex_areas_mm2()
    whole = float(area.sum())
    return Displacement(
        largest_mm=float(distance[int(np.argmax(np.abs(distance)))]),
        mean_mm=float((distance * area).sum()) / whole,
        mean_size_mm=float((np.abs(distance) * area).sum()) / whole,
        moved_share=float(area[distance != 0].sum()) / whole,
    )


def lines_of(ledger: Ledger) -> tuple[str, ...]:
    """The ledger for people."""
    texts = [SIGNS] if any(line.displacement is not None for line in ledger.lines) else []
    for line in ledger.lines:
        old, new = line.before, line.after
        change = new.volume_ml - old.volume_ml
        share = change / old.volume_ml * 100 if old.volume_ml else 0.0
        texts.append(f"{line.number}. {line.edit}")
        parts = [f"volume {new.volume_ml:.1f} mL ({change:+.2f} mL, {share:+.3f} %)"]
        if line.displacement is not None:
            d = line.displacement
            parts.append(f"largest {d.largest_mm:+.2f} mm, mean {d.mean_mm:+.4f} mm")
        if abs(new.roughness_mm - old.roughness_mm) > 0.05 * old.roughness_mm:
            parts.append(f"roughness {old.roughness_mm:.3f} -> {new.roughness_mm:.3f} mm")
        texts.append("   " + "; ".join(parts))
        texts += [f"   {sentence}" for sentence in line.told]
        texts += [f"   {concern_line(concern)}" for concern in line.concerns]
        texts.append(
            f"   girths along the contour, {SMOOTHED_OVER}, by height "
            + _girths(ledger.levels_mm, old, new)
        )
    if ledger.places_mm:
        moves = ", ".join(f"{name} {moved:+.1f}" for name, moved in ledger.places_mm.items())
        texts.append(f"All edits together, at places that bear no pressure: {moves} mm")
    return tuple(texts)


def concern_line(concern: Concern) -> str:
    """A concern in a line: what it is, and whether somebody means it."""
    if not concern.word:
        return f"! {concern.what}"
    meant = "accepted" if concern.accepted else "NOT accepted"
    return f"! {concern.what} ({meant}: {concern.word})"


def _girths(levels_mm: tuple[float, ...], old: Figures, new: Figures) -> str:
    parts: list[str] = []
    for level, before, after in zip(levels_mm, old.girths_mm, new.girths_mm, strict=True):
        if after is None:
            parts.append(f"{level:g}: -")
        elif before is None:
            parts.append(f"{level:g}: {after:.1f}")
        else:
            parts.append(f"{level:g}: {after:.1f} ({after - before:+.1f})")
    return ", ".join(parts) + " mm"


def _upright(limb: Limb) -> Mesh:
    if limb.frame is None:
        return limb.mesh
    motion = limb.frame.limb_from_mesh
    return limb.mesh.with_vertices(moved_by(motion, limb.mesh.vertices_mm))
