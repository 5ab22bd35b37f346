"""Limits: what limits the accuracy of a result, with figures and advice.

In      the figures of an assessment and the expected error.
Out     findings, the gravest first; every rule has a number and a remedy.
"""

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from limbgram.capture.setup import SetupCited
from limbgram.core.interval import COVER
from limbgram.core.tape import AGREES_SIGMAS, sigmas_apart
from limbgram.findings import Finding, Gravity, doubt, fault, note
from limbgram.reconstruction.measuring.uncertainty import (
    CAMERAS,
    CREASES,
    FACES,
    GAPS,
    OFFSET,
    SCALE,
)
from limbgram.report.accuracy.figures import CHECK_TELLS, Figures, SurfaceSigma
from limbgram.report.accuracy.judgement import (
    FAR_SCALE,
    IMAGE,
    LENS_FOUND,
    scale_source,
    tape_is_precise,
)
from limbgram.report.accuracy.selfcalibration import SelfCalibration
from limbgram.report.accuracy.surface import UNNAMED

_ORDER = (Gravity.FAULT, Gravity.DOUBT, Gravity.NOTE)

_NARROW_DEG = 12.0
_WIDE_GAP_DEG = 30.0
_GAPING_DEG = 60.0
_TWO_RAYS = 0.6
_FEW_PHOTOS = 0.05
_BLURRED_PX = 1.5
_NOISY_GREY = 4.0
_BOARD_PHOTOS = 0.5
_SYSTEMATIC_PX = 0.05
_SYSTEMATIC_SIGMAS = 0.5
_ODD_PHOTO = 2.0
_MOVED_SIGMAS = 3.0
_FILLED = 0.02
_SUREST, _UNSURE_TIMES, _UNSURE = 0.25, 2.0, 0.15
"""Of the surest quarter's sigma, the multiple that is not sure, and the share of it that is told:
limbs painted all over have up to 0.10, one with paint on a twelfth of it 0.3."""
_NOT_ROUND = 0.10
_OPEN = 0.05
_LEFT_OUT = 0.02
_CHECK_OFF = 0.001
_PARTS = {
    IMAGE: "image",
    CAMERAS: "cameras",
    SCALE: "scale",
    FAR_SCALE: "far_scale",
    OFFSET: "offset",
    FACES: "faces",
    GAPS: "gaps",
    CREASES: "creases",
    UNNAMED: "unnamed",
}
"""Parts of the expected error, as findings name them."""


def findings(
    figures: Figures,
    setups: Sequence[SetupCited] = (),
    uncalibrated: SelfCalibration | None = None,
) -> tuple[Finding, ...]:
    """Findings of what limits a result and how to improve it, the gravest first."""
    rules = (
        _paint_limit,
        _scale_limits,
        _surface_limits,
        _movement_limits,
        _photo_limits,
        _geometry_limits,
        _lens_limits,
        _largest_part,
    )
    found = [finding for rule in rules for finding in rule(figures)]
    if uncalibrated is not None:
        little = COVER * uncalibrated.sigma_mm <= LENS_FOUND.green  # not so where it is not known
        make = doubt if little else fault
        found.append(make("limit.no_camera_file", cost=uncalibrated.finding))
    found += [one.finding for one in setups if one.to_do]
    return tuple(sorted(found, key=lambda one: _ORDER.index(one.gravity)))


def _paint_limit(figures: Figures) -> Iterator[Finding]:
    """Where little is seen: sigma there stands out over what this capture can do elsewhere."""
    sigma = figures.surface.sigma
    if sigma is None:
        return
    unsure = _share_beyond(sigma, _UNSURE_TIMES * _surest_mm(sigma))
    if unsure > _UNSURE:
        yield doubt("limit.paint", unsure_share=unsure, times=_UNSURE_TIMES)


def _surest_mm(sigma: SurfaceSigma) -> float:
    """Sigma below which the surest part of the area lies."""
    below = [0.0, *itertools.accumulate(sigma.area_share)]
    return float(np.interp(_SUREST, below, sigma.edges_mm))


def _share_beyond(sigma: SurfaceSigma, limit_mm: float) -> float:
    """Share of the area whose sigma is larger."""
    below = [0.0, *itertools.accumulate(sigma.area_share)]
    return 1.0 - float(np.interp(limit_mm, sigma.edges_mm, below))


