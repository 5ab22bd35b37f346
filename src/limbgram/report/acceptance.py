"""Acceptance: the certificate of a kit, as a page and as a sheet of paper.

In      a Certificate.
Out     a Report of one sheet or two: the answer and every error first, then what was measured how.
"""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from limbgram.capture.acceptance import (
    Acceptance,
    MeasuredError,
    Spread,
    without_outcome,
)
from limbgram.capture.certificate import Certificate
from limbgram.capture.permissible_errors import KINDS
from limbgram.capture.setup import Outcome, SetupCited
from limbgram.findings import LANGUAGES, fault, told
from limbgram.report.blocks import (
    AdviceList,
    Banner,
    Block,
    Card,
    Colour,
    Illustration,
    Report,
    Section,
    Table,
    Text,
)
from limbgram.report.drawings.drawing import FAINT, GREEN, INK, ORANGE, RED, Chart, plain
from limbgram.report.intended_use import OF_SCANS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS: dict[Outcome, Colour] = {"pass": "green", "fail": "red", "cannot tell": "amber"}
_INKS: dict[Outcome | None, str] = {
    "pass": GREEN,
    "fail": RED,
    "cannot tell": ORANGE,
    None: FAINT,
}
_SHORT = {
    "form": "form, 95 %",
    "form-all": "form, all points",
    "size": "size",
    "spacing": "spacing",
    "length": "length",
    "surface": "surface, 95 %",
}
_MOST_BARS = 40
_ROW_IN = 0.17
_METHOD = (
    "In the manner of VDI/VDE 2634 Part 3 and ISO 10360-13, on the surface that is delivered. "
    "Size error: diameter of the Gaussian (least squares) sphere or cylinder less the calibrated "
    "one. Form: width of the narrowest shell round it that holds 95 % of the measured area, and of "
    "that which holds every point. Spacing error: distance between the middles of two such spheres "
    "less the calibrated one. Length error: the same between the middles of two coded marks. "
    "Nowhere is a scale fitted. A strip along the shaft, and what no photo measured, is left out."
)
_RULE = (
    "Decision by ISO 14253-1: with the permissible error M and the artefact's expanded uncertainty "
    "U (k = 2), an error E passes if |E| + U is not larger than M, fails if |E| - U is larger, and "
    "between them nobody can tell. One error that fails, fails the test; what was not measured "
    "leaves it undecided. The standards ask for a bar in seven positions all over the volume in "
    "which limbs will stand: as many positions were tested as captures are named here."
)


def acceptance_report(certificate: Certificate) -> Report:
    """The certificate, the answer first."""
    found = certificate.acceptance
    return Report(
        title=f"Acceptance test of {_kit(certificate)}",
        banner=Banner(
            badge=found.outcome.upper(),
            words=told(without_outcome(found.headline)),
            colour=COLOURS[found.outcome],
        ),
        cards=_cards(certificate),
        note=f"{_RULE} Made by {certificate.program}.",
        intended_use=OF_SCANS,
        sections=(
            *_missing(found),
            Section(title="Errors against what is permitted", blocks=_errors(found), sheet=1),
            Section(title="All errors of a kind", blocks=(_spread_table(found.spreads),), sheet=1),
            Section(
                title="The artefact, the kit and the captures",
                blocks=_scope_section(certificate),
                sheet=2,
            ),
            Section(title="How it was measured", blocks=_method_section(found), sheet=2),
        ),
    )


def setup_section(setups: Sequence[SetupCited], sheet: int | None = None) -> Iterator[Section]:
    """The section about the kit on a case's page; None where the camera has no certificate."""
    if not setups:
        return
    remarks = tuple(one.finding for one in setups if one.to_do)
    blocks: tuple[Block, ...] = tuple(
        Text(words=told(one.finding)) for one in setups if not one.to_do
    )
    if remarks:
        blocks = (*blocks, AdviceList(items=remarks))
    yield Section(title="Proof of the kit", blocks=blocks, sheet=sheet)


