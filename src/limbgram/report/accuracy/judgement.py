"""The judgement: green, amber or red in millimetres, with the reason, and the criteria behind it.

In      the figures of an assessment.
Out     criteria, each with its limits and light; the worst one gives the light of the whole.
Limits  for capture of limb shapes: a tenth of a percent of scale and a few tenths of a millimetre
        of surface are below what a socket's fit shows; beyond the red limits a girth or volume is
        wrong by one ply of sock.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from scipy.special import ndtri

from limbgram.capture.setup import SetupCited
from limbgram.core.interval import COVER
from limbgram.core.tape import AGREES_SIGMAS, CONTRADICTS_SIGMAS, sigmas_apart
from limbgram.findings import Finding, Gravity, Value, note
from limbgram.reconstruction.calibration.cameras import SQUARE_WITHIN, square_pixel_tolerance
from limbgram.reconstruction.mapping.zoom import zoomed_photos
from limbgram.reconstruction.measuring.uncertainty import CAMERAS
from limbgram.reconstruction.scale.displaced_board import tipped_photos
from limbgram.report.accuracy.figures import (
    CHECK_TELLS,
    BudgetPart,
    ExpectedError,
    Figures,
    LengthFigures,
    LensFigures,
    MovementFigures,
    NetworkFigures,
    SurfaceFigures,
    TapedLength,
    TruthFigures,
    independent_checks,
    length_unit,
)
from limbgram.report.accuracy.selfcalibration import SelfCalibration
from limbgram.report.verdict_light import Light

_ORDER: tuple[Light, ...] = ("green", "amber", "red")
_GRAVITIES: dict[Light, Gravity] = {
    "green": Gravity.NOTE,
    "amber": Gravity.DOUBT,
    "red": Gravity.FAULT,
}

IMAGE, FAR_SCALE = "image measurement", "scale, at the far end"
"""Parts of the expected error beside those that the mesh names."""
_SIGMAS_KNOWN_TO = 0.14
"""Relative standard deviation of how well the sigmas of a whole capture are known: of the true over
the expected distance that 95 % of the surface keep, of 57 captures with dense to little paint."""
_PROMISED = math.exp(float(ndtri(0.95)) * _SIGMAS_KNOWN_TO)
"""What 95 of 100 captures keep, over what half of them keep."""
_FORMAL_TOO_SMALL = 4.0
"""Formal sigmas of matching were found three to four times too small against known truth."""


@dataclass(frozen=True, kw_only=True)
class Criterion:
    """One figure against its limits: green up to `green`, red beyond `red`."""

    key: str
    title: str
    value: float
    unit: str
    green: float
    red: float
    light: Light
    finding: Finding
    """Says the figure and what it is of."""


@dataclass(frozen=True)
class _Limit:
    key: str
    title: str
    unit: str
    green: float
    red: float = math.inf
    """Infinite where the figure alone spoils nothing."""

    def judge(
        self, code: str, value: float, /, unknown: Light = "amber", **values: Value
    ) -> Criterion:
        """Judge a figure by its limits; an unknown figure gets the light `unknown`."""
        return self.judged(value, Finding(code, values=values), unknown)

    def judged(self, value: float, finding: Finding, unknown: Light = "amber") -> Criterion:
        """Judge a figure, with a finding whose gravity follows from the light."""
        if not math.isfinite(value):
            light: Light = unknown
        elif value <= self.green:
            light = "green"
        else:
            light = "amber" if value <= self.red else "red"
        said = _with_gravity_of(finding, light)
        return Criterion(**asdict(self), value=value, light=light, finding=said)


SCALE = _Limit("scale_check", "Scale: worst check length", "%", 0.1, 0.3)
SCALE_SIGMA = _Limit("scale_sigma", "Scale: uncertainty (two sigma)", "%", 0.1, 0.3)
SURFACE_P95 = _Limit("surface_p95", "Surface: error within which 95 % lies", "mm", 0.6, 1.0)
SURFACE_RMS = _Limit("surface_rms", "Surface: RMS error", "mm", 0.3, 0.5)
FILLED = _Limit("filled", "Surface filled in, not measured", "%", 5.0, 25.0)
LEFT_OUT = _Limit("left_out", "Surface measured but left out", "%", 5.0, 25.0)
WHICH = _Limit("which_part", "Bodies beside the surface, none of them chosen by you", "", 0.0, 20.0)
"""Never red: a body is a twentieth of all, so there are at most twenty."""
MISSING = _Limit("photos_missing", "Photos that could not be placed", "%", 10.0, 50.0)
GAP = _Limit("gap", "Widest gap between photos, seen from the limb", "deg", 60.0, 150.0)
AROUND = _Limit("around", "Directions round the limb without surface", "%", 10.0, 25.0)
"""A tape over a gap of 10 % of the way round (36 degrees) of a 50 mm radius reads 0.5 mm too
little, over one of 25 % 7.8 mm: 2 r (a - sin a) for half the gap's angle a. Good captures have 0 to
2 %."""
OPEN = _Limit("open", "Surface missing beyond one brim", "%", 5.0, 25.0)
"""A limb of 50 mm radius and 240 mm that is open at its distal end too has 8 %, half a shell 40 %,
good captures 0 to 1 %."""
LENS = _Limit("lens", "Camera: photos against its calibration", "sigmas", 3.0)
"""Never red by itself: what it does to the size, a length tells. Six good captures have 0.5 to 1.0,
one with a focal length 3 % wrong 6.6."""
LENS_PATTERN = _Limit("lens_pattern", "Camera: pattern in the residuals", "px", 0.05)
ZOOMED = _Limit("zoomed", "Photos of another focal length", "", 0.0)
"""Never red by itself: their focal lengths are solved for, and a lens that was zoomed differs in
more than that."""
SQUARE = _Limit(
    "square_pixels", "Camera: pixels higher than wide, or wider", "%", 100 * SQUARE_WITHIN
)
"""Never red by itself, as the others of a camera. Sensors are made with square pixels; what a lens
is found to have else was done to it: a picture read row by row from a hand that moved, one shifted
by a stabiliser, a calibration board that is stretched. Half of it goes into sizes. Good captures
have 0.000 to 0.007 %, a phone's with a rolling shutter 0.37 %."""
_PATTERN_SIGMAS = 0.5
"""A pattern below so many sigmas of one coordinate is not told from noise."""
TAPE = _Limit(
    "tape", "Taped girth against the surface", "sigmas", AGREES_SIGMAS, CONTRADICTS_SIGMAS
)
"""Of tape and surface together, by the rule of `core.tape`."""
MOVED = _Limit("movement", "Movement of the limb", "mm", 0.0)
"""Green only where none was found: its size says how far a rigid limb moved, not by how much its
soft parts gave way. Where the limb alone places the photos it is never red by itself."""
_MOVED_RED_MM = 1.0
"""Where limb and surroundings place the photos together, a shift of half the photos goes into the
surface by half, and girths are wrong by a ply of sock."""
TIPPED = _Limit("board_tipped", "Photos that show the board in another plane", "", 0.0, 0.0)
"""Red at once where the limb is not known to have kept still: an object that was turned over stands
in the scene twice then, and no figure of the surface tells it."""
BENT = _Limit("bending", "Bending of the limb", "mm", 0.0, _MOVED_RED_MM)
FOCUSED = _Limit("focused", "Scale against the distance in EXIF", "times", 1.5, 3.0)
"""Lenses tell their distance in coarse steps and from the sensor: only a clear contradiction
counts, such as inches taken for centimetres."""
LENS_FOUND = _Limit("lens_found", "Camera without a file: its part of the error", "mm", 0.3)
"""Half of what the surface may be wrong by; never red by itself: the surface's limits hold it."""
SETUP = _Limit("setup", "Acceptance tests that the kit failed", "", 0.0)
"""Never red by itself: the error that it found shows in a length or not at all in this capture."""
MEAN = _Limit("surface_mean", "Surface: mean signed distance", "mm", 0.10, 0.25)
SPREAD = _Limit("surface_iqr", "Surface: interquartile range (IQR)", "mm", 0.25, 0.40)
GIRTH = _Limit("girth", "Girth: worst error", "mm", 1.0, 1.6)
VOLUME = _Limit("volume", "Volume: error", "%", 0.5, 1.1)


