"""Limits: what keeps a result from being better, with its figure, and what to do about it.

In      the figures of an assessment and the expected error.
Out     findings, the gravest first; every rule has a number and a remedy.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from limbgram.capture.certificate import SetupCited
from limbgram.core.errors import with_full_stop
from limbgram.core.interval import COVER
from limbgram.core.tape import AGREES_SIGMAS, sigmas_apart
from limbgram.reconstruction.measuring.uncertainty import CAMERAS, CREASES, OFFSET, SCALE
from limbgram.report.accuracy.figures import Figures, SurfaceSigma
from limbgram.report.accuracy.judgement import (
    FAR_SCALE,
    IMAGE,
    LENS_FOUND,
    rests_on,
    tape_tells,
)
from limbgram.report.accuracy.selfcalibration import SelfCalibration
from limbgram.report.accuracy.surface import UNNAMED

Gravity = Literal["serious", "worth doing", "note"]
_ORDER: tuple[Gravity, ...] = ("serious", "worth doing", "note")

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
_CALIBRATE = (
    "Photograph the calibration board at the same zoom and focus, then run `limbgram calibrate`."
)


@dataclass(frozen=True)
class Finding:
    """One thing that limits the result."""

    gravity: Gravity
    what: str
    remedy: str


def findings(
    figures: Figures,
    setups: Sequence[SetupCited] = (),
    uncalibrated: SelfCalibration | None = None,
) -> tuple[Finding, ...]:
    """What limits this result and how to better it, the gravest first."""
    rules = (_paint, _scale, _surface, _movement, _photographs, _geometry, _lens, _largest_part)
    found = [finding for rule in rules for finding in rule(figures)]
    if uncalibrated is not None:
        little = COVER * uncalibrated.sigma_mm <= LENS_FOUND.green  # not so where it is not known
        gravity: Gravity = "worth doing" if little else "serious"
        found.append(Finding(gravity, uncalibrated.sentence, _CALIBRATE))
    found += [
        Finding("serious" if one.outcome == "fail" else "worth doing", one.sentence, one.remark)
        for one in setups
        if one.remark
    ]
    return tuple(sorted(found, key=lambda one: _ORDER.index(one.gravity)))


def _paint(figures: Figures) -> Iterator[Finding]:
    """Where little is seen: sigma there stands out over what this capture can do elsewhere."""
    sigma = figures.surface.sigma
    if sigma is None:
        return
    unsure = _share_beyond(sigma, _UNSURE_TIMES * _quantile(sigma, _SUREST))
    if unsure > _UNSURE:
        yield Finding(
            "worth doing",
            f"Paint is missing on the surface, or few photos see it: {unsure:.0%} of what was "
            f"measured is more than {_UNSURE_TIMES:.0f} times less sure than the surest quarter "
            "(light in the picture of the uncertainty), for relief there is not seen.",
            "Dab spots of 1 to 8 mm on the bare places, no gap wider than a spot, and photograph "
            "again.",
        )


def _quantile(sigma: SurfaceSigma, share: float) -> float:
    """Sigma below which this share of the area lies."""
    below = [0.0, *itertools.accumulate(sigma.area_share)]
    return float(np.interp(share, below, sigma.edges_mm))


def _share_beyond(sigma: SurfaceSigma, limit_mm: float) -> float:
    """Share of the area whose sigma is larger."""
    below = [0.0, *itertools.accumulate(sigma.area_share)]
    return 1.0 - float(np.interp(limit_mm, sigma.edges_mm, below))


def _scale(figures: Figures) -> Iterator[Finding]:
    lengths, board = figures.lengths, figures.lengths.board
    if lengths.unit != "mm":
        yield Finding(
            "serious",
            "Nothing says how large the limb is: every length here has an unknown unit.",
            "Lay the scale board beside the limb, or give a known distance, and run again.",
        )
        return
    if not lengths.check:
        yield Finding(
            "serious",
            "No second length checks the scale: a mistyped or misprinted length goes unnoticed.",
            "Give one more known distance between marks that the photos show.",
        )
    elif not lengths.checked_by_another_piece and not any(map(tape_tells, lengths.tapes)):
        yield Finding(
            "worth doing",
            f"The scale was set by {rests_on(lengths)} alone: what checks it was printed with what "
            "set it, and a print that is too large as a whole would go unnoticed.",
            "Tape a girth of 300 mm or more where the limb hardly tapers, and say so: `--tape "
            "150=354` for 354 mm round the limb at 150 mm above the table, or `--tape widest=354`. "
            "Or measure a distance beside the limb with a steel rule, and give it with "
            "`--known-distance`.",
        )
    for tape in lengths.tapes:
        if tape.reason:
            yield Finding(
                "worth doing",
                f"The girth that was taped {tape.place} could not be compared: "
                f"{tape.reason.rstrip('.')}.",
                "Tape it where the surface has a whole girth, and say how high above the table.",
            )
        elif sigmas_apart(tape.error_mm, tape.sigma_mm) > AGREES_SIGMAS:
            yield Finding(
                "serious",
                f"The girth that was taped {tape.place} is {abs(tape.error_mm):.1f} mm "
                f"{'smaller' if tape.error_mm > 0 else 'larger'} than the surface's.",
                "Tape it again; then measure a long row of the board's squares, or the known "
                "distance, and give its true size.",
            )
    if lengths.check_worst > _CHECK_OFF:
        yield Finding(
            "serious",
            f"The check length {lengths.check_worst_label} is off by "
            f"{100 * lengths.check_worst:.2f} %.",
            "Measure that length again; look whether the board is flat and did not move.",
        )
    if board is not None and board.photos < _BOARD_PHOTOS * board.placed_photos:
        yield Finding(
            "worth doing",
            f"The scale board is seen in {board.photos} of {board.placed_photos} photos.",
            "Lay it closer to the limb, flat, so that most photos show the whole of it.",
        )


def _movement(figures: Figures) -> Iterator[Finding]:
    movement = figures.movement
    if movement is not None and movement.shift > 0.0:
        yield Finding(
            "worth doing" if movement.alone else "serious",
            movement.sentence,
            "Support the limb, take the photos in one quick walk, and let nobody touch the board.",
        )
    if movement is not None and movement.bending > 0.0:
        yield Finding(
            "serious",
            movement.bending_sentence,
            "Let the patient rest the limb so that no joint or muscle moves, calibrate the camera "
            "with a board, hold it still for each photo, and take them again.",
        )


def _surface(figures: Figures) -> Iterator[Finding]:
    surface = figures.surface
    if surface.around.missing_share > _NOT_ROUND:
        yield Finding(
            "serious",
            f"{surface.around.missing_share:.0%} of the directions round the limb have no "
            f"measured surface; the widest gap is {surface.around.widest_gap_deg:.0f} "
            "degrees.",
            "Walk all the way round in steps of 20 degrees or less; look which photos were not "
            "placed.",
        )
    if surface.around.open_share > _OPEN:
        yield Finding(
            "serious",
            f"The surface is open beyond one brim: {surface.around.open_share:.0%} of it is "
            "missing there.",
            "Take photos that look at the open places squarely, at the limb's end from above.",
        )
    if surface.sigma is None:
        yield Finding(
            "note",
            "The surface carries no uncertainty of its own: the expected error is a rough guess "
            "from the scene's points.",
            "Run `limbgram reconstruct` again with this version.",
        )
    if surface.filled_share > _FILLED:
        yield Finding(
            "worth doing",
            f"{surface.filled_share:.1%} of the surface was filled in where fewer than two "
            "photos measured it (orange in the picture).",
            "Paint what is bare there, and add photos that look at those places squarely, from "
            "above and below as needed.",
        )
    if surface.left_out_share > _LEFT_OUT:
        yield Finding(
            "serious",
            f"{surface.left_out_share:.1%} of what was measured of the surface was torn off by "
            "a bare strip, or hangs on nothing, and is not in it.",
            "Look whether the wanted side is there; paint bare places and overlap more.",
        )
    few = surface.photos_per_place.below_3_share
    if few > _FEW_PHOTOS:
        yield Finding(
            "worth doing",
            f"{few:.1%} of the surface is seen by fewer than three photos within 65 degrees: "
            "nothing checks the measurement there.",
            "Walk round in smaller steps, and once more higher or lower.",
        )


def _photographs(figures: Figures) -> Iterator[Finding]:
    images = figures.images
    missing = [row.name for row in images.by_photo if not row.placed]
    if missing:
        yield Finding(
            "worth doing",
            f"{len(missing)} photos could not be placed ({', '.join(missing[:4])}"
            f"{' ...' if len(missing) > 4 else ''}).",
            "The table of photos says why, and what to do, for each.",
        )
    if images.edge_width_px > _BLURRED_PX:
        yield Finding(
            "worth doing",
            f"The photos are soft: the sharpest edges are {images.edge_width_px:.1f} px wide.",
            "Hold the camera still, use a shorter exposure or a flash, focus on the limb.",
        )
    if images.noise_grey > _NOISY_GREY:
        yield Finding(
            "worth doing",
            f"The photos are noisy: {images.noise_grey:.1f} grey levels.",
            "More light and a lower ISO number.",
        )
    for row in images.by_photo:
        for remark in row.remarks:
            yield Finding(
                "note", with_full_stop(f"{row.name}: {remark}"), "Take that photo again if you can."
            )
    usual = figures.residuals.rms_px
    for row in figures.residuals.by_photo:
        if row.rms_px > _ODD_PHOTO * usual:
            yield Finding(
                "worth doing",
                f"{row.name} fits worse than the others: {row.rms_px:.2f} px against "
                f"{usual:.2f} px.",
                "Leave it out or take it again.",
            )


def _geometry(figures: Figures) -> Iterator[Finding]:
    network = figures.network
    ring, angles = network.ring, network.angles
    if ring is not None and ring.largest_gap_deg > _WIDE_GAP_DEG:
        gaping = ring.largest_gap_deg > _GAPING_DEG
        yield Finding(
            "serious" if gaping else "note",
            f"The widest gap between photos, seen from the limb, is "
            f"{ring.largest_gap_deg:.0f} degrees.",
            "Take photos in steps of 20 degrees or less all the way round.",
        )
    if angles.median_deg < _NARROW_DEG:
        yield Finding(
            "worth doing",
            f"The base is small: rays meet at {angles.median_deg:.0f} degrees (median), which "
            "leaves depth uncertain.",
            "Walk round the limb rather than turn the camera; keep 15 to 20 degrees between "
            "photos that show the same place.",
        )
    if network.rays.two_share > _TWO_RAYS:
        yield Finding(
            "note",
            f"{network.rays.two_share:.0%} of the points are seen by two photos only.",
            "More overlap: smaller steps, or a second round at another height.",
        )


def _lens(figures: Figures) -> Iterator[Finding]:
    for camera, lens in zip(figures.residuals.by_camera, figures.cameras, strict=True):
        name = lens.name
        limit_px = max(_SYSTEMATIC_PX, _SYSTEMATIC_SIGMAS * figures.network.sigma0_robust_px)
        if camera.systematic_px > limit_px:
            yield Finding(
                "worth doing",
                f"The residuals of {name} follow a pattern over the picture "
                f"({camera.systematic_px:.3f} px): its lens is not what the calibration says.",
                "Calibrate again at the zoom and focus of these photos, with the board reaching "
                "into every corner of the picture.",
            )
        moved = [
            one.name
            for one in lens.parameters
            if lens.source == "board" and abs(one.contradicted_sigmas) > _MOVED_SIGMAS
        ]
        if moved:
            yield Finding(
                "worth doing",
                f"The photos contradict the calibration of {name} by more than three sigmas "
                f"({', '.join(moved)}).",
                "Was the focus or zoom touched since? Calibrate again with this set-up.",
            )


def _largest_part(figures: Figures) -> Iterator[Finding]:
    """The largest part of the expected error, which is where effort pays."""
    known = [one for one in figures.expected.budget if math.isfinite(one.sigma_mm)]
    if not known or figures.lengths.unit != "mm":
        return
    largest = max(known, key=lambda one: one.sigma_mm)
    pixel = figures.images.pixel
    larger = "A larger board, closer to the limb and in more photos; or a longer known distance."
    overlap = "More overlap between photos, and a fresh calibration with more board photos."
    remedies = {
        IMAGE: f"A pixel is {pixel:.2f} mm on the limb: come closer, or use more "
        "pixels; more photos help with their square root only.",
        CAMERAS: overlap,
        SCALE: larger,
        FAR_SCALE: larger,
        OFFSET: "Sharper photos, or photos from nearer: it goes with the size of a pixel.",
        CREASES: "Sharper photos, or photos from nearer: the surface does not reach into them.",
        UNNAMED: f"{overlap} {larger}",
    }
    yield Finding(
        "note",
        f"The largest part of the expected error is {largest.part}: "
        f"{largest.sigma_mm:.3f} mm (one sigma).",
        remedies[largest.part],
    )
