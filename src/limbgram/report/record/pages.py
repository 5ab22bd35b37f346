"""Words: a record's tree as rows of text, for page and paper alike.

The page of a record: one HTML file, nothing from outside, no script.

In      the tree of a record and its pictures.
Out     HTML text; its first screen says side, unit and what to check.

The PDF of a record: two sheets to file and sign.

In      the tree of a record and its pictures.
Out     the bytes of a PDF (A4): the shape and its measures; what was done to it and how sure it is.
"""

from collections.abc import Iterator, Sequence
from html import escape
from typing import Any

from limbgram.core.interval import HOLDS, Interval, plus_minus
from limbgram.report.document.page import card, document, figure_html, table
from limbgram.report.document.paper import Sheet, pdf_of
from limbgram.report.drawings.drawing import BLUE, FAINT, Picture
from limbgram.report.record import pages as words
from limbgram.report.record.advice import tape_checks

Tree = dict[str, Any]
Row = tuple[str, ...]

SIDES = {"left": "LEFT", "right": "RIGHT", "none": "NO SIDE"}
BIAS_NOTE = (
    "A bias shifts all radii one way (+ outwards); typical (RMS) and largest go both ways. 0.25 mm "
    "of radius is what a socket's fit can show."
)
COMPARISON_NOTE = "This shape is the second one: differences are this shape less the other."
MEASURE_HEADS = (
    "#height mm", "#tape mm", "#contour mm", "#ML mm", "#AP mm", "#area cm²", "#volume below mL",
)  # fmt: skip
LANDMARK_HEADS = ("#no.", "landmark", "#right mm", "#anterior mm", "#proximal mm")
CHANGE_HEADS = ("#height mm", "#tape mm", "#change", "#%", "#ML change", "#AP change",
                "#mL since the last level", "#change")  # fmt: skip
LEDGER_NOTE = (
    "Largest and mean: how far the surface moved, + outward (room), - inward (pressure). Volume: "
    "of the closed shape, an open brim closed from its middle."
)
LEDGER_HEADS = ("#no.", "edit", "#volume mL", "#change mL", "#%", "#largest mm", "#mean mm")
BIAS_HEADS = ("step", "#bias mm", "#typical mm", "#largest mm", "#volume %", "how it is known")
FILE_HEADS = ("file", "printed as", "kind", "SHA-256")


def title(tree: Tree) -> str:
    return f"Record of {tree['id']}"


def badge(tree: Tree) -> str:
    """What nobody may overlook."""
    return f"{SIDES[tree['side']]} · mm"


def banner(tree: Tree) -> str:
    """Side, unit and frame, in a sentence."""
    side = tree["side"]
    whose = "No side was given" if side == "none" else f"The patient's {side} side"
    sock = tree["measures"]["sock_taken_off_mm"]
    worn = f"{sock:g} mm of sock are off" if sock else "no sock is recorded as taken off"
    return (
        f"{whose}. All lengths are in millimetres (mm), volumes in millilitres. Aligned: +Z "
        f"proximal, +Y anterior, +X the patient's right, origin distal; {worn}."
    )


def card_rows(tree: Tree) -> tuple[tuple[str, str, str], ...]:
    """What is asked first: question, answer, note."""
    across, deep, long = tree["size_mm"]
    rows = [row for row in tree["measures"]["levels"] if row["volume_below_ml"] is not None]
    girths = [row for row in tree["measures"]["levels"] if row["tape_mm"] is not None]
    cards = [
        (
            "Size",
            f"{long:.1f} mm long",
            f"{across:.1f} mm from side to side, {deep:.1f} mm from front to back",
        )
    ]
    if rows:
        top = rows[-1]
        cards.append(
            (
                "Volume",
                f"{_figure(top['volume_below_ml'], 1)} mL",
                f"from the distal end up to {_height(tree, top)}",
            )
        )
    if girths:
        widest = max(girths, key=lambda row: row["tape_mm"]["value"])
        cards.append(
            (
                "Largest tape girth",
                f"{_figure(widest['tape_mm'], 1)} mm",
                f"at {_height(tree, widest)}",
            )
        )
    compared = tree["comparison"]
    if compared is not None and compared["volume"]["ml"] is not None:
        change, plies = compared["volume"]["ml"], compared["volume"]["sock_plies"]
        cards.append(
            (
                "Change of volume",
                f"{change['difference']:+.1f} mL",
                f"{100 * change['share']:+.2f} %, like {plies:+.1f} sock plies",
            )
        )
    return tuple(cards)


