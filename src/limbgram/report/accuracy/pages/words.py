"""Words: figures of the tree as people read them, for page and PDF alike."""

from dataclasses import dataclass
from typing import Any

from limbgram.report.accuracy.glossary import LENGTH, SHARE, TERMS, Term, value_at

MEANING = (
    "Green: finer than a socket's fit can show. Amber: usable, with the doubt that is named. Red: "
    "much of the limb is missing, a girth or volume may be wrong by a ply of sock or more, or the "
    "size is not known; make nothing from it unchecked."
)


@dataclass(frozen=True)
class Card:
    """One question of the first screen and its answer."""

    question: str
    answer: str
    note: str


@dataclass(frozen=True)
class Shown:
    """One figure of the glossary, ready to print."""

    title: str
    value: str
    unit: str
    definition: str


def cards(tree: dict[str, Any]) -> tuple[Card, ...]:
    """Surface, scale, completeness, photos."""
    surface, images, lengths = tree["surface"], tree["images"], tree["lengths"]
    unit = tree["unit"]
    if tree["truth"] is not None:
        error, note = tree["truth"]["p95_mm"], "95 % of the surface lies nearer to the truth"
    else:
        sure = tree["expected"]["basis"] == "vertex sigmas"
        error = tree["expected"]["p95_mm"]
        note = "95 % of the surface is expected nearer" + ("" if sure else " (a rough guess)")
    checks = lengths["check"]
    return (
        Card("Surface error", number(error, unit), note),
        Card(
            "Scale on lengths that did not set it",
            f"{100 * lengths['check_worst']:.3f} %" if checks else "not checked",
            f"worst of {len(checks)}: {lengths['check_worst_label']}"
            if checks
            else "give a second known length",
        ),
        Card(
            "Measured",
            f"{surface['measured_share']:.1%}",
            f"filled in {surface['filled_share']:.1%}, left out {surface['left_out_share']:.1%}",
        ),
        Card(
            "Photos placed",
            f"{images['placed']} of {images['photos']}",
            f"a pixel is {number(images['pixel'], unit)} on the limb",
        ),
    )


def number(value: float | None, unit: str) -> str:
    """A length with its unit; three digits."""
    return "not known" if value is None else f"{value:.3g} {unit}"


def text_of(value: float | None, form: str) -> str:
    """A figure in a format; empty where it is not known."""
    return "" if value is None else format(value, form)


def shown_terms(tree: dict[str, Any]) -> tuple[Shown, ...]:
    """Every figure of the glossary that this tree has."""
    found = ((term, value_at(tree, term.path)) for term in TERMS)
    return tuple(_shown(term, value, tree["unit"]) for term, value in found if value is not None)


def _shown(term: Term, value: float, unit: str) -> Shown:
    if term.unit == SHARE:
        return Shown(term.title, f"{100 * value:.4g}", "%", term.definition)
    text = f"{value:,}" if isinstance(value, int) else f"{value:.4g}"
    name = unit if term.unit == LENGTH else term.unit.replace(LENGTH, unit).replace("^2", "²")
    if not isinstance(value, int) and abs(value) >= 10_000:
        text = f"{value:,.0f}"
    return Shown(term.title, text, name, term.definition)