def expectation(
    surface: SurfaceFigures,
    lengths: LengthFigures,
    network: NetworkFigures,
    movement: MovementFigures | None,
) -> ExpectedError:
    """The error to expect on the surface, mm, and what it is made of.

    None is stated (NaN) where something that would show on the surface is not decided: sigmas hold
    for photos that are explained.

    With vertex sigmas: from those; each source's part is its own RMS over the same area, so the
    parts add up in squares to the whole. What 95 % of the surface keep is a promise, which 95 of
    100 captures keep, as sigmas too are known to a part of themselves. Without: four times the
    formal sigma of the scene's points, and the scale at the far end.
    """
    found = _expected_parts(surface, lengths, network)
    if movement is None or not movement.unexplained:
        return found
    return replace(found, rms_mm=math.nan, p95_mm=math.nan)


def _expected_parts(
    surface: SurfaceFigures, lengths: LengthFigures, network: NetworkFigures
) -> ExpectedError:
    sigma = surface.sigma
    if sigma is not None:
        return ExpectedError(
            basis="vertex sigmas",
            rms_mm=sigma.rms_mm,
            p95_mm=_PROMISED * sigma.expected_error_p95_mm,
            budget=_budget({IMAGE: sigma.own_rms_mm, **sigma.shares_mm}),
        )
    arm = max(surface.size) / 2
    scale_mm = scale_sigma(lengths) * arm  # NaN where nothing tells: unknown is not 0
    image_mm = _FORMAL_TOO_SMALL * network.point_sigma.median
    rms_mm = image_mm if math.isnan(scale_mm) else math.hypot(image_mm, scale_mm)
    return ExpectedError(
        basis="points of the scene",
        rms_mm=rms_mm,
        p95_mm=COVER * rms_mm,
        budget=_budget({IMAGE: image_mm, CAMERAS: math.nan, FAR_SCALE: scale_mm}),
    )