def inside_rows(tree: Tree) -> list[Row]:
    """The same of what a wall holds."""
    return [_measure_row(row) for row in tree["inside"]["levels"]]


def inside_note() -> str:
    return _skin("inside").strip()


def measure_rows(tree: Tree) -> list[Row]:
    """A row a level; one without an answer has a second cell alone, which says why."""
    return [_measure_row(row) for row in tree["measures"]["levels"]]


def measure_note(tree: Tree) -> str:
    with_sigma = any(
        row["tape_mm"] is not None and row["tape_mm"]["sigma"] is not None
        for row in tree["measures"]["levels"]
    )
    spread = f"{HOLDS}." if with_sigma else ""
    skin, reference = _skin(tree["measures"]["skin"]), tree["measures"]["reference"]
    return (
        f"{skin}Heights count from: {reference}. Tape: what a taut tape reads; "
        f"contour: along the skin, into hollows. ML: side to side, AP: front to back. {spread}"
    ).strip()


def landmark_rows(tree: Tree) -> list[Row]:
    return [
        (str(number), mark["name"], *(f"{value:+.1f}" for value in mark["in_limb_mm"]))
        for number, mark in enumerate(tree["landmarks"], start=1)
    ]


def change_rows(tree: Tree) -> list[Row]:
    """What differs, level by level."""
    return [_change_row(row) for row in tree["comparison"]["levels"]]


def ledger_rows(tree: Tree) -> list[Row]:
    """A row an edit; under it a sentence for each thing that somebody has to mean or to know."""
    rows: list[Row] = []
    for line in tree["recipe"]["lines"]:
        before, after = line["before"]["volume_ml"], line["after"]["volume_ml"]
        moved = line["displacement"]
        rows.append(
            (
                str(line["number"]),
                line["edit"],
                f"{after:.1f}",
                f"{after - before:+.2f}",
                f"{100 * (after / before - 1):+.3f}" if before else "",
                "" if moved is None else f"{moved['largest_mm']:+.2f}",
                "" if moved is None else f"{moved['mean_mm']:+.3f}",
            )
        )
        rows += [("", sentence) for sentence in line["told"]]
        rows += [("!", _mark(concern)) for concern in line["concerns"]]
    return rows


def girth_ledger(tree: Tree) -> tuple[Row, list[Row]]:
    """Girths after each edit, at levels that stay the same: heads and rows."""
    recipe = tree["recipe"]
    heads = ("#no.", *(f"#{level:.0f} mm" for level in recipe["levels_mm"]))
    lines = recipe["lines"]
    start = [] if not lines else [("before", *_girths(lines[0]["before"]))]
    return heads, [*start, *((str(one["number"]), *_girths(one["after"])) for one in lines)]


def recipe_note(tree: Tree) -> str:
    """What the ledger is, and whether it is this shape's."""
    recipe = tree["recipe"]
    done = f"Computed for this record by doing {recipe['id']} to {recipe['scan']} again"
    apart = recipe["apart_mm"]
    if apart is None:
        return f"{done}; the rest of this record shows the shape before these edits."
    return f"{done}; the result and the shape of this record are {apart:.3f} mm apart at most."


def bias_rows(tree: Tree) -> list[Row]:
    return [
        (
            one["step"],
            _number(one["bias_mm"], "+.3f"),
            "" if one["typical_mm"] is None else f"{one['typical_mm']:.3f}",
            "" if one["largest_mm"] is None else f"{one['largest_mm']:.3f}",
            "" if one["volume_share"] is None else f"{100 * one['volume_share']:+.3f}",
            one["basis"],
        )
        for one in tree["bias"]
    ]


