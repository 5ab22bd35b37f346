"""Comparing two shapes: what changed, where, and whether it matters for the fit.

In      two Limbs: the first is what one compares with, the second what one has now.
Out     a Comparison: the alignment it stands on, distances, radial errors, girths and volumes.
Method  everything in the first's limb frame; differences are second less first, positive where
        the second lies outside.
Fails   MeasureError: the shapes cannot be laid on each other, or share no level.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from limbgram.errors import MeasureError, OptionsError
from limbgram.geometry.rigid import Rigid
from limbgram.shape.comparing.deviation import Deviation, deviation
from limbgram.shape.comparing.frames import Axes, axes_of, in_limb_frame, outside_of
from limbgram.shape.comparing.levels import LevelChanges, changes_by_level, shared_heights_mm
from limbgram.shape.comparing.radial import RadialErrors, SpokeOptions, radial_errors
from limbgram.shape.comparing.registration import (
    Alignment,
    RegistrationOptions,
    as_is,
    as_they_lie,
    by_landmarks,
    by_shape,
)
from limbgram.shape.comparing.registration.volume import slide_to_volume
from limbgram.shape.limb import Limb
from limbgram.surface.mesh import Mesh

_SOCK_MM = 0.01
_SLID_MM, _LOOSE_MM, _LOOSE_GROWTH = 1.0, 0.5, 3.0
"""From here on pointed out: a slide along the axis, its standard deviation, and what 1 mm of growth

all round would slide, mm."""


@dataclass(frozen=True, kw_only=True)
class CompareOptions:
    """How shapes are laid on each other, and where they are measured."""

    registration: RegistrationOptions = field(default_factory=RegistrationOptions)
    spacing_mm: float = 20.0
    """Between levels."""
    spokes: SpokeOptions = field(default_factory=SpokeOptions)


DEFAULTS = CompareOptions()


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """What changed from the first shape to the second."""

    names: tuple[str, str]
    alignment: Alignment
    axes: Axes
    """Of the first."""
    first_in_limb: Mesh
    second_in_limb: Mesh
    """Both in the first's limb frame."""
    deviation: Deviation
    radial: RadialErrors | None
    levels: LevelChanges
    notes: tuple[str, ...]
    """What a reader must know to trust the figures."""


def compare(first: Limb, second: Limb, options: CompareOptions = DEFAULTS) -> Comparison:
    """Lay the second shape on the first and measure what differs."""
    if not (np.isfinite(options.spacing_mm) and options.spacing_mm >= 1.0):
        raise OptionsError(
            f"Levels {options.spacing_mm:g} mm apart cannot be used. Choose 1 mm or more."
        )
    brim_mm = options.registration.brim_mm
    if not (np.isfinite(brim_mm) and brim_mm >= 0):
        raise OptionsError(f"A brim of {brim_mm:g} mm cannot be. Choose 0 mm or more.")
    first, second = outside_of(first), outside_of(second)
    axes = axes_of(first)
    alignment = lay(first, second, axes, options.registration)
    one = in_limb_frame(first.mesh, axes.limb_from_mesh)
    two = in_limb_frame(second.mesh, axes.limb_from_mesh @ alignment.first_from_second)
    notes = [*first.notes, *second.notes, *alignment.notes, *at_odds(first, second)]
    if axes.note:
        notes.append(axes.note)
    scanned = one.sigma_mm is not None and two.sigma_mm is not None
    if scanned and alignment.looseness is None and not alignment.exact:
        notes.append(
            "What stands behind ± are the errors of both scans, not those of how they were laid on "
            "each other: 1 mm along the axis moves the volume by a slice of 1 mm."
        )
    try:
        radial = radial_errors(one, two, brim_mm, options.spokes)
    except MeasureError as error:
        radial = None
        notes.append(f"There is no mean radial error. {error}")
    return Comparison(
        names=(first.name, second.name),
        alignment=alignment,
        axes=axes,
        first_in_limb=one,
        second_in_limb=two,
        deviation=deviation(one, two, brim_mm),
        radial=radial,
        levels=changes_by_level(
            one, two, shared_heights_mm(one, two, options.spacing_mm), alignment.slide_sigma_mm
        ),
        notes=tuple(dict.fromkeys(notes)),
    )