def scale_sigma(lengths: LengthFigures) -> float:
    """Standard deviation of the scale, a fraction: as estimated, or as the checks show it."""
    known = [one for one in (lengths.relative_sigma, lengths.check_rms) if not math.isnan(one)]
    return max(known, default=math.nan)


def _budget(parts_mm: dict[str, float]) -> tuple[BudgetPart, ...]:
    """The parts of the expected error, one standard deviation each."""
    return tuple(BudgetPart(part=part, sigma_mm=sigma_mm) for part, sigma_mm in parts_mm.items())


def criteria(
    figures: Figures,
    setups: Sequence[SetupCited] = (),
    uncalibrated: SelfCalibration | None = None,
) -> tuple[Criterion, ...]:
    """Every figure that has a limit, judged; a lens without a file, the tests of the kit."""
    truth = figures.truth
    surface = _expected_error_criteria(figures) if truth is None else _truth_criteria(truth)
    return (
        *_scale_criterion(figures),
        *_independent_checks(figures),
        *surface,
        *_completeness_criteria(figures),
        *_camera_criteria(figures),
        *_zoom_criteria(figures),
        *_uncalibrated_criterion(figures, uncalibrated),
        *kit_criteria(setups),
        *_movement_criteria(figures),
    )


def worst(judged: Sequence[Criterion]) -> Light:
    """The worst light of all criteria."""
    return _ORDER[max(_ORDER.index(one.light) for one in judged)]


