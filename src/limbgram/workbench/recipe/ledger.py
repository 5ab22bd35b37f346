"""The ledger: what each edit did to volume, girths and surface, in figures.

Girths are taken at levels that stay the same for the whole recipe, so lines can be compared: those
of a measuring table with `SPACING_MM`, and for each edit the height where it moved most. Volumes
before and after an edit are those between the same two heights, between which neither surface is
open, nor closed by the cover of a cut: what is cut away is no change of volume. A wall encloses its
material and no longer the limb: it has no volume to compare, and all edits together are told up to
it; its girths are those of the skin that touches the limb. Displacement is the distance of the new
surface from the old one, positive outwards.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.smoothed_length import SMOOTHED_OVER
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3, with_faces
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.findings import LANGUAGES, Finding, told
from limbgram.workbench.edits.cutting import ON_CUT_MM
from limbgram.workbench.edits.pressing import changed_vertices, same_triangles, signed_offsets
from limbgram.workbench.edits.regions import roughness_mm, upright_mm
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.levels import (
    DISTAL_END,
    PROXIMAL_END,
    Refused,
    Sigmas,
    Volumes,
    contour_mm,
    levels_at,
)
from limbgram.workbench.measures.measured_skin import inner_faces
from limbgram.workbench.recipe.consent import Concern

SPACING_MM = 20.0
"""Between levels."""
_LEAST_LEVELS = 3
SIGNS = "How far the surface moved: + outward, which gives room; - inward, which gives pressure."
"""Of what is made over the shape, which is a positive."""


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
    largest_at: int
    """The vertex of the new surface that moved most."""


@dataclass(frozen=True, kw_only=True)
class Extreme:
    """The girth where an edit moved the surface most."""

    height_mm: float
    before_mm: float | None
    after_mm: float | None


@dataclass(frozen=True, kw_only=True)
class VolumeChange:
    """Volumes between the same two heights; None stands for an end of the limb."""

    low_mm: float | None
    high_mm: float | None
    before_ml: float
    after_ml: float


@dataclass(frozen=True, kw_only=True)
class Line:
    """The ledger's entry of one edit."""

    number: int
    edit: str
    """The edit in one line."""
    before: Figures
    after: Figures
    volume: VolumeChange | None
    """None where no span of heights is closed in both, and for what `becomes` another thing."""
    extreme: Extreme | None
    """None where nothing moved, or where the displacement is not told."""
    displacement: Displacement | None
    """None for a mirror, which moves everything; for a cleaning, which takes away what was no
    limb; for a cut and a wall, whose new surface is no skin that moved; and where an edit only
    added surface beyond an open edge, which lies neither outside the old one nor inside."""
    told: tuple[Finding, ...] = ()
    """What the edit itself has to say: what it took away, or could not do."""
    concerns: tuple[Concern, ...] = ()
    """Where it presses on what bears no pressure, and what of it is unusually deep."""
    becomes: bool = False
    """Whether the shape is another thing after it, as a wall is none of the limb's surface."""


@dataclass(frozen=True, kw_only=True)
class Ledger:
    """What the edits of a recipe did, in figures."""

    levels_mm: tuple[float, ...]
    """Heights of the girths: along the limb's axis, or the mesh's z where it is not aligned."""
    lines: tuple[Line, ...]
    volume: VolumeChange | None = None
    """Of all edits together, up to what made another thing of the shape, such as a wall."""
    places_mm: Mapping[str, float] = field(default_factory=dict[str, float])
    """How far all edits together moved the surface at each sensitive place that is marked, without
    the sock: positive outward, room. Where they press within its reach, the deepest place counts,
    else its landmark."""


def choose_levels(limb: Limb) -> tuple[float, ...]:
    """The heights of a measuring table; even ones on a shape that is too low for three of them."""
    heights = upright(limb).vertices_mm[:, 2]
    low, high = float(heights.min()), float(heights.max())
    table = np.arange(np.ceil(low / SPACING_MM), np.floor(high / SPACING_MM) + 1) * SPACING_MM
    within = table[(table > low) & (table < high)]
    if len(within) < _LEAST_LEVELS:
        within = low + (high - low) * (np.arange(2 * _LEAST_LEVELS) + 0.5) / (2 * _LEAST_LEVELS)
    return tuple(within.tolist())


def girth_mm(limb: Limb, height_mm: float, wall: Wall | None = None) -> float | None:
    """The contour girth at a height; None where no section is closed."""
    return _skin_girths_mm(limb, (height_mm,), wall)[0]


def _skin_girths_mm(
    limb: Limb, levels_mm: Sequence[float], wall: Wall | None
) -> tuple[float | None, ...]:
    """Girths of the skin that touches the limb: of a wall that was made outwards, its inside.

    A wall that goes round no hollow, as a half shell, shows no girth of its inside.
    """
    mesh = upright(limb)
    if wall is not None and wall.side == "outward":
        inner = inner_faces(mesh)
        if not inner.any():
            return (None,) * len(levels_mm)
        mesh = with_faces(mesh, mesh.faces[inner][:, ::-1].copy())
    return _contour_girths_mm(mesh, levels_mm)


