"""Registration: the alignment of a second shape on a first one.

In      two Limbs and the way: by landmarks, by shape (ICP), by volume, or as they are.
Out     an Alignment: the motion, how it was found and how well.
Method  The motion is always rigid: a wrong size stays in the figures instead of vanishing in a
        scale. By volume, the second slides along the long axis until both hold the same below the
        lower of the two brims, as a limb sinks into a socket until it fills it: the difference
        falls steadily with the slide, so there is one root. A shape that fits badly is also tried
        as its mirror image; a limb that is nearly its own mirror image is not asked.
Fails   MeasureError: too few landmarks, no overlap, a shape that tells no pose, an open distal end,
        or no slide that makes the volumes equal.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import Rigid, fit_similarity
from limbgram.core.interval import widening
from limbgram.core.known_words import require_known_words
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.anatomy.names import match_names, paired_landmarks
from limbgram.workbench.compare.counterparts import CounterpartSurface
from limbgram.workbench.compare.frames import brim_height_mm
from limbgram.workbench.compare.icp import (
    FINE,
    MIDDLE,
    Fit,
    PoseCovariance,
    best_of_starts,
    known_pose,
    measured_samples,
    run_icp,
    width_mm,
)
from limbgram.workbench.limb import AlignedLimb, Limb
from limbgram.workbench.measures.levels import DISTAL_END, Sigmas, Volumes

_MIRROR_SUSPECT_SHARE = 0.005
"""RMS distance, as a share of the width, from which on a mirrored shape is tried."""
_MIRROR_BETTER = 0.5
_MIRROR_X = np.array([-1.0, 1.0, 1.0])
Way = Literal["auto", "icp", "landmarks", "volume", "as-is"]
"""auto: as they lie where one was made from the other; else by landmarks where three are shared;
else by the limb frames where the shapes leave their place along the axis open; else by icp."""
WAYS: tuple[Way, ...] = get_args(Way)
_FEWEST_LANDMARKS = 3
_SPREAD_MM = 5.0
"""Landmarks must lie this far off a common line (RMS), or they determine no turn about it."""
_MARK_MM = 0.2
"""No landmark is more precise than a painted spot in several photos (0.16 mm RMS, measured)."""
_LEAST_USED = 0.2
FAR_MM = 5.0
"""Surfaces that stay this far apart (RMS) are hardly of one limb."""
_MOST_WIDER, _MOST_RMS_SHARE = 0.15, 0.05
"""Shapes are not of one limb if their widths differ and they stay apart by more than these shares
of the first one's width: ICP would place them anywhere along the axis. A part of a limb may be
wider than the whole and still fit."""
_SAME_POSE_MM = 1e-3
_SIZE_DIFFERENCE = 0.03
"""From this difference in size on, the place along the axis is off by millimetres."""


@dataclass(frozen=True, kw_only=True)
class RegistrationOptions:
    """How a second shape is laid on a first."""

    way: Way = "auto"
    brim_mm: float = 5.0
    """Strip along open edges that takes no part."""
    landmark_weights: Mapping[str, float] = field(default_factory=dict)
    """By name; 1 where none is given, 0 leaves a landmark out."""
    mostly_unchanged: bool = False
    """Most of the surface is the same on both, so that auto goes by shape rather than landmarks:
    captures of one limb, or a cast before and after a rectification."""

    def __post_init__(self) -> None:
        require_known_words(self)


DEFAULTS = RegistrationOptions()
_CLEAR_MM = 1e-3
"""Distance kept below the brim, so that the section is closed."""
_FARTHEST_MM = 60.0
_ROOT_TOLERANCE_MM = 1e-9


@dataclass(frozen=True, kw_only=True)
class Alignment:
    """The alignment of the second shape on the first, and how it was found."""

    way: Way
    first_from_second: Rigid
    """Between the frames of the meshes."""
    how: Finding
    """The way, for every report that gives figures found by it."""
    rms_mm: float | None
    """RMS of landmarks, or of distances between the surfaces; None where nothing was fitted."""
    pose_covariance: PoseCovariance | None = None
    """The pose's uncertainty by shapes or landmarks; None where nothing was fitted."""
    exact: bool = False
    """True where one shape was made from the other and still lies as it was made."""
    slide_sigma_mm: float = 0.0
    """Standard deviation of the second's place along the long axis, as far as it is known."""
    slid_mm: float | None = None
    """Along that axis, from where limb frames put it; None without frames."""
    notes: tuple[Finding, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Slide:
    """A shift along the first's long axis after which both hold the same volume."""

    shift_mm: float
    height_mm: float
    """In the first's limb frame: below it both hold the same volume."""


def alignment_as_made(first: Limb, second: Limb) -> Alignment | None:
    """The alignment by which one shape was made from the other; None if that is not known."""
    made = known_pose(first, second)
    if made is None:
        return None
    return Alignment(
        way="as-is",
        first_from_second=made.first_from_second,
        how=note("compare.laid.made", because=made.because),
        rms_mm=None,
        exact=True,
    )


def as_is(first: Limb, second: Limb) -> Alignment:
    """The alignment of limb frame on limb frame, or of file on file if neither has one."""
    match first, second:
        case AlignedLimb(), AlignedLimb():
            pose = first.limb_from_mesh.inverse @ second.limb_from_mesh
            how = note("compare.laid.frames")
        case (AlignedLimb(), bare) | (bare, AlignedLimb()):
            raise MeasureError("compare.frames.one_only", bare=bare.name)
        case _:
            pose, how = Rigid.identity(), note("compare.laid.files")
    made = known_pose(first, second)
    exact = (
        made is not None
        and _largest_difference_mm(pose, made.first_from_second, second) < _SAME_POSE_MM
    )
    return Alignment(way="as-is", first_from_second=pose, how=how, rms_mm=None, exact=exact)


def by_landmarks(first: Limb, second: Limb, weights: Mapping[str, float]) -> Alignment:
    """Align landmarks of the same places by weighted least squares, without scaling."""
    both = paired_landmarks(first.landmarks, second.landmarks)
    meant = match_names(weights, [mark.name for mark, _ in both])
    weight = {meant[name]: given for name, given in weights.items() if name in meant}
    unknown = set(weights) - set(meant)
    if unknown or any(not np.isfinite(w) or w < 0 for w in weights.values()):
        raise OptionsError("compare.weights.wrong", names=tuple(weights))
    used = [pair for pair in both if weight.get(pair[0].name, 1.0) > 0]
    if len(used) < _FEWEST_LANDMARKS:
        raise MeasureError("compare.landmarks.few", shared=len(used), fewest=_FEWEST_LANDMARKS)
    to_mm = np.stack([mark.position_mm for mark, _ in used])
    from_mm = np.stack([mark.position_mm for _, mark in used])
    share = np.array([weight.get(mark.name, 1.0) for mark, _ in used])
    share = share / share.sum()
    centred = (to_mm - share @ to_mm) * np.sqrt(share)[:, None]
    if np.linalg.svd(centred)[1][1] < _SPREAD_MM:
        raise MeasureError("compare.landmarks.on_line", names=tuple(mark.name for mark, _ in used))
    fit = fit_similarity(from_mm, to_mm, with_scale=False, weights=share)
    pose = Rigid(fit.rotation, fit.translation)
    off_mm = np.linalg.norm(pose.apply(from_mm) - to_mm, axis=1)
    rms_mm = float(np.sqrt(share @ off_mm**2))
    worst = used[int(np.argmax(off_mm))][0].name
    return Alignment(
        way="landmarks",
        first_from_second=pose,
        how=note(
            "compare.laid.landmarks",
            landmarks=len(used),
            rms_mm=rms_mm,
            largest_mm=float(off_mm.max()),
            worst=worst,
        ),
        rms_mm=rms_mm,
        pose_covariance=_covariance_by_landmarks(to_mm, off_mm, share),
    )


def by_shape(first: Limb, second: Limb, options: RegistrationOptions = DEFAULTS) -> Alignment:
    """Align the surfaces by robust ICP, without their brims and filled parts.

    Raises:
        MeasureError: no overlap, or sizes so different that the shape tells no place.
    """
    surface = CounterpartSurface.of(first.mesh, options.brim_mm)
    start = _start_pose(first, second)
    fine_mm = measured_samples(second, FINE, options.brim_mm)
    notes: list[Finding] = []
    fit = None if start is None else run_icp(fine_mm, surface, start)
    if fit is None or fit.used_share < _LEAST_USED:
        best, rival = best_of_starts(first, second, surface, options.brim_mm)
        fit = run_icp(fine_mm, surface, best)
        if rival:
            notes.append(doubt("compare.pose.rival"))
    _require_same_limb(first, second, fine_mm, fit, options)
    if abs(fit.larger_share) > _SIZE_DIFFERENCE:
        notes.append(
            doubt(
                "compare.shape.other_size",
                share=abs(fit.larger_share),
                larger=fit.larger_share > 0,
            )
        )
    if not fit.converged:
        notes.append(doubt("compare.shape.unsettled", rounds=fit.rounds))
    if fit.rms_mm > FAR_MM:
        notes.append(doubt("compare.shape.far", rms_mm=fit.rms_mm))
    notes += mirror_findings(first, second, surface, fit, options.brim_mm)
    notes += fit.undetermined
    return Alignment(
        way="icp",
        first_from_second=fit.first_from_second,
        how=note(
            "compare.laid.shape",
            brim_mm=options.brim_mm,
            rms_mm=fit.rms_mm,
            used_share=fit.used_share,
        ),
        rms_mm=fit.rms_mm,
        pose_covariance=fit.pose_covariance,
        notes=tuple(notes),
    )


def _require_same_limb(
    first: Limb, second: Limb, second_mm: Points3, fit: Fit, options: RegistrationOptions
) -> None:
    """Refuse surfaces that share too little, or whose sizes differ too much to tell a place."""
    names = {"first": first.name, "second": second.name}
    if not fit.used_share >= _LEAST_USED:
        raise MeasureError("compare.shape.no_overlap", share=fit.used_share, **names)
    first_mm = width_mm(measured_samples(first, MIDDLE, options.brim_mm))
    wider = width_mm(second_mm) / first_mm - 1
    if abs(wider) > _MOST_WIDER and fit.rms_mm > _MOST_RMS_SHARE * first_mm:
        raise MeasureError(
            "compare.shape.other_width",
            **names,
            share=abs(wider),
            wider=wider > 0,
            rms_mm=fit.rms_mm,
        )


def slide_to_volume(first_in_limb: Mesh, second_in_limb: Mesh) -> Slide:
    """The slide after which both hold the same volume below the lower brim."""
    first, second = _volumes_of(first_in_limb), _volumes_of(second_in_limb)
    first_top, second_top = brim_height_mm(first_in_limb), brim_height_mm(second_in_limb)

    def level(shift_mm: float) -> float:
        return min(first_top, second_top + shift_mm) - _CLEAR_MM

    def excess(shift_mm: float) -> float:
        height = level(shift_mm)
        return (
            second.between(DISTAL_END, height - shift_mm).value
            - first.between(DISTAL_END, height).value
        )

    from scipy.optimize import brentq  # a twentieth of a second, for this way of aligning alone

    length = min(np.ptp(mesh.vertices_mm[:, 2]) for mesh in (first_in_limb, second_in_limb))
    reach = min(_FARTHEST_MM, 0.4 * float(length))
    if excess(-reach) * excess(reach) > 0:
        raise MeasureError("compare.slide.none", reach_mm=reach)
    shift_mm = float(np.asarray(brentq(excess, -reach, reach, xtol=_ROOT_TOLERANCE_MM)))
    return Slide(shift_mm=shift_mm, height_mm=level(shift_mm))


def mirror_findings(
    first: Limb,
    second: Limb,
    surface: CounterpartSurface,
    fit: Fit,
    brim_mm: float,
) -> tuple[Finding, ...]:
    """A doubt where the mirror image of the second fits the first far better."""
    if not fit.rms_mm > _MIRROR_SUSPECT_SHARE * width_mm(first.mesh.vertices_mm):
        return ()
    mirrored = replace(
        second,
        mesh=replace(
            second.mesh,
            vertices_mm=second.mesh.vertices_mm * _MIRROR_X,
            faces=second.mesh.faces[:, ::-1].copy(),
        ),
    )
    best, _ = best_of_starts(first, mirrored, surface, brim_mm)
    image = run_icp(measured_samples(mirrored, FINE, brim_mm), surface, best)
    if not (
        image.rms_mm < _MIRROR_BETTER * fit.rms_mm and image.cost_mm < _MIRROR_BETTER * fit.cost_mm
    ):
        return ()
    return (doubt("compare.shape.mirrored", image_rms_mm=image.rms_mm, rms_mm=fit.rms_mm),)


def _largest_difference_mm(one: Rigid, other: Rigid, limb: Limb) -> float:
    """The largest difference of two poses at a limb's vertices."""
    points = limb.mesh.vertices_mm
    return float(np.abs(one.apply(points) - other.apply(points)).max())


def _covariance_by_landmarks(
    places_mm: Points3, off_mm: Float64[np.ndarray, " k"], share: Float64[np.ndarray, " k"]
) -> PoseCovariance:
    """The pose's covariance from the landmarks' residuals, as isotropic errors.

    Few landmarks determine their size badly, so it is widened.
    """
    middle = share @ places_mm
    apart = places_mm - middle
    turns = np.stack([np.cross(axis, apart) for axis in np.eye(3)], axis=2)
    shifts = np.broadcast_to(np.eye(3), turns.shape)
    columns = np.concatenate([turns, shifts], axis=2).reshape(-1, 6)
    weights = np.repeat(share, 3)
    inverse = np.linalg.inv((columns * weights[:, None]).T @ columns)
    spread = inverse @ ((columns * weights[:, None] ** 2).T @ columns) @ inverse
    counted = 1 / float(np.square(share).sum())
    free = max(3 * counted - 6, 1.0)
    mark_mm2 = float(share @ off_mm**2) * counted / free
    return PoseCovariance(
        middle_mm=middle,
        covariance=max(mark_mm2 * widening(free) ** 2, _MARK_MM**2) * spread,
        growth_shift=np.zeros(3),
    )


def _start_pose(first: Limb, second: Limb) -> Rigid | None:
    """The start pose by landmarks or limb frames; None if there are neither."""
    try:
        return by_landmarks(first, second, {}).first_from_second
    except MeasureError:
        if isinstance(first, AlignedLimb) and isinstance(second, AlignedLimb):
            return as_is(first, second).first_from_second
        return None


def _volumes_of(mesh: Mesh) -> Volumes:
    return Volumes.of(Sigmas.of(mesh))