def _scale_limits(figures: Figures) -> Iterator[Finding]:
    lengths, board = figures.lengths, figures.lengths.board
    if lengths.unit != "mm":
        yield fault("limit.scale.none")
        return
    if not any(map(tape_is_precise, lengths.tapes)):
        if not lengths.check:
            yield fault("limit.scale.unchecked")
        elif not lengths.checked_by_another_piece:
            yield doubt(
                "limit.scale.one_source",
                source=scale_source(lengths),
                needed_percent=100 * CHECK_TELLS,
            )
    for tape in lengths.tapes:
        if tape.reason:
            yield doubt("limit.tape.not_compared", height_mm=tape.height_mm, reason=tape.reason)
        elif sigmas_apart(tape.error_mm, tape.sigma_mm) > AGREES_SIGMAS:
            yield fault("limit.tape.conflict", height_mm=tape.height_mm, error_mm=tape.error_mm,
                        off_mm=abs(tape.error_mm), smaller=tape.error_mm > 0)  # fmt: skip
    if lengths.check_worst > _CHECK_OFF:
        yield fault(
            "limit.scale.check_off",
            label=lengths.check_worst_label,
            error_percent=100 * lengths.check_worst,
        )
    if board is not None and board.photos < _BOARD_PHOTOS * board.placed_photos:
        yield doubt("limit.scale.board_seen", photos=board.photos, placed=board.placed_photos)


def _movement_limits(figures: Figures) -> Iterator[Finding]:
    movement = figures.movement
    if movement is not None and movement.shift > 0.0:
        make = doubt if movement.alone else fault
        yield make("limit.moved", movement=movement.found)
    if movement is not None and movement.bending > 0.0:
        yield fault("limit.bent", bending=movement.bent)


def _surface_limits(figures: Figures) -> Iterator[Finding]:
    surface, around = figures.surface, figures.surface.around
    if around.missing_share > _NOT_ROUND:
        yield fault(
            "limit.surface.not_round",
            missing_share=around.missing_share,
            widest_gap_deg=around.widest_gap_deg,
        )
    if around.open_share > _OPEN:
        yield fault("limit.surface.open", missing_share=around.open_share)
    if surface.sigma is None:
        yield note("limit.surface.without_sigma")
    if surface.filled_share > _FILLED:
        yield doubt("limit.surface.filled", filled_share=surface.filled_share)
    if surface.left_out_share > _LEFT_OUT:
        yield fault("limit.surface.left_out", left_out_share=surface.left_out_share)
    few = surface.photos_per_place.below_3_share
    if few > _FEW_PHOTOS:
        yield doubt("limit.surface.few_photos", share=few)


def _photo_limits(figures: Figures) -> Iterator[Finding]:
    images = figures.images
    missing = tuple(row.name for row in images.by_photo if not row.placed)
    if missing:
        yield doubt("limit.photos.missing", count=len(missing), photos=missing)
    if images.edge_width_px > _BLURRED_PX:
        yield doubt("limit.photos.soft", edge_px=images.edge_width_px)
    if images.noise_grey > _NOISY_GREY:
        yield doubt("limit.photos.noisy", noise_grey=images.noise_grey)
    for row in images.by_photo:
        for remark in row.remarks:
            yield note("limit.photos.remark", photo=row.name, remark=remark)
    usual = figures.residuals.rms_px
    for row in figures.residuals.by_photo:
        if row.rms_px > _ODD_PHOTO * usual:
            yield doubt("limit.photos.odd", photo=row.name, rms_px=row.rms_px, usual_px=usual)


def _geometry_limits(figures: Figures) -> Iterator[Finding]:
    network = figures.network
    ring, angles = network.ring, network.angles
    if ring is not None and ring.largest_gap_deg > _WIDE_GAP_DEG:
        make = fault if ring.largest_gap_deg > _GAPING_DEG else note
        yield make("limit.photos.gap", gap_deg=ring.largest_gap_deg)
    if angles.median_deg < _NARROW_DEG:
        yield doubt("limit.photos.small_base", angle_deg=angles.median_deg)
    if network.rays.two_share > _TWO_RAYS:
        yield note("limit.photos.two_rays", share=network.rays.two_share)


def _lens_limits(figures: Figures) -> Iterator[Finding]:
    for camera, lens in zip(figures.residuals.by_camera, figures.cameras, strict=True):
        limit_px = max(_SYSTEMATIC_PX, _SYSTEMATIC_SIGMAS * figures.network.sigma0_robust_px)
        if camera.systematic_px > limit_px:
            yield doubt("limit.lens.pattern", camera=lens.name, pattern_px=camera.systematic_px)
        moved = tuple(
            one.name
            for one in lens.parameters
            if lens.source == "board" and abs(one.contradicted_sigmas) > _MOVED_SIGMAS
        )
        if moved:
            yield doubt(
                "limit.lens.contradicted",
                camera=lens.name,
                parameters=moved,
                limit_sigmas=_MOVED_SIGMAS,
            )


def _largest_part(figures: Figures) -> Iterator[Finding]:
    """The largest part of the expected error, which is where effort pays."""
    known = [one for one in figures.expected.budget if math.isfinite(one.sigma_mm)]
    if not known or figures.lengths.unit != "mm":
        return
    largest = max(known, key=lambda one: one.sigma_mm)
    yield note(
        "limit.largest_part",
        part=_PARTS[largest.part],
        sigma_mm=largest.sigma_mm,
        pixel_mm=figures.images.pixel,
    )
