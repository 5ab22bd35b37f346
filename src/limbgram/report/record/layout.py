"""Layout: what the page and the PDF of a record show, and in which order.

In      the content of a record and its pictures.
Out     a Report of two sheets: the shape, its measures and what to check, to be signed; what was
        done to it and how sure it is.
"""

from collections.abc import Iterator, Sequence

from limbgram.core.geometry.smoothed_length import SMOOTHED_OVER
from limbgram.core.interval import HOLDS, Interval, plus_minus
from limbgram.findings import Finding, told
from limbgram.report.blocks import (
    AdviceList,
    Banner,
    Block,
    Card,
    Fields,
    Heading,
    Illustration,
    Report,
    Section,
    Table,
    Text,
)
from limbgram.report.drawings.drawing import Picture
from limbgram.report.record.advice import APART_MM, tape_checks
from limbgram.report.record.content import Content, Json, RecipeDone
from limbgram.workbench.recipe.consent import Concern
from limbgram.workbench.recipe.ledger import Figures, extreme_line

Row = tuple[str, ...]

SIDES = {"left": "LEFT", "right": "RIGHT", "none": "NO SIDE"}
BIAS_NOTE = (
    "A bias shifts all radii one way (+ outwards); typical (RMS) and largest go both ways. 0.25 mm "
    "of radius is what a socket's fit can show."
)
COMPARISON_NOTE = (
    "This shape is the second one: differences are this shape less the other. Heights count from "
    "the origin of the other one's frame."
)
MEASURE_HEADS = (
    "#height mm", "#tape mm", "#contour mm", "#ML mm", "#AP mm", "#area cm²", "#volume below mL",
)  # fmt: skip
SHEET_HEADS = ("measure", "#value", "#±", "unit")
LANDMARK_HEADS = ("#no.", "landmark", "#right mm", "#anterior mm", "#proximal mm")
CHANGE_HEADS = ("#height mm", "#tape mm", "#change", "#%", "#ML change", "#AP change",
                "#mL since the last level", "#change")  # fmt: skip
TAPE_HEADS = ("read", "#height mm", "#tape mm", "#scan mm", "#scan less tape mm", "what it says")
LEDGER_NOTE = (
    "Largest and mean: how far the surface moved, + outward (room), - inward (pressure). Volume: "
    "between two heights between which the shape is open neither before nor after."
)
LEDGER_HEADS = ("#no.", "edit", "#volume mL", "#change mL", "#%", "#largest mm", "#mean mm")
BIAS_HEADS = ("step", "#bias mm", "#typical mm", "#largest mm", "#volume %", "how it is known")
FILE_HEADS = ("file", "printed as", "kind", "SHA-256")


def record_report(content: Content, pictures: Sequence[Picture]) -> Report:
    """The record, the four sides first among its pictures."""
    return Report(
        title=f"Record of {content.id}" + (content.case_id and f", case {content.case_id}"),
        banner=Banner(badge=badge(content), words=_banner(content), colour="blue"),
        cards=tuple(_cards(content)),
        intended_use=content.intended_use,
        sections=(
            _findings(content),
            _shape(content, pictures[0]),
            _measures(content),
            *_sheet(content),
            _signature_section(content),
            *_tape(content),
            *_comparison(content),
            *_recipe(content.recipe),
            *(
                Section(title=one.title, blocks=(_illustration(one, optional=True),), sheet=2)
                for one in pictures[1:]
            ),
            Section(
                title="What each step does to a radius",
                blocks=(
                    Text(words=BIAS_NOTE, note=True),
                    Table(heads=BIAS_HEADS, rows=tuple(bias_rows(content))),
                ),
                sheet=2,
            ),
            Section(
                title="Files and versions",
                blocks=(
                    Text(words=content.names, note=True),
                    Table(heads=FILE_HEADS, rows=tuple(file_rows(content))),
                    Text(words=versions(content), note=True),
                ),
                sheet=2,
            ),
        ),
    )


def _findings(content: Content) -> Section:
    return Section(
        title="Before anything is made from it",
        blocks=(AdviceList(items=content.findings),),
        sheet=1,
    )


def _shape(content: Content, picture: Picture) -> Section:
    marks = tuple(landmark_rows(content))
    return Section(
        title=picture.title,
        blocks=(
            _illustration(picture, least_in=1.9),
            Heading(words="Landmarks, in the limb's axes"),
            Table(heads=LANDMARK_HEADS, rows=marks, shorten="cut")
            if marks
            else Text(words="None were marked."),
        ),
        sheet=1,
    )