def headline(figures: Figures, judged: Sequence[Criterion]) -> Finding:
    """The first line: the light and its reasons, then surface and scale in figures."""
    light = worst(judged)
    verdict = _with_gravity_of(_verdict(figures, judged, light), light)
    return _with_gravity_of(note("verdict.headline", light=light, verdict=verdict), light)


def without_light(headline: Finding) -> Finding:
    """A headline without the name of its light, for where the light itself is shown.

    That of a file of an earlier version, which has no values, stays whole.
    """
    said = headline.values.get("verdict")
    return said if isinstance(said, Finding) else headline


def findings_in(headline: Finding) -> tuple[Finding, ...]:
    """The findings in a headline."""
    values = without_light(headline).values.values()
    return tuple(one for one in values if isinstance(one, Finding))


def _verdict(figures: Figures, judged: Sequence[Criterion], light: Light) -> Finding:
    doubts = [one for one in reasons(judged) if one.light == light]
    if figures.lengths.unit != "mm":
        first, second = _reasons([one for one in doubts if one is not judged[0]])
        return note("verdict.no_size", size=judged[0].finding, first=first, second=second)
    main = next(one for one in judged if one.key == SURFACE_P95.key)
    scale = _scale_finding(figures)
    if light == "green":
        return note("verdict.green", p95_mm=main.value, limit_mm=main.green, scale=scale)
    alone = next((one for one in doubts if one is main), doubts[0])
    first, second = _reasons([one for one in doubts if one is not main])
    sure = math.isfinite(main.value) and main.light == "green"  # makes up for nothing missing
    return note(
        "verdict.doubtful",
        first=first or alone.finding,
        second=second,
        p95_mm=main.value if sure else None,
        scale=scale,
    )


def _with_gravity_of(finding: Finding, light: Light) -> Finding:
    return replace(finding, gravity=_GRAVITIES[light])


def reasons(judged: Sequence[Criterion]) -> tuple[Criterion, ...]:
    """Criteria that are not green, the worst first; completeness and tapes first among equals."""
    doubtful = [one for one in judged if one.light != "green"]
    first = (AROUND.key, GAP.key, TAPE.key)
    return tuple(sorted(doubtful, key=lambda one: (-_ORDER.index(one.light), one.key not in first)))


def size_is_checked(figures: Figures) -> bool:
    """Whether a length independent of the scale's source agrees with it.

    Lengths between a board's own corners are no such lengths: a board printed too large as a whole
    is too large in all of them. Nor are bars and mats that the same printer made. A girth counts
    where the tape can tell, and then every such tape has to agree, whatever else agrees. A true
    surface agrees up to the red limit: its scale error also holds a skin that lies too far out.
    """
    lengths = figures.lengths
    if lengths.unit != "mm":
        return False
    if figures.truth is not None:
        return 100 * abs(figures.truth.scale_error) <= SCALE.red
    if any(map(tape_is_precise, lengths.tapes)):
        return math.isfinite(confirmed_by_tape(lengths))
    return _confirmed_by_length(lengths)


def _confirmed_by_length(lengths: LengthFigures) -> bool:
    """Whether there are independent check lengths, and all of them agree."""
    others = independent_checks(lengths.control, lengths.check)
    return bool(others) and all(100 * abs(one.error) <= SCALE.green for one in others)


def confirmed_by_tape(lengths: LengthFigures) -> float:
    """The share of the size to which tapes confirm it; NaN where they do not."""
    telling = [one for one in lengths.tapes if tape_is_precise(one)]
    agree = all(sigmas_apart(one.error_mm, one.sigma_mm) <= AGREES_SIGMAS for one in telling)
    return min(map(_tape_precision, telling)) if telling and agree else math.nan


def tape_is_precise(tape: TapedLength) -> bool:
    """Whether a tape is precise enough to check the size."""
    return _tape_precision(tape) <= CHECK_TELLS  # NaN where it could not be compared


