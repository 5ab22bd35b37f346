"""Layout: what the page and the PDF of an assessment show, and in which order.

In      an Assessment, and pictures of the surface.
Out     a Report of two sheets: the first for everybody, the second for those who measure.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from limbgram.core.geometry.smoothed_length import SMOOTHED_OVER
from limbgram.findings import Finding, told
from limbgram.report.acceptance import setup_section
from limbgram.report.accuracy.assessment import Assessment
from limbgram.report.accuracy.charts import (
    Series,
    bars,
    correlations,
    counts,
    curve,
    histogram,
    vectors,
)
from limbgram.report.accuracy.figures import (
    LENGTH,
    LENS_SOURCES,
    SHARE,
    CameraResiduals,
    ExplanationFigures,
    KnownLength,
    LensFigures,
    SigmaTest,
    TapedLength,
)
from limbgram.report.accuracy.glossary import Term, terms, value_at
from limbgram.report.accuracy.judgement import BENT, MOVED, without_light
from limbgram.report.alignment import COMPARED_MM
from limbgram.report.blocks import (
    AdviceList,
    Banner,
    Block,
    Card,
    Columns,
    Heading,
    Illustration,
    Report,
    Section,
    Table,
    Text,
)
from limbgram.report.drawings.drawing import BLUE, GREEN, ORANGE, Picture
from limbgram.report.intended_use import OF_SCANS

MEANING = (
    "Green: finer than a socket's fit can show. Amber: usable, with the doubt that is named. Red: "
    "much of the limb is missing, a girth or volume may be wrong by a ply of sock or more, or the "
    "size is not known; make nothing from it unchecked."
)


def accuracy_report(assessment: Assessment, pictures: Sequence[Picture]) -> Report:
    """The assessment, the verdict first and every figure last."""
    return Report(
        title=f"How accurate is {assessment.case}?",
        banner=Banner(
            badge=assessment.light.upper(),
            words=told(without_light(assessment.headline)),
            colour=assessment.light,
        ),
        cards=_cards(assessment),
        note=MEANING,
        intended_use=OF_SCANS,
        sections=(
            _findings(assessment),
            *_pictures(pictures),
            Section(
                title="Limits and what was found",
                blocks=(_criteria(assessment),),
                sheet=1,
            ),
            *_against_truth(assessment),
            _expected_error(assessment),
            _lengths(assessment),
            _residuals(assessment),
            _network(assessment),
            Section(title="Cameras", blocks=tuple(_cameras(assessment)), sheet=2),
            _photos(assessment),
            *_explanations(assessment),
            *setup_section(assessment.setups, sheet=2),
            _glossary(assessment),
        ),
    )


def _explanations(assessment: Assessment) -> Iterator[Section]:
    """The section of what may have happened between the photos; none if nothing may."""
    movement, unit = assessment.figures.movement, assessment.unit
    if movement is None or not movement.explanations:
        return
    rows = tuple(
        (
            _BODIES[one.bodies],
            _KINDS[one.kind],
            _photo_names(one.photos, len(assessment.figures.images.by_photo)),
            _effect_text(one, unit),
            f"{one.score:.0f}",
            f"{one.variance_before:.1f}",
            f"{one.variance_after:.1f}",
            "fact"
            if one.told
            else "undecided: " + ", ".join(_FAILED[rule] for rule in one.failed)
            if one.matters
            else "too small to matter",
        )
        for one in movement.explanations
    )
    yield Section(
        title="What explains the photos",
        blocks=(
            Table(
                heads=("bodies", "what", "photos", "#effect (95 %)", "#score", "#variance before",
                       "#after", "standing"),
                rows=rows,
            ),
            Text(
                words="Each line is held against lenses that differ from photo to photo as much as "
                "this capture shows. The effect is the largest motion of a point of the limb, or "
                "the share by which a focal length differs. What lenses explain was solved for, "
                "and is told as a fact only where it stands the same rules. The "
                "score is twice the logarithm of likelihood that the line gains, less what its "
                "numbers cost. Variance is that of what both bodies leave, over that of the "
                "measurements; 1 is chance. While a movement that matters is undecided, no "
                "error of the surface is stated."
            ),
        ),
        sheet=2,
    )  # fmt: skip


def _effect_text(one: ExplanationFigures, unit: str) -> str:
    if one.is_share:
        return f"{one.effect:.2%} ({one.low:.2%} to {one.high:.2%})"
    return f"{_length(one.effect, unit)} ({one.low:.2f} to {one.high:.2f})"


_BODIES = {
    "limb and room": "limb and surroundings",
    "halves": "halves of the limb",
    "limb and board": "limb and board",
    "lenses": "lenses of photos",
    "board": "scale board",
}
_KINDS = {
    "step": "step between photos",
    "drift": "slow movement",
    "photo": "one photo alone",
    "sway": "elsewhere in every photo",
    "rest": "not explained",
    "principal point": "picture shifted on the sensor",
    "focal length": "own focal length",
    "rolling shutter": "rolling shutter",
    "camera file": "another focal length than the camera file's",
    "bend": "bent",
}
_FAILED = {
    "chance": "no cause is found",
    "lens": "a changing lens explains it as well",
    "size": "may be too small to matter",
    "one photo": "one photo alone speaks for it",
    "lenses of photos": "lenses that differ more explain it as well",
    "board": "a board that was pushed explains it as well",
    "few points": "only photos that few points hold speak for it",
    "motion": "a limb that lies elsewhere in every photo explains it as well",
    "model": "what an uncalibrated lens does beyond its model explains it as well",
}


def _photo_names(names: Sequence[str], all_photos: int) -> str:
    """Names of photos; not those of all."""
    if len(names) >= all_photos:
        return "all"
    return ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")


def _cards(assessment: Assessment) -> tuple[Card, ...]:
    """Surface, scale, completeness, photos."""
    figures, unit = assessment.figures, assessment.unit
    surface, images, lengths = figures.surface, figures.images, figures.lengths
    if figures.truth is not None:
        error, note = figures.truth.p95_mm, "95 % of the surface lies nearer to the truth"
    else:
        sure = figures.expected.basis == "vertex sigmas"
        error = figures.expected.p95_mm
        note = "95 % of the surface lies nearer" + ("" if sure else " (a rough guess)")
    checks = len(lengths.check)
    return (
        Card("Surface error", _length(error, unit), note),
        Card(
            "Scale on lengths that did not set it",
            f"{100 * lengths.check_worst:.3f} %" if checks else "not checked",
            f"worst of {checks}: {lengths.check_worst_label}"
            if checks
            else f"give a {'second ' * (lengths.unit == 'mm')}known length",
        ),
        Card(
            "Measured",
            f"{surface.measured_share:.1%}",
            f"filled in {surface.filled_share:.1%}, left out {surface.left_out_share:.1%}",
        ),
        Card(
            "Photos placed",
            f"{images.placed} of {images.photos}",
            f"a pixel is {_length(images.pixel, unit)} on the limb",
        ),
    )


def _findings(assessment: Assessment) -> Section:
    items = assessment.findings
    nothing = Text(words="Nothing that would be worth another photograph.")
    return Section(
        title="What limits this result, and what to do",
        blocks=(AdviceList(items=items) if items else nothing,),
        sheet=1,
    )


def _pictures(pictures: Sequence[Picture]) -> Iterator[Section]:
    """The first has its place on the sheet, others as far as there is room."""
    for number, one in enumerate(pictures):
        figure = Illustration(image=one, caption=one.caption, least_in=1.6, optional=number > 0)
        yield Section(title=one.title, blocks=(figure,), sheet=1)


def _criteria(assessment: Assessment) -> Table:
    judged, not_told = assessment.criteria, tuple(_unjudged_rows(assessment))
    rows = tuple(
        (
            one.title,
            f"{one.value:.3g}" if math.isfinite(one.value) else "not known",
            one.unit,
            f"{one.green:g}",
            f"{one.red:g}" if math.isfinite(one.red) else "never",
            told(one.finding),
            one.light,
        )
        for one in judged
    )
    return Table(
        heads=("figure", "#found", "unit", "#green up to", "#red beyond", "in words", "light"),
        rows=(*rows, *not_told),
        marked=(*(one.light == "red" for one in judged), *(False for _ in not_told)),
        colours=(*(one.light for one in judged), *(None for _ in not_told)),
        page_head="in words",
    )


def _unjudged_rows(assessment: Assessment) -> Iterator[tuple[str, ...]]:
    """Rows of figures without a light, because nobody looked or nothing could be seen."""
    movement = assessment.figures.movement
    turned = "Not looked for: the object was turned on purpose, or an older version made the case."
    for limit, said in (
        (MOVED, turned if movement is None else told(movement.found)),
        (BENT, turned if movement is None else _sentence_of(movement.bent)),
    ):
        if not any(one.key == limit.key for one in assessment.criteria):
            found = "not looked for" if movement is None or not said else "not known"
            yield limit.title, found, assessment.unit, "", "", said, "none"


def _against_truth(assessment: Assessment) -> Iterator[Section]:
    """Distances from the truth, girths, and whether sigmas are honest."""
    truth = assessment.figures.truth
    if truth is None:
        return
    vertices = assessment.figures.surface.vertices
    figures = [
        Illustration(
            image=histogram(
                truth.histogram.edges_mm,
                [Series("vertices", truth.histogram.vertices, BLUE)],
                "signed distance, mm (outside is positive)",
                "Histogram of the distances from the truth",
            ),
            caption=f"{truth.vertices:,} of {vertices:,} vertices, those measured and nearer "
            f"than {COMPARED_MM:g} mm to what photos show of the truth: RMS {truth.rms_mm:.4f} mm "
            f"({truth.rms_px:.3f} px), 95 % within {truth.p95_mm:.4f} mm, mean "
            f"{truth.mean_mm:+z.4f} mm.",
        )
    ]
    if truth.sigma is not None:
        figures.append(_sigma_test_blocks(truth.sigma))
    rows = tuple(
        (
            f"{one.height_mm:.1f}",
            f"{one.measured_mm:.2f}",
            f"{one.true_mm:.2f}",
            f"{one.error_mm:+z.3f}",
        )
        for one in truth.girths
    )
    yield Section(
        title=f"Against the truth: {truth.kind}",
        blocks=(
            Text(words=f"Alignment: {truth.alignment}.", note=True),
            Columns(figures=tuple(figures)),
            Heading(words=f"Girths of sections (taut tape, {SMOOTHED_OVER})", page_only=True),
            Table(
                heads=("#height mm", "#ours mm", "#true mm", "#error mm"),
                rows=rows,
                page_only=True,
            ),
        ),
        sheet=2,
    )


def _sigma_test_blocks(sigma: SigmaTest) -> Illustration:
    return Illustration(
        image=curve(
            [part.sigma_mm for part in sigma.by_sigma],
            [part.rms_error_mm for part in sigma.by_sigma],
            ("sigma told, mm", "RMS error found, mm"),
            "Error found against sigma told, in tenths of the vertices",
        ),
        caption=f"Error over sigma: robust spread {sigma.robust_spread:.2f} (1 is honest), "
        f"{sigma.within_95_share:.1%} inside the 95 % interval, rank correlation "
        f"{_formatted(sigma.rank_correlation, '.2f') or 'not known'}.",
    )


def _expected_error(assessment: Assessment) -> Section:
    """How sure the vertices are, and what the expected error is made of."""
    expected, unit = assessment.figures.expected, assessment.unit
    budget = [one for one in expected.budget if math.isfinite(one.sigma_mm)]
    figures = [
        Illustration(
            image=bars(
                [one.part for one in budget],
                [one.sigma_mm for one in budget],
                unit,
                "Parts of the expected error",
            ),
            caption="Parts of the expected error, one standard deviation each, from the "
            f"{expected.basis}.",
        )
    ]
    sigma = assessment.figures.surface.sigma
    if sigma is not None:
        figures.append(
            Illustration(
                image=histogram(
                    sigma.edges_mm,
                    [Series("area", [100 * share for share in sigma.area_share], BLUE)],
                    f"sigma along the normal, {unit}; height: % of the area",
                    "Histogram of the vertex sigmas",
                ),
                caption=f"Sigma of the measured surface: median {sigma.median_mm:.3g}, 95 % below "
                f"{sigma.p95_mm:.3g} {unit}; {sigma.shared_rms_mm:.3g} of it is "
                "shared by all vertices.",
            )
        )
    return Section(
        title="Expected error",
        blocks=(Columns(figures=tuple(figures)), *_openings(assessment)),
        sheet=1,
    )


def _openings(assessment: Assessment) -> Iterator[Block]:
    found, unit = assessment.figures.surface.openings, assessment.unit
    if not found:
        yield Text(words="The surface is closed.", page_only=True)
        return
    heads = (f"#rim {unit}", *(f"#middle {axis} {unit}" for axis in "xyz"))
    rows = tuple((f"{one.rim:.1f}", *(f"{along:z.1f}" for along in one.middle)) for one in found)
    yield Heading(words="Where it is open", page_only=True)
    yield Table(heads=heads, rows=rows, page_only=True)


def _lengths(assessment: Assessment) -> Section:
    """Control and check lengths apart, and the board."""
    lengths = assessment.figures.lengths
    blocks: list[Block] = [
        Heading(words="Check lengths: they did not set the scale, so they test it"),
        _known_length_rows(lengths.check),
        Heading(words="Control lengths: they set the scale"),
        _known_length_rows(lengths.control),
    ]
    if lengths.tapes:
        heads = ("girth", "#tape mm", "#surface mm", "#error mm", "#error %",
                 "#sigma of both mm")  # fmt: skip
        rows = tuple(_tape_row(one) for one in lengths.tapes)
        blocks += [
            Heading(words="Taped girths: they owe nothing to the scale"),
            Table(heads=heads, rows=rows),
        ]
    board = lengths.board
    if board is not None:
        words = (
            f"{board.board}, seen in {board.photos} of {board.placed_photos} photos, "
            f"{_formatted(board.corners_per_photo, '.1f')} of {board.corners} corners on average."
        )
        blocks.append(Text(words=words, note=True))
    return Section(title="Known lengths", blocks=tuple(blocks))


def _known_length_rows(lengths: Sequence[KnownLength]) -> Block:
    rows = tuple(
        (
            one.label,
            f"{one.known_mm:.3f}",
            f"{one.measured_mm:.3f}",
            f"{one.error_mm:+z.4f}",
            f"{100 * one.error:+z.4f}",
            _formatted(one.sigma_mm, ".4f"),
        )
        for one in lengths
    )
    heads = ("length", "#known mm", "#measured mm", "#error mm", "#error %", "#sigma mm")
    return Table(heads=heads, rows=rows) if rows else Text(words="None.")


def _tape_row(one: TapedLength) -> tuple[str, ...]:
    if one.reason:
        return one.place, f"{one.read_mm:.1f}", told(one.reason)
    return (
        one.place,
        f"{one.read_mm:.1f}",
        f"{one.measured_mm:.1f}",
        f"{one.error_mm:+z.1f}",
        f"{100 * one.error:+z.1f}",
        f"{one.sigma_mm:.1f}",
    )


def _residuals(assessment: Assessment) -> Section:
    """Histogram, and photo by photo."""
    found = assessment.figures.residuals
    bins, photos = found.histogram, found.by_photo
    figures = (
        Illustration(
            image=histogram(
                bins.edges_px,
                [Series("x", bins.x, BLUE), Series("y", bins.y, ORANGE)],
                "measured minus projected, px (ends hold what lies beyond)",
                "Histogram of the residuals",
            ),
            caption=f"RMS of one coordinate {_formatted(found.rms_px, '.4f')} px; "
            f"{_formatted(found.beyond_3_sigma_share, '.2%')} lie beyond three robust sigmas "
            "(Gaussian: 0.27 %).",
        ),
        Illustration(
            image=bars(
                [one.name for one in photos],
                [one.rms_px for one in photos],
                "px",
                "Residual RMS by photo",
            ),
            caption="RMS of one coordinate, photo by photo.",
        ),
    )
    return Section(
        title="Residuals of the image points", blocks=(Columns(figures=figures),), sheet=2
    )


def _by_place(camera: CameraResiduals) -> Illustration:
    return Illustration(
        image=vectors(camera.grid, "Mean residual by place in the picture"),
        caption="Mean residual of all photos by place in the picture. Arrows that follow a pattern "
        f"mean a lens that is not as calibrated: systematic part "
        f"{_formatted(camera.systematic_px, '.4f')} px (one coordinate, chance taken off).",
    )


def _zones(camera: CameraResiduals) -> Table:
    rows = tuple(
        (
            f"{zone.from_share:.0%} to {zone.to_share:.0%}",
            f"{zone.observations:,}",
            _formatted(zone.rms_px, ".4f"),
            _formatted(zone.outward_px, "+z.4f"),
        )
        for zone in camera.zones
    )
    heads = ("middle to corner", "#image points", "#RMS px", "#mean outward px")
    return Table(heads=heads, rows=rows, page_only=True)


def _network(assessment: Assessment) -> Section:
    """Rays, angles, overlap."""
    network = assessment.figures.network
    rays, angles, overlap = network.rays, network.angles, network.overlap
    numbers = rays.numbers
    weakest = min(overlap.best_partner, default=0)
    figures = (
        Illustration(
            image=histogram(
                angles.edges_deg,
                [Series("points", angles.points, BLUE)],
                "widest intersection angle, degrees",
                "Histogram of intersection angles",
            ),
            caption=f"Median {angles.median_deg:.0f} degrees; 5 % below {angles.low_deg:.0f}.",
        ),
        Illustration(
            image=histogram(
                [n - 0.5 for n in (*numbers, numbers[-1] + 1)],
                [Series("points", rays.points, GREEN)],
                f"rays per point ({numbers[-1]}: or more)",
                "Histogram of rays per point",
            ),
            caption=f"{network.points:,} points with {network.observations:,} image points, "
            f"{rays.mean:.2f} rays on average, "
            f"{rays.two_share:.0%} with two; redundancy {network.redundancy:,} "
            f"(mean redundancy number {network.redundancy_share:.2f}), sigma0 "
            f"{_formatted(network.sigma0_px, '.4f')} px, robust "
            f"{_formatted(network.sigma0_robust_px, '.4f')} px.",
        ),
    )
    shared = tuple(
        (name, *(f"{points:,}" for points in row))
        for name, row in zip(overlap.names, overlap.shared_points, strict=True)
    )
    return Section(
        title="Rays and overlap",
        blocks=(
            Columns(figures=figures),
            Illustration(
                image=counts(overlap.names, overlap.shared_points, "Points shared by photos"),
                caption="Points that two photos share: the darker, the more. The photo joined "
                f"worst shares {weakest:,} with its best partner.",
                page_only=True,
            ),
            Table(
                heads=("photo", *(f"#{name}" for name in overlap.names)),
                rows=shared,
                folded="All counts of shared points; a photo's own points on the diagonal",
                page_only=True,
            ),
        ),
        sheet=2,
    )


def _cameras(assessment: Assessment) -> Iterator[Block]:
    """Every lens, and how surely each photo is placed."""
    residuals = {one.camera: one for one in assessment.figures.residuals.by_camera}
    for number, lens in enumerate(assessment.figures.cameras):
        for block in _lens(lens, residuals.get(lens.camera)):
            yield replace(block, page_only=True) if number > 0 else block
    poses = assessment.figures.poses
    if poses is not None:
        words = "Where the photos were taken: one standard deviation"
        rows = tuple(
            (one.name, f"{one.centre:.4f}", f"{one.rotation_deg:.5f}") for one in poses.by_photo
        )
        heads = ("photo", f"#centre {assessment.unit}", "#rotation deg")
        yield Heading(words=words, page_only=True)
        yield Table(heads=heads, rows=rows, page_only=True)


def _lens(lens: LensFigures, residuals: CameraResiduals | None) -> Iterator[Block]:
    """Parameters, sigmas, correlations, and what the lens leaves over in the pictures."""
    source = LENS_SOURCES[lens.source]
    words = f"{lens.name}, {lens.width_px} x {lens.height_px} px, {source}"
    rows = tuple(
        (
            one.name,
            one.unit,
            f"{one.value:.6g}",
            "held" if one.held else _formatted(one.sigma, ".2g"),
            f"{one.calibrated:.6g}",
            "held" if one.held else _formatted(one.calibrated_sigma, ".2g"),
            _formatted(one.moved_sigmas, "+z.2f"),
        )
        for one in lens.parameters
    )
    heads = ("parameter", "unit", "#adjusted", "#sigma", "#calibrated", "#sigma",
             "#moved, sigmas")  # fmt: skip
    yield Heading(words=words)
    yield Table(heads=heads, rows=rows)
    figures: list[Illustration] = []
    tied = lens.correlations
    if tied is not None:
        caption = "Correlations of the adjusted parameters; orange is negative."
        image = correlations(tied.order, tied.matrix, "Correlations")
        figures.append(Illustration(image=image, caption=caption))
    if residuals is not None:
        figures.append(_by_place(residuals))
    if figures:
        yield Columns(figures=tuple(figures))
    if residuals is not None:
        yield _zones(residuals)


def _photos(assessment: Assessment) -> Section:
    """Photo by photo."""
    images, unit = assessment.figures.images, assessment.unit
    rows = tuple(
        (
            one.name,
            "placed" if one.placed else "not placed",
            f"{one.points:,}",
            _formatted(one.edge_width_px, ".2f"),
            _formatted(one.distance, ",.0f"),
            _formatted(one.pixel, ".3f"),
            " ".join(_sentence_of(said) for said in (one.reason, *one.remarks)).strip(),
        )
        for one in images.by_photo
    )
    heads = ("photo", "verdict", "#points", "#edge width px", f"#distance {unit}",
             f"#pixel {unit}", "remarks")  # fmt: skip
    marked = tuple(not one.placed for one in images.by_photo)
    return Section(title="Photos", blocks=(Table(heads=heads, rows=rows, marked=marked),))


def _glossary(assessment: Assessment) -> Section:
    """Every figure that this assessment has, with unit and definition."""
    found = ((term, value_at(assessment.figures, term.path)) for term in terms())
    rows = tuple(
        _term_row(term, value, assessment.unit)
        for term, value in found
        if value is not None and math.isfinite(value)
    )
    return Section(
        title="Every figure, its unit and what it is",
        blocks=(Table(heads=("figure", "#value", "unit", "definition"), rows=rows),),
    )


def _term_row(term: Term, value: float, unit: str) -> tuple[str, ...]:
    if term.unit == SHARE:
        return term.title, f"{100 * value:.4g}", "%", term.definition
    text = f"{value:,}" if isinstance(value, int) else f"{value:.4g}"
    name = unit if term.unit == LENGTH else term.unit.replace(LENGTH, unit).replace("^2", "²")
    if not isinstance(value, int) and abs(value) >= 10_000:
        text = f"{value:,.0f}"
    return term.title, text, name, term.definition


def _length(value: float, unit: str) -> str:
    """A length with its unit; three digits."""
    return f"{value:.3g} {unit}" if math.isfinite(value) else "not known"


def _sentence_of(finding: Finding | None) -> str:
    return "" if finding is None else told(finding)


def _formatted(value: float, form: str) -> str:
    """A figure in a format; empty where it is not known."""
    return format(value, form) if math.isfinite(value) else ""