def _measures(content: Content) -> Section:
    blocks: list[Block] = [
        Text(words=measure_note(content), note=True),
        Table(heads=MEASURE_HEADS, rows=tuple(measure_rows(content)), shorten="thin"),
    ]
    if content.inside is not None:
        blocks += [
            Heading(words="Measures of the inside by level", page_only=True),
            Text(words=_skin("inside").strip(), note=True, page_only=True),
            Table(heads=MEASURE_HEADS, rows=tuple(inside_rows(content)), page_only=True),
        ]
    return Section(title="Measures by level", blocks=tuple(blocks), sheet=1)


def _sheet(content: Content) -> Iterator[Section]:
    """The form of the kind of limb; what was not marked is not listed."""
    rows = [] if content.sheet is None else content.sheet["rows"]
    known = [row for row in rows if row["value"] is not None]
    doubted = any(row["doubt"] for row in known)
    filled = tuple(
        (
            row["words"]["en"] + (f" ({row['formula']})" if row["formula"] else ""),
            f"{row['value']:.1f}",
            plus_minus(row["sigma"] and Interval.of_sigma(row["sigma"]), 1),
            row["unit"],
            *((_doubted_places(row),) if doubted else ()),
        )
        for row in known
    )
    if filled:
        skin = _skin(content.measures["skin"]).strip()
        heads = (*SHEET_HEADS, *(("goes by",) if doubted else ()))
        yield Section(
            title="Measuring sheet",
            blocks=(
                *((Text(words=skin, note=True),) if skin else ()),
                Table(heads=heads, rows=filled, shorten="cut"),
            ),
            sheet=1,
        )


def _doubted_places(row: Json) -> str:
    """The landmarks that a figure goes by though nobody has confirmed them, or in place of others
    that were not marked."""
    match row["doubt"]:
        case None:
            return ""
        case {"values": {"lacking": lacking, "stand_ins": stand_ins}}:
            return f"{', '.join(stand_ins)} instead of {', '.join(lacking)}"
        case other:
            return f"{', '.join(other['values']['names'])} (not confirmed)"


def _signature_section(content: Content) -> Section:
    """Where a professional writes what the tape says."""
    blocks: list[Block] = []
    checks = tape_checks(content)
    inside = "" if content.inside is None else " of the inside"
    if checks:
        labels = tuple(f"at {height:g} mm: {girth:.1f}, tape" for height, girth in checks)
        blocks = [
            Fields(labels=labels),
            Text(
                words=f"Heights count from: {content.measures['reference']}. More than "
                f"{APART_MM:g} mm apart: find out why before anything is made.",
                note=True,
            ),
        ]
    return Section(
        title=f"Girths{inside}, mm, and what the tape reads" if checks else "",
        blocks=(*blocks, Fields(labels=("Checked by:", "Date:", "Signature:"))),
        sheet=1,
    )


def _tape(content: Content) -> Iterator[Section]:
    """Every girth that was read, the withdrawn ones too."""
    if content.tape:
        rows = tuple(tape_rows(content))
        yield Section(
            title="Read by tape, and held against the scan",
            blocks=(
                Text(words=f"Heights count from the distal end. {HOLDS}.", note=True),
                Table(heads=TAPE_HEADS, rows=rows, shorten="cut"),
            ),
            sheet=2,
        )


def _comparison(content: Content) -> Iterator[Section]:
    compared = content.comparison
    if compared is None:
        return
    yield Section(
        title=f"Compared with {compared['first']}",
        blocks=(
            Text(words=_sentence_of(compared["verdict"])),
            Text(words=COMPARISON_NOTE, note=True),
            Table(heads=CHANGE_HEADS, rows=tuple(change_rows(content)), page_only=True),
        ),
        sheet=2,
    )


def _recipe(recipe: RecipeDone | None) -> Iterator[Section]:
    if recipe is None:
        return
    heads, rows = girth_ledger(recipe)
    title = f"Girths after each edit, by height in the limb frame (contour, mm, {SMOOTHED_OVER})"
    yield Section(
        title="Edits and what they did",
        blocks=(
            Text(words=recipe_note(recipe), note=True),
            Table(heads=LEDGER_HEADS, rows=tuple(ledger_rows(recipe)), shorten="cut"),
            Text(words=LEDGER_NOTE, note=True),
            Heading(words=title, page_only=True),
            Table(heads=heads, rows=tuple(rows), page_only=True),
        ),
        sheet=2,
    )


def _illustration(
    picture: Picture, *, least_in: float = 1.2, optional: bool = False
) -> Illustration:
    return Illustration(
        image=picture, caption=picture.caption, least_in=least_in, optional=optional
    )


def badge(content: Content) -> str:
    """The badge of a record: what nobody may overlook."""
    return f"{SIDES[content.side]} · mm"