def acceptance_lines(found: Acceptance, language: str = LANGUAGES[0]) -> tuple[str, ...]:
    """The test for people at a terminal; its findings in their language."""
    rows = [
        f"  {one.capture}: {_SHORT[one.kind]} of {one.name} {_signed_text(one)} mm"
        + (
            ""
            if one.permissible_mm is None
            else f" of {one.permissible_mm:.3f} permitted: {one.outcome}"
        )
        for one in found.values
    ]
    missing = [
        f"  {one.capture}: {one.name}: {told(one.reason, language)}" for one in found.not_measured
    ]
    spreads = [
        f"  {KINDS[one.kind]}: mean {one.bias_mm:+z.3f} mm"
        + (f" ({one.bias_share:+z.3%})" if one.bias_share is not None else "")
        + (f", spread {one.spread_mm:.3f} mm" if one.spread_mm is not None else "")
        + f", largest {one.worst_mm:+z.3f} mm of {one.count}"
        for one in found.spreads
    ]
    return (
        told(found.headline, language),
        *rows,
        *(("Not measured:", *missing) if missing else ()),
        "All together:",
        *spreads,
    )


def _kit(certificate: Certificate) -> str:
    return ", ".join(one.label or "an unnamed camera" for one in certificate.cameras) or "a kit"


def _cards(certificate: Certificate) -> tuple[Card, ...]:
    found = certificate.acceptance
    lengths = [one for one in found.spreads if one.kind in ("spacing", "length")]
    forms = [one for one in found.spreads if one.kind == "form"]
    count = len(certificate.captures)
    return (
        Card(
            "Largest error of a length",
            f"{max((abs(one.worst_mm) for one in lengths), default=math.nan):.3f} mm"
            if lengths
            else "not tested",
            "between spheres or marks",
        ),
        Card(
            "Mean error of lengths",
            f"{100 * _mean_share(lengths):+z.3f} %" if lengths else "not tested",
            "an error of scale shows here",
        ),
        Card(
            "Largest error of form",
            f"{forms[0].worst_mm:.3f} mm" if forms else "not tested",
            "95 % of the points of a sphere or cylinder",
        ),
        Card(
            "Tested",
            f"{certificate.made}, {count} {'capture' if count == 1 else 'captures'}",
            f"counts for {certificate.valid_months} months",
        ),
    )


def _mean_share(lengths: Sequence[Spread]) -> float:
    """Mean of the errors of all lengths, between spheres and between marks, as parts of them."""
    summed = sum(one.count * (one.bias_share or 0.0) for one in lengths)
    return summed / sum(one.count for one in lengths)


def _missing(found: Acceptance) -> Iterator[Section]:
    if not found.not_measured:
        return
    items = tuple(
        fault("record.kit.not_measured", body=one.name, capture=one.capture, reason=one.reason)
        for one in found.not_measured
    )
    yield Section(title="Not measured", blocks=(AdviceList(items=items),), sheet=1)


def _errors(found: Acceptance) -> tuple[Block, ...]:
    judged = [one for one in found.values if one.permissible_mm is not None]
    rows = tuple(_error_row(one) for one in found.values)
    table = Table(
        heads=(
            "capture",
            "what",
            "of",
            "#calibrated mm",
            "#measured mm",
            "#error mm",
            "#U mm",
            "#permitted mm",
            "decision",
        ),
        rows=rows,
        colours=tuple(
            None if one.outcome is None else COLOURS[one.outcome] for one in found.values
        ),
        shorten="cut",
    )
    if not judged:
        return (table,)
    caption = (
        "Each error as a part of what is permitted (dashed), with the artefact's uncertainty as a "
        "whisker."
    )
    return Illustration(image=_chart(judged), caption=caption, optional=True), table


def _error_row(one: MeasuredError) -> tuple[str, ...]:
    form = one.kind in ("form", "form-all", "surface")
    return (
        one.capture,
        _SHORT[one.kind],
        one.name,
        "" if form else f"{one.calibrated_mm:.3f}",
        f"{one.measured_mm:.3f}",
        _signed_text(one),
        f"{one.uncertainty_mm:.3f}",
        "" if one.permissible_mm is None else f"{one.permissible_mm:.3f}",
        one.outcome or "told only",
    )


