"""Comparing two shapes: what changed, where, and whether it matters for the fit.

In      two Limbs: the first is what one compares with, the second what one has now.
Out     a Comparison: the alignment it stands on, distances, radial errors, girths and volumes.
Method  everything in the first's limb frame; differences are second less first, positive where
        the second lies outside.
Fails   MeasureError: the shapes cannot be laid on each other, or share no level.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.frames import Rigid, angle_between_deg
from limbgram.core.interval import COVER
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.notebook import brief, data_frame, html_of
from limbgram.core.spreadsheet import Table
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.compare.deviation import Deviation, deviation
from limbgram.workbench.compare.frames import (
    Axes,
    axes_of,
    mesh_in_frame,
    outside_by_name,
)
from limbgram.workbench.compare.icp import PoseCovariance
from limbgram.workbench.compare.levels import (
    Change,
    LevelChanges,
    changes_by_level,
    shared_heights_mm,
)
from limbgram.workbench.compare.radial import RadialErrors, radial_errors
from limbgram.workbench.compare.registration import (
    FAR_MM,
    Alignment,
    RegistrationOptions,
    alignment_as_made,
    as_is,
    by_landmarks,
    by_shape,
    slide_to_volume,
)
from limbgram.workbench.compare.skins import skins_to_compare
from limbgram.workbench.limb import AlignedLimb, Limb

_LEAST_SPACING_MM = 1.0
_SOCK_MM = 0.01
_MOST_SLIDE_MM, _MOST_SLIDE_SIGMA_MM, _MOST_GROWTH_SHIFT = 1.0, 0.5, 3.0
"""From here on pointed out: a slide along the axis, its standard deviation, and what 1 mm of growth