def _banner(content: Content) -> str:
    """Side, unit and frame, in a sentence."""
    side = content.side
    whose = "No side was given" if side == "none" else f"The patient's {side} side"
    sock = content.measures["sock_taken_off_mm"]
    worn = f"{sock:g} mm of sock are off" if sock else "no sock is recorded as taken off"
    return (
        f"{whose}. All lengths are in millimetres (mm), volumes in millilitres. Aligned: +Z "
        f"proximal, +Y anterior, +X the patient's right, origin distal; {worn}."
    )


def _cards(content: Content) -> Iterator[Card]:
    """The cards that answer the first questions."""
    across, deep, long = content.size_mm
    rows = [row for row in content.measures["levels"] if row["volume_below_ml"] is not None]
    girths = [row for row in content.measures["levels"] if row["tape_mm"] is not None]
    wall = content.measures["skin"] == "outside"
    yield Card(
        "Size",
        f"{long:.1f} mm long",
        f"{across:.1f} mm from side to side, {deep:.1f} mm from front to back",
    )
    if rows:
        top = rows[-1]
        yield Card(
            "Volume",
            f"{_figure_text(top['volume_below_ml'], 1)} mL",
            f"{'of the material, ' * wall}from the distal end up to {_height_text(content, top)}",
        )
    if girths:
        widest = max(girths, key=lambda row: row["tape_mm"]["value"])
        yield Card(
            "Largest tape girth",
            f"{_figure_text(widest['tape_mm'], 1)} mm",
            f"{'outside, ' * wall}at {_height_text(content, widest)}",
        )
    if content.case is not None:
        yield Card("Capture", content.case.light.upper(), content.case.headline)
    compared = content.comparison
    if compared is not None and compared["volume"]["ml"] is not None:
        change, plies = compared["volume"]["ml"], compared["volume"]["sock_plies"]
        yield Card(
            "Change of volume",
            f"{change['difference']:+z.1f} mL",
            f"{100 * change['share']:+z.2f} %, like {plies:+z.1f} sock plies",
        )


def inside_rows(content: Content) -> list[Row]:
    """Rows of measures of a wall's inside."""
    return [] if content.inside is None else [_measure_row(row) for row in content.inside["levels"]]


def measure_rows(content: Content) -> list[Row]:
    """A row a level; one without an answer has a second cell alone, which says why."""
    return [_measure_row(row) for row in content.measures["levels"]]


def measure_note(content: Content) -> str:
    with_sigma = any(
        row["tape_mm"] is not None and row["tape_mm"]["sigma"] is not None
        for row in content.measures["levels"]
    )
    spread = f"{HOLDS}." if with_sigma else ""
    skin, reference = _skin(content.measures["skin"]), content.measures["reference"]
    others = content.measures["beside"]
    beside = "" if others is None else _sentence_of(others)
    return (
        f"{skin}Heights count from: {reference}. Girths are {SMOOTHED_OVER}; tape: what "
        f"a taut tape reads, contour: along the skin, into hollows. ML: side to side, AP: front to "
        f"back. {spread} {beside}"
    ).strip()


def landmark_rows(content: Content) -> list[Row]:
    return [
        (
            str(number),
            mark.name + ("" if mark.confirmed else " (proposed, not confirmed)"),
            *(f"{value:+z.1f}" for value in mark.in_limb_mm),
        )
        for number, mark in enumerate(content.landmarks, start=1)
    ]


def tape_rows(content: Content) -> Iterator[Row]:
    """A row a reading."""
    for one in content.tape:
        said = "they contradict each other" if one.conflict else "agrees"
        said = said if one.reason is None else told(one.reason)
        said += f"; accepted {one.accepted}" if one.accepted else ""
        said += f"; taken back {one.withdrawn}" if one.withdrawn else ""
        measured, difference = "", ""
        if one.measured_mm is not None:
            measured = f"{one.measured_mm:.1f}"
            difference = f"{one.measured_mm - one.read_mm:+z.1f}"
            if one.within_mm is not None:
                difference += f" {plus_minus(Interval.of_half_width(one.within_mm), 1)}"
        height, read = f"{one.height_mm:g}", f"{one.read_mm:.1f}"
        yield (one.made, height, read, measured, difference, said)


def change_rows(content: Content) -> list[Row]:
    """What differs, level by level."""
    compared = content.comparison
    return [] if compared is None else [_change_row(row) for row in compared["levels"]]


def ledger_rows(recipe: RecipeDone) -> list[Row]:
    """A row an edit; under it a sentence for each thing that somebody has to mean or to know."""
    rows: list[Row] = []
    for line in recipe.lines:
        volume, moved = line.volume, line.displacement
        before, after = (0.0, 0.0) if volume is None else (volume.before_ml, volume.after_ml)
        rows.append(
            (
                str(line.number),
                line.edit,
                "" if volume is None else f"{after:.1f}",
                "" if volume is None else f"{after - before:+z.2f}",
                f"{100 * (after / before - 1):+z.3f}" if before else "",
                "" if moved is None else f"{moved.largest_mm:+z.2f}",
                "" if moved is None else f"{moved.mean_mm:+z.3f}",
            )
        )
        if line.extreme is not None:
            rows.append(("", f"Where it moved most: {extreme_line(line.extreme)}"))
        rows += [("", told(one)) for one in line.told]
        rows += [("!", _consent_note(concern)) for concern in line.concerns]
    return rows