def file_rows(tree: Tree) -> list[Row]:
    return [(one["what"], one["id"], one["kind"], one["sha256"]) for one in tree["files"]]


def versions(tree: Tree) -> str:
    return "Made by " + ", ".join(f"{name} {what}" for name, what in tree["versions"].items()) + "."


def _height(tree: Tree, row: Tree) -> str:
    """A height, and what it counts from where that is no end of the limb."""
    reference = tree["measures"]["reference"]
    counted = "" if reference == "distal end" else f" from {reference}"
    return f"{row['from_reference_mm']:g} mm{counted}"


def _measure_row(row: Tree) -> Row:
    height = f"{row['from_reference_mm']:.1f}"
    if row["tape_mm"] is None:
        return height, row["reason"]
    area, volume = row["area_mm2"], row["volume_below_ml"]
    per = {"value": area["value"] / 100, "sigma": area["sigma"] and area["sigma"] / 100}
    return (
        height,
        _figure(row["tape_mm"], 1),
        _figure(row["contour_mm"], 1),
        _figure(row["ml_mm"], 1),
        _figure(row["ap_mm"], 1),
        _figure(per, 2),
        "-" if volume is None else _figure(volume, 1),
    )


def _change_row(row: Tree) -> Row:
    height = f"{row['height_mm']:.1f}"
    tape, slab = row.get("tape_mm"), row["volume_since_last_level_ml"]
    if tape is None:
        return height, row["reason"] or "-"
    return (
        height,
        f"{tape['second']:.1f}",
        f"{tape['difference']:+.1f}",
        f"{100 * tape['share']:+.2f}",
        f"{row['ml_mm']['difference']:+.1f}",
        f"{row['ap_mm']['difference']:+.1f}",
        "-" if slab is None else f"{slab['second']:.1f}",
        "-" if slab is None else f"{slab['difference']:+.1f}",
    )


def _skin(skin: str) -> str:
    """Which skin of a wall the figures are of."""
    if skin == "inside":
        return "Of the INSIDE of the wall; areas and volumes are of what it holds. "
    if skin == "outside":
        return "Of the OUTSIDE of the wall; areas and volumes are of its material. "
    return ""


def _mark(concern: Tree) -> str:
    """What somebody had to mean, or has to know, of an edit."""
    if not concern["word"]:
        return concern["what"]
    return f"{concern['what']} ({'accepted' if concern['accepted'] else 'NOT accepted'})"


def _girths(figures: Tree) -> Row:
    return tuple("-" if girth is None else f"{girth:.1f}" for girth in figures["girths_mm"])


def _figure(figure: Tree, decimals: int) -> str:
    sigma = figure["sigma"]
    interval = None if sigma is None else Interval.of_sigma(sigma)
    return f"{figure['value']:.{decimals}f} {plus_minus(interval, max(decimals, 2))}".rstrip()


def _number(value: float | None, form: str) -> str:
    return "not known" if value is None else format(value, form)


def record_page(tree: Tree, pictures: Sequence[Picture]) -> str:
    """The record as one self-contained page."""
    title = words.title(tree)
    cards = "".join(card(*row) for row in words.card_rows(tree))
    sections = (
        f"<h1>{escape(title)}</h1>",
        f'<p class="light blue"><b>{words.badge(tree)}</b>'
        f"<span>{escape(words.banner(tree))}</span></p>",
        f'<div class="cards">{cards}</div>',
        f'<p class="use">{escape(tree["intended_use"])}</p>',
        "<h2>Before anything is made from it</h2>",
        _findings(tree["findings"]),
        figure_html(pictures[0]),
        *_landmarks(tree),
        "<h2>Measures by level</h2>",
        f'<p class="note">{escape(words.measure_note(tree))}</p>',
        table(words.MEASURE_HEADS, words.measure_rows(tree)),
        *_inside(tree),
        *_comparison(tree),
        *(figure_html(picture) for picture in pictures[1:]),
        *_recipe(tree),
        "<h2>What each step does to a radius</h2>",
        f'<p class="note">{escape(words.BIAS_NOTE)}</p>',
        table(words.BIAS_HEADS, words.bias_rows(tree)),
        "<h2>Files and versions</h2>",
        f'<p class="note">{escape(tree["names"])}</p>',
        table(words.FILE_HEADS, words.file_rows(tree)),
        f'<p class="note">{escape(words.versions(tree))}</p>',
    )
    return document(f"{title}, {words.badge(tree)}", sections)


