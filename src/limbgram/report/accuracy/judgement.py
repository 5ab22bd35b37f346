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
from typing import Literal

from limbgram.capture.certificate import SetupCited
from limbgram.core.interval import COVER
from limbgram.core.tape import AGREES_SIGMAS, CONTRADICTS_SIGMAS, sigmas_apart
from limbgram.findings import told
from limbgram.reconstruction.calibration.cameras import SQUARE_WITHIN, squareness
from limbgram.reconstruction.mapping.zoom import zoomed_photos
from limbgram.reconstruction.measuring.uncertainty import CAMERAS
from limbgram.reconstruction.scale.marks import marks_of_label
from limbgram.report.accuracy.figures import (
    BudgetPart,
    ExpectedError,
    Figures,
    LengthFigures,
    LensFigures,
    NetworkFigures,
    SurfaceFigures,
    TapedLength,
    TruthFigures,
)
from limbgram.report.accuracy.selfcalibration import SelfCalibration

Light = Literal["green", "amber", "red"]
_ORDER: tuple[Light, ...] = ("green", "amber", "red")

IMAGE, FAR_SCALE = "image measurement", "scale, at the far end"
"""Parts of the expected error beside those that the mesh names."""
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
    sentence: str
    """For people; says the figure and what it is of."""


@dataclass(frozen=True)
class _Limit:
    key: str
    title: str
    unit: str
    green: float
    red: float = math.inf
    """Infinite where the figure alone spoils nothing."""

    def judge(self, value: float, sentence: str, unknown: Light = "amber") -> Criterion:
        """Compare; a figure that is not known gets the light `unknown`."""
        if not math.isfinite(value):
            light: Light = unknown
        elif value <= self.green:
            light = "green"
        else:
            light = "amber" if value <= self.red else "red"
        return Criterion(**asdict(self), value=value, light=light, sentence=sentence)


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
TAPE_TELLS = 0.01
"""Of the girth: a tape checks the size where its two sigmas are no more. 1 % of a
girth of 350 mm is less than two plies of sock, and a print fitted to the page is 3 % off or more. A
tape reaches 1 % on a girth of 300 mm that does not taper."""
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
    surface: SurfaceFigures, lengths: LengthFigures, network: NetworkFigures
) -> ExpectedError:
    """The error to expect on the surface, mm, and what it is made of.

    With vertex sigmas: from those; each source's part is its own RMS over the same area, so the
    parts add up in squares to the whole. Without: four times the formal sigma of the scene's
    points, and the scale at the far end.
    """
    sigma = surface.sigma
    if sigma is not None:
        return ExpectedError(
            basis="vertex sigmas",
            rms_mm=sigma.rms_mm,
            p95_mm=sigma.expected_error_p95_mm,
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
    """What the expected error is made of, one standard deviation each."""
    return tuple(BudgetPart(part=part, sigma_mm=sigma_mm) for part, sigma_mm in parts_mm.items())


def criteria(
    figures: Figures,
    setups: Sequence[SetupCited] = (),
    uncalibrated: SelfCalibration | None = None,
) -> tuple[Criterion, ...]:
    """Every figure that has a limit, judged; a lens without a file, the tests of the kit."""
    truth = figures.truth
    surface = _expected(figures) if truth is None else _against_truth(truth)
    return (
        *_scale(figures),
        *_independent(figures),
        *surface,
        *_completeness(figures),
        *_cameras(figures),
        *_zoomed(figures),
        *_uncalibrated(figures, uncalibrated),
        *of_kit(setups),
        *_movement(figures),
    )


def worst(judged: Sequence[Criterion]) -> Light:
    """The light of the whole."""
    return _ORDER[max(_ORDER.index(one.light) for one in judged)]


def headline(figures: Figures, judged: Sequence[Criterion]) -> str:
    """The first line: the light and its reasons, then surface and scale in figures."""
    light = worst(judged)
    word = light.upper()
    if figures.lengths.unit != "mm":
        more = [one for one in reasons(judged) if one.light == light and one is not judged[0]]
        return " ".join((f"{word}. No millimetres.", judged[0].sentence, *_reasons(more)))
    main = next(one for one in judged if one.key == SURFACE_P95.key)
    scale = f"Scale: {_scale_words(figures)}."
    if light == "green":
        within = f"95 % within {main.value:.2f} mm (limit {main.green:.2f} mm)"
        return f"{word}. Surface: {within}. {scale}"
    grave = [one for one in reasons(judged) if one.light == light and one is not main]
    said = _reasons(grave) or [main.sentence]
    return " ".join((f"{word}.", *said, *_measured(main), scale))


def reasons(judged: Sequence[Criterion]) -> tuple[Criterion, ...]:
    """What is not green, the worst first; what is missing and what size it has before the rest."""
    doubtful = [one for one in judged if one.light != "green"]
    first = (AROUND.key, GAP.key, TAPE.key)
    return tuple(sorted(doubtful, key=lambda one: (-_ORDER.index(one.light), one.key not in first)))


def size_is_checked(figures: Figures) -> bool:
    """Whether a length that owes nothing to what set the scale agrees with it.

    Lengths between a board's own corners are no such lengths: a board printed too large as a whole
    is too large in all of them. Nor are bars and mats that the same printer made. A girth counts
    where the tape can tell, and then every such tape has to agree, whatever else agrees.
    """
    lengths = figures.lengths
    if lengths.unit != "mm":
        return False
    if figures.truth is not None:
        return True
    if any(map(tape_tells, lengths.tapes)):
        return math.isfinite(confirmed_by_tape(lengths))
    return lengths.checked_by_another_piece


def confirmed_by_tape(lengths: LengthFigures) -> float:
    """To what share of the size the tapes confirm it; NaN where they do not."""
    telling = [one for one in lengths.tapes if tape_tells(one)]
    agree = all(sigmas_apart(one.error_mm, one.sigma_mm) <= AGREES_SIGMAS for one in telling)
    return min(map(_sure_to, telling)) if telling and agree else math.nan


def tape_tells(tape: TapedLength) -> bool:
    """Whether a tape is sure enough to check the size."""
    return _sure_to(tape) <= TAPE_TELLS  # NaN where it could not be compared


def _sure_to(tape: TapedLength) -> float:
    """Two sigmas of a tape, as a share of what it read."""
    return AGREES_SIGMAS * tape.sigma_mm / tape.read_mm


def _scale_words(figures: Figures) -> str:
    """What set the scale, how well check lengths agree, and what checks it independently."""
    lengths = figures.lengths
    count, error = len(lengths.check), 100 * lengths.check_worst
    set_by = f"set by {rests_on(lengths)}"
    if count and error <= SCALE.green:
        lengths_agree = "check length agrees" if count == 1 else "check lengths agree"
        set_by += f", {count} {lengths_agree} to {error:.3f} %"
    if not size_is_checked(figures):
        if lengths.checked_by_another_piece:
            return f"{set_by}; a taped girth contradicts it"
        vague = _vague(lengths)
        return f"{set_by}; not checked independently{vague and f': {vague}'}"
    if figures.truth is not None or lengths.checked_by_another_piece:
        return f"{set_by}; checked independently"
    return f"{set_by}; confirmed to {100 * confirmed_by_tape(lengths):.1f} % by tape"


def rests_on(lengths: LengthFigures) -> str:
    """What the scale was set by."""
    if any(marks_of_label(one.label) for one in (*lengths.control, *lengths.check)):
        return "prints of one printer"
    if lengths.source == "distances":
        return "known distances" if len(lengths.control) > 1 else "one known distance"
    return "one board"


def _vague(lengths: LengthFigures) -> str:
    """What is said of tapes that cannot tell the size; empty where one can."""
    sure = min((_sure_to(one) for one in lengths.tapes if not one.reason), default=None)
    if sure is None:
        return "; ".join(f"the {_not_compared(one)}" for one in lengths.tapes)
    if sure <= TAPE_TELLS:
        return ""
    return f"the tape is sure to {100 * sure:.1f} % only ({100 * TAPE_TELLS:g} % is needed)"


def _reasons(grave: Sequence[Criterion]) -> list[str]:
    """The first two reasons; the surface's RMS says what its 95 % say."""
    return [one.sentence for one in grave if one.key != SURFACE_RMS.key][:2]


def _measured(main: Criterion) -> list[str]:
    """How sure the rest is, which makes up for nothing that is missing."""
    if not math.isfinite(main.value) or main.light != "green":
        return []
    return [f"Measured surface: 95 % within {main.value:.2f} mm."]


def _scale(figures: Figures) -> tuple[Criterion, ...]:
    lengths = figures.lengths
    if lengths.unit != "mm":
        sentence = "Nothing in the photos says how large the limb is."
        return (SCALE.judge(math.nan, sentence, "red"),)
    count = len(lengths.check)
    error = 100 * lengths.check_worst
    plural = "check length" if count == 1 else "check lengths"
    if not count:
        sentence = "No length that did not set the scale confirms it."
    elif error <= SCALE.green:
        sentence = (
            f"The scale agrees with {count} {plural} to {error:.3f} % (limit {SCALE.green} %)."
        )
    else:
        sentence = (
            f"The check length {lengths.check_worst_label} is off by {error:.3f} % "
            f"(limit {SCALE.green} %)."
        )
    two_sigma = 200 * lengths.relative_sigma
    return (
        SCALE.judge(error, sentence),
        SCALE_SIGMA.judge(
            two_sigma,
            f"The scale is known to {two_sigma:.3f} % (limit {SCALE_SIGMA.green} %)"
            + (_surer(figures) if two_sigma > SCALE_SIGMA.green else "."),
        ),
    )


def _surer(figures: Figures) -> str:
    """Why no more is known of the scale, and what would tell more."""
    stretch = figures.lengths.board_stretch
    if stretch == 0:
        return ". Show a board in more photos, or tape a longer distance, or more of them."
    longer, shorter = ("x", "y") if stretch > 0 else ("y", "x")
    said = (
        f": the board is {100 * abs(stretch):.2f} % longer along its {longer} than along its "
        f"{shorter}. "
    )
    if figures.movement is not None and figures.movement.alone:
        return f"{said}It stood beside a limb that moved, which may be why. Photograph it again."
    return f"{said}Measure both on the print, and print it again at 100 %."


def _independent(figures: Figures) -> Iterator[Criterion]:
    """What owes nothing to the scale's own source: tapes, and the distance in EXIF."""
    if figures.lengths.unit != "mm":
        return
    for tape in figures.lengths.tapes:
        yield _taped(tape, figures.lengths.source)
    ratio = figures.images.distance_over_stated
    if math.isfinite(ratio):
        factor = max(ratio, 1 / ratio)
        yield FOCUSED.judge(
            factor,
            f"The photos say that the lens was focused {factor:.1f} times as "
            f"{'near' if ratio > 1 else 'far'} as the limb is by this scale"
            + (": was the length given in another unit?" if factor > FOCUSED.green else "."),
        )


def _not_compared(tape: TapedLength) -> str:
    return f"taped girth {tape.place} could not be compared ({tape.reason.rstrip('.')})"


def _taped(tape: TapedLength, source: str) -> Criterion:
    """A reading that cannot be compared says nothing against the surface."""
    if tape.reason:
        return TAPE.judge(math.nan, f"The {_not_compared(tape)}.", unknown="green")
    said = (
        f"The tape read {tape.read_mm:g} mm {tape.place}; the surface has "
        f"{tape.measured_mm:.1f} mm there ({tape.error:+.1%}, both are sure to "
        f"{COVER * tape.sigma_mm:.0f} mm together)"
    )
    judged = TAPE.judge(sigmas_apart(tape.error_mm, tape.sigma_mm), f"{said}.")
    if judged.light == "green":
        return judged
    cause = (
        "the scale board is probably not as large as stated: measure a row of its squares"
        if source == "board"
        else "a known distance was probably mistyped: measure it again"
    )
    return replace(judged, sentence=f"{said}: {cause}, and tape again.")


def _uncalibrated(figures: Figures, found: SelfCalibration | None) -> Iterator[Criterion]:
    """Never green where nobody can say what a lens without a file costs, or where it costs much."""
    if found is not None and figures.lengths.unit == "mm":
        yield LENS_FOUND.judge(COVER * found.sigma_mm, found.sentence)


def of_kit(setups: Sequence[SetupCited]) -> Iterator[Criterion]:
    """A kit is green where it passed its test and the test still counts.

    One that failed is amber. So is one of which nothing is known: the test could not tell, or was
    made longer ago than it was meant to count for.
    """
    for one in setups:
        if one.outcome == "fail":
            yield SETUP.judge(1.0, one.sentence)
        elif one.outcome == "cannot tell" or one.expired:
            yield SETUP.judge(math.nan, f"{one.sentence} {one.remark}")
        else:
            yield SETUP.judge(0.0, one.sentence)


def _cameras(figures: Figures) -> Iterator[Criterion]:
    """What the photos say against the calibrations that were given."""
    limit_px = max(LENS_PATTERN.green, _PATTERN_SIGMAS * figures.network.sigma0_robust_px)
    for camera, lens in zip(figures.residuals.by_camera, figures.cameras, strict=True):
        if lens.source != "board":
            continue
        name = lens.name
        free = [one for one in lens.parameters if math.isfinite(one.contradicted_sigmas)]
        if free:
            worst_one = max(free, key=lambda one: abs(one.contradicted_sigmas))
            sigmas = abs(worst_one.contradicted_sigmas)
            yield LENS.judge(
                sigmas,
                f"The photos contradict the camera file of {name}: they say another "
                f"{worst_one.name}, by {sigmas:.1f} sigmas. Was zoom or focus touched since the "
                "calibration, or is it another camera's file?"
                if sigmas > LENS.green
                else f"The photos agree with the camera file of {name}.",
            )
        yield _square(lens)
        pattern = camera.systematic_px
        if math.isfinite(pattern):
            yield replace(LENS_PATTERN, green=limit_px).judge(
                pattern,
                f"The residuals of {name} follow a pattern over the picture ({pattern:.3f} px): "
                "its lens is not what the camera file says."
                if pattern > limit_px
                else f"The residuals of {name} follow no pattern over the picture.",
            )


def _zoomed(figures: Figures) -> Iterator[Criterion]:
    """Nothing is said where all photos have the focal length of their camera."""
    names = [one.name for one in figures.images.by_photo if one.zoomed]
    if names:
        yield ZOOMED.judge(
            float(len(names)),
            told(zoomed_photos(names, figures.images.photos)),
        )


def _square(lens: LensFigures) -> Criterion:
    """Whether the pixels of a lens are as wide as high, as those of sensors are.

    Both as it was calibrated and as the photos have it: the adjustment holds a board's calibration
    to square pixels.
    """
    named = {one.name: one for one in lens.parameters}
    fx, fy = named["fx"], named["fy"]
    found, calibrated = fx.value / fy.value - 1, fx.calibrated / fy.calibrated - 1
    of_file = abs(calibrated) > abs(found)
    off = 100 * (calibrated if of_file else found)
    limit = replace(SQUARE, green=100 * squareness(lens.width_px, lens.height_px))
    if abs(off) <= limit.green:
        return limit.judge(abs(off), f"The pixels of {lens.name} come out square.")
    longer, shorter = ("wider", "high") if off < 0 else ("higher", "wide")
    whose = (
        f"The calibration of {lens.name} says that its pixels are"
        if of_file
        else f"The pixels of {lens.name} come out"
    )
    return limit.judge(
        abs(off),
        f"{whose} {abs(off):.2f} % {longer} than {shorter} (limit "
        f"{limit.green:.1f} %), and sensors have square ones: the camera moved while its rows were "
        "read (rolling shutter), its stabiliser shifted the picture, or the calibration board is "
        "stretched. Hold the camera still for each photo, with stabiliser and electronic shutter "
        "off where it can be done, and calibrate again.",
    )


def _misfit(what: str, did: str) -> str:
    """What does not fit while nobody can say whether limb or lens is the cause."""
    return (
        f"{what} not keep together from photo to photo, beyond chance: the limb {did}, or the "
        "lens, which no board calibrated, is another than was found. Calibrate the camera, or let "
        "the limb rest and take the photos again."
    )


def _movement(figures: Figures) -> Iterator[Criterion]:
    """Whether the limb kept still and kept its shape.

    Nothing is said where it could not be looked for; where something does not fit and only its
    cause is not known, that is a doubt.
    """
    movement = figures.movement
    if movement is None:
        return
    if movement.misfit:
        yield MOVED.judge(
            math.nan,
            _misfit("The limb and what lies round it do", "moved"),
        )
    if movement.bending_misfit:
        yield BENT.judge(
            math.nan,
            _misfit("The two halves of the limb do", "bent"),
        )
    if math.isfinite(movement.shift):
        sentence, limit = movement.sentence, MOVED
        if movement.shift > 0.0 and movement.alone:
            sentence += " The photos were placed by the points on the limb alone."
        elif movement.shift > 0.0:
            limit = replace(MOVED, red=_MOVED_RED_MM)
            sentence += " Its own points do not place them. Take the photos again."
        yield limit.judge(movement.shift, sentence)
    if math.isfinite(movement.bending):
        again = " Take them again." if movement.bending else ""
        yield BENT.judge(movement.bending, movement.bending_sentence + again)


def _expected(figures: Figures) -> tuple[Criterion, ...]:
    expected = figures.expected
    if figures.lengths.unit != "mm":
        return ()
    p95, rms = expected.p95_mm, expected.rms_mm
    return (
        SURFACE_P95.judge(
            p95,
            f"95 % of the measured surface is expected within {p95:.2f} mm of the limb "
            f"(limit {SURFACE_P95.green:.2f} mm).",
        ),
        SURFACE_RMS.judge(
            rms, f"Expected RMS error {rms:.3f} mm (limit {SURFACE_RMS.green:.2f} mm)."
        ),
    )


def _against_truth(truth: TruthFigures) -> tuple[Criterion, ...]:
    p95, rms, mean, iqr = truth.p95_mm, truth.rms_mm, truth.mean_mm, truth.iqr_mm
    girth = max((abs(one.error_mm) for one in truth.girths), default=math.nan)
    volume = 100 * abs(truth.volume_error)
    return (
        SURFACE_P95.judge(
            p95,
            f"95 % of the measured surface lies within {p95:.3f} mm of the truth "
            f"(limit {SURFACE_P95.green:.2f} mm).",
        ),
        SURFACE_RMS.judge(rms, f"RMS distance to the truth {rms:.3f} mm."),
        MEAN.judge(
            abs(mean),
            f"Mean signed distance to the truth {mean:+.3f} mm (limit {MEAN.green:.2f} mm).",
        ),
        SPREAD.judge(iqr, f"Interquartile range {iqr:.3f} mm (limit {SPREAD.green:.2f} mm)."),
        GIRTH.judge(girth, f"The worst girth is off by {girth:.2f} mm."),
        VOLUME.judge(volume, f"The volume is off by {volume:.2f} %."),
    )


def _completeness(figures: Figures) -> tuple[Criterion, ...]:
    surface, images = figures.surface, figures.images
    ring = figures.network.ring
    gap = math.nan if ring is None else ring.largest_gap_deg
    around = surface.around
    round_about, beyond = 100 * around.missing_share, 100 * around.open_share
    filled, left_out = 100 * surface.filled_share, 100 * surface.left_out_share
    missing = images.photos - images.placed
    return (
        AROUND.judge(
            round_about,
            f"{round_about:.0f} % of the directions round the limb have no measured surface (the "
            f"widest gap is {around.widest_gap_deg:.0f} degrees, seen from its middle): a tape "
            "there would run over air."
            if round_about > AROUND.green
            else f"{round_about:.0f} % of the directions round the limb have no measured surface.",
        ),
        OPEN.judge(
            beyond,
            f"The surface is open beyond one brim: {beyond:.0f} % of it would be needed to close "
            "the rest."
            if beyond > OPEN.green
            else "The surface is open at one brim at most.",
        ),
        FILLED.judge(filled, f"{filled:.1f} % of the surface was filled in; no photo measured it."),
        LEFT_OUT.judge(
            left_out,
            f"{left_out:.1f} % of what was measured of it was torn off or in crumbs, and is not in "
            "the surface.",
        ),
        _which(surface),
        MISSING.judge(
            100 * missing / max(images.photos, 1),
            f"{missing} of {images.photos} photos could not be placed.",
        ),
        GAP.judge(
            gap,
            f"No photo looks from {gap:.0f} degrees in a row: that side is not measured."
            if gap > GAP.green
            else f"The widest gap between photos is {gap:.0f} degrees.",
        ),
    )


def _which(surface: SurfaceFigures) -> Criterion:
    """Whether it is clear which body is meant; the other side of its wall is no rival."""
    rivals = [one for one in surface.other_parts if one.relation == "apart"]
    count = 0 if surface.part_given else len(rivals)
    plural = "Another body lies" if count == 1 else f"{count} other bodies lie"
    sentence = "It is clear which body is meant."
    if count:
        numbers = ", ".join(str(one.number) for one in rivals)
        sentence = (
            f"{plural} apart from it (part {numbers}): the photos look at this one most. Say "
            "--part NUMBER to choose."
        )
    return WHICH.judge(float(count), sentence)