def lay(first: Limb, second: Limb, axes: Axes, options: RegistrationOptions) -> Alignment:
    """The second shape laid on the first, in the way that was asked for."""
    match options.way:
        case "landmarks":
            return by_landmarks(first, second, options.landmark_weights)
        case "as-is":
            return as_is(first, second)
        case "auto":
            return as_they_lie(first, second) or _by_shape(first, second, axes, options)
        case "icp":
            return _by_shape(first, second, axes, options)
        case "volume":
            return _by_volume(first, second, axes, options)


def _by_shape(first: Limb, second: Limb, axes: Axes, options: RegistrationOptions) -> Alignment:
    """By shape, and how sure its place along the axis is."""
    laid = by_shape(first, second, options)
    loose = laid.looseness
    if loose is None:
        return laid
    along = axes.limb_from_mesh.rotation[2]
    sigma_mm = float(np.sqrt(along @ loose.covariance_mm2 @ along))
    growth = float(along @ loose.growth_shift)
    place = f"its place along the long axis is known to ± {sigma_mm:.2f} mm (1 sigma)"
    slid_mm = _slid_mm(first, second, axes, laid)
    if slid_mm is not None:
        place += f" and lies {slid_mm:+.2f} mm from where the limb frames put it"
    notes = list(laid.notes)
    if abs(slid_mm or 0.0) > _SLID_MM or sigma_mm > _LOOSE_MM or abs(growth) > _LOOSE_GROWTH:
        notes.append(
            f"Laid by shape, the second slides along the long axis: {place}. 1 mm taken off or "
            f"added all round passes for a slide of {abs(growth):.1f} mm, and girths and volumes "
            "move with it. If one shape was made from the other, or both are aligned well, take "
            "them as they lie (--align as-is); landmarks do not slide either."
        )
    return replace(
        laid,
        sentence=f"{laid.sentence}; {place}",
        slide_sigma_mm=sigma_mm,
        slid_mm=slid_mm,
        notes=tuple(notes),
    )


def _slid_mm(first: Limb, second: Limb, axes: Axes, laid: Alignment) -> float | None:
    """Along the first's long axis, from where the limb frames say that the second lies."""
    if first.frame is None or second.frame is None or laid.looseness is None:
        return None
    middle = laid.looseness.middle_mm[None]
    told = as_is(first, second).first_from_second @ laid.first_from_second.inverse
    return float((middle - told.apply(middle))[0] @ axes.limb_from_mesh.rotation[2])


def _by_volume(first: Limb, second: Limb, axes: Axes, options: RegistrationOptions) -> Alignment:
    shaped = by_shape(first, second, options)
    limb_from_second = axes.limb_from_mesh @ shaped.first_from_second
    slide = slide_to_volume(
        in_limb_frame(first.mesh, axes.limb_from_mesh),
        in_limb_frame(second.mesh, limb_from_second),
    )
    along = Rigid(np.eye(3), np.array([0.0, 0.0, slide.shift_mm]))
    return replace(
        shaped,
        way="volume",
        first_from_second=axes.limb_from_mesh.inverse @ along @ limb_from_second,
        sentence=f"by volume: laid by shape, then slid {slide.shift_mm:+.2f} mm along the long "
        f"axis until both hold the same volume below {slide.height_mm:.1f} mm",
        rms_mm=None,
        looseness=None,
    )


def at_odds(first: Limb, second: Limb) -> tuple[str, ...]:
    """What to say where one is a left limb and the other a right one, or wore another sock."""
    notes: list[str] = []
    sides = [limb.frame.side for limb in (first, second) if limb.frame is not None]
    if set(sides) == {"left", "right"}:
        notes.append(
            f"The first is a {sides[0]} limb and the second a {sides[1]} one: what differs may be "
            "that. Mirror one of them by `limbgram edit` to compare both sides."
        )
    if abs(first.sock_mm - second.sock_mm) >= _SOCK_MM:
        notes.append(
            f"A sock of {first.sock_mm:g} mm was taken off the first shape and of "
            f"{second.sock_mm:g} mm off the second: if both wore the same sock, up to "
            f"{abs(first.sock_mm - second.sock_mm):g} mm of the difference is the sock."
        )
    return tuple(notes)