def _findings(found: Sequence[dict[str, str]]) -> str:
    items = "".join(
        f'<li><span class="{"grave" if one["gravity"] == "serious" else "mild"}">'
        f"{escape(one['what'])}</span><em>&rarr; {escape(one['remedy'])}</em></li>"
        for one in found
    )
    return f'<ol class="do">{items}</ol>'


def _landmarks(tree: Tree) -> Iterator[str]:
    yield "<h3>Landmarks, in the limb's axes</h3>"
    rows = words.landmark_rows(tree)
    yield table(words.LANDMARK_HEADS, rows) if rows else "<p>None were marked.</p>"


def _inside(tree: Tree) -> Iterator[str]:
    if tree["inside"] is None:
        return
    yield "<h3>Measures of the inside by level</h3>"
    yield f'<p class="note">{words.inside_note()}</p>'
    yield table(words.MEASURE_HEADS, words.inside_rows(tree))


def _comparison(tree: Tree) -> Iterator[str]:
    compared = tree["comparison"]
    if compared is None:
        return
    yield f"<h2>Compared with {escape(compared['first'])}</h2>"
    yield f"<p>{escape(compared['verdict'])}</p>"
    yield f'<p class="note">{words.COMPARISON_NOTE}</p>'
    yield table(words.CHANGE_HEADS, words.change_rows(tree))


def _recipe(tree: Tree) -> Iterator[str]:
    if tree["recipe"] is None:
        return
    yield "<h2>Edits and what they did</h2>"
    yield f'<p class="note">{escape(words.recipe_note(tree))}</p>'
    yield table(words.LEDGER_HEADS, words.ledger_rows(tree))
    yield f'<p class="note">{words.LEDGER_NOTE}</p>'
    yield "<h3>Girths after each edit, by height in the limb frame (contour, mm)</h3>"
    yield table(*words.girth_ledger(tree))


_MOST_LEVELS = 26
_FINDING_IN = 0.26
"""Room of a finding."""
_SENTENCE_IN = 0.13
"""What a reason in place of figures takes beside its first line."""
_SIGN = "Checked by: ____________________   Date: ______________   Signature: ____________________"


def record_pdf(tree: Tree, pictures: Sequence[Picture]) -> bytes:
    """The record as a PDF of two pages."""
    return pdf_of((_first(tree, pictures).figure, _second(tree, pictures[1:]).figure))


