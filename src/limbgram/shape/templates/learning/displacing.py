"""Displacements: how far along its normals a shape was moved by a rectification.

In      a pair of Limbs, before and after.
Out     places on the before and their displacements, with how the after was laid on it.
Method  rays along the normals to the after, by Newton's steps on its nearest triangles.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64

from limbgram.geometry.arrays import Points3
from limbgram.shape.comparing.comparing import lay
from limbgram.shape.comparing.counterparts import Ground, measured_faces
from limbgram.shape.comparing.frames import axes_of, in_limb_frame
from limbgram.shape.comparing.registration import Alignment, RegistrationOptions
from limbgram.shape.comparing.sampling import sample_evenly
from limbgram.shape.limb import Limb

_SAMPLES = 25_000
_STEPS = 8
_MET_MM = 0.02
_SETTLED_MM = 2e-3
_STEEPEST = 0.3
"""Least cosine between the normals of both shapes along which a displacement is taken."""
_MOST_MM, _MOST_RMS_MM = 15.0, 5.0
"""A rectification moves no finger tip of a limb by more, nor the whole of it (root mean square)."""
_NEARLY_ALL = 0.995


@dataclass(frozen=True, kw_only=True)
class Pair:
    """A shape before and after a rectification."""

    before: Limb
    after: Limb


@dataclass(frozen=True, kw_only=True)
class LearnOptions:
    """How pairs are laid on each other, and what is kept."""

    registration: RegistrationOptions = field(
        default_factory=lambda: RegistrationOptions(mostly_unchanged=True)
    )
    reference: str | None = None
    """Landmark from which heights count; None takes the most proximal that all pairs have."""
    false_share: float = 0.05
    """Of the nodes that are kept, at most this share by chance."""
    least_mm: float = 0.1
    """Smaller mean displacements are not kept."""
    farthest_mm: float = 30.0
    """Larger displacements are no rectification."""


@dataclass(frozen=True, kw_only=True)
class Displacements:
    """Of n places."""

    points_mm: Points3
    """On the before, in its limb frame."""
    moved_mm: Float64[np.ndarray, " n"]
    """Along its normals, positive outwards."""
    alignment: Alignment


def displacements(pair: Pair, options: LearnOptions) -> Displacements:
    """Where the after lies off the before."""
    before = pair.before
    axes = axes_of(before)
    alignment = lay(before, pair.after, axes, options.registration)
    brim_mm = options.registration.brim_mm
    placed = in_limb_frame(pair.after.mesh, alignment.first_from_second)
    ground = Ground.of(placed, brim_mm)
    samples = sample_evenly(before.mesh, _SAMPLES)
    moved = np.zeros(len(samples.points_mm))
    active = np.arange(len(moved))
    for _ in range(_STEPS):
        normals = samples.normals[active]
        there = samples.points_mm[active] + moved[active, None] * normals
        found = ground.counterparts(there)
        lean = np.einsum("nc,nc->n", normals, found.flat_normals)
        gap = np.einsum("nc,nc->n", found.points_mm - there, found.flat_normals)
        step = gap / np.where(np.abs(lean) < _STEEPEST, np.inf, lean)
        moved[active] += step
        active = active[np.abs(step) > _SETTLED_MM]
    found = ground.counterparts(samples.points_mm + moved[:, None] * samples.normals)
    met = np.abs(found.signed_mm) < _MET_MM
    own = measured_faces(before.mesh, brim_mm)[samples.faces]
    good = met & own & ~found.at_brim & found.measured & (np.abs(moved) < options.farthest_mm)
    return Displacements(
        points_mm=axes.limb_from_mesh.apply(samples.points_mm[good]),
        moved_mm=moved[good],
        alignment=alignment,
    )


def about_pair(pair: Pair, move: Displacements) -> tuple[str, ...]:
    """How the pair was laid, and whether what differs can be a rectification at all."""
    name = f"{pair.before.name or 'before'} to {pair.after.name or 'after'}"
    notes = [f"{name}: aligned {move.alignment.sentence}.", *move.alignment.notes]
    most_mm = float(np.quantile(np.abs(move.moved_mm), _NEARLY_ALL))
    rms_mm = float(np.sqrt(np.mean(move.moved_mm**2)))
    if most_mm > _MOST_MM or rms_mm > _MOST_RMS_MM:
        notes.append(
            f"{name}: the shapes differ by {move.moved_mm.min():+.1f} to "
            f"{move.moved_mm.max():+.1f} mm, {rms_mm:.1f} mm RMS. That is more than a "
            f"rectification does ({_MOST_MM:g} mm at a place, {_MOST_RMS_MM:g} mm RMS): they look "
            "like two limbs, or lie wrongly on each other. Do not use this template before you "
            "know why."
        )
    return tuple(notes)
