"""Template: a rectification that follows landmarks, as it is kept, and applied to another limb."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int64
from scipy.spatial import KDTree

from limbgram.core.errors import MeasureError, OptionsError, refusals_about
from limbgram.core.notebook import brief
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.anatomy.names import identity_of, landmarks_by_identity
from limbgram.workbench.edits.guard import require_sound
from limbgram.workbench.edits.pressing import USUAL_DEPTH_MM, Pressure, effects_at_places
from limbgram.workbench.limb import Landmark, Limb, Side
from limbgram.workbench.templates.chart_field import Field, evaluate_field
from limbgram.workbench.templates.charts import Along, ChartPlace, plain_chart, pulled_chart

_STRONGEST = 3.0
_LOW_SHARE = 0.25


@dataclass(frozen=True, kw_only=True)
class TemplateMark:
    """A landmark's place on the chart."""

    name: str
    height: float
    angle_deg: float
    """From the front towards the lateral side."""

    @property
    def place(self) -> ChartPlace:
        return np.array([self.height, np.radians(self.angle_deg)])


@dataclass(frozen=True, kw_only=True)
class Template:
    """Displacements along the outward normal over the chart of a limb."""

    name: str
    pairs: int
    """Before-and-after pairs that it was learned from."""
    sided: bool
    """False if made from limbs without side, where +X is called lateral."""
    reference: str
    """Landmark at chart height 1."""
    marks: tuple[TemplateMark, ...]
    heights: Float64[np.ndarray, " h"]
    """Chart heights of the nodes."""
    displacement_mm: Field
    """Positive outwards; 0 where nothing is significant."""
    spread_mm: Field
    """Standard deviation between pairs; NaN where fewer than two pairs know the place."""
    known_pairs: Int64[np.ndarray, "h a"]
    """Pairs that know each node."""
    along: Along = "axis"
    """What its heights count along."""

    __repr__ = brief

    def has_side_of(self, side: Side) -> bool:
        """Whether the template can be applied to a limb of this side."""
        return self.sided == (side != "none")


@dataclass(frozen=True, kw_only=True)
class Applied:
    """A limb after a template."""

    limb: Limb
    moved_mm: Float64[np.ndarray, " n"]
    """Of each vertex along its normal, positive outwards."""
    pressures: tuple[Pressure, ...]
    """Sensitive places that it presses on."""
    notes: tuple[Finding, ...]

    __repr__ = brief


def apply_template(limb: Limb, template: Template, strength: float = 1.0) -> Applied:
    """Apply a template to a limb, at the limb's own landmarks.

    Args:
        strength: Factor of all displacements; 1 as learned.

    Raises:
        MeasureError: no frame or reference landmark, or landmarks that contradict the template.
        EditError: the surface would fold or cross itself.
    """
    if not (np.isfinite(strength) and 0 < strength <= _STRONGEST):
        raise OptionsError("template.strength", strength=strength, most=_STRONGEST)
    limb = limb.aligned()
    if not template.has_side_of(limb.side):
        raise MeasureError(
            "template.other_side",
            template=template.name,
            sided=template.sided,
            name=limb.name or None,
            side=limb.side,
        )
    marks = {identity_of(mark.name): mark.place for mark in template.marks}
    chart = pulled_chart(limb, plain_chart(limb, template.reference, template.along), marks)
    mesh = limb.mesh
    places = chart.places(limb.mesh_in_limb.vertices_mm)
    moved = strength * evaluate_field(template.displacement_mm, template.heights, places)
    vertices = mesh.vertices_mm + moved[:, None] * mesh.vertex_normals()
    after = mesh.with_vertices(vertices)
    with refusals_about(f"The template {template.name!r}"):
        require_sound(mesh, after)
    landmarks = _with_landmarks_carried(limb, vertices - mesh.vertices_mm)
    made = replace(limb.with_mesh(after), landmarks=landmarks)
    pressures = effects_at_places(limb, made).pressures
    return Applied(
        limb=made,
        moved_mm=moved,
        pressures=pressures,
        notes=(*_pressure_doubts(pressures, moved), *_notes(limb, template, places[:, 0])),
    )


def moves_at_marks(template: Template) -> dict[str, float]:
    """How far a template moves the surface at each of its landmarks, positive outward."""
    if not template.marks:
        return {}
    places = np.stack([mark.place for mark in template.marks])
    moved = evaluate_field(template.displacement_mm, template.heights, places)
    return {mark.name: float(value) for mark, value in zip(template.marks, moved, strict=True)}


def _with_landmarks_carried(limb: Limb, moved_mm: np.ndarray) -> tuple[Landmark, ...]:
    """The limb with its landmarks moved by the surface under them."""
    if not limb.landmarks:
        return ()
    nearest = np.asarray(
        KDTree(limb.mesh.vertices_mm).query([mark.position_mm for mark in limb.landmarks])[1]
    )
    return tuple(
        replace(mark, position_mm=mark.position_mm + moved_mm[vertex])
        for mark, vertex in zip(limb.landmarks, nearest)
    )


def _pressure_doubts(pressures: Sequence[Pressure], moved_mm: np.ndarray) -> Iterator[Finding]:
    for one in pressures:
        yield doubt("template.presses", depth_mm=one.depth_mm, place=one.place, why=one.why)
    deepest = float(np.abs(moved_mm).max(initial=0.0))
    if deepest > USUAL_DEPTH_MM:
        yield doubt("template.deep", depth_mm=deepest, usual_mm=USUAL_DEPTH_MM)


def _notes(
    limb: Limb, template: Template, heights: Float64[np.ndarray, " n"]
) -> tuple[Finding, ...]:
    have = landmarks_by_identity(limb.landmarks)
    missing = tuple(one.name for one in template.marks if identity_of(one.name) not in have)
    notes: list[Finding] = []
    if missing:
        notes.append(note("template.marks_missing", names=missing))
    above = float((heights > template.heights[-1]).mean())
    if above > _LOW_SHARE:
        notes.append(note("template.above", share=above))
    return tuple(notes)