def _contour_girths_mm(mesh: Mesh, levels_mm: Sequence[float]) -> tuple[float | None, ...]:
    """Contour girths as in a measuring table."""
    sigmas = Sigmas.of(mesh)
    return tuple(
        None if isinstance(level, Refused) else sigmas.figure(level, contour_mm(level)).value
        for level in levels_at(mesh, levels_mm)
    )


def extreme_girth(
    before: Limb, after: Limb, moved: Displacement | None, wall: Wall | None = None
) -> Extreme | None:
    """The girth where an edit moved most."""
    if moved is None or moved.largest_mm == 0:
        return None
    height_mm = round(float(upright(after).vertices_mm[moved.largest_at, 2]), 1)
    return Extreme(
        height_mm=height_mm,
        before_mm=girth_mm(before, height_mm, wall),
        after_mm=girth_mm(after, height_mm, wall),
    )


def cut_cover(before: Limb, after: Limb) -> Points3 | None:
    """Vertices of the cap that closed a cut; None where it was left open."""
    corners = after.mesh.vertices_mm[after.mesh.faces]
    off_mm = tree_on(before.mesh).closest(corners.mean(1)).distances_mm
    ids = np.unique(after.mesh.faces[off_mm > ON_CUT_MM])
    return after.mesh.vertices_mm[ids] if len(ids) else None


def covers_after(covers: Sequence[Points3], before: Limb, after: Limb) -> tuple[Points3, ...]:
    """Caps after an edit that moved the shape but kept its triangles, as turning a joint does."""
    if not covers or not same_triangles(before.mesh, after.mesh):
        return tuple(covers)
    tree = KDTree(before.mesh.vertices_mm)
    return tuple(after.mesh.vertices_mm[tree.query(one)[1]] for one in covers)


def cover_spans_mm(limb: Limb, covers: Sequence[Points3]) -> tuple[tuple[float, float], ...]:
    """The range of heights of each cap."""
    motion = limb.known_limb_from_mesh
    placed = covers if motion is None else [motion.apply(one) for one in covers]
    return tuple((float(one[:, 2].min()), float(one[:, 2].max())) for one in placed)


def volume_change(
    before: Limb, after: Limb, covers_mm: Sequence[tuple[float, float]] = ()
) -> VolumeChange | None:
    """Volumes between two heights between which neither surface is open, or covered.

    Args:
        covers_mm: Lowest and highest place of each cover of a cut that was made between.
    """
    old, new = Volumes.of(Sigmas.of(upright(before))), Volumes.of(Sigmas.of(upright(after)))
    tips_mm = [float(one.lowest.min()) for one in (old, new)]
    tops_mm = [float(one.sorted_tops[-1]) for one in (old, new)]
    open_mm = np.concatenate([old.open_edges, new.open_edges, np.reshape(covers_mm, (-1, 2))])
    open_mm = open_mm[np.argsort(open_mm[:, 0])]
    starts = np.concatenate([[min(tips_mm)], np.maximum.accumulate(open_mm[:, 1])])
    stops = np.concatenate([open_mm[:, 0], [max(tops_mm)]])
    both = np.minimum(stops, min(tops_mm)) - np.maximum(starts, max(tips_mm))
    longest = int(np.argmax(both))
    if both[longest] <= 0:
        return None
    low = DISTAL_END if longest == 0 else float(starts[longest])
    high = PROXIMAL_END if longest == len(open_mm) else float(stops[longest])
    volumes_ml = [_volume_ml(one, low, high) for one in (old, new)]
    return VolumeChange(
        low_mm=low if np.isfinite(low) else None,
        high_mm=high if np.isfinite(high) else None,
        before_ml=volumes_ml[0],
        after_ml=volumes_ml[1],
    )


def _volume_ml(volumes: Volumes, low_mm: float, high_mm: float) -> float:
    """Volume between two heights; beyond a closed end there is none."""
    low_mm = DISTAL_END if low_mm < volumes.lowest.min() else low_mm
    high_mm = PROXIMAL_END if high_mm > volumes.sorted_tops[-1] else high_mm
    return volumes.between(low_mm, high_mm).value / 1000


def figures_of(
    limb: Limb,
    levels_mm: tuple[float, ...],
    covers_mm: Sequence[tuple[float, float]] = (),
    wall: Wall | None = None,
) -> Figures:
    """Volume, girths and roughness; a level that runs through a cut's cover has no girth.

    Args:
        wall: The edit that made a wall of the shape.
    """
    girths_mm = tuple(
        None if any(low < level < high for low, high in covers_mm) else girth
        for level, girth in zip(levels_mm, _skin_girths_mm(limb, levels_mm, wall), strict=True)
    )
    return Figures(
        volume_ml=volume_mm3(limb.mesh) / 1000,
        girths_mm=girths_mm,
        roughness_mm=roughness_mm(limb.mesh),
    )