all round would slide, mm."""
_FRAMES_AGREE_DEG, _FRAMES_AGREE_MM = 5.0, 10.0
"""Two alignments that lie so near to where the shapes put each other can both be good ones."""


@dataclass(frozen=True, kw_only=True)
class CompareOptions:
    """How shapes are aligned on each other, and where they are measured."""

    registration: RegistrationOptions = field(default_factory=RegistrationOptions)
    spacing_mm: float = 20.0
    """Between levels."""


DEFAULTS = CompareOptions()


@dataclass(frozen=True, kw_only=True)
class VolumeByShape:
    """The change of volume if the shapes are aligned by shape alone."""

    alignment: Alignment
    volume: Change
    laid_sigma_mm3: float
    at_odds: bool
    """It contradicts the reported change beyond the uncertainty of both alignments."""


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
    laid_sigma_mm: Float64[np.ndarray, " n"] | None
    """Standard deviation of the second's position at the first's vertices, along their normals, by
    the alignment alone; None where that is not known, or exact."""
    by_shape: VolumeByShape | None
    """Given where auto aligned them not by shape, and neither was made from the other."""
    notes: tuple[Finding, ...]
    """Findings that a reader must know to trust the figures."""

    __repr__ = brief

    def to_frame(self) -> Any:
        """A pandas.DataFrame with a row for each height: every figure of both, and its change.

        Raises:
            MissingError: pandas is not installed.
        """
        return data_frame(self._table())

    def _repr_html_(self) -> str:
        """The same table, for notebooks."""
        return html_of(self._table(), "second less first; sigma is one standard deviation")

    def _table(self) -> Table:
        names = tuple(dict.fromkeys(name for one in self.levels.levels for name in one.measures))
        ends = ("first", "second", "change", "sigma")
        changes = (
            (one.height_mm, [one.measures.get(name) for name in names])
            for one in self.levels.levels
        )
        return Table(
            title="levels",
            columns=("height_mm", *(f"{end}_{name}" for name in names for end in ends)),
            rows=tuple(
                (height, *(cell for change in listed for cell in _change_cells(change)))
                for height, listed in changes
            ),
        )


def _change_cells(change: Change | None) -> tuple[float | None, ...]:
    if change is None:
        return (None,) * 4
    return change.first.value, change.second.value, change.difference, change.sigma


def compare(first: Limb, second: Limb, options: CompareOptions = DEFAULTS) -> Comparison:
    """Align the second shape on the first and measure the differences."""
    if not (np.isfinite(options.spacing_mm) and options.spacing_mm >= _LEAST_SPACING_MM):
        raise OptionsError(
            "compare.spacing.small", spacing_mm=options.spacing_mm, least_mm=_LEAST_SPACING_MM
        )
    brim_mm = options.registration.brim_mm
    if not (np.isfinite(brim_mm) and brim_mm >= 0):
        raise OptionsError("compare.brim.negative", brim_mm=brim_mm)
    (first, second), walls = skins_to_compare([outside_by_name(one) for one in (first, second)])
    axes = axes_of(first)
    registration = options.registration
    alignment = align_shapes(first, second, axes, registration)
    one = mesh_in_frame(first.mesh, axes.limb_from_mesh)
    two = mesh_in_frame(second.mesh, axes.limb_from_mesh @ alignment.first_from_second)
    notes = [
        *walls,
        *first.notes,
        *second.notes,
        *alignment.notes,
        *mismatch_findings(first, second),
    ]
    if axes.doubt is not None:
        notes.append(axes.doubt)
    scanned = one.sigma_mm is not None and two.sigma_mm is not None
    if scanned and alignment.pose_covariance is None and not alignment.exact:
        notes.append(note("compare.within.of_scans"))
    try:
        radial = radial_errors(one, two, brim_mm)
    except MeasureError as error:
        radial = None
        notes.append(doubt("compare.radial.none", reason=error.finding))
    heights = shared_heights_mm(one, two, options.spacing_mm)
    levels = changes_by_level(one, two, heights, alignment.slide_sigma_mm)
    loose = alignment.pose_covariance
    return Comparison(
        names=(first.name, second.name),
        alignment=alignment,
        axes=axes,
        first_in_limb=one,
        second_in_limb=two,
        deviation=deviation(one, two, brim_mm),
        radial=radial,
        levels=levels,
        laid_sigma_mm=None
        if loose is None
        else loose.sigmas_mm(first.mesh.vertices_mm, first.mesh.vertex_normals()),
        by_shape=None
        if registration.way != "auto" or alignment.way == "icp" or alignment.exact
        else _volume_by_shape(first, second, axes, registration, alignment, levels),
        notes=tuple(dict.fromkeys(notes)),
    )


def align_shapes(first: Limb, second: Limb, axes: Axes, options: RegistrationOptions) -> Alignment:
    """The alignment of the second shape on the first, by the method asked for."""
    match options.way:
        case "landmarks":
            return _by_landmarks(first, second, axes, options)
        case "as-is":
            return as_is(first, second)
        case "auto":
            return alignment_as_made(first, second) or _by_best_evidence(
                first, second, axes, options
            )
        case "icp":
            return _by_shape(first, second, axes, options)
        case "volume":
            return _by_volume(first, second, axes, options)


def _by_best_evidence(
    first: Limb, second: Limb, axes: Axes, options: RegistrationOptions
) -> Alignment:
    """Align by landmarks or limb frames, which do not slide where a limb shrank, or by shape.

    Where most of the surface is unchanged the shape holds it better than any hand marks it.
    """
    notes: tuple[Finding, ...] = ()
    if not options.mostly_unchanged:
        try:
            laid = _by_landmarks(first, second, axes, options)
        except MeasureError:
            laid = None
        if laid is not None and laid.rms_mm is not None and laid.rms_mm <= FAR_MM:
            return laid
        if laid is not None:
            notes = (doubt("compare.landmarks.unlike", how=laid.how),)
    shaped = _by_shape(first, second, axes, options)
    open_place = shaped.slide_sigma_mm > _MOST_SLIDE_SIGMA_MM
    if (
        open_place
        and not options.mostly_unchanged
        and _frames_agree_with_shape(first, second, shaped)
    ):
        return replace(
            as_is(first, second),
            notes=(
                *notes,
                *shaped.notes,
                doubt("compare.frames.taken"),
            ),
        )
    return replace(shaped, notes=(*notes, *shaped.notes))


def _frames_agree_with_shape(first: Limb, second: Limb, shaped: Alignment) -> bool:
    """Whether both limbs have frames that their shapes do not contradict."""
    if shaped.pose_covariance is None or not _both_aligned(first, second):
        return False
    told = as_is(first, second).first_from_second
    middle = shaped.pose_covariance.middle_mm[None]
    moved = told.apply(shaped.first_from_second.inverse.apply(middle)) - middle
    turned = angle_between_deg(told.rotation, shaped.first_from_second.rotation)
    return turned < _FRAMES_AGREE_DEG and float(np.linalg.norm(moved)) < _FRAMES_AGREE_MM


def _both_aligned(first: Limb, second: Limb) -> bool:
    return isinstance(first, AlignedLimb) and isinstance(second, AlignedLimb)


def _volume_by_shape(
    first: Limb,
    second: Limb,
    axes: Axes,
    options: RegistrationOptions,
    told: Alignment,
    levels: LevelChanges,
) -> VolumeByShape | None:
    """The change of volume by shape; None where the shapes cannot be aligned, or have no volume."""
    try:
        shaped = _by_shape(first, second, axes, options)
    except MeasureError:
        return None
    one = mesh_in_frame(first.mesh, axes.limb_from_mesh)
    two = mesh_in_frame(second.mesh, axes.limb_from_mesh @ shaped.first_from_second)
    again = changes_by_level(
        one, two, tuple(level.height_mm for level in levels.levels), shaped.slide_sigma_mm
    )
    if again.volume is None or levels.volume is None or again.from_mm != levels.from_mm:
        return None
    apart = abs(again.volume.difference - levels.volume.difference)
    known = told.pose_covariance is not None
    room = COVER * float(np.hypot(again.laid_sigma_mm3, levels.laid_sigma_mm3))
    return VolumeByShape(
        alignment=shaped,
        volume=again.volume,
        laid_sigma_mm3=again.laid_sigma_mm3,
        at_odds=not known or apart > room,
    )


def _by_landmarks(first: Limb, second: Limb, axes: Axes, options: RegistrationOptions) -> Alignment:
    """The alignment by landmarks, with its uncertainty along the axis."""
    laid = by_landmarks(first, second, options.landmark_weights)
    if laid.pose_covariance is None:
        return laid
    return replace(laid, slide_sigma_mm=_sigma_along_axis_mm(laid.pose_covariance, axes))


def _sigma_along_axis_mm(loose: PoseCovariance, axes: Axes) -> float:
    """Standard deviation along the first's long axis."""
    along = axes.limb_from_mesh.rotation[2]
    return float(np.sqrt(along @ loose.covariance_mm2 @ along))