def _tape_precision(tape: TapedLength) -> float:
    """Two sigmas of a tape, as a share of what it read."""
    return AGREES_SIGMAS * tape.sigma_mm / tape.read_mm


def _scale_finding(figures: Figures) -> Finding:
    """A finding of what set the scale, how well check lengths agree, and of independent checks."""
    lengths = figures.lengths
    count, error = len(lengths.check), 100 * lengths.check_worst
    agree = count > 0 and error <= SCALE.green
    checked, vague, sure = "no", None, None
    if not size_is_checked(figures):
        by_tape = figures.truth is None and any(map(tape_is_precise, lengths.tapes))
        if by_tape and lengths.checked_by_another_piece:
            checked = "contradicted"
        elif figures.truth is not None or (lengths.checked_by_another_piece and not by_tape):
            checked = "disagrees"
        else:
            vague = _vague_tape_findings(lengths) or None
    elif figures.truth is not None or _confirmed_by_length(lengths):
        checked = "length"
    else:
        checked, sure = "tape", 100 * confirmed_by_tape(lengths)
    return note(
        "verdict.scale",
        source=scale_source(lengths),
        count=count if agree else 0,
        error_percent=error,
        checked=checked,
        why=vague,
        sure_percent=sure,
    )


def scale_source(lengths: LengthFigures) -> Literal["prints", "distances", "distance", "board"]:
    """What the scale was set by: the prints of one printer, known distances, or one of a kind."""
    if any(one.between in ("plate", "marks") for one in (*lengths.control, *lengths.check)):
        return "prints"
    if lengths.source == "distances":
        return "distances" if len(lengths.control) > 1 else "distance"
    return "board"


def _vague_tape_findings(lengths: LengthFigures) -> tuple[Finding, ...]:
    """Findings about tapes too imprecise to check the size; none where one is precise enough."""
    sure = min((_tape_precision(one) for one in lengths.tapes if not one.reason), default=None)
    if sure is None:
        return tuple(
            note("verdict.tape.unseen", height_mm=one.height_mm, reason=one.reason)
            for one in lengths.tapes
        )
    if sure <= CHECK_TELLS:
        return ()
    said = note("verdict.tape.unsure", sure_percent=100 * sure, needed_percent=100 * CHECK_TELLS)
    return (said,)


def _reasons(grave: Sequence[Criterion]) -> tuple[Finding | None, Finding | None]:
    """The first two reasons but the surface's RMS, which mostly says what its 95 % say."""
    first, second, *_more = (
        *(one.finding for one in grave if one.key != SURFACE_RMS.key),
        None,
        None,
    )
    return first, second


def _scale_criterion(figures: Figures) -> tuple[Criterion, ...]:
    lengths = figures.lengths
    if lengths.unit != "mm":
        return (SCALE.judge("verdict.scale.unknown", math.nan, "red"),)
    return _check_criterion(lengths), _scale_sigma_criterion(figures)


def _check_criterion(lengths: LengthFigures) -> Criterion:
    """The criterion of check lengths, which did not set the scale."""
    error = 100 * lengths.check_worst
    if not lengths.check:
        return SCALE.judge("verdict.scale.unchecked", error)
    if error <= SCALE.green:
        return SCALE.judge(
            "verdict.scale.agrees",
            error,
            count=len(lengths.check),
            error_percent=error,
            limit_percent=SCALE.green,
        )
    return SCALE.judge(
        "verdict.scale.off",
        error,
        label=lengths.check_worst_label,
        error_percent=error,
        limit_percent=SCALE.green,
    )