def displacement_between(old: Mesh, new: Mesh) -> Displacement:
    """How far the new surface lies from the old."""
    distance = np.zeros(len(new))
    moved = changed_vertices(old, new)
    if moved.any():
        distance[moved] = signed_offsets(old, new.vertices_mm[moved]).signed_mm
    distance[np.abs(distance) < 1e-9] = 0.0
    area = new.vertex_areas_mm2()
    whole = float(area.sum())
    largest = int(np.argmax(np.abs(distance)))
    return Displacement(
        largest_mm=float(distance[largest]),
        largest_at=largest,
        mean_mm=float((distance * area).sum()) / whole,
        mean_size_mm=float((np.abs(distance) * area).sum()) / whole,
        moved_share=float(area[distance != 0].sum()) / whole,
    )


def lines_of(ledger: Ledger, language: str = LANGUAGES[0]) -> tuple[str, ...]:
    """The ledger for people; its findings in their language."""
    texts = [SIGNS] if any(line.displacement is not None for line in ledger.lines) else []
    for line in ledger.lines:
        old, new = line.before, line.after
        texts.append(f"{line.number}. {line.edit}")
        parts = [] if line.becomes else [_volume_line(line.volume)]
        if line.displacement is not None:
            d = line.displacement
            parts.append(f"largest {d.largest_mm:+z.2f} mm, mean {d.mean_mm:+z.4f} mm")
        if abs(new.roughness_mm - old.roughness_mm) > 0.05 * old.roughness_mm:
            parts.append(f"roughness {old.roughness_mm:.3f} -> {new.roughness_mm:.3f} mm")
        texts += ["   " + "; ".join(parts)] if parts else []
        texts += [f"   {told(one, language)}" for one in line.told]
        texts += [f"   {concern_line(concern, language)}" for concern in line.concerns]
        texts.append(
            f"   girths along the contour, {SMOOTHED_OVER}, by height "
            + _girth_line(ledger.levels_mm, old.girths_mm, new.girths_mm)
        )
        if line.extreme is not None:
            texts.append(f"   where it moved most: {extreme_line(line.extreme)}")
    if len(ledger.lines) > 1 and not ledger.lines[0].becomes:
        wall = next((line.number for line in ledger.lines if line.becomes), None)
        which = "All edits" if wall is None else f"All edits before no. {wall}"
        texts.append(f"{which} together: {_volume_line(ledger.volume)}")
    if ledger.places_mm:
        moves = ", ".join(f"{name} {moved:+z.1f}" for name, moved in ledger.places_mm.items())
        texts.append(f"All edits together, at places that bear no pressure: {moves} mm")
    return tuple(texts)


def concern_line(concern: Concern, language: str = LANGUAGES[0]) -> str:
    """A concern in a line: what it is, and whether somebody means it."""
    if not concern.word:
        return f"! {told(concern.finding, language)}"
    meant = "accepted" if concern.accepted else "NOT accepted"
    return f"! {told(concern.finding, language)} ({meant}: {concern.word})"


def _volume_line(change: VolumeChange | None) -> str:
    if change is None:
        return "volume not comparable: no span of heights is closed before and after"
    off = change.after_ml - change.before_ml
    share = off / change.before_ml * 100 if change.before_ml else 0.0
    low = "the distal end" if change.low_mm is None else f"{change.low_mm:.1f} mm"
    high = "the proximal end" if change.high_mm is None else f"{change.high_mm:.1f} mm"
    where = "" if change.low_mm is change.high_mm is None else f" from {low} to {high}"
    return f"volume{where} {change.after_ml:.1f} mL ({off:+z.2f} mL, {share:+z.3f} %)"


def extreme_line(extreme: Extreme) -> str:
    """The girth at the extreme, and its change."""
    before, after = (extreme.before_mm,), (extreme.after_mm,)
    return _girth_line((extreme.height_mm,), before, after)


def _girth_line(
    levels_mm: tuple[float, ...], old: tuple[float | None, ...], new: tuple[float | None, ...]
) -> str:
    parts: list[str] = []
    for level, before, after in zip(levels_mm, old, new, strict=True):
        if after is None:
            parts.append(f"{level:g}: -")
        elif before is None:
            parts.append(f"{level:g}: {after:.1f}")
        else:
            parts.append(f"{level:g}: {after:.1f} ({after - before:+z.1f})")
    return ", ".join(parts) + " mm"


def upright(limb: Limb) -> Mesh:
    motion = limb.known_limb_from_mesh
    mesh = limb.mesh if motion is None else limb.mesh.moved(motion)
    return mesh.with_vertices(upright_mm(limb))