def _by_shape(first: Limb, second: Limb, axes: Axes, options: RegistrationOptions) -> Alignment:
    """The alignment by shape, with its uncertainty along the axis."""
    laid = by_shape(first, second, options)
    loose = laid.pose_covariance
    if loose is None:
        return laid
    along = axes.limb_from_mesh.rotation[2]
    sigma_mm = _sigma_along_axis_mm(loose, axes)
    growth = float(along @ loose.growth_shift)
    slid_mm = _slide_from_frames_mm(first, second, axes, laid)
    place = note("compare.laid.place", within_mm=COVER * sigma_mm, slid_mm=slid_mm)
    notes = list(laid.notes)
    if (
        abs(slid_mm or 0.0) > _MOST_SLIDE_MM
        or sigma_mm > _MOST_SLIDE_SIGMA_MM
        or abs(growth) > _MOST_GROWTH_SHIFT
    ):
        notes.append(doubt("compare.shape.slides", place=place, slide_mm=abs(growth)))
    return replace(
        laid,
        how=note("compare.laid.shape_and_place", how=laid.how, place=place),
        slide_sigma_mm=sigma_mm,
        slid_mm=slid_mm,
        notes=tuple(notes),
    )


def _slide_from_frames_mm(first: Limb, second: Limb, axes: Axes, laid: Alignment) -> float | None:
    """The shift along the first's long axis from where the limb frames put the second."""
    if laid.pose_covariance is None or not _both_aligned(first, second):
        return None
    middle = laid.pose_covariance.middle_mm[None]
    told = as_is(first, second).first_from_second @ laid.first_from_second.inverse
    return float((middle - told.apply(middle))[0] @ axes.limb_from_mesh.rotation[2])


def _by_volume(first: Limb, second: Limb, axes: Axes, options: RegistrationOptions) -> Alignment:
    shaped = by_shape(first, second, options)
    limb_from_second = axes.limb_from_mesh @ shaped.first_from_second
    slide = slide_to_volume(
        mesh_in_frame(first.mesh, axes.limb_from_mesh),
        mesh_in_frame(second.mesh, limb_from_second),
    )
    along = Rigid(np.eye(3), np.array([0.0, 0.0, slide.shift_mm]))
    return replace(
        shaped,
        way="volume",
        first_from_second=axes.limb_from_mesh.inverse @ along @ limb_from_second,
        how=note("compare.laid.volume", slid_mm=slide.shift_mm, height_mm=slide.height_mm),
        rms_mm=None,
        pose_covariance=None,
    )


def mismatch_findings(first: Limb, second: Limb) -> tuple[Finding, ...]:
    """Doubts where the two limbs' sides differ, or their socks."""
    notes: list[Finding] = []
    if {first.side, second.side} == {"left", "right"}:
        notes.append(doubt("compare.sides.differ", first=first.side, second=second.side))
    if abs(first.sock_mm - second.sock_mm) >= _SOCK_MM:
        notes.append(
            doubt(
                "compare.socks.differ",
                first_mm=first.sock_mm,
                second_mm=second.sock_mm,
                apart_mm=abs(first.sock_mm - second.sock_mm),
            )
        )
    return tuple(notes)