def _scale_sigma_criterion(figures: Figures) -> Criterion:
    """The criterion of the scale's sigma; where it is too large, with the reason and advice."""
    two_sigma, limit = 200 * figures.lengths.relative_sigma, SCALE_SIGMA.green
    stretch = figures.lengths.board_stretch
    if not two_sigma > limit:
        return SCALE_SIGMA.judge(
            "verdict.scale.sure", two_sigma, two_sigma_percent=two_sigma, limit_percent=limit
        )
    if stretch == 0:
        return SCALE_SIGMA.judge(
            "verdict.scale.vague", two_sigma, two_sigma_percent=two_sigma, limit_percent=limit
        )
    longer, shorter = ("x", "y") if stretch > 0 else ("y", "x")
    by: dict[str, Any] = {}
    if figures.movement is not None and figures.movement.alone:
        code = "verdict.scale.beside_moved"
    elif figures.lengths.stretch_doubt == "none":
        code = "verdict.scale.stretched"
    else:
        code, by = "verdict.scale.stretched_or_lens", {"by": figures.lengths.stretch_doubt}
    return SCALE_SIGMA.judge(
        code,
        two_sigma,
        two_sigma_percent=two_sigma,
        limit_percent=limit,
        stretch_percent=100 * abs(stretch),
        longer=longer,
        shorter=shorter,
        **by,
    )


def _independent_checks(figures: Figures) -> Iterator[Criterion]:
    """Criteria of checks independent of the scale's source: tapes, and the distance in EXIF."""
    if figures.lengths.unit != "mm":
        return
    for tape in figures.lengths.tapes:
        yield _tape_finding(tape, figures.lengths.source)
    ratio = figures.images.distance_over_stated
    if math.isfinite(ratio):
        factor = max(ratio, 1 / ratio)
        yield FOCUSED.judge(
            "verdict.focused.elsewhere" if factor > FOCUSED.green else "verdict.focused.there",
            factor,
            factor=factor,
            near=ratio > 1,
        )


def _tape_finding(tape: TapedLength, source: str) -> Criterion:
    """A reading that cannot be compared says nothing against the surface."""
    if tape.reason:
        return TAPE.judge(
            "verdict.tape.not_compared",
            math.nan,
            "green",
            height_mm=tape.height_mm,
            reason=tape.reason,
        )
    apart = sigmas_apart(tape.error_mm, tape.sigma_mm)
    return TAPE.judge(
        "verdict.tape.agrees" if apart <= TAPE.green else "verdict.tape.contradicts",
        apart,
        height_mm=tape.height_mm,
        read_mm=tape.read_mm,
        measured_mm=tape.measured_mm,
        error_share=tape.error,
        sure_mm=COVER * tape.sigma_mm,
        source=source,
    )


def _uncalibrated_criterion(figures: Figures, found: SelfCalibration | None) -> Iterator[Criterion]:
    """Never green where nobody can say what a lens without a file costs, or where it costs much."""
    if found is not None and figures.lengths.unit == "mm":
        yield LENS_FOUND.judged(COVER * found.sigma_mm, found.finding)


def kit_criteria(setups: Sequence[SetupCited]) -> Iterator[Criterion]:
    """Criteria of kits: green where a kit passed its test and the test is still valid.

    One that failed is amber. So is one of which nothing is known: the test could not tell, or was
    made longer ago than it was meant to count for.
    """
    for one in setups:
        if one.outcome == "fail":
            yield SETUP.judge("verdict.kit.proved", 1.0, test=one.finding)
        elif one.outcome == "cannot tell" or one.expired:
            yield SETUP.judge("verdict.kit.unproved", math.nan, test=one.finding)
        else:
            yield SETUP.judge("verdict.kit.proved", 0.0, test=one.finding)