def girth_ledger(recipe: RecipeDone) -> tuple[Row, list[Row]]:
    """Girths after each edit, at levels that stay the same: heads and rows."""
    heads = ("#no.", *(f"#{level:.0f} mm" for level in recipe.levels_mm))
    lines = recipe.lines
    start = [] if not lines else [("before", *_girths(lines[0].before))]
    return heads, [*start, *((str(one.number), *_girths(one.after)) for one in lines)]


def recipe_note(recipe: RecipeDone) -> str:
    """What the ledger is, and whether it is this shape's."""
    done = f"Computed for this record by doing {recipe.id} to {recipe.scan} again"
    if recipe.apart_mm is None:
        return f"{done}; the rest of this record shows the shape before these edits."
    return (
        f"{done}; the result and the shape of this record are {recipe.apart_mm:.3f} mm apart at "
        "most."
    )


def bias_rows(content: Content) -> list[Row]:
    return [
        (
            one.step,
            "not known" if one.bias_mm is None else f"{one.bias_mm:+z.3f}",
            "" if one.typical_mm is None else f"{one.typical_mm:.3f}",
            "" if one.largest_mm is None else f"{one.largest_mm:.3f}",
            "" if one.volume_share is None else f"{100 * one.volume_share:+z.3f}",
            told(one.basis),
        )
        for one in content.bias
    ]


def file_rows(content: Content) -> list[Row]:
    return [(one.what, one.id, one.kind, one.sha256) for one in content.files]


def versions(content: Content) -> str:
    return "Made by " + ", ".join(f"{name} {what}" for name, what in content.versions.items()) + "."


def _height_text(content: Content, row: Json) -> str:
    """A height, and what it counts from where that is no end of the limb."""
    reference = content.measures["reference"]
    counted = "" if reference == "distal end" else f" from {reference}"
    return f"{row['from_reference_mm']:g} mm{counted}"


def _measure_row(row: Json) -> Row:
    height = f"{row['from_reference_mm']:.1f}"
    if row["tape_mm"] is None:
        return height, " ".join(map(_sentence_of, row["reasons"]))
    area, volume = row["area_mm2"], row["volume_below_ml"]
    per = {"value": area["value"] / 100, "sigma": area["sigma"] and area["sigma"] / 100}
    return (
        height,
        _figure_text(row["tape_mm"], 1),
        _figure_text(row["contour_mm"], 1),
        _figure_text(row["ml_mm"], 1),
        _figure_text(row["ap_mm"], 1),
        _figure_text(per, 2),
        "-" if volume is None else _figure_text(volume, 1),
    )


def _change_row(row: Json) -> Row:
    height = f"{row['height_mm']:.1f}"
    tape, slab = row.get("tape_mm"), row["volume_since_last_level_ml"]
    if tape is None:
        return height, "-" if row["reason"] is None else _sentence_of(row["reason"])
    return (
        height,
        f"{tape['second']:.1f}",
        f"{tape['difference']:+z.1f}",
        f"{100 * tape['share']:+z.2f}",
        f"{row['ml_mm']['difference']:+z.1f}",
        f"{row['ap_mm']['difference']:+z.1f}",
        "-" if slab is None else f"{slab['second']:.1f}",
        "-" if slab is None else f"{slab['difference']:+z.1f}",
    )


def _skin(skin: str) -> str:
    """Which skin of a wall the figures are of."""
    if skin == "inside":
        return "Of the INSIDE of the wall; areas and volumes are of what it holds. "
    if skin == "outside":
        return "Of the OUTSIDE of the wall; areas and volumes are of its material. "
    return ""


def _consent_note(concern: Concern) -> str:
    """What somebody had to mean, or has to know, of an edit."""
    if not concern.word:
        return told(concern.finding)
    return f"{told(concern.finding)} ({'accepted' if concern.accepted else 'NOT accepted'})"


def _girths(figures: Figures) -> Row:
    return tuple("-" if girth is None else f"{girth:.1f}" for girth in figures.girths_mm)


def _sentence_of(finding: Json) -> str:
    """The sentence of a finding in a tree."""
    return told(Finding.from_tree(finding))


def _figure_text(figure: Json, decimals: int) -> str:
    sigma = figure["sigma"]
    interval = None if sigma is None else Interval.of_sigma(sigma)
    return f"{figure['value']:.{decimals}f} {plus_minus(interval, max(decimals, 2))}".rstrip()