def _first(tree: Tree, pictures: Sequence[Picture]) -> Sheet:
    sheet = _headed(tree, words.title(tree))
    sheet.cards(words.card_rows(tree))
    sheet.picture(pictures[0], 2.85)
    marks = words.landmark_rows(tree)
    if marks:
        sheet.table(words.LANDMARK_HEADS, marks[: sheet.rows_that_fit(4.5)], (1, 6, 2, 2, 2))
    sheet.heading("Measures by level")
    sheet.text(words.measure_note(tree), points=7, colour=FAINT)
    others = [one for one in tree["findings"] if one["topic"] != "tape"]
    rows = words.measure_rows(tree)
    sentences = sum(len(row) < len(words.MEASURE_HEADS) for row in rows)
    below_in = 1.0 + _FINDING_IN * len(others) + _SENTENCE_IN * sentences
    most = min(_MOST_LEVELS, sheet.rows_that_fit(below_in))
    step = max(1, -(-len(rows) // max(most, 1)))
    sheet.table(words.MEASURE_HEADS, rows[::step], (2, 3, 3, 3, 3, 3, 3.4))
    if step > 1:
        sheet.text(f"One level in {step}; all are on the page.", points=6.5, colour=FAINT)
    _pdf_findings(sheet, others)
    _tape_boxes(sheet, tree)
    return sheet


def _pdf_findings(sheet: Sheet, found: Sequence[dict[str, str]]) -> None:
    sheet.heading("Before anything is made from it")
    for idx, one in enumerate(found):
        if sheet.room_in < 0.85 + _FINDING_IN:
            sheet.text(f"and {len(found) - idx} more on the page", points=7, colour=FAINT)
            return
        weight = "bold" if one["gravity"] == "serious" else "normal"
        sheet.text(f"{idx + 1}. {one['what']}", points=7, weight=weight)
        sheet.text(f"→ {one['remedy']}", points=7, colour=FAINT)


def _tape_boxes(sheet: Sheet, tree: Tree) -> None:
    """Where a professional writes what the tape says."""
    checks = tape_checks(tree)
    if checks:
        sheet.heading("Girths, mm, and what the tape reads")
        boxes = "      ".join(
            f"at {height:g} mm: {girth:.1f}, tape ________" for height, girth in checks
        )
        sheet.text(boxes, points=8)
        sheet.text(
            f"Heights count from: {tree['measures']['reference']}. More than 1 mm or 1 % apart: "
            "find out why before anything is made.",
            points=7,
            colour=FAINT,
        )
    sheet.gap(0.12)
    sheet.text(_SIGN, points=8)


def _second(tree: Tree, pictures: Sequence[Picture]) -> Sheet:
    sheet = _headed(tree, f"{words.title(tree)}, second sheet")
    bias, files = words.bias_rows(tree), words.file_rows(tree)
    below_in = 1.5 + 0.16 * (len(bias) + len(files) + 2)
    if tree["comparison"] is not None:
        sheet.heading(f"Compared with {tree['comparison']['first']}")
        sheet.text(tree["comparison"]["verdict"], points=7.5)
        sheet.text(words.COMPARISON_NOTE, points=6.5, colour=FAINT)
    if tree["recipe"] is not None:
        sheet.heading("Edits and what they did")
        sheet.text(words.recipe_note(tree), points=7, colour=FAINT)
        sheet.text(words.LEDGER_NOTE, points=6.5, colour=FAINT)
        rows = words.ledger_rows(tree)
        kept = rows[: sheet.rows_that_fit(below_in + 0.2)]
        sheet.table(words.LEDGER_HEADS, kept, (0.7, 11, 2, 2, 1.7, 2, 1.7), points=6.5)
        if len(kept) < len(rows):
            more = f"and {len(rows) - len(kept)} more on the page"
            sheet.text(more, points=6.5, colour=FAINT)
    for picture in pictures:
        if sheet.room_in - below_in > 1.2:
            if tree["comparison"] is None:
                sheet.heading(picture.title)
            sheet.picture(picture, sheet.room_in - below_in)
    sheet.heading("What each step does to a radius")
    sheet.text(words.BIAS_NOTE, points=6.5, colour=FAINT)
    sheet.table(words.BIAS_HEADS, bias, (3.4, 2, 2, 2, 1.9, 11.6), points=6.1)
    sheet.heading("Files and versions")
    sheet.table(words.FILE_HEADS, files, (2.2, 2.6, 1, 9), points=6.3)
    sheet.text(f"{words.versions(tree)} {tree['names']}", points=6.5, colour=FAINT)
    return sheet


def _headed(tree: Tree, title: str) -> Sheet:
    sheet = Sheet()
    sheet.text(title, points=12, weight="bold")
    sheet.gap(0.06)
    sheet.banner(words.badge(tree), words.banner(tree), BLUE)
    sheet.foot(tree["intended_use"])
    return sheet