def _camera_criteria(figures: Figures) -> Iterator[Criterion]:
    """Criteria of calibrations that the photos contradict."""
    limit_px = max(LENS_PATTERN.green, _PATTERN_SIGMAS * figures.network.sigma0_robust_px)
    for camera, lens in zip(figures.residuals.by_camera, figures.cameras, strict=True):
        file = lens.contradicted
        if file is not None:
            yield LENS.judge(
                "verdict.lens.not_used",
                file.sigmas,
                camera=lens.name,
                given_px=file.given_px,
                shown_px=file.shown_px,
            )
        if lens.source != "board":
            continue
        free = [one for one in lens.parameters if math.isfinite(one.contradicted_sigmas)]
        if free:
            worst_one = max(free, key=lambda one: abs(one.contradicted_sigmas))
            sigmas = abs(worst_one.contradicted_sigmas)
            yield LENS.judge(
                "verdict.lens.contradicted" if sigmas > LENS.green else "verdict.lens.agrees",
                sigmas,
                camera=lens.name,
                parameter=worst_one.name,
                sigmas=sigmas,
            )
        yield _has_square_pixels(lens)
        pattern = camera.systematic_px
        if math.isfinite(pattern):
            yield replace(LENS_PATTERN, green=limit_px).judge(
                "verdict.pattern.seen" if pattern > limit_px else "verdict.pattern.none",
                pattern,
                camera=lens.name,
                pattern_px=pattern,
            )


def _zoom_criteria(figures: Figures) -> Iterator[Criterion]:
    """Nothing is said where all photos have the focal length of their camera."""
    names = [one.name for one in figures.images.by_photo if one.zoomed]
    if names:
        yield ZOOMED.judged(float(len(names)), zoomed_photos(names, figures.images.photos))


def _has_square_pixels(lens: LensFigures) -> Criterion:
    """Whether the pixels of a lens are as wide as high, as those of sensors are.

    Both as it was calibrated and as the photos have it: the adjustment holds a board's calibration
    to square pixels.
    """
    named = {one.name: one for one in lens.parameters}
    fx, fy = named["fx"], named["fy"]
    found, calibrated = fx.value / fy.value - 1, fx.calibrated / fy.calibrated - 1
    of_file = abs(calibrated) > abs(found)
    off = 100 * (calibrated if of_file else found)
    limit = replace(SQUARE, green=100 * square_pixel_tolerance(lens.width_px, lens.height_px))
    return limit.judge(
        "verdict.pixels.square" if abs(off) <= limit.green else "verdict.pixels.stretched",
        abs(off),
        camera=lens.name,
        of_file=of_file,
        off_percent=abs(off),
        wider=off < 0,
        limit_percent=limit.green,
    )


def _movement_criteria(figures: Figures) -> Iterator[Criterion]:
    """Criteria of whether the limb kept still and kept its shape.

    Nothing is said where it could not be looked for; where something does not fit and only its
    cause is not known, that is a doubt.
    """
    movement = figures.movement
    yield from _tipped_board_criteria(
        figures, kept_still=movement is not None and movement.shift == 0.0
    )
    if movement is None:
        return
    unit = length_unit(figures.lengths.unit)
    moved, bent = (replace(limit, unit=unit) for limit in (MOVED, BENT))
    known = all(lens.source == "board" for lens in figures.cameras)
    if movement.misfit:
        said = movement.found
        yield moved.judge("verdict.misfit.moved", math.nan, movement=said, calibrated=known)
    if movement.bending_misfit:
        said = movement.bent
        yield bent.judge("verdict.misfit.bent", math.nan, bending=said, calibrated=known)
    if math.isfinite(movement.shift):
        said = movement.found
        if movement.shift > 0.0 and movement.alone:
            yield moved.judge("verdict.moved.alone", movement.shift, movement=said)
        elif movement.shift > 0.0:
            limit = replace(moved, red=_MOVED_RED_MM)
            yield limit.judge("verdict.moved.together", movement.shift, movement=said)
        else:
            yield moved.judged(movement.shift, said)
    if movement.bent is not None and math.isfinite(movement.bending):
        said = movement.bent
        if movement.bending:
            yield bent.judge("verdict.bent", movement.bending, bending=said)
        else:
            yield bent.judged(movement.bending, said)