def _signed_text(one: MeasuredError) -> str:
    return (
        f"{one.error_mm:.3f}"
        if one.kind in ("form", "form-all", "surface")
        else (f"{one.error_mm:+z.3f}")
    )


def _chart(judged: Sequence[MeasuredError]) -> Chart:
    """The worst errors, each beside its limit."""
    ranked = sorted(judged, key=lambda one: -abs(one.error_mm) / (one.permissible_mm or 1.0))
    shown = ranked[:_MOST_BARS]

    def draw(axes: "Axes") -> None:
        plain(axes)
        for row, one in enumerate(shown):
            limit = one.permissible_mm or 1.0
            axes.barh(
                row,
                one.error_mm / limit,
                xerr=one.uncertainty_mm / limit,
                color=_INKS[one.outcome],
                height=0.66,
                error_kw={"ecolor": INK, "elinewidth": 0.9, "capsize": 2},
            )
        for side in (-1.0, 1.0):
            axes.axvline(side, color=INK, lw=0.9, ls="--")
        axes.axvline(0.0, color=FAINT, lw=0.7)
        errors = [abs(one.error_mm) / (one.permissible_mm or 1) for one in shown]
        whiskers = [one.uncertainty_mm / (one.permissible_mm or 1) for one in shown]
        ends = [error + whisker for error, whisker in zip(errors, whiskers, strict=True)]
        reach = max(1.15, 1.1 * max(errors), 1.02 * max(ends))
        axes.set_xlim(-reach, reach)
        axes.set_ylim(len(shown) - 0.5, -0.5)
        names = [f"{_SHORT[one.kind]} {one.name}, {one.capture}" for one in shown]
        axes.set_yticks(range(len(shown)), names, fontsize=6.5)
        axes.set_xlabel("error over permissible error", fontsize=7, color=INK)

    return Chart(
        draw=draw,
        title="Errors against what is permitted",
        width_in=6.9,
        height_in=0.6 + _ROW_IN * len(shown),
        left_in=2.1,
    )


def _spread_table(spreads: Sequence[Spread]) -> Table:
    return Table(
        heads=("error", "#how many", "#mean mm", "#mean %", "#spread mm", "#largest mm"),
        rows=tuple(
            (
                KINDS[one.kind],
                str(one.count),
                f"{one.bias_mm:+z.3f}",
                "" if one.bias_share is None else f"{100 * one.bias_share:+z.3f}",
                "" if one.spread_mm is None else f"{one.spread_mm:.3f}",
                f"{one.worst_mm:+z.3f}",
            )
            for one in spreads
        ),
    )


def _scope_section(certificate: Certificate) -> tuple[Block, ...]:
    artefact = certificate.artefact
    calibrated = ", ".join(text for text in (artefact.certificate, artefact.calibrated) if text)
    kit = [f"{one.label or 'unnamed'}, file {one.sha256[:8]}" for one in certificate.cameras]
    return (
        Text(
            words=f"Artefact: {artefact.name} (file {artefact.sha256[:8]}"
            + (f"; {calibrated}" if calibrated else "")
            + f"). Camera file: {'; '.join(kit) or 'none, so no report can cite this test'}."
        ),
        Table(
            heads=("capture", "photos of", "#photos", "its own verdict", "what set its size"),
            rows=tuple(
                (one.name, one.id, str(one.photos), one.light, one.scale)
                for one in certificate.captures
            ),
        ),
        Text(
            words="Permitted: "
            + "; ".join(
                f"{KINDS[one.kind]} {one.words}" for one in certificate.acceptance.permitted
            )
            + ". L is the calibrated length in mm."
        ),
    )


def _method_section(found: Acceptance) -> tuple[Block, ...]:
    rows = tuple(
        (
            one.capture,
            one.name,
            f"{one.points:,}",
            f"{one.seen:.0%}",
            f"{one.off_rms_mm:.4f}",
        )
        for one in found.bodies
    )
    table = Table(heads=("capture", "body", "#points", "#seen of it", "#RMS off it, mm"), rows=rows)
    return (Text(words=_METHOD), *((table,) if rows else ()))