def _tipped_board_criteria(figures: Figures, *, kept_still: bool) -> Iterator[Criterion]:
    """Whether photos that show the board in another plane may show the object in another pose."""
    tipped = tipped_photos(figures.images.set_aside)
    if tipped and not kept_still:
        count, others = len(tipped), tipped[0].values["others"]
        yield TIPPED.judge("verdict.board_tipped", float(count), photos=count, others=others)


def _expected_error_criteria(figures: Figures) -> tuple[Criterion, ...]:
    expected = figures.expected
    if figures.lengths.unit != "mm":
        return ()
    p95, rms = expected.p95_mm, expected.rms_mm
    if figures.movement is not None and figures.movement.unexplained:
        return (
            SURFACE_P95.judge("verdict.surface.withdrawn", math.nan),
            SURFACE_RMS.judge("verdict.surface.withdrawn", math.nan),
        )
    return (
        SURFACE_P95.judge("verdict.surface.expected", p95, p95_mm=p95, limit_mm=SURFACE_P95.green),
        SURFACE_RMS.judge(
            "verdict.surface.expected_rms", rms, rms_mm=rms, limit_mm=SURFACE_RMS.green
        ),
    )


def _truth_criteria(truth: TruthFigures) -> tuple[Criterion, ...]:
    p95, rms, mean, iqr = truth.p95_mm, truth.rms_mm, truth.mean_mm, truth.iqr_mm
    girth = max((abs(one.error_mm) for one in truth.girths), default=math.nan)
    volume = 100 * abs(truth.volume_error)
    return (
        SURFACE_P95.judge("verdict.truth.p95", p95, p95_mm=p95, limit_mm=SURFACE_P95.green),
        SURFACE_RMS.judge("verdict.truth.rms", rms, rms_mm=rms),
        MEAN.judge("verdict.truth.mean", abs(mean), mean_mm=mean, limit_mm=MEAN.green),
        SPREAD.judge("verdict.truth.spread", iqr, iqr_mm=iqr, limit_mm=SPREAD.green),
        GIRTH.judge("verdict.truth.girth", girth, error_mm=girth),
        VOLUME.judge("verdict.truth.volume", volume, error_percent=volume),
    )


def _completeness_criteria(figures: Figures) -> tuple[Criterion, ...]:
    surface, images = figures.surface, figures.images
    ring = figures.network.ring
    gap = math.nan if ring is None else ring.largest_gap_deg
    around = surface.around
    round_about, beyond = 100 * around.missing_share, 100 * around.open_share
    filled, left_out = 100 * surface.filled_share, 100 * surface.left_out_share
    missing = images.photos - images.placed
    return (
        AROUND.judge(
            "verdict.around.missing" if round_about > AROUND.green else "verdict.around.whole",
            round_about,
            missing_percent=round_about,
            widest_gap_deg=around.widest_gap_deg,
        ),
        OPEN.judge(
            "verdict.open.beyond" if beyond > OPEN.green else "verdict.open.one_brim",
            beyond,
            missing_percent=beyond,
        ),
        FILLED.judge("verdict.filled", filled, filled_percent=filled),
        LEFT_OUT.judge("verdict.left_out", left_out, left_out_percent=left_out),
        _body_choice_criterion(surface),
        MISSING.judge(
            "verdict.photos_missing",
            100 * missing / max(images.photos, 1),
            missing=missing,
            photos=images.photos,
        ),
        GAP.judge("verdict.gap.wide" if gap > GAP.green else "verdict.gap.usual", gap, gap_deg=gap),
    )


def _body_choice_criterion(surface: SurfaceFigures) -> Criterion:
    """The criterion of which body is meant; the other side of its wall is no rival."""
    rivals = [one for one in surface.other_parts if one.relation == "apart"]
    count = 0 if surface.part_given else len(rivals)
    return WHICH.judge(
        "verdict.part.rivals" if count else "verdict.part.clear",
        float(count),
        count=count,
        numbers=tuple(one.number for one in rivals),
    )
